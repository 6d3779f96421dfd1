"""Output of results as terminal text, HTML page, workbook, CSV and JSON files from sections."""

from __future__ import annotations

import io
import json
import platform
import re
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from ehl.common.data import Citation
from ehl.common.errors import InputError
from ehl.common.figures import figure_of, interactive, own_style, printable, quiet_about_names, save_figure
from ehl.common.files import FIGURE, PAGE, make_folder, replacing, write_file
from ehl.common.notes import notes_table, print_notes
from ehl.common.progress import counted
from ehl.common.quantities import quantities
from ehl.common.sections import Code, Folded, Head, Item, MainResult, Medium, Notes, Picture, Row, Section, Text
from ehl.common.table import Cell, Table, html_template
from ehl.common.terminal import print_text
from ehl.common.version import __version__

if TYPE_CHECKING:
    import pandas as pd
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from xlsxwriter.format import Format
    from xlsxwriter.workbook import Workbook

_MAX_SHEET_WIDTH, _MAX_SHEET_NAME = 425, 31  # of a column [pixel]; of the name of a sheet [characters]
_ASIDE = re.compile(r"<metadata>.*?</metadata>\s*|<!--.*?-->\s*", re.DOTALL)
_ID, _REFERENCE = re.compile(r' id="([^"]*)"'), re.compile(r'(?:url\(|href=")#([^)"]+)')


class StatusOfReason:
    """A result with the status of its `reason`."""

    @property
    def status(self: Any) -> Literal["converged", "failed"]:
        """``failed`` if there is a reason."""
        return "failed" if self.reason else "converged"


