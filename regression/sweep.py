"""The sweep: plan -> cases, the longest first -> (workers solve, the parent writes) -> result file of this shard.

A case that fails is tried again with a safer setting, and is a row with its reason if that fails too; a worker that
dies costs one restart; a process that dies is resumed by the same command.
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

import numpy as np

from ehl.errors import InputError
from ehl.oil import Oil
from regression.cost import case_seconds
from regression.evaluators import SOLVER, Evaluator, case_key, solve_outputs
from regression.executors import Executor, compute, local_executor
from regression.plan import Plan
from regression.store import ResultStore, finished_keys
from regression.workers import TIME_CAP, WORKER_LOST, Task, Work


@dataclass(frozen=True)
class Progress:
    """How far a sweep is: cases of this shard.

    Parameters
    ----------
    done, total, failed : int
        Cases on disk or computed; of the shard; failed in this call.
    remaining : float or None
        Estimated wall time to the end [s], from the estimated cost of the cases and the pace so far; None before the
        first case.
    """

    done: int
    total: int
    failed: int
    remaining: float | None = None


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
    damaged : int
        Rows on disk that no longer match their checksum; computed again.
    saved : int or None
        Rows taken over from a file that was cut short; None where it was sound.
    safer : int
        Cases that have a result only with a safer setting than planned.
    seconds, seconds_cases : float
        Wall time, and that of all cases computed here together.
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
    damaged: int
    saved: int | None
    safer: int
    seconds: float
    seconds_cases: float


def sweep(
    plan: Plan,
    run: Path,
    *,
    evaluate: Evaluator = solve_outputs,
    version: str = SOLVER,
    jobs: int = 1,
    executor: Executor | None = None,
    shard: tuple[int, int] = (1, 1),
    flush_every: int = 16,
    flush_seconds: float = 1.0,
    time_cap: float | None = 600.0,
    retries: int = 1,
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
        Case to results; may raise `ConvergenceError` with a reason. Picklable where workers compute.
    version : str
        Names what `evaluate` computes with; part of every case's key.
    jobs : int
        Worker processes, one thread each; 1 computes in this process.
    executor : Executor, optional
        Where to compute in place of `jobs` local processes, as of `regression.dask_workers.dask_executor`.
    shard : tuple of int
        (i, n): every n-th case, beginning with the i-th. One file per shard, so that shards may run at once.
    flush_every : int
        Rows put on disk together.
    flush_seconds : float
        Or earlier, once this much time has passed.
    time_cap : float or None
        Wall time after which a case is given up with the reason "time_cap" [s].
    retries : int
        Safer settings tried where the solver gives a case up.
    retry_failed : bool
        Compute the failed cases on disk again: those the solver gave up with the settings that were not tried yet,
        those that ran out of time or lost their worker as they were.
    progress : callable, optional
        Called after every case.

    Returns
    -------
    SweepReport

    Raises
    ------
    InputError
        The folder holds another run, cannot be written, or the shard is not one of n.
    WorkersDie, ClusterLost
        Nothing can be computed any more; every finished case is on disk.
    KeyboardInterrupt
        Ctrl-C or SIGTERM came; every finished case is on disk.
    """
    clock = time.perf_counter()
    number, shards = shard
    if not 1 <= number <= shards:
        raise InputError("shard", f"{number}/{shards}", "i/n with 1 <= i <= n")
    if jobs < 1:
        raise InputError("jobs", jobs, "at least 1")
    if retries < 0:
        raise InputError("retries", retries, "at least 0")
    path = shard_path(run, number, shards)
    indices = np.arange(number - 1, len(plan.points), shards)
    cost = case_seconds(plan)[indices]
    # the longest first: the last cases to run are short, and no core waits long for another
    order = np.lexsort((indices, -cost))
    with ResultStore(path, run_meta(plan, version)) as store, stop_requests() as stop:
        known = store.rows()
        done = {key for key, (status, _, _) in known.items() if not (retry_failed and status == "failed")}
        # what another division into shards has computed counts as well
        done |= finished_keys(path)
        tried = {key: _tried(reason, attempts) for key, (_, reason, attempts) in known.items()} if retry_failed else {}

        costs: dict[str, float] = {}
        waiting: list[tuple[int, str]] = []
        for position in order:
            index = int(indices[position])
            key = case_key(plan.case_at(index), version)
            if key not in done and key not in costs:
                costs[key] = float(cost[position])
                waiting.append((index, key))

        def pending() -> Iterator[Task]:
            for index, key in waiting:
                if key not in recorder.recorded:
                    yield Task(key, plan.points.origin[index], plan.case_at(index), tried.get(key, 0))

        resumed = len(indices) - len(waiting)
        recorder = Recorder(store, len(indices), resumed, flush_every, flush_seconds, progress, stop, costs)
        try:
            recorder.show()
            chosen = local_executor(jobs) if executor is None else executor
            restarts = compute(pending, Work(evaluate, time_cap, retries), chosen, recorder.record)
        finally:
            recorder.flush()
    return SweepReport(
        path,
        len(indices),
        resumed,
        recorder.counts["converged"],
        recorder.counts["unsettled"],
        recorder.counts["failed"],
        recorder.reasons,
        restarts,
        store.torn,
        store.damaged,
        store.saved,
        recorder.safer,
        time.perf_counter() - clock,
        recorder.seconds_cases,
    )


