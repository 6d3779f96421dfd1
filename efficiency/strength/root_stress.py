"""Root stress of the teeth over the mesh cycle: finite elements of one pitch in a ring, loaded by the contact forces.

The stiffness is factorised once for each member. Unit forces on the flank produce the stress along both fillets of the
loaded tooth and of its two neighbours; any load distribution is a superposition of these. The stress is the maximum
principal stress at the free surface, from the strain in the surface, and only normal forces are included.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.gear_flanks import GearFlanks, Member
from efficiency.cutting.machine import rotation
from efficiency.ltca.load_distribution import PositionLoad
from efficiency.ltca.solid_tooth import SolidTooth, ring_displacements
from efficiency.strength import hexahedra
from efficiency.strength.root_mesh import Counts, RootMesh, root_mesh
from ehl.common.arrays import BoolArray, FloatArray
from ehl.common.errors import InputError

# teeth in the ring; more teeth change the stress by less than 0.1 %
_RING = 3
# elements above the middle of the fillet for which the stress is evaluated
_OVER = 3
# of the factors; stresses differ from those of double precision by less than 1e-4
_PRECISION = np.float32
_GAUSS = 1.0 / np.sqrt(3.0)
_CORNERS = [(x, z) for x in (0, 1) for z in (0, 1)]


@dataclass(frozen=True)
class RootTooth:
    """Stress response of a tooth of one member to unit forces on its flank."""

    member: Member
    # stress at p points along the fillets of s stations on the loaded and the opposite side of a tooth per unit normal
    # force at n points of the flank of this pair (0), of the next (1) and of the previous one (-1): along the outline,
    # across it and shear [1/m2]
    loaded: dict[int, NDArray[np.float32]]
    far: dict[int, NDArray[np.float32]]
    levels: FloatArray  # height of the load points above the root cone, at stations along the face [m]
    width: float  # face width [m]
    station: FloatArray  # distance from the toe [m]
    height: FloatArray  # height of the points on the loaded side above the root cone [m]
    # radius of the fillet on the loaded side, and thickness of the tooth between its tangents of 30 deg [m]
    radius: FloatArray
    chord: FloatArray
    fillet: str  # origin of the fillets, in words
    winding: float  # angle by which the tooth winds around its axis [rad]

    def shares(self, face: FloatArray, height: FloatArray) -> FloatArray:
        """Weights (m, n) of the load points for forces at distances from the toe and above the root cone (m,) [m].

        They are linear in between, so that forces and moments are preserved.
        """
        rows, columns = self.levels.shape
        at = np.clip(face / self.width, 0.0, 1.0) * (columns - 1)
        column = np.minimum(at.astype(int), columns - 2)
        along = at - column
        level = self.levels[:, column] * (1.0 - along) + self.levels[:, column + 1] * along
        row = np.clip((level <= height).sum(axis=0) - 1, 0, rows - 2)
        each = np.arange(face.size)
        low, high = level[row, each], level[row + 1, each]
        over = np.clip((height - low) / (high - low), 0.0, 1.0)
        found = np.zeros((face.size, rows, columns))
        for i, j in _CORNERS:
            found[each, row + i, column + j] = (over if i else 1.0 - over) * (along if j else 1.0 - along)
        return found.reshape(face.size, -1)


@dataclass(frozen=True)
class RootStress:
    """Root stress of one tooth over its mesh."""

    member: Member
    tension: float  # maximum principal stress along the fillet on the loaded side [Pa]
    compression: float  # most negative principal stress on the opposite side [Pa]
    # place of the maximum tension: distance from the toe, height above the root cone [m]
    face: float
    height: float
    roll: FloatArray  # roll of the tooth pair [rad of the pinion]
    # maximum tension and compression along the face at each roll [Pa]
    history: FloatArray
    history_compression: FloatArray
    station: FloatArray  # distance from the toe [m]
    along: FloatArray  # maximum tension of the mesh cycle at these stations [Pa]
    # radius of the fillet there [m], and its notch parameter: thickness over twice the radius [-]
    radius: float
    notch: float
    fillet: str  # origin of the fillet, in words


WOUND = 5.0
"""Angle by which a tooth winds around its axis above which it has more elements, and its stress was not checked."""


def root_tooth(
    flanks: GearFlanks, member: Member, tooth: SolidTooth, module: float, counts: Counts | None = None
) -> RootTooth:
    """Mesh, factors and unit stresses of one member; `ConvergenceError` if no fillet fits or elements are folded.

    `tooth` contains the flanks, the body and the loaded side; `module` is the mean normal module for the default edge
    radius of a cutter [m].
    """
    body, grid = tooth.body, tooth.grid
    usual = Counts()
    counts = counts or replace(usual, along=int(np.ceil(usual.along * max(1.0, grid.winding / WOUND))))
    mesh = root_mesh(flanks, member, grid, body.rim_thickness, module, counts)
    side = int(tooth.side)
    modulus = np.where(mesh.rim, body.moduli["foot"], body.moduli["tooth"])
    poisson = body.material.poisson_ratio
    held = np.zeros(len(mesh.nodes), bool)
    for name in body.held:
        held |= getattr(mesh, name)
    kept = np.zeros(len(mesh.nodes), bool)
    kept[mesh.left] = kept[mesh.right] = True
    stiffness = hexahedra.element_stiffness(mesh.nodes[mesh.elements], modulus, poisson, _PRECISION)
    factors = hexahedra.Factors(mesh.elements, stiffness, mesh.places, kept, held)
    # the loaded flank of the pinion faces the next pair, that of the gear the previous one
    ahead = (1 if side else -1) * (-1 if member == "pinion" else 1)
    read = {k: _Surface(mesh, k) for k in (0, 1)}
    wanted = np.zeros(len(mesh.nodes), bool)
    for surface in read.values():
        wanted[surface.elements[..., hexahedra.FACE]] = True
    moved = _ring_solution(mesh, factors, held, wanted, _unit_forces(mesh, side), grid.pitch)
    stress = {
        k: {
            j * ahead: surface.stress(u, body.material.youngs_modulus, poisson).astype(np.float32)
            for j, u in moved.items()
        }
        for k, surface in read.items()
    }
    places = read[side].sorted(read[side].places)
    u, height = grid.blank.place(np.moveaxis(places, -1, 0))
    station = u.mean(axis=1) - grid.u[0, 0]
    low = 2 * counts.low
    outline = mesh.outlines[side]
    floor = grid.blank.root(mesh.stations[::2] + grid.u[0, 0])
    return RootTooth(
        member,
        stress[side],
        stress[1 - side],
        outline.height[low::2, ::2] - floor,
        float(mesh.stations[-1]),
        station,
        height - grid.blank.root(u),
        np.interp(station, mesh.columns, mesh.radius[side]),
        np.interp(station, mesh.columns, mesh.chord),
        mesh.fillet,
        grid.winding,
    )


def root_stress(tooth: RootTooth, loads: Sequence[PositionLoad], pitch: float) -> RootStress:
    """Stress of a tooth over the mesh cycle from loads over one pitch of the pinion [rad]."""
    rolls: list[float] = []
    forces: dict[int, list[FloatArray]] = {j: [] for j in tooth.loaded}
    for load in loads:
        p = load.position
        face, height = (getattr(p, f"{name}_{tooth.member}") for name in ("face", "height"))
        carried = load.force[:, None] * tooth.shares(face, height)
        for pair in np.unique(p.pair[load.force > 0.0]):
            rolls.append(p.pinion_angle + float(pair) * pitch)
            for j, found in forces.items():
                found.append(carried[p.pair == pair + j].sum(axis=0))
    if not rolls:
        raise InputError("load", "no loaded point", "a load distribution with forces above 0 N")
    order = np.argsort(rolls)
    carried_by = {j: np.stack(found)[order].T for j, found in forces.items()}

    def principal(unit: dict[int, NDArray[np.float32]], sign: float) -> FloatArray:
        """Maximum (sign 1) or minimum principal stress (s, p, k)."""
        one, two, shear = np.moveaxis(sum((unit[j] @ f for j, f in carried_by.items()), np.zeros(())), 2, 0)
        return np.asarray(0.5 * (one + two) + sign * np.hypot(0.5 * (one - two), shear))

    tension, pressed = principal(tooth.loaded, 1.0), principal(tooth.far, -1.0)
    worst = np.unravel_index(int(np.argmax(tension)), tension.shape)
    radius = float(tooth.radius[worst[0]])
    return RootStress(
        tooth.member,
        float(tension.max()),
        float(pressed.min()),
        float(tooth.station[worst[0]]),
        float(tooth.height[worst[0], worst[1]]),
        np.array(rolls)[order],
        tension.max(axis=(0, 1)),
        pressed.min(axis=(0, 1)),
        tooth.station,
        tension.max(axis=(1, 2)),
        radius,
        float(tooth.chord[worst[0]]) / (2.0 * radius),
        tooth.fillet,
    )


def _unit_forces(mesh: RootMesh, side: int) -> FloatArray:
    """Consistent forces (3 nodes, points) of unit normal loads at points of a flank, with linear pressures in between.

    The moments of the pressures with all linear functions are those of the unit load, so that force and moment are
    preserved.
    """
    elements = mesh.elements[mesh.surface[side][mesh.counts.low :]]
    rows, columns = elements.shape[:2]
    points, weights = np.polynomial.legendre.leggauss(3)
    at = np.array([[x, -1.0, z] for x in points for z in points])
    weight = np.outer(weights, weights).ravel()
    values, slopes = hexahedra.shape_functions(at)
    corners = mesh.nodes[elements]
    one, two = (np.einsum("pn,rcnx->rcpx", slopes[..., axis], corners) for axis in (0, 2))
    area = np.cross(one, two)
    opposite = hexahedra.CORNERS_AND_EDGES[:, 1] == 1
    inside = corners[:, :, opposite].mean(axis=2) - corners[:, :, hexahedra.FACE].mean(axis=2)
    area *= np.sign(np.einsum("rcpx,rcx->rcp", area, inside))[..., None]
    size = np.linalg.norm(area, axis=-1)
    linear = [(0.5 * (1.0 - at[:, k]), 0.5 * (1.0 + at[:, k])) for k in (0, 2)]
    place = np.arange((rows + 1) * (columns + 1)).reshape(rows + 1, columns + 1)
    moments = np.zeros((place.size, place.size))
    forces = np.zeros((len(mesh.nodes), 3, place.size))
    for i, j in _CORNERS:
        share = linear[0][i] * linear[1][j]
        own = place[i : rows + i, j : columns + j]
        part = np.einsum("rcpx,p,pn->rcnx", area, weight * share, values)
        np.add.at(forces, (elements[..., None], np.arange(3), own[..., None, None]), part)
        for m, n in _CORNERS:
            other = place[m : rows + m, n : columns + n]
            np.add.at(moments, (own, other), size @ (weight * share * linear[0][m] * linear[1][n]))
    return np.asarray(np.linalg.solve(moments, forces.reshape(-1, place.size).T).T)


def _ring_solution(
    mesh: RootMesh, factors: hexahedra.Factors, held: BoolArray, wanted: BoolArray, forces: FloatArray, pitch: float
) -> dict[int, hexahedra.Real]:
    """Displacement (3 nodes, points) of the loaded tooth (0) and of the next in increasing (1) and decreasing azimuth.

    The latter has the key -1. Only the displacement of the wanted nodes is complete.
    """
    free = ~held[mesh.left]
    cuts = mesh.left[free], mesh.right[free]
    position = np.empty(len(mesh.nodes), np.int64)
    position[factors.border] = np.arange(factors.border.size)
    both = np.concatenate(cuts)
    order = hexahedra.degrees_of_freedom(position[both])
    side = order.size // 2
    turn = rotation(pitch)

    def turned(values: FloatArray, matrix: FloatArray) -> FloatArray:
        """Values of both cuts with those of the right cut in another frame."""
        right = matrix @ values[side:].reshape(-1, 3, values.shape[1])
        return np.concatenate([values[:side], right.reshape(side, -1)])

    reduced = factors.condensed_load(forces.astype(_PRECISION))
    # displacements on the right cut in the frame of the next pitch
    stiffness = factors.stiffness[np.ix_(order, order)].astype(float)
    stiffness = turned(turned(stiffness, turn.T).T, turn.T)
    around = ring_displacements(
        stiffness, turned(reduced[hexahedra.degrees_of_freedom(both)].astype(float), turn.T), _RING, _RING
    )
    count = reduced.shape[1]
    whole = np.zeros((reduced.shape[0], 3 * count), reduced.dtype)
    whole[:, :count] = reduced
    for k, j in enumerate((0, 1, -1)):
        ends = np.concatenate([around[j % _RING], around[(j + 1) % _RING]])
        whole[hexahedra.degrees_of_freedom(both), k * count : (k + 1) * count] = turned(ends, turn)
    whole[hexahedra.degrees_of_freedom(np.flatnonzero(held))] = 0.0
    whole = factors.displacement(whole, wanted)
    return {j: whole[:, k * count : (k + 1) * count] for k, j in enumerate((0, 1, -1))}


class _Surface:
    """Optimal stress points of quadratic elements on the fillet surface of one side, and their strain."""

    def __init__(self, mesh: RootMesh, side: int) -> None:
        self.elements = mesh.elements[mesh.surface[side][: mesh.counts.low + _OVER]]  # (o, c, 20)
        self.at = np.array([[x, -1.0, z] for x in (-_GAUSS, _GAUSS) for z in (-_GAUSS, _GAUSS)])
        values, slopes = hexahedra.shape_functions(self.at)
        corners = mesh.nodes[self.elements]
        one, two = (np.einsum("pn,ocnx->ocpx", slopes[..., axis], corners) for axis in (0, 2))
        first = one / np.linalg.norm(one, axis=-1)[..., None]
        normal = np.cross(one, two)
        normal /= np.linalg.norm(normal, axis=-1)[..., None]
        second = np.cross(normal, first)
        self.axes = np.stack([first, second], axis=-2)
        metric = np.einsum("ocpix,ocpjx->ocpij", np.stack([one, two], axis=-2), self.axes)
        self.slopes = np.einsum("ocpij,pnj->ocpin", np.linalg.inv(metric), slopes[..., [0, 2]])
        self.places = np.einsum("pn,ocnx->ocpx", values, corners)

    def stress(self, moved: hexahedra.Real, modulus: float, poisson: float) -> FloatArray:
        """Plane stress (s, p, 3, k) of displacements (3 nodes, k): along the outline, across it, shear [Pa]."""
        local = moved.reshape(-1, 3, moved.shape[1])[self.elements[..., hexahedra.FACE]]
        rate = np.einsum("ocpin,ocnxk->ocpixk", self.slopes[..., hexahedra.FACE], local, optimize=True)
        rate = np.einsum("ocpixk,ocpjx->ocpijk", rate, self.axes, optimize=True)
        one, two, shear = rate[..., 0, 0, :], rate[..., 1, 1, :], rate[..., 0, 1, :] + rate[..., 1, 0, :]
        scale = modulus / (1.0 - poisson**2)
        parts = [one + poisson * two, two + poisson * one, 0.5 * (1.0 - poisson) * shear]
        return self.sorted(scale * np.stack(parts, axis=-2))

    @staticmethod
    def sorted(values: FloatArray) -> FloatArray:
        """Values of elements with four points each (o, c, 4, ...) as stations and points (s, p, ...)."""
        outline, along = values.shape[:2]
        rest = values.shape[3:]
        split = values.reshape(outline, along, 2, 2, *rest).swapaxes(0, 1)  # along, outline, x, z
        return np.moveaxis(split, 3, 1).reshape(2 * along, 2 * outline, *rest)
