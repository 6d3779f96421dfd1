"""One evaluation: ease-off, machine settings, loaded contact in every state, and figures or the reason of failure."""

import hashlib
import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from efficiency.conditions.conditions import resolve_friction
from efficiency.design.design import Design
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.power_loss import loss_of
from efficiency.machine_settings.inputs import SettingsInput
from efficiency.machine_settings.settings_result import SettingsResult
from efficiency.machine_settings.solve import machine_settings
from efficiency.optimisation.problem import EDGE_FREE, START, SearchProblem, as_made, state_text, with_values
from efficiency.pair import GearPair
from ehl import __version__
from ehl.common.data import data_path
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.journal import Journal
from ehl.common.runner import Executor, run_tasks

_ROOT = ("root_stress_pinion", "root_stress_gear")
_LOSS = "power_loss"
Grid = tuple[int, int]


@dataclass(frozen=True)
class Evaluation:
    """One point of the search."""

    key: str  # hash of all inputs
    variables: dict[str, float]  # values of the variables, SI
    figures: dict[str, float] = field(default_factory=dict)  # figures over duty and states, SI; nan if unavailable
    reason: str = ""  # reason of failure; empty otherwise
    notes: tuple[str, ...] = ()  # notes of the machine settings
    seconds: float = 0.0  # wall time
    # of an exact evaluation: loss of the aligned pair over the duty with each uncertain input of friction at the lower
    # and the upper end of its interval [W]; ``"interval"`` holds both ends of the loss with all of them,
    # ``"aligned"`` the loss and its numerical error
    losses: dict[str, tuple[float, float]] = field(default_factory=dict)
    # loss of the aligned pair with the friction model of the check and its error [W]; empty without a check
    solved: tuple[float, ...] = ()

    def excess(self, allowed: Mapping[str, float]) -> dict[str, float]:
        """Relative excess of each figure above its limit; figures within their limits are omitted."""
        found = {}
        for name, limit in allowed.items():
            value = self.figures.get(name, math.nan)
            if not value <= limit:
                found[name] = value / limit - 1.0 if limit > 0.0 else math.inf
        return found

    def feasible(self, allowed: Mapping[str, float]) -> bool:
        """Whether the point has a result within all limits."""
        return not self.reason and not self.excess(allowed)


@dataclass(frozen=True)
class EvaluationTask:
    """Inputs of an evaluation."""

    problem: SearchProblem
    values: dict[str, float]  # values of the variables; empty for the start
    states: tuple[dict[str, float], ...]  # misalignments and manufacturing errors of the ease-off
    grid: Grid  # positions and points per line
    bodies: str = ""  # design (JSON) that provides elastic bodies and roots; empty for those of the point
    accepted: str = "converged"  # status of the settings of the start, accepted in addition to ``converged``
    solved: str = ""  # friction model that checks the loss of the aligned pair; empty for no check
    interval: bool = False  # whether the interval of the loss is computed

    @property
    def key(self) -> str:
        """Hash of all inputs of the figures, including the version of the program."""
        p = self.problem
        content = (
            *(__version__, p.start.model_dump_json(), p.flanks, p.figures, [asdict(row) for row in p.duty], p.over),
            *(_content("formulas", p.friction.removeprefix("strict:"), ".json"), p.friction.startswith("strict:")),
            *(_content("oils", p.oil, ".toml"), sorted(self.values.items()), self.states, self.grid),
            *(bool(self.bodies), self.accepted, self.solved, self.interval),
        )
        return hashlib.sha256(repr(content).encode()).hexdigest()[:24]

    def pair(self, design: Design) -> GearPair:
        """A pair with the elastic bodies of the task, or with its own."""
        return _reference(self.bodies).sharing_bodies(design) if self.bodies else GearPair(design)


def _content(folder: str, name: str, suffix: str) -> str:
    """Hash of the content of a user's or shipped file; else the name."""
    for path in (Path(name), data_path(folder, f"{name}{suffix}")):
        if path.is_file():
            return hashlib.sha256(path.read_bytes()).hexdigest()
    return name


