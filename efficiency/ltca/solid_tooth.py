"""One tooth of a member as a three-dimensional elastic solid on its ring of teeth, condensed to one flank.

The deflection under loads on the flank is that of the flank, except near the load. There it is that of the middle
surface of the tooth on the normal of the contact point: the local deformation between both is a separate part
(`local_compliance`). The solid is solved once per member at the nodes of a grid on the flank; polynomials interpolate
in between.

A member as a ring of equal tooth cells: deflections of a loaded tooth and of its neighbours.

Each cell shares the functions on its left side with the previous cell. Its inner unknowns are condensed onto the two
sides. The ring of sides has a block-circulant stiffness, solved by the discrete Fourier transform over the teeth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from efficiency.contact.gear_flanks import GearFlanks, Member, Side
from efficiency.contact.tooth_grid import ToothGrid, tooth_grid, tooth_shapes
from efficiency.cutting.machine import rotation
from efficiency.ltca import ritz_solid as ritz
from efficiency.ltca.ritz_solid import ORDERS, Orders, Part, RitzSolid, ToothCell
from ehl.common.arrays import FloatArray, IntArray
from ehl.common.errors import ConvergenceError
from ehl.material import Material

REACH = 3
"""Teeth ahead of the loaded one whose deflection is kept."""


@dataclass(frozen=True)
class RingResponse:
    """Values of functionals of the displacement of a tooth under loads on one tooth."""

    own: FloatArray  # (k, m) value on the loaded tooth per unit load [m/N]
    ahead: tuple[FloatArray, ...]  # value on the next teeth in increasing azimuth [m/N]


def ring_response(solid: RitzSolid, pitch: float, cells: int, functionals: FloatArray, loads: int) -> RingResponse:
    """Solve a ring of cells, a pitch [rad] apart; `ConvergenceError` if the member is not held.

    `functionals` (k, 3 n): displacement at the points of interest, of all components of all functions. The first
    `loads` of them are also the places of unit forces in the direction of the displacement.
    """
    count, side = solid.count, 3 * solid.left.size

    def components(functions: IntArray) -> IntArray:
        return np.concatenate([functions + i * count for i in range(3)])

    border = np.concatenate([components(solid.left), components(solid.right)])
    body = np.union1d(*(solid.functions[part].number for part in ("foot", "slot")))
    # the tooth onto its root, then the body onto the sides
    part = _CondensedBody(np.arange(3 * count), solid.stiffness, functionals.T, np.zeros((len(functionals),) * 2))
    for kept in (components(body), border):
        part = part.condensed(kept)
    order = np.searchsorted(part.unknowns, border)
    stiffness, sides = part.stiffness[np.ix_(order, order)], part.functionals[order]
    # displacements on the right side, in the frame of the next cell
    frame = np.eye(2 * side)
    frame[side:, side:] = np.kron(rotation(pitch), np.eye(solid.left.size))
    seen = frame.T @ sides
    moved = ring_displacements(frame.T @ stiffness @ frame, seen[:, :loads], cells, REACH + 2)
    readings = [seen[:side].T @ moved[j] + seen[side:].T @ moved[j + 1] for j in range(REACH + 1)]
    # in a ring of few cells a tooth ahead is the loaded one again
    readings = [read + (j % cells == 0) * part.compliance[:, :loads] for j, read in enumerate(readings)]
    return RingResponse(readings[0], tuple(readings[1:]))


@dataclass(frozen=True)
class _CondensedBody:
    """A body condensed onto some unknowns: stiffness, functionals (columns), compliance of the eliminated unknowns."""

    unknowns: IntArray
    stiffness: FloatArray
    functionals: FloatArray
    compliance: FloatArray

    def condensed(self, kept: IntArray) -> _CondensedBody:
        """The same body on fewer unknowns (Schur complement)."""
        stays = np.isin(self.unknowns, kept)
        inner, outer = np.flatnonzero(~stays), np.flatnonzero(stays)
        scale = 1.0 / np.sqrt(np.diag(self.stiffness)[inner])
        matrix = self.stiffness[np.ix_(inner, inner)] * scale[:, None] * scale
        try:
            factor = scipy.linalg.cholesky(matrix, lower=True, overwrite_a=True, check_finite=False)
        except scipy.linalg.LinAlgError as error:
            raise ConvergenceError("tooth_not_held", "the stiffness of the tooth is not positive definite") from error
        coupling = self.stiffness[np.ix_(inner, outer)]
        # unknowns without coupling to the inside do not change
        touched = np.flatnonzero(coupling.any(axis=0))
        sides = np.concatenate([coupling[:, touched], self.functionals[inner]], axis=1)
        half = scipy.linalg.solve_triangular(
            factor, scale[:, None] * sides, lower=True, overwrite_b=True, check_finite=False
        )
        rest = half.T @ half
        size = touched.size
        stiffness, functionals = self.stiffness[np.ix_(outer, outer)], self.functionals[outer]
        stiffness[np.ix_(touched, touched)] -= rest[:size, :size]
        functionals[touched] -= rest[:size, size:]
        return _CondensedBody(self.unknowns[outer], stiffness, functionals, self.compliance + rest[size:, size:])


def ring_displacements(condensed: FloatArray, force: FloatArray, cells: int, count: int) -> FloatArray:
    """Displacements (count, side, loads) of the left sides of the loaded cell and of the following cells."""
    side = condensed.shape[0] // 2
    ll, lr, rr = condensed[:side, :side], condensed[:side, side:], condensed[side:, side:]
    moved = np.zeros((count, side, force.shape[1]))
    # harmonics k and cells - k are conjugate
    for k in range(cells // 2 + 1):
        phase = np.exp(2j * np.pi * k / cells)
        matrix = ll + rr + lr * phase + lr.T / phase
        pull = force[:side] + force[side:] / phase
        if k == 0 or 2 * k == cells:
            matrix, pull, share = np.real(matrix), np.real(pull), 1.0
        else:
            share = 2.0
        try:
            found = scipy.linalg.cho_solve(
                scipy.linalg.cho_factor(matrix, lower=True, check_finite=False), pull, check_finite=False
            )
        except scipy.linalg.LinAlgError as error:
            raise ConvergenceError("tooth_not_held", "the body of the member is not constrained") from error
        for j in range(count):
            moved[j] += share / cells * np.real(phase**j * found)
    return moved


Points = tuple[FloatArray, FloatArray, NDArray[np.int64]]
"""Face, height [m] and number of the tooth of each contact point."""

# tuned: rows over the depth and columns along the face at which the flanks of the solid are computed (this work); may
# be changed after running `test_cell_follows_the_flanks`
ROWS, COLUMNS = 15, 7
_MIDDLE = 0.5
_NEWTON = 4
# tuned: radius of the local deformation in half thicknesses (in a half-space the difference of displacement between the
# surface and a depth vanishes at a distance of that depth; the factor is a choice of this work); may be changed after
# running `test_deflection_at_nine_flank_points`
_REACH = 1.5


@dataclass(frozen=True)
class ToothBody:
    """Material of a member and the body under its teeth."""

    material: Material  # material of the teeth
    rim_thickness: float  # from the root cone to the base, normal to the pitch cone [m]
    held: frozenset[str] = frozenset({"base"})  # surfaces of the body that are fixed to the shaft
    youngs_modulus: float | None = None  # Young's modulus of the body [Pa]; default: that of the teeth

    @property
    def moduli(self) -> dict[Part, float]:
        """Young's modulus of each part of a tooth cell [Pa]."""
        teeth = self.material.youngs_modulus
        under = teeth if self.youngs_modulus is None else self.youngs_modulus
        return {"foot": under, "slot": under, "tooth": teeth}