class Reportable:
    """A result that can be printed, drawn and written; it is equal to itself alone.

    A subclass defines `to_dict`, and either `sections` or the name of the module that creates them.
    """

    def __init_subclass__(cls, **options: Any) -> None:
        # the comparison of all fields by `dataclass` fails for arrays; it does not replace a method of the class
        super().__init_subclass__(**options)
        if cls.__eq__ is object.__eq__:
            cls.__eq__, cls.__hash__ = object.__eq__, object.__hash__  # type: ignore[method-assign]

    presenter = ""
    """``"module:name"`` with functions ``name_sections(result, medium, **options)`` and ``plot_name(result, ax)``."""
    file_name = "report"
    """Name of page and workbook in a folder."""

    def sections(self, medium: Medium = "page", *args: Any, **options: Any) -> list[Section]:
        """Content of the result for a medium."""
        module, _, name = self.presenter.partition(":")
        found: list[Section] = getattr(import_module(module), f"{name}_sections")(self, medium, *args, **options)
        return found

    def _plot(self, ax: Axes | None, **options: Any) -> Axes:
        module, _, name = self.presenter.partition(":")
        draw: Callable[[Any, Axes | None], Axes] | None = None
        if module:
            draw = getattr(import_module(module), f"plot_{name}", None)
        if draw is None:
            raise InputError("plot", type(self).__name__, "a result with figures")
        return draw(self, ax)

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        raise NotImplementedError

    def references(self) -> set[str]:
        """Uses of `data/references.toml` that the result cites; by default those of its `results`."""
        return set[str]().union(*(result.references() for result in getattr(self, "results", ())))

    def citation(self) -> Citation:
        """References of the laws, formulas and standards that the result used, with `text` and `bibtex`."""
        return Citation.of(self.references())

    def plot(self, ax: Axes | None = None, **options: Any) -> Axes:
        """Draw the main figure on matplotlib axes `ax` or a new pyplot figure; options as in `sections`."""
        with interactive():
            return self._plot(ax, **options)

    def show(self, **options: Any) -> None:
        """Print the result to the terminal; options as in `sections`."""
        print_sections(self.sections("terminal", **options))

    def report(self, path: Path | str, **options: Any) -> Path:
        """Write one file: page (.html), workbook (.xlsx), first table (.csv), or all numbers (.json).

        Options as in `sections`.

        Raises
        ------
        InputError
            The suffix is unknown, or the file cannot be written.
        """
        path = Path(path)
        suffix = path.suffix.lower()
        if suffix in PAGE:
            return write_page(path, self.sections("page", **options))
        if suffix == ".xlsx":
            return write_workbook(path, self.sections("files", **options))
        if suffix == ".csv":
            write_file(path, next(iter(tables_of(self.sections("files", **options)))).csv(), "csv")
        elif suffix == ".json":
            write_file(path, json.dumps(self.to_dict(), allow_nan=False) + "\n", "report")
        else:
            raise InputError("report", str(path), "a file name ending in .html, .xlsx, .csv or .json")
        return path

    def write(
        self,
        *,
        report: Path | str | None = None,
        xlsx: Path | str | None = None,
        csv: Path | str | None = None,
        plot: Path | str | None = None,
        folder: Path | str | None = None,
        **options: Any,
    ) -> list[Path]:
        """Write several files; returns the files and folders written.

        Parameters
        ----------
        report : Path or str, optional
            HTML page.
        xlsx : Path or str, optional
            Workbook of all tables.
        csv : Path or str, optional
            Folder for all tables, or file for the first table.
        plot : Path or str, optional
            Folder for all figures (PNG), or file for the main figure (PNG, SVG, PDF).
        folder : Path or str, optional
            Folder for page, workbook, all tables (CSV) and all figures (PNG).
        **options
            As in `sections`.

        Raises
        ------
        InputError
            The suffix does not match the kind of file, or a file or folder cannot be written.
        """
        given = {"report": report, "xlsx": xlsx, "csv": csv, "plot": plot}
        places = {name: Path(place) for name, place in given.items() if place is not None}
        for name, suffixes in (("report", PAGE), ("xlsx", (".xlsx",))):
            if name in places and places[name].suffix.lower() not in suffixes:
                raise InputError(name, str(places[name]), f"a file name ending in {suffixes[0]}")
        for name, place in places.items():
            suffix = place.suffix.lower()
            if name == "plot" and suffix in FIGURE:
                save_figure(self.figure(**options), place)
            elif name == "plot":
                write_figures(place, self.sections("page", **options))
            elif name == "csv" and suffix != ".csv":
                write_csv(place, tables_of(self.sections("files", **options)))
            else:
                self.report(place, **options)
        return [*places.values(), *([] if folder is None else self._write_all(Path(folder), **options))]

    def _write_all(self, folder: Path, **options: Any) -> list[Path]:
        page, files = self.sections("page", **options), self.sections("files", **options)
        written = [write_page(folder / f"{self.file_name}.html", page)]
        written += write_csv(folder, tables_of(files))
        written.append(write_workbook(folder / f"{self.file_name}.xlsx", files))
        write_figures(folder, page)
        return written

    def _repr_html_(self) -> str:
        return "\n".join(table.html() for table in tables_of(self.sections("terminal")) if table.rows)

    def figure(self, name: str | None = None, **options: Any) -> Figure:
        """A figure of the report by name, or the main one, as a matplotlib figure that is not shown.

        Options as in `sections`.

        Raises
        ------
        InputError
            The name is unknown; the message lists all names.
        """
        if name is None:
            with own_style():
                return figure_of(self._plot(None, **options))
        named = {picture.name: picture for picture in pictures_of(self.sections("page", **options))}
        if name not in named:
            raise InputError("figure", name, "one of " + ", ".join(named) if named else "a result with figures")
        return named[name].figure()


class TableResult(Reportable):
    """A result that is a table; a subclass defines `table`."""

    def table(self) -> Table:
        """The result as a table."""
        raise NotImplementedError

    def sections(self, medium: Medium = "page", *args: Any, **options: Any) -> list[Section]:
        """The table."""
        table = self.table()
        return [Section("", [Head(table.title), table])]

    def to_dict(self) -> dict[str, Any]:
        """Rows by the names of their columns, SI units, for JSON."""
        return {"rows": self.table().records()}

    def to_frame(self) -> pd.DataFrame:
        """The table as a data frame, SI units."""
        return self.table().to_frame()


def _si_units(frame: pd.DataFrame) -> dict[str, str]:
    """SI unit of each column that has one."""
    known = quantities()
    return {name: known[name].unit for name in map(str, frame.columns) if name in known and known[name].unit}


