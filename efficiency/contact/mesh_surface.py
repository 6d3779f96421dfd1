"""The gear flank as a map of the mesh: surface of roll angle, ease-off, and limits of both flanks.

All fields are Chebyshev patches over (u, v): u [m] along the pitch cone of the gear from the mean point towards the
heel, v the fraction of its whole depth from the root. Gear points and parameters of the pinion points are solved once
(`flank_grid`) and used for every misaligned state. If the pinion is undercut its fields are fitted to the existing
points, and the map contains the limit of undercut.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.assembly import Assembly
from efficiency.contact.chebyshev import Patch, PointFit
from efficiency.contact.ease_off import ConjugatePoints, conjugate_points, ease_off, pinion_phase
from efficiency.contact.flank_grid import SHAPE, FlankGrid, flank_grid, last_point, regular_part
from efficiency.contact.relief import FlankDeviation, PairRelief
from efficiency.cutting.flank import CutFlank, Flank
from efficiency.cutting.machine import cross, dot, turn, unit
from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError

POSITION = ("x", "y", "z")


@dataclass(frozen=True)
class LineFrame:
    """Tangents of the gear flank at points of contact lines, gear frame."""

    along: FloatArray  # (3, n) unit tangent of the line of constant roll angle, towards the heel
    # (3, n) tangential gradient of the roll angle [rad/m]; the line moves over the gear at ``1/|gradient|`` per unit
    # speed
    gradient: FloatArray
    # (2, n) change of (u, v) per metre along the gradient and along the line
    rates_gradient: FloatArray
    rates_along: FloatArray


def line_frame(patch: Patch, u: FloatArray, v: FloatArray) -> LineFrame:
    """Directions of the contact lines through points of the gear flank."""
    ru, rv = patch(u, v, POSITION, du=1), patch(u, v, POSITION, dv=1)
    (roll_u,), (roll_v,) = patch(u, v, ("roll",), du=1), patch(u, v, ("roll",), dv=1)
    along = (ru * roll_v - rv * roll_u) * np.sign(roll_v)
    stretch = np.sqrt(dot(along, along))
    rates_along = np.stack([roll_v, -roll_u]) * np.sign(roll_v) / stretch
    e, f, g = dot(ru, ru), dot(ru, rv), dot(rv, rv)
    area = e * g - f * f
    up, vp = (g * roll_u - f * roll_v) / area, (e * roll_v - f * roll_u) / area
    gradient = ru * up + rv * vp
    size = np.sqrt(dot(gradient, gradient))
    return LineFrame(along / stretch, gradient, np.stack([up, vp]) / size, rates_along)


_AXIS = np.array([[0.0], [0.0], [1.0]])  # axis of a member in its work frame


def tangent_angle(axis: FloatArray, normal: FloatArray, direction: FloatArray) -> FloatArray:
    """Angle of tangents d (3, n) of a flank with outward normals n (3, n) and axis (3, 1) [rad].

    ``atan2(d . (n x e1), d . e1)`` with ``e1 = axis x n``: the angle is invariant to rotation about the axis, so that
    the lay of a flank can be used in the mesh.
    """
    first = unit(cross(np.broadcast_to(axis, normal.shape), normal))
    return np.asarray(np.arctan2(dot(direction, cross(normal, first)), dot(direction, first)))


def undirected(angle: FloatArray) -> FloatArray:
    """An angle between undirected lines, from -pi/2 to pi/2 [rad]."""
    return np.asarray((angle + 0.5 * np.pi) % np.pi - 0.5 * np.pi)


def mark_angles(flank: Flank, u: FloatArray, h: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Angle of the lay at blank coordinates u, h (n,) [m], [rad], and a mask of existing points."""
    points, found = flank.solve(u, h)
    angle = tangent_angle(_AXIS, points.normal, flank.marks(points))
    # undirected lines: no angle may differ by pi from the first existing one
    first = angle[int(np.argmax(found))]
    return first + undirected(angle - first), found


BoolArray = NDArray[np.bool_]

NORMAL = ("nx", "ny", "nz")
# the lay direction varies slowly over a flank: error between nodes 0.01 deg (13x42), 1 deg at an undercut (9x34)
_MARK_NODES, _MARK_SHAPE = (8, 6), (4, 3)
PINION = ("px", "py", "pz")
EDGES = (
    *("gear toe", "gear heel", "gear tip", "gear root"),
    *("pinion toe", "pinion heel", "pinion tip", "pinion root", "pinion undercut"),
)
# tuned: largest undercut share of the mating flank (this work); may be changed freely
_MAX_UNDERCUT = 0.3
# tuned: largest interpolation error of a map, as a fraction of the tooth depth (this work); may be lowered freely
_MAX_ERROR = 0.01


