"""Search of ease-off and blank: gains of the shipped hypoids, the front against a grid, random search, exact check.

``python -m benchmarks optimise gain`` searches each pair for the least loss within the limits of the start (figures of
docs/optimise.md). ``random`` draws ten times as many points evenly between the same bounds and tells how many are
better. What breaks a limit when aligned breaks it in the box: its other states are left out. Where processes over the
points so far are sure that it does, by three standard deviations, the point is not computed either, but for every tenth
of them, by which that is judged. ``grid`` compares the hypervolume of the front of two variables with that of a grid of
13 x 13. ``again`` computes start and best of the searches that ``gain`` has kept with the formula there is now, and
with solved contacts by ``--friction ehl``. ``page`` draws the figures of docs/optimise.md from the command that stands
there. ``--vary ease_off blank`` frees the blank too. A pair ``random:SEED`` is a face-milled hypoid drawn at random.
Evaluations are kept in the folder; what was stopped goes on.
"""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from common import OUT, command_line, write_rows
from report_figures import screenshot

import efficiency
from efficiency.machine_settings.inputs import SettingsInput, load_targets
from efficiency.optimisation.check import check_solved, exact_task
from efficiency.optimisation.evaluation import Evaluation, Store, Task, allowed_of, evaluate_all, settings_of
from efficiency.optimisation.optimise import load_start, make_problem, optimise, search_task
from efficiency.optimisation.pareto import hypervolume
from efficiency.optimisation.problem import Problem
from efficiency.optimisation.result import Candidate, Optimisation, front_of
from efficiency.optimisation.surrogate import Processes, table_of, transformed
from ehl import MixedEhlError
from regression.sweeping.executors import Executor, local_executor

PAIRS = (
    "fm_hypoid_13x42",
    "fm_hypoid_13x42_relieved",
    "fh_hypoid_9x34",
    "fh_hypoid_9x34_relieved",
    "fh_hypoid_9x34_offset_10",
    "fh_hypoid_9x34_offset_10_relieved",
)
LOSS = "power_loss"
PAGE = "fm_hypoid_13x42_relieved"
GRID_PAIR, GRID, GRID_SEARCH = "fh_spiral_bevel_12x37", 13, 60
BOUNDS = {"lengthwise_crowning": (10e-6, 120e-6), "profile_crowning": (4e-6, 36e-6)}
TWO: dict[str, Any] = {"objectives": [LOSS, "pressure_max"], "misalignment": {}, "limits": {"edge_load_share": "50 %"}}
TEN = 10
BEST = "best.json"
# random points: the first are all computed, the rest in blocks; deviations that are sure; every so many judged
FIRST, BLOCK, SURE, JUDGED = 60, 60, 3.0, 10


@dataclass(frozen=True)
class Chosen:
    """What the command line says."""

    pairs: Sequence[str]
    folder: Path
    evaluations: int
    jobs: int
    vary: Sequence[str]
    points: int = 0


def search(chosen: Chosen, pair: str, **more: Any) -> Optimisation:
    """The least loss within the limits of the start."""
    store = folder_of(chosen, pair) / "points.jsonl"
    fixed: dict[str, Any] = {"objectives": [LOSS], "evaluations": chosen.evaluations, "check": 4, "jobs": chosen.jobs}
    return optimise(targets_of(pair), chosen.vary, store=store, **fixed, **more)


def folder_of(chosen: Chosen, pair: str) -> Path:
    """Where the search of a pair is kept."""
    return chosen.folder / pair.replace(":", "_")


def targets_of(pair: str) -> SettingsInput | str:
    """Shipped targets by their name, or those of ``random:SEED``."""
    kind, _, seed = pair.partition(":")
    return random_targets(int(seed)) if kind == "random" else pair


def random_targets(seed: int) -> SettingsInput:
    """A face-milled hypoid drawn at random, with crowning and relief as the shipped pairs have; one that can be cut."""
    rng = np.random.default_rng(seed)
    base = load_targets("fm_hypoid_13x42_relieved")
    while True:
        pinion = int(rng.integers(9, 16))
        diameter = rng.uniform(0.15, 0.26)
        scale = diameter / base.blank.outer_pitch_diameter_gear
        angle = np.radians(rng.uniform(19.0, 22.0))
        blank = {
            "name": f"random_{seed}",
            "source": "drawn at random",
            "teeth_pinion": pinion,
            "teeth_gear": round(pinion * rng.uniform(2.6, 4.4)),
            "hypoid_offset": round(diameter * rng.uniform(0.05, 0.17), 4),
            "outer_pitch_diameter_gear": round(diameter, 4),
            "face_width_gear": round(diameter * rng.uniform(0.15, 0.18), 4),
            "mean_spiral_angle_pinion": float(np.radians(rng.uniform(42.0, 50.0))),
            "cutter_radius": round(diameter * rng.uniform(0.36, 0.46), 4),
            "pressure_angle": base.blank.pressure_angle.model_copy(update={"drive": angle, "coast": angle}),
        }
        crowning = {"crowning_toe": rng.uniform(2e-5, 4e-5), "relief_root": rng.uniform(5e-6, 12e-6)}
        target = base.targets.drive.model_copy(
            update=crowning | {"crowning_heel": crowning["crowning_toe"], "relief_tip": crowning["relief_root"]}
        )
        torque = base.operation.torque * scale**3 * 42 / 13 * pinion / blank["teeth_gear"]
        found = base.model_copy(
            update={
                "name": f"random_{seed}",
                "source": "drawn at random",
                "blank": base.blank.model_copy(update=blank),
                "targets": base.targets.model_copy(update={"drive": target, "coast": target}),
                "operation": base.operation.model_copy(update={"torque": float(f"{torque:.2g}")}),
            }
        )
        try:
            if efficiency.settings(found, transmission=False).status == "converged":
                return found
        except MixedEhlError:
            continue


