"""Where the cases of a sweep, or the points of a search, are computed: here, in worker processes, on a dask cluster.

An executor distributes tasks and returns rows as they are finished. A worker that crashes is replaced; the case that
crashed it is found by computing the suspects one by one.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Any, Protocol

from ehl.common.errors import MixedEhlError
from regression.sweeping.workers import cpu_limit, init_worker

# after so many crashes in a row without a finished case, the cases are not the cause
MAX_CRASHES = 5

Row = Mapping[str, Any]


class Task(Protocol):
    """Anything to be computed, with a key that tells it from all others; it travels to workers."""

    @property
    def key(self) -> str:
        """Unique."""
        ...


class Runner(Protocol):
    """What a worker does with a task; it travels to workers."""

    @property
    def time_cap(self) -> float | None:
        """Wall time of a task [s]."""
        ...

    def __call__(self, task: Any) -> Row:
        """Row of the task, with its ``key``. Never raises for what is wrong with the task."""
        ...

    def crashed(self, task: Any) -> Row:
        """Row of a task whose worker crashed."""
        ...


class WorkersCrashed(Exception):
    """Workers crashed; the tasks in flight are suspects."""


class AllWorkersCrashed(MixedEhlError):
    """Every worker crashes, whatever it computes."""

    exit_code = 1


class Executor(Protocol):
    """What computes tasks."""

    def rows(self, tasks: Iterator[Task], runner: Runner, in_flight: dict[str, Task]) -> Iterator[Row]:
        """Rows as they are finished; `in_flight` holds the tasks that were distributed and have no row yet.

        Raises
        ------
        WorkersCrashed
            Workers crashed.
        """
        ...


@dataclass(frozen=True)
class ThisProcess:
    """One case after the other, here."""

    def rows(self, tasks: Iterator[Task], runner: Runner, in_flight: dict[str, Task]) -> Iterator[Row]:
        """As `Executor.rows`."""
        from threadpoolctl import threadpool_limits

        with threadpool_limits(1):
            for task in tasks:
                yield runner(task)


@dataclass(frozen=True)
class LocalProcesses:
    """Worker processes of this machine (joblib, loky), one thread each."""

    jobs: int

    def rows(self, tasks: Iterator[Task], runner: Runner, in_flight: dict[str, Task]) -> Iterator[Row]:
        """As `Executor.rows`."""
        from joblib import Parallel, delayed, parallel_config
        from joblib.externals.loky.process_executor import BrokenProcessPool

        parent = os.getpid()

        def distributed() -> Iterator[Any]:
            for task in tasks:
                in_flight[task.key] = task
                yield delayed(_in_worker)(parent, task, runner)

        with parallel_config(backend="loky", inner_max_num_threads=1):
            # one case waits at each worker: the longest cases come first and the last ones must not queue
            parallel = Parallel(
                n_jobs=self.jobs, return_as="generator_unordered", batch_size=1, pre_dispatch=2 * self.jobs
            )
            rows = parallel(distributed())
            try:
                for row in rows:
                    in_flight.pop(row["key"], None)
                    yield row
            except BrokenProcessPool:
                raise WorkersCrashed from None
            finally:
                with warnings.catch_warnings():
                    # a sweep that is stopped leaves tasks unused, on purpose
                    warnings.simplefilter("ignore", UserWarning)
                    rows.close()


def _in_worker(parent: int, task: Task, runner: Runner) -> Row:
    init_worker(parent)
    with cpu_limit(runner.time_cap):
        return runner(task)


def local_executor(jobs: int) -> Executor:
    """This process for one job, worker processes for more."""
    return ThisProcess() if jobs == 1 else LocalProcesses(jobs)


def cluster(dask: Any) -> AbstractContextManager[Executor | None]:
    """Workers of a dask cluster: address, scheduler file, ``local:N``, or a connected client; None for None."""
    if dask is None:
        return nullcontext(None)
    from regression.sweeping.dask_workers import DaskCluster, dask_executor

    return dask_executor(dask) if isinstance(dask, str) else nullcontext(DaskCluster(dask, worker_timeout=3600.0))


def compute(
    pending: Callable[[], Iterator[Task]], runner: Runner, executor: Executor, record: Callable[[Row], None]
) -> int:
    """Compute all pending tasks; returns how often workers crashed.

    Raises
    ------
    AllWorkersCrashed
        `MAX_CRASHES` cases in a row crashed their worker and none was finished.
    """
    crashes = 0
    crashed: dict[str, Task] = {}

    def record_crashed() -> None:
        for task in crashed.values():
            record(runner.crashed(task))
        crashed.clear()

    def finished(row: Row) -> None:
        # other cases are finished, so those that crashed are the cause
        record_crashed()
        record(row)

    while True:
        in_flight: dict[str, Task] = {}
        try:
            for row in executor.rows((task for task in pending() if task.key not in crashed), runner, in_flight):
                finished(row)
            record_crashed()
            return crashes
        except WorkersCrashed:
            crashes += 1
        # one of these crashed its worker: alone in a fresh worker each, they show which
        for task in list(in_flight.values()):
            try:
                for row in executor.rows(iter([task]), runner, {}):
                    finished(row)
            except WorkersCrashed:
                crashes += 1
                crashed[task.key] = task
                if len(crashed) >= MAX_CRASHES:
                    raise AllWorkersCrashed(
                        f"all workers crash: the last {len(crashed)} cases each crashed their worker, and none was "
                        "finished. Check the memory, and run `mixed-ehl doctor` where the workers run. "
                        "Finished cases are on disk; the same command resumes."
                    ) from None
