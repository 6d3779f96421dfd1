"""Edges of both members as potential contact lines: contact after the regular line of contact has left the flank.

A contact line ends at a tip, toe or heel edge. Beyond this end, the edge itself can contact the mating flank: contact
before and after the path of the smooth flanks. The gap is that of the sharp edge and the real mating flank, both placed
in space. Root edges are not edges of a tooth; lines end there without edge contact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from efficiency.contact.contact_search import point_contact
from efficiency.contact.mesh_surface import EDGES, POSITION, MeshSurface, line_frame
from ehl.common.arrays import BoolArray, FloatArray, IntArray
from ehl.common.errors import ConvergenceError

# free edges of a tooth
FREE = tuple(k for k, name in enumerate(EDGES) if name.split()[1] in ("toe", "heel", "tip"))
_SAMPLES = 161
_STEP = 1e-7
# minimum cosine squared of the angle between line and edge; at smaller values the edge is nearly normal to the line
_CROSSING = 0.02
_LANDING = 8
_BEYOND = 0.02
# points of an edge over those of a line, at which the tooth is too narrow for its depth; shipped designs: 2 at most
_MOST_POINTS = 20


@dataclass(frozen=True)
class EdgePiece:
    """Part of an edge inside all other edges with a monotone roll angle."""

    edge: int  # index in `EDGES`
    roll: FloatArray  # (m,) roll angle at which each vertex contacts its conjugate point, increasing [rad]
    # (m,) map coordinates of the vertices
    u: FloatArray
    v: FloatArray
    arc: FloatArray  # (m,) distance along the edge [m]
    inwards: float  # +1 if a larger roll angle lies further inside the flank, -1 if it lies outside
    bend: float  # mean of the field ``bend`` [1/rad]


def limit_slopes(surface: MeshSurface, u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Derivatives of the distances inside each of `EDGES` along the gradient of the roll angle and along the line."""
    frame = line_frame(surface.patch, u, v)
    slopes = []
    for rates in (frame.rates_gradient, frame.rates_along):
        ahead = surface.limits(u + _STEP * rates[0], v + _STEP * rates[1])
        back = surface.limits(u - _STEP * rates[0], v - _STEP * rates[1])
        with np.errstate(invalid="ignore"):
            slopes.append((ahead - back) / (2.0 * _STEP))
    return slopes[0], slopes[1]