def gain_row(found: Optimisation, seconds: float) -> dict[str, Any]:
    """What was gained, in percent of the start, exact figures in all states."""
    row: dict[str, Any] = {"pair": found.name, "evaluations": len(found.evaluations)}
    row |= {"within": sum(p.feasible(found.allowed) for p in found.evaluations)}
    row |= {"failed": sum(bool(p.reason) for p in found.evaluations)}
    return row | changes(found.best, found.problem) | {"s": round(seconds)}


def changes(best: Candidate | None, problem: Problem) -> dict[str, Any]:
    """Figures of the best against the start and the interval of the gain, in percent."""
    row: dict[str, Any] = {name: round(100.0 * best.change(name), 2) if best else None for name in problem.figures}
    low, high = best.gain_interval if best else (np.nan, np.nan)
    return row | {"gain from": round(100.0 * low, 2), "gain to": round(100.0 * high, 2)}


def gain(chosen: Chosen) -> None:
    """Each pair searched."""
    rows = []
    for pair in chosen.pairs:
        clock = time.perf_counter()
        found = search(chosen, pair)
        rows.append(gain_row(found, time.perf_counter() - clock))
        print(rows[-1], flush=True)
        best = found.best.point.variables if found.best else {}
        (folder_of(chosen, pair) / BEST).write_text(json.dumps(best), encoding="utf-8")
        write_rows(chosen.folder / "gain.csv", rows)


def again(chosen: Chosen, friction: str) -> None:
    """Start and best of kept searches, exact, with the formula there is now; with solved contacts where asked for."""
    rows = []
    for pair in chosen.pairs:
        folder = folder_of(chosen, pair)
        values = json.loads((folder / BEST).read_text(encoding="utf-8"))
        start = load_start(given) if isinstance(given := targets_of(pair), str) else given
        problem = make_problem(
            start, chosen.vary, [LOSS], None, None, None, None, "mean", "drive", friction=None, oil=None
        )
        exact, store = exact_task(search_task(problem, settings_of(problem, {}))), Store(folder / "again.jsonl")
        before, after = evaluate_all([exact, replace(exact, values=values)], local_executor(chosen.jobs), store)
        allowed = {name: value for name, value in allowed_of(problem, before).items() if np.isfinite(value)}
        best = Candidate(pair, after, after, before, allowed)
        row = {"pair": pair, "verdict": best.verdict} | changes(best, problem)
        if friction:
            (best,), reason = check_solved(exact, (best,), friction, store)
            gain, error = best.solved_gain
            ours = 1.0 - best.exact.losses["aligned"][0] / best.start.losses["aligned"][0]
            shares = {"aligned": ours, "solved": gain, "error": error}
            row |= {name: round(100.0 * share, 2) for name, share in shares.items()}
            row |= {"losses": (best.start.solved, best.exact.solved), "reason": reason}
        rows.append(row)
        print(row, flush=True)
        write_rows(chosen.folder / "again.csv", rows)


def random(chosen: Chosen) -> None:
    """Ten times as many points, evenly drawn between the same bounds."""
    for pair in chosen.pairs:
        found = search(chosen, pair)
        best = min((p.figures[LOSS] for p in found.front), default=np.inf)
        limits = {name: value for name, value in found.allowed.items() if name != LOSS}
        task = _task(found)
        count = chosen.points or TEN * chosen.evaluations
        places = np.random.default_rng(0).random((count, len(found.problem.variables)))
        executor, store = local_executor(chosen.jobs), Store(folder_of(chosen, pair) / "random.jsonl")
        tasks = [replace(task, values=found.problem.values_at(place)) for place in places]
        aligned = [replace(one, states=task.states[:1]) for one in tasks]
        first, judged = screened(aligned, places, limits, executor, store)
        left = [one for one, alone in zip(tasks, first, strict=True) if alone and alone.feasible(limits)]
        points = evaluate_all(left, executor, store)
        within = [p for p in points if p.feasible(found.allowed)]
        better = [p for p in within if p.figures[LOSS] < best]
        least = min((p.figures[LOSS] for p in within), default=np.nan) / found.start.figures[LOSS] - 1.0
        ours = best / found.start.figures[LOSS] - 1.0
        print(
            f"{pair}: {len(tasks)} random points, {len(first) - first.count(None)} computed; of {len(judged)} sure to "
            f"break a limit {sum(p.feasible(limits) for p in judged)} did not; {len(left)} keep the limits aligned, "
            f"{len(within)} in all states, {len(better)} better than the search; loss {100.0 * least:+.2f} % against "
            f"{100.0 * ours:+.2f} %",
            flush=True,
        )


