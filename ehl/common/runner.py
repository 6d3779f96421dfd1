"""Parallel work: tasks are computed in this process, in worker processes, or on a dask cluster.

`run_tasks` returns one row per task, in the order of the tasks. With a journal, tasks with a stored row are not
computed again. Workers that crash are replaced. The task that caused a crash is found by computing the suspects one by
one, each in a new worker.
"""

from __future__ import annotations

import logging
import math
import os
import secrets
import signal
import threading
import time
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

from ehl.common.errors import MixedEhlError, check_count
from ehl.common.threads import single_thread

if TYPE_CHECKING:
    from ehl.common.journal import Journal

# number of successive crashes without a finished task after which the tasks are not the cause
MAX_CRASHES = 5
MAX_JOBS = 1024  # upper limit of processors of one machine
MIN_MOST_JOBS = 32  # worker processes that every machine may start; a worker needs about 0.2 GB
# processor time after which a worker process is ended: the time cap times the first, plus the second [s]
CPU_LIMIT = (1.5, 30.0)
_in_worker_process = False

Row = TypeVar("Row")
Numbered = tuple[int, Any]


class WorkersCrashed(Exception):
    """Workers crashed; the tasks in flight are suspects."""


class AllWorkersCrashed(MixedEhlError):
    """Every worker crashes, independent of its task."""


def granted_workers() -> int:
    """Number of processors permitted by affinity, cgroup quotas, scheduler (Slurm) and OMP_THREAD_LIMIT.

    It is 1 in a worker, and on machines without semaphores, which worker processes need.
    """
    if _in_worker_process or _no_semaphores():
        return 1
    from joblib.externals.loky import cpu_count

    # loky reads the quota of the outermost group only
    granted = [int(cpu_count()), *_quotas(Path("/proc/self/cgroup"), Path("/sys/fs/cgroup"))]
    for name in ("SLURM_CPUS_PER_TASK", "SLURM_CPUS_ON_NODE", "OMP_THREAD_LIMIT"):
        value = os.environ.get(name, "")
        if value.isdecimal() and int(value) > 0:
            granted.append(int(value))
    return min(granted)


def _quotas(groups: Path, root: Path) -> Iterator[int]:
    """Processors permitted by the quotas (cgroup v2) of the group of this process and its parents, rounded up."""
    try:
        own = next(line[3:] for line in groups.read_text().splitlines() if line.startswith("0::"))
    except (OSError, StopIteration):
        return
    place = root / own.strip("/")
    for folder in (place, *place.parents):
        try:
            quota, period = (folder / "cpu.max").read_text().split()
        except (OSError, ValueError):
            continue
        if quota != "max":
            yield max(1, math.ceil(int(quota) / int(period)))


@cache
def _no_semaphores() -> bool:
    """Whether named semaphores are not available (no /dev/shm, or forbidden), so that joblib has no processes."""
    try:
        from _multiprocessing import SemLock  # type: ignore[import-not-found]

        SemLock(0, 0, 1, name=f"/mixed-ehl-{os.getpid()}-{secrets.token_hex(4)}", unlink=True)
    except (ImportError, OSError, ValueError) as error:
        warnings.filterwarnings("ignore", ".*joblib will operate in serial mode")
        logging.getLogger("mixed_ehl").warning("one process: no semaphores here (%s), see docs/sweep.md", error)
        return True
    return False


def checked_jobs(jobs: int | None) -> int:
    """Number of worker processes, at most and by default `granted_workers`.

    Raises `InputError`: the number is below 1, or so large that the workers would fill the memory.
    """
    granted = 1 if jobs == 1 else granted_workers()
    most = max(MIN_MOST_JOBS, 4 * granted)
    if jobs is not None:
        check_count("jobs", jobs, 1, most, f"Worker processes; this process may use {granted}.")
    return granted if jobs is None else min(jobs, granted)


