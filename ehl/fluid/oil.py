"""Oil cards: what is known of one oil, and the `Lubricant` it is at a temperature."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from ehl.fluid.density import density_at
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.rheology import RisingStress
from ehl.fluid.viscosity import (
    GOLD_COEFFICIENTS,
    gold_2001,
    vogel_1921,
    vogel_slope,
    walther_1931,
    walther_slope,
)
from ehl.io.data import data_names, data_path
from ehl.io.errors import InputError
from ehl.io.units import KELVIN, ValueRange
from ehl.io.validation import InputModel, read_toml, validate

Array = NDArray[np.float64]
Values = TypeVar("Values", float, Array)

TEMPERATURE_RANGE = (-40.0 + KELVIN, 200.0 + KELVIN)

Temperature = Annotated[
    float,
    ValueRange("K", ge=TEMPERATURE_RANGE[0], le=TEMPERATURE_RANGE[1], hint="Write degrees Celsius as '80 degC'."),
]
KinematicViscosity = Annotated[float, ValueRange("m^2/s", gt=1e-7, le=1.0)]
PressureViscosity = Annotated[float, ValueRange("1/Pa", ge=1e-10, le=1e-7)]


class ModulusViscosity(InputModel):
    """eta = K exp(B/(T + C)) exp(p/(a1 + a2 T + (b1 + b2 T) p)), T in degC (modulus law)."""

    law: Literal["modulus"]
    K: Annotated[float, ValueRange("Pa*s", gt=0.0)]
    B: float
    C: float
    a1: Annotated[float, ValueRange("Pa", gt=0.0)]
    a2: float  # [Pa/K]
    b1: float
    b2: float  # [1/K]


class WaltherViscosity(InputModel):
    """Walther in temperature, Roelands (or Barus) in pressure."""

    law: Literal["roelands", "barus"]


class TabulatedAlpha(InputModel):
    """Pressure-viscosity coefficient at given temperatures; ln alpha is linear between them."""

    law: Literal["table"]
    temperature: tuple[Temperature, ...] = Field(min_length=1)
    value: tuple[PressureViscosity, ...] = Field(min_length=1)


class GoldAlpha(InputModel):
    """Pressure-viscosity coefficient from the kinematic viscosity (Gold), through one measured point if given."""

    law: Literal["gold"]
    base: Literal["mineral", "pao", "polyglycol", "ester"]
    anchor_temperature: Temperature | None = None
    anchor_value: PressureViscosity | None = None


class ModulusAlpha(InputModel):
    """Pressure-viscosity coefficient as the slope of the modulus law at p = 0."""

    law: Literal["modulus"]


class RisingStressInput(InputModel):
    """Eyring stress that rises with pressure (`ehl.fluid.rheology.RisingStress`)."""

    stress_low: Annotated[float, ValueRange("Pa", ge=1e4, le=1e9)]
    stress_slope: Annotated[float, ValueRange("", gt=0.0, le=0.5)]
    pressure_start: Annotated[float, ValueRange("Pa", ge=0.0, le=1e10)]
    pressure_end: Annotated[float, ValueRange("Pa", gt=0.0, le=1e11)]

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if not self.pressure_end > self.pressure_start:
            raise InputError("pressure_end", f"{self.pressure_end:.6g} Pa", "above pressure_start")
        return self

    def law(self) -> RisingStress:
        """tau0 as a function of pressure."""
        return RisingStress(self.stress_low, self.stress_slope, self.pressure_start, self.pressure_end)


class CalibratedValue(InputModel):
    """One parameter fitted to measured friction: SI value, standard error of its logarithm, 95 % interval."""

    value: float
    standard_error: float
    interval_low: float
    interval_high: float
    unit: str = ""


class CalibrationRecord(InputModel):
    """What of a card was calibrated, from what (`mixed-ehl calibrate`); numbers SI."""

    file: str
    file_hash: str
    date: str
    solver_version: str
    card: str
    model: str
    geometry: str
    coating: str = ""
    rows_used: int
    rows_excluded: int
    outliers: tuple[int, ...] = ()
    noise: float
    fitted: dict[str, CalibratedValue]
    undetermined: tuple[str, ...] = ()
    held: dict[str, float] = Field(default_factory=dict)
    conditions: dict[str, tuple[float, float]]
    surface: dict[str, float] = Field(default_factory=dict)


class Oil(InputModel):
    """An oil card (`data/oils/*.toml`). Each figure's source and certainty stand in the file.

    Examples
    --------
    >>> oil = Oil.load("75w90")
    >>> f"{1e6 * oil.viscosity_kinematic(373.15):.1f} cSt"
    '13.3 cSt'
    """

    name: str
    description: str = ""
    source: str
    certainty: Literal["found", "mixed", "from memory"]
    viscosity_kinematic_40: KinematicViscosity
    viscosity_kinematic_100: KinematicViscosity
    base: Literal["mineral", "pao", "polyglycol", "ester"] = "mineral"
    density_15: Annotated[float, ValueRange("kg/m^3", ge=500.0, le=2000.0)]
    density_temperature: Annotated[float, ValueRange("1/K", ge=-2e-3, le=0.0)] = -6.75e-4
    viscosity: Annotated[ModulusViscosity | WaltherViscosity, Field(discriminator="law")]
    pressure_viscosity: Annotated[TabulatedAlpha | GoldAlpha | ModulusAlpha, Field(discriminator="law")]
    limiting_shear_coefficient: Annotated[float, ValueRange("", gt=0.0, le=1.0)]
    eyring_stress: Annotated[float, ValueRange("Pa", ge=1e4, le=1e9)] | None = None
    # left out of the card's hash: formulas fitted with the constant stress stay valid
    eyring_stress_pressure: RisingStressInput | None = Field(default=None, exclude=True)
    thermal_conductivity: Annotated[float, ValueRange("W/(m*K)", gt=0.0, le=10.0)] = 0.14
    heat_capacity: Annotated[float, ValueRange("J/(kg*K)", gt=0.0, le=10000.0)] = 2000.0
    temperature_valid: tuple[Temperature, Temperature] = (20.0 + KELVIN, 150.0 + KELVIN)
    # where figures come from does not change them
    calibration: CalibrationRecord | None = Field(default=None, exclude=True)

    @classmethod
    def load(cls, name: str) -> Oil:
        """A shipped oil by name, or a card of the user by its path ending in .toml.

        Parameters
        ----------
        name : str
            One of `ehl.shipped("oils")`, or a path.

        Returns
        -------
        Oil

        Raises
        ------
        InputError
            There is no such oil or file; the message lists the shipped ones.

        Examples
        --------
        >>> import ehl
        >>> round(ehl.Oil.load("fva3").viscosity_kinematic(313.15) * 1e6)
        97
        """
        return _load_card(name, _changed(name))

    def density(self, temperature: Values) -> Values:
        """Density at ambient pressure [kg/m3]; `temperature` in K."""
        return density_at(temperature, self.density_15, self.density_temperature)

    def viscosity_kinematic(self, temperature: Values) -> Values:
        """Kinematic viscosity at ambient pressure [m2/s]; `temperature` in K."""
        return walther_1931(temperature, self.viscosity_kinematic_40, self.viscosity_kinematic_100)

    def viscosity_dynamic(self, temperature: Values) -> Values:
        """Dynamic viscosity at ambient pressure [Pa s]; `temperature` in K."""
        law = self.viscosity
        if isinstance(law, ModulusViscosity):
            return vogel_1921(temperature, law.K, law.B, law.C)
        return self.viscosity_kinematic(temperature) * self.density(temperature)

    def temperature_viscosity(self, temperature: Values) -> Values:
        """beta = -d ln(eta)/dT at ambient pressure [1/K]; `temperature` in K."""
        law = self.viscosity
        if isinstance(law, ModulusViscosity):
            return vogel_slope(temperature, law.B, law.C)
        # eta = nu rho
        thinning = walther_slope(temperature, self.viscosity_kinematic_40, self.viscosity_kinematic_100)
        return thinning - self.density_temperature * self.density_15 / self.density(temperature)

    def alpha(self, temperature: Values) -> Values:
        """Pressure-viscosity coefficient [1/Pa]; `temperature` in K."""
        law = self.pressure_viscosity
        if isinstance(law, TabulatedAlpha):
            return _between(law, temperature)
        if isinstance(law, GoldAlpha):
            exponent = GOLD_COEFFICIENTS[law.base][1]
            if law.anchor_temperature is not None and law.anchor_value is not None:
                ratio = self.viscosity_kinematic(temperature) / self.viscosity_kinematic(law.anchor_temperature)
                anchored: Values = law.anchor_value * ratio**exponent
                return anchored
            return gold_2001(self.viscosity_kinematic(temperature), law.base)
        assert isinstance(self.viscosity, ModulusViscosity)
        return 1.0 / (self.viscosity.a1 + self.viscosity.a2 * (temperature - KELVIN))

    def at(self, temperature: float | Array) -> Lubricant:
        """The lubricant at an inlet temperature [K]; its fields are arrays where the temperature is one.

        Without a measured Eyring stress, tau0 = 2 Lambda/alpha closes the model
        (Arana, Larranaga & Ulacia 2019).

        Parameters
        ----------
        temperature : float
            [K].

        Returns
        -------
        Lubricant

        Raises
        ------
        InputError
            The temperature is outside -40 to 200 degC.

        Examples
        --------
        >>> import ehl
        >>> ehl.Oil.load("fva3").at(353.15).viscosity_law
        'modulus'
        """
        low, high = TEMPERATURE_RANGE
        values = np.ravel(np.asarray(temperature, dtype=float))
        wrong = values[~((low <= values) & (values <= high))]
        if wrong.size:
            raise InputError(
                "temperature_oil",
                f"{wrong[0]:.6g} K",
                f"{low:.6g} K to {high:.6g} K (-40 to 200 degC)",
                "Write degrees Celsius as '80 degC'.",
            )
        outside = bool(np.any((values < self.temperature_valid[0]) | (values > self.temperature_valid[1])))
        found = self.lubricant(temperature)
        numbers = {name: float(value) for name, value in vars(found).items() if isinstance(value, np.floating)}
        return replace(found, **numbers, extrapolated=outside)  # type: ignore[arg-type]

    def lubricant(self, temperature: Any) -> Lubricant:
        """`at` without its checks, for what only computes like a temperature."""
        law, alpha = self.viscosity, self.alpha(temperature)
        return Lubricant(
            viscosity_inlet=self.viscosity_dynamic(temperature),
            pressure_viscosity=alpha,
            viscosity_law=law.law,
            modulus_constants=(law.a1, law.a2, law.b1, law.b2) if isinstance(law, ModulusViscosity) else (),
            rheology="eyring",
            eyring_stress=self.eyring_stress or 2.0 * self.limiting_shear_coefficient / alpha,
            limiting_shear_coefficient=self.limiting_shear_coefficient,
            temperature=temperature,
            temperature_viscosity=self.temperature_viscosity(temperature),
            temperature_constants=(law.B, law.C) if isinstance(law, ModulusViscosity) else (),
            density=self.density(temperature),
            thermal_conductivity=self.thermal_conductivity,
            heat_capacity=self.heat_capacity,
        )


def _between(law: TabulatedAlpha, temperature: Values) -> Values:
    """Linear in ln alpha between the temperatures of the table, and beyond them with the slope of its ends."""
    if len(law.value) == 1:
        return 0.0 * temperature + law.value[0]
    points = list(zip(law.temperature, (math.log(value) for value in law.value), strict=True))
    pieces = [
        (t1, low + (high - low) / (t1 - t0) * (temperature - t0))
        for (t0, low), (t1, high) in itertools.pairwise(points)
    ]
    log_alpha: Any = pieces[-1][1]
    for end, piece in reversed(pieces[:-1]):
        log_alpha = np.where(temperature <= end, piece, log_alpha)
    alpha: Values = np.exp(log_alpha)
    return alpha


def _changed(name: str) -> int:
    """Time stamp of a card of the user, so that one that was written anew is read anew; 0 for shipped ones."""
    if not name.endswith(".toml"):
        return 0
    try:
        return Path(name).stat().st_mtime_ns
    except OSError:
        return 0


@cache
def _load_card(name: str, changed: int) -> Oil:
    # a sweep asks for the same card once per case
    names = data_names("oils")
    if name.endswith(".toml") and Path(name).is_file():
        return validate(Oil, read_toml(name), name)
    if name not in names:
        raise InputError("oil", name, "one of " + ", ".join(names) + ", or the path of a card ending in .toml")
    return validate(Oil, read_toml(data_path("oils", f"{name}.toml")), f"oils/{name}.toml")
