"""Potential contact lines of all tooth pairs in mesh, at the positions of one pinion pitch.

Frame: the fixed mesh frame, z along the gear axis from the crossing point towards the heel, right-handed,
SI units. Everything "per unit pinion speed" is for a pinion turning at 1 rad/s in its driving direction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.assembly import cross, dot, turn
from efficiency.contact.line_frame import POSITION, line_frame
from efficiency.contact.mesh_surface import NORMAL, MeshSurface
from efficiency.contact.pair import GearPair
from ehl.errors import ConvergenceError, InputError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class MeshPosition:
    """All potential contact lines at one pinion angle; one entry per point, lines consecutive.

    Attributes
    ----------
    pinion_angle : float
        Roll of the pinion from the design point in the driving direction [rad].
    pair : (n,) int array
        Tooth pair the point belongs to: 0 the reference pair, +1 a pair further along in mesh, -1 one behind.
    position : (n, 3) array
        Point in the mesh frame [m].
    normal : (n, 3) array
        Unit common normal out of the pinion flank into the gear tooth, the direction of the force
        on the gear.
    along, across : (n, 3) arrays
        Unit tangent of the contact line (y, toe to heel) and the one square to it (x = along cross normal).
    length : (n,) array
        Length of contact line the point stands for [m] (quadrature weight; their sum is the line length).
    gap : (n,) array
        Separation of the unloaded flanks along the normal [m]; the smallest over all pairs is zero.
    radius_equivalent : (n,) array
        Equivalent radius of curvature normal to the contact line [m].
    lever_pinion, lever_gear : (n,) arrays
        Arm of a unit normal force about each axis [m], positive: torque = sum(force lever).
        ``lever_gear/lever_pinion`` is the tooth ratio N2/N1 at every (conjugate) point.
    sliding_along, sliding_across : (n,) arrays
        Sliding velocity, pinion minus gear, along y and x per unit pinion speed [m].
    entrainment : (n,) array
        Mean surface velocity along x relative to the moving contact line, per unit pinion speed [m], signed:
        positive where the surfaces move towards +x. sliding_across/entrainment is the slide-to-roll ratio.
    height_gear, height_pinion : (n,) arrays
        Distance of the point from the root cone of each member, square to its pitch cone [m].
    face_gear, face_pinion : (n,) arrays
        Distance along the pitch cone from the toe of each member [m].
    transmission_error : float
        Rotation of the rigid unloaded gear ahead of its place at constant ratio [rad]; zero or negative
        when it lags behind the design point.
    """

    pinion_angle: float
    pair: IntArray
    position: FloatArray
    normal: FloatArray
    along: FloatArray
    across: FloatArray
    length: FloatArray
    gap: FloatArray
    radius_equivalent: FloatArray
    lever_pinion: FloatArray
    lever_gear: FloatArray
    sliding_along: FloatArray
    sliding_across: FloatArray
    entrainment: FloatArray
    height_gear: FloatArray
    height_pinion: FloatArray
    face_gear: FloatArray
    face_pinion: FloatArray
    transmission_error: float


@dataclass(frozen=True)
class _Lines:
    """Points of lines of constant roll angle on the gear flank and the length each stands for, lines consecutive."""

    u: FloatArray
    v: FloatArray
    length: FloatArray


def mesh_cycle(pair: GearPair, positions: int = 24, points_per_line: int = 31) -> tuple[MeshPosition, ...]:
    """Contact lines at equally spaced pinion angles over one pinion pitch, ``2 pi/N1``.

    Parameters
    ----------
    pair : GearPair
        Geometry of the pair.
    positions : int
        Number of pinion angles in the pitch (the end of the pitch, equal to its start, is left out).
    points_per_line : int
        Points on each contact line, midpoints of equal parts.

    Returns
    -------
    tuple of MeshPosition
        One entry per pinion angle.
    """
    for name, value, least in (("positions", positions, 1), ("points_per_line", points_per_line, 2)):
        if not isinstance(value, int) or value < least:
            raise InputError(name, value, f"a whole number of at least {least}")
    surface = pair.surface
    angles = np.arange(positions) / positions * surface.pitch
    lowest, highest = surface.roll_range
    pairs = np.arange(
        int(np.floor((lowest - surface.pitch) / surface.pitch)), int(np.ceil(highest / surface.pitch)) + 1
    )
    # a pair further along in mesh has a larger roll angle
    roll = angles[:, None] + pairs[None, :] * surface.pitch
    place, column = np.nonzero((roll > lowest) & (roll < highest))
    lines, kept = _trace(surface, roll[place, column], points_per_line)
    place, column = place[kept], column[kept]
    fields = _points(surface, lines)
    count = points_per_line
    owner, tooth = np.repeat(place, count), np.repeat(pairs[column], count)
    result = []
    for k in range(positions):
        here = owner == k
        if not here.any():
            raise ConvergenceError("no_contact", f"no tooth pair can touch at pinion angle {angles[k]:.4g} rad")
        own = {name: values[here] for name, values in fields.items()}
        closing = own.pop("valley") / own["lever_gear"]
        own["gap"] = (closing - closing.min()) * own["lever_gear"]
        error = -_lowest(closing.reshape(-1, count))
        result.append(MeshPosition(float(angles[k]), tooth[here], transmission_error=error, **own))
    return tuple(result)


def _lowest(closing: FloatArray) -> float:
    """Smallest value over all lines (rows), between the points by the parabola through the three lowest."""
    line, point = np.unravel_index(int(np.argmin(closing)), closing.shape)
    if not 0 < point < closing.shape[1] - 1:
        return float(closing[line, point])
    before, least, after = closing[line, point - 1 : point + 2]
    bend = before - 2.0 * least + after
    return float(least - 0.125 * (after - before) ** 2 / bend) if bend > 0.0 else float(least)


def _trace(surface: MeshSurface, roll: FloatArray, count: int) -> tuple[_Lines, IntArray]:
    """Lines of given roll angles inside both blanks, and which of the given ones have any length."""
    coarse = 61
    swapped = _steep(surface)
    low, high = surface.patch.v_range if swapped else surface.patch.u_range
    run = np.broadcast_to(np.linspace(low, high, coarse), (roll.size, coarse))
    u, v, found = _level(surface, roll, run, swapped)
    margin = np.where(found, surface.margin(u.ravel(), v.ravel()).reshape(u.shape), -1.0)
    inside = margin > 0.0
    kept = np.flatnonzero(inside.any(axis=1))
    margin, run, roll = margin[kept], run[kept], roll[kept]
    # the longest inner part: from its first to its last inner sample around the sample farthest inside
    deepest = np.argmax(margin, axis=1)
    ends = []
    for step in (-1, 1):
        edge = deepest.copy()
        for _ in range(coarse):
            ahead = np.clip(edge + step, 0, coarse - 1)
            edge = np.where(margin[np.arange(kept.size), ahead] > 0.0, ahead, edge)
        outer = np.clip(edge + step, 0, coarse - 1)
        rows = np.arange(kept.size)
        ends.append(_end(surface, roll, run[rows, edge], run[rows, outer], swapped))
    start, stop = ends
    part = (stop - start) / count
    run = start[:, None] + part[:, None] * (np.arange(count) + 0.5)
    u, v, _ = _level(surface, roll, run, swapped)
    u, v = u.ravel(), v.ravel()
    return _Lines(u, v, _stretch(surface, u, v, swapped) * np.repeat(part, count)), kept


def _stretch(surface: MeshSurface, u: FloatArray, v: FloatArray, swapped: bool) -> FloatArray:
    """Length of a line per unit of the coordinate it is followed in."""
    p = surface.patch
    ru, rv = p(u, v, POSITION, du=1), p(u, v, POSITION, dv=1)
    (roll_u,), (roll_v,) = p(u, v, ("roll",), du=1), p(u, v, ("roll",), dv=1)
    tangent = rv - ru * roll_v / roll_u if swapped else ru - rv * roll_u / roll_v
    return np.asarray(np.sqrt(dot(tangent, tangent)))


def _steep(surface: MeshSurface) -> bool:
    """Whether the lines run more across the tooth height than along the face."""
    u, v = np.array([surface.design_point[0]]), np.array([surface.design_point[1]])
    (roll_u,), (roll_v,) = (surface.patch(u, v, ("roll",), du=a, dv=1 - a) for a in (1, 0))
    depth = float(surface.height(u, v + 1.0)[0] - surface.height(u, v)[0])
    return bool(abs(roll_u[0]) > abs(roll_v[0]) / depth)


def _level(
    surface: MeshSurface, roll: FloatArray, run: FloatArray, swapped: bool
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Points of the lines at given u (or v where swapped); where a line leaves the map the nearest point of its rim."""
    low, high = surface.patch.u_range if swapped else surface.patch.v_range
    target = np.broadcast_to(roll[:, None], run.shape).ravel()
    fixed = run.ravel()
    free = np.full(fixed.shape, 0.5 * (low + high))
    found = np.zeros(fixed.shape, dtype=bool)
    for _ in range(12):
        u, v = (free, fixed) if swapped else (fixed, free)
        slope = surface.patch(u, v, ("roll",), du=int(swapped), dv=int(not swapped))[0]
        step = (surface.exact_roll(u, v) - target) / slope
        moved = np.clip(free - step, low, high)
        found = np.abs(step) < 1e-10 * (high - low)
        settled = bool(np.all(np.abs(moved - free) < 1e-10 * (high - low)))
        free = moved
        if settled:
            break
    u, v = (free, fixed) if swapped else (fixed, free)
    return u.reshape(run.shape), v.reshape(run.shape), found.reshape(run.shape)


