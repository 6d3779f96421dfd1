"""Runs: the results of a sweep in a folder, and the function that computes them."""

from __future__ import annotations

from functools import cached_property, partial
from os import PathLike
from pathlib import Path
from typing import Any

import pandas as pd

from ehl import SOLVER
from ehl.common.errors import InputError, check_count
from ehl.common.pages import TableResult
from ehl.common.progress import ProgressCallback, counted
from ehl.common.runner import checked_jobs, cluster
from ehl.common.sections import Medium, Section
from ehl.common.threads import one_thread
from ehl.warmup import prepare_workers
from regression.data.dataset import Dataset, RunStatus, load_dataset, results_path, run_status
from regression.data.result_files import merge, read_meta
from regression.friction.published_registry import PUBLISHED
from regression.plan.cost import ALLOWED_TIME_CAP
from regression.plan.plan import Plan
from regression.sweeping.evaluators import published_outputs, solve_outputs
from regression.sweeping.sweep import SweepReport, sweep_shard

MAX_RETRIES = 100  # far more than there are fallback settings


class Run(PathLike[str], TableResult):
    """The results of a sweep.

    Parameters
    ----------
    source : str or path
        Folder or file of results, or the name of a shipped dataset.
    reports : tuple of SweepReport
        Reports of the call of `sweep`; empty for results that are opened only.

    Raises
    ------
    InputError
        There are no results of that name.

    Examples
    --------
    >>> from regression import Run
    >>> run = Run("gear_fva3")
    >>> run.status.complete
    True
    >>> len(run.dataset()) == len(run.to_frame())
    True
    """

    def __init__(self, source: str | PathLike[str], reports: tuple[SweepReport, ...] = ()) -> None:
        self.path = results_path(source)
        self.reports = reports

    def __fspath__(self) -> str:
        return str(self.path)

    @cached_property
    def plan(self) -> Plan:
        """The plan of the run, as stored with the results."""
        return Plan.from_json(str(read_meta(self.path)["plan"]))

    @property
    def status(self) -> RunStatus:
        """Progress of the run, read from disk; also while another process computes it."""
        return run_status(self.path)

    @property
    def unanswered(self) -> int:
        """Number of cases without a result in the last call of `sweep`, whether computed then or found on disk."""
        return sum(report.unanswered for report in self.reports)

    def dataset(self) -> Dataset:
        """All results as a dataset."""
        return load_dataset(self.path)

    def to_frame(self, *, units: bool = False) -> pd.DataFrame:
        """All results, as `Dataset.to_frame`."""
        return self.dataset().to_frame(units=units)

    def to_dict(self) -> dict[str, Any]:
        """The status of the run, for JSON."""
        return self.status.to_dict()

    def retry(self, **options: Any) -> Run:
        """Compute the failed cases again with new settings; options of `sweep`, by default the formula of the run."""
        computed_by = str(read_meta(self.path)["solver_version"])
        if computed_by in PUBLISHED:
            options.setdefault("formula", computed_by)
        return sweep(self.plan, self.path, retry_failed=True, **options)

    def merge(self, target: str | Path, *, compress: bool = False, complete: bool = False) -> int:
        """Write all results into one file, sorted by case key; returns the number of cases.

        Parameters
        ----------
        target : str or Path
            A result file (``.h5``), or a table (``.csv``).
        compress : bool
            Compress the result file, like the shipped datasets.
        complete : bool
            Raise an `InputError` for a run with missing cases.

        Raises
        ------
        InputError
            The target exists, has another suffix or cannot be written, or the results are of different runs.
        """
        target = Path(target)
        kind = target.suffix.lower()
        if kind not in (".h5", ".csv"):
            raise InputError("target", str(target), "a file name ending in .h5 or .csv")
        if complete and not (status := self.status).complete:
            missing = status.planned - status.finished
            hint = f"{missing} of {status.planned} are missing."
            raise InputError("run", str(self.path), "a run with all its cases", hint)
        if kind == ".csv":
            dataset = self.dataset()
            dataset.save(target)
            return len(dataset)
        return merge(self.path, target, compress=compress)

    def sections(self, medium: Medium = "page", *args: Any, **options: Any) -> list[Section]:
        """Result files and failed cases."""
        return self.status.sections(medium)

    def __repr__(self) -> str:
        status = self.status
        failed = f", {len(status.failed)} failed" if status.failed else ""
        return f"Run {self.path}: {status.plan_name!r}, {status.finished} of {counted(status.planned, 'case')}{failed}"


