"""Load capacity of a bevel pair after ANSI/AGMA 2003-D19: contact and bending stress numbers, safety factors, power.

torque  ->  K_v, K_m, size, crowning and curvature factors  ->  stress numbers  ->  permissible numbers, safety

The geometry factors I and J are inputs (charts of Annex D, or another program). Formula numbers (SI) from the public
repository github.com/afuentesaz/AGMAStandards (AGMA2003D19Calc), whose self test provides the printed values of the
example in Annex E. The standard itself was not available: this is not a certified calculation. The Miner sum over its
life curves is this work.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from efficiency.blanks import rating
from efficiency.blanks.rating import AgmaMember, Curve, Pair, as_pair
from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError

if TYPE_CHECKING:
    from efficiency.blanks.pair_blank import PairBlank

_ELASTIC = math.sqrt(207e9 / (2.0 * math.pi * (1.0 - 0.3**2)))  # C_p of steel on steel (32M) [sqrt(Pa)]
_MOUNTING = 1.00, 1.10, 1.25  # K_mb with neither, one or both members cantilevered
_RELIABILITY = {2: (0.84, 0.70), 10: (0.92, 0.85), 100: (1.00, 1.00), 1000: (1.12, 1.25), 10000: (1.22, 1.50)}
# contact and bending stress numbers [MPa] of each grade, with hardened roots; factors of the Brinell hardness
_NUMBERS = {
    "carburized": ((1380.0, 205.0), (1550.0, 240.0), (1720.0, 275.0)),
    "flame_hardened": ((1210.0, 154.0), (1310.0, 154.0)),
    "nitrided_4140": (None, (1000.0, 150.0)),
    "nitralloy": (None, (1100.0, 165.0)),
}
_THROUGH_HARDENED = ((2.35, 162.89), (0.30, 14.48)), ((2.51, 203.86), (0.33, 41.24))
# stress cycle factors of carburized steel as powers of the load cycles: C_L; K_L to the knee and above it
_PITTING, _ROOT, _KNEE = (3.4822, -0.0602), (6.1514, -0.1192), {False: (1.3558, -0.0178), True: (1.683, -0.0323)}


@dataclass(frozen=True)
class AgmaRating:
    """Load capacity after AGMA 2003; pairs are (pinion, gear), stresses in Pa."""

    # K_v, K_m, C_s, K_s, K_x, C_p [sqrt(Pa)], K_T, C_R, K_R
    dynamic_factor: float
    face_load_factor: float
    size_factor_pitting: float
    size_factor_root: float
    curvature_factor: float
    elasticity_factor: float
    temperature_factor: float
    reliability_factor_pitting: float
    reliability_factor_root: float
    contact_stress: float  # s_c
    # C_L, K_L, C_H, s_ac, s_at
    life_factor_pitting: Pair
    life_factor_root: Pair
    hardness_ratio_factor: Pair
    contact_stress_number: Pair
    bending_stress_number: Pair
    # s_wc, s_t, s_wt
    contact_stress_permissible: Pair
    root_stress: Pair
    root_stress_permissible: Pair
    safety_pitting: Pair
    safety_root: Pair
    # P_ac, P_at [W] with safety factors of 1
    power_pitting: Pair
    power_root: Pair
    spectrum: rating.SpectrumRating | None  # None without a load spectrum


def life_curves(critical_service: bool) -> tuple[Curve, Curve]:
    """C_L and K_L of carburized steel over load cycles, Figures 5 and 6, from 1e4 and 1e3 to 1e10 cycles.

    C_L is 2 at 1e4 cycles and does not rise below (as in textbooks; the standard was not read).
    """
    high = _KNEE[critical_service]
    knee = (high[0] / _ROOT[0]) ** (1.0 / (_ROOT[1] - high[1]))

    def points(*values: tuple[float, tuple[float, float]]) -> Curve:
        return tuple(n for n, _ in values), tuple(factor * n**power for n, (factor, power) in values)

    return points((1e4, _PITTING), (1e10, _PITTING)), points((1e3, _ROOT), (knee, high), (1e10, high))


def stress_numbers(member: AgmaMember, name: str) -> Pair:
    """s_ac and s_at [Pa] of the material and grade, Tables 3 and 5, unless given."""
    if member.material == "through_hardened":
        found: Pair | None = as_pair(
            [a * (member.brinell or 0.0) + b for a, b in _THROUGH_HARDENED[min(member.grade, 2) - 1]]
        )
    else:
        grades = _NUMBERS[member.material]
        found = grades[member.grade - 1] if member.grade <= len(grades) else None
    given = member.contact_stress_number, member.bending_stress_number
    if found is None:
        if None in given:
            allowed = "a grade of this material in AGMA 2003, or both stress numbers"
            raise InputError(f"rating.agma_2003.{name}.grade", f"{member.grade} ({member.material})", allowed)
        found = (math.nan, math.nan)
    contact, bending = (1e6 * own if value is None else value for own, value in zip(found, given, strict=True))
    return contact, bending


def hardness_ratio_factor(pinion: AgmaMember, gear: AgmaMember, ratio: float, roughness: float) -> float:
    """C_H of a through-hardened gear (27M) to (30M); ratio of teeth, Ra of the pinion flanks [m]."""
    if gear.material != "through_hardened" or gear.brinell is None:
        return 1.0
    if pinion.material != "through_hardened" or pinion.brinell is None:
        return max(1.0 + 0.00075 * math.exp(-0.52e6 * roughness) * (450.0 - gear.brinell), 1.0)
    harder = min(pinion.brinell / gear.brinell, 1.7)
    return 1.0 if harder < 1.2 else 1.0 + (0.00898 * harder - 0.00829) * (ratio - 1.0)


def rate_agma(pair: PairBlank | rating.RatedPair, inputs: rating.RatingInput) -> AgmaRating | None:
    """Load capacity at the torque of the inputs, and over their spectrum; None without a table `agma_2003`."""
    own = inputs.agma_2003
    if own is None:
        return None
    if pair.hypoid_offset:
        text = f"{1e3 * pair.hypoid_offset:.4g} mm"
        raise InputError("rating.agma_2003", text, "no offset", "AGMA 2003 is for bevel pairs.")
    face = min(pair.pinion.face_width, pair.gear.face_width)
    module = 1e3 * pair.gear.outer_diameter / pair.gear.teeth
    diameters = np.array([pair.pinion.outer_diameter, pair.gear.outer_diameter])
    distribution = _MOUNTING[rating.CANTILEVERED.index(inputs.cantilevered)] + 5.6 * face**2  # (20M)
    size = min(max(4.92 * face + 0.4375, 0.5), 0.83), 0.5 if module < 1.6 else 0.4867 + 0.008399 * module  # (18M, 19M)
    curvature = rating.curvature_factor(pair)
    hot = 1.0 if own.temperature_blank is None else max((own.temperature_blank - 0.15) / 393.0, 1.0)  # (31M)
    reliability = _RELIABILITY[own.one_failure_in]
    members, curves = (own.pinion, own.gear), life_curves(own.critical_service)
    contact_number, bending_number = np.transpose(
        [stress_numbers(m, name) for m, name in zip(members, ("pinion", "gear"), strict=True)]
    )
    # Rz = 6 Ra
    hard = 1.0, hardness_ratio_factor(own.pinion, own.gear, pair.ratio, inputs.flank_rz / 6.0)
    contact_limit = contact_number * hard / (hot * reliability[0])
    root_limit = bending_number / (hot * reliability[1])

    def stresses(torque: float, speed: float) -> tuple[float, float, FloatArray]:
        """K_v, s_c (1M), s_t (5M)."""
        dynamic = inputs.dynamic_factor or rating.dynamic_factor(pair, speed, inputs.accuracy_grade)
        load = 2.0 * torque * inputs.application_factor * dynamic * distribution / (face * diameters[0])
        contact = load * size[0] * own.crowning_factor / (diameters[0] * own.pitting_geometry_factor)
        geometry = np.array([m.bending_geometry_factor for m in members])
        # the torque of the gear over its diameter is that of the pinion
        return dynamic, _ELASTIC * math.sqrt(contact), load * size[1] / (1e-3 * module * curvature * geometry)

    dynamic, contact, root = stresses(inputs.torque, inputs.speed)
    life = [(1.0, 1.0)] * 2
    if inputs.life is not None:
        cycles = rating.load_cycles(pair.ratio, inputs.speed, inputs.life)
        life = [rating.life_factors(curve, cycles) for curve in curves]

    def used(torque: float, speed: float) -> tuple[FloatArray, FloatArray]:
        _, pressed, bent = stresses(torque, speed)
        return pressed / contact_limit, bent / root_limit

    safety = contact_limit * life[0] / contact, root_limit * life[1] / root
    power = inputs.torque * inputs.speed
    return AgmaRating(
        dynamic_factor=dynamic,
        face_load_factor=distribution,
        size_factor_pitting=size[0],
        size_factor_root=size[1],
        curvature_factor=curvature,
        elasticity_factor=_ELASTIC,
        temperature_factor=hot,
        reliability_factor_pitting=reliability[0],
        reliability_factor_root=reliability[1],
        contact_stress=contact,
        life_factor_pitting=life[0],
        life_factor_root=life[1],
        hardness_ratio_factor=hard,
        contact_stress_number=as_pair(contact_number),
        bending_stress_number=as_pair(bending_number),
        contact_stress_permissible=as_pair(contact_limit * life[0]),
        root_stress=as_pair(root),
        root_stress_permissible=as_pair(root_limit * life[1]),
        safety_pitting=as_pair(safety[0]),
        safety_root=as_pair(safety[1]),
        power_pitting=as_pair(power * safety[0] ** 2),
        power_root=as_pair(power * safety[1]),
        spectrum=rating.spectrum_rating(curves, inputs.loads, pair.ratio, used),
    )
