"""Tooth thickness of both members from their computed flanks.

The two flanks of the gear bound one slot, as the cutter leaves it. The pinion flanks are turned into that slot until
both touch, and the backlash is then taken off the pinion tooth.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from efficiency.blank.cones import ToothShape
from efficiency.contact.ease_off import conjugate_points, pinion_phase
from efficiency.cutting.flank import Flank, FlankPoints
from efficiency.design import Design
from ehl.errors import ConvergenceError, InputError

FloatArray = NDArray[np.float64]

# the root itself may be undercut or fillet: thickness there is extrapolated from these fractions of the whole depth
_FRACTIONS = (0.2, 0.6, 1.0)


def _points(flank: Flank, u: FloatArray, h: FloatArray, member: str) -> FlankPoints:
    points, found = flank.solve(u, h)
    if not found.all():
        raise ConvergenceError("undercut", f"the {flank.side} {member} flank does not span its blank")
    return points


def _normal_width(one: FlankPoints, other: FlankPoints, angle: FloatArray, pitch_angle: float) -> FloatArray:
    radius = np.hypot(one.position[0], one.position[1])
    spiral = 0.5 * (one.angles(pitch_angle)[0] + other.angles(pitch_angle)[0])
    return np.asarray(radius * angle * np.cos(spiral))


def gear_thickness(design: Design, u: FloatArray, h: FloatArray) -> FloatArray:
    """Normal circular tooth thickness of the gear [m] at blank coordinates (u, h)."""
    member = design.gear
    concave = _points(member.flank("concave"), u, h, "gear")
    convex = _points(member.flank("convex"), u, h, "gear")
    slot = np.abs(concave.azimuth - convex.azimuth)
    tooth = 2.0 * np.pi / member.blank.teeth - slot
    return _normal_width(concave, convex, tooth, member.blank.pitch_angle)


def pinion_thickness(design: Design, u: FloatArray, h: FloatArray) -> FloatArray:
    """Normal circular tooth thickness of the pinion [m] at blank coordinates (u, h), backlash taken off."""
    member = design.pinion
    blank = member.blank.blank()
    assembly = design.with_misalignment().placement()
    turned = []
    points = []
    for side in ("drive", "coast"):
        pinion, gear = design.flanks(side)
        middle = np.array([0.5 * (gear.blank.mean_addendum - blank.mean_addendum)])
        touching = conjugate_points(_points(gear, np.zeros(1), middle, "gear"), assembly)
        points.append(_points(pinion, u, h, "pinion"))
        turned.append(points[-1].azimuth + pinion_phase(touching, pinion))
    tooth = np.abs(turned[0] - turned[1])
    width = _normal_width(points[0], points[1], tooth, blank.pitch_angle)
    return np.asarray(width - design.assembly.normal_backlash)


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


def tooth_shapes(design: Design, stations: int = 7) -> tuple[ToothShape, ToothShape]:
    """Depth and thickness of one tooth of the pinion and of the gear, toe to heel.

    Raises
    ------
    InputError
        The flanks of a member cross: its tooth has no thickness left at the tip or at the root.
    """
    shapes = []
    for name, member, thickness in (
        ("pinion", design.pinion, pinion_thickness),
        ("gear", design.gear, gear_thickness),
    ):
        blank = member.blank.blank()
        u = np.linspace(-0.5, 0.5, stations) * blank.face_width
        across = np.repeat(np.array(_FRACTIONS), stations)
        along = np.tile(u, len(_FRACTIONS))
        width = thickness(design, along, blank.height(along, across)).reshape(len(_FRACTIONS), stations)
        root = np.array([np.polyval(np.polyfit(_FRACTIONS, column, 2), 0.0) for column in width.T])
        for place, values in (("tip", width[-1]), ("root", root)):
            _require_thickness(name, place, values, u + 0.5 * blank.face_width)
        shapes.append(
            ToothShape(blank.teeth, u + 0.5 * blank.face_width, blank.tip(u) - blank.root(u), root, width[-1])
        )
    return shapes[0], shapes[1]
