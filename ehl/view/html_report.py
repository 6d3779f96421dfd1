"""One self-contained HTML page from sections of text, tables and figures."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ehl.io.files import write_file
from ehl.view.table import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Text:
    """A paragraph of plain text."""

    text: str
    kind = "text"


@dataclass(frozen=True)
class Formula:
    """Preformatted text: an equation, a command."""

    text: str
    kind = "formula"


@dataclass(frozen=True)
class Picture:
    """A matplotlib figure with its caption."""

    figure: Figure
    caption: str
    kind = "picture"

    @property
    def svg(self) -> str:
        """The figure as inline SVG."""
        return figure_svg(self.figure)


@dataclass(frozen=True)
class Pictures:
    """Figures side by side where the page is wide enough."""

    pictures: Sequence[Picture]
    kind = "pictures"


@dataclass(frozen=True)
class KeyFigures:
    """The few numbers that matter: (value, what it is)."""

    figures: Sequence[tuple[str, str]]
    kind = "key_figures"


Block = Text | Formula | Table | Picture | Pictures | KeyFigures


@dataclass(frozen=True)
class Section:
    """A titled part of the page."""

    title: str
    blocks: Sequence[Block]


def figure_svg(figure: Figure) -> str:
    """A figure as an SVG element without the XML prolog."""
    import matplotlib as mpl

    from ehl.view.plots import printable, quiet_about_names

    printable(figure)
    buffer = io.StringIO()
    with quiet_about_names(), mpl.rc_context({"svg.fonttype": "none", "font.family": "sans-serif"}):
        figure.savefig(buffer, format="svg", transparent=True)
    text = buffer.getvalue()
    return text[text.index("<svg") :]


def write_report(path: Path, title: str, subtitle: str, sections: Sequence[Section], footer: str = "") -> Path:
    """Write the page.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("ehl.view"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    page = environment.get_template("report.html").render(
        title=title, subtitle=subtitle, sections=sections, footer=footer
    )
    write_file(path, page, "report", folder=True)
    return path


def number(value: float, digits: int = 4) -> str:
    """A number for a table: `digits` significant digits, a dash where there is none."""
    return format(value, f".{digits}g") if math.isfinite(value) else "–"
