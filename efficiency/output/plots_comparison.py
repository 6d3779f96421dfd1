"""Figures of a comparison of friction models: friction and loss along the mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from efficiency.loss.compare import Comparison
    from efficiency.loss.result import EfficiencyResult

FloatArray = NDArray[np.float64]
MARKERS = "os^vD<>PX*"


def friction_along_mesh(result: EfficiencyResult) -> FloatArray:
    """Friction coefficient at each position, weighted with the sliding power density; nan without sliding."""
    points = result.points
    weight = points.force * points.speed_sliding
    total = np.bincount(points.position, weight, minlength=result.positions)
    sliding = np.bincount(points.position, weight * result.friction.mu, minlength=result.positions)
    return np.asarray(np.divide(sliding, total, out=np.full(result.positions, np.nan), where=total > 0.0))


def plot_friction_along_mesh(comparison: Comparison) -> Figure:
    """Friction coefficient over one pinion pitch, one line per model."""
    return _along(
        comparison, [friction_along_mesh(result) for result in comparison.results], "friction coefficient [-]"
    )


def plot_loss_along_mesh(comparison: Comparison) -> Figure:
    """Power loss over one pinion pitch, one line per model."""
    return _along(comparison, [result.power_loss_positions for result in comparison.results], "power loss [W]")


def _along(comparison: Comparison, values: list[FloatArray], label: str) -> Figure:
    figure = Figure(figsize=(7.0, 4.4), layout="constrained")
    axes: Axes = figure.add_subplot()
    shades = colormaps["viridis"](np.linspace(0.0, 0.9, max(len(values), 2)))
    for number, (result, line) in enumerate(zip(comparison.results, values, strict=True)):
        step = float(result.pinion_angle[1] - result.pinion_angle[0])
        axes.plot(
            result.pinion_angle / (step * result.positions),
            line,
            color=shades[number],
            marker=MARKERS[number % len(MARKERS)],
            ms=3.5,
            lw=1.2,
            label=result.friction_model,
        )
    axes.set(xlabel="pinion roll [pinion pitches]", ylabel=label, ylim=(0.0, None))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure
