"""Mutants of the parts that must not be wrong, and the share of them that their tests notice.

    python -m validation mutants                      # every mutant of every area, hours; for the night
    python -m validation mutants units --sample 20    # some, chosen by the seed

A mutant is one change of one function: a comparison, an operator, a number, a condition, a returned value, a term or a
statement left out, half of a value, or the smaller of two for the larger. Texts, annotations and the arguments of
errors are not changed, as tests do not assert wording.
The tests of an area are collected once and run once, to learn which functions each runs. Each mutant is a forked
process that replaces the code of a function and runs the tests of this function, the shortest first, up to the first
failure. A mutant that takes ten times as long as its tests, or waits without end, is noticed too.
"""

from __future__ import annotations

import argparse
import ast
import gc
import importlib
import inspect
import itertools
import json
import math
import os
import random
import resource
import signal
import sys
import tempfile
import threading
import time
import types
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from common import command_line

ROOT = Path(__file__).resolve().parents[1]
# area -> functions of each file (empty: all), tests
AREAS: dict[str, tuple[dict[str, str], tuple[str, ...]]] = {
    "units": ({"ehl/common/units.py": ""}, ("tests/unit/ehl/test_units.py", "tests/unit/ehl/test_inputs.py")),
    "journal": ({"ehl/common/journal.py": ""}, ("tests/unit/regression/test_store.py",)),
    "errors": (
        {
            "ehl/rough/averaging.py": "batch_means interval_of_means richardson neighbour_correlation pieces parts "
            "_parts friction _friction_of interval film_jumped net_exchange realisation_error",
            "ehl/rough/multilevel.py": "in_common differences mean _extrapolated _limit _pair half_widths interval "
            "stated drift _interval film_error",
            "ehl/smooth/refine.py": "relative extrapolate rounding_errors",
        },
        tuple(f"tests/unit/ehl/test_{name}.py" for name in ("error_bars", "transient_parts", "steady_mesh")),
    ),
    "neglected": (
        {
            "ehl/rough/solve.py": "exchange_error",
            "ehl/rough/transient_result.py": "friction_error",
            "ehl/rough/mixed.py": "roughness_effect _viscous film_stress_ratio _subgrid_error _with_subgrid_film",
            "ehl/rough/dry_limit.py": "share_deficit dry_limit left_out",
            "ehl/smooth/hot_film.py": "_changes change",
            "ehl/heat/estimate.py": "",
            "ehl/elastic_shear.py": "",
            "ehl/validity.py": "checked friction_above_limit_temperature limits_of _limits_of_oil _limits_of_heat",
        },
        (
            *(f"tests/unit/ehl/test_{name}.py" for name in ("error_bars", "heat", "acceptance")),
            "tests/verification/ehl/test_elastic_shear.py",
        ),
    ),
    "inputs": (
        {
            "ehl/uncertainty/result.py": "score_of combined ends of groups",
            "ehl/uncertainty/spread.py": "stated_change of_figure below known shift at none spread lateral_spread",
            "ehl/uncertainty/contact_design.py": "",
            "ehl/fluid/oil_laws.py": "standard_uncertainty",
            "ehl/surface/finish.py": "_given scaled sigma surface_uncertainty",
            "regression/friction/uncertainty.py": "",
        },
        (
            *(f"tests/unit/ehl/test_{name}.py" for name in ("input_uncertainty", "finish")),
            "tests/unit/efficiency/test_error_bars.py",
            "tests/unit/regression/test_formula.py",
        ),
    ),
    "intervals": (
        {
            "regression/fitting/fit.py": "scores _errors _r2 bands interval_of _band_widths _with_noise "
            "covered_by_other_folds conformal_width ratio_of_means noise_floor _width_of_oils_left_out checked_scores",
            "regression/fitting/rows.py": "realisation_scatter measured_noise band_noise statistical_variance "
            "expected_rows rms drawn_rows",
            "regression/fitting/coefficients.py": "linear_fit _variance_inflation _nonlinear_fit",
            "regression/fitting/cross_validation.py": "of cell_groups fold_numbers cross_validate interval_factors",
            "regression/fitting/sensitivity.py": "sobol_indices _estimates",
            "regression/friction/error_tables.py": "",
            "regression/friction/fitted.py": "excess log_width evaluate",
            "regression/friction/network.py": "statistics corrected",
            "regression/calibration/determination.py": "determination_of intervals_by_errors profile_intervals follow",
            "regression/calibration/robust.py": "",
        },
        (
            *(f"tests/unit/regression/test_{name}.py" for name in ("error_bars", "noise", "fit", "formula")),
            *(
                f"tests/unit/regression/test_fit_checks.py::{name}"
                for name in (
                    "test_interval_of_means_over_profiles_is_narrower",
                    "test_corners_lie_beside_the_cloud_and_state_their_coverage",
                    "test_band_table_is_that_of_plain_numpy",
                    "test_interval_of_an_oil_that_was_not_fitted",
                )
            ),
            "tests/unit/regression/test_calibration_parts.py",
            "tests/verification/regression/test_recovery.py",
            "tests/unit/regression/test_friction_models.py",
            "tests/golden/test_golden.py",
        ),
    ),
    "loss": (
        {
            "efficiency/loss/ehl_friction.py": "_solve_one _left_open _friction",
            "efficiency/loss/contact_sample.py": "",
            "efficiency/loss/uncertainty.py": "",
            "efficiency/loss/lubrication.py": "bulk_spread",
            "efficiency/loss/friction_equilibrium.py": "closed balance_error",
            "efficiency/loss/efficiency_result.py": "inputs loss_interval uncertainty",
            "efficiency/conditions/duty.py": "efficiency_error cycle_uncertainty _share_of_squares",
            "efficiency/conditions/grid.py": "_largest _few _between",
            "efficiency/axle/axle.py": "_ends of",
        },
        (
            *(
                f"tests/unit/efficiency/test_{name}.py"
                for name in ("error_bars", "contact_sample", "ehl_friction", "lubrication")
            ),
            *(
                f"tests/unit/efficiency/test_grid.py::{name}"
                for name in (
                    "test_a_law_of_powers_is_exact",
                    "test_a_kink_between_sparse_nodes_is_found",
                    "test_stated_error_is_three_times_the_largest_difference_between_nodes",
                )
            ),
        ),
    ),
    "guard": (
        {"regression/friction/data_cloud.py": ""},
        ("tests/verification/regression/test_data_cloud.py",),
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
EXTREMES = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum"}
KILLED, SURVIVED = 0, 3
QUICK = 2.0  # processor time of a test above which it is not counted on [s]
SPARE = 4.0  # processor time of a mutant over that of the tests [s]
WAITING = 8.0  # wall time over processor time of a mutant that waits for what does not come


def changes(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """Changes of one node, in words and as the node that replaces it."""
    new = deepcopy(node)
    if isinstance(new, ast.Compare) and type(new.ops[0]) in COMPARED:
        new.ops[0] = COMPARED[type(new.ops[0])]()
        yield "comparison", new
    elif isinstance(new, ast.BinOp | ast.AugAssign) and type(new.op) in OPERATED:
        new.op = OPERATED[type(new.op)]()
        yield "operator", new
        if isinstance(node, ast.BinOp):
            if isinstance(node.op, ast.Add | ast.Sub):
                yield "term left out", deepcopy(node.left)
            yield "half", ast.BinOp(ast.Constant(0.5), ast.Mult(), deepcopy(node))
    elif isinstance(new, ast.Call) and _name(new.func) in EXTREMES:
        setattr(new.func, "id" if isinstance(new.func, ast.Name) else "attr", EXTREMES[_name(new.func)])
        yield "smaller, larger", new
    elif isinstance(new, ast.Call) and _name(new.func) == "hypot":
        for at in range(len(new.args)):
            left = deepcopy(new)
            left.args[at] = ast.Constant(0.0)
            yield "term left out", left
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


def _name(function: ast.expr) -> str:
    return getattr(function, "id", getattr(function, "attr", ""))


def places(
    node: ast.AST, only: Sequence[str] = (), inside: bool = False
) -> Iterator[tuple[ast.AST, str, Any, ast.AST]]:
    """Parent, field, index and node of all that may change: what is inside functions, but texts and messages.

    only: names of these functions; default: all.
    """
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "type_comment", "exc", "cause"):
            continue
        for at, child in enumerate(value) if isinstance(value, list) else ((None, value),):
            # the code of a function does not hold the defaults of its arguments
            if not isinstance(child, ast.AST) or isinstance(child, ast.JoinedStr | ast.arguments):
                continue
            function = getattr(child, "name", "") if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef) else ""
            if function in ("__repr__", "__str__"):
                continue
            if inside:
                yield node, name, at, child
            yield from places(child, only, inside or (bool(function) and (not only or function in only)))


def mutants(path: Path, only: Sequence[str] = ()) -> Iterator[tuple[str, int, str, ast.Module]]:
    """Kind, line and changed text of every mutant of a file, and its tree."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for parent, name, at, node in list(places(tree, only)):
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


def functions(path: Path, tree: ast.Module) -> dict[str, types.CodeType]:
    """Code of every function of a file by its qualified name."""
    found = codes(compile(ast.fix_missing_locations(tree), str(path), "exec"))
    return {code.co_qualname: code for code in found if code.co_flags & inspect.CO_OPTIMIZED}


def put_in(path: Path, new: dict[str, types.CodeType]) -> None:
    """Give the functions of an imported module other code."""
    for function in gc.get_objects():
        if isinstance(function, types.FunctionType) and function.__code__.co_filename == str(path):
            code = new.get(function.__code__.co_qualname)
            if code is not None and len(code.co_freevars) == len(function.__code__.co_freevars):
                function.__code__ = code


def clear_caches() -> None:
    """Clear the caches of functions of the program, which would hide that a test runs them."""
    for function in gc.get_objects():
        if hasattr(type(function), "cache_clear") and function.__module__.startswith(
            ("ehl", "regression", "efficiency")
        ):
            function.cache_clear()


class Area:
    """Plugin of pytest: in place of the tests, those of every mutant that run its function, in a process of its own."""

    def __init__(self, name: str, sample: int, seed: int) -> None:
        self.name, self.sample, self.seed = name, sample, seed
        self.only = {ROOT / path: names.split() for path, names in AREAS[name][0].items()}
        self.rows: list[dict[str, Any]] = []

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Run the tests without a mutant, then those of each mutant."""
        for path in AREAS[self.name][0]:  # what tests import late
            importlib.import_module(path.removesuffix(".py").replace("/", "."))
        with tempfile.TemporaryDirectory() as folder:
            used = Path(folder) / "used"
            if self._forked(session.items, used=used) != SURVIVED:
                raise SystemExit(f"{self.name}: the tests fail without a mutant")
            runs = json.loads(used.read_text(encoding="utf-8"))
        every = [(p, number) for p, only in self.only.items() for number in range(sum(1 for _ in mutants(p, only)))]
        chosen = every if not self.sample else random.Random(self.seed).sample(every, min(self.sample, len(every)))
        for path, only in self.only.items():
            sound = functions(path, ast.parse(path.read_text(encoding="utf-8")))
            numbers = {number for of, number in chosen if of == path}
            for number, (kind, line, text, tree) in enumerate(mutants(path, only)):
                if number in numbers:
                    new = {name: code for name, code in functions(path, tree).items() if code != sound.get(name)}
                    own = [k for k, (seconds, names) in enumerate(runs) if seconds < QUICK and new.keys() & set(names)]
                    own.sort(key=lambda k: runs[k][0])
                    items, limits = [session.items[k] for k in own], [10.0 * runs[k][0] + SPARE for k in own]
                    killed = self._forked(items, (path, new), limits=limits) != SURVIVED
                    place = f"{path.relative_to(ROOT)}:{line}"
                    row = {"area": self.name, "place": place, "kind": kind, "change": text, "killed": killed}
                    self.rows.append(row)
                    if not killed:
                        print(f"{place}: {kind}: {text}", flush=True)
        return True

    def _forked(
        self,
        items: list[Any],
        mutant: tuple[Path, dict[str, types.CodeType]] | None = None,
        *,
        used: Path | None = None,
        limits: Sequence[float] = (),
    ) -> int:
        """How a process ends that runs tests up to the first failure.

        used: file of what each test runs.
        limits: processor time of each test [s].
        """
        sys.stdout.flush()
        with warnings.catch_warnings():  # of other threads, of which there are none that hold a lock
            warnings.simplefilter("ignore", DeprecationWarning)
            process = os.fork()
        if process == 0:
            end = KILLED
            try:
                os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
                os.dup2(1, 2)
                if mutant is not None:
                    put_in(*mutant)
                    clear_caches()
                files, runs = set(map(str, self.only)), []
                hard = resource.getrlimit(resource.RLIMIT_CPU)[1]
                for item, after, limit in itertools.zip_longest(items, items[1:], limits):
                    names, clock = set[str](), time.process_time()
                    if limit is not None:
                        resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(clock + limit), hard))
                        signal.alarm(math.ceil(WAITING * limit))

                    def note(frame: types.FrameType, event: str, _: object) -> None:
                        if event == "call" and frame.f_code.co_filename in files:
                            names.add(frame.f_code.co_qualname)  # noqa: B023

                    if used is not None:
                        clear_caches()
                        sys.setprofile(note)
                        threading.setprofile(note)
                    passed = _passes(item, after)
                    runs.append((time.process_time() - clock, sorted(names)))
                    if not passed:
                        break
                else:
                    end = SURVIVED
                if used is not None:
                    used.write_text(json.dumps(runs), encoding="utf-8")
            finally:
                os._exit(end)
        _, status = os.waitpid(process, 0)
        return os.waitstatus_to_exitcode(status)


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
