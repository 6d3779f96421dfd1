"""Geometry of an involute pair on parallel axes (ISO 21771 terms): radii, working angle, path of contact.

The path of contact is counted from the pitch point along the line of action in the transverse section, positive
towards the tip of the pinion: A (root of the pinion) is negative, E (its tip) positive.
"""

import math
from dataclasses import dataclass
from functools import cached_property

from scipy.optimize import newton

from ehl.common.errors import InputError


def involute(angle: float) -> float:
    """inv(alpha) = tan(alpha) - alpha."""
    return math.tan(angle) - angle


@dataclass(frozen=True)
class InvolutePair:
    """An external pair; lengths in m, angles in rad, (pinion, gear) where there are two."""

    teeth: tuple[int, int]
    module: float  # normal module m_n
    pressure_angle: float  # normal, of the basic rack
    helix_angle: float  # at the reference cylinder; 0 for spur gears
    profile_shift: tuple[float, float]  # x [-]
    face_width: float
    centre_distance: float | None = None  # without backlash if not given
    # of the basic rack over the module [-]
    addendum: tuple[float, float] = (1.0, 1.0)
    dedendum: tuple[float, float] = (1.25, 1.25)
    # instead of that of addendum, profile shift and the tip shortening that keeps the clearance
    tip_diameter: tuple[float | None, float | None] = (None, None)

    @cached_property
    def transverse_angle(self) -> float:
        """alpha_t: tan(alpha_t) = tan(alpha_n)/cos(beta)."""
        return math.atan(math.tan(self.pressure_angle) / math.cos(self.helix_angle))

    @cached_property
    def reference(self) -> tuple[float, float]:
        """Reference radii r = z m_n/(2 cos beta)."""
        one, two = (0.5 * z * self.module / math.cos(self.helix_angle) for z in self.teeth)
        return one, two

    @cached_property
    def base(self) -> tuple[float, float]:
        """Base radii r_b = r cos(alpha_t)."""
        one, two = (r * math.cos(self.transverse_angle) for r in self.reference)
        return one, two

    @cached_property
    def base_helix(self) -> float:
        """beta_b: tan(beta_b) = tan(beta) cos(alpha_t)."""
        return math.atan(math.tan(self.helix_angle) * math.cos(self.transverse_angle))

    @cached_property
    def working_angle(self) -> float:
        """alpha_wt, transverse, at the working pitch circles."""
        if self.centre_distance is not None:
            cosine = sum(self.base) / self.centre_distance
            if cosine >= 1.0:
                least = f"above {1e3 * sum(self.base):.6g} mm, the sum of the base radii"
                raise InputError("centre_distance", f"{1e3 * self.centre_distance:.6g} mm", least)
            return math.acos(cosine)
        shift = 2.0 * sum(self.profile_shift) / sum(self.teeth) * math.tan(self.pressure_angle)
        value = involute(self.transverse_angle) + shift
        # Newton's method from above, where the involute is convex
        return float(newton(lambda a: involute(a) - value, 1.2, lambda a: math.tan(a) ** 2, tol=1e-15))

    @cached_property
    def centre(self) -> float:
        """Centre distance."""
        return sum(self.base) / math.cos(self.working_angle)

    @cached_property
    def pitch(self) -> tuple[float, float]:
        """Working pitch radii."""
        one, two = (r / math.cos(self.working_angle) for r in self.base)
        return one, two

    @cached_property
    def root(self) -> tuple[float, float]:
        """Root radii r + m (x - dedendum)."""
        parts = zip(self.reference, self.profile_shift, self.dedendum, strict=True)
        one, two = (r + self.module * (x - depth) for r, x, depth in parts)
        return one, two

    @cached_property
    def tip(self) -> tuple[float, float]:
        """Tip radii; without tip diameters, shortened for the centre distance."""
        short = max(sum(self.reference) + sum(self.profile_shift) * self.module - self.centre, 0.0)
        parts = zip(self.reference, self.profile_shift, self.addendum, self.tip_diameter, strict=True)
        one, two = (
            r + self.module * (x + height) - short if given is None else 0.5 * given for r, x, height, given in parts
        )
        return one, two

    @cached_property
    def tangent(self) -> tuple[float, float]:
        """Distances of the pitch point from both base tangent points, r_w sin(alpha_wt)."""
        one, two = (r * math.sin(self.working_angle) for r in self.pitch)
        return one, two

    @cached_property
    def path(self) -> tuple[float, float]:
        """Ends A (negative) and E (positive) of the path of contact, at the tips of gear and pinion."""
        approach, recess = (
            math.sqrt(max(tip**2 - base**2, 0.0)) - tangent
            for tip, base, tangent in zip(reversed(self.tip), reversed(self.base), reversed(self.tangent), strict=True)
        )
        if approach >= self.tangent[0] or recess >= self.tangent[1]:
            member = "gear" if approach >= self.tangent[0] else "pinion"
            detail = "tips that meet involute flanks: the path of contact runs beyond a base circle"
            raise InputError(f"{member}.tip_diameter", f"{2e3 * self.tip[member == 'gear']:.6g} mm", detail)
        if approach + recess <= 0.0:
            raise InputError("centre_distance", f"{1e3 * self.centre:.6g} mm", "one at which the tips overlap")
        return -approach, recess

    @cached_property
    def base_pitch(self) -> float:
        """Transverse base pitch p_bt."""
        return 2.0 * math.pi * self.base[0] / self.teeth[0]

    @property
    def contact_ratio(self) -> float:
        """Transverse contact ratio epsilon_alpha [-]."""
        start, end = self.path
        return (end - start) / self.base_pitch

    @property
    def overlap_ratio(self) -> float:
        """Overlap ratio epsilon_beta = b tan(beta_b)/p_bt [-]."""
        return self.face_width * math.tan(self.base_helix) / self.base_pitch

    @property
    def loss_factor(self) -> float:
        """H_v of Ohlendorf (1958), load shared evenly by two pairs of teeth [-]: contact ratios from 1 to 2.

        pi (u + 1)/(z1 u cos beta_b) (1 - e + e1^2 + e2^2), e1 and e2 the parts of the contact ratio after and before
        the pitch point.
        """
        start, end = (value / self.base_pitch for value in self.path)
        ratio = self.teeth[1] / self.teeth[0]
        scale = math.pi * (ratio + 1.0) / (self.teeth[0] * ratio * math.cos(self.base_helix))
        return scale * (1.0 - (end - start) + start**2 + end**2)

    def half_angle(self, member: int, radius: float) -> float:
        """Half the angle that a tooth of pinion (0) or gear (1) fills at a radius, transverse [rad].

        Below the base circle the flanks continue radially.
        """
        z, x = self.teeth[member], self.profile_shift[member]
        at = math.acos(min(1.0, self.base[member] / radius))
        own = (0.5 * math.pi + 2.0 * x * math.tan(self.pressure_angle)) / z
        return own + involute(self.transverse_angle) - involute(at)
