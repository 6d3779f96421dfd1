"""Root stress under the pair's own contact forces against other finite elements of the same teeth.

An independent second computation on the nodes of `root_mesh`: 27-node hexahedra of scikit-fem, a ring of three teeth in
one system, each contact force spread over the nodes of the face that it acts on, greatest principal stress of the full
tensor at the Gauss points of the faces of the fillet. As a script it prints both methods for every design and member.
"""

import sys
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix, diags_array, kron
from scipy.sparse.linalg import LinearOperator, cg, splu
from scipy.spatial import cKDTree
from skfem import Basis, ElementHex1, ElementHex2, MeshHex, MeshHex2
from skfem.models.elasticity import lame_parameters
from twins.compliance_fem import closing, elasticity

import efficiency
from efficiency.contact.gear_flanks import Member
from efficiency.cutting.machine import rotation
from efficiency.ltca.load_distribution import PositionLoad
from efficiency.ltca.solid_tooth import ToothBody
from efficiency.mesh import LoadedMesh
from efficiency.strength.hexahedra import CORNERS_AND_EDGES, shape_functions
from efficiency.strength.root_mesh import Counts, RootMesh, root_mesh
from efficiency.strength.root_stress import root_stress, root_tooth
from ehl.common.arrays import FloatArray, IntArray

TEETH = 3
HEX = ElementHex2()
FINE = Counts(low=6, high=9, layer=3, across=2, deep=2, along=8)


@dataclass(frozen=True)
class RootPeaks:
    """Greatest stress of the fillet of the loaded side, by both methods [Pa]; unknowns of the elements."""

    elements: float
    model: float
    unknowns: int


