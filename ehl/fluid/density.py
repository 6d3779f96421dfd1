"""Density laws over temperature and pressure with their derivatives.

Each law is the input table of an oil card; its method `at` gives the law at one temperature (`Compression`) with
`ratio` and `slope`, from which the solvers compute their tables. `ehl.fluid.oil_laws` lists the laws.
"""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from ehl.common.arrays import FloatArray, Values
from ehl.common.units import KELVIN, ValueRange
from ehl.common.validation import InputModel

DOWSON_HIGGINSON = (0.6e-9, 1.7e-9)  # [1/Pa]


def density_at(temperature: Values, density_15: float, coefficient: float) -> Values:
    """Density at ambient pressure, rho15 (1 + a_T (T - 15 degC)) [kg/m3]; `temperature` in K."""
    return density_15 * (1.0 + coefficient * (temperature - KELVIN - 15.0))


def dowson_higginson_1966(
    pressure: FloatArray, a: float = DOWSON_HIGGINSON[0], b: float = DOWSON_HIGGINSON[1]
) -> FloatArray:
    """Dowson-Higginson: rho/rho0 = 1 + a p/(1 + b p) (Dowson & Higginson 1966).

    The variant (5.9e8 + 1.34 p)/(5.9e8 + p) is another function, which differs by 0.8 % at 2 GPa.
    """
    return np.asarray(1.0 + a * pressure / (1.0 + b * pressure))


@dataclass(frozen=True)
class DowsonHigginson:
    """`dowson_higginson_1966` with its constants [1/Pa]; zeros are an incompressible fluid."""

    a: float = DOWSON_HIGGINSON[0]
    b: float = DOWSON_HIGGINSON[1]

    def ratio(self, pressure: FloatArray) -> FloatArray:
        """rho/rho0 at pressures [Pa]."""
        return dowson_higginson_1966(pressure, self.a, self.b)

    def slope(self, pressure: FloatArray) -> FloatArray:
        """d(rho/rho0)/dp [1/Pa]."""
        return np.asarray(self.a / (1.0 + self.b * pressure) ** 2)


@dataclass(frozen=True)
class TaitCompression:
    """rho0/rho = 1 - ln(1 + (1 + K0') p/K0)/(1 + K0') (Tait)."""

    modulus: float  # K0 at the temperature [Pa]
    rate: float  # K0' [-]

    def ratio(self, pressure: FloatArray) -> FloatArray:
        """rho/rho0 at pressures [Pa]."""
        return np.asarray(1.0 / (1.0 - np.log(1.0 + (1.0 + self.rate) * pressure / self.modulus) / (1.0 + self.rate)))

    def slope(self, pressure: FloatArray) -> FloatArray:
        """d(rho/rho0)/dp [1/Pa]."""
        return np.asarray(self.ratio(pressure) ** 2 / (self.modulus + (1.0 + self.rate) * pressure))


@dataclass(frozen=True)
class MurnaghanCompression:
    """rho/rho0 = (1 + K0' p/K0)^(1/K0') (Murnaghan 1944)."""

    modulus: float  # K0 at the temperature [Pa]
    rate: float  # K0' [-]

    def ratio(self, pressure: FloatArray) -> FloatArray:
        """rho/rho0 at pressures [Pa]."""
        return np.asarray((1.0 + self.rate * pressure / self.modulus) ** (1.0 / self.rate))

    def slope(self, pressure: FloatArray) -> FloatArray:
        """d(rho/rho0)/dp [1/Pa]."""
        return np.asarray(self.ratio(pressure) / (self.modulus + self.rate * pressure))


Compression = DowsonHigginson | TaitCompression | MurnaghanCompression  # over pressure at one temperature
DOWSON_HIGGINSON_LAW, INCOMPRESSIBLE = DowsonHigginson(), DowsonHigginson(0.0, 0.0)


class DowsonHigginsonDensity(InputModel):
    """rho/rho0 = 1 + a p/(1 + b p) at every temperature."""

    law: Literal["dowson_higginson"] = "dowson_higginson"
    a: Annotated[float, ValueRange("1/Pa", ge=0.0, le=1e-8)] = DOWSON_HIGGINSON[0]
    b: Annotated[float, ValueRange("1/Pa", ge=0.0, le=1e-7)] = DOWSON_HIGGINSON[1]

    def at(self, temperature: Any) -> Compression:
        """The law at a temperature in K."""
        return DowsonHigginson(self.a, self.b)


class IncompressibleDensity(InputModel):
    """rho = rho0 at every pressure."""

    law: Literal["incompressible"] = "incompressible"

    def at(self, temperature: Any) -> Compression:
        """The law at a temperature in K."""
        return INCOMPRESSIBLE


class _State(InputModel):
    """Bulk modulus K0 = K00 exp(-betaK T), T in K (Fakhreddine & Zoller; Bair), and its rate K0'."""

    K00: Annotated[float, ValueRange("Pa", ge=1e8, le=1e12)]
    betaK: Annotated[float, ValueRange("1/K", ge=0.0, le=0.05)]
    K0_rate: Annotated[float, ValueRange("", ge=2.0, le=30.0)]
    compression: ClassVar[type[TaitCompression | MurnaghanCompression]]

    def at(self, temperature: Any) -> Compression:
        """The law at a temperature in K."""
        return self.compression(self.K00 * np.exp(-self.betaK * temperature), self.K0_rate)


class Tait(_State):
    """Tait's equation over temperature."""

    law: Literal["tait"] = "tait"
    compression = TaitCompression


class Murnaghan(_State):
    """Murnaghan's equation over temperature."""

    law: Literal["murnaghan"] = "murnaghan"
    compression = MurnaghanCompression
