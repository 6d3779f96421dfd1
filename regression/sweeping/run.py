"""Runs: the results of a sweep in a folder, and the functions that compute them.

Slurm jobs of a sweep: a job that compiles, an array of shards, and a job that merges and fits.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property, partial
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ehl import SOLVER
from ehl.common.errors import InputError
from ehl.common.progress import ProgressCallback
from ehl.common.runner import MAX_JOBS, checked_jobs, cluster
from ehl.common.threads import one_thread
from ehl.common.units import ValueRange
from ehl.warmup import prepare_workers
from regression.data.dataset import Dataset, RunStatus, load_dataset, results_path, run_status
from regression.data.result_files import merge, read_meta
from regression.friction.published_registry import PUBLISHED
from regression.plan.plan import Plan
from regression.sweeping.evaluators import published_outputs, solve_outputs
from regression.sweeping.rerun import SHARE, Rerun, rerun
from regression.sweeping.sweep import SweepReport, sweep_shard

if TYPE_CHECKING:
    import pandas as pd

MAX_TASKS = 10_000
DEFAULT_JOBS = 4  # processors of a task by default
DEFAULT_TIME = "04:00:00"
# options of sbatch that the script sets
_OWN = ("array", "cpus-per-task", "dependency", "parsable", "wrap")

_SCRIPT = """#!/bin/bash
# Run this on the login node: bash FILE. It submits all jobs. A second run computes the missing cases.
set -euo pipefail

