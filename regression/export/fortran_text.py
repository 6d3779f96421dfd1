"""A formula as a Fortran 2008 module."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

from regression.export.data_functions import RESULTS
from regression.export.printer import ATOM, LIBRARY, Printer, assignments, broken, commented, number_rows, packed
from regression.export.program import OUTPUTS, Program


class FortranPrinter(Printer):
    """Expressions of real(dp)."""

    functions: ClassVar[Mapping[str, str]] = {**LIBRARY, "isfinite": "ieee_is_finite"}
    both, either, opposite = " .and. ", " .or. ", ".not. "
    infinite = "ieee_value(1.0_dp, ieee_positive_inf)"
    undefined = "ieee_value(1.0_dp, ieee_quiet_nan)"
    reserved = frozenset({"merge", "int", "dp", "layer", "i", "x"})

    def number(self, number: float) -> str:
        """A literal of kind dp."""
        text = super().number(number)
        return text if "ieee" in text else f"{text}_dp"

    def function(self, name: str, arguments: Sequence[str]) -> str:
        """A call; coordinates of functions over stored rows go as one array."""
        if name in RESULTS:
            return f"{name}([{', '.join(arguments)}])"
        return super().function(name, arguments)

    def item(self, name: str, place: int) -> str:
        """A number of the array that functions over stored numbers return."""
        return f"{name}({place + 1})"

    def choose(self, condition: str, yes: str, no: str) -> tuple[str, int]:
        """The intrinsic merge."""
        return f"merge({yes}, {no}, {condition})", ATOM


# NaN goes through: what max and min do with it is left to the compiler
_HELPERS = {"maximum": ("larger", ">"), "minimum": ("smaller", "<")}


_LOOPS = {
    "networks": """
  pure function networks(logarithms) result(r)
    real(dp), intent(in) :: logarithms(:)
    real(dp) :: r(6), out(2, MEMBERS), x(SIZE), reach(SIZE), one(UNITS), two(UNITS)
    integer :: m
    reach = FADE_dp * (networks_scales(:, 4) - networks_scales(:, 3))
    x = (min(max(logarithms, -1e3_dp), 1e3_dp) - networks_scales(:, 1)) / networks_scales(:, 2)
    r(1) = 1.0_dp - maxval(max(networks_scales(:, 3) - x, x - networks_scales(:, 4)) / reach)
    r(1) = min(max(r(1), 0.0_dp), 1.0_dp)
    r(1) = r(1) * r(1) * (3.0_dp - 2.0_dp * r(1))
    x = min(max(x, networks_scales(:, 3) - reach), networks_scales(:, 4) + reach)
    do m = 1, MEMBERS
      one = layer(networks_weights(:FIRST, m), x, UNITS)
      one = one / sqrt(1.0_dp + one ** 2)
      two = layer(networks_weights(FIRST + 1:SECOND, m), one, UNITS)
      two = two / sqrt(1.0_dp + two ** 2)
      out(:, m) = layer(networks_weights(SECOND + 1:, m), two, 2)
    end do
    r(2:3) = sum(out, 2) / MEMBERS
    r(4) = sum((out(1, :) - r(2)) ** 2) / MEMBERS
    r(5) = sum((out(1, :) - r(2)) * (out(2, :) - r(3))) / MEMBERS
    r(6) = sum((out(2, :) - r(3)) ** 2) / MEMBERS
  end function networks

  pure function layer(weights, x, units) result(z)
    integer, intent(in) :: weights(:), units
    real(dp), intent(in) :: x(:)
    real(dp) :: z(units)
    integer :: i
    z = weights(units * size(x) + 1:)
    do i = 1, size(x)
      z = z + weights(units * (i - 1) + 1:units * i) * x(i)
    end do
    z = STEP_dp * z
  end function layer""",
    "guard": """
  pure function guard(logarithms) result(r)
    real(dp), intent(in) :: logarithms(:)
    real(dp) :: r(3), c(SIZE), u(SIZE), z(SIZE), total, apart, ends(4)
    integer :: j
    c = min(max(logarithms, -1e3_dp), 1e3_dp) - guard_scales(:, 1)
    u = c / guard_scales(:, 2)
    z = matmul(c, guard_whitening)
    r = [huge(total), sqrt(sum(z ** 2)), huge(total)]
    do j = 1, CASES
      r(1) = min(r(1), sum((z - STEP_dp * guard_cases(j, :)) ** 2))
    end do
    r(1) = sqrt(r(1))
    do j = 1, PAIRS
      ends = STEP_dp * guard_limits(3:, j)
      total = u(1 + guard_limits(1, j)) + u(1 + guard_limits(2, j))
      apart = u(1 + guard_limits(1, j)) - u(1 + guard_limits(2, j))
      r(3) = min(r(3), total - ends(1), ends(2) - total, apart - ends(3), ends(4) - apart)
    end do
  end function guard""",
}


def _stored_rows(program: Program) -> list[str]:
    """Module variables."""
    lines = []
    for function in program.data_functions:
        for array, rows in function.arrays.items():
            whole = isinstance(rows[0][0], int)
            kind, mark = ("integer", "") if whole else ("real(dp)", "_dp")
            lines.append(f"  {kind}, save :: {function.name}_{array}({len(rows[0])}, {len(rows)})")
            numbers = number_rows([[number for row in rows for number in row]], "    ", "//", mark)
            lines += [f"  data {function.name}_{array} &", numbers.replace("\n", " &\n")]
    return lines


def fortran_text(program: Program, name: str) -> str:
    """A module with one elemental subroutine: arguments may be arrays of one shape."""
    printer = FortranPrinter(name)
    arguments = [argument.name for argument in program.arguments]
    lines = [commented(program, "!"), f"module {name}_formula"]
    used = "ieee_is_finite, ieee_is_nan, ieee_value, ieee_quiet_nan, ieee_positive_inf"
    lines += [f"  use, intrinsic :: ieee_arithmetic, only: {used}"]
    lines += ["  implicit none", f"  private; public :: {name}", "  integer, parameter :: dp = kind(1.0d0)"]
    lines += [*_stored_rows(program), "contains"]
    lines += _wrapped(f"elemental subroutine {name}({', '.join((*arguments, *OUTPUTS))})", "  ")
    lines += _wrapped(f"real(dp), intent(in) :: {', '.join(arguments)}", "    ")
    lines += ["    real(dp), intent(out) :: mu, lower, upper; integer, intent(out) :: flag"]
    for kind, logical in (("real(dp)", False), ("logical", True)):
        names = [
            printer.variable(step.name) + (f"({RESULTS[step.operation]})" if step.operation in RESULTS else "")
            for step in (*program.coefficients, *program.steps)
            if step.logical == logical and step.name not in OUTPUTS
        ]
        if names:
            lines += _wrapped(f"{kind} :: {', '.join(names)}", "    ")
    statements = [
        f"{variable} = {f'int({expression})' if variable == 'flag' else expression};"
        for variable, expression, _ in assignments(program, printer)
    ]
    lines += [line.removesuffix(";") for line in packed(statements, "    ", " &")]
    lines += [f"  end subroutine {name}"]
    for operation, (helper, sign) in _HELPERS.items():
        if operation in program.operations:
            lines += [
                "",
                f"  elemental function {helper}(a, b) result(c)",
                "    real(dp), intent(in) :: a, b",
                "    real(dp) :: c",
                f"    c = merge(a, b, a {sign} b .or. ieee_is_nan(a))",
                f"  end function {helper}",
            ]
    lines += [function.filled(_LOOPS[function.name]) for function in program.data_functions]
    lines += [f"end module {name}_formula", ""]
    return "\n".join(lines)


def _wrapped(line: str, indent: str) -> list[str]:
    return broken(line, indent, end=" &").split("\n")
