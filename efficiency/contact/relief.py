"""Tip and end relief: material removed from a finished flank at its tip, toe and heel.

Relief is a depth normal to the flank, which increases from zero at its length from the edge to its amount at the edge.
Across a line of contact the separation of the flanks is x^2/(2R) from their closest approach; relief adds r(x). The
minimum of the sum is the closest approach of the relieved flanks: it moves away from the edge, the gap there increases,
and the curvature changes. Before and after the path of the flanks the edge itself is in contact only if the flank near
it is not in contact first.

Deviation of the flanks of a pair from their design: slopes, crowning and twist, and the tolerances of a grade.

The deviation is normal to the flanks, of both members together, positive where material is missing. It is added to the
ease-off, which is exact to first order.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from math import pi, sin, tan
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import model_validator

from efficiency.cutting.blank import Blank
from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel

Error = Annotated[float, ValueRange("m", ge=-5e-4, le=5e-4)]


class FlankDeviation(InputModel):
    """Deviation of both flanks in contact together [m]."""

    # difference from root to tip (pressure angle) and from toe to heel (spiral angle)
    profile_slope: Error = 0.0
    lengthwise_slope: Error = 0.0
    # at tip and root, at toe and heel, and at the corners, the middle of the flank being zero
    profile_crowning: Error = 0.0
    lengthwise_crowning: Error = 0.0
    twist: Error = 0.0

    def depth(self, blank: Blank, u: FloatArray, v: FloatArray) -> FloatArray:
        """Missing material [m] at distances from the mean point [m] and fractions of the depth of the gear."""
        x, y = 2.0 * u / blank.face_width, 2.0 * v - 1.0
        crowned = self.profile_crowning * y**2 + self.lengthwise_crowning * x**2 + self.twist * x * y
        return np.asarray(0.5 * (self.profile_slope * y + self.lengthwise_slope * x) + crowned)

    def __bool__(self) -> bool:
        return any(self.model_dump().values())


def flank_tolerances(grade: int, module: float, pinion: Blank, gear: Blank) -> FlankDeviation:
    """Standard deviations of the flanks of a pair made to a grade of ISO 1328-1:2013 (1 to 11).

    Slope and form tolerances of profile and helix (formulas unverified) of the mean normal module [m], the mean
    diameter and the face width of each member; there are no flank tolerances of bevel gears in ISO 17485. Assumed: a
    tolerance is two standard deviations, and form deviations are crowning (profile, helix) and twist (as of the helix).
    The form deviation is the band about the mean line: c for a crowning of c, 2 t for a twist of t at the corners.
    """
    squares = np.zeros(4)
    for blank in (pinion, gear):
        d = 2e3 * blank.mean_cone_distance * math.sin(blank.pitch_angle)
        b, m = 1e3 * blank.face_width, 1e3 * module
        slopes = 0.4 * m + 0.001 * d + 4.0, 0.05 * math.sqrt(d) + 0.35 * math.sqrt(b) + 4.0
        forms = 0.55 * m + 5.0, 0.07 * math.sqrt(d) + 0.45 * math.sqrt(b) + 4.0
        squares += np.square([*slopes, *forms])
    profile, lengthwise, curved, barrel = 0.5e-6 * 2.0 ** (0.5 * (grade - 5)) * np.sqrt(squares)
    return FlankDeviation(
        profile_slope=profile,
        lengthwise_slope=lengthwise,
        profile_crowning=curved,
        lengthwise_crowning=barrel,
        twist=0.5 * barrel,
    )


ReliefForm = Literal["linear", "parabolic", "circular"]

# samples of the sections: over the range, then between the neighbours of the minimum
_COARSE, _FINE = 41, 21
# tuned: distance to both sides for the curvature of relief [m], about the half-width of a loaded contact; may be
# changed after running the tests of relieved edges
_WIDTH = 1e-4
# largest amount as a fraction of the mean transverse tooth thickness; relief of both flanks leaves half of it (this
# work)
_MAX_SHARE = 0.25


class EdgeRelief(InputModel):
    """Relief at one edge."""

    # depth at the edge, normal to the flank [m]
    amount: Annotated[
        float, ValueRange("m", gt=0.0, le=1e-3, hint="Relief removes material; omit the table for no relief.")
    ]
    # distance of its start from the edge: down the tooth for the tip, along the face for toe and heel [m]
    length: Annotated[float, ValueRange("m", gt=0.0, le=0.1)]
    form: ReliefForm = "parabolic"  # a flat chamfer, a parabola, or an arc; the last two are tangent to the flank

    @model_validator(mode="after")
    def _flatter_than_half_a_right_angle(self) -> Self:
        if self.amount > self.length:
            stated = f"{self.amount * 1e3:.6g} mm"
            hint = "Relief must be flatter than 45 deg: reduce the amount or increase the length."
            raise InputError("amount", stated, f"at most its length of {self.length * 1e3:.6g} mm", hint)
        return self

    def depth(self, distance: FloatArray) -> FloatArray:
        """Depth [m] at distances from the edge [m]; extrapolated beyond the edge."""
        reach = np.maximum(self.length - distance, 0.0)
        if self.form == "linear":
            return np.asarray(self.amount * reach / self.length)
        if self.form == "parabolic":
            return np.asarray(self.amount * (reach / self.length) ** 2)
        radius = 0.5 * (self.length**2 + self.amount**2) / self.amount
        return np.asarray(radius - np.sqrt(radius**2 - np.minimum(reach, 0.999 * radius) ** 2))


class MemberRelief(InputModel):
    """Relief of both flanks of a member at tip, toe and heel; None for an edge without relief.

    At a corner the larger depth applies, because both reliefs are removed separately.
    """

    tip: EdgeRelief | None = None
    toe: EdgeRelief | None = None
    heel: EdgeRelief | None = None

    def depth(self, blank: Blank, u: FloatArray, h: FloatArray) -> FloatArray:
        """Depth [m] at blank coordinates (u, h) [m]."""
        half = 0.5 * blank.face_width
        depths = [np.zeros(np.broadcast_shapes(np.shape(u), np.shape(h)))]
        for relief, distance in ((self.tip, blank.tip(u) - h), (self.toe, u + half), (self.heel, half - u)):
            if relief is not None:
                depths.append(relief.depth(distance))
        return np.asarray(np.max(depths, axis=0))

    def check(self, blank: Blank) -> None:
        """Raise an `InputError` for relief larger than the tooth."""
        half = 0.5 * blank.face_width
        taper = tan(blank.addendum_angle) + tan(blank.dedendum_angle)
        depth = blank.mean_addendum + blank.mean_dedendum - half * abs(taper)
        if self.tip is not None and self.tip.length >= depth:
            allowed = f"below the smallest whole depth of the tooth, {depth * 1e3:.4g} mm"
            hint = "Usual values are a tenth to a third of the depth."
            raise InputError("edge_relief.tip.length", f"{self.tip.length * 1e3:.6g} mm", allowed, hint)
        ends = [end for end in (self.toe, self.heel) if end is not None]
        along = sum(end.length for end in ends)
        if ends and along >= blank.face_width:
            where = f"edge_relief.{'heel' if self.toe is None else 'toe'}.length"
            stated, allowed = f"{along * 1e3:.6g} mm at toe and heel together", f"{blank.face_width * 1e3:.4g} mm"
            hint = "Usual values are a twentieth to a fifth of the face width at each end."
            raise InputError(where, stated, f"below the face width, {allowed}", hint)
        thickness = pi * blank.mean_cone_distance * sin(blank.pitch_angle) / blank.teeth
        for name in ("tip", "toe", "heel"):
            given: EdgeRelief | None = getattr(self, name)
            if given is not None and given.amount > _MAX_SHARE * thickness:
                allowed = f"at most {_MAX_SHARE * thickness * 1e3:.4g} mm, a quarter of the tooth thickness"
                hint = "Usual values are 10 to 60 um; use the addendum or the face width for a larger chamfer."
                raise InputError(f"edge_relief.{name}.amount", f"{given.amount * 1e3:.6g} mm", allowed, hint)

    def __bool__(self) -> bool:
        return any(part is not None for part in (self.tip, self.toe, self.heel))


@dataclass(frozen=True)
class PairRelief:
    """Relief of both members."""

    pinion: MemberRelief = field(default_factory=MemberRelief)
    gear: MemberRelief = field(default_factory=MemberRelief)

    def __bool__(self) -> bool:
        return bool(self.pinion) or bool(self.gear)


@dataclass(frozen=True)
class ReliefSection:
    """Closest approach of relieved flanks in sections across their lines of contact."""

    place: FloatArray  # (n,) its position across the line [m]
    gap: FloatArray  # (n,) separation there, relative to the closest approach without relief [m]
    curvature: FloatArray  # (n,) relative curvature there [1/m]


def relief_section(
    depth: Callable[[FloatArray], FloatArray], curvature: FloatArray, centre: FloatArray
) -> ReliefSection:
    """Minimum of ``curvature (x - centre)^2/2 + depth(x)`` in n sections across the lines.

    `depth` is the relief [m] at positions (n, m) [m]; `curvature` (positive) and `centre` (n,) are those of the flanks
    without relief [1/m], [m].
    """
    at_centre = depth(centre[:, None])[:, 0]
    # farther away the parabola alone exceeds the relief at the centre
    reach = np.sqrt(2.0 * at_centre / curvature)
    place, rows = centre, np.arange(centre.size)
    for count in (_COARSE, _FINE, _FINE):
        x = place[:, None] + reach[:, None] * np.linspace(-1.0, 1.0, count)
        gap = 0.5 * curvature[:, None] * (x - centre[:, None]) ** 2 + depth(x)
        least = np.argmin(gap, axis=1)
        place, reach = x[rows, least], reach * (2.0 / (count - 1))
    lowest = gap[rows, least]
    around = depth(place[:, None] + _WIDTH * np.array([-1.0, 0.0, 1.0]))
    bend = np.maximum((around[:, 0] - 2.0 * around[:, 1] + around[:, 2]) / _WIDTH**2, 0.0)
    return ReliefSection(place, lowest, curvature + bend)