def _end(surface: MeshSurface, roll: FloatArray, inner: FloatArray, outer: FloatArray, swapped: bool) -> FloatArray:
    """Where the lines cross the boundary between an inner and an outer sample, by bisection."""
    for _ in range(24):
        middle = 0.5 * (inner + outer)
        u, v, found = _level(surface, roll, middle[:, None], swapped)
        good = found[:, 0] & (surface.margin(u[:, 0], v[:, 0]) > 0.0)
        inner, outer = np.where(good, middle, inner), np.where(good, outer, middle)
    return inner


def _points(surface: MeshSurface, lines: _Lines) -> dict[str, FloatArray]:
    """All fields of `MeshPosition` but those that need the whole position, for flattened lines."""
    u, v = lines.u, lines.v
    p, assembly, sign = surface.patch, surface.assembly, surface.direction
    local, facing = p(u, v, POSITION), p(u, v, NORMAL)
    facing = facing / np.sqrt(dot(facing, facing))
    f2, rate = assembly.roll(local, facing)
    frame = line_frame(p, u, v)
    position = assembly.gear_in_mesh(local, f2)
    normal = -turn(facing, f2)
    along = turn(frame.along, f2)
    along = along - normal * dot(along, normal)
    along = along / np.sqrt(dot(along, along))
    across = cross(along, normal)
    gradient = dot(turn(frame.gradient, f2), across)
    sliding = sign * assembly.sliding(position)
    sliding_across = dot(sliding, across)
    # the line runs over the gear at 1/gradient: relative to it the gear surface moves the other way
    surface_gear = -1.0 / gradient
    surface_pinion = surface_gear + sliding_across
    lever_pinion, lever_gear = assembly.levers(position, normal)

    # the ease-off belongs to the pinion: per metre across the line on the pinion the conjugate gear point moves so much
    sliding_along = dot(sliding, along)
    rates = frame.rates_gradient * np.sign(gradient) * surface_gear - frame.rates_along * sliding_along
    up, vp = rates / surface_pinion
    (eu,), (ev,) = p(u, v, ("ease_off",), du=1), p(u, v, ("ease_off",), dv=1)
    euu, euv, evv = (p(u, v, ("ease_off",), du=2 - k, dv=k)[0] for k in (0, 1, 2))
    # its curvature adds to that of the conjugate flanks, its slope shifts the place of closest approach
    slope = eu * up + ev * vp
    curvature = rate / (surface_gear * surface_pinion) + euu * up**2 + 2.0 * euv * up * vp + evv * vp**2
    u1, h1 = p(u, v, ("u1", "h1"))
    gear, pinion = surface.gear.blank, surface.pinion.blank
    return {
        "position": position.T,
        "normal": normal.T,
        "along": along.T,
        "across": across.T,
        "length": lines.length,
        "valley": p(u, v, ("ease_off",))[0] - 0.5 * slope**2 / curvature,
        "radius_equivalent": 1.0 / curvature,
        "lever_pinion": sign * lever_pinion,
        "lever_gear": sign * np.sign(assembly.ratio) * lever_gear,
        "sliding_along": sliding_along,
        "sliding_across": sliding_across,
        "entrainment": 0.5 * (surface_gear + surface_pinion),
        "height_gear": surface.height(u, v) - gear.root(u),
        "height_pinion": h1 - pinion.root(u1),
        "face_gear": u + 0.5 * gear.face_width,
        "face_pinion": u1 + 0.5 * pinion.face_width,
    }
