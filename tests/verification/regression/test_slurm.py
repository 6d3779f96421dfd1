"""Slurm without a cluster: a stand-in for `sbatch` runs what a real one would; the data are those of a local run."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from small_plans import GEAR_VARIABLES, sweep_plan

from ehl.io.validation import validate
from regression.data.dataset import load_dataset
from regression.plan.plan import Plan
from regression.sweeping.dask_workers import DaskCluster
from regression.sweeping.evaluators import published_outputs
from regression.sweeping.sweep import sweep_shard

# of the options of sbatch the array alone counts; each task sees what Slurm gives it
SBATCH = """#!/bin/bash
set -eu
script=$1
last=$(sed -n 's/^#SBATCH --array=1-//p' "$script")
export SLURM_CPUS_PER_TASK=$(sed -n 's/^#SBATCH --cpus-per-task=//p' "$script")
export SLURM_JOB_ID=4711
if [ -z "$last" ]; then
    # a job of dask: runs on after the command
    nohup bash "$script" > "$script.log" 2>&1 &
    echo "Submitted batch job $!"
    exit 0
fi
for task in $(seq 1 "$last"); do
    SLURM_ARRAY_TASK_ID=$task bash "$script"
done
"""
SCANCEL = '#!/bin/bash\nkill "$@" 2> /dev/null\n'


@pytest.fixture
def slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with `sbatch`, `scancel` and `mixed-ehl`, first in the path of commands."""
    commands = tmp_path / "commands"
    commands.mkdir()
    program = f"#!/bin/bash\nexec {sys.executable} -c 'from efficiency.cli import main; main()' \"$@\"\n"
    for name, text in (("sbatch", SBATCH), ("scancel", SCANCEL), ("mixed-ehl", program)):
        (commands / name).write_text(text)
        (commands / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{commands}:{os.environ['PATH']}")
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    return commands


@pytest.mark.usefixtures("slurm")
def test_a_job_array_gives_the_formula_of_a_local_run_bit_for_bit(
    mixed_ehl: Callable[..., Any], tmp_path: Path
) -> None:
    (tmp_path / "my plan.toml").write_text('name = "array"\n[sampling]\nsize = 32\n' + GEAR_VARIABLES)
    options = ("--with", "arana_2019", "--set", "sampling.seed=5")
    printed = mixed_ehl("sweep", "my plan.toml", "-o", "runs/a b", "--slurm", "2", *options)
    assert printed.code == 0
    (tmp_path / "job.sh").write_text(printed.out)
    done = subprocess.run(["sbatch", "job.sh"], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert {path.name for path in (tmp_path / "runs" / "a b").glob("*.h5")} == {
        "shard-0001-of-0002.h5",
        "shard-0002-of-0002.h5",
    }
    assert mixed_ehl("sweep", "merge", "runs/a b", "-o", "all.h5").code == 0
    assert mixed_ehl("sweep", "my plan.toml", "-o", "local", "--jobs", "1", *options).code == 0
    for run, formula in (("all.h5", "array.json"), ("local", "local.json")):
        assert mixed_ehl("fit", run, "-o", formula, "--family", "power_law").code == 0
    assert (tmp_path / "array.json").read_bytes() == (tmp_path / "local.json").read_bytes()


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
        # one thread a worker, as the sweep asks for
        assert "--nthreads 1" in script
        cluster.scale(jobs=1)
        report = sweep_shard(
            plan, tmp_path / "dask", evaluate=evaluate, executor=DaskCluster(client, worker_timeout=120.0)
        )
    assert (report.converged, report.failed) == (16, 0)
    sweep_shard(plan, tmp_path / "local", evaluate=evaluate)
    assert load_dataset(tmp_path / "dask").data_hash == load_dataset(tmp_path / "local").data_hash
