"""Where the unloaded flanks touch at a pinion angle: the constrained minimum of the rotation that separates them.

The minimum is taken over the part of the flanks that both members have. Inside it is a stationary point; on the rim one
edge is active (contact of a tip, toe, heel or root edge with the mating flank), at a corner two. Each is found by
Newton's method in the two map coordinates for all pinion angles together, second derivatives by complex step.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.mesh_surface import MeshSurface
from efficiency.contact.touch import Touch, touch

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

_STEP = 1e-30
# directions in which the gap is flatter than this share of the steepest count as level: conjugate flanks touch in lines
_LEVEL = 1e-8
_ITERATIONS = 12
_SETTLED = 1e-11
# how far outside an edge a contact still counts as inside [m]
_OUTSIDE = 1e-9
# edges nearer to the sample than this share of the tooth depth are tried
_NEAR = 0.08


@dataclass(frozen=True)
class Closest:
    """Contact of one tooth pair at n pinion angles.

    Attributes
    ----------
    u, v : (n,) arrays
        Map coordinates whose real pinion point touches.
    back : (n,) array
        Rotation the gear is short of the constant ratio when they touch [rad].
    edge : (n,) int array
        Index in `EDGES` of the active edge, -1 inside the flanks.
    corner : (n,) bool array
        Where a second edge is active: a corner touches.
    settled : (n,) bool array
        False where no minimum was found and the best sample stands in for it.
    expected : (n,) array
        `back` as the ease-off of the best sample near its line of contact has it [rad]: coarse, and independent of the
        search.
    """

    u: FloatArray
    v: FloatArray
    back: FloatArray
    edge: IntArray
    corner: BoolArray
    settled: BoolArray
    expected: FloatArray


@dataclass(frozen=True)
class _State:
    """Limits, and slopes and second derivatives of gap and limits (first row the gap), scaled to the map."""

    limits: FloatArray
    slopes: FloatArray
    bends: FloatArray

    def at(self, points: BoolArray) -> _State:
        """Some of the points."""
        return _State(self.limits[..., points], self.slopes[..., points], self.bends[..., points])


@dataclass(frozen=True)
class _Problem:
    """Gap and limits of one pair at pinion angles, in map coordinates scaled to the size of the map."""

    surface: MeshSurface
    scale: FloatArray

    def state(self, angle: FloatArray, x: FloatArray) -> _State:
        """All of it at points x (2, n): both complex steps in one call."""
        n = angle.size
        moved = np.concatenate([x, x], axis=1).astype(np.complex128)
        moved[0, :n] += 1j * _STEP
        moved[1, n:] += 1j * _STEP
        found = touch(self.surface, np.tile(angle, 2), *(moved * self.scale[:, None]))
        slopes = np.concatenate([found.slope[None], found.limit_slopes]) * self.scale[:, None]
        bends = np.stack([np.imag(slopes[..., :n]), np.imag(slopes[..., n:])], axis=2) / _STEP
        both = 0.5 * (bends + np.swapaxes(bends, 1, 2))
        return _State(np.real(found.limits[:, :n]), np.real(slopes[..., :n]), both)

    def on_map(self, x: FloatArray) -> BoolArray:
        """Which points lie on the map; beyond it the polynomials mean nothing."""
        low, high = (
            np.array([self.surface.patch.u_range, self.surface.patch.v_range]).T[:, :, None] / self.scale[:, None]
        )
        return np.asarray(((x >= low) & (x <= high)).all(axis=0))

    def back(self, angle: FloatArray, x: FloatArray) -> tuple[FloatArray, Touch]:
        """Rotation that the gear is short of its place [rad], and the points."""
        found = touch(self.surface, angle, *(x * self.scale[:, None]))
        s = self.surface
        lag = found.gear_rotation - s.assembly.ratio * (s.direction * angle + s.roll_zero)
        return -s.forward * np.angle(np.exp(1j * lag)), found

    def newton(self, angle: FloatArray, start: FloatArray, edges: IntArray) -> tuple[FloatArray, BoolArray]:
        """Newton's method at n points, and which of them arrived.

        ``edges`` (2, n) says what is looked for: -1, -1 a stationary point, -2, -1 the floor of the valley, k, -1 the
        least gap along edge k, k, l the corner of two edges.
        """
        x, settled = start.copy(), np.zeros(angle.shape, dtype=bool)
        active = np.arange(angle.size)
        for _ in range(_ITERATIONS):
            now, wanted = self.state(angle[active], x[:, active]), edges[:, active]
            move = np.empty((2, active.size))
            for kind, step in (
                (wanted[0] == -1, _inside),
                (wanted[0] == -2, _across),
                ((wanted[0] >= 0) & (wanted[1] < 0), _on_edge),
                (wanted[1] >= 0, _corner),
            ):
                if kind.any():
                    move[:, kind] = step(now.at(kind), wanted[:, kind])
            move = np.clip(move, -0.1, 0.1)
            x[:, active] += move
            done = np.abs(move).max(axis=0) < _SETTLED
            settled[active[done]] = True
            # far outside the map the polynomials mean nothing
            lost = (np.abs(x[:, active] - start[:, active]) > 0.7).any(axis=0)
            active = active[~done & ~lost]
            if not active.size:
                break
        return x, settled


def _inside(now: _State, edges: IntArray) -> FloatArray:
    """Newton step to a stationary point of the gap, downhill in every direction."""
    size, axes = np.linalg.eigh(np.moveaxis(now.bends[0], -1, 0))
    along = np.einsum("nij,in->nj", axes, now.slopes[0])
    size = np.abs(size)
    step = np.where(size > _LEVEL * size[:, -1:], along / size.clip(1e-300), 0.0)
    return np.asarray(-np.einsum("nij,nj->in", axes, step))


def _across(now: _State, edges: IntArray) -> FloatArray:
    """Newton step in the steepest direction only: to the floor of the valley."""
    size, axes = np.linalg.eigh(np.moveaxis(now.bends[0], -1, 0))
    steepest = axes[:, :, -1].T
    return np.asarray(-steepest * np.sum(steepest * now.slopes[0], axis=0) / size[:, -1])


def _on_edge(now: _State, edges: IntArray) -> FloatArray:
    """Newton step to the least gap along an edge."""
    points = np.arange(edges.shape[1])
    slope, normal = now.slopes[0], now.slopes[1 + edges[0], :, points].T
    square = np.sum(normal * normal, axis=0).clip(1e-300)
    tangent = np.stack([-normal[1], normal[0]]) / np.sqrt(square)
    lift = np.sum(slope * normal, axis=0) / square
    towards = -normal * now.limits[edges[0], points] / square
    bend = now.bends[0] - lift * np.moveaxis(now.bends[1 + edges[0], :, :, points], 0, -1)
    run = np.sum(tangent * (slope + np.einsum("ijn,jn->in", bend, towards)), axis=0)
    curve = np.abs(np.einsum("in,ijn,jn->n", tangent, bend, tangent))
    # along a straight edge there is no least gap; steps are cut to the tenth part of the map anyway
    return np.asarray(towards - tangent * run / np.maximum(curve, np.abs(run)).clip(1e-300))


def _corner(now: _State, edges: IntArray) -> FloatArray:
    """Newton step to where two edges meet; a long one where they run alongside."""
    points = np.arange(edges.shape[1])
    matrix = np.stack([now.slopes[1 + edge, :, points] for edge in edges], axis=1)
    alongside = np.abs(np.linalg.det(matrix)) < 1e-9 * np.abs(matrix).max(axis=(1, 2)) ** 2
    matrix[alongside] = np.eye(2)
    value = np.stack([now.limits[edge, points] for edge in edges], axis=1)
    step = np.linalg.solve(matrix, value[..., None])[..., 0].T
    return np.asarray(np.where(alongside, 1.0, -step))


def closest(surface: MeshSurface, angle: FloatArray) -> Closest:
    """Contact of one tooth pair at pinion angles from the design point, driving direction [rad]."""
    (u0, u1), (v0, v1) = surface.patch.u_range, surface.patch.v_range
    problem = _Problem(surface, np.array([u1 - u0, v1 - v0]))
    grid_u, grid_v = (g.ravel() for g in np.meshgrid(np.linspace(u0, u1, 49), np.linspace(v0, v1, 41)))
    within = surface.margin(grid_u, grid_v) >= 0.0
    grid_u, grid_v = grid_u[within], grid_v[within]
    gap, bend, roll = surface.patch(grid_u, grid_v, ("turn_back", "bend", "roll"))
    rough = gap + 0.5 * bend * (roll - angle[:, None]) ** 2
    lowest, expected = np.argmin(rough, axis=1), rough.min(axis=1)
    sample = np.stack([grid_u[lowest], grid_v[lowest]]) / problem.scale[:, None]

    found, settled = problem.newton(angle, sample, np.full((2, angle.size), -1))
    back, points = problem.back(angle, found)
    room = np.real(points.limits)
    edge, corner = np.full(angle.shape, -1), np.zeros(angle.shape, dtype=bool)
    # a stationary point above the sample is not the one looked for
    lost = ~settled | ~problem.on_map(found) | (back > problem.back(angle, sample)[0] + 1e-12)
    rest = np.flatnonzero(lost | (room.min(axis=0) < -_OUTSIDE))
    if rest.size:
        at, back[rest], edge[rest], corner[rest], settled[rest] = _on_rim(
            problem, angle[rest], sample[:, rest], room[:, rest]
        )
        found[:, rest] = at
        # where no place is found the sample stands in, with its value near its line of contact
        back = np.where(settled, back, expected)
    return Closest(found[0] * problem.scale[0], found[1] * problem.scale[1], back, edge, corner, settled, expected)


def _on_rim(
    problem: _Problem, angle: FloatArray, sample: FloatArray, room: FloatArray
) -> tuple[FloatArray, FloatArray, IntArray, BoolArray, BoolArray]:
    """Least gap over edges and corners that lie inside all other edges; the sample itself where there is none.

    Tried are the edges that the stationary point lies beyond or the sample lies near to, and the corners of the three
    of them that the sample is nearest to.
    """
    at = sample.copy()
    near = np.real(problem.back(angle, sample)[1].limits)
    active, corner, settled = np.full(angle.shape, -1), np.zeros(angle.shape, bool), np.zeros(angle.shape, bool)
    best = np.full(angle.shape, np.inf)
    depth = problem.surface.undercut_scale
    edge, point = np.nonzero((near < _NEAR * depth) | (room < 0.0))
    single = np.stack([edge, np.full(edge.shape, -1)])
    nearest = np.sort(np.argsort(near, axis=0)[:3], axis=0)
    for attempt in range(2):
        if attempt == 1:
            # no edge has its lowest point inside the others: a corner, or flanks that touch in lines, where any place
            # on the floor of the valley will do
            left = np.flatnonzero(~settled)
            if not left.size:
                break
            pairs = [nearest[[i, j]][:, left] for i, j in combinations(range(3), 2)]
            single = np.concatenate([*pairs, np.stack([np.full(left.shape, -2), np.full(left.shape, -1)])], axis=1)
            point = np.tile(left, 4)
        x, ok = problem.newton(angle[point], sample[:, point], single)
        value, touched = problem.back(angle[point], x)
        ok &= problem.on_map(x) & (np.real(touched.limits).min(axis=0) > -_OUTSIDE)
        for k in np.flatnonzero(ok)[np.argsort(-value[ok])]:
            p = point[k]
            if value[k] < best[p]:
                at[:, p], best[p], settled[p] = x[:, k], value[k], True
                active[p], corner[p] = max(int(single[0, k]), -1), single[1, k] >= 0
    return at, best, active, corner, settled
