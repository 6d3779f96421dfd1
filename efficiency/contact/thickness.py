"""Tooth thickness of both members from their computed flanks.

The two flanks of the gear bound one slot, as the cutter leaves it. The pinion flanks are turned into that slot until
both touch, and the backlash is then taken off the pinion tooth.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from efficiency.blanks.cones import ToothShape
from efficiency.contact.gear_flanks import GearFlanks
from efficiency.cutting.flank import Flank, FlankPoints
from ehl.io.errors import ConvergenceError, InputError

FloatArray = NDArray[np.float64]

# the root itself may be undercut or fillet: thickness there is extrapolated from these fractions of the whole depth
_FRACTIONS = (0.2, 0.6, 1.0)
# a tooth that fills more of its pitch than this at the mean point is one whose flanks cross
_WIDEST = 0.9


def _points(flank: Flank, u: FloatArray, h: FloatArray, member: str) -> tuple[FlankPoints, FloatArray]:
    """Flank points with the mean point as the last one, and 0 where they exist, nan elsewhere."""
    points, found = flank.solve(np.append(u, 0.0), np.append(h, 0.0))
    if not found[-1]:
        raise ConvergenceError("undercut", f"the {flank.side} {member} flank does not reach the mean point")
    # a missing point takes the place of the mean point, so that no number of it spreads
    points = flank.points(np.where(found, points.parameters, points.parameters[:, -1:]))
    return points, np.where(found[:-1], 0.0, np.nan)


def _normal_thickness(
    concave: Flank, convex: Flank, phases: tuple[float, float], u: FloatArray, h: FloatArray, member: str
) -> FloatArray:
    """Normal circular tooth thickness at blank coordinates [m]; nan where a flank is undercut.

    The tooth reaches around the axis from the flank that looks backwards to the one that looks forwards. On which of
    the equal teeth a flank was cut does not matter: whole pitches are taken off.
    """
    (one, missing_one), (other, missing_other) = (_points(flank, u, h, member) for flank in (concave, convex))
    looks = one.position[0, -1] * one.normal[1, -1] - one.position[1, -1] * one.normal[0, -1]
    tooth = np.sign(looks) * (one.azimuth + phases[0] - other.azimuth - phases[1])
    pitch = 2.0 * np.pi / concave.blank.teeth
    mean = tooth[-1] % pitch
    mean -= pitch * (mean > _WIDEST * pitch)
    angle = mean + np.angle(np.exp(1j * (tooth - tooth[-1])))
    radius = np.hypot(one.position[0], one.position[1])
    pitch_angle = concave.blank.pitch_angle
    spiral = 0.5 * (one.angles(pitch_angle)[0] + other.angles(pitch_angle)[0])
    return np.asarray((radius * angle * np.cos(spiral))[:-1] + missing_one + missing_other)


def gear_thickness(flanks: GearFlanks, u: FloatArray, h: FloatArray) -> FloatArray:
    """Normal circular tooth thickness of the gear [m] at blank coordinates (u, h); nan where a flank is undercut."""
    return _normal_thickness(flanks.gear["concave"], flanks.gear["convex"], (0.0, 0.0), u, h, "gear")


def pinion_thickness(flanks: GearFlanks, u: FloatArray, h: FloatArray) -> FloatArray:
    """Normal circular tooth thickness of the pinion [m] at blank coordinates (u, h), backlash taken off.

    nan where a flank is undercut.
    """
    phases = flanks.pinion_phases["concave"], flanks.pinion_phases["convex"]
    width = _normal_thickness(flanks.pinion["concave"], flanks.pinion["convex"], phases, u, h, "pinion")
    return np.asarray(width - flanks.normal_backlash)


def _require_thickness(member: str, place: str, values: FloatArray, face: FloatArray) -> None:
    if np.all(values > 0.0):
        return
    thinnest = int(np.argmin(values))
    raise InputError(
        f"{member}: tooth thickness at the {place}",
        f"{values[thinnest] * 1e3:.3g} mm at {face[thinnest] * 1e3:.3g} mm from the toe",
        "above 0 mm",
        f"The concave and the convex flank of the {member} cross: check point_radius and blade_angle of both cutters, "
        "both machine settings, the addendum and the pitch angle.",
    )


def _filled(width: FloatArray, face: FloatArray) -> FloatArray:
    """Missing values of (fractions, stations) from the smooth surface through the others: undercut thins the tooth."""
    found = np.isfinite(width)
    if found.all():
        return width
    across, along = np.meshgrid(np.array(_FRACTIONS), face / face[-1], indexing="ij")
    terms = np.stack([across**i * along**j for i in range(3) for j in range(3 - i)], axis=-1)
    filled = width.copy()
    filled[~found] = terms[~found] @ np.linalg.lstsq(terms[found], width[found], rcond=None)[0]
    return filled


def tooth_shapes(flanks: GearFlanks, stations: int = 7) -> tuple[ToothShape, ToothShape]:
    """Depth and thickness of one tooth of the pinion and of the gear, toe to heel.

    Where a flank is undercut the thickness is that of the tooth continued from the rest.

    Raises
    ------
    InputError
        The flanks of a member cross: its tooth has no thickness left at the tip or at the root.
    """
    shapes = []
    for name, member, thickness in (
        ("pinion", flanks.pinion, pinion_thickness),
        ("gear", flanks.gear, gear_thickness),
    ):
        blank = member["concave"].blank
        u = np.linspace(-0.5, 0.5, stations) * blank.face_width
        face = u + 0.5 * blank.face_width
        across = np.repeat(np.array(_FRACTIONS), stations)
        along = np.tile(u, len(_FRACTIONS))
        width = thickness(flanks, along, blank.height(along, across)).reshape(len(_FRACTIONS), stations)
        width = _filled(width, face)
        root = np.array([np.polyval(np.polyfit(_FRACTIONS, column, 2), 0.0) for column in width.T])
        for place, values in (("tip", width[-1]), ("root", root)):
            _require_thickness(name, place, values, face)
        shapes.append(ToothShape(blank.teeth, face, blank.tip(u) - blank.root(u), root, width[-1]))
    return shapes[0], shapes[1]
