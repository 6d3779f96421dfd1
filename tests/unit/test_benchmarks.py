"""Benchmarks and validation read their arguments; every figure of the documentation has its script; counts of work."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FIGURES = {path.name for path in (ROOT / "docs" / "figures").glob("*.png")}
COMMAND = {"calibration.png"}  # drawn by a command of the program, on its page


def script(*arguments: str) -> subprocess.CompletedProcess[str]:
    """A process of its own: with threads of other tests Python 3.11 may never return from a profiled call."""
    paths = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    environment = os.environ | {"PYTHONPATH": paths}
    return subprocess.run(
        [sys.executable, *arguments], cwd=ROOT, env=environment, capture_output=True, text=True, timeout=300
    )


@pytest.mark.parametrize("place", ["benchmarks", "validation"])
def test_every_script_states_its_subject_and_reads_its_arguments(place: str) -> None:
    done = script("-m", place, "check")
    assert done.returncode == 0, done.stdout + done.stderr
    assert script("-m", place, "nothing").returncode == 2


def test_figures_of_the_documentation_have_their_script() -> None:
    listed = set(script("-m", "validation", "figures", "--list").stdout.split())
    assert listed == FIGURES - COMMAND


def test_work_of_fixed_tasks_is_that_of_the_baseline() -> None:
    """Where a change is meant, ``python benchmarks/counts.py --write`` writes the new baseline."""
    done = script("benchmarks/counts.py")
    counted = [line for line in done.stdout.splitlines() if " baseline " in line]
    assert len(counted) == 10
    assert [line for line in counted if "OUTSIDE" in line] == []
    assert done.returncode == 0, done.stderr