class RootElements:
    """Finite elements of a ring of teeth of one member."""

    def __init__(self, mesh: RootMesh, pitch: float, body: ToothBody, levels: FloatArray) -> None:
        """`levels`: heights of the nodes of the loaded flank over the root cone, up from the middle of the fillet."""
        self.mesh, self.levels, count = mesh, levels, len(mesh.nodes)
        values, _ = shape_functions(2.0 * HEX.doflocs - 1.0)
        tooth = np.einsum("an,enx->eax", values, mesh.nodes[mesh.elements])
        places = np.concatenate([tooth @ rotation(k * pitch).T for k in range(TEETH)]).transpose(2, 1, 0)
        number = np.arange(TEETH * count).reshape(TEETH, count)
        number[:-1, mesh.right] = number[1:, mesh.left]
        corner = [int(np.abs(CORNERS_AND_EDGES - 2.0 * at + 1.0).sum(axis=1).argmin()) for at in HEX.doflocs[:8]]
        self.corners, t = np.unique(number[:, mesh.elements[:, corner]], return_inverse=True)
        plain = MeshHex(np.zeros((3, self.corners.size)), t.reshape(-1, 8).T)
        curved = MeshHex2.from_mesh(plain)
        located = np.empty_like(curved.doflocs)
        located[:, curved.dofs.element_dofs] = places
        self.basis = Basis(MeshHex2(located, curved.t), HEX, intorder=5)
        self.places = np.empty((3, self.basis.N))
        self.places[:, self.basis.element_dofs] = places
        fixed = np.zeros(self.basis.N, bool)
        for name in body.held:
            fixed[self.on(np.unique(number[:, getattr(mesh, name)]))] = True
        first, last = self.on(mesh.left), self.on(mesh.right + (TEETH - 1) * count)
        around = self.places[:, last].T @ rotation(TEETH * pitch)
        away, pair = cKDTree(self.places[:, first].T).query(around)
        assert away.max() < 1e-9
        free = ~fixed
        free[last] = False
        self.expand = closing(self.basis.N, first[pair], last, TEETH * pitch)[:, np.tile(free, 3)].tocsr()
        modulus, poisson = body.material.youngs_modulus, body.material.poisson_ratio
        self.lame = lame_parameters(modulus, poisson)
        self.stiffness = (self.expand.T @ elasticity(self.basis, modulus, poisson) @ self.expand).tocsr()
        # trilinear functions of the corners of the same elements, for the preconditioner
        rows, corner = self.basis.element_dofs, self.basis.nodal_dofs[0]
        weights = np.array([ElementHex1().lbasis(HEX.doflocs.T, n)[0] for n in range(8)])[:, :, None]
        many = np.broadcast_arrays(weights, rows, self.basis.mesh.t[:, None])
        values, *places = (x.ravel() for x in many)
        linear = coo_matrix((values, tuple(places))).tocsr()
        linear = diags_array(1.0 / np.ravel(linear.sum(axis=1))) @ linear
        independent, at = np.flatnonzero(np.tile(free, 3)), (self.basis.N * np.arange(3)[:, None] + corner).ravel()
        self.linear = (kron(np.eye(3), linear) @ self.expand[at][:, np.isin(independent, at)]).tocsr()[independent]

    def on(self, corners: IntArray) -> IntArray:
        """Nodes of the faces with these corners."""
        mesh = self.basis.mesh
        outer = mesh.boundary_facets()
        return self.basis.get_dofs(outer[np.isin(self.corners, corners)[mesh.facets[:, outer]].all(axis=0)]).all()

    def solve(self, forces: FloatArray) -> FloatArray:
        """Displacements (3 nodes, k) under forces (3 nodes, k): conjugate gradients, two-level preconditioner."""
        inverse, linear = 1.0 / self.stiffness.diagonal(), self.linear
        coarse = splu((linear.T @ self.stiffness @ linear).tocsc(), permc_spec="MMD_AT_PLUS_A")
        levels = LinearOperator(self.stiffness.shape, lambda x: inverse * x + linear @ coarse.solve(linear.T @ x))
        found = [cg(self.stiffness, right, rtol=1e-6, M=levels) for right in (self.expand.T @ forces).T]
        assert not any(failed for _, failed in found)
        return np.asarray(self.expand @ np.stack([moved for moved, _ in found], axis=1))

    def spread(self, side: int, tooth: int, face: FloatArray, height: FloatArray, force: FloatArray) -> FloatArray:
        """Nodal forces (3, nodes) of forces against a flank of a tooth, from toe and over the root cone."""
        found, mapping = np.zeros((3, self.basis.N)), self.basis.mesh.mapping()
        rows = self.mesh.surface[side][self.mesh.counts.low :] + tooth * len(self.mesh.elements)
        planes = np.arange(self.mesh.stations.size)
        for x, h, f in zip(face, height, force, strict=True):
            z = float(np.interp(x, self.mesh.stations, planes))
            level = [np.interp(z, planes, line) for line in self.levels]
            r = float(np.interp(h, level, np.arange(len(level))))
            i, k = min(int(r) // 2, rows.shape[0] - 1), min(int(z) // 2, rows.shape[1] - 1)
            at = np.array([[0.5 * r - i], [0.0], [0.5 * z - k]])
            slope = mapping.DF(at, tind=rows[i, [k]])[:, :, 0, 0]
            normal = np.cross(slope[:, 0], slope[:, 2])
            normal *= np.sign(normal @ slope[:, 1]) / np.linalg.norm(normal)
            values = np.array([HEX.lbasis(at, n)[0][0] for n in range(27)])
            found[:, self.basis.element_dofs[:, rows[i, k]]] += f * np.outer(normal, values)
        return found

    def principal(self, side: int, moved: FloatArray) -> FloatArray:
        """Greatest principal stress at the Gauss points of the faces of a fillet of tooth 0 [Pa]."""
        one, two = (x.ravel() for x in np.meshgrid(*[0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)] * 2))
        elements = self.mesh.surface[side][: self.mesh.counts.low + 3].ravel()
        points = np.stack([one, 0.0 * one, two]), np.ones(one.size)
        basis = Basis(self.basis.mesh, HEX, elements=elements, quadrature=points)
        gradient = np.stack([np.asarray(basis.interpolate(x).grad) for x in moved.reshape(3, -1)])
        strain = np.moveaxis(0.5 * (gradient + gradient.transpose(1, 0, 2, 3)), (0, 1), (-2, -1))
        trace = np.trace(strain, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
        return np.asarray(np.linalg.eigvalsh(self.lame[0] * trace + 2.0 * self.lame[1] * strain)[..., -1])


def root_peaks(loaded: LoadedMesh, member: Member, counts: Counts) -> RootPeaks:
    """Both methods on one member under the contact forces of a loaded mesh."""
    design, solid = loaded.mesh.bevel, getattr(loaded.mesh.grids.teeth, member)
    flanks, module, pitch = design.flanks(), loaded.mesh.pitch.module_normal, 2.0 * np.pi / design.pinion.blank.teeth
    load = loaded.grids.fine
    model = root_stress(root_tooth(flanks, member, solid, module), load.positions, pitch)
    mesh, side = root_mesh(flanks, member, solid.grid, solid.body.rim_thickness, module, counts), int(solid.side)
    floor = solid.grid.blank.root(mesh.stations + solid.grid.u[0, 0])
    fem = RootElements(mesh, solid.grid.pitch, solid.body, mesh.outlines[side].height[2 * counts.low :] - floor)
    # the worst position of the model and the next on both sides
    worst = int(model.history.argmax())
    rolls = model.roll[np.clip(np.arange(worst - 1, worst + 2), 0, model.roll.size - 1)]
    right = np.stack([_forces(fem, load.positions, roll, pitch, member, side) for roll in rolls], axis=1)
    stress = [float(fem.principal(side, moved).max()) for moved in fem.solve(right).T]
    return RootPeaks(max(stress), model.tension, fem.stiffness.shape[0])


def _forces(
    fem: RootElements, positions: tuple[PositionLoad, ...], roll: float, pitch: float, member: Member, side: int
) -> FloatArray:
    """Forces on all nodes of the ring, tooth 0 at a roll of its pair."""
    away = [(roll - p.position.pinion_angle) / pitch for p in positions]
    at = positions[int(np.argmin(np.abs(away - np.round(away))))]
    own = round((roll - at.position.pinion_angle) / pitch)
    # the next tooth in rising azimuth carries the next pair or the one before
    ahead = (1 if side else -1) * (1 if member == "pinion" else -1)
    face, height = (getattr(at.position, f"{name}_{member}") for name in ("face", "height"))
    found = np.zeros((3, fem.basis.N))
    for step in (-1, 0, 1):
        points = (at.position.pair == own + step * ahead) & (at.force > 0.0)
        found += fem.spread(side, step % TEETH, face[points], height[points], at.force[points])
    return found.ravel()


DESIGNS = (
    "fm_spiral_bevel_14x39", "fm_hypoid_13x42", "fh_hypoid_9x34", "fh_hypoid_9x34_offset_10", "fh_spiral_bevel_12x37",
)  # fmt: skip


def main() -> None:
    """Print the stress of each member of the designs named, else of `DESIGNS`, by both methods."""
    members: tuple[Member, Member] = ("pinion", "gear")
    for name in sys.argv[1:] or DESIGNS:
        loaded = efficiency.load(name).mesh().load()
        for member in members:
            found = root_peaks(loaded, member, FINE)
            print(
                f"| {name}, {member} | {found.model / 1e6:.0f} MPa | {found.elements / 1e6:.0f} MPa "
                f"| {100 * (found.model / found.elements - 1.0):+.1f} % | {found.unknowns} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
