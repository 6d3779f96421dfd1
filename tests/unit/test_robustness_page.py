"""docs/robustness.md: every line names tests that provoke it; all of them exist."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "robustness.md").read_text(encoding="utf-8")
FAULTS_PAGE = PAGE.split("## What the endurance")[0]
LINES = [
    line for line in FAULTS_PAGE.splitlines() if line.startswith("| ") and not line.startswith(("| what |", "| code |"))
]
FAULTS = [line for line in LINES if not re.match(r"\| \d+ \|", line)]
TESTS = {
    node.name
    for module in (ROOT / "tests").rglob("test_*.py")
    for node in ast.walk(ast.parse(module.read_text(encoding="utf-8")))
    if isinstance(node, ast.FunctionDef)
}


@pytest.mark.parametrize("line", FAULTS)
def test_tests_of_a_line_exist(line: str) -> None:
    named = re.findall(r"`(test_\w+)`", line)
    assert named
    assert set(named) <= TESTS, set(named) - TESTS


def test_the_faults_provoked_have_their_line() -> None:
    """Whatever `test_robustness` provokes stands on the page; what only guards the sound case does not."""
    module = ast.parse((ROOT / "tests" / "unit" / "test_robustness.py").read_text(encoding="utf-8"))
    tests = (node.name for node in module.body if isinstance(node, ast.FunctionDef))
    provoked = {name for name in tests if name.startswith("test_")}
    sound = {
        "test_what_is_nested_less_is_read",
        "test_units_with_small_powers_stay",
        "test_shipped_oils_have_names_that_fit",
    }
    assert provoked - sound <= set(re.findall(r"`(test_\w+)`", PAGE))
    assert len(FAULTS) > 30
