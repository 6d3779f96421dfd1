"""The sweep: plan -> cases -> (workers solve, the parent writes) -> result file of this shard.

A case that fails is a row with its reason; a worker that dies costs one restart; a process that dies is resumed by the
same command.
"""

from __future__ import annotations

import hashlib
import os
import signal
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import Any

from ehl.errors import InputError
from ehl.oil import Oil
from regression.evaluators import SOLVER, Evaluator, case_key, solve_outputs
from regression.plan import Plan
from regression.store import ResultStore
from regression.workers import Task, compute


@dataclass(frozen=True)
class Progress:
    """How far a sweep is: cases of this shard."""

    done: int
    total: int
    failed: int


@dataclass(frozen=True)
class SweepReport:
    """What one call of `sweep` did.

    Parameters
    ----------
    path : Path
        The result file of this shard.
    total : int
        Cases of this shard.
    resumed : int
        Of these, found on disk.
    converged, unsettled, failed : int
        Computed in this call; unsettled cases have a result whose interval is wider than asked for.
    reasons : dict
        Number of unsettled and failed cases by reason.
    restarts : int
        How often workers died and were replaced.
    torn : int
        Rows of an earlier process that were cut off because they were not whole.
    seconds : float
        Wall time.
    """

    path: Path
    total: int
    resumed: int
    converged: int
    unsettled: int
    failed: int
    reasons: dict[str, int]
    restarts: int
    torn: int
    seconds: float


def sweep(
    plan: Plan,
    run: Path,
    *,
    evaluate: Evaluator = solve_outputs,
    version: str = SOLVER,
    jobs: int = 1,
    shard: tuple[int, int] = (1, 1),
    flush_every: int = 16,
    flush_seconds: float = 5.0,
    time_cap: float | None = 600.0,
    retry_failed: bool = False,
    progress: Callable[[Progress], None] | None = None,
) -> SweepReport:
    """Compute the cases of a plan that are not on disk yet.

    Parameters
    ----------
    plan : Plan
        What to compute.
    run : Path
        Folder of the results; made if there is none.
    evaluate : callable
        Case to results; may raise `ConvergenceError` with a reason. Picklable where `jobs` > 1.
    version : str
        Names what `evaluate` computes with; part of every case's key.
    jobs : int
        Worker processes, one thread each; 1 computes in this process.
    shard : tuple of int
        (i, n): every n-th case, beginning with the i-th. One file per shard, so that shards may run at once.
    flush_every : int
        Rows put on disk together.
    flush_seconds : float
        Or earlier, once this much time has passed.
    time_cap : float or None
        Wall time after which a case is given up with the reason "time_cap" [s].
    retry_failed : bool
        Compute the failed cases on disk again (with another time cap, say).
    progress : callable, optional
        Called after every case.

    Returns
    -------
    SweepReport

    Raises
    ------
    InputError
        The folder holds another run, cannot be written, or the shard is not one of n.
    KeyboardInterrupt
        Ctrl-C or SIGTERM came; every finished case is on disk.
    """
    clock = time.perf_counter()
    number, shards = shard
    if not 1 <= number <= shards:
        raise InputError("shard", f"{number}/{shards}", "i/n with 1 <= i <= n")
    if jobs < 1:
        raise InputError("jobs", jobs, "at least 1")
    try:
        run.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError("run", str(run), "a folder that can be written", f"{error.strerror}.") from None
    path = run / f"shard-{number:04d}-of-{shards:04d}.h5"
    total = len(range(number - 1, plan.count, shards))
    with ResultStore(path, run_meta(plan, version)) as store, _stop_requests() as stop:
        done = store.keys(converged_only=retry_failed)
        recorder = _Recorder(store, total, len(done), flush_every, flush_seconds, progress, stop)

        def pending() -> Iterator[Task]:
            for index, (origin, case) in enumerate(plan.cases()):
                if index % shards == number - 1:
                    key = case_key(case, version)
                    if key not in done:
                        yield Task(key, origin, case)

        def record(row: Mapping[str, Any]) -> None:
            done.add(row["key"])
            recorder.record(row)

        try:
            recorder.show()
            restarts = compute(pending, evaluate, jobs, time_cap, record)
        finally:
            recorder.flush()
    return SweepReport(
        path,
        total,
        recorder.resumed,
        recorder.counts["converged"],
        recorder.counts["unsettled"],
        recorder.counts["failed"],
        recorder.reasons,
        restarts,
        store.torn,
        time.perf_counter() - clock,
    )


@dataclass
class _Recorder:
    """Puts rows on disk in groups, counts them, and ends the sweep between two cases when asked to."""

    store: ResultStore
    total: int
    resumed: int
    flush_every: int
    flush_seconds: float
    progress: Callable[[Progress], None] | None
    stop: threading.Event
    counts: Counter[str] = field(default_factory=Counter)
    reasons: dict[str, int] = field(default_factory=dict)
    _buffer: list[Mapping[str, Any]] = field(default_factory=list)
    _flushed: float = field(default_factory=time.perf_counter)

    def record(self, row: Mapping[str, Any]) -> None:
        self._buffer.append(row)
        self.counts[row["status"]] += 1
        if row["status"] != "converged":
            self.reasons[row["reason"]] = self.reasons.get(row["reason"], 0) + 1
        if len(self._buffer) >= self.flush_every or time.perf_counter() - self._flushed > self.flush_seconds:
            self.flush()
        self.show()
        if self.stop.is_set():
            raise KeyboardInterrupt

    def flush(self) -> None:
        self.store.append(self._buffer)
        self._buffer.clear()
        self._flushed = time.perf_counter()

    def show(self) -> None:
        if self.progress is not None:
            self.progress(Progress(self.resumed + self.counts.total(), self.total, self.counts["failed"]))


@contextmanager
def _stop_requests() -> Iterator[threading.Event]:
    """Turn Ctrl-C and SIGTERM (a job at its time limit) into an event; a second Ctrl-C acts at once."""
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


def run_meta(plan: Plan, version: str) -> dict[str, str | int]:
    """What every file of a run carries."""
    return {
        "plan": plan.model_dump_json(),
        "plan_name": plan.name,
        "plan_hash": plan.plan_hash,
        "solver_version": version,
        "oil": plan.oil or "",
        "oil_hash": oil_hash(plan.oil) if plan.oil else "",
        "bodies_hash": _bodies_hash(plan),
        "count": plan.count,
    }


def _bodies_hash(plan: Plan) -> str:
    figures = [body.body().model_dump_json(exclude={"source"}) for body in (plan.solid_1, plan.solid_2)]
    return hashlib.sha256("\n".join(figures).encode()).hexdigest()


def oil_hash(name: str) -> str:
    """Hash of the figures on an oil card."""
    return hashlib.sha256(Oil.load(name).model_dump_json(exclude={"description", "source"}).encode()).hexdigest()


def available_jobs() -> int:
    """Processors this process may use, or those a Slurm task was given."""
    given = os.environ.get("SLURM_CPUS_PER_TASK", "")
    if given.isdigit() and int(given) > 0:
        return int(given)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
