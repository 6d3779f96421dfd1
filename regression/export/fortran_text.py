"""A formula as a Fortran 2008 module."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

from regression.export.data_functions import RESULTS
from regression.export.printer import ATOM, LIBRARY, Printer, assignments, broken, commented, number_rows
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
    integer :: m, at
    reach = FADE_dp * (networks_scales(:, 4) - networks_scales(:, 3))
    x = (min(max(logarithms, -1e3_dp), 1e3_dp) - networks_scales(:, 1)) / networks_scales(:, 2)
    r(1) = 1.0_dp - maxval(max(networks_scales(:, 3) - x, x - networks_scales(:, 4)) / reach)
    r(1) = min(max(r(1), 0.0_dp), 1.0_dp)
    r(1) = r(1) * r(1) * (3.0_dp - 2.0_dp * r(1))
    x = min(max(x, networks_scales(:, 3) - reach), networks_scales(:, 4) + reach)
    at = 0
    do m = 1, MEMBERS
      one = layer(x, UNITS, at)
      one = one / sqrt(1.0_dp + one ** 2)
      at = at + UNITS * (SIZE + 1)
      two = layer(one, UNITS, at)
      two = two / sqrt(1.0_dp + two ** 2)
      at = at + UNITS * (UNITS + 1)
      out(:, m) = layer(two, 2, at)
      at = at + 2 * (UNITS + 1)
    end do
    r(2:3) = sum(out, 2) / MEMBERS
    r(4) = sum((out(1, :) - r(2)) ** 2) / MEMBERS
    r(5) = sum((out(1, :) - r(2)) * (out(2, :) - r(3))) / MEMBERS
    r(6) = sum((out(2, :) - r(3)) ** 2) / MEMBERS
  end function networks

  pure function layer(x, units, at) result(z)
    real(dp), intent(in) :: x(:)
    integer, intent(in) :: units, at
    real(dp) :: z(units)
    integer :: k, first
    do k = 1, units
      first = at + (k - 1) * (size(x) + 1)
      z(k) = STEP_dp * networks_weights(first + size(x) + 1, 1)
      z(k) = z(k) + sum(STEP_dp * networks_weights(first + 1:first + size(x), 1) * x)
    end do
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
      r(1) = min(r(1), sum((z - STEP_dp * guard_cases(:, j)) ** 2))
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
_A_STATEMENT = 900  # numbers: keeps within the limit of continuation lines


def _stored_rows(program: Program) -> list[str]:
    """Module variables, each in data statements of a bounded length."""
    lines = []
    for function in program.data_functions:
        for array, rows in function.arrays.items():
            name, whole = f"{function.name}_{array}", isinstance(rows[0][0], int)
            lines.append(f"  {'integer' if whole else 'real(dp)'}, save :: {name}({len(rows[0])}, {len(rows)})")
            parts = [row[start : start + _A_STATEMENT] for row in rows for start in range(0, len(row), _A_STATEMENT)]
            long = len(rows) == 1
            for place, part in enumerate(parts if long else [[number for row in rows for number in row]]):
                first = place * _A_STATEMENT + 1
                target = f"({name}(i, 1), i = {first}, {first + len(part) - 1})" if long else name
                text = number_rows([part], "    ", "//", "" if whole else "_dp").replace("\n", " &\n")
                lines += [f"  data {target} &", text]
    return ["  integer :: i", *lines] if lines else []


def _loops(program: Program) -> list[str]:
    return [function.filled(_LOOPS[function.name]) for function in program.data_functions]


def fortran_text(program: Program, name: str) -> str:
    """A module with one elemental subroutine: arguments may be arrays of one shape."""
    printer = FortranPrinter(name)
    arguments = [argument.name for argument in program.arguments]
    lines = [commented(program, "!"), "", f"module {name}_formula"]
    used = "ieee_is_finite, ieee_is_nan, ieee_value, ieee_quiet_nan, ieee_positive_inf"
    lines += [f"  use, intrinsic :: ieee_arithmetic, only: {used}"]
    lines += ["  implicit none", "  private", f"  public :: {name}", "  integer, parameter :: dp = kind(1.0d0)"]
    lines += [*_stored_rows(program), "contains"]
    lines += _wrapped(f"elemental subroutine {name}({', '.join((*arguments, *OUTPUTS))})", "  ")
    lines += _wrapped(f"real(dp), intent(in) :: {', '.join(arguments)}", "    ")
    lines += ["    real(dp), intent(out) :: mu, lower, upper", "    integer, intent(out) :: flag"]
    lines += [
        f"    real(dp), parameter :: {printer.variable(value.name)} = {printer.number(value.number)}"
        for value in program.coefficients
    ]
    for kind, logical in (("real(dp)", False), ("logical", True)):
        names = [
            printer.variable(step.name) + (f"({RESULTS[step.operation]})" if step.operation in RESULTS else "")
            for step in program.steps
            if step.logical == logical and step.name not in OUTPUTS
        ]
        if names:
            lines += _wrapped(f"{kind} :: {', '.join(names)}", "    ")
    for variable, expression in assignments(program, printer):
        lines += _wrapped(f"{variable} = {f'int({expression})' if variable == 'flag' else expression}", "    ")
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
    lines += [*_loops(program), f"end module {name}_formula", ""]
    return "\n".join(lines)


def _wrapped(line: str, indent: str) -> list[str]:
    return broken(line, indent, end=" &").split("\n")
