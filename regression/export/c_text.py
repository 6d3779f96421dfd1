"""A formula as C99."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import ClassVar

from regression.export.data_functions import NAMES
from regression.export.printer import ATOM, LIBRARY, OR, Printer, assignments, broken, commented
from regression.export.program import OUTPUTS, Program

_RESERVED = frozenset(
    {
        *("auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum"),
        *("extern", "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return"),
        *("short", "signed", "sizeof", "static", "struct", "switch", "typedef", "union", "unsigned", "void"),
        *("volatile", "while", "pow", "result", "distance", "matern"),
    }
)


class CPrinter(Printer):
    """Expressions of doubles with the functions of math.h."""

    functions: ClassVar[Mapping[str, str]] = {**LIBRARY, "absolute": "fabs"}
    both, either, opposite = " && ", " || ", "!"
    infinite, undefined = "INFINITY", "NAN"
    reserved = _RESERVED

    def power(self, base: tuple[str, int], exponent: tuple[str, int]) -> tuple[str, int]:
        """pow(base, exponent)."""
        # alone between commas a negative number needs no brackets
        right = re.sub(r"^\((-[\w.+-]+)\)$", r"\1", exponent[0])
        return f"pow({base[0]}, {right})", ATOM

    def function(self, name: str, arguments: Sequence[str]) -> str:
        """A call; coordinates of functions over stored rows go as one array."""
        if name in NAMES:
            return f"{name}((const double[]){{{', '.join(arguments)}}})"
        return super().function(name, arguments)

    def choose(self, condition: str, yes: str, no: str) -> tuple[str, int]:
        """The conditional operator, in brackets wherever it is an operand."""
        return f"({condition}) ? {yes} : ({no})" if "?" in no else f"({condition}) ? {yes} : {no}", OR - 1


# NaN goes through, as in numpy: fmax and fmin would hide it
_HELPERS = {
    "maximum": "static double larger(double a, double b) { return a > b || isnan(a) ? a : b; }",
    "minimum": "static double smaller(double a, double b) { return a < b || isnan(a) ? a : b; }",
}


_LOOPS = {
    "gp_mean": """
static double gp_mean(const double x[])
{
    double total = 0.0;
    for (int j = 0; j < ROWS; j++) {
        total += gp_mean_rows[j][SIZE] * matern(x, gp_mean_rows[j], SIZE);
    }
    return total;
}
""",
    "gp_reduction": """
static double gp_reduction(const double x[])
{
    double covariance[ROWS], total = 0.0;
    for (int j = 0; j < ROWS; j++) {
        covariance[j] = matern(x, gp_reduction_rows[j], SIZE);
    }
    for (int i = 0; i < ROWS; i++) {
        double spread = 0.0;
        for (int j = 0; j < ROWS; j++) {
            spread += covariance[j] * gp_reduction_rows[j][SIZE + i];
        }
        total += spread * spread;
    }
    return total;
}
""",
    "case_distance": """
static double case_distance(const double x[])
{
    double least = INFINITY;
    for (int j = 0; j < ROWS; j++) {
        const double r = distance(x, case_distance_rows[j], SIZE);
        least = r < least || isnan(r) ? r : least;
    }
    return least;
}
""",
    "hull_margin": """
static double hull_margin(const double x[])
{
    double least = INFINITY;
    for (int j = 0; j < ROWS; j++) {
        const double *row = hull_margin_rows[j];
        const double margin = row[2] * x[(int)row[0]] + row[3] * x[(int)row[1]] + row[4];
        least = margin < least ? margin : least;
    }
    return least;
}
""",
}
_DISTANCE = """
static double distance(const double x[], const double z[], int size)
{
    double square = 0.0;
    for (int i = 0; i < size; i++) {
        square += (x[i] - z[i]) * (x[i] - z[i]);
    }
    return sqrt(square);
}
"""
_MATERN = """
static double matern(const double x[], const double z[], int size)
{
    const double a = sqrt(5.0) * distance(x, z, size);
    return (1.0 + a + a * a / 3.0) * exp(-a);
}
"""


def _data_functions(program: Program) -> list[str]:
    names = {function.kind for function in program.data_functions}
    lines = [_DISTANCE] * bool(names - {"hull_margin"}) + [_MATERN] * bool(names & {"gp_mean", "gp_reduction"})
    for function in program.data_functions:
        count, width = function.rows.shape
        rows = ",\n".join(broken(f"{{{', '.join(map(repr, row))}}}", "    ") for row in function.rows.tolist())
        lines += [f"static const double {function.name}_rows[{count}][{width}] = {{", rows, "};"]
        lines += [function.code(_LOOPS).replace("ROWS", str(count)).replace("SIZE", str(function.size))]
    return lines


def c_text(program: Program, name: str) -> str:
    """One function and the struct it returns; compiles with C99 or later and needs the mathematical library."""
    printer = CPrinter(name)
    arguments = ",\n    ".join(f"double {argument.name}" for argument in program.arguments)
    lines = [commented(program, " *").replace(" *", "/*", 1), " *"]
    lines += [
        f" * cc -O2 -c {name}.c, link with -lm; without -ffast-math, which takes NaN out of the language.",
        " */",
        "",
    ]
    lines += ["#include <math.h>", "", "typedef struct {", "    double mu, lower, upper;", "    int flag;"]
    lines += [f"}} {name}_result;", ""]
    lines += [text for operation, text in _HELPERS.items() if operation in program.operations]
    lines += _data_functions(program)
    lines += ["", f"{name}_result {name}(\n    {arguments})", "{"]
    lines += [
        f"    const double {printer.variable(value.name)} = {printer.number(value.number)};"
        for value in program.coefficients
    ]
    values = dict(zip((step.name for step in program.steps), assignments(program, printer), strict=True))
    for step in program.steps:
        variable, expression = values[step.name]
        kind = "int" if step.logical or step.name == "flag" else "double"
        cast = f"(int)({expression})" if step.name == "flag" else expression
        lines.append(broken(f"const {kind} {variable} = {cast};", "    "))
    lines += [f"    const {name}_result result = {{{', '.join(OUTPUTS)}}};", "    return result;", "}", ""]
    return "\n".join(lines)
