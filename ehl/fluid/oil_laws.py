"""Laws of an oil in cards and input files: viscosity, pressure-viscosity coefficient, density; their uncertainty."""

import math
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ehl.common.errors import InputError
from ehl.common.units import KELVIN, ValueRange
from ehl.common.validation import InputModel
from ehl.fluid import viscosity as viscosity_laws
from ehl.fluid.density import DowsonHigginsonDensity, IncompressibleDensity, Murnaghan, Tait
from ehl.fluid.free_volume import Doolittle, ImprovedYasutomi, McEwenPaluch, OriginalYasutomi
from ehl.fluid.pressure_viscosity import AlphaDefinition, solve_constant

# register of the viscosity and density laws
AbsoluteViscosity = ImprovedYasutomi | OriginalYasutomi | Doolittle | McEwenPaluch
ViscosityByConstants = viscosity_laws.ModulusViscosity | AbsoluteViscosity
ViscosityInput = Annotated[ViscosityByConstants | viscosity_laws.WaltherViscosity, Field(discriminator="law")]
DensityInput = Annotated[Tait | Murnaghan | DowsonHigginsonDensity | IncompressibleDensity, Field(discriminator="law")]


def compression_of(density: Any, viscosity: Any, temperature: Any) -> dict[str, Any]:
    """Field of `Lubricant` for the density law, if any; a free-volume law has its own."""
    law = viscosity.state if density is None and isinstance(viscosity, Doolittle) else density
    return {} if law is None else {"compression": law.at(temperature)}


class StatedAlpha(InputModel):
    """Definition of a given pressure-viscosity coefficient; default: the slope at p = 0."""

    alpha_definition: AlphaDefinition | None = None


class TabulatedAlpha(StatedAlpha):
    """Pressure-viscosity coefficient at given temperatures, with linear interpolation of ln alpha."""

    law: Literal["table"]
    temperature: tuple[viscosity_laws.Temperature, ...] = Field(min_length=1)
    value: tuple[viscosity_laws.AlphaValue, ...] = Field(min_length=1)


class GoldAlpha(StatedAlpha):
    """Pressure-viscosity coefficient from the kinematic viscosity (Gold), scaled to one measured value if given."""

    law: Literal["gold"]
    base: Literal["mineral", "pao", "polyglycol", "ester"]
    anchor_temperature: viscosity_laws.Temperature | None = None
    anchor_value: viscosity_laws.AlphaValue | None = None


class ModulusAlpha(StatedAlpha):
    """Pressure-viscosity coefficient from the constants of the viscosity law.

    With an anchor a factor on ln(eta(p)/eta0) gives the coefficient the given value at the given temperature.
    """

    law: Literal["modulus", "constants"]
    anchor_temperature: viscosity_laws.Temperature | None = None
    anchor_value: viscosity_laws.AlphaValue | None = None

    @model_validator(mode="after")
    def _anchored(self) -> Self:
        stated = (self.anchor_temperature, self.anchor_value, self.alpha_definition)
        if any(value is not None for value in stated) and any(value is None for value in stated):
            allowed = "anchor_temperature, anchor_value and alpha_definition, all three or none"
            raise InputError("anchor_value", self.anchor_value, allowed)
        return self


AlphaInput = Annotated[TabulatedAlpha | GoldAlpha | ModulusAlpha, Field(discriminator="law")]

NO_DEFINITION = (
    "{where} has no definition of alpha: the slope at p = 0 is assumed; "
    "set alpha_definition = 'slope' to confirm it, or 'secant_200' for Gold's formula, FVA 400 or ISO/TR 15144"
)


def law_by_constants(
    law: ViscosityByConstants, temperature: Any
) -> viscosity_laws.ModulusLaw | viscosity_laws.RelativeLaw:
    """Pressure law at an inlet temperature [K]."""
    if isinstance(law, viscosity_laws.ModulusViscosity):
        return viscosity_laws.ModulusLaw((law.a1, law.a2, law.b1, law.b2), temperature, (law.B, law.C))
    return viscosity_laws.RelativeLaw(law, temperature)


KNOWN_PRESSURE = 0.5e9  # default of the pressure up to which a law must be valid [Pa]
_LEAST_SLOPE = 1e-10  # [1/Pa]


def check_rising(law: ViscosityByConstants, temperatures: tuple[float, ...], pressure: float | None) -> None:
    """Check that the viscosity increases with pressure without a pole up to a pressure [Pa].

    Raises `InputError`: it does not; the message states temperature and pressure.
    """
    pressures = np.linspace(0.0, pressure or KNOWN_PRESSURE, 101)
    for temperature in temperatures:
        slope = law_by_constants(law, temperature).by_pressure(pressures)
        wrong = ~(slope > _LEAST_SLOPE)
        if isinstance(law, viscosity_laws.ModulusViscosity):
            low, bend = law.a1 + law.a2 * (temperature - KELVIN), law.b1 + law.b2 * (temperature - KELVIN)
            wrong |= low + bend * pressures <= 0.0
        if wrong.any():
            allowed = (
                f"constants with which the viscosity increases with pressure up to {pressures[-1] / 1e9:.3g} GPa; at "
                f"{temperature - KELVIN:.4g} degC it does not at {pressures[wrong][0] / 1e9:.3g} GPa"
            )
            hint = "Correct the constants, or give their highest valid pressure as pressure_valid."
            raise InputError("viscosity.law", law.law, allowed, hint)


