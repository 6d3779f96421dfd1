"""A formula as live cells: an XLSX workbook with one row per contact point, or the text of one cell formula."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import ClassVar

import numpy as np

from ehl.common.errors import InputError
from ehl.fluid.oil import Oil
from ehl.material import Material, effective_modulus
from regression.export.printer import ATOM, COMPARE, Printer, description
from regression.export.program import OUTPUTS, Program
from regression.friction.conditions import LUBRICANT_UNITS, Array, lubricant_row

_FIRST_ROW = 3  # under the names and the units, counted from 0
_ROWS = 20
_MAX_CELL_LENGTH = 8192  # characters of a cell formula


class SpreadsheetPrinter(Printer):
    """Cell formulas with the functions Excel, LibreOffice and Google Sheets share."""

    functions: ClassVar[Mapping[str, str]] = {
        **{n: n.upper() for n in ("exp", "log10", "sqrt", "sin", "cos", "tan", "sinh", "cosh", "tanh", "erf", "erfc")},
        "absolute": "ABS",
        "log": "LN",
        "arctan": "ATAN",
        "arcsinh": "ASINH",
        "arctanh": "ATANH",
        "choose": "IF",
        "maximum": "MAX",
        "minimum": "MIN",
        "isfinite": "ISNUMBER",
    }
    times, over, power_sign = "*", "/", "^"
    # a cell holds no infinity; the film ratio of a smooth surface is all that needs one
    infinite, undefined = "1E+30", "NA()"

    def __init__(self, cells: Mapping[str, str] | None = None) -> None:
        super().__init__()
        self.cells = cells or {}

    def variable(self, name: str) -> str:
        """The cell that holds it, or its name, made unlike a cell's."""
        return self.cells.get(name, f"{name}_" if re.fullmatch(r"[A-Za-z]{1,3}\d+", name) else name)

    def number(self, number: float) -> str:
        """A literal; spreadsheets read 15 digits of one."""
        return super().number(number).replace("e", "E").removesuffix(".0")

    def logical(self, operation: str, parts: Sequence[tuple[str, int]]) -> tuple[str, int]:
        """The functions AND, OR, NOT; an error among the parts counts as false."""
        call = f"{operation.upper()}("
        # one call in place of one inside the other
        texts = [text.removeprefix(call).removesuffix(")") if text.startswith(call) else text for text, _ in parts]
        text = f"{call}{','.join(texts)})"
        return (f"IFERROR({text},FALSE)" if "ISNUMBER" in text and "IFERROR" not in text else text), ATOM

    def comparison(self, operation: str, left: str, right: str) -> tuple[str, int]:
        """Without spaces, as cells are written."""
        return super().comparison(operation, left, right)[0].replace(" ", ""), COMPARE

    def function(self, name: str, arguments: Sequence[str]) -> str:
        """A call without spaces."""
        return super().function(name, arguments).replace(", ", ",")


def cell_formula(program: Program) -> str:
    """One formula by LET (Excel 2021, Microsoft 365, LibreOffice 24.8) that names its arguments and gives mu.

    Raises
    ------
    InputError
        It is longer than a cell takes.
    """
    printer = SpreadsheetPrinter()
    parts = [(printer.variable(value.name), printer.number(value.number)) for value in program.coefficients]
    parts += [(printer.variable(step.name), printer.expression(step)) for step in program.steps]
    # backwards from mu: interval and flag have steps of their own
    used, kept = {"mu"}, list[str]()
    for name, expression in reversed(parts):
        if name in used:
            used |= set(re.findall(r"[A-Za-z_]\w*", expression))
            kept.insert(0, f"{name},{expression}")
    text = f"=LET({','.join(kept)},mu)".replace(" ", "")
    if len(text) > _MAX_CELL_LENGTH:
        raise InputError(
            "path",
            f"a formula of {len(text)} characters",
            f"at most {_MAX_CELL_LENGTH} in one cell",
            "Write .xlsx.",
        )
    return text


def spreadsheet_text(program: Program) -> str:
    """The description and the cell formula."""
    head = "\n".join(description(program))
    how = "Define the arguments as names, or write their cells in their place, and enter:"
    return f"{head}\n\n{how}\n\n{cell_formula(program)}\n"


