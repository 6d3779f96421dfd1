"""Text of an expression from recorded values; operators and functions in the syntax of each language."""

import keyword
import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import ClassVar

from ehl import __version__
from ehl.common.errors import InputError
from regression.export.program import MEANING, OUTPUTS, RESULTS, Program
from regression.export.record import COMPARISONS, FUNCTIONS, Value
from regression.friction.conditions import UNITS
from regression.friction.models import FrictionFlag

# how tightly an operator binds; an operand that binds less tightly is put in brackets
OR, AND, COMPARE, SUM, PRODUCT, POWER, ATOM = range(7)
# of the written code in any language, in addition to `reserved`: a function of this name would hide them
_WORDS = frozenset(
    {
        *(*RESULTS, *keyword.kwlist, "rows", "layer", "squash", "squashed", "digits", "index", "real", "len", "matmul"),
        *("isnan", "isfinite", "size", "zeros", "numel", "mean", "sum", "min", "max", "reshape", "cellfun", "cat"),
    }
)
_INFIX = {"add": (" + ", SUM), "subtract": (" - ", SUM), "multiply": (" * ", PRODUCT), "divide": (" / ", PRODUCT)}


class Printer:
    """Expressions in one language; this class contains the common syntax of Python and C.

    A negative number or a sign within an expression is in brackets: spreadsheets bind it tighter than the power.
    """

    functions: ClassVar[Mapping[str, str]] = {}
    times = " * "
    over = " / "
    both = " and "
    either = " or "
    opposite = "not "
    power_sign = " ** "
    infinite = "inf"
    undefined = "nan"
    array = ("", "")  # around the coordinates that a function over stored numbers takes
    element = "{}[{}]"  # one of its results, counted from `first`
    first = 0
    reserved: frozenset[str] = frozenset()

    def __init__(self, function_name: str = "") -> None:
        self.function_name = function_name.lower()
        self._reserved = {*FUNCTIONS, *self.functions.values(), *self.reserved}
        self.outputs = [self.variable(name) for name in OUTPUTS]
        if self.function_name in {*self._reserved, *_WORDS, *UNITS}:
            hint = "The function takes the name of the file."
            raise InputError("path", function_name, "a file name that is no word of the written code", hint)

    def expression(self, value: Value) -> str:
        """Text of a value from names; its own name is not used."""
        return self._text(value, named=False)[0]

    def variable(self, name: str) -> str:
        """A name as the language allows it."""
        return f"{name}_" if name.lower() in {self.function_name, *self._reserved} else name

    def number(self, number: float) -> str:
        """A number with all its digits."""
        if math.isnan(number):
            return self.undefined
        if math.isinf(number):
            return self.infinite if number > 0.0 else f"-{self.infinite}"
        return repr(number)

    def function(self, name: str, arguments: Sequence[str]) -> str:
        """A call; the operation's own name where the language has no other."""
        left, right = self.array if name in RESULTS else ("", "")
        return f"{self.functions.get(name, name)}({left}{', '.join(arguments)}{right})"

    def power(self, base: tuple[str, int], exponent: tuple[str, int]) -> tuple[str, int]:
        """Base to the exponent, given as text and level."""
        left, right = (self._enclosed(part, ATOM) for part in (base, exponent))
        return f"{left}{self.power_sign}{right}", POWER

    def choose(self, condition: str, yes: str, no: str) -> tuple[str, int]:
        """One of two values by a condition."""
        return self.function("choose", (condition, yes, no)), ATOM

    def comparison(self, operation: str, left: str, right: str) -> tuple[str, int]:
        """A comparison of two numbers."""
        return f"{left} {COMPARISONS[operation]} {right}", COMPARE

    def logical(self, operation: str, parts: Sequence[tuple[str, int]]) -> tuple[str, int]:
        """And, or, not."""
        if operation == "not":
            return f"{self.opposite}{self._enclosed(parts[0], ATOM)}", COMPARE
        level, sign = (AND, self.both) if operation == "and" else (OR, self.either)
        return sign.join(self._enclosed(part, level) for part in parts), level

    def _text(self, value: Value, named: bool = True) -> tuple[str, int]:
        if value.operation == "constant":
            text = self.number(value.number)
            return (f"({text})", ATOM) if text.startswith("-") and named else (text, ATOM)
        if not value.operands or (named and value.name):
            return self.variable(value.name), ATOM
        parts = [self._text(operand) for operand in value.operands]
        operation = value.operation
        if operation == "item":
            return self.element.format(parts[0][0], int(value.number) + self.first), ATOM
        last = value.operands[-1]
        if operation == "add" and last.operation == "constant" and last.number < 0.0:
            return f"{self._enclosed(parts[0], SUM)} - {self.number(-last.number)}", SUM
        if operation in _INFIX:
            sign, level = _INFIX[operation]
            sign = {" * ": self.times, " / ": self.over}.get(sign, sign)
            # a - (b - c) and a / (b * c) keep their brackets
            right = level + (operation in ("subtract", "divide"))
            return self._enclosed(parts[0], level) + sign + self._enclosed(parts[1], right), level
        if operation == "power":
            return self.power(parts[0], parts[1])
        if operation == "negative":
            return f"(-{self._enclosed(parts[0], ATOM)})", ATOM
        if operation in COMPARISONS:
            return self.comparison(operation, *(self._enclosed(part, SUM) for part in parts))
        if operation in ("and", "or", "not"):
            return self.logical(operation, parts)
        # alone between commas a sign needs no brackets
        signed = ("constant", "negative")
        texts = [
            text[1:-1] if operand.operation in signed and not operand.name and text.startswith("(-") else text
            for operand, (text, _) in zip(value.operands, parts, strict=True)
        ]
        if operation == "choose":
            return self.choose(texts[0], texts[1], texts[2])
        return self.function(operation, texts), ATOM

    @staticmethod
    def _enclosed(part: tuple[str, int], level: int) -> str:
        text, own = part
        return text if own >= level else f"({text})"


