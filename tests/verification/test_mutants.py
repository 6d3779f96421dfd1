"""A sample of the mutants of `validation/mutants.py`: nearly all are noticed by the tests of their functions."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no forks here")
def test_nine_of_twelve_mutants_are_noticed() -> None:
    command = [sys.executable, "-m", "validation", "mutants", "guard", "--sample", "12", "--seed", "3"]
    # a session of its own within that of the gate
    clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    ended = subprocess.run(command, cwd=ROOT, env=clean, capture_output=True, text=True, timeout=500)
    assert ended.returncode == 0, ended.stderr
    (noticed, made) = map(int, re.findall(r"(\d+) of (\d+)", ended.stdout)[-1])
    assert made == 12
    assert noticed >= 9, ended.stdout
