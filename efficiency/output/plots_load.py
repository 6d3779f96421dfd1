"""Figures under load: load sharing, transmission error, friction and loss of a mesh; efficiency and loss of a map."""

from __future__ import annotations

from itertools import product

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from efficiency.conditions.duty import DutyCycle
from efficiency.conditions.grid import Grid
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.power_loss import friction_along_mesh
from ehl.common.data import reason_text
from ehl.common.figures import BLUE, GREY, ORANGE, axes_or_new, figure_of, new_figure, panels
from ehl.common.quantities import axis_label, quantities, quantity, to_display, typeset_units
from ehl.common.sections import Picture, picture
from regression.friction.published_registry import model_label

# least number of torques and of speeds for contours
_CONTOURS = 3


def is_map(grid: Grid) -> bool:
    """Whether the axes are torque, speed and temperature, in this order."""
    return tuple(grid.axes) == ("torque", "speed", "temperature")


def plot_map(map_: Grid, ax: Axes | None = None) -> Axes:
    """Efficiency over speed, one line per torque, one panel per oil temperature; in `ax` only the first panel."""
    if not is_map(map_):
        return plot_lines(map_, ax)
    values = 100.0 * map_.values()
    all_axes = _panels(map_, 1.5, 3.6) if ax is None else [ax]
    speed = to_display("speed", np.array(map_.axes["speed"]))
    shades = colormaps["viridis"](np.linspace(0.1, 0.85, len(map_.axes["torque"])))
    for k, (axes, temperature) in enumerate(zip(all_axes, map_.axes["temperature"], strict=False)):
        for j, torque in enumerate(map_.axes["torque"]):
            axes.plot(speed, values[j, :, k], color=shades[j], marker="o", ms=3, label=quantity("torque").text(torque))
        axes.set(xlabel=axis_label("speed"), title=typeset_units(quantity("temperature").text(temperature)))
        axes.grid(alpha=0.3)
    all_axes[0].set_ylabel("mesh efficiency [%]")
    all_axes[-1].legend(frameon=False, title="pinion torque")
    return all_axes[0]


def _panels(grid: Grid, margin: float, width: float) -> list[Axes]:
    """Axes for each oil temperature, next to each other."""
    count = len(grid.axes["temperature"])
    return panels(count, count, (margin, 0.0), (width, 3.8), sharey=True)


def plot_lines(grid: Grid, ax: Axes | None = None) -> Axes:
    """Efficiency over the longest numerical axis, one line per combination of the others."""
    numeric = [name for name, values in grid.axes.items() if all(isinstance(v, int | float) for v in values)]
    along = max(numeric, key=lambda name: len(grid.axes[name]), default=next(iter(grid.axes)))
    axes = axes_or_new(ax)
    place = list(grid.axes).index(along)
    lines = np.moveaxis(100.0 * grid.values(), place, -1).reshape(-1, len(grid.axes[along]))
    others = [name for name in grid.axes if name != along]
    known, places = quantities().get(along), grid.axes[along]
    if along not in numeric:
        places = tuple(map(str, places))
    elif known is not None:
        places = tuple(map(known.to_display, places))
    for line, values in zip(lines, product(*(grid.axes[name] for name in others)), strict=True):
        named = zip(others, values, strict=True)
        words = (quantity(n).text(v) if isinstance(v, float) and n in quantities() else str(v) for n, v in named)
        axes.plot(places, line, "o-", label=", ".join(words))
    axes.set(xlabel=along if known is None else known.axis_label, ylabel="mesh efficiency [%]")
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.grid(alpha=0.3)
    if others:
        axes.legend(frameon=False, fontsize=8)
    return axes


def plot_duty(duty: DutyCycle, ax: Axes | None = None) -> Axes:
    """Energy loss at each operating point of a duty cycle."""
    axes = axes_or_new(ax)
    torque, speed = quantity("torque"), quantity("speed")
    names = [f"{torque.text(r.torque)}, {speed.text(r.speed)}, {r.side}" for r in duty.rows]
    axes.barh(names, [to_display("energy_loss", row.energy_loss) for row in duty.rows])
    axes.set(xlabel=axis_label("energy_loss"))
    axes.invert_yaxis()
    return axes


