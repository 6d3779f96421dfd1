"""The lubricant in the input file: by its numbers or by an oil card, and its shear law."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Tag, model_validator

from ehl.fluid.density import DOWSON_HIGGINSON
from ehl.fluid.lubricant import DensityLaw, Lubricant
from ehl.fluid.oil import Oil, RisingStressInput, Temperature
from ehl.fluid.rheology import Limit, Rheology
from ehl.io.errors import InputError
from ehl.io.units import ValueRange
from ehl.io.validation import InputModel

Viscosity = Annotated[float, ValueRange("Pa*s", ge=1e-4, le=100.0)]
PressureViscosity = Annotated[float, ValueRange("1/Pa", ge=1e-10, le=5e-8)]
Stress = Annotated[float, ValueRange("Pa", ge=1e5, le=1e9)]
LimitCoefficient = Annotated[float, ValueRange("", gt=0.0, le=1.0)]
Conductivity = Annotated[float, ValueRange("W/(m*K)", gt=0.0, le=10.0)]
RISING_TABLE = "a table with stress_low, stress_slope, pressure_start, pressure_end"
HeatCapacity = Annotated[float, ValueRange("J/(kg*K)", gt=0.0, le=10000.0)]


class ShearInput(InputModel):
    """The shear law. Nothing is assumed for what an oil has not been measured for: a law asks for its parameters."""

    rheology: Rheology = "eyring"
    eyring_stress_law: Literal["constant", "pressure"] = "constant"
    eyring_stress_pressure: RisingStressInput | None = None
    carreau_stress: Stress | None = None
    carreau_exponent: Annotated[float, ValueRange("", ge=0.1, le=1.0)] | None = None
    limiting_shear: Limit = "cut"
    limiting_shear_ambient: Annotated[float, ValueRange("Pa", ge=0.0, le=1e8)] | None = None

    @model_validator(mode="after")
    def _parameters_of_the_law(self) -> Self:
        if self.rheology == "carreau":
            for name, meaning in (("carreau_stress", "stress G such as '5 MPa'"), ("carreau_exponent", "exponent n")):
                if getattr(self, name) is None:
                    raise InputError(name, None, f"the {meaning} of the oil, with rheology = 'carreau'")
        if self.limiting_shear == "smooth" and not (self.limiting_shear_ambient or 0.0) > 0.0:
            raise InputError(
                "limiting_shear_ambient",
                self.limiting_shear_ambient,
                "above 0 Pa with limiting_shear = 'smooth'",
                "The limit acts on the pressure flow there, also in the inlet where Lambda p vanishes.",
            )
        return self

    def shear_figures(self) -> dict[str, Any]:
        """What these keys say of the fields of `Lubricant`."""
        given: dict[str, Any] = {"rheology": self.rheology, "limiting_shear": self.limiting_shear}
        for name in ("carreau_stress", "carreau_exponent", "limiting_shear_ambient"):
            if getattr(self, name) is not None:
                given[name] = getattr(self, name)
        if self.eyring_stress_law == "pressure" and self.eyring_stress_pressure is not None:
            given["eyring_stress"] = self.eyring_stress_pressure.law()
        return given

    def unused_inputs(self) -> list[tuple[str, str]]:
        """Given keys that the chosen law does not use, and why."""
        given = {name for name in self.model_fields_set if getattr(self, name) is not None}
        idle = []
        if self.rheology != "eyring":
            eyring = ("eyring_stress", "eyring_stress_law", "eyring_stress_pressure")
            idle += [(name, f"rheology is {self.rheology}") for name in eyring if name in given]
        elif self.eyring_stress_law == "pressure" and "eyring_stress" in given:
            idle.append(("eyring_stress", "eyring_stress_law is pressure"))
        elif self.eyring_stress_law == "constant" and "eyring_stress_pressure" in given:
            idle.append(("eyring_stress_pressure", "eyring_stress_law is constant"))
        if self.rheology != "carreau":
            carreau = ("carreau_stress", "carreau_exponent")
            idle += [(name, f"rheology is {self.rheology}") for name in carreau if name in given]
        return idle


class DirectLubricant(ShearInput):
    """A lubricant given by its numbers at the inlet temperature."""

    viscosity_inlet: Viscosity
    pressure_viscosity: PressureViscosity
    viscosity_law: Literal["roelands", "barus"] = "roelands"
    density_law: DensityLaw = "dowson_higginson"
    density_coefficients: tuple[float, float] = DOWSON_HIGGINSON
    eyring_stress: Stress = 5e6
    limiting_shear_coefficient: LimitCoefficient | None = None
    temperature_oil: Temperature = 353.15
    temperature_viscosity: Annotated[float, ValueRange("1/K", ge=0.0, le=0.2)] = 0.03
    density: Annotated[float, ValueRange("kg/m^3", ge=500.0, le=2000.0)] = 850.0
    thermal_conductivity: Conductivity = 0.14
    heat_capacity: HeatCapacity = 2000.0

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if self.rheology == "eyring" and self.eyring_stress_law == "pressure" and self.eyring_stress_pressure is None:
            raise InputError("eyring_stress_pressure", None, RISING_TABLE, "eyring_stress_law is 'pressure'.")
        limit_keys = self.limiting_shear == "smooth" or self.limiting_shear_ambient is not None
        if limit_keys and self.limiting_shear_coefficient is None:
            raise InputError("limiting_shear_coefficient", None, "Lambda of tau_L = tau_L0 + Lambda p, above 0 to 1")
        return self

    def lubricant(self) -> Lubricant:
        """The numbers the solvers take."""
        limit = self.limiting_shear_coefficient
        plain = Lubricant(
            viscosity_inlet=self.viscosity_inlet,
            pressure_viscosity=self.pressure_viscosity,
            viscosity_law=self.viscosity_law,
            density_law=self.density_law,
            density_coefficients=self.density_coefficients,
            eyring_stress=self.eyring_stress,
            limiting_shear_coefficient=math.inf if limit is None else limit,
            temperature=self.temperature_oil,
            temperature_viscosity=self.temperature_viscosity,
            density=self.density,
            thermal_conductivity=self.thermal_conductivity,
            heat_capacity=self.heat_capacity,
        )
        return replace(plain, **self.shear_figures())


class OilLubricant(ShearInput):
    """An oil card at a temperature; shear law and thermal figures may be overridden."""

    oil: str
    temperature_oil: Temperature
    eyring_stress: Stress | None = None
    limiting_shear_coefficient: LimitCoefficient | None = None
    thermal_conductivity: Conductivity | None = None
    heat_capacity: HeatCapacity | None = None

    @model_validator(mode="after")
    def _known(self) -> Self:
        card = Oil.load(self.oil)
        if self.rheology == "eyring" and self.eyring_stress_law == "pressure" and self._rising_stress(card) is None:
            raise InputError("eyring_stress_pressure", None, RISING_TABLE, f"The card of {self.oil} has none.")
        return self

    def _rising_stress(self, card: Oil) -> RisingStressInput | None:
        return self.eyring_stress_pressure or card.eyring_stress_pressure

    def lubricant(self) -> Lubricant:
        """The numbers the solvers take."""
        card = Oil.load(self.oil)
        names = ("eyring_stress", "limiting_shear_coefficient", "thermal_conductivity", "heat_capacity")
        given = {name: getattr(self, name) for name in names if getattr(self, name) is not None}
        rising = self._rising_stress(card)
        if self.eyring_stress_law == "pressure" and rising is not None:
            given["eyring_stress"] = rising.law()
        return replace(card.at(self.temperature_oil), **(given | self.shear_figures()))


def _lubricant_kind(value: Any) -> str:
    keys = value if isinstance(value, dict) else getattr(value, "model_fields_set", ())
    return "card" if "oil" in keys else "direct"


LubricantInput = Annotated[
    Annotated[OilLubricant, Tag("card")] | Annotated[DirectLubricant, Tag("direct")],
    Discriminator(_lubricant_kind),
]
