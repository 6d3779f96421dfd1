"""The laws of an oil card by ufuncs, so that they can be recorded: `ehl.fluid.oil.Oil.at` for arrays."""

from __future__ import annotations

import itertools
import math

import numpy as np

from ehl.fluid.lubricant import GOLD_COEFFICIENTS, KELVIN, ROELANDS_LOG_VISCOSITY, ROELANDS_PRESSURE
from ehl.fluid.oil import GoldAlpha, ModulusViscosity, Oil, TabulatedAlpha
from regression.friction.conditions import Array


def oil_columns(oil: Oil, temperature_oil: Array, pressure_hertz: Array) -> dict[str, Array | float]:
    """The variables of `regression.friction.conditions.LUBRICANT_UNITS`.

    Parameters
    ----------
    oil : Oil
        The card whose numbers are taken.
    temperature_oil : array
        [K]; the laws hold from -40 to 200 degC.
    pressure_hertz : array
        [Pa].
    """
    viscosity_inlet = _viscosity_dynamic(oil, temperature_oil)
    temperature_viscosity = _temperature_viscosity(oil, temperature_oil)
    pressure_viscosity = _alpha(oil, temperature_oil)
    mean_pressure = 0.25 * math.pi * pressure_hertz
    rise = _log_viscosity_rise(oil, temperature_oil, mean_pressure, viscosity_inlet, pressure_viscosity)
    viscosity_mean_pressure = np.exp(np.minimum(np.log(viscosity_inlet) + rise, 690.0))
    return {
        "viscosity_inlet": viscosity_inlet,
        "viscosity_kinematic": viscosity_inlet / _density(oil, temperature_oil),
        "viscosity_mean_pressure": viscosity_mean_pressure,
        "pressure_viscosity": pressure_viscosity,
        "eyring_stress": oil.eyring_stress or 2.0 * oil.limiting_shear_coefficient / pressure_viscosity,
        "limiting_shear_coefficient": oil.limiting_shear_coefficient,
        "temperature_viscosity": temperature_viscosity,
        "thermal_conductivity": oil.thermal_conductivity,
    }


def _density(oil: Oil, temperature: Array) -> Array:
    return oil.density_15 * (1.0 + oil.density_temperature * (temperature - KELVIN - 15.0))


def _walther_constants(oil: Oil) -> tuple[float, float]:
    double_40, double_100 = (
        math.log10(math.log10(1e6 * nu + 0.7)) for nu in (oil.viscosity_kinematic_40, oil.viscosity_kinematic_100)
    )
    low, high = math.log10(40.0 + KELVIN), math.log10(100.0 + KELVIN)
    slope = (double_40 - double_100) / (high - low)
    return double_40 + slope * low, slope


def _walther(oil: Oil, temperature: Array) -> Array:
    """Kinematic viscosity [m2/s] by `ehl.fluid.lubricant.walther_1931`."""
    m, n = _walther_constants(oil)
    return (10.0 ** (10.0 ** (m - n * np.log10(temperature))) - 0.7) * 1e-6


def _temperature_viscosity(oil: Oil, temperature: Array) -> Array:
    """beta [1/K] by `ehl.fluid.oil.Oil.temperature_viscosity`."""
    law = oil.viscosity
    if isinstance(law, ModulusViscosity):
        return law.B / (temperature - KELVIN + law.C) ** 2
    _, n = _walther_constants(oil)
    nu = 1e6 * _walther(oil, temperature)
    thinning = n * (nu + 0.7) * np.log(nu + 0.7) / (nu * temperature)
    return thinning - oil.density_temperature * oil.density_15 / _density(oil, temperature)


def _viscosity_dynamic(oil: Oil, temperature: Array) -> Array:
    law = oil.viscosity
    if isinstance(law, ModulusViscosity):
        return law.K * np.exp(law.B / (temperature - KELVIN + law.C))
    return _walther(oil, temperature) * _density(oil, temperature)


def _alpha(oil: Oil, temperature: Array) -> Array:
    law = oil.pressure_viscosity
    if isinstance(law, GoldAlpha):
        scale, exponent = GOLD_COEFFICIENTS[law.base]
        if law.anchor_temperature is not None and law.anchor_value is not None:
            anchor = oil.viscosity_kinematic(law.anchor_temperature)
            return law.anchor_value * (_walther(oil, temperature) / anchor) ** exponent
        return scale * (_walther(oil, temperature) * 1e6) ** exponent * 1e-9
    if isinstance(law, TabulatedAlpha):
        return _between(law, temperature)
    assert isinstance(oil.viscosity, ModulusViscosity)
    return 1.0 / (oil.viscosity.a1 + oil.viscosity.a2 * (temperature - KELVIN))


def _between(law: TabulatedAlpha, temperature: Array) -> Array:
    """Linear in ln alpha between the temperatures of the table, and beyond them with the slope of its ends."""
    if len(law.value) == 1:
        return 0.0 * temperature + law.value[0]
    points = list(zip(law.temperature, (math.log(value) for value in law.value), strict=True))
    pieces = [
        (t1, low + (high - low) / (t1 - t0) * (temperature - t0))
        for (t0, low), (t1, high) in itertools.pairwise(points)
    ]
    log_alpha = pieces[-1][1]
    for end, piece in reversed(pieces[:-1]):
        log_alpha = np.where(temperature <= end, piece, log_alpha)
    return np.exp(log_alpha)


def _log_viscosity_rise(oil: Oil, temperature: Array, pressure: Array, viscosity: Array, alpha: Array) -> Array:
    """ln(eta/eta0) at a pressure by `ehl.fluid.lubricant.Lubricant.log_viscosity_ratio`."""
    law = oil.viscosity
    if isinstance(law, ModulusViscosity):
        celsius = temperature - KELVIN
        return pressure / (law.a1 + law.a2 * celsius + (law.b1 + law.b2 * celsius) * pressure)
    if law.law == "barus":
        return alpha * pressure
    roelands = np.log(viscosity) + ROELANDS_LOG_VISCOSITY
    exponent = alpha * ROELANDS_PRESSURE / roelands
    return roelands * ((1.0 + pressure / ROELANDS_PRESSURE) ** exponent - 1.0)
