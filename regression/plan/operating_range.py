"""The operating range of gears: from contact points and their weights to a plan.

Each range lies between weighted quantiles over the contact points of gear designs in operation. The weight of a point
is its friction work, so that a plan over these ranges has its cases where power is lost.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.common.files import toml_text
from ehl.common.pages import TableResult
from ehl.common.quantities import quantity, rounded_towards, si_unit, to_display
from ehl.common.table import Table
from ehl.common.threads import one_thread
from ehl.fluid.oil import Oil
from ehl.state import ContactState
from regression.friction.conditions import conditions_of
from regression.plan.plan import Plan

if TYPE_CHECKING:
    import pandas as pd

# sampling scale of each variable of the plan
_SCALES = {
    "pressure_hertz": "linear",
    "radius_equivalent": "log",
    "speed_entrainment": "log",
    "slide_to_roll": "log",
    "lengthwise_to_roll": "linear",
    "temperature_oil": "linear",
    "roughness_rms": "log",
    "correlation_length": "log",
}
_COLUMNS = ("minimum", "low", "median", "high", "maximum")
_ONE_VALUE = 1.02  # ratio of the ends below which a range is a single value
MIN_SLIDING = 1e-3  # smallest slide-to-roll ratio of a plan: sliding below it gives no information on friction


@dataclass(frozen=True)
class WeightedPoints:
    """Contact points of one design at one operating point.

    Parameters
    ----------
    state : ContactState
        Local conditions.
    weight : array
        Weight of each point: its share of the loss times its duration.
    oil : Oil
        Oil card for the film ratio.

    Examples
    --------
    >>> state = ehl.ContactState.of(
    ...     pressure_hertz=[0.8e9, 1.2e9], radius_equivalent=0.015, effective_modulus=226e9, speed_entrainment=5.0)
    >>> WeightedPoints(state, [1.0, 3.0], ehl.Oil.load("75w90")).state.size
    2
    """

    state: ContactState
    weight: FloatArray
    oil: Oil


@dataclass(frozen=True)
class VariableRange:
    """Weighted quantiles of one variable: the ends of its range, its median, and the extremes of all points."""

    low: float
    median: float
    high: float
    minimum: float
    maximum: float


@dataclass(frozen=True)
class OperatingRange(TableResult):
    """Ranges of contact conditions of gears in operation.

    Parameters
    ----------
    variables : dict
        Name to `VariableRange`, SI: the variables of a plan, the film ratio, and pressure times sliding speed.
    coverage : float
        Share of the weight inside each range.

    Examples
    --------
    >>> state = ehl.ContactState.of(
    ...     pressure_hertz=[0.8e9, 1.2e9], radius_equivalent=0.015, effective_modulus=226e9, speed_entrainment=5.0,
    ...     slide_to_roll=0.2, roughness_rms_1=0.4e-6)
    >>> found = operating_range([WeightedPoints(state, [1.0, 3.0], ehl.Oil.load("75w90"))])
    >>> f"{found['pressure_hertz'].high:.3g} Pa"
    '1.2e+09 Pa'
    """

    variables: dict[str, VariableRange]
    coverage: float

    def __getitem__(self, name: str) -> VariableRange:
        return self.variables[name]

    def to_frame(self) -> pd.DataFrame:
        """One row per variable: unit, minimum, low, median, high, maximum (SI)."""
        import pandas as pd

        rows = {
            name: {"unit": si_unit(name), **{key: getattr(x, key) for key in _COLUMNS}}
            for name, x in self.variables.items()
        }
        return pd.DataFrame.from_dict(rows, orient="index").rename_axis("variable")

    def __repr__(self) -> str:
        ranges = (f"  {name}: {x.low:.4g} to {x.high:.4g} {si_unit(name)}" for name, x in self.variables.items())
        return "\n".join((f"OperatingRange, {100.0 * self.coverage:g} % of the weight (SI)", *map(str.rstrip, ranges)))

    def table(self) -> Table:
        """Minimum, low, median, high and maximum of each variable in display units."""
        rows = [(column, *(getattr(x, column) for x in self.variables.values())) for column in _COLUMNS]
        title = f"contact points: {100.0 * self.coverage:g} % of the friction work lies between low and high"
        return Table(("", *self.variables), rows, title=title, vertical=True)

    def plan_text(
        self,
        name: str,
        oils: Sequence[str],
        *,
        size: int,
        description: str = "",
        margin: float = 0.1,
        accuracy: str = "fast",
    ) -> str:
        """The text (TOML) of a plan file over the ranges.

        Parameters
        ----------
        oils : sequence of str
            Oil cards; every point is computed with each of them.
        size : int
            Number of points in the ranges, for each oil.
        margin : float
            Every range is widened at both ends by this share of its length (of its logarithm on a log scale), so that
            the gears lie inside the fitted range.
        """
        ranges = self.variables
        content: dict[str, Any] = {"name": name, "description": description, "sampling": {"size": size, "seed": 1}}
        content["variables"] = {
            variable: _axis(variable, ranges[variable], scale, margin)
            for variable, scale in _SCALES.items()
            if variable in ranges
        }
        if "film_ratio" in ranges:
            low, high = _widened(ranges["film_ratio"].low, ranges["film_ratio"].high, "log", margin)
            content["constraints"] = {
                "film_ratio": {"low": rounded_towards(low, math.floor), "high": rounded_towards(high, math.ceil)}
            }
        content["lubricant"] = {"oil": oils[0] if len(oils) == 1 else list(oils)}
        return toml_text(content | {"model": {"accuracy": accuracy}})

    def plan(self, name: str, oils: Sequence[str], *, size: int, **options: Any) -> Plan:
        """The plan over the ranges; parameters of `plan_text`."""
        return Plan.from_dict(tomllib.loads(self.plan_text(name, oils, size=size, **options)))


def weighted_quantile(values: ArrayLike, weights: ArrayLike, levels: ArrayLike) -> FloatArray:
    """Quantiles of weighted values, interpolated in the cumulative weight at the middle of each value's weight.

    With equal weights these are Hazen's quantiles. Levels beyond the first and last value give the extreme values.

    Raises `InputError`: no values, a weight that is negative or not finite, or no positive weight.
    """
    x, w = np.ravel(np.asarray(values, dtype=float)), np.ravel(np.asarray(weights, dtype=float))
    if x.size == 0 or x.size != w.size:
        raise InputError("weights", f"{w.size} for {x.size} values", "as many weights as values, at least one")
    if not (np.isfinite(w).all() and np.isfinite(x).all() and w.min() >= 0.0 and w.sum() > 0.0):
        raise InputError("weights", "given", "finite values and weights of at least 0, one of them above 0")
    counted = w > 0.0
    x, w = x[counted], w[counted]
    order = np.argsort(x, kind="stable")
    x, w = x[order], w[order]
    return np.asarray(np.interp(np.asarray(levels, dtype=float), (np.cumsum(w) - 0.5 * w) / w.sum(), x))


@one_thread
def operating_range(points: Sequence[WeightedPoints], coverage: float = 0.98) -> OperatingRange:
    """Ranges of the variables of a plan, and of the film ratio, over weighted contact points.

    Parameters
    ----------
    points : sequence of WeightedPoints
        Contact points of all designs and operating points.
    coverage : float
        Share of the weight inside each range; half of the rest is cut off at each end.

    Returns
    -------
    OperatingRange

    Raises
    ------
    InputError
        There are no points, weights are invalid, or the coverage is outside 0.5 to 1.

    Examples
    --------
    >>> import numpy as np
    >>> from ehl import ContactState, Oil
    >>> from regression import WeightedPoints, operating_range
    >>> state = ContactState.of(
    ...     pressure_hertz=np.linspace(0.5e9, 1.5e9, 101), radius_equivalent=0.01, effective_modulus=226e9,
    ...     speed_entrainment=5.0, slide_to_roll=0.2, temperature_oil=363.15,
    ...     roughness_rms_1=0.3e-6, roughness_rms_2=0.4e-6,
    ... )
    >>> ranges = operating_range([WeightedPoints(state, np.ones(101), Oil.load("fva3"))], coverage=0.9)
    >>> f"{ranges['pressure_hertz'].low:.3g} to {ranges['pressure_hertz'].high:.3g} Pa"
    '5.46e+08 to 1.45e+09 Pa'
    >>> ranges.plan("gears", ["fva3"], size=64).count
    64
    """
    if not points:
        raise InputError("points", "none", "contact points of at least one design")
    if not 0.5 <= coverage <= 1.0:
        raise InputError("coverage", coverage, "0.5 to 1")
    columns: dict[str, list[FloatArray]] = {name: [] for name in (*_SCALES, "film_ratio", "pressure_velocity")}
    for part in points:
        table = conditions_of(part.state, part.oil)
        quantities = {
            **table,
            "slide_to_roll": np.abs(table["slide_to_roll"]),
            "lengthwise_to_roll": np.abs(table["speed_sliding_lengthwise"] / table["speed_entrainment"]),
            "film_ratio": table["film_ratio_formula"],
            "pressure_velocity": table["pressure_hertz"] * table["speed_sliding"],
        }
        for name, column in columns.items():
            column.append(np.ravel(quantities[name]))
    weight = np.concatenate([np.ravel(part.weight) for part in points])
    tail = 0.5 * (1.0 - coverage)
    ranges = {}
    for name, parts in columns.items():
        values = np.concatenate(parts)
        if np.isfinite(values).all():
            low, median, high = (float(q) for q in weighted_quantile(values, weight, (tail, 0.5, 1.0 - tail)))
            ranges[name] = VariableRange(low, median, high, float(values.min()), float(values.max()))
    return OperatingRange(ranges, coverage)


def _axis(name: str, variable: VariableRange, scale: str, margin: float) -> float | str | dict[str, Any]:
    unit = quantity(name).display
    low, high = variable.low, variable.high
    if name == "slide_to_roll":
        low, high = max(low, MIN_SLIDING), max(high, 2.0 * MIN_SLIDING)
    if name == "lengthwise_to_roll" and high < MIN_SLIDING:
        return 0.0
    if high <= _ONE_VALUE * low:
        return _value(rounded_towards(to_display(name, variable.median), math.floor), unit)
    low, high = _widened(low, high, scale, margin)
    if name == "lengthwise_to_roll":
        low = max(low, 0.0)
    # rounded outwards in the display unit
    low, high = rounded_towards(to_display(name, low), math.floor), rounded_towards(to_display(name, high), math.ceil)
    return {"low": _value(low, unit), "high": _value(high, unit), **({"scale": scale} if scale == "log" else {})}


def _widened(low: float, high: float, scale: str, margin: float) -> tuple[float, float]:
    if scale == "log":
        step = margin * math.log(high / low)
        return low * math.exp(-step), high * math.exp(step)
    step = margin * (high - low)
    return low - step, high + step


def _value(value: float, unit: str) -> float | str:
    return f"{value:g} {unit}" if unit else value
