"""Reader of tables of the user (CSV, XLSX), which finds dialect, header and units from the content.

A header cell is ``name [unit]``, ``name (unit)``, ``name / unit`` or a bare name; under a bare name numbers are SI and
texts have their unit. The units may also be in a second row (as `mixed-ehl sweep merge` writes them). Names are those
of docs/nomenclature.md in any spelling, or the usual ones of other programs and test rigs (data/column_names.csv).

A table whose names are all exact is strict: each column, row and cell must be usable. A table of another program (names
that correspond to those of the program, or lines above the header) is not: other columns, lines between the rows and
rows with missing values are left out, and a note states the meaning of each column.
"""

from __future__ import annotations

import io
import logging
import math
import re
import warnings
import zipfile
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ehl.common.data import data_rows
from ehl.common.dialect import MISSING, decimals_of, with_point
from ehl.common.errors import InputError, near, remedy
from ehl.common.files import read_bytes, read_text
from ehl.common.units import ValueRange, parse_quantity

if TYPE_CHECKING:
    import pandas as pd

_LOG = logging.getLogger("mixed_ehl")
# a header such as "pressure_hertz [GPa]"; round brackets are common in spreadsheets; what follows # is a comment
_HEADER = re.compile(r"(?P<name>[^\[(#]+?|#.*)\s*(?:[\[(]\s*(?P<unit>[^\])]*?)\s*[\])].*?)?(?:\s#.*)?")
_MOST_WRONG = 1000  # cells that cannot be used, after which a table is not read further
_HEADER_LINES = 200  # among the first of these the header is looked for
# first cell of a row that a spreadsheet or a test rig adds below the data
_STATISTICS = (
    *("mean", "average", "avg", "median", "min", "max", "minimum", "maximum", "std", "sd", "stdev", "stddev", "rms"),
    *("sum", "total", "count", "mittelwert", "mittel", "summe", "stabw", "standardabweichung", "anzahl", "gesamt"),
)
_PLACEHOLDERS = re.compile(r"-?9{1,6}(\.0*)?")  # of missing values, where the quantity cannot have them
_CODES = re.compile(r"-9{3,6}(\.0*)?")  # which a signed quantity could have
_WORKBOOKS = (".xlsx", ".xlsm")
MAX_ROWS = 1_000_000
MAX_COLUMNS = 1000
MAX_CELLS = 10_000_000
_SHEET_ROWS = 2**20  # of the format
MAX_UNPACKED = 1_000_000_000  # of a workbook [bytes]

# what a spreadsheet takes for the beginning of a formula
_FORMULA = ("=", "+", "-", "@", "\t", "\r")

Cell = float | int | str | None
Quantities = Mapping[str, ValueRange | None]  # unit and range of every column there may be; None for a text
Column = tuple[float, ...] | tuple[str, ...]


@dataclass(frozen=True)
class _Head:
    """One row of a header: what its columns are."""

    position: int
    names: tuple[str, ...]
    units: tuple[str | None, ...]
    quantities: tuple[str, ...]
    exact: bool

    @property
    def score(self) -> int:
        """Number of quantities found."""
        return len({name for name in self.quantities if name})


