"""What the command line can do, a notebook can do: it imports what the packages export, and nothing behind it."""

from __future__ import annotations

import ast
import importlib
import pkgutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("ehl", "regression", "efficiency")
CONSOLE = "ehl.common.console"  # progress bars, options in errors, JSON: what all command lines share
OUTSIDE = {"typer", "rich", *sys.stdlib_module_names}
MODULES = sorted(
    module
    for package in PACKAGES
    for module in (ROOT / package).rglob("*.py")
    if "cli" in module.relative_to(ROOT).with_suffix("").parts
)


def names_used(tree: ast.AST) -> Iterator[str]:
    """Dotted names of all imports, also inside functions, and of attributes of the packages (`ehl.view`)."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in PACKAGES:
            yield f"{node.value.id}.{node.attr}"


def allowed(name: str) -> bool:
    package, _, rest = name.partition(".")
    if package not in PACKAGES:
        return package in OUTSIDE
    own_command_line = rest.partition(".")[0] == "cli"
    console = f"{name}.".startswith(f"{CONSOLE}.")
    return not rest or own_command_line or console or rest in importlib.import_module(package).__all__


def test_there_are_command_lines() -> None:
    assert {module.relative_to(ROOT).parts[0] for module in MODULES} == set(PACKAGES)


@pytest.mark.parametrize("module", MODULES, ids=lambda module: str(module.relative_to(ROOT)))
def test_command_line_imports_public_names_only(module: Path) -> None:
    assert [name for name in names_used(ast.parse(module.read_text(encoding="utf-8"))) if not allowed(name)] == []


def test_rule_finds_what_reaches_past() -> None:
    code = "from ehl.common.figures import save_figure\ndef f():\n    import regression.formula\n    ehl.heat"
    assert {name for name in names_used(ast.parse(code)) if not allowed(name)} == {
        "ehl.common.figures.save_figure",
        "regression.formula",
        "ehl.heat",
    }
    assert allowed("ehl.Contact")
    assert allowed("ehl.common.console.print_json")
    assert not allowed("numpy")


@pytest.mark.parametrize("package", ["ehl", "regression", "efficiency"])
def test_every_module_is_imported(package: str) -> None:
    found = importlib.import_module(package)
    names = [module.name for module in pkgutil.walk_packages(found.__path__, f"{package}.")]
    assert len(names) > 20
    for name in names:
        importlib.import_module(name)
