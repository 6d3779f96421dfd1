"""Potential contact lines of all tooth pairs in mesh, including edges, at the positions of one pinion pitch.

Frame: the fixed mesh frame, z along the gear axis from the crossing point towards the heel, right-handed, SI units.
"Per unit pinion speed" refers to a pinion rotating at 1 rad/s in its driving direction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.edge_lines import EdgePiece, EdgePoints, edge_pieces, edge_points, nearest_edge
from efficiency.contact.line_tracing import Lines, Spans, line_points, line_spans, within_reach
from efficiency.contact.mesh_surface import EDGES, NORMAL, POSITION, MeshSurface, line_frame, tangent_angle, undirected
from efficiency.contact.relief import relief_section
from efficiency.cutting.machine import cross, dot, turn
from ehl.common.arrays import FloatArray, IntArray
from ehl.common.errors import ConvergenceError, check_count

# tuned: gear rotation to which edges are followed by default, as a fraction of the gear pitch (this work); may be
# changed freely, larger loads extend it
EDGE_REACH = 1.0 / 60.0
# tuned: minimum cosine squared of the angle between an edge and the lines for the section normal to the edge (this
# work); may be changed after running the tests of edges against direct tangency
_MIN_CROSSING = 0.1
# tuned: largest relative radius of two flanks with a line of contact [m] (this work); may be changed freely
MAX_RADIUS = 10.0
_APART = 1e-3  # separation at points beyond a limit of undercut, more than any deflection closes [m]
MAX_POSITIONS, MAX_POINTS_PER_LINE = 1000, 301  # of a cycle; work rises with the square of the points


@dataclass(frozen=True)
class EdgeProximity:
    """The tip, toe or heel edge nearest to each point, in the section in which its contact is plane."""

    index: IntArray  # (n,) index of the nearest free edge in `EDGES`
    # (n,) distance of the closest approach of the unlimited flanks from the edge [m]: positive inside the flank,
    # negative if the edge itself is the next point of contact
    distance: FloatArray
    # (n,) radius of the edge over that of its section in the plane of contact [-]: cosine squared of the angle between
    # line and edge, 1 for a section normal to the edge
    crossing: FloatArray
    # (n,) points that belong to an edge and not to a line of contact; on a relieved flank the relief near the edge may
    # contact instead
    touching: NDArray[np.bool_]

    def at(self, points: IntArray) -> EdgeProximity:
        """A subset of the points."""
        return EdgeProximity(self.index[points], self.distance[points], self.crossing[points], self.touching[points])


@dataclass(frozen=True)
class MeshPosition:
    """All potential contact lines at one pinion angle; one entry per point, lines consecutive."""

    pinion_angle: float  # roll angle of the pinion from the design point in the driving direction [rad]
    # tooth pair of the point: 0 the reference pair, +1 the next pair ahead in mesh, -1 the pair behind
    pair: IntArray
    position: FloatArray  # point in the mesh frame [m]
    # unit common normal out of the pinion flank into the gear tooth, the direction of the force on the gear
    normal: FloatArray
    # unit tangent of the contact line (y, toe to heel) and the unit vector normal to it (x = along cross normal)
    along: FloatArray
    across: FloatArray
    # length of contact line represented by the point [m] (quadrature weight; their sum is the line length)
    length: FloatArray
    gap: FloatArray  # separation of the unloaded flanks along the normal [m]; its minimum over all pairs is zero
    radius_equivalent: FloatArray  # equivalent radius of curvature normal to the contact line [m]
    # lever arm of a unit normal force about each axis [m], positive: torque = sum(force lever).
    # ``lever_gear/lever_pinion`` is the tooth ratio N2/N1 at every (conjugate) point.
    lever_pinion: FloatArray
    lever_gear: FloatArray
    # sliding velocity of the pinion relative to the gear, along y and x, per unit pinion speed [m]
    sliding_along: FloatArray
    sliding_across: FloatArray
    # mean surface velocity along x relative to the moving contact line, per unit pinion speed [m], signed: positive
    # where the surfaces move towards +x. sliding_across/entrainment is the slide-to-roll ratio.
    entrainment: FloatArray
    # distance of the point from the root cone of each member, normal to its pitch cone [m]
    height_gear: FloatArray
    height_pinion: FloatArray
    # distance along the pitch cone from the toe of each member [m]
    face_gear: FloatArray
    face_pinion: FloatArray
    # rotation of the rigid unloaded gear relative to constant ratio [rad]; zero, or negative if it lags behind the
    # design point
    transmission_error: float
    # angle between the lay of each flank and the contact line [rad]
    lay_pinion: FloatArray
    lay_gear: FloatArray
    # edges nearest to the points; None without edges
    edge: EdgeProximity | None = field(default=None, compare=False)

    @property
    def line_number(self) -> IntArray:
        """Number of the contact line or edge of each point, unique in the position."""
        edge = np.zeros(self.pair.size, np.int64)
        if self.edge is not None:
            edge = np.where(self.edge.touching, self.edge.index + 1, 0)
        return np.asarray(self.pair * (len(EDGES) + 1) + edge)

    @property
    def sliding_direction(self) -> FloatArray:
        """Unit vectors of the sliding velocity of the pinion relative to the gear, (n, 3); zero at the pitch line."""
        sliding = self.sliding_along[:, None] * self.along + self.sliding_across[:, None] * self.across
        speed = np.linalg.norm(sliding, axis=1)
        return np.asarray(sliding / np.where(speed > 0.0, speed, 1.0)[:, None])

    @cached_property
    def lines(self) -> tuple[IntArray, ...]:
        """Indices of the points of each contact line and of each edge, in order along it."""
        ends = np.flatnonzero(np.diff(self.line_number)) + 1
        return tuple(np.split(np.arange(self.pair.size), ends))


@dataclass(frozen=True)
class CycleLines:
    """Lines of contact of all tooth pairs at the positions of a pinion pitch, before their division into points."""

    surface: MeshSurface  # map of the mesh
    angles: FloatArray  # (positions,) pinion angles [rad]
    roll: FloatArray  # (k,) roll angles of all tooth pairs at all positions [rad]
    # (k,) tooth pair and position of each roll angle
    tooth: IntArray
    owner: IntArray
    on_path: IntArray  # (m,) indices of roll angles with a line of contact
    spans: Spans  # lines of contact

    @cached_property
    def edges(self) -> tuple[EdgePiece, ...]:
        """Edges that may contact at the ends of the lines."""
        return edge_pieces(self.surface)


def cycle_lines(surface: MeshSurface, positions: int) -> CycleLines:
    """Trace the lines of contact, which several divisions into points can share."""
    check_count("positions", positions, 1, MAX_POSITIONS)
    angles = np.arange(positions) / positions * surface.pitch
    lowest, highest = surface.roll_range
    # one additional pair at both ends, because edges contact before and after the path
    first, last = (lowest - surface.pitch) / surface.pitch, highest / surface.pitch
    pairs = np.arange(int(np.floor(first)) - 1, int(np.ceil(last)) + 2)
    # a pair further ahead in mesh has a larger roll angle
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

    surface: both flanks and the map of their mesh.
    positions, points_per_line: number of pinion angles in the pitch, and of points on each contact line, at midpoints
        of equal parts. Edges have points at about the same distance.
    reach: largest gear rotation closed by the load [rad]; lines and edges end where more is required. Default: whole
        lines, and edges to 1/60 of the gear pitch.
    edges: whether tip, toe and heel edges may contact at the ends of the lines.
    lines: lines from `cycle_lines` for the same number of positions.
    """
    check_count("points_per_line", points_per_line, 2, MAX_POINTS_PER_LINE)
    lines = lines or cycle_lines(surface, positions)
    tooth, owner, on_path, spans = lines.tooth, lines.owner, lines.on_path, lines.spans
    if reach is not None:
        spans, kept = within_reach(surface, spans, owner[on_path], reach)
        on_path = on_path[kept]
    points = line_points(surface, spans, points_per_line)
    fields, across = sectioned_fields(surface, points.u, points.v, points.length)
    moved = relieved(across, fields)
    fields["closing"] = fields.pop("minimum_gap") / fields["lever_gear"]
    of = np.repeat(on_path, points_per_line)
    edge = None
    if edges:
        of, fields, edge = _with_edges(lines, of, fields, points, reach, (across, moved), points_per_line)
    result = []
    for k, angle in enumerate(lines.angles):
        here = np.flatnonzero(owner[of] == k)
        if not here.size:
            raise ConvergenceError("no_contact", f"no tooth pair is in contact at pinion angle {angle:.4g} rad")
        own = {name: values[here] for name, values in fields.items()}
        closing = own.pop("closing")
        first = int(np.count_nonzero(owner[on_path] == k)) * points_per_line
        first_touch = _lowest(closing[:first].reshape(-1, points_per_line))
        gap = (closing - closing.min()) * own["lever_gear"]
        error = -min(first_touch, float(closing[first:].min(initial=np.inf)))
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
    relief: tuple[Across, FloatArray],
    per_line: int,
) -> tuple[IntArray, dict[str, FloatArray], EdgeProximity]:
    """Edge points appended to those of the lines: roll angle of each point, all fields, nearest edges.

    At each position only the edge points within the reach are kept.
    """
    surface, owner = lines.surface, lines.owner
    pitch = 2.0 * np.pi / surface.assembly.teeth_gear
    spacing = float(np.median(on_lines.length))
    points = edge_points(surface, lines.edges, lines.roll, spacing, reach or EDGE_REACH * pitch, per_line)
    if reach is not None:
        least = np.full(int(owner.max()) + 1, np.inf)
        np.minimum.at(least, owner[of], fields["closing"])
        np.minimum.at(least, owner[points.owner], points.closing)
        points = points.at(points.closing < least[owner[points.owner]] + reach)
    own, across = sectioned_fields(surface, points.u, points.v, points.length)
    del own["minimum_gap"]
    distance_edge = relieved_edges(across, own, points)
    meets = across.curvature > 1.01 / MAX_RADIUS
    points, own = points.at(meets), {name: values[meets] for name, values in own.items()}
    crossing = np.maximum(nearest_edge(surface, points.u, points.v)[2], _MIN_CROSSING)
    # radius in the section normal to the edge
    own["radius_equivalent"] = own["radius_equivalent"] / crossing
    own["closing"] = points.closing + own.pop("relief")
    index, distance, crossing_lines = nearest_edge(surface, on_lines.u, on_lines.v)
    if surface.relief:
        across_lines, moved = relief
        distance = distance - across_lines.outwards(index) * moved
    proximity = EdgeProximity(
        np.concatenate([index, points.edge]),
        np.concatenate([distance, distance_edge[meets] / np.sqrt(crossing)]),
        np.concatenate([crossing_lines, np.ones(points.u.size)]),
        np.concatenate([np.zeros(index.size, bool), np.ones(points.u.size, bool)]),
    )
    both = {name: np.concatenate([values, own[name]]) for name, values in fields.items()}
    return np.concatenate([of, points.owner]), both, proximity