LINE = 130  # characters; two more mark a line that goes on
_TABLE_LINE = 700  # of numbers: a row of the networks is one line
# functions with the same name in C, Fortran and MATLAB; maximum and minimum propagate NaN as in numpy
LIBRARY = {
    "absolute": "abs",
    "arctan": "atan",
    "arcsinh": "asinh",
    "arctanh": "atanh",
    "maximum": "larger",
    "minimum": "smaller",
}


def assignments(program: Program, printer: Printer) -> list[tuple[str, str, Value]]:
    """Name, expression and owner of every coefficient and step."""
    return [
        (
            printer.variable(value.name),
            printer.number(value.number) if value.operation == "coefficient" else printer.expression(value),
            value,
        )
        for value in (*program.coefficients, *program.steps)
    ]


def description(program: Program) -> list[str]:
    """Head of every program: origin, arguments, results, errors."""
    formula = program.formula
    scores, data = formula.validation, formula.data
    wide = 100.0 * formula.interval.level
    of = "a single roughness profile" if formula.interval.of_means == 1.0 else "the mean over roughness profiles"
    ranges = {name: f"{low:.6g} to {high:.6g}" for name, (low, high) in formula.ranges.items()}
    others = [
        f"{name} {text} {formula.units.get(name, '') or '-'}"
        for name, text in ranges.items()
        if name not in program.arguments
    ]
    unguarded = formula.cloud is not None and "guard" not in program.operations
    oil = program.oil or "any: its properties are arguments"
    if program.oil is None and len(formula.oils) == 1 and formula.oils[0].name is not None:
        oil = f"its properties are arguments; the formula was fitted to {formula.oils[0].name}"
    corrected = "networks that correct " if formula.network is not None else ""
    return [
        f"Friction of a lubricated line contact: {corrected}{formula.family}, {formula.form.title}.",
        f"Written by mixed-ehl {__version__} from a fit of {data.used} contacts (plan {data.plan}, solver "
        f"{data.solver_version}, data {data.hash[:12]}).",
        f"Oil: {oil}.",
        f"Held-out errors: mean {100.0 * scores.mape:.1f} %, 95 % of the cases within {100.0 * scores.p95:.0f} %, "
        f"worst {100.0 * scores.largest:.0f} %.",
        "Arguments in SI units, with the range:",
        *(
            f"  {name} [{UNITS[name] or '-'}] {ranges.get(name, '')}".rstrip() + f": {MEANING[name]}"
            for name in program.arguments
        ),
        "Results:",
        "  mu: friction coefficient, without rolling traction; NaN where the formula has no value",
        f"  lower, upper: {wide:g} % interval of mu for {of}; outside the range with the largest error",
        f"  flag: {flag_meanings(program)}",
        *(("Points within the range, but far from all fitted cases, are not flagged.",) if unguarded else ()),
        *((f"Range also: {', '.join(others)}.",) if others else ()),
    ]


