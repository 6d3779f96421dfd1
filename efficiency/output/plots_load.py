"""Figures of a loaded mesh: load sharing, transmission error, friction and loss, comparisons."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ehl.common.figures import BLUE, GREY, ORANGE, new_figure
from ehl.common.quantities import axis_label, quantity, to_display, typeset_units
from regression.friction.published_registry import model_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from efficiency.conditions.grid import Grid
    from efficiency.loss.compare import Comparison
    from efficiency.loss.efficiency_result import EfficiencyResult


FloatArray = NDArray[np.float64]
OPERATION = ("torque", "speed", "temperature")


def _figure(width: float = 7.0, height: float = 4.2) -> tuple[Figure, Axes]:
    figure = new_figure(width, height)
    return figure, figure.add_subplot()


def plot_load_sharing(result: EfficiencyResult) -> Figure:
    """Share of the torque carried by one tooth pair over its roll angle, in pinion pitches."""
    figure, axes = _figure()
    pitch = _pitch(result)
    roll, share = [], []
    for load in result.load.positions:
        for pair, part in load.share.items():
            roll.append(load.position.pinion_angle / pitch + pair)
            share.append(part)
    order = np.argsort(roll)
    axes.plot(np.array(roll)[order], np.array(share)[order], color=BLUE, marker=".", ms=4)
    axes.set(
        xlabel="roll of one tooth pair from the design point [pinion pitches]",
        ylabel="share of the torque [-]",
        ylim=(0.0, 1.05),
        title=f"Load sharing at {result.torque:g} N m",
    )
    return figure


def plot_pair_load(result: EfficiencyResult) -> Figure:
    """Normal force and greatest Hertz pressure of one tooth pair over its roll angle, in pinion pitches."""
    figure, axes = _figure()
    pitch = _pitch(result)
    rows = sorted(
        (
            load.position.pinion_angle / pitch + int(pair),
            to_display("force", float(load.force[load.position.pair == pair].sum())),
            to_display("pressure_hertz", float(load.pressure_hertz[load.position.pair == pair].max())),
        )
        for load in result.load.positions
        for pair in np.unique(load.position.pair)
    )
    roll, force, pressure = np.array(rows).T
    axes.plot(roll, force, color=BLUE, marker=".", ms=4, label="normal force")
    axes.set(
        xlabel="roll of one tooth pair from the design point [pinion pitches]",
        ylabel=axis_label("force"),
        ylim=(0.0, 1.25 * float(force.max())),
    )
    other = axes.twinx()
    other.plot(roll, pressure, color=ORANGE, marker=".", ms=4, label="greatest Hertz pressure")
    other.set(ylabel="greatest " + axis_label("pressure_hertz"), ylim=(0.0, 1.25 * float(pressure.max())))
    handles = [*axes.get_lines(), *other.get_lines()]
    axes.legend(handles, [str(line.get_label()) for line in handles], frameon=False, loc="upper left", ncols=2)
    axes.set_title(f"Load of one tooth pair at {result.torque:g} N m")
    return figure


def plot_root_stress(result: EfficiencyResult) -> Figure:
    """Greatest root stress of both members over the roll of the tooth pair, and along the face."""
    strength, pitch = result.strength, _pitch(result)
    figure = new_figure(9.0, 3.6)
    over, along = figure.subplots(1, 2)
    for root, color in ((strength.pinion, BLUE), (strength.gear, ORANGE)):
        if root is None:
            continue
        tension, pressed = (to_display("root_stress_pinion", x) for x in (root.history, root.history_compression))
        over.plot(root.roll / pitch, tension, color=color, marker=".", ms=4, label=f"{root.member}, loaded side")
        over.plot(root.roll / pitch, pressed, color=color, lw=0.8, ls="--", label=f"{root.member}, other side")
        along.plot(to_display("face_gear", root.station), to_display("root_stress_pinion", root.along), color=color)
    over.axhline(0.0, color=GREY, lw=0.6)
    over.set(xlabel="roll of one tooth pair from the design point [pinion pitches]", ylabel=axis_label("root_stress"))
    over.legend(frameon=False, fontsize=8)
    along.set(xlabel="distance from the toe [mm]", ylabel="greatest of the mesh [MPa]", ylim=(0.0, None))
    figure.suptitle(f"Root stress at {result.torque:g} N m")
    return figure


def plot_transmission_error(result: EfficiencyResult) -> Figure:
    """Loaded and unloaded transmission error over one pinion pitch, each about its mean."""
    figure, axes = _figure()
    angle = result.pinion_angle / _pitch(result)
    unloaded = np.array([p.position.transmission_error for p in result.load.positions])
    for name, values, color in (
        ("unloaded", unloaded, GREY),
        (f"at {result.torque:g} N m", result.transmission_error_positions, BLUE),
    ):
        arcsec = to_display("transmission_error", values)
        label = f"{name}: {np.ptp(arcsec):.1f} arcsec peak to peak, mean {arcsec.mean():.1f}"
        axes.plot(angle, arcsec - arcsec.mean(), color=color, marker=".", label=label)
    axes.set(xlabel="pinion roll [pinion pitches]", ylabel="transmission error of the gear, less mean [arcsec]")
    axes.margins(y=0.2)
    axes.legend(frameon=False, loc="upper right")
    return figure


def plot_friction_and_loss(result: EfficiencyResult) -> Figure:
    """Load-weighted friction coefficient and power loss along the mesh cycle."""
    figure, axes = _figure()
    angle = result.pinion_angle / _pitch(result)
    points, mu = result.points, result.friction.mu
    weight = points.force * points.speed_sliding
    each = [points.position == k for k in range(result.positions)]
    mean = np.array([np.average(mu[at], weights=weight[at]) for at in each])
    low, high = (np.array([f(mu[at]) for at in each]) for f in (np.min, np.max))
    axes.fill_between(angle, low, high, color=BLUE, alpha=0.15, lw=0.0, label="range over the lines")
    axes.plot(angle, mean, color=BLUE, marker=".", label="mean, weighted with sliding power")
    axes.set(xlabel="pinion roll [pinion pitches]", ylabel=axis_label("mu"), ylim=(0.0, None))
    loss = axes.twinx()
    loss.plot(angle, result.power_loss_positions, color=ORANGE, marker=".", label="power loss")
    finite = result.power_loss_positions[np.isfinite(result.power_loss_positions)]
    loss.set(ylabel="power loss [W]", ylim=(0.0, 1.3 * float(finite.max()) if finite.size else 1.0))
    handles = [*axes.get_legend_handles_labels()[0], *loss.get_lines()]
    axes.legend(handles, [str(h.get_label()) for h in handles], frameon=False, loc="lower left")
    found = result.status == "converged"
    outcome = f"efficiency {100.0 * result.efficiency:.3f} %" if found else f"failed ({result.reason})"
    axes.set_title(f"{model_label(result.friction_model)}: {outcome}")
    return figure


def plot_comparison(comparison: Comparison) -> Figure:
    """Power loss in percent of the input, one bar per friction model; closed forms in grey.

    The axis is that of the many: a bar or interval far beyond them ends in an arrow, with its number.
    """
    rows = comparison.rows
    figure, axes = _figure(7.5, 0.9 + 0.42 * len(rows))
    loss = np.array([100.0 * (1.0 - row.efficiency) for row in rows])
    low, high = (np.array([100.0 * (1.0 - getattr(row, f"efficiency_{end}")) for row in rows]) for end in _ENDS)
    limit = axis_limit(np.fmax(loss, high))
    place = np.arange(len(rows))[::-1]
    colors = [GREY if row.kind == "closed form" else BLUE for row in rows]
    axes.barh(place, np.minimum(np.nan_to_num(loss), limit), color=colors)
    for at, row, value, left, right in zip(place, rows, loss, low, high, strict=True):
        text = f"{100.0 * row.efficiency:.3f} %" if math.isfinite(row.efficiency) else row.reason
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
    # over the whole figure: long names of friction models leave the axes narrow
    state = ", ".join(quantity(n).text(getattr(comparison, n)) for n in OPERATION)
    figure.suptitle(typeset_units(f"{comparison.design}: {state}"))
    return figure


_ENDS = ("upper", "lower")
_FAR = 6.0  # times the median


def axis_limit(ends: FloatArray) -> float:
    """End of an axis for bars of lengths `ends`: what is far beyond the median does not stretch it."""
    known = ends[np.isfinite(ends) & (ends > 0.0)]
    if not known.size:
        return 1.0
    near = known[known <= _FAR * np.median(known)]
    return float(near.max())


def plot_map(map_: Grid) -> Figure:
    """Efficiency over speed, one line per torque, one panel per oil temperature."""
    from matplotlib import colormaps

    values = 100.0 * map_.values()
    panels = len(map_.axes["temperature"])
    figure = new_figure(1.5 + 3.6 * panels, 3.8)
    all_axes = np.atleast_1d(figure.subplots(1, panels, sharey=True))
    speed = to_display("speed", np.array(map_.axes["speed"]))
    shades = colormaps["viridis"](np.linspace(0.1, 0.85, len(map_.axes["torque"])))
    for k, (axes, temperature) in enumerate(zip(all_axes, map_.axes["temperature"], strict=True)):
        for j, torque in enumerate(map_.axes["torque"]):
            axes.plot(speed, values[j, :, k], color=shades[j], marker="o", ms=3, label=quantity("torque").text(torque))
        axes.set(xlabel=axis_label("speed"), title=typeset_units(quantity("temperature").text(temperature)))
        axes.grid(alpha=0.3)
    all_axes[0].set_ylabel("mesh efficiency [%]")
    all_axes[-1].legend(frameon=False, title="pinion torque")
    return figure


def _pitch(result: EfficiencyResult) -> float:
    """Pinion pitch [rad] from the equally spaced positions."""
    step = float(result.pinion_angle[1] - result.pinion_angle[0])
    return step * result.positions