def read_table(
    path: Path,
    quantities: Quantities,
    required: Sequence[str] = (),
    *,
    bare: bool = True,
    missing: bool = False,
    instead: Mapping[str, str] | None = None,
) -> tuple[dict[str, Column], tuple[int, ...]]:
    """Columns of a table file, checked and converted to SI, and the number of each row in it, counted from 1.

    path: text of any encoding, separator and decimal sign, or the first sheet of a workbook.
    quantities: unit and range of every column there may be; None for a column of text. Columns whose name begins with
        ``#`` are notes and omitted.
    required: columns there must be.
    bare: whether a number without any unit is in SI units.
    missing: whether rows that hold ``nan``, ``Bad``, ``-999`` or the like are left out; in the table of another program
        also those with an empty cell.
    instead: remedies for names that are no column (`ehl.common.errors.remedy`).
    Raises `InputError`: the file cannot be read, lacks a column, has an unknown one, or a cell cannot be used; it is
    named.
    """
    allowed, workbook = "an existing CSV or XLSX file", path.suffix.lower() in _WORKBOOKS
    if workbook:
        cells = _read_xlsx(path, read_bytes(path, "file", allowed))
    else:
        cells = _read_csv(path, read_text(path, "file", allowed), quantities)
    if cells.empty:
        raise InputError(path.name, "no rows", "a header and at least one row")
    heads = _heads(cells, quantities)
    foreign = not heads[0].exact or heads[0].position > 0
    if foreign:
        heads = [_distinct(head) for head in heads]
    else:
        _check_names(path, heads[0], quantities, instead or {})
    _require(path, heads[0], required, quantities)
    if not foreign and not workbook:
        _check_width(path, cells, len(heads[0].names))
    found: dict[str, list[Any]] = {}
    numbers: list[int] = []
    left_out, other = 0, list[int]()
    ends = [head.position for head in heads[1:]] + [len(cells)]
    for block, (head, end) in enumerate(zip(heads, ends, strict=True), 1):
        taken = {name: k for k, name in enumerate(head.quantities) if name}
        if not foreign or taken.keys() >= set(required):
            body = cells.iloc[head.position + 1 : end]
            rows, out, more = _block(path, body, head, taken, quantities, bare, foreign, missing)
            left_out, other = left_out + out, other + more
            for number, values in rows:
                numbers.append(number)
                for name, value in values.items():
                    found.setdefault(name, []).append(value)
            if "curve" in quantities and "curve" not in taken and len(heads) > 1:
                found.setdefault("curve", []).extend([str(block)] * len(rows))
    whole = {name: tuple(values) for name, values in found.items() if len(values) == len(numbers)}
    if not numbers:
        raise InputError(path.name, "a header without rows", "at least one row below the header")
    if left_out > len(numbers):
        raise InputError(
            path.name, f"{left_out} rows with missing values", f"fewer than the {len(numbers)} complete ones"
        )
    if foreign or left_out or other:
        _log_columns(path, heads[0], left_out, other)
    return whole, tuple(numbers)


def _block(
    path: Path,
    body: pd.DataFrame,
    head: _Head,
    taken: Mapping[str, int],
    quantities: Quantities,
    bare: bool,
    foreign: bool,
    missing: bool,
) -> tuple[list[tuple[int, dict[str, Any]]], int, list[int]]:
    """Number and values of the rows below a header, how many lack a value, and the rows that are no data."""
    units = list(head.units)
    body = body.iloc[:, : len(units)]
    if len(body) and _are_units(list(body.iloc[0]), head.quantities, units, quantities):
        units = [str(cell).strip() or None for cell in body.iloc[0]]
        body = body.iloc[1:]
    for k, (name, found) in enumerate(zip(head.names, head.quantities, strict=True)):
        own = quantities.get(found)
        if units[k] is None and own is not None and own.unit and _fits(name, own):
            units[k] = name  # a column named after its unit, such as hours
    separator = str(body.attrs.get("separator", ""))
    decimals = decimals_of([cell for cell in body.to_numpy().ravel() if isinstance(cell, str)], separator)
    rows: list[tuple[int, dict[str, Any]]] = []
    wrong: dict[object, InputError] = {}
    left_out, other, last = 0, list[int](), head.position
    labelled = any(k == 0 and quantities[name] is None for name, k in taken.items())
    for number, row in zip(body.index, body.to_numpy(), strict=True):
        used = {name: row[k] for name, k in taken.items()}
        texts = not any(_looks_numeric(cell) for cell in used.values())
        added = not labelled and str(row[0]).strip(" .:").casefold() in _STATISTICS
        if added or (texts and rows and not foreign and number > last + 1):
            other.append(int(number))
            if texts and not foreign:  # another table behind an empty line
                break
            continue
        last = number
        if foreign and texts:
            continue  # a line of text between the steps of a test rig
        values: dict[str, Any] = {}
        for name, cell in used.items():
            quantity, where = quantities[name], f"{path.name}, row {number}, {head.names[taken[name]]}"
            if quantity is not None and missing and _is_missing(cell, units[taken[name]], quantity, empty=foreign):
                break
            try:
                if quantity is None:
                    values[name] = _text(cell, where)
                else:
                    values[name] = _number(cell, units[taken[name]], quantity, where, bare, decimals)
            except InputError as error:
                if quantity and quantity.unit and not bare and not units[taken[name]] and _looks_numeric(cell):
                    column, hint = f"{path.name}, column {head.names[taken[name]]}", "Write the unit into its header."
                    wrong.setdefault(name, InputError(column, cell, error.allowed, hint))
                else:
                    wrong[number, name] = error
        else:
            rows.append((int(number), values))
            continue
        left_out += 1
        if len(wrong) > _MOST_WRONG:
            break
    if wrong:
        raise InputError.of(wrong.values())
    return rows, left_out, other


