"""What the efficiency inherits from friction formula, boundary friction and roughness: an interval and its shares.

Each source shifts the efficiency by its standard deviation times the slope (a central difference over plus and minus
one standard deviation); the sources are independent of each other and add as squares. Boundary friction and roughness
are one number for the whole flank. The error of a friction formula is not: its lack of fit is shared by neighbouring
points, its scatter is not. Both limits are given; the interval uses the first, all points wrong the same way, which is
never too narrow.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Any

import numpy as np
import pandas as pd

from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.kinematics import Operation
from efficiency.loss.lubrication import SolvedFriction
from ehl.io.errors import InputError
from ehl.io.numbers import finite_or_none
from ehl.view.table import Column, Table
from regression.formula import Formula
from regression.friction.models import FrictionModel

Solve = Callable[[FrictionModel, Operation], EfficiencyResult]

LEVEL = 0.90
# two standard deviations, the interval of solved contacts and of models that do not tell
_LEVEL_EHL = math.erf(math.sqrt(2.0))


@dataclass(frozen=True)
class Spread:
    """How well a number is known: one standard deviation.

    Parameters
    ----------
    sigma : float
        In the unit of the number, or over the number where `relative`.
    relative : bool
        Whether it is a share of the number.
    """

    sigma: float
    relative: bool = False

    def __post_init__(self) -> None:
        if not (math.isfinite(self.sigma) and self.sigma >= 0.0):
            raise InputError("sigma", self.sigma, "a finite number of at least 0")

    @classmethod
    def of_range(cls, low: float, high: float) -> Spread:
        """All values from `low` to `high` equally likely: (high - low)/sqrt(12)."""
        if not high >= low:
            raise InputError("range", [low, high], "the lower end first")
        return cls((high - low) / math.sqrt(12.0))

    def around(self, value: float) -> float:
        """Standard deviation of a value."""
        return self.sigma * abs(value) if self.relative else self.sigma


@dataclass(frozen=True)
class UncertainInputs:
    """Spreads of the inputs.

    Parameters
    ----------
    boundary_friction : Spread
        Of mu_b [-]. Default: all of 0.065 to 0.13, equally likely, as
        met in the literature (after Arana, Larranaga & Ulacia 2019).
    roughness_pinion, roughness_gear : Spread
        Of Rq [m]; 15 % by default, ours.
    """

    boundary_friction: Spread = Spread((0.13 - 0.065) / math.sqrt(12.0))
    roughness_pinion: Spread = Spread(0.15, relative=True)
    roughness_gear: Spread = Spread(0.15, relative=True)


@dataclass(frozen=True)
class UncertaintySource:
    """One source.

    Attributes
    ----------
    name : str
        What is uncertain.
    sigma_input : float
        Its standard deviation, nan where it is a function of place.
    sigma_efficiency : float
        Standard deviation of the efficiency by it [-].
    variance_share : float
        Share of the variance of the efficiency [-].
    note : str
        What it takes for granted, or why it is left out.
    """

    name: str
    sigma_input: float
    sigma_efficiency: float
    variance_share: float
    note: str


@dataclass(frozen=True, repr=False)
class EfficiencyUncertainty:
    """Interval of the efficiency.

    Attributes
    ----------
    efficiency, sigma_efficiency : float
        [-].
    level : float
        Probability the interval holds, for normal errors.
    efficiency_lower, efficiency_upper : float
        With all points of the friction formula wrong the same way [-].
    sigma_efficiency_independent : float
        With the points of the formula independent of each other [-].
    sources : tuple of UncertaintySource
    """

    efficiency: float
    sigma_efficiency: float
    level: float
    efficiency_lower: float
    efficiency_upper: float
    sigma_efficiency_independent: float
    sources: tuple[UncertaintySource, ...]

    def to_dict(self) -> dict[str, Any]:
        """For JSON; not-a-number becomes None."""
        content: dict[str, Any] = finite_or_none(self)
        return content

    def __repr__(self) -> str:
        return f"EfficiencyUncertainty({self._interval()})"

    def _interval(self) -> str:
        """The interval in words."""
        low, middle, high = (
            f"{100.0 * value:.3f}" for value in (self.efficiency_lower, self.efficiency, self.efficiency_upper)
        )
        return f"efficiency {middle} %, {100.0 * self.level:.0f} % interval {low} to {high} %"

    def table(self) -> Table:
        """Where the uncertainty comes from."""
        columns = (
            "source",
            Column("sigma_efficiency", of="efficiency_error", label="sigma of the efficiency"),
            Column("variance_share", of="share", label="share of the variance", digits=3),
            Column("sigma_input", label="sigma of the source, SI", digits=3),
            "note",
        )
        rows = [(s.name, s.sigma_efficiency, s.variance_share, s.sigma_input, s.note) for s in self.sources]
        return Table(columns, rows, title=f"Uncertainty: {self._interval()}.", name="uncertainty")

    def to_frame(self) -> pd.DataFrame:
        """The same, one row for each source."""
        return self.table().to_frame()

    def _repr_html_(self) -> str:
        return self.table().html()


def with_boundary_friction(model: FrictionModel, value: float) -> FrictionModel | None:
    """The same model with another mu_b; None where mu_b is no input of it."""
    if isinstance(model, Formula):
        return replace(model, formula=model.formula.model_copy(update={"boundary_friction": value}))
    if hasattr(model, "boundary_friction"):
        return replace(model, boundary_friction=value)  # type: ignore[type-var]
    return None


def boundary_friction_of(model: FrictionModel) -> float:
    """mu_b of a friction model; nan where it has none."""
    holder = model.formula if isinstance(model, Formula) else model
    return float(getattr(holder, "boundary_friction", math.nan))


def efficiency_uncertainty(
    result: EfficiencyResult, solve: Solve, inputs: UncertainInputs = UncertainInputs(), level: float = LEVEL
) -> EfficiencyUncertainty:
    """Carry the uncertainty of friction formula, boundary friction and roughness to the efficiency.

    Parameters
    ----------
    result : EfficiencyResult
        With its friction model and operating point.
    solve : callable
        Efficiency with a friction model at an operation; asked six times.
    inputs : UncertainInputs
        Spreads of the inputs.
    level : float
        Probability of the interval.

    Raises
    ------
    InputError
        The level is no probability.
    """
    if not 0.0 < level < 1.0:
        raise InputError("level", level, "between 0 and 1")
    friction, operation = result.model, result.operation
    same, independent, formula_note = _formula_error(result, friction)
    found: list[tuple[str, float, float, str]] = [("friction formula", math.nan, same, formula_note)]

    mu_b = boundary_friction_of(friction)
    sigma = inputs.boundary_friction.around(mu_b)
    if math.isfinite(mu_b):
        models = [with_boundary_friction(friction, min(max(mu_b + s, 0.0), 1.0)) for s in (-sigma, sigma)]
        changes = [solve(model, operation).efficiency for model in models if model is not None]
        found.append(("boundary friction", sigma, 0.5 * abs(changes[1] - changes[0]), f"mu_b {mu_b:g} of the model"))
    else:
        found.append(("boundary friction", sigma, 0.0, "mu_b is no input of this friction model"))
    for name, spread in (("pinion", inputs.roughness_pinion), ("gear", inputs.roughness_gear)):
        field = f"roughness_rms_{name}"
        rms = getattr(operation, field)
        sigma = spread.around(rms)
        ends = [max(rms + s, 0.0) for s in (-sigma, sigma)]
        low, high = (solve(friction, replace(operation, **{field: end})).efficiency for end in ends)
        note = "one number for all flanks of the member"
        if ends[1] - ends[0] < 2.0 * sigma:
            note += "; Rq ends at 0"
        found.append((f"roughness of the {name}", sigma, 0.5 * abs(high - low), note))
    numerical = result.efficiency_error / math.sqrt(3.0)
    found.append(("discretisation", math.nan, numerical, "the stated error as the ends of an even distribution"))

    variance = sum(row[2] ** 2 for row in found if math.isfinite(row[2]))
    sources = tuple(
        UncertaintySource(name, given, moved, moved**2 / variance if variance > 0.0 else 0.0, note)
        for name, given, moved, note in found
    )
    total = math.sqrt(variance)
    apart = math.sqrt(max(variance - (same**2 - independent**2 if math.isfinite(same) else 0.0), 0.0))
    reach = NormalDist().inv_cdf(0.5 + 0.5 * level) * total
    return EfficiencyUncertainty(
        result.efficiency,
        total,
        level,
        result.efficiency - reach,
        min(result.efficiency + reach, 1.0),
        apart,
        sources,
    )


def _formula_error(result: EfficiencyResult, friction: FrictionModel) -> tuple[float, float, str]:
    """Standard deviations of the efficiency by the friction model's own interval: all points alike, and independent."""
    estimate, points = result.friction, result.points
    if isinstance(estimate, SolvedFriction):
        known = 0.5 * (result.efficiency_upper - result.efficiency_lower) / NormalDist().inv_cdf(0.5 + 0.5 * _LEVEL_EHL)
        return known, known, "error of the mean over the solved contacts"
    half = 0.5 * (estimate.upper - estimate.lower)
    if not np.all(np.isfinite(half)):
        return math.nan, math.nan, "the model states no interval: its error is not in the result"
    level = friction.formula.interval.level if isinstance(friction, Formula) else _LEVEL_EHL
    sigma = half / NormalDist().inv_cdf(0.5 + 0.5 * level)
    # d efficiency / d loss
    slope = result.power_output / result.power_input**2 if result.driver == "gear" else 1.0 / result.power_input
    each = sigma * points.force * points.speed_sliding / result.positions
    same, independent = slope * float(each.sum()), slope * float(np.sqrt(np.sum(each**2)))
    return same, independent, f"all points wrong the same way; independent of each other they give {independent:.2g}"
