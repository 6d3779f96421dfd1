"""Tables and their output to terminal, page, CSV, XLSX and JSON.

Rows contain SI numbers and texts; columns are named after `ehl.common.quantities`. Terminal, page and workbook show
display units; CSV, JSON and data frames are SI. Texts given by users are escaped in all of them.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Any

from ehl.common import quantities
from ehl.common.data import reason_text
from ehl.common.table_reader import harmless
from ehl.common.terminal import terminal, wrapped

if TYPE_CHECKING:
    import pandas as pd
    from jinja2 import Template
    from rich.console import Console, ConsoleOptions, RenderResult

Cell = float | int | str | bool | None

NOTHING = "–"  # shown for a missing value
_GAP = 2  # between the columns of a terminal
_NARROWEST = 12  # width of a folded column of texts, or that of its longest word up to
_WIDEST_WORD = 22
_DENSE, _DENSEST = 9, 13  # number of columns above which a page uses a smaller font


@dataclass(frozen=True)
class Column:
    """A column of a table."""

    name: str  # key of the column in CSV, JSON and data frames
    # name of the quantity if different from `name`; without a quantity the column has plain numbers or texts
    of: str = ""
    label: str = ""  # label in the head, instead of that of the quantity
    digits: int = 0  # significant digits, instead of those of the quantity
    decimals: int | None = None  # decimals in the display unit, instead of significant digits
    rounded: bool = False  # whether digits before the point are rounded as well

    @property
    def quantity(self) -> quantities.Quantity:
        """Quantity of the column."""
        known = quantities.quantities()
        return known[self.of] if self.of else known.get(self.name, quantities.Quantity(self.name, label=self.name))

    def text(self, value: Cell) -> str:
        """Text of a cell in the display unit."""
        if value is None:
            return NOTHING
        if isinstance(value, bool):
            return "yes" if value else "no"
        if isinstance(value, str):
            return reason_text(value) if self.name == "reason" else value
        shown = self.quantity.to_display(value)
        if self.decimals is not None and math.isfinite(shown):
            return f"{round(shown, self.decimals) + 0.0:.{self.decimals}f}"
        if self.rounded:
            shown = quantities.rounded(float(shown), self.digits)
        digits = self.digits or self.quantity.digits
        return str(shown) if isinstance(shown, int) else quantities.format_number(shown, digits)

    def shown(self, value: Cell) -> Cell:
        """Value of a cell in the display unit."""
        return value if value is None or isinstance(value, str | bool) else self.quantity.to_display(value)


@dataclass(frozen=True)
class Table:
    """Rows of SI numbers and texts with named columns.

    Parameters
    ----------
    columns : sequence of Column or str
        A string is short for `Column` of that name.
    rows : sequence of sequences
        Numbers in SI (also of numpy), texts, truth values, None; non-finite numbers become None.
    title : str
        Head of the table.
    notes : sequence of str
        Remarks below the table.
    name : str
        Name of the sheet or CSV file; by default the title.
    highlight : int
        Row that is emphasised on a page.
    vertical : bool
        Whether the table is shown with one line per column: quantity, values, unit. Texts in the first column become
        the heads of the values.

    Examples
    --------
    >>> table = Table(["oil", "film_central"], [["fva3", 2.5e-7]])
    >>> print(table.csv(), end="")
    oil,film_central [m]
    fva3,2.5e-07
    >>> table.records()
    [{'oil': 'fva3', 'film_central': 2.5e-07}]
    """

    columns: Sequence[Column | str]
    rows: Sequence[Sequence[Any]]
    title: str = ""
    notes: Sequence[str] = ()
    name: str = ""
    highlight: int = -1
    vertical: bool = False

    def __repr__(self) -> str:
        heads = [column if isinstance(column, str) else column.name for column in self.columns]
        shown = ", ".join(heads[:10]) + (", ..." if len(heads) > 10 else "")
        return f"Table({self.title or self.name!r}: {len(self.rows)} rows of {shown})"

    @classmethod
    def from_columns(cls, columns: Mapping[Any, Iterable[Any]], **others: Any) -> Table:
        """A table from columns of equal length; `others` are parameters of `Table`."""
        return cls(tuple(columns), tuple(zip(*columns.values(), strict=True)), **others)

    @classmethod
    def from_records(cls, records: Sequence[Mapping[str, Any]], **others: Any) -> Table:
        """A table from rows by column names, some of which may be missing; `others` are parameters of `Table`."""
        names = tuple(dict.fromkeys(name for record in sorted(records, key=len, reverse=True) for name in record))
        return cls(names, tuple(tuple(record.get(name) for name in names) for record in records), **others)

    def __post_init__(self) -> None:
        columns = tuple(Column(column) if isinstance(column, str) else column for column in self.columns)
        rows = tuple(tuple(map(cell, row)) for row in self.rows)
        if any(len(row) != len(columns) for row in rows):
            raise ValueError(f"rows of {len(columns)} cells expected")
        object.__setattr__(self, "columns", columns)
        object.__setattr__(self, "rows", rows)

    @property
    def names(self) -> list[str]:
        """Names of the columns."""
        return [column.name for column in self._columns]

    def records(self) -> list[dict[str, Cell]]:
        """Rows by the names of their columns, SI, for JSON."""
        return [dict(zip(self.names, row, strict=True)) for row in self.rows]

    def select(self, names: Sequence[str]) -> Table:
        """The table with some of its columns, in the order of `names`."""
        places = [self.names.index(name) for name in names]
        rows = [[row[i] for i in places] for row in self.rows]
        return replace(self, columns=[self.columns[i] for i in places], rows=rows)

    def to_frame(self) -> pd.DataFrame:
        """The table as a pandas data frame."""
        import pandas as pd

        return pd.DataFrame(self.records(), columns=self.names)

    def csv(self) -> str:
        """CSV text, SI, with units in the head; texts that a spreadsheet would evaluate get an apostrophe."""
        file = io.StringIO()
        writer = csv.writer(file, lineterminator="\n")
        head, rows = self.grid(display=False)
        writer.writerow(map(harmless, head))
        writer.writerows([harmless(value) for value in row] for row in rows)
        return file.getvalue()

    def html(self) -> str:
        """The table as an HTML element, in display units."""
        head, rows = self._texts(typeset=True)
        dense = "dense densest" if len(head) > _DENSEST else "dense" if len(head) > _DENSE else ""
        left = self._left(head, rows)
        return html_template("table.html").render(table=self, head=head, rows=rows, left=left, dense=dense)

    _repr_html_ = html

    def print(self) -> None:
        """Print the table at the width of the output; columns that do not fit are listed below."""
        terminal().print(self, crop=False, overflow="ignore")

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        from rich.box import SIMPLE_HEAD
        from rich.table import Table as Grid

        head, rows = self._texts(typeset=False)
        left = self._left(head, rows)
        widths = self._fitting(head, rows, left, options.max_width)
        if self.title:
            yield wrapped(self.title, "italic")
        if rows and sum(widths.values()) + _GAP * (len(widths) - 1) <= options.max_width:
            grid = Grid(box=SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, _GAP - 1, 0, 0))
            for i, width in widths.items():
                grid.add_column(wrapped(head[i]), justify="left" if left[i] else "right", width=width)
            for row in rows:
                grid.add_row(*(wrapped(row[i]) for i in widths))
            yield grid
        else:  # less than two columns fit; no head without rows
            yield from (wrapped(f"{head[i]}: {row[i]}") for row in rows for i in widths)
        missing = [head[i] for i in range(len(head)) if i not in widths]
        if missing:
            yield wrapped(f"not shown at {options.max_width} characters: {'; '.join(missing)}")
        yield from map(wrapped, self.notes)

    @property
    def _columns(self) -> Sequence[Column]:
        return self.columns  # type: ignore[return-value]

    def grid(self, *, display: bool) -> tuple[list[str], list[list[Cell]]]:
        """Head and cells of a file, with numbers in SI or display units."""
        return self._arranged(
            lambda column: column.name,
            lambda column: quantities.printed_unit(column.quantity.display if display else column.quantity.unit),
            lambda column, cell: column.shown(cell) if display else cell,
        )

    def _texts(self, *, typeset: bool) -> tuple[list[str], list[list[str]]]:
        """Head and cells as shown."""

        def written(column: Column) -> str:
            unit = column.quantity.display
            # no line break within a unit of a page
            return quantities.typeset_unit(unit).replace(" ", "\xa0") if typeset else quantities.printed_unit(unit)

        return self._arranged(lambda c: c.label or c.quantity.label, written, lambda c, x: c.text(x))

    def _arranged(
        self, label: Callable[[Column], str], unit: Callable[[Column], str], value: Callable[[Column, Cell], Any]
    ) -> tuple[list[str], list[list[Any]]]:
        if self.vertical:
            named = len(self.rows) > 1 and not self._numeric(0)
            heads = [str(row[0]) for row in self.rows] if named else ["value"] * len(self.rows)
            shown = [
                [label(c), *(value(c, row[i]) for row in self.rows), unit(c)]
                for i, c in list(enumerate(self._columns))[named:]
            ]
            return ["quantity", *heads, "unit"], shown
        head = [_with_unit(label(c), unit(c) if self._numeric(i) else "") for i, c in enumerate(self._columns)]
        return head, [[value(c, x) for c, x in zip(self._columns, row, strict=True)] for row in self.rows]

    def _numeric(self, column: int) -> bool:
        """Whether a column has a number or is empty."""
        cells = [row[column] for row in self.rows if row[column] is not None]
        return not cells or any(not isinstance(x, str) for x in cells)

    def _left(self, head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[bool]:
        """Whether each shown column has texts, which are left-aligned."""
        like = [[bool(_LIKE_NUMBER.fullmatch(row[i])) for row in rows] for i in range(len(head))]
        if not self.vertical:
            return [not all(cells) for cells in like]
        # texts among the values of a vertical table are right-aligned like numbers
        return [True, *(not any(cells) for cells in like[1:-1]), True]

    def _fitting(
        self, head: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[bool], limit: int
    ) -> dict[int, int]:
        """Columns that fit and their widths; the first two, and the unit of a vertical table, are always included."""
        from rich.cells import cell_len

        least, full = [], []
        for i, title in enumerate(head):
            content = max((cell_len(row[i]) for row in rows), default=0)
            word = max((cell_len(part) for part in title.split()), default=1)
            longest = max((cell_len(part) for row in rows for part in row[i].split()), default=1)
            folded = min(content, max(_NARROWEST, min(longest, _WIDEST_WORD)))
            least.append(max(folded if left[i] else content, word))
            full.append(max(content, cell_len(title)))
        keep, fixed = list(range(len(head))), 1 if self.vertical else 0
        while len(keep) > 2 + fixed and sum(least[i] + _GAP for i in keep) - _GAP > limit:
            del keep[-1 - fixed]
        spare = limit + _GAP - sum(least[i] + _GAP for i in keep)
        widths = {}
        for i in keep:
            widths[i] = least[i] + max(0, min(spare, full[i] - least[i]))
            spare -= widths[i] - least[i]
        return widths


@cache
def html_template(name: str) -> Template:
    """A template of `ehl/common/templates`; texts are escaped."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=StrictUndefined)
    environment.loader = PackageLoader("ehl.common")
    environment.filters["typeset"] = quantities.typeset_units
    return environment.get_template(name)


# right-aligned cells: numbers, intervals, percentages, dashes
_LIKE_NUMBER = re.compile(r"|[–-]|[<>~±]?\s*[+-]?\d[\d.,e+-]*(\s*%)?(\s*(to|±|/)\s*[+-]?\d[\d.,e+-]*(\s*%)?)?|yes|no")


def cell(value: Any) -> Cell:
    """A value for a table: numpy numbers become Python numbers, and non-finite numbers None."""
    if hasattr(value, "item"):
        value = value.item()
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int) else str(value)


def _with_unit(text: str, unit: str) -> str:
    return f"{text} [{unit}]" if unit else text
