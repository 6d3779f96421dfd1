"""How well the inputs of a contact are known: default spreads, and those of the user."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

from ehl.fluid.oil import Oil
from ehl.io.errors import InputError
from ehl.io.units import ValueRange
from ehl.io.validation import InputModel

Kind = Literal["relative", "absolute"]


@dataclass(frozen=True)
class Spread:
    """How well a number is known: one standard deviation.

    Parameters
    ----------
    sd : float
        Of the logarithm of a number that is known up to a factor ("relative"), or of the number in SI units
        ("absolute").
    kind : {"relative", "absolute"}
    source : str
        Where it comes from.

    Raises
    ------
    InputError
        It is below 0 or no number.

    Examples
    --------
    >>> round(Spread(0.15).at(0.4e-6, 1.0) * 1e6, 3)
    0.465
    """

    sd: float
    kind: Kind = "relative"
    source: str = "given"

    def __post_init__(self) -> None:
        if not (math.isfinite(self.sd) and self.sd >= 0.0):
            raise InputError("spread", self.sd, "a finite standard deviation of at least 0")

    @classmethod
    def of_range(cls, low: float, high: float, source: str = "given") -> Spread:
        """All values from `low` to `high` equally likely in their logarithm: ln(high/low)/sqrt(12)."""
        if not high >= low > 0.0:
            raise InputError("range", [low, high], "two positive numbers, the lower end first")
        return cls(math.log(high / low) / math.sqrt(12.0), "relative", source)

    def at(self, value: float, score: float) -> float:
        """The value so many standard deviations away."""
        return value * math.exp(score * self.sd) if self.kind == "relative" else value + score * self.sd


BOUNDARY_FILM = Spread.of_range(20e-9, 150e-9, "20 to 150 nm, tribofilms of gear oils in print")
BOUNDARY_FRICTION = Spread.of_range(0.065, 0.13, "0.065 to 0.13 in print")
ROUGHNESS_RMS = Spread(0.15, source="ours")
CORRELATION_LENGTH = Spread.of_range(15e-6, 60e-6, "ours: a factor of 2 either way")
PEKLENIK_NUMBER = Spread.of_range(0.5, 2.0, "ours: a factor of 2 either way")
TEMPERATURE_BULK = Spread(10.0, "absolute", "ours")

Relative = Annotated[
    float, ValueRange("", ge=0.0, le=3.0, hint="One standard deviation of its logarithm: 0.1 is about 10 %.")
]
Kelvins = Annotated[float, ValueRange("K", ge=0.0, le=100.0, hint="One standard deviation.")]

# of oils whose card states none: ours, after the spread of cards of one family
OIL_SPREADS = {
    "pressure_viscosity": Spread(0.12, source="ours: cards state none"),
    "viscosity": Spread(0.05, source="ours: cards state none"),
    "eyring_stress": Spread(0.25, source="ours: cards state none"),
    "limiting_shear": Spread(0.15, source="ours: cards state none"),
    "thermal_conductivity": Spread(0.1, source="ours: cards state none"),
}
SURFACE_SPREADS = {
    "roughness_rms": ROUGHNESS_RMS,
    "correlation_length": CORRELATION_LENGTH,
    "peklenik_number": PEKLENIK_NUMBER,
    "boundary_film": BOUNDARY_FILM,
    "boundary_friction": BOUNDARY_FRICTION,
    "temperature_bulk": TEMPERATURE_BULK,
}
# what has one cause is shown as one
GROUPS = {
    **dict.fromkeys(OIL_SPREADS, "oil"),
    "roughness_rms": "roughness",
    "correlation_length": "roughness",
    "peklenik_number": "roughness",
    "boundary_film": "boundary film",
    "boundary_friction": "boundary friction",
    "temperature_bulk": "bulk temperature",
}


class UncertaintyInput(InputModel):
    """Table [uncertainty]: one standard deviation of each input, in place of those of oil card, finish and program.

    Relative ones are of the logarithm: 0.1 is about 10 %. An input that is known exactly has 0.

    Attributes
    ----------
    pressure_viscosity : float, optional
        Of the rise of ln eta with pressure [-]; of the card by default, as the next four.
    viscosity, eyring_stress, limiting_shear, thermal_conductivity : float, optional
        Of the oil, relative [-].
    roughness_rms, correlation_length, peklenik_number : float, optional
        Of either surface, relative [-].
    boundary_film, boundary_friction : float, optional
        Relative [-].
    temperature_bulk : float, optional
        Of both bodies [K].
    same_surface : bool
        Both surfaces come from one finish, so that the Rq of both is wrong the same way.

    Examples
    --------
    >>> UncertaintyInput(roughness_rms=0.05).spread("roughness_rms").sd
    0.05
    """

    pressure_viscosity: Relative | None = None
    viscosity: Relative | None = None
    eyring_stress: Relative | None = None
    limiting_shear: Relative | None = None
    thermal_conductivity: Relative | None = None
    roughness_rms: Relative | None = None
    correlation_length: Relative | None = None
    peklenik_number: Relative | None = None
    boundary_film: Relative | None = None
    boundary_friction: Relative | None = None
    temperature_bulk: Kelvins | None = None
    same_surface: bool = False

    @classmethod
    def none(cls, **given: float) -> UncertaintyInput:
        """All inputs known exactly, but for those given."""
        return cls(**(dict.fromkeys(GROUPS, 0.0) | given))

    def spread(self, name: str, oil: Oil | None = None) -> Spread:
        """How well an input is known: as given here, by the oil card, or the default."""
        given = getattr(self, name)
        if name in SURFACE_SPREADS:
            default = SURFACE_SPREADS[name]
            return default if given is None else Spread(given, default.kind)
        if given is not None:
            return Spread(given)
        card = getattr(oil, "uncertainty", None)
        return OIL_SPREADS[name] if card is None else Spread(getattr(card, name), source="oil card")


DEFAULT = UncertaintyInput()
