"""Figures of formulas: Stribeck curves, traction curves and maps, with the computed cases near them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ehl.common.figures import GREY, new_figure
from ehl.common.quantities import axis_label, quantity, to_display, typeset_units
from ehl.fluid.oil import Oil
from ehl.state import ContactState
from regression.data.dataset import Dataset
from regression.fitting.rows import fitted_rows
from regression.friction.conditions import Array, Conditions, conditions_of
from regression.friction.fitted import FittedFormula
from regression.friction.models import FrictionFlag
from regression.friction.published_registry import PUBLISHED
from regression.view.plots import AXES, COLOURS, RASTER_DPI, plain_ticks

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_HELD = ("pressure_hertz", "radius_equivalent", "speed_entrainment", "slide_to_roll_total", "temperature_oil")
_NEAR = 0.22  # largest distance of each variable of a near case, over the range of the variable
_POINTS = 121
_MAP = 41
COLEMAN = 0.05
_EXTRAPOLATED = (FrictionFlag.EXTRAPOLATED_NEAR, FrictionFlag.EXTRAPOLATED_FAR, FrictionFlag.OUTSIDE_RANGE)


@dataclass(frozen=True)
class CurveConditions:
    """Conditions of curves."""

    dataset: Dataset  # rows of one oil are shown with the curves
    oil: Oil  # its card
    oil_name: str  # name of the oil in the rows: for a card of the user its path, not the name on the card
    held: Mapping[str, float]  # SI value of every variable; curves and maps vary some of them
    ranges: Mapping[str, tuple[float, float]]  # smallest and largest value of every variable in the data

    def at(self, **values: float) -> CurveConditions:
        """Copy with other constant values."""
        return replace(self, held={**self.held, **values})

    def conditions(self, **varied: Array) -> dict[str, Array]:
        """Local conditions with some variables as arrays; sliding is across the contact line."""
        values: dict[str, float | Array] = {**self.held, **varied}
        rough = np.asarray(values["roughness_rms"]) / np.sqrt(2.0)
        state = ContactState.of(
            pressure_hertz=values["pressure_hertz"],
            radius_equivalent=values["radius_equivalent"],
            effective_modulus=values["effective_modulus"],
            speed_entrainment=values["speed_entrainment"],
            slide_to_roll=values["slide_to_roll_total"],
            temperature_oil=values["temperature_oil"],
            correlation_length=values["correlation_length"],
            peklenik_number=values["peklenik_number"],
            roughness_rms_1=rough,
            roughness_rms_2=rough,
        )
        return conditions_of(state, self.oil)

    def near(self, *free: str) -> tuple[Array, dict[str, Array]]:
        """Friction and variables of the computed cases near the constant values; variables in `free` are ignored."""
        frame = fitted_rows(self.dataset)
        frame = frame[frame["oil"] == self.oil_name]
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

    def description(self, *left_out: str) -> str:
        """The constant values in words."""
        parts = []
        for name in (*_HELD, "roughness_rms"):
            if name not in left_out:
                entry = quantity(name)
                parts.append(f"{entry.label} {entry.text(self.held[name], 3)}")
        return ", ".join(parts)


def middle_conditions(dataset: Dataset, oil: str) -> CurveConditions:
    """The middle of the data of one oil: the median of every variable."""
    frame = fitted_rows(dataset)
    frame = frame[frame["oil"] == oil]
    names = (*_HELD, "roughness_rms", "correlation_length", "peklenik_number", "effective_modulus")
    held = {name: float(frame[name].median()) for name in names}
    ranges = {name: (float(frame[name].min()), float(frame[name].max())) for name in names}
    return CurveConditions(dataset, Oil.load(oil), oil, held, ranges)


def varies(middle: CurveConditions, name: str) -> bool:
    """Whether the data contain more than one value of a variable."""
    low, high = middle.ranges[name]
    return high > low * (1.0 + 1e-6)


def plot_stribeck(middle: CurveConditions, formulas: Sequence[FittedFormula]) -> Figure:
    """Friction over the film ratio at three slide-to-roll ratios, from slow and rough to fast and smooth."""
    figure = new_figure(10.4, 4.9, dpi=RASTER_DPI)
    panels = figure.subplots(1, 3, sharey=True)
    speed, rough = (np.geomspace(*_ends(middle, name), _POINTS) for name in ("speed_entrainment", "roughness_rms"))
    for axes, sliding in zip(panels, _spread(middle, "slide_to_roll_total"), strict=True):
        here = middle.at(slide_to_roll_total=sliding)
        table = here.conditions(speed_entrainment=speed, roughness_rms=rough[::-1])
        mu, near = here.near("speed_entrainment", "roughness_rms")
        axes.plot(near["film_ratio_formula"], mu, ".", color="black", ms=4, alpha=0.6, label="computed, near")
        _curves(axes, table["film_ratio_formula"], table, formulas, middle.oil.base)
        ratio = table["film_ratio_formula"]
        axes.set(xscale="log", xlabel="film ratio λ by formula [-]", xlim=(ratio[0], ratio[-1]))
        axes.set_title(f"|SR| {sliding:.2g}", fontsize=10)
        plain_ticks(axes.xaxis, ratio[0], ratio[-1])
    frame = fitted_rows(middle.dataset)
    least, most = frame["friction_coefficient"].quantile((0.01, 0.995))
    for axes in panels:
        axes.set(yscale="log", ylim=(0.6 * least, 2.0 * most))
        plain_ticks(axes.yaxis, 0.6 * least, 2.0 * most)
    _legend(figure, panels)
    return figure


def plot_traction(middle: CurveConditions, formulas: Sequence[FittedFormula]) -> Figure:
    """Friction over the slide-to-roll ratio at three pressures."""
    figure = new_figure(10.4, 4.9, dpi=RASTER_DPI)
    panels = figure.subplots(1, 3, sharey=True)
    high = middle.ranges["slide_to_roll_total"][1]
    sliding = np.linspace(0.0, high, 4 * _POINTS)
    reach: list[float] = []
    for axes, pressure in zip(panels, _spread(middle, "pressure_hertz"), strict=True):
        here = middle.at(pressure_hertz=pressure)
        table = here.conditions(slide_to_roll_total=sliding)
        mu, near = here.near("slide_to_roll_total")
        axes.plot(near["slide_to_roll_total"], mu, ".", color="black", ms=4, alpha=0.6, label="computed, near")
        _curves(axes, sliding, table, formulas, middle.oil.base)
        axes.set(xlabel="|SR| [-]", xlim=(0.0, high))
        axes.set_title(f"Hertz pressure {quantity('pressure_hertz').text(pressure, 2)}", fontsize=10)
        reach.append(float(np.quantile(mu, 0.95)) if mu.size else 0.0)
        reach.append(1.3 * float(np.nanmax(formulas[0].evaluate(table).mu)))
    # formulas with much larger friction are cut off
    panels[0].set_ylim(0.0, max(1.6 * max(reach), 1.1 * COLEMAN))
    _legend(figure, panels)
    return figure


def plot_maps(middle: CurveConditions, formula: FittedFormula) -> Figure:
    """Friction over pressure and speed by a formula, with near computed cases in the same colours.

    The panels show three roughnesses, or three slide-to-roll ratios if the roughness does not vary.
    """
    from matplotlib.colors import LogNorm

    figure = new_figure(10.4, 3.6, dpi=RASTER_DPI)
    panels = figure.subplots(1, 3, sharey=True)
    pressure = np.linspace(*middle.ranges["pressure_hertz"], _MAP)
    speed = np.geomspace(*middle.ranges["speed_entrainment"], _MAP)
    grid = dict(zip(("speed_entrainment", "pressure_hertz"), np.meshgrid(speed, pressure), strict=True))
    third = "roughness_rms" if varies(middle, "roughness_rms") else "slide_to_roll_total"
    panels_at = [middle.at(**{third: value}) for value in _spread(middle, third)]
    up = to_display("pressure_hertz", pressure)
    maps = [formula.evaluate(here.conditions(**grid)) for here in panels_at]
    every = np.concatenate([value.mu.ravel() for value in maps])
    levels = np.geomspace(0.98 * np.nanmin(every), 1.02 * np.nanmax(every), 17)
    norm = LogNorm(levels[0], levels[-1])
    for axes, here, value in zip(panels, panels_at, maps, strict=True):
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
    panels[0].set_ylabel(axis_label("pressure_hertz"))
    bar = figure.colorbar(filled, ax=panels, label="friction coefficient µ [-]")
    bar.set_ticks(levels[::4].tolist(), labels=[f"{level:.2g}" for level in levels[::4]])
    return figure


def _spread(middle: CurveConditions, name: str) -> tuple[float, float, float]:
    """The 15, 50 and 85 % quantiles of a variable."""
    frame = fitted_rows(middle.dataset)
    values = frame.loc[frame["oil"] == middle.oil_name, name].to_numpy(dtype=float)
    low, centre, high = (float(value) for value in np.quantile(values, (0.15, 0.5, 0.85)))
    return low, centre, high


def _curves(axes: Axes, x: Array, table: Conditions, formulas: Sequence[FittedFormula], base: str) -> None:
    from matplotlib import colormaps

    shades = colormaps["tab20"]
    for number, published in enumerate(PUBLISHED.values()):
        mu, _ = published.values(table, base)
        dash = ("-", "--", ":")[number % 3]
        axes.plot(x, mu, color=shades(number / 20.0), ls=dash, lw=1.0, label=f"{published.label}{published.mark}")
    axes.axhline(COLEMAN, color=GREY, lw=1.0, label="constant 0.05 (Coleman)")
    for number, formula in reversed(list(enumerate(formulas))):
        value = formula.evaluate(table)
        colour = COLOURS[number % len(COLOURS)]
        axes.plot(x, value.mu, color=colour, lw=2.4 if number == 0 else 1.6, label=formula.label)
        if number == 0:
            axes.fill_between(x, value.lower, value.upper, color=colour, alpha=0.15, lw=0.0)


def _legend(figure: Figure, panels: Sequence[Axes]) -> None:
    """One legend for all panels, fitted formulas first."""
    panels[0].set_ylabel("friction coefficient µ [-]")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles[::-1], labels[::-1], loc="outside lower center", ncols=5, frameon=False, fontsize=8)


def _ends(middle: CurveConditions, name: str) -> tuple[float, float]:
    """The 3 and 97 % quantiles of a variable."""
    frame = fitted_rows(middle.dataset)
    values = frame.loc[frame["oil"] == middle.oil_name, name].to_numpy(dtype=float)
    low, high = (float(value) for value in np.quantile(values[values > 0.0], (0.03, 0.97)))
    return low, high
