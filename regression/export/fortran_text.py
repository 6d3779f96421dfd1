"""A formula as a Fortran 2008 module."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

from regression.export.data_functions import NAMES
from regression.export.printer import ATOM, LIBRARY, Printer, assignments, broken, commented
from regression.export.program import OUTPUTS, Program


class FortranPrinter(Printer):
    """Expressions of real(dp)."""

    functions: ClassVar[Mapping[str, str]] = {**LIBRARY, "isfinite": "ieee_is_finite"}
    both, either, opposite = " .and. ", " .or. ", ".not. "
    infinite = "ieee_value(1.0_dp, ieee_positive_inf)"
    undefined = "ieee_value(1.0_dp, ieee_quiet_nan)"
    reserved = frozenset({"merge", "int", "dp", "distance", "matern"})

    def number(self, number: float) -> str:
        """A literal of kind dp."""
        text = super().number(number)
        return text if "ieee" in text else f"{text}_dp"

    def function(self, name: str, arguments: Sequence[str]) -> str:
        """A call; coordinates of functions over stored rows go as one array."""
        if name in NAMES:
            return f"{name}([{', '.join(arguments)}])"
        return super().function(name, arguments)

    def choose(self, condition: str, yes: str, no: str) -> tuple[str, int]:
        """The intrinsic merge."""
        return f"merge({yes}, {no}, {condition})", ATOM


# NaN goes through: what max and min do with it is left to the compiler
_HELPERS = {
    "maximum": ("larger", ">"),
    "minimum": ("smaller", "<"),
}


_LOOPS = {
    "gp_mean": """
  pure function gp_mean(x) result(total)
    real(dp), intent(in) :: x(:)
    real(dp) :: total
    integer :: j
    total = 0.0_dp
    do j = 1, ROWS
      total = total + gp_mean_rows(SIZE + 1, j) * matern(x, gp_mean_rows(:SIZE, j))
    end do
  end function gp_mean""",
    "gp_reduction": """
  pure function gp_reduction(x) result(total)
    real(dp), intent(in) :: x(:)
    real(dp) :: total, covariance(ROWS)
    integer :: j
    do j = 1, ROWS
      covariance(j) = matern(x, gp_reduction_rows(:SIZE, j))
    end do
    total = sum(matmul(gp_reduction_rows(SIZE + 1:, :), covariance) ** 2)
  end function gp_reduction""",
    "case_distance": """
  pure function case_distance(x) result(least)
    real(dp), intent(in) :: x(:)
    real(dp) :: least
    integer :: j
    least = huge(least)
    do j = 1, ROWS
      least = merge(least, distance(x, case_distance_rows(:, j)), least <= distance(x, case_distance_rows(:, j)))
    end do
  end function case_distance""",
    "hull_margin": """
  pure function hull_margin(x) result(least)
    real(dp), intent(in) :: x(:)
    real(dp) :: least, row(5)
    integer :: j
    least = huge(least)
    do j = 1, ROWS
      row = hull_margin_rows(:, j)
      least = min(least, row(3) * x(1 + int(row(1))) + row(4) * x(1 + int(row(2))) + row(5))
    end do
  end function hull_margin""",
}
_DISTANCE = """
  pure function distance(x, z) result(r)
    real(dp), intent(in) :: x(:), z(:)
    real(dp) :: r
    r = sqrt(sum((x - z) ** 2))
  end function distance"""
_MATERN = """
  pure function matern(x, z) result(m)
    real(dp), intent(in) :: x(:), z(:)
    real(dp) :: m, a
    a = sqrt(5.0_dp) * distance(x, z)
    m = (1.0_dp + a + a ** 2 / 3.0_dp) * exp(-a)
  end function matern"""


def _stored_rows(program: Program) -> list[str]:
    """Module variables; one data statement a row keeps within the limit of continuation lines."""
    lines = []
    for function in program.data_functions:
        count, width = function.rows.shape
        lines += [f"  real(dp), save :: {function.name}_rows({width}, {count})"]
        for j, row in enumerate(function.rows.tolist(), start=1):
            numbers = ", ".join(f"{number!r}_dp" for number in row)
            lines += _wrapped(f"data {function.name}_rows(:, {j}) / {numbers} /", "  ")
    return lines


def _loops(program: Program) -> list[str]:
    names = {function.kind for function in program.data_functions}
    lines = [_DISTANCE] * bool(names - {"hull_margin"}) + [_MATERN] * bool(names & {"gp_mean", "gp_reduction"})
    for function in program.data_functions:
        text = function.code(_LOOPS).replace("ROWS", str(len(function.rows)))
        lines.append(text.replace("SIZE", str(function.size)))
    return lines


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
            printer.variable(step.name)
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
