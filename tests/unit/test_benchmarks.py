"""Every benchmark says what it is and reads its arguments; figures of the documentation have theirs; counts of work."""

from __future__ import annotations

import importlib
import importlib.util
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]


def place() -> ModuleType:
    """``python -m benchmarks``, as a module."""
    spec = importlib.util.spec_from_file_location("benchmark_list", ROOT / "benchmarks" / "__main__.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


PLACE = place()


@pytest.mark.parametrize("name", PLACE.benchmarks())
def test_a_benchmark_says_what_it_is_and_reads_its_arguments(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    about = PLACE.benchmarks()[name]
    assert 20 < len(about) <= 120
    assert about.endswith((".", "?"))
    with pytest.raises(SystemExit) as end:
        importlib.import_module(name).main(["--help"])
    assert end.value.code == 0
    assert about.split()[0] in capsys.readouterr().out


def test_figures_of_the_documentation_have_their_benchmark() -> None:
    drawn = {path.name for path in (ROOT / "docs" / "figures").glob("*.png")}
    assert set(PLACE.FIGURES) <= drawn
    assert drawn - set(PLACE.FIGURES) == {"calibration.png"}  # a command of the program, on its page
    assert {benchmark for benchmark, *_ in PLACE.FIGURES.values()} <= set(PLACE.benchmarks())


def test_list_and_one_of_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert PLACE.main([]) == 0
    assert "counts" in capsys.readouterr().out
    with pytest.raises(SystemExit) as end:
        PLACE.main(["nothing"])
    assert end.value.code == 2


def test_work_of_fixed_tasks_is_that_of_the_baseline() -> None:
    """Where a change is meant, ``python -m benchmarks counts --write`` writes the new baseline.

    In a process of its own: beside threads that other tests leave, Python 3.11 may never return from a profiled call.
    """
    paths = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    command = [sys.executable, "-m", "benchmarks", "counts"]
    done = subprocess.run(
        command, cwd=ROOT, env=os.environ | {"PYTHONPATH": paths}, capture_output=True, text=True, timeout=300
    )
    counted = [line for line in done.stdout.splitlines() if " baseline " in line]
    assert len(counted) == 10
    assert [line for line in counted if "OUTSIDE" in line] == []
    assert done.returncode == 0, done.stderr


def test_work_beyond_a_tenth_or_without_a_baseline_is_outside() -> None:
    counts = importlib.import_module("counts")
    assert counts.Count("work", 109, 100).within
    assert not counts.Count("work", 112, 100).within
    assert not counts.Count("work", 100, None).within
