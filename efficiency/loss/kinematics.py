"""Local conditions of lubrication at the loaded contact points."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import model_validator

from efficiency.contact.assembly import Axis as Axis
from efficiency.contact.contact_lines import MeshPosition
from efficiency.ltca.load_distribution import LoadDistribution
from ehl.common.arrays import FloatArray, IntArray
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel, in_any_case, value_range_of
from ehl.fluid.oil import Oil
from ehl.fluid.viscosity import Temperature
from ehl.inputs import SurfaceInput
from ehl.state import ContactState
from ehl.surface.finish import Finish, default_correlation_length, lay_seen
from ehl.uncertainty.spread import DEFAULT, UncertaintyInput

Driver = Literal["pinion", "gear"]

# texture of the flanks: unit and range
TEXTURE = {name: value_range_of(SurfaceInput, name) for name in ("correlation_length", "peklenik_number")}


class OperatingPoint(InputModel):
    """Default operating point."""

    # torque at the pinion shaft [N m]
    torque: Annotated[float, ValueRange("N*m", gt=0.0, le=1e6, hint="Positive at the pinion; coast: `--side coast`.")]
    speed: Annotated[float, ValueRange("rad/s", gt=0.0, le=5000.0)]  # speed of the pinion [rad/s]
    temperature: Temperature  # oil temperature [K]
    oil: Annotated[str, in_any_case("oils")]  # name of an oil card
    driver: Driver = "pinion"  # driving member

    @model_validator(mode="after")
    def _known(self) -> Self:
        Oil.load(self.oil)
        return self


# units and ranges of an operating point given outside the design file
OPERATION_LIMITS: dict[str, ValueRange] = {
    name: value_range_of(OperatingPoint, name) for name in ("torque", "speed", "temperature")
}


@dataclass(frozen=True)
class Operation:
    """Operating conditions of a pair, from values that `efficiency.conditions.conditions` has checked."""

    speed: float  # angular speed [rad/s]
    temperature: float  # oil temperature [K], also at the inlet of the contacts unless `temperature_inlet` is given
    # Rq of the flanks [m]
    roughness_rms_pinion: float = 0.0
    roughness_rms_gear: float = 0.0
    # driving member; with the gear driving, all velocities and the friction forces are reversed at the same points
    driver: Driver = "pinion"
    # bulk temperatures of the teeth [K]; default: oil temperature
    temperature_bulk_pinion: float | None = None
    temperature_bulk_gear: float | None = None
    # oil temperature at the inlet of the contacts [K], if the teeth heat the oil
    temperature_inlet: float | None = None
    # correlation length of the roughness of either flank across the contact line [m]; default: from the finishes,
    # without a finish 40 Rq
    correlation_length: float | None = None
    # correlation length along the contact line over that across it [-]; default: from the finishes and the angle
    # between their lay and the contact line at every point, without a finish 1
    peklenik_number: float | None = None
    # surface finish of the flanks
    finish_pinion: Finish | None = None
    finish_gear: Finish | None = None
    uncertainty: UncertaintyInput = DEFAULT  # spreads of the inputs

    def texture(self, lay_pinion: FloatArray, lay_gear: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Correlation length across the contact line [m] and Peklenik number of both flanks together.

        Correlation lengths of each flank in both directions are from `ehl.surface.finish.lay_seen`; 1/l^2 of the flanks
        is averaged with weights Rq^2, because their slopes add.

        lay_pinion, lay_gear: angle between the lay of each flank and the contact line [rad].
        """
        flanks = (
            (self.roughness_rms_pinion, self.finish_pinion, lay_pinion),
            (self.roughness_rms_gear, self.finish_gear, lay_gear),
        )
        across, along, weight = np.zeros_like(lay_pinion), np.zeros_like(lay_pinion), 0.0
        for rms, finish, angle in flanks:
            if rms == 0.0:
                continue
            own, ratio = float(default_correlation_length(rms)), 1.0
            if finish is not None:
                own, ratio = float(finish.length_at(rms)), finish.lay_ratio.value
            seen, ratio_seen = lay_seen(own, ratio, angle)
            across, along = across + (rms / seen) ** 2, along + (rms / (ratio_seen * seen)) ** 2
            weight += rms**2
        if weight == 0.0:
            across, along, weight = np.full_like(lay_pinion, 1.0), np.full_like(lay_pinion, 1.0), 1e-10
        length = np.sqrt(weight / across)
        gamma = np.maximum(np.sqrt(across / along), 1.0 / 3.0)
        return (
            length if self.correlation_length is None else np.full_like(length, self.correlation_length),
            gamma if self.peklenik_number is None else np.full_like(gamma, self.peklenik_number),
        )

    @property
    def inlet(self) -> float:
        """Oil temperature at the inlet of the contacts [K]."""
        return self.temperature if self.temperature_inlet is None else self.temperature_inlet

    @property
    def bulk(self) -> tuple[float, float]:
        """Bulk temperatures of pinion and gear teeth [K]."""
        pinion, gear = self.temperature_bulk_pinion, self.temperature_bulk_gear
        return self.temperature if pinion is None else pinion, self.temperature if gear is None else gear


@dataclass(frozen=True)
class LoadedPoints:
    """Loaded points of all positions of a mesh cycle, concatenated."""

    state: ContactState  # local conditions; surface 1 is the pinion
    force: FloatArray  # normal force [N]
    speed_sliding: FloatArray  # length of the sliding vector [m/s]
    position: IntArray  # index of the position of each point
    index: IntArray  # index of the point in that position

    def values(self, cycle: Sequence[MeshPosition], name: str) -> FloatArray:
        """Values at the points of an array of the mesh positions."""
        return np.concatenate([getattr(p, name)[self.index[self.position == k]] for k, p in enumerate(cycle)])


def loaded_points(load: LoadDistribution, effective_modulus: float, operation: Operation) -> LoadedPoints:
    """Local conditions at every loaded point.

    Only the sign of the ratio of sliding across the line to entrainment matters; x is directed so that the entrainment
    is positive.

    load: forces over the cycle.
    effective_modulus: E' [Pa].
    operation: speed, oil temperature, roughness.
    Returns: at least one point per position.
    """
    at = load.loaded
    omega = operation.speed
    correlation_length, peklenik_number = operation.texture(at["lay_pinion"], at["lay_gear"])
    state = ContactState.of(
        pressure_hertz=at["pressure_hertz"],
        radius_equivalent=at["radius_equivalent"],
        effective_modulus=effective_modulus,
        speed_entrainment=np.abs(at["entrainment"]) * omega,
        slide_to_roll=at["sliding_across"] / at["entrainment"],
        speed_sliding_lengthwise=at["sliding_along"] * omega,
        temperature_oil=operation.inlet,
        temperature_bulk_1=operation.bulk[0],
        temperature_bulk_2=operation.bulk[1],
        roughness_rms_1=operation.roughness_rms_pinion,
        roughness_rms_2=operation.roughness_rms_gear,
        correlation_length=correlation_length,
        peklenik_number=peklenik_number,
    )
    sliding = np.hypot(at["sliding_across"], at["sliding_along"]) * omega
    return LoadedPoints(state, at["force"], sliding, load.loaded_position, load.loaded_index)
