"""Root stress under the pair's own contact forces against other finite elements of the same teeth.

An independent second computation: 27-node hexahedra of scikit-fem with curved sides on the cut flanks, fillets and
roots (`tooth_grid`, `root_profile`); four blocks a section that meet in the middle of the fillets; a ring of three
teeth; each contact force spread over the nodes of the face that it acts on; greatest principal stress of the full
tensor at the Gauss points of the faces of the fillet. Conjugate gradients. As a script it prints the table of
docs/strength.md.
"""

import sys
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import block_diag, coo_matrix, kron, lil_matrix
from scipy.sparse.linalg import LinearOperator, cg, splu
from skfem import Basis, ElementHex2, MeshHex, MeshHex2
from twins.compliance_fem import elasticity

import efficiency
from efficiency.contact.gear_flanks import GearFlanks, Member
from efficiency.contact.tooth_grid import root_profile, tooth_grid
from efficiency.design.design import Design, MemberInput
from efficiency.ltca.load_distribution import PositionLoad
from efficiency.ltca.solid_tooth import solid_tooth_of
from efficiency.mesh import LoadedMesh
from efficiency.strength.root_mesh import EDGE_RADIUS
from efficiency.strength.root_stress import root_stress, root_tooth

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
TEETH = 3


@dataclass(frozen=True)
class Cells:
    """Elements of a pitch: from the middle of the slot to that of the fillet, on to the tip, across, down, along."""

    low: int = 5
    high: int = 12
    across: int = 6
    deep: int = 5
    along: int = 12


@dataclass(frozen=True)
class RootPeaks:
    """Greatest stress of the fillet of the loaded side, by both methods [Pa]; unknowns of the elements."""

    elements: float
    model: float
    unknowns: int
    seconds: float

    @property
    def error(self) -> float:
        """Of the model [-]."""
        return self.model / self.elements - 1.0


def with_edge_radius(design: Design, radius: float) -> Design:
    """The design with an edge radius [m] on all blades, so that both methods see the same cut fillet."""

    def member(given: MemberInput) -> MemberInput:
        found = given
        for side in ("concave", "convex"):
            flank = getattr(found, side)
            cutter = flank.cutter.model_copy(update={"edge_radius": radius})
            found = found.model_copy(update={side: flank.model_copy(update={"cutter": cutter})})
        return found

    return design.model_copy(update={name: member(getattr(design, name)) for name in ("pinion", "gear")})


