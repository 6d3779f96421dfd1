"""A formula as C99."""

import re
from collections.abc import Mapping, Sequence
from typing import ClassVar

from regression.export.printer import ATOM, LIBRARY, OR, Printer, assignments, broken, commented, number_rows, packed
from regression.export.program import RESULTS, Program

_RESERVED = frozenset(
    {
        *("auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum"),
        *("extern", "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return"),
        *("short", "signed", "sizeof", "static", "struct", "switch", "typedef", "union", "unsigned", "void"),
        *("volatile", "while", "pow", "power", "half_cube", "square", "at_least", "at_most", "result", "unit"),
    }
)
_SQUARES = {"2.0": 1, "4.0": 2, "8.0": 3}  # exponents, and how many times the base is squared
_NUMBER, _WHOLE = r"-?[\d.]+(e[+-]?\d+)?", r"-?\d+\.0"


class CPrinter(Printer):
    """Expressions of doubles with the functions of math.h."""

    functions: ClassVar[Mapping[str, str]] = {**LIBRARY, "absolute": "fabs"}
    both, either, opposite = " && ", " || ", "!"
    infinite, undefined = "INFINITY", "NAN"
    array, element = ("(const double[]){", "}"), "{}.of[{}]"
    reserved = _RESERVED

    def power(self, base: tuple[str, int], exponent: tuple[str, int]) -> tuple[str, int]:
        """Squares, the power 1.5 by the root, pow for other whole exponents, else by logarithms."""
        # alone between commas a negative number needs no brackets
        left, right = base[0], re.sub(r"^\((-[\w.+-]+)\)$", r"\1", exponent[0])
        if right == "1.5":
            return f"half_cube({left})", ATOM
        if right in _SQUARES:
            return "square(" * _SQUARES[right] + left + ")" * _SQUARES[right], ATOM
        return f"{'pow' if re.fullmatch(_WHOLE, right) else 'power'}({left}, {right})", ATOM

    def function(self, name: str, arguments: Sequence[str]) -> str:
        """A call; maximum and minimum of a number and a constant are short functions."""
        if name in ("maximum", "minimum") and re.fullmatch(_NUMBER, arguments[1]):
            name = {"maximum": "at_least", "minimum": "at_most"}[name]
        return super().function(name, arguments)

    def choose(self, condition: str, yes: str, no: str) -> tuple[str, int]:
        """The conditional operator, in brackets wherever it is an operand."""
        return f"({condition}) ? {yes} : ({no})" if "?" in no else f"({condition}) ? {yes} : {no}", OR - 1


# NaN goes through, as in numpy: fmax and fmin would hide it. The first two are one instruction; NaN of a second number
# is lost, which is a constant or comes with that of the first. A power by logarithms takes half the time of pow.
_HELPERS = (
    "/* loops for processors with FMA too, chosen when the program starts */",
    "#if defined(__x86_64__) && defined(__GLIBC__) && defined(__has_attribute)",
    "#if __has_attribute(target_clones)",
    '#define CLONES __attribute__((target_clones("fma", "default")))',
    "#endif",
    "#endif",
    "#ifndef CLONES",
    "#define CLONES",
    "#endif",
    "static double at_least(double a, double b) { return b > a ? b : a; }",
    "static double at_most(double a, double b) { return b < a ? b : a; }",
    "static double larger(double a, double b) { return a > b || isnan(a) ? a : b; }",
    "static double smaller(double a, double b) { return a < b || isnan(a) ? a : b; }",
    "static double square(double a) { return a * a; }",
    "static double half_cube(double a) { return a * sqrt(a); }",
    "static double power(double a, double b) { return exp(b * log(a)); }",
)


def _data_functions(program: Program) -> list[str]:
    lines = []
    for function in program.data_functions:
        for name, rows in function.arrays.items():
            kind = "int" if name == "limits" else "double"
            lines.append(f"static const {kind} {function.name}_{name}[{len(rows)}][{len(rows[0])}] = {{")
            lines += [number_rows(rows, "    "), "};"]
        lines.append(function.loop(".c").rstrip())
    return lines


def c_text(program: Program, name: str) -> str:
    """One function and the struct it returns; compiles with C99 or later and needs the mathematical library."""
    printer = CPrinter(name)
    arguments = ", ".join(f"double {name}" for name in program.arguments)
    lines = [commented(program, " *").replace(" *", "/*", 1)]
    lines += [
        f" * cc -O3 -fno-math-errno -c {name}.c, link with -lm; not -ffast-math, which takes NaN out of the language.",
        " */",
    ]
    lines += ["#include <math.h>", f"typedef struct {{ double mu, lower, upper; int flag; }} {name}_result;", ""]
    lines += _HELPERS
    lines += _data_functions(program)
    lines += ["", broken(f"{name}_result {name}({arguments})", ""), "{"]
    statements = []
    for variable, expression, value in assignments(program, printer):
        kind = "int" if value.logical or value.name == "flag" else "double"
        kind = f"{value.operation}_results" if value.operation in RESULTS else kind
        cast = f"(int)({expression})" if value.name == "flag" else expression
        statements.append(f"const {kind} {variable} = {cast};")
    lines += packed(statements, "    ", kind="const double ")
    lines += [f"    return ({name}_result){{{', '.join(printer.outputs)}}};", "}", ""]
    return "\n".join(lines)
