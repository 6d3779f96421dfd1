"""The sweep: plan -> cases, the longest first -> (workers solve, the parent writes) -> result file of this shard.

A case that fails is tried again with a safer setting, and is a row with its reason if that fails too; a worker that
dies costs one restart; a process that dies is resumed by the same command.
"""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ehl.contact import Contact
from ehl.fluid.oil import Oil
from ehl.io.errors import InputError
from regression.data.store import ResultStore, finished_keys
from regression.friction.oil_cards import card_hash, cards_hash
from regression.plan.plan import Plan
from regression.plan.sampling import Array
from regression.sweeping.cost import case_seconds
from regression.sweeping.evaluators import SOLVER, Evaluator, case_key, solve_outputs
from regression.sweeping.executors import Executor, compute, local_executor
from regression.sweeping.recorder import Progress as Progress
from regression.sweeping.recorder import Recorder, stop_requests
from regression.sweeping.retry import safer_setting
from regression.sweeping.workers import TIME_CAP, WORKER_LOST, Task, Work


@dataclass(frozen=True)
class SweepReport:
    """What one call of `sweep` did.

    Parameters
    ----------
    path : Path
        The result file of this shard.
    total : int
        Cases of this shard.
    resumed : int
        Of these, found on disk.
    converged, unsettled, failed : int
        Computed in this call; unsettled cases have a result whose interval is wider than asked for.
    reasons : dict
        Number of unsettled and failed cases by reason.
    restarts : int
        How often workers died and were replaced.
    torn : int
        Rows of an earlier process that were cut off because they were not whole.
    damaged : int
        Rows on disk that no longer match their checksum; computed again.
    saved : int or None
        Rows taken over from a file that was cut short; None where it was sound.
    safer : int
        Cases that have a result only with a safer setting than planned.
    seconds, seconds_cases, seconds_cpu : float
        Wall time; that of all cases computed here together, and their processor time.
    workers : int or None
        Worker processes of this machine; None where others computed.
    """

    path: Path
    total: int
    resumed: int
    converged: int
    unsettled: int
    failed: int
    reasons: dict[str, int]
    restarts: int
    torn: int
    damaged: int
    saved: int | None
    safer: int
    seconds: float
    seconds_cases: float
    seconds_cpu: float
    workers: int | None

    @property
    def occupancy(self) -> float | None:
        """Share of the workers' time inside cases; None where it is not known."""
        if self.workers is None or not self.seconds_cases:
            return None
        return self.seconds_cases / (self.workers * self.seconds)


@dataclass(frozen=True)
class Conduct:
    """How the cases of a sweep are computed.

    Parameters
    ----------
    evaluate : callable
        Case to results; may raise `ConvergenceError` with a reason. Picklable where workers compute.
    version : str
        Names what `evaluate` computes with; part of every case's key.
    jobs : int
        Worker processes, one thread each; 1 computes in this process.
    executor : Executor, optional
        Where to compute in place of `jobs` local processes, as of `regression.sweeping.dask_workers.dask_executor`.
    flush_every : int
        Rows put on disk together.
    flush_seconds : float
        Or earlier, once this much time has passed.
    time_cap : float or None
        Wall time after which a case is given up with the reason "time_cap" [s].
    retries : int
        Safer settings tried where the solver gives a case up.
    retry_failed : bool
        Compute the failed cases on disk again: those the solver gave up with the settings that were not tried yet,
        those that ran out of time or lost their worker as they were.
    progress : callable, optional
        Called after every case.
    """

    evaluate: Evaluator = solve_outputs
    version: str = SOLVER
    jobs: int = 1
    executor: Executor | None = None
    flush_every: int = 16
    flush_seconds: float = 1.0
    time_cap: float | None = 600.0
    retries: int = 1
    retry_failed: bool = False
    progress: Callable[[Progress], None] | None = None

    def __post_init__(self) -> None:
        for name, least in (("jobs", 1), ("retries", 0), ("flush_every", 1)):
            if getattr(self, name) < least:
                raise InputError(name, getattr(self, name), f"at least {least}")


def sweep(plan: Plan, run: Path, *, shard: tuple[int, int] = (1, 1), **conduct: Any) -> SweepReport:
    """Compute the cases of a plan that are not on disk yet.

    Parameters
    ----------
    plan : Plan
        What to compute.
    run : Path
        Folder of the results; made if there is none.
    shard : tuple of int
        (i, n): every n-th case, beginning with the i-th. One file per shard, so that shards may run at once.
    **conduct
        Fields of `Conduct`.

    Returns
    -------
    SweepReport

    Raises
    ------
    InputError
        The folder holds another run, cannot be written, or the shard is not one of n.
    WorkersDie, ClusterLost
        Nothing can be computed any more; every finished case is on disk.
    KeyboardInterrupt
        Ctrl-C or SIGTERM came; every finished case is on disk.
    """
    how = Conduct(**conduct)
    number, shards = shard
    if not 1 <= number <= shards:
        raise InputError("shard", f"{number}/{shards}", "i/n with 1 <= i <= n")
    path = shard_path(run, number, shards)
    indices = np.arange(number - 1, len(plan.points), shards)
    points = [PlannedCase(plan.points.origin[int(i)], partial(plan.case_at, int(i))) for i in indices]
    return compute_cases(path, run_meta(plan, how.version), points, case_seconds(plan)[indices], how)


