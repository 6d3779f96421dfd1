"""Tables as a workbook (XLSX) and as a folder of CSV files."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from efficiency.output.data_tables import DataTable
from ehl import __version__
from ehl.io.errors import InputError

if TYPE_CHECKING:
    from xlsxwriter.format import Format
    from xlsxwriter.workbook import Workbook

_WIDEST = 60
_LONGEST_NAME = 31


def write_xlsx(path: Path, tables: Sequence[DataTable], title: str) -> Path:
    """Write tables as one workbook: a sheet for each, headers frozen and filtered, a first sheet that says what it is.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    import xlsxwriter
    from xlsxwriter.exceptions import FileCreateError

    _make_folder(path.parent, "--xlsx")
    book = xlsxwriter.Workbook(str(path), {"nan_inf_to_errors": False, "strings_to_numbers": False})
    bold = book.add_format({"bold": True, "bottom": 1, "text_wrap": True, "valign": "top"})
    book.set_properties({"title": title, "comments": f"mixed-ehl {__version__}"})
    front = [("what", title), ("program", f"mixed-ehl {__version__}"), ("units", "SI; in the head of each column")]
    front += [(f"sheet {_sheet_name(table.name)}", f"{len(table.rows)} rows") for table in tables]
    for table in (DataTable("about", ("", ""), front), *tables):
        _add_sheet(book, table, bold)
    try:
        book.close()
    except (OSError, FileCreateError) as error:
        raise InputError("--xlsx", str(path), "a writable file", f"{error}.") from None
    return path


def _add_sheet(book: Workbook, table: DataTable, bold: Format) -> None:
    sheet = book.add_worksheet(_sheet_name(table.name))
    titled = any(table.header)
    if titled:
        sheet.write_row(0, 0, table.header, bold)
        sheet.freeze_panes(1, 0)
        if table.rows:
            sheet.autofilter(0, 0, len(table.rows), len(table.header) - 1)
    for number, row in enumerate(table.rows, start=int(titled)):
        for column, value in enumerate(row):
            if isinstance(value, str):
                sheet.write_string(number, column, value)
            elif value is not None:
                sheet.write_number(number, column, value)
    for column, name in enumerate(table.header):
        words = [row[column] for row in table.rows[:200] if isinstance(row[column], str)]
        sheet.set_column(column, column, min(_WIDEST, max(12, len(name) // 2 + 4, *(len(str(w)) for w in words), 0)))
    sheet.set_landscape()
    sheet.repeat_rows(0)


def write_csv(folder: Path, tables: Sequence[DataTable]) -> list[Path]:
    """Write each table as a CSV file of its name, the units in the header; what has no value stays empty.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    _make_folder(folder, "--csv")
    written = []
    for table in tables:
        path = folder / f"{re.sub(r'[^A-Za-z0-9.]+', '_', table.name)}.csv"
        try:
            with path.open("w", newline="", encoding="utf-8") as file:
                writer = csv.writer(file, lineterminator="\n")
                writer.writerow(table.header)
                writer.writerows(["" if value is None else value for value in row] for row in table.rows)
        except OSError as error:
            raise InputError("--csv", str(path), "a writable file", f"{error}.") from None
        written.append(path)
    return written


def _make_folder(folder: Path, option: str) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(option, str(folder), "a folder that can be written", f"{error}.") from None


def _sheet_name(name: str) -> str:
    return re.sub(r"[\[\]:*?/\\]", " ", name)[:_LONGEST_NAME]
