"""Closed-form mesh efficiency of a bevel or hypoid pair with a constant friction coefficient.

The printed formulas of Coleman and of Buckingham were not available. Both expressions are our own derivations of the
same two ideas: sliding averaged over the line of action, and worm-type loss plus bevel loss.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from efficiency.blanks.rating import Pair
from efficiency.cutting.blank import Blank
from efficiency.loss.kinematics import Driver
from ehl.common.errors import InputError


@dataclass(frozen=True)
class PitchGeometry:
    """Pitch-point data of a bevel or hypoid pair, pinion driving.

    Raises `InputError` if a length or the contact ratio is not positive, or an angle is outside 0 to 90 degrees.
    """

    pressure_angle: float  # generated normal pressure angle of the drive side [rad]
    # of pinion and gear
    spiral_angle: Pair  # mean [rad]
    pitch_angle: Pair  # [rad]
    radius: Pair  # mean pitch radius [m]
    module_normal: float  # mean normal module [m]
    contact_ratio_profile: float  # transverse (profile) contact ratio of the virtual cylindrical pair [-]

    def hypoid_factor(self, *, concave: bool) -> float:
        """Z_Hyp of ISO 10300; `concave`: whether the concave pinion flank is loaded."""
        from efficiency.blanks.iso_10300 import hypoid_factor
        from efficiency.blanks.tangency import PitchCones

        spirals = self.spiral_angle
        one, two = (radius / math.sin(cone) for radius, cone in zip(self.radius, self.pitch_angle, strict=True))
        limit = PitchCones(self.pitch_angle, (one, two), spirals).limit_pressure_angle(spirals[0] - spirals[1])
        return hypoid_factor(*spirals, self.pressure_angle, self.pressure_angle - (limit if concave else -limit))

    @classmethod
    def of(
        cls, pinion: Blank, gear: Blank, angles_pinion: tuple[float, float], angles_gear: tuple[float, float]
    ) -> PitchGeometry:
        """Pitch-point data from the blanks and the mean spiral and pressure angles of the mating flanks [rad]."""
        pressure = 0.5 * (angles_pinion[1] + angles_gear[1])
        spirals = angles_pinion[0], angles_gear[0]
        one, two = (blank.mean_cone_distance * math.sin(blank.pitch_angle) for blank in (pinion, gear))
        return cls(
            pressure_angle=pressure,
            spiral_angle=spirals,
            pitch_angle=(pinion.pitch_angle, gear.pitch_angle),
            radius=(one, two),
            module_normal=2.0 * two * math.cos(spirals[1]) / gear.teeth,
            contact_ratio_profile=profile_contact_ratio(pinion, gear, 0.5 * sum(spirals), pressure),
        )

    def __post_init__(self) -> None:
        for name in ("radius", "module_normal", "contact_ratio_profile"):
            value = getattr(self, name)
            if not np.all(np.isfinite(value) & (np.array(value) > 0.0)):
                raise InputError(name, value, "a finite number above 0")
        for name in ("pressure_angle", "spiral_angle", "pitch_angle"):
            value = getattr(self, name)
            if not np.all((np.array(value) >= 0.0) & (np.array(value) < 0.5 * math.pi)):
                raise InputError(name, value, "an angle from 0 to below pi/2 rad")

    @property
    def lengthwise_measure(self) -> float:
        """Sliding along the tooth per normal velocity, a = |tan b1 - tan b2| [-]."""
        one, two = map(math.tan, self.spiral_angle)
        return abs(one - two)

    @property
    def profile_measure(self) -> float:
        """Maximum profile sliding per normal velocity, k [-]; without offset its mean over the action is k/2."""
        cos_n = math.cos(self.pressure_angle)
        cos_base = math.sqrt(1.0 - (math.sin(0.5 * sum(self.spiral_angle)) * cos_n) ** 2)
        each = zip(self.pitch_angle, self.radius, self.spiral_angle, strict=True)
        curvature = sum(math.cos(cone) / (radius * math.cos(spiral)) for cone, radius, spiral in each)
        half_action = 0.5 * self.contact_ratio_profile * math.pi * self.module_normal
        return half_action * cos_n / cos_base * curvature

    @property
    def mean_sliding(self) -> float:
        """Mean length of the sliding vector (a, k t) for t uniform in 0..1 [-]."""
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


def coleman_type(pair: PitchGeometry, friction_coefficient: float = 0.05, driver: Driver = "pinion") -> float:
    """Mesh efficiency by averaged sliding, "Coleman-type, this work" [-].

    ``eta = 1 - mu S/(cos a_n + m C tan b1)`` with the mean sliding S, the mean lengthwise share C, and m equal to mu
    with the sign of tan b1 - tan b2. The normal force follows from the torque balance of the pinion with lengthwise
    friction. If the gear drives, the friction force is reversed: ``eta = 1/(1 + mu S/(cos a_n - m C tan b1))``.

    pair: pitch-point data of the pair.
    friction_coefficient: constant friction coefficient; Coleman used 0.05 (as cited by Kolivand, Li & Kahraman 2010).
    driver: driving member.
    """
    _check_friction(friction_coefficient)
    mu, way = friction_coefficient, 1.0 if driver == "pinion" else -1.0
    way = math.copysign(way, way * (pair.spiral_angle[0] - pair.spiral_angle[1]))
    wedge = math.cos(pair.pressure_angle) + way * mu * pair.mean_lengthwise_share * math.tan(pair.spiral_angle[0])
    loss = mu * pair.mean_sliding / wedge
    return 1.0 - loss if driver == "pinion" else 1.0 / (1.0 + loss)


def buckingham_type(pair: PitchGeometry, friction_coefficient: float = 0.05, driver: Driver = "pinion") -> float:
    """Mesh efficiency as worm-type loss plus bevel loss, "Buckingham-type, this work" [-].

    The first term is `lengthwise_sliding`; from it ``mu k/(2 cos a_n)`` is subtracted,
    the profile sliding of the spiral bevel pair.

    pair: pitch-point data of the pair.
    friction_coefficient: constant friction coefficient.
    driver: driving member.
    """
    worm = lengthwise_sliding(pair, friction_coefficient, driver)
    return worm - friction_coefficient * pair.profile_measure / (2.0 * math.cos(pair.pressure_angle))


def lengthwise_sliding(pair: PitchGeometry, friction_coefficient: float = 0.05, driver: Driver = "pinion") -> float:
    """Mesh efficiency with lengthwise sliding only, exact at the pitch point [-].

    With friction in the equilibrium ``(cos a_n + m tan b2)/(cos a_n + m tan b1)``, where m is mu with the sign of
    tan b1 - tan b2; if the gear drives, the friction force is reversed. Profile sliding is neglected, so there is no
    loss without offset.

    pair: pitch-point data of the pair.
    friction_coefficient: constant friction coefficient.
    driver: driving member.
    """
    _check_friction(friction_coefficient)
    cos_n = math.cos(pair.pressure_angle)
    tan_1, tan_2 = map(math.tan, pair.spiral_angle)
    signed = math.copysign(friction_coefficient, tan_1 - tan_2)
    if driver == "pinion":
        return (cos_n + signed * tan_2) / (cos_n + signed * tan_1)
    return (cos_n - signed * tan_1) / (cos_n - signed * tan_2)


def profile_contact_ratio(pinion: Blank, gear: Blank, spiral_angle: float, pressure_angle: float) -> float:
    """Profile contact ratio of the virtual cylindrical pair in the mean transverse section [-].

    Virtual radii ``r/cos d`` and mean addenda as in ISO 10300-1 (unverified). The result for ISO/TR 10300-30 sample 1
    is 1.165, as printed. With an offset the formula is approximate: for the blanks of samples 2 and 3 it differs from
    the printed 1.010 and 1.176; the shipped flanks give 0.96 and 1.10 (drive side), 0.87 and 0.92 (coast side).

    pinion, gear: blanks.
    spiral_angle, pressure_angle: mean spiral angle of both members and normal pressure angle [rad].
    """
    transverse = math.atan(math.tan(pressure_angle) / math.cos(spiral_angle))
    path = 0.0
    for blank in (pinion, gear):
        radius = blank.mean_cone_distance * math.tan(blank.pitch_angle)
        tip, base = radius + blank.mean_addendum, radius * math.cos(transverse)
        path += math.sqrt(tip**2 - base**2) - radius * math.sin(transverse)
    pitch = 2.0 * math.pi * pinion.mean_cone_distance * math.sin(pinion.pitch_angle) / pinion.teeth
    return path / (pitch * math.cos(transverse))
