"""Lines of constant roll angle on the gear flank: their extent inside both blanks, and points on them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.mesh_surface import NORMAL, POSITION, MeshSurface, line_frame
from ehl.common.arrays import FloatArray, IntArray
from ehl.common.errors import ConvergenceError

# ends of lines: relative error of the distance from the boundary, or of the position within a step between samples
_END_ERROR, _END_STEPS = 1e-11, 60


@dataclass(frozen=True)
class Lines:
    """Points of lines of constant roll angle on the gear flank and the length represented by each, concatenated."""

    u: FloatArray
    v: FloatArray
    length: FloatArray


@dataclass(frozen=True)
class Spans:
    """Extent of lines of given roll angles, in the coordinate along which they are followed."""

    roll: FloatArray
    start: FloatArray
    stop: FloatArray
    swapped: bool


def line_spans(surface: MeshSurface, roll: FloatArray) -> tuple[Spans, IntArray]:
    """Lines of given roll angles inside both blanks, and indices of roll angles with a line of finite length."""
    coarse = 61
    at = np.array([surface.design_point[0]]), np.array([surface.design_point[1]])
    (roll_u,), (roll_v,) = (surface.patch(*at, ("roll",), du=a, dv=1 - a) for a in (1, 0))
    depth = float(surface.height(at[0], at[1] + 1.0)[0] - surface.height(*at)[0])
    # whether the lines extend more over the tooth height than along the face
    swapped = bool(abs(roll_u[0]) > abs(roll_v[0]) / depth)
    low, high = surface.patch.v_range if swapped else surface.patch.u_range
    run = np.broadcast_to(np.linspace(low, high, coarse), (roll.size, coarse))
    u, v, found = _level(surface, roll, run, swapped)
    margin = np.where(found, surface.margin(u.ravel(), v.ravel()).reshape(u.shape), -1.0)
    inside = margin > 0.0
    kept = np.flatnonzero(inside.any(axis=1))
    margin, run, roll, free, found = margin[kept], run[kept], roll[kept], (u if swapped else v)[kept], found[kept]
    # the longest inner part: between the first and last inner samples around the sample farthest inside
    deepest = np.argmax(margin, axis=1)
    ends = []
    for step in (-1, 1):
        edge = deepest.copy()
        for _ in range(coarse):
            ahead = np.clip(edge + step, 0, coarse - 1)
            edge = np.where(margin[np.arange(kept.size), ahead] > 0.0, ahead, edge)
        pair = np.arange(kept.size)[:, None], np.stack([edge, np.clip(edge + step, 0, coarse - 1)], axis=1)
        ends.append(_end(surface, roll, run[pair], free[pair], margin[pair], found[pair].all(axis=1), swapped))
    start, stop = ends
    if not roll.size:
        raise ConvergenceError("no_contact", "the blanks of both members have no common part of the flank")
    return Spans(roll, start, stop, swapped), kept


def within_reach(surface: MeshSurface, spans: Spans, owner: IntArray, reach: float) -> tuple[Spans, IntArray]:
    """Part of each line that a gear rotation closes after first contact of its position, with a margin."""
    samples = 81
    share = np.linspace(0.0, 1.0, samples)
    run = spans.start[:, None] + (spans.stop - spans.start)[:, None] * share
    u, v, _ = _level(surface, spans.roll, run, spans.swapped)
    back, lever = surface.patch(u.ravel(), v.ravel(), ("ease_off_angle", "lever")).reshape(2, *run.shape)
    # relief delays first contact, but may close sooner near a point than at it
    relieved = back + surface.relief_depth(u.ravel(), v.ravel()).reshape(run.shape) / lever
    least = np.full(int(owner.max()) + 1, np.inf)
    np.minimum.at(least, owner, relieved.min(axis=1))
    inside = back <= least[owner][:, None] + reach
    kept = np.flatnonzero(inside.any(axis=1))
    first = np.maximum(np.argmax(inside[kept], axis=1) - 1, 0)
    last = np.minimum(samples - np.argmax(inside[kept, ::-1], axis=1), samples - 1)
    rows = np.arange(kept.size)
    return Spans(spans.roll[kept], run[kept][rows, first], run[kept][rows, last], spans.swapped), kept


def line_points(surface: MeshSurface, spans: Spans, count: int) -> Lines:
    """Midpoints of equal parts of each line."""
    part = (spans.stop - spans.start) / count
    run = spans.start[:, None] + part[:, None] * (np.arange(count) + 0.5)
    u, v, _ = _level(surface, spans.roll, run, spans.swapped)
    u, v = u.ravel(), v.ravel()
    # change of the coordinate along which a line is followed, per length of the line
    rate = np.abs(line_frame(surface.patch, u, v).rates_along[int(spans.swapped)])
    return Lines(u, v, np.repeat(part, count) / rate)


def _level(
    surface: MeshSurface, roll: FloatArray, run: FloatArray, swapped: bool, start: FloatArray | None = None
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Points of the lines at given u (or v if swapped); outside the map the nearest point of its boundary.

    `start`: estimate of the other coordinate.
    """
    low, high = surface.patch.u_range if swapped else surface.patch.v_range
    target = np.broadcast_to(roll[:, None], run.shape).ravel()
    fixed = run.ravel()
    free = np.full(fixed.shape, 0.5 * (low + high)) if start is None else start.ravel()
    found = np.zeros(fixed.shape, dtype=bool)
    for _ in range(12):
        u, v = (free, fixed) if swapped else (fixed, free)
        slope = surface.patch(u, v, ("roll",), du=int(swapped), dv=int(not swapped))[0]
        # exact roll angle from the equation of meshing at the interpolated point and normal
        f2, _ = surface.assembly.roll(surface.patch(u, v, POSITION), surface.patch(u, v, NORMAL))
        step = (surface.direction * (f2 / surface.assembly.ratio - surface.roll_zero) - target) / slope
        moved = np.clip(free - step, low, high)
        found = np.abs(step) < 1e-10 * (high - low)
        settled = bool(np.all(np.abs(moved - free) < 1e-10 * (high - low)))
        free = moved
        if settled:
            break
    u, v = (free, fixed) if swapped else (fixed, free)
    return u.reshape(run.shape), v.reshape(run.shape), found.reshape(run.shape)


