"""Where a loaded mesh leaves what the model can tell: pressure above the hardness, load at an edge of a tooth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.contact_lines import MeshPosition
from efficiency.load.compliance import Tooth
from efficiency.load.load_distribution import LoadDistribution, TeethElasticity

FloatArray = NDArray[np.float64]

# points within this share of the face width or tooth height from the middle belong to no side
_MIDDLE = 1.0 / 6.0
ARCSEC = np.pi / (180.0 * 3600.0)
# matched flanks stay well below (ours): more is a design whose flanks do not belong together
_LARGE_ERROR = 100.0 * ARCSEC


@dataclass(frozen=True)
class Peak:
    """Where the greatest Hertz pressure of the cycle lies.

    Attributes
    ----------
    pressure : float
        [Pa].
    place : str
        Where on the gear flank, in words and figures.
    edge : str
        The edge the contact line ends at there, such as ``tip edge of the gear``; empty inside the flank.
    """

    pressure: float
    place: str
    edge: str


def hardness(teeth: TeethElasticity) -> float:
    """Hardness of the softer member [Pa]."""
    return min(teeth.material_pinion.hardness, teeth.material_gear.hardness)


def points_above_hardness(load: LoadDistribution, teeth: TeethElasticity) -> tuple[int, int]:
    """Number of points with a Hertz pressure above the hardness of the softer member, and of loaded points."""
    pressure = np.concatenate([p.pressure_hertz for p in load.positions])
    return int(np.count_nonzero(pressure > hardness(teeth))), int(np.count_nonzero(pressure > 0.0))


def pressure_peak(load: LoadDistribution, teeth: TeethElasticity) -> Peak:
    """Where the greatest Hertz pressure of the cycle lies."""
    number = int(np.argmax([p.pressure_hertz.max() for p in load.positions]))
    at = load.positions[number]
    point = int(np.argmax(at.pressure_hertz))
    face, height = float(at.position.face_gear[point]), float(at.position.height_gear[point])
    width, depth = _extent(teeth.gear, face)
    place = (
        f"{_side(face / width, 'toe', 'heel')}, {_side(height / depth, 'root', 'tip')} of the gear flank "
        f"({face * 1e3:.2f} of {width * 1e3:.2f} mm from the toe, {height * 1e3:.2f} of {depth * 1e3:.2f} mm over the "
        f"root, position {number + 1} of {len(load.positions)})"
    )
    return Peak(float(at.pressure_hertz[point]), place, _edge(at.position, point, teeth))


def limit_notes(load: LoadDistribution, teeth: TeethElasticity, unloaded: float) -> tuple[str, ...]:
    """What a user has to know of the load: pressure above the hardness, a peak at an edge, flanks that do not match.

    `unloaded` is the transmission error without load, peak to peak [rad].
    """
    peak = pressure_peak(load, teeth)
    notes = []
    above, loaded = points_above_hardness(load, teeth)
    if above:
        notes.append(
            f"Hertz pressure above the {hardness(teeth) / 1e9:.3g} GPa hardness of the softer member at {above} of "
            f"{loaded} loaded points, up to {peak.pressure / 1e9:.4g} GPa, {peak.place}; the teeth would yield"
        )
    if peak.edge:
        figures = "" if above else f", {peak.pressure / 1e9:.4g} GPa {peak.place},"
        notes.append(
            f"the greatest pressure{figures} lies at the {peak.edge}; contact of the edge itself is not modelled"
        )
    if unloaded > _LARGE_ERROR:
        notes.append(
            f"the unloaded transmission error, {unloaded / ARCSEC:.0f} arcsec peak to peak, is above "
            f"{_LARGE_ERROR / ARCSEC:.0f} arcsec: the two flanks do not match, check the machine settings"
        )
    return tuple(notes)


def _extent(tooth: Tooth, face: float) -> tuple[float, float]:
    """Face width of a tooth, and its height at a distance from the toe [m]."""
    return tooth.plate.length * tooth.cos_spiral, float(tooth.plate.local_height(face / tooth.cos_spiral))


def _side(share: float, low: str, high: str) -> str:
    if abs(share - 0.5) <= _MIDDLE:
        return f"midway {low} to {high}"
    return f"near the {low if share < 0.5 else high}"


def _edge(position: MeshPosition, point: int, teeth: TeethElasticity) -> str:
    """The tooth edge a contact line ends at, if the point is the last one before an end of its line."""
    same = np.flatnonzero(position.pair == position.pair[point])
    if point not in (same[0], same[-1]):
        return ""
    ends: dict[str, float] = {}
    for member, tooth, face, height in (
        ("gear", teeth.gear, position.face_gear[point], position.height_gear[point]),
        ("pinion", teeth.pinion, position.face_pinion[point], position.height_pinion[point]),
    ):
        width, depth = _extent(tooth, float(face))
        ends |= {
            f"tip edge of the {member}": depth - float(height),
            f"toe of the {member}": float(face),
            f"heel of the {member}": width - float(face),
        }
    return min(ends, key=lambda name: ends[name])
