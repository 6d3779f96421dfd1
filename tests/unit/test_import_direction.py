"""Arrows run one way: efficiency -> regression -> ehl."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FORBIDDEN = {"ehl": {"regression", "efficiency"}, "regression": {"efficiency"}, "efficiency": set()}


def imported_packages(module: Path) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module.split(".")[0])
    return names


@pytest.mark.parametrize("package", FORBIDDEN)
def test_package_imports_only_downwards(package: str) -> None:
    modules = sorted((ROOT / package).rglob("*.py"))
    assert modules
    for module in modules:
        assert not imported_packages(module) & FORBIDDEN[package], module


def test_no_module_of_a_name_that_says_nothing() -> None:
    stems = {module.stem for package in FORBIDDEN for module in (ROOT / package).rglob("*.py")}
    assert not stems & {"utils", "common", "helpers", "core"}


def test_tests_hold_no_packages() -> None:
    # tests/ehl/__init__.py would shadow our ehl
    assert not list((ROOT / "tests").rglob("__init__.py"))