Bodies = tuple[ToothBody, ToothBody]
"""Bodies of pinion and gear."""


@dataclass(frozen=True)
class SolidTooth:
    """Compliance of a tooth at its loaded flank.

    Contact points are given by their distance from the toe along the pitch cone and above the root cone [m].
    """

    body: ToothBody  # material and body under the teeth
    grid: ToothGrid  # both flanks
    cell: ToothCell  # blocks of the tooth and the body
    side: float  # coordinate of the loaded flank across the tooth block: 1 the upper, 0 the lower one
    nodes: tuple[FloatArray, FloatArray]  # nodes over the height and along the face of the tooth block
    # (n, n) deflection at the nodes per unit normal force at the nodes [m/N] without local deformation; symmetric and
    # positive semidefinite, the height is the slowest index
    own: FloatArray
    ahead: tuple[FloatArray, ...]  # the same on the next teeth on the side that the loaded flank faces
    half_thickness: FloatArray  # (n,) distance along the normal from the flank to the middle surface at the nodes [m]
    discarded: float  # negative eigenvalue of `own` set to zero, over the largest eigenvalue [-]

    @property
    def face_width(self) -> float:
        """Face width [m]."""
        return self.cell.width

    def whole_depth(self, face: ArrayLike) -> FloatArray:
        """Height of the tip above the root cone at a distance from the toe [m]."""
        return np.asarray(np.interp(np.asarray(face, float), self.cell.stations, self.cell.top))

    def influences(self, sets: Sequence[Points]) -> list[FloatArray]:
        """Deflection along the contact normal per unit normal force [m/N], (n, n), of independent sets of points.

        The number of the tooth each point lies on increases to the side that the loaded flanks face.
        """
        shapes = self._interpolation(*(np.concatenate([points[k] for points in sets]) for k in (0, 1)))
        # one product for all points, because the matrices of the nodes are large and those of a set are small
        read = [shapes @ response for response in (self.own, *self.ahead)]
        matrices, start = [], 0
        for face, _, tooth in sets:
            here = slice(start, start + face.size)
            start += face.size
            shape = shapes[here].T
            matrix = np.zeros((face.size, face.size))
            teeth = {int(n): np.flatnonzero(tooth == n) for n in np.unique(tooth)}
            for n, at in teeth.items():
                for distance, response in enumerate(read):
                    there = teeth.get(n + distance)
                    if there is None:
                        continue
                    block = response[here][there] @ shape[:, at]
                    matrix[there[:, None], at] = block
                    if distance:
                        matrix[at[:, None], there] = block.T
            matrices.append(matrix)
        return matrices

    def depth(self, face: ArrayLike, height: ArrayLike) -> FloatArray:
        """Distance along the contact normal from the flank to the middle surface [m], (n,)."""
        return np.asarray(self._interpolation(face, height) @ self.half_thickness)

    def outline(self) -> FloatArray:
        """Closed outline of the flank: distance from the toe and above the root cone [m], (2, k)."""
        face = self.cell.stations
        there = np.stack([face, np.zeros_like(face)])
        back = np.stack([face, self.cell.top])[:, ::-1]
        return np.concatenate([there, back, there[:, :1]], axis=1)

    def _interpolation(self, face: ArrayLike, height: ArrayLike) -> FloatArray:
        """Values (points, nodes) of the polynomials of the flank grid."""
        b, c = self.cell.on_flank(np.asarray(face, float), np.asarray(height, float))
        over, along = (ritz.lagrange_polynomials(nodes, x)[0] for nodes, x in zip(self.nodes, (b, c), strict=True))
        return (over[:, :, None] * along[:, None, :]).reshape(b.size, -1)


