"""Axial section of both blanks: cones, axes, crossing point."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ehl.view.plots import BLUE, GREY, ORANGE

if TYPE_CHECKING:
    from efficiency.blanks.cones import Blank
    from efficiency.design.design import Design

FloatArray = NDArray[np.float64]

_MM = 1e3


def blank_figure(design: Design) -> Figure:
    """Both members in the plane of their axes, gear axis upright; a hypoid pinion is turned into that plane.

    The mean points coincide for a bevel pair. With an offset each member is drawn in its own axial plane, as a
    designer's section does, and the mean points then lie apart.
    """
    figure = Figure(layout="constrained")
    axes = figure.add_subplot()
    shaft = design.assembly.shaft_angle
    gear, pinion = design.gear.blank.blank(), design.pinion.blank.blank()
    # along its axis and out of it, towards the mesh, in the drawing: the gear axis points down so that teeth face up
    directions = {
        "gear": (np.array([0.0, 1.0]), np.array([1.0, 0.0])),
        "pinion": (
            np.array([np.sin(shaft), np.cos(shaft)]),
            np.array([-np.cos(shaft), np.sin(shaft)]),
        ),
    }
    for name, blank, colour in (("gear", gear, ORANGE), ("pinion", pinion, BLUE)):
        _member(axes, blank, *directions[name], colour, f"{name}, {blank.teeth} teeth")
    axes.plot(0.0, 0.0, marker="+", ms=12, mew=1.6, color="k")
    axes.annotate("crossing point", (0.0, 0.0), xytext=(-8, -16), textcoords="offset points", fontsize=9, ha="right")
    for style, name in (("-", "pitch cone"), ("--", "face cone"), (":", "root cone"), ("-.", "axis")):
        axes.plot([], [], color="k", lw=0.9, ls=style, label=name)
    offset = design.assembly.hypoid_offset
    axes.set(
        xlabel="from the crossing point, square to the gear axis [mm]",
        ylabel="along the gear axis [mm]",
        title=f"{design.name}: axial section, shaft angle {np.degrees(shaft):.4g}°"
        + (f", offset {offset * _MM:.5g} mm" if offset else ""),
    )
    axes.set_aspect("equal")
    axes.grid(alpha=0.2)
    axes.legend(loc="best", fontsize=8)
    axes.margins(0.06)
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    figure.set_size_inches(8.4, min(1.1 + 7.4 * (top - bottom) / (right - left), 9.0))
    return figure


def _member(axes: Axes, blank: Blank, along: FloatArray, out: FloatArray, colour: str, label: str) -> None:
    """Tooth section on both sides of the axis, cones to their apexes, axis."""
    u = np.array([-0.5, 0.5]) * blank.face_width
    toe, heel = u
    corners = [(toe, blank.root(u)[0]), (toe, blank.tip(u)[0]), (heel, blank.tip(u)[1]), (heel, blank.root(u)[1])]
    body_height = blank.root(u) - (blank.mean_addendum + blank.mean_dedendum)
    corners += [(heel, body_height[1]), (toe, body_height[0])]
    radius, z = blank.axial(*(np.array(values) for values in zip(*corners, strict=True)))
    radius = np.maximum(radius, 0.0)
    for sign in (1.0, -1.0):
        points = (z[:, None] * along + sign * radius[:, None] * out) * _MM
        axes.fill(
            *points[:4].T, facecolor=colour, edgecolor=colour, alpha=0.55, lw=1.2, label=label if sign > 0 else None
        )
        axes.fill(*points[[0, 3, 4, 5]].T, facecolor=colour, edgecolor=colour, alpha=0.18, lw=0.8)
        for height, style in ((blank.root(u), ":"), (blank.tip(u), "--"), (0.0 * u, "-")):
            line = _to_apex(blank, u, height)
            drawn = (line[1][:, None] * along + sign * line[0][:, None] * out) * _MM
            axes.plot(*drawn.T, color=colour, lw=0.8, ls=style, alpha=0.9)
    reach = np.array([min(0.0, float(z.min())) - 0.004, float(z.max()) + 0.012])
    axes.plot(*(reach[:, None] * along * _MM).T, color=GREY, lw=0.9, ls="-.")


def _to_apex(blank: Blank, u: FloatArray, height: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Radius and axial position of a cone from its apex to the heel."""
    radius, z = blank.axial(u, height)
    slope = (z[1] - z[0]) / (radius[1] - radius[0])
    return np.array([0.0, radius[1]]), np.array([z[1] - slope * radius[1], z[1]])
