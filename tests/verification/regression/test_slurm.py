"""Slurm without a cluster: a stand-in for `sbatch` runs what a real one would; the data are those of a local run."""

import os
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from small_plans import GEAR_VARIABLES, PROGRAM, sweep_plan

from ehl.common.dask_workers import DaskCluster
from ehl.common.validation import validate
from regression.data.dataset import load_dataset
from regression.formula import Formula
from regression.plan.plan import Plan
from regression.sweeping.evaluators import published_outputs
from regression.sweeping.sweep import sweep_shard

# of the options of sbatch array and dependency alone count; each task sees what Slurm gives it
SBATCH = """#!/bin/bash
set -eu
here=$(dirname "$0")
echo "$@" >> "$here/calls"
dependency="" script=""
for option in "$@"; do
    case $option in
        --dependency=*) dependency=${option#--dependency=} ;;
        --*) ;;
        *) script=$option ;;
    esac
done
if [ -z "$script" ]; then
    script=$(mktemp "$here/job.XXXX")
    cat > "$script"
    # jobs run at once, so the one waited for has ended: it must have been submitted, and its tasks may have failed
    [ -z "$dependency" ] || [ -e "$here/ended-${dependency#afterany:}" ]
    last=$(sed -n 's/^#SBATCH --array=1-//p' "$script")
    id=$((4711 + $(ls "$here" | grep -c ended || true)))
    export SLURM_CPUS_PER_TASK=$(sed -n 's/^#SBATCH --cpus-per-task=//p' "$script")
    export SLURM_JOB_ID=$id
    for task in $(seq 1 "${last:-1}"); do
        SLURM_ARRAY_TASK_ID=$task bash "$script" >> "$here/log" 2>&1 || echo "task $task: $?" >> "$here/ended-$id"
    done
    touch "$here/ended-$id"
    echo "$id;cluster"
    exit 0
fi
# a job of dask: runs on after the command; as of Slurm itself from a copy, since dask removes the script at once
export SLURM_CPUS_PER_TASK=1 SLURM_JOB_ID=4711
copy=$(mktemp "$here/dask.XXXX")
cp "$script" "$copy"
nohup bash "$copy" > "$copy.log" 2>&1 &
echo "Submitted batch job $!"
"""
SCANCEL = '#!/bin/bash\nkill "$@" 2> /dev/null\n'


@pytest.fixture
def slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with `sbatch`, `scancel` and `mixed-ehl`, first in the path of commands."""
    commands = tmp_path / "commands"
    commands.mkdir()
    program = f"#!/bin/bash\nexec {sys.executable} -c '{PROGRAM}' \"$@\"\n"
    for name, text in (("sbatch", SBATCH), ("scancel", SCANCEL), ("mixed-ehl", program)):
        (commands / name).write_text(text)
        (commands / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{commands}:{os.environ['PATH']}")
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    return commands


def test_array_merge_and_fit_give_what_a_local_run_gives(slurm: Path, mixed_ehl: Any, tmp_path: Path) -> None:
    """In a container; first with a task that is killed: nothing is merged, and the same script computes the rest."""
    (slurm / "apptainer").write_text('#!/bin/bash\n[ "$1 $2" = "exec my image.sif" ]\nshift 2\nexec "$@"\n')
    (slurm / "apptainer").chmod(0o755)
    (tmp_path / "my plan.toml").write_text('name = "array"\n[sampling]\nsize = 32\n' + GEAR_VARIABLES)
    options = ("--with", "arana_2019", "--set", "sampling.seed=5")
    chain = ("--merge", "all.h5", "--fit", "array.json", "--sbatch", "partition=short", "--sbatch", "mem=8G")
    container = ("--container", "my image.sif")
    printed = mixed_ehl("sweep", "my plan.toml", "-o", "runs/a b", "--slurm", "2", *options, *chain, *container)
    assert printed.code == 0
    task = "exec apptainer exec 'my image.sif' mixed-ehl sweep"
    assert task in printed.out

    def submit(script: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(["bash", "-c", script], capture_output=True, text=True, timeout=300)

    assert submit(printed.out.replace(task, f"[ $SLURM_ARRAY_TASK_ID = 1 ] || kill -9 $$\n{task}")).returncode == 0
    assert not (tmp_path / "all.h5").exists()
    assert "16 of 32 are missing" in (slurm / "log").read_text()
    done = submit(printed.out)
    assert done.returncode == 0, done.stderr + (slurm / "log").read_text()
    assert done.stdout.splitlines() == ["array 4713: 2 tasks", "then 4714: merge and fit"]
    assert (slurm / "calls").read_text().splitlines()[2:] == ["--parsable", "--parsable --dependency=afterany:4713"]
    for job in slurm.glob("job.*"):
        assert {"#SBATCH --partition=short", "#SBATCH --mem=8G"} <= set(job.read_text().splitlines())
    shards = {path.name for path in (tmp_path / "runs" / "a b").glob("*.jsonl")}
    assert shards == {"shard-0001-of-0002.jsonl", "shard-0002-of-0002.jsonl"}
    assert mixed_ehl("sweep", "my plan.toml", "-o", "local", "--jobs", "1", *options).code == 0
    assert load_dataset(tmp_path / "all.h5").data_hash == load_dataset(tmp_path / "local").data_hash
    assert Formula.load(tmp_path / "array.json").data.hash == load_dataset(tmp_path / "local").data_hash


@pytest.mark.usefixtures("slurm")
def test_the_cluster_of_the_page_on_sweeps_computes(tmp_path: Path) -> None:
    jobqueue = pytest.importorskip("dask_jobqueue")
    from distributed import Client

    plan = validate(Plan, sweep_plan("jobqueue"))
    evaluate = partial(published_outputs, name="xu_kahraman_2007")
    arguments = {"cores": 1, "processes": 1, "memory": "2 GB", "walltime": "04:00:00"}
    with jobqueue.SLURMCluster(**arguments, dashboard_address=None) as cluster, Client(cluster) as client:
        script = cluster.job_script()
        for line in ("#SBATCH -n 1", "#SBATCH --cpus-per-task=1", "#SBATCH --mem=2G", "#SBATCH -t 04:00:00"):
            assert line in script
        # one thread per worker, as the sweep sets it
        assert "--nthreads 1" in script
        cluster.scale(jobs=1)
        workers = DaskCluster(client, worker_timeout=120.0)
        report = sweep_shard(plan, tmp_path / "dask", evaluate=evaluate, executor=workers)
    assert (report.converged, report.failed) == (16, 0)
    sweep_shard(plan, tmp_path / "local", evaluate=evaluate)
    assert load_dataset(tmp_path / "dask").data_hash == load_dataset(tmp_path / "local").data_hash
