"""Figures of a comparison of friction models: loss, friction along the mesh, loss by region, run time."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps
from matplotlib.ticker import NullFormatter

from efficiency.loss.power_loss import FACES, HEIGHTS, friction_along_mesh
from efficiency.output.tables import operating_state
from ehl.common.arrays import FloatArray
from ehl.common.data import reason_text
from ehl.common.figures import BLUE, GREY, ORANGE, axes_or_new, figure_of, new_figure, panels
from ehl.common.quantities import typeset_units

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from efficiency.loss.compare import Comparison

MARKERS = "os^vD<>PX*"


def plot_comparison(comparison: Comparison, ax: Axes | None = None) -> Axes:
    """Power loss in percent of the input, one bar per friction model; closed forms in grey.

    A bar or interval far above the median ends in an arrow with its value.
    """
    rows = sorted(comparison.rows, key=lambda row: (math.isnan(row.power_loss), row.power_loss))  # as in the table
    axes = axes_or_new(ax, 7.5, 0.9 + 0.42 * len(rows))
    loss = np.array([100.0 * (1.0 - row.efficiency) for row in rows])
    low, high = (np.array([100.0 * (1.0 - getattr(row, f"efficiency_{end}")) for row in rows]) for end in _ENDS)
    limit = axis_limit(np.fmax(loss, high))
    place = np.arange(len(rows))[::-1]
    colors = [GREY if row.kind == "closed form" else BLUE for row in rows]
    axes.barh(place, np.minimum(np.nan_to_num(loss), limit), color=colors)
    for at, row, value, left, right in zip(place, rows, loss, low, high, strict=True):
        text = f"{100.0 * row.efficiency:.2f} %" if math.isfinite(row.efficiency) else reason_text(row.reason)
        end = value if math.isfinite(value) else 0.0
        if right > left and value <= limit:
            ends = [[max(value - left, 0.0)], [max(min(right, limit) - value, 0.0)]]
            axes.errorbar(value, at, xerr=ends, fmt="none", ecolor=ORANGE, capsize=3)
        end = np.fmax(end, right)
        if end > limit:
            axes.plot(limit, at, marker=">", ms=8, color=ORANGE, zorder=5)
            if right > left:
                text += f"\n{100.0 * row.efficiency_lower:.3g} to {100.0 * row.efficiency_upper:.3g} %"
        size, gap = (8, 8) if end > limit else (9, 5)
        axes.annotate(
            text, (min(end, limit), at), xytext=(gap, 0), textcoords="offset points", fontsize=size, va="center"
        )
    axes.set_yticks(place, [row.label for row in rows])
    axes.set(xlabel="mesh power loss [% of input]; bars end with the efficiency", xlim=(0.0, 1.35 * limit))
    # title of the whole figure, because long names of friction models leave narrow axes
    title = axes.set_title if ax is not None else figure_of(axes).suptitle
    title(typeset_units(f"{comparison.design}: {operating_state(comparison)}"))
    return axes


_ENDS = ("upper", "lower")
_FAR = 6.0  # times the median


def axis_limit(ends: FloatArray) -> float:
    """End of an axis for bars of lengths `ends`, without the lengths far above the median."""
    known = ends[np.isfinite(ends) & (ends > 0.0)]
    if not known.size:
        return 1.0
    near = known[known <= _FAR * np.median(known)]
    return float(near.max())


def plot_friction_along_mesh(comparison: Comparison) -> Figure:
    """Friction coefficient over one pinion pitch, one line per model."""
    return _along(
        comparison, [friction_along_mesh(result) for result in comparison.results], "friction coefficient [-]"
    )


def plot_loss_along_mesh(comparison: Comparison) -> Figure:
    """Power loss over one pinion pitch, one line per model."""
    return _along(comparison, [result.cycle.power_loss for result in comparison.results], "power loss [W]")


def _along(comparison: Comparison, values: list[FloatArray], label: str) -> Figure:
    figure = new_figure(7.0, 3.9 + 0.2 * len(values))
    axes: Axes = figure.add_subplot()
    shades = colormaps["viridis"](np.linspace(0.0, 0.9, max(len(values), 2)))
    for number, (result, line) in enumerate(zip(comparison.results, values, strict=True)):
        roll = result.cycle.pinion_angle / result.cycle.pitch
        style = {"color": shades[number], "marker": MARKERS[number % len(MARKERS)], "ms": 3.5, "lw": 1.2}
        axes.plot(roll, line, label=comparison.rows[number].label, **style)
    axes.set(xlabel="pinion roll [pinion pitches]", ylabel=label, ylim=(0.0, None))
    axes.grid(alpha=0.3)
    figure.legend(fontsize=8, frameon=False, loc="outside lower center")
    return figure


def plot_loss_by_region(comparison: Comparison) -> Figure:
    """Share of the sliding loss by thirds of the gear flank, one panel for each friction model."""
    rows = [row for row in comparison.rows if row.loss_regions]
    all_axes = panels(len(rows), 3, (0.9, 0.5), (3.0, 1.9), sharey=True)
    figure = figure_of(all_axes[0])
    top = 100.0 * max((float(np.nanmax(row.loss_regions)) for row in rows), default=1.0)
    shown = None
    for axes, row in zip(all_axes, rows, strict=True):
        shares = 100.0 * np.array(row.loss_regions)
        shown = axes.imshow(shares, origin="lower", cmap="Oranges", vmin=0.0, vmax=top, aspect="auto")
        for (height, face), share in np.ndenumerate(shares):
            dark = share > 0.6 * top
            axes.annotate(
                f"{share:.1f}", (face, height), ha="center", va="center", color="w" if dark else "k", fontsize=8
            )
        axes.set_xticks(range(3), FACES, fontsize=8)
        axes.set_yticks(range(3), HEIGHTS, fontsize=8)
        axes.set_title(row.label, fontsize=8)
    if shown is not None:
        figure.colorbar(shown, ax=figure.axes, label="share of the sliding loss [%]")
    figure.supxlabel("third of the gear face", fontsize=9)
    figure.supylabel("third of the gear height", fontsize=9)
    return figure


def plot_run_time(comparison: Comparison) -> Figure:
    """Run time of friction and loss for each friction model, without geometry and load."""
    rows = [row for row in comparison.rows if row.kind == "mesh"][::-1]
    figure = new_figure(7.0, 0.9 + 0.34 * len(rows))
    axes: Axes = figure.add_subplot()
    seconds = np.maximum([row.seconds for row in rows], 1e-5)
    axes.barh(np.arange(len(rows)), seconds, color=BLUE)
    for place, value in enumerate(seconds):
        axes.annotate(
            f"{value:.3g} s", (value, place), xytext=(4, 0), textcoords="offset points", va="center", fontsize=8
        )
    axes.set_yticks(np.arange(len(rows)), [row.label for row in rows], fontsize=8)
    axes.set_xscale("log")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set(xlabel="run time of friction and loss [s]", xlim=(None, 6.0 * float(seconds.max())))
    return figure
