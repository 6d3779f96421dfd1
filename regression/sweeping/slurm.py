"""Slurm jobs for a sweep: one compiles, an array of shards writes a result file each, one merges and fits."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence

from ehl.common.errors import InputError
from ehl.common.runner import MAX_JOBS

MAX_TASKS = 10_000
DEFAULT_JOBS = 4  # processors of a task by default
DEFAULT_TIME = "04:00:00"
# what the script itself gives to sbatch
_OWN = ("array", "cpus-per-task", "dependency", "parsable", "wrap")

_SCRIPT = """#!/bin/bash
# Run this on the login node: bash FILE. It submits everything; run again, it computes what is missing.
set -euo pipefail

{before}array=$(sbatch --parsable{after} <<'EOF'
#!/bin/bash
#SBATCH --array=1-{shards}
#SBATCH --cpus-per-task={jobs}
{options}
# the memory and time of a task are its own: one that was killed is resumed by submitting again
exec {sweep} --shard "${{SLURM_ARRAY_TASK_ID}}/{shards}"
EOF
)
echo "array ${{array%%;*}}: {shards} tasks"
"""
# kernels once for all tasks, which load them from the cache folder of the user
_BEFORE = """kernels=$(sbatch --parsable <<'EOF'
#!/bin/bash
#SBATCH --cpus-per-task=1
{options}
exec {warmup}
EOF
)
"""
_AFTER = ' --dependency="afterany:${kernels%%;*}"'
# after the array however it ended: a case without an answer is a row with its reason, and makes its task end with 1
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
    """The script that submits a sweep, to be run by ``bash``.

    plan, run: as given to ``mixed-ehl sweep``.
    shards: tasks of the array.
    options: further arguments of the command, as ``["--set", "lubricant.oil=fva3"]``.
    jobs: processors of a task: its workers follow SLURM_CPUS_PER_TASK.
    sbatch: options of ``sbatch`` for all jobs, by their long names: ``partition``, ``account``, ``mem``, ``time``...
    container: image in which ``apptainer`` runs the program.
    merge, fit: one file of all results, and the formula fitted to them: made by a job that waits for the array.
    kernels: compile the kernels of contacts in a job of their own that the array waits for.
    Raises `InputError`: fewer than one task, or processor, or more than a cluster gives; an option sbatch does not take
    so.
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
            allowed = "a long option of sbatch, as partition=short"
            raise InputError("sbatch", name, f"{allowed}; not {', '.join(_OWN)}, which the script gives itself")
        # the head of a script is no shell: a value with a blank would end there
        if not re.fullmatch(r"[\w.,:;=@%+/\[\]-]+", value):
            raise InputError(f"sbatch {name}", value, "a value without blanks or quotes")
    return dict(sbatch)
