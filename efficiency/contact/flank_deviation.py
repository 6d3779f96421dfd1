"""Deviation of the flanks of a pair from their design: slopes, crowning and twist, and the tolerances of a grade.

The deviation is normal to the flanks, of both members together, positive where material is missing. It is added to the
ease-off, which is exact to first order.
"""

import math
from typing import Annotated

import numpy as np

from efficiency.cutting.blank import Blank
from ehl.common.arrays import FloatArray
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
        profile_crowning=0.5 * curved,
        lengthwise_crowning=0.5 * barrel,
        twist=0.5 * barrel,
    )
