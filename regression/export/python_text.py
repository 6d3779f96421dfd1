"""A formula as a Python module that needs numpy only."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from regression.export.printer import ATOM, Printer, assignments, broken, commented, number_rows
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
    reserved = frozenset({"np", "math", "def", "is", "in", "if", "as", "lambda", "from", "for"})

    def comparison(self, operation: str, left: str, right: str) -> tuple[str, int]:
        """In brackets: & and | bind tighter than a comparison."""
        return f"({super().comparison(operation, left, right)[0]})", ATOM


_LOOPS = {
    "networks": """
def networks(*logarithms):
    mean, scale, low, high = (np.array(row).reshape(-1, *[1] * np.ndim(logarithms[0])) for row in NETWORKS_SCALES)
    reach = FADE * (high - low)
    x = (np.clip(np.array(np.broadcast_arrays(*logarithms)), -1e3, 1e3) - mean) / scale
    fading = np.clip(1.0 - np.max(np.maximum(low - x, x - high) / reach, axis=0), 0.0, 1.0)
    x = np.clip(x, low - reach, high + reach)
    outputs, at = [], 0
    for _ in range(MEMBERS):
        values = x
        for units in (UNITS, UNITS, 2):
            rows = STEP * NETWORKS_WEIGHTS[0, at : at + units * (len(values) + 1)].reshape(units, -1)
            at += rows.size
            z = np.tensordot(rows[:, :-1], values, axes=1) + rows[:, -1].reshape(-1, *[1] * (x.ndim - 1))
            values = z if units == 2 else z / np.sqrt(1.0 + z * z)
        outputs.append(values)
    a, b = np.moveaxis(np.array(outputs), 1, 0)
    p, q = a - a.mean(axis=0), b - b.mean(axis=0)
    spread = ((p * p).mean(axis=0), (p * q).mean(axis=0), (q * q).mean(axis=0))
    return fading * fading * (3.0 - 2.0 * fading), a.mean(axis=0), b.mean(axis=0), *spread
""",
    "guard": """
def guard(*logarithms):
    shape = (-1, *[1] * np.ndim(logarithms[0]))
    mean, scale = (np.array(row).reshape(shape) for row in GUARD_SCALES)
    centred = np.clip(np.array(np.broadcast_arrays(*logarithms)), -1e3, 1e3) - mean
    u, z = centred / scale, np.tensordot(GUARD_WHITENING, centred, axes=1)
    least = np.min([np.sum((z - STEP * case.reshape(shape)) ** 2, axis=0) for case in GUARD_CASES], axis=0)
    margin = np.inf
    for i, k, *ends in GUARD_LIMITS:
        low, high, small, large = (STEP * end for end in ends)
        for value, one, other in ((u[i] + u[k], low, high), (u[i] - u[k], small, large)):
            margin = np.minimum(margin, np.minimum(value - one, other - value))
    return np.sqrt(least), np.sqrt(np.sum(z * z, axis=0)), margin
""",
}


def _data_functions(program: Program) -> list[str]:
    lines = []
    for function in program.data_functions:
        for name, rows in function.arrays.items():
            lines += [f"{function.name}_{name} = np.array([".upper().replace("NP.ARRAY", "np.array")]
            lines += [number_rows(rows, "    ", "[]"), "])"]
        lines.append(function.filled(_LOOPS[function.name]))
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
