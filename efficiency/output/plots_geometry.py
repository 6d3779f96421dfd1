"""Figures of the geometry of a pair: ease-off, contact lines on the gear flank, unloaded transmission error."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from efficiency.contact.contact_lines import MeshPosition
from efficiency.contact.pair import GearPair

_MM, _UM, _ARCSEC = 1e3, 1e6, 180.0 * 3600.0 / np.pi


def _outline(axes: Axes, pair: GearPair) -> None:
    """Gear blank and the edge of the pinion's reach, in blank coordinates of the gear."""
    blank = pair.surface.gear.blank
    u = np.linspace(-0.5, 0.5, 101) * blank.face_width
    root, tip = blank.root(u) * _MM, blank.tip(u) * _MM
    axes.plot(
        np.concatenate([u, u[::-1], u[:1]]) * _MM, np.concatenate([root, tip[::-1], root[:1]]), color="0.25", lw=1.2
    )
    v = np.linspace(*pair.surface.patch.v_range, 61)
    grid_u, grid_v = np.meshgrid(u, v)
    margin = pair.surface.margin(grid_u.ravel(), grid_v.ravel()).reshape(grid_u.shape)
    height = pair.surface.height(grid_u, grid_v)
    axes.contour(grid_u * _MM, height * _MM, margin, levels=[0.0], colors="0.25", linestyles="--", linewidths=1.0)
    axes.set_xlabel("distance from mean point along the face [mm]  (toe - heel)")
    axes.set_ylabel("height over pitch cone [mm]  (root - tip)")


def ease_off_figure(pair: GearPair) -> Figure:
    """Ease-off over the gear flank [um]; dashed: the part both blanks reach; line: the unloaded contact path."""
    surface = pair.surface
    figure = Figure(figsize=(8.0, 4.2), layout="constrained")
    axes = figure.subplots()
    u = np.linspace(-0.5, 0.5, 121) * surface.gear.blank.face_width
    grid_u, grid_v = np.meshgrid(u, np.linspace(max(0.0, surface.patch.v_range[0]), 1.0, 81))
    relief = surface.patch(grid_u.ravel(), grid_v.ravel(), ("ease_off",))[0].reshape(grid_u.shape)
    height = surface.height(grid_u, grid_v)
    levels = MaxNLocator(20).tick_values(0.0, max(float(np.percentile(relief, 99.0)) * _UM, 0.01))
    colours = axes.contourf(grid_u * _MM, height * _MM, relief * _UM, levels=levels, cmap="viridis", extend="both")
    figure.colorbar(colours, ax=axes, label="ease-off (material missing on the pinion) [µm]")
    axes.plot(pair.path.u * _MM, pair.path.height * _MM, color="w", lw=2.0, label="unloaded contact path, one pitch")
    _outline(axes, pair)
    axes.legend(loc="lower left", facecolor="0.4", labelcolor="w")
    axes.set_title(f"{pair.name}, {pair.side} side: ease-off on the gear flank")
    return figure


def contact_lines_figure(pair: GearPair, cycle: tuple[MeshPosition, ...]) -> Figure:
    """Potential contact lines of all positions on the gear flank, coloured by equivalent radius."""
    blank = pair.surface.gear.blank
    figure = Figure(figsize=(8.0, 4.2), layout="constrained")
    axes = figure.subplots()
    lines, radii = [], []
    for position in cycle:
        for tooth in np.unique(position.pair):
            own = position.pair == tooth
            u = position.face_gear[own] - 0.5 * blank.face_width
            line = np.stack([u, position.height_gear[own] + blank.root(u)], axis=1) * _MM
            # one piece per point, so that the colour can change along the line
            middle = 0.5 * (line[1:] + line[:-1])
            corners = np.concatenate([line[:1], middle, line[-1:]])
            lines += list(np.stack([corners[:-1], corners[1:]], axis=1))
            radii.append(position.radius_equivalent[own])
            if position is cycle[0]:
                axes.plot(*line.T, color="k", lw=2.5, zorder=3)
    shown = axes.add_collection(LineCollection(lines, array=np.concatenate(radii) * _MM, cmap="plasma", linewidths=1.3))
    figure.colorbar(shown, ax=axes, label="equivalent radius normal to the line [mm]")
    _outline(axes, pair)
    axes.set_title(f"{pair.name}, {pair.side} side: contact lines (black: one position, all pairs)")
    return figure


def transmission_figure(pair: GearPair, cycle: tuple[MeshPosition, ...]) -> Figure:
    """Unloaded transmission error of one tooth pair, and of all pairs over two pitches."""
    figure = Figure(figsize=(8.0, 3.6), layout="constrained")
    axes = figure.subplots()
    pitch = pair.surface.pitch
    axes.plot(
        pair.path.pinion_angle / pitch, pair.path.transmission_error * _ARCSEC, color="C0", label="one tooth pair"
    )
    angle = np.array([p.pinion_angle for p in cycle]) / pitch
    error = np.array([p.transmission_error for p in cycle]) * _ARCSEC
    axes.plot(
        np.concatenate([angle - 1.0, angle]), np.concatenate([error, error]), "o", ms=3.5, color="C1", label="all pairs"
    )
    axes.set_xlabel("pinion angle from the design point [pitches]")
    axes.set_ylabel("transmission error [arcsec]")
    axes.grid(alpha=0.3)
    axes.legend()
    axes.set_title(f"{pair.name}, {pair.side} side: unloaded transmission error")
    return figure
