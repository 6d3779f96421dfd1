"""A formula as a MATLAB or Octave function file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

from regression.export.data_functions import RESULTS
from regression.export.printer import LIBRARY, Printer, assignments, broken, commented, number_rows
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


_LOOPS = {
    "networks": """
function r = networks(x)
  [scales, weights] = networks_data();
  fading = 1;
  for i = 1:SIZE
    low = scales(3, i); high = scales(4, i); reach = FADE * (high - low);
    x{i} = (min(max(x{i}, -1e3), 1e3) - scales(1, i)) / scales(2, i);
    fading = min(fading, 1 - max(low - x{i}, x{i} - high) / reach);
    x{i} = min(max(x{i}, low - reach), high + reach);
  end
  fading = max(fading, 0);
  outs = cell(1, MEMBERS);
  at = 0;
  for m = 1:MEMBERS
    [one, at] = layer(STEP * weights, x, UNITS, at);
    [two, at] = layer(STEP * weights, cellfun(@(z) z ./ sqrt(1 + z .^ 2), one, 'UniformOutput', false), UNITS, at);
    [outs{m}, at] = layer(STEP * weights, cellfun(@(z) z ./ sqrt(1 + z .^ 2), two, 'UniformOutput', false), 2, at);
  end
  r = {fading .* fading .* (3 - 2 * fading), 0, 0, 0, 0, 0};
  for m = 1:MEMBERS
    r{2} = r{2} + outs{m}{1} / MEMBERS;
    r{3} = r{3} + outs{m}{2} / MEMBERS;
  end
  for m = 1:MEMBERS
    a = outs{m}{1} - r{2};
    b = outs{m}{2} - r{3};
    r{4} = r{4} + a .^ 2 / MEMBERS;
    r{5} = r{5} + a .* b / MEMBERS;
    r{6} = r{6} + b .^ 2 / MEMBERS;
  end
end

function [z, at] = layer(weights, x, units, at)
  z = cell(1, units);
  for k = 1:units
    z{k} = weights(at + numel(x) + 1);
    for i = 1:numel(x)
      z{k} = z{k} + weights(at + i) * x{i};
    end
    at = at + numel(x) + 1;
  end
end
""",
    "guard": """
function r = guard(x)
  [scales, whitening, cases, limits] = guard_data();
  u = cell(1, SIZE);
  z = cell(1, SIZE);
  r = {Inf, 0, Inf};
  for i = 1:SIZE
    x{i} = min(max(x{i}, -1e3), 1e3) - scales(1, i);
    u{i} = x{i} / scales(2, i);
    z{i} = 0;
    for k = 1:i
      z{i} = z{i} + whitening(i, k) * x{k};
    end
    r{2} = r{2} + z{i} .^ 2;
  end
  r{2} = sqrt(r{2});
  for j = 1:CASES
    square = 0;
    for i = 1:SIZE
      square = square + (z{i} - STEP * cases(j, i)) .^ 2;
    end
    r{1} = min(r{1}, square);
  end
  r{1} = sqrt(r{1});
  for j = 1:PAIRS
    ends = STEP * limits(j, 3:6);
    total = u{limits(j, 1) + 1} + u{limits(j, 2) + 1};
    apart = u{limits(j, 1) + 1} - u{limits(j, 2) + 1};
    r{3} = min(min(r{3}, total - ends(1)), ends(2) - total);
    r{3} = min(min(r{3}, apart - ends(3)), ends(4) - apart);
  end
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
            lines += [f"    {name}_ = reshape( ...", f"{text}, {len(rows[0])}, {len(rows)})';"]
        lines += ["  end", *(f"  {name} = {name}_;" for name in arrays), "end"]
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