def map_figures(grid: Grid) -> list[Picture]:
    """Lines over speed, and contours if there are enough torques and speeds."""
    pictures = [picture("efficiency_map", "Mesh efficiency over pinion speed.", plot_map, grid)]
    if grid.shape[0] >= _CONTOURS and grid.shape[1] >= _CONTOURS:
        for name in ("efficiency", "power_loss", "friction_coefficient_mean"):
            caption = f"Contours: {quantity(name).label}."
            pictures.append(picture(f"contours_{name}", caption, contour_figure, grid, name))
    return pictures


def contour_figure(grid: Grid, name: str) -> Figure:
    """Contours of one value over speed and torque, one panel per oil temperature."""
    values = to_display(name, grid.values(name))
    all_axes = _panels(grid, 2.2, 3.4)
    figure = figure_of(all_axes[0])
    speed = to_display("speed", np.array(grid.axes["speed"]))
    torque = to_display("torque", np.array(grid.axes["torque"]))
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    levels = MaxNLocator(10).tick_values(low, high if high > low else low + 1e-9 + 1e-3 * abs(low))
    order = np.ix_(np.argsort(torque), np.argsort(speed))
    for number, axes in enumerate(all_axes):
        field = np.ma.masked_invalid(values[:, :, number][order])
        shades = axes.contourf(np.sort(speed), np.sort(torque), field, levels=levels, cmap="viridis")
        lines = axes.contour(np.sort(speed), np.sort(torque), field, levels=levels, colors="w", linewidths=0.6)
        axes.clabel(lines, fontsize=7)
        axes.plot(*(part.ravel() for part in np.meshgrid(speed, torque)), ".", color="0.2", ms=2)
        temperature = grid.axes["temperature"][number]
        axes.set(xlabel=axis_label("speed"), title=typeset_units(quantity("temperature").text(temperature)))
    figure.colorbar(shades, ax=all_axes[-1], label=axis_label(name))
    all_axes[0].set_ylabel(axis_label("torque"))
    return figure


def plot_load_sharing(result: EfficiencyResult, ax: Axes | None = None) -> Axes:
    """Share of the torque on one tooth pair over its roll angle in pinion pitches."""
    axes = axes_or_new(ax)
    pitch, loads = result.cycle.pitch, result.load.positions
    shares = sorted((at.position.pinion_angle / pitch + pair, part) for at in loads for pair, part in at.share.items())
    axes.plot(*np.array(shares).T, color=BLUE, marker=".", ms=4)
    axes.set(
        xlabel="roll of one tooth pair from the design point [pinion pitches]",
        ylabel="share of the torque [-]",
        ylim=(0.0, 1.05),
        title=f"Load sharing at {result.conditions.torque:g} N m",
    )
    return axes


def plot_pair_load(result: EfficiencyResult, ax: Axes | None = None) -> Axes:
    """Normal force and maximum Hertz pressure of one tooth pair over its roll angle in pinion pitches."""
    axes = axes_or_new(ax)
    pitch = result.cycle.pitch
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
    other.plot(roll, pressure, color=ORANGE, marker=".", ms=4, label="maximum Hertz pressure")
    other.set(ylabel="maximum " + axis_label("pressure_hertz"), ylim=(0.0, 1.25 * float(pressure.max())))
    handles = [*axes.get_lines(), *other.get_lines()]
    axes.legend(handles, [str(line.get_label()) for line in handles], frameon=False, loc="upper left", ncols=2)
    axes.set_title(f"Load of one tooth pair at {result.conditions.torque:g} N m")
    return axes


def plot_root_stress(result: EfficiencyResult) -> Figure:
    """Maximum root stress of both members over the roll angle of the tooth pair, and along the face."""
    strength, pitch = result.strength, result.cycle.pitch
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
    along.set(xlabel="distance from the toe [mm]", ylabel="maximum over the mesh [MPa]", ylim=(0.0, None))
    figure.suptitle(f"Root stress at {result.conditions.torque:g} N m")
    return figure


