"""A formula as C99."""

import re
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
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

    def operand(self, value: Value) -> str:
        """Text of a value where it is used: its name, or its expression."""
        return self._text(value)[0]

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
_HELPERS, _POINTS = (
    Path(__file__).with_name(f"{name}.c").read_text(encoding="utf-8") for name in ("helpers", "points")
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


def _kind(step: Value) -> str:
    return "int" if step.logical or step.name == "flag" else "double"


def _block(program: Program, name: str) -> list[str]:
    """Function of the n points of a block: loops over the points, between them the functions over stored numbers."""
    loop: dict[Value, int] = {}
    for value in sorted(reached(program.steps), key=lambda value: value.serial):
        loop[value] = max((loop[operand] + isinstance(operand, DataValue) for operand in value.operands), default=0)
    calls = [step for step in program.steps if isinstance(step, DataValue)]
    steps = [step for step in program.steps if not isinstance(step, DataValue)]
    plain = CPrinter(name)
    # those that a later loop uses are stored for each point
    uses = [(loop[step], set(re.findall(r"\w+", plain.expression(step)))) for step in program.steps]
    stored = {s for s in steps if any(place > loop[s] and plain.variable(s.name) in words for place, words in uses)}
    printer = CPrinter(name, program.arguments, {step.name for step in stored})
    declared = [f"const double {plain.variable(c.name)} = {plain.number(c.number)};" for c in program.coefficients]
    declared += [f"{_kind(step)} {plain.variable(step.name)}[BLOCK];" for step in steps if step in stored]
    for call in calls:
        sizes = len(call.operands), RESULTS[call.operation]
        declared.append("double {0}_x[{1} * BLOCK], {0}[{2} * BLOCK];".format(call.name, *sizes))
    lines = [f"INLINE void block(const int n, const {name}_point *at, {name}_result *results)", "{"]
    lines += packed(declared, "    ", kind="const double ")
    for place in range(max(loop.values()) + 1):
        statements = []
        for step in (step for step in steps if loop[step] == place):
            text = f"(int)({printer.expression(step)})" if step.name == "flag" else printer.expression(step)
            kind = "" if step in stored else f"const {_kind(step)} "
            statements.append(f"{kind}{printer.variable(step.name)} = {text};")
        for call in (call for call in calls if loop[call] == place):
            texts = [printer.operand(value) for value in call.operands]
            statements += [f"{call.name}_x[{k} * n + p] = {text};" for k, text in enumerate(texts)]
        if place == max(loop.values()):
            statements.append(f"results[p] = ({name}_result){{{', '.join(printer.outputs)}}};")
        lines += ["    for (int p = 0; p < n; p++) {", *packed(statements, "        ", kind="const double "), "    }"]
        lines += [f"    {call.operation}(n, {call.name}_x, {call.name});" for call in calls if loop[call] == place]
    return [*lines, "}", ""]


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
    lines += [f"typedef struct {{ double mu, lower, upper; int flag; }} {name}_result;", "", _HELPERS.rstrip()]
    lines += [*_data_functions(program), "", *_block(program, name)]
    words = {"NAME": name, "NUMBERS": "double " + members.replace(", ", ", double "), "MEMBERS": members}
    text = re.sub("|".join(words), lambda found: words[found[0]], _POINTS)
    lines += [broken(line.strip(), line[: -len(line.lstrip())]) if line.strip() else "" for line in text.split("\n")]
    return "\n".join(lines)
