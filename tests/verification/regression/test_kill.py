"""A sweep killed in mid-run and resumed ends with the data, and the formula bit for bit, of one that was not."""

import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from small_plans import GEAR_VARIABLES

from ehl.common.errors import InputError
from regression.data.dataset import load_dataset, run_status
from regression.data.result_files import merge
from regression.fitting.fit import fit_formula
from regression.plan.plan import Plan
from regression.sweeping.evaluators import published_outputs, solve_outputs
from regression.sweeping.sweep import sweep_shard

PLAN = 'name = "kill"\n[sampling]\nsize = SIZE\n' + GEAR_VARIABLES + '[model]\naccuracy = "fast"\nthermal = "off"\n'

ARANA: dict[str, Any] = {"evaluate": partial(published_outputs, name="arana_2019"), "version": "arana_2019"}

# prints its progress after every case, and waits for a moment so that the kill is during the run
CHILD = """
import sys, time
import regression
from regression.sweeping import sweep

plan, run, name, jobs = sys.argv[1:]
def show(progress):
    print(progress.done, flush=True)
    time.sleep(0.005)
sweep.FLUSH_ROWS, sweep.FLUSH_SECONDS = 4, 60.0
regression.sweep(plan, run, formula=name if name != "ehl" else None, jobs=int(jobs), progress=show)
"""


def _kill_after(cases: int, plan: Path, run: Path, name: str, jobs: int) -> None:
    """Kill a sweep in a process group of its own when it has done so many cases, and see its workers leave."""
    command = [sys.executable, "-c", CHILD, str(plan), str(run), name, str(jobs)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True) as process:
        for line in process.stdout:
            if int(line) >= cases:
                process.kill()
                break
        assert process.wait() == -signal.SIGKILL
    for _ in range(300):
        try:
            os.killpg(process.pid, 0)
        except ProcessLookupError:
            return
        time.sleep(0.1)
    os.killpg(process.pid, signal.SIGKILL)
    raise AssertionError("workers stayed behind without their parent")


def _plan(folder: Path, size: int) -> Path:
    path = folder / "plan.toml"
    path.write_text(PLAN.replace("SIZE", str(size)))
    return path


def _is_whole(plan: Plan, run: Path, *families: str, **how: Any) -> None:
    """A run has the data, and its formulas the bits, of one that was not stopped."""
    sweep_shard(plan, run.with_name("whole"), **how)
    found, whole = load_dataset(run), load_dataset(run.with_name("whole"))
    assert found.data_hash == whole.data_hash
    for family in families:
        assert fit_formula(found, family).to_json() == fit_formula(whole, family).to_json()


def test_killed_workers_and_all_resumed_is_bit_identical(tmp_path: Path) -> None:
    path, run = _plan(tmp_path, 64), tmp_path / "killed"
    _kill_after(24, path, run, "arana_2019", 2)
    assert 0 < run_status(run).finished < 64
    resumed = sweep_shard(Plan.from_file(path), run, **ARANA)
    assert resumed.resumed >= 20
    assert resumed.resumed + resumed.converged == 64
    _is_whole(Plan.from_file(path), run, "power_law", "short", **ARANA)


def test_killed_solver_sweep_is_bit_identical(tmp_path: Path) -> None:
    path, run = _plan(tmp_path, 32), tmp_path / "killed"
    path.write_text(path.read_text().replace("roughness_rms", "# roughness_rms"))
    _kill_after(9, path, run, "ehl", 1)
    assert 0 < run_status(run).finished < 32
    assert sweep_shard(Plan.from_file(path), run, evaluate=solve_outputs).resumed >= 8
    assert (load_dataset(run).frame["status"] == "converged").all()
    _is_whole(Plan.from_file(path), run, "xu", evaluate=solve_outputs)


def test_a_full_disk_stops_in_words_and_the_resumed_run_is_bit_identical(tmp_path: Path) -> None:
    """A limit on the size of files stands for the disk."""
    plan, run = Plan.from_file(_plan(tmp_path, 256)), tmp_path / "full"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, before[1]))
    try:
        with pytest.raises(InputError, match=r"disk that can be written\. .*Free some space and repeat"):
            sweep_shard(plan, run, **ARANA)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    kept = run_status(run).finished
    assert 0 < kept < 256
    resumed = sweep_shard(plan, run, **ARANA)
    assert (resumed.resumed, resumed.converged) == (kept, 256 - kept)
    _is_whole(plan, run, "power_law", **ARANA)


def test_two_sweeps_of_one_shard_at_once(tmp_path: Path, mixed_ehl: Callable[..., Any]) -> None:
    path, run, name = _plan(tmp_path, 64), tmp_path / "run", "arana_2019"
    command = [sys.executable, "-c", CHILD, str(path), str(run), name, "1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as first:
        first.stdout.readline()
        os.kill(first.pid, signal.SIGSTOP)
        second = mixed_ehl("sweep", path, "-o", run, "--with", name, "--jobs", "1")
        os.kill(first.pid, signal.SIGCONT)
        first.stdout.read()
        assert first.wait() == 0
    assert second.code == 2
    assert "Is the same command running?" in second.err
    assert run_status(run).complete


def test_a_sweep_that_is_running_is_read_and_fitted(tmp_path: Path) -> None:
    """Whatever the writer is at, what is read are whole rows of it."""
    path, run, name = _plan(tmp_path, 256), tmp_path / "running", "arana_2019"
    sweep_shard(Plan.from_file(path), tmp_path / "whole", **ARANA)
    whole = load_dataset(tmp_path / "whole").frame.set_index("key")
    command = [sys.executable, "-c", CHILD, str(path), str(run), name, "1"]
    seen: list[int] = []
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        for line in process.stdout:
            if int(line) >= 64 and len(seen) < 6 and int(line) < 250:
                dataset = load_dataset(run)
                frame = dataset.frame.set_index("key")
                assert set(frame.index) <= set(whole.index)
                same = whole.loc[frame.index, "friction_coefficient"]
                assert (frame["friction_coefficient"] == same).all()
                seen.append(len(frame))
                if len(seen) == 3:
                    assert fit_formula(dataset, "power_law").data.count == len(frame)
                    assert merge(run, tmp_path / "part.h5") >= len(frame)
        # the readers were not in the way of the writer
        assert process.wait() == 0
    assert seen == sorted(seen)
    assert 60 <= seen[0] < 256
    assert len(load_dataset(run)) == 256
