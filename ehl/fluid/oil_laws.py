"""Laws of the oil as tables of a card or of the input file: viscosity, its pressure coefficient, density."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from ehl.common.errors import InputError
from ehl.common.units import KELVIN, ValueRange
from ehl.common.validation import InputModel
from ehl.fluid.conductivity import CONDUCTIVITY_FAMILIES, FilmConductivity
from ehl.fluid.density import Murnaghan, Tait
from ehl.fluid.free_volume import Doolittle, McEwenPaluch
from ehl.fluid.pressure_viscosity import AlphaDefinition, solve_constant
from ehl.fluid.viscosity import (
    AbsoluteLaw,
    ModulusLaw,
    RelativeLaw,
    ScaledAbsoluteRise,
    ScaledRise,
    vogel_1921,
    vogel_slope,
)
from ehl.fluid.yasutomi import Yasutomi

TEMPERATURE_RANGE = (-40.0 + KELVIN, 200.0 + KELVIN)

Temperature = Annotated[
    float,
    ValueRange("K", ge=TEMPERATURE_RANGE[0], le=TEMPERATURE_RANGE[1], hint="Write degrees Celsius as '80 degC'."),
]
AlphaValue = Annotated[float, ValueRange("1/Pa", ge=1e-10, le=1e-7)]
GlassTemperature = Annotated[float, ValueRange("K", ge=100.0, le=400.0, hint="Write degrees Celsius as '-72 degC'.")]
PerPressure = Annotated[float, ValueRange("1/Pa", gt=0.0, le=1e-6)]
DynamicViscosity = Annotated[float, ValueRange("Pa*s", gt=0.0)]
Positive = Annotated[float, ValueRange("", gt=0.0, le=1e3)]
Difference = Annotated[float, ValueRange("K", gt=0.0, le=1e4)]
Expansion = Annotated[float, ValueRange("1/K", ge=-0.1, le=0.1)]


class ModulusViscosity(InputModel):
    """eta = K exp(B/(T + C)) exp(p/(a1 + a2 T + (b1 + b2 T) p)), T in degC (modulus law)."""

    law: Literal["modulus"]
    K: Annotated[float, ValueRange("Pa*s", gt=0.0)]
    B: Annotated[float, ValueRange("K", ge=-1e6, le=1e6)]
    C: Annotated[float, ValueRange("K", ge=-1e4, le=1e4)]
    a1: Annotated[float, ValueRange("Pa", gt=0.0)]
    a2: float  # [Pa/K]
    b1: float
    b2: float  # [1/K]


class WaltherViscosity(InputModel):
    """Walther in temperature, Roelands (or Barus) in pressure."""

    law: Literal["roelands", "barus"]


class ImprovedYasutomi(InputModel):
    """`ehl.fluid.yasutomi.Yasutomi`, improved form: F = (1 + b1 p)^b2."""

    law: Literal["yasutomi_improved"]
    viscosity_glass: DynamicViscosity = 1e12
    Tg0: GlassTemperature
    A1: Difference
    A2: PerPressure
    b1: PerPressure
    b2: Annotated[float, ValueRange("", ge=-2.0, lt=0.0)]
    C1: Positive
    C2: Difference

    def absolute(self) -> AbsoluteLaw:
        """The law."""
        glass = self.Tg0 - KELVIN
        return Yasutomi(self.viscosity_glass, glass, self.A1, self.A2, self.b1, self.b2, self.C1, self.C2)


class OriginalYasutomi(InputModel):
    """`ehl.fluid.yasutomi.Yasutomi`, original form: F = 1 - B1 ln(1 + B2 p)."""

    law: Literal["yasutomi_original"]
    viscosity_glass: DynamicViscosity = 1e12
    Tg0: GlassTemperature
    A1: Difference
    A2: PerPressure
    B1: Positive
    B2: PerPressure
    C1: Positive
    C2: Difference

    def absolute(self) -> AbsoluteLaw:
        """The law."""
        glass = self.Tg0 - KELVIN
        return Yasutomi(self.viscosity_glass, glass, self.A1, self.A2, self.B1, self.B2, self.C1, self.C2, True)


class StateEquation(InputModel):
    """Density under pressure by Tait or Murnaghan, K0 = K00 exp(-betaK T), T in K."""

    law: Literal["tait", "murnaghan"]
    K00: Annotated[float, ValueRange("Pa", ge=1e8, le=1e12)]
    betaK: Annotated[float, ValueRange("1/K", ge=0.0, le=0.05)]
    K0_rate: Annotated[float, ValueRange("", ge=2.0, le=30.0)]

    def state(self) -> Tait | Murnaghan:
        """The law over temperature."""
        return (Tait if self.law == "tait" else Murnaghan)(self.K00, self.betaK, self.K0_rate)


class DowsonHigginsonDensity(InputModel):
    """rho/rho0 = 1 + a p/(1 + b p)."""

    law: Literal["dowson_higginson"]
    a: Annotated[float, ValueRange("1/Pa", ge=0.0, le=1e-8)] = 0.6e-9
    b: Annotated[float, ValueRange("1/Pa", ge=0.0, le=1e-7)] = 1.7e-9


class IncompressibleDensity(InputModel):
    """rho = rho0 at every pressure."""

    law: Literal["incompressible"]


class DoolittleViscosity(InputModel):
    """`ehl.fluid.free_volume.Doolittle` with its equation of state."""

    law: Literal["doolittle"]
    viscosity_reference: DynamicViscosity
    temperature_reference: Temperature
    B: Positive
    R0: Annotated[float, ValueRange("", gt=0.0, lt=0.9)]
    epsilon: Expansion
    volume_expansion: Expansion
    state: StateEquation

    def absolute(self) -> AbsoluteLaw:
        """The law."""
        return Doolittle(
            self.viscosity_reference,
            self.temperature_reference,
            self.B,
            self.R0,
            self.epsilon,
            self.volume_expansion,
            self.state.state(),
        )


class McEwenPaluchViscosity(InputModel):
    """`ehl.fluid.free_volume.McEwenPaluch`; temperatures in degC, a0 and pinf at 40 degC."""

    law: Literal["mcewen_paluch"]
    K: DynamicViscosity
    B: float
    C: float
    a0: AlphaValue
    a0_fall: Expansion = 0.0
    q: Positive
    CF: Annotated[float, ValueRange("", ge=0.0, le=1e3)]
    pinf: Annotated[float, ValueRange("Pa", ge=1e8, le=1e12)]
    pinf_rise: Annotated[float, ValueRange("Pa/K", ge=0.0, le=1e9)] = 0.0

    def absolute(self) -> AbsoluteLaw:
        """The law."""
        return McEwenPaluch((self.K, self.B, self.C), self.a0, self.a0_fall, self.q, self.CF, self.pinf, self.pinf_rise)


AbsoluteViscosity = ImprovedYasutomi | OriginalYasutomi | DoolittleViscosity | McEwenPaluchViscosity
ViscosityByConstants = ModulusViscosity | AbsoluteViscosity
ViscosityInput = Annotated[ViscosityByConstants | WaltherViscosity, Field(discriminator="law")]
DensityInput = Annotated[StateEquation | DowsonHigginsonDensity | IncompressibleDensity, Field(discriminator="law")]


class ConductivityInput(InputModel):
    """`FilmConductivity` by its constants, or by the name of a family of oils."""

    c1: Annotated[float, ValueRange("1/Pa", ge=0.0, le=1e-8)]
    c2: Annotated[float, ValueRange("1/Pa", ge=0.0, le=1e-8)]

    @model_validator(mode="before")
    @classmethod
    def _of_a_family(cls, values: Any) -> Any:
        if not isinstance(values, str):
            return values
        if values not in CONDUCTIVITY_FAMILIES:
            allowed = "one of " + ", ".join(CONDUCTIVITY_FAMILIES) + "; or a table with c1 and c2"
            raise InputError("conductivity_pressure", values, allowed)
        return vars(CONDUCTIVITY_FAMILIES[values])

    def law(self) -> FilmConductivity:
        """k/k0 over pressure."""
        return FilmConductivity(self.c1, self.c2)


def conductivity_figures(given: ConductivityInput | None) -> dict[str, Any]:
    """The field of `Lubricant` for the growth of the conductivity, where it is given."""
    return {} if given is None else {"film_conductivity": given.law()}


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
    "{where} does not say what its alpha means: taken as the slope at p = 0, as before; "
    "write alpha_definition = 'slope' to keep it, 'secant_200' for a figure of Gold's formula, FVA 400 or ISO/TR 15144"
)


def density_figures(
    density: StateEquation | DowsonHigginsonDensity | IncompressibleDensity | None,
    viscosity: ViscosityByConstants | WaltherViscosity | None,
    temperature: Any,
) -> dict[str, Any]:
    """The fields of `Lubricant` for a density law; that of a free-volume law is its equation of state."""
    if density is None and isinstance(viscosity, DoolittleViscosity):
        density = viscosity.state
    if density is None:
        return {}
    if isinstance(density, StateEquation):
        coefficients = (density.state().modulus(temperature), density.K0_rate)
        return {"density_law": density.law, "density_coefficients": coefficients}
    if isinstance(density, DowsonHigginsonDensity):
        return {"density_law": density.law, "density_coefficients": (density.a, density.b)}
    return {"density_law": density.law}


def law_by_constants(law: ViscosityByConstants, temperature: Any) -> ModulusLaw | RelativeLaw:
    """The law under pressure at an inlet temperature [K]."""
    if isinstance(law, ModulusViscosity):
        return ModulusLaw((law.a1, law.a2, law.b1, law.b2), temperature, (law.B, law.C))
    return RelativeLaw(law.absolute(), temperature)


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
    own = law.absolute()
    absolute = own if scale == 1.0 else ScaledAbsoluteRise(own, scale)
    ambient = 0.0 * temperature
    return {
        "viscosity_law": law.law,
        "viscosity_inlet": np.exp(absolute.log_viscosity(ambient, temperature)),
        "pressure_viscosity": absolute.by_pressure(ambient, temperature),
        "temperature_viscosity": -absolute.by_temperature(ambient, temperature),
        "absolute_law": absolute,
    }