def scale_of_law(
    law: ViscosityByConstants, temperature: float, alpha: float | None, definition: AlphaDefinition
) -> float:
    """Factor on ln(eta(p)/eta0) that gives a law the coefficient `alpha` at a temperature [K]; 1 without `alpha`."""
    if alpha is None:
        return 1.0
    own = law_by_constants(law, temperature)
    return float(solve_constant(lambda factor: viscosity_laws.ScaledRise(own, factor), alpha, definition, 1.0))


def figures_by_constants(law: ViscosityByConstants, temperature: Any, scale: float) -> dict[str, Any]:
    """Fields of `Lubricant` for a law at an inlet temperature [K], with the factor `scale` on ln(eta(p)/eta0)."""
    if isinstance(law, viscosity_laws.ModulusViscosity):
        moduli = tuple(value / scale for value in (law.a1, law.a2, law.b1, law.b2))
        return {
            "viscosity_law": law.law,
            "viscosity_inlet": viscosity_laws.vogel_1921(temperature, law.K, law.B, law.C),
            "pressure_viscosity": 1.0 / (moduli[0] + moduli[1] * (temperature - KELVIN)),
            "temperature_viscosity": viscosity_laws.vogel_slope(temperature, law.B, law.C),
            "modulus_constants": moduli,
            "temperature_constants": (law.B, law.C),
        }
    ambient = 0.0 * temperature
    return {
        "viscosity_law": law.law,
        "viscosity_inlet": np.exp(law.log_viscosity(ambient, temperature)),
        "pressure_viscosity": scale * law.by_pressure(ambient, temperature),
        "temperature_viscosity": -law.by_temperature(ambient, temperature),
        "absolute_law": law,
        "absolute_scale": scale,
    }


Deviation = Annotated[float, ValueRange("", ge=0.0, le=1.0, hint="One standard deviation, relative: 0.08 is 8 %.")]
Factor = Annotated[float, ValueRange("", gt=0.0, le=100.0)]

VARIABLES = ("pressure_viscosity", "viscosity", "eyring_stress", "limiting_shear", "thermal_conductivity")

# tuned: of ln(eta/eta0) of FVA 400 oils about Gold's formula for the secant at 0.2 GPa (own evaluation)
GOLD_DEVIATION = {"mineral": 0.07, "hydrocracked": 0.08, "pao": 0.17, "polyglycol": 0.17, "ester": 0.12}
MEMORY_DEVIATION = 0.15


class CardUncertainty(InputModel):
    """Relative standard deviations of the inputs of a card."""

    pressure_viscosity: Deviation  # of ln(eta/eta0), equal for all pressures and temperatures
    viscosity: Deviation  # of eta0
    eyring_stress: Deviation
    limiting_shear: Deviation
    thermal_conductivity: Deviation
    source: str


class InputFactors(InputModel):
    """Factors on the inputs of a card."""

    pressure_viscosity: Factor = 1.0  # on ln(eta/eta0)
    viscosity: Factor = 1.0
    eyring_stress: Factor = 1.0
    limiting_shear: Factor = 1.0
    thermal_conductivity: Factor = 1.0


def standard_uncertainty(
    law: ViscosityByConstants | viscosity_laws.WaltherViscosity, gold: str | None, certainty: str
) -> dict[str, Any]:
    """Default uncertainty of a card (own estimate).

    law: viscosity over pressure.
    gold: base oil, if the pressure-viscosity coefficient is from Gold's formula without a measured value.
    certainty: of the card.
    """
    memory, spread = certainty == "unverified", law.deviation
    if isinstance(law, viscosity_laws.WaltherViscosity):
        spread = math.hypot(spread, 0.0 if gold is None else GOLD_DEVIATION.get(gold, 0.17))
    if memory:
        spread = math.hypot(spread, MEMORY_DEVIATION)
    return {
        "pressure_viscosity": round(spread, 3),
        "viscosity": 0.10 if memory else 0.05,
        # tau0 from k T/V and from 2 Lambda/alpha(p, T) differ by a factor of 1.4 to 2.3 at 1 GPa; the published law of
        # a PAO is 2.8 times the latter (docs/shear.md)
        "eyring_stress": 0.40,
        "limiting_shear": 0.25 if memory else 0.20,
        "thermal_conductivity": 0.10,
        "source": f"Estimated from the viscosity law of the card ({law.law}) and the origin of its values.",
    }
