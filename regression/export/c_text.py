"""A formula as C99."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import ClassVar

from regression.export.data_functions import RESULTS
from regression.export.printer import ATOM, LIBRARY, OR, Printer, assignments, broken, commented, number_rows, packed
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
_HELPERS = (
    "static double larger(double a, double b) { return a > b || isnan(a) ? a : b; }",
    "static double smaller(double a, double b) { return a < b || isnan(a) ? a : b; }",
)


_LOOPS = {
    "networks": """
typedef struct { double of[6]; } networks_results;

static void layer(const double *restrict weights, int size, int units, const double *restrict x, double *restrict z)
{
    for (int k = 0; k < units; k++) {
        double sum = weights[size * units + k];
        for (int i = 0; i < size; i++) sum += weights[i * units + k] * x[i];
        z[k] = STEP * sum;
    }
}

static void hidden(const double *weights, int size, const double *x, double *z)
{
    layer(weights, size, UNITS, x, z);
    for (int k = 0; k < UNITS; k++) z[k] /= sqrt(1.0 + z[k] * z[k]);
}

static networks_results networks(const double logarithms[])
{
    networks_results r = {{1.0, 0.0, 0.0, 0.0, 0.0, 0.0}};
    double x[SIZE], one[UNITS], two[UNITS], out[MEMBERS][2];
    for (int i = 0; i < SIZE; i++) {
        const double low = networks_scales[2][i], high = networks_scales[3][i], reach = FADE * (high - low);
        x[i] = (smaller(larger(logarithms[i], -1e3), 1e3) - networks_scales[0][i]) / networks_scales[1][i];
        r.of[0] = smaller(r.of[0], 1.0 - larger(low - x[i], x[i] - high) / reach);
        x[i] = smaller(larger(x[i], low - reach), high + reach);
    }
    r.of[0] = larger(r.of[0], 0.0);
    r.of[0] *= r.of[0] * (3.0 - 2.0 * r.of[0]);
    for (int m = 0; m < MEMBERS; m++) {
        hidden(networks_weights[m], SIZE, x, one);
        hidden(networks_weights[m] + FIRST, UNITS, one, two);
        layer(networks_weights[m] + SECOND, UNITS, 2, two, out[m]);
        for (int i = 0; i < 2; i++) r.of[1 + i] += out[m][i] / MEMBERS;
    }
    for (int m = 0; m < MEMBERS; m++) {
        const double a = out[m][0] - r.of[1], b = out[m][1] - r.of[2], squares[3] = {a * a, a * b, b * b};
        for (int i = 0; i < 3; i++) r.of[3 + i] += squares[i] / MEMBERS;
    }
    return r;
}
""",
    "guard": """
typedef struct { double of[3]; } guard_results;

static guard_results guard(const double logarithms[])
{
    guard_results r = {{INFINITY, 0.0, INFINITY}};
    double c[SIZE], u[SIZE], z[SIZE], squares[CASES];
    for (int i = 0; i < SIZE; i++) {
        c[i] = smaller(larger(logarithms[i], -1e3), 1e3) - guard_scales[0][i];
        u[i] = c[i] / guard_scales[1][i];
        z[i] = 0.0;
        for (int k = 0; k <= i; k++) z[i] += guard_whitening[i][k] * c[k];
        r.of[1] += z[i] * z[i];
    }
    for (int j = 0; j < CASES; j++) {
        squares[j] = 0.0;
        for (int i = 0; i < SIZE; i++) {
            const double way = z[i] - STEP * guard_cases[i][j];
            squares[j] += way * way;
        }
    }
    for (int j = 0; j < CASES; j++) r.of[0] = squares[j] < r.of[0] ? squares[j] : r.of[0];
    for (int j = 0; j < PAIRS; j++) {
        const int *row = guard_limits[j];
        const double sum = u[row[0]] + u[row[1]], apart = u[row[0]] - u[row[1]];
        const double ends[4] = {sum - STEP * row[2], STEP * row[3] - sum, apart - STEP * row[4], STEP * row[5] - apart};
        for (int i = 0; i < 4; i++) r.of[2] = ends[i] < r.of[2] ? ends[i] : r.of[2];
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
            kind = "int" if name == "limits" else "double"
            lines.append(f"static const {kind} {function.name}_{name}[{len(rows)}][{len(rows[0])}] = {{")
            lines += [number_rows(rows, "    "), "};"]
        lines.append(function.filled(_LOOPS[function.name]))
    return lines


def c_text(program: Program, name: str) -> str:
    """One function and the struct it returns; compiles with C99 or later and needs the mathematical library."""
    printer = CPrinter(name)
    arguments = ", ".join(f"double {argument.name}" for argument in program.arguments)
    lines = [commented(program, " *").replace(" *", "/*", 1)]
    lines += [
        f" * cc -O3 -fno-math-errno -c {name}.c, link with -lm; not -ffast-math, which takes NaN out of the language.",
        " */",
        "",
    ]
    lines += ["#include <math.h>", f"typedef struct {{ double mu, lower, upper; int flag; }} {name}_result;", ""]
    lines += _HELPERS
    lines += _data_functions(program)
    lines += ["", broken(f"{name}_result {name}({arguments})", ""), "{"]
    statements = []
    for variable, expression, value in assignments(program, printer):
        kind = "int" if value.logical or variable == "flag" else "double"
        kind = f"{value.operation}_results" if value.operation in RESULTS else kind
        cast = f"(int)({expression})" if variable == "flag" else expression
        statements.append(f"const {kind} {variable} = {cast};")
    lines += packed(statements, "    ", kind="const double ")
    lines += [f"    return ({name}_result){{{', '.join(OUTPUTS)}}};", "}", ""]
    return "\n".join(lines)