def targets_of(problem: SearchProblem, values: Mapping[str, float], name: str = "") -> SettingsInput:
    """Initial targets with the variables at these values."""
    return with_values(problem.start, values, problem.flanks, name)


def settings_of(problem: SearchProblem, values: Mapping[str, float], name: str = "") -> SettingsResult:
    """Machine settings of the initial targets with the variables at these values."""
    return machine_settings(targets_of(problem, values, name), transmission=False)


def evaluate(task: EvaluationTask) -> Evaluation:
    """Figures of a point, or the reason of failure."""
    clock, found = time.perf_counter(), dict[str, Any]()
    try:
        made = _cut(task, targets_of(task.problem, task.values))
        pair = task.pair(made.design)
        if task.solved:
            results = duty_results(pair, task.problem, task.problem.states[0], task.grid, task.solved)
            found["solved"] = _mean_loss(task.problem, results)
        else:
            each = [state_figures(p, task.problem, s, task.grid) for p, s in _made(task, pair)]
            figures = over_states(each, task.problem)
            missing = [name for name, value in figures.items() if not math.isfinite(value)]
            if missing and task.values:  # for the start the caller reports missing figures
                raise ConvergenceError("no_data", f"no {', '.join(missing)}{missing_roots(pair, task.problem)}")
            losses = loss_interval(pair, task) if task.interval else {}
            found |= {"figures": figures, "notes": made.warnings, "losses": losses}
    except ConvergenceError as error:
        found["reason"] = f"{error.reason}: {error.detail}"
    except InputError as error:
        found["reason"] = str(error)
    return Evaluation(task.key, task.values, **found, seconds=time.perf_counter() - clock)


def _cut(task: EvaluationTask, inputs: SettingsInput, state: str = "") -> SettingsResult:
    """Machine settings of targets; `ConvergenceError` with the `state` unless their status is accepted."""
    made = machine_settings(inputs, transmission=False)
    if made.status not in ("converged", task.accepted):
        raise ConvergenceError(made.status, f"{state}{next(iter(made.warnings), '')}")
    return made


@lru_cache(maxsize=2)
def _reference(design: str) -> GearPair:
    """The pair whose elastic bodies are shared; computed once per process."""
    return GearPair(Design.model_validate_json(design))


def _made(task: EvaluationTask, pair: GearPair) -> Iterator[tuple[GearPair, dict[str, float]]]:
    """The pair in each state: as designed, or with machine settings for the ease-off with manufacturing errors."""
    designed = targets_of(task.problem, task.values)
    for state in task.states:
        inputs = as_made(designed, state, task.problem.flanks)
        if inputs is designed:
            yield pair, state
            continue
        yield task.pair(_cut(task, inputs, f"{state_text(state)}: ").design), state


def missing_roots(pair: GearPair, problem: SearchProblem) -> str:
    """Why teeth have no root stress; empty if they have one."""
    roots = pair.mesh(problem.duty[0].side, 4, 9).root_teeth()
    return "".join(f": {root}" for root in roots if isinstance(root, str))


def over_states(found: list[dict[str, float]], problem: SearchProblem) -> dict[str, float]:
    """Figures over all states from those of each: mean or maximum of the loss [W], worst of the others."""
    loss = np.mean if problem.over == "mean" else np.max
    return {name: float((loss if name == _LOSS else np.max)([figures[name] for figures in found])) for name in found[0]}


def state_figures(pair: GearPair, problem: SearchProblem, state: Mapping[str, float], grid: Grid) -> dict[str, float]:
    """Figures of a pair over the duty in one state: mean loss [W], worst of the others."""
    results = duty_results(pair, problem, state, grid)
    worst = {name: max(_figure(result, name) for result in results) for name in problem.figures if name != _LOSS}
    return {_LOSS: _mean_loss(problem, results)[0], **worst}


