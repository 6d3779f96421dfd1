"""The adaptive sweep: batches of further cases where a surrogate of the friction is least certain of what matters.

plan swept -> surrogate -> points of largest weighted variance -> computed -> ... until the cross-validated error stops
improving or the budget is spent. Failed cases are recorded with their reason and count as visited.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd

from ehl.io.errors import InputError
from regression.data.dataset import load_dataset
from regression.plan.constraints import constrained_quantities
from regression.plan.plan import Plan
from regression.plan.sampling import Array, BoxSampler, lattice
from regression.sweeping.surrogate import FrictionSurrogate, choose_batch, fit_surrogate
from regression.sweeping.sweep import (
    PlannedCase,
    SweepOptions,
    SweepReport,
    compute_cases,
    run_meta,
    shard_path,
    sweep_shard,
)

# candidates for a batch, all combinations of the lists together
CANDIDATES = 1024
# results a surrogate needs for each of its inputs
MIN_RESULTS_PER_INPUT = 4
BATCH_FILE = "adaptive.json"
# apart from the seeds of the plan and of the other batches
_SEED_STEP = 1_000_003
_SCHEMA = 1


@dataclass(frozen=True)
class SurrogateScore:
    """Error of the surrogate after so many cases: leave-one-out errors of ln mu at the plan's own points.

    Parameters
    ----------
    cases : int
        Cases with a result.
    weighted : float
        Root of the mean square, weighted as the batches are; the sweep ends when this stops falling.
    p95 : float
        95 % of the errors are smaller.
    """

    cases: int
    weighted: float
    p95: float

    def __str__(self) -> str:
        error = f"{100.0 * self.weighted:.2g} % weighted, {100.0 * self.p95:.2g} % at 95 %"
        return f"{self.cases} results: cross-validated error of mu {error}"


@dataclass(frozen=True)
class AdaptiveReport:
    """What an adaptive sweep did.

    Parameters
    ----------
    scores : tuple of SurrogateScore
        After the plan, and after each batch.
    batches : int
        Batches computed, those of earlier calls included.
    ended : str
        ``budget`` or ``no_gain``.
    sweeps : tuple of SweepReport
        Of the plan and of each batch.
    """

    scores: tuple[SurrogateScore, ...]
    batches: int
    ended: str
    sweeps: tuple[SweepReport, ...]


@dataclass(frozen=True)
class BatchPoint:
    """A point of a batch; `values` are those of the plan's variables."""

    values: dict[str, float]
    oil: str | None
    seed: int | None


@dataclass(frozen=True)
class PointBatch:
    """Points chosen together, and the score that was known then."""

    score: SurrogateScore
    points: tuple[BatchPoint, ...]


def adaptive_sweep(
    plan: Plan, folder: Path, *, notify: Callable[[SurrogateScore], None] | None = None, **options: Any
) -> AdaptiveReport:
    """Sweep a plan and add batches of cases by its `[adaptive]` table; the same call resumes.

    The points of a batch are written to disk before they are computed, so that a killed run resumes with the same ones.

    Parameters
    ----------
    plan : Plan
        Its ranges are the box the further points lie in.
    folder : Path
        Folder of the results.
    notify : callable, optional
        Called with each score.
    **options
        Fields of `regression.sweeping.sweep.SweepOptions`.

    Raises
    ------
    InputError
        The plan has no ranges, too few cases for a surrogate, or the record of the batches cannot be used.
    """
    from threadpoolctl import threadpool_limits

    given = SweepOptions(**options)
    if not any(axis.sampled for axis in plan.axes.values()):
        raise InputError("variables", "no range", "at least one range for an adaptive sweep")
    if plan.adaptive.budget <= plan.count:
        hint = "The budget counts the cases of the plan too."
        raise InputError("adaptive.budget", plan.adaptive.budget, f"more than the plan's {plan.count} cases", hint)
    sweeps = [sweep_shard(plan, folder, **options)]
    path, record = shard_path(folder, 1, 1), folder / BATCH_FILE
    batches = _read_batches(record, plan)
    # the batches of an earlier call come first, so that a run ends as if it had not been interrupted
    for batch in batches:
        sweeps.append(_compute(plan, path, batch.points, given))
    scores = [batch.score for batch in batches]
    while True:
        with threadpool_limits(1):
            data = _Data.of(plan, folder)
            scores.append(data.score())
            if notify is not None:
                notify(scores[-1])
            remaining = (plan.adaptive.budget - len(data.frame)) // plan.sampling.realisations
            if _settled(scores, plan.adaptive.gain) or remaining < 1:
                ended: Literal["budget", "no_gain"] = "budget" if remaining < 1 else "no_gain"
                return AdaptiveReport(tuple(scores), len(batches), ended, tuple(sweeps))
            points = data.choose(min(plan.adaptive.batch, remaining), len(batches))
        batches.append(PointBatch(scores[-1], points))
        _write_batches(record, plan, batches)
        sweeps.append(_compute(plan, path, points, given))


