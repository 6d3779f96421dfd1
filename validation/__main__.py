"""Figures and tables of the documentation, and data made from the program: one script each.

``python -m validation`` lists the scripts, ``python -m validation NAME ...`` runs one with its own arguments.
``python -m validation figures [NAME ...]`` draws figures of the documentation, hours for all, and writes one table of
what ran, how long and how it ended; ``figures --list`` lists them. ``check`` reads the arguments of every script.
"""

from __future__ import annotations

import ast
import contextlib
import importlib
import io
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from common import OUT, command_line, one_of, write_rows  # noqa: E402

TWINS = str(HERE.parent / "tests" / "twins")  # second algorithms are scripts of their own
FIGURES = {
    **dict.fromkeys(("app.png", "app_phone.png"), ("app_response.py", "--out", "docs/figures")),
    "axle_maps.png": ("axle_maps.py",),
    "comparison.png": ("report_figures.py", "comparison"),
    "report_gear.png": ("report_figures.py", "gear"),
    "friction_work.png": ("friction_work.py", "--out", "docs/figures"),
    "gear_load_time.png": ("gear_load_time.py",),
    "low_slip.png": ("low_slip.py", "docs/figures"),
    **dict.fromkeys(("measured_film.png", "measured_low_slip.png", "measured_oils.png"), ("measured.py",)),
    **dict.fromkeys(("optimise_report.png", "optimise_trade.png"), ("report_figures.py", "optimise")),
    "smooth_accuracy.png": ("smooth_accuracy.py", "--out", "docs/figures"),
    "step.png": ("step_picture.py", "docs/figures"),
    "tooth_compliance.png": (f"{TWINS}/compliance_fem.py",),
    "waviness.png": (f"{TWINS}/waviness.py",),
    "work_precision.png": ("work_precision.py", "--out", "docs/figures"),
}


def scripts() -> dict[str, str]:
    """First line of the head of every script, by name; modules without ``main`` are parts of others."""
    found = {}
    for path in sorted(HERE.glob("[a-z]*.py")):
        module = ast.parse(path.read_text(encoding="utf-8"))
        if any(isinstance(node, ast.FunctionDef) and node.name == "main" for node in module.body):
            found[path.stem] = (ast.get_docstring(module) or "").partition("\n")[0]
    return found


def draw(names: Sequence[str]) -> int:
    """Draw figures, each script in a process of its own."""
    rows = []
    for script, *arguments in dict.fromkeys(FIGURES[name] for name in names or FIGURES):
        clock = time.perf_counter()
        command = [sys.executable, str(HERE / script), *arguments]
        code = subprocess.run(command, env=os.environ | {"PYTHONPATH": str(HERE.parent / "tests")}).returncode
        seconds = round(time.perf_counter() - clock, 1)
        rows.append({"script": " ".join([Path(script).name, *arguments]), "seconds": seconds, "exit code": code})
        write_rows(OUT / "figures.csv", rows)
    for row in rows:
        print(*row.values(), sep="  ")
    return max(int(row["exit code"]) for row in rows)


def check() -> int:
    """Whether every script states its subject and reads its arguments; the number of those that do not."""
    wrong = []
    for name, about in scripts().items():
        code: object = None
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            try:
                importlib.import_module(name).main(["--help"])
            except SystemExit as end:
                code = end.code
        if code != 0 or not 20 < len(about) <= 120 or about.split()[0] not in printed.getvalue():
            wrong.append(name)
    print("wrong:", *wrong)
    return len(wrong)


def main(argv: Sequence[str]) -> int:
    """List, run or draw."""
    listed = scripts()
    if not argv:
        for name, about in listed.items():
            print(f"{name:22} {about}")
        return 0
    parser = command_line(__doc__)
    parser.add_argument("what", choices=[*listed, "figures", "check"], metavar="NAME")
    what = parser.parse_args(argv[:1]).what
    if what == "check":
        return check()
    if what != "figures":
        code = importlib.import_module(what).main(list(argv[1:]))
        return code if isinstance(code, int) else 0
    parser = command_line(draw.__doc__)
    parser.add_argument("names", nargs="*", type=one_of(FIGURES), metavar="FIGURE")
    parser.add_argument("--list", action="store_true")
    given = parser.parse_args(argv[1:])
    if given.list:
        print(*FIGURES, sep="\n")
        return 0
    return draw(given.names)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
