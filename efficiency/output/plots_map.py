"""Figures of a map: efficiency, loss and friction over torque, speed and oil temperature."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator

from efficiency.output.plots_load import plot_map
from ehl.common.figures import new_figure
from ehl.common.quantities import axis_label, quantity, to_display, typeset_units

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from efficiency.conditions.duty import DutyCycle
    from efficiency.conditions.grid import Grid

# values of torque and of speed from which on contours say more than lines
_CONTOURS = 3


def is_map(grid: Grid) -> bool:
    """Whether the axes are torque, speed and temperature, in this order."""
    return tuple(grid.axes) == ("torque", "speed", "temperature")


def grid_figures(grid: Grid) -> Iterator[tuple[str, Figure, str]]:
    """(name, figure, caption) of any grid."""
    if is_map(grid):
        yield from map_figures(grid)
    else:
        yield "efficiency", lines_figure(grid), "Mesh efficiency over the axes."


def lines_figure(grid: Grid) -> Figure:
    """Efficiency over the longest axis of numbers, one line per combination of the others."""
    numeric = [name for name, values in grid.axes.items() if all(isinstance(v, int | float) for v in values)]
    along = max(numeric, key=lambda name: len(grid.axes[name]), default=next(iter(grid.axes)))
    figure = new_figure()
    axes = figure.subplots()
    place = list(grid.axes).index(along)
    lines = np.moveaxis(100.0 * grid.values(), place, -1).reshape(-1, len(grid.axes[along]))
    others = [name for name in grid.axes if name != along]
    for line, values in zip(lines, product(*(grid.axes[name] for name in others)), strict=True):
        words = (f"{n} {v:.4g}" if isinstance(v, float) else str(v) for n, v in zip(others, values, strict=True))
        axes.plot([str(v) if along not in numeric else v for v in grid.axes[along]], line, "o-", label=", ".join(words))
    axes.set(xlabel=along, ylabel="mesh efficiency [%]")
    axes.grid(alpha=0.3)
    if others:
        axes.legend(frameon=False, fontsize=7)
    return figure


def duty_figure(duty: DutyCycle) -> Figure:
    """Energy lost at each operating point of a duty cycle."""
    figure = new_figure()
    axes = figure.subplots()
    torque, speed = quantity("torque"), quantity("speed")
    names = [f"{torque.text(r.torque)}, {speed.text(r.speed)}, {r.side}" for r in duty.rows]
    axes.barh(names, [to_display("energy_loss", row.energy_loss) for row in duty.rows])
    axes.set(xlabel=axis_label("energy_loss"))
    axes.invert_yaxis()
    return figure


def map_figures(grid: Grid) -> Iterator[tuple[str, Figure, str]]:
    """(name, figure, caption): lines over speed, and contours where there are enough torques and speeds."""
    yield "efficiency_map", plot_map(grid), "Mesh efficiency over pinion speed."
    if grid.shape[0] >= _CONTOURS and grid.shape[1] >= _CONTOURS:
        for name in ("efficiency", "power_loss", "friction_coefficient_mean"):
            yield f"contours_{name}", contour_figure(grid, name), f"Contours: {quantity(name).label}."


def contour_figure(grid: Grid, name: str) -> Figure:
    """Contours of one value over speed and torque, one panel per oil temperature."""
    values = to_display(name, grid.values(name))
    panels = len(grid.axes["temperature"])
    figure = new_figure(2.2 + 3.4 * panels, 3.8)
    all_axes = np.atleast_1d(figure.subplots(1, panels, sharey=True))
    speed = to_display("speed", np.array(grid.axes["speed"]))
    torque = to_display("torque", np.array(grid.axes["torque"]))
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    levels = MaxNLocator(10).tick_values(low, high if high > low else low + 1e-9 + 1e-3 * abs(low))
    order = np.ix_(np.argsort(torque), np.argsort(speed))
    for number, axes in enumerate(all_axes):
        field = np.ma.masked_invalid(values[:, :, number][order])
        shades = axes.contourf(np.sort(speed), np.sort(torque), field, levels=levels, cmap="viridis")
        lines = axes.contour(np.sort(speed), np.sort(torque), field, levels=levels, colors="w", linewidths=0.6)
        axes.clabel(lines, fontsize=7)
        axes.plot(*(part.ravel() for part in np.meshgrid(speed, torque)), ".", color="0.2", ms=2)
        temperature = grid.axes["temperature"][number]
        axes.set(xlabel=axis_label("speed"), title=typeset_units(quantity("temperature").text(temperature)))
        if number == panels - 1:
            figure.colorbar(shades, ax=axes, label=axis_label(name))
    all_axes[0].set_ylabel(axis_label("torque"))
    return figure
