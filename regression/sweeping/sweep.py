"""The sweep: plan -> cases, the longest first -> (workers solve, the parent writes) -> result file of this shard.

A case that fails is solved again with fallback settings. If these fail too, its row states the reason. Workers that
crash are replaced. The same command resumes a sweep that was killed.

Recording of finished cases of a sweep: counts, rows on disk, progress, and stop on request.
"""

from __future__ import annotations

import hashlib
import signal
import threading
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

from ehl import SOLVER
from ehl.common.data import counted_reasons
from ehl.common.errors import InputError
from ehl.common.files import make_folder
from ehl.common.journal import Journal
from ehl.common.progress import ProgressCallback, counted, duration, progress_to, report_progress
from ehl.common.runner import Executor, TaskRun, local_executor
from ehl.fluid.oil import Oil
from regression.data.result_files import JOURNAL, SAME_RUN, TEXT_WIDTHS, case_status, cases_of_other_files
from regression.friction.oil_cards import card_hash, cards_hash
from regression.plan.plan import Plan
from regression.sweeping import evaluators

# number of rows that are written to disk together, and the time after which fewer rows are written [s]
FLUSH_ROWS, FLUSH_SECONDS = 16, 1.0


@contextmanager
def stop_requests() -> Iterator[threading.Event]:
    """Event that is set by Ctrl-C and SIGTERM (time limit of a job); a second Ctrl-C stops at once."""
    stop = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def ask(number: int, frame: FrameType | None) -> None:
        stop.set()
        signal.signal(signal.SIGINT, signal.default_int_handler)

    for number in before:
        signal.signal(number, ask)
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@dataclass
class SweepReport:
    """Report of one call of `sweep_shard`."""

    path: Path  # the result file of this shard
    total: int  # cases of this shard
    workers: int | None  # worker processes of this machine; None on a cluster
    resumed: int  # cases found on disk
    # number of cases without a result by reason, of this call and on disk
    reasons_failed: Counter[str]
    # cases computed in this call; the error of an unsettled result exceeds the tolerance
    converged: int = 0
    unsettled: int = 0
    failed: int = 0
    reasons_unsettled: Counter[str] = field(default_factory=Counter)  # number of these unsettled cases by reason
    restarts: int = 0  # number of crashes after which the workers were replaced
    truncated: int = 0  # incomplete rows of an interrupted process; computed again
    corrupt: int = 0  # rows on disk that do not match their checksum; computed again
    fallback: int = 0  # cases that have a result only with fallback settings
    seconds: float = 0.0  # wall time [s]
    seconds_cases: float = 0.0  # sum of the wall times of the cases computed in this call [s]
    seconds_cpu: float = 0.0  # sum of their processor times [s]

    def count(self, row: Mapping[str, Any]) -> None:
        """Add a case computed in this call."""
        status = row["status"]
        setattr(self, status, getattr(self, status) + 1)
        if status != "converged":
            (self.reasons_failed if status == "failed" else self.reasons_unsettled)[row["reason"]] += 1
        if status != "failed" and row.get("setting"):
            self.fallback += 1
        self.seconds_cases += float(row.get("seconds", 0.0))
        self.seconds_cpu += float(row.get("seconds_cpu", 0.0))

    @property
    def unanswered(self) -> int:
        """Number of cases of this shard without a result, of all calls."""
        return sum(self.reasons_failed.values())

    @property
    def occupancy(self) -> float | None:
        """Share of the time of the workers inside cases; None if it is unknown."""
        if self.workers is None or not self.seconds_cases:
            return None
        return self.seconds_cases / (self.workers * self.seconds)

    def to_text(self) -> str:
        """The report as text."""
        unsettled = f"{self.unsettled} unsettled, " if self.unsettled else ""
        lines = [
            f"{self.path}: {counted(self.total, 'case')}, {self.resumed} found on disk, {self.converged} converged, "
            f"{unsettled}{self.failed} failed, {self.seconds:.1f} s"
        ]
        if self.occupancy is not None and self.workers is not None:
            workers = counted(self.workers, "worker")
            lines.append(
                f"CPU time of the cases {duration(self.seconds_cpu)}; {workers} spent {100.0 * self.occupancy:.1f} % "
                "of the time in cases"
            )
        remarks = (
            (self.corrupt, f"computed again as the checksum on disk did not match: {counted(self.corrupt, 'row')}"),
            (self.fallback, f"result with fallback settings only (column setting): {counted(self.fallback, 'case')}"),
            (self.truncated, f"computed again after an interruption: {counted(self.truncated, 'incomplete row')}"),
            (self.restarts, f"workers crashed and were replaced: {counted(self.restarts, 'time')}"),
            (self.reasons_unsettled, f"with an error above the tolerance: {counted_reasons(self.reasons_unsettled)}"),
            (self.reasons_failed, f"without a result: {counted_reasons(self.reasons_failed)}"),
        )
        return "\n".join([*lines, *(text for count, text in remarks if count)])


