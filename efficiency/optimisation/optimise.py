"""Optimisation of ease-off and blank: start, initial sample, batches by expected improvement, check on the full mesh.

Each evaluation is written to the journal when it ends. Each batch depends only on the evaluations before it and on the
seed, so an interrupted run resumes and ends with the same front for any number of worker processes.
"""

import json
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any, get_args

import numpy as np

from efficiency.conditions.conditions import default_friction, resolve_friction
from efficiency.conditions.duty import DutyRow, read_duty
from efficiency.loss.ehl_friction import ehl_friction
from efficiency.machine_settings.inputs import SettingsInput, load_targets, targets_next_to
from efficiency.machine_settings.settings_result import SettingsResult
from efficiency.optimisation import evaluation
from efficiency.optimisation import problem as search_problem
from efficiency.optimisation.check import Correction, Evaluate, check_best, check_front, check_solved, gain_split
from efficiency.optimisation.evaluation import Evaluation, EvaluationTask
from efficiency.optimisation.load_sizing import BOX, sized_for_load
from efficiency.optimisation.result import Candidate, Optimisation, best_of
from efficiency.optimisation.surrogate import Processes, first_points, table_of, transformed
from efficiency.pair import GearPair
from ehl import __version__
from ehl.common.arrays import finite_or_none
from ehl.common.data import named_file
from ehl.common.errors import ConvergenceError, InputError, check_choice, check_count
from ehl.common.files import write_file
from ehl.common.journal import Journal
from ehl.common.progress import ProgressCallback, progress_to, report_progress
from ehl.common.runner import checked_jobs, cluster, local_executor
from ehl.common.threads import one_thread
from ehl.common.validation import read_toml
from ehl.fluid.oil import Oil

EVALUATIONS, BATCH, CHECKED = 120, 4, 4
"""Default numbers of evaluations, of points in a batch, and of points of the front checked on the full mesh."""
MAX_EVALUATIONS = 20_000
SEARCH_GRID = (8, 31)
"""Positions and points per line of the search; fewer points underestimate the maximum pressure by 3 to 14 %."""
# points of the initial sample per variable; evaluations between two fits of the length scales
_FIRST, _REFIT = 4, 24
# largest number of states used in a search; with more states it uses three of them
_MAX_STATES = 5
# fractions of the evaluations after which the best point is checked to correct the remaining points
_CHECK_AT = 2 / 3, 5 / 6


