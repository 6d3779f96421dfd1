"""Viscosity laws over temperature and pressure with their derivatives.

Temperature laws give eta or nu at ambient pressure. Pressure laws give L = ln(eta(p, T)/eta0), where eta0 is the
viscosity at ambient pressure and inlet temperature. They consist of ufuncs and arithmetic, so that they apply to floats
and arrays and can be exported as code. The compiled solvers interpolate L in a table (`ehl.fluid.lookup`). Input tables
of the laws have their constants and uncertainty; `ehl.fluid.oil_laws` lists them.
"""

import math
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, Protocol

import numpy as np

from ehl.common.arrays import FloatArray, Values
from ehl.common.units import KELVIN, ValueRange
from ehl.common.validation import InputModel

TEMPERATURE_RANGE = (-40.0 + KELVIN, 200.0 + KELVIN)

Temperature = Annotated[float, ValueRange("K", ge=TEMPERATURE_RANGE[0], le=TEMPERATURE_RANGE[1])]
AlphaValue = Annotated[float, ValueRange("1/Pa", ge=1e-10, le=1e-7)]
DynamicViscosity = Annotated[float, ValueRange("Pa*s", gt=0.0)]
Positive = Annotated[float, ValueRange("", gt=0.0, le=1e3)]
Expansion = Annotated[float, ValueRange("1/K", ge=-0.1, le=0.1)]
ROELANDS_PRESSURE = 1.96e8  # p0 [Pa]
ROELANDS_LOG_VISCOSITY = 9.67  # -ln of the common viscosity of all curves, 6.31e-5 Pa s
ROELANDS_TEMPERATURE = 138.0  # [K]

_LAST_BEFORE_POLE = 0.9  # share of the pressure at the pole of a modulus law above which the tangent is used

# (s, t) of Gold's formula by base oil; nu in cSt, alpha in 1/GPa
GOLD_COEFFICIENTS: dict[str, tuple[float, float]] = {
    "mineral": (9.904, 0.1390),
    "pao": (7.382, 0.1335),
    "polyglycol": (5.489, 0.1485),
    "ester": (6.605, 0.1360),
}

# tuned: default standard deviation of ln(eta/eta0) (own estimate). The Roelands law with the measured slope or secant
# deviates by -19 to +13 % at 0.8 GPa over seven oils
ROELANDS_DEVIATION = 0.12
# tuned: difference of two published sets of constants for one oil, FVA 3: 6 to 9 % at 0.8 GPa
MODULUS_DEVIATION = 0.08
# tuned: free-volume and glass-transition laws fitted to viscometer data up to 1 GPa
MEASURED_DEVIATION = 0.05


def walther_1931(temperature: Values, viscosity_40: float, viscosity_100: float) -> Values:
    """Kinematic viscosity at any temperature from its values at 40 and 100 degC.

    log10 log10(nu + 0.7) = m - n log10 T, nu in cSt, T in K (Walther 1931; ASTM D341).

    temperature: temperature [K].
    viscosity_40, viscosity_100: kinematic viscosity at 40 and 100 degC [m2/s].
    Returns kinematic viscosity [m2/s].
    """
    m, n = _walther_constants(viscosity_40, viscosity_100)
    viscosity: Values = (10.0 ** (10.0 ** (m - n * np.log10(temperature))) - 0.7) * 1e-6
    return viscosity


def walther_slope(temperature: Values, viscosity_40: float, viscosity_100: float) -> Values:
    """-d ln(nu)/dT of `walther_1931` [1/K] with the same arguments: n (nu + 0.7) ln(nu + 0.7)/(nu T), nu in cSt."""
    _, n = _walther_constants(viscosity_40, viscosity_100)
    nu = 1e6 * walther_1931(temperature, viscosity_40, viscosity_100)
    slope: Values = n * (nu + 0.7) * np.log(nu + 0.7) / (nu * temperature)
    return slope


