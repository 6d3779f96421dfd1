"""Figures of a fit: parity by regime, residuals over every variable, sensitivity."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ehl.common.figures import BLUE, GREY, ORANGE, axes_or_new, new_figure
from ehl.common.quantities import quantity, typeset_units
from regression.data.dataset import Dataset, columns
from regression.fitting.cross_validation import held_out_friction
from regression.fitting.noise import BANDS
from regression.fitting.rows import boundary_friction_of, computed_friction, fitted_rows
from regression.friction.conditions import Array
from regression.friction.fitted import FittedFormula, friction_of_form
from regression.view.tables import region_text

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

    from regression.fitting.sensitivity import SobolIndices

COLOURS = (BLUE, ORANGE, "#4f8f5b", "#8d5a97", "#b0413e", "#5f6b2d")
RASTER_DPI = 160  # of the scattered points inside the vector figure
# variables of the figures, and whether their axis is logarithmic
AXES: dict[str, bool] = {
    "film_ratio": True,
    "pressure_hertz": False,
    "radius_equivalent": True,
    "speed_entrainment": True,
    "slide_to_roll_total": True,
    "temperature_oil": False,
    "viscosity_inlet": True,
    "roughness_rms": True,
    "correlation_length": True,
    "peklenik_number": True,
    "asperity_load_share": False,
}


def checked_rows(dataset: Dataset) -> pd.DataFrame:
    """Rows on which a formula can be compared: those with sliding and positive friction."""
    frame = dataset.converged
    usable = (frame["friction_coefficient"] > 0.0) & (frame["slide_to_roll_total"] > 0.0)
    return frame[usable].reset_index(drop=True)


def friction_of_rows(formula: FittedFormula, frame: pd.DataFrame) -> Array:
    """Friction coefficient of a formula for rows of a dataset, with the boundary friction of each row."""
    values = columns(frame)
    return friction_of_form(formula.form, formula.coefficients, formula.network, values, boundary_friction_of(frame))[0]


def plot_regimes(dataset: Dataset, formulas: Sequence[FittedFormula]) -> Figure:
    """Held-out friction by every formula over computed friction, one panel for each band of the film ratio.

    Cases that were excluded from the fit are shown with the best formula.
    """
    frame = checked_rows(dataset)
    mu, ratio = computed_friction(frame), frame["film_ratio"].to_numpy(dtype=float)
    used = frame["key"].isin(fitted_rows(dataset, formulas[0])["key"]).to_numpy(dtype=bool)
    shown = {formula.label: friction_of_rows(formula, frame) for formula in formulas}
    for formula in formulas:
        # both tables are sorted by key
        shown[formula.label][used] = held_out_friction(dataset, formula).mu
    limits = list(itertools.pairwise((0.0, *BANDS["film_ratio"], math.inf)))
    bands = [(low, high) for low, high in limits if ((ratio >= low) & (ratio < high)).any()]
    if np.isinf(ratio).any():
        bands.append((math.inf, math.inf))
    figure = new_figure(9.6, 4.2 * math.ceil(len(bands) / 2), dpi=RASTER_DPI)
    panels = np.ravel(figure.subplots(math.ceil(len(bands) / 2), 2, squeeze=False))
    for axes, (low, high) in zip(panels, bands, strict=False):
        inside = (ratio >= low) & (ratio < high) if math.isfinite(low) else np.isinf(ratio)
        ends = np.quantile(mu[inside], (0.005, 1.0)) * (0.7, 1.3)
        # the best formula on top
        for order, (name, values) in reversed(list(enumerate(shown.items()))):
            x, y = np.maximum(mu, ends[0]), np.clip(values, 0.5 * ends[0], 2.0 * ends[1])
            if order == 0:
                rest = inside & ~used
                axes.plot(x[rest], y[rest], ".", ms=4, color="#b9bec6", alpha=0.7, label="left out", rasterized=True)
            here, style = inside & used, {"color": COLOURS[order % len(COLOURS)], "alpha": 0.75 if order == 0 else 0.35}
            axes.plot(x[here], y[here], ".", ms=4, label=name, rasterized=True, **style)
        axes.plot(ends, ends, color="black", lw=0.8)
        for factor in (0.9, 1.1):
            axes.plot(ends, factor * ends, color="black", lw=0.6, ls="--")
        axes.set(xscale="log", yscale="log", xlim=ends, ylim=(0.5 * ends[0], 2.0 * ends[1]))
        axes.set(xlabel="computed friction coefficient [-]", ylabel="by formula, held out [-]")
        axes.set_title(_band_title(low, high, int((inside & used).sum())), fontsize=10)
        plain_ticks(axes.xaxis, *ends)
        plain_ticks(axes.yaxis, 0.5 * ends[0], 2.0 * ends[1])
    for axes in panels[len(bands) :]:
        axes.set_axis_off()
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles[::-1], labels[::-1], loc="outside lower center", ncols=4, frameon=False)
    return figure


def _band_title(low: float, high: float, count: int) -> str:
    if math.isinf(low):
        return f"smooth, {count} cases fitted"
    ends = f"λ < {high:g}" if low == 0.0 else f"λ ≥ {low:g}" if math.isinf(high) else f"{low:g} ≤ λ < {high:g}"
    return f"{ends}, {count} cases fitted"


def plain_ticks(axis: Axis, low: float, high: float) -> None:
    """Tick labels of a logarithmic axis as decimals such as 0.01, without overlap."""
    from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, StrMethodFormatter

    steps = (1.0, 2.0, 5.0) if high < 40.0 * low else (1.0, 3.0) if high < 400.0 * low else (1.0,)
    # below a factor of six a logarithmic locator has too few ticks
    axis.set_major_locator(LogLocator(subs=steps) if high > 6.0 * low else MaxNLocator(5, steps=(1, 2, 5, 10)))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def plot_residuals(dataset: Dataset, formula: FittedFormula) -> Figure:
    """Ratio of held-out to computed friction of the fitted cases, with its running median and 5 to 95 % range."""
    frame = fitted_rows(dataset, formula)
    ratio = held_out_friction(dataset, formula).mu / computed_friction(frame)
    shown = [name for name in AXES if _varies(frame[name].to_numpy(dtype=float))]
    rows = math.ceil(len(shown) / 3)
    figure = new_figure(10.4, 2.7 * rows, dpi=RASTER_DPI)
    panels = np.ravel(figure.subplots(rows, 3, squeeze=False, sharey=True))
    limit = max(1.1, float(np.exp(1.2 * np.quantile(np.abs(np.log(ratio)), 0.98))))
    for number, (axes, name) in enumerate(zip(panels, shown, strict=False)):
        entry, logarithmic = quantity(name), AXES[name]
        values = frame[name].to_numpy(dtype=float)
        here = np.isfinite(values) & ((values > 0.0) if logarithmic else True)
        x, y = entry.to_display(values[here]), ratio[here]
        axes.plot(x, np.clip(y, 1.0 / limit, limit), ".", color=BLUE, ms=3, alpha=0.4, rasterized=True)
        centre, low, middle, high = _running(x, y)
        axes.plot(centre, middle, color=ORANGE, lw=1.6)
        axes.fill_between(centre, low, high, color=ORANGE, alpha=0.18, lw=0.0)
        axes.axhline(1.0, color="black", lw=0.7)
        axes.set(xlabel=entry.axis_label, yscale="log", ylim=(0.95 / limit, limit / 0.95))
        plain_ticks(axes.yaxis, 1.0 / limit, limit)
        if logarithmic:
            axes.set_xscale("log")
            plain_ticks(axes.xaxis, float(x.min()), float(x.max()))
        if number % 3 == 0:
            axes.set_ylabel("µ held out over\ncomputed µ [-]")
    for axes in panels[len(shown) :]:
        axes.set_axis_off()
    return figure


def _varies(values: Array) -> bool:
    finite = values[np.isfinite(values)]
    return finite.size > 1 and float(np.ptp(finite)) > 1e-6 * float(np.abs(finite).max())


def _running(x: Array, y: Array, count: int = 12) -> tuple[Array, Array, Array, Array]:
    """Centre, 5 %, 50 % and 95 % quantiles of y in slices of x with equal numbers of points."""
    order = np.argsort(x)
    slices = [part for part in np.array_split(order, min(count, max(1, len(x) // 10))) if part.size]
    centre = np.array([np.median(x[part]) for part in slices])
    quantiles = np.array([np.quantile(y[part], (0.05, 0.5, 0.95)) for part in slices])
    return centre, quantiles[:, 0], quantiles[:, 1], quantiles[:, 2]


def plot_bands(formula: FittedFormula) -> Figure:
    """Held-out errors by band of each variable: bars for the mean, marks for the 95 % quantile."""
    bands = formula.bands
    figure = new_figure(7.6, 1.3 + 0.26 * len(bands))
    axes = figure.add_subplot()
    names = list(dict.fromkeys(band.variable for band in bands))
    mean, most = (np.array([100.0 * getattr(band, name) for band in bands]) for name in ("mape", "p95"))
    place = np.arange(len(bands))
    axes.barh(place, mean, color=[(BLUE, GREY)[names.index(band.variable) % 2] for band in bands], label="mean")
    axes.plot(most, place, "|", color=ORANGE, ms=11, mew=2, label="95 % quantile")
    for at, band in zip(place, bands, strict=True):
        end = (max(mean[at], most[at]), at)
        axes.annotate(f"{band.count}", end, xytext=(6, 0), textcoords="offset points", fontsize=7, va="center")
    axes.set_yticks(place, [typeset_units(region_text(b.variable, b.low, b.high)) for b in bands], fontsize=8)
    axes.invert_yaxis()
    axes.set(xlabel="error of held-out cases [%]", xlim=(0.0, 1.1 * max(float(mean.max()), float(most.max()))))
    axes.grid(axis="x", alpha=0.3)
    axes.legend(frameon=False, fontsize=8, loc="lower right")
    return figure


def plot_sensitivity(indices: SobolIndices) -> Figure:
    """First-order and total Sobol indices of ln mu with their 90 % intervals, the largest first."""
    order = np.argsort(indices.total)
    figure = new_figure(6.0, 0.5 * len(order) + 1.3)
    axes = figure.add_subplot()
    places = np.arange(len(order))
    for shift, values, interval, colour, label in (
        (0.19, indices.total, indices.total_interval, BLUE, "total, with interactions"),
        (-0.19, indices.first, indices.first_interval, GREY, "alone"),
    ):
        reach = np.abs(interval[order].T - values[order])
        axes.barh(places + shift, values[order], height=0.36, color=colour, label=label, xerr=reach, ecolor="black")
    labels = [quantity(name).label for name in indices.names]
    axes.set_yticks(places, [labels[i] for i in order])
    axes.set(xlabel="share of the variance of ln µ [-]", xlim=(0.0, None))
    axes.legend(frameon=False, loc="lower right")
    return figure


def plot_friction(dataset: Dataset) -> Figure:
    """Computed friction over the film ratio, coloured by the slide-to-roll ratio."""
    frame = dataset.converged
    figure = new_figure(6.0, 4.6)
    axes = figure.add_subplot()
    ratio = frame["film_ratio"].to_numpy()
    rough = np.isfinite(ratio)
    x = ratio if rough.any() else frame["slide_to_roll_total"].to_numpy()
    mu, colour = frame["friction_coefficient"], frame["slide_to_roll_total"]
    points = axes.scatter(x, mu, c=colour, norm="log", cmap="viridis", s=18, linewidths=0.0)
    figure.colorbar(points, ax=axes, label="|SR| [-]")
    axes.set_xscale("log")
    axes.set(xlabel="film ratio [-]" if rough.any() else "|SR| [-]", ylabel="friction coefficient [-]")
    axes.set_ylim(bottom=0.0)
    return figure


def plot_parity(dataset: Dataset, formulas: Sequence[FittedFormula], ax: Axes | None = None) -> Axes:
    """Held-out friction by each formula over computed friction, best formula on top; dashed lines at 10 %."""
    mu = fitted_rows(dataset, formulas[0])["friction_coefficient"].to_numpy(dtype=float)
    axes = axes_or_new(ax, 6.0, 4.6)
    lines = []
    for formula, colour in reversed(list(zip(formulas, (BLUE, ORANGE, GREY), strict=False))):
        label = f"{formula.label} (MAPE {100.0 * formula.validation.mape:.2g} %)"
        held_out = held_out_friction(dataset, formula).mu
        lines += axes.plot(mu, held_out, ".", color=colour, ms=5, alpha=0.8, label=label)
    ends = np.array([0.8 * mu.min(), 1.15 * mu.max()])
    axes.plot(ends, ends, color="black", lw=0.8)
    for factor in (0.9, 1.1):
        axes.plot(ends, factor * ends, color="black", lw=0.6, ls="--")
    axes.set(xscale="log", yscale="log", xlim=ends)
    axes.set(xlabel="computed friction coefficient [-]", ylabel="held-out friction coefficient by formula [-]")
    axes.legend(handles=lines[::-1], frameon=False, loc="upper left")
    return axes
