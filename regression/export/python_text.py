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
        lines.append(function.loop("_numpy.txt"))
    return lines


def python_text(program: Program, name: str) -> str:
    """The module; its function takes numbers or arrays that broadcast."""
    printer = PythonPrinter(name)
    parameters = ", ".join(program.arguments)
    lines = [commented(program, "#"), "", "import numpy as np", ""]
    lines += _data_functions(program)
    lines += ["", broken(f"def {name}({parameters}):", "")]
    lines += [f'    """{", ".join(OUTPUTS)} as described above; numbers or arrays."""']
    lines += [broken(f"{parameters} = (np.asarray(given, dtype=float) for given in ({parameters}))", "    ", end=" \\")]
    lines += ['    with np.errstate(all="ignore"):']
    statements = [f"{variable} = {expression};" for variable, expression, _ in assignments(program, printer)]
    lines += [line.removesuffix(";") for line in packed(statements, "        ", " \\")]
    mu, lower, upper, flag = printer.outputs
    lines += [f"    return {mu}[()], {lower}[()], {upper}[()], {flag}.astype(int)[()]", ""]
    return "\n".join(lines)
