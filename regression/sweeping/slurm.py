"""Slurm jobs of a sweep: a job that compiles, an array of shards, and a job that merges and fits."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path

from ehl.common.errors import InputError, check_count
from ehl.common.runner import MAX_JOBS
from regression.plan.plan import Plan
from regression.sweeping.run import check_options

MAX_TASKS = 10_000
DEFAULT_JOBS = 4  # processors of a task by default
DEFAULT_TIME = "04:00:00"
# options of sbatch that the script sets
_OWN = ("array", "cpus-per-task", "dependency", "parsable", "wrap")

# the first job compiles once for all tasks, which load the kernels from the cache folder of the user; the last job runs
# in any case, since a task with a failed case ends with exit code 1
_SCRIPT = """#!/bin/bash
# Run this on the login node: bash FILE. It submits all jobs. A second run computes the missing cases.
set -euo pipefail

{% if warmup %}
kernels=$(sbatch --parsable <<'EOF'
#!/bin/bash
#SBATCH --cpus-per-task=1
{{ options }}
exec {{ warmup }}
EOF
)
{% endif %}
array=$(sbatch --parsable{{ ' --dependency="afterany:${kernels%%;*}"' if warmup }} <<'EOF'
#!/bin/bash
#SBATCH --array=1-{{ shards }}
#SBATCH --cpus-per-task={{ jobs }}
{{ options }}
# memory and time are per task; a task that was killed is resumed when the script is run again
exec {{ sweep }} --shard "${SLURM_ARRAY_TASK_ID}/{{ shards }}"
EOF
)
echo "array ${array%%;*}: {{ shards }} tasks"
{% if last %}

behind=$(sbatch --parsable --dependency="afterany:${array%%;*}" <<'EOF'
#!/bin/bash
#SBATCH --cpus-per-task=1
{{ options }}
set -e
{{ last.values() | join("\n") }}
EOF
)
echo "then ${behind%%;*}: {{ last | join(" and ") }}"
{% endif %}
"""


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
        Processors of a task, by default 4; the number of its workers is SLURM_CPUS_PER_TASK.
    changes : sequence of str
        Entries that replace those of the plan, such as ``lubricant.oil=fva3``.
    formula : str, optional
        Compute with this published formula instead of the solver.
    time_cap : float or str
        Wall time after which a case is stopped [s].
    retries, retry_failed : int, bool
        As in `sweep`.
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
    from jinja2 import Template

    Plan.from_file(plan, changes)
    cap = time_cap if isinstance(time_cap, str) else f"{time_cap:g} s"
    check_options(formula, cap, retries)
    jobs = DEFAULT_JOBS if jobs is None else jobs
    for name, value, most in (("jobs", jobs, MAX_JOBS), ("tasks", tasks, MAX_TASKS)):
        check_count(name, value, 1, most)
    program = ["mixed-ehl"] if container is None else ["apptainer", "exec", container, "mixed-ehl"]
    options = [part for change in changes for part in ("--set", change)] + (["--with", formula] if formula else [])
    options += ["--time-cap", cap, "--retries", str(retries), *(["--retry-failed"] if retry_failed else [])]
    given = {"job-name": "mixed-ehl", "time": DEFAULT_TIME} | _checked(sbatch or {})
    last = {}
    if merge is not None:
        last["merge"] = _line([*program, "sweep", "merge", str(folder), "-o", str(merge), "--complete"])
    if fit is not None:
        last["fit"] = _line([*program, "fit", str(folder if merge is None else merge), "-o", str(fit)])
    script: str = Template(_SCRIPT, trim_blocks=True, keep_trailing_newline=True).render(
        shards=tasks,
        jobs=jobs,
        options="\n".join(f"#SBATCH --{name}={value}" for name, value in given.items()),
        warmup="" if formula else _line([*program, "warmup", "rough"]),
        sweep=_line([*program, "sweep", str(plan), *options, "-o", str(folder)]),
        last=last,
    )
    return script


def _line(words: Sequence[str]) -> str:
    """A command as one line of a script; a line break could end the text for `sbatch`, and the rest would be run."""
    for word in words:
        if not word.isprintable():
            raise InputError("slurm", word, "paths and options without line breaks and control characters")
    return shlex.join(words)


def _checked(sbatch: Mapping[str, str]) -> dict[str, str]:
    for name, value in sbatch.items():
        if not re.fullmatch(r"[a-z][a-z-]*", name) or name in _OWN:
            allowed = "a long option of sbatch such as partition=short"
            raise InputError("sbatch", name, f"{allowed}; not {', '.join(_OWN)}, which the script sets")
        # values in the head of a script are not quoted
        if not re.fullmatch(r"[\w.,:;=@%+/\[\]-]+", value):
            raise InputError("sbatch", f"{name}={value}", "a value without blanks or quotes")
    return dict(sbatch)
