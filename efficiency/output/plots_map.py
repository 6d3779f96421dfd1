"""Figures of a map: efficiency, loss and friction over torque, speed and oil temperature."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from efficiency.output.plots_load import RPM, plot_map
from ehl.io.units import KELVIN

if TYPE_CHECKING:
    from efficiency.loss.map import EfficiencyMap

# values of torque and of speed from which on contours say more than lines
_CONTOURS = 3


def map_figures(grid: EfficiencyMap) -> Iterator[tuple[str, Figure, str]]:
    """(name, figure, caption): lines over speed, and contours where there are enough torques and speeds."""
    yield "efficiency_map", plot_map(grid), "Mesh efficiency over pinion speed."
    if grid.shape[0] >= _CONTOURS and grid.shape[1] >= _CONTOURS:
        for name, title, factor in (
            ("efficiency", "mesh efficiency [%]", 100.0),
            ("power_loss", "power loss [W]", 1.0),
            ("friction_coefficient_mean", "mean friction coefficient [-]", 1.0),
        ):
            yield f"contours_{name}", contour_figure(grid, name, title, factor), f"Contours: {title}."


def contour_figure(grid: EfficiencyMap, name: str, title: str, factor: float) -> Figure:
    """Contours of one value over speed and torque, one panel per oil temperature."""
    values = factor * grid.values(name)
    panels = len(grid.temperature_oil)
    figure = Figure(figsize=(2.2 + 3.4 * panels, 3.8), layout="constrained")
    all_axes = np.atleast_1d(figure.subplots(1, panels, sharey=True))
    speed, torque = np.array(grid.speed_pinion) * RPM, np.array(grid.torque_pinion)
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
        axes.set(xlabel="pinion speed [rpm]", title=f"{grid.temperature_oil[number] - KELVIN:.4g} degC")
        if number == panels - 1:
            figure.colorbar(shades, ax=axes, label=title)
    all_axes[0].set_ylabel("pinion torque [N m]")
    return figure
