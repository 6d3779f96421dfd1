"""Progress reports of long computations in all three packages.

A computation calls `report_progress`; the callback given to `progress_to` receives each `Progress`. Public functions
take the callback as `progress=`; ``progress=print`` writes one line per step.

Times as text.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass


def duration(seconds: float) -> str:
    """A duration as text, such as ``42 s``, ``3 min 20 s`` or ``5 h 12 min``."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


def counted(number: int, noun: str) -> str:
    """A number and its noun, such as ``1 case`` and ``2 cases``."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


@dataclass(frozen=True)
class Progress:
    """State of a long computation."""

    step: str  # name of the counted items, such as "contacts"
    # number of finished items, and number of all items
    done: int
    total: int
    seconds_left: float | None = None  # estimated wall time of the remaining items [s]; None without an estimate

    def __str__(self) -> str:
        left = f", about {duration(self.seconds_left)} left" if self.seconds_left and self.done < self.total else ""
        return f"{self.step} {self.done} of {self.total}{left}"


ProgressCallback = Callable[[Progress], object]
_callback: ContextVar[ProgressCallback | None] = ContextVar("progress", default=None)


def report_progress(step: str, done: int, total: int, seconds_left: float | None = None) -> None:
    """Report the state of a step to the callback of the enclosing `progress_to`, if any."""
    callback = _callback.get()
    if callback is not None:
        callback(Progress(step, done, total, seconds_left))


@contextmanager
def progress_to(callback: ProgressCallback | None) -> Iterator[None]:
    """Send the progress reported in the block to `callback`; None keeps the callback of the enclosing block."""
    if callback is None:
        yield
        return
    token = _callback.set(callback)
    try:
        yield
    finally:
        _callback.reset(token)