def flag_meanings(program: Program) -> str:
    """Numbers of the flag and their meanings."""
    meanings = {FrictionFlag.OK: "good"}
    if "guard" in program.operations:
        meanings[FrictionFlag.EXTRAPOLATED_NEAR] = "within the range, but extrapolated"
        meanings[FrictionFlag.EXTRAPOLATED_FAR] = "extrapolated far from the fitted cases"
    meanings[FrictionFlag.OUTSIDE_RANGE] = "outside the range"
    meanings[FrictionFlag.UNDEFINED] = "no value"
    return ", ".join(f"{flag:d} {meaning}" for flag, meaning in meanings.items())


def commented(program: Program, mark: str) -> str:
    """The description as comment lines."""
    lines: list[str] = []
    for line in description(program):
        indent = "    " if line.startswith(" ") else ""
        lines += textwrap.wrap(line, 125, subsequent_indent=indent, break_long_words=False) or [""]
    return "\n".join(f"{mark} {line}".rstrip() for line in lines).replace("*/", "* /")


def broken(line: str, indent: str, end: str = "") -> str:
    """A statement over several lines, broken at spaces; `end` marks a line that goes on."""
    return f"{end}\n".join(
        textwrap.wrap(
            line,
            LINE,
            initial_indent=indent,
            subsequent_indent=f"{indent}    ",
            break_long_words=False,
            break_on_hyphens=False,
        )
    )


def packed(statements: Sequence[str], indent: str, end: str = "", kind: str = "") -> list[str]:
    """Statements that end with a semicolon, on as few lines as possible.

    statements: without line breaks.
    indent, end: before each line, and at the end of one that goes on.
    kind: declarations that begin with it are joined.
    """
    lines: list[str] = []
    for statement in statements:
        last = lines[-1] if lines else ""
        joined = f"{last} {statement}"
        if kind and statement.startswith(kind) and last.startswith(indent + kind) and last.count(";") == 1:
            joined = f"{last[:-1]}, {statement.removeprefix(kind)}"
        if last and "\n" not in last and len(joined) <= LINE:
            lines[-1] = joined
        else:
            lines.append(broken(statement, indent, end))
    return "\n".join(lines).split("\n")


def number_rows(
    rows: Sequence[Sequence[float]], indent: str, ends: str = "{}", kind: str = "", width: int = _TABLE_LINE
) -> str:
    """Rows of numbers, each between two brackets, as many per line of `width` as fit; `kind` follows each number."""
    left, right = (ends[0], ends[1]) if ends else ("", "")
    parts = [part for row in rows for part in (left, *(f"{number!r}{kind}," for number in row), right)]
    text = "\0".join(parts).replace(f",\0{right}", right or ",").replace(f"{left}\0", left)
    lines, line = [], indent
    words = text.split("\0")
    for k, word in enumerate(words):
        shown = f"{word}," if right and word.endswith(right) and k < len(words) - 1 else word
        if len(line) + len(shown) > width and line.strip():
            lines.append(line)
            line = indent
        line += shown
    return "\n".join([*lines, line]).rstrip(",")