def _required(package: str) -> InputError:
    hint = "Install it with: pip install 'mixed-ehl[tables]'. CSV and XLSX require no extra."
    return InputError("package", package, "an installed package", hint)


class Tabular:
    """A result with one row per point or case, for programs that read xarray or Parquet (extra `tables`)."""

    def to_frame(self) -> pd.DataFrame:
        """One row per point, SI units."""
        raise NotImplementedError

    def _dimensions(self) -> tuple[str, ...]:
        """Columns that are the axes; without any, the rows are one dimension, `case`."""
        return ()

    def to_xarray(self) -> xarray.Dataset:
        """The result over its axes, with SI units as the attribute `units` of each variable.

        Raises
        ------
        InputError
            The package xarray is not installed.
        """
        frame, axes = self.to_frame(), list(self._dimensions())
        try:
            found: xarray.Dataset = (frame.set_index(axes) if axes else frame.rename_axis("case")).to_xarray()
        except ImportError:
            raise _required("xarray") from None
        for name, unit in _si_units(frame).items():
            found[name].attrs["units"] = unit
        return found

    def to_parquet(self, path: str | PathLike[str]) -> None:
        """Write the rows as a Parquet file, with the SI unit in the metadata of each column.

        Raises
        ------
        InputError
            The package pyarrow is not installed, or the file cannot be written.
        """
        try:
            import pyarrow
            from pyarrow import parquet
        except ImportError:
            raise _required("pyarrow") from None
        frame = self.to_frame()
        table, units = pyarrow.Table.from_pandas(frame, preserve_index=False), _si_units(frame)
        fields = [field.with_metadata({"unit": units.get(field.name, "")}) for field in table.schema]
        with replacing(Path(path), "parquet") as draft:
            parquet.write_table(table.cast(pyarrow.schema(fields, metadata=table.schema.metadata)), draft)


def inner_items(items: Sequence[Item]) -> Iterator[Item]:
    """Items in reading order, including those of rows and folded parts."""
    for item in items:
        if isinstance(item, Row | Folded):
            yield from inner_items(item.items)
        else:
            yield item


def all_items(sections: Sequence[Section]) -> Iterator[Item]:
    """Items of all sections in reading order."""
    for section in sections:
        yield from inner_items(section.items)


def tables_of(sections: Sequence[Section]) -> list[Table]:
    """All tables of the sections, including notes."""
    found = (notes_table(x.notes, x.cases) if isinstance(x, Notes) else x for x in all_items(sections))
    return [item for item in found if isinstance(item, Table)]


def pictures_of(sections: Sequence[Section]) -> list[Picture]:
    """All pictures of the sections that have a name."""
    return [item for item in all_items(sections) if isinstance(item, Picture) and item.name]


def head_of(sections: Sequence[Section]) -> Head:
    """The head of the sections."""
    return next((item for item in all_items(sections) if isinstance(item, Head)), Head(""))


def print_sections(sections: Sequence[Section]) -> None:
    """Print text, notes and tables to the terminal."""
    for section in sections:
        if section.title:
            print_text(section.title)
        for item in inner_items(section.items):
            if isinstance(item, Table):
                item.print()
            elif isinstance(item, Notes):
                print_notes(item.notes, item.cases)
            elif isinstance(item, Text):
                print_text(item.text)
            elif isinstance(item, Code):
                print(item.text)
            elif isinstance(item, MainResult):
                print_text("\n".join([f"{item.label}: {item.value}", *(f"{x}, {what}" for x, what in item.known)]))


def write_page(path: Path, sections: Sequence[Section]) -> Path:
    """Write sections as one self-contained HTML page.

    Raises `InputError`: the file cannot be written.
    """
    head = head_of(sections)
    footer = f"mixed-ehl {__version__}, Python {platform.python_version()}. {head.footer}".strip()
    page = html_template("report.html").render(head=head, sections=sections, footer=footer, svg=picture_svg)
    write_file(path, page, "report")
    return path


