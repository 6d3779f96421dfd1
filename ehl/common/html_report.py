"""One self-contained HTML page from sections of text, tables and figures."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ehl.common.files import write_file
from ehl.common.notes import Note
from ehl.common.quantities import typeset_units
from ehl.common.table import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ASIDE = re.compile(r"<metadata>.*?</metadata>\s*|<!--.*?-->\s*", re.DOTALL)
_ID, _REFERENCE = re.compile(r' id="([^"]*)"'), re.compile(r'(?:url\(|href=")#([^)"]+)')


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
class Beside:
    """Blocks side by side where the page is wide enough."""

    blocks: Sequence[Block]
    kind = "beside"


@dataclass(frozen=True)
class Answer:
    """The answer of a page.

    Parameters
    ----------
    value : str
        With its unit.
    label : str
        What it is.
    known : sequence of (str, str)
        How well it is known: an interval or an error, and what leaves it open.
    """

    value: str
    label: str
    known: Sequence[tuple[str, str]] = ()
    kind = "answer"


@dataclass(frozen=True)
class KeyFigures:
    """The few numbers that matter: (value, what it is)."""

    figures: Sequence[tuple[str, str]]
    kind = "key_figures"


@dataclass(frozen=True)
class Notes:
    """What a reader has to know, the gravest first: three at once, the others behind a line.

    Parameters
    ----------
    notes : sequence of Note
    cases : int
        Of how many cases they are.
    none : str
        Words where there are none.
    """

    notes: Sequence[Note]
    cases: int = 1
    none: str = "Nothing to note: no limit of the model is touched."
    kind = "notes"
    shown = 3


@dataclass(frozen=True)
class Folded:
    """Blocks behind a line of words; open on paper."""

    title: str
    blocks: Sequence[Block]
    kind = "folded"


Block = Text | Formula | Table | Picture | Pictures | Beside | Answer | KeyFigures | Notes | Folded


@dataclass(frozen=True)
class Section:
    """A part of the page; those with a title are numbered."""

    title: str
    blocks: Sequence[Block]


def figure_svg(figure: Figure) -> str:
    """A figure as an SVG element without the XML prolog."""
    import matplotlib as mpl

    from ehl.common.figures import printable, quiet_about_names

    printable(figure)
    buffer = io.StringIO()
    with quiet_about_names(), mpl.rc_context({"svg.fonttype": "none", "font.family": "sans-serif"}):
        figure.savefig(buffer, format="svg", transparent=True, bbox_inches="tight", pad_inches=0.05)
    text = buffer.getvalue()
    text = _ASIDE.sub("", text[text.index("<svg") :])
    # names of groups repeat in the figures of a page; those that are referred to are unique
    used = set(_REFERENCE.findall(text))
    return _ID.sub(lambda found: found[0] if found[1] in used else "", text)


def write_report(path: Path, title: str, subtitle: str, sections: Sequence[Section], footer: str = "") -> Path:
    """Write the page.

    Parameters
    ----------
    path : Path
        HTML file.
    title, subtitle : str
        Head of the page: what it is of, and for which case.
    sections : sequence of Section
        The first without a title: the answer, its uncertainty and what has to be known.
    footer : str
        Versions and what is not part of the page.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("ehl.common"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["typeset"] = typeset_units
    page = environment.get_template("report.html").render(
        title=title, subtitle=subtitle, sections=sections, footer=footer
    )
    write_file(path, page, "report", folder=True)
    return path
