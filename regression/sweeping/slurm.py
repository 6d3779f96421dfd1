"""A Slurm job array for a sweep: one shard per task, each with its own result file."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

from ehl.io.errors import InputError
from regression.plan.cost import MAX_JOBS

MAX_TASKS = 10_000
DEFAULT_JOBS = 4  # processors of a task by default

_SCRIPT = """#!/bin/bash
#SBATCH --job-name=mixed-ehl
#SBATCH --array=1-{shards}
#SBATCH --cpus-per-task={jobs}
#SBATCH --time=04:00:00

# compiled kernels are cached on the node: many processes on one shared folder slow each other down
export NUMBA_CACHE_DIR="${{TMPDIR:-/tmp}}/mixed-ehl-numba-${{SLURM_JOB_ID:-0}}"

# a task that was killed is resumed by submitting the array again
exec {command} --shard "${{SLURM_ARRAY_TASK_ID}}/{shards}"
"""


def array_script(plan: str, run: str, shards: int, options: Sequence[str] = (), jobs: int = DEFAULT_JOBS) -> str:
    """The script for `sbatch`.

    Parameters
    ----------
    plan, run : str
        As given to ``mixed-ehl sweep``.
    shards : int
        Tasks of the array.
    options : sequence of str
        Further arguments of the command, as ``["--set", "lubricant.oil=fva3"]``.
    jobs : int
        Processors of a task: its workers follow SLURM_CPUS_PER_TASK.

    Raises
    ------
    InputError
        Fewer than one task, or processor, or more than a cluster gives.
    """
    for name, value, most in (("jobs", jobs, MAX_JOBS), ("tasks", shards, MAX_TASKS)):
        if not 1 <= value <= most:
            raise InputError(name, value, f"at least 1, at most {most}")
    command = shlex.join(["mixed-ehl", "sweep", plan, *options, "-o", run])
    return _SCRIPT.format(shards=shards, jobs=jobs, command=command)
