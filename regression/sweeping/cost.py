"""How long the cases of a plan will take, before any is computed: for the estimate a user sees, and the order of work.

A rough contact by the deterministic solver costs nodes times steps: both grow with the half-width over the correlation
length, both change with the film ratio. The coefficients are least squares of ln(seconds) on contacts of the default
plan's ranges on one core; `benchmarks/sweep_cost.py` fits them to any finished run and says what the estimate is worth.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ehl.rough.mixed import roughness_matters
from regression.friction.conditions import derive
from regression.plan.plan import Plan
from regression.plan.points import lubricant_table, state_table

Array = NDArray[np.float64]

# seconds of the smooth solution with its heat, by accuracy
SMOOTH: dict[str, float] = {"fast": 0.07, "standard": 0.3, "reference": 2.0}
# shape of ln(seconds) of a rough run: q, l, q^2, l^2, q l with q = ln(b/lc), l = ln(film ratio); 1474 contacts, fast
ROUGH = (-0.753, -0.265, 0.391, 0.200, -0.036)
# by accuracy: the constant, and the factor that makes a sum over many cases right; standard rests on 24 contacts,
# reference on a few: orders of magnitude only
LEVEL: dict[str, tuple[float, float]] = {"fast": (-1.535, 1.13), "standard": (0.6, 1.3), "reference": (3.4, 1.0)}


@dataclass(frozen=True)
class CostEstimate:
    """What a plan will cost.

    Parameters
    ----------
    cases : int
        Of the plan.
    rough : int
        Of these, rolled through in time.
    seconds : float
        CPU time of all cases.
    longest : float
        Of the longest case [s].
    """

    cases: int
    rough: int
    seconds: float
    longest: float

    def wall(self, jobs: int) -> float:
        """Wall time with so many workers [s]: never shorter than the longest case."""
        return max(self.seconds / jobs, self.longest)


def estimate_cost(plan: Plan) -> CostEstimate:
    """The cost of a plan."""
    points = plan.points
    matters, _, _ = _rough(plan, points.columns, points.oils)
    seconds = case_seconds(plan)
    return CostEstimate(len(seconds), int(np.count_nonzero(matters)), float(seconds.sum()), float(seconds.max()))


def case_seconds(plan: Plan) -> Array:
    """Estimated seconds of every case of a plan, in its order."""
    return points_seconds(plan, plan.points.columns, plan.points.oils)


def points_seconds(plan: Plan, columns: Mapping[str, Array], oils: Sequence[str | None]) -> Array:
    """Estimated seconds of cases at points given by values of the plan's variables and their oils."""
    matters, width, ratio = _rough(plan, columns, oils)
    accuracy = plan.model.accuracy
    seconds = np.full(matters.shape, SMOOTH[accuracy])
    constant, factor = LEVEL[accuracy]
    seconds[matters] += factor * np.exp(constant + cost_terms(width[matters], ratio[matters]) @ np.array(ROUGH))
    return seconds


def cost_terms(width: Array, ratio: Array) -> Array:
    """Columns beside the constant in the model of ln(seconds), from b over the correlation length and film ratio."""
    q, film = np.log(width), np.log(ratio)
    return np.column_stack([q, film, q * q, film * film, q * film])


def _rough(
    plan: Plan, columns: Mapping[str, Array], oils: Sequence[str | None]
) -> tuple[NDArray[np.bool_], Array, Array]:
    """Which cases are rolled through in time; half-width over correlation length and film ratio of all."""
    size = len(oils)
    if plan.model.roughness == "load_sharing":
        return np.zeros(size, dtype=bool), np.ones(size), np.ones(size)
    table = derive({**state_table(plan, columns, size), **lubricant_table(plan, columns, oils)})
    ratio = table["film_ratio_formula"]
    length = columns.get("correlation_length", np.full(size, plan.surface.correlation_length))
    matters = np.array([np.isfinite(x) and roughness_matters(float(x), plan.model) for x in ratio], dtype=bool)
    return matters, table["half_width"] / length, ratio
