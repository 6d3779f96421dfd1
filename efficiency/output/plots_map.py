"""Figures of a map: efficiency, loss and friction over torque, speed and oil temperature."""

from __future__ import annotations

from functools import partial
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from ehl.common.figures import axes_or_new, new_figure
from ehl.common.quantities import axis_label, quantities, quantity, to_display, typeset_units
from ehl.common.sections import Picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from efficiency.conditions.duty import DutyCycle
    from efficiency.conditions.grid import Grid

# least number of torques and of speeds for contours
_CONTOURS = 3


def is_map(grid: Grid) -> bool:
    """Whether the axes are torque, speed and temperature, in this order."""
    return tuple(grid.axes) == ("torque", "speed", "temperature")


def plot_map(map_: Grid, ax: Axes | None = None) -> Axes:
    """Efficiency over speed, one line per torque, one panel per oil temperature; in `ax` only the first panel."""
    from matplotlib import colormaps

    if not is_map(map_):
        return plot_lines(map_, ax)
    values = 100.0 * map_.values()
    panels = len(map_.axes["temperature"])
    if ax is None:
        all_axes = list(np.atleast_1d(new_figure(1.5 + 3.6 * panels, 3.8).subplots(1, panels, sharey=True)))
    else:
        all_axes = [ax]
    speed = to_display("speed", np.array(map_.axes["speed"]))
    shades = colormaps["viridis"](np.linspace(0.1, 0.85, len(map_.axes["torque"])))
    for k, (axes, temperature) in enumerate(zip(all_axes, map_.axes["temperature"], strict=False)):
        for j, torque in enumerate(map_.axes["torque"]):
            axes.plot(speed, values[j, :, k], color=shades[j], marker="o", ms=3, label=quantity("torque").text(torque))
        axes.set(xlabel=axis_label("speed"), title=typeset_units(quantity("temperature").text(temperature)))
        axes.grid(alpha=0.3)
    all_axes[0].set_ylabel("mesh efficiency [%]")
    all_axes[-1].legend(frameon=False, title="pinion torque")
    main: Axes = all_axes[0]
    return main


def plot_lines(grid: Grid, ax: Axes | None = None) -> Axes:
    """Efficiency over the longest numerical axis, one line per combination of the others."""
    numeric = [name for name, values in grid.axes.items() if all(isinstance(v, int | float) for v in values)]
    along = max(numeric, key=lambda name: len(grid.axes[name]), default=next(iter(grid.axes)))
    axes = axes_or_new(ax)
    place = list(grid.axes).index(along)
    lines = np.moveaxis(100.0 * grid.values(), place, -1).reshape(-1, len(grid.axes[along]))
    others = [name for name in grid.axes if name != along]
    known, places = quantities().get(along), grid.axes[along]
    if along not in numeric:
        places = tuple(map(str, places))
    elif known is not None:
        places = tuple(map(known.to_display, places))
    for line, values in zip(lines, product(*(grid.axes[name] for name in others)), strict=True):
        named = zip(others, values, strict=True)
        words = (quantity(n).text(v) if isinstance(v, float) and n in quantities() else str(v) for n, v in named)
        axes.plot(places, line, "o-", label=", ".join(words))
    axes.set(xlabel=along if known is None else known.axis_label, ylabel="mesh efficiency [%]")
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.grid(alpha=0.3)
    if others:
        axes.legend(frameon=False, fontsize=8)
    return axes


def plot_duty(duty: DutyCycle, ax: Axes | None = None) -> Axes:
    """Energy loss at each operating point of a duty cycle."""
    axes = axes_or_new(ax)
    torque, speed = quantity("torque"), quantity("speed")
    names = [f"{torque.text(r.torque)}, {speed.text(r.speed)}, {r.side}" for r in duty.rows]
    axes.barh(names, [to_display("energy_loss", row.energy_loss) for row in duty.rows])
    axes.set(xlabel=axis_label("energy_loss"))
    axes.invert_yaxis()
    return axes


def map_figures(grid: Grid) -> list[Picture]:
    """Lines over speed, and contours if there are enough torques and speeds."""
    pictures = [Picture(partial(plot_map, grid), "Mesh efficiency over pinion speed.", "efficiency_map")]
    if grid.shape[0] >= _CONTOURS and grid.shape[1] >= _CONTOURS:
        for name in ("efficiency", "power_loss", "friction_coefficient_mean"):
            caption = f"Contours: {quantity(name).label}."
            pictures.append(Picture(partial(contour_figure, grid, name), caption, f"contours_{name}"))
    return pictures


def contour_figure(grid: Grid, name: str) -> Figure:
    """Contours of one value over speed and torque, one panel per oil temperature."""
    from matplotlib.ticker import MaxNLocator

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