def duty_results(
    pair: GearPair, problem: SearchProblem, state: Mapping[str, float], grid: Grid, friction: str | None = None
) -> list[EfficiencyResult]:
    """Results of all operating points in one state; raises `ConvergenceError` if one has no result."""
    model = resolve_friction(friction or problem.friction, pair.design)
    own = pair.design.assembly.misalignment.model_dump()
    shifted = {name: own[name] + value for name, value in state.items() if name in own}
    results = []
    for row in problem.duty:
        result = pair.at(model, grid=grid, many=True, oil=problem.oil, **shifted, **row.condition)
        if result.reason:
            raise ConvergenceError(result.reason, f"{abs(row.torque):g} N m")
        results.append(result)
    return results


def loss_interval(pair: GearPair, task: EvaluationTask) -> dict[str, tuple[float, float]]:
    """`Evaluation.losses` of the aligned pair."""
    problem = task.problem
    results = duty_results(pair, problem, problem.states[0], task.grid)
    hours = np.array([row.hours for row in problem.duty])

    def mean(efficiencies: list[float]) -> float:
        operation = [(result.conditions, value) for result, value in zip(results, efficiencies, strict=True)]
        losses = [loss_of(value, at.torque, at.speed, at.driver) for at, value in operation]
        return float(np.average(losses, weights=hours))

    names = dict.fromkeys(source.name for result in results for source in result.inputs.sources)
    found = {
        name: (mean([_moved(r, name, "below") for r in results]), mean([_moved(r, name, "above") for r in results]))
        for name in names
    }
    ends = mean([r.efficiency_upper for r in results]), mean([r.efficiency_lower for r in results])
    return found | {"interval": ends, "aligned": _mean_loss(problem, results)}


def _moved(result: EfficiencyResult, name: str, end: str) -> float:
    moved = {source.name: float(getattr(source, end)) for source in result.inputs.sources}
    return moved.get(name, result.efficiency)


def _mean_loss(problem: SearchProblem, results: list[EfficiencyResult]) -> tuple[float, float]:
    """Loss over the duty and its error [W]."""
    hours = [row.hours for row in problem.duty]
    loss = float(np.average([r.power_loss for r in results], weights=hours))
    return loss, float(np.average([r.efficiency_error * r.power_input for r in results], weights=hours))


def _figure(result: EfficiencyResult, name: str) -> float:
    if name in _ROOT:
        return float(getattr(result.strength, name))
    if name == "pressure_flank":
        loaded = result.load.loaded
        return float(np.max(loaded["pressure_hertz"], where=loaded["at_edge"] < 0.5, initial=0.0))
    if name == "temperature_flash":
        return float(np.nanmax(result.lubrication.temperature_flash))
    return float(result.value(name))


def allowed_of(problem: SearchProblem, start: Evaluation) -> dict[str, float]:
    """Upper limit of each limited figure: a value, or the value of the start."""
    allowed = {}
    for name, limit in problem.limits.items():
        value = start.figures[name] if limit == START else float(limit)
        allowed[name] = max(value, EDGE_FREE) if name == "edge_load_share" and limit == START else value
    return allowed


def _row(task: EvaluationTask) -> dict[str, Any]:
    return asdict(evaluate(task))


def _crashed(task: EvaluationTask) -> dict[str, Any]:
    return asdict(Evaluation(task.key, task.values, reason="worker_lost: its worker crashed"))


def evaluate_all(
    tasks: list[EvaluationTask], executor: Executor, journal: Journal, done: Callable[[], None] = lambda: None
) -> list[Evaluation]:
    """Evaluations of tasks in their order; those in the journal are read, the others are computed."""
    found = []
    for row in run_tasks(tasks, _row, executor=executor, journal=journal, crashed=_crashed):
        losses = {name: tuple(ends) for name, ends in row["losses"].items()}
        known = {**row, "losses": losses, "notes": tuple(row["notes"]), "solved": tuple(row["solved"])}
        found.append(Evaluation(**known))
        done()
    return found