def screened(
    tasks: Sequence[Task], places: np.ndarray, limits: dict[str, float], executor: Executor, store: Store
) -> tuple[list[Evaluation | None], list[Evaluation]]:
    """Evaluations, None where processes over those before are sure that a limit is broken; the judged ones of these."""
    names = list(limits)
    bounds = np.array([transformed(name, np.array([value]))[0] for name, value in limits.items()])
    processes, refit_at = Processes(places.shape[1], len(names)), FIRST
    found: list[Evaluation | None] = []
    judged: list[Evaluation] = []
    for start in range(0, len(tasks), BLOCK):
        block = np.arange(start, min(start + BLOCK, len(tasks)))
        sure = np.zeros(block.size, dtype=bool)
        if start >= FIRST:
            known = [(place, one) for place, one in zip(places, found, strict=False) if one and not one.reason]
            inputs, figures = np.array([place for place, _ in known]), [one.figures for _, one in known]
            scales = start >= refit_at
            refit_at = 2 * start if scales else refit_at
            processes.fit(inputs, table_of(figures, names), inputs[:0], scales=scales)
            mean, sd = processes.predict(places[block])
            sure = np.any(mean - SURE * sd > bounds, axis=1)
        check = sure & (block % JUDGED == 0)
        computed = iter(evaluate_all([tasks[k] for k in block[~sure | check]], executor, store))
        here = [next(computed) if compute else None for compute in ~sure | check]
        judged += [one for one, checked in zip(here, check, strict=True) if checked and one]
        found += here
        print(f"{len(found)}: {len(found) - found.count(None)} computed", flush=True)
    return found, judged


def _task(found: Optimisation) -> Task:
    """The task of the points of a search."""
    made = efficiency.settings(found.problem.start, transmission=False)
    return replace(search_task(found.problem, made), states=found.search_states)


def grid(folder: Path, jobs: int) -> None:
    """Hypervolume of the front of a search and of a grid of two variables."""
    store = folder / "grid" / "points.jsonl"
    found = optimise(GRID_PAIR, BOUNDS, evaluations=GRID_SEARCH, check=0, jobs=jobs, store=store, **TWO)
    axes = [np.linspace(0.0, 1.0, GRID)] * 2
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    task = _task(found)
    tasks = [replace(task, values=found.problem.values_at(place)) for place in places]
    points = evaluate_all(tasks, local_executor(jobs), Store(folder / "grid" / "grid.jsonl"))
    names = found.problem.objectives
    fronts = {"search": found.front, "grid": front_of(points, names, found.allowed)}
    figures = {kind: np.array([[p.figures[n] for n in names] for p in front]) for kind, front in fronts.items()}
    every = np.vstack(list(figures.values()))
    low, high = every.min(axis=0), every.max(axis=0)
    corner = high + 0.1 * (high - low)
    rows = []
    for kind, values_of in figures.items():
        volume = hypervolume((values_of - low) / (high - low), (corner - low) / (high - low))
        count = len(found.evaluations) if kind == "search" else len(points)
        rows.append({"front of": kind, "evaluations": count, "points": len(values_of), "hypervolume": round(volume, 5)})
        print(rows[-1], flush=True)
    write_rows(folder / "grid.csv", rows)


def page(chosen: Chosen, figures: Path) -> None:
    """First screen of the page of a search, and its trade."""
    folder = chosen.folder / "page"
    store = folder / "points.jsonl"
    found = optimise(PAGE, ("ease_off", "blank"), evaluations=160, jobs=chosen.jobs, store=store)
    found.write(folder=folder)
    screenshot(folder / "optimise.html", figures / "optimise_report.png")
    shutil.copy(folder / "trade.png", figures / "optimise_trade.png")


def main(argv: Sequence[str] | None = None) -> None:
    """See the head of the file."""
    parser = command_line(__doc__)
    parser.add_argument("what", choices=("gain", "random", "again", "grid", "page"))
    parser.add_argument("pairs", nargs="*", default=PAIRS)
    parser.add_argument("--evaluations", type=int, default=120)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--vary", nargs="*", default=("ease_off",))
    parser.add_argument("--points", type=int, default=0, help="random points, else ten times the evaluations")
    parser.add_argument("--friction", default="", help="of again: a model that solves contacts, 'ehl'")
    parser.add_argument("--out", type=Path, default=OUT / "optimise")
    parser.add_argument("--figures", type=Path, default=Path("docs/figures"))
    options = parser.parse_args(argv)
    chosen = Chosen(options.pairs, options.out, options.evaluations, options.jobs, options.vary, options.points)
    if options.what == "grid":
        grid(options.out, options.jobs)
    elif options.what == "page":
        page(chosen, options.figures)
    elif options.what == "again":
        again(chosen, options.friction)
    else:
        {"gain": gain, "random": random}[options.what](chosen)


if __name__ == "__main__":
    main()
