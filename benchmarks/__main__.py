"""One place for all benchmarks.

``python -m benchmarks`` lists them. ``python -m benchmarks NAME ...`` runs one with its own arguments (``--help``).
``python -m benchmarks figures [NAME ...]`` draws the figures of the documentation anew, hours for all, and
writes one table of what ran, how long and how it ended. ``python -m benchmarks counts`` compares the work of fixed
tasks with the stored baseline, in seconds.
"""

from __future__ import annotations

import ast
import importlib
import sys
import time
from collections.abc import Sequence
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "tests")]  # benchmarks share scenes and second algorithms with tests

from common import OUT, command_line, one_of, write_rows  # noqa: E402

FIGURES = {
    **dict.fromkeys(("app.png", "app_phone.png"), ("app_response", "--out", "docs/figures")),
    "comparison.png": ("report_figures", "comparison"),
    "report_gear.png": ("report_figures", "gear"),
    "gear_load_time.png": ("gear_load_time", "docs/figures"),
    "low_slip.png": ("low_slip", "docs/figures"),
    **dict.fromkeys(
        ("measured_film.png", "measured_low_slip.png", "measured_oils.png"), ("measured", "--out", "docs/figures")
    ),
    **dict.fromkeys(("optimise_report.png", "optimise_trade.png"), ("optimise", "page")),
    "root_stress_fem.png": ("root_stress_fem", "docs/figures"),
    "smooth_accuracy.png": ("smooth_accuracy", "--out", "docs/figures"),
    "step.png": ("step_picture", "docs/figures"),
    "stress_wide.png": ("stress", "--out", "docs/figures"),
    "tooth_compliance.png": ("compliance_fem", "docs/figures"),
    "waviness.png": ("mixed_validation", "waviness", "--out", "docs/figures"),
    "work_precision.png": ("work_precision", "--out", "docs/figures"),
}


def benchmarks() -> dict[str, str]:
    """First line of the head of every benchmark, by name; modules without ``main`` are parts of others."""
    found = {}
    for path in sorted(HERE.glob("[a-z]*.py")):
        module = ast.parse(path.read_text(encoding="utf-8"))
        if any(isinstance(node, ast.FunctionDef) and node.name == "main" for node in module.body):
            found[path.stem] = (ast.get_docstring(module) or "").partition("\n")[0]
    return found


def run(name: str, arguments: Sequence[str]) -> int:
    """Run one benchmark; its exit code."""
    code = importlib.import_module(name).main(list(arguments))
    return code if isinstance(code, int) else 0


def draw(names: Sequence[str]) -> int:
    """Draw figures of the documentation; a benchmark that fails does not keep the others from theirs."""
    rows = []
    for name in names or FIGURES:
        benchmark, *arguments = FIGURES[name]
        clock, code = time.perf_counter(), 1
        try:
            code = run(benchmark, arguments)
        except (Exception, SystemExit) as error:
            print(f"{name}: {error!r}", file=sys.stderr)
        seconds = round(time.perf_counter() - clock, 1)
        rows.append({"figure": name, "benchmark": " ".join(FIGURES[name]), "seconds": seconds, "exit code": code})
        write_rows(OUT / "figures.csv", rows)
    for row in rows:
        print(*row.values(), sep="  ")
    return max(int(row["exit code"]) for row in rows)


def main(argv: Sequence[str]) -> int:
    """List, run or draw."""
    listed = benchmarks()
    if not argv:
        for name, about in listed.items():
            print(f"{name:22} {about}")
        return 0
    parser = command_line(__doc__)
    parser.add_argument("what", choices=[*listed, "figures"], metavar="NAME")
    what = parser.parse_args(argv[:1]).what
    if what != "figures":
        return run(what, argv[1:])
    parser = command_line(draw.__doc__)
    parser.add_argument("names", nargs="*", type=one_of(FIGURES), metavar="FIGURE")
    return draw(parser.parse_args(argv[1:]).names)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
