"""A formula as a Fortran 2008 module."""

from collections.abc import Mapping, Sequence
from decimal import Decimal
from typing import ClassVar

from regression.export.printer import ATOM, LIBRARY, LINE, Printer, assignments, broken, commented, number_rows, packed
from regression.export.program import OUTPUTS, RESULTS, Program


class FortranPrinter(Printer):
    """Expressions of real(dp)."""

    functions: ClassVar[Mapping[str, str]] = {**LIBRARY, "isfinite": "ieee_is_finite"}
    both, either, opposite = " .and. ", " .or. ", ".not. "
    infinite = "ieee_value(1.0_dp, ieee_positive_inf)"
    undefined = "ieee_value(1.0_dp, ieee_quiet_nan)"
    array, element, first = ("[", "]"), "{}({})", 1
    reserved = frozenset({"merge", "int", "dp", "layer", "i", "x"})

    def number(self, number: float) -> str:
        """A literal of kind dp."""
        text = super().number(number)
        return text if "ieee" in text else f"{text}_dp"

    def choose(self, condition: str, yes: str, no: str) -> tuple[str, int]:
        """The intrinsic merge."""
        return f"merge({yes}, {no}, {condition})", ATOM


# NaN goes through: what max and min do with it is left to the compiler
_HELPERS = {"maximum": ("larger", ">"), "minimum": ("smaller", "<")}

# digits of whole numbers as text, which takes a third of the lines of a list of numbers; no quote and no backslash
_DIGITS = "".join(chr(code) for code in range(35, 125) if chr(code) != "\\")
_BASE = len(_DIGITS)


def _as_text(name: str, rows: Sequence[Sequence[float]], decimals: int, size: int) -> list[str]:
    """A constant from a text with `size` digits for each number, which is whole in its last decimal."""
    places, zero, unit = [_BASE**power for power in reversed(range(size))], _BASE**size // 2, 10**decimals
    numbers = [round(number * unit) + zero for row in rows for number in row]
    text = "".join(_DIGITS[number // place % _BASE] for number in numbers for place in places)
    shape, text = f"{len(rows[0])}, {len(rows)}", f'  character(*), parameter :: {name}_text = "{text}"'
    parts = [text[max(k, 0) : k + LINE - 2] for k in range(-1, len(text), LINE - 2)]
    at = ["i:i", *(f"i + {k}:i + {k}" for k in range(1, size))]
    terms = [
        f"{place} * index(digits, {name}_text({k}))".removeprefix("1 * ") for place, k in zip(places, at, strict=True)
    ]
    formula = f"{' + '.join(terms)} - {zero + sum(places)}"
    if decimals:
        formula = f"({formula}) / {unit}.0_dp"
    values = f"reshape([({formula}, i = 1, len({name}_text), {size})], [{shape}])"
    kind = "real(dp)" if decimals else "integer"
    return [
        "&\n&".join(parts),
        broken(f"{kind}, parameter :: {name}({shape}) = {values}", "  ", end=" &"),
    ]


def _decimals(number: float) -> int:
    """Decimals of a number as it is written."""
    return 0 if number == int(number) else max(0, -int(Decimal(str(number)).as_tuple().exponent))


def _stored_rows(program: Program) -> list[str]:
    """Module variables."""
    lines = ["  integer :: i", f'  character(*), parameter :: digits = "{_DIGITS}"']
    for function in program.data_functions:
        for array, rows in function.arrays.items():
            name, numbers = f"{function.name}_{array}", [number for row in rows for number in row]
            decimals = max(_decimals(number) for number in numbers)
            largest = max(abs(number) for number in numbers) * 10**decimals
            size = next((size for size in (2, 3, 4) if largest < _BASE**size // 2), None)
            if size is not None:
                lines += _as_text(name, rows, decimals, size)
                continue
            lines += [f"  real(dp), save :: {name}({len(rows[0])}, {len(rows)})", f"  data {name} &"]
            lines.append(number_rows([numbers], "    ", "//", "_dp", LINE).replace("\n", " &\n"))
    return lines if len(lines) > 2 else []


def fortran_text(program: Program, name: str) -> str:
    """A module with one elemental subroutine: arguments may be arrays of one shape."""
    printer = FortranPrinter(name)
    lines = [commented(program, "!"), f"module {name}_formula"]
    used = "ieee_is_finite, ieee_is_nan, ieee_value, ieee_quiet_nan, ieee_positive_inf"
    lines += [f"  use, intrinsic :: ieee_arithmetic, only: {used}"]
    lines += [f"  implicit none; private; public :: {name}", "  integer, parameter :: dp = kind(1.0d0)"]
    lines += [*_stored_rows(program), "contains"]
    dummies = ", ".join((*program.arguments, *printer.outputs))
    lines += [broken(f"elemental subroutine {name}({dummies})", "  ", end=" &")]
    lines += [broken(f"real(dp), intent(in) :: {', '.join(program.arguments)}", "    ", end=" &")]
    *numbers, flag = printer.outputs
    lines += [f"    real(dp), intent(out) :: {', '.join(numbers)}; integer, intent(out) :: {flag}"]
    for kind, logical in (("real(dp)", False), ("logical", True)):
        names = [
            printer.variable(step.name) + (f"({RESULTS[step.operation]})" if step.operation in RESULTS else "")
            for step in (*program.coefficients, *program.steps)
            if step.logical == logical and step.name not in OUTPUTS
        ]
        if names:
            lines += [broken(f"{kind} :: {', '.join(names)}", "    ", end=" &")]
    statements = [
        f"{variable} = {f'int({expression})' if value.name == 'flag' else expression};"
        for variable, expression, value in assignments(program, printer)
    ]
    lines += [line.removesuffix(";") for line in packed(statements, "    ", " &")]
    lines += [f"  end subroutine {name}"]
    for operation, (helper, sign) in _HELPERS.items():
        if operation in program.operations:
            lines += [
                f"  elemental real(dp) function {helper}(a, b)",
                "    real(dp), intent(in) :: a, b",
                f"    {helper} = merge(a, b, a {sign} b .or. ieee_is_nan(a))",
                f"  end function {helper}",
            ]
    lines += [function.loop(".f90").strip("\n") for function in program.data_functions]
    lines += [f"end module {name}_formula", ""]
    return "\n".join(lines)