def shard_path(run: Path, number: int, shards: int) -> Path:
    """The result file of a shard, its folder made if there is none.

    Raises
    ------
    InputError
        The folder cannot be made.
    """
    try:
        run.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError("run", str(run), "a folder that can be written", f"{error.strerror}.") from None
    return run / f"shard-{number:04d}-of-{shards:04d}.h5"


def _tried(reason: str, attempts: int) -> int:
    """How many settings need not be tried again for a case that failed."""
    return 0 if reason in (TIME_CAP, WORKER_LOST) else attempts


@dataclass
class Recorder:
    """Puts rows on disk in groups, counts them, and ends the sweep between two cases when asked to."""

    store: ResultStore
    total: int
    resumed: int
    flush_every: int
    flush_seconds: float
    progress: Callable[[Progress], None] | None
    stop: threading.Event
    costs: Mapping[str, float]
    counts: Counter[str] = field(default_factory=Counter)
    reasons: dict[str, int] = field(default_factory=dict)
    recorded: set[str] = field(default_factory=set)
    safer: int = 0
    seconds_cases: float = 0.0
    _buffer: list[Mapping[str, Any]] = field(default_factory=list)
    _start: float = field(default_factory=time.perf_counter)
    _flushed: float = field(default_factory=time.perf_counter)
    _cost_done: float = 0.0
    _cost_all: float = field(init=False)

    def __post_init__(self) -> None:
        self._cost_all = sum(self.costs.values())

    def record(self, row: Mapping[str, Any]) -> None:
        """Take a row; raises `KeyboardInterrupt` where the sweep was asked to stop."""
        self._buffer.append(row)
        self.recorded.add(row["key"])
        self.counts[row["status"]] += 1
        if row["status"] != "converged":
            self.reasons[row["reason"]] = self.reasons.get(row["reason"], 0) + 1
        if row["status"] != "failed" and row.get("setting"):
            self.safer += 1
        self.seconds_cases += float(row.get("seconds", 0.0))
        self._cost_done += self.costs.get(row["key"], 0.0)
        if len(self._buffer) >= self.flush_every or time.perf_counter() - self._flushed > self.flush_seconds:
            self.flush()
        self.show()
        if self.stop.is_set():
            raise KeyboardInterrupt

    def flush(self) -> None:
        """Put what is waiting on disk."""
        self.store.append(self._buffer)
        self._buffer.clear()
        self._flushed = time.perf_counter()

    def show(self) -> None:
        """Tell how far the sweep is."""
        if self.progress is not None:
            done = self.resumed + self.counts.total()
            self.progress(Progress(done, self.total, self.counts["failed"], self._remaining()))

    def _remaining(self) -> float | None:
        if self._cost_done <= 0.0:
            return None
        elapsed = time.perf_counter() - self._start
        return elapsed * max(self._cost_all - self._cost_done, 0.0) / self._cost_done


@contextmanager
def stop_requests() -> Iterator[threading.Event]:
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
        "oil": ", ".join(plan.oils),
        "oil_hash": oils_hash(plan.oils),
        "bodies_hash": _bodies_hash(plan),
        "count": plan.count,
    }


def _bodies_hash(plan: Plan) -> str:
    figures = [body.body().model_dump_json(exclude={"source"}) for body in (plan.solid_1, plan.solid_2)]
    return hashlib.sha256("\n".join(figures).encode()).hexdigest()


def oil_hash(name: str) -> str:
    """Hash of the figures on an oil card."""
    return hashlib.sha256(Oil.load(name).model_dump_json(exclude={"description", "source"}).encode()).hexdigest()


def oils_hash(names: tuple[str, ...]) -> str:
    """Hash of the figures on the oil cards of a plan; that of the card itself where there is one."""
    if len(names) <= 1:
        return oil_hash(names[0]) if names else ""
    return hashlib.sha256("\n".join(oil_hash(name) for name in names).encode()).hexdigest()


def available_jobs() -> int:
    """Processors this process may use, or those a Slurm task was given."""
    given = os.environ.get("SLURM_CPUS_PER_TASK", "")
    if given.isdigit() and int(given) > 0:
        return int(given)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
