"""Workers of a sweep: one case at a time, one thread each, with a time cap; a worker that dies is replaced."""

from __future__ import annotations

import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from types import FrameType
from typing import Any

from ehl.errors import ConvergenceError
from ehl.inputs import Case
from regression.evaluators import Evaluator, input_row

TIME_CAP = "time_cap"
WORKER_LOST = "worker_lost"


@dataclass(frozen=True)
class Task:
    """One case on its way to a worker."""

    key: str
    origin: str
    case: Case


class _TimeCapReached(BaseException):
    """Not an `Exception`: a solver that catches those must not swallow it."""


def evaluate_task(task: Task, evaluate: Evaluator, time_cap: float | None) -> dict[str, Any]:
    """Row of one case. Never raises: what goes wrong becomes status "failed" and a reason."""
    clock = time.perf_counter()
    row: dict[str, Any] = {"key": task.key, "origin": task.origin, "status": "failed", "reason": "", "skipped": ""}
    try:
        row |= input_row(task.case)
        with _limited(time_cap):
            row |= {"status": "converged", **evaluate(task.case)}
    except _TimeCapReached:
        row["reason"] = TIME_CAP
    except ConvergenceError as error:
        row["reason"] = error.reason
    except Exception as error:
        # one bad case must not cost the run; the type says where to look, unless the cap itself broke something
        late = time_cap is not None and time.perf_counter() - clock >= time_cap
        row["reason"] = TIME_CAP if late else f"error:{type(error).__name__}"
    row["seconds"] = time.perf_counter() - clock
    return row


@cache
def _become_worker(parent: int) -> None:
    """Set up a worker process, once: Ctrl-C is the parent's business, and without parent there is nothing to do."""
    # Ctrl-C reaches the whole process group; the parent alone decides what it means
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        # a killed parent says no good-bye; idle workers would stay for minutes
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@contextmanager
def _limited(seconds: float | None) -> Iterator[None]:
    """Raise `_TimeCapReached` in the block after a while, where the system has an alarm clock for it."""
    if seconds is None or not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        yield
        return

    def give_up(number: int, frame: FrameType | None) -> None:
        raise _TimeCapReached

    before = signal.signal(signal.SIGALRM, give_up)
    # again every second: an exception raised inside a callback (a compiler's, say) is swallowed
    signal.setitimer(signal.ITIMER_REAL, seconds, 1.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def compute(
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

    parent = os.getpid()

    def handed_out() -> Iterator[Any]:
        for task in tasks:
            in_flight[task.key] = task
            yield delayed(_work)(parent, task, evaluate, time_cap)

    with parallel_config(backend="loky", inner_max_num_threads=1):
        parallel = Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1)
        rows = parallel(handed_out())
        try:
            for row in rows:  # noqa: UP028 - rows must be closed below, not by `yield from`
                yield row
        finally:
            with warnings.catch_warnings():
                # a sweep that is stopped leaves tasks unused, on purpose
                warnings.simplefilter("ignore", UserWarning)
                rows.close()


def _work(parent: int, task: Task, evaluate: Evaluator, time_cap: float | None) -> dict[str, Any]:
    _become_worker(parent)
    return evaluate_task(task, evaluate, time_cap)