def elastic_teeth(flanks: GearFlanks, bodies: Bodies, side: Side) -> tuple[SolidTooth, SolidTooth]:
    """Pinion and gear tooth, loaded on the flanks of a side.

    Raises `InputError` if the flanks of a member cross, and `ConvergenceError` if a flank does not span its blank or a
    tooth is pointed.
    """
    return solid_tooth_of(flanks, bodies[0], "pinion", side), solid_tooth_of(flanks, bodies[1], "gear", side)


def solid_tooth_of(
    flanks: GearFlanks, body: ToothBody, member: Member, side: Side, orders: Orders = ORDERS, cells: int | None = None
) -> SolidTooth:
    """Solid tooth of one member; `orders` and `cells` as in `solid_tooth`."""
    try:
        grid = tooth_grid(flanks, member, ROWS, COLUMNS)
    except ConvergenceError as error:
        if error.reason == "flanks_cross":
            # its error states the position of the crossing and the remedy
            tooth_shapes(flanks)
        raise
    return solid_tooth(grid, flanks.loaded_side(member, side), body, orders, cells)


def solid_tooth(
    grid: ToothGrid, loaded: str, body: ToothBody, orders: Orders = ORDERS, cells: int | None = None
) -> SolidTooth:
    """Solve a tooth for loads on its concave or convex flank.

    grid: both flanks.
    loaded ("concave", "convex"): loaded flank.
    body: material and body under the teeth.
    orders: polynomial orders.
    cells: teeth in the ring, default: all; a ring of fewer cells is closed like a complete one.
    Raises `ConvergenceError`: the tooth model is folded, or the body is not held.
    """
    if not body.held:
        raise ConvergenceError("tooth_not_held", "no surface of the body is fixed")
    cell, orders = ritz.tooth_cell(grid, body.rim_thickness), orders.longer(ritz.turns(grid))
    poisson = body.material.poisson_ratio
    try:
        solid = ritz.ritz_solid(cell, body.moduli, poisson, body.held, orders)
    except ConvergenceError as error:
        if error.reason != "tooth_folded":
            raise
        # steep fillets fold the polynomials of the slot between them: the tooth block then begins at the root
        cell = ritz.tooth_cell(grid, body.rim_thickness, from_root=True)
        solid = ritz.ritz_solid(cell, body.moduli, poisson, body.held, orders)
    side = 1.0 if grid.sides[1] == loaded else 0.0
    nodes = ritz.lobatto_nodes(orders.tooth[1] + 1), ritz.lobatto_nodes(orders.tooth[2] + 1)
    b, c = (x.ravel() for x in np.meshgrid(*nodes, indexing="ij"))
    flank, into = _flank_points(cell, side, b, c)
    middle, half = _middle_surface(cell, flank, into, b, c)
    reading = np.concatenate([_along_normal(solid, places, into) for places in ((np.full_like(b, side), b, c), middle)])
    count = b.size
    response = ring_response(solid, cell.pitch, cells or cell.teeth, reading, count)
    on_flank, on_middle = response.own[:count], response.own[count:]
    # weight of the local deformation: 1 near the load, decreasing to 0 at twice the half thickness
    distance = np.linalg.norm(flank[:, None] - flank[None], axis=-1)
    near = np.exp(-((distance / (_REACH * 0.5 * (half[:, None] + half[None]))) ** 4))
    own, discarded = _positive(on_flank - near * (on_flank - on_middle))
    # an upper loaded flank faces the next tooth in increasing azimuth
    ahead = tuple(matrix[:count] if side == 1.0 else matrix[:count].T for matrix in response.ahead)
    return SolidTooth(body, grid, cell, side, nodes, own, ahead, half, discarded)