# function of tasks, their function and a time cap [s]: number and row of each task in the order in which they are
# finished; it raises `WorkersCrashed` if workers crashed
Executor = Callable[[Iterator[Numbered], Callable[[Any], Any], float | None], Iterator[Numbered]]


def this_process(tasks: Iterator[Numbered], function: Callable[[Any], Any], _: float | None) -> Iterator[Numbered]:
    """`Executor` of one task after the other, in this process."""
    with single_thread():
        for number, task in tasks:
            yield number, function(task)


def worker_processes(
    tasks: Iterator[Numbered], function: Callable[[Any], Any], time_cap: float | None, *, jobs: int
) -> Iterator[Numbered]:
    """`Executor` of worker processes of this machine (loky), one thread each."""
    from joblib import Parallel, delayed, parallel_config
    from joblib.externals.loky.process_executor import BrokenProcessPool

    # a run that is stopped leaves unused tasks, of which joblib warns, also from a thread of its own
    warnings.filterwarnings("ignore", category=UserWarning, module=r"joblib\.parallel")
    calls = (delayed(_in_worker)(os.getpid(), task, function, time_cap) for task in tasks)
    with parallel_config(backend="loky", inner_max_num_threads=1):
        # only one task waits per worker, so that the last tasks are not queued behind a long one
        parallel = Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1, pre_dispatch=2 * jobs)
        found = parallel(calls)
        try:
            yield from found
        except BrokenProcessPool:
            raise WorkersCrashed from None
        finally:
            found.close()


def _in_worker(parent: int, task: Numbered, function: Callable[[Any], Any], time_cap: float | None) -> Numbered:
    init_worker(parent)
    with cpu_limit(time_cap):
        return task[0], function(task[1])


def local_executor(jobs: int) -> Executor:
    """This process for one job, otherwise worker processes."""
    return this_process if jobs == 1 else partial(worker_processes, jobs=jobs)


def cluster(dask: Any) -> AbstractContextManager[Executor | None]:
    """Workers of a dask cluster: address, scheduler file, ``local:N``, or a connected client; None for None."""
    if dask is None:
        return nullcontext(None)
    from ehl.common.dask_workers import DaskCluster, dask_executor

    return dask_executor(dask) if isinstance(dask, str) else nullcontext(DaskCluster(dask, worker_timeout=3600.0))


def run_tasks(
    tasks: Sequence[Any],
    function: Callable[[Any], Row],
    *,
    jobs: int | None = None,
    journal: Journal | None = None,
    executor: Executor | None = None,
    crashed: Callable[[Any], Row] | None = None,
) -> Iterator[Row]:
    """Rows of tasks, in the order of the tasks.

    tasks: picklable tasks; with a journal each has a `key` (str), and only one of several tasks with one key is
        computed.
    function: picklable function that returns the row of a task, including failures of this task. With a journal the
        row is a mapping of JSON values.
    jobs: worker processes of one thread each; by default `granted_workers`.
    journal: rows found there are not computed again; new rows are appended as soon as they are finished.
    executor: result of `cluster`, which replaces local processes.
    crashed: row of a task that crashed its worker; by default a crash is an error.
    Raises `AllWorkersCrashed`: all workers crash, or one crashed and `crashed` is not given.
    """
    keys: Sequence[Any] = range(len(tasks)) if journal is None else [task.key for task in tasks]
    found: dict[Any, Any] = {} if journal is None else journal.rows
    if journal is not None:
        journal.reused |= journal.on_disk.intersection(keys)
    waiting = {key: task for key, task in zip(keys, tasks, strict=True) if key not in found}
    order = list(waiting)
    if len(waiting) < 2:
        executor = this_process
    elif executor is None:
        executor = local_executor(min(checked_jobs(jobs), len(waiting)))
    new = iter(TaskRun(waiting.values(), function, executor, crashed or _crash_is_an_error))
    for key in keys:
        while key not in found:
            number, row = next(new)
            if journal is None:
                found[order[number]] = row
            else:
                journal.append([{"key": order[number], **cast("Mapping[str, Any]", row)}])
        yield found.pop(key) if journal is None else found[key]


