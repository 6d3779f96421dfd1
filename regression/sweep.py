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
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any

from ehl.errors import ConvergenceError, InputError
from ehl.inputs import Case
from ehl.oil import Oil
from regression.evaluators import SOLVER, Evaluator, case_key, input_row, solve_outputs
from regression.plan import Plan
from regression.store import ResultStore

TIME_CAP = "time_cap"
WORKER_LOST = "worker_lost"


@dataclass(frozen=True)
class Task:
    """One case on its way to a worker."""

    key: str
    origin: str
    case: Case


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
    converged, failed : int
        Computed in this call.
    reasons : dict
        Number of failed cases by reason.
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
    failed: int
    reasons: dict[str, int]
    restarts: int
    torn: int
    seconds: float


class _TimeCapReached(BaseException):
    """Not an `Exception`: a solver that catches those must not swallow it."""


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
    time_cap: float | None = 120.0,
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
    progress : callable, optional
        Called after every case.

    Returns
    -------
    SweepReport

    Raises
    ------
    InputError
        The folder holds another run, cannot be written, or the shard is not one of n.
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
    converged = failed = 0
    reasons: dict[str, int] = {}
    with ResultStore(path, run_meta(plan, version)) as store:
        done = store.keys
        resumed = len(done)
        buffer: list[Mapping[str, Any]] = []
        last_flush = time.perf_counter()

        def record(row: Mapping[str, Any]) -> None:
            nonlocal converged, failed, last_flush
            buffer.append(row)
            done.add(row["key"])
            if row["status"] == "converged":
                converged += 1
            else:
                failed += 1
                reasons[row["reason"]] = reasons.get(row["reason"], 0) + 1
            if len(buffer) >= flush_every or time.perf_counter() - last_flush > flush_seconds:
                store.append(buffer)
                buffer.clear()
                last_flush = time.perf_counter()
            if progress is not None:
                progress(Progress(len(done), total, failed))

        def pending() -> Iterator[Task]:
            for index, (origin, case) in enumerate(plan.cases()):
                if index % shards == number - 1:
                    key = case_key(case, version)
                    if key not in done:
                        yield Task(key, origin, case)

        try:
            if progress is not None:
                progress(Progress(resumed, total, 0))
            restarts = _compute(pending, evaluate, jobs, time_cap, record)
        finally:
            store.append(buffer)
    seconds = time.perf_counter() - clock
    return SweepReport(path, total, resumed, converged, failed, reasons, restarts, store.torn, seconds)


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


def evaluate_task(task: Task, evaluate: Evaluator, time_cap: float | None) -> dict[str, Any]:
    """Row of one case. Never raises: what goes wrong becomes status "failed" and a reason."""
    clock = time.perf_counter()
    row: dict[str, Any] = {"key": task.key, "origin": task.origin, "status": "failed", "reason": "", "skipped": ""}
    try:
        row |= input_row(task.case)
        with _limited(time_cap):
            row |= evaluate(task.case)
        row["status"] = "converged"
    except _TimeCapReached:
        row["reason"] = TIME_CAP
    except ConvergenceError as error:
        row["reason"] = error.reason
    except Exception as error:
        # one bad case must not cost the run; the type says where to look
        row["reason"] = f"error:{type(error).__name__}"
    row["seconds"] = time.perf_counter() - clock
    return row


@contextmanager
def _limited(seconds: float | None) -> Iterator[None]:
    """Raise `_TimeCapReached` in the block after a while, where the system has an alarm clock for it."""
    if seconds is None or not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        yield
        return

    def give_up(number: int, frame: FrameType | None) -> None:
        raise _TimeCapReached

    before = signal.signal(signal.SIGALRM, give_up)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def _compute(
    pending: Callable[[], Iterator[Task]],
    evaluate: Evaluator,
    jobs: int,
    time_cap: float | None,
    record: Callable[[Mapping[str, Any]], None],
) -> int:
    """Compute all pending tasks; returns how often lost workers were replaced."""
    if jobs == 1:
        from threadpoolctl import threadpool_limits

        with threadpool_limits(1):
            for task in pending():
                record(evaluate_task(task, evaluate, time_cap))
        return 0

    from joblib.externals.loky.process_executor import BrokenProcessPool

    restarts = 0
    while True:
        in_flight: dict[str, Task] = {}
        try:
            for row in _in_workers(pending(), evaluate, jobs, time_cap, in_flight):
                in_flight.pop(row["key"], None)
                record(row)
            return restarts
        except BrokenProcessPool:
            restarts += 1
        # one of these killed its worker: alone in a fresh worker each, it shows which
        for task in in_flight.values():
            try:
                for row in _in_workers(iter([task]), evaluate, jobs, time_cap, {}):
                    record(row)
            except BrokenProcessPool:
                restarts += 1
                record(_lost(task))


def _lost(task: Task) -> dict[str, Any]:
    row = {"key": task.key, "origin": task.origin, "status": "failed", "reason": WORKER_LOST, "skipped": ""}
    return row | input_row(task.case)


def _in_workers(
    tasks: Iterator[Task],
    evaluate: Evaluator,
    jobs: int,
    time_cap: float | None,
    in_flight: dict[str, Task],
) -> Iterator[dict[str, Any]]:
    """Rows as the workers finish them; `in_flight` gets every task that was handed out."""
    from joblib import Parallel, delayed, parallel_config

    def handed_out() -> Iterator[Any]:
        for task in tasks:
            in_flight[task.key] = task
            yield delayed(evaluate_task)(task, evaluate, time_cap)

    with parallel_config(backend="loky", inner_max_num_threads=1):
        parallel = Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1)
        yield from parallel(handed_out())
