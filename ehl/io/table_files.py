"""Tables a user brings (CSV, XLSX): columns by the names of docs/nomenclature.md, units in the header or in the cells.

A header cell is ``name [unit]`` or a bare name; under a bare name numbers are SI and texts carry their unit. A second
row that holds units alone (as `mixed-ehl sweep merge` writes it) serves too.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ehl.io.errors import InputError
from ehl.io.units import ValueRange, parse_quantity

# a header such as "pressure_hertz [GPa]"; round brackets are common in spreadsheets
_HEADER = re.compile(r"(?P<name>[^\[(]+?)\s*(?:[\[(]\s*(?P<unit>[^\])]*?)\s*[\])])?")
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")
MAX_ROWS = 1_000_000

Cell = float | int | str | None
Column = tuple[float, ...] | tuple[str, ...]
# rows that are not empty, each with its number in the file, counted from 1
Rows = list[tuple[int, list[Cell]]]


def read_table(
    path: Path,
    quantities: Mapping[str, ValueRange | None],
    required: Sequence[str] = (),
    *,
    bare: bool = True,
) -> dict[str, Column]:
    """Columns of a table file, checked and converted to SI.

    Parameters
    ----------
    path : Path
        CSV (comma, semicolon or tab; decimal comma where the separator is not one) or XLSX, first sheet.
    quantities : mapping
        Unit and range of every column there may be; None for a column of text. Columns whose name begins with ``#`` are
        notes and left out.
    required : sequence of str
        Columns there must be.
    bare : bool
        Whether a number without any unit counts as SI.

    Raises
    ------
    InputError
        The file cannot be read, lacks a column, has one nobody knows, or a cell cannot be used; it is named.
    """
    return numbered_table(path, quantities, required, bare=bare)[0]


def numbered_table(
    path: Path,
    quantities: Mapping[str, ValueRange | None],
    required: Sequence[str] = (),
    *,
    bare: bool = True,
) -> tuple[dict[str, Column], tuple[int, ...]]:
    """The same as `read_table`, and the number of each row in the file, counted from 1 as editors do."""
    rows = _rows_of(path)
    if not rows:
        raise InputError(path.name, "no rows", "a header and at least one row")
    header = [_HEADER.fullmatch(str(cell or "").strip()) for cell in rows[0][1]]
    names = [match["name"].strip() if match else "" for match in header]
    units = [match["unit"] if match else None for match in header]
    _check_names(path, names, quantities, required)
    first = 1
    if len(rows) > 1 and _are_units(rows[1][1], names, units, quantities):
        units = [str(cell).strip() if cell not in (None, "") else None for cell in rows[1][1]]
        first = 2
    if len(rows) == first:
        raise InputError(path.name, "a header without rows", "at least one row below the header")
    if len(rows) - first > MAX_ROWS:
        raise InputError(path.name, f"{len(rows) - first} rows", f"at most {MAX_ROWS} rows")
    columns: dict[str, Column] = {}
    for position, (name, unit) in enumerate(zip(names, units, strict=True)):
        if name.startswith("#"):
            continue
        cells = [row[position] if position < len(row) else None for _, row in rows[first:]]
        quantity = quantities[name]
        where = [f"{path.name}, row {number}, {name}" for number, _ in rows[first:]]
        if quantity is None:
            columns[name] = tuple(_text(cell, place) for cell, place in zip(cells, where, strict=True))
        else:
            checked = (_number(cell, unit, quantity, place, bare) for cell, place in zip(cells, where, strict=True))
            columns[name] = tuple(checked)
    return columns, tuple(number for number, _ in rows[first:])


def _check_names(
    path: Path, names: Sequence[str], quantities: Mapping[str, ValueRange | None], required: Sequence[str]
) -> None:
    known = ", ".join(quantities)
    for name in names:
        if not name.startswith("#") and name not in quantities:
            hint = "A column of notes begins with '#'."
            raise InputError(f"{path.name}, header", name, f"columns named {known}", hint)
        if names.count(name) > 1:
            raise InputError(f"{path.name}, header", name, "each column once")
    for name in required:
        if name not in names:
            raise InputError(f"{path.name}, column {name}", None, f"columns {', '.join(required)}")


def _are_units(
    row: Sequence[Cell], names: Sequence[str], units: Sequence[str | None], quantities: Mapping[str, ValueRange | None]
) -> bool:
    """Whether the second row holds units: a unit under every number column, and none in the header."""
    found = False
    for position, name in enumerate(names):
        quantity = quantities.get(name)
        if quantity is None:
            continue
        cell = row[position] if position < len(row) else None
        text = str(cell or "").strip()
        if units[position] is not None or not text:
            return False
        if quantity.unit == "":
            if text not in ("1", "-", "%"):
                return False
            continue
        try:
            parse_quantity(f"1 {text}", quantity.unit)
        except InputError:
            return False
        if text[0].isdigit() and "/" not in text:
            return False
        found = True
    return found


def _text(cell: Cell, where: str) -> str:
    text = "" if cell is None else str(cell).strip()
    if not text:
        raise InputError(where, None, "a text")
    return text


def _number(cell: Cell, unit: str | None, quantity: ValueRange, where: str, bare: bool) -> float:
    value: Cell = cell.strip() if isinstance(cell, str) else cell
    if value is None or value == "":
        raise InputError(where, None, quantity.expected, "The cell is empty.")
    if unit and unit != "1" and unit != "-":
        try:
            number = float(value)
        except ValueError:
            # a cell may carry a unit of its own
            number = math.nan
        value = f"{number!r} {unit}" if math.isfinite(number) else value
    return quantity.check(value, where, bare=bare or not quantity.unit)


def _rows_of(path: Path) -> Rows:
    if path.suffix.lower() in (".xlsx", ".xlsm"):
        return _xlsx_rows(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise InputError("file", str(path), "an existing CSV or XLSX file", "Check the path.") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            "file", str(path), "a readable UTF-8 CSV file, or XLSX", f"It could not be read: {error}."
        ) from None
    # a line of notes or without content stays in place as an empty one, so that rows keep their numbers
    lines = [line if line.strip() and not line.startswith("# ") else "" for line in text.splitlines()]
    separator = max(",;\t", key=next((line for line in lines if line), "").count)
    reader = csv.reader(io.StringIO("\n".join(lines)), delimiter=separator)
    rows: Rows = []
    start = 1
    try:
        for row in reader:
            if row:
                rows.append((start, [*row]))
            # a cell in quotes may hold line breaks
            start = reader.line_num + 1
    except csv.Error as error:
        raise InputError("file", str(path), "a CSV file", f"It could not be read: {error}.") from None
    if separator == ",":
        return rows
    return [(number, [_decimal_point(cell) for cell in row]) for number, row in rows]


def _decimal_point(cell: Cell) -> Cell:
    text = str(cell).strip()
    return text.replace(",", ".") if _DECIMAL_COMMA.fullmatch(text) else cell


def _xlsx_rows(path: Path) -> Rows:
    try:
        from openpyxl import load_workbook
    except ImportError:
        hint = 'Install it by pip install "mixed-ehl[excel]", or save the sheet as CSV.'
        raise InputError("file", str(path), "CSV, unless openpyxl is installed", hint) from None
    try:
        book = load_workbook(path, read_only=True, data_only=True)
    except FileNotFoundError:
        raise InputError("file", str(path), "an existing CSV or XLSX file", "Check the path.") from None
    except Exception as error:  # openpyxl lets errors of zip and XML through
        raise InputError("file", str(path), "a readable XLSX file", f"It could not be read: {error}.") from None
    try:
        rows = [(number, [_cell(cell) for cell in row]) for number, row in enumerate(book.worksheets[0].values, 1)]
    finally:
        book.close()
    return [(number, row) for number, row in rows if any(cell not in (None, "") for cell in row)]


def _cell(cell: object) -> Cell:
    """Numbers and texts as they are; dates and truth values as text, so that a complaint shows what stands there."""
    if cell is None or (isinstance(cell, (int, float, str)) and not isinstance(cell, bool)):
        return cell
    return str(cell)


def read_columns(value: Any, quantities: Mapping[str, ValueRange | None]) -> dict[str, Column]:
    """Columns a plan holds itself, as lists of equal length, or those of the file it names.

    Raises
    ------
    InputError
        As `read_table`; or the lists differ in length.
    """
    if not isinstance(value, dict):
        raise InputError("table", value, "a table of columns, or file = 'points.csv'")
    if "file" in value:
        if len(value) > 1:
            raise InputError("file", value["file"], "either a file or columns, not both")
        return read_table(Path(str(value["file"])), quantities)
    columns: dict[str, Column] = {}
    for name, cells in value.items():
        if name not in quantities:
            raise InputError(name, cells, "columns named " + ", ".join(quantities))
        if not isinstance(cells, (list, tuple)) or not 1 <= len(cells) <= MAX_ROWS:
            raise InputError(name, cells, f"a list of 1 to {MAX_ROWS} entries")
        quantity = quantities[name]
        if quantity is None:
            columns[name] = tuple(_text(cell, f"{name}[{i}]") for i, cell in enumerate(cells))
        else:
            columns[name] = tuple(quantity.check(cell, f"{name}[{i}]") for i, cell in enumerate(cells))
    lengths = {name: len(cells) for name, cells in columns.items()}
    if len(set(lengths.values())) > 1:
        raise InputError(next(iter(lengths)), lengths, "columns of one length")
    return columns