@dataclass(frozen=True)
class PlannedCase:
    """A case to be computed, made when it is needed: a long plan would fill the memory."""

    origin: str
    case: Callable[[], Contact]


def compute_cases(
    path: Path, meta: Mapping[str, str | int], points: Sequence[PlannedCase], cost: Array, how: Conduct
) -> SweepReport:
    """Compute those of some cases that are not in a result file yet, the longest first.

    Parameters
    ----------
    path : Path
        The result file; made if there is none.
    meta : mapping
        As of `run_meta`.
    points : sequence of PlannedCase
        The cases.
    cost : array
        Their estimated seconds.
    how : Conduct
        How they are computed.
    """
    clock = time.perf_counter()
    # the longest first: the last cases to run are short, and no core waits long for another
    order = np.lexsort((np.arange(len(points)), -cost))
    with ResultStore(path, meta) as store, stop_requests() as stop:
        known = store.rows()
        done = {key for key, (status, _, _) in known.items() if not (how.retry_failed and status == "failed")}
        # what another division into shards has computed counts as well
        done |= finished_keys(path)
        tried = {key: _tried(*entry) for key, entry in known.items()}
        costs: dict[str, float] = {}
        waiting: list[tuple[str, PlannedCase]] = []
        for position in order:
            point = points[int(position)]
            case = point.case()
            key = case_key(case, how.version)
            if tried.get(key) and safer_setting(case, tried[key]) is None:
                # nothing is left to try: the row keeps the solver's reason
                continue
            if key not in done and key not in costs:
                costs[key] = float(cost[position])
                waiting.append((key, point))
        resumed = len(points) - len(waiting)
        recorder = Recorder(store, len(points), resumed, how.flush_every, how.flush_seconds, how.progress, stop, costs)

        def pending() -> Iterator[Task]:
            for key, point in waiting:
                if key not in recorder.recorded:
                    yield Task(key, point.origin, point.case(), tried.get(key, 0))

        try:
            recorder.show()
            executor = local_executor(how.jobs) if how.executor is None else how.executor
            work = Work(how.evaluate, how.time_cap, how.retries)
            restarts = compute(pending, work, executor, recorder.record)
        finally:
            recorder.flush()
    return SweepReport(
        path,
        len(points),
        resumed,
        recorder.counts["converged"],
        recorder.counts["unsettled"],
        recorder.counts["failed"],
        recorder.reasons,
        restarts,
        store.torn,
        store.damaged,
        store.saved,
        recorder.safer,
        time.perf_counter() - clock,
        recorder.seconds_cases,
        recorder.seconds_cpu,
        how.jobs if how.executor is None else None,
    )


def shard_path(run: Path, number: int, shards: int) -> Path:
    """The result file of a shard, its folder made if there is none.

    Raises
    ------
    InputError
        The folder cannot be made.
    """
    try:
        run.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError("run", str(run), "a folder that can be written", f"{error.strerror}.") from None
    return run / f"shard-{number:04d}-of-{shards:04d}.h5"


def _tried(status: str, reason: str, attempts: int) -> int:
    """How many settings need not be tried again for a case that is on disk."""
    return attempts if status == "failed" and reason not in (TIME_CAP, WORKER_LOST) else 0


def run_meta(plan: Plan, version: str) -> dict[str, str | int]:
    """What every file of a run carries."""
    return {
        "plan": plan.model_dump_json(),
        "plan_name": plan.name,
        "plan_hash": plan.plan_hash,
        "solver_version": version,
        "oil": ", ".join(plan.oils),
        "oil_hash": oils_hash(plan.oils),
        "bodies_hash": _bodies_hash(plan),
        "count": plan.count,
    }


def _bodies_hash(plan: Plan) -> str:
    figures = [body.body().model_dump_json(exclude={"source"}) for body in (plan.solid_1, plan.solid_2)]
    return hashlib.sha256("\n".join(figures).encode()).hexdigest()


def oil_hash(name: str) -> str:
    """Hash of the figures on an oil card."""
    return card_hash(Oil.load(name))


def oils_hash(names: tuple[str, ...]) -> str:
    """Hash of the figures on the oil cards of a plan; that of the card itself where there is one."""
    return cards_hash([oil_hash(name) for name in names])


def available_jobs() -> int:
    """Processors this process may use, or those a Slurm task was given."""
    given = os.environ.get("SLURM_CPUS_PER_TASK", "")
    if given.isdigit() and int(given) > 0:
        return int(given)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
