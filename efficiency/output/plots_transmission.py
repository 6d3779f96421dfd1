"""Figures of the unloaded transmission error and its harmonics."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ehl.view.plots import BLUE, GREY, ORANGE

if TYPE_CHECKING:
    from efficiency.geometry import SideGeometry

ARCSEC = np.degrees(1.0) * 3600.0


def transmission_figure(side: SideGeometry) -> Figure:
    """Transmission error of one tooth pair with its neighbours; below them all the curve of the mesh."""
    figure = Figure(figsize=(6.6, 3.8), layout="constrained")
    axes = figure.add_subplot()
    mesh, pair = side.pair.transmission, side.pair
    path, pitch = mesh.path, pair.surface.pitch
    roll, error = path.pinion_angle / pitch, path.transmission_error * ARCSEC
    for shift, colour, name in ((-1.0, GREY, "neighbours"), (1.0, GREY, None), (0.0, BLUE, "one tooth pair")):
        axes.plot(roll + shift, np.where(path.free, error, np.nan), color=colour, lw=1.2, label=name)
        axes.plot(roll + shift, np.where(path.free, np.nan, error), color=colour, lw=1.0, ls=":")
    if not path.free.all():
        axes.plot([], [], color=BLUE, lw=1.0, ls=":", label="contact of an edge")
    start = mesh.pinion_angle[0] / pitch
    turns = np.arange(-1, 3)[:, None] + mesh.pinion_angle / pitch
    axes.plot(turns.ravel(), np.tile(mesh.error, 4) * ARCSEC, color=ORANGE, lw=2.4, alpha=0.8, label="gear pair")
    low = float(mesh.error.min()) * ARCSEC
    axes.set(
        xlabel="pinion angle from the design point [pinion pitches]",
        ylabel="transmission error of the gear [arcsec]",
        xlim=(start - 0.75, start + 1.75),
        ylim=(min(3.2 * low, -1e-3), max(-0.9 * low, 1e-3)),
    )
    axes.set_title(
        f"{pair.name}, {side.side}:\nunloaded transmission error, {mesh.peak_to_peak * ARCSEC:.4g} arcsec peak to peak",
        fontsize=10,
    )
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, ncols=2, loc="upper center", frameon=False)
    return figure


def harmonics_figure(side: SideGeometry) -> Figure:
    """Amplitudes of the transmission error at multiples of the mesh frequency."""
    figure = Figure(figsize=(6.6, 3.8), layout="constrained")
    axes = figure.add_subplot()
    values = side.pair.transmission.harmonics * ARCSEC
    order = np.arange(1, values.size + 1)
    axes.bar(order, values, color=BLUE, width=0.6)
    for at, value in zip(order, values, strict=True):
        axes.annotate(
            f"{value:.3g}", (at, value), xytext=(0, 3), textcoords="offset points", ha="center", va="bottom", fontsize=8
        )
    axes.set(
        xlabel="order of the mesh frequency [-]",
        ylabel="amplitude [arcsec]",
        ylim=(0.0, 1.15 * max(float(values.max()), 1e-6)),
        xticks=order,
    )
    axes.set_title(f"{side.pair.name}, {side.side}:\nharmonics of the transmission error", fontsize=10)
    return figure
