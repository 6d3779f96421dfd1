"""Figures of one contact."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ehl.common.figures import BLUE, GREY, ORANGE
from ehl.common.quantities import axis_label, to_display

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ehl.heat.traction import ThermalTraction
    from ehl.line_contact import LineContact
    from ehl.smooth import SteadyResult


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
