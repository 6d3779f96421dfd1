"""Pressure-viscosity coefficients of an oil card over temperature, from any of their definitions."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.fluid.oil_laws import GoldAlpha, ModulusAlpha, TabulatedAlpha, figures_by_constants, scale_of_law
from ehl.fluid.pressure_viscosity import TemperatureFit, alpha_film, roelands_slope, solve_constant, temperature_fit
from ehl.fluid.viscosity import GOLD_COEFFICIENTS, TEMPERATURE_RANGE, RoelandsLaw, WaltherViscosity, gold_2001

if TYPE_CHECKING:
    from ehl.fluid.oil import Oil

_MOST_KEPT = 512  # cards


def stated(card: Oil, temperature: Any) -> Any:
    """The coefficient in the definition of the card [1/Pa]; `temperature` in K."""
    law = card.pressure_viscosity
    if isinstance(law, TabulatedAlpha):
        return _between(law, temperature)
    assert isinstance(law, GoldAlpha)
    if law.anchor_temperature is None or law.anchor_value is None:
        return gold_2001(card.viscosity_kinematic(temperature), law.base)
    ratio = card.viscosity_kinematic(temperature) / card.viscosity_kinematic(law.anchor_temperature)
    return law.anchor_value * ratio ** GOLD_COEFFICIENTS[law.base][1]


def slope(card: Oil, temperature: Any) -> Any:
    """d ln(eta)/dp at p = 0 [1/Pa]; `temperature` in K."""
    law, viscosity = card.pressure_viscosity, card.viscosity
    if isinstance(law, ModulusAlpha):
        assert not isinstance(viscosity, WaltherViscosity)
        return figures_by_constants(viscosity, temperature, factor(card))["pressure_viscosity"]
    definition = card.alpha_definition
    if viscosity.law == "barus" or definition == "slope":
        return stated(card, temperature)
    if definition == "secant_200":
        return roelands_slope(stated(card, temperature), card.viscosity_dynamic(temperature))

    return stated(card, temperature) * _slope_over_stated(card)(temperature)


@lru_cache(maxsize=_MOST_KEPT)
def _slope_over_stated(card: Oil) -> TemperatureFit:
    def ratio(at: FloatArray) -> FloatArray:
        value = stated(card, at)
        found = solve_constant(
            lambda alpha: RoelandsLaw(card.viscosity_dynamic(at), alpha, at, 0.0),  # type: ignore[arg-type]
            value,
            card.alpha_definition,
            value,
        )
        return np.asarray(found / value)

    return _fit(card, ratio)


@lru_cache(maxsize=_MOST_KEPT)
def factor(card: Oil) -> float:
    """Factor on ln(eta(p)/eta0) of the law with which it meets the anchor of the card."""
    law, viscosity = card.pressure_viscosity, card.viscosity
    if not isinstance(law, ModulusAlpha) or isinstance(viscosity, WaltherViscosity) or law.anchor_temperature is None:
        return 1.0
    return scale_of_law(viscosity, law.anchor_temperature, law.anchor_value, card.alpha_definition)


def film(card: Oil, temperature: Any, alpha: Any) -> Any:
    """alpha_film of the law with its pressure_rise_factor [1/Pa]; `temperature` in K, `alpha` from `slope`."""
    if card.viscosity.law == "barus":
        return card.factors.pressure_viscosity * alpha
    return alpha * _film_over_slope(card)(temperature)


@lru_cache(maxsize=_MOST_KEPT)
def _film_over_slope(card: Oil) -> TemperatureFit:
    return _fit(card, lambda at: np.asarray(alpha_film(card.without_film(at).pressure_law) / slope(card, at)))


def _fit(card: Oil, function: Callable[[FloatArray], FloatArray]) -> TemperatureFit:
    low, high = TEMPERATURE_RANGE
    law = card.pressure_viscosity
    kinks = law.temperature[1:-1] if isinstance(law, TabulatedAlpha) else ()
    return temperature_fit(function, (low, *(at for at in kinks if low < at < high), high))


def _between(law: TabulatedAlpha, temperature: Any) -> Any:
    """Linear interpolation of ln alpha in the table, and linear extrapolation beyond its ends."""
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
    return np.exp(log_alpha)
