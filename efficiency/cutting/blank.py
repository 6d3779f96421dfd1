"""Blank of one member: cones, face width, tooth height along the face (ISO 23509 terms).

Blank coordinates of a point: u, the distance along the pitch cone from the mean point towards the heel, and h, the
height normal to the pitch cone, positive towards the tooth tip.
"""

from math import tan
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from efficiency.cutting.newton import AnyArray
from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel

Hand = Literal["left", "right"]
Length = Annotated[float, ValueRange("m", gt=0.0, le=3.0)]
Depth = Annotated[float, ValueRange("m", ge=0.0, le=0.2)]
TaperAngle = Annotated[float, ValueRange("rad", ge=-0.35, le=0.35)]
Shift = Annotated[float, ValueRange("m", ge=-1.0, le=1.0)]

# of the tooth depth: narrower teeth have no lines of contact along the face (this work)
NARROWEST_FACE = 0.5


class Blank(InputModel):
    """Cones of one member in ISO 23509 terms, SI units and rad; the mean point is at the middle of the face width."""

    teeth: Annotated[int, Field(ge=1, le=400)]  # number of teeth
    pitch_angle: Annotated[float, ValueRange("rad", gt=0.0, lt=1.5707)]  # pitch cone angle [rad]
    # distances along the pitch cone [m]
    mean_cone_distance: Length
    face_width: Length
    # heights at the mean point, normal to the pitch cone [m]
    mean_addendum: Depth
    mean_dedendum: Depth
    # angles of face and root cone to the pitch cone [rad]
    addendum_angle: TaperAngle
    dedendum_angle: TaperAngle
    # distance of the pitch apex beyond the crossing point, away from the heel; 0 for a bevel pair [m]
    pitch_apex_beyond_crossing: Shift = 0.0
    hand: Hand  # hand of spiral

    @model_validator(mode="after")
    def _face_fits(self) -> Self:
        limits = {"twice the mean cone distance": 2.0 * self.mean_cone_distance}
        depth, taper = self.mean_addendum + self.mean_dedendum, tan(self.addendum_angle) + tan(self.dedendum_angle)
        if taper != 0.0:
            end = "toe" if taper > 0.0 else "heel"
            limits[f"where the tooth depth vanishes at the {end}"] = abs(2.0 * depth / taper)
        what, limit = min(limits.items(), key=lambda item: item[1])
        if self.face_width >= limit:
            raise InputError("face_width", f"{self.face_width * 1e3:.6g} mm", f"below {limit * 1e3:.6g} mm, {what}")
        if self.face_width < NARROWEST_FACE * depth:
            allowed = f"at least {NARROWEST_FACE * depth * 1e3:.3g} mm, half of the tooth depth at the mean point"
            raise InputError("face_width", f"{self.face_width * 1e3:.6g} mm", allowed, "Check the unit.")
        return self

    def axial(self, u: AnyArray, h: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Radius and axial position [m] of blank coordinates."""
        cone = self.mean_cone_distance + u
        c, s = np.cos(self.pitch_angle), np.sin(self.pitch_angle)
        return cone * s + h * c, cone * c - h * s - self.pitch_apex_beyond_crossing

    def coordinates(self, radius: AnyArray, z: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Blank coordinates (u, h) [m] of a radius and an axial position; the inverse of `axial`."""
        c, s = np.cos(self.pitch_angle), np.sin(self.pitch_angle)
        along = z + self.pitch_apex_beyond_crossing
        return radius * s + along * c - self.mean_cone_distance, radius * c - along * s

    def place(self, point: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Blank coordinates (u, h) [m] of points (3, ...) in the frame of the member."""
        return self.coordinates(np.hypot(point[0], point[1]), point[2])

    def root(self, u: AnyArray) -> AnyArray:
        """Height of the root cone [m], negative."""
        return -self.mean_dedendum - u * float(np.tan(self.dedendum_angle))

    def tip(self, u: AnyArray) -> AnyArray:
        """Height of the face cone [m]."""
        return self.mean_addendum + u * float(np.tan(self.addendum_angle))

    def inside(self, u: AnyArray, h: AnyArray) -> list[AnyArray]:
        """Distances inside toe, heel, tip and root [m], negative outside."""
        half = 0.5 * self.face_width
        return [u + half, half - u, self.tip(u) - h, h - self.root(u)]

    def height(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Height [m] of the fraction v of the whole depth, 0 at the root and 1 at the tip."""
        root = self.root(u)
        return root + v * (self.tip(u) - root)

    def fraction(self, u: AnyArray, h: AnyArray) -> AnyArray:
        """Fraction v of the whole depth at a height [m]; the inverse of `height`."""
        root = self.root(u)
        return np.asarray((h - root) / (self.tip(u) - root))


def blank_dimensions(blank: Blank) -> dict[str, float]:
    """Dimensions of a blank drawing in addition to the cones, SI units; crown distances are along the axis."""
    u = np.array([-0.5, 0.5]) * blank.face_width
    tips, roots = blank.tip(u), blank.root(u)
    (radius, crown), (root_radius, root) = blank.axial(u, tips), blank.axial(u, roots)
    face_angle, root_angle = blank.pitch_angle + blank.addendum_angle, blank.pitch_angle - blank.dedendum_angle
    outer = blank.mean_cone_distance + float(u[1])
    return {
        "face_angle": face_angle,
        "root_angle": root_angle,
        "outer_cone_distance": outer,
        "outer_diameter": 2.0 * outer * float(np.sin(blank.pitch_angle)),
        "outer_tip_diameter": 2.0 * float(radius[1]),
        "inner_tip_diameter": 2.0 * float(radius[0]),
        "outer_addendum": float(tips[1]),
        "outer_dedendum": -float(roots[1]),
        "outer_whole_depth": float(tips[1] - roots[1]),
        "crossing_to_crown": float(crown[1]),
        "crossing_to_front_crown": float(crown[0]),
        "face_apex_beyond_crossing": float(radius[1] / np.tan(face_angle) - crown[1]),
        "root_apex_beyond_crossing": float(root_radius[1] / np.tan(root_angle) - root[1]),
    }
