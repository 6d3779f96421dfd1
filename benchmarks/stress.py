"""Stability campaign of the deterministic rough solver: random contacts far outside the gear range, checked one by one.

    python benchmarks/stress.py --range wide --count 2048 --travel 2 --nodes-max 512 --cap 8 --defer
    python benchmarks/stress.py --range wide --count 2048 --travel 2 --cap 60 --again 100
    python benchmarks/stress.py --range wide --report
    python benchmarks/stress.py --range cards --count 160 --travel 2
    python benchmarks/stress.py --memory 1000

Every contact goes through `ehl.Contact.solve` in a worker process that is killed when a case takes more processor
time than `--cap`. Rows are appended to a CSV as they come; the same command again goes on where it stopped. `--travel`
fixes a shorter averaging window than the accuracy takes, which saves time; the interval of mu then counts for nothing.
`--nodes-max` lowers the budget of nodes; `--defer` leaves what needs more (and what reaches the cap) to a second pass.
`--again N` is that pass: N of those left, drawn at random, with the accuracy's own budget. From both the report
estimates the outcomes of the whole sample (`stress_report.py`).

Outcomes: "converged"; "with fallback" (more than 1 % of the steps needed another method than Newton, or the smooth
solver's list of fallbacks is not empty); "unsettled" (a result, its interval or its lagged steps beyond the limits);
"refused" (no result, and why); "wrong" (an exception, or a result that breaks one of the invariants: must not occur).
"""

from __future__ import annotations

import argparse
import csv
import math
import multiprocessing
import os
import random
import resource
import signal
import tempfile
import threading
import time
from collections.abc import Sequence
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from common import OUT, command_line
from stress_cases import RANGES, Scene, scenes

import ehl.rough.mixed
from ehl.common.errors import ConvergenceError, InputError
from ehl.result import ContactResult, friction_above_limit_temperature
from ehl.rough import TransientResult, solve_transient
from ehl.rough.accuracy import BUDGET
from ehl.rough.mixed import TOLERANCE

FALLBACK_STEPS = 0.01  # share of the steps above which a run counts as one with fallback
LOAD_TOLERANCE = 2e-3
NUMBERS = (
    "friction_coefficient", "friction_fluid", "friction_asperity", "film_central", "film_min", "pressure_max",
    "asperity_load_share", "rolling_traction", "temperature_film_max", "temperature_flash", "film_error",
    "friction_error", "mesh_error", "statistical_error",
)  # fmt: skip
STEPS = ("plain", "relaxed", "continued", "slow", "lagged", "unconverged")
COLUMNS = (
    "index", "range", *scenes("gear", 2, 0)[0].row, "outcome", "reason", "detail", *NUMBERS, "film_ratio",
    "roughness_load_share", *(f"steps_{name}" for name in STEPS), "nodes", "steps", "travel", "net_exchange",
    "iterations_per_step", "boundary_film", "capped_share", "repeats", "skipped", "case_seconds",
    "memory_mb",
)  # fmt: skip
LEFT = ("mesh_budget", "time_cap")  # what a first pass with fewer nodes leaves to the second


