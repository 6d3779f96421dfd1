"""Repeated computation of cases of a dataset, to compare the present solver with the stored results."""

from collections.abc import Hashable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ehl.common.errors import InputError
from ehl.contact import Contact
from regression.data.dataset import Dataset
from regression.friction.conditions import STATE_UNITS
from regression.plan.plan import Plan
from regression.sweeping.evaluators import Evaluator, fallback_settings, input_row, solve_outputs

SHARE = 0.01
# what distinguishes the cases of a plan
_IDENTITY = (*(STATE_UNITS.keys() - {"effective_modulus", "roughness_rms_2"}), "boundary_friction", "seed")


@dataclass(frozen=True)
class Rerun:
    """One case computed again."""

    key: str  # of the row in the dataset
    stored: float  # friction coefficient of the dataset
    computed: float  # friction coefficient of the present solver
    error: float  # stated relative errors of both, combined
    seconds: float  # stored CPU time

    @property
    def difference(self) -> float:
        """|computed/stored - 1|."""
        return abs(self.computed / self.stored - 1.0)


def rerun(
    dataset: Dataset,
    plan: Plan,
    *,
    share: float = SHARE,
    seed: int = 1,
    evaluate: Evaluator = solve_outputs,
) -> Iterator[Rerun]:
    """Compute a random share of a dataset's cases again.

    plan: plan of the dataset.
    share: share of the cases of the plan.
    seed: seed of the random choice.
    Raises `InputError`: a case of the plan is not in the dataset; `ConvergenceError`: a case with a stored result has
    no result now.
    """
    order = np.random.default_rng(seed).permutation(len(plan.points))
    remaining = max(int(np.ceil(share * len(order))), 1)
    for index in order:
        if remaining == 0:
            return
        case = plan.case_at(int(index))
        row = row_of(dataset, case)
        if row["status"] == "failed":
            continue
        remaining -= 1
        setting = fallback_settings(case, max(int(row["attempts"]) - 1, 0))
        outputs = evaluate(case if setting is None else setting[0])
        yield Rerun(
            str(row["key"]),
            float(row["friction_coefficient"]),
            float(outputs["friction_coefficient"]),
            float(np.hypot(float(row["friction_error"]), float(outputs.get("friction_error", 0.0)))),
            float(row["seconds_cpu"]),
        )


def row_of(dataset: Dataset, case: Contact) -> dict[Hashable, Any]:
    """The row of a case, found by its inputs because its key depends on the version of the solver."""
    inputs, frame = input_row(case), dataset.frame
    here = frame["oil"] == inputs["oil"]
    for name in _IDENTITY:
        here &= np.isclose(frame[name], float(inputs[name]), rtol=1e-9, atol=0.0)
    if not here.any():
        hint = "Use the plan of this dataset."
        raise InputError("plan", dataset.plan_name, "the plan of the dataset", hint)
    return frame[here].iloc[0].to_dict()
