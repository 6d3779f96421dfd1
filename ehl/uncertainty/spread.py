"""Standard deviations of the inputs of a contact: from oil card, finish and additives, or given by the user.

Slopes of ln mu for inputs that a friction formula does not contain, over the film ratio (own work).

The table was computed by `validation/input_sensitivities.py`: means over solved contacts in the range of gears.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import PrivateAttr

from ehl.common.arrays import FloatArray
from ehl.common.data import data_rows
from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel
from ehl.fluid.oil import Oil
from ehl.fluid.oil_laws import VARIABLES
from ehl.surface.finish import HALF_RANGE, LEAST_PEKLENIK, Figure, surface_uncertainty, with_lay_ratio

FILE = "sensitivities.csv"
FILM_RATIOS = (0.1, 0.2, 0.4, 0.8, 1.6, 3.2)
FILM_TO_SHARE = "boundary_film_share"  # slopes of the logit of the asperity load share with the boundary film


@cache
def _slopes() -> dict[str, tuple[FloatArray, FloatArray, FloatArray]]:
    """For each input: ln of the film ratios, slopes of ln mu below and above the value."""
    rows: dict[str, list[tuple[float, ...]]] = {}
    for row in data_rows(FILE):
        numbers = tuple(float(row[name]) for name in ("film_ratio", "slope_below", "slope_above"))
        rows.setdefault(row["input"], []).append(numbers)
    columns = {name: np.array(sorted(found)).T for name, found in rows.items()}
    return {name: (np.log(ratios), below, above) for name, (ratios, below, above) in columns.items()}


def stated_change(
    name: str, spread: Spread, film_ratio: FloatArray, score: float
) -> tuple[FloatArray, FloatArray] | None:
    """Change of ln mu with an input `score` standard deviations below and above; None for an input without a table.

    Linear in ln(film ratio) between the entries and constant beyond them. For smooth surfaces only the properties of
    the bodies have an effect.
    """
    if name not in _slopes():
        return None
    nodes, below, above = _slopes()[name]
    place = np.log(np.clip(film_ratio, 1e-6, 1e6))
    weight = np.where(np.isfinite(film_ratio) | (name in ("temperature_bulk", "conductivity_solid")), 1.0, 0.0)
    down, up = spread.shift(-score), spread.shift(score)
    return weight * down * np.interp(place, nodes, below), weight * up * np.interp(place, nodes, above)


Kind = Literal["relative", "absolute"]


@dataclass(frozen=True)
class Spread:
    """Standard deviation of a number."""

    sd: float  # of the logarithm ("relative"), or of the number in SI units ("absolute")
    kind: Kind = "relative"
    source: str = "given"
    sd_below: float | None = None  # to lower values, if different

    @classmethod
    def of_figure(cls, figure: Figure) -> Spread:
        """Spread of a positive value with its central 90 % range."""
        up, down = (math.log(end) / HALF_RANGE for end in (figure.high / figure.value, figure.value / figure.low))
        return cls(up, "relative", figure.source, down)

    @property
    def below(self) -> float:
        """Standard deviation to lower values."""
        return self.sd if self.sd_below is None else self.sd_below

    @property
    def known(self) -> bool:
        """Whether the number is exact."""
        return self.sd == 0.0 and self.below == 0.0

    def shift(self, score: float) -> float:
        """Change of the logarithm, or of the number, by `score` standard deviations."""
        return score * (self.sd if score > 0.0 else self.below)

    def at(self, value: Any, score: float) -> Any:
        """The value shifted by `score` standard deviations."""
        return value * math.exp(self.shift(score)) if self.kind == "relative" else value + self.shift(score)


# difference between a bulk temperature that is not estimated from the loss, or given, and the true one
TEMPERATURE_BULK = Spread(10.0, "absolute", "estimated")
# hardened steel, 30 +- 10 W/(m K); measured: 21 (through-hardened bearing steel) to 46 (annealed), unverified
CONDUCTIVITY_SOLID = Spread(0.30, source="hardened steel, 21 to 46 W/(m K)")

# standard deviation of ln mu of the lateral mode compared with solutions with two-dimensional roughness
# (docs/roughness.md), and the smooth film ratio above which it decreases as the inverse square, like the effect of
# roughness
LATERAL_MODE, LATERAL_RATIO = 0.08, 1.0
LATERAL_CAUSE = "rough_contact_model"

Relative = Annotated[
    float, ValueRange("", ge=0.0, le=3.0, hint="One standard deviation of its logarithm: 0.1 is about 10 %.")
]
Kelvins = Annotated[float, ValueRange("K", ge=0.0, le=100.0, hint="One standard deviation.")]

SURFACE = ("roughness_rms", "correlation_length", "peklenik_number", "boundary_film", "boundary_friction")
# cause of each input in a headline
GROUPS = {
    **dict.fromkeys(VARIABLES, "oil"),
    **dict.fromkeys(("roughness_rms", "correlation_length", "peklenik_number"), "roughness"),
    "boundary_film": "boundary film",
    LATERAL_CAUSE: "roughness",
    "boundary_friction": "boundary friction",
    "temperature_bulk": "bulk temperature",
    "conductivity_solid": "steel",
}


class UncertaintyInput(InputModel):
    """Table [uncertainty]: standard deviations of inputs that replace those of oil card, finish and program.

    Relative values are standard deviations of the logarithm: 0.1 is about 10 %. An exact input has 0.
    """

    # of the increase of ln eta with pressure, relative [-]; default: oil card, as for the next four
    pressure_viscosity: Relative | None = None
    viscosity: Relative | None = None
    eyring_stress: Relative | None = None
    limiting_shear: Relative | None = None
    thermal_conductivity: Relative | None = None
    # of each surface, relative [-]
    roughness_rms: Relative | None = None
    correlation_length: Relative | None = None
    peklenik_number: Relative | None = None  # default with a finish: spread of its lay ratio
    boundary_film: Relative | None = None
    boundary_friction: Relative | None = None
    # of mu by the model of two-dimensional roughness with asperity contact, relative [-]
    rough_contact_model: Relative | None = None
    temperature_bulk: Kelvins | None = None  # of both bodies [K]
    conductivity_solid: Relative | None = None  # thermal conductivity of both bodies, relative [-]
    # whether the errors of Rq of both surfaces are fully correlated; default: with a named finish
    same_surface: bool | None = None
    _figures: Mapping[str, Figure] = PrivateAttr(default_factory=dict)
    _surface: Mapping[str, Any] = PrivateAttr(default_factory=dict)
    _bulk: Spread = PrivateAttr(default=TEMPERATURE_BULK)

    @classmethod
    def none(cls, **given: float) -> UncertaintyInput:
        """All inputs exact except those given."""
        return cls(**(dict.fromkeys(GROUPS, 0.0) | given))

    def of_surface(self, **surface: Any) -> Self:
        """The same with the ranges of a surface; keywords of `ehl.surface.finish.surface_uncertainty`."""
        found = self.model_copy()
        found._figures, found._surface = surface_uncertainty(**surface), surface
        return found

    def with_surface_of(self, other: UncertaintyInput) -> Self:
        """The same with the ranges of the surface of another one, unless it has its own."""
        found = self.model_copy()
        if not found._figures:
            found._figures, found._surface = other._figures, other._surface
        return found

    def of_bulk(self, spread: Spread) -> Self:
        """The same with another default of the bulk temperature."""
        found = self.model_copy()
        found._bulk = spread
        return found

    @property
    def shared_rms(self) -> bool:
        """Whether the errors of Rq of both surfaces are fully correlated."""
        return self._surface.get("finish") is not None if self.same_surface is None else self.same_surface

    @property
    def lay_ratio(self) -> float | None:
        """Lay ratio of the finish, if the spread of `peklenik_number` is its spread; None for that of gamma."""
        given = self.peklenik_number is not None or self._surface.get("peklenik_number") is not None
        return None if given or self._surface.get("finish") is None else self._figures["peklenik_number"].value

    def lay_moved(self, length: Any, gamma: Any, score: float) -> tuple[Any, Any]:
        """Correlation length [m] and Peklenik number with the uncertain lay shifted by `score` standard deviations.

        With a finish its lay ratio is shifted and both values follow at the same angle of the marks; a given
        correlation length is not changed.
        """
        spread, ratio = self.spread("peklenik_number"), self.lay_ratio
        if ratio is None:
            return length, np.maximum(spread.at(gamma, score), LEAST_PEKLENIK)
        seen, moved = with_lay_ratio(length, gamma, ratio, spread.at(ratio, score))
        return (seen if self._surface.get("correlation_length") is None else length), moved

    def spread(self, name: str, oil: Oil | None = None) -> Spread:
        """Spread of an input: given here, from oil card, finish and additives, or the default."""
        given = getattr(self, name)
        if name == "temperature_bulk":
            return self._bulk if given is None else Spread(given, "absolute")
        if given is not None:
            return Spread(given)
        if name == LATERAL_CAUSE:
            return Spread(LATERAL_MODE, source="compared with solutions with two-dimensional roughness")
        if name == "conductivity_solid":
            return CONDUCTIVITY_SOLID
        if name in SURFACE:
            return Spread.of_figure((self._figures or _UNNAMED)[name])
        if oil is None:
            raise InputError("oil", None, "an oil whose data contain their uncertainty")
        return Spread(getattr(oil.uncertainty, name), source="oil card")


def lateral_spread(film_ratio: Any, sd: float) -> Any:
    """Standard deviation of ln mu by the model of two-dimensional roughness at smooth film ratios [-]."""
    return sd * np.minimum((LATERAL_RATIO / np.maximum(film_ratio, LATERAL_RATIO)) ** 2, 1.0)


_UNNAMED = surface_uncertainty(roughness_rms=1e-6)
DEFAULT = UncertaintyInput()
