"""docs/theory.md: every equation names the function that computes it and the tests that prove it; all of them exist."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "theory.md").read_text(encoding="utf-8").splitlines()
PROOFS = [line.removeprefix("→ ") for line in PAGE if line.startswith("→ ")]


def defined_in(*folders: str) -> set[str]:
    """Names of the functions and classes of some folders."""
    names = set()
    for folder in folders:
        for module in (ROOT / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
                if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
                    names.add(node.name)
    return names


CODE, TESTS = defined_in("ehl", "regression", "efficiency"), defined_in("tests")


@pytest.mark.parametrize("proof", PROOFS)
def test_functions_and_tests_of_an_equation_exist(proof: str) -> None:
    functions, tests = (set(re.findall(r"`(\w+)`", part)) for part in proof.split(";"))
    assert functions
    assert tests
    assert functions <= CODE, functions - CODE
    assert tests <= TESTS, tests - TESTS


def test_every_equation_is_followed_by_its_proof() -> None:
    """An indented block is an equation; before the next one or the next heading stands a line with an arrow."""
    fenced = False
    open_equation = ""
    for line in PAGE:
        if line.startswith("```"):
            fenced = not fenced
        if fenced:
            continue
        if line.startswith("    ") and not open_equation:
            open_equation = line.strip()
        elif line.startswith("→ "):
            open_equation = ""
        assert not (line.startswith("#") and open_equation), open_equation
    assert not open_equation
    assert len(PROOFS) > 40
