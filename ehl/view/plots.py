"""Figures of one contact."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ehl.common.errors import InputError
from ehl.common.figures import BLUE, GREY, ORANGE, new_figure
from ehl.common.quantities import axis_label, to_display

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ehl.heat.traction import ThermalTraction
    from ehl.line_contact import LineContact
    from ehl.smooth.solver import SteadyResult


def plot_contact(result: Any, ax: Axes | None = None) -> Axes:
    """Figure of pressure, film and temperatures; of a transient run also its history and roughness."""
    from ehl.view.rough_plots import plot_transient

    if result.problem is None or result.film is None or result.isothermal is None:
        raise InputError("plot", result.reason, "a solved contact")
    if ax is None and result.transient is not None:
        return plot_transient(result.problem, result.transient, result.isothermal, _caption(result))
    return _plot_smooth(result.problem.line, result.film, result.heat, _caption(result), ax)


def _caption(result: Any) -> str:
    """Title of the figure."""
    if result.transient is None:
        return (
            f"mu = {result.friction_coefficient:.4g}, h_c = {result.film_central * 1e9:.1f} nm, "
            f"h_min = {result.film_min * 1e9:.1f} nm"
        )
    errors = f"mesh ±{100.0 * result.mesh_error:.2g} %, 90 % interval ±{100.0 * result.statistical_error:.2g} %"
    first = f"μ = {result.friction_coefficient:.4f} ({errors})"
    if math.isfinite(result.friction_boundary_half):
        half, double = result.friction_boundary_half, result.friction_boundary_double
        first += f",  {half:.4f} … {double:.4f} at half and twice the boundary film"
    second = f"λ = {result.film_ratio:.2g},  asperities carry {100.0 * result.asperity_load_share:.2g} %"
    if math.isfinite(result.roughness_load_share):
        second += f", {100.0 * result.roughness_load_share:.2g} % of the load above the macroscopic pressure"
    return f"{first}\n{second},  {result.status} {result.reason}".rstrip()


def _plot_smooth(
    line: LineContact, film: SteadyResult, heat: ThermalTraction | None, title: str, ax: Axes | None
) -> Axes:
    """Pressure and film over x/b with the Hertz pressure; temperatures in a second plot if they were computed."""
    b = line.half_width
    temperature_axes = None
    if ax is not None:
        axes = ax
    elif heat:
        axes, temperature_axes = new_figure(7.0, 6.6).subplots(2, 1, sharex=True, height_ratios=(3, 2))
    else:
        axes = new_figure().add_subplot()
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
    if heat and temperature_axes:
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
    (temperature_axes or axes).set_xlabel("x/b [-]")
    return axes
