"""How well the inputs of a contact are known: by oil card, finish and additives, or as the user says."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import PrivateAttr

from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel
from ehl.fluid.oil import Oil
from ehl.fluid.oil_uncertainty import VARIABLES
from ehl.surface.finish import HALF_RANGE, Figure, surface_uncertainty

Kind = Literal["relative", "absolute"]


@dataclass(frozen=True)
class Spread:
    """How well a number is known: one standard deviation.

    Raises `InputError`: it is below 0 or no number.

    Examples
    --------
    >>> round(Spread(0.15).at(0.4e-6, 1.0) * 1e6, 3)
    0.465
    """

    # of the logarithm of a number that is known up to a factor ("relative"), or of the number in SI units ("absolute")
    sd: float
    kind: Kind = "relative"
    source: str = "given"  # where it comes from
    sd_below: float | None = None  # to lower values, where that differs

    def __post_init__(self) -> None:
        for sd in (self.sd, self.below):
            if not (math.isfinite(sd) and sd >= 0.0):
                raise InputError("spread", sd, "a finite standard deviation of at least 0")

    @classmethod
    def of_figure(cls, figure: Figure) -> Spread:
        """Of a positive figure with its central 90 % range."""
        up, down = (math.log(end) / HALF_RANGE for end in (figure.high / figure.value, figure.value / figure.low))
        return cls(up, "relative", figure.source, down)

    @property
    def below(self) -> float:
        """Standard deviation to lower values."""
        return self.sd if self.sd_below is None else self.sd_below

    @property
    def known(self) -> bool:
        """Whether the number is known exactly."""
        return self.sd == 0.0 and self.below == 0.0

    def shift(self, score: float) -> float:
        """Change of the logarithm, or of the number, so many standard deviations away."""
        return score * (self.sd if score > 0.0 else self.below)

    def at(self, value: Any, score: float) -> Any:
        """The value so many standard deviations away."""
        return value * math.exp(self.shift(score)) if self.kind == "relative" else value + self.shift(score)


# the teeth are rarely as warm as the oil or a heat balance says
TEMPERATURE_BULK = Spread(10.0, "absolute", "ours")
# of hardened steel, 30 +- 10 W/(m K): 21 (through-hardened bearing steel) to 46 (annealed) were found, from memory
CONDUCTIVITY_SOLID = Spread(0.30, source="hardened steel, 21 to 46 W/(m K)")

# standard deviation of ln mu of the lateral mode against solutions with two-dimensional roughness (docs/roughness.md),
# and the smooth film ratio above which it falls as its inverse square, as the effect of roughness does
LATERAL_MODE, LATERAL_RATIO = 0.08, 1.0
LATERAL_CAUSE = "rough_contact_model"

Relative = Annotated[
    float, ValueRange("", ge=0.0, le=3.0, hint="One standard deviation of its logarithm: 0.1 is about 10 %.")
]
Kelvins = Annotated[float, ValueRange("K", ge=0.0, le=100.0, hint="One standard deviation.")]

SURFACE = ("roughness_rms", "correlation_length", "peklenik_number", "boundary_film", "boundary_friction")
# what has one cause is shown as one
GROUPS = {
    **dict.fromkeys(VARIABLES, "oil"),
    "roughness_rms": "roughness",
    "correlation_length": "roughness",
    "peklenik_number": "roughness",
    "boundary_film": "boundary film",
    LATERAL_CAUSE: "roughness",
    "boundary_friction": "boundary friction",
    "temperature_bulk": "bulk temperature",
    "conductivity_solid": "steel",
}


class UncertaintyInput(InputModel):
    """Table [uncertainty]: one standard deviation of each input, in place of those of oil card, finish and program.

    Relative ones are of the logarithm: 0.1 is about 10 %. An input that is known exactly has 0.

    Examples
    --------
    >>> UncertaintyInput(roughness_rms=0.05).spread("roughness_rms").sd
    0.05
    """

    # of the rise of ln eta with pressure [-]; of the card by default, as the next four
    pressure_viscosity: Relative | None = None
    # of the oil, relative [-]
    viscosity: Relative | None = None
    eyring_stress: Relative | None = None
    limiting_shear: Relative | None = None
    thermal_conductivity: Relative | None = None
    # of either surface, relative [-]
    roughness_rms: Relative | None = None
    correlation_length: Relative | None = None
    peklenik_number: Relative | None = None
    # relative [-]
    boundary_film: Relative | None = None
    boundary_friction: Relative | None = None
    # of mu by the model of two-dimensional roughness where asperities touch, relative [-]
    rough_contact_model: Relative | None = None
    temperature_bulk: Kelvins | None = None  # of both bodies [K]
    conductivity_solid: Relative | None = None  # thermal conductivity of both bodies, relative [-]
    # both surfaces were made alike, so that the Rq of both is wrong the same way; by default where a finish is named
    same_surface: bool | None = None
    _figures: Mapping[str, Figure] = PrivateAttr(default_factory=dict)
    _finish: str | None = PrivateAttr(default=None)

    @classmethod
    def none(cls, **given: float) -> UncertaintyInput:
        """All inputs known exactly, but for those given."""
        return cls(**(dict.fromkeys(GROUPS, 0.0) | given))

    def of_surface(self, **surface: Any) -> Self:
        """The same with the ranges of a surface; keywords as of `ehl.surface.finish.surface_uncertainty`."""
        found = self.model_copy()
        found._figures, found._finish = surface_uncertainty(**surface), surface.get("finish")
        return found

    @property
    def shared_rms(self) -> bool:
        """Whether the Rq of both surfaces has one cause."""
        return self._finish is not None if self.same_surface is None else self.same_surface

    def spread(self, name: str, oil: Oil | None = None) -> Spread:
        """How well an input is known: as given here, by oil card, finish and additives, or the default."""
        given = getattr(self, name)
        if name == "temperature_bulk":
            return TEMPERATURE_BULK if given is None else Spread(given, "absolute")
        if given is not None:
            return Spread(given)
        if name == LATERAL_CAUSE:
            return Spread(LATERAL_MODE, source="against solutions with two-dimensional roughness")
        if name == "conductivity_solid":
            return CONDUCTIVITY_SOLID
        if name in SURFACE:
            return Spread.of_figure((self._figures or _UNNAMED)[name])
        if oil is None:
            raise InputError("oil", None, "an oil, whose card says how well its figures are known")
        return Spread(getattr(oil.uncertainty, name), source="oil card")


def lateral_spread(film_ratio: Any, sd: float) -> Any:
    """Standard deviation of ln mu by the model of two-dimensional roughness at smooth film ratios [-]."""
    return sd * np.minimum((LATERAL_RATIO / np.maximum(film_ratio, LATERAL_RATIO)) ** 2, 1.0)


# figures do not matter where only their ratios are asked for
_UNNAMED = surface_uncertainty(roughness_rms=1e-6)
DEFAULT = UncertaintyInput()
