"""A formula as a MATLAB or Octave function file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

from regression.export.data_functions import RESULTS
from regression.export.printer import LIBRARY, Printer, assignments, broken, commented, number_rows, packed
from regression.export.program import Program


class MatlabPrinter(Printer):
    """Elementwise expressions."""

    functions: ClassVar[Mapping[str, str]] = LIBRARY
    times, over, power_sign = " .* ", " ./ ", " .^ "
    both, either, opposite = " & ", " | ", "~"
    infinite, undefined = "Inf", "NaN"

    def item(self, name: str, place: int) -> str:
        """An entry of the cell array that functions over stored numbers return."""
        return f"{name}{{{place + 1}}}"

    def function(self, name: str, arguments: Sequence[str]) -> str:
        """A call; coordinates of functions over stored rows go as one cell array."""
        if name in RESULTS:
            return f"{name}({{{', '.join(arguments)}}})"
        return super().function(name, arguments)

    reserved = frozenset({"choose", "end", "function", "if", "for", "while", "switch", "case", "layer"})


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


_ROWS = """
function [x, shape] = rows(x)
  shape = size(x{1});
  for i = 2:numel(x)
    shape = size(zeros(shape) + x{i});
  end
  x = cellfun(@(v) reshape(v + zeros(shape), 1, []), x(:), 'UniformOutput', false);
  x = min(max(cat(1, x{:}), -1e3), 1e3);
end"""

_LOOPS = {
    "networks": """
function r = networks(x)
  [scales, weights] = networks_data();
  [x, shape] = rows(x);
  low = scales(:, 3); high = scales(:, 4); reach = FADE * (high - low);
  x = (x - scales(:, 1)) ./ scales(:, 2);
  fading = min(max(1 - max(max(low - x, x - high) ./ reach, [], 1), 0), 1);
  x = min(max(x, low - reach), high + reach);
  out = zeros(2, size(x, 2), MEMBERS);
  for m = 1:MEMBERS
    w = STEP * weights(:, m);
    one = layer(w(1:FIRST), x, UNITS);
    two = layer(w(FIRST + 1:SECOND), one ./ sqrt(1 + one .^ 2), UNITS);
    out(:, :, m) = layer(w(SECOND + 1:end), two ./ sqrt(1 + two .^ 2), 2);
  end
  centre = mean(out, 3);
  a = out(1, :, :) - centre(1, :); b = out(2, :, :) - centre(2, :);
  r = {fading .^ 2 .* (3 - 2 * fading), centre(1, :), centre(2, :), mean(a .^ 2, 3), mean(a .* b, 3), mean(b .^ 2, 3)};
  r = cellfun(@(v) reshape(v, shape), r, 'UniformOutput', false);
end

function z = layer(weights, x, units)
  weights = reshape(weights, units, []);
  z = weights(:, 1:end - 1) * x + weights(:, end);
end
""",
    "guard": """
function r = guard(x)
  [scales, whitening, cases, limits] = guard_data();
  [x, shape] = rows(x);
  x = x - scales(:, 1);
  u = x ./ scales(:, 2);
  z = whitening' * x;
  r = {Inf, sqrt(sum(z .^ 2, 1)), Inf};
  for j = 1:CASES
    r{1} = min(r{1}, sum((z - STEP * cases(j, :)') .^ 2, 1));
  end
  r{1} = sqrt(r{1});
  for row = limits
    total = u(row(1) + 1, :) + u(row(2) + 1, :); apart = u(row(1) + 1, :) - u(row(2) + 1, :);
    r{3} = min(min(r{3}, total - STEP * row(3)), STEP * row(4) - total);
    r{3} = min(min(r{3}, apart - STEP * row(5)), STEP * row(6) - apart);
  end
  r = cellfun(@(v) reshape(v, shape), r, 'UniformOutput', false);
end
""",
}


def _data_functions(program: Program) -> list[str]:
    lines = []
    for function in program.data_functions:
        arrays = function.arrays
        lines += [function.filled(_LOOPS[function.name])]
        kept = " ".join(f"{name}_" for name in arrays)
        lines += [f"function [{', '.join(arrays)}] = {function.name}_data()", f"  persistent {kept}"]
        lines += [f"  if isempty({next(iter(arrays))}_)"]
        for name, rows in arrays.items():
            text = number_rows([[number for row in rows for number in row]], "      ", "[]").replace("\n", " ...\n")
            lines += [f"    {name}_ = reshape( ...", f"{text}, {len(rows[0])}, {len(rows)});"]
        lines += ["  end", *(f"  {name} = {name}_;" for name in arrays), "end"]
    return lines


def matlab_text(program: Program, name: str) -> str:
    """A function file; arguments are numbers or arrays that expand to one size (MATLAB R2016b, Octave 4)."""
    printer = MatlabPrinter(name)
    arguments = ", ".join(argument.name for argument in program.arguments)
    lines = _wrapped(f"function [mu, lower, upper, flag] = {name}({arguments})", "")
    lines += [commented(program, "%")]
    statements = [f"{variable} = {expression};" for variable, expression, _ in assignments(program, printer)]
    lines += packed(statements, "  ", " ...")
    lines += ["end"]
    lines += [text for operation, text in _HELPERS.items() if operation in program.operations]
    lines += [_CHOOSE, *([_ROWS] if program.data_functions else []), *_data_functions(program), ""]
    return "\n".join(lines)


def _wrapped(line: str, indent: str) -> list[str]:
    return broken(line, indent, end=" ...").split("\n")
