"""A formula as a Python module that needs numpy only."""

from collections.abc import Mapping
from typing import ClassVar

from regression.export.printer import ATOM, Printer, assignments, broken, commented, number_rows, packed
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
    mean, scale, low, high = NETWORKS_SCALES[:, :, None]
    reach = FADE * (high - low)
    x, shape = rows(logarithms)
    x = (x - mean) / scale
    fading = np.clip(1.0 - np.max(np.maximum(low - x, x - high) / reach, axis=0), 0.0, 1.0)
    x = np.clip(x, low - reach, high + reach)
    one, outputs = squashed(layer(NETWORKS_FIRST, x)), []
    for m in range(MEMBERS):
        own = slice(m * UNITS, (m + 1) * UNITS)
        two = squashed(layer(NETWORKS_SECOND[:, own], one[own]))
        outputs.append(STEP * layer(NETWORKS_LAST[:, 2 * m : 2 * m + 2], two))
    a, b = np.moveaxis(np.array(outputs), 1, 0)
    p, q = a - a.mean(axis=0), b - b.mean(axis=0)
    spread = ((p * p).mean(axis=0), (p * q).mean(axis=0), (q * q).mean(axis=0))
    found = fading * fading * (3.0 - 2.0 * fading), a.mean(axis=0), b.mean(axis=0), *spread
    return [part.reshape(shape) for part in found]


def layer(weights, x):
    return weights[:-1].T @ x + weights[-1][:, None]


def squashed(z):
    return STEP * z / np.sqrt(1.0 + (STEP * z) ** 2)
""",
    "guard": """
def guard(*logarithms):
    x, shape = rows(logarithms)
    centred = x - GUARD_SCALES[0][:, None]
    u, z = centred / GUARD_SCALES[1][:, None], GUARD_WHITENING @ centred
    least = np.min([np.sum((z - STEP * case[:, None]) ** 2, axis=0) for case in GUARD_CASES.T], axis=0)
    margin = np.inf
    for i, k, *ends in GUARD_LIMITS:
        low, high, small, large = (STEP * end for end in ends)
        for value, one, other in ((u[i] + u[k], low, high), (u[i] - u[k], small, large)):
            margin = np.minimum(margin, np.minimum(value - one, other - value))
    return [part.reshape(shape) for part in (np.sqrt(least), np.sqrt(np.sum(z * z, axis=0)), margin)]
""",
}
_ROWS = """
def rows(logarithms):
    x = np.clip(np.array(np.broadcast_arrays(*logarithms)), -1e3, 1e3)
    return x.reshape(len(x), -1), x.shape[1:]
"""


def _data_functions(program: Program) -> list[str]:
    lines = [_ROWS] if program.data_functions else []
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
    lines += ['    with np.errstate(all="ignore"):']
    statements = [f"{variable} = {expression};" for variable, expression, _ in assignments(program, printer)]
    lines += [line.removesuffix(";") for line in packed(statements, "        ", " \\")]
    lines += ["    return mu[()], lower[()], upper[()], flag.astype(int)[()]", ""]
    return "\n".join(lines)
