"""Closed forms for the mesh efficiency of a whole bevel or hypoid pair with one constant friction
coefficient.

The printed formulas of Coleman and of Buckingham were not at hand. Both expressions below are our own
derivations of the same two ideas (sliding averaged over the line of action; worm-like loss plus bevel loss)
and are named so.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ehl.errors import InputError


@dataclass(frozen=True)
class PitchGeometry:
    """Pitch-point data of a bevel or hypoid pair, pinion driving.

    Parameters
    ----------
    pressure_angle : float
        Generated normal pressure angle of the drive side [rad].
    spiral_angle_pinion, spiral_angle_gear : float
        Mean spiral angles [rad].
    pitch_angle_pinion, pitch_angle_gear : float
        Pitch angles [rad].
    radius_pinion, radius_gear : float
        Mean pitch radii [m].
    module_normal : float
        Mean normal module [m].
    contact_ratio_profile : float
        Transverse (profile) contact ratio of the virtual cylindrical pair [-].

    Raises
    ------
    InputError
        If a length or the contact ratio is not positive, or an angle is outside 0..90 degrees.
    """

    pressure_angle: float
    spiral_angle_pinion: float
    spiral_angle_gear: float
    pitch_angle_pinion: float
    pitch_angle_gear: float
    radius_pinion: float
    radius_gear: float
    module_normal: float
    contact_ratio_profile: float

    def __post_init__(self) -> None:
        for name in ("radius_pinion", "radius_gear", "module_normal", "contact_ratio_profile"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(name, value, "a finite number above 0")
        for name in (
            "pressure_angle",
            "spiral_angle_pinion",
            "spiral_angle_gear",
            "pitch_angle_pinion",
            "pitch_angle_gear",
        ):
            value = getattr(self, name)
            if not (math.isfinite(value) and 0.0 <= value < 0.5 * math.pi):
                raise InputError(name, value, "an angle from 0 to below pi/2 rad")

    @property
    def lengthwise_measure(self) -> float:
        """Sliding along the tooth per normal velocity, a = |tan b1 - tan b2| [-]."""
        return abs(math.tan(self.spiral_angle_pinion) - math.tan(self.spiral_angle_gear))

    @property
    def profile_measure(self) -> float:
        """Greatest profile sliding per normal velocity, k [-] (offset 0: k/2 is its mean over the action)."""
        cos_n = math.cos(self.pressure_angle)
        mean_spiral = 0.5 * (self.spiral_angle_pinion + self.spiral_angle_gear)
        cos_base = math.sqrt(1.0 - (math.sin(mean_spiral) * cos_n) ** 2)
        curvature = math.cos(self.pitch_angle_pinion) / (
            self.radius_pinion * math.cos(self.spiral_angle_pinion)
        ) + math.cos(self.pitch_angle_gear) / (self.radius_gear * math.cos(self.spiral_angle_gear))
        half_action = 0.5 * self.contact_ratio_profile * math.pi * self.module_normal
        return half_action * cos_n / cos_base * curvature

    @property
    def mean_sliding(self) -> float:
        """Mean of the length of the sliding vector (a, k t), t uniform in 0..1 [-]."""
        a, k = self.lengthwise_measure, self.profile_measure
        tail = 0.0 if a == 0.0 else a * a / k * math.asinh(k / a)
        return 0.5 * (math.hypot(a, k) + tail)

    @property
    def mean_lengthwise_share(self) -> float:
        """Mean cosine between the sliding vector and the tooth direction, C [-]."""
        a, k = self.lengthwise_measure, self.profile_measure
        return 0.0 if a == 0.0 else a / k * math.asinh(k / a)


def _check_friction(friction_coefficient: float) -> None:
    if not (math.isfinite(friction_coefficient) and 0.0 <= friction_coefficient < 1.0):
        raise InputError("friction_coefficient", friction_coefficient, "0 to below 1")


def coleman_type(pair: PitchGeometry, friction_coefficient: float = 0.05) -> float:
    """Mesh efficiency by averaged sliding, "Coleman-type, our derivation" [-].

    ``eta = 1 - mu S/(cos a_n + mu C tan b1)`` with S the mean sliding and C the mean lengthwise share: the
    normal force follows from the pinion's torque balance with the lengthwise friction in it.

    Parameters
    ----------
    pair : PitchGeometry
        Pitch-point data of the pair.
    friction_coefficient : float
        Constant friction coefficient; 0.05 is the value of Coleman (as cited by Kolivand, Li & Kahraman
        2010).
    """
    _check_friction(friction_coefficient)
    mu = friction_coefficient
    wedge = math.cos(pair.pressure_angle) + mu * pair.mean_lengthwise_share * math.tan(pair.spiral_angle_pinion)
    return 1.0 - mu * pair.mean_sliding / wedge


def buckingham_type(pair: PitchGeometry, friction_coefficient: float = 0.05) -> float:
    """Mesh efficiency as worm-like loss plus bevel loss, "Buckingham-type, our derivation" [-].

    ``eta = (cos a_n + mu tan b2)/(cos a_n + mu tan b1) - mu k/(2 cos a_n)``. The first term is exact at the
    pitch point for a pinion with the larger spiral angle; the second is the profile sliding of the spiral
    bevel pair.

    Parameters
    ----------
    pair : PitchGeometry
        Pitch-point data of the pair.
    friction_coefficient : float
        Constant friction coefficient.
    """
    _check_friction(friction_coefficient)
    mu, cos_n = friction_coefficient, math.cos(pair.pressure_angle)
    worm = (cos_n + mu * math.tan(pair.spiral_angle_gear)) / (cos_n + mu * math.tan(pair.spiral_angle_pinion))
    return worm - mu * pair.profile_measure / (2.0 * cos_n)
