"""A sweep on a dask cluster: `client.map` hands cases out, `as_completed` takes rows back, the parent alone writes.

joblib's dask backend is not used: it ignores n_jobs and hung when a task kept killing its worker.
"""

from __future__ import annotations

import logging
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import Any

from ehl import __version__
from ehl.io.errors import InputError, MixedEhlError
from regression.sweeping.executors import MAX_LOST_WORKERS, Executor, Row, WorkersLost
from regression.sweeping.workers import Task, Work, dead_end, one_thread

# cases at each thread of a worker: one runs, one waits
_DEPTH = 2
CONNECT = 10  # how long an address may take to answer [s]
_LOOK = 5.0  # how often a silent cluster is looked at [s]


class ClusterLost(MixedEhlError):
    """The scheduler or all workers of a cluster are gone."""

    exit_code = 1


@dataclass(frozen=True)
class DaskCluster:
    """Workers of a dask cluster.

    Parameters
    ----------
    client : distributed.Client
        Connected.
    patience : float
        How long the cluster may be without any worker [s].
    """

    client: Any
    patience: float = 60.0

    def rows(self, tasks: Iterator[Task], work: Work, in_flight: dict[str, Task]) -> Iterator[Row]:
        """As `regression.sweeping.executors.Executor.rows`."""
        distributed = import_module("distributed")
        self._wait_for_workers()
        run = uuid.uuid4().hex[:8]
        futures: dict[Any, Task] = {}
        killed = 0

        def hand_out(count: int) -> list[Any]:
            batch = list(islice(tasks, count))
            in_flight.update({task.key: task for task in batch})
            keys = [f"mixed-ehl-{run}-{task.key}" for task in batch]
            new = self.client.map(_in_dask_worker, batch, work=work, version=__version__, key=keys, pure=False)
            futures.update(zip(new, batch, strict=True))
            return list(new)

        try:
            hand_out(self._width())
            while futures:
                finished = distributed.as_completed(list(futures), timeout=_LOOK)
                try:
                    for future in finished:
                        task = futures.pop(future)
                        row = self._result(future)
                        if row is None:
                            killed += 1
                            if killed >= MAX_LOST_WORKERS:
                                raise WorkersLost
                        else:
                            killed = 0
                            del in_flight[task.key]
                            yield row
                        for new in hand_out(max(1, self._width() - len(futures))):
                            finished.add(new)
                except TimeoutError:
                    self._wait_for_workers()
            if in_flight:
                raise WorkersLost
        finally:
            if futures and self.client.status == "running":
                self.client.cancel(list(futures), force=True)

    def _width(self) -> int:
        return _DEPTH * max(1, sum(int(n) for n in self.client.nthreads().values()))

    def _result(self, future: Any) -> Row | None:
        """The row of a finished future; None where its worker died.

        Raises
        ------
        ClusterLost
            The scheduler is gone.
        InputError
            The workers cannot compute.
        """
        distributed = import_module("distributed")
        try:
            row: Row = future.result()
            return row
        except distributed.KilledWorker:
            return None
        except distributed.CancelledError:
            raise ClusterLost(_gone("the scheduler closed the connection")) from None
        except _OtherVersion as error:
            allowed = f"workers with mixed-ehl {__version__}"
            raise InputError("--dask", f"worker with mixed-ehl {error}", allowed, "Use one environment.") from None
        except ImportError as error:
            hint = f"{error}. Install mixed-ehl {__version__} where the workers run."
            raise InputError("--dask", "a worker without mixed-ehl", "workers that can import it", hint) from None

    def _wait_for_workers(self) -> None:
        """Return as soon as there is a worker.

        Raises
        ------
        ClusterLost
            There is none for `patience`, or no scheduler.
        """
        end = time.monotonic() + self.patience
        while True:
            if self.client.status != "running":
                raise ClusterLost(_gone("the scheduler is gone"))
            try:
                if self.client.nthreads():
                    return
            except (OSError, TimeoutError):
                raise ClusterLost(_gone("the scheduler does not answer")) from None
            if time.monotonic() > end:
                raise ClusterLost(_gone(f"no worker for {self.patience:.0f} s"))
            time.sleep(0.1)


def _gone(what: str) -> str:
    return (
        f"dask cluster: {what}. What is finished is on disk; start scheduler and workers, and give the command again."
    )


class _OtherVersion(Exception):
    """The worker's mixed-ehl is another version: its results would stand under the wrong key."""


def _in_dask_worker(task: Task, work: Work, version: str) -> Row:
    if version != __version__:
        raise _OtherVersion(__version__)
    one_thread()
    with dead_end(work.time_cap):
        return work(task)


@contextmanager
def dask_executor(address: str) -> Iterator[Executor]:
    """Connect to a dask cluster.

    Parameters
    ----------
    address : str
        ``tcp://host:8786``, the path of a scheduler file (``.json``), or ``local:4`` for four worker processes here.

    Raises
    ------
    InputError
        dask is not installed, the address is none, or nobody answers there.
    """
    try:
        dask, distributed = import_module("dask"), import_module("distributed")
    except ImportError:
        hint = 'Install it by pip install "mixed-ehl[dask]".'
        raise InputError("--dask", address, "nothing, unless dask is installed", hint) from None

    kind, colon, count = address.partition(":")
    if kind == "local":
        if not (colon and count.isdigit() and int(count) >= 1):
            raise InputError("--dask", address, "local:N with N worker processes, such as local:4")
        # a case that kills its worker is found by us: no need to let it kill three more
        with (
            dask.config.set({"distributed.scheduler.allowed-failures": 0, "distributed.comm.timeouts.connect": "30s"}),
            distributed.LocalCluster(
                n_workers=int(count),
                threads_per_worker=1,
                processes=True,
                dashboard_address=None,
                memory_limit=0,
                # what happens to workers is said by the sweep, once
                silence_logs=logging.CRITICAL,
            ) as cluster,
            distributed.Client(cluster) as client,
        ):
            yield DaskCluster(client)
        return
    if address.endswith(".json") and not Path(address).is_file():
        # dask would wait for it for ever
        hint = "Start `dask scheduler --scheduler-file FILE` first."
        raise InputError("--dask", address, "a scheduler file that exists", hint)
    try:
        client = (
            distributed.Client(scheduler_file=address)
            if address.endswith(".json")
            else distributed.Client(address, timeout=CONNECT)
        )
    except (OSError, TimeoutError, ValueError) as error:
        hint = f"{error}. Is `dask scheduler` running there?"
        raise InputError("--dask", address, "tcp://HOST:PORT, a scheduler file, or local:N", hint) from None
    with client:
        yield DaskCluster(client)
