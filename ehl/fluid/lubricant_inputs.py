"""The lubricant in the input file, by numbers or by an oil card, and its shear law."""

import math
from dataclasses import replace
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Discriminator, Field, Tag, field_serializer, field_validator, model_validator

from ehl.common.errors import InputError
from ehl.common.units import ValueRange, value_range
from ehl.common.validation import InputModel, in_any_case, validate
from ehl.fluid import oil_laws
from ehl.fluid.density import DOWSON_HIGGINSON, INCOMPRESSIBLE, Compression, DowsonHigginson
from ehl.fluid.free_volume import Doolittle
from ehl.fluid.lubricant import ASSUMED_CONDUCTIVITY, PAO, FilmConductivity, Lubricant
from ehl.fluid.oil import Oil, lubricant_of
from ehl.fluid.oil_sheet import card_content
from ehl.fluid.pressure_viscosity import AlphaDefinition, roelands_slope, solve_constant
from ehl.fluid.rheology import Limit, Rheology, RisingStress
from ehl.fluid.viscosity import RoelandsLaw, Temperature

Viscosity = Annotated[float, ValueRange("Pa*s", ge=1e-4, le=100.0)]
PressureViscosity = Annotated[float, ValueRange("1/Pa", ge=1e-10, le=5e-8)]
Stress = Annotated[float, ValueRange("Pa", ge=1e5, le=1e9)]
LimitCoefficient = Annotated[float, ValueRange("", gt=0.0, le=1.0)]
Conductivity = Annotated[float, ValueRange("W/(m*K)", gt=0.0, le=10.0)]
RISING_TABLE = "a table with stress_low, stress_slope, pressure_start, pressure_end"
HeatCapacity = Annotated[float, ValueRange("J/(kg*K)", gt=0.0, le=10000.0)]


class ShearInput(InputModel):
    """The shear law; its parameters are required, as unmeasured properties of an oil have no default values."""

    rheology: Rheology = "eyring"
    eyring_stress_law: Literal["constant", "pressure"] | None = None  # default: that of the oil card, or constant
    eyring_stress_pressure: RisingStress | None = None
    carreau_stress: Stress | None = None
    carreau_exponent: Annotated[float, ValueRange("", ge=0.1, le=1.0)] | None = None
    limiting_shear: Limit = "cut"
    limiting_shear_ambient: Annotated[float, ValueRange("Pa", ge=0.0, le=1e8)] | None = None
    shear_modulus: Annotated[float, ValueRange("Pa", ge=1e5, le=1e11)] | None = None

    @model_validator(mode="after")
    def _parameters_of_the_law(self) -> Self:
        if self.rheology == "carreau":
            for name, meaning in (("carreau_stress", "stress G such as '5 MPa'"), ("carreau_exponent", "exponent n")):
                if getattr(self, name) is None:
                    raise InputError(name, None, f"the {meaning} of the oil, with rheology = 'carreau'")
        if self.limiting_shear == "smooth" and not (self.limiting_shear_ambient or 0.0) > 0.0:
            hint = "The limit then acts on the pressure flow, including the inlet, where Lambda p vanishes."
            allowed = "above 0 Pa with limiting_shear = 'smooth'"
            raise InputError("limiting_shear_ambient", self.limiting_shear_ambient, allowed, hint)
        return self

    def shear_figures(self) -> dict[str, Any]:
        """Fields of `Lubricant` from these keys."""
        given: dict[str, Any] = {"rheology": self.rheology, "limiting_shear": self.limiting_shear}
        for name in ("carreau_stress", "carreau_exponent", "limiting_shear_ambient", "shear_modulus"):
            if getattr(self, name) is not None:
                given[name] = getattr(self, name)
        if self.eyring_stress_law == "pressure" and self.eyring_stress_pressure is not None:
            given["eyring_stress"] = self.eyring_stress_pressure
        return given

    def unused_inputs(self) -> list[tuple[str, str]]:
        """Given keys that have no effect with the chosen law, with reasons."""
        given = {name for name in self.model_fields_set if getattr(self, name) is not None}
        idle = []
        if self.rheology != "eyring":
            eyring = ("eyring_stress", "eyring_stress_law", "eyring_stress_pressure")
            idle += [(name, f"rheology is {self.rheology}") for name in eyring if name in given]
        elif self.eyring_stress_law == "pressure" and "eyring_stress" in given:
            idle.append(("eyring_stress", "eyring_stress_law is pressure"))
        elif self.eyring_stress_law != "pressure" and "eyring_stress_pressure" in given:
            idle.append(("eyring_stress_pressure", "eyring_stress_law is not pressure"))
        if self.rheology != "carreau":
            carreau = ("carreau_stress", "carreau_exponent")
            idle += [(name, f"rheology is {self.rheology}") for name in carreau if name in given]
        return idle


