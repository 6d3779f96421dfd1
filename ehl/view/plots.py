"""Figures of one contact."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ehl.io.errors import InputError
from ehl.io.files import make_folder
from ehl.quantities import axis_label, to_display

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ehl.heat import ThermalTraction
    from ehl.line_contact import LineContact
    from ehl.smooth import SteadyResult

_LONGEST = 160  # of a line [characters]
_ASIAN = (
    "Noto Sans CJK JP", "Noto Sans CJK SC", "Noto Sans JP", "Noto Sans SC", "Source Han Sans", "WenQuanYi Zen Hei",
    "Droid Sans Fallback", "Arial Unicode MS", "Hiragino Sans", "PingFang SC", "Apple SD Gothic Neo", "Yu Gothic",
    "MS Gothic", "Microsoft YaHei", "SimHei", "Malgun Gothic",
)  # fmt: skip

BLUE, ORANGE, GREY = "#1f5a99", "#c8651b", "#8a8f98"


def plot_smooth(line: LineContact, film: SteadyResult, heat: ThermalTraction | None, title: str) -> Figure:
    """Pressure and film over x/b, with the Hertz pressure; temperatures below where heat was computed."""
    import numpy as np
    from matplotlib.figure import Figure

    b = line.half_width
    figure = Figure(figsize=(7.0, 6.6 if heat else 4.2), layout="constrained")
    if heat:
        axes, temperature_axes = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    else:
        axes = figure.add_subplot()
    inside = np.linspace(-1.0, 1.0, 201)
    hertz = line.pressure_hertz * np.sqrt(np.maximum(1.0 - inside**2, 0.0))
    axes.plot(inside, to_display("pressure", hertz), color=GREY, lw=1.0, ls="--", label="Hertz")
    axes.plot(film.x / b, to_display("pressure", film.pressure), color=BLUE, label="pressure")
    axes.set(ylabel=axis_label("pressure"), xlim=(-2.0, 1.5), ylim=(0.0, None))
    film_axes = axes.twinx()
    film_axes.plot(film.x / b, to_display("film_thickness", film.film), color=ORANGE, label="film thickness")
    film_axes.set(
        ylabel=axis_label("film_thickness"), ylim=(0.0, 4.0 * to_display("film_thickness", film.film_central))
    )
    lines = [*axes.get_lines(), *film_axes.get_lines()]
    axes.legend(lines, [str(line.get_label()) for line in lines], loc="upper right", frameon=False)
    axes.set_title(title)
    if heat:
        x = heat.x / b
        temperature_axes.plot(
            x, to_display("temperature", heat.temperature_film), color=ORANGE, label="film, mid-layer"
        )
        temperature_axes.plot(x, to_display("temperature", heat.temperature_flash_1), color=BLUE, label="surface 1")
        temperature_axes.plot(
            x, to_display("temperature", heat.temperature_flash_2), color=BLUE, ls="--", label="surface 2"
        )
        temperature_axes.set(ylabel=axis_label("temperature"))
        temperature_axes.legend(loc="upper left", frameon=False)
    figure.axes[1 if heat else 0].set_xlabel("x/b [-]")
    return figure


def printable(figure: Figure) -> None:
    """Make the words of a figure fit to print: no name of a user is read as mathematics or runs off the page.

    Parameters
    ----------
    figure : Figure
        Its titles, labels and legends are changed in place. Chinese, Japanese and Korean are drawn by a font of them
        where one is installed, else as boxes.
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
    """Names of a user may have signs no font has, or be too long for a layout, which is then left as it is."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing", UserWarning)
        warnings.filterwarnings("ignore", "constrained_layout not applied", UserWarning)
        yield


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure; the suffix of `path` chooses the format.

    Raises
    ------
    InputError
        The suffix is unknown or the file cannot be written.
    """
    try:
        if path.suffix.lower() not in (".png", ".svg", ".pdf"):
            raise InputError("plot", str(path), "a file name ending in .png, .svg or .pdf")
        printable(figure)
        with quiet_about_names():
            figure.savefig(path, dpi=150)
    except OSError as error:
        raise InputError("plot", str(path), "a writable file", f"{error}.") from None


def save_figures(figures: Iterable[tuple[Any, ...]], folder: Path) -> None:
    """Write figures, each of them (name, figure, ...), as PNG files into a folder.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    make_folder(folder, "plot")
    for name, figure, *_ in figures:
        save_figure(figure, folder / f"{name}.png")
