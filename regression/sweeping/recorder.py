"""Recording of finished cases of a sweep: counts, rows on disk, progress, and stop on request."""

from __future__ import annotations

import signal
import threading
import time
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from types import FrameType
from typing import Any

from ehl.common.journal import Journal
from ehl.common.progress import report_progress


@dataclass
class Recorder:
    """Counts rows, writes them to disk in groups, and ends the sweep between two cases on request."""

    journal: Journal
    total: int
    resumed: int
    flush_every: int
    flush_seconds: float
    stop: threading.Event
    costs: Mapping[str, float]
    counts: Counter[str] = field(default_factory=Counter)
    reasons: defaultdict[str, Counter[str]] = field(default_factory=lambda: defaultdict(Counter))
    fallback: int = 0
    seconds_cases: float = 0.0
    seconds_cpu: float = 0.0
    _buffer: list[Mapping[str, Any]] = field(default_factory=list)
    _start: float = field(default_factory=time.perf_counter)
    _flushed: float = field(default_factory=time.perf_counter)
    _cost_done: float = 0.0
    _cost_all: float = field(init=False)

    def __post_init__(self) -> None:
        self._cost_all = sum(self.costs.values())

    def record(self, row: Mapping[str, Any]) -> None:
        """Record a row; raises `KeyboardInterrupt` after a stop request."""
        # missing values become nan or empty texts when the rows are read
        self._buffer.append({name: value for name, value in row.items() if value == value and value != ""})
        self.counts[row["status"]] += 1
        if row["status"] != "converged":
            self.reasons[row["status"]][row["reason"]] += 1
        if row["status"] != "failed" and row.get("setting"):
            self.fallback += 1
        self.seconds_cases += float(row.get("seconds", 0.0))
        self.seconds_cpu += float(row.get("seconds_cpu", 0.0))
        self._cost_done += self.costs.get(row["key"], 0.0)
        if len(self._buffer) >= self.flush_every or time.perf_counter() - self._flushed > self.flush_seconds:
            self.flush()
        self.show()
        if self.stop.is_set():
            raise KeyboardInterrupt

    def flush(self) -> None:
        """Write the waiting rows to disk."""
        self.journal.append(self._buffer)
        self._buffer.clear()
        self._flushed = time.perf_counter()

    def show(self) -> None:
        """Report the progress."""
        step = f"{failed} failed, cases" if (failed := self.counts["failed"]) else "cases"
        report_progress(step, self.resumed + self.counts.total(), self.total, self._remaining())

    def _remaining(self) -> float | None:
        if self._cost_done <= 0.0:
            return None
        elapsed = time.perf_counter() - self._start
        return elapsed * max(self._cost_all - self._cost_done, 0.0) / self._cost_done


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
