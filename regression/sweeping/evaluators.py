"""Evaluation of one case of a sweep to a row of results; settings that are tried after a failure.

Work of a worker process: one case at a time with a time cap, and with fallback settings if the solver fails.
"""

from __future__ import annotations

import ctypes
import hashlib
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from types import FrameType
from typing import Any, get_args

import numpy as np
from pydantic import BaseModel

from ehl.common.errors import ConvergenceError
from ehl.contact import Contact
from ehl.fluid.lubricant_inputs import OilLubricant
from ehl.fluid.oil import Oil
from ehl.inputs import Accuracy
from ehl.sequence import MOTION
from regression.data.result_files import OUTPUT_UNITS, SURFACE_UNITS
from regression.friction.conditions import UNITS, derive, lubricant_row
from regression.friction.published_registry import PUBLISHED

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


def _time_limit(seconds: float | None) -> AbstractContextManager[None]:
    """Raise `_TimeCapReached` in the block after a time, and again every second.

    The repetition is needed because exceptions inside callbacks, for example of a compiler, are suppressed.
    """
    if seconds is None:
        return nullcontext()
    signals = hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()
    return _alarm(seconds) if signals else _thread_alarm(seconds)


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


Outputs = Mapping[str, float | str]
Evaluator = Callable[[Contact], Outputs]

# reasons in the case itself or in the formula, which no other setting can change
FINAL_REASONS = frozenset({"too_hot", "shear_strength", "undefined"})
_ACCURACIES: tuple[str, ...] = get_args(Accuracy)


def case_numbers(case: BaseModel, prefix: str = "") -> dict[str, Any]:
    """Every input of a case that has a value, by its full name such as ``surface.seed``, as stored in journals."""
    found: dict[str, Any] = {}
    for name in type(case).model_fields:
        value = getattr(case, name)
        if isinstance(value, BaseModel):
            found |= case_numbers(value, f"{prefix}{name}.")
        elif value is not None:
            found[prefix + name] = value
    return found


def case_key(case: Contact, version: str) -> str:
    """Key of a case: digest of the version of the solver and of `case_numbers`."""
    return hashlib.sha256(repr((version, *case_numbers(case).items())).encode()).hexdigest()


def input_row(case: Contact) -> dict[str, float | str]:
    """Inputs of a case as stored in a dataset, Rq after running-in, and the name of its oil card."""
    contact = case.line_contact()
    lubricant = case.lubricant.lubricant()
    return {
        **{name: getattr(contact, name) for name in MOTION},
        "temperature_oil": case.lubricant.temperature_oil,
        "roughness_rms_1": case.surface.rms_in_contact(case.surface.roughness_rms_1),
        "roughness_rms_2": case.surface.rms_in_contact(case.surface.roughness_rms_2),
        **{name: float(getattr(case.surface, name)) for name in SURFACE_UNITS},
        **lubricant_row(lubricant, contact.pressure_hertz),
        "oil": case.lubricant.oil if isinstance(case.lubricant, OilLubricant) else "",
    }


def solve_outputs(case: Contact) -> Outputs:
    """Results of the contact solver, with its status (converged, unsettled) and reason.

    Raises `ConvergenceError`: with the reason of the solver.
    """
    result = case.solve()
    if result.status == "failed":
        raise ConvergenceError(result.reason)
    values: dict[str, float | str] = {name: float(getattr(result, name, np.nan)) for name in OUTPUT_UNITS}
    if result.transient is not None:
        run = result.transient
        values |= {"boundary_film": run.boundary_film, "nodes": run.nodes, "steps": run.steps}
        values["travel"] = run.travel * case.line_contact().half_width
    skipped = "; ".join(dict.fromkeys(text.partition(":")[0] for text in result.skipped))
    return values | {"status": result.status, "reason": result.reason, "skipped": skipped}


def published_outputs(case: Contact, name: str) -> Outputs:
    """Friction by a published formula, for fast trials of plans and fits.

    Raises `ConvergenceError`: the formula has no positive value for this case.
    """
    columns = derive({key: np.array([value]) for key, value in input_row(case).items() if key in UNITS})
    base = Oil.load(case.lubricant.oil).base if isinstance(case.lubricant, OilLubricant) else "mineral"
    mu, _ = PUBLISHED[name].values(columns, base)
    if np.isnan(mu[0]):
        raise ConvergenceError("undefined")
    return {"friction_coefficient": float(mu[0]), "film_ratio": float(columns["film_ratio_formula"][0])}


def fallback_settings(case: Contact, step: int) -> tuple[Contact, str] | None:
    """The case with the settings after `step` failures, and the changes as text; None if no settings are left.

    Each step uses the next finer accuracy; the last step switches the shortcuts off.
    """
    if step == 0:
        return case, ""
    level = _ACCURACIES.index(case.model.accuracy)
    finer = min(level + step, len(_ACCURACIES) - 1)
    changes: dict[str, object] = {}
    if finer > level:
        # a friction tolerance would override the mesh of the accuracy
        changes |= {"accuracy": _ACCURACIES[finer], "friction_tolerance": None}
    beyond = step - (finer - level)
    if beyond == 1 and case.model.shortcuts != "off":
        changes["shortcuts"] = "off"
    elif beyond > 0:
        return None
    changed = " ".join(f"{name}={value}" for name, value in changes.items() if value is not None)
    return case.model_copy(update={"model": case.model.model_copy(update=changes)}), changed