@one_thread
def sweep(
    plan: Plan | str | Path,
    folder: str | PathLike[str],
    *,
    jobs: int | None = None,
    shard: tuple[int, int] | str = (1, 1),
    dask: Any = None,
    formula: str | None = None,
    time_cap: float | str | None = 600.0,
    retries: int = 1,
    retry_failed: bool = False,
    progress: ProgressCallback | None = None,
) -> Run:
    """Compute the cases of a plan that are not on disk yet; the same call resumes an interrupted sweep.

    Parameters
    ----------
    plan : Plan, str or Path
        A plan, the path of a plan file, or the name of a shipped plan.
    folder : str or path
        Folder of the results; created if it does not exist.
    jobs : int, optional
        Worker processes of one thread each; all processors by default, 1 computes in this process.
    shard : tuple of int, or str
        (i, n) or ``"i/n"``: every n-th case, beginning with the i-th, for n simultaneous sweeps of one plan.
    dask : str or distributed.Client, optional
        Compute on a dask cluster: the address of its scheduler, a scheduler file, ``local:N``, or a connected client.
        The sweep waits up to an hour for the workers.
    formula : str, optional
        Compute with this published formula instead of the solver, to try a plan in seconds.
    time_cap : float or str, optional
        Wall time after which a case is stopped [s]; None for no limit.
    retries : int
        Number of fallback settings that are tried if the solver fails.
    retry_failed : bool
        Compute the failed cases on disk again.
    progress : callable, optional
        Called with a `Progress` after each case; ``print`` writes one line per call.

    Returns
    -------
    Run

    Raises
    ------
    InputError
        The folder contains another run or cannot be written, or an option is invalid.
    AllWorkersCrashed, ClusterLost
        There are no workers left; every finished case is on disk.
    KeyboardInterrupt
        Ctrl-C or SIGTERM; every finished case is on disk.

    Examples
    --------
    >>> import tempfile
    >>> from regression import sweep
    >>> folder = tempfile.mkdtemp()
    >>> run = sweep("demo", folder, formula="xu_kahraman_2007", jobs=1)
    >>> run.status.finished
    48
    >>> bool(run.to_frame()["friction_coefficient"].max() < 0.2)
    True
    """
    content = plan if isinstance(plan, Plan) else Plan.from_file(plan)
    check_options(formula, time_cap, retries)
    part = _shard(shard)
    workers = checked_jobs(jobs)
    with cluster(dask) as executor:
        if formula is None and executor is None and workers > 1:
            prepare_workers(rough=True)
        report = sweep_shard(
            content,
            Path(folder),
            part,
            evaluate=partial(published_outputs, name=formula) if formula else solve_outputs,
            version=formula or SOLVER,
            jobs=workers,
            executor=executor,
            time_cap=None if time_cap is None else ALLOWED_TIME_CAP.check_given(time_cap, "time_cap"),
            retries=retries,
            retry_failed=retry_failed,
            progress=progress,
        )
        return Run(folder, (report,))


def check_options(formula: str | None, time_cap: float | str | None, retries: int) -> None:
    """Raise an `InputError` for options of `sweep` outside their range."""
    if formula is not None and formula not in PUBLISHED:
        raise InputError("formula", formula, "one of " + ", ".join(sorted(PUBLISHED)))
    check_count("retries", retries, 0, MAX_RETRIES)
    if time_cap is not None:
        ALLOWED_TIME_CAP.check_given(time_cap, "time_cap")


def _shard(value: tuple[int, int] | str) -> tuple[int, int]:
    """Number of a shard and of all shards."""
    number, _, shards = value.partition("/") if isinstance(value, str) else (str(value[0]), "/", str(value[1]))
    if not (number.isdecimal() and shards.isdecimal() and 1 <= int(number) <= int(shards)):
        raise InputError("shard", value, "i/n with 1 <= i <= n", "An example is 2/8.")
    return int(number), int(shards)