class DirectLubricant(ShearInput):
    """A lubricant given by its properties at the inlet temperature.

    Either eta0 and alpha with a law of one constant (Roelands, Barus), or the table `viscosity` with the constants of a
    law, as in an oil card. With the table eta0 is optional, and alpha scales the increase with pressure.
    """

    viscosity_inlet: Viscosity | None = None
    pressure_viscosity: PressureViscosity | None = None
    alpha_definition: AlphaDefinition | None = None
    viscosity_law: Literal["roelands", "barus"] = "roelands"
    viscosity: Annotated[oil_laws.ViscosityByConstants, Field(discriminator="law")] | None = None
    pressure_rise_factor: Annotated[float, ValueRange("", ge=0.2, le=5.0)] = 1.0
    pressure_valid: Annotated[float, ValueRange("Pa", ge=1e7, le=1e10)] | None = None
    density_law: Literal["incompressible", "dowson_higginson"] = "dowson_higginson"
    density_coefficients: tuple[float, float] = DOWSON_HIGGINSON
    density_pressure: oil_laws.DensityInput | None = None
    eyring_stress: Stress = 5e6
    limiting_shear_coefficient: LimitCoefficient | None = None
    temperature_oil: Temperature = 353.15
    temperature_viscosity: Annotated[float, ValueRange("1/K", ge=0.0, le=0.2)] = 0.03
    density: Annotated[float, ValueRange("kg/m^3", ge=500.0, le=2000.0)] = 850.0
    thermal_conductivity: Conductivity = 0.14
    conductivity_pressure: FilmConductivity | None = None
    heat_capacity: HeatCapacity = 2000.0

    @model_validator(mode="before")
    @classmethod
    def _numbers_or_constants(cls, values: Any) -> Any:
        if isinstance(values, dict) and values.get("viscosity") is None:
            for name, kind in (("viscosity_inlet", Viscosity), ("pressure_viscosity", PressureViscosity)):
                if values.get(name) is None:
                    hint = "Alternatively give a table viscosity with the constants."
                    raise InputError(name, None, value_range(kind).expected(), hint)
        return values

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if self.rheology == "eyring" and self.eyring_stress_law == "pressure" and self.eyring_stress_pressure is None:
            raise InputError("eyring_stress_pressure", None, RISING_TABLE, "eyring_stress_law is 'pressure'.")
        if self.viscosity is not None:
            oil_laws.check_rising(self.viscosity, (self.temperature_oil,), self.pressure_valid)
        limit_keys = self.limiting_shear == "smooth" or self.limiting_shear_ambient is not None
        if limit_keys and self.limiting_shear_coefficient is None:
            raise InputError("limiting_shear_coefficient", None, "Lambda of tau_L = tau_L0 + Lambda p, above 0 to 1")
        return self

    def lubricant(self) -> Lubricant:
        """The lubricant at the inlet temperature."""
        limit = self.limiting_shear_coefficient
        plain: Compression = DowsonHigginson(*self.density_coefficients)
        if self.density_law == "incompressible":
            plain = INCOMPRESSIBLE
        density: dict[str, Any] = {"compression": plain} | oil_laws.compression_of(
            self.density_pressure, self.viscosity, self.temperature_oil
        )
        found = Lubricant(
            **self._viscosity_figures(),
            pressure_rise_factor=self.pressure_rise_factor,
            pressure_valid=self.pressure_valid or math.inf,
            eyring_stress=self.eyring_stress,
            limiting_shear_coefficient=math.inf if limit is None else limit,
            temperature=self.temperature_oil,
            density=self.density,
            thermal_conductivity=self.thermal_conductivity,
            heat_capacity=self.heat_capacity,
            film_conductivity=self.conductivity_pressure or PAO,
            **density,
        )
        return replace(found, **self.shear_figures())

    def _viscosity_figures(self) -> dict[str, Any]:
        law, definition = self.viscosity, self.alpha_definition or "slope"
        if law is not None:
            scale = oil_laws.scale_of_law(law, self.temperature_oil, self.pressure_viscosity, definition)
            figures = oil_laws.figures_by_constants(law, self.temperature_oil, scale)
            figures = {name: float(v) if isinstance(v, np.generic | np.ndarray) else v for name, v in figures.items()}
            return figures if self.viscosity_inlet is None else figures | {"viscosity_inlet": self.viscosity_inlet}
        assert self.viscosity_inlet is not None
        assert self.pressure_viscosity is not None
        slope = self.pressure_viscosity
        if self.viscosity_law == "roelands" and definition == "secant_200":
            slope = roelands_slope(slope, self.viscosity_inlet)
        elif self.viscosity_law == "roelands" and definition != "slope":
            slope = solve_constant(
                lambda alpha: RoelandsLaw(self.viscosity_inlet, alpha, self.temperature_oil, 0.0),  # type: ignore[arg-type]
                self.pressure_viscosity,
                definition,
                self.pressure_viscosity,
            )
        return {
            "viscosity_inlet": self.viscosity_inlet,
            "pressure_viscosity": float(slope),
            "viscosity_law": self.viscosity_law,
            "temperature_viscosity": self.temperature_viscosity,
        }

    def unused_inputs(self) -> list[tuple[str, str]]:
        """Given keys that have no effect with the chosen laws, with reasons."""
        idle = super().unused_inputs()
        if self.viscosity is not None:
            own = {"viscosity_law", "temperature_viscosity"} & self.model_fields_set
            idle += [(name, f"viscosity.law is {self.viscosity.law}") for name in sorted(own)]
        if self.density_pressure is not None or isinstance(self.viscosity, Doolittle):
            own = {"density_law", "density_coefficients"} & self.model_fields_set
            idle += [(name, "density_pressure or the viscosity law determines the density") for name in sorted(own)]
        elif self.density_law == "incompressible" and "density_coefficients" in self.model_fields_set:
            idle.append(("density_coefficients", "density_law is incompressible"))
        return idle

    def remarks(self) -> tuple[str, ...]:
        """Notes on assumptions of these inputs."""
        silent = self.pressure_viscosity is not None and self.alpha_definition is None and self.viscosity_law != "barus"
        assumed = self.conductivity_pressure is None
        undefined = oil_laws.NO_DEFINITION.format(where="lubricant.pressure_viscosity")
        return (undefined,) * silent + (ASSUMED_CONDUCTIVITY,) * assumed