def picture_svg(picture: Picture) -> str:
    """The figure of a picture as an SVG element without the XML prolog."""
    import matplotlib as mpl

    figure = picture.figure()
    printable(figure)
    buffer = io.StringIO()
    with quiet_about_names(), own_style(), mpl.rc_context({"svg.fonttype": "none", "font.family": "sans-serif"}):
        figure.savefig(buffer, format="svg", transparent=True, bbox_inches="tight", pad_inches=0.05)
    text = buffer.getvalue()
    text = _ASIDE.sub("", text[text.index("<svg") :])
    # remove names of groups, which are not unique within a page; referenced names are unique
    used = set(_REFERENCE.findall(text))
    return _ID.sub(lambda found: found[0] if found[1] in used else "", text)


def write_figures(folder: Path, sections: Sequence[Section]) -> None:
    """Write all named figures as PNG files into a folder.

    Raises `InputError`: there is no figure, or the folder cannot be written.
    """
    pictures = pictures_of(sections)
    if not pictures:
        raise InputError("plot", str(folder), "a result with figures")
    make_folder(folder, "plot")
    for picture in pictures:
        save_figure(picture.figure(), folder / f"{picture.name}.png")


def write_csv(folder: Path, tables: Sequence[Table]) -> list[Path]:
    """Write each table as a CSV file.

    Raises `InputError`: the folder cannot be written.
    """
    make_folder(folder, "csv")
    written = []
    for table in tables:
        path = folder / f"{re.sub(r'[^A-Za-z0-9.]+', '_', table.name or table.title)}.csv"
        write_file(path, table.csv(), "csv")
        written.append(path)
    return written


def write_workbook(path: Path, sections: Sequence[Section]) -> Path:
    """Write all tables as one workbook in display units, one sheet per table after a list of them.

    Raises `InputError`: the file cannot be written.
    """
    import xlsxwriter

    tables, title = tables_of(sections), head_of(sections).title
    content = io.BytesIO()
    # texts stay texts
    book = xlsxwriter.Workbook(content, {"strings_to_formulas": False, "strings_to_urls": False})
    bold = book.add_format({"bold": True, "bottom": 1, "text_wrap": True, "valign": "top"})
    book.set_properties({"title": title, "comments": f"mixed-ehl {__version__}"})
    names = _sheet_names(tables)
    front: list[list[Cell]] = [["what", title], ["program", f"mixed-ehl {__version__}"]]
    front += [["units", "in the head of each column"]]
    for name, table in zip(names, tables, strict=True):
        front.append([f"sheet {name}", counted(len(table.rows), "row")])
        front.extend([f"note on {name}", note] for note in table.notes)
    _add_sheet(book, "about", [], front, bold)
    for name, table in zip(names, tables, strict=True):
        _add_sheet(book, name, *table.grid(display=True), bold)
    book.close()
    write_file(path, content.getvalue(), "xlsx")
    return path


def _add_sheet(book: Workbook, name: str, head: Sequence[str], rows: Sequence[Sequence[Cell]], bold: Format) -> None:
    sheet = book.add_worksheet(name)
    if head:
        sheet.write_row(0, 0, head, bold)
        sheet.freeze_panes(1, 0)
        if rows:
            sheet.autofilter(0, 0, len(rows), len(head) - 1)
    for number, row in enumerate(rows, start=bool(head)):
        sheet.write_row(number, 0, row)
    sheet.autofit(_MAX_SHEET_WIDTH)
    sheet.set_landscape()
    sheet.repeat_rows(0)


def _sheet_names(tables: Sequence[Table]) -> list[str]:
    """Valid names of sheets: short, unique, and without forbidden characters."""
    names: list[str] = []
    for table in tables:
        clean = re.sub(r"[\[\]:*?/\\\x00-\x1f]", " ", table.name or table.title).strip(" '") or "table"
        name, number = clean[:_MAX_SHEET_NAME], 1
        while name.lower() in {"about", "history", *(other.lower() for other in names)}:
            number += 1
            name = f"{clean[: _MAX_SHEET_NAME - 4]} {number}"
        names.append(name)
    return names
