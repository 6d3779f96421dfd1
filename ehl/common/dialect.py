"""Dialect of a table of text, found by its content: separator, decimal sign, and where the numbers begin and end."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from ehl.common.errors import InputError

# words for a value that is missing; numbers such as -999 are values unless a quantity excludes them
MISSING = frozenset(
    (
        *("nan", "bad", "n/a", "na", "#n/a", "none", "null", "void", "invalid", "missing", "masked", "inf", "-inf"),
        *("*", "**", "***", "*****", "-", "--", "---", "?", "1.#qnan", "1.#ind"),
    )
)
_PLAIN = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?")
_GROUPED = {".": re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+\.\d+"), ",": re.compile(r"[+-]?[1-9]\d{0,2}(\.\d{3})+,\d+")}
# with decimal commas elsewhere: 1.5 or 1500?
_AMBIGUOUS = {".": re.compile(r"[+-]?[1-9]\d{0,2},\d{3}"), ",": re.compile(r"[+-]?[1-9]\d{0,2}\.\d{3}")}
_LEADING = re.compile(r"([+-]?[\d.,]*\d[.,]?(?:[eE][+-]?\d+)?)(.*)", re.DOTALL)
_SIGNS = str.maketrans({"\u2212": "-", "\u2013": "-", "\u00a0": " ", "\u202f": " "})


@dataclass(frozen=True)
class Dialect:
    """How a table of text is written."""

    separator: str  # between cells; a blank for any number of blanks
    decimal: str  # decimal sign, a point or a comma

    def cells(self, line: str) -> list[str]:
        """Cells of a line without quotes; empty ones at its end are left out."""
        line = line.strip(" \ufeff\x1a")
        cells = line.split() if self.separator == " " else line.split(self.separator)
        cells = [cell.strip().strip('"').strip() for cell in cells]
        while cells and not cells[-1]:
            cells.pop()
        return cells

    def number(self, cell: str) -> float | None:
        """Value of a cell; nan for an empty one or a word for a missing value, None for another text.

        Raises `InputError`: the cell may be meant with either decimal sign.
        """
        text = cell.translate(_SIGNS).strip()
        if not text or text.casefold() in MISSING:
            return math.nan
        if _AMBIGUOUS[self.decimal].fullmatch(text):
            either = text.replace(",", ".").replace(".", ""), text.replace(",", ".")
            hint = f"{either[1]} or {either[0]}? Write the number without a separator of thousands."
            raise InputError("cell", cell, f"numbers with the decimal sign {self.decimal!r} of the other cells", hint)
        if _GROUPED[self.decimal].fullmatch(text):
            text = text.replace("," if self.decimal == "." else ".", "")
        if self.decimal == ",":
            if "," in text and "." in text:
                return None
            text = text.replace(",", ".")
        return float(re.sub("[dD]", "e", text)) if _PLAIN.fullmatch(text) else None

    def is_numeric(self, cell: str) -> bool:
        """Whether the cell is a number, or stands for a missing one."""
        try:
            return self.number(cell) is not None
        except InputError:
            return True


DIALECTS = tuple(
    Dialect(*pair) for pair in (("\t", "."), (";", "."), (",", "."), (" ", "."), ("\t", ","), (";", ","), (" ", ","))
)


@dataclass(frozen=True)
class NumericBlock:
    """The longest run of lines of numbers in a text."""

    dialect: Dialect  # how they are written
    # numbers of its first and last line, counted from 1; 0 where there is none
    first: int = 0
    last: int = 0
    header: tuple[str, ...] = ()  # lines before it that have content
    rows: tuple[list[str], ...] = field(default=(), repr=False)  # cells of its lines
    numbers: tuple[int, ...] = field(default=(), repr=False)  # number of each of these lines


_SAMPLE = 500  # lines by which the dialect is chosen


def numeric_block(text: str) -> NumericBlock:
    """The table of numbers of a text without named columns, in the dialect that reads most lines as numbers."""
    lines = text.splitlines()
    sample = lines[:: max(1, len(lines) // _SAMPLE)]
    best, score = DIALECTS[0], (0, 0)
    for dialect in DIALECTS:
        if dialect.separator in text or dialect.separator == " ":
            rows = [cells for line in sample if (cells := _numbers(line, dialect))]
            # a separator that cuts lines into more cells wins among those that read as many lines
            reached = (len(rows), max(map(len, rows), default=0))
            if reached > score:
                best, score = dialect, reached
    return _longest_run(lines, best)


def _numbers(line: str, dialect: Dialect) -> list[str]:
    """Cells of a line of numbers; none where it has another text, or no number at all."""
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


def decimals_of(cells: Sequence[str]) -> str:
    """Decimal signs found in cells that are numbers, perhaps with a unit behind: ``"."``, ``","``, or ``".,"``."""
    point = comma = False
    for cell in cells:
        match = _LEADING.match(cell.translate(_SIGNS).strip())
        text = match[1] if match else ""
        if "," in text and not _GROUPED["."].fullmatch(text):
            comma = comma or Dialect(";", ",").is_numeric(text)
        elif "." in text and _PLAIN.fullmatch(text) and not _AMBIGUOUS[","].fullmatch(text):
            point = True
    return ".," if point and comma else "," if comma else "."


def with_point(cell: str, decimals: str, where: str) -> str:
    """A cell that begins with a number, perhaps with its unit behind, with a decimal point; others as they are.

    cell: without blanks at its ends.
    decimals: of the table, as of `decimals_of`.
    where: of the error.
    Raises `InputError`: the number may be meant with either decimal sign.
    """
    match = _LEADING.fullmatch(cell.translate(_SIGNS))
    if match is None or "," not in match[1] + decimals:
        return cell
    text, unit = match[1], match[2]
    if any(_AMBIGUOUS[sign].fullmatch(text) for sign in decimals):
        either = re.sub("[.,]", "", text), text.replace(",", ".")
        hint = f"{either[1]} or {either[0]}? Write numbers without a separator of thousands."
        raise InputError(where, cell, "numbers with the decimal sign of the other cells", hint)
    grouped = next((sign for sign in ".," if _GROUPED[sign].fullmatch(text)), "")
    if grouped:
        text = text.replace("," if grouped == "." else ".", "")
    text = text.replace(",", ".")
    return text + unit if _PLAIN.fullmatch(text) else cell
