"""The search: start -> points about it -> batches where improvement is expected -> exact check of the best.

Each evaluation is written down when it ends, and each batch follows from the evaluations before it and the seed alone:
a run that was killed goes on where it was and ends with the same front, whatever the number of worker processes.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from efficiency.loss.duty import DutyRow, read_duty
from efficiency.loss.efficiency_result import Output, Presented
from efficiency.loss.ehl_friction import ehl_friction
from efficiency.optimisation.evaluation import (
    Evaluation,
    Store,
    Task,
    allowed_of,
    evaluate_all,
    missing_roots,
    over_states,
    settings_of,
)
from efficiency.optimisation.pareto import non_dominated, spread_out
from efficiency.optimisation.problem import (
    Flanks,
    Over,
    Problem,
    box_states,
    checked_limits,
    checked_objectives,
    variables_of,
)
from efficiency.optimisation.surrogate import Processes, first_points, next_points, table_of, transformed
from efficiency.pair import POINTS_PER_LINE, POSITIONS, GearPair, default_friction, resolve_friction
from efficiency.synthesis.inputs import SettingsInput, load_targets, targets_beside
from efficiency.synthesis.settings_result import SettingsResult
from ehl import __version__
from ehl.fluid.oil import Oil
from ehl.io.data import named_file
from ehl.io.errors import ConvergenceError, InputError
from ehl.io.files import write_file
from ehl.io.numbers import finite_or_none
from ehl.io.validation import read_toml
from ehl.quantities import quantities
from ehl.uncertainty.result import Change, combined
from regression.plan.cost import checked_jobs
from regression.sweeping.executors import Executor, ThisProcess, cluster, local_executor

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]

EVALUATIONS, BATCH, CHECKED = 120, 4, 4
"""Default numbers: evaluations of a search, points of a batch, points of the front that are checked exactly."""
MAX_EVALUATIONS = 20_000
SEARCH_GRID, CHECK_GRID = (8, 31), (POSITIONS, POINTS_PER_LINE)
"""Positions and points per line of search and check; fewer points tell the greatest pressure 3 to 14 % too low."""
# spread-out points before the first batch, for each variable; evaluations between two fits of the length scales
_FIRST, _REFIT = 4, 24
# states of a search: with more of them it takes three
_MAX_STATES = 5
# times that points are checked until one keeps the limits
_CHECKS = 3
# the search keeps so far below limits, for what the coarse mesh and shared bodies are off (ours; measured in the docs)
_MARGIN = 0.015
# share of the evaluations after which the best point is checked for the limits of the rest; the most they are tightened
_LEARN_AT, _MOST_LEARNT = 2 / 3, 0.1
# tightened by less than this, a limit is not worth a note
_WORTH_TELLING = 5e-4


@dataclass(frozen=True)
class Candidate:
    """A point of the front after its exact check: full mesh, own elastic bodies, all states.

    Attributes
    ----------
    name : str
        Of its design.
    point : Evaluation
        As the search saw it.
    exact : Evaluation
        Exact figures, with the interval of the loss.
    start : Evaluation
        The start, exact as well.
    allowed : dict
        Limits, with the exact figures of the start.
    """

    name: str
    point: Evaluation
    exact: Evaluation
    start: Evaluation
    allowed: dict[str, float]

    def change(self, name: str) -> float:
        """Change of a figure against the start, in shares of it; nan where the start has none [-]."""
        old = self.start.figures.get(name, math.nan)
        return self.exact.figures.get(name, math.nan) / old - 1.0 if old else math.nan

    @property
    def holds(self) -> bool:
        """Whether the exact figures keep all limits."""
        return self.exact.feasible(self.allowed)

    @property
    def gain(self) -> float:
        """Share of the loss that is saved [-]."""
        return -self.change("power_loss")

    @property
    def gain_interval(self) -> tuple[float, float]:
        """90 % interval of the gain of the aligned pair: each uncertain input wrong the same way before and after."""
        if not self.exact.losses or not self.start.losses:
            return math.nan, math.nan
        new, old = self.exact.losses, self.start.losses
        ratio = math.log(new["aligned"][0] / old["aligned"][0])
        changes = [
            Change(
                name,
                group="",
                sd=math.nan,
                below=math.log(new[name][0] / old[name][0]) - ratio,
                above=math.log(new[name][1] / old[name][1]) - ratio,
            )
            for name in new
            if name in old and name not in ("aligned", "interval")
        ]
        low, high = (float(end) for end in combined(changes))
        return 1.0 - math.exp(ratio + high), 1.0 - math.exp(ratio + low)

    @property
    def solved_gain(self) -> tuple[float, float]:
        """Gain of the aligned pair with the friction model of the check, and its error; nan where not asked for."""
        if not self.exact.solved or not self.start.solved:
            return math.nan, math.nan
        (new, new_error), (old, old_error) = self.exact.solved, self.start.solved
        return 1.0 - new / old, new / old * math.hypot(new_error / new, old_error / old)

    @property
    def verdict(self) -> str:
        """In words: whether the limits hold, and whether the gain is beyond what is not known of the friction."""
        if self.exact.reason:
            return self.exact.reason
        above = [f"{name} {100.0 * share:+.1f} %" for name, share in self.exact.excess(self.allowed).items()]
        if above:
            return "above the limit: " + ", ".join(above)
        low, _ = self.gain_interval
        return "gain certain at 90 %" if low > 0.0 else "gain smaller than the uncertainty of friction"


@dataclass(frozen=True, repr=False)
class Optimisation(Presented):
    """What a search for the pair that loses less has found; SI units.

    Parameters
    ----------
    name : str
        Of the targets it started from.
    problem : Problem
        Variables, objectives, limits, duty, states, friction.
    start : Evaluation
        The start on the mesh of the search.
    allowed : dict
        Limits on that mesh.
    evaluations : tuple of Evaluation
        All points, the start first.
    candidates : tuple of Candidate
        Points that were checked, in that order.
    search_states : tuple of dict
        Misalignments of the search; the check takes all of the problem.
    notes : tuple of str
        What to know of the run.
    seed, jobs, reused : int
        Of the random numbers; worker processes; evaluations that an earlier run had computed.
    seconds : float
        Wall time.
    output : Output, optional
        Draws, prints and writes it.
    """

    name: str
    problem: Problem
    start: Evaluation
    allowed: dict[str, float]
    evaluations: tuple[Evaluation, ...]
    candidates: tuple[Candidate, ...]
    search_states: tuple[dict[str, float], ...]
    notes: tuple[str, ...]
    seed: int
    jobs: int
    reused: int
    seconds: float
    output: Output | None = field(default=None, repr=False, compare=False)

    @property
    def front(self) -> tuple[Evaluation, ...]:
        """Points that keep all limits and that no other such point dominates, least loss first."""
        return front_of(self.evaluations, self.problem.objectives, self.allowed)

    @property
    def best(self) -> Candidate | None:
        """The checked point within all limits that is best in the first objective; None where none beats the start."""
        first = self.problem.objectives[0]
        held = [candidate for candidate in self.candidates if candidate.holds]
        better = [c for c in held if c.exact.figures[first] < c.start.figures[first]]
        return min(better, key=lambda candidate: candidate.exact.figures[first], default=None)

    @property
    def status(self) -> Literal["converged", "failed"]:
        """``failed`` where no checked point keeps the limits and is better than the start."""
        return "converged" if self.best is not None else "failed"

    @property
    def reason(self) -> str:
        """Why there is none."""
        if self.best is not None:
            return ""
        return f"none of {len(self.evaluations) - 1} points is better within the limits"

    def settings(self, candidate: Candidate) -> SettingsResult:
        """Machine settings and design of a candidate."""
        return settings_of(self.problem, candidate.point.variables, candidate.name)

    def to_frame(self) -> pandas.DataFrame:
        """One row per evaluation, SI units."""
        from efficiency.optimisation.report import evaluations_table

        return evaluations_table(self).to_frame()

    def to_dict(self) -> dict[str, Any]:
        """For JSON; not-a-number becomes None."""
        best = self.best
        front = {point.key for point in self.front}
        rows = [
            {"variables": e.variables, "figures": e.figures, "status": state_of(e, self.allowed), "reason": e.reason}
            | {"front": e.key in front}
            for e in self.evaluations
        ]
        checked = [
            {
                "name": c.name,
                "variables": c.point.variables,
                "figures": c.exact.figures,
                "gain": c.gain,
                "gain_interval": c.gain_interval,
                "solved_gain": c.solved_gain,
                "holds": c.holds,
                "verdict": c.verdict,
            }
            for c in self.candidates
        ]
        head = {
            "name": self.name,
            "status": self.status,
            "reason": self.reason,
            "best": best.name if best else None,
            "objectives": self.problem.objectives,
            "limits": self.allowed,
            "friction_model": self.problem.friction,
            "oil": self.problem.oil,
            "states": self.problem.states,
            "start": {"variables": self.problem.start_values, "figures": self.start.figures},
            "candidates": checked,
            "evaluations": rows,
            "notes": self.notes,
            "seed": self.seed,
            "seconds": self.seconds,
        }
        plain: dict[str, Any] = finite_or_none(head)
        return plain

    def __repr__(self) -> str:
        best = self.best
        found = self.reason if best is None else f"loss {100.0 * best.change('power_loss'):+.1f} % ({best.name})"
        return (
            f"Optimisation({self.name}: {len(self.evaluations)} evaluations, {len(self.front)} on the front, {found})"
        )


@dataclass(frozen=True)
class OptimisationOutput:
    """Draws, prints and writes a search (`efficiency.loss.efficiency_result.Output`)."""

    def figures(self, result: Optimisation) -> dict[str, Figure]:
        """Figures by their names."""
        from efficiency.optimisation.plots import optimisation_figures

        return {name: figure for name, figure, _ in optimisation_figures(result)}

    def show(self, result: Optimisation, **parts: Any) -> None:
        """Print the candidates beside the start, and what has to be known of the search."""
        from efficiency.optimisation.report import candidates_table, search_notes
        from ehl.view.notes import notes_table

        candidates_table(result).print()
        notes_table(search_notes(result)).print()

    def write(self, result: Optimisation, units: str, **files: Any) -> list[Path]:
        """Page, tables, figures, and the design of each candidate into `folder`."""
        from efficiency.optimisation.report import write_optimisation

        return write_optimisation(result, Path(files["folder"]))


def state_of(point: Evaluation, allowed: Mapping[str, float]) -> str:
    """``feasible``, ``limit`` (one is exceeded), or ``failed``."""
    return "failed" if point.reason else "feasible" if point.feasible(allowed) else "limit"


def front_of(
    points: Sequence[Evaluation], objectives: Sequence[str], allowed: Mapping[str, float]
) -> tuple[Evaluation, ...]:
    """Non-dominated points among those that keep the limits, in the order of the first objective."""
    kept = list({p.key: p for p in points if p.feasible(allowed)}.values())
    if not kept:
        return ()
    values = np.array([[p.figures[name] for name in objectives] for p in kept])
    chosen = [kept[k] for k in np.flatnonzero(non_dominated(values))]
    return tuple(sorted(chosen, key=lambda p: p.figures[objectives[0]]))


def optimise(
    targets: SettingsInput | Path | str,
    variables: Mapping[str, Any] | Sequence[str] | None = None,
    *,
    objectives: Sequence[str] | None = None,
    limits: Mapping[str, Any] | None = None,
    duty: Path | str | Sequence[DutyRow] | None = None,
    misalignment: Mapping[str, Any] | None = None,
    tolerance: Mapping[str, Any] | None = None,
    over: Over = "mean",
    flanks: Flanks = "drive",
    friction: str | None = None,
    oil: str | None = None,
    evaluations: int = EVALUATIONS,
    batch: int = BATCH,
    check: int = CHECKED,
    solved: str | None = None,
    seed: int = 1,
    jobs: int | None = 1,
    dask: Any = None,
    store: Path | str | None = None,
    report: Callable[[int, int], None] | None = None,
) -> Optimisation:
    """Search ease-off and blank of a pair for less loss within limits of pressure, transmission error, edges and roots.

    Parameters
    ----------
    targets : SettingsInput, Path or str
        Targets of the pair to start from: content, file, or the name of shipped ones.
    variables : mapping or sequence, optional
        Names of `efficiency.optimisation.problem.VARIABLES`, with their bounds: two values, ``"from:to unit"``, or None
        for default ones. ``"ease_off"``, the default, stands for crowning lengthwise and in profile, bias, twist, place
        of the contact, and relief where the targets have it; ``"blank"`` for spiral angle, offset, cutter radius,
        pressure angles, addendum and depth factor where the blank states them.
    objectives : sequence of str, optional
        Figures to minimise, the most important first; by default loss, pressure and loaded transmission error.
    limits : mapping, optional
        Figures and what they may be at most: a value, or ``"start"`` for not more than the start. By default pressure,
        loaded transmission error, edge load and root stresses of the start.
    duty : Path, str or sequence of DutyRow, optional
        Duty cycle, as of `GearPair.duty`; by default the operating point of the targets.
    misalignment : mapping, optional
        Half widths of the box of `E`, `P`, `G` [m] and `alpha` [rad] the pair has to be good in; by default 0.05 mm in
        E and P. Empty for the aligned pair alone.
    tolerance : mapping, optional
        Half widths of variables of the ease-off as it is made, besides the misalignments; at most seven of both.
    over : {"mean", "worst"}
        What counts of the losses in the box; of all else the worst counts.
    flanks : {"drive", "coast", "both"}
        Whose ease-off is varied.
    friction : str, optional
        Friction formula; by default the one shipped for the oil.
    oil : str, optional
        Oil card in place of that of the targets.
    evaluations : int
        Of the search, the start included.
    batch : int
        Points between two updates of the surrogate; they are computed at the same time.
    check : int
        Points of the front, and the next best where it has fewer, that are computed again on the full mesh, in all
        states.
    solved : str, optional
        Friction model that solves contacts (``ehl``...), to check the gain of the best point with; minutes.
    seed : int
        Of the random numbers.
    jobs : int, optional
        Worker processes, None for the cores there are.
    dask : str or distributed.Client, optional
        Compute on a dask cluster, as `regression.sweep`; a batch should then be as large as the cluster.
    store : Path or str, optional
        File of the evaluations, read and continued.
    report : callable, optional
        Called with the number of evaluations done and of all.

    Returns
    -------
    Optimisation

    Raises
    ------
    InputError
        What cannot be used: variables, bounds, an objective without data.
    ConvergenceError
        The start itself cannot be computed.

    Examples
    --------
    >>> import efficiency
    >>> found = efficiency.optimise(
    ...     "fh_spiral_bevel_12x37", {"lengthwise_crowning": "30:80 um"}, misalignment={}, friction="constant:0.05",
    ...     evaluations=4, check=0,
    ... )  # fmt: skip
    >>> len(found.evaluations)
    4
    """
    clock = time.perf_counter()
    jobs = checked_jobs(jobs)
    start = load_start(targets) if isinstance(targets, Path | str) else targets
    problem = make_problem(
        start, variables, objectives, limits, duty, misalignment, tolerance, over, flanks, friction, oil
    )
    _check_numbers(evaluations, batch, check, len(problem.variables))
    if solved is not None and solved.partition(":")[0] != "ehl":
        models = "a friction model that solves contacts: ehl, ehl:load_sharing, ehl:smooth"
        raise InputError("check friction", solved, models, "The gain by the formula of the search needs no second one.")
    if solved is not None:
        ehl_friction(solved)  # refuses words it does not know before the search begins
    known = Store(None if store is None else Path(store))
    total, done = evaluations + check + 3 * (check > 0), 0

    def step(count: int = 1) -> None:
        nonlocal done
        done += count
        if report is not None:
            report(min(done, total), total)

    with cluster(dask) as workers:
        executor = workers or local_executor(jobs)
        if known.path is not None:
            _write_problem(problem, known.path.with_name("problem.json"), evaluations, batch, seed)
        problem, first, states, task, notes = _begin(problem, executor, known, default=limits is None)
        step()
        allowed = allowed_of(problem, first)
        keep, points = dict(allowed), [first]
        for until in (int(_LEARN_AT * evaluations) if check else 0, evaluations):
            points = _search(problem, task, points, keep, until, batch, seed, executor, known, step)
            if until < evaluations and check:
                keep = _learned(problem, task, points, allowed, executor, known, step)
                notes += _learned_note(keep, allowed)
        candidates, more = _check(problem, task, points, allowed, keep, check, solved, executor, known, step)
    if more:
        notes.append(more)
    return Optimisation(
        name=start.name,
        problem=problem,
        start=first,
        allowed=allowed,
        evaluations=tuple(points),
        candidates=candidates,
        search_states=states,
        notes=tuple(notes),
        seed=seed,
        jobs=jobs,
        reused=known.reused,
        seconds=time.perf_counter() - clock,
        output=OptimisationOutput(),
    )


def load_start(name: Path | str) -> SettingsInput:
    """Targets to start from; those beside a design file, which alone is refused with what to do."""
    path = named_file("targets", "targets", name)
    content = read_toml(path)
    if "assembly" in content and "targets" not in content:
        beside = targets_beside(path)
        if beside.is_file():
            return load_targets(beside)
        raise InputError(
            "targets",
            str(name),
            "a targets file (blank, [cutting], [targets]); a design holds no wanted ease-off",
            f"Write its blank and ease-off as in data/targets into {beside.name} beside it, or start from shipped "
            "targets by name.",
        )
    return load_targets(path)


def make_problem(
    start: SettingsInput,
    variables: Mapping[str, Any] | Sequence[str] | None,
    objectives: Sequence[str] | None,
    limits: Mapping[str, Any] | None,
    duty: Path | str | Sequence[DutyRow] | None,
    misalignment: Mapping[str, Any] | None,
    tolerance: Mapping[str, Any] | None,
    over: Over,
    flanks: Flanks,
    friction: str | None,
    oil: str | None,
) -> Problem:
    """The problem of `optimise`, checked."""
    if over not in ("mean", "worst"):
        raise InputError("over", over, "mean or worst")
    if flanks not in ("drive", "coast", "both"):
        raise InputError("flanks", flanks, "drive, coast or both")
    own = start.operation
    rows: tuple[DutyRow, ...]
    if duty is None:
        rows = (DutyRow(own.torque, own.speed, own.temperature_oil, 1.0),)
    else:
        rows = read_duty(duty) if isinstance(duty, Path | str) else tuple(duty)
    if flanks != "both" and all(row.side != flanks for row in rows):
        raise InputError("flanks", flanks, "flanks that carry load in the duty cycle")
    card = oil or own.oil
    Oil.load(card)
    return Problem(
        start=start,
        variables=tuple(variables_of(start, variables, flanks)),
        flanks=flanks,
        objectives=checked_objectives(objectives),
        limits=checked_limits(limits),
        duty=rows,
        states=box_states(misalignment, tolerance),
        over=over,
        friction=friction or default_friction(card),
        oil=card,
    )


def _check_numbers(evaluations: int, batch: int, check: int, variables: int) -> None:
    for name, value, least, most in (
        ("evaluations", evaluations, variables + 3, MAX_EVALUATIONS),
        ("batch", batch, 1, 256),
        ("check", check, 0, 100),
    ):
        if not least <= value <= most:
            raise InputError(name, value, f"from {least} to {most}")


def _write_problem(problem: Problem, path: Path, evaluations: int, batch: int, seed: int) -> None:
    content = {
        "version": __version__,
        "start": problem.start.model_dump(),
        "variables": [asdict(v) for v in problem.variables],
        "objectives": problem.objectives,
        "limits": problem.limits,
        "duty": [asdict(row) for row in problem.duty],
        "states": problem.states,
        "flanks": problem.flanks,
        "over": problem.over,
        "friction": problem.friction,
        "oil": problem.oil,
        "evaluations": evaluations,
        "batch": batch,
        "seed": seed,
    }
    write_file(path, json.dumps(finite_or_none(content), indent=1) + "\n", "output", folder=True)


def search_task(problem: Problem, start: SettingsResult) -> Task:
    """What the points of a search are like; with the bodies of the start where only the ease-off is varied."""
    bodies = "" if problem.varies_blank else start.design.model_dump_json()
    return Task(problem, {}, problem.states, SEARCH_GRID, bodies=bodies, accepted=start.status)


def _begin(
    problem: Problem, executor: Executor, store: Store, *, default: bool
) -> tuple[Problem, Evaluation, tuple[dict[str, float], ...], Task, list[str]]:
    """The start in all states; which of them the search takes; the task its points are like."""
    made = settings_of(problem, {})
    pair = GearPair(made.design)
    model = resolve_friction(problem.friction, made.design)
    if getattr(model, "solves_contacts", False):
        hint = "Search with a formula; `solved` (--check-friction) checks the gain with solved contacts."
        raise InputError("friction", problem.friction, "a formula, a constant, or a published model", hint)
    notes = [] if made.status == "converged" else [f"start: {made.status}: {'; '.join(made.warnings)}"]
    task = search_task(problem, made)
    each = evaluate_all([replace(task, states=(state,)) for state in problem.states], executor, store)
    for found in each:
        if found.reason:
            reason, _, detail = found.reason.partition(": ")
            raise ConvergenceError(reason, f"the start: {detail}")
    problem, missing = _with_data(problem, pair, each[0], default)
    notes += missing
    states = _search_states(problem, each)
    task = replace(task, problem=problem, states=states)
    figures = over_states(
        [found.figures for state, found in zip(problem.states, each, strict=True) if state in states], problem
    )
    first = Evaluation(task.key, problem.start_values, figures, notes=made.warnings)
    if len(states) < len(problem.states):
        notes.append(
            f"search in {len(states)} of {len(problem.states)} states: aligned as designed, and the corners with most "
            "and least pressure at the start; the check takes all"
        )
    return problem, first, states, task, notes


def _with_data(problem: Problem, pair: GearPair, start: Evaluation, default: bool) -> tuple[Problem, list[str]]:
    """The problem without default limits that have no data; an objective or a limit asked for has to have them."""
    missing = [name for name in problem.figures if not math.isfinite(start.figures[name])]
    notes = []
    for name in missing:
        reason = missing_roots(pair, problem) if name.startswith("root_stress") else ""
        if name in problem.objectives or not default:
            kind = "objective" if name in problem.objectives else "limit"
            remedy = "give the tooth a root (larger edge radius or slot), or leave it out"
            raise InputError(kind, name, f"a figure that this pair has{reason}", f"To do: {remedy}.")
        notes.append(f"{name} is not limited, the start has none{reason}")
    limits = {name: limit for name, limit in problem.limits.items() if name not in missing}
    return replace(problem, limits=limits), notes


def _search_states(problem: Problem, each: Sequence[Evaluation]) -> tuple[dict[str, float], ...]:
    """The aligned pair and the corners with the greatest and the least pressure, else loss, of the start."""
    states = problem.states
    if len(states) <= _MAX_STATES:
        return states
    name = "pressure_max" if "pressure_max" in problem.figures else "power_loss"
    order = sorted(range(1, len(states)), key=lambda k: each[k].figures[name])
    return states[0], states[order[-1]], states[order[0]]


def _search(
    problem: Problem,
    task: Task,
    points: Sequence[Evaluation],
    allowed: Mapping[str, float],
    evaluations: int,
    batch: int,
    seed: int,
    executor: Executor,
    store: Store,
    step: Callable[[], None],
) -> list[Evaluation]:
    """The start, the points so far and all further ones, in the order of the batches."""
    names, dimension = problem.figures, len(problem.variables)
    origin = np.array([v.place(problem.start_values[v.name]) for v in problem.variables])
    limits = np.array(
        [
            transformed(name, np.array([allowed[name] * (1.0 - _MARGIN)]))[0] if name in allowed else np.inf
            for name in names
        ]
    )
    processes = Processes(dimension, len(names))
    first, points = points[0], list(points[1:])
    places = [origin, *(np.array([v.place(p.variables[v.name]) for v in problem.variables]) for p in points)]
    refit_at = 0
    while len(points) < evaluations - 1:
        left = evaluations - 1 - len(points)
        if not points:
            proposed = first_points(dimension, min(_FIRST * dimension, left), seed, origin)
        else:
            known = [first, *points]
            good = np.array([not e.reason for e in known])
            if good.sum() < 2:
                proposed = np.random.default_rng([seed, len(points)]).random((min(batch, left), dimension))
            else:
                cube, scales = np.array(places), len(points) >= refit_at
                refit_at = len(points) + _REFIT if scales else refit_at
                proposed = next_points(
                    cube[good],
                    table_of([e.figures for e in known if not e.reason], names),
                    cube[~good],
                    limits,
                    len(problem.objectives),
                    processes,
                    count=min(batch, left),
                    number=len(points),
                    seed=seed,
                    scales=scales,
                )
        values = [{v.name: v.at(float(z)) for v, z in zip(problem.variables, row, strict=True)} for row in proposed]
        points += evaluate_all([replace(task, values=one) for one in values], executor, store, step)
        places += list(proposed)
    return [first, *points]


def _chosen(
    problem: Problem, points: Sequence[Evaluation], allowed: Mapping[str, float], count: int
) -> list[Evaluation]:
    """Points to check: spread over the front; the next best in the first objective where the front is short."""
    front = front_of(points, problem.objectives, allowed)
    if len(front) >= count:
        values = np.array([[p.figures[name] for name in problem.objectives] for p in front])
        return [front[k] for k in sorted(spread_out(values, count))]
    on_front = {p.key for p in front}
    others = {p.key: p for p in points if p.feasible(allowed) and p.key not in on_front}
    first = problem.objectives[0]
    return [*front, *sorted(others.values(), key=lambda p: p.figures[first])][:count]


def _exact(task: Task) -> Task:
    """The task on the full mesh, with own bodies, in all states."""
    return replace(task, states=task.problem.states, grid=CHECK_GRID, bodies="", interval=True)


def _learned(
    problem: Problem,
    task: Task,
    points: Sequence[Evaluation],
    allowed: Mapping[str, float],
    executor: Executor,
    store: Store,
    step: Callable[[], None],
) -> dict[str, float]:
    """Limits of the search, tightened by what it tells too low of its best point so far."""
    strict = {name: value * (1.0 - _MARGIN) for name, value in allowed.items()}
    better = [p for p in points[1:] if p.feasible(strict)]
    if not better:
        return dict(allowed)
    best = min(better, key=lambda p: p.figures[problem.objectives[0]])
    start, exact = evaluate_all([_exact(task), replace(_exact(task), values=best.variables)], executor, store, step)
    if start.reason or exact.reason:
        return dict(allowed)
    limited = allowed_of(problem, start)
    return {name: value / (1.0 + _understated(name, best, exact, allowed, limited)) for name, value in allowed.items()}


def _learned_note(learned: Mapping[str, float], allowed: Mapping[str, float]) -> list[str]:
    """What the search told too low, in words; none where it was nothing."""
    told = [
        f"{quantities()[name].label} {100.0 * (value / learned[name] - 1.0):.1f} %"
        for name, value in allowed.items()
        if learned[name] < value * (1.0 - _WORTH_TELLING)
    ]
    if not told:
        return []
    return [
        f"told too low by the mesh of the search, its limits are tightened by as much on the way: {', '.join(told)}"
    ]


def _understated(
    name: str, point: Evaluation, exact: Evaluation, allowed: Mapping[str, float], limited: Mapping[str, float]
) -> float:
    """Share by which the search tells a figure, over its limit, too low; 0 for edge loads, which may vanish."""
    if name == "edge_load_share":
        return 0.0
    ratio = (exact.figures[name] / limited[name]) / (point.figures[name] / allowed[name])
    return min(max(ratio - 1.0, 0.0), _MOST_LEARNT) if math.isfinite(ratio) else 0.0


def _check(
    problem: Problem,
    task: Task,
    points: Sequence[Evaluation],
    allowed: Mapping[str, float],
    learned: Mapping[str, float],
    count: int,
    solved: str | None,
    executor: Executor,
    store: Store,
    step: Callable[[], None],
) -> tuple[tuple[Candidate, ...], str]:
    """Points of the front on the full mesh with own bodies, in all states; the best one with solved contacts too."""
    strict = {name: value * (1.0 - _MARGIN) for name, value in learned.items()}
    kept = (strict, {name: value * (1.0 - _MARGIN) for name, value in allowed.items()}, dict(allowed))
    keep = next((limits for limits in kept if front_of(points[1:], problem.objectives, limits)), dict(allowed))
    if not front_of(points[1:], problem.objectives, keep) or not count:
        return (), "" if count == 0 else "no point of the search keeps all limits"
    exact = _exact(task)
    (start,) = evaluate_all([exact], executor, store, step)
    if start.reason:
        return (), f"the start on the full mesh: {start.reason}"
    limited = allowed_of(problem, start)
    candidates: list[Candidate] = []
    for _ in range(_CHECKS):
        known = {c.point.key for c in candidates}
        chosen = [p for p in _chosen(problem, points[1:], keep, count) if p.key not in known]
        found = evaluate_all([replace(exact, values=p.variables) for p in chosen], executor, store, step)
        candidates += [
            Candidate(f"{problem.start.name}_optimum_{number}", point, one, start, limited)
            for number, (point, one) in enumerate(zip(chosen, found, strict=True), len(candidates) + 1)
        ]
        if any(c.holds for c in candidates):
            break
        # as far below the limits as the search was wrong about these points
        for name in keep:
            excess = [c.exact.excess(limited).get(name, 0.0) for c in candidates if not c.exact.reason]
            worst = max((x for x in excess if math.isfinite(x)), default=0.0)
            keep[name] = min(keep[name], allowed[name] * (1.0 - _MARGIN) / (1.0 + worst))
    held = [c for c in candidates if c.holds]
    if solved and held:
        best = min(held, key=lambda c: c.exact.figures[problem.objectives[0]])
        again = [replace(exact, interval=False, solved=solved, values=values) for values in ({}, best.point.variables)]
        # solved contacts have their own processes
        before, after = evaluate_all(again, ThisProcess(), store)
        if before.reason or after.reason:
            return tuple(candidates), f"check with {solved}: {before.reason or after.reason}"
        checked = replace(
            best, exact=replace(best.exact, solved=after.solved), start=replace(start, solved=before.solved)
        )
        candidates[candidates.index(best)] = checked
    return tuple(candidates), ""
