"""A Slurm job array for a sweep: one shard per task, each with its own result file."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

from ehl.errors import InputError

_SCRIPT = """#!/bin/bash
#SBATCH --job-name=mixed-ehl
#SBATCH --array=1-{shards}
#SBATCH --cpus-per-task=4
#SBATCH --time=04:00:00

# compiled kernels are cached on the node: many processes on one shared folder slow each other down
export NUMBA_CACHE_DIR="${{TMPDIR:-/tmp}}/mixed-ehl-numba-${{SLURM_JOB_ID:-0}}"

# a task that was killed is resumed by submitting the array again
exec mixed-ehl sweep {plan} -o {run} --shard "${{SLURM_ARRAY_TASK_ID}}/{shards}"
"""


def array_script(plan: str, run: str, shards: int, changes: Sequence[str] = ()) -> str:
    """The script for `sbatch`; the number of workers follows SLURM_CPUS_PER_TASK. `changes` are those of ``--set``.

    Raises
    ------
    InputError
        Fewer than one shard.
    """
    if shards < 1:
        raise InputError("--slurm", shards, "at least 1 task")
    options = "".join(f" --set {shlex.quote(change)}" for change in changes)
    return _SCRIPT.format(shards=shards, plan=shlex.quote(plan) + options, run=shlex.quote(run))
