"""Tasks on a dask cluster: `client.map` distributes them, `as_completed` returns rows, only the parent writes.

joblib's dask backend is not used: it ignores n_jobs and hung when a task kept killing its worker.
"""

import logging
import os
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib import import_module
from itertools import islice
from typing import Any

from ehl.common.errors import InputError, MixedEhlError
from ehl.common.runner import MAX_CRASHES, Executor, Numbered, WorkersCrashed, cpu_limit
from ehl.common.threads import keep_one_thread
from ehl.common.version import __version__

# cases per thread of a worker: one running, one waiting
_CASES_PER_THREAD = 2
CONNECT = 10  # longest time for a connection [s]
_CHECK_EVERY = 5.0  # interval of the checks of a silent cluster [s]


class ClusterLost(MixedEhlError):
    """The scheduler or all workers of a cluster are gone."""


@dataclass(frozen=True)
class DaskCluster:
    """Workers of a dask cluster."""

    client: Any  # connected
    worker_timeout: float = 60.0  # longest time without any worker [s]

    def __call__(
        self, tasks: Iterator[Numbered], function: Callable[[Any], Any], time_cap: float | None
    ) -> Iterator[Numbered]:
        """See `ehl.common.runner.Executor`."""
        distributed = import_module("distributed")
        self._wait_for_workers()
        run = uuid.uuid4().hex[:8]
        futures: set[Any] = set()
        crashes = 0
        crashed = False

        def distribute(count: int) -> list[Any]:
            batch = list(islice(tasks, count))
            keys = [f"mixed-ehl-{run}-{number}" for number, _ in batch]
            shared = {"function": function, "time_cap": time_cap, "version": __version__}
            new = self.client.map(_in_dask_worker, batch, key=keys, pure=False, **shared)
            futures.update(new)
            return list(new)

        try:
            distribute(self._width())
            while futures:
                finished = distributed.as_completed(list(futures), timeout=_CHECK_EVERY)
                try:
                    for future in finished:
                        futures.remove(future)
                        result = self._result(future)
                        if result is None:
                            crashed = True
                            crashes += 1
                            if crashes >= MAX_CRASHES:
                                raise WorkersCrashed
                        else:
                            crashes = 0
                            yield result
                        for new in distribute(max(1, self._width() - len(futures))):
                            finished.add(new)
                except TimeoutError:
                    self._wait_for_workers()
            if crashed:
                raise WorkersCrashed
        except (OSError, distributed.CancelledError):  # raised by any call after the scheduler was killed
            raise _cluster_lost("the scheduler closed the connection") from None
        finally:
            if futures and self.client.status == "running":
                with suppress(OSError):
                    self.client.cancel(list(futures), force=True)

    def _width(self) -> int:
        return _CASES_PER_THREAD * max(1, sum(int(n) for n in self.client.nthreads().values()))

    def _result(self, future: Any) -> Numbered | None:
        """Number and row of a finished future; None where its worker crashed.

        Raises `InputError`: the workers cannot compute.
        """
        distributed = import_module("distributed")
        try:
            result: Numbered = future.result()
            return result
        except distributed.KilledWorker:
            return None
        except _OtherVersion as error:
            allowed = f"workers with mixed-ehl {__version__}"
            raise InputError("dask", f"worker with mixed-ehl {error}", allowed, "Use one environment.") from None
        except ImportError as error:
            hint = f"{error}. Install mixed-ehl {__version__} in the environment of the workers."
            raise InputError("dask", "a worker without mixed-ehl", "workers that can import it", hint) from None

    def _wait_for_workers(self) -> None:
        """Return as soon as there is a worker.

        Raises `ClusterLost`: there is no worker for `worker_timeout`, or no scheduler.
        """
        end = time.monotonic() + self.worker_timeout
        while True:
            if self.client.status != "running":
                raise _cluster_lost("the scheduler is gone")
            try:
                if self.client.nthreads():
                    return
            except (OSError, TimeoutError):
                raise _cluster_lost("the scheduler does not answer") from None
            if time.monotonic() > end:
                raise _cluster_lost(f"no worker for {self.worker_timeout:.0f} s")
            time.sleep(0.1)


def _cluster_lost(cause: str) -> ClusterLost:
    return ClusterLost(
        f"dask cluster: {cause}. Finished cases are on disk; start scheduler and workers, then repeat the command."
    )


class _OtherVersion(Exception):
    """The worker has another version of mixed-ehl, so that its results would be stored under the wrong key."""


def _in_dask_worker(task: Numbered, function: Callable[[Any], Any], time_cap: float | None, version: str) -> Numbered:
    if version != __version__:
        raise _OtherVersion(__version__)
    keep_one_thread()
    with cpu_limit(time_cap):
        return task[0], function(task[1])


@contextmanager
def dask_executor(address: str) -> Iterator[Executor]:
    """Connect to a dask cluster.

    address: ``tcp://host:8786``, the path of a scheduler file (``.json``), or ``local:4`` for four local processes.
    Raises `InputError`: dask is not installed, the address is not valid, or no scheduler answers there.
    """
    try:
        dask, distributed = import_module("dask"), import_module("distributed")
    except ImportError:
        hint = 'Install it by pip install "mixed-ehl[dask]".'
        raise InputError("dask", address, "no value unless dask is installed", hint) from None

    kind, colon, count = address.partition(":")
    if kind == "local":
        if not (colon and count.isdecimal() and int(count) >= 1):
            raise InputError("dask", address, "local:N with N worker processes, such as local:4")
        # no repetition by dask, because the sweep itself finds the case that crashes its worker
        with (
            dask.config.set({"distributed.scheduler.allowed-failures": 0, "distributed.comm.timeouts.connect": "30s"}),
            distributed.LocalCluster(
                n_workers=int(count),
                threads_per_worker=1,
                processes=True,
                # a separate status page for each cluster, accessible from this machine only
                dashboard_address="127.0.0.1:0",
                memory_limit=0,
                # the sweep reports crashes itself
                silence_logs=logging.CRITICAL,
            ) as cluster,
            distributed.Client(cluster) as client,
        ):
            yield DaskCluster(client)
        return
    if address.endswith(".json") and not os.path.isfile(address):
        # dask would wait for the file without limit
        hint = "Start `dask scheduler --scheduler-file FILE` first."
        raise InputError("dask", address, "a scheduler file that exists", hint)
    try:
        client = (
            distributed.Client(scheduler_file=address)
            if address.endswith(".json")
            else distributed.Client(address, timeout=CONNECT)
        )
    except (OSError, TimeoutError, ValueError) as error:
        hint = f"{error}. Is `dask scheduler` running there?"
        raise InputError("dask", address, "tcp://HOST:PORT, a scheduler file, or local:N", hint) from None
    with client:
        yield DaskCluster(client)