def _looks_numeric(cell: Cell) -> bool:
    return isinstance(cell, int | float) or str(cell).strip()[-1:].isdigit()


def _is_missing(cell: Cell, unit: str | None, quantity: ValueRange, *, empty: bool) -> bool:
    """Whether a cell holds a word for a missing value, or a number such as -999 that the quantity cannot have."""
    text = "" if cell is None else str(cell).strip()
    if not text:
        return empty
    if text.casefold() in MISSING:
        return True
    if not _PLACEHOLDERS.fullmatch(text):
        return False
    try:
        quantity.check(f"{text} {unit}" if unit and unit not in ("1", "-") else float(text), "cell")
    except InputError:
        return True
    return False


def _log_columns(path: Path, head: _Head, left_out: int, others: Sequence[int]) -> None:
    """Note the meaning of each column."""
    pairs = [(name, mine) for name, mine in zip(head.names, head.quantities, strict=True) if name]
    named = [f"{name} -> {mine}" for name, mine in pairs if mine and name != mine]
    other = [name for name, mine in pairs if not mine]
    parts = [", ".join(named)] if named else []
    parts += [f"not used: {', '.join(other)}"] if other else []
    parts += [f"rows with missing values, omitted: {left_out}"] if left_out else []
    if others:
        parts.append(f"row {', '.join(map(str, others))}: statistics or another table, omitted")
    if parts:
        _LOG.info("%s: %s", path.name, "; ".join(parts))


def _heads(cells: pd.DataFrame, quantities: Quantities) -> list[_Head]:
    """The header, and every later row that repeats it or most of it."""
    first = _head(0, list(cells.iloc[0]), quantities)
    if first.exact and first.score:
        return [first]
    near_top = [_head(k, list(cells.iloc[k]), quantities) for k in range(min(len(cells), _HEADER_LINES))]
    best = max(near_top, key=lambda head: head.score)
    if not best.score:
        return [first]
    below = ((k, cells.iat[k, 0]) for k in range(best.position + 1, len(cells)))
    words = [k for k, cell in below if isinstance(cell, str) and cell[:1].isalpha()]
    later = (_head(k, list(cells.iloc[k]), quantities) for k in words)
    return [best, *(head for head in later if head.score >= max(2, 0.6 * best.score))]


def _head(position: int, row: Sequence[Cell], quantities: Quantities) -> _Head:
    names: list[str] = []
    units: list[str | None] = []
    mine: list[str] = []
    exact = True
    # a workbook may have notes next to the table
    width = next((k for k in range(len(row), 0, -1) if row[k - 1] is not None and str(row[k - 1]).strip()), 0)
    for cell in row[:width]:
        match = _HEADER.fullmatch(str(cell).strip().strip('"'))
        name, unit = (match["name"].strip(), match["unit"]) if match else ("", None)
        found = name if name in quantities else ""
        if found and unit and (own := quantities[found]) is not None and not _fits(unit, own):
            # a speed in km/h is that of the vehicle
            others = [mine for mine in quantities if mine != found and found in _other_names(mine)]
            fitting = (mine for mine in others if (of := quantities[mine]) is not None and _fits(unit, of))
            found = next(fitting, found)
            exact = exact and found == name
        if match and not found and not name.startswith("#"):
            name, unit, found = _with_unit(name, unit, quantities)
            quantity = quantities.get(found) if found else None
            if found and quantity is not None and unit and not _fits(unit, quantity):
                found = ""
            exact = exact and not found
        names.append(name)
        units.append(unit)
        mine.append(found)
    return _Head(position, tuple(names), tuple(units), tuple(mine), exact)


