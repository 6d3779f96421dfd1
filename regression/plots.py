"""Figures of a dataset and of the formulas fitted to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ehl.plots import BLUE, GREY, ORANGE
from regression.dataset import Dataset, columns
from regression.formula import Formula

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_friction(dataset: Dataset) -> Figure:
    """Computed friction over the film ratio, coloured by the slide-to-roll ratio."""
    from matplotlib.figure import Figure

    frame = dataset.converged
    figure = Figure(figsize=(6.0, 4.6), layout="constrained")
    axes = figure.add_subplot()
    ratio = frame["film_ratio"].to_numpy()
    rough = np.isfinite(ratio)
    x = ratio if rough.any() else frame["slide_to_roll_total"].to_numpy()
    points = axes.scatter(
        x,
        frame["friction_coefficient"],
        c=frame["slide_to_roll_total"],
        norm="log",
        cmap="viridis",
        s=18,
        linewidths=0.0,
    )
    figure.colorbar(points, ax=axes, label="|SR| [-]")
    axes.set_xscale("log")
    axes.set(xlabel="film ratio [-]" if rough.any() else "|SR| [-]", ylabel="friction coefficient [-]")
    axes.set_ylim(bottom=0.0)
    return figure


def plot_parity(dataset: Dataset, formulas: Sequence[Formula]) -> Figure:
    """Friction by each formula over the computed one; dashed lines 10 % off."""
    from matplotlib.figure import Figure

    frame = dataset.converged
    mu = frame["friction_coefficient"].to_numpy()
    figure = Figure(figsize=(6.0, 4.6), layout="constrained")
    axes = figure.add_subplot()
    for formula, colour in zip(formulas, (BLUE, ORANGE, GREY), strict=False):
        predicted = formula.evaluate(columns(frame)).mu
        label = f"{formula.family} (held-out MAPE {100.0 * formula.validation.mape:.2g} %)"
        axes.plot(mu, predicted, ".", color=colour, ms=5, alpha=0.8, label=label)
    ends = np.array([0.8 * mu.min(), 1.15 * mu.max()])
    axes.plot(ends, ends, color="black", lw=0.8)
    for factor in (0.9, 1.1):
        axes.plot(ends, factor * ends, color="black", lw=0.6, ls="--")
    axes.set(
        xscale="log",
        yscale="log",
        xlim=ends,
        xlabel="computed friction coefficient [-]",
        ylabel="friction coefficient by formula [-]",
    )
    axes.legend(frameon=False, loc="upper left")
    return figure
