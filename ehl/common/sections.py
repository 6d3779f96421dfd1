"""Content of a result as data: sections of numbers, notes, text, tables and figures (written by `ehl.common.pages`)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

from ehl.common.figures import figure_of, own_style
from ehl.common.notes import Note
from ehl.common.table import Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Medium = Literal["page", "terminal", "files"]
"""Target of sections: HTML page, terminal, or files (workbook and CSV, tables only)."""


@dataclass(frozen=True)
class Head:
    """Title of a page or workbook, its case, and remarks for the foot of the page."""

    title: str
    subtitle: str = ""
    footer: str = ""


@dataclass(frozen=True)
class Text:
    """A paragraph of plain text."""

    text: str


@dataclass(frozen=True)
class Code:
    """Preformatted text: an equation, a command."""

    text: str


@dataclass(frozen=True)
class Picture:
    """A figure with its caption, drawn when a writer needs it."""

    draw: Callable[[], Figure | Axes]  # returns a matplotlib figure, or axes of it
    caption: str
    name: str = ""  # name of its file; a picture without name is only part of the page

    def figure(self) -> Figure:
        """The figure, drawn now."""
        with own_style():
            return figure_of(self.draw())


def picture(name: str, caption: str, draw: Callable[..., Figure | Axes], *arguments: Any) -> Picture:
    """The picture that `draw` makes of its arguments."""
    return Picture(partial(draw, *arguments), caption, name)


@dataclass(frozen=True)
class Row:
    """Items next to each other if the page is wide enough."""

    items: Sequence[Item]


@dataclass(frozen=True)
class MainResult:
    """The main result of a page."""

    value: str  # value with unit
    label: str  # description
    known: Sequence[tuple[str, str]] = ()  # interval or error, and its source


@dataclass(frozen=True)
class KeyFigures:
    """The most important numbers: (value, description)."""

    figures: Sequence[tuple[str, str]]


@dataclass(frozen=True)
class Notes:
    """Notes, the most severe first; a page shows three of them and folds the others."""

    notes: Sequence[Note]
    cases: int = 1  # number of cases
    none: str = "No notes: no limit of the model is reached."  # sentence if there are no notes
    shown = 3


@dataclass(frozen=True)
class Folded:
    """Items that a page shows on demand and in print."""

    title: str
    items: Sequence[Item]


Item = Head | Text | Code | Table | Picture | Row | MainResult | KeyFigures | Notes | Folded


@dataclass(frozen=True)
class Section:
    """A part of a page; sections with a title are numbered."""

    title: str
    items: Sequence[Item]