def _crash_is_an_error(task: Any) -> Any:
    raise AllWorkersCrashed(f"a worker crashed at {task!r:.200}. Check the memory, and run `mixed-ehl doctor`.")


class TaskRun:
    """Computes tasks and replaces crashed workers; iterating gives number and row of each task as it is finished.

    tasks: picklable tasks; taken when a worker is free.
    function: returns the row of a task.
    crashed: returns the row of a task that crashed its worker.
    time_cap: wall time of a task [s]; the system ends a process that exceeds it by far (`CPU_LIMIT`).
    restarts: number of crashes after which workers were replaced.
    """

    def __init__(
        self,
        tasks: Iterable[Any],
        function: Callable[[Any], Any],
        executor: Executor,
        crashed: Callable[[Any], Any],
        time_cap: float | None = None,
    ) -> None:
        self._numbered = enumerate(tasks)
        self._function, self._executor, self._crashed, self._time_cap = function, executor, crashed, time_cap
        self._lock = threading.Lock()
        self._in_flight: dict[int, Any] = {}
        self.restarts = 0

    def _taken(self) -> Iterator[Numbered]:
        """The remaining tasks; executors may take them from another thread."""
        while True:
            with self._lock:
                entry = next(self._numbered, None)
                if entry is None:
                    return
                self._in_flight[entry[0]] = entry[1]
            yield entry

    def _results(self, tasks: Iterator[Numbered]) -> Iterator[Numbered]:
        for number, row in self._executor(tasks, self._function, self._time_cap):
            self._in_flight.pop(number, None)
            yield number, row

    def __iter__(self) -> Generator[Numbered, None, None]:
        """Number and row of every task.

        Raises `AllWorkersCrashed`: `MAX_CRASHES` tasks in a row crashed their worker and none was finished.
        """
        crashed: dict[int, Any] = {}

        def known_as_crashed() -> Iterator[Numbered]:
            while crashed:
                number, task = crashed.popitem()
                yield number, self._crashed(task)

        while True:
            try:
                for result in self._results(self._taken()):
                    # other tasks are finished, so that those that crashed are the cause
                    yield from known_as_crashed()
                    yield result
                if not self._in_flight:
                    yield from known_as_crashed()
                    return
            except WorkersCrashed:
                self.restarts += 1
            # one of these crashed its worker; each is computed alone in a new worker to find it
            for number, task in list(self._in_flight.items()):
                try:
                    for result in self._results(iter([(number, task)])):
                        yield from known_as_crashed()
                        yield result
                except WorkersCrashed:
                    self.restarts += 1
                    crashed[number] = self._in_flight.pop(number)
                    if len(crashed) >= MAX_CRASHES:
                        raise AllWorkersCrashed(
                            f"all workers crash: the last {len(crashed)} cases each crashed their worker, and none was "
                            "finished. Check the memory, and run `mixed-ehl doctor` in the environment of the workers. "
                            "Finished cases are on disk; the same command resumes."
                        ) from None


@contextmanager
def cpu_limit(seconds: float | None) -> Iterator[None]:
    """Let the system end this process if a block exceeds its time cap by far.

    A compiled loop that does not return receives no exception. The timer counts processor time without waiting.
    """
    if seconds is None or not hasattr(signal, "setitimer"):
        yield
        return
    signal.setitimer(signal.ITIMER_VIRTUAL, CPU_LIMIT[0] * seconds + CPU_LIMIT[1])
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)


@cache
def init_worker(parent: int) -> None:
    """Set up a worker process once: it ignores Ctrl-C and ends with its parent."""
    global _in_worker_process
    _in_worker_process = True
    # Ctrl-C is sent to the whole process group, but only the parent handles it
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        # a killed parent cannot end its workers, and idle workers would remain for minutes
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