def broken(result: ContactResult, row: dict[str, Any]) -> list[str]:
    """Invariants the result breaks."""
    if result.status == "failed":
        return [] if result.reason else ["failure without a reason"]
    found = []
    for name in NUMBERS:
        value = getattr(result, name)
        if not math.isfinite(value):
            found.append(f"{name} is {value}")
    if found:
        return found
    if result.status not in ("converged", "unsettled") or (result.status == "unsettled") != bool(result.reason):
        found.append(f"status {result.status} with reason {result.reason!r}")
    if not -1e-9 <= result.asperity_load_share <= 1.0 + 1e-6:
        found.append(f"share {result.asperity_load_share}")
    if not 0.0 < result.film_min <= 1.001 * max(result.film_central, result.film_min):
        found.append("films")
    limit = 0.2 if row["oil"] else row["limiting_shear_coefficient"]
    if not 0.0 <= result.friction_coefficient <= (1.02 * max(0.1, limit) + 0.01 if limit else math.inf):
        found.append(f"mu {result.friction_coefficient:.3g}")
    if not row["temperature_celsius"] + 273.1 <= result.temperature_film_max < 1e5:
        found.append(f"film temperature {result.temperature_film_max:.4g} K")
    run = result.transient
    if run is None:
        film = result.film
        assert film is not None
        if not (abs(film.load_residual) < 1e-4 and abs(film.mass_residual) < 1e-3):
            found.append(f"residuals {film.load_residual:.2g} {film.mass_residual:.2g}")
        return found
    if result.film_min < run.boundary_film * (1.0 - 1e-6):
        found.append("film below the boundary film")
    share = 0.0 if math.isnan(run.roughness_load_share) else run.roughness_load_share
    # a macroscopic pressure that carries more than the load is a status of its own
    if not -0.1 <= share <= 1.0 + 1e-6 and result.reason != "macroscopic_pressure":
        found.append(f"roughness share {run.roughness_load_share:.3g}")
    if not (math.isfinite(run.net_exchange) and np.all(np.isfinite(run.history_friction))):
        found.append("history or exchange not finite")
    arrays = [getattr(run.snapshot, name) for name in run.snapshot.__dataclass_fields__]
    arrays += [getattr(run.profiles, name) for name in run.profiles.__dataclass_fields__]
    if not all(np.all(np.isfinite(a)) for a in arrays):
        found.append("profiles not finite")
        return found
    if run.snapshot.film.min() <= 0.0 or run.snapshot.pressure_fluid.min() < 0.0:
        found.append("negative film or pressure")
    contact = run.run.problem.model.contact
    carried = float((run.snapshot.pressure_fluid + run.snapshot.pressure_asperity).sum())
    units = run.run.problem.units
    if abs(carried / (contact.load * units.pressure) - 1.0) > LOAD_TOLERANCE and run.fallbacks.unconverged == 0:
        found.append(f"load {carried / (contact.load * units.pressure):.4g}")
    if result.status == "converged" and run.fallbacks.unconverged > 0.01 * run.fallbacks.total:
        found.append("converged with unconverged steps")
    return found


def _doubt(result: ContactResult, accuracy: str, travel: float | None) -> str:
    """Reason why a result is not settled; the interval of a short window does not count, heat behind it does."""
    if not (travel and result.reason == "statistical_interval"):
        return result.reason if result.status == "unsettled" else ""
    beyond_law = friction_above_limit_temperature(result) > 0.5 * TOLERANCE[accuracy] * result.friction_coefficient
    return "too_hot" if beyond_law else ""


def _deferred(*_: object) -> None:
    raise ConvergenceError("mesh_budget", "left to the second pass")