def _end(
    surface: MeshSurface,
    roll: FloatArray,
    run: FloatArray,
    free: FloatArray,
    margin: FloatArray,
    known: NDArray[np.bool_],
    swapped: bool,
) -> FloatArray:
    """Intersection of the lines with the boundary: Illinois method, with bisection where they leave the map.

    `run`, `free`, `margin` (n, 2): the coordinate along which the lines are followed, the other one, and the distance
    inside the boundary, at the last inner and the first outer sample; both are the same sample if a line ends with the
    map. `known` (n,): whether both samples are points of the line.
    """
    inner, outer = run[:, 0], run[:, 1]
    (free_in, free_out), (inside, outside) = free.T, margin.T
    least, depth = _END_ERROR * np.ptp(run, axis=1), surface.undercut_scale
    kept = np.zeros(roll.size)
    for _ in range(_END_STEPS):
        share = np.where(known, inside / np.where(known, inside - outside, 1.0), 0.5)
        middle, start = inner + share * (outer - inner), free_in + share * (free_out - free_in)
        at_u, at_v, on_line = _level(surface, roll, middle[:, None], swapped, start[:, None])
        u, v, found = at_u[:, 0], at_v[:, 0], on_line[:, 0]
        here, there = np.where(found, surface.margin(u, v), -1.0), u if swapped else v
        good, done = here > 0.0, np.abs(here) < _END_ERROR * depth
        # Illinois method: the value of an end retained twice is halved
        inside, outside = (
            np.where(good, here, np.where(kept < 0.0, 0.5, 1.0) * inside),
            np.where(good, np.where(kept > 0.0, 0.5, 1.0) * outside, here),
        )
        inner, free_in = np.where(good | done, middle, inner), np.where(good | done, there, free_in)
        outer, free_out = np.where(good & ~done, outer, middle), np.where(good & ~done, free_out, there)
        known, kept = np.where(good, known, found), np.where(good, 1.0, -1.0)
        if np.all(np.abs(outer - inner) <= least):
            break
    return inner
