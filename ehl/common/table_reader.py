"""Tables a user brings (CSV, XLSX): columns by the names of docs/nomenclature.md, units in the header or in the cells.

A header cell is ``name [unit]`` or a bare name; under a bare name numbers are SI and texts carry their unit. A second
row that holds units alone (as `mixed-ehl sweep merge` writes it) serves too.
"""

from __future__ import annotations

import io
import math
import re
import warnings
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ehl.common.errors import InputError, near
from ehl.common.files import read_bytes, read_text
from ehl.common.units import ValueRange, parse_quantity

if TYPE_CHECKING:
    import pandas as pd

# a header such as "pressure_hertz [GPa]"; round brackets are common in spreadsheets
_HEADER = re.compile(r"(?P<name>[^\[(]+?)\s*(?:[\[(]\s*(?P<unit>[^\])]*?)\s*[\])])?")
_DECIMAL_COMMA = re.compile(r"^\s*([+-]?\d+),(\d+(?:[eE][+-]?\d+)?)\s*$")
_WORKBOOKS = (".xlsx", ".xlsm")
MAX_ROWS = 1_000_000
MAX_COLUMNS = 1000
MAX_CELLS = 10_000_000
_SHEET_ROWS = 2**20  # of the format
MAX_UNPACKED = 1_000_000_000  # of a workbook [bytes]

# what a spreadsheet takes for the beginning of a formula
_FORMULA = ("=", "+", "-", "@", "\t", "\r")

# what others call our columns
_OTHER_NAMES = {
    **dict.fromkeys(("mu", "cof", "friction", "traction", "traction_coefficient"), "friction_coefficient"),
    **dict.fromkeys(("srr", "sr", "slip", "slide_roll_ratio"), "slide_to_roll"),
    **dict.fromkeys(("speed", "velocity", "rolling_speed", "entrainment_speed", "u_e"), "speed_entrainment"),
    **dict.fromkeys(("temperature", "temp", "oil_temperature"), "temperature_oil"),
    **dict.fromkeys(("pressure", "hertz_pressure", "p_h"), "pressure_hertz"),
    **dict.fromkeys(("radius", "r"), "radius_equivalent"),
    **dict.fromkeys(("rq", "roughness"), "roughness_rms"),
    **dict.fromkeys(("time", "duration", "share"), "hours"),
}

Cell = float | int | str | None
Column = tuple[float, ...] | tuple[str, ...]


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
    cells = _read_cells(path)
    if cells.empty:
        raise InputError(path.name, "no rows", "a header and at least one row")
    header = [_HEADER.fullmatch(str(cell).strip()) for cell in cells.iloc[0]]
    names = [match["name"].strip() if match else "" for match in header]
    # beside the table of a workbook there may be notes
    while names and not names[-1]:
        names.pop()
    units = [match["unit"] if match else None for match in header[: len(names)]]
    _check_names(path, names, quantities, required)
    if path.suffix.lower() not in _WORKBOOKS:
        _check_width(path, cells, len(names))
    body = cells.iloc[1:, : len(names)]
    if len(body) and _are_units(list(body.iloc[0]), names, units, quantities):
        units = [str(cell).strip() or None for cell in body.iloc[0]]
        body = body.iloc[1:]
    if body.empty:
        raise InputError(path.name, "a header without rows", "at least one row below the header")
    columns: dict[str, Column] = {}
    for position, (name, unit) in enumerate(zip(names, units, strict=True)):
        if name.startswith("#"):
            continue
        quantity = quantities[name]
        where = [f"{path.name}, row {number}, {name}" for number in body.index]
        column = zip(body.iloc[:, position], where, strict=True)
        if quantity is None:
            columns[name] = tuple(_text(cell, place) for cell, place in column)
        else:
            columns[name] = tuple(_number(cell, unit, quantity, place, bare) for cell, place in column)
    return columns, tuple(int(number) for number in body.index)


def _check_width(path: Path, cells: pd.DataFrame, width: int) -> None:
    """Refuse rows of a CSV file with more cells than the header: most often a decimal comma cut a number in two."""
    for number, row in zip(cells.index[1:], cells.iloc[1:, width:].to_numpy(), strict=True):
        more = sum(bool(str(cell).strip()) for cell in row)
        if more:
            hint = "Where a comma is the decimal sign, separate cells by semicolons. A column of notes begins with '#'."
            raise InputError(
                f"{path.name}, row {number}", f"{width + more} cells", f"{width} cells as in the header", hint
            )


def _check_names(
    path: Path, names: Sequence[str], quantities: Mapping[str, ValueRange | None], required: Sequence[str]
) -> None:
    known = ", ".join(quantities)
    for name in names:
        if not name.startswith("#") and name not in quantities:
            other = _OTHER_NAMES.get(name.lower(), "")
            hint = f"Did you mean {other!r}?" if other in quantities else near(name, quantities)
            hint = f"{hint} A column of notes begins with '#'.".strip()
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
        text = str(row[position]).strip()
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
    if text.startswith(tuple(f"'{sign}" for sign in _FORMULA)):
        text = text[1:]  # as `harmless` wrote it
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
        except (ValueError, OverflowError):
            # a cell may carry a unit of its own
            number = math.nan
        value = f"{number!r} {unit}" if math.isfinite(number) else value
    return quantity.check(value, where, bare=bare or not quantity.unit)


