"""The laws of an oil that a card or the input file names: viscosity, its pressure coefficient, density."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from ehl.common.errors import InputError
from ehl.common.units import KELVIN
from ehl.common.validation import InputModel
from ehl.fluid.density import DowsonHigginsonDensity, IncompressibleDensity, Murnaghan, Tait
from ehl.fluid.free_volume import Doolittle, McEwenPaluch
from ehl.fluid.pressure_viscosity import AlphaDefinition, solve_constant
from ehl.fluid.viscosity import (
    AbsoluteLaw,
    AlphaValue,
    ModulusLaw,
    ModulusViscosity,
    RelativeLaw,
    ScaledAbsoluteRise,
    ScaledRise,
    Temperature,
    WaltherViscosity,
    vogel_1921,
    vogel_slope,
)
from ehl.fluid.yasutomi import ImprovedYasutomi, OriginalYasutomi

# a new law is one class in a file of its own and its name here
AbsoluteViscosity = ImprovedYasutomi | OriginalYasutomi | Doolittle | McEwenPaluch
ViscosityByConstants = ModulusViscosity | AbsoluteViscosity
ViscosityInput = Annotated[ViscosityByConstants | WaltherViscosity, Field(discriminator="law")]
DensityInput = Annotated[Tait | Murnaghan | DowsonHigginsonDensity | IncompressibleDensity, Field(discriminator="law")]


def compression_of(density: Any, viscosity: Any, temperature: Any) -> dict[str, Any]:
    """The field of `Lubricant` for a density law, where one is given; that of a free-volume law is its own."""
    law = viscosity.state if density is None and isinstance(viscosity, Doolittle) else density
    return {} if law is None else {"compression": law.at(temperature)}


class StatedAlpha(InputModel):
    """A pressure-viscosity coefficient that is stated: which of the four it is.

    Without it the value is taken as the slope at p = 0, as files before this key were.
    """

    alpha_definition: AlphaDefinition | None = None

    @model_serializer(mode="wrap")
    def _without_none(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        # the hash of a card is that of its text: cards without the key keep theirs
        content: dict[str, Any] = handler(self)
        if self.alpha_definition is None:
            content.pop("alpha_definition", None)
        return content


class TabulatedAlpha(StatedAlpha):
    """Pressure-viscosity coefficient at given temperatures; ln alpha is linear between them."""

    law: Literal["table"]
    temperature: tuple[Temperature, ...] = Field(min_length=1)
    value: tuple[AlphaValue, ...] = Field(min_length=1)


class GoldAlpha(StatedAlpha):
    """Pressure-viscosity coefficient from the kinematic viscosity (Gold), through one measured point if given."""

    law: Literal["gold"]
    base: Literal["mineral", "pao", "polyglycol", "ester"]
    anchor_temperature: Temperature | None = None
    anchor_value: AlphaValue | None = None


class ModulusAlpha(StatedAlpha):
    """The coefficient that the constants of the viscosity law give.

    With an anchor the whole of ln(eta(p)/eta0) is multiplied by one factor, such that the coefficient has this value
    at this temperature.
    """

    law: Literal["modulus", "constants"]
    anchor_temperature: Temperature | None = None
    anchor_value: AlphaValue | None = None

    @model_serializer(mode="wrap")
    def _without_anchor(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return {key: value for key, value in handler(self).items() if value is not None}

    @model_validator(mode="after")
    def _anchored(self) -> Self:
        stated = (self.anchor_temperature, self.anchor_value, self.alpha_definition)
        if any(value is not None for value in stated) and any(value is None for value in stated):
            raise InputError(
                "anchor_value",
                self.anchor_value,
                "anchor_temperature, anchor_value and alpha_definition, all three or none",
            )
        return self


AlphaInput = Annotated[TabulatedAlpha | GoldAlpha | ModulusAlpha, Field(discriminator="law")]

NO_DEFINITION = (
    "{where} does not say what its alpha means: taken as the slope at p = 0; "
    "write alpha_definition = 'slope' to keep it, 'secant_200' for a figure of Gold's formula, FVA 400 or ISO/TR 15144"
)


def law_by_constants(law: ViscosityByConstants, temperature: Any) -> ModulusLaw | RelativeLaw:
    """The law under pressure at an inlet temperature [K]."""
    if isinstance(law, ModulusViscosity):
        return ModulusLaw((law.a1, law.a2, law.b1, law.b2), temperature, (law.B, law.C))
    return RelativeLaw(law, temperature)


KNOWN_PRESSURE = 0.5e9  # up to here at least a law must hold where the card does not say [Pa]
_LEAST_SLOPE = 1e-10  # [1/Pa]


def check_rising(law: ViscosityByConstants, temperatures: tuple[float, ...], pressure: float | None) -> None:
    """Refuse constants with which the viscosity falls with pressure, stays, or has a pole up to a pressure [Pa].

    Raises
    ------
    InputError
        Naming temperature and pressure.
    """
    pressures = np.linspace(0.0, pressure or KNOWN_PRESSURE, 101)
    for temperature in temperatures:
        slope = law_by_constants(law, temperature).by_pressure(pressures)
        wrong = ~(slope > _LEAST_SLOPE)
        if isinstance(law, ModulusViscosity):
            low, bend = law.a1 + law.a2 * (temperature - KELVIN), law.b1 + law.b2 * (temperature - KELVIN)
            wrong |= low + bend * pressures <= 0.0
        if wrong.any():
            raise InputError(
                "viscosity.law",
                law.law,
                f"constants with which the viscosity rises with pressure up to {pressures[-1] / 1e9:.3g} GPa; at "
                f"{temperature - KELVIN:.4g} degC it does not at {pressures[wrong][0] / 1e9:.3g} GPa",
                "Correct the constants, or state the pressure they hold to as pressure_valid.",
            )


def scale_of_law(
    law: ViscosityByConstants, temperature: float, alpha: float | None, definition: AlphaDefinition
) -> float:
    """The factor on ln(eta(p)/eta0) with which a law has a stated coefficient at a temperature [K]; 1 without it."""
    if alpha is None:
        return 1.0
    own = law_by_constants(law, temperature)
    return float(solve_constant(lambda factor: ScaledRise(own, factor), alpha, definition, 1.0))


def figures_by_constants(law: ViscosityByConstants, temperature: Any, scale: float) -> dict[str, Any]:
    """The fields of `Lubricant` for a law by constants at an inlet temperature [K], its rise multiplied by `scale`."""
    if isinstance(law, ModulusViscosity):
        moduli = tuple(value / scale for value in (law.a1, law.a2, law.b1, law.b2))
        return {
            "viscosity_law": law.law,
            "viscosity_inlet": vogel_1921(temperature, law.K, law.B, law.C),
            "pressure_viscosity": 1.0 / (moduli[0] + moduli[1] * (temperature - KELVIN)),
            "temperature_viscosity": vogel_slope(temperature, law.B, law.C),
            "modulus_constants": moduli,
            "temperature_constants": (law.B, law.C),
        }
    absolute: AbsoluteLaw = law if scale == 1.0 else ScaledAbsoluteRise(law, scale)
    ambient = 0.0 * temperature
    return {
        "viscosity_law": law.law,
        "viscosity_inlet": np.exp(absolute.log_viscosity(ambient, temperature)),
        "pressure_viscosity": absolute.by_pressure(ambient, temperature),
        "temperature_viscosity": -absolute.by_temperature(ambient, temperature),
        "absolute_law": absolute,
    }
