"""A formula as C99."""

import re
from collections.abc import Collection, Mapping, Sequence
from typing import ClassVar

from regression.export.printer import ATOM, LIBRARY, OR, Printer, broken, commented, number_rows, packed
from regression.export.program import RESULTS, DataValue, Program, reached
from regression.export.record import Value

_RESERVED = frozenset(
    {
        *("auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum"),
        *("extern", "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return"),
        *("short", "signed", "sizeof", "static", "struct", "switch", "typedef", "union", "unsigned", "void"),
        *("volatile", "while", "pow", "power", "half_cube", "square", "at_least", "at_most", "result", "unit"),
        *("block", "least", "point", "results"),
    }
)
_SQUARES = {"2.0": 1, "4.0": 2, "8.0": 3}  # exponents, and how many times the base is squared
_NUMBER, _WHOLE = r"-?[\d.]+(e[+-]?\d+)?", r"-?\d+\.0"


class CPrinter(Printer):
    """Expressions of doubles with the functions of math.h."""

    functions: ClassVar[Mapping[str, str]] = {**LIBRARY, "absolute": "fabs"}
    both, either, opposite = " && ", " || ", "!"
    infinite, undefined = "INFINITY", "NAN"
    element = "{}[{} * n + p]"
    reserved = _RESERVED

    def __init__(self, function_name: str, arguments: Sequence[str] = (), arrays: Collection[str] = ()) -> None:
        """arguments, arrays: names of members of the points and of values stored for each point of a block."""
        self.arguments, self.arrays = arguments, arrays
        super().__init__(function_name)

    def variable(self, name: str) -> str:
        """A name; of a value of each point with the number p of the point."""
        if name in self.arguments:
            return f"at[p].{name}"
        return super().variable(name) + ("[p]" if name in self.arrays else "")

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
    "enum { BLOCK = 8 }; /* points that are evaluated at once */",
    "/* compiled for processors with FMA too, chosen when the program starts */",
    "#define CLONES",
    "#if defined(__x86_64__) && defined(__GLIBC__) && defined(__has_attribute)",
    "#if __has_attribute(target_clones)",
    "#undef CLONES",
    '#define CLONES __attribute__((target_clones("fma", "default")))',
    "#endif",
    "#endif",
    "/* n is a constant where the functions are used, 1 or BLOCK; loops over points are vectorized, not unrolled */",
    "#ifdef __GNUC__",
    "#define INLINE static inline __attribute__((always_inline))",
    '#define EACH_POINT _Pragma("GCC unroll 1") for (int p = 0; p < n; p++)',
    "#else",
    "#define INLINE static inline",
    "#define EACH_POINT for (int p = 0; p < n; p++)",
    "#endif",
    "INLINE double at_least(double a, double b) { return b > a ? b : a; }",
    "INLINE double at_most(double a, double b) { return b < a ? b : a; }",
    "INLINE double larger(double a, double b) { return a > b || isnan(a) ? a : b; }",
    "INLINE double smaller(double a, double b) { return a < b || isnan(a) ? a : b; }",
    "INLINE double square(double a) { return a * a; }",
    "INLINE double half_cube(double a) { return a * sqrt(a); }",
    "INLINE double power(double a, double b) { return exp(b * log(a)); }",
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


def _loops(program: Program) -> tuple[list[list[Value]], frozenset[str]]:
    """Steps of each loop over the points of a block, and the names of values that a later loop uses.

    A loop ends where functions over stored numbers are called, which are the last steps of it.
    """
    number: dict[Value, int] = {}
    for value in sorted(reached(program.steps), key=lambda value: value.serial):
        number[value] = max((number[o] + isinstance(o, DataValue) for o in value.operands), default=0)
    crossing = set()
    for step in program.steps:
        waiting = list(step.operands)
        while waiting:
            value = waiting.pop()
            if not value.name:
                waiting.extend(value.operands)
            elif value.operands and number[value] < number[step] and not isinstance(value, DataValue):
                crossing.add(value.name)
    loops: list[list[Value]] = [[] for _ in range(max(number.values()) + 1)]
    for step in sorted(program.steps, key=lambda step: isinstance(step, DataValue)):
        loops[number[step]].append(step)
    return loops, frozenset(crossing)


