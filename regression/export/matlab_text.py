"""A formula as a MATLAB or Octave function file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

from regression.export.data_functions import NAMES
from regression.export.printer import LIBRARY, Printer, assignments, broken, commented
from regression.export.program import Program


class MatlabPrinter(Printer):
    """Elementwise expressions."""

    functions: ClassVar[Mapping[str, str]] = LIBRARY
    times, over, power_sign = " .* ", " ./ ", " .^ "
    both, either, opposite = " & ", " | ", "~"
    infinite, undefined = "Inf", "NaN"

    def function(self, name: str, arguments: Sequence[str]) -> str:
        """A call; coordinates of functions over stored rows go as one cell array."""
        if name in NAMES:
            return f"{name}({{{', '.join(arguments)}}})"
        return super().function(name, arguments)

    reserved = frozenset({"choose", "end", "function", "if", "for", "while", "switch", "case", "distance", "matern"})


_CHOOSE = """
function result = choose(condition, yes, no)
  shape = zeros(size(condition + yes + no));
  condition = (condition + shape) > 0;
  result = no + shape;
  yes = yes + shape;
  result(condition) = yes(condition);
end"""

# NaN goes through, which max and min would hide
_HELPERS = {
    "maximum": """
function result = larger(a, b)
  result = choose(a > b | isnan(a), a, b);
end""",
    "minimum": """
function result = smaller(a, b)
  result = choose(a < b | isnan(a), a, b);
end""",
}


_LOOPS = {
    "gp_mean": """
function total = gp_mean(x)
  rows = gp_mean_rows();
  total = 0;
  for j = 1:size(rows, 1)
    total = total + rows(j, end) * matern(x, rows(j, :));
  end
end
""",
    "gp_reduction": """
function total = gp_reduction(x)
  rows = gp_reduction_rows();
  size_x = numel(x);
  covariance = cell(1, size(rows, 1));
  for j = 1:size(rows, 1)
    covariance{j} = matern(x, rows(j, :));
  end
  total = 0;
  for i = 1:size(rows, 1)
    spread = 0;
    for j = 1:size(rows, 1)
      if rows(j, size_x + i) ~= 0
        spread = spread + covariance{j} * rows(j, size_x + i);
      end
    end
    total = total + spread .^ 2;
  end
end
""",
    "case_distance": """
function least = case_distance(x)
  rows = case_distance_rows();
  least = Inf;
  for j = 1:size(rows, 1)
    least = min(least, distance(x, rows(j, :)));
  end
end
""",
    "hull_margin": """
function least = hull_margin(x)
  rows = hull_margin_rows();
  least = Inf;
  for j = 1:size(rows, 1)
    row = rows(j, :);
    least = min(least, row(3) * x{row(1) + 1} + row(4) * x{row(2) + 1} + row(5));
  end
end
""",
}
_SHARED = """
function r = distance(x, row)
  square = 0;
  for i = 1:numel(x)
    square = square + (x{i} - row(i)) .^ 2;
  end
  r = sqrt(square);
end

function m = matern(x, row)
  a = sqrt(5) * distance(x, row);
  m = (1 + a + a .^ 2 / 3) .* exp(-a);
end
"""


def _data_functions(program: Program) -> list[str]:
    if not program.data_functions:
        return []
    lines = [_SHARED]
    for function in program.data_functions:
        rows = ";\n".join("\n".join(_wrapped(" ".join(map(repr, row)), "    ")) for row in function.rows.tolist())
        lines += [function.code(_LOOPS), f"function rows = {function.name}_rows()", "  persistent stored"]
        lines += ["  if isempty(stored)", "    stored = [", rows, "    ];", "  end", "  rows = stored;", "end"]
    return lines


def matlab_text(program: Program, name: str) -> str:
    """A function file; arguments are numbers or arrays that expand to one size (MATLAB R2016b, Octave 4)."""
    printer = MatlabPrinter(name)
    arguments = ", ".join(argument.name for argument in program.arguments)
    lines = _wrapped(f"function [mu, lower, upper, flag] = {name}({arguments})", "")
    lines += [commented(program, "%")]
    lines += [f"  {printer.variable(value.name)} = {printer.number(value.number)};" for value in program.coefficients]
    for variable, expression in assignments(program, printer):
        lines += _wrapped(f"{variable} = {expression};", "  ")
    lines += ["end"]
    lines += [text for operation, text in _HELPERS.items() if operation in program.operations]
    lines += [_CHOOSE, *_data_functions(program), ""]
    return "\n".join(lines)


def _wrapped(line: str, indent: str) -> list[str]:
    return broken(line, indent, end=" ...").split("\n")
