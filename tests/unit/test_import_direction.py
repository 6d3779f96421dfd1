"""Arrows run one way: efficiency -> regression -> ehl, and without circles between the folders of each."""

import ast
import importlib
import pkgutil
import re
import sys
from collections import defaultdict
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FORBIDDEN = {"ehl": {"regression", "efficiency"}, "regression": {"efficiency"}, "efficiency": set()}


def modules_imported(module: Path) -> Iterator[str]:
    """Dotted names of all imports, also inside functions, and of attributes of the packages (`ehl.view`)."""
    for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "relative import"
            # "from ehl.fluid import oil" may name a module or what a folder exports
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in FORBIDDEN:
            yield f"{node.value.id}.{node.attr}"


def part_of(package: str, dotted: str) -> str:
    """Folder, or module outside of folders, of a dotted name; empty for the package itself."""
    parts = dotted.split(".")[1:]
    if not parts:
        return ""
    folder = ROOT / package / parts[0]
    return parts[0] if folder.is_dir() or folder.with_suffix(".py").is_file() else ""


def arrows(package: str) -> dict[str, set[str]]:
    """Imports between the folders of one package."""
    found: dict[str, set[str]] = defaultdict(set)
    for module in sorted((ROOT / package).rglob("*.py")):
        parts = module.relative_to(ROOT).with_suffix("").parts
        here = part_of(package, ".".join(part for part in parts if part != "__init__"))
        for name in modules_imported(module):
            there = part_of(package, name)
            if name.split(".")[0] == package and there != here and name != f"{package}.__version__":
                found[here].add(there)
    return found


@pytest.mark.parametrize("package", FORBIDDEN)
def test_package_imports_only_downwards_and_without_circles(package: str) -> None:
    modules = sorted((ROOT / package).rglob("*.py"))
    assert modules
    for module in modules:
        assert not {name.split(".")[0] for name in modules_imported(module)} & FORBIDDEN[package], module
    assert arrows(package)
    TopologicalSorter(arrows(package)).prepare()  # raises CycleError


def test_names_of_modules() -> None:
    stems = {module.stem for package in FORBIDDEN for module in (ROOT / package).rglob("*.py")}
    assert not stems & {"utils", "helpers", "core"}
    assert not list((ROOT / "tests").rglob("__init__.py"))  # tests/ehl/__init__.py would shadow our ehl


CONSOLE = "ehl.common.console"  # progress bars, options in errors, JSON: what all command lines share
OUTSIDE = {"typer", "rich", *sys.stdlib_module_names}
MODULES = sorted(
    module
    for package in FORBIDDEN
    for module in (ROOT / package).rglob("*.py")
    if "cli" in module.relative_to(ROOT).with_suffix("").parts
)


def allowed(name: str) -> bool:
    package, _, rest = name.partition(".")
    if package not in FORBIDDEN:
        return package in OUTSIDE
    own_command_line = rest.partition(".")[0] == "cli"
    console = f"{name}.".startswith(f"{CONSOLE}.")
    return not rest or own_command_line or console or rest in importlib.import_module(package).__all__


def test_command_lines_import_public_names_only() -> None:
    assert {module.relative_to(ROOT).parts[0] for module in MODULES} == set(FORBIDDEN)
    for module in MODULES:
        assert [name for name in modules_imported(module) if not allowed(name)] == [], module


@pytest.mark.parametrize("package", FORBIDDEN)
def test_every_module_is_imported(package: str) -> None:
    found = importlib.import_module(package)
    names = [module.name for module in pkgutil.walk_packages(found.__path__, f"{package}.")]
    assert len(names) > 20
    for name in names:
        importlib.import_module(name)


def test_every_presenter_has_the_functions_it_names() -> None:
    """`Reportable` finds sections and main figure by name; the page of `demo` has no figure of its own."""
    text = "".join(path.read_text(encoding="utf-8") for name in FORBIDDEN for path in (ROOT / name).rglob("*.py"))
    found = re.findall(r'presenter = "([\w.]+):(\w+)"', text)
    assert len(found) > 9
    for module, name in found:
        wanted = {f"{name}_sections", f"plot_{name}"} - {"plot_demo"}
        assert wanted <= vars(importlib.import_module(module)).keys()
