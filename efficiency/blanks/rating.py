"""Load capacity of a bevel pair (ISO 10300, AGMA 2003): inputs, geometry that it requires, life and load spectrum.

A life curve is a sequence of lines of log stress over log load cycles; a load spectrum is rated by the Miner sum.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal, Self

import numpy as np
from pydantic import model_validator

from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel

if TYPE_CHECKING:
    from efficiency.blanks.pair_blank import PairBlank
    from efficiency.blanks.virtual_gears import VirtualGears

ROOT_ROUGHNESS = 16e-6
"""Default Rz of the root fillets [m] (ISO/TR 10300-30, sample 1)."""
CANTILEVERED = ("neither", "one", "both")

Side = Literal["drive", "coast"]
SIDES: tuple[Side, Side] = ("drive", "coast")
Pair = tuple[float, float]  # values of pinion and gear
Curve = tuple[Sequence[float], Sequence[float]]  # load cycles, life factors
# contact and root stress over their limits at a pinion torque [N m] and speed [rad/s]
Used = Callable[[float, float], tuple[FloatArray, FloatArray]]
Torque = Annotated[float, ValueRange("N*m", gt=0.0, le=1e7)]
Speed = Annotated[float, ValueRange("rad/s", gt=0.0, le=1e5)]
Hours = Annotated[float, ValueRange("h", gt=0.0, le=1e6)]
Stress = Annotated[float, ValueRange("Pa", gt=0.0, le=1e10)]
Rz = Annotated[float, ValueRange("m", gt=0.0, le=1e-4)]
GeometryFactor = Annotated[float, ValueRange("", gt=0.0, le=1.0)]


class AgmaMember(InputModel):
    """A member in the rating after AGMA 2003: geometry factor J, and material with its grade or stress numbers."""

    bending_geometry_factor: GeometryFactor
    material: Literal["carburized", "flame_hardened", "through_hardened", "nitrided_4140", "nitralloy"] = "carburized"
    grade: Literal[1, 2, 3] = 1
    brinell: Annotated[float, ValueRange("", ge=180.0, le=400.0)] | None = None
    contact_stress_number: Stress | None = None
    bending_stress_number: Stress | None = None

    @model_validator(mode="after")
    def _hardness(self) -> Self:
        if self.material == "through_hardened" and self.brinell is None:
            raise InputError("brinell", None, "the Brinell hardness of a through-hardened steel")
        return self


class AgmaFactors(InputModel):
    """Table `rating.agma_2003`: geometry factors I and J (of charts or other programs) and factors of AGMA 2003."""

    pitting_geometry_factor: GeometryFactor
    pinion: AgmaMember
    gear: AgmaMember
    crowning_factor: Annotated[float, ValueRange("", ge=1.5, le=5.0)] = 1.5
    one_failure_in: Literal[2, 10, 100, 1000, 10000] = 100
    temperature_blank: Annotated[float, ValueRange("K", ge=273.15, le=473.15)] | None = None
    critical_service: bool = False


class RatingLoad(InputModel):
    """One step of a load spectrum."""

    torque: Torque
    speed: Speed
    hours: Hours


class RatingFactors(InputModel):
    """Table `rating` of a design file: additional inputs of the load capacity.

    `cantilevered`: members without bearings on both sides. `pattern_verified`: how the contact pattern is checked, of
    each pair under full or light load, or of a sample. With `pitch_deviation_gear` the dynamic and transverse load
    factors are of Method B, else of Method C with the accuracy grade of ISO 17485. `agma_2003`: rating after AGMA 2003
    as well.
    """

    application_factor: Annotated[float, ValueRange("", ge=1.0, le=5.0)] = 1.0
    dynamic_factor: Annotated[float, ValueRange("", ge=1.0, le=5.0)] | None = None
    pitch_deviation_gear: Annotated[float, ValueRange("m", ge=0.0, le=5e-4)] | None = None
    accuracy_grade: Literal[5, 6, 7, 8, 9] = 7
    cantilevered: Literal["neither", "one", "both"] = "one"
    pattern_verified: Literal["full_load", "light_load", "sample"] = "light_load"
    profile_crowning: Literal["low", "high"] = "low"
    root_rz: Rz = ROOT_ROUGHNESS
    life: Hours | None = None
    loads: tuple[RatingLoad, ...] = ()
    agma_2003: AgmaFactors | None = None


class RatingInput(RatingFactors):
    """Table `rating` of a blank file: load, blades, material and oil as well."""

    torque: Torque
    speed: Speed
    edge_radius_pinion: Annotated[float, ValueRange("m", gt=0.0, le=0.02)]
    edge_radius_gear: Annotated[float, ValueRange("m", gt=0.0, le=0.02)]
    contact_endurance: Stress = 1.5e9
    bending_endurance: Stress = 480e6
    viscosity_kinematic_40: Annotated[float, ValueRange("m^2/s", gt=0.0, le=1e-2)] = 150e-6
    flank_rz: Rz = 8e-6


@dataclass(frozen=True)
class RatedMember:
    """Data of one member for the rating; names and units of `MemberBlank`."""

    teeth: int
    pitch_angle: float
    mean_cone_distance: float
    mean_diameter: float
    outer_diameter: float
    face_width: float
    mean_spiral_angle: float
    mean_addendum: float
    mean_whole_depth: float
    thickness_coefficient: float


@dataclass(frozen=True)
class RatedPair:
    """Data of a pair for the rating, a subset of `PairBlank` with its names and units."""

    pinion: RatedMember
    gear: RatedMember
    ratio: float
    hypoid_offset: float
    cutter_radius: float
    module_normal: float
    offset_angle: float
    offset_angle_pitch_plane: float
    pressure_angle_drive: float
    pressure_angle_coast: float
    effective_pressure_angle_drive: float
    effective_pressure_angle_coast: float
    profile_shift: float
    dedendum_factor: float
    virtual_drive: VirtualGears
    virtual_coast: VirtualGears


@dataclass(frozen=True)
class SpectrumRating:
    """Miner sums of a load spectrum, and the factors on all its stresses at which they are 1; (pinion, gear)."""

    damage_pitting: Pair
    damage_root: Pair
    safety_pitting_spectrum: Pair
    safety_root_spectrum: Pair


def load_cycles(ratio: float, speed: float, hours: float) -> Pair:
    """Load cycles of pinion and gear at a pinion speed [rad/s] over hours."""
    cycles = 1800.0 * hours * speed / math.pi
    return cycles, cycles / ratio


def life_factor(curve: Curve, cycles: float) -> float:
    """Stress number over that of the reference life after load cycles, constant outside the curve."""
    return float(np.exp(np.interp(math.log(max(cycles, 1.0)), np.log(curve[0]), np.log(curve[1]))))


def life_factors(curve: Curve, cycles: Pair) -> Pair:
    """Life factors of pinion and gear."""
    return life_factor(curve, cycles[0]), life_factor(curve, cycles[1])


def _cycles(curve: Curve, ratio: float) -> float:
    """Cycles to failure at a stress over the permissible one of the reference life; infinite below the last factor."""
    cycles, factors = np.log(curve[0])[::-1], np.log(curve[1])[::-1]
    if math.log(ratio) < factors[0]:
        return math.inf
    return math.exp(float(np.interp(math.log(ratio), factors, cycles)))


def damage(curve: Curve, steps: Sequence[tuple[float, float]], safety: float = 1.0) -> float:
    """Miner sum of a spectrum: stress over the permissible one of the reference life, and load cycles."""
    return sum(n / _cycles(curve, safety * ratio) if safety * ratio <= curve[1][0] else math.inf for ratio, n in steps)


def _safety(curve: Curve, steps: Sequence[tuple[float, float]]) -> float:
    """Factor on all stresses at which the damage is 1."""
    from scipy.optimize import brentq  # slow to import

    most = curve[1][0] / max(ratio for ratio, _ in steps)
    if damage(curve, steps, most * (1.0 - 1e-12)) < 1.0:
        return most
    # below the last factor of the curve the damage is 0
    logarithm = brentq(
        lambda x: min(damage(curve, steps, math.exp(x)), 10.0) - 1.0, math.log(1e-6 * most), math.log(most)
    )
    return math.exp(logarithm)


def spectrum_rating(
    curves: tuple[Curve, Curve], loads: Sequence[RatingLoad], ratio: float, used: Used
) -> SpectrumRating | None:
    """Damage of a load spectrum; None without one.

    curves: life curves of pitting and root.
    """
    if not loads:
        return None
    steps = [(*used(load.torque, load.speed), load_cycles(ratio, load.speed, load.hours)) for load in loads]
    members = [[[(float(step[kind][i]), step[2][i]) for step in steps] for i in (0, 1)] for kind in (0, 1)]
    damages, safeties = (
        [as_pair([f(curve, member) for member in both]) for curve, both in zip(curves, members, strict=True)]
        for f in (damage, _safety)
    )
    return SpectrumRating(damages[0], damages[1], safeties[0], safeties[1])


def as_pair(values: Sequence[float] | FloatArray) -> Pair:
    """Values of pinion and gear as plain numbers."""
    return float(values[0]), float(values[1])


def curvature_factor(pair: PairBlank | RatedPair) -> float:
    """K_F0 of ISO 10300 (33) to (35), K_x of AGMA 2003 (21M) to (23M): lengthwise curvature of the teeth."""
    spiral, cone = pair.gear.mean_spiral_angle, pair.gear.mean_cone_distance
    if spiral < 1e-3 or pair.cutter_radius > cone:
        return 1.0
    power = 0.279 / math.log10(math.sin(spiral))
    return float(min(max(0.211 * (pair.cutter_radius / cone) ** power + 0.789, 1.0), 1.15))


def dynamic_factor(pair: PairBlank | RatedPair, speed: float, accuracy_grade: int) -> float:
    """K_v of ISO 10300, Method C, and of AGMA 2003 (13M) to (16M) with Q_v = 16 - grade; pinion speed [rad/s]."""
    rim = 0.5 * speed / pair.ratio * pair.gear.outer_diameter
    exponent = 0.25 * (accuracy_grade - 4.0) ** 0.667
    a = 50.0 + 56.0 * (1.0 - exponent)
    return float((a / (a + math.sqrt(200.0 * rim))) ** -exponent)