def _lowest(closing: FloatArray) -> float:
    """Smallest value over all lines (rows), interpolated by the parabola through the three lowest points."""
    if not closing.size:
        return math.inf
    line, point = np.unravel_index(int(np.argmin(closing)), closing.shape)
    if not 0 < point < closing.shape[1] - 1:
        return float(closing[line, point])
    before, least, after = closing[line, point - 1 : point + 2]
    bend = before - 2.0 * least + after
    return float(least - 0.125 * (after - before) ** 2 / bend) if bend > 0.0 else float(least)


@dataclass(frozen=True)
class Across:
    """Sections across lines of contact, through points of the map."""

    surface: MeshSurface  # map of the mesh
    # points (n,)
    u: FloatArray
    v: FloatArray
    # (2, n) change of the map coordinates along the section [1], [1/m]: of the gear point, and of the point conjugate
    # to the pinion point
    on_gear: FloatArray
    on_pinion: FloatArray
    centre: FloatArray  # (n,) position of the closest approach of the flanks without relief [m]
    curvature: FloatArray  # (n,) relative curvature of the flanks [1/m]

    def at(self, points: NDArray[np.bool_]) -> Across:
        """A subset of the sections."""
        names = [name for name in self.__dataclass_fields__ if name != "surface"]
        return Across(self.surface, *(getattr(self, name)[..., points] for name in names))

    @cached_property
    def _pinion_place(self) -> tuple[FloatArray, FloatArray]:
        """u1, h1 on the pinion and their change along the section, (2, n) each."""
        p = self.surface.patch
        by_u, by_v = p(self.u, self.v, ("u1", "h1"), du=1), p(self.u, self.v, ("u1", "h1"), dv=1)
        return p(self.u, self.v, ("u1", "h1")), by_u * self.on_pinion[0] + by_v * self.on_pinion[1]

    def places(self, x: FloatArray) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
        """Blank coordinates on gear and pinion at positions (n, m) along the sections [m]."""
        u, v = self.u[:, None] + self.on_gear[0][:, None] * x, self.v[:, None] + self.on_gear[1][:, None] * x
        (u1, h1), (by_u, by_h) = self._pinion_place
        pinion = u1[:, None] + by_u[:, None] * x, h1[:, None] + by_h[:, None] * x
        return (u, self.surface.height(u, v)), pinion

    def relief(self, x: FloatArray) -> FloatArray:
        """Relief of both members at positions (n, m) along the sections [m]."""
        gear, pinion = self.places(x)
        of, surface = self.surface.relief, self.surface
        return of.gear.depth(surface.gear.blank, *gear) + of.pinion.depth(surface.pinion.blank, *pinion)

    def outwards(self, edge: IntArray) -> FloatArray:
        """+1 if the section leaves the flank over an edge of `EDGES` with increasing position, otherwise -1."""
        gear, pinion = self.places(np.array([[0.0, 1e-6]]))
        signs = np.ones(edge.size)
        blanks = (0, self.surface.gear.blank, gear), (len(EDGES) // 2, self.surface.pinion.blank, pinion)
        for first, blank, (u, h) in blanks:
            for k, distance in enumerate(blank.inside(u, h)):
                signs = np.where(edge == first + k, np.sign(distance[:, 0] - distance[:, 1]), signs)
        return signs


def relieved(across: Across, fields: dict[str, FloatArray]) -> FloatArray:
    """Add the relief to gap and radius of points on lines; returns the displacement of the closest approach [m]."""
    moved = np.zeros(across.u.size)
    if not across.surface.relief:
        return moved
    cut = across.relief(across.centre[:, None])[:, 0] > 0.0
    if cut.any():
        own = across.at(cut)
        section = relief_section(own.relief, own.curvature, own.centre)
        moved[cut] = section.place - own.centre
        fields["minimum_gap"][cut] += section.gap
        fields["radius_equivalent"][cut] = 1.0 / section.curvature
    return moved


def relieved_edges(across: Across, fields: dict[str, FloatArray], points: EdgePoints) -> FloatArray:
    """Add the relief to the radius of edge points; returns the distance of the closest approach inside the edge [m].

    ``relief`` of the fields becomes the additional gear rotation for closing, compared with the sharp edge [rad].
    """
    fields["relief"] = np.zeros(across.u.size)
    if not across.surface.relief or not across.u.size:
        return -points.distance
    out = across.outwards(points.edge)
    section = relief_section(across.relief, across.curvature, out * points.distance)
    distance = -out * section.place
    # inside the flank the relief contacts first; at the edge the relief is missing material
    sharp = 0.5 * across.curvature * points.distance**2
    added = np.where(distance >= 0.0, section.gap - sharp, across.relief(np.zeros((across.u.size, 1)))[:, 0])
    fields["relief"] = np.maximum(added, 0.0) / fields["lever_gear"]
    fields["radius_equivalent"] = 1.0 / section.curvature
    return np.asarray(distance)


def conjugate_fields(surface: MeshSurface, u: FloatArray, v: FloatArray, length: FloatArray) -> dict[str, FloatArray]:
    """Fields of `MeshPosition` at points (u, v) of the map, each in contact at its own roll angle.

    Fields that depend on the whole position are omitted; ``minimum_gap`` is the separation of the flanks [m].
    """
    fields, across = sectioned_fields(surface, u, v, length)
    relieved(across, fields)
    return fields


def sectioned_fields(
    surface: MeshSurface, u: FloatArray, v: FloatArray, length: FloatArray
) -> tuple[dict[str, FloatArray], Across]:
    """Fields as in `conjugate_fields` for flanks without relief, and the sections across the lines."""
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
    # the line moves over the gear at 1/gradient; relative to it the gear surface moves in the opposite direction
    surface_gear = -1.0 / gradient
    surface_pinion = surface_gear + sliding_across
    lever_pinion, lever_gear = assembly.levers(position, normal)

    # the ease-off is defined on the pinion: change of the conjugate gear point per metre across the line on the pinion
    sliding_along = dot(sliding, along)
    rates = frame.rates_gradient * np.sign(gradient) * surface_gear - frame.rates_along * sliding_along
    up, vp = rates / surface_pinion
    (eu,), (ev,) = p(u, v, ("ease_off",), du=1), p(u, v, ("ease_off",), dv=1)
    euu, euv, evv = (p(u, v, ("ease_off",), du=2 - k, dv=k)[0] for k in (0, 1, 2))
    # its curvature adds to that of the conjugate flanks, its slope shifts the point of closest approach
    slope = eu * up + ev * vp
    curvature = rate / (surface_gear * surface_pinion) + euu * up**2 + 2.0 * euv * up * vp + evv * vp**2
    # beyond a limit of undercut the separation has a maximum at the line: there is no contact but that of the edges
    beyond = curvature < 1.0 / MAX_RADIUS
    curvature, slope = np.where(beyond, 1.0 / MAX_RADIUS, curvature), np.where(beyond, 0.0, slope)
    u1, h1 = p(u, v, ("u1", "h1"))
    gear, pinion = surface.gear.blank, surface.pinion.blank
    mark_gear, mark_pinion = surface.marks(u, v, ("gear", "pinion"))
    gear_axis = np.array([[0.0], [0.0], [1.0]])
    fields = {
        "position": position.T,
        "normal": normal.T,
        "along": along.T,
        "across": across.T,
        "length": length,
        "minimum_gap": p(u, v, ("ease_off",))[0] - 0.5 * slope**2 / curvature + _APART * beyond,
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
        "lay_pinion": undirected(mark_pinion - tangent_angle(assembly.pinion_axis, normal, along)),
        "lay_gear": undirected(mark_gear - tangent_angle(gear_axis, -normal, along)),
    }
    on_gear = frame.rates_gradient * np.sign(gradient)
    return fields, Across(surface, u, v, on_gear, np.stack([up, vp]), -slope / curvature, curvature)
