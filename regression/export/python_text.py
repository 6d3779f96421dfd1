"""A formula as a Python module that needs numpy only."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from regression.export.printer import ATOM, Printer, assignments, broken, commented
from regression.export.program import OUTPUTS, Program
from regression.export.record import FUNCTIONS


class PythonPrinter(Printer):
    """numpy expressions, elementwise."""

    functions: ClassVar[Mapping[str, str]] = {
        **{name: f"np.{name}" for name in (*FUNCTIONS, "isfinite")},
        "choose": "np.where",
    }
    both, either, opposite = " & ", " | ", "~"
    infinite, undefined = "np.inf", "np.nan"
    reserved = frozenset({"np", "math", "def", "is", "in", "if", "as", "lambda", "from", "for", "distance", "matern"})

    def comparison(self, operation: str, left: str, right: str) -> tuple[str, int]:
        """In brackets: & and | bind tighter than a comparison."""
        return f"({super().comparison(operation, left, right)[0]})", ATOM


_LOOPS = {
    "gp_mean": """
def gp_mean(*x):
    return sum(row[-1] * matern(distance(row, x)) for row in GP_MEAN)
""",
    "gp_reduction": """
def gp_reduction(*x):
    covariance = np.array([matern(distance(row, x)) for row in GP_REDUCTION])
    spread = np.tensordot(GP_REDUCTION[:, len(x) :], covariance, axes=(0, 0))
    return np.sum(spread**2, axis=0)
""",
    "case_distance": """
def case_distance(*x):
    least = np.inf
    for row in CASE_DISTANCE:
        least = np.minimum(least, distance(row, x))
    return least
""",
    "hull_margin": """
def hull_margin(*x):
    least = np.inf
    for i, k, a, b, c in HULL_MARGIN:
        least = np.minimum(least, a * x[int(i)] + b * x[int(k)] + c)
    return least
""",
}
_SHARED = """
def distance(row, x):
    return np.sqrt(sum((part - place) ** 2 for part, place in zip(x, row)))


def matern(r):
    a = np.sqrt(5.0) * r
    return (1.0 + a + a**2 / 3.0) * np.exp(-a)
"""


def _data_functions(program: Program) -> list[str]:
    if not program.data_functions:
        return []
    lines = [_SHARED]
    for function in program.data_functions:
        rows = ",\n".join(broken(f"[{', '.join(map(repr, row))}]", "    ") for row in function.rows.tolist())
        lines += ["", f"{function.name.upper()} = np.array([", rows, "])", "", function.code(_LOOPS)]
    return lines


def python_text(program: Program, name: str) -> str:
    """The module; its function takes numbers or arrays that broadcast."""
    printer = PythonPrinter(name)
    parameters = ", ".join(argument.name for argument in program.arguments)
    lines = [commented(program, "#"), "", "import numpy as np", ""]
    lines += _data_functions(program)
    lines += ["", broken(f"def {name}({parameters}):", "")]
    lines += [f'    """{", ".join(OUTPUTS)} as described above; numbers or arrays."""']
    lines += [broken(f"{parameters} = (np.asarray(given, dtype=float) for given in ({parameters}))", "    ", end=" \\")]
    lines += [f"    {printer.variable(value.name)} = {printer.number(value.number)}" for value in program.coefficients]
    lines += ['    with np.errstate(all="ignore"):']
    for variable, expression in assignments(program, printer):
        statement = f"{variable} = {expression}"
        lines.append(broken(statement if len(statement) < 100 else f"{variable} = ({expression})", "        "))
    lines += ["    return mu[()], lower[()], upper[()], flag.astype(int)[()]", ""]
    return "\n".join(lines)