def nearest_edge(surface: MeshSurface, u: FloatArray, v: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Free edge nearest along the normal of the line: index in `EDGES`, distance [m], squared cosine; (n,)."""
    rows = list(FREE)
    across, along = (slope[rows] for slope in limit_slopes(surface, u, v))
    size = np.hypot(across, along)
    cosine = np.maximum(np.abs(across) / size, np.sqrt(_CROSSING))
    distance = np.maximum(surface.limits(u, v)[rows], 0.0) / (size * cosine)
    nearest = np.argmin(distance, axis=0)
    each = np.arange(u.size)
    return np.array(rows)[nearest], distance[nearest, each], cosine[nearest, each] ** 2


def edge_pieces(surface: MeshSurface) -> tuple[EdgePiece, ...]:
    """All parts of the free edges of both members that can contact the mate."""
    pieces: list[EdgePiece] = []
    for edge in FREE:
        u, v = _edge_curve(surface, edge)
        limits = surface.limits(u, v)
        limits[edge] = np.inf
        pieces += _monotone_parts(surface, edge, u, v, limits.min(axis=0))
    return tuple(pieces)


def _edge_curve(surface: MeshSurface, edge: int) -> tuple[FloatArray, FloatArray]:
    """Samples of an edge on the map: along the face for a tip, over the depth for toe and heel."""
    member, place = EDGES[edge].split()
    half = 0.5 * surface.gear.blank.face_width
    u, v = np.linspace(-half, half, _SAMPLES), np.linspace(0.0, 1.0, _SAMPLES)
    if member == "gear":
        if place == "tip":
            return u, np.ones_like(u)
        return np.full_like(v, -half if place == "toe" else half), v
    fixed, free = (u, np.full_like(u, 0.5)) if place == "tip" else (v, np.zeros_like(v))
    step, low, high = (1e-6, -0.5, 1.5) if place == "tip" else (1e-6 * half, -2.0 * half, 2.0 * half)

    def distance(at: FloatArray) -> FloatArray:
        pair = (fixed, at) if place == "tip" else (at, fixed)
        return np.asarray(surface.limits(*pair)[edge])

    for _ in range(12):
        value = distance(free)
        slope = (distance(free + step) - value) / step
        free = np.clip(free - value / slope, low, high)
    return (fixed, free) if place == "tip" else (free, fixed)


def _monotone_parts(
    surface: MeshSurface, edge: int, u: FloatArray, v: FloatArray, margin: FloatArray
) -> list[EdgePiece]:
    roll = surface.patch(u, v, ("roll",))[0]
    inwards = np.sign(limit_slopes(surface, u, v)[0][edge])
    rising = np.sign(np.diff(roll, append=2.0 * roll[-1] - roll[-2]))
    kind = np.where(margin > 0.0, 3.0 * inwards + rising, 0.0)
    starts = np.flatnonzero(np.diff(kind, prepend=np.nan) != 0.0)
    parts = []
    for first, last in zip(starts, [*starts[1:], u.size], strict=True):
        if margin[first] <= 0.0 or last - first < 2:
            continue
        # extended to the intersections with other edges at both ends
        us, vs = [*u[first:last]], [*v[first:last]]
        for inner, outer, where in ((first, first - 1, 0), (last - 1, last, len(us) + 1)):
            if 0 <= outer < u.size:
                share = margin[inner] / (margin[inner] - margin[outer]) if margin[outer] < 0.0 else 1.0
                us.insert(where, u[inner] + share * (u[outer] - u[inner]))
                vs.insert(where, v[inner] + share * (v[outer] - v[inner]))
        a, b = np.array(us), np.array(vs)
        order = np.argsort(surface.patch(a, b, ("roll",))[0])
        a, b = a[order], b[order]
        points = surface.patch(a, b, POSITION)
        arc = np.concatenate([[0.0], np.cumsum(np.sqrt((np.diff(points, axis=1) ** 2).sum(axis=0)))])
        bend = float(surface.patch(a, b, ("bend",))[0].mean())
        angle = surface.patch(a, b, ("roll",))[0]
        parts.append(EdgePiece(edge, angle, a, b, arc, float(inwards[first]), bend))
    return parts


@dataclass(frozen=True)
class EdgePoints:
    """Points of edges that may contact at given pinion angles."""

    owner: IntArray  # (n,) index of the roll angle of each point
    edge: IntArray  # (n,) index in `EDGES`
    # (n,) map coordinates
    u: FloatArray
    v: FloatArray
    length: FloatArray  # (n,) length of edge represented by each point [m]
    closing: FloatArray  # (n,) gear rotation that closes the gap between the sharp edge and the mating flank [rad]
    # (n,) distance of the edge from the line of contact, which is outside the flank, normal to the line [m], positive
    distance: FloatArray

    def at(self, points: BoolArray) -> EdgePoints:
        """A subset of the points."""
        return EdgePoints(*(getattr(self, name)[points] for name in self.__dataclass_fields__))


def edge_points(
    surface: MeshSurface, pieces: tuple[EdgePiece, ...], roll: FloatArray, spacing: float, reach: float, per_line: int
) -> EdgePoints:
    """Points of edges outside the lines of roll angles (k,): pinion angles plus whole pitches [rad].

    `spacing` is the intended distance along the edge [m]; `reach` is the largest separation of the conjugate flanks at
    a point, as gear rotation [rad]; `per_line` is the number of points of a line. Raises `ConvergenceError` if an edge
    requires many times as many.
    """
    parts: list[list[FloatArray]] = []
    for piece in pieces:
        width = np.sqrt(2.0 * reach / abs(piece.bend))
        for k, angle in enumerate(roll):
            low, high = (angle, angle + width) if piece.inwards > 0.0 else (angle - width, angle)
            ends = np.interp([low, high], piece.roll, piece.arc)
            extent = float(ends[1] - ends[0])
            if extent < 1e-3 * spacing:
                continue
            if extent > _MOST_POINTS * per_line * spacing:
                found = f"the {EDGES[piece.edge]} edge is in contact over {extent * 1e3:.3g} mm, contact lines are "
                found += f"{per_line * spacing * 1e3:.3g} mm long; check face width, tooth depth and spiral angle"
                raise ConvergenceError("short_lines", found)
            count = max(4, int(np.ceil(extent / spacing)))
            arc = ends[0] + extent * (np.arange(count) + 0.5) / count
            u, v = np.interp(arc, piece.arc, piece.u), np.interp(arc, piece.arc, piece.v)
            parts.append([u, v, *(np.full(count, x) for x in (extent / count, angle, k, piece.edge))])
    if not parts:
        none, zero = np.zeros(0, np.int64), np.zeros(0)
        return EdgePoints(none, none, zero, zero, zero, zero, zero)
    u, v, length, angle, owner, edges = (np.concatenate(column) for column in zip(*parts, strict=True))
    # at some points of a gear edge the pinion has no flank
    at_u, at_v, exists = u.copy(), v.copy(), np.ones(u.shape, bool)
    own = np.flatnonzero(np.array([EDGES[k].startswith("gear") for k in edges]))
    if own.size:
        at_u[own], at_v[own], exists[own] = _landing(surface, u[own], v[own], angle[own])
    closing = point_contact(surface, angle, at_u, at_v).behind
    exists &= surface.regular(at_u, at_v) > 0.0
    frame = line_frame(surface.patch, u, v)
    size = np.sqrt((frame.gradient**2).sum(axis=0))
    distance = np.abs(surface.patch(u, v, ("roll",))[0] - angle) / size
    return EdgePoints(owner, edges, u, v, length, closing, distance).at(exists)


def _landing(
    surface: MeshSurface, u: FloatArray, v: FloatArray, angle: FloatArray
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Map coordinates of the pinion points that meet gear points (u, v) at pinion angles, and a mask of found ones.

    Newton's method; points without a solution keep the coordinates of the gear point.
    """
    x, y = u.copy(), v.copy()
    reach = surface.patch.u_range[1] - surface.patch.u_range[0]
    size = np.full(u.shape, np.inf)
    for _ in range(_LANDING):
        at = point_contact(surface, angle, x, y)
        tip, root = np.real(at.limits[2]), np.real(at.limits[3])
        slope_u = np.real(at.limit_slopes[0])
        slope_v = np.real(at.limit_slopes[3] * tip - root * at.limit_slopes[2]) / (tip + root) ** 2
        off_u, off_v = np.real(at.gear_u) - u, np.real(at.gear_v) - v
        determinant = slope_u[0] * slope_v[1] - slope_u[1] * slope_v[0]
        step_x = (slope_v[1] * off_u - slope_u[1] * off_v) / determinant
        step_y = (slope_u[0] * off_v - slope_v[0] * off_u) / determinant
        x = x - np.clip(step_x, -0.1 * reach, 0.1 * reach)
        y = y - np.clip(step_y, -0.2, 0.2)
        size = np.maximum(np.abs(step_x) / reach, np.abs(step_y))
        if size.max() < 1e-10:
            break
    (u_low, u_high), (v_low, v_high) = surface.patch.u_range, surface.patch.v_range
    depth = v_high - v_low
    # slightly beyond the map its polynomials are still valid
    inside = (x > u_low) & (x < u_high) & (y > v_low - _BEYOND * depth) & (y < v_high + _BEYOND * depth)
    found = (size < 1e-8) & inside
    return np.where(found, x, u), np.where(found, y, v), found