def plot_transmission_error(result: EfficiencyResult, ax: Axes | None = None) -> Axes:
    """Loaded and unloaded transmission error over one pinion pitch, each about its mean."""
    axes = axes_or_new(ax)
    angle = result.cycle.pinion_angle / result.cycle.pitch
    unloaded = np.array([p.position.transmission_error for p in result.load.positions])
    for name, values, color in (
        ("unloaded", unloaded, GREY),
        (f"at {result.conditions.torque:g} N m", result.cycle.transmission_error, BLUE),
    ):
        arcsec = to_display("transmission_error", values)
        label = f"{name}: {np.ptp(arcsec):.1f} arcsec peak to peak, mean {arcsec.mean():.1f}"
        axes.plot(angle, arcsec - arcsec.mean(), color=color, marker=".", label=label)
    axes.set(xlabel="pinion roll [pinion pitches]", ylabel="transmission error of the gear about its mean [arcsec]")
    axes.margins(y=0.2)
    axes.legend(frameon=False, loc="upper right")
    return axes


def plot_forces(result: EfficiencyResult) -> Figure:
    """Mesh stiffness, and forces on both shafts, over one pinion pitch."""
    figure = new_figure(9.0, 3.2)
    axes = figure.subplots(1, 3)
    if (forces := result.forces) is None:
        return figure
    angle = forces.pinion_angle / result.cycle.pitch
    axes[0].plot(angle, 1e-3 * forces.stiffness, color=BLUE, marker=".", ms=4)
    axes[0].set(ylabel="mesh stiffness [kN m/rad]", ylim=(0.0, None))
    for own, name in zip(axes[1:], ("pinion", "gear"), strict=True):
        for way, color in (("axial", BLUE), ("radial", ORANGE), ("tangential", GREY)):
            values = to_display(f"force_{way}_{name}", getattr(getattr(forces, name), way))
            own.plot(angle, values, color=color, marker=".", ms=4, label=way)
        own.set(ylabel=f"force on the {name} shaft [kN]")
    for own in axes:
        own.set_xlabel("pinion roll [pinion pitches]")
    axes[1].legend(frameon=False, fontsize=8)
    return figure


def plot_friction_and_loss(result: EfficiencyResult, ax: Axes | None = None) -> Axes:
    """Friction coefficient weighted with the sliding power, and power loss, along the mesh cycle."""
    axes = axes_or_new(ax)
    angle = result.cycle.pinion_angle / result.cycle.pitch
    each = [result.friction.mu[result.points.position == k] for k in range(result.solution.positions)]
    low, high = ([f(mu) for mu in each] for f in (np.min, np.max))
    axes.fill_between(angle, low, high, color=BLUE, alpha=0.15, lw=0.0, label="range over the lines")
    mean = friction_along_mesh(result)
    axes.plot(angle, mean, color=BLUE, marker=".", label="mean, weighted with sliding power")
    axes.set(xlabel="pinion roll [pinion pitches]", ylabel=axis_label("mu"), ylim=(0.0, None))
    loss = axes.twinx()
    lost = result.cycle.power_loss
    loss.plot(angle, lost, color=ORANGE, marker=".", label="power loss")
    finite = lost[np.isfinite(lost)]
    loss.set(ylabel="power loss [W]", ylim=(0.0, 1.3 * float(finite.max()) if finite.size else 1.0))
    handles = [*axes.get_legend_handles_labels()[0], *loss.get_lines()]
    axes.legend(handles, [str(h.get_label()) for h in handles], frameon=False, loc="lower left")
    found = result.status == "converged"
    outcome = f"efficiency {100.0 * result.efficiency:.3f} %" if found else f"failed: {reason_text(result.reason)}"
    axes.set_title(f"{model_label(result.friction_model)}: {outcome}")
    return axes
