"""Potential contact lines of all tooth pairs in mesh, edges included, at the positions of one pinion pitch.

Frame: the fixed mesh frame, z along the gear axis from the crossing point towards the heel, right-handed,
SI units. Everything "per unit pinion speed" is for a pinion turning at 1 rad/s in its driving direction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.assembly import cross, dot, turn
from efficiency.contact.edge_lines import EdgePiece, edge_pieces, edge_points, nearest_edge
from efficiency.contact.line_frame import POSITION, line_frame
from efficiency.contact.line_trace import Lines, Spans, line_points, line_spans, within_reach
from efficiency.contact.mesh_surface import EDGES, NORMAL, MeshSurface
from ehl.io.errors import ConvergenceError, InputError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


# gear rotation up to which edges are followed where nothing else is said, as a share of the pitch of the gear
EDGE_REACH = 1.0 / 60.0
# least cosine squared of the angle between an edge and the lines for which the section square to the edge is taken
_LEAST_CROSSING = 0.1
# of two flanks that still have a line of contact [m]
LARGEST_RADIUS = 10.0


@dataclass(frozen=True)
class EdgeProximity:
    """The tip, toe or heel edge next to each point, in the section in which its contact is plane.

    Attributes
    ----------
    index : (n,) int array
        Of the nearest free edge in `EDGES`.
    distance : (n,) array
        From the place of closest approach of the unlimited flanks to the edge [m]: positive where it lies inside the
        flank, negative where the edge itself is next to touch.
    crossing : (n,) array
        Radius of the edge over that of its section in the plane of contact [-]: cosine squared of the angle between
        line and edge, 1 where the section is square to the edge.
    """

    index: IntArray
    distance: FloatArray
    crossing: FloatArray

    @property
    def touching(self) -> NDArray[np.bool_]:
        """Points that belong to an edge, not to a line of contact."""
        return np.asarray(self.distance < 0.0)

    def at(self, points: IntArray) -> EdgeProximity:
        """Some of the points."""
        return EdgeProximity(self.index[points], self.distance[points], self.crossing[points])


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
    edge : EdgeProximity, optional
        The edges next to the points; None where edges are left out.
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
    edge: EdgeProximity | None = field(default=None, compare=False)

    @property
    def line_number(self) -> IntArray:
        """Number of the contact line or edge that each point belongs to, unique in the position."""
        edge = np.zeros(self.pair.size, np.int64)
        if self.edge is not None:
            edge = np.where(self.edge.touching, self.edge.index + 1, 0)
        return np.asarray(self.pair * (len(EDGES) + 1) + edge)

    @cached_property
    def lines(self) -> tuple[IntArray, ...]:
        """Indices of the points of each contact line and of each edge, in their order along it."""
        ends = np.flatnonzero(np.diff(self.line_number)) + 1
        return tuple(np.split(np.arange(self.pair.size), ends))


@dataclass(frozen=True)
class CycleLines:
    """Lines of contact of all tooth pairs at the positions of a pinion pitch, before they are divided into points.

    Attributes
    ----------
    surface : MeshSurface
        Map of the mesh.
    angles : (positions,) array
        Pinion angles [rad].
    roll : (k,) array
        Roll angles of all tooth pairs at all positions [rad].
    tooth, owner : (k,) int arrays
        Tooth pair and position they belong to.
    on_path : (m,) int array
        Those that have a line of contact.
    spans : Spans
        Their lines.
    """

    surface: MeshSurface
    angles: FloatArray
    roll: FloatArray
    tooth: IntArray
    owner: IntArray
    on_path: IntArray
    spans: Spans

    @cached_property
    def edges(self) -> tuple[EdgePiece, ...]:
        """Edges that may touch where the lines end."""
        return edge_pieces(self.surface)


def cycle_lines(surface: MeshSurface, positions: int) -> CycleLines:
    """Follow the lines of contact; several divisions into points can share them."""
    if not isinstance(positions, int) or positions < 1:
        raise InputError("positions", positions, "a whole number of at least 1")
    angles = np.arange(positions) / positions * surface.pitch
    lowest, highest = surface.roll_range
    # one pair more to both sides: edges touch before and after the path
    pairs = np.arange(
        int(np.floor((lowest - surface.pitch) / surface.pitch)) - 1, int(np.ceil(highest / surface.pitch)) + 2
    )
    # a pair further along in mesh has a larger roll angle
    roll = (angles[:, None] + pairs[None, :] * surface.pitch).ravel()
    on_path = np.flatnonzero((roll > lowest) & (roll < highest))
    spans, kept = line_spans(surface, roll[on_path])
    tooth, owner = np.tile(pairs, positions), np.repeat(np.arange(positions), pairs.size)
    return CycleLines(surface, angles, roll, tooth, owner, on_path[kept], spans)


def mesh_cycle(
    surface: MeshSurface,
    positions: int = 24,
    points_per_line: int = 31,
    reach: float | None = None,
    edges: bool = False,
    lines: CycleLines | None = None,
) -> tuple[MeshPosition, ...]:
    """Contact lines at equally spaced pinion angles over one pinion pitch, ``2 pi/N1``.

    Parameters
    ----------
    surface : MeshSurface
        Both flanks and the map of their mesh.
    positions : int
        Number of pinion angles in the pitch (the end of the pitch, equal to its start, is left out).
    points_per_line : int
        Points on each contact line, midpoints of equal parts; edges have points at about the same distance.
    reach : float, optional
        Gear rotation that the load can close at most [rad]: lines and edges end where more is needed. By default lines
        are followed from end to end and edges to a sixtieth of the gear's pitch.
    edges : bool
        Whether tip, toe and heel edges may touch where the lines end.
    lines : CycleLines, optional
        From `cycle_lines`, where they are known for this number of positions.

    Returns
    -------
    tuple of MeshPosition
        One entry per pinion angle.
    """
    if not isinstance(points_per_line, int) or points_per_line < 2:
        raise InputError("points_per_line", points_per_line, "a whole number of at least 2")
    lines = lines or cycle_lines(surface, positions)
    tooth, owner, on_path, spans = lines.tooth, lines.owner, lines.on_path, lines.spans
    if reach is not None:
        spans, kept = within_reach(surface, spans, owner[on_path], reach)
        on_path = on_path[kept]
    points = line_points(surface, spans, points_per_line)
    fields = conjugate_fields(surface, points.u, points.v, points.length)
    fields["closing"] = fields.pop("valley") / fields["lever_gear"]
    of = np.repeat(on_path, points_per_line)
    edge = None
    if edges:
        of, fields, edge = _with_edges(lines, of, fields, points, reach)
    result = []
    for k, angle in enumerate(lines.angles):
        here = np.flatnonzero(owner[of] == k)
        if not here.size:
            raise ConvergenceError("no_contact", f"no tooth pair can touch at pinion angle {angle:.4g} rad")
        own = {name: values[here] for name, values in fields.items()}
        closing = own.pop("closing")
        first = int(np.count_nonzero(owner[on_path] == k)) * points_per_line
        foremost = _lowest(closing[:first].reshape(-1, points_per_line))
        gap = (closing - closing.min()) * own["lever_gear"]
        error = -min(foremost, float(closing[first:].min(initial=np.inf)))
        next_to = edge.at(here) if edge is not None else None
        result.append(
            MeshPosition(float(angle), tooth[of[here]], gap=gap, transmission_error=error, edge=next_to, **own)
        )
    return tuple(result)


def _with_edges(
    lines: CycleLines,
    of: IntArray,
    fields: dict[str, FloatArray],
    on_lines: Lines,
    reach: float | None,
) -> tuple[IntArray, dict[str, FloatArray], EdgeProximity]:
    """Points of edges behind those of the lines: roll angle each belongs to, all fields, the edges next to the points.

    Of each position only those are kept that the reach closes.
    """
    surface, owner = lines.surface, lines.owner
    pitch = 2.0 * np.pi / surface.assembly.teeth_gear
    spacing = float(np.median(on_lines.length))
    points = edge_points(surface, lines.edges, lines.roll, spacing, reach or EDGE_REACH * pitch)
    if reach is not None:
        least = np.full(int(owner.max()) + 1, np.inf)
        np.minimum.at(least, owner[of], fields["closing"])
        np.minimum.at(least, owner[points.owner], points.closing)
        points = points.at(points.closing < least[owner[points.owner]] + reach)
    own = conjugate_fields(surface, points.u, points.v, points.length)
    del own["valley"]
    meets = own["radius_equivalent"] < 0.99 * LARGEST_RADIUS
    points, own = points.at(meets), {name: values[meets] for name, values in own.items()}
    crossing = np.maximum(nearest_edge(surface, points.u, points.v)[2], _LEAST_CROSSING)
    # the section square to the edge
    own["radius_equivalent"] = own["radius_equivalent"] / crossing
    own["closing"] = points.closing
    index, distance, crossing_lines = nearest_edge(surface, on_lines.u, on_lines.v)
    proximity = EdgeProximity(
        np.concatenate([index, points.edge]),
        np.concatenate([distance, -points.distance / np.sqrt(crossing)]),
        np.concatenate([crossing_lines, np.ones(points.u.size)]),
    )
    both = {name: np.concatenate([values, own[name]]) for name, values in fields.items()}
    return np.concatenate([of, points.owner]), both, proximity


def _lowest(closing: FloatArray) -> float:
    """Smallest value over all lines (rows), between the points by the parabola through the three lowest."""
    if not closing.size:
        return math.inf
    line, point = np.unravel_index(int(np.argmin(closing)), closing.shape)
    if not 0 < point < closing.shape[1] - 1:
        return float(closing[line, point])
    before, least, after = closing[line, point - 1 : point + 2]
    bend = before - 2.0 * least + after
    return float(least - 0.125 * (after - before) ** 2 / bend) if bend > 0.0 else float(least)


def conjugate_fields(surface: MeshSurface, u: FloatArray, v: FloatArray, length: FloatArray) -> dict[str, FloatArray]:
    """Fields of `MeshPosition` at points (u, v) of the map, each in contact at its own roll angle.

    All but those that need the whole position; ``valley`` is the separation of the flanks there [m].
    """
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
    # next to a limit of undercut flanks part more and more slowly, beyond it they would cut into each other
    curvature = np.maximum(curvature, 1.0 / LARGEST_RADIUS)
    u1, h1 = p(u, v, ("u1", "h1"))
    gear, pinion = surface.gear.blank, surface.pinion.blank
    return {
        "position": position.T,
        "normal": normal.T,
        "along": along.T,
        "across": across.T,
        "length": length,
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
