"""Work of a worker process: one case at a time with a time cap, and with fallback settings if the solver fails."""

from __future__ import annotations

import ctypes
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import Any

from ehl.common.errors import ConvergenceError
from ehl.contact import Contact
from regression.sweeping.evaluators import FINAL_REASONS, Evaluator, case_numbers, fallback_settings, input_row

TIME_CAP = "time_cap"
WORKER_CRASHED = "worker_lost"  # the reason as result files state it


@dataclass(frozen=True)
class CaseTask:
    """One case for a worker; `failed` is the number of settings that failed before."""

    key: str
    origin: str
    case: Contact
    failed: int = 0


@dataclass(frozen=True)
class CaseRunner:
    """Solves a case within its time cap, with fallback settings."""

    evaluate: Evaluator  # contact to results
    time_cap: float | None = None  # wall time for a case, all attempts together [s]
    retries: int = 0  # how many fallback settings are tried after a failure

    def __call__(self, task: CaseTask) -> dict[str, Any]:
        """Row of one case. An error gives the status "failed" and a reason instead of an exception."""
        clock, processor = time.perf_counter(), time.thread_time()
        row = _failed_row(task)
        try:
            row |= input_row(task.case) | {"case": case_numbers(task.case)}
            with _time_limit(self.time_cap):
                self._attempt(task, row)
        except _TimeCapReached:
            # after a retry that was stopped, the reason of the solver remains
            row["reason"] = row["reason"] or TIME_CAP
        except Exception as error:
            # an error of one case must not end the run; its reason is the type of the error or the time cap
            late = self.time_cap is not None and time.perf_counter() - clock >= self.time_cap
            row["reason"] = row["reason"] or (TIME_CAP if late else f"error:{type(error).__name__}")
        row["seconds"] = time.perf_counter() - clock
        row["seconds_cpu"] = time.thread_time() - processor
        return row

    def crashed(self, task: CaseTask) -> dict[str, Any]:
        """Row of a case whose worker crashed."""
        return _failed_row(task) | {"reason": WORKER_CRASHED, "case": case_numbers(task.case)} | input_row(task.case)

    def _attempt(self, task: CaseTask, row: dict[str, Any]) -> None:
        for step in range(task.failed, task.failed + self.retries + 1):
            setting = fallback_settings(task.case, step)
            if setting is None:
                return
            case, row["setting"] = setting
            row["attempts"] = step + 1
            try:
                row |= {"status": "converged", "reason": "", **self.evaluate(case)}
            except ConvergenceError as error:
                row["reason"] = error.reason
                if error.reason in FINAL_REASONS:
                    return
            else:
                return


def _failed_row(task: CaseTask) -> dict[str, Any]:
    row = {"key": task.key, "origin": task.origin, "status": "failed", "reason": "", "skipped": "", "setting": ""}
    return {**row, "attempts": task.failed + 1}


class _TimeCapReached(BaseException):
    """Not an `Exception`, so that a solver that catches exceptions does not suppress it."""


@contextmanager
def _time_limit(seconds: float | None) -> Iterator[None]:
    """Raise `_TimeCapReached` in the block after a time, and again every second.

    The repetition is needed because exceptions inside callbacks, for example of a compiler, are suppressed.
    """
    if seconds is None:
        yield
    elif hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread():
        with _alarm(seconds):
            yield
    else:
        with _thread_alarm(seconds):
            yield


@contextmanager
def _alarm(seconds: float) -> Iterator[None]:
    def raise_timeout(number: int, frame: FrameType | None) -> None:
        raise _TimeCapReached

    before = signal.signal(signal.SIGALRM, raise_timeout)
    signal.setitimer(signal.ITIMER_REAL, seconds, 1.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


@contextmanager
def _thread_alarm(seconds: float) -> Iterator[None]:
    """Time limit in a thread that receives no signals, such as those of dask workers."""
    raise_in = ctypes.pythonapi.PyThreadState_SetAsyncExc
    thread = ctypes.c_ulong(threading.get_ident())
    over, lock = threading.Event(), threading.Lock()

    def watch() -> None:
        wait = seconds
        while not over.wait(wait):
            with lock:
                if not over.is_set():
                    raise_in(thread, ctypes.py_object(_TimeCapReached))
            wait = 1.0

    threading.Thread(target=watch, daemon=True).start()
    try:
        yield
    finally:
        while True:
            try:
                with lock:
                    over.set()
                raise_in(thread, None)
                break
            except _TimeCapReached:
                continue  # raised after the end of the block
