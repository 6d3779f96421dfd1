"""Figures of a fit (parity, residuals, sensitivity) and of formulas (Stribeck and traction curves, maps)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ehl.common.figures import BLUE, GREY, ORANGE, axes_or_new, figure_of, new_figure, panels
from ehl.common.quantities import axis_label, quantity, to_display, typeset_units
from ehl.fluid.oil import Oil
from regression.data.dataset import Dataset, columns
from regression.fitting.cross_validation import held_out_friction
from regression.fitting.rows import BANDS, boundary_friction_of, computed_friction, fitted_rows
from regression.friction.conditions import Array, Conditions, conditions_of, state_across
from regression.friction.fitted import FittedFormula, friction_of_form
from regression.friction.models import COLEMAN_FRICTION, FrictionFlag
from regression.friction.published_registry import PUBLISHED
from regression.view.tables import conditions_text, region_text

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

    from regression.fitting.sensitivity import SobolIndices

_HELD = ("pressure_hertz", "radius_equivalent", "speed_entrainment", "slide_to_roll_total", "temperature_oil")
_NEAR = 0.22  # largest distance of each variable of a near case, over the range of the variable
_POINTS = 121
_MAP = 41
_EXTRAPOLATED = (FrictionFlag.EXTRAPOLATED_NEAR, FrictionFlag.EXTRAPOLATED_FAR, FrictionFlag.OUTSIDE_RANGE)


@dataclass(frozen=True)
class CurveConditions:
    """Conditions of curves."""

    frame: pd.DataFrame  # fitted rows; those of one oil are shown with the curves
    oil: Oil  # its card
    oil_name: str  # name of the oil in the rows: for a card of the user its path, not the name on the card
    held: Mapping[str, float]  # SI value of every variable; curves and maps vary some of them
    ranges: Mapping[str, tuple[float, float]]  # smallest and largest value of every variable in the data

    def at(self, **values: float) -> CurveConditions:
        """Copy with other constant values."""
        return replace(self, held={**self.held, **values})

    def conditions(self, **varied: Array) -> dict[str, Array]:
        """Local conditions with some variables as arrays; sliding is across the contact line."""
        return conditions_of(state_across({**self.held, **varied}), self.oil)

    def quantiles(
        self, name: str, shares: Sequence[float] = (0.15, 0.5, 0.85), above: float = -math.inf
    ) -> list[float]:
        """Quantiles of the values of a variable."""
        values = self.rows[name].to_numpy(dtype=float)
        return [float(value) for value in np.quantile(values[values > above], shares)]

    @cached_property
    def rows(self) -> pd.DataFrame:
        """The fitted rows of the oil."""
        return self.frame[self.frame["oil"] == self.oil_name]

    def near(self, *free: str) -> tuple[Array, dict[str, Array]]:
        """Friction and variables of the computed cases near the constant values; variables in `free` are ignored."""
        frame = self.rows
        inside = np.ones(len(frame), dtype=bool)
        for name in (*_HELD, "roughness_rms"):
            low, high = self.ranges[name]
            if name not in free and high > low:
                values, held = frame[name].to_numpy(dtype=float), self.held[name]
                if AXES[name] and low > 0.0:
                    values, held, low, high = np.log(values), np.log(held), np.log(low), np.log(high)
                inside &= np.abs(values - held) <= _NEAR * (high - low)
        frame = frame[inside]
        table = {name: frame[name].to_numpy(dtype=float) for name in (*_HELD, "roughness_rms", "film_ratio_formula")}
        return frame["friction_coefficient"].to_numpy(dtype=float), table

    def description(self) -> str:
        """The constant values as text."""
        return conditions_text({name: self.held[name] for name in (*_HELD, "roughness_rms")})


def middle_conditions(dataset: Dataset, oil: str) -> CurveConditions:
    """The middle of the data of one oil: the median of every variable."""
    every = fitted_rows(dataset)
    frame = every[every["oil"] == oil]
    names = (*_HELD, "roughness_rms", "correlation_length", "peklenik_number", "effective_modulus")
    held = {name: float(frame[name].median()) for name in names}
    ranges = {name: (float(frame[name].min()), float(frame[name].max())) for name in names}
    return CurveConditions(every, Oil.load(oil), oil, held, ranges)


def varies(middle: CurveConditions, name: str) -> bool:
    """Whether the data contain more than one value of a variable."""
    low, high = middle.ranges[name]
    return high > low * (1.0 + 1e-6)


def plot_stribeck(middle: CurveConditions, formulas: Sequence[FittedFormula]) -> Figure:
    """Friction over the film ratio at three slide-to-roll ratios, from slow and rough to fast and smooth."""
    all_axes = _three(4.9)
    ends = (middle.quantiles(name, (0.03, 0.97), above=0.0) for name in ("speed_entrainment", "roughness_rms"))
    speed, rough = (np.geomspace(low, high, _POINTS) for low, high in ends)
    for axes, sliding in zip(all_axes, middle.quantiles("slide_to_roll_total"), strict=True):
        here = middle.at(slide_to_roll_total=sliding)
        varied = {"speed_entrainment": speed, "roughness_rms": rough[::-1]}
        ratio = _curves(axes, "film_ratio_formula", here, varied, formulas)[0]["film_ratio_formula"]
        axes.set(xscale="log", xlabel="film ratio λ by formula [-]", xlim=(ratio[0], ratio[-1]))
        axes.set_title(f"|SR| {sliding:.2g}", fontsize=10)
        plain_ticks(axes.xaxis, ratio[0], ratio[-1])
    least, most = middle.frame["friction_coefficient"].quantile((0.01, 0.995))
    for axes in all_axes:
        axes.set(yscale="log", ylim=(0.6 * least, 2.0 * most))
        plain_ticks(axes.yaxis, 0.6 * least, 2.0 * most)
    all_axes[0].set_ylabel("friction coefficient µ [-]")
    return _with_legend(all_axes, ncols=5, fontsize=8)


def plot_traction(middle: CurveConditions, formulas: Sequence[FittedFormula]) -> Figure:
    """Friction over the slide-to-roll ratio at three pressures."""
    all_axes = _three(4.9)
    high = middle.ranges["slide_to_roll_total"][1]
    sliding = np.linspace(0.0, high, 4 * _POINTS)
    reach: list[float] = []
    for axes, pressure in zip(all_axes, middle.quantiles("pressure_hertz"), strict=True):
        varied = {"slide_to_roll_total": sliding}
        table, mu = _curves(axes, "slide_to_roll_total", middle.at(pressure_hertz=pressure), varied, formulas)
        axes.set(xlabel="|SR| [-]", xlim=(0.0, high))
        axes.set_title(f"Hertz pressure {quantity('pressure_hertz').text(pressure, 2)}", fontsize=10)
        reach.append(float(np.quantile(mu, 0.95)) if mu.size else 0.0)
        reach.append(1.3 * float(np.nanmax(formulas[0].evaluate(table).mu)))
    # formulas with much larger friction are cut off
    all_axes[0].set(ylim=(0.0, max(1.6 * max(reach), 1.1 * COLEMAN_FRICTION)), ylabel="friction coefficient µ [-]")
    return _with_legend(all_axes, ncols=5, fontsize=8)


def plot_maps(middle: CurveConditions, formula: FittedFormula) -> Figure:
    """Friction over pressure and speed by a formula, with near computed cases in the same colours.

    The panels show three roughnesses, or three slide-to-roll ratios if the roughness does not vary.
    """
    from matplotlib.colors import LogNorm

    all_axes = _three(3.6)
    pressure = np.linspace(*middle.ranges["pressure_hertz"], _MAP)
    speed = np.geomspace(*middle.ranges["speed_entrainment"], _MAP)
    grid = dict(zip(("speed_entrainment", "pressure_hertz"), np.meshgrid(speed, pressure), strict=True))
    third = "roughness_rms" if varies(middle, "roughness_rms") else "slide_to_roll_total"
    panels_at = [middle.at(**{third: value}) for value in middle.quantiles(third)]
    up = to_display("pressure_hertz", pressure)
    maps = [formula.evaluate(here.conditions(**grid)) for here in panels_at]
    every = np.concatenate([value.mu.ravel() for value in maps])
    levels = np.geomspace(0.98 * np.nanmin(every), 1.02 * np.nanmax(every), 17)
    norm = LogNorm(levels[0], levels[-1])
    for axes, here, value in zip(all_axes, panels_at, maps, strict=True):
        filled = axes.contourf(speed, up, value.mu, levels=levels, cmap="viridis", norm=norm)
        extrapolated = np.isin(value.flag, _EXTRAPOLATED)
        if extrapolated.any():
            axes.contourf(speed, up, extrapolated, levels=(0.5, 1.5), colors="none", hatches=["///"])
        mu, near = here.near("pressure_hertz", "speed_entrainment")
        x, y = near["speed_entrainment"], to_display("pressure_hertz", near["pressure_hertz"])
        axes.scatter(x, y, c=mu, cmap="viridis", norm=norm, s=26, edgecolors="white", linewidths=0.8)
        axes.set(xscale="log", xlabel=axis_label("speed_entrainment"))
        plain_ticks(axes.xaxis, speed[0], speed[-1])
        held = typeset_units(quantity(third).text(here.held[third], 2))
        axes.set_title(f"{quantity(third).label} {held}", fontsize=10)
    all_axes[0].set_ylabel(axis_label("pressure_hertz"))
    figure = figure_of(all_axes[0])
    bar = figure.colorbar(filled, ax=all_axes, label="friction coefficient µ [-]")
    bar.set_ticks(levels[::4].tolist(), labels=[f"{level:.2g}" for level in levels[::4]])
    return figure


def _curves(
    axes: Axes, over: str, here: CurveConditions, varied: dict[str, Array], formulas: Sequence[FittedFormula]
) -> tuple[Conditions, Array]:
    """Draw near cases and all formulas over a variable; returns the conditions, and the friction of the cases."""
    from matplotlib import colormaps

    table, (computed, near) = here.conditions(**varied), here.near(*varied)
    axes.plot(near[over], computed, ".", color="black", ms=4, alpha=0.6, label="computed, near")
    x, shades = table[over], colormaps["tab20"]
    for number, published in enumerate(PUBLISHED.values()):
        mu, _ = published.values(table, here.oil.base)
        dash = ("-", "--", ":")[number % 3]
        axes.plot(x, mu, color=shades(number / 20.0), ls=dash, lw=1.0, label=f"{published.label}{published.mark}")
    axes.axhline(COLEMAN_FRICTION, color=GREY, lw=1.0, label="constant 0.05 (Coleman)")
    for number, formula in reversed(list(enumerate(formulas))):
        value = formula.evaluate(table)
        colour = COLOURS[number % len(COLOURS)]
        axes.plot(x, value.mu, color=colour, lw=2.4 if number == 0 else 1.6, label=formula.label)
        if number == 0:
            axes.fill_between(x, value.lower, value.upper, color=colour, alpha=0.15, lw=0.0)
    return table, computed


def _three(height: float, count: int = 3) -> list[Axes]:
    """Panels, three in a row, with one scale of friction."""
    return panels(count, 3, (0.0, 0.0), (10.4 / 3.0, height), dpi=RASTER_DPI, sharey=True)


def _with_legend(all_axes: Sequence[Axes], ncols: int, fontsize: float | None = None) -> Figure:
    """Their figure with one legend for all panels, fitted formulas first."""
    figure = figure_of(all_axes[0])
    handles, labels = all_axes[0].get_legend_handles_labels()
    style = {"ncols": ncols, "frameon": False, "fontsize": fontsize}
    figure.legend(handles[::-1], labels[::-1], loc="outside lower center", **style)
    return figure


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
    all_axes = panels(len(bands), 2, (0.0, 0.0), (4.8, 4.2), dpi=RASTER_DPI)
    for axes, (low, high) in zip(all_axes, bands, strict=True):
        inside = (ratio >= low) & (ratio < high) if math.isfinite(low) else np.isinf(ratio)
        ends = np.quantile(mu[inside], (0.005, 1.0)) * (0.7, 1.3)
        # the best formula on top
        for order, (name, values) in reversed(list(enumerate(shown.items()))):
            x, y = np.maximum(mu, ends[0]), np.clip(values, 0.5 * ends[0], 2.0 * ends[1])
            if order == 0:
                rest = inside & ~used
                axes.plot(x[rest], y[rest], ".", ms=4, color="#b9bec6", alpha=0.7, label="left out", rasterized=True)
            here, colour = inside & used, COLOURS[order % len(COLOURS)]
            alpha = 0.75 if order == 0 else 0.35
            axes.plot(x[here], y[here], ".", ms=4, label=name, color=colour, alpha=alpha, rasterized=True)
        _equal_within_tenth(axes, ends)
        axes.set(xscale="log", yscale="log", xlim=ends, ylim=(0.5 * ends[0], 2.0 * ends[1]))
        axes.set(xlabel="computed friction coefficient [-]", ylabel="by formula, held out [-]")
        axes.set_title(_band_title(low, high, int((inside & used).sum())), fontsize=10)
        plain_ticks(axes.xaxis, *ends)
        plain_ticks(axes.yaxis, 0.5 * ends[0], 2.0 * ends[1])
    return _with_legend(all_axes, ncols=4)


def _equal_within_tenth(axes: Axes, ends: Array) -> None:
    axes.plot(ends, ends, color="black", lw=0.8)
    for factor in (0.9, 1.1):
        axes.plot(ends, factor * ends, color="black", lw=0.6, ls="--")


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
    all_axes = _three(2.7, len(shown))
    limit = max(1.1, float(np.exp(1.2 * np.quantile(np.abs(np.log(ratio)), 0.98))))
    for number, (axes, name) in enumerate(zip(all_axes, shown, strict=True)):
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
    return figure_of(all_axes[0])


def _varies(values: Array) -> bool:
    finite = values[np.isfinite(values)]
    return finite.size > 1 and float(np.ptp(finite)) > 1e-6 * float(np.abs(finite).max())


def _running(x: Array, y: Array) -> tuple[Array, Array, Array, Array]:
    """Centre, 5 %, 50 % and 95 % quantiles of y in slices of x with equal numbers of points."""
    order = np.argsort(x)
    slices = [part for part in np.array_split(order, min(12, max(1, len(x) // 10))) if part.size]
    centre = np.array([np.median(x[part]) for part in slices])
    quantiles = np.array([np.quantile(y[part], (0.05, 0.5, 0.95)) for part in slices])
    return centre, quantiles[:, 0], quantiles[:, 1], quantiles[:, 2]


def plot_bands(formula: FittedFormula) -> Axes:
    """Held-out errors by band of each variable: bars for the mean, marks for the 95 % quantile."""
    bands = formula.bands
    axes = axes_or_new(None, 7.6, 1.3 + 0.26 * len(bands))
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
    return axes


def plot_sensitivity(indices: SobolIndices) -> Axes:
    """First-order and total Sobol indices of ln mu with their 90 % intervals, the largest first."""
    order = np.argsort(indices.total)
    axes = axes_or_new(None, 6.0, 0.5 * len(order) + 1.3)
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
    return axes


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
    _equal_within_tenth(axes, ends)
    axes.set(xscale="log", yscale="log", xlim=ends)
    axes.set(xlabel="computed friction coefficient [-]", ylabel="held-out friction coefficient by formula [-]")
    axes.legend(handles=lines[::-1], frameon=False, loc="upper left")
    return axes
