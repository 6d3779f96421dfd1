"""Dialect of a text table, determined from its content: separator, decimal sign, first and last line of numbers."""

import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from ehl.common.errors import InputError

# words for a value that is missing; numbers such as -999 are values unless a quantity excludes them
MISSING = frozenset(
    (
        *("nan", "bad", "n/a", "na", "#n/a", "none", "null", "void", "invalid", "missing", "masked", "inf", "-inf"),
        *("n.a.", "k.a.", "ungültig", "fehlt", "fehler", "leer", "error", "err", "fail", "failed", "undefined"),
        *("overload", "overflow", "#value!", "#wert!", "#div/0!", "#nv", "no data", "keine daten"),
        *("*", "**", "***", "*****", "-", "--", "---", "?", "1.#qnan", "1.#ind"),
    )
)
_PLAIN = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?")
_GROUPED = {".": re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+\.\d+"), ",": re.compile(r"[+-]?[1-9]\d{0,2}(\.\d{3})+,\d+")}
# with decimal commas elsewhere: 1.5 or 1500?
_AMBIGUOUS = {".": re.compile(r"[+-]?[1-9]\d{0,2},\d{3}"), ",": re.compile(r"[+-]?[1-9]\d{0,2}\.\d{3}")}
_COMMAS = re.compile(r"[+-]?\d+,\d+")
_SPACED = re.compile(r"([+-]?[1-9]\d{0,2}(?:[ '’]\d{3})+)((?![\d'’]).*)")
_LEADING = re.compile(r"([+-]?[\d.,]*\d[.,]?(?:[eE][+-]?\d+)?)(.*)", re.DOTALL)
_DATE = re.compile(r"\d{1,4}[./-]\d{1,2}[./-]\d{1,4}|\d{1,2}:\d{2}(:\d{2}([.,]\d+)?)?")  # or a time
_SIGNS = str.maketrans({"\u2212": "-", "\u2013": "-", **dict.fromkeys("\u00a0\u2009\u202f", " ")})


@dataclass(frozen=True)
class Dialect:
    """Separator and decimal sign of a text table."""

    separator: str  # separator of cells; a blank means any number of blanks
    decimal: str  # decimal sign, a point or a comma
    unsure: bool = False  # whether the other one is possible as well

    def cells(self, line: str) -> list[str]:
        """Cells of a line without quotes and without empty cells at its end."""
        line = line.strip(" \ufeff\x1a")
        if '"' in line and self.separator == ",":  # with decimal commas
            cells = next(csv.reader([line]))
        else:
            cells = line.split() if self.separator == " " else line.split(self.separator)
        cells = [cell.strip().strip('"').strip() for cell in cells]
        while cells and not cells[-1]:
            cells.pop()
        return cells

    def number(self, cell: str) -> float | None:
        """Value of a cell; nan for an empty cell, a missing value or a date, None for another text.

        Raises `InputError`: the decimal sign of the cell is ambiguous.
        """
        text = cell.translate(_SIGNS).strip()
        if not text or text.casefold() in MISSING or _DATE.fullmatch(text):
            return math.nan
        if any(_AMBIGUOUS[sign].fullmatch(text) for sign in (".," if self.unsure else self.decimal)):
            raise _ambiguous("cell", cell, text)
        if _GROUPED[self.decimal].fullmatch(text):
            text = text.replace("," if self.decimal == "." else ".", "")
        if self.decimal == ",":
            if "," in text and "." in text:
                return None
            text = text.replace(",", ".")
        return float(re.sub("[dD]", "e", text)) if _PLAIN.fullmatch(text) else None

    def is_numeric(self, cell: str) -> bool:
        """Whether the cell is a number or a missing value."""
        try:
            return self.number(cell) is not None
        except InputError:
            return True


DIALECTS = tuple(Dialect(separator, decimal) for decimal in ".," for separator in "\t;, ")


@dataclass(frozen=True)
class NumericBlock:
    """The longest run of lines of numbers in a text."""

    dialect: Dialect  # their dialect
    # first and last line, counted from 1; 0 if there is none
    first: int = 0
    last: int = 0
    header: tuple[str, ...] = ()  # lines with content before it
    rows: tuple[list[str], ...] = field(default=(), repr=False)  # cells of its lines
    numbers: tuple[int, ...] = field(default=(), repr=False)  # number of each of these lines


_SAMPLE = 500  # number of lines from which the dialect is determined


def numeric_block(text: str) -> NumericBlock:
    """The table of numbers of a text without named columns, in the dialect that gives the most lines of numbers."""
    lines = text.splitlines()
    sample = lines[:: max(1, len(lines) // _SAMPLE)]
    best, score = DIALECTS[0], (0, 0)
    for dialect in DIALECTS:
        if dialect.separator in text or dialect.separator == " ":
            rows = [cells for line in sample if (cells := _numbers(line, dialect))]
            # among dialects with equal numbers of lines the one with more cells is chosen
            reached = (len(rows), max(map(len, rows), default=0))
            if reached > score:
                best, score = dialect, reached
    block = _longest_run(lines, best)
    pairs = best.separator == "," and all(map(_COMMAS.fullmatch, map(",".join, block.rows)))
    if pairs and any(row[1].startswith("0") and len(row[1]) > 1 for row in block.rows):
        best = Dialect(";", ",")  # one column: no integer begins with a zero
        block = _longest_run(lines, best)
    unsure = best.decimal == "." and decimals_of([cell for row in block.rows for cell in row], best.separator) == ".,"
    return replace(block, dialect=replace(best, unsure=unsure))


def _numbers(line: str, dialect: Dialect) -> list[str]:
    """Cells of a line of numbers; none if the line has another text or no number."""
    cells = [] if line.lstrip().startswith("#") else dialect.cells(line)
    some = any(cell[-1:].isdigit() or cell[-1:] == "." for cell in cells)
    return cells if some and all(map(dialect.is_numeric, cells)) else []


def _longest_run(lines: Sequence[str], dialect: Dialect) -> NumericBlock:
    runs: list[list[tuple[int, list[str]]]] = [[]]
    for number, line in enumerate(lines, 1):
        if cells := _numbers(line, dialect):
            runs[-1].append((number, cells))
        elif runs[-1] and line.strip():
            runs.append([])
    run = max(runs, key=len)
    if not run:
        return NumericBlock(dialect)
    widths = [len(cells) for _, cells in run]
    width = max(set(widths), key=widths.count)
    while len(run[0][1]) < width:  # a number of points, say, belongs to the header
        run.pop(0)
    first = run[0][0]
    header = tuple(line.strip() for line in lines[: first - 1] if line.strip())
    return NumericBlock(dialect, first, run[-1][0], header, tuple(cells for _, cells in run), tuple(n for n, _ in run))


def decimals_of(cells: Sequence[str], separator: str = "") -> str:
    """Decimal signs in cells that are numbers with or without a unit: ``"."``, ``","``, or ``".,"``.

    Semicolons separate the cells of countries with decimal commas: without a comma and without a number that only a
    point as decimal sign can have (0.5, 12.25, 1234.5) either sign is possible there.
    """
    point = comma = False
    for cell in cells:
        match = _LEADING.match(cell.translate(_SIGNS).strip())
        text = match[1] if match else ""
        if "," in text and not _GROUPED["."].fullmatch(text):
            comma = comma or Dialect(";", ",").is_numeric(text)
        elif "." in text and _PLAIN.fullmatch(text) and not _AMBIGUOUS[","].fullmatch(text):
            point = True
    if separator == ";" and not point and not comma:
        return ".,"
    return ".," if point and comma else "," if comma else "."


def with_point(cell: str, decimals: str, where: str) -> str:
    """A cell that begins with a number, converted to a decimal point; other cells are unchanged.

    cell: text without blanks at its ends.
    decimals: result of `decimals_of` for the table.
    where: field of the error.
    Raises `InputError`: the decimal sign of the number is ambiguous.
    """
    cell = cell.translate(_SIGNS)
    if (spaced := _SPACED.fullmatch(cell)) is not None:  # of thousands: a cell is no list
        cell = re.sub("[ '’]", "", spaced[1]) + spaced[2]
    match = _LEADING.fullmatch(cell)
    if match is None:
        return cell
    text, unit = match[1], match[2]
    if "," not in text + decimals:
        return text + unit
    if any(_AMBIGUOUS[sign].fullmatch(text) for sign in decimals):
        raise _ambiguous(where, cell, text)
    grouped = next((sign for sign in ".," if _GROUPED[sign].fullmatch(text)), "")
    if grouped:
        text = text.replace("," if grouped == "." else ".", "")
    text = text.replace(",", ".")
    return text + unit if _PLAIN.fullmatch(text) else cell


def _ambiguous(where: str, cell: str, text: str) -> InputError:
    small, large = text.replace(",", "."), re.sub("[.,]", "", text)
    hint = f"{small} or {large}? Write {small}0 or {large}, without a separator of thousands."
    return InputError(where, cell, "numbers with an unambiguous decimal sign", hint)
