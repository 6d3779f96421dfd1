"""Where the cases of a sweep are computed: this process, worker processes of this machine, or a dask cluster.

An executor hands out tasks and gives rows back as they are finished. A worker that dies is replaced; the case that
killed it is found by computing the suspects one by one.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from ehl.io.errors import MixedEhlError
from regression.sweeping.workers import Task, Work, become_worker, dead_end, lost_row

# so many cases in a row each took their worker along, and none was finished: no case is to blame for that
MAX_LOST_WORKERS = 5

Row = Mapping[str, Any]


class WorkersLost(Exception):
    """Workers died; the tasks in flight are suspects."""


class WorkersDie(MixedEhlError):
    """Every worker dies, whatever it computes."""

    exit_code = 1


class Executor(Protocol):
    """What computes tasks."""

    def rows(self, tasks: Iterator[Task], work: Work, in_flight: dict[str, Task]) -> Iterator[Row]:
        """Rows as they are finished; `in_flight` holds the tasks that were handed out and not given back.

        Raises
        ------
        WorkersLost
            Workers died.
        """
        ...


@dataclass(frozen=True)
class ThisProcess:
    """One case after the other, here."""

    def rows(self, tasks: Iterator[Task], work: Work, in_flight: dict[str, Task]) -> Iterator[Row]:
        """As `Executor.rows`."""
        from threadpoolctl import threadpool_limits

        with threadpool_limits(1):
            for task in tasks:
                yield work(task)


@dataclass(frozen=True)
class LocalProcesses:
    """Worker processes of this machine (joblib, loky), one thread each."""

    jobs: int

    def rows(self, tasks: Iterator[Task], work: Work, in_flight: dict[str, Task]) -> Iterator[Row]:
        """As `Executor.rows`."""
        from joblib import Parallel, delayed, parallel_config
        from joblib.externals.loky.process_executor import BrokenProcessPool

        parent = os.getpid()

        def handed_out() -> Iterator[Any]:
            for task in tasks:
                in_flight[task.key] = task
                yield delayed(_in_worker)(parent, task, work)

        with parallel_config(backend="loky", inner_max_num_threads=1):
            # one case waits at each worker: the longest cases come first and the last ones must not queue
            parallel = Parallel(
                n_jobs=self.jobs, return_as="generator_unordered", batch_size=1, pre_dispatch=2 * self.jobs
            )
            rows = parallel(handed_out())
            try:
                for row in rows:
                    in_flight.pop(row["key"], None)
                    yield row
            except BrokenProcessPool:
                raise WorkersLost from None
            finally:
                with warnings.catch_warnings():
                    # a sweep that is stopped leaves tasks unused, on purpose
                    warnings.simplefilter("ignore", UserWarning)
                    rows.close()


def _in_worker(parent: int, task: Task, work: Work) -> Row:
    become_worker(parent)
    with dead_end(work.time_cap):
        return work(task)


def local_executor(jobs: int) -> Executor:
    """This process for one job, worker processes for more."""
    return ThisProcess() if jobs == 1 else LocalProcesses(jobs)


def compute(
    pending: Callable[[], Iterator[Task]], work: Work, executor: Executor, record: Callable[[Row], None]
) -> int:
    """Compute all pending tasks; returns how often workers were lost.

    Raises
    ------
    WorkersDie
        `MAX_LOST_WORKERS` cases in a row lost their worker and none was finished.
    """
    losses = 0
    lost: dict[str, Task] = {}

    def record_lost() -> None:
        for task in lost.values():
            record(lost_row(task))
        lost.clear()

    def finished(row: Row) -> None:
        # workers live, so the cases that lost theirs are to blame
        record_lost()
        record(row)

    while True:
        in_flight: dict[str, Task] = {}
        try:
            for row in executor.rows((task for task in pending() if task.key not in lost), work, in_flight):
                finished(row)
            record_lost()
            return losses
        except WorkersLost:
            losses += 1
        # one of these killed its worker: alone in a fresh worker each, it shows which
        for task in list(in_flight.values()):
            try:
                for row in executor.rows(iter([task]), work, {}):
                    finished(row)
            except WorkersLost:
                losses += 1
                lost[task.key] = task
                if len(lost) >= MAX_LOST_WORKERS:
                    raise WorkersDie(
                        f"workers die: the last {len(lost)} cases each ended their worker and none was finished. "
                        "Is there memory enough, and does `mixed-ehl doctor` pass where the workers run? "
                        "What is finished is on disk; the same command goes on."
                    ) from None