@dataclass(frozen=True)
class UndercutRegion:
    """The part of the mating flank that is missing because the pinion is undercut."""

    share: float  # share of the flank area inside both blanks
    u: tuple[float, float]  # range along the pitch cone of the gear from its mean point [m]
    fraction: tuple[float, float]  # range of the depth fraction of the gear, 0 root, 1 tip


@dataclass(frozen=True)
class MeshSurface:
    """Fields of the mesh on the gear flank."""

    # real flanks
    gear: Flank
    pinion: Flank
    assembly: Assembly  # their position with misalignments
    phase: float  # rotation of the pinion flank about its axis [rad] for which the minimum ease-off is zero
    direction: float  # +1 or -1: sense of pinion rotation about the axis of the mesh frame when these flanks drive
    # pinion rotation f1 [rad] at contact of the design point; roll angles are ``direction (f1 - roll_zero)``
    roll_zero: float
    design_point: tuple[float, float]  # (u, v) of the design point: mean cone distance, middle of the working depth
    # (u, v) of the minimum ease-off over lever inside the flanks, where the transmission error is highest
    error_maximum: tuple[float, float]
    # fields ``x y z nx ny nz`` (gear frame; normal out of the gear tooth), ``azimuth`` of that point relative to the
    # design point, ``roll`` (surface of roll angle in driving direction [rad]), ``ease_off`` [m], ``lever`` (lever arm
    # about the gear axis [m]), ``ease_off_angle`` (ease-off over lever: the gear rotation that closes it [rad]),
    # ``bend`` (separation of the conjugate pair over the lever is ``bend (roll - angle)^2/2`` at a point fixed to the
    # pinion [1/rad]), ``u1``, ``h1`` (blank coordinates on the pinion [m]), ``px py pz`` (real pinion point in its
    # frame, phase included, turned by the rotation at which it meshes [m]) and, for an undercut pinion, ``regular``
    # (positive where its flank exists)
    patch: Patch
    interpolation_error: float  # estimated error of ease-off and gear flank between the nodes, along the normal [m]
    undercut: UndercutRegion | None  # undercut part of the mating flank
    grid: FlankGrid  # solved flank points
    # relief of both flanks at their edges; the map itself is without relief
    relief: PairRelief = field(default_factory=PairRelief)

    def relief_depth(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Relief of both members together at map coordinates [m]."""
        u1, h1 = self.patch(u, v, ("u1", "h1"))
        of_gear = self.relief.gear.depth(self.gear.blank, u, self.height(u, v))
        return np.asarray(of_gear + self.relief.pinion.depth(self.pinion.blank, u1, h1))

    @property
    def pitch(self) -> float:
        """Angular pitch of the pinion [rad]."""
        return 2.0 * np.pi / self.assembly.teeth_pinion

    @property
    def error_maximum_roll(self) -> float:
        """Roll angle of that point [rad]."""
        u, v = self.error_maximum
        return float(self.patch(np.array([u]), np.array([v]), ("roll",))[0, 0])

    @property
    def forward(self) -> float:
        """+1 or -1: sense of gear rotation about its axis when these flanks drive."""
        return float(self.direction * np.sign(self.assembly.ratio))

    @property
    def undercut_scale(self) -> float:
        """Length that scales the field ``regular`` to a distance: the depth of the gear tooth [m]."""
        middle = np.zeros(1)
        return float((self.height(middle, np.ones(1)) - self.height(middle, middle))[0])

    @cached_property
    def marks(self) -> Patch:
        """Angles of the lay of both flanks [rad], fields ``gear``, ``pinion``."""
        half = 0.5 * self.gear.blank.face_width
        u, v = Patch.nodes((-half, half), (0.0, 1.0), _MARK_NODES)
        u1, h1 = self.patch(u, v, ("u1", "h1"))
        gear, on_gear = mark_angles(self.gear, u, self.height(u, v))
        pinion, on_pinion = mark_angles(self.pinion, u1, h1)
        both = on_gear & on_pinion
        fields = {"gear": gear[both], "pinion": pinion[both]}
        return PointFit((-half, half), (0.0, 1.0), _MARK_SHAPE, u[both], v[both])(fields)

    def common_points(self, columns: int, rows: int) -> tuple[FloatArray, FloatArray]:
        """Map coordinates of the points of a grid at which both members have a flank; `ConvergenceError` if none."""
        ranges = np.linspace(*self.patch.u_range, columns), np.linspace(*self.patch.v_range, rows)
        u, v = (g.ravel() for g in np.meshgrid(*ranges))
        inside = self.margin(u, v) >= 0.0
        if not inside.any():
            raise ConvergenceError("no_contact", "the blanks of both members have no common part of the flank")
        return u[inside], v[inside]

    @cached_property
    def roll_range(self) -> tuple[float, float]:
        """Smallest and largest roll angle at which both members have a flank [rad]."""
        roll = self.patch(*self.common_points(81, 61), ("roll",))[0]
        return float(roll.min()), float(roll.max())

    def height(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Height above the pitch cone of the gear [m]."""
        return self.gear.blank.height(u, v)

    def limits(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Distance inside each of `EDGES` [m], negative outside, (9, n); toe, heel, face and root cone, undercut."""
        u1, h1 = self.patch(u, v, ("u1", "h1"))
        of_gear, of_pinion = self.gear.blank.inside(u, self.height(u, v)), self.pinion.blank.inside(u1, h1)
        return np.stack([*of_gear, *of_pinion, self.regular(u, v)])

    def regular(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Measure of the distance of the pinion from its undercut limit [m]."""
        if "regular" not in self.patch.names:
            return np.full(np.shape(u), np.inf)
        return np.asarray(self.patch(u, v, ("regular",))[0] * self.undercut_scale)

    def margin(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Distance inside the nearest limit of both flanks [m], negative outside."""
        return np.asarray(self.limits(u, v).min(axis=0))


def mesh_surface(
    gear: Flank,
    pinion: Flank,
    assembly: Assembly,
    shape: tuple[int, int] = SHAPE,
    grid: FlankGrid | None = None,
    deviation: FlankDeviation | None = None,
) -> MeshSurface:
    """Map of the mesh of two real flanks in an assembly with its misalignments.

    gear, pinion, assembly: mating flanks and their position.
    shape: Chebyshev coefficients along the face and over the depth.
    grid: flank points of the same flanks from another position.
    deviation: of the flanks from the given ones.
    Raises `ConvergenceError`: a flank does not exist at the design point, too much of the mating region is undercut,
        the members do not mesh there, or the fields are not smooth enough for the map.
    """
    grid = grid or flank_grid(gear, pinion, assembly, shape)
    conjugate = conjugate_points(grid.points, assembly)
    phase = pinion_phase(last_point(conjugate), pinion, grid.start[:, -1:])
    relief, parameters, found = ease_off(conjugate, pinion, phase, grid.start)
    present, bound = regular_part(grid, parameters, found & grid.found)
    if not present.all() and not grid.dense:
        return mesh_surface(gear, pinion, assembly, grid=grid.denser(assembly), deviation=deviation)
    return _map(grid, assembly, conjugate, phase, relief, parameters, present, bound, deviation or FlankDeviation())


def _map(
    grid: FlankGrid,
    assembly: Assembly,
    conjugate: ConjugatePoints,
    phase: float,
    relief: FloatArray,
    parameters: FloatArray,
    present: BoolArray,
    bound: Patch | None,
    deviation: FlankDeviation,
) -> MeshSurface:
    points, missing = grid.points, deviation.depth(grid.gear.blank, grid.u, grid.v)
    relief = relief + missing
    in_mesh = assembly.gear_in_mesh(points.position, conjugate.gear_roll)
    force = -turn(points.normal, conjugate.gear_roll)
    lever_pinion, lever_gear = assembly.levers(in_mesh, force)
    lever = np.abs(lever_gear)
    direction = float(np.sign(lever_pinion[-1]))
    pinion_roll = conjugate.gear_roll / assembly.ratio
    u1, h1 = grid.pinion.blank.place(conjugate.position)
    fields = dict(zip(POSITION + NORMAL, [*points.position, *points.normal], strict=True)) | {
        "azimuth": np.angle(np.exp(1j * (points.azimuth - points.azimuth[-1]))),
        "roll": direction * (pinion_roll - pinion_roll[-1]),
        "lever": lever,
        "u1": u1,
        "h1": h1,
    }
    on_gear = _fitter(grid, grid.found)
    base = on_gear(fields)
    # off their line of contact the separation of the conjugate flanks is bend (roll - angle)^2/2 at a point fixed to
    # the pinion
    frame = line_frame(base, grid.u, grid.v)
    share = dot(direction * assembly.sliding(in_mesh), turn(frame.gradient, conjugate.gear_roll))
    base = base.joined(on_gear({"bend": conjugate.rate * (1.0 - share) / lever}))
    if bound is not None:
        base = base.joined(bound.raised(base.shape))

    on_pinion = _fitter(grid, present)

    follow = pinion_roll - pinion_roll[-1]

    def with_ease_off(relief: FloatArray) -> Patch:
        real = dict(zip(PINION, turn(conjugate.position + relief * conjugate.normal, follow), strict=True))
        return base.joined(on_pinion({"ease_off": relief, "ease_off_angle": relief / lever} | real))

    middle = (0.0, float(grid.v[-1]))
    start = MeshSurface(
        grid.gear,
        grid.pinion,
        assembly,
        phase,
        direction,
        float(pinion_roll[-1]),
        middle,
        middle,
        with_ease_off(relief),
        0.0,
        None,
        grid,
    )
    # rotate the pinion until its highest point contacts: the minimum ease-off becomes zero
    highest, lowest = _error_maximum(start)
    reached = relief[present] / lever[present]
    if lowest < reached.min() - np.ptp(reached) - _MAX_ERROR * start.undercut_scale / lever[-1]:
        raise ConvergenceError("map", "the ease-off is extrapolated beyond its points near the limit of undercut")
    phase += direction * lowest / abs(assembly.ratio)
    relief, parameters, found = ease_off(conjugate, grid.pinion, phase, parameters)
    relief = relief + missing
    if not found[present].all():
        present = present & found
        on_pinion = _fitter(grid, present)
    if present.mean() < 1.0 - 2.0 * _MAX_UNDERCUT:
        raise _undercut_error(grid, 1.0 - float(present.mean()), "map")
    surface = replace(start, phase=phase, error_maximum=highest, patch=with_ease_off(np.where(present, relief, 0.0)))
    tail = surface.patch.tail
    error = tail["ease_off"] if not grid.dense else _checked(surface, parameters, deviation)
    # error of the interpolated gear flank: azimuth error along the normal
    error += tail["azimuth"] * float(lever[-1])
    if not error < _MAX_ERROR * start.undercut_scale:
        raise ConvergenceError(
            "map",
            f"the flanks are not smooth enough for the map of the mesh: error {error * 1e6:.3g} um{_deep_roots(grid)}",
        )
    undercut = _undercut_region(surface)
    if undercut is not None and undercut.share > _MAX_UNDERCUT:
        raise _undercut_error(grid, undercut.share, "mating flank")
    return replace(surface, interpolation_error=error, undercut=undercut)


def _undercut_error(grid: FlankGrid, share: float, of: str) -> ConvergenceError:
    who = f"{grid.pinion.side} pinion flank" if grid.found.all() else f"{grid.gear.side} gear flank, or its mate,"
    return ConvergenceError(
        "undercut",
        f"the {who} is undercut, {share:.0%} of the {of} is missing; change the profile shift, or raise "
        f"the pressure angle or the spiral angle{_deep_roots(grid)}",
    )


def _deep_roots(grid: FlankGrid) -> str:
    """Flanks whose root is cut far too deep, in words; they undercut and damage the flank above."""
    deep = [
        f"the {flank.side} {name} flank is cut with its root {flank.tip_below_root * 1e3:.3g} mm below the root cone: "
        "withdraw the cutter"
        for name, flank in (("pinion", grid.pinion), ("gear", grid.gear))
        if isinstance(flank, CutFlank) and flank.tip_below_root > 0.5 * flank.blank.mean_dedendum
    ]
    return "".join(f"; {text}" for text in deep)


def _fitter(grid: FlankGrid, present: BoolArray) -> Callable[[dict[str, FloatArray]], Patch]:
    """Function that fits patches to values at the nodes: interpolation, or least squares over the existing nodes."""
    if present.all():
        rows = int(np.flatnonzero(np.diff(grid.u) != 0.0)[0]) + 1
        nodes = (grid.u.size - 1) // rows, rows

        def whole(fields: dict[str, FloatArray]) -> Patch:
            values = {name: value[:-1] for name, value in fields.items()}
            return Patch.fit(grid.u_range, grid.v_range, nodes, values).lowered(grid.shape)

        return whole
    fit = PointFit(grid.u_range, grid.v_range, grid.shape, grid.u[present], grid.v[present])
    return lambda fields: fit({name: value[present] for name, value in fields.items()})


def _checked(surface: MeshSurface, parameters: FloatArray, deviation: FlankDeviation) -> float:
    """Maximum error of the ease-off [m] at points between the nodes of a partly undercut flank."""
    nodes = surface.grid
    random = np.random.default_rng(0)
    u, v = random.uniform(*nodes.u_range, 60), random.uniform(max(0.0, nodes.v_range[0]), 1.0, 60)
    inside = surface.margin(u, v) > 0.0
    u, v = u[inside], v[inside]
    # parameters from the nearest node
    scale = np.array([[nodes.u_range[1]], [0.5]])
    here, there = np.stack([u, v]) / scale, np.stack([nodes.u, nodes.v]) / scale
    nearest = np.argmin(((here[:, :, None] - there[:, None, :]) ** 2).sum(axis=0), axis=1)
    radius, z = surface.gear.blank.axial(u, surface.height(u, v))
    on_gear, good = surface.gear.refine(radius, z, nodes.points.parameters[:, nearest])
    exact = conjugate_points(surface.gear.points(on_gear), surface.assembly)
    relief, _, found = ease_off(exact, surface.pinion, surface.phase, parameters[:, nearest])
    good &= found
    relief = relief + deviation.depth(surface.gear.blank, u, v)
    error = np.abs(surface.patch(u, v, ("ease_off",))[0] - relief)
    return float(error[good].max(initial=0.0))


def _undercut_region(surface: MeshSurface) -> UndercutRegion | None:
    """Undercut part of the flank inside both blanks."""
    if "regular" not in surface.patch.names:
        return None
    half = 0.5 * surface.gear.blank.face_width
    u, v = (g.ravel() for g in np.meshgrid(np.linspace(-half, half, 81), np.linspace(0.0, 1.0, 61)))
    limits = surface.limits(u, v)
    inside = (limits[:-1] >= 0.0).all(axis=0)
    missing = inside & (limits[-1] < 0.0)
    if not missing.any():
        return None
    depth = surface.height(u, np.ones_like(u)) - surface.height(u, np.zeros_like(u))
    share = float(depth[missing].sum() / depth[inside].sum())
    (u_low, u_high), (v_low, v_high) = ((float(x[missing].min()), float(x[missing].max())) for x in (u, v))
    return UndercutRegion(share, (u_low, u_high), (v_low, v_high))


def _error_maximum(surface: MeshSurface) -> tuple[tuple[float, float], float]:
    """Position and value of the minimum ease-off over lever inside the flanks, by successively finer grids."""
    (u0, u1), (v0, v1) = surface.patch.u_range, surface.patch.v_range
    centre, reach = np.array([0.5 * (u0 + u1), 0.5 * (v0 + v1)]), np.array([0.5 * (u1 - u0), 0.5 * (v1 - v0)])
    lowest = np.inf
    for count in (41, 11, 11, 11):
        axes = [np.linspace(c - r, c + r, count) for c, r in zip(centre, reach, strict=True)]
        u, v = (g.ravel() for g in np.meshgrid(*axes))
        height = np.where(surface.margin(u, v) >= 0.0, surface.patch(u, v, ("ease_off_angle",))[0], np.inf)
        at = int(np.argmin(height))
        if not np.isfinite(height[at]):
            break
        centre, lowest = np.array([u[at], v[at]]), float(height[at])
        # two cells to each side, because the minimum of an inclined valley may lie beyond the nearest cell
        reach = reach * 4.0 / (count - 1)
    if not np.isfinite(lowest):
        raise ConvergenceError("no_contact", "the blanks of both members have no common part of the flank")
    sharp = _stationary(surface.patch, centre)
    if surface.margin(sharp[:1], sharp[1:])[0] > 0.0:
        value = float(surface.patch(sharp[:1], sharp[1:], ("ease_off_angle",))[0, 0])
        if value <= lowest:
            centre, lowest = sharp, value
    return (float(centre[0]), float(centre[1])), lowest


def _stationary(patch: Patch, start: FloatArray) -> FloatArray:
    """Stationary point of the ease-off over lever near a start, (2,); the start itself if the curvature is negative."""
    at = start
    for _ in range(4):
        u, v = at[:1], at[1:]
        a, b, aa, ab, bb = (
            float(patch(u, v, ("ease_off_angle",), du=i, dv=j)[0, 0])
            for i, j in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
        )
        determinant = aa * bb - ab * ab
        if determinant <= 0.0 or aa <= 0.0:
            return start
        at = at - np.array([bb * a - ab * b, aa * b - ab * a]) / determinant
    return at
