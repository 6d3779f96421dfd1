"""Undercut check of both members (ISO 23509 clause 8): limits of the profile shift at toe and heel.

Formula numbers (227) to (258) of ISO 23509:2016 as read in a public secondary source. That source takes the gear's
limit (258) as a lower bound of x_hm1 too; as the gear has -x_hm1 it is an upper bound, which is used here.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import asin, cos, sin, sqrt, tan
from typing import Literal

from efficiency.blanks.dimensions import Placement
from efficiency.blanks.lengthwise import Trace
from efficiency.blanks.tangency import PitchCones, limit_pressure_angle


@dataclass(frozen=True)
class UndercutLimit:
    """Limit of x_hm1 at one end of one member: smallest for the pinion, largest for the gear."""

    member: Literal["pinion", "gear"]
    place: Literal["toe", "heel"]
    limit: float
    undercut: bool


def undercut_limits(
    cones: PitchCones,
    place: Placement,
    trace: Trace,
    ends: tuple[tuple[float, float], tuple[float, float]],
    teeth: tuple[int, int],
    module: float,
    addendum_factor: float,
    shift: float,
    gear_taper: tuple[float, float],
    pressure_angles: tuple[float, float],
) -> tuple[UndercutLimit, ...]:
    """Limits at toe and heel of both members.

    Parameters
    ----------
    ends : ((float, float), (float, float))
        (R_i1, R_e1), (R_i2, R_e2) [m].
    addendum_factor, shift : float
        k_hap, x_hm1.
    gear_taper : (float, float)
        theta_a2, theta_f2.
    pressure_angles : (float, float)
        alpha_nD, alpha_nC.
    """
    d_1, d_2 = cones.pitch_angle_1, cones.pitch_angle_2
    alpha_n = 0.5 * sum(pressure_angles)
    mean_2 = cones.cone_distance_2
    results: list[UndercutLimit] = []

    def virtual(z: int, spiral: float, delta: float) -> float:
        return z / ((1.0 - (sin(spiral) * cos(alpha_n)) ** 2) * cos(spiral) * cos(delta))

    for name, cone_1 in zip(("toe", "heel"), ends[0], strict=True):
        back = cones.cone_distance_1 - cone_1
        cone_2 = sqrt(mean_2**2 + back**2 - 2.0 * mean_2 * back * cos(place.zeta_mp))
        b_2 = trace.spiral(cone_2)
        b_1 = b_2 + asin(place.offset_in_plane / cone_2)
        diameter_2 = 2.0 * cone_2 * sin(d_2)
        effective = diameter_2 * teeth[0] * cos(b_2) / (teeth[1] * cos(b_1))
        alpha_lim = limit_pressure_angle(d_1, d_2, 0.5 * effective / sin(d_1), cone_2, b_1, b_2, place.zeta_mp)
        alpha = min(pressure_angles[0] - alpha_lim, pressure_angles[1] + alpha_lim)
        tool = addendum_factor + (cone_2 - mean_2) * tan(gear_taper[0]) / module
        local = diameter_2 / teeth[1] * cos(b_2)
        least = 1.1 * tool - virtual(teeth[0], b_1, d_1) * local * sin(alpha) ** 2 / (2.0 * module)
        least += (effective - 2.0 * cone_1 * sin(d_1)) * cos(d_1) / (2.0 * module)
        results.append(UndercutLimit("pinion", "toe" if name == "toe" else "heel", least, shift < least))
    for name, cone_2 in zip(("toe", "heel"), ends[1], strict=True):
        b_2 = trace.spiral(cone_2)
        tool = addendum_factor + (cone_2 - mean_2) * tan(gear_taper[1]) / module
        local = 2.0 * cone_2 * sin(d_2) / teeth[1] * cos(b_2)
        needed = 1.1 * tool - virtual(teeth[1], b_2, d_2) * local * sin(min(pressure_angles)) ** 2 / (2.0 * module)
        results.append(UndercutLimit("gear", "toe" if name == "toe" else "heel", -needed, shift > -needed))
    return tuple(results)
