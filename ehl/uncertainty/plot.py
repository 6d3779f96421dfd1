"""Bars of the inputs whose uncertainty counts most."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ehl.common.figures import BLUE, GREY
from ehl.common.quantities import typeset_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ehl.uncertainty.result import InputUncertainty

MOST = 12


def plot_sources(found: InputUncertainty) -> Figure:
    """One bar for each input from the lower to the upper end it alone leaves, the widest on top."""
    from matplotlib.figure import Figure

    shown = found.quantity
    sources = [s for s in found.sources if s.high > s.low][:MOST]
    figure = Figure(figsize=(7.0, 1.6 + 0.32 * (len(sources) + 1)), layout="constrained")
    axes = figure.add_subplot()
    bars = [("all inputs", found.low, found.high, GREY)]
    bars += [(source.label, source.low, source.high, BLUE) for source in sources]
    for place, (_, low, high, colour) in enumerate(bars):
        left, right = shown.to_display(low), shown.to_display(high)
        axes.barh(place, right - left, left=left, height=0.6, color=colour)
    axes.axvline(shown.to_display(found.value), color="black", lw=0.8)
    axes.set_yticks(range(len(bars)), [name for name, *_ in bars])
    axes.invert_yaxis()
    unit = typeset_unit(shown.display)
    axes.set_xlabel(f"{shown.label} [{unit or '-'}], {100.0 * found.level:.0f} % interval")
    axes.set_title("Measure first what makes the widest bar", fontsize=10)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.tick_params(axis="y", length=0)
    return figure