def solved(
    scene: Scene, accuracy: str, travel: float | None, nodes_max: int | None = None, defer: bool = False
) -> dict[str, Any]:
    """The row of one scene; with `defer` a contact beyond the budget of nodes is not solved on a coarser mesh."""
    started = time.process_time()
    row = dict(scene.row)

    def solve(*given: Any, **options: Any) -> TransientResult:
        if options.get("travel") is None:
            options["travel"] = travel
        return solve_transient(*given, **options)

    beyond = _deferred if defer else ehl.rough.mixed._with_subgrid_film
    with (
        mock.patch.object(ehl.rough.mixed, "solve_transient", solve),
        mock.patch.object(ehl.rough.mixed, "_with_subgrid_film", beyond),
        mock.patch.dict(BUDGET, {accuracy: (nodes_max, nodes_max) if nodes_max else BUDGET[accuracy]}),
        tempfile.TemporaryDirectory() as folder,
    ):
        try:
            result = scene.case(Path(folder), accuracy).solve()
        except InputError as error:
            return row | _ended("refused", f"input:{error.field}", str(error), time.process_time() - started)
        except Exception as error:  # the campaign is there to find these
            return row | _ended("wrong", type(error).__name__, str(error), time.process_time() - started)
    faults = broken(result, row)
    run = result.transient
    steps = run.fallbacks if run is not None else None
    other = 1.0 - steps.plain / steps.total if steps is not None else 0.0
    smooth = " ".join(result.film.fallbacks) if result.film is not None else ""
    doubt = _doubt(result, accuracy, travel)
    limited = defer and run is not None and any("budget of nodes" in note for note in run.notes)
    if faults:
        outcome, reason = "wrong", "invariant"
    elif limited and (doubt or result.status == "failed"):
        outcome, reason = "refused", "mesh_budget"  # more nodes may do better
    elif result.status == "failed":
        outcome, reason = "refused", result.reason
    elif doubt:
        outcome, reason = "unsettled", doubt
    else:
        outcome = "with fallback" if other > FALLBACK_STEPS or smooth else "converged"
        reason = smooth
    row |= _ended(outcome, reason, "; ".join(faults), time.process_time() - started)
    row |= {name: getattr(result, name) for name in NUMBERS}
    row["skipped"] = " | ".join(text.partition(":")[0] for text in result.skipped)
    row |= {"film_ratio": result.film_ratio, "roughness_load_share": result.roughness_load_share}
    if run is not None and steps is not None:
        row |= {f"steps_{name}": getattr(steps, name) / steps.total for name in STEPS}
        row |= {"nodes": run.nodes, "steps": run.steps, "travel": run.travel, "net_exchange": run.net_exchange}
        row |= {"iterations_per_step": run.iterations_per_step, "boundary_film": run.boundary_film}
        row |= {"repeats": run.repeats, "capped_share": run.capped_share}
    return row


def _ended(outcome: str, reason: str, detail: str, seconds: float) -> dict[str, Any]:
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return {"outcome": outcome, "reason": reason, "detail": detail, "case_seconds": seconds, "memory_mb": memory}


def _serve(pipe: Connection, accuracy: str, travel: float | None, nodes_max: int | None, defer: bool) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = os.getppid()

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)  # a killed parent says no good-bye

    threading.Thread(target=watch, daemon=True).start()
    while True:
        scene = pipe.recv()
        if scene is None:
            return
        pipe.send(solved(scene, accuracy, travel, nodes_max, defer))


