"""Unloaded contact path and transmission error of one tooth pair, and of all pairs with its harmonics.

One pair: the real pinion flank is placed in space and the gear is rotated until contact (`contact_search`); the result
is exact except for the interpolation of both flanks. Inside the flanks the contact is tangency, on their boundary edge
contact. All pairs: the pair with the largest gear rotation carries the load, so the curve of the mesh is the upper
envelope of the curve of one pair, shifted by whole pitches.
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
# number of angles per pitch for the path of one pair, and for the curve of the mesh
_PER_PITCH, _FINE = 32, 1024
# number of random samples of measured flanks
_DRAWS = 400
# limits of the transmission error: multiple of the first-order value from the ease-off, plus a fraction of the angular
# pitch of the gear that is always allowed; and the largest fraction of the pitch
# tuned: the three are ours; may be changed after solving the random blanks of the tests
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
    expected: FloatArray  # first-order transmission error from the ease-off on a coarse grid [rad]

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
    _plausible(
        surface, float(np.ptp(error)), float(np.ptp(_envelope(path.pinion_angle, path.expected, angle, pitch)[0]))
    )
    # a pair one pitch further ahead in mesh has a larger roll angle
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
    blank = surface.gear.blank
    depth = (path.height - blank.root(path.u)) / (blank.tip(path.u) - blank.root(path.u))
    lever = np.abs(surface.patch(path.u, depth, ("lever",))[0])
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


def _plausible(surface: MeshSurface, error: float, expected: float) -> None:
    """Raise an error if the transmission error is far above the first-order value, or above the general limit."""
    pitch = 2.0 * np.pi / surface.assembly.teeth_gear
    if error > _LARGEST * pitch or error > _PROPORTION * expected + _SMALL * pitch:
        raise ConvergenceError(
            "transmission",
            f"the unloaded transmission error, {np.degrees(error):.3g} deg peak to peak, is out of proportion with "
            f"the ease-off, about {np.degrees(expected):.3g} deg; the flanks do not match: check machine settings, "
            "hypoid offset and misalignments",
        )