@dataclass
class Recorder:
    """Counts rows, writes them to disk in groups, and ends the sweep between two cases on request."""

    journal: Journal
    report: SweepReport
    stop: threading.Event
    costs: Mapping[str, float]  # estimated seconds of the cases to be computed
    waiting: list[Mapping[str, Any]] = field(default_factory=list)  # rows that are not on disk yet
    done: float = 0.0  # estimated seconds of the computed cases

    def __post_init__(self) -> None:
        self.start = self.flushed = time.perf_counter()
        self.total = sum(self.costs.values())

    def record(self, row: Mapping[str, Any]) -> None:
        """Record a row; raises `KeyboardInterrupt` after a stop request."""
        # missing values become nan or empty texts when the rows are read
        self.waiting.append({name: value for name, value in row.items() if value == value and value != ""})
        self.report.count(row)
        self.done += self.costs.get(row["key"], 0.0)
        if len(self.waiting) >= FLUSH_ROWS or time.perf_counter() - self.flushed > FLUSH_SECONDS:
            self.flush()
        self.show()
        if self.stop.is_set():
            raise KeyboardInterrupt

    def flush(self) -> None:
        """Write the waiting rows to disk."""
        self.journal.append(self.waiting)
        self.waiting.clear()
        self.flushed = time.perf_counter()

    def show(self) -> None:
        """Report the progress."""
        report = self.report
        left = None
        if self.done > 0.0:
            elapsed = time.perf_counter() - self.start
            left = elapsed * max(self.total - self.done, 0.0) / self.done
        step = f"{report.failed} failed, cases" if report.failed else "cases"
        done = report.resumed + report.converged + report.unsettled + report.failed
        report_progress(step, done, report.total, left)


def sweep_shard(
    plan: Plan,
    folder: Path,
    shard: tuple[int, int] = (1, 1),
    *,
    evaluate: evaluators.Evaluator = evaluators.solve_outputs,
    version: str = SOLVER,
    jobs: int = 1,
    executor: Executor | None = None,
    time_cap: float | None = 600.0,
    retries: int = 1,
    retry_failed: bool = False,
    progress: ProgressCallback | None = None,
) -> SweepReport:
    """Compute the cases of a plan, or of one shard of it, that are not on disk yet, the longest first.

    Other parameters and errors as of `regression.sweep`. With `retry_failed`, cases without convergence use settings
    that were not tried yet; cases that reached the time cap or crashed their worker use the same settings.

    shard: each has its own file, so that shards may run simultaneously.
    evaluate: contact to results; may raise `ConvergenceError` with a reason. Workers need to pickle it.
    version: version of `evaluate`; part of the key of every case.
    executor: from `ehl.common.runner.cluster`; replaces `jobs` local processes.
    """
    number, shards = shard
    make_folder(folder, "run")
    path = folder / f"shard-{number:04d}-of-{shards:04d}{JOURNAL}"
    indices = np.arange(number - 1, len(plan.points), shards)
    clock = time.perf_counter()
    cost = plan.case_seconds()[0][indices]
    # the longest first, so that all workers finish at about the same time
    order = np.lexsort((np.arange(indices.size), -cost))
    meta = run_meta(plan, version)
    known = cases_of_other_files(path, meta)  # of other divisions into shards
    with (
        progress_to(progress),
        Journal(path, meta, SAME_RUN, keep=case_status) as journal,
        stop_requests() as stop,
    ):
        # a failure does not replace a result
        for key, entry in journal.rows.items():
            if entry[0] != "failed" or known.get(key, entry)[0] == "failed":
                known[key] = entry
        done = {key for key, (status, _, _) in known.items() if not (retry_failed and status == "failed")}
        # number of settings of a case that failed and are not tried again
        lost = (evaluators.TIME_CAP, evaluators.WORKER_CRASHED)
        failures = {k: n if status == "failed" and why not in lost else 0 for k, (status, why, n) in known.items()}
        costs: dict[str, float] = {}
        waiting: dict[str, int] = {}
        kept: dict[str, str] = {}  # reason of each failed case on disk that is not computed again
        for position in order:
            index = int(indices[position])
            case = plan.case_at(index)
            key = evaluators.case_key(case, version)
            # if no settings are left the row keeps the reason of the solver
            exhausted = bool(failures.get(key)) and evaluators.fallback_settings(case, failures[key]) is None
            if exhausted or key in done:
                if known[key][0] == "failed":
                    kept[key] = known[key][1]
            elif key not in costs:
                costs[key], waiting[key] = float(cost[position]), index
        jobs = max(1, min(jobs, len(waiting)))
        workers = jobs if executor is None else None
        resumed = indices.size - len(waiting)
        report = SweepReport(path, indices.size, workers, resumed, Counter(kept.values()))
        recorder = Recorder(journal, report, stop, costs)
        # contacts are created when they are needed, to save memory
        tasks = (
            evaluators.CaseTask(key, plan.points.origin[index], plan.case_at(index), failures.get(key, 0))
            for key, index in waiting.items()
        )
        solve = evaluators.CaseRunner(evaluate, time_cap, retries)
        run = TaskRun(tasks, solve, executor or local_executor(jobs), solve.crashed, time_cap)
        try:
            recorder.show()
            with closing(iter(run)) as results:
                for _, row in results:
                    recorder.record(row)
        finally:
            recorder.flush()
    report.restarts, report.truncated, report.corrupt = run.restarts, journal.truncated, journal.corrupt
    report.seconds = time.perf_counter() - clock
    return report


def run_meta(plan: Plan, version: str) -> dict[str, str | int]:
    """Metadata of every file of a run.

    Raises `InputError`: the name of an oil cannot be stored in the rows.
    """
    width = TEXT_WIDTHS["oil"]
    for name in plan.oils:
        if not name.isascii() or len(name) > width or ", " in name:
            allowed = f"at most {width} letters, digits and signs of ASCII, no comma before a blank"
            raise InputError("lubricant.oil", name, allowed, "Run in the folder of the card and use its file name.")
    bodies = [body.body().model_dump_json(exclude={"source"}) for body in (plan.solid_1, plan.solid_2)]
    return {
        "plan": plan.model_dump_json(),
        "plan_name": plan.name,
        "plan_hash": plan.plan_hash,
        "solver_version": version,
        "oil": ", ".join(plan.oils),
        "oil_hash": cards_hash([card_hash(Oil.load(name)) for name in plan.oils]),
        "bodies_hash": hashlib.sha256("\n".join(bodies).encode()).hexdigest(),
        "count": plan.count,
    }