def write_workbook(program: Program, path: Path) -> None:
    """Write the workbook: sheet `friction` with rows to fill in and to copy down, `coefficients`, `about`.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    import xlsxwriter
    from xlsxwriter.exceptions import FileCreateError

    book = xlsxwriter.Workbook(str(path))
    bold = book.add_format({"bold": True})
    soft = book.add_format({"font_color": "#5b6675"})
    given = book.add_format({"bg_color": "#f4f6f9", "border": 1, "border_color": "#d9dee5"})
    head = book.add_format({"bold": True, "bottom": 1, "text_wrap": True, "valign": "bottom"})
    result = book.add_format({"bold": True, "num_format": "0.00000"})
    sheet, numbers, about = (book.add_worksheet(title) for title in ("friction", "coefficients", "about"))
    for row, value in enumerate(program.coefficients, start=1):
        numbers.write(row, 0, value.name)
        numbers.write_number(row, 1, value.number)
        book.define_name(value.name, f"=coefficients!$B${row + 1}")
    numbers.write_row(0, 0, ("coefficient", "value"), bold)
    for row, line in enumerate(description(program)):
        about.write(row, 0, line.strip(), bold if row == 0 else None)

    names = _columns(program)
    units = {argument.name: argument.unit or "-" for argument in program.arguments}
    sheet.write(
        0, 0, "Shaded cells are given; mu, its interval and the flag follow. Copy a whole row down for more.", soft
    )
    for column, name in enumerate(names):
        sheet.write(1, column, name, head)
        sheet.write(2, column, units.get(name, ""), soft)
    inputs = example_rows(program)
    for row in range(_ROWS):
        cells = {name: f"${_letters(column)}{_FIRST_ROW + row + 1}" for column, name in enumerate(names)}
        printer = SpreadsheetPrinter(cells)
        for column, number in enumerate(inputs[row].tolist()):
            sheet.write_number(_FIRST_ROW + row, column, number, given)
        for step in program.steps:
            style = result if step.name in OUTPUTS[:3] else None
            place = (_FIRST_ROW + row, names.index(step.name))
            sheet.write_formula(*place, "=" + printer.expression(step).replace(" ", ""), style)
    sheet.set_row(1, 45)
    sheet.set_column(0, len(program.arguments) - 1, 15)
    sheet.set_column(len(program.arguments), len(names) - 1, 12)
    sheet.freeze_panes(_FIRST_ROW, 0)
    numbers.set_column(0, 1, 22)
    about.set_column(0, 0, 120)
    try:
        book.close()
    except (FileCreateError, OSError) as error:
        raise InputError("path", str(path), "a writable file", f"{error}.") from None


def _columns(program: Program) -> list[str]:
    """Arguments, results, and behind them the steps."""
    steps = [step.name for step in program.steps if step.name not in OUTPUTS]
    return [*(argument.name for argument in program.arguments), *OUTPUTS, *steps]


def _letters(column: int) -> str:
    text = ""
    column += 1
    while column:
        column, rest = divmod(column - 1, 26)
        text = chr(ord("A") + rest) + text
    return text


def example_rows(program: Program) -> Array:
    """Points to start from: the middle of the range, with the sliding from its least to its greatest."""
    steel = Material.load("steel")
    ranges = program.formula.ranges
    middle = {
        name: float(np.sqrt(low * high)) if low > 0.0 else 0.5 * (low + high) for name, (low, high) in ranges.items()
    }
    low, high = ranges.get("slide_to_roll_total", (0.01, 1.0))
    values: dict[str, float] = {
        "effective_modulus": effective_modulus(steel, steel),
        "speed_sliding_lengthwise": 0.0,
        "correlation_length": 30e-6,
        "peklenik_number": 1.0,
        **_oil_at_middle(program, middle),
        **middle,
    }
    rows = np.tile([values.get(argument.name, 0.0) for argument in program.arguments], (_ROWS, 1))
    names = [argument.name for argument in program.arguments]
    if "slide_to_roll" in names:
        rows[:, names.index("slide_to_roll")] = np.geomspace(max(low, 1e-4), high, _ROWS)
    return np.asarray(rows)


def _oil_at_middle(program: Program, middle: Mapping[str, float]) -> dict[str, float]:
    known = [identity.name for identity in program.formula.oils if identity.name is not None]
    oil = Oil.load(known[0] if known else "fva3")
    lubricant = oil.at(middle.get("temperature_oil", 353.15))
    row = lubricant_row(lubricant, middle.get("pressure_hertz", 1e9))
    return {name: row[name] for name in LUBRICANT_UNITS}