def _walther_constants(viscosity_40: float, viscosity_100: float) -> tuple[float, float]:
    """m and n of the line through both viscosities."""
    double_40, double_100 = (math.log10(math.log10(nu * 1e6 + 0.7)) for nu in (viscosity_40, viscosity_100))
    low, high = math.log10(40.0 + KELVIN), math.log10(100.0 + KELVIN)
    slope = (double_40 - double_100) / (high - low)
    return double_40 + slope * low, slope


def vogel_1921(temperature: Values, scale: float, rise: float, shift: float) -> Values:
    """Dynamic viscosity K exp(B/(T + C)) [Pa s] at a temperature in K; K in Pa s, B and C in K for T in degC."""
    viscosity: Values = scale * np.exp(rise / (temperature - KELVIN + shift))
    return viscosity


def vogel_slope(temperature: Values, rise: float, shift: float) -> Values:
    """-d ln(eta)/dT of `vogel_1921` [1/K]."""
    return rise / (temperature - KELVIN + shift) ** 2


def gold_2001(viscosity_kinematic: Values, base: str) -> Values:
    """Pressure-viscosity coefficient alpha = s nu^t 1e-9 [1/Pa], nu in cSt (Gold et al. 2001).

    viscosity_kinematic: at the temperature of the coefficient [m2/s].
    base: base oil, a key of `GOLD_COEFFICIENTS`.
    """
    scale, exponent = GOLD_COEFFICIENTS[base]
    alpha: Values = scale * (viscosity_kinematic * 1e6) ** exponent * 1e-9
    return alpha