class Worker:
    """A process that solves one scene at a time and is replaced when it takes too long or dies."""

    def __init__(
        self, accuracy: str, travel: float | None, nodes_max: int | None, cap: float, defer: bool = False
    ) -> None:
        self._arguments, self._cap = (accuracy, travel, nodes_max, defer), cap
        self._context = multiprocessing.get_context("spawn")
        self._start()

    def _start(self) -> None:
        self._pipe, other = self._context.Pipe()
        self._process = self._context.Process(target=_serve, args=(other, *self._arguments), daemon=True)
        self._process.start()
        other.close()

    def solve(self, scene: Scene, cap: float | None = None) -> dict[str, Any]:
        """The row of a scene; refused for its time where the cap is reached."""
        used = self._processor_time()
        self._pipe.send(scene)
        try:
            while self._processor_time() - used < (cap or self._cap):
                if self._pipe.poll(0.5):
                    return dict(self._pipe.recv())
            outcome, reason = "refused", "time_cap"
        except EOFError:
            outcome, reason = "wrong", "worker died"
        seconds = (cap or self._cap) if reason == "time_cap" else math.nan
        self._process.kill()
        self._process.join()
        self._start()
        return scene.row | _ended(outcome, reason, "", seconds)

    def _processor_time(self) -> float:
        """Of the worker [s]."""
        stat = Path(f"/proc/{self._process.pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
        return (int(stat[11]) + int(stat[12])) / os.sysconf("SC_CLK_TCK")

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.join()


def campaign(options: argparse.Namespace) -> None:
    """Solve the scenes of this shard, or of the second pass, that are not in its file yet."""
    number, shards = (int(part) for part in options.shard.split("/"))
    found = scenes(options.range, options.count, options.seed)
    if options.again:
        path = options.out / f"again_{options.range}_seed{options.seed}_{number}of{shards}.csv"
        first = _written(options.out, "stress", options.range, options.seed)
        left = [index for index, reason in first if reason in LEFT]
        picked = [found[i] for i in random.Random(options.seed).sample(left, min(options.again, len(left)))]
        picked = picked[number - 1 :: shards]
    else:
        path = options.out / f"stress_{options.range}_seed{options.seed}_{number}of{shards}.csv"
        picked = found[number - 1 :: shards]
    stem = "again" if options.again else "stress"
    done = {index for index, _ in _written(options.out, stem, options.range, options.seed)}
    begun = path.exists()
    worker = Worker(options.accuracy, options.travel, options.nodes_max, options.cap, options.defer)
    for scene in scenes("gear", 4, 0):  # compiles
        worker.solve(scene, cap=600.0)
    until = time.perf_counter() + options.minutes * 60.0
    with path.open("a", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, COLUMNS, restval="")
        if not begun:
            writer.writeheader()
        for scene in picked:
            if time.perf_counter() > until:
                break
            if scene.index not in done:
                writer.writerow({"index": scene.index, "range": options.range, **worker.solve(scene)})
                stream.flush()
    worker.close()


def _written(folder: Path, stem: str, kind: str, seed: int) -> list[tuple[int, str]]:
    """Index and reason of every contact in the files of a pass, in the order of the sample."""
    rows: list[tuple[int, str]] = []
    for path in folder.glob(f"{stem}_{kind}_seed{seed}_*.csv"):
        with path.open(newline="", encoding="utf-8") as stream:
            rows += [(int(row["index"]), row["reason"]) for row in csv.DictReader(stream)]
    return sorted(rows)


def memory(options: argparse.Namespace) -> None:
    """Resident memory of one process over many small cases."""
    picked = [scene for scene in scenes("gear", 8 * options.memory, options.seed) if scene.row["kind"] == "gaussian"]
    rows = []
    with (options.out / "stress_memory.csv").open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, ("case", "resident_mb"))
        writer.writeheader()
        for number, scene in enumerate(picked[: options.memory]):
            small = scene.row | {"radius_equivalent": 5e-3, "correlation_length": 4e-5}
            solved(Scene(scene.index % 8, small), options.accuracy, 1.0)
            rows.append({"case": number, "resident_mb": _resident()})
            writer.writerow(rows[-1])
            stream.flush()
    for at in (0, *(round(share * (len(rows) - 1)) for share in (0.1, 0.25, 0.5, 0.75, 1.0))):
        print(f"case {at:5d}: {rows[at]['resident_mb']:7.1f} MB resident")
    print(f"peak {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0:.1f} MB")


def _resident() -> float:
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def main(argv: Sequence[str] | None = None) -> None:
    """Run from the command line."""
    parser = command_line(__doc__)
    parser.add_argument("--range", choices=tuple(RANGES), default="wide")
    parser.add_argument("--count", type=int, default=64, help="scenes of the sample")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cap", type=float, default=60.0, help="processor time of a case [s]")
    parser.add_argument("--shard", default="1/1", help="i/n: every n-th scene, from the i-th")
    parser.add_argument("--minutes", type=float, default=math.inf, help="stop after this time")
    parser.add_argument("--accuracy", choices=("fast", "standard", "reference"), default="fast")
    parser.add_argument("--travel", type=float, default=None, help="fixed window [b]")
    parser.add_argument("--nodes-max", type=int, default=None, help="budget of nodes instead of the accuracy's own")
    parser.add_argument("--defer", action="store_true", help="leave what needs more nodes to a second pass")
    parser.add_argument("--again", type=int, default=0, help="solve so many of those that a first pass left")
    parser.add_argument("--report", action="store_true", help="table and figure of what is there")
    parser.add_argument("--memory", type=int, default=0, help="resident memory over so many small cases")
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args(argv)
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # for the workers
    options.out.mkdir(parents=True, exist_ok=True)
    if options.memory:
        memory(options)
        return
    if not options.report:
        campaign(options)
    from stress_report import report  # pandas: not in the workers, whose memory is measured

    report(options.out, options.range)


if __name__ == "__main__":
    main()
