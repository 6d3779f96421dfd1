"""How long contacts will take to solve: for the estimate a user sees, and for the order of computation.

A rough contact costs nodes times steps: both grow with the half-width over the correlation
length, with thin films, and with the roughness over what the Hertz pressure flattens. The coefficients are least
squares of ln(seconds) on the rough contacts of the shipped datasets, each on one core;
`validation/sweep_cost.py` fits them to finished runs and prints the error of the estimate, held out too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ehl.common.arrays import FloatArray
from ehl.common.duration import duration
from ehl.common.errors import InputError
from ehl.common.runner import MAX_JOBS, granted_workers
from ehl.inputs import ModelInput
from ehl.rough.accuracy import BOUND, WORK
from ehl.rough.mixed import roughness_matters

# seconds of the smooth solution with its heat, by accuracy
SMOOTH: dict[str, float] = {"fast": 0.05, "standard": 0.15, "reference": 1.0}
# shape of ln(seconds) of a rough run: q, l, d, q^2, q l, q d, l^2, l d, d^2 with q = ln(b/lc), l = ln(film ratio),
# d = ln(Rq R/b^2)
ROUGH = (0.145, -0.195, 0.549, 0.163, 0.130, 0.071, 0.024, 0.178, 0.100)
# by accuracy: the constant, and the factor that makes a sum over many cases right; standard rests on 8 contacts,
# reference on a few of an earlier engine: orders of magnitude
LEVEL: dict[str, tuple[float, float]] = {"fast": (-1.57, 1.1), "standard": (-0.02, 1.1), "reference": (2.4, 1.1)}
# of the work of a run that the solver allows (`ehl.rough.accuracy.WORK`): time of a node-iteration [s], and runs of a
# contact whose roughness is finer than its mesh
NODE_ITERATION, RUNS = 1.5e-7, 4


@dataclass(frozen=True)
class CostEstimate:
    """What a plan will cost."""

    # name of the plan; accuracy of its contacts
    plan: str
    accuracy: str
    cases: int  # of the plan
    rough: int  # of these, transient rough contacts
    seconds: float  # CPU time of all cases [s]
    longest: float  # of the longest case [s]
    # ConstraintWindow of the constraints to the share of the points drawn that lie outside of it
    rejected: dict[str, float]

    def wall(self, jobs: int) -> float:
        """Wall time with so many workers [s]: never shorter than the longest case."""
        return max(self.seconds / jobs, self.longest)

    def to_text(self, jobs: int | None = None) -> str:
        """The estimate in words, with the wall time for so many workers; for all processors by default."""
        jobs = granted_workers() if jobs is None else jobs
        if not 1 <= jobs <= MAX_JOBS:
            raise InputError("jobs", jobs, f"at least 1, at most {MAX_JOBS}")
        rough = f", {self.rough} of them transient rough contacts" if self.rough else ""
        lines = [f"{self.plan}: {self.cases} cases ({self.accuracy}){rough}"]
        for name, share in sorted(self.rejected.items(), key=lambda item: -item[1]):
            lines.append(f"  {100.0 * share:.0f} % of the points drawn lie outside constraints.{name}")
        workers = f"{jobs} {'worker' if jobs == 1 else 'workers'}"
        longest = duration(self.longest) if self.longest >= 1.0 else "under 1 s"
        lines.append(
            f"about {duration(self.seconds)} of CPU time, {duration(self.wall(jobs))} with {workers}, longest "
            f"case {longest}; single cases may take twice or half of it, few of them five times as long"
        )
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.to_text()


def contact_seconds(model: ModelInput, table: Mapping[str, FloatArray]) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Estimated seconds of contacts, and which of them are transient rough contacts.

    model: model and accuracy of the contact solver.
    table: `regression.friction.conditions.conditions_of` the contacts, and their correlation length.
    Returns: no contact above the work that the solver allows, however far outside the fitted range.
    """
    seconds = np.full(table["pressure_hertz"].shape, SMOOTH[model.accuracy])
    rough = np.zeros(seconds.shape, dtype=bool)
    films = zip(*_hot_film(table), strict=True)
    rough |= [math.isfinite(ratio) and roughness_matters(ratio, model, stress) for ratio, stress in films]
    constant, factor = LEVEL[model.accuracy]
    terms = cost_terms(table)[rough]
    most = RUNS * BOUND * WORK[model.accuracy] * NODE_ITERATION
    seconds[rough] += np.minimum(factor * np.exp(np.minimum(constant + terms @ np.array(ROUGH), 100.0)), most)
    return seconds, rough


def _hot_film(table: Mapping[str, FloatArray]) -> tuple[list[float], list[float]]:
    """Film ratio with the heat of the inlet (Wilson & Gupta), and shear stress over the Eyring stress, as estimated.

    A cold film says that contacts at 20 m/s are smooth, some of which are the longest of all.
    """
    loading = table["viscosity_inlet"] * table["temperature_viscosity"] * table["speed_entrainment"] ** 2
    loading = loading / table["thermal_conductivity"]
    factor = 1.0 / (1.0 + 0.1 * (1.0 + 14.8 * table["slide_to_roll_total"] ** 0.83) * loading**0.64)
    with np.errstate(divide="ignore", invalid="ignore"):
        viscous = table["viscosity_mean_pressure"] * table["speed_sliding"] / (factor * table["film_formula"])
        stress = np.arcsinh(viscous / table["eyring_stress"])
    # without sliding there is no friction that roughness could change; without an Eyring stress nothing is known
    stress = np.where(np.isfinite(stress) & (stress > 0.0), stress, np.inf)
    return (factor * table["film_ratio_formula"]).tolist(), stress.tolist()


def cost_terms(table: Mapping[str, FloatArray]) -> FloatArray:
    """Terms of the model of ln(seconds) besides the constant; not finite where a contact is smooth."""
    with np.errstate(divide="ignore", invalid="ignore"):
        q = np.log(table["half_width"] / table["correlation_length"])
        film = np.log(table["film_ratio_formula"])
        height = np.log(table["roughness_rms"] * table["radius_equivalent"] / table["half_width"] ** 2)
        terms = (q, film, height, q * q, q * film, q * height, film * film, film * height, height * height)
        return np.column_stack(terms)
