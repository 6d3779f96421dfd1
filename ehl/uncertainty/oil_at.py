"""An oil with one figure wrong by a stated factor."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil


def varied_oil(oil: Oil, name: str, sd: float, score: float) -> Oil:
    """The oil with one figure so many standard deviations of its logarithm away."""
    return _VariedOil(oil, name, math.exp(score * sd))  # type: ignore[return-value]


class _VariedOil:
    def __init__(self, oil: Oil, name: str, factor: float) -> None:
        self._oil, self._name, self._factor = oil, name, factor

    def __getattr__(self, name: str) -> Any:
        return getattr(self._oil, name)

    def at(self, temperature: Any) -> Lubricant:
        found, f = self._oil.at(temperature), self._factor
        if self._name == "pressure_viscosity":
            constants = tuple(value / f for value in found.modulus_constants)
            return replace(found, pressure_viscosity=f * found.pressure_viscosity, modulus_constants=constants)
        field = {"viscosity": "viscosity_inlet", "limiting_shear": "limiting_shear_coefficient"}.get(
            self._name, self._name
        )
        return replace(found, **{field: f * getattr(found, field)})
