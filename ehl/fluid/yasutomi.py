"""Viscosity by the distance from the glass transition (Yasutomi, Bair & Winer 1984; improved form of Bair 2007)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ehl.common.units import KELVIN
from ehl.fluid.poles import pole_growth

Array = NDArray[np.float64]

LAST_DEPTH = 0.5  # of the way from the glass transition to the pole: from there on along the tangent
_REST = 2e-13  # slope where the original form would fall: no viscosity is the same at two pressures [1/Pa]
_GRID = np.linspace(0.0, 6e9, 301)  # where the original form's largest viscosity is looked for [Pa]
_TEMPERATURES = np.linspace(200.0, 700.0, 4001)  # [K]


@dataclass(frozen=True)
class Yasutomi:
    """log10 eta = log10 etaG - C1 X/(C2 + X), X = (T - Tg) F, Tg = Tg0 + A1 ln(1 + A2 p), T and Tg in degC.

    Improved: F = (1 + b1 p)^b2. Original: F = 1 - b1 ln(1 + b2 p), which turns negative at high pressure; from the
    pressure where its viscosity would start to fall, it stays but for 2e-4 of ln eta per GPa (ours). Nearer than C2/2
    to the pole X = -C2, where eta is above etaG 10^C1, log10 eta goes on along its tangent in X (ours).

    Parameters
    ----------
    viscosity_glass : float
        etaG [Pa s].
    temperature_glass : float
        Tg0 [degC].
    rise, rise_rate : float
        A1 [K] and A2 [1/Pa].
    expansion, exponent : float
        b1 and b2: [1/Pa] and [-] improved, [-] and [1/Pa] original.
    c1, c2 : float
        C1 [-] and C2 [K].
    original : bool
        The form of F.
    """

    viscosity_glass: float
    temperature_glass: float
    rise: float
    rise_rate: float
    expansion: float
    exponent: float
    c1: float
    c2: float
    original: bool = False

    def log_viscosity(self, pressure: Array, temperature: Array) -> Array:
        """ln eta, eta in Pa s, at pressures [Pa] and temperatures [K]."""
        held = self._held(pressure, temperature)
        growth, _ = pole_growth(-self._distance(held, temperature) / self.c2, LAST_DEPTH)
        rest = _REST * (pressure - held)
        return np.asarray(np.log(self.viscosity_glass) + math.log(10.0) * self.c1 * growth + rest)

    def by_pressure(self, pressure: Array, temperature: Array) -> Array:
        """d ln eta/dp [1/Pa]."""
        held = self._held(pressure, temperature)
        factor, factor_p = self._factor(held)
        glass_p = self.rise * self.rise_rate / (1.0 + self.rise_rate * held)
        distance_p = self._above_glass(held, temperature) * factor_p - glass_p * factor
        slope = self._by_distance(held, temperature) * distance_p
        return np.where(pressure > held, _REST, slope) if self.original else np.asarray(slope)

    def by_temperature(self, pressure: Array, temperature: Array) -> Array:
        """d ln eta/dT [1/K]."""
        pressure = self._held(pressure, temperature)
        return np.asarray(self._by_distance(pressure, temperature) * self._factor(pressure)[0])

    def _by_distance(self, pressure: Array, temperature: Array) -> Array:
        _, slope = pole_growth(-self._distance(pressure, temperature) / self.c2, LAST_DEPTH)
        return np.asarray(-math.log(10.0) * self.c1 / self.c2 * slope)

    def _above_glass(self, pressure: Array, temperature: Array) -> Array:
        glass = self.temperature_glass + self.rise * np.log(1.0 + self.rise_rate * pressure)
        return np.asarray(temperature - KELVIN - glass)

    def _factor(self, pressure: Array) -> tuple[Array, Array]:
        """F and dF/dp."""
        if self.original:
            inside = 1.0 + self.exponent * pressure
            return 1.0 - self.expansion * np.log(inside), -self.expansion * self.exponent / inside
        inside = 1.0 + self.expansion * pressure
        factor = inside**self.exponent
        return factor, self.exponent * self.expansion * factor / inside

    def _distance(self, pressure: Array, temperature: Array) -> Array:
        return np.asarray(self._above_glass(pressure, temperature) * self._factor(pressure)[0])

    def _held(self, pressure: Array, temperature: Array) -> Array:
        """The pressure, or that of the largest viscosity where the original form would fall."""
        return np.minimum(pressure, pressure_of_largest(self, temperature)) if self.original else pressure


def pressure_of_largest(law: Yasutomi, temperature: Array) -> Array:
    """Pressure up to which the viscosity of the original form rises [Pa]; `temperature` in K."""
    return np.asarray(np.interp(temperature, _TEMPERATURES, _largest(law)))


@lru_cache(maxsize=32)
def _largest(law: Yasutomi) -> Array:
    """dX/dp = 0 by bisection, at `_TEMPERATURES`."""

    def falls(pressure: Array) -> NDArray[np.bool_]:
        factor, factor_p = law._factor(pressure)
        glass_p = law.rise * law.rise_rate / (1.0 + law.rise_rate * pressure)
        return np.asarray(law._above_glass(pressure, _TEMPERATURES) * factor_p - glass_p * factor >= 0.0, dtype=bool)

    rising = np.logical_and.accumulate(~falls(_GRID[:, None]), axis=0)
    low = _GRID[np.maximum(rising.sum(axis=0) - 1, 0)]
    high = low + _GRID[1]
    for _ in range(50):
        middle = 0.5 * (low + high)
        over = falls(middle)
        low, high = np.where(over, low, middle), np.where(over, middle, high)
    return np.asarray(low)