class OilLubricant(ShearInput):
    """An oil at a temperature; shear law and thermal properties may be overridden."""

    instead = dict.fromkeys(
        ("viscosity_inlet", "viscosity", "pressure_viscosity", "alpha_definition", "temperature_viscosity", "density"),
        "The oil card determines it: change the card, or omit oil and give viscosity_inlet and pressure_viscosity.",
    )
    oil: Annotated[str, in_any_case("oils")] | Oil
    temperature_oil: Temperature
    eyring_stress: Stress | None = None
    limiting_shear_coefficient: LimitCoefficient | None = None
    thermal_conductivity: Conductivity | None = None
    heat_capacity: HeatCapacity | None = None

    @field_serializer("oil")
    def _as_content(self, oil: str | Oil) -> Any:
        return card_content(oil) if isinstance(oil, Oil) else oil

    @field_validator("oil", mode="before")
    @classmethod
    def _from_content(cls, oil: Any) -> Any:
        if isinstance(oil, dict):
            return validate(Oil, oil)
        if not isinstance(oil, str | Oil):
            raise InputError("", oil, "a name, the path of a card, an Oil or the content of a card")
        return oil

    @model_validator(mode="after")
    def _known(self) -> Self:
        card = Oil.load(self.oil)
        law = self.eyring_stress_law if self.rheology == "eyring" else None
        if law == "pressure" and (self.eyring_stress_pressure or card.eyring_stress_pressure) is None:
            raise InputError("eyring_stress_pressure", None, RISING_TABLE, f"The card of {card.name} contains none.")
        if law == "constant" and not (self.eyring_stress or card.eyring_stress):
            hint = (
                f"The card of {card.name} contains none; its stress increases with pressure like that of the base oil."
            )
            raise InputError("eyring_stress", None, "a stress such as '8 MPa', with a constant law", hint)
        return self

    def remarks(self) -> tuple[str, ...]:
        """Notes on assumptions of the oil card."""
        return Oil.load(self.oil).remarks()

    def lubricant(self, temperature: Any = None) -> Lubricant:
        """The lubricant at the inlet temperature, or at other temperatures [K] (scalar or array)."""
        card = Oil.load(self.oil)
        names = ("eyring_stress", "limiting_shear_coefficient", "thermal_conductivity", "heat_capacity")
        given: dict[str, Any] = {name: getattr(self, name) for name in names if getattr(self, name) is not None}
        if "limiting_shear_coefficient" in given:
            given["limiting_shear_ambient"] = 0.0  # the value of the oil card belongs to its coefficient
        rising = self.eyring_stress_pressure or card.eyring_stress_pressure
        if self.eyring_stress_law == "pressure" and rising is not None:
            given["eyring_stress"] = rising
        found = lubricant_of(self.oil, self.temperature_oil if temperature is None else temperature)
        # the viscosity is that of the oil card
        return replace(found, **(given | self.shear_figures())).with_alpha_film(found.pressure_viscosity_film)


def _lubricant_kind(value: Any) -> str:
    keys = value if isinstance(value, dict) else getattr(value, "model_fields_set", ())
    return "card" if "oil" in keys else "direct"


LubricantInput = Annotated[
    Annotated[OilLubricant, Tag("card")] | Annotated[DirectLubricant, Tag("direct")], Discriminator(_lubricant_kind)
]
