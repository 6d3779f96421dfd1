"""A formula as C99."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import ClassVar

from regression.export.data_functions import RESULTS
from regression.export.printer import ATOM, LIBRARY, OR, Printer, assignments, broken, commented, number_rows
from regression.export.program import OUTPUTS, Program

_RESERVED = frozenset(
    {
        *("auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum"),
        *("extern", "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return"),
        *("short", "signed", "sizeof", "static", "struct", "switch", "typedef", "union", "unsigned", "void"),
        *("volatile", "while", "pow", "result", "unit"),
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
        if name in RESULTS:
            return f"{name}((const double[]){{{', '.join(arguments)}}})"
        return super().function(name, arguments)

    def item(self, name: str, place: int) -> str:
        """A number of the structure that functions over stored numbers return."""
        return f"{name}.of[{place}]"

    def choose(self, condition: str, yes: str, no: str) -> tuple[str, int]:
        """The conditional operator, in brackets wherever it is an operand."""
        return f"({condition}) ? {yes} : ({no})" if "?" in no else f"({condition}) ? {yes} : {no}", OR - 1


# NaN goes through, as in numpy: fmax and fmin would hide it
_HELPERS = {
    "maximum": "static double larger(double a, double b) { return a > b || isnan(a) ? a : b; }",
    "minimum": "static double smaller(double a, double b) { return a < b || isnan(a) ? a : b; }",
}


_LOOPS = {
    "networks": """
typedef struct { double of[6]; } networks_results;

static double unit(const int **row, const double x[], int size)
{
    double z = STEP * (*row)[size];
    for (int i = 0; i < size; i++) z += STEP * (*row)[i] * x[i];
    *row += size + 1;
    return z;
}

static networks_results networks(const double logarithms[])
{
    networks_results r = {{1.0, 0.0, 0.0, 0.0, 0.0, 0.0}};
    double x[SIZE], a[MEMBERS], b[MEMBERS];
    for (int i = 0; i < SIZE; i++) {
        const double low = networks_scales[2][i], high = networks_scales[3][i], reach = FADE * (high - low);
        const double clipped = fmin(fmax(logarithms[i], -1e3), 1e3);
        x[i] = (clipped - networks_scales[0][i]) / networks_scales[1][i];
        r.of[0] = fmin(r.of[0], 1.0 - fmax(low - x[i], x[i] - high) / reach);
        x[i] = fmin(fmax(x[i], low - reach), high + reach);
    }
    r.of[0] = fmax(r.of[0], 0.0);
    r.of[0] = r.of[0] * r.of[0] * (3.0 - 2.0 * r.of[0]);
    const int *row = networks_weights[0];
    for (int m = 0; m < MEMBERS; m++) {
        double one[UNITS], two[UNITS];
        for (int i = 0; i < UNITS; i++) {
            one[i] = unit(&row, x, SIZE);
            one[i] /= sqrt(1.0 + one[i] * one[i]);
        }
        for (int i = 0; i < UNITS; i++) {
            two[i] = unit(&row, one, UNITS);
            two[i] /= sqrt(1.0 + two[i] * two[i]);
        }
        a[m] = unit(&row, two, UNITS);
        b[m] = unit(&row, two, UNITS);
        r.of[1] += a[m] / MEMBERS;
        r.of[2] += b[m] / MEMBERS;
    }
    for (int m = 0; m < MEMBERS; m++) {
        const double da = a[m] - r.of[1], db = b[m] - r.of[2];
        r.of[3] += da * da / MEMBERS;
        r.of[4] += da * db / MEMBERS;
        r.of[5] += db * db / MEMBERS;
    }
    return r;
}
""",
    "guard": """
typedef struct { double of[3]; } guard_results;

static guard_results guard(const double logarithms[])
{
    guard_results r = {{INFINITY, 0.0, INFINITY}};
    double c[SIZE], u[SIZE], z[SIZE];
    for (int i = 0; i < SIZE; i++) {
        c[i] = fmin(fmax(logarithms[i], -1e3), 1e3) - guard_scales[0][i];
        u[i] = c[i] / guard_scales[1][i];
        z[i] = 0.0;
        for (int k = 0; k <= i; k++) z[i] += guard_whitening[i][k] * c[k];
        r.of[1] += z[i] * z[i];
    }
    for (int j = 0; j < CASES; j++) {
        double square = 0.0;
        for (int i = 0; i < SIZE; i++) {
            const double way = z[i] - STEP * guard_cases[j][i];
            square += way * way;
        }
        r.of[0] = fmin(r.of[0], square);
    }
    for (int j = 0; j < PAIRS; j++) {
        const int *row = guard_limits[j];
        const double sum = u[row[0]] + u[row[1]], apart = u[row[0]] - u[row[1]];
        r.of[2] = fmin(r.of[2], fmin(sum - STEP * row[2], STEP * row[3] - sum));
        r.of[2] = fmin(r.of[2], fmin(apart - STEP * row[4], STEP * row[5] - apart));
    }
    r.of[0] = sqrt(r.of[0]);
    r.of[1] = sqrt(r.of[1]);
    return r;
}
""",
}


def _data_functions(program: Program) -> list[str]:
    lines = []
    for function in program.data_functions:
        for name, rows in function.arrays.items():
            kind = "int" if isinstance(rows[0][0], int) else "double"
            lines.append(f"static const {kind} {function.name}_{name}[{len(rows)}][{len(rows[0])}] = {{")
            lines += [number_rows(rows, "    "), "};"]
        lines.append(function.filled(_LOOPS[function.name]))
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
        kind = f"{step.operation}_results" if step.operation in RESULTS else kind
        cast = f"(int)({expression})" if step.name == "flag" else expression
        lines.append(broken(f"const {kind} {variable} = {cast};", "    "))
    lines += [f"    const {name}_result result = {{{', '.join(OUTPUTS)}}};", "    return result;", "}", ""]
    return "\n".join(lines)