def _with_unit(name: str, unit: str | None, quantities: Quantities) -> tuple[str, str | None, str]:
    """Name, unit and quantity of a head, its unit behind another sign too: ``p / GPa`` (DIN 1313), ``SRR %``, ``T_C``.

    A name with an underscore has a unit only if it is no name as a whole.
    """
    if unit is None:
        first, _, after = name.partition("/")
        before, _, last = name.rpartition(" ")
        stem, _, end = name.rpartition("_") if not _meant(name, quantities) else ("", "", "")
        for words, rest in ((first, after), (before, last), (stem, end if end[:1].isalpha() else "")):
            words, rest = words.strip().removesuffix(" in"), rest.strip()
            meant = (words if words in quantities else _meant(words, quantities)) if words and rest else ""
            quantity = quantities.get(meant)
            if quantity is not None and _fits(rest, quantity):
                return words, rest, meant
    return name, unit, _meant(name, quantities)


@cache
def _other_names(quantity: str) -> list[str]:
    """Names of a quantity in other programs and test rigs."""
    return next((row["names"].split() for row in data_rows("column_names.csv") if row["quantity"] == quantity), [])


def _plain_name(name: str) -> str:
    name = name.casefold()
    for special, plain in zip("äöüμ\u00b5%", ("ae", "oe", "ue", "mu", "mu", "percent"), strict=True):
        name = name.replace(special, plain)
    return re.sub(r"[^a-z0-9]+", "_", name).strip("_")


def _meant(name: str, quantities: Quantities) -> str:
    """The quantity denoted by a name of another program; empty if unknown."""
    plain = _plain_name(name)
    if plain in quantities:
        return plain
    return next((mine for mine in quantities if plain in _other_names(mine)), "")


def _fits(unit: str, quantity: ValueRange) -> bool:
    if unit in ("-", "1", ""):
        return not quantity.unit
    try:
        parse_quantity(f"1 {unit}", quantity.unit)
    except InputError:
        return False
    return True


def _distinct(head: _Head) -> _Head:
    """The same with each quantity once: of several columns that stand for one, the first in data/column_names.csv."""
    mine = list(head.quantities)
    for quantity in {name for name in mine if name}:
        places = [k for k, name in enumerate(mine) if name == quantity]
        order = [quantity, *_other_names(quantity)]
        kept = min(places, key=lambda k: order.index(_plain_name(head.names[k])))
        for k in places:
            mine[k] = quantity if k == kept else ""
    return replace(head, quantities=tuple(mine))


def _require(path: Path, head: _Head, required: Sequence[str], quantities: Quantities) -> None:
    for name in required:
        if name not in head.quantities:
            others = (other for other in head.names if other and not other.startswith("#") and other not in quantities)
            hint = next(filter(None, (near(other, quantities) for other in others)), "")
            hint = f"The header has {', '.join(filter(None, head.names))}. {hint}".strip()
            raise InputError(f"{path.name}, column {name}", None, f"columns {', '.join(required)}", hint)


def _check_width(path: Path, cells: pd.DataFrame, width: int) -> None:
    """Raise an `InputError` for CSV rows longer than the header, usually because of decimal commas."""
    for number, row in zip(cells.index[1:], cells.iloc[1:, width:].to_numpy(), strict=True):
        more = sum(bool(str(cell).strip()) for cell in row)
        if more:
            hint = "Where a comma is the decimal sign, separate cells by semicolons. A column of notes begins with '#'."
            raise InputError(
                f"{path.name}, row {number}", f"{width + more} cells", f"{width} cells as in the header", hint
            )


def _check_names(path: Path, head: _Head, quantities: Quantities, instead: Mapping[str, str]) -> None:
    known = ", ".join(quantities)
    counts = Counter(head.names)
    for name in head.names:
        if not name.startswith("#") and name not in quantities:
            hint = f"{remedy(name, instead) or near(name, quantities)} A column of notes begins with '#'.".strip()
            raise InputError(f"{path.name}, header", name, f"columns named {known}", hint)
        if counts[name] > 1:
            raise InputError(f"{path.name}, header", name, "each column once")


def _are_units(row: Sequence[Cell], names: Sequence[str], units: Sequence[str | None], quantities: Quantities) -> bool:
    """Whether the second row contains units: a unit under every number column, and none in the header."""
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
        elif not _fits(text, quantity) or (text[0].isdigit() and "/" not in text):
            return False
        else:
            found = True
    return found