class RootElements:
    """Finite elements of a ring of teeth of one member; lengths in metres."""

    def __init__(
        self,
        flanks: GearFlanks,
        member: Member,
        rim: float,
        modulus: float,
        poisson: float,
        held: frozenset[str],
        cells: Cells = Cells(),
    ) -> None:
        self.cells, self.modulus, self.poisson = cells, modulus, poisson
        planes = 2 * cells.along + 1
        self.grid = grid = tooth_grid(flanks, member, 60, planes)
        middle = grid.height.shape[0] // 2
        radius = grid.blank.axial(grid.u[middle], grid.height[middle])[0]
        turn = np.gradient(0.5 * (grid.lower + grid.upper)[middle], grid.u[0])
        scale = radius / np.sqrt(1.0 + (radius * turn) ** 2)
        sides = [self._side(flanks, member, k) for k in (0, 1)]
        lines = self._outlines(sides[0], sides[1], scale)
        self.flank = [line[2 * cells.low :] for line in lines]  # from the middle of the fillet to the tip
        blocks = self._blocks(lines, grid.blank.root(grid.u[0]) - rim)
        flat = np.concatenate([b.reshape(-1, 2, planes) for b in blocks])
        key = np.round(flat[:, :, planes // 2] / (1e-6 * radius[planes // 2])).astype(np.int64)
        _, first, number = np.unique(key, axis=0, return_index=True, return_inverse=True)
        section = flat[first]
        azimuth, height = section[:, 0] / scale, section[:, 1]
        points = grid.point(azimuth, np.broadcast_to(grid.u[0], azimuth.shape), height)
        lattices, start = [], 0
        for b in blocks:
            size = b.shape[0] * b.shape[1]
            plane = number.ravel()[start : start + size].reshape(b.shape[:2])
            lattices.append(plane[..., None] * planes + np.arange(planes))
            start += size
        self.lattices: list[IntArray] = lattices
        self._mesh(points.reshape(-1, 3), lattices)
        self.size = self.basis.N
        self._ring(held)

    def _side(self, flanks: GearFlanks, member: Member, k: int) -> list[FloatArray]:
        """Azimuth and height (n, 2) of a side at each station, tip first, down to its deepest point."""
        grid, flank = self.grid, flanks.of(member)[self.grid.sides[k]]
        cut = root_profile(flank, grid.u.shape[1], np.inf)
        assert cut is not None, "the settings cut no fillet"
        azimuth = grid.upper if k else grid.lower
        found = []
        for c in range(grid.u.shape[1]):
            above = grid.height[:, c] > cut.start[c]
            a, h = azimuth[above, c][::-1], grid.height[above, c][::-1]
            # the tooth is turned into its place: the fillet joins the flank at the start of the latter
            free, there = flank.solve(np.array([grid.u[0, c]]), np.array([h[-1]]))
            assert there.all()
            turn = a[-1] - float(np.unwrap([cut.azimuth[0, c], float(free.azimuth[0])])[1])
            keep = np.concatenate([[True], np.diff(cut.height[:, c]) < 0.0])
            lower = np.stack([cut.azimuth[keep, c] + turn, cut.height[keep, c]], axis=1)
            found.append(np.concatenate([np.stack([a, h], axis=1), lower[lower[:, 1] < h[-1]]]))
        return found

    def _outlines(self, low: list[FloatArray], high: list[FloatArray], scale: FloatArray) -> list[FloatArray]:
        """Lattice (n, 2, k) of both sides, from the middle of the slot to the tip, flattened."""
        curves: list[list[FloatArray]] = [[], []]
        for one, two, s in zip(low, high, scale, strict=True):
            ahead = one + np.array([self.grid.pitch, 0.0])
            if two[-1, 0] < ahead[-1, 0]:
                end = 0.5 * (two[-1] + ahead[-1])
            else:  # both fillets cross
                order = np.argsort(ahead[:, 0])
                over = two[:, 1] - np.interp(two[:, 0], ahead[order, 0], ahead[order, 1], left=-np.inf)
                stop = int(np.argmax((over < 0.0) & (two[:, 0] > ahead[:, 0].min())))
                end = two[stop]
                two, ahead = two[:stop], ahead[ahead[:, 0] > end[0]]
            for k, (side, last) in enumerate(
                ((ahead - [self.grid.pitch, 0.0], end - [self.grid.pitch, 0.0]), (two, end))
            ):
                curves[k].append(np.concatenate([last[None], side[::-1]]) * np.array([s, 1.0]))
        return [self._nodes(side) for side in curves]

    def _nodes(self, side: list[FloatArray]) -> FloatArray:
        c = self.cells
        u = np.linspace(-1.0, 1.0, len(side))
        lengths = [np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(x, axis=0).T))]) for x in side]
        half = []
        for x, s in zip(side, lengths, strict=True):
            # middle of the fillet: the tangent at 45 deg, from a running mean
            at = np.linspace(0.0, s[-1], 400)
            y, h = (np.interp(at, s, z) for z in x.T)
            steep = np.convolve(np.arctan2(np.gradient(h), np.abs(np.gradient(y))), np.ones(9) / 9.0, mode="same")
            half.append(at[4 + int(np.argmax(steep[4:] > 0.25 * np.pi))] / s[-1])
        share = np.polyval(np.polyfit(u, half, 2), u)
        lattice = []
        for x, s, f in zip(side, lengths, share, strict=True):
            up = np.linspace(0.0, 1.0, c.high + 1)
            up = _halved(0.35 * up + 0.65 * up**2)
            at = np.concatenate([np.linspace(0.0, f, 2 * c.low + 1)[:-1], f + (1.0 - f) * up])
            lattice.append(np.stack([np.interp(at * s[-1], s, z) for z in x.T], axis=1))
        return np.stack(lattice, axis=-1)

    def _blocks(self, lines: list[FloatArray], base: FloatArray) -> list[FloatArray]:
        """Lattices (m, n, 2, k): tooth, body under it, body under both halves of the slots."""
        c = self.cells
        left, right = lines
        away = np.linspace(-1.0, 1.0, c.across + 1)  # from the middle of the tooth
        t = _halved(0.5 + 0.5 * np.sign(away) * (1.0 - (1.0 - np.abs(away)) ** 2.2))
        t = t[None, :, None, None]
        tooth = left[2 * c.low :, None] * (1.0 - t) + right[2 * c.low :, None] * t
        # rows bent down near the fillets, so that the corners of the three blocks there are wide
        fade = (1.0 - np.linspace(0.0, 1.0, 2 * c.high + 1)) ** 3
        wide = np.abs(right[2 * c.low, 0] - left[2 * c.low, 0])
        tooth[:, :, 1] -= 0.5 * fade[:, None, None] * (t * (1.0 - t))[:, :, 0] * wide
        down = _halved(np.linspace(0.0, 1.0, c.deep + 1) ** 2.4)[:, None, None, None]
        ends = [np.stack([x, base]) for x in (left[0, 0], left[2 * c.low, 0], right[2 * c.low, 0], right[0, 0])]
        for a, b in ((1, 2), (2, 1)):
            ends[a][0] = 0.75 * ends[a][0] + 0.25 * (left, right)[b - 1][2 * c.low, 0]
        under = ends[1][None] * (1.0 - t[0]) + ends[2][None] * t[0]
        body = tooth[:1] * (1.0 - down) + under[None] * down
        slots = []
        for line, (a, b) in ((left, (0, 1)), (right, (3, 2))):
            top = line[: 2 * c.low + 1]
            share = (top[:, 0] - top[0, 0]) / (top[-1, 0] - top[0, 0])
            floor = ends[a] + share[:, None] * (ends[b] - ends[a])
            slots.append(top[None] * (1.0 - down) + floor[None] * down)
        return [tooth, body, *slots]

    def _mesh(self, points: FloatArray, lattices: list[IntArray]) -> None:
        order = np.rint(2.0 * ElementHex2().doflocs).astype(int)
        nodes, numbers, start = [], [], 0
        for x in lattices:
            m, n, p = ((np.arange(0, size - 1, 2)) for size in x.shape)
            i, j, k = (y.ravel() for y in np.meshgrid(m, n, p, indexing="ij"))
            nodes.append(np.stack([x[i + a, j + b, k + d] for a, b, d in order]))
            numbers.append(start + np.arange(i.size).reshape(m.size, n.size, p.size))
            start += i.size
        self.tooth, self.slot = numbers[0], numbers[2:]
        own = np.concatenate(nodes, axis=1)
        corners, t = np.unique(own[:8], return_inverse=True)
        mesh = MeshHex2.from_mesh(MeshHex(points[corners].T, t.reshape(8, -1)))
        dofs = Basis(mesh, ElementHex2(), intorder=1).element_dofs
        assert mesh.dofs.element_dofs.shape == dofs.shape
        self.dof = np.full(len(points), -1)
        self.dof[own] = dofs
        places = np.empty((3, dofs.max() + 1))
        places[:, dofs] = points[own].transpose(2, 0, 1)
        located = np.empty_like(mesh.doflocs)
        located[:, mesh.dofs.element_dofs] = points[own].transpose(2, 0, 1)
        self.mesh = MeshHex2(located, mesh.t)
        self.basis = Basis(self.mesh, ElementHex2(), intorder=5)
        self.points = places

    def _ring(self, held: frozenset[str]) -> None:
        _, body, left, right = self.lattices
        surfaces = {
            "base": np.concatenate([x[-1].ravel() for x in (body, left, right)]),
            "toe": np.concatenate([x[..., 0].ravel() for x in (body, left, right)]),
            "heel": np.concatenate([x[..., -1].ravel() for x in (body, left, right)]),
        }
        fixed = np.zeros(self.size, bool)
        for name in held:
            fixed[self.dof[surfaces[name]]] = True
        first, last = self.dof[left[:, 0].ravel()], self.dof[right[:, 0].ravel()]
        n = self.size
        c, s = np.cos(self.grid.pitch), np.sin(self.grid.pitch)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        rest = np.setdiff1d(np.arange(n), last)
        keep = coo_matrix((np.ones(rest.size), (rest, rest)), shape=(n, n))
        pairs = coo_matrix((np.ones(last.size), (last, first)), shape=(n, n))
        ahead = np.roll(np.eye(TEETH), 1, axis=1)
        whole = kron(np.eye(TEETH), kron(np.eye(3), keep)) + kron(ahead, kron(turn, pairs))
        free = ~fixed
        free[last] = False
        self.expand = whole.tocsc()[:, np.tile(free, 3 * TEETH)].tocsr()
        one = elasticity(self.basis, self.modulus, self.poisson)
        self.stiffness = (self.expand.T @ block_diag([one] * TEETH, format="csr") @ self.expand).tocsr()
        # trilinear functions of the corners of the same elements, for the preconditioner
        corner = self.basis.nodal_dofs[0]
        places = ElementHex2().doflocs
        weights = np.abs(1.0 - places[:, None] - places[None, :8]).prod(axis=2)
        elements, mine = self.basis.element_dofs, np.full(n, -1)
        mine[corner] = np.arange(corner.size)
        linear = lil_matrix((n, corner.size))
        for row, weight in zip(elements, weights, strict=True):
            for other, w in zip(elements[:8], weight, strict=True):
                if w:
                    linear[row, mine[other]] = w
        at = (n * np.arange(3 * TEETH)[:, None] + corner).ravel()
        independent = np.flatnonzero(np.tile(free, 3 * TEETH))
        columns = np.isin(independent, at)
        moved = kron(np.eye(3 * TEETH), linear.tocsr()) @ self.expand[at][:, columns]
        self.linear = moved.tocsr()[independent]

    def solve(self, forces: FloatArray) -> FloatArray:
        """Displacements (9 nodes, k) under forces (9 nodes, k): conjugate gradients, two-level preconditioner."""
        inverse, linear = 1.0 / self.stiffness.diagonal(), self.linear
        coarse = splu(
            (linear.T @ self.stiffness @ linear).tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}
        )
        levels = LinearOperator(
            self.stiffness.shape, lambda right: inverse * right + linear @ coarse.solve(linear.T @ right)
        )
        found = [cg(self.stiffness, right, rtol=1e-7, M=levels) for right in (self.expand.T @ forces).T]
        assert not any(failed for _, failed in found)
        return np.asarray(self.expand @ np.stack([moved for moved, _ in found], axis=1))

    def spread(self, face: FloatArray, height: FloatArray, force: FloatArray, upper: bool) -> FloatArray:
        """Nodal forces (3, nodes) of forces against the flank, from toe and over the root cone."""
        c, found = self.cells, np.zeros((3, self.size))
        lattice = self.lattices[0][:, -1 if upper else 0]
        line = self.flank[int(upper)][:, 1]
        u = self.grid.u[0]
        level = line - self.grid.blank.root(u)
        inside = self.points[:, self.dof[self.lattices[0][:, c.across]]]
        for x, h, f in zip(face, height, force, strict=True):
            z = np.clip(x / np.ptp(u), 0.0, 1.0) * 2 * c.along
            k = min(int(z) // 2, c.along - 1)
            along, along_slope = _quadratic(z - 2 * k)
            own = level[:, 2 * k : 2 * k + 3] @ along
            r = float(np.interp(h, own, np.arange(own.size)))
            i = min(int(r) // 2, c.high - 1)
            over, over_slope = _quadratic(r - 2 * i)
            nodes = self.dof[lattice[2 * i : 2 * i + 3, 2 * k : 2 * k + 3]]
            place = self.points[:, nodes]
            normal = np.cross(
                np.einsum("xij,i,j->x", place, over_slope, along), np.einsum("xij,i,j->x", place, over, along_slope)
            )
            inward = inside[:, 2 * i, 2 * k] - place[:, 1, 1]
            normal *= np.sign(normal @ inward) / np.linalg.norm(normal)
            np.add.at(found, (slice(None), nodes), normal[:, None, None] * np.outer(over, along) * f)
        return found

    def principal(self, moved: FloatArray, upper: bool) -> FloatArray:
        """Greatest principal stress at the Gauss points of the faces of a fillet [Pa]; displacements (3, nodes)."""
        c, gauss = self.cells, 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)
        one, two = (x.ravel() for x in np.meshgrid(gauss, gauss, indexing="ij"))
        own = [
            x[[0]] if k else x[: max(c.high // 4, 1), [-1 if upper else 0]]
            for k, x in enumerate((self.tooth, self.slot[upper]))
        ]
        found = []
        for elements, axis, place in ((own[0], 1, float(upper)), (own[1], 0, 0.0)):
            points = np.insert(np.stack([one, two]), axis, place, axis=0)
            basis = Basis(self.mesh, ElementHex2(), elements=elements.ravel(), quadrature=(points, np.ones(one.size)))
            found.append(self._principal(basis, moved))
        return np.concatenate(found)

    def _principal(self, basis: Basis, moved: FloatArray) -> FloatArray:
        gradient = np.stack([np.asarray(basis.interpolate(x).grad) for x in moved])
        strain = np.moveaxis(0.5 * (gradient + gradient.transpose(1, 0, 2, 3)), (0, 1), (-2, -1))
        lame = self.modulus * self.poisson / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson))
        trace = np.trace(strain, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
        return np.asarray(np.linalg.eigvalsh(lame * trace + self.modulus / (1.0 + self.poisson) * strain)[..., -1])


def _halved(corners: FloatArray) -> FloatArray:
    """Places of corners and of the nodes halfway between them."""
    return np.interp(np.arange(2 * corners.size - 1), 2 * np.arange(corners.size), corners)


def _quadratic(x: float) -> tuple[FloatArray, FloatArray]:
    """Values and slopes at x of the quadratic functions of the nodes 0, 1 and 2."""
    values = [0.5 * (x - 1.0) * (x - 2.0), x * (2.0 - x), 0.5 * x * (x - 1.0)]
    return np.array(values), np.array([x - 1.5, 2.0 - 2.0 * x, x - 0.5])


def root_peaks(loaded: LoadedMesh, member: Member, cells: Cells, radius: float) -> RootPeaks:
    """Both methods on one member with an edge radius [m], under the contact forces of a loaded mesh."""
    design = with_edge_radius(loaded.mesh.bevel, radius)
    given = design.pinion if member == "pinion" else design.gear
    body, flanks, pitch = given.tooth_body(), design.flanks(), 2.0 * np.pi / design.pinion.blank.teeth
    tooth = root_tooth(flanks, member, solid_tooth_of(flanks, body, member, "drive"), loaded.mesh.pitch.module_normal)
    load = loaded.grids.fine
    model = root_stress(tooth, load.positions, pitch)
    clock = time.perf_counter()
    material = body.material
    fem = RootElements(
        flanks, member, body.rim_thickness, material.youngs_modulus, material.poisson_ratio, body.held, cells
    )
    upper = fem.grid.sides[1] == flanks.loaded_side(member, "drive")
    # the worst position of the model and the next on both sides
    worst = int(model.history.argmax())
    rolls = model.roll[np.clip(np.arange(worst - 1, worst + 2), 0, model.roll.size - 1)]
    right = np.stack([_forces(fem, load.positions, roll, pitch, member, upper) for roll in rolls], axis=1)
    stress = [float(fem.principal(x.reshape(TEETH, 3, -1)[0], upper).max()) for x in fem.solve(right).T]
    return RootPeaks(max(stress), model.tension, fem.stiffness.shape[0], time.perf_counter() - clock)


def _forces(
    fem: RootElements, positions: tuple[PositionLoad, ...], roll: float, pitch: float, member: Member, upper: bool
) -> FloatArray:
    """Forces on all nodes of the ring, tooth 0 at a roll of its pair."""
    away = [(roll - p.position.pinion_angle) / pitch for p in positions]
    at = positions[int(np.argmin(np.abs(away - np.round(away))))]
    own = round((roll - at.position.pinion_angle) / pitch)
    # the next tooth in rising azimuth carries the next pair or the one before
    ahead = (1 if upper else -1) * (1 if member == "pinion" else -1)
    face, height = (getattr(at.position, f"{name}_{member}") for name in ("face", "height"))
    found = np.zeros((TEETH, 3, fem.size))
    for step in (-1, 0, 1):
        points = (at.position.pair == own + step * ahead) & (at.force > 0.0)
        found[step] = fem.spread(face[points], height[points], at.force[points], upper)
    return found.ravel()


DESIGNS = (
    "fm_spiral_bevel_14x39", "fm_hypoid_13x42", "fh_hypoid_9x34", "fh_hypoid_9x34_offset_10", "fh_spiral_bevel_12x37",
)  # fmt: skip


def main() -> None:
    """Print the stress of each member of the designs named, else of `DESIGNS`, by both methods."""
    members: tuple[Member, Member] = ("pinion", "gear")
    for name in sys.argv[1:] or DESIGNS:
        loaded = efficiency.load(name).mesh().load()
        radius = EDGE_RADIUS * loaded.mesh.pitch.module_normal
        for member in members:
            found = root_peaks(loaded, member, Cells(), radius)
            print(
                f"| {name}, {member} | {found.model / 1e6:.0f} MPa | {found.elements / 1e6:.0f} MPa "
                f"| {100 * found.error:+.1f} % | {found.unknowns} | {found.seconds:.0f} s |",
                flush=True,
            )


if __name__ == "__main__":
    main()