{before}array=$(sbatch --parsable{after} <<'EOF'
#!/bin/bash
#SBATCH --array=1-{shards}
#SBATCH --cpus-per-task={jobs}
{options}
# memory and time are per task; a task that was killed is resumed when the script is run again
exec {sweep} --shard "${{SLURM_ARRAY_TASK_ID}}/{shards}"
EOF
)
echo "array ${{array%%;*}}: {shards} tasks"
"""
# compiles once for all tasks, which load the kernels from the cache folder of the user
_BEFORE = """kernels=$(sbatch --parsable <<'EOF'
#!/bin/bash
#SBATCH --cpus-per-task=1
{options}
exec {warmup}
EOF
)
"""
_AFTER = ' --dependency="afterany:${kernels%%;*}"'
# runs in any case, since a task with a failed case ends with exit code 1
_BEHIND = """
behind=$(sbatch --parsable --dependency="afterany:${{array%%;*}}" <<'EOF'
#!/bin/bash
#SBATCH --cpus-per-task=1
{options}
set -e
{commands}
EOF
)
echo "then ${{behind%%;*}}: {what}"
"""


def job_script(
    plan: str,
    run: str,
    shards: int,
    options: Sequence[str] = (),
    jobs: int = DEFAULT_JOBS,
    *,
    sbatch: Mapping[str, str] | None = None,
    container: str | None = None,
    merge: str | None = None,
    fit: str | None = None,
    kernels: bool = True,
) -> str:
    """The script that submits a sweep, to be run with ``bash``.

    plan, run: arguments of ``mixed-ehl sweep``.
    shards: tasks of the array.
    options: further arguments of the command, such as ``["--set", "lubricant.oil=fva3"]``.
    jobs: processors of a task; the number of its workers is SLURM_CPUS_PER_TASK.
    sbatch: options of ``sbatch`` for all jobs by their long names: ``partition``, ``account``, ``mem``, ``time``...
    container: image in which ``apptainer`` runs the program.
    merge, fit: file of all results, and file of the formula fitted to them, written by a job after the array.
    kernels: compile the kernels of contacts in a job before the array.
    Raises `InputError`: the number of tasks or processors is out of range, or an option of sbatch is invalid.
    """
    for name, value, most in (("jobs", jobs, MAX_JOBS), ("tasks", shards, MAX_TASKS)):
        if not 1 <= value <= most:
            raise InputError(name, value, f"at least 1, at most {most}")
    program = ["mixed-ehl"] if container is None else ["apptainer", "exec", container, "mixed-ehl"]
    given = {"job-name": "mixed-ehl", "time": DEFAULT_TIME} | _checked(sbatch or {})
    directives = "\n".join(f"#SBATCH --{name}={value}" for name, value in given.items())
    script = _SCRIPT.format(
        shards=shards,
        jobs=jobs,
        options=directives,
        before=_BEFORE.format(options=directives, warmup=shlex.join([*program, "warmup", "rough"])) if kernels else "",
        after=_AFTER if kernels else "",
        sweep=shlex.join([*program, "sweep", plan, *options, "-o", run]),
    )
    behind = []
    if merge is not None:
        behind.append([*program, "sweep", "merge", run, "-o", merge, "--complete"])
    if fit is not None:
        behind.append([*program, "fit", run if merge is None else merge, "-o", fit])
    if behind:
        what = " and ".join(name for name, target in (("merge", merge), ("fit", fit)) if target is not None)
        commands = "\n".join(shlex.join(command) for command in behind)
        script += _BEHIND.format(options=directives, commands=commands, what=what)
    return script


def _checked(sbatch: Mapping[str, str]) -> dict[str, str]:
    for name, value in sbatch.items():
        if not re.fullmatch(r"[a-z][a-z-]*", name) or name in _OWN:
            allowed = "a long option of sbatch such as partition=short"
            raise InputError("sbatch", name, f"{allowed}; not {', '.join(_OWN)}, which the script sets")
        # values in the head of a script are not quoted
        if not re.fullmatch(r"[\w.,:;=@%+/\[\]-]+", value):
            raise InputError(f"sbatch {name}", value, "a value without blanks or quotes")
    return dict(sbatch)


_SECONDS = ValueRange("s", gt=0.0)


class Run(PathLike[str]):
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
        """All results as a dataset.

        Returns
        -------
        Dataset
        """
        return load_dataset(self.path)

    def to_frame(self, *, units: bool = False) -> pd.DataFrame:
        """All results as a data frame.

        Parameters
        ----------
        units : bool
            Name the columns with their SI units, as ``pressure_hertz [Pa]``.

        Returns
        -------
        DataFrame
            One row per case, sorted by key.
        """
        return self.dataset().to_frame(units=units)

    def to_dict(self) -> dict[str, Any]:
        """The status of the run.

        Returns
        -------
        dict
            For JSON.
        """
        return self.status.to_dict()

    def retry(self, **options: Any) -> Run:
        """Compute the failed cases again, with settings that were not tried yet.

        Parameters
        ----------
        **options
            Options of `sweep`; the default formula is that of the run.

        Returns
        -------
        Run
        """
        computed_by = str(read_meta(self.path)["solver_version"])
        if computed_by in PUBLISHED:
            options.setdefault("formula", computed_by)
        return sweep(self.plan, self.path, retry_failed=True, **options)

    def rerun(self, plan: Plan | None = None, *, share: float = SHARE, seed: int = 1) -> Iterator[Rerun]:
        """Compute a random share of the cases again, to compare the present solver with the results.

        Parameters
        ----------
        plan : Plan, optional
            Replaces the stored plan.
        share : float
            Share of the cases of the plan.
        seed : int
            Seed of the random choice.

        Yields
        ------
        Rerun
            Stored and computed friction of one case.
        """
        return rerun(self.dataset(), plan or self.plan, share=share, seed=seed)

    def merge(self, target: str | Path, *, compress: bool = False, complete: bool = False) -> int:
        """Write all results into one file, sorted by case key.

        Parameters
        ----------
        target : str or Path
            A result file (``.h5``), or a table (``.csv``).
        compress : bool
            Compress the result file, like the shipped datasets.
        complete : bool
            Refuse a run with missing cases.

        Returns
        -------
        int
            Number of cases.

        Raises
        ------
        InputError
            The target exists or cannot be written, or the results are of different runs.
        """
        target = Path(target)
        if complete and not (status := self.status).complete:
            missing = status.planned - status.finished
            hint = f"{missing} of {status.planned} are missing."
            raise InputError("run", str(self.path), "a run with all its cases", hint)
        if target.suffix == ".csv":
            dataset = self.dataset()
            dataset.save(target)
            return len(dataset)
        return merge(self.path, target, compress=compress)

    def to_text(self) -> str:
        """Report of the last call of `sweep`.

        Returns
        -------
        str
        """
        return "\n".join(report.to_text() for report in self.reports)

    def __repr__(self) -> str:
        status = self.status
        failed = f", {len(status.failed)} failed" if status.failed else ""
        return f"Run {self.path}: {status.plan_name!r}, {status.finished} of {status.planned} cases{failed}"

    def _repr_html_(self) -> str:
        return self.status.table().html()


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
        The folder holds another run or cannot be written, or an option is invalid.
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
    _check_formula(formula)
    part = _shard(shard)
    with cluster(dask) as executor:
        options: dict[str, Any] = {
            "evaluate": partial(published_outputs, name=formula) if formula else solve_outputs,
            "version": formula or SOLVER,
            "jobs": checked_jobs(jobs),
            "executor": executor,
            "time_cap": None if time_cap is None else _time_cap(time_cap),
            "retries": retries,
            "retry_failed": retry_failed,
            "progress": progress,
        }
        if formula is None and executor is None and options["jobs"] > 1:
            prepare_workers(rough=True)
        target = Path(folder)
        return Run(target, (sweep_shard(content, target, part, **options),))


def slurm_script(
    plan: str | Path,
    folder: str | PathLike[str],
    tasks: int,
    *,
    jobs: int | None = None,
    changes: Sequence[str] = (),
    formula: str | None = None,
    time_cap: float | str = 600.0,
    retries: int = 1,
    retry_failed: bool = False,
    sbatch: Mapping[str, str] | None = None,
    container: str | None = None,
    merge: str | Path | None = None,
    fit: str | Path | None = None,
) -> str:
    """Script that submits a sweep to Slurm: a job that compiles, an array of shards, and a job that merges and fits.

    Parameters
    ----------
    plan : str or Path
        The path of a plan file, or the name of a shipped plan.
    folder : str or path
        Folder of the results.
    tasks : int
        Tasks of the array, each with its own shard and result file.
    jobs : int, optional
        Processors of a task; 4 by default.
    changes : sequence of str
        Entries that replace those of the plan, such as ``lubricant.oil=fva3``.
    formula : str, optional
        Compute with this published formula instead of the solver.
    time_cap : float or str
        Wall time after which a case is stopped [s].
    retries : int
        Number of fallback settings that are tried if the solver fails.
    retry_failed : bool
        Compute the failed cases on disk again.
    sbatch : mapping of str
        Options of ``sbatch`` for all jobs by their long names, such as ``{"partition": "short", "mem": "8G"}``.
    container : str, optional
        Image in which ``apptainer`` runs the program.
    merge : str or Path, optional
        Merge all shards into this file when the array has ended.
    fit : str or Path, optional
        File of a formula that is fitted to all results.

    Returns
    -------
    str
        The script, to be run with ``bash`` on a computer with ``sbatch``.

    Raises
    ------
    InputError
        The plan or an option is invalid.

    Examples
    --------
    >>> from regression import slurm_script
    >>> script = slurm_script("demo", "run", tasks=8, sbatch={"partition": "short"}, merge="all.h5")
    >>> print("\\n".join(line for line in script.splitlines() if "mixed-ehl sweep" in line))
    exec mixed-ehl sweep demo --time-cap '600 s' --retries 1 -o run --shard "${SLURM_ARRAY_TASK_ID}/8"
    mixed-ehl sweep merge run -o all.h5 --complete
    """
    Plan.from_file(plan, changes)
    _check_formula(formula)
    options = [part for change in changes for part in ("--set", change)]
    options += ["--with", formula] if formula else []
    cap = time_cap if isinstance(time_cap, str) else f"{time_cap:g} s"
    _time_cap(cap)
    options += ["--time-cap", cap, "--retries", str(retries), *(["--retry-failed"] if retry_failed else [])]
    merged, fitted = (None if path is None else str(path) for path in (merge, fit))
    return job_script(
        str(plan), str(folder), tasks, options, DEFAULT_JOBS if jobs is None else jobs, sbatch=sbatch,
        container=container, merge=merged, fit=fitted, kernels=formula is None,
    )  # fmt: skip


def _check_formula(formula: str | None) -> None:
    if formula is not None and formula not in PUBLISHED:
        raise InputError("formula", formula, "one of " + ", ".join(sorted(PUBLISHED)))


def _shard(value: tuple[int, int] | str) -> tuple[int, int]:
    number, _, shards = value.partition("/") if isinstance(value, str) else (str(value[0]), "/", str(value[1]))
    if not (number.isdigit() and shards.isdigit()):
        raise InputError("shard", value, "i/n with 1 <= i <= n", "An example is 2/8.")
    return int(number), int(shards)


def _time_cap(value: float | str) -> float:
    """Seconds; a text must have a unit."""
    return _SECONDS.check(value, "time_cap", bare=not isinstance(value, str))
