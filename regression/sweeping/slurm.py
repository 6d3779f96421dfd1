"""Slurm jobs of a sweep: a job that compiles, an array of shards, and a job that merges and fits."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence

from ehl.common.errors import InputError, check_count
from ehl.common.runner import MAX_JOBS

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
        check_count(name, value, 1, most)
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