def _text(cell: Cell, where: str) -> str:
    text = "" if cell is None else str(cell).strip()
    if text.startswith(tuple(f"'{sign}" for sign in _FORMULA)):
        text = text[1:]  # as `harmless` wrote it
    if not text:
        raise InputError(where, None, "a text")
    return text


def _number(cell: Cell, unit: str | None, quantity: ValueRange, where: str, bare: bool, decimals: str) -> float:
    value: Cell = with_point(cell.strip(), decimals, where) if isinstance(cell, str) else cell
    if value is None or value == "":
        raise InputError(where, None, quantity.expected(), "The cell is empty.")
    if _CODES.fullmatch(str(value)) and quantity.unit:
        hint = "It may be a code of a missing value. Omit the row, or write the value with its unit in the cell."
        raise InputError(where, cell, "a number other than -999 or -9999", hint)
    if unit and unit != "1" and unit != "-":
        try:
            number = math.nan if "_" in str(value) else float(value)
        except (ValueError, OverflowError):
            # a cell may carry a unit of its own
            number = math.nan
        value = f"{number!r} {unit}" if math.isfinite(number) else value
    return quantity.check(value, where, bare=bare or not quantity.unit)


def _check_size(path: Path, rows: int, columns: int) -> None:
    """Raise an `InputError` for a table that is too large; `columns` is the width of the widest row."""
    for found, most, what in ((rows, MAX_ROWS, "rows"), (columns, MAX_COLUMNS, "columns")):
        if found > most:
            raise InputError(path.name, f"{found} {what}", f"at most {most} {what}")
    if rows * columns > MAX_CELLS:
        raise InputError(path.name, f"{rows} rows of {columns} cells", f"at most {MAX_CELLS} cells")


def _separator(lines: Sequence[str], quantities: Quantities) -> str:
    """Separator with which a line near the top names most quantities, or the most frequent one of the first line."""
    top = [line for line in lines if line][:_HEADER_LINES]
    scores = {
        mark: max(
            # a head may contain blanks
            (_head(0, _cut(line, mark), quantities).score for line in top if mark.strip(" ") or not _MARK.search(line)),
            default=0,
        )
        for mark in _MARKS
    }
    counts = {mark: top[0].count(mark) if top and mark.strip(" ") else 0 for mark in scores}
    return max(scores, key=lambda mark: (scores[mark], counts[mark]))


_MARK = re.compile(r"[,;\t]")
_MARKS = (",", ";", "\t", "  ", " ")  # two blanks for two and more, one for any number


def _cut(line: str, mark: str) -> list[str]:
    """Cells of a line, without regard to quotes."""
    return re.split(r" {2,}", line.strip()) if mark == "  " else line.split() if mark == " " else line.split(mark)


def _read_csv(path: Path, text: str, quantities: Quantities) -> pd.DataFrame:
    import pandas as pd

    # a line of notes becomes an empty one, so that rows keep their numbers
    lines = [line if line.strip() and not line.startswith("# ") else "" for line in text.splitlines()]
    separator = _separator(lines, quantities)
    if not separator.strip(" "):
        lines, separator = ["\t".join(_cut(line, separator)) for line in lines], "\t"
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
    if frame.empty:
        return frame
    frame = frame.fillna("")
    frame.attrs["separator"] = separator
    # a cell in quotes may hold line breaks
    height = 1 + frame.apply(lambda column: column.str.count("\n")).sum(axis=1)
    frame.index = 1 + height.cumsum() - height
    return frame[[bool(lines[min(number, len(lines)) - 1]) for number in frame.index]]


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
        # dates and truth values become text, so that an error shows what stands there
        row = ["" if x is None else x if type(x) in (float, int, str) else str(x) for x in cells]
        while row and row[-1] == "":
            row.pop()
        if row:
            rows[number] = row
            width = max(width, len(row))
            _check_size(path, len(rows), width)
    return rows


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


def read_columns(value: Any, quantities: Quantities) -> dict[str, Column]:
    """Columns of a plan from lists of equal length or from a file.

    Raises `InputError`: as `read_table`; or the lists differ in length.
    """
    if not isinstance(value, dict):
        raise InputError("table", value, "a table of columns, or file = 'points.csv'")
    if "file" in value:
        if len(value) > 1:
            raise InputError("file", value["file"], "either a file or columns, not both")
        return read_table(Path(str(value["file"])), quantities)[0]
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
