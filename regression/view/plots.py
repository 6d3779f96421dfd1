"""Figures of a dataset and of the formulas fitted to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ehl.view.plots import BLUE, GREY, ORANGE
from regression.data.dataset import Dataset
from regression.fitting.held_out import fitted_rows, held_out_friction
from regression.friction.formula import Formula

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
    """Held-out friction by each formula over the computed one, best formula on top; dashed lines 10 % off."""
    from matplotlib.figure import Figure

    mu = fitted_rows(dataset, formulas[0])["friction_coefficient"].to_numpy(dtype=float)
    figure = Figure(figsize=(6.0, 4.6), layout="constrained")
    axes = figure.add_subplot()
    lines = []
    for formula, colour in reversed(list(zip(formulas, (BLUE, ORANGE, GREY), strict=False))):
        label = f"{formula.name} (MAPE {100.0 * formula.validation.mape:.2g} %)"
        held_out = held_out_friction(dataset, formula).mu
        lines += axes.plot(mu, held_out, ".", color=colour, ms=5, alpha=0.8, label=label)
    ends = np.array([0.8 * mu.min(), 1.15 * mu.max()])
    axes.plot(ends, ends, color="black", lw=0.8)
    for factor in (0.9, 1.1):
        axes.plot(ends, factor * ends, color="black", lw=0.6, ls="--")
    axes.set(
        xscale="log",
        yscale="log",
        xlim=ends,
        xlabel="computed friction coefficient [-]",
        ylabel="held-out friction coefficient by formula [-]",
    )
    axes.legend(handles=lines[::-1], frameon=False, loc="upper left")
    return figure