def _flank_points(cell: ToothCell, side: float, b: FloatArray, c: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points (n, 3) of a flank [m] and unit normals into the tooth."""
    points, tangents = cell.tooth.place(np.full_like(b, side), b, c)
    normal = np.cross(tangents[:, 1], tangents[:, 2])
    inside = tangents[:, 0] * (0.5 - side)
    normal *= np.sign(np.sum(normal * inside, axis=1) / np.linalg.norm(normal, axis=1) ** 2)[:, None]
    return points, normal / np.linalg.norm(normal, axis=1)[:, None]


def _middle_surface(
    cell: ToothCell, flank: FloatArray, into: FloatArray, b: FloatArray, c: FloatArray
) -> tuple[tuple[FloatArray, FloatArray, FloatArray], FloatArray]:
    """Intersections of the normals with the middle surface, limited to it: block coordinates and distances."""
    # Newton's method on: point of the middle surface = flank point + distance times normal
    b, c = b.copy(), c.copy()
    distance = np.zeros_like(b)
    for _ in range(_NEWTON):
        points, tangents = cell.tooth.place(np.full_like(b, _MIDDLE), b, c)
        matrix = np.stack([tangents[:, 1], tangents[:, 2], -into], axis=-1)
        step = np.linalg.solve(matrix, (flank + distance[:, None] * into - points)[..., None])[..., 0]
        # at an end of the tooth the normal may leave it before the middle surface
        b, c = np.clip(b + step[:, 0], 0.0, 1.0), np.clip(c + step[:, 1], 0.0, 1.0)
        distance = distance + step[:, 2]
    points, _ = cell.tooth.place(np.full_like(b, _MIDDLE), b, c)
    return (np.full_like(b, _MIDDLE), b, c), np.sum((points - flank) * into, axis=1)


def _along_normal(
    solid: RitzSolid, places: tuple[FloatArray, FloatArray, FloatArray], direction: FloatArray
) -> FloatArray:
    """Displacement in given directions (n, 3) at positions in the tooth, as functionals of all components."""
    functions = solid.functions["tooth"]
    values = functions.values(*places)
    rows = np.zeros((values.shape[0], 3, solid.count))
    rows[:, :, functions.number] = direction[:, :, None] * values[:, None, :]
    return rows.reshape(values.shape[0], -1)


def _positive(response: FloatArray) -> tuple[FloatArray, float]:
    """Nearest symmetric positive semidefinite matrix, and its most negative eigenvalue over the largest."""
    values, vectors = np.linalg.eigh(0.5 * (response + response.T))
    kept = np.maximum(values, 0.0)
    matrix = (vectors * kept) @ vectors.T
    return 0.5 * (matrix + matrix.T), float(max(-values[0], 0.0) / values[-1])
