"""Yasutomi viscosity law of the distance from the glass transition (Yasutomi, Bair & Winer 1984; Bair 2007)."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Annotated, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from ehl.common.arrays import FloatArray
from ehl.common.units import KELVIN, ValueRange
from ehl.common.validation import InputModel
from ehl.fluid.viscosity import MEASURED_DEVIATION, DynamicViscosity, pole_growth

LAST_DEPTH = 0.5  # share of the way from the glass transition to the pole above which the tangent is used
_REST = 2e-13  # slope where the original form would decrease, so that ln eta remains monotone [1/Pa]
_GRID = np.linspace(0.0, 6e9, 301)  # pressures for the largest viscosity of the original form [Pa]
_TEMPERATURES = np.linspace(200.0, 700.0, 4001)  # [K]

GlassTemperature = Annotated[float, ValueRange("K", ge=100.0, le=400.0, hint="Write degrees Celsius as '-72 degC'.")]
PerPressure = Annotated[float, ValueRange("1/Pa", gt=0.0, le=1e-6)]
Difference = Annotated[float, ValueRange("K", gt=0.0, le=1e4)]
Positive = Annotated[float, ValueRange("", gt=0.0, le=1e3)]


class _Yasutomi(InputModel):
    """log10 eta = log10 etaG - C1 X/(C2 + X), X = (T - Tg) F, Tg = Tg0 + A1 ln(1 + A2 p), T and Tg in degC.

    Within C2/2 of the pole X = -C2, where eta exceeds etaG 10^C1, log10 eta is continued by its tangent in X (own
    choice).
    """

    deviation: ClassVar[float] = MEASURED_DEVIATION
    viscosity_glass: DynamicViscosity = 1e12
    Tg0: GlassTemperature
    A1: Difference
    A2: PerPressure
    C1: Positive
    C2: Difference

    def log_viscosity(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """ln eta, eta in Pa s, at pressures [Pa] and temperatures [K]."""
        held = self._held(pressure, temperature)
        growth, _ = pole_growth(-self._distance(held, temperature) / self.C2, LAST_DEPTH)
        rest = _REST * (pressure - held)
        return np.asarray(np.log(self.viscosity_glass) + math.log(10.0) * self.C1 * growth + rest)

    def by_pressure(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """d ln eta/dp [1/Pa]."""
        held = self._held(pressure, temperature)
        factor, factor_p = self._factor(held)
        glass_p = self.A1 * self.A2 / (1.0 + self.A2 * held)
        distance_p = self._above_glass(held, temperature) * factor_p - glass_p * factor
        slope = self._by_distance(held, temperature) * distance_p
        return np.where(pressure > held, _REST, slope)

    def by_temperature(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """d ln eta/dT [1/K]."""
        pressure = self._held(pressure, temperature)
        return np.asarray(self._by_distance(pressure, temperature) * self._factor(pressure)[0])

    def _by_distance(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        _, slope = pole_growth(-self._distance(pressure, temperature) / self.C2, LAST_DEPTH)
        return np.asarray(-math.log(10.0) * self.C1 / self.C2 * slope)

    def _above_glass(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        glass = (self.Tg0 - KELVIN) + self.A1 * np.log(1.0 + self.A2 * pressure)
        return np.asarray(temperature - KELVIN - glass)

    def _distance(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        return np.asarray(self._above_glass(pressure, temperature) * self._factor(pressure)[0])

    def _factor(self, pressure: FloatArray) -> tuple[FloatArray, FloatArray]:
        """F and dF/dp."""
        raise NotImplementedError

    def _held(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """The pressure, limited to that of the largest viscosity."""
        return pressure


class ImprovedYasutomi(_Yasutomi):
    """Improved form: F = (1 + b1 p)^b2; equation and pole as in `_Yasutomi`."""

    law: Literal["yasutomi_improved"] = "yasutomi_improved"
    b1: PerPressure
    b2: Annotated[float, ValueRange("", ge=-2.0, lt=0.0)]

    def _factor(self, pressure: FloatArray) -> tuple[FloatArray, FloatArray]:
        inside = 1.0 + self.b1 * pressure
        factor = inside**self.b2
        return factor, self.b2 * self.b1 * factor / inside


class OriginalYasutomi(_Yasutomi):
    """Original form: F = 1 - B1 ln(1 + B2 p), which turns negative at high pressure.

    Above the pressure of its largest viscosity ln eta increases by 2e-4 per GPa (own choice).
    """

    law: Literal["yasutomi_original"] = "yasutomi_original"
    B1: Positive
    B2: PerPressure

    def _factor(self, pressure: FloatArray) -> tuple[FloatArray, FloatArray]:
        inside = 1.0 + self.B2 * pressure
        return 1.0 - self.B1 * np.log(inside), -self.B1 * self.B2 / inside

    def _held(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        return np.minimum(pressure, pressure_of_largest(self, temperature))


def pressure_of_largest(law: OriginalYasutomi, temperature: FloatArray) -> FloatArray:
    """Pressure of the largest viscosity of the original form [Pa]; `temperature` in K."""
    return np.asarray(np.interp(temperature, _TEMPERATURES, _largest(law)))


@lru_cache(maxsize=32)
def _largest(law: OriginalYasutomi) -> FloatArray:
    """Solution of dX/dp = 0 by bisection at `_TEMPERATURES`."""

    def falls(pressure: FloatArray) -> NDArray[np.bool_]:
        factor, factor_p = law._factor(pressure)
        glass_p = law.A1 * law.A2 / (1.0 + law.A2 * pressure)
        return np.asarray(law._above_glass(pressure, _TEMPERATURES) * factor_p - glass_p * factor >= 0.0, dtype=bool)

    rising = np.logical_and.accumulate(~falls(_GRID[:, None]), axis=0)
    low = _GRID[np.maximum(rising.sum(axis=0) - 1, 0)]
    high = low + _GRID[1]
    for _ in range(50):
        middle = 0.5 * (low + high)
        over = falls(middle)
        low, high = np.where(over, low, middle), np.where(over, middle, high)
    return np.asarray(low)