def _read_cells(path: Path) -> pd.DataFrame:
    """The cells of a file as they are, in rows numbered as in the file from 1; rows without content left out."""
    allowed = "an existing CSV or XLSX file"
    if path.suffix.lower() in _WORKBOOKS:
        return _read_xlsx(path, read_bytes(path, "file", allowed))
    return _read_csv(path, read_text(path, "file", allowed))


def _check_size(path: Path, rows: int, columns: int) -> None:
    """Refuse a table that memory has no room for; `columns` is the width of the widest row."""
    for found, most, what in ((rows, MAX_ROWS, "rows"), (columns, MAX_COLUMNS, "columns")):
        if found > most:
            raise InputError(path.name, f"{found} {what}", f"at most {most} {what}")
    if rows * columns > MAX_CELLS:
        raise InputError(path.name, f"{rows} rows of {columns} cells", f"at most {MAX_CELLS} cells")


def _read_csv(path: Path, text: str) -> pd.DataFrame:
    import pandas as pd

    # a line of notes becomes an empty one, so that rows keep their numbers
    lines = [line if line.strip() and not line.startswith("# ") else "" for line in text.splitlines()]
    separator = max(",;\t", key=next((line for line in lines if line), "").count)
    width = max((line.count(separator) for line in lines), default=0) + 1
    _check_size(path, sum(map(bool, lines)), width)
    try:
        frame = pd.read_csv(
            io.StringIO("\n".join(lines)),
            sep=separator,
            header=None,
            names=range(width),
            index_col=False,
            dtype=str,
            na_filter=False,
            skip_blank_lines=False,
        )
    except pd.errors.EmptyDataError:
        return pd.DataFrame()
    except pd.errors.ParserError as error:
        raise InputError("file", str(path), "a CSV file", f"It could not be read: {error}.") from None
    frame = frame.fillna("")
    # a cell in quotes may hold line breaks
    height = 1 + frame.apply(lambda column: column.str.count("\n")).sum(axis=1)
    frame.index = 1 + height.cumsum() - height
    frame = frame[[bool(lines[min(number, len(lines)) - 1]) for number in frame.index]]
    return frame if separator == "," else frame.replace(_DECIMAL_COMMA, r"\1.\2", regex=True)


def _read_xlsx(path: Path, content: bytes) -> pd.DataFrame:
    import pandas as pd

    try:
        import openpyxl
    except ImportError:
        hint = 'Install it by pip install "mixed-ehl[excel]", or save the sheet as CSV.'
        raise InputError("file", str(path), "CSV, unless openpyxl is installed", hint) from None
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as parts:
            size = sum(part.file_size for part in parts.infolist())
        if size > MAX_UNPACKED:
            hint = f"Unpacked it has {size} bytes; at most {MAX_UNPACKED} are read."
            raise InputError("file", str(path), "a smaller XLSX file", hint)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of extensions of the format, which hold no cells
            book = openpyxl.load_workbook(io.BytesIO(content), read_only=True, data_only=True)
            rows = _xlsx_rows(path, book.worksheets[0])
    except InputError:
        raise
    except Exception as error:  # openpyxl lets errors of zip and XML through
        raise InputError("file", str(path), "a readable XLSX file", f"It could not be read: {error}.") from None
    width = max(map(len, rows.values()), default=0)
    return pd.DataFrame([row + [""] * (width - len(row)) for row in rows.values()], index=list(rows), dtype=object)


def _xlsx_rows(path: Path, sheet: Any) -> dict[int, list[Cell]]:
    """Rows with content by their number; a sheet may state a wrong size, or have its one cell far down."""
    sheet.reset_dimensions()
    rows: dict[int, list[Cell]] = {}
    width = 0
    for number, cells in enumerate(sheet.iter_rows(values_only=True), 1):
        if number > _SHEET_ROWS:  # a row may state any number, and the reader fills up to it
            raise InputError("file", str(path), f"rows numbered up to {_SHEET_ROWS}, as XLSX has them")
        row = ["" if cell is None else _cell(cell) for cell in cells]
        while row and row[-1] == "":
            row.pop()
        if row:
            rows[number] = row
            width = max(width, len(row))
            _check_size(path, len(rows), width)
    return rows


def _cell(cell: object) -> Cell:
    """Numbers and texts as they are; dates and truth values as text, so that an error shows what stands there."""
    return cell if isinstance(cell, (int, float, str)) and not isinstance(cell, bool) else str(cell)


def harmless(value: Cell) -> Cell:
    """A cell to be written that a spreadsheet does not compute: an apostrophe stands before a text such as ``=1+1``."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str) and value.startswith(_FORMULA):
        try:
            float(value)
        except ValueError:
            return f"'{value}"
    return value


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
