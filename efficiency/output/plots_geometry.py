"""Figures on the projection of the flanks: ease-off, contact lines, contact pattern, equivalent radius.

A flank is drawn in blank coordinates, toe on the left, root below: along the pitch cone from the mean point, and square
to it from the pitch cone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from ehl.view.plots import BLUE, ORANGE

if TYPE_CHECKING:
    from efficiency.contact.contact_lines import MeshPosition
    from efficiency.contact.flank_pair import FlankPair
    from efficiency.contact.pattern import ContactPattern
    from efficiency.contact.transmission import ContactPath

FloatArray = NDArray[np.float64]
Member = Literal["pinion", "gear"]

_MM, _UM = 1e3, 1e6
_EDGE = "0.25"


def projection(pair: FlankPair, member: Member, u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where points (u, v) of the map of a mesh lie on the projection of a member [mm], shape kept."""
    if member == "gear":
        return u * _MM, pair.surface.height(u, v) * _MM
    u1, h1 = pair.surface.patch(u.ravel(), v.ravel(), ("u1", "h1"))
    return u1.reshape(u.shape) * _MM, h1.reshape(u.shape) * _MM


def map_grid(pair: FlankPair, columns: int = 141, rows: int = 81) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points (u, v) over the whole map and how far they lie inside both blanks [m], each (rows, columns)."""
    patch = pair.surface.patch
    u, v = np.meshgrid(np.linspace(*patch.u_range, columns), np.linspace(*patch.v_range, rows))
    return u, v, pair.surface.margin(u.ravel(), v.ravel()).reshape(u.shape)


def flank_axes(axes: Axes, pair: FlankPair, member: Member) -> None:
    """Blank of a member, and dashed the part of it that the other one reaches."""
    blank = (pair.surface.gear if member == "gear" else pair.surface.pinion).blank
    u = np.linspace(-0.5, 0.5, 101) * blank.face_width
    root, tip = blank.root(u) * _MM, blank.tip(u) * _MM
    along = np.concatenate([u, u[::-1], u[:1]]) * _MM
    axes.plot(along, np.concatenate([root, tip[::-1], root[:1]]), color=_EDGE, lw=1.2)
    grid_u, grid_v, margin = map_grid(pair)
    axes.contour(
        *projection(pair, member, grid_u, grid_v), margin, levels=[0.0], colors=_EDGE, linestyles="--", linewidths=0.9
    )
    room = 0.03 * blank.face_width * _MM
    axes.set_xlim(along.min() - room, along.max() + room)
    # below the root there is room for the legend
    axes.set_ylim(root.min() - 4.0 * room, tip.max() + room)
    axes.set_aspect("equal")
    axes.set_xlabel(f"along the face of the {member} [mm]   toe → heel")
    axes.set_ylabel("over pitch cone [mm]\nroot → tip")


def flank_figure(pair: FlankPair, member: Member, what: str) -> tuple[Figure, Axes]:
    """Figure as high as the flank of a member needs, and its axes with a title."""
    flank = pair.surface.gear if member == "gear" else pair.surface.pinion
    u = np.array([-0.5, 0.5]) * flank.blank.face_width
    extent = float(np.max(flank.blank.tip(u)) - np.min(flank.blank.root(u)))
    figure = Figure(figsize=(6.6, min(1.75 + 4.4 * extent / flank.blank.face_width, 7.0)), layout="compressed")
    axes = figure.add_subplot()
    axes.set_title(f"{pair.name}, {pair.side}:\n{what} on the {member} ({flank.side} flank)", fontsize=10)
    return figure, axes


def draw_path(axes: Axes, pair: FlankPair, path: ContactPath, member: Member, colour: str) -> None:
    """Unloaded path of contact of one tooth pair, inside the edges."""
    u, height = (path.u, path.height) if member == "gear" else (path.u_pinion, path.height_pinion)
    free = path.free
    axes.plot(np.where(free, u, np.nan) * _MM, height * _MM, color=colour, lw=2.2, label="unloaded path of contact")


def ease_off_figure(pair: FlankPair, path: ContactPath | None = None, member: Member = "gear") -> Figure:
    """Ease-off over the flank of a member, contours in um; dashed: the part both blanks reach.

    Parameters
    ----------
    pair : FlankPair
        The mesh.
    path : ContactPath, optional
        Path of contact to draw; that of the pair over one pitch if not given.
    member : {"gear", "pinion"}
        On whose projection.
    """
    figure, axes = flank_figure(pair, member, "ease-off")
    u, v, margin = map_grid(pair)
    relief = pair.surface.patch(u.ravel(), v.ravel(), ("ease_off",))[0].reshape(u.shape) * _UM
    shown = np.ma.masked_where(margin < 0.0, relief)
    top = max(float(np.max(relief[margin >= 0.0], initial=0.0)), 0.01)
    levels = MaxNLocator(10).tick_values(0.0, top)
    x, y = projection(pair, member, u, v)
    colours = axes.contourf(x, y, shown, levels=levels, cmap="viridis")
    lines = axes.contour(x, y, shown, levels=levels[1:], colors="w", linewidths=0.7)
    axes.clabel(lines, fmt="%g", fontsize=8)
    figure.colorbar(colours, ax=axes, label="ease-off, material\nmissing on pinion [µm]", shrink=0.85)
    draw_path(axes, pair, pair.path if path is None else path, member, ORANGE)
    flank_axes(axes, pair, member)
    axes.legend(loc="lower left", fontsize=8, frameon=False, ncols=2)
    return figure


def contact_lines_figure(
    pair: FlankPair, cycle: tuple[MeshPosition, ...], path: ContactPath | None = None, member: Member = "gear"
) -> Figure:
    """Potential contact lines of all positions of a pitch, coloured by equivalent radius, and the path of contact."""
    figure, axes = flank_figure(pair, member, "contact lines")
    blank = (pair.surface.gear if member == "gear" else pair.surface.pinion).blank
    lines: list[FloatArray] = []
    radii = []
    for position in cycle:
        face = position.face_gear if member == "gear" else position.face_pinion
        height = position.height_gear if member == "gear" else position.height_pinion
        for own in _flank_lines(position):
            u = face[own] - 0.5 * blank.face_width
            line = np.stack([u, height[own] + blank.root(u)], axis=1) * _MM
            # one piece per point, so that the colour can change along the line
            corners = np.concatenate([line[:1], 0.5 * (line[1:] + line[:-1]), line[-1:]])
            lines += list(np.stack([corners[:-1], corners[1:]], axis=1))
            radii.append(position.radius_equivalent[own])
            if position is cycle[0]:
                axes.plot(
                    *line.T, color="k", lw=2.5, zorder=3, label="one position, all pairs" if own[0] == 0 else None
                )
    shown = axes.add_collection(LineCollection(lines, array=np.concatenate(radii) * _MM, cmap="plasma", linewidths=1.3))
    figure.colorbar(shown, ax=axes, label="equivalent radius\nnormal to the line [mm]", shrink=0.85)
    draw_path(axes, pair, pair.path if path is None else path, member, BLUE)
    flank_axes(axes, pair, member)
    axes.legend(loc="lower left", fontsize=8, frameon=False, ncols=2)
    return figure


def _flank_lines(position: MeshPosition) -> list[NDArray[np.int64]]:
    """Points of each contact line of a position; those of edges left out."""
    edge = position.edge
    return [line for line in position.lines if edge is None or not edge.touching[line[0]]]


def radius_figure(pair: FlankPair, cycle: tuple[MeshPosition, ...], lines: int = 6) -> Figure:
    """Equivalent radius normal to the line along some of the contact lines of the cycle."""
    from matplotlib import colormaps

    figure = Figure(figsize=(6.6, 3.6), layout="constrained")
    axes = figure.add_subplot()
    pitch = pair.surface.pitch
    traces = [
        (
            position.pinion_angle / pitch + float(position.pair[own[0]]),
            position.face_gear[own],
            position.radius_equivalent[own],
        )
        for position in cycle
        for own in _flank_lines(position)
    ]
    traces.sort(key=lambda trace: trace[0])
    chosen = np.unique(np.linspace(0, len(traces) - 1, lines + 2).astype(int)[1:-1])
    for colour, number in zip(colormaps["viridis"](np.linspace(0.0, 0.9, chosen.size)), chosen, strict=True):
        roll, face, radius = traces[number]
        axes.plot(face * _MM, radius * _MM, color=colour, marker=".", ms=3, label=f"{roll:+.2f}")
    axes.set(
        xlabel="along the face of the gear from the toe [mm]",
        ylabel="equivalent radius normal\nto the contact line [mm]",
        ylim=(0.0, None),
        xlim=(0.0, pair.surface.gear.blank.face_width * _MM),
    )
    axes.set_title(f"{pair.name}, {pair.side}:\nequivalent radius along contact lines", fontsize=10)
    axes.grid(alpha=0.3)
    axes.legend(
        title="roll of the pair\n[pinion pitches]",
        fontsize=8,
        title_fontsize=8,
        loc="center left",
        bbox_to_anchor=(1.0, 0.5),
    )
    return figure


def contact_pattern_figure(pair: FlankPair, pattern: ContactPattern, path: ContactPath, member: Member) -> Figure:
    """Contact pattern on a member, shaded in quarters of the marking thickness, with the path of contact."""
    thickness = pattern.thickness * _UM
    figure, axes = flank_figure(pair, member, f"contact pattern, marking {thickness:.4g} µm,")
    u, height = (pattern.gear_u, pattern.gear_height) if member == "gear" else (pattern.pinion_u, pattern.pinion_height)
    gap = np.ma.masked_where(~pattern.inside, np.where(pattern.inside, pattern.separation, 0.0) * _UM)
    levels = np.linspace(0.0, thickness, 5)
    shades = axes.contourf(u * _MM, height * _MM, gap, levels=levels, cmap="Blues_r", vmin=-0.3 * thickness)
    if pattern.marked.any():
        axes.contour(u * _MM, height * _MM, gap, levels=levels[-1:], colors=BLUE, linewidths=1.4)
    figure.colorbar(shades, ax=axes, label="least distance\nof the flanks [µm]", shrink=0.85, format="%.3g")
    draw_path(axes, pair, path, member, ORANGE)
    flank_axes(axes, pair, member)
    axes.legend(loc="lower left", fontsize=8, frameon=False)
    return figure
