"""Mutants of the parts that must not be wrong, and the share of them that their tests notice.

    python -m validation mutants                      # every mutant of every area, hours; for the night
    python -m validation mutants units --sample 20    # some, chosen by the seed

A mutant is one change of one function: a comparison, an operator, a number, a condition, a returned value, or a
statement left out. Texts, annotations and the arguments of errors are not changed, as tests do not assert wording.
The tests of an area are collected once; each mutant is a forked process that replaces the code of the function and runs
them up to the first failure. A mutant that takes ten times as long as the tests is noticed too.
"""

from __future__ import annotations

import argparse
import ast
import gc
import importlib
import json
import os
import random
import resource
import sys
import time
import types
from collections import Counter
from collections.abc import Iterator, Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from common import command_line

ROOT = Path(__file__).resolve().parents[1]
# area -> files, tests
AREAS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "units": (("ehl/common/units.py",), ("tests/unit/ehl/test_units.py", "tests/unit/test_your_files.py")),
    "journal": (("ehl/common/journal.py",), ("tests/unit/regression/test_store.py",)),
    "errors": (
        ("ehl/rough/batch_means.py", "ehl/rough/multilevel.py", "ehl/validity.py"),
        ("tests/unit/ehl/test_error_bars.py", "tests/unit/ehl/test_transient_parts.py"),
    ),
    "guard": (
        ("regression/friction/data_cloud.py", "regression/friction/error_tables.py"),
        ("tests/verification/regression/test_data_cloud.py", "tests/unit/regression/test_fit_checks.py"),
    ),
}
COMPARED = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
OPERATED = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult,
    ast.FloorDiv: ast.Mult, ast.Mod: ast.Mult, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd,
}  # fmt: skip
KILLED, SURVIVED, NO_MUTANT = 0, 3, 4
SPARE = 10.0  # processor time of a mutant over that of the tests [s]


def changes(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """Changes of one node, in words and as the node that replaces it."""
    new = deepcopy(node)
    if isinstance(new, ast.Compare) and type(new.ops[0]) in COMPARED:
        new.ops[0] = COMPARED[type(new.ops[0])]()
        yield "comparison", new
    elif isinstance(new, ast.BinOp | ast.AugAssign) and type(new.op) in OPERATED:
        new.op = OPERATED[type(new.op)]()
        yield "operator", new
    elif isinstance(new, ast.BoolOp):
        new.op = ast.Or() if isinstance(new.op, ast.And) else ast.And()
        yield "and, or", new
    elif isinstance(new, ast.UnaryOp) and isinstance(new.op, ast.Not | ast.USub):
        yield "sign", new.operand
    elif isinstance(new, ast.Constant) and isinstance(new.value, bool | int | float):
        number = new.value
        new.value = not number if isinstance(number, bool) else number + 1 if isinstance(number, int) else 1.5 * number
        yield "number", new if new.value != number else ast.Constant(1.0)
    elif isinstance(new, ast.If | ast.IfExp | ast.While):
        new.test = ast.UnaryOp(ast.Not(), new.test)
        yield "condition", new
    elif isinstance(new, ast.Return) and new.value is not None and not isinstance(new.value, ast.Constant):
        yield "returned value", ast.Return(ast.Constant(None))
    elif isinstance(new, ast.Break | ast.Continue):
        yield "jump", ast.Continue() if isinstance(new, ast.Break) else ast.Break()
    if isinstance(node, ast.Raise | ast.AugAssign) or (isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)):
        yield "left out", ast.Pass()


def places(node: ast.AST, inside: bool = False) -> Iterator[tuple[ast.AST, str, Any, ast.AST]]:
    """Parent, field, index and node of all that may change: what is inside functions, but texts and messages."""
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "type_comment", "exc", "cause"):
            continue
        for at, child in enumerate(value) if isinstance(value, list) else ((None, value),):
            if not isinstance(child, ast.AST) or isinstance(child, ast.JoinedStr):
                continue
            function = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef)
            if function and child.name in ("__repr__", "__str__"):  # type: ignore[attr-defined]
                continue
            if (inside and name != "args") or (inside and not isinstance(child, ast.arguments)):
                yield node, name, at, child
            yield from places(child, inside or function)


