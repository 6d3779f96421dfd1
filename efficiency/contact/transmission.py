"""Unloaded contact path and transmission error: of one tooth pair, and of all pairs with its harmonics.

One pair: the real pinion flank is placed in space and the gear turned until they touch (`contact_search`): exact but
for the interpolation of both flanks. Inside the flanks that is tangency, on their rim the contact of an edge. All
pairs: the pair that holds the gear farthest ahead carries it, so the curve of the mesh is the upper envelope of the
curve of one pair, shifted by whole pitches.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from efficiency.contact.chebyshev import akima_curve
from efficiency.contact.contact_search import contact_search, point_contact
from efficiency.contact.measured_flank import MeasuredFlank
from efficiency.contact.mesh_surface import EDGES, MeshSurface
from ehl.common.arrays import BoolArray, FloatArray, IntArray
from ehl.common.errors import ConvergenceError

ORDERS = 10
# angles of the path of one pair in a pitch, and of the curve of the mesh
_PER_PITCH, _FINE = 32, 1024
# draws of measured flanks
_DRAWS = 400
# acceptance: how many times the transmission error that the ease-off has to first order, beyond a share of the angular
# pitch of the gear that is small in any case; and the share above which no pair of teeth carries smoothly
# tuned: the three are ours; may be changed by whoever solves the random blanks of the tests
_PROPORTION, _SMALL, _LARGEST = 3.0, 5e-4, 0.1


@dataclass(frozen=True)
class ContactPath:
    """Contact of one tooth pair without load."""

    pinion_angle: FloatArray  # roll of the pinion from the design point in driving direction [rad]
    # gear rotation ahead of its place at constant ratio [rad]; zero at the highest point of the curve
    transmission_error: FloatArray
    # contact point on the gear: distance from its mean point along the pitch cone, height over that cone [m]
    u: FloatArray
    height: FloatArray
    # the same on the pinion [m]
    u_pinion: FloatArray
    height_pinion: FloatArray
    edge: IntArray  # index in `EDGES` of the edge in contact, -1 where both flanks touch with a common normal
    corner: BoolArray  # where the end of an edge touches, cut off by a second one
    settled: BoolArray  # false where no minimum was found: the place is then that of the best sample
    expected: FloatArray  # transmission error as the ease-off has it, to first order and on a coarse grid [rad]

    @property
    def free(self) -> BoolArray:
        """Where both flanks touch with a common normal, inside their edges."""
        return np.asarray(self.settled & (self.edge < 0))

    @property
    def edges(self) -> tuple[str, ...]:
        """Names of the edges in contact anywhere on the path."""
        return tuple(EDGES[k] for k in np.unique(self.edge[self.edge >= 0]))


@dataclass(frozen=True)
class Transmission:
    """Unloaded transmission error of a mesh."""

    path: ContactPath  # one tooth pair, from one pitch before its highest point to one behind
    pinion_angle: FloatArray  # one pitch of the mesh in equal steps around the highest point, its end left out [rad]
    error: FloatArray  # transmission error of all pairs there [rad]
    peak_to_peak: float  # range of `error` [rad]
    harmonics: FloatArray  # amplitudes at the first orders of the mesh frequency [rad]
    edges: tuple[str, ...]  # edges in contact while their pair carries: edge contact of the unloaded mesh
    settled: bool  # whether the contact was found wherever a pair carries
    # 95 % interval of `peak_to_peak` by the uncertainty of measured flanks [rad]; none where both are computed
    interval: tuple[float, float] | None = None

    @property
    def pitch(self) -> float:
        """Angular pitch of the pinion [rad]."""
        return float(self.pinion_angle[1] - self.pinion_angle[0]) * self.pinion_angle.size

    def at(self, angle: FloatArray) -> FloatArray:
        """Transmission error of all pairs at any pinion angle [rad]."""
        return np.asarray(np.interp(angle, self.pinion_angle, self.error, period=self.pitch))


def contact_path(surface: MeshSurface, angle: FloatArray) -> ContactPath:
    """Contact and transmission error of one tooth pair at pinion angles from the design point [rad]."""
    found = contact_search(surface, angle)
    at = point_contact(surface, angle, found.u, found.v)
    u, v = np.real(at.gear_u), np.real(at.gear_v)
    point = surface.patch(found.u, found.v, ("px", "py", "pz"))
    u1, h1 = surface.pinion.blank.coordinates(np.hypot(point[0], point[1]), point[2])
    return ContactPath(
        angle,
        -found.back,
        u,
        surface.height(u, v),
        np.real(u1),
        np.real(h1),
        found.edge,
        found.corner,
        found.settled,
        -found.expected,
    )


def transmission(surface: MeshSurface) -> Transmission:
    """Transmission error of the unloaded mesh over one pitch, all tooth pairs together.

    `ConvergenceError` where the blanks share no part of the flank, or the transmission error is out of proportion with
    the ease-off.
    """
    pitch, centre = surface.pitch, surface.error_maximum_roll
    first, last = surface.roll_range
    # so that the neighbours of the pair at its highest point are on their way in and out
    centre = float(np.clip(centre, first + 0.5 * pitch, max(last, first + pitch) - 0.5 * pitch))
    path = contact_path(surface, centre + np.linspace(-1.0, 1.0, 2 * _PER_PITCH + 1) * pitch)
    angle = centre + (np.arange(_FINE) / _FINE - 0.5) * pitch
    error, best = _envelope(path.pinion_angle, path.transmission_error, angle, pitch)
    _plausible(
        surface, float(np.ptp(error)), float(np.ptp(_envelope(path.pinion_angle, path.expected, angle, pitch)[0]))
    )
    # a pair one pitch further along in mesh has a larger roll angle
    reached = angle + (best - 1) * pitch
    nearest = np.rint((reached - path.pinion_angle[0]) / pitch * _PER_PITCH).astype(int)
    carrying = np.unique(nearest)
    touched = np.unique(path.edge[carrying])
    return Transmission(
        path=path,
        pinion_angle=angle,
        error=error,
        peak_to_peak=float(np.ptp(error)),
        harmonics=2.0 * np.abs(np.fft.rfft(error))[1 : ORDERS + 1] / _FINE,
        edges=tuple(EDGES[k] for k in touched[touched >= 0]),
        settled=bool(path.settled[carrying].all()),
        interval=_interval(surface, path, angle),
    )


def _interval(surface: MeshSurface, path: ContactPath, angle: FloatArray) -> tuple[float, float] | None:
    """95 % interval of the peak-to-peak error by draws of measured flanks.

    Material that is added at the point of contact turns the gear ahead by its thickness over the lever of the contact
    normal; that the point moves changes it in second order only (envelope theorem).
    """
    covariance = np.zeros((path.u.size, path.u.size))
    for flank, u, h in ((surface.gear, path.u, path.height), (surface.pinion, path.u_pinion, path.height_pinion)):
        if isinstance(flank, MeasuredFlank):
            covariance = covariance + flank.covariance(u, h)
    if not covariance.any():
        return None
    blank = surface.gear.blank
    depth = (path.height - blank.root(path.u)) / (blank.tip(path.u) - blank.root(path.u))
    lever = np.abs(surface.patch(path.u, depth, ("lever",))[0])
    draws = (
        np.random.default_rng(0).multivariate_normal(np.zeros(lever.size), covariance, _DRAWS, method="eigh") / lever
    )
    errors = [np.ptp(_envelope(path.pinion_angle, path.transmission_error + x, angle, surface.pitch)[0]) for x in draws]
    # draws scatter about the estimate as the estimate about the truth
    low, high = np.quantile(errors, (0.025, 0.975))
    return float(low), float(high)


def _envelope(at: FloatArray, single: FloatArray, angle: FloatArray, pitch: float) -> tuple[FloatArray, IntArray]:
    """Curve of the leading pair at angles of one pitch, and which of the three pairs that is."""
    # local cubics: where an edge takes over, the kink stays where it is
    pairs = np.stack([akima_curve(at, single, angle + k * pitch) for k in (-1, 0, 1)])
    pairs = np.where(np.isnan(pairs), -np.inf, pairs)
    best = np.argmax(pairs, axis=0)
    return np.asarray(pairs[best, np.arange(angle.size)]), best


def _plausible(surface: MeshSurface, error: float, expected: float) -> None:
    """Refuse a transmission error that the ease-off, to first order, does not come near, or above any flank's."""
    pitch = 2.0 * np.pi / surface.assembly.teeth_gear
    if error > _LARGEST * pitch or error > _PROPORTION * expected + _SMALL * pitch:
        raise ConvergenceError(
            "transmission",
            f"the unloaded transmission error, {np.degrees(error):.3g} deg peak to peak, is out of proportion with "
            f"the ease-off, about {np.degrees(expected):.3g} deg; the flanks do not match: check machine settings, "
            "hypoid offset and misalignments",
        )
