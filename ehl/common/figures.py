"""Figures: style, fonts for names given by users, and files."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from ehl.common.errors import InputError
from ehl.common.files import FIGURE, replacing

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LONGEST = 160  # of a line [characters]
_ASIAN = (
    "Noto Sans CJK JP", "Noto Sans CJK SC", "Noto Sans JP", "Noto Sans SC", "Source Han Sans", "WenQuanYi Zen Hei",
    "Droid Sans Fallback", "Arial Unicode MS", "Hiragino Sans", "PingFang SC", "Apple SD Gothic Neo", "Yu Gothic",
    "MS Gothic", "Microsoft YaHei", "SimHei", "Malgun Gothic",
)  # fmt: skip

BLUE, ORANGE, GREY = "#1f5a99", "#c8651b", "#8a8f98"
Layout = Literal["constrained", "compressed"]
_INTERACTIVE: ContextVar[bool] = ContextVar("interactive", default=False)


@contextmanager
def own_style() -> Iterator[None]:
    """The defaults of matplotlib, independent of a matplotlibrc of the user (LaTeX, fonts, sizes)."""
    import matplotlib
    from matplotlib import style

    shown = matplotlib.is_interactive()
    try:
        with style.context("default"):
            try:
                yield
            finally:
                # a notebook becomes interactive with its first figure; the end of the context would reset it
                shown = matplotlib.is_interactive()
    finally:
        matplotlib.interactive(shown)


@contextmanager
def interactive() -> Iterator[None]:
    """Create new figures with pyplot, so that notebooks and `pyplot.show` show them."""
    before = _INTERACTIVE.set(True)
    try:
        with own_style():
            yield
    finally:
        _INTERACTIVE.reset(before)


def new_figure(width: float = 7.0, height: float = 4.2, *, layout: Layout = "constrained", dpi: int = 100) -> Figure:
    """An empty figure of the given size [inch]."""
    if _INTERACTIVE.get():
        with suppress(ImportError):  # the backend of the user needs a display
            from matplotlib import pyplot

            return pyplot.figure(figsize=(width, height), layout=layout, dpi=dpi)
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout=layout, dpi=dpi)


def axes_or_new(ax: Axes | None, width: float = 7.0, height: float = 4.2) -> Axes:
    """The given axes, or those of a new figure."""
    return new_figure(width, height).add_subplot() if ax is None else ax


def panels(
    count: int,
    columns: int,
    margin: tuple[float, float],
    each: tuple[float, float],
    *,
    dpi: int = 100,
    sharey: bool = False,
) -> list[Axes]:
    """Axes of a figure with `count` panels, up to `columns` in a row, of a size `each` within a `margin` [inch]."""
    across, down = min(columns, count), -(-count // columns)
    figure = new_figure(margin[0] + across * each[0], margin[1] + down * each[1], dpi=dpi)
    found = figure.subplots(down, across, squeeze=False, sharey=sharey).ravel()
    for spare in found[count:]:
        spare.set_axis_off()
    return list(found[:count])


def printable(figure: Figure) -> None:
    """Prepare the texts of a figure for printing: names given by users are not mathematics, and long texts are wrapped.

    figure: its titles, labels and legends are changed in place. Chinese, Japanese and Korean texts use a suitable
        font if one is installed; otherwise boxes appear.
    """
    from matplotlib.text import Text

    ticks = {
        label
        for axes in figure.axes
        for axis in (axes.xaxis, axes.yaxis)
        for label in axis.get_ticklabels(which="both")
    }
    for text in figure.findobj(Text):
        words = text.get_text()
        if not words or (text in ticks and "mathdefault" in words):
            continue  # powers of ten
        text.set_parse_math(False)
        if not words.isascii():
            text.set_fontfamily(_families())
        if max(map(len, words.split("\n"))) > _LONGEST:
            text.set_text("\n".join(line[:_LONGEST] for line in words.split("\n")))


@cache
def _families() -> list[str]:
    from matplotlib.font_manager import fontManager

    installed = {font.name for font in fontManager.ttflist}
    return ["DejaVu Sans", *(name for name in _ASIAN if name in installed)]


@contextmanager
def quiet_about_names() -> Iterator[None]:
    """Ignore warnings about characters without a glyph and about texts that are too long for the layout."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing", UserWarning)
        warnings.filterwarnings("ignore", "constrained_layout not applied", UserWarning)
        yield


def figure_of(drawn: Artist) -> Figure:
    """The figure, or that of axes."""
    figure = drawn.figure
    return figure if figure is figure.figure else figure_of(figure)


def save_figure(drawn: Figure | Axes, path: Path) -> None:
    """Write a figure; the suffix of `path` chooses the format.

    Raises `InputError`: the suffix is unknown or the file cannot be written.
    """
    if path.suffix.lower() not in FIGURE:
        raise InputError("plot", str(path), "a file name ending in .png, .svg or .pdf")
    figure = figure_of(drawn)
    printable(figure)
    with replacing(path, "plot") as draft, quiet_about_names(), own_style():
        figure.savefig(draft, dpi=150, format=path.suffix[1:].lower())
