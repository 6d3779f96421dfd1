"""Figures of a loaded flank: contact pattern under load, pressure, friction, film, sliding and loss over the tooth.

A flank is drawn in blank coordinates with the toe on the left and the root at the bottom: distance from the mean point
along the pitch cone, and height above the pitch cone.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from efficiency.contact.gear_flanks import Member
from efficiency.cutting.blank import Blank
from efficiency.output.flank_map import FlankMap
from ehl.common.arrays import FloatArray
from ehl.common.figures import GREY, ORANGE, figure_of, new_figure
from ehl.common.quantities import axis_label, quantity, to_display

_MM = 1e3
_EDGE = "0.25"
COLOURS = "viridis"  # of all fields over a flank
# share of the maximum load per length below which film and friction are replaced by those of neighbouring points,
# because they diverge for vanishing load
_CARRIES = 0.03

PRESSURE, LOSS = "pressure_hertz", "loss_density"
# fields with long tails, and fields whose scale does not begin at zero
_TAILS, _OFFSET = ("film_ratio", "slide_to_roll_total"), ("friction_coefficient", "temperature_flash")


def field_values(flank: FlankMap, name: str) -> FloatArray:
    """A field in the displayed unit; zero or nan without load."""
    return np.asarray(to_display(name, flank.local(name)))


def field_figure(flank: FlankMap, name: str, top: float | None = None) -> Figure:
    """A field over the loaded part of the gear flank; `top` [displayed unit] is the end of a common scale."""
    figure, axes = _flank_figure(flank, "gear", quantity(name).label)
    load = flank.of_load("load_per_length")
    shown = _filled(np.where(load > _CARRIES * load.max(), field_values(flank, name), np.nan))
    finite = shown[np.isfinite(shown)]
    if finite.size:
        levels = _levels(finite if top is None else np.append(finite, top), name)
        x, y = _place(flank, "gear")
        clipping = _contact_region(axes, flank, "gear")
        beyond = "max" if float(finite.max()) > levels[-1] else "neither"
        shades = axes.contourf(x, y, np.clip(shown, levels[0], None), levels=levels, cmap=COLOURS, extend=beyond)
        lines = axes.contour(x, y, shown, levels=levels[1:-1:2], colors="w", linewidths=0.5)
        for artist in (shades, lines):
            artist.set_clip_path(clipping, axes.transData)
        _colour_bar(figure, shades, axes, axis_label(name))
    _outline(axes, flank, "gear")
    return figure


def contact_figure(flank: FlankMap, member: Member = "gear", top: float | None = None) -> Figure:
    """Contact pattern under load: maximum pressure at each point, and the loaded lines at one position.

    `top` [GPa] is the end of a scale that several figures share.
    """
    figure, axes = _flank_figure(flank, member, f"contact pattern at {flank.result.conditions.torque:.4g} N m")
    x, y = _place(flank, member)
    pressure = field_values(flank, PRESSURE)
    axes.plot([], [], color=_EDGE, lw=0.6, label="potential lines")
    axes.add_collection(LineCollection(list(np.stack([x, y], axis=2)[::2]), colors=_EDGE, linewidths=0.3, alpha=0.6))
    if pressure.max() > 0.0:
        levels = MaxNLocator(8).tick_values(0.0, top or float(pressure.max()))
        clipping = _contact_region(axes, flank, member)
        shades = axes.contourf(x, y, _filled(np.where(flank.loaded, pressure, np.nan)), levels=levels, cmap=COLOURS)
        shades.set_clip_path(clipping, axes.transData)
        _colour_bar(figure, shades, axes, axis_label(PRESSURE))
    _one_position(axes, flank, member)
    u, h = flank.loaded_edges(member)
    if u.size:
        axes.plot(u * _MM, h * _MM, "x", color="k", ms=4, zorder=4, label="edge contact")
    _outline(axes, flank, member, below=4.0)
    axes.legend(loc="lower left", fontsize=7, frameon=False, ncols=2)
    return figure


def sliding_figure(flank: FlankMap) -> Figure:
    """Sliding velocity of the pinion relative to the gear as arrows on the gear flank, coloured by magnitude."""
    figure, axes = _flank_figure(flank, "gear", "sliding velocity, pinion relative to gear,")
    x, y = _place(flank, "gear")
    along, up = flank.sliding
    total = np.where(flank.loaded, flank.local("speed_sliding"), np.nan)
    chosen = np.ix_(_every(x.shape[0], 14), _every(x.shape[1], 12))
    keep = flank.loaded[chosen]
    if keep.any():
        parts = (values[chosen][keep] for values in (x, y, along, up, total))
        arrows = axes.quiver(*parts, cmap=COLOURS, angles="xy", width=0.0035)
        _colour_bar(figure, arrows, axes, "sliding speed [m/s]")
        largest = float(np.nanmax(np.hypot(along, up)[chosen][keep]))
        if largest > 0.0:
            axes.quiverkey(arrows, 0.12, 0.06, largest, f"{largest:.3g} m/s in the projection", labelpos="E")
    _outline(axes, flank, "gear", below=4.0)
    return figure


def _every(count: int, wanted: int) -> NDArray[np.int64]:
    """About `wanted` of `count` indices, evenly spread and without the ends."""
    return np.unique(np.linspace(0, count - 1, min(wanted, count) + 2).round().astype(np.int64)[1:-1])


def _levels(finite: FloatArray, name: str) -> FloatArray:
    """Levels of the contours; fields with long tails end at the 99th percentile."""
    top = float(np.quantile(finite, 0.99)) if name in _TAILS else float(finite.max())
    low = float(finite.min()) if name in _OFFSET else 0.0
    # a constant field, such as a constant friction coefficient
    if top - low < 1e-9 * max(abs(top), 1e-30):
        low, top = (0.0, 1.2 * top) if top > 0.0 else (0.0, 1.0)
    return np.asarray(MaxNLocator(10).tick_values(low, top))


def _filled(values: FloatArray) -> FloatArray:
    """Nan replaced by the nearest value along the line, so that contours extend to the limit of the contact."""
    empty = ~np.isfinite(values)
    if empty.all():
        return values
    # a neighbouring line is farther than any point of the same line
    step = (float(values.shape[1]), 1.0)
    nearest = distance_transform_edt(empty, sampling=step, return_distances=False, return_indices=True)
    return np.asarray(values[tuple(nearest)])


def _contact_region(axes: Axes, flank: FlankMap, member: Member) -> Any:
    """Path around the loaded part; its outline is drawn."""
    x, y = _place(flank, member)
    load = _continued(flank.of_load("load_per_length"))
    region = axes.contourf(x, y, load, levels=[0.0, 2.0 * float(load.max())], colors="none")
    axes.contour(x, y, load, levels=[0.0], colors=_EDGE, linewidths=0.9)
    return region.get_paths()[0]


def _continued(load: FloatArray) -> FloatArray:
    """Load extrapolated below zero along the line, so that its zero is the end of the contact."""
    result = load.copy()
    below = -1e-3 * float(load.max())
    for row in result:
        loaded = np.flatnonzero(row > 0.0)
        if not loaded.size:
            row[:] = -float(load.max())
            continue
        for end, step in ((loaded[0], 1), (loaded[-1], -1)):
            inner = min(max(end + step, 0), row.size - 1)
            slope = max(float(row[inner] - row[end]), 0.0)
            outside = np.arange(end - step, -1 if step > 0 else row.size, -step)
            row[outside] = np.minimum(row[end] - slope * np.abs(outside - end), below)
    return result


def _one_position(axes: Axes, flank: FlankMap, member: Member) -> None:
    """Loaded parts of the lines at the position of maximum pressure; the width is in proportion to the load."""
    loads = flank.result.load.positions
    load = loads[int(np.argmax([part.pressure_hertz.max() for part in loads]))]
    p = load.position
    blank = flank.flanks.blank(member)
    u = getattr(p, f"face_{member}") - 0.5 * blank.face_width
    h = getattr(p, f"height_{member}") + blank.root(u)
    pieces, widths = [], []
    for at in p.lines:
        pieces += line_pieces(np.column_stack([u[at], h[at]]) * _MM)
        widths += list(load.load_per_length[at])
    width = np.array(widths) / max(max(widths), 1e-300)
    kept = width > 0.0
    lines = [piece for piece, keep in zip(pieces, kept, strict=True) if keep]
    axes.add_collection(LineCollection(lines, colors=ORANGE, linewidths=0.6 + 4.0 * width[kept], zorder=3))
    axes.plot([], [], color=ORANGE, lw=3.0, label="loaded at the position of maximum pressure")


def _place(flank: FlankMap, member: Member) -> tuple[FloatArray, FloatArray]:
    u, h = flank.place(member)
    return u * _MM, h * _MM


def _flank_figure(flank: FlankMap, member: Member, what: str) -> tuple[Figure, Axes]:
    """Figure of a flank and its axes with a title."""
    title = f"{flank.result.design}, {flank.result.side}:\n{what} on the {member}"
    return flank_figure(flank.flanks.blank(member), title)


def flank_figure(blank: Blank, title: str, ax: Axes | None = None) -> tuple[Figure, Axes]:
    """Figure with the aspect ratio of the flanks of a blank, and its axes with a title."""
    u = np.array([-0.5, 0.5]) * blank.face_width
    extent = float(np.max(blank.tip(u)) - np.min(blank.root(u)))
    size = 6.6, min(1.9 + 4.8 * extent / blank.face_width, 7.0)
    axes = new_figure(*size, layout="compressed").add_subplot() if ax is None else ax
    axes.set_title(title, fontsize=10)
    return figure_of(axes), axes


def _colour_bar(figure: Figure, shades: ScalarMappable, axes: Axes, label: str) -> None:
    bar = figure.colorbar(shades, ax=axes, shrink=0.9)
    bar.set_label(label, fontsize=8, labelpad=9.0)


def line_pieces(line: FloatArray) -> list[FloatArray]:
    """A line (n, 2) divided into n pieces, one around each point, so that colour or width can vary along it."""
    corners = np.concatenate([line[:1], 0.5 * (line[1:] + line[:-1]), line[-1:]])
    return list(np.stack([corners[:-1], corners[1:]], axis=1))


def _outline(axes: Axes, flank: FlankMap, member: Member, below: float = 1.0) -> None:
    """Outline and pitch line of a member, and the axes around it."""
    left, right = outline(axes, flank.flanks.blank(member), member, below)
    axes.plot([left, right], [0.0, 0.0], color=GREY, lw=0.7, ls="-.", zorder=0)
    axes.set_ylabel("above pitch cone\n[mm] root → tip", fontsize=8)


def outline(axes: Axes, blank: Blank, member: Member, below: float) -> tuple[float, float]:
    """Outline of a blank and the axes around it with space for a legend below the root; returns toe and heel [mm]."""
    u = np.linspace(-0.5, 0.5, 101) * blank.face_width
    root, tip = blank.root(u) * _MM, blank.tip(u) * _MM
    along = np.concatenate([u, u[::-1], u[:1]]) * _MM
    axes.plot(along, np.concatenate([root, tip[::-1], root[:1]]), color=_EDGE, lw=1.2)
    room = 0.03 * blank.face_width * _MM
    axes.set_xlim(along.min() - room, along.max() + room)
    axes.set_ylim(root.min() - below * room, tip.max() + room)
    axes.set_aspect("equal")
    axes.set_xlabel(f"along the face of the {member} [mm]   toe → heel")
    return float(along.min()), float(along.max())