def _settled(scores: Sequence[SurrogateScore], gain: float) -> bool:
    """Whether the last two batches together lowered the error by less than `gain` of it."""
    return len(scores) > 2 and scores[-1].weighted > (1.0 - gain) * scores[-3].weighted


@dataclass(frozen=True)
class _Data:
    """What is on disk, and the surrogate of it."""

    plan: Plan
    frame: pd.DataFrame
    surrogate: FrictionSurrogate
    span: float

    @classmethod
    def of(cls, plan: Plan, folder: Path) -> _Data:
        frame = load_dataset(folder).frame
        usable = (frame["status"] != "failed") & (frame["friction_coefficient"] > 0.0)
        table = {str(name): frame[name].to_numpy() for name in frame}
        span = _span(table)
        inputs = _inputs(plan, table, span)
        minimum = MIN_RESULTS_PER_INPUT * inputs.shape[1]
        if np.count_nonzero(usable) < minimum:
            hint = "Increase sampling.size."
            raise InputError("sampling.size", int(np.count_nonzero(usable)), f"at least {minimum} results", hint)
        known = frame[usable]
        error = np.nan_to_num(known["friction_error"].to_numpy(), nan=0.0)
        log_mu = np.log(known["friction_coefficient"].to_numpy())
        surrogate = fit_surrogate(inputs[usable], log_mu, error, inputs[~usable])
        # the rows in the order of the surrogate: those with a result first
        return cls(plan, pd.concat([known, frame[~usable]], ignore_index=True), surrogate, span)

    def score(self) -> SurrogateScore:
        """Leave-one-out errors at the plan's own points, which fill the box evenly."""
        known = self.frame.iloc[: self.surrogate.results]
        own = (known["origin"] != "adaptive").to_numpy()
        error = np.abs(self.surrogate.residual[own])
        weight = _weight(self.plan, {str(name): known[name].to_numpy()[own] for name in known})
        mean_square = float(np.sum(weight * error**2) / np.sum(weight))
        return SurrogateScore(self.surrogate.results, mean_square**0.5, float(np.quantile(error, 0.95)))

    def choose(self, size: int, batch: int) -> tuple[BatchPoint, ...]:
        """The points of the next batch."""
        plan = self.plan
        oils: Sequence[str | None] = plan.oils or (None,)
        combinations = [(oil, fixed) for oil in oils for fixed in lattice(plan.axes)]
        # a sequence of its own for every batch
        sampler = BoxSampler(plan.axes, "sobol", plan.sampling.seed + _SEED_STEP * (batch + 1))
        each = max(64, CANDIDATES // len(combinations))
        parts = []
        for oil, fixed in combinations:
            block = sampler.inside(each, plan.constraint_filter(fixed, oil))
            columns = {**{name: np.full(each, value) for name, value in fixed.items()}, **block.columns}
            parts.append((oil, block.number, columns))
        columns = {name: np.concatenate([part[2][name] for part in parts]) for name in plan.axes}
        names = [oil for oil, number, _ in parts for _ in number]
        table = {**columns, **plan.conditions(columns, names)}
        chosen = choose_batch(self.surrogate, _inputs(plan, table, self.span), _weight(plan, table), size)
        number = np.concatenate([part[1] for part in parts])[chosen] + _SEED_STEP * (batch + 1)
        seeds = plan.roughness_seeds(number)
        repeat = plan.sampling.realisations
        return tuple(
            BatchPoint(
                {name: float(column[index]) for name, column in columns.items()},
                names[index],
                None if seeds is None else int(seeds[position * repeat + k]),
            )
            for position, index in enumerate(chosen)
            for k in range(repeat)
        )


def _weight(plan: Plan, table: Mapping[str, Array]) -> Array:
    """Weight of the variance at each point: a column of the plan's choice, one in the mean."""
    if plan.adaptive.weight == "uniform":
        return np.ones(len(table["pressure_hertz"]))
    weight = constrained_quantities(table, plan.bodies, None)[plan.adaptive.weight]
    return np.asarray(weight / weight.mean())


def _span(table: Mapping[str, Array]) -> float:
    """Standard deviation of the logarithm of the film ratio; 0 for smooth surfaces."""
    ratio = table["film_ratio_formula"]
    return float(np.log(ratio).std()) if np.isfinite(ratio).all() else 0.0


def _inputs(plan: Plan, table: Mapping[str, Array], span: float) -> Array:
    """Standardised inputs: the ranges as a unit cube, lists by their span, oils by viscosity, ln of the film ratio."""
    values = dict(table)
    values["lengthwise_to_roll"] = values["speed_sliding_lengthwise"] / values["speed_entrainment"]
    unit = BoxSampler(plan.axes, "sobol", 0).unit(values)
    extra = []
    for name, axis in plan.axes.items():
        if not axis.sampled and len(axis.values) > 1:
            extra.append((values[name] - axis.values[0]) / (max(axis.values) - min(axis.values)))
    if len(plan.oils) > 1:
        extra += [np.log(values["viscosity_inlet"]), np.log(values["pressure_viscosity"] * 1e8)]
    if span > 0.0:
        extra.append(np.log(values["film_ratio_formula"]) / span)
    return np.column_stack([unit, *extra])


def _compute(plan: Plan, path: Path, points: tuple[BatchPoint, ...], options: SweepOptions) -> SweepReport:
    columns = {name: np.array([point.values[name] for point in points]) for name in plan.axes}
    cost, _ = plan.contact_seconds(columns, [point.oil for point in points])
    cases = [PlannedCase("adaptive", partial(plan.case, p.values, oil=p.oil, seed=p.seed)) for p in points]
    return compute_cases(path, run_meta(plan, options.version), cases, cost, options)


def _write_batches(path: Path, plan: Plan, batches: Sequence[PointBatch]) -> None:
    content = {"schema": _SCHEMA, "plan_hash": plan.plan_hash, "batches": [asdict(batch) for batch in batches]}
    draft = path.with_suffix(".new")
    try:
        draft.write_text(json.dumps(content))
        draft.replace(path)
    except OSError as error:
        raise InputError(
            "run", str(path), "a disk that can be written", f"{error}. Free some space and repeat the command."
        ) from None


def _read_batches(path: Path, plan: Plan) -> list[PointBatch]:
    if not os.path.exists(path):
        return []
    try:
        content = json.loads(path.read_text())
        if content["schema"] != _SCHEMA or content["plan_hash"] != plan.plan_hash:
            raise ValueError("it belongs to another plan or version")
        return [
            PointBatch(SurrogateScore(**batch["score"]), tuple(BatchPoint(**point) for point in batch["points"]))
            for batch in content["batches"]
        ]
    except (OSError, ValueError, KeyError, TypeError) as error:
        hint = f"{error}. Move it away: its batches are chosen again, their results are kept."
        raise InputError("run", str(path), "the record of this plan's batches", hint) from None