def mutants(path: Path) -> Iterator[tuple[str, int, str, ast.Module]]:
    """Kind, line and changed text of every mutant of a file, and its tree."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for parent, name, at, node in list(places(tree)):
        for kind, new in changes(node):
            ast.copy_location(new, node)
            _put(parent, name, at, new)
            text = f"{ast.unparse(node).splitlines()[0][:80]} -> {ast.unparse(new).splitlines()[0][:80]}"
            yield kind, getattr(node, "lineno", 0), text, tree
            _put(parent, name, at, node)


def _put(parent: ast.AST, name: str, at: int | None, node: ast.AST) -> None:
    if at is None:
        setattr(parent, name, node)
    else:
        getattr(parent, name)[at] = node


def codes(code: types.CodeType) -> Iterator[types.CodeType]:
    """All code of a module."""
    for value in code.co_consts:
        if isinstance(value, types.CodeType):
            yield value
            yield from codes(value)


def replaced(path: Path, tree: ast.Module) -> bool:
    """Put the code of a mutant into the functions of the imported module; whether any differs."""
    new = {c.co_qualname: c for c in codes(compile(ast.fix_missing_locations(tree), str(path), "exec"))}
    found = False
    for function in gc.get_objects():
        if isinstance(function, types.FunctionType) and function.__code__.co_filename == str(path):
            code = new.get(function.__code__.co_qualname)
            if code is not None and code != function.__code__:
                if len(code.co_freevars) != len(function.__code__.co_freevars):
                    return False
                function.__code__ = code
                found = True
    return found


class Area:
    """Plugin of pytest: in place of the tests, the tests of every mutant in a process of its own."""

    def __init__(self, name: str, sample: int, seed: int) -> None:
        self.name, self.sample, self.seed = name, sample, seed
        self.rows: list[dict[str, Any]] = []

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Run the tests without a mutant, then those of each mutant."""
        for path in AREAS[self.name][0]:  # what tests import late
            importlib.import_module(path.removesuffix(".py").replace("/", "."))
        items = list(session.items)
        clock = time.process_time(), sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
        if self._forked(items, None, None) != SURVIVED:
            raise SystemExit(f"{self.name}: the tests fail without a mutant")
        seconds = sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2]) - clock[1]
        every = [(ROOT / path, number) for path in AREAS[self.name][0] for number in range(_count(ROOT / path))]
        chosen = every if not self.sample else random.Random(self.seed).sample(every, min(self.sample, len(every)))
        for path, number in sorted(chosen):
            kind, line, text, tree = next(m for k, m in enumerate(mutants(path)) if k == number)
            found = self._forked(items, (path, tree), 10.0 * seconds + SPARE)
            if found != NO_MUTANT:
                row = {"area": self.name, "place": f"{path.relative_to(ROOT)}:{line}", "kind": kind, "change": text}
                self.rows.append(row | {"killed": found != SURVIVED})
                if found == SURVIVED:
                    print(f"{row['place']}: {kind}: {text}", flush=True)
        return True

    def _forked(self, items: list[Any], mutant: tuple[Path, ast.Module] | None, limit: float | None) -> int:
        """How a process ends that runs the tests up to the first failure."""
        sys.stdout.flush()
        process = os.fork()
        if process == 0:
            end = KILLED
            try:
                os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
                os.dup2(1, 2)
                if limit is not None:
                    resource.setrlimit(resource.RLIMIT_CPU, (int(limit) + 1, int(limit) + 2))
                if mutant is not None and not replaced(*mutant):
                    end = NO_MUTANT
                else:
                    end = SURVIVED if all(map(_passes, items, [*items[1:], None])) else KILLED
            finally:
                os._exit(end)
        _, status = os.waitpid(process, 0)
        return os.waitstatus_to_exitcode(status)


def _count(path: Path) -> int:
    return sum(1 for _ in mutants(path))


def _passes(item: Any, after: Any) -> bool:
    from _pytest.runner import runtestprotocol

    return not any(report.failed for report in runtestprotocol(item, log=False, nextitem=after))


def main(argv: Sequence[str] | None = None) -> None:
    """Make mutants and count those that the tests notice."""
    parser = command_line(__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("areas", nargs="*", choices=[*AREAS, []], default=[])
    parser.add_argument("--sample", type=int, default=0, help="mutants of each area; default: all")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, help="a line of JSON for each mutant")
    options = parser.parse_args(argv)
    rows: list[dict[str, Any]] = []
    for name in options.areas or AREAS:
        area = Area(name, options.sample, options.seed)
        quiet = ["-qq", "-p", "no:xdist", "-p", "no:cacheprovider", "-o", "timeout=0"]
        pytest.main([*quiet, *(str(ROOT / test) for test in AREAS[name][1])], plugins=[area])
        rows += area.rows
        if options.out is not None:
            options.out.write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")
    made, killed = Counter(row["area"] for row in rows), Counter(row["area"] for row in rows if row["killed"])
    for name in made:
        print(f"{name}: {killed[name]} of {made[name]} mutants noticed, {100.0 * killed[name] / made[name]:.0f} %")


if __name__ == "__main__":
    main()
