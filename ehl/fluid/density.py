"""Density over temperature and pressure: every law once, as functions of arrays with their derivatives."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ehl.io.units import KELVIN

Array = NDArray[np.float64]
Values = TypeVar("Values", float, Array)

DOWSON_HIGGINSON = (0.6e-9, 1.7e-9)  # [1/Pa]


def density_at(temperature: Values, density_15: float, coefficient: float) -> Values:
    """Density at ambient pressure, rho15 (1 + a_T (T - 15 degC)) [kg/m3]; `temperature` in K."""
    return density_15 * (1.0 + coefficient * (temperature - KELVIN - 15.0))


def dowson_higginson_1966(pressure: Array, a: float = DOWSON_HIGGINSON[0], b: float = DOWSON_HIGGINSON[1]) -> Array:
    """rho/rho0 = 1 + a p/(1 + b p) (Dowson & Higginson 1966).

    The variant (5.9e8 + 1.34 p)/(5.9e8 + p) is another function: 0.8 % apart at 2 GPa.
    """
    return np.asarray(1.0 + a * pressure / (1.0 + b * pressure))


def dowson_higginson_slope(pressure: Array, a: float = DOWSON_HIGGINSON[0], b: float = DOWSON_HIGGINSON[1]) -> Array:
    """d(rho/rho0)/dp of `dowson_higginson_1966` [1/Pa]."""
    return np.asarray(a / (1.0 + b * pressure) ** 2)