@dataclass(frozen=True)
class BarusLaw:
    """L = alpha p - beta (T - T0) (Barus 1893); fields may be arrays."""

    alpha: float  # [1/Pa]
    temperature: float  # T0 [K]
    beta: float  # [1/K]

    def log_ratio(self, pressure: FloatArray, temperature: FloatArray | None = None) -> FloatArray:
        """L at pressures [Pa] and temperatures [K]; at the inlet temperature where none are given."""
        rise = self.alpha * pressure
        return rise if temperature is None else rise - self.beta * (temperature - self.temperature)

    def by_pressure(self, pressure: FloatArray) -> FloatArray:
        """dL/dp [1/Pa] at the inlet temperature."""
        return np.asarray(self.alpha + 0.0 * pressure)

    def by_temperature(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """dL/dT [1/K]."""
        return np.full(np.broadcast(pressure, temperature).shape, -self.beta)


@dataclass(frozen=True)
class RoelandsLaw:
    """L = A ((1 + p/p0)^z ((T - 138)/(T0 - 138))^-s0 - 1) (Roelands 1966); fields may be arrays.

    A = ln eta0 + 9.67, z = alpha p0/A, s0 = beta (T0 - 138)/A, p0 = 1.96e8 Pa.
    """

    viscosity: float  # eta0 [Pa s]
    alpha: float  # [1/Pa]
    temperature: float  # T0 [K]
    beta: float  # [1/K]

    def log_ratio(self, pressure: FloatArray, temperature: FloatArray | None = None) -> FloatArray:
        """L at pressures [Pa] and temperatures [K]; at the inlet temperature where none are given."""
        height = np.log(self.viscosity) + ROELANDS_LOG_VISCOSITY
        growth = (1.0 + pressure / ROELANDS_PRESSURE) ** (self.alpha * ROELANDS_PRESSURE / height)
        if temperature is not None:
            span = self.temperature - ROELANDS_TEMPERATURE
            relative = np.maximum(temperature - ROELANDS_TEMPERATURE, 1.0) / span
            growth = growth * relative ** (-self.beta * span / height)
        return np.asarray(height * (growth - 1.0))

    def by_pressure(self, pressure: FloatArray) -> FloatArray:
        """dL/dp [1/Pa] at the inlet temperature."""
        exponent = self.alpha * ROELANDS_PRESSURE / (np.log(self.viscosity) + ROELANDS_LOG_VISCOSITY)
        return np.asarray(self.alpha * (1.0 + pressure / ROELANDS_PRESSURE) ** (exponent - 1.0))

    def by_temperature(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """dL/dT [1/K]."""
        height = np.log(self.viscosity) + ROELANDS_LOG_VISCOSITY
        exponent = self.beta * (self.temperature - ROELANDS_TEMPERATURE) / height
        level = height + self.log_ratio(pressure, temperature)
        return np.asarray(-level * exponent / np.maximum(temperature - ROELANDS_TEMPERATURE, 1.0))


@dataclass(frozen=True)
class ModulusLaw:
    """L = p/(a1 + a2 T + (b1 + b2 T) p) + ln(eta0(T)/eta0), T in degC (FVA 400; Arana, Larranaga & Ulacia 2019).

    For negative b1 + b2 T there is a pole at p = -(a1 + a2 T)/(b1 + b2 T); above 0.9 of that pressure L is continued by
    its tangent (own choice).
    """

    constants: tuple[float, ...]  # a1 [Pa], a2 [Pa/K], b1 [-], b2 [1/K]
    temperature: float  # T0 [K]
    vogel: tuple[float, ...] = ()  # (B, C) of `vogel_1921` for eta0(T) [K]; empty for exp(-beta (T - T0))
    beta: float = 0.0  # [1/K]; used without `vogel`

    @property
    def numbers(self) -> FloatArray:
        """The law for `ehl.heat._kernels.modulus_viscosity`."""
        ambient = (*self.vogel, 0.0) if self.vogel else (0.0, math.inf, self.beta)
        return np.array([*self.constants, self.temperature, *ambient, _LAST_BEFORE_POLE, KELVIN])

    def log_ratio(self, pressure: FloatArray, temperature: FloatArray | None = None) -> FloatArray:
        """L at pressures [Pa] and temperatures [K]; at the inlet temperature where none are given."""
        rise, _ = self._rise(pressure, self.temperature if temperature is None else temperature)
        return np.asarray(rise if temperature is None else rise + self._thinning(temperature))

    def by_pressure(self, pressure: FloatArray) -> FloatArray:
        """dL/dp [1/Pa] at the inlet temperature."""
        return np.asarray(self._rise(pressure, self.temperature)[1])

    def by_temperature(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """dL/dT [1/K]."""
        _, a2, _, b2 = self.constants
        low, stiffening = self._moduli(temperature)
        thinning = vogel_slope(temperature, *self.vogel) if self.vogel else self.beta
        pole = low / np.maximum(-stiffening, 1e-30)
        inside = np.minimum(pressure, _LAST_BEFORE_POLE * pole)
        modulus = low + stiffening * inside
        within = -inside * (a2 + b2 * inside) / modulus**2
        # on the tangent L = g(y)/|B| with y = p/pole: both g and 1/|B| depend on temperature
        rise, slope = self._rise(pressure, temperature)
        bent = np.minimum(stiffening, -1e-30)
        beyond = slope * pressure * (b2 / bent - a2 / low) - rise * b2 / bent
        return np.asarray(np.where(pressure > inside, beyond, within) - thinning)

    def _rise(self, pressure: FloatArray, temperature: FloatArray | float) -> tuple[FloatArray, FloatArray]:
        """p/(A + B p) and its slope."""
        low, stiffening = self._moduli(temperature)
        inside = np.minimum(pressure, _LAST_BEFORE_POLE * low / np.maximum(-stiffening, 1e-30))
        modulus = low + stiffening * inside
        slope = low / modulus**2
        return inside / modulus + slope * (pressure - inside), slope

    def _moduli(self, temperature: FloatArray | float) -> tuple[FloatArray | float, FloatArray | float]:
        a1, a2, b1, b2 = self.constants
        celsius = temperature - KELVIN
        return a1 + a2 * celsius, b1 + b2 * celsius

    def _thinning(self, temperature: FloatArray) -> FloatArray:
        if not self.vogel:
            return -self.beta * (temperature - self.temperature)
        rise, shift = self.vogel
        return rise / (temperature - KELVIN + shift) - rise / (self.temperature - KELVIN + shift)


class ModulusViscosity(InputModel):
    """eta = K exp(B/(T + C)) exp(p/(a1 + a2 T + (b1 + b2 T) p)), T in degC (modulus law)."""

    deviation: ClassVar[float] = MODULUS_DEVIATION
    law: Literal["modulus"] = "modulus"
    K: Annotated[float, ValueRange("Pa*s", gt=0.0)]
    B: Annotated[float, ValueRange("K", ge=-1e6, le=1e6)]
    C: Annotated[float, ValueRange("K", ge=-1e4, le=1e4)]
    a1: Annotated[float, ValueRange("Pa", gt=0.0)]
    a2: float  # [Pa/K]
    b1: float
    b2: float  # [1/K]


class WaltherViscosity(InputModel):
    """Walther law over temperature, Roelands (or Barus) law over pressure."""

    deviation: ClassVar[float] = ROELANDS_DEVIATION
    law: Literal["roelands", "barus"]


def pole_growth(place: FloatArray, last: float) -> tuple[FloatArray, FloatArray]:
    """g = y/(1 - y) and dg/dy of laws with a pole at y = 1, continued by the tangent above y = `last` (own choice)."""
    inside = np.minimum(place, last)
    slope = 1.0 / (1.0 - inside) ** 2
    return inside / (1.0 - inside) + slope * (place - inside), slope


class AbsoluteLaw(Protocol):
    """A law of eta over pressure and temperature with constants of the oil."""

    def log_viscosity(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """ln eta, eta in Pa s, at pressures [Pa] and temperatures [K]."""

    def by_pressure(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """d ln eta/dp [1/Pa]."""

    def by_temperature(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """d ln eta/dT [1/K]."""


@dataclass(frozen=True)
class RelativeLaw:
    """L = ln eta(p, T) - ln eta(0, T0) of an `AbsoluteLaw`."""

    law: AbsoluteLaw
    temperature: float  # T0 [K]; may be an array

    def log_ratio(self, pressure: FloatArray, temperature: FloatArray | None = None) -> FloatArray:
        """L at pressures [Pa] and temperatures [K]; at the inlet temperature where none are given."""
        warm: Any = self.temperature if temperature is None else temperature
        at_inlet: Any = self.temperature
        return np.asarray(self.law.log_viscosity(pressure, warm) - self.law.log_viscosity(0.0 * pressure, at_inlet))

    def by_pressure(self, pressure: FloatArray) -> FloatArray:
        """dL/dp [1/Pa] at the inlet temperature."""
        at_inlet: Any = self.temperature
        return self.law.by_pressure(pressure, at_inlet)

    def by_temperature(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """dL/dT [1/K]."""
        return self.law.by_temperature(pressure, temperature)


@dataclass(frozen=True)
class ScaledRise:
    """A law with a factor on its increase with pressure: L(0, T) + factor (L(p, T) - L(0, T))."""

    law: BarusLaw | RoelandsLaw | ModulusLaw | RelativeLaw
    factor: float  # [-]; may be an array

    def log_ratio(self, pressure: FloatArray, temperature: FloatArray | None = None) -> FloatArray:
        """L at pressures [Pa] and temperatures [K]; at the inlet temperature where none are given."""
        if temperature is None:
            return np.asarray(self.factor * self.law.log_ratio(pressure))
        ambient = self.law.log_ratio(0.0 * pressure, temperature)
        return np.asarray(ambient + self.factor * (self.law.log_ratio(pressure, temperature) - ambient))

    def by_pressure(self, pressure: FloatArray) -> FloatArray:
        """dL/dp [1/Pa] at the inlet temperature."""
        return np.asarray(self.factor * self.law.by_pressure(pressure))

    def by_temperature(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """dL/dT [1/K]."""
        ambient = self.law.by_temperature(0.0 * pressure, temperature)
        return np.asarray(ambient + self.factor * (self.law.by_temperature(pressure, temperature) - ambient))


PressureLaw = BarusLaw | RoelandsLaw | ModulusLaw | RelativeLaw | ScaledRise