@one_thread
def optimise(
    targets: SettingsInput | Path | str,
    variables: Mapping[str, Any] | Sequence[str] | None = None,
    *,
    objectives: Sequence[str] | None = None,
    limits: Mapping[str, Any] | None = None,
    duty: Path | str | Sequence[DutyRow] | None = None,
    misalignment: Mapping[str, Any] | None = None,
    tolerance: Mapping[str, Any] | None = None,
    over: search_problem.Over = "mean",
    flanks: search_problem.Flanks = "drive",
    friction: str | None = None,
    oil: str | None = None,
    evaluations: int = EVALUATIONS,
    batch: int = BATCH,
    check: int = CHECKED,
    solved: str | None = None,
    seed: int = 1,
    sized: bool = False,
    jobs: int | None = None,
    dask: Any = None,
    store: Path | str | None = None,
    progress: ProgressCallback | None = None,
) -> Optimisation:
    """Optimise ease-off and blank of a pair for low loss within limits of pressure, transmission error and stress.

    Parameters
    ----------
    targets : SettingsInput, Path or str
        Targets of the initial pair: the object, a file, or the name of shipped targets.
    variables : mapping or sequence, optional
        Names of `efficiency.optimisation.problem.VARIABLES`, with their bounds: two values, ``"from:to unit"``, or None
        for the default bounds. ``"ease_off"``, the default, comprises lengthwise and profile crowning, bias, twist,
        position of the contact, and the reliefs of the targets. ``"blank"`` comprises spiral angle, cutter radius,
        pressure angles, addendum factor and depth factor where the blank states them.
    objectives : sequence of str, optional
        Figures to minimise, the most important first; default: loss, pressure and loaded transmission error.
    limits : mapping, optional
        Figures and their upper limits: a value, or ``"start"`` for the value of the start. Default: pressure with and
        away from edges, loaded transmission error, edge load and root stresses of the start.
    duty : Path, str or sequence of DutyRow, optional
        Duty cycle, as in `GearPair.duty`; default: the operating point of the targets.
    misalignment : mapping, optional
        Half widths of the misalignment box: `E`, `P`, `G` [m] and `shaft_angle_error` [rad]; default: 0.05 mm in
        E and P. An empty mapping means the aligned pair only.
    tolerance : mapping, optional
        Half widths of manufacturing errors of ease-off variables; at most seven half widths with the misalignments.
    over : {"mean", "worst"}
        Whether the loss is the mean or the maximum over the states; all other figures are the worst.
    flanks : {"drive", "coast", "both"}
        Flanks whose ease-off is varied.
    friction : str, optional
        Friction formula; default: the formula shipped for the oil.
    oil : str, optional
        Oil card in place of that of the targets.
    evaluations : int
        Number of evaluations of the search, including the start.
    batch : int
        Number of points between two updates of the surrogate; they are computed in parallel.
    check : int
        Number of points computed again on the full mesh in all states: points of the front, then the next best.
    solved : str, optional
        Friction model with solved contacts (``ehl``...) that checks the gain of the best point; takes minutes.
    seed : int
        Seed of the random numbers.
    sized : bool
        First size ease-off and relief of the start for the torque of the targets (`sized_for_load`, same box).
    jobs : int, optional
        Worker processes; default: all available cores.
    dask : str or distributed.Client, optional
        Dask cluster, as in `regression.sweep`; choose a batch as large as the cluster.
    store : Path or str, optional
        File of the evaluations; an existing file is read and continued.
    progress : callable, optional
        Called with a `Progress` after each evaluation.

    Returns
    -------
    Optimisation

    Raises
    ------
    InputError
        Invalid variables or bounds, or an objective without data.
    ConvergenceError
        The start cannot be computed.

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
    if sized:
        half = {} if misalignment is None else dict.fromkeys(BOX, 0.0) | dict(misalignment)
        start = sized_for_load(start, misalignment={n: x for n, x in half.items() if n in BOX}).targets
    problem = make_problem(
        start, variables, objectives, limits, duty, misalignment, tolerance, over, flanks, friction, oil
    )
    check_count("evaluations", evaluations, len(problem.variables) + 3, MAX_EVALUATIONS)
    check_count("batch", batch, 1, 256)
    check_count("check", check, 0, 100)
    if solved is not None and solved.partition(":")[0] != "ehl":
        models = "a friction model with solved contacts: ehl, ehl:smooth"
        raise InputError("check friction", solved, models, "The search itself already uses a formula.")
    if solved is not None:
        ehl_friction(solved)  # rejects invalid settings before the search begins
    path = None if store is None else Path(store)
    total = (
        evaluations + len(problem.states) - 1 + (check + 1 + len(_CHECK_AT) + len(search_problem.PARTS) if check else 0)
    )
    done = 0

    def step() -> None:
        nonlocal done
        done += 1
        report_progress("evaluations", min(done, total), total)

    with progress_to(progress), cluster(dask) as workers, Journal(path, field="output") as journal:
        evaluate = partial(
            evaluation.evaluate_all, executor=workers or local_executor(jobs), journal=journal, done=step
        )
        if path is not None:
            content = {"version": __version__, **asdict(problem), "start": problem.start.model_dump()}
            content |= {"evaluations": evaluations, "batch": batch, "seed": seed}
            text = json.dumps(finite_or_none(content), indent=1) + "\n"
            write_file(path.with_name("problem.json"), text, "output")
        problem, first, states, task, notes = _begin(problem, evaluate, default=limits is None)
        start_known = len(journal.reused) == len(problem.states)
        allowed = evaluation.allowed_of(problem, first)
        correction, points = Correction(problem, allowed), [first]
        candidates: tuple[Candidate, ...] = ()
        for share in _CHECK_AT if check else ():
            points = _search(task, points, correction, int(share * evaluations), batch, seed, evaluate)
            correction = check_best(task, points, correction, evaluate)
        points = _search(task, points, correction, evaluations, batch, seed, evaluate)
        more = ""
        if check:
            candidates, more = check_front(task, points, correction, check, evaluate)
        split = gain_split(task, best_of(candidates, problem.objectives[0]), evaluate)
        if solved and not more:
            candidates, more = check_solved(task, candidates, solved, journal)
    notes += [*correction.notes, *filter(None, [more])]
    found = Optimisation(
        name=start.name,
        problem=problem,
        start=first,
        allowed=allowed,
        evaluations=tuple(points),
        candidates=candidates,
        search_states=states,
        notes=tuple(notes),
        gain_split=split,
        seed=seed,
        jobs=jobs,
        reused=start_known + sum(point.key in journal.reused for point in points[1:]),
        seconds=time.perf_counter() - clock,
    )
    if split:
        parts = ", ".join(f"{part} {100.0 * gain:+.1f} %" for part, gain in split.items())
        notes.append(f"gain by kind of variable, one after the other: {parts}")
    if found.best is not None:
        values = found.best.point.variables
        at = [(v.quantity.label, bound) for v in problem.variables if (bound := v.at_bound(values[v.name]))]
        if at:
            names = ", ".join(f"{label} ({bound})" for label, bound in at)
            notes.append(f"variables of the best point at a bound: {names}; widen it with --vary")
    return replace(found, notes=tuple(notes))


def load_start(name: Path | str) -> SettingsInput:
    """Initial targets; for a design file, the targets file that belongs to it."""
    path = named_file("targets", "targets", name)
    content = read_toml(path)
    if "assembly" not in content or "targets" in content:
        return load_targets(path)
    own = targets_next_to(path)
    if own.is_file():
        return load_targets(own)
    allowed = "a targets file (blank, [cutting], [targets]); a design file does not contain the intended ease-off"
    hint = (
        f"Write its blank and ease-off in the format of data/targets to {own.name} in the same folder, or start from "
    )
    raise InputError("targets", str(name), allowed, f"{hint}shipped targets by name.")


def make_problem(
    start: SettingsInput,
    variables: Mapping[str, Any] | Sequence[str] | None,
    objectives: Sequence[str] | None,
    limits: Mapping[str, Any] | None,
    duty: Path | str | Sequence[DutyRow] | None,
    misalignment: Mapping[str, Any] | None,
    tolerance: Mapping[str, Any] | None,
    over: search_problem.Over,
    flanks: search_problem.Flanks,
    friction: str | None,
    oil: str | None,
) -> search_problem.SearchProblem:
    """The validated problem of `optimise`."""
    check_choice("over", over, get_args(search_problem.Over))
    check_choice("flanks", flanks, get_args(search_problem.Flanks))
    own = start.operation
    rows: tuple[DutyRow, ...]
    if duty is None:
        rows = (DutyRow(own.torque, own.speed, own.temperature, 1.0),)
    else:
        rows = read_duty(duty) if isinstance(duty, Path | str) else tuple(duty)
    if flanks != "both" and all(row.side != flanks for row in rows):
        raise InputError("flanks", flanks, "flanks that carry load in the duty cycle")
    wanted = tuple(dict.fromkeys(objectives or search_problem.OBJECTIVES))
    for name in wanted:
        check_choice("objective", name, search_problem.FIGURES)
    card = oil or own.oil
    Oil.load(card)
    return search_problem.SearchProblem(
        start=start,
        variables=tuple(search_problem.variables_of(start, variables, flanks)),
        flanks=flanks,
        objectives=wanted,
        limits=search_problem.checked_limits(limits),
        duty=rows,
        states=search_problem.box_states(misalignment, tolerance),
        over=over,
        friction=friction or default_friction(card),
        oil=card,
    )


def search_task(problem: search_problem.SearchProblem, start: SettingsResult) -> EvaluationTask:
    """Template of the tasks of a search; with the elastic bodies of the start where only the ease-off is varied."""
    bodies = "" if problem.varies_blank else start.design.model_dump_json()
    return EvaluationTask(problem, {}, problem.states, SEARCH_GRID, bodies=bodies, accepted=start.status)


def _begin(
    problem: search_problem.SearchProblem, evaluate: Evaluate, *, default: bool
) -> tuple[search_problem.SearchProblem, Evaluation, tuple[dict[str, float], ...], EvaluationTask, list[str]]:
    """The start in all states, the states of the search, the template of its tasks, and notes."""
    made = evaluation.settings_of(problem, {})
    pair = GearPair(made.design)
    model = resolve_friction(problem.friction, made.design)
    if model.solves_contacts:
        hint = "Search with a formula; `solved` (--check-friction) checks the gain with solved contacts."
        raise InputError("friction", problem.friction, "a formula, a constant, or a published model", hint)
    notes = [] if made.status == "converged" else [f"start: {made.status}: {'; '.join(made.warnings)}"]
    task = search_task(problem, made)
    each = evaluate([replace(task, states=(state,)) for state in problem.states])
    for found in each:
        if found.reason:
            reason, _, detail = found.reason.partition(": ")
            raise ConvergenceError(reason, f"the start: {detail}")
    problem, missing = _with_data(problem, pair, each[0], default)
    notes += missing
    states = problem.states
    if len(states) > _MAX_STATES:
        # the aligned pair and the corners with the highest and the lowest pressure of the start; without it, the loss
        name = "pressure_hertz_max" if "pressure_hertz_max" in problem.figures else "power_loss"
        order = sorted(range(1, len(states)), key=lambda k: each[k].figures[name])
        states = states[0], states[order[-1]], states[order[0]]
    task = replace(task, problem=problem, states=states)
    figures = evaluation.over_states(
        [found.figures for state, found in zip(problem.states, each, strict=True) if state in states], problem
    )
    first = Evaluation(task.key, problem.start_values, figures, notes=made.warnings)
    if len(states) < len(problem.states):
        notes.append(
            f"the search uses {len(states)} of {len(problem.states)} states: the aligned pair and the corners with the "
            "highest and lowest pressure of the start; the check uses all states"
        )
    return problem, first, states, task, notes


def _with_data(
    problem: search_problem.SearchProblem, pair: GearPair, start: Evaluation, default: bool
) -> tuple[search_problem.SearchProblem, list[str]]:
    """The problem without the default limits that have no data; explicit objectives and limits must have data."""
    missing = [name for name in problem.figures if not math.isfinite(start.figures[name])]
    notes = []
    for name in missing:
        reason = evaluation.missing_roots(pair, problem) if name.startswith("root_stress") else ""
        if name in problem.objectives or not default:
            kind = "objective" if name in problem.objectives else "limit"
            remedy = "Give the tooth a root (larger edge radius or slot), or omit the figure."
            raise InputError(kind, name, f"a quantity available for this pair{reason}", remedy)
        notes.append(f"no limit on {name}, because the start has no such value{reason}")
    limits = {name: limit for name, limit in problem.limits.items() if name not in missing}
    return replace(problem, limits=limits), notes


def _search(
    task: EvaluationTask,
    points: Sequence[Evaluation],
    correction: Correction,
    evaluations: int,
    batch: int,
    seed: int,
    evaluate: Evaluate,
) -> list[Evaluation]:
    """The given points and all further ones up to `evaluations`, in the order of the batches."""
    problem, bounds = task.problem, correction.limits
    names, dimension = problem.figures, len(problem.variables)
    limits = np.array([transformed(name, np.array([bounds.get(name, math.inf)]))[0] for name in names])
    processes, refit_at = Processes(dimension, limits, len(problem.objectives), seed), 0
    points = list(points)
    while len(points) < evaluations:
        left, known = evaluations - len(points), [e for e in points if not e.reason]
        if len(points) == 1:
            (origin,) = problem.places_of([problem.start_values])
            proposed = first_points(dimension, min(_FIRST * dimension, left), seed, origin)
        elif len(known) < 2:
            proposed = np.random.default_rng([seed, len(points) - 1]).random((min(batch, left), dimension))
        else:
            scales = len(points) > refit_at
            refit_at = len(points) - 1 + _REFIT if scales else refit_at
            figures = table_of([correction(e).figures for e in known], names)
            made, failed = (
                problem.places_of([e.variables for e in of]) for of in (known, [e for e in points if e.reason])
            )
            number, count = len(points) - 1, min(batch, left)
            proposed = processes.next_points(made, figures, failed, count=count, number=number, scales=scales)
        points += evaluate([replace(task, values=problem.values_at(place)) for place in proposed])
    return points
