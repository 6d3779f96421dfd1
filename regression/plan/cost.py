"""Computation time of contacts: for the estimate shown to the user, and for the order of computation.

The time of a rough contact is proportional to nodes times steps. Both increase with the ratio of half-width to
correlation length, with decreasing film, and with the ratio of roughness to the deformation by the Hertz pressure. The
coefficients are a least squares fit of ln(seconds) to the rough contacts of the shipped datasets, each on one core;
`validation/sweep_cost.py` fits them to finished runs and prints the error of the estimate, also for held-out cases.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ehl.common.arrays import FloatArray
from ehl.common.errors import check_count
from ehl.common.progress import counted, duration
from ehl.common.runner import MAX_JOBS, granted_workers
from ehl.common.units import ValueRange
from ehl.inputs import ModelInput
from ehl.rough.accuracy import BOUND, WORK
from ehl.rough.mixed import roughness_matters
from regression.friction.conditions import inlet_heating

# seconds of the smooth solution with thermal effects, by accuracy
SMOOTH: dict[str, float] = {"fast": 0.05, "standard": 0.15, "reference": 1.0}
# coefficients of ln(seconds) of a rough run: q, l, d, q^2, q l, q d, l^2, l d, d^2 with q = ln(b/lc),
# l = ln(film ratio), d = ln(Rq R/b^2)
ROUGH = (0.145, -0.195, 0.549, 0.163, 0.130, 0.071, 0.024, 0.178, 0.100)
# by accuracy: the constant, and the factor that corrects the sum over many cases; standard was fitted to 8 contacts,
# reference to a few contacts of an earlier solver (orders of magnitude)
LEVEL: dict[str, tuple[float, float]] = {"fast": (-1.83, 1.1), "standard": (-0.02, 1.1), "reference": (2.4, 1.1)}
# limit of the work of a run (`ehl.rough.accuracy.WORK`): time of a node-iteration [s], and runs of a
# contact whose roughness is finer than its mesh
NODE_ITERATION, RUNS = 1.5e-7, 4

ALLOWED_TIME_CAP = ValueRange("s", gt=0.0, le=1e8)


@dataclass(frozen=True)
class CostEstimate:
    """Estimated computation time of a plan."""

    plan: str  # its name
    accuracy: str  # of its contacts
    cases: int
    rough: int  # transient rough contacts among the cases
    seconds: float  # CPU time of all cases [s]
    longest: float  # CPU time of the longest case [s]
    rejected: dict[str, float]  # name of each constraint to the share of the drawn points outside of it

    def wall(self, jobs: int) -> float:
        """Wall time with a number of workers [s]: at least the time of the longest case."""
        return max(self.seconds / jobs, self.longest)

    def to_text(self, jobs: int | None = None) -> str:
        """The estimate as text, with the wall time for a number of workers (default: all processors)."""
        jobs = granted_workers() if jobs is None else jobs
        check_count("jobs", jobs, 1, MAX_JOBS)
        rough = f", {self.rough} of them rough and transient" if self.rough else ""
        lines = [f"{self.plan}: {counted(self.cases, 'case')} ({self.accuracy}){rough}"]
        for name, share in sorted(self.rejected.items(), key=lambda item: -item[1]):
            lines.append(f"  {100.0 * share:.0f} % of the points drawn lie outside constraints.{name}")
        longest = duration(self.longest) if self.longest >= 1.0 else "under 1 s"
        lines.append(
            f"about {duration(self.seconds)} of CPU time, {duration(self.wall(jobs))} with {counted(jobs, 'worker')}, "
            f"longest case {longest}; the estimate for a single case is accurate within a factor of two, rarely five"
        )
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.to_text()


def contact_seconds(model: ModelInput, table: Mapping[str, FloatArray]) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Estimated seconds of contacts, and which of them are transient rough contacts.

    model: model and accuracy of the contact solver.
    table: result of `regression.friction.conditions.conditions_of`, and the correlation length.
    Returns: seconds are limited by the largest work of the solver, also far outside the fitted range.
    """
    seconds = np.full(table["pressure_hertz"].shape, SMOOTH[model.accuracy])
    films = zip(*_hot_film(table), strict=True)
    rough = np.array([math.isfinite(film) and roughness_matters(film, model, stress) for film, stress in films], bool)
    constant, factor = LEVEL[model.accuracy]
    terms = cost_terms(table)[rough]
    most = RUNS * BOUND * WORK[model.accuracy] * NODE_ITERATION
    seconds[rough] += np.minimum(factor * np.exp(np.minimum(constant + terms @ np.array(ROUGH), 100.0)), most)
    return seconds, rough


def _hot_film(table: Mapping[str, FloatArray]) -> tuple[list[float], list[float]]:
    """Estimated film ratio with inlet shear heating (Gupta), and shear stress over the Eyring stress.

    With isothermal films contacts at 20 m/s would be classified as smooth, some of which take the longest.
    """
    factor = inlet_heating(table)
    with np.errstate(divide="ignore", invalid="ignore"):
        viscous = table["viscosity_mean_pressure"] * table["speed_sliding"] / (factor * table["film_formula"])
        stress = np.arcsinh(viscous / table["eyring_stress"])
    # without sliding or Eyring stress the stress ratio is not limited
    stress = np.where(np.isfinite(stress) & (stress > 0.0), stress, np.inf)
    return (factor * table["film_ratio_formula"]).tolist(), stress.tolist()


def cost_terms(table: Mapping[str, FloatArray]) -> FloatArray:
    """Terms of the model of ln(seconds) without the constant; not finite where a contact is smooth."""
    with np.errstate(divide="ignore", invalid="ignore"):
        q = np.log(table["half_width"] / table["correlation_length"])
        film = np.log(table["film_ratio_formula"])
        height = np.log(table["roughness_rms"] * table["radius_equivalent"] / table["half_width"] ** 2)
        terms = (q, film, height, q * q, q * film, q * height, film * film, film * height, height * height)
        return np.column_stack(terms)