def _kind(step: Value) -> str:
    return "int" if step.logical or step.name == "flag" else "double"


def _block(program: Program, name: str) -> list[str]:
    """Function of the n points of a block."""
    loops, crossing = _loops(program)
    printer, plain = CPrinter(name, program.arguments, crossing), CPrinter(name)
    steps = [step for loop in loops for step in loop]
    declared = [f"const double {plain.variable(c.name)} = {plain.number(c.number)};" for c in program.coefficients]
    for kind in ("double", "int"):
        kept = [plain.variable(step.name) for step in steps if step.name in crossing and _kind(step) == kind]
        declared += [f"{kind} {', '.join(f'{variable}[BLOCK]' for variable in kept)};"] if kept else []
    for step in steps:
        if isinstance(step, DataValue):
            given, found = len(step.operands), RESULTS[step.operation]
            declared.append(f"double {step.name}_x[{given} * BLOCK], {step.name}[{found} * BLOCK];")
    lines = [f"INLINE void block(const int n, const {name}_point *at, {name}_result *results)", "{"]
    lines += packed(declared, "    ", kind="const double ")
    for loop in loops:
        statements, calls = [], []
        for step in loop:
            if isinstance(step, DataValue):
                for k, operand in enumerate(step.operands):
                    text = printer.variable(operand.name) if operand.name else printer.expression(operand)
                    statements.append(f"{step.name}_x[{k} * n + p] = {text};")
                calls.append(f"    {step.operation}(n, {step.name}_x, {step.name});")
                continue
            kind = "" if step.name in crossing else f"const {_kind(step)} "
            text = printer.expression(step)
            text = f"(int)({text})" if step.name == "flag" else text
            statements.append(f"{kind}{printer.variable(step.name)} = {text};")
        if loop is loops[-1]:
            statements.append(f"results[p] = ({name}_result){{{', '.join(printer.outputs)}}};")
        lines += ["    for (int p = 0; p < n; p++) {", *packed(statements, "        ", kind="const double "), "    }"]
        lines += calls
    return [*lines, "}"]


def c_text(program: Program, name: str) -> str:
    """Functions of one point and of many, and the struct of results; C99 or later, with the mathematical library."""
    lines = [commented(program, " *").replace(" *", "/*", 1)]
    lines += [
        f" * {name}_points evaluates arrays of n points in blocks, which takes less time for each point.",
        f" * cc -O3 -fno-math-errno -c {name}.c, link with -lm; not -ffast-math, which takes NaN out of the language.",
        " */",
    ]
    members = ", ".join(program.arguments)
    lines += ["#include <math.h>", broken(f"typedef struct {{ double {members}; }} {name}_point;", "")]
    lines += [f"typedef struct {{ double mu, lower, upper; int flag; }} {name}_result;", ""]
    lines += [*_HELPERS, *_data_functions(program), "", *_block(program, name), ""]
    for which, size in (("one", "1"), ("many", "BLOCK")):
        lines += [
            f"CLONES static void {name}_{which}(const {name}_point *at, {name}_result *results) "
            f"{{ block({size}, at, results); }}"
        ]
    numbers = ", ".join(f"double {name}" for name in program.arguments)
    lines += ["", broken(f"{name}_result {name}({numbers})", ""), "{"]
    lines += [broken(f"const {name}_point point = {{{', '.join(program.arguments)}}};", "    ")]
    lines += [f"    {name}_result result;", f"    {name}_one(&point, &result);", "    return result;", "}", ""]
    lines += [f"void {name}_points(int n, const {name}_point points[], {name}_result results[])", "{", "    int i = 0;"]
    lines += [f"    for (; i + BLOCK <= n; i += BLOCK) {name}_many(points + i, results + i);"]
    lines += [f"    for (; i < n; i++) {name}_one(points + i, results + i);", "}", ""]
    return "\n".join(lines)
