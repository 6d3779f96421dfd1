"""A formula as a MATLAB or Octave function file."""

from collections.abc import Mapping
from typing import ClassVar

from regression.export.printer import LIBRARY, Printer, assignments, broken, commented, number_rows, packed
from regression.export.program import Program


class MatlabPrinter(Printer):
    """Elementwise expressions."""

    functions: ClassVar[Mapping[str, str]] = LIBRARY
    times, over, power_sign = " .* ", " ./ ", " .^ "
    both, either, opposite = " & ", " | ", "~"
    infinite, undefined = "Inf", "NaN"
    array, element, first = ("{", "}"), "{}{{{}}}", 1
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


def _data_functions(program: Program) -> list[str]:
    lines = []
    for function in program.data_functions:
        arrays = function.arrays
        lines += [function.loop(".m")]
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
    lines = [
        broken(f"function [{', '.join(printer.outputs)}] = {name}({', '.join(program.arguments)})", "", end=" ..."),
        commented(program, "%"),
    ]
    statements = [f"{variable} = {expression};" for variable, expression, _ in assignments(program, printer)]
    lines += packed(statements, "  ", " ...")
    lines += ["end"]
    lines += [text for operation, text in _HELPERS.items() if operation in program.operations]
    lines += [_CHOOSE, *([_ROWS] if program.data_functions else []), *_data_functions(program), ""]
    return "\n".join(lines)
