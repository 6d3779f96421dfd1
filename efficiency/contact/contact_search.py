"""Contact of the unloaded flanks at a pinion angle: the constrained minimum of the gap, measured as gear rotation.

A point of the real pinion flank at a pinion angle has a certain radius and height in the gear frame; there the gear
flank has a known azimuth. The difference is the rotation at which the gear flank meets that point. Without load the
gear rotates until the first contact. Inside the flanks this is tangency with a common normal; on their boundary it is
edge contact: a tip, toe, heel or root edge on the mating flank, or a corner of two edges.

Each minimum is found by Newton's method in the two map coordinates for all pinion angles together, with second
derivatives by complex step.

Unloaded contact path and transmission error of one tooth pair, and of all pairs with its harmonics.

One pair: the real pinion flank is placed in space and the gear is rotated until contact (`contact_path`); the result is
exact except for the interpolation of both flanks. Inside the flanks the contact is tangency, on their boundary edge
contact. All pairs: the pair with the largest gear rotation carries the load, so the curve of the mesh is the upper
envelope of the curve of one pair, shifted by whole pitches.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from efficiency.contact.chebyshev import akima_curve
from efficiency.contact.measured_flank import MeasuredFlank
from efficiency.contact.mesh_surface import EDGES, PINION, MeshSurface
from efficiency.cutting.blank import Blank
from efficiency.cutting.machine import turn
from efficiency.cutting.newton import Array
from ehl.common.arrays import BoolArray, FloatArray, IntArray
from ehl.common.errors import ConvergenceError

ORDERS = 10
# number of angles per pitch for the path of one pair, and for the curve of the mesh
_PER_PITCH, _FINE = 32, 1024
# number of random samples of measured flanks
_DRAWS = 400
# limits of the transmission error: multiple of the first-order value from the ease-off, plus a fraction of the angular
# pitch of the gear that is always allowed; and the largest fraction of the pitch
# tuned: the three are choices of this work; may be changed after solving the random blanks of the tests
_PROPORTION, _SMALL, _LARGEST = 3.0, 5e-4, 0.1


@dataclass(frozen=True)
class ContactPath:
    """Unloaded contact of one tooth pair."""

    pinion_angle: FloatArray  # roll angle of the pinion from the design point in driving direction [rad]
    # gear rotation relative to constant ratio [rad]; zero at the highest point of the curve
    transmission_error: FloatArray
    # contact point on the gear: distance from its mean point along the pitch cone, height above that cone [m]
    u: FloatArray
    height: FloatArray
    # contact point on the pinion [m]
    u_pinion: FloatArray
    height_pinion: FloatArray
    edge: IntArray  # index in `EDGES` of the edge in contact, -1 for tangency of both flanks
    corner: BoolArray  # whether the contact is at a corner of two edges
    settled: BoolArray  # false if no minimum was found: the position is then that of the best sample
    # first-order transmission error from the ease-off on a coarse grid [rad], independent of the search
    expected: FloatArray

    @property
    def free(self) -> BoolArray:
        """Mask of tangency of both flanks, inside their edges."""
        return np.asarray(self.settled & (self.edge < 0))

    @property
    def edges(self) -> tuple[str, ...]:
        """Names of the edges in contact anywhere on the path."""
        return tuple(EDGES[k] for k in np.unique(self.edge[self.edge >= 0]))


@dataclass(frozen=True)
class Transmission:
    """Unloaded transmission error of a mesh."""

    path: ContactPath  # one tooth pair, from one pitch before its highest point to one pitch behind it
    pinion_angle: FloatArray  # one pitch of the mesh in equal steps around the highest point, without its end [rad]
    error: FloatArray  # transmission error of all pairs [rad]
    peak_to_peak: float  # range of `error` [rad]
    harmonics: FloatArray  # amplitudes at the first orders of the mesh frequency [rad]
    edges: tuple[str, ...]  # edges in contact while their pair carries: edge contact of the unloaded mesh
    settled: bool  # whether the contact was found wherever a pair carries
    # 95 % interval of `peak_to_peak` from the uncertainty of measured flanks [rad]; None if both are computed
    interval: tuple[float, float] | None = None

    @property
    def pitch(self) -> float:
        """Angular pitch of the pinion [rad]."""
        return float(self.pinion_angle[1] - self.pinion_angle[0]) * self.pinion_angle.size

    def at(self, angle: FloatArray) -> FloatArray:
        """Transmission error of all pairs at any pinion angle [rad]."""
        return np.asarray(np.interp(angle, self.pinion_angle, self.error, period=self.pitch))


def transmission(surface: MeshSurface) -> Transmission:
    """Transmission error of the unloaded mesh over one pitch, all tooth pairs together.

    Raises `ConvergenceError` if the blanks have no common part of the flank, or if the transmission error is out of
    proportion with the ease-off.
    """
    pitch, centre = surface.pitch, surface.error_maximum_roll
    first, last = surface.roll_range
    # range in which the neighbours of the pair at its highest point enter and leave the mesh
    centre = float(np.clip(centre, first + 0.5 * pitch, max(last, first + pitch) - 0.5 * pitch))
    path = contact_path(surface, centre + np.linspace(-1.0, 1.0, 2 * _PER_PITCH + 1) * pitch)
    angle = centre + (np.arange(_FINE) / _FINE - 0.5) * pitch
    error, best = _envelope(path.pinion_angle, path.transmission_error, angle, pitch)
    high, expected = np.ptp(error), np.ptp(_envelope(path.pinion_angle, path.expected, angle, pitch)[0])
    gear_pitch = 2.0 * np.pi / surface.assembly.teeth_gear
    # above the general limit, or far above the value of first order
    if high > min(_LARGEST * gear_pitch, _PROPORTION * expected + _SMALL * gear_pitch):
        found = (
            f"the unloaded transmission error, {np.degrees(high):.3g} deg peak to peak, is out of proportion with the "
        )
        found += f"ease-off, about {np.degrees(expected):.3g} deg; the flanks do not match: "
        raise ConvergenceError("transmission", f"{found}check machine settings, hypoid offset and misalignments")
    # a pair one pitch further ahead in mesh has a larger roll angle
    reached = angle + (best - 1) * pitch
    nearest = np.rint((reached - path.pinion_angle[0]) / pitch * _PER_PITCH).astype(int)
    carrying = np.unique(nearest)
    touched = np.unique(path.edge[carrying])
    return Transmission(
        path=path,
        pinion_angle=angle,
        error=error,
        peak_to_peak=float(high),
        harmonics=2.0 * np.abs(np.fft.rfft(error))[1 : ORDERS + 1] / _FINE,
        edges=tuple(EDGES[k] for k in touched[touched >= 0]),
        settled=bool(path.settled[carrying].all()),
        interval=_interval(surface, path, angle),
    )


def _interval(surface: MeshSurface, path: ContactPath, angle: FloatArray) -> tuple[float, float] | None:
    """95 % interval of the peak-to-peak error from random samples of measured flanks.

    Additional material at the point of contact advances the gear by its thickness over the lever of the contact normal;
    the displacement of the point has an effect of second order only (envelope theorem).
    """
    covariance = np.zeros((path.u.size, path.u.size))
    for flank, u, h in ((surface.gear, path.u, path.height), (surface.pinion, path.u_pinion, path.height_pinion)):
        if isinstance(flank, MeasuredFlank):
            covariance = covariance + flank.covariance(u, h)
    if not covariance.any():
        return None
    lever = np.abs(surface.patch(path.u, surface.gear.blank.fraction(path.u, path.height), ("lever",))[0])
    draw = np.random.default_rng(0).multivariate_normal
    draws = draw(np.zeros(lever.size), covariance, _DRAWS, method="eigh") / lever
    errors = [np.ptp(_envelope(path.pinion_angle, path.transmission_error + x, angle, surface.pitch)[0]) for x in draws]
    # samples scatter about the estimate as the estimate does about the true value
    low, high = np.quantile(errors, (0.025, 0.975))
    return float(low), float(high)


def _envelope(at: FloatArray, single: FloatArray, angle: FloatArray, pitch: float) -> tuple[FloatArray, IntArray]:
    """Curve of the leading pair at angles of one pitch, and the index of that pair among three."""
    # local cubics keep the kink local where an edge takes over
    pairs = np.stack([akima_curve(at, single, angle + k * pitch) for k in (-1, 0, 1)])
    pairs = np.where(np.isnan(pairs), -np.inf, pairs)
    best = np.argmax(pairs, axis=0)
    return np.asarray(pairs[best, np.arange(angle.size)]), best


@dataclass(frozen=True)
class PointContact:
    """Points of the pinion transformed to the gear."""

    # (2, n) derivatives along u and v of the lag of the gear relative to the constant ratio [rad/m, rad]
    slope: Array
    # (k, n) distance inside each of `EDGES` [m], each member in its own coordinates; the last one only for an undercut
    # pinion
    limits: Array
    limit_slopes: Array  # (k, 2, n) their derivatives
    # (n,) position of the point on the gear
    gear_u: Array
    gear_v: Array
    behind: FloatArray  # (n,) lag of the gear relative to the constant ratio, from -pi to pi [rad]; real


def _axial(point: Array, slopes: tuple[Array, Array]) -> tuple[Array, list[Array]]:
    """Radius of points, and the derivatives of radius, azimuth and height."""
    radius = np.sqrt(point[0] ** 2 + point[1] ** 2)
    rates = []
    for slope in slopes:
        around = (point[0] * slope[1] - point[1] * slope[0]) / radius**2
        rates.append(np.stack([(point[0] * slope[0] + point[1] * slope[1]) / radius, around, slope[2]]))
    return radius, rates


def _limits(blank: Blank, u: Array, h: Array, rates: list[Array]) -> tuple[list[Array], list[Array]]:
    """Distances inside toe, heel, tip and root of a blank and their derivatives; `rates` of radius, azimuth, height."""
    tip, root = np.tan(blank.addendum_angle), -np.tan(blank.dedendum_angle)
    c, s = np.cos(blank.pitch_angle), np.sin(blank.pitch_angle)
    along = np.stack([rate[0] * s + rate[2] * c for rate in rates])
    over = np.stack([rate[0] * c - rate[2] * s for rate in rates])
    return blank.inside(u, h), [along, -along, tip * along - over, over - root * along]


def point_contact(surface: MeshSurface, angle: FloatArray, u: Array, v: Array) -> PointContact:
    """Pinion points at map coordinates (n,), real or complex, in the gear frame at pinion angles (n,) [rad]."""
    assembly, gear, pinion = surface.assembly, surface.gear.blank, surface.pinion.blank
    values, *slopes = surface.patch.slopes(u, v, (*PINION, "roll"))
    at, roll = values[:3], values[3]
    back = surface.direction * np.stack([at[1], -at[0], 0.0 * at[2]])
    at_u, at_v = (slope[:3] + slope[3] * back for slope in slopes)
    turned = np.pi + surface.direction * (angle - roll) + surface.roll_zero

    def place(vector: Array) -> Array:
        return np.asarray(assembly.pinion_frame @ turn(vector, turned))

    point = place(at) + assembly.pinion_origin - np.array([[0.0], [0.0], [assembly.G]])
    radius, rates = _axial(point, (place(at_u), place(at_v)))
    gear_u, gear_h = gear.coordinates(radius, point[2])
    on_gear, gear_slopes = _limits(gear, gear_u, gear_h, rates)
    depth, depth_rate = on_gear[2] + on_gear[3], gear_slopes[2] + gear_slopes[3]
    gear_v = on_gear[3] / depth
    v_rate = (gear_slopes[3] - gear_v * depth_rate) / depth
    azimuth, by_u, by_v = surface.patch.slopes(gear_u, gear_v, ("azimuth",))
    ahead = [rate[1] for rate in rates] - by_u * gear_slopes[0] - by_v * v_rate

    radius_1, rates_1 = _axial(at, (at_u, at_v))
    pinion_u, pinion_h = pinion.coordinates(radius_1, at[2])
    on_pinion, pinion_slopes = _limits(pinion, pinion_u, pinion_h, rates_1)
    limits, slopes = [*on_gear, *on_pinion], [*gear_slopes, *pinion_slopes]
    if "regular" in surface.patch.names:
        regular, regular_u, regular_v = surface.patch.slopes(u, v, ("regular",))
        scale = surface.undercut_scale
        limits.append(scale * regular[0])
        slopes.append(scale * np.concatenate([regular_u, regular_v]))
    here = np.arctan2(np.real(point[1]), np.real(point[0])) - surface.grid.points.azimuth[-1] - np.real(azimuth[0])
    lag = here - assembly.ratio * (surface.direction * angle + surface.roll_zero)
    return PointContact(
        slope=-surface.forward * np.stack(ahead),
        limits=np.stack(limits),
        limit_slopes=np.stack(slopes),
        gear_u=gear_u,
        gear_v=gear_v,
        behind=-surface.forward * np.angle(np.exp(1j * lag)),
    )


_STEP = 1e-30
# tuned: relative curvature of the gap below which a direction is neglected, because conjugate flanks contact along
# lines (this work); may be changed after running the tests of tangency
_LEVEL = 1e-8
_ITERATIONS = 12
_SETTLED = 1e-11
# distance outside an edge within which a contact is accepted as inside [m]
_OUTSIDE = 1e-9
# tuned: edges within this fraction of the tooth depth from the sample are tried (this work); may be raised freely at
# the cost of time
_NEAR = 0.08


@dataclass(frozen=True)
class _SearchState:
    """Limits, first and second derivatives of gap and limits (first row: gap), scaled to the map."""

    limits: FloatArray
    slopes: FloatArray
    bends: FloatArray

    def at(self, points: BoolArray) -> _SearchState:
        """A subset of the points."""
        return _SearchState(self.limits[..., points], self.slopes[..., points], self.bends[..., points])


@dataclass(frozen=True)
class _Problem:
    """Gap and limits of one pair at pinion angles, in map coordinates scaled to the size of the map."""

    surface: MeshSurface
    scale: FloatArray

    def state(self, angle: FloatArray, x: FloatArray) -> _SearchState:
        """State at points x (2, n), with both complex steps in one call."""
        n = angle.size
        moved = np.concatenate([x, x], axis=1).astype(np.complex128)
        moved[0, :n] += 1j * _STEP
        moved[1, n:] += 1j * _STEP
        found = point_contact(self.surface, np.tile(angle, 2), *(moved * self.scale[:, None]))
        slopes = np.concatenate([found.slope[None], found.limit_slopes]) * self.scale[:, None]
        bends = np.stack([np.imag(slopes[..., :n]), np.imag(slopes[..., n:])], axis=2) / _STEP
        both = 0.5 * (bends + np.swapaxes(bends, 1, 2))
        return _SearchState(np.real(found.limits[:, :n]), np.real(slopes[..., :n]), both)

    def on_map(self, x: FloatArray) -> BoolArray:
        """Mask of points on the map; outside it the polynomials are not valid."""
        patch = self.surface.patch
        low, high = np.array([patch.u_range, patch.v_range]).T[:, :, None] / self.scale[:, None]
        return np.asarray(((x >= low) & (x <= high)).all(axis=0))

    def back(self, angle: FloatArray, x: FloatArray) -> tuple[FloatArray, PointContact]:
        """Lag of the gear [rad], and the points; infinite on another turn of a tooth that winds around its member."""
        s, place = self.surface, x * self.scale[:, None]
        found = point_contact(s, angle, *place)
        other = np.abs(s.patch(place[0], place[1], ("roll",))[0] - angle) > np.pi
        return np.where(other, np.inf, found.behind), found

    def newton(self, angle: FloatArray, start: FloatArray, edges: IntArray) -> tuple[FloatArray, BoolArray]:
        """Newton's method at n points, and a mask of converged ones.

        ``edges`` (2, n) defines the kind of point: -1, -1 a stationary point, -2, -1 the line of minimum gap, k, -1 the
        minimum gap along edge k, k, l the corner of two edges.
        """
        x, settled = start.copy(), np.zeros(angle.shape, dtype=bool)
        active = np.arange(angle.size)
        for _ in range(_ITERATIONS):
            now, sought = self.state(angle[active], x[:, active]), edges[:, active]
            move = np.empty((2, active.size))
            for kind, step in (
                (sought[0] == -1, _inside),
                (sought[0] == -2, _across),
                ((sought[0] >= 0) & (sought[1] < 0), _on_edge),
                (sought[1] >= 0, _corner),
            ):
                if kind.any():
                    move[:, kind] = step(now.at(kind), sought[:, kind])
            move = np.clip(move, -0.1, 0.1)
            x[:, active] += move
            done = np.abs(move).max(axis=0) < _SETTLED
            settled[active[done]] = True
            # far outside the map the polynomials are not valid
            lost = (np.abs(x[:, active] - start[:, active]) > 0.7).any(axis=0)
            active = active[~done & ~lost]
            if not active.size:
                break
        return x, settled


def _inside(now: _SearchState, edges: IntArray) -> FloatArray:
    """Newton step to a stationary point of the gap, downhill in every direction."""
    size, axes = np.linalg.eigh(np.moveaxis(now.bends[0], -1, 0))
    along = np.einsum("nij,in->nj", axes, now.slopes[0])
    size = np.abs(size)
    step = np.where(size > _LEVEL * size[:, -1:], along / size.clip(1e-300), 0.0)
    return np.asarray(-np.einsum("nij,nj->in", axes, step))


def _across(now: _SearchState, edges: IntArray) -> FloatArray:
    """Newton step in the steepest direction only: to the line of minimum gap."""
    size, axes = np.linalg.eigh(np.moveaxis(now.bends[0], -1, 0))
    steepest = axes[:, :, -1].T
    return np.asarray(-steepest * np.sum(steepest * now.slopes[0], axis=0) / size[:, -1])


def _on_edge(now: _SearchState, edges: IntArray) -> FloatArray:
    """Newton step to the minimum gap along an edge."""
    points = np.arange(edges.shape[1])
    slope, normal = now.slopes[0], now.slopes[1 + edges[0], :, points].T
    square = np.sum(normal * normal, axis=0).clip(1e-300)
    tangent = np.stack([-normal[1], normal[0]]) / np.sqrt(square)
    lift = np.sum(slope * normal, axis=0) / square
    towards = -normal * now.limits[edges[0], points] / square
    bend = now.bends[0] - lift * np.moveaxis(now.bends[1 + edges[0], :, :, points], 0, -1)
    run = np.sum(tangent * (slope + np.einsum("ijn,jn->in", bend, towards)), axis=0)
    curve = np.abs(np.einsum("in,ijn,jn->n", tangent, bend, tangent))
    # along a straight edge there is no minimum gap; steps are limited to a tenth of the map anyway
    return np.asarray(towards - tangent * run / np.maximum(curve, np.abs(run)).clip(1e-300))


def _corner(now: _SearchState, edges: IntArray) -> FloatArray:
    """Newton step to the corner of two edges; a long step for parallel edges."""
    points = np.arange(edges.shape[1])
    matrix = np.stack([now.slopes[1 + edge, :, points] for edge in edges], axis=1)
    parallel = np.abs(np.linalg.det(matrix)) < 1e-9 * np.abs(matrix).max(axis=(1, 2)) ** 2
    matrix[parallel] = np.eye(2)
    value = np.stack([now.limits[edge, points] for edge in edges], axis=1)
    step = np.linalg.solve(matrix, value[..., None])[..., 0].T
    return np.asarray(np.where(parallel, 1.0, -step))


def contact_path(surface: MeshSurface, angle: FloatArray) -> ContactPath:
    """Contact and transmission error of one tooth pair at pinion angles from the design point [rad]."""
    (u0, u1), (v0, v1) = surface.patch.u_range, surface.patch.v_range
    problem = _Problem(surface, np.array([u1 - u0, v1 - v0]))
    # a pinion with few teeth turns far during one contact: more samples
    columns = max(49, int(8.0 * np.ptp(surface.roll_range)))
    grid_u, grid_v = surface.common_points(columns, 41)
    gap, bend, roll = surface.patch(grid_u, grid_v, ("ease_off_angle", "bend", "roll"))
    rough = gap + 0.5 * bend * (roll - angle[:, None]) ** 2
    lowest, expected = np.argmin(rough, axis=1), rough.min(axis=1)
    sample = np.stack([grid_u[lowest], grid_v[lowest]]) / problem.scale[:, None]

    found, settled = problem.newton(angle, sample, np.full((2, angle.size), -1))
    back, points = problem.back(angle, found)
    room = np.real(points.limits)
    edge, corner = np.full(angle.shape, -1), np.zeros(angle.shape, dtype=bool)
    # a stationary point above the sample is rejected
    lost = ~settled | ~problem.on_map(found) | (back > problem.back(angle, sample)[0] + 1e-12)
    rest = np.flatnonzero(lost | (room.min(axis=0) < -_OUTSIDE))
    if rest.size:
        found[:, rest], back[rest], edge[rest], corner[rest], settled[rest] = _on_rim(
            problem, angle[rest], sample[:, rest], room[:, rest]
        )
        # without a solution the sample is used, with its value near its line of contact
        back = np.where(settled, back, expected)
    place = found[0] * problem.scale[0], found[1] * problem.scale[1]
    at = point_contact(surface, angle, *place)
    u, v = np.real(at.gear_u), np.real(at.gear_v)
    point = surface.patch(*place, PINION)
    on_pinion = surface.pinion.blank.place(point)
    return ContactPath(angle, -back, u, surface.height(u, v), *on_pinion, edge, corner, settled, -expected)


def _on_rim(
    problem: _Problem, angle: FloatArray, sample: FloatArray, room: FloatArray
) -> tuple[FloatArray, FloatArray, IntArray, BoolArray, BoolArray]:
    """Minimum gap over edges and corners inside all other edges; the sample itself if there is none.

    Candidates are the edges beyond which the stationary point lies or near which the sample lies, and the corners of
    the three edges nearest to the sample.
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
            # no edge has its minimum inside the others: a corner, or flanks in line contact, where any point on the
            # line of minimum gap is accepted
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
