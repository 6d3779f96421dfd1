"""Progress of a sweep: a bar on a terminal, plain lines elsewhere (log files, job arrays)."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import IO

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
from rich.progress import Progress as RichProgress

from ehl.common.duration import duration
from regression.sweeping.recorder import Progress

LINE_EVERY = 30.0  # between two lines [s]


@contextmanager
def show_progress(name: str, stream: IO[str] | None = None) -> Iterator[Callable[[Progress], None]]:
    """Show how far a sweep is while the block runs, on standard error; gives what to call with each `Progress`."""
    console = Console(file=stream or sys.stderr)
    if console.is_terminal:
        with _bar(name, console) as show:
            yield show
    else:
        yield _Lines(name, console.file).show


@contextmanager
def _bar(name: str, console: Console) -> Iterator[Callable[[Progress], None]]:
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[left]}", markup=False),
        TextColumn("{task.fields[failed]}", markup=False),
    )
    with RichProgress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(name, total=None, failed="", left="")

        def show(progress: Progress) -> None:
            left, failed = _words(progress)
            bar.update(task, completed=progress.done, total=progress.total, failed=failed, left=left)

        yield show


class _Lines:
    """One line at once, one every half minute, and one at the end."""

    def __init__(self, name: str, stream: IO[str], clock: Callable[[], float] = time.perf_counter) -> None:
        self.name, self.stream, self.clock = name, stream, clock
        self.last = -LINE_EVERY

    def show(self, progress: Progress) -> None:
        now = self.clock()
        if now - self.last < LINE_EVERY and progress.done < progress.total:
            return
        self.last = now
        words = ", ".join(word for word in _words(progress) if word)
        line = f"{self.name}: {progress.done} of {progress.total} cases" + (f", {words}" if words else "")
        print(line, file=self.stream, flush=True)


def _words(progress: Progress) -> tuple[str, str]:
    known = progress.remaining is not None and progress.done < progress.total
    left = f"about {duration(progress.remaining or 0.0)} left" if known else ""
    elapsed = f"{duration(progress.elapsed)} elapsed" if progress.elapsed >= 1.0 else ""
    return ", ".join(filter(None, (elapsed, left))), f"{progress.failed} failed" if progress.failed else ""
