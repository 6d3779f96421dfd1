"""Figures of a pair without load: flanks in projection, axial section, and a shaded view of teeth in mesh.

Coordinates as in `efficiency.output.plots_flank`.
"""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from efficiency.contact.contact_lines import MeshPosition
from efficiency.contact.flank_pair import ContactPattern, FlankPair
from efficiency.contact.gear_flanks import MEMBERS, Member
from efficiency.contact.tooth_grid import tooth_grid
from efficiency.cutting.blank import Blank
from efficiency.cutting.flank import Flank
from efficiency.design.design import Design
from efficiency.geometry.pair_geometry import SideGeometry
from efficiency.output.plots_flank import COLOURS, flank_figure, line_pieces, outline
from efficiency.output.solid import teeth_surface
from ehl.common.arrays import FloatArray
from ehl.common.figures import BLUE, GREY, ORANGE, axes_or_new, figure_of, new_figure
from ehl.common.units import ARCSEC

_ROWS, _COLUMNS, _TEETH = 7, 13, 3  # points of a flank, teeth of each member in the view
_TRACES = 6  # contact lines with their equivalent radius
_LIGHT = np.array([-0.45, 0.55, 0.55])  # right, up, towards the viewer
_MM, _UM = 1e3, 1e6
_EDGE = "0.25"


def tooth_pair_figure(pair: FlankPair) -> Figure:
    """Teeth of both members at the position of maximum transmission error, seen from heel and from toe.

    Positions include the misalignments.
    """
    figure = new_figure(9.6, 4.0)
    surface, assembly = pair.surface, pair.surface.assembly
    angle = surface.direction * surface.error_maximum_roll + surface.roll_zero
    pinion, gear = (_teeth(pair, member).reshape(-1, 3).T for member in MEMBERS)
    placed = [
        assembly.gear_in_mesh(gear, np.full(gear.shape[1], assembly.ratio * angle)),
        assembly.pinion_in_mesh(pinion, np.full(pinion.shape[1], angle + surface.phase)),
    ]
    cells = np.concatenate(placed, axis=1).T.reshape(-1, 4, 3)
    tints = np.repeat([to_rgb(ORANGE), to_rgb(BLUE)], [part.shape[1] // 4 for part in placed], axis=0)
    u, v = (np.array([value]) for value in surface.error_maximum)
    highest = surface.patch(u, v, ("x", "y", "z"))
    contact = assembly.gear_in_mesh(highest, np.array([assembly.ratio * angle]))[:, 0]
    # generatrix of the pitch cone of the gear there, to the heel, and the normal of the cone, out of the gear teeth
    radial, axial = np.array([*contact[:2], 0.0]) / np.hypot(contact[0], contact[1]), np.array([0.0, 0.0, 1.0])
    c, s = np.cos(surface.gear.blank.pitch_angle), np.sin(surface.gear.blank.pitch_angle)
    along, out = s * radial + c * axial, c * radial - s * axial
    aside = np.cross(out, along)
    for axes, side, name in zip(figure.subplots(1, 2), (1.0, -1.0), ("heel", "toe"), strict=True):
        view = _view(side * along + 0.35 * side * aside + 0.45 * out, out)
        polygons, colours = _painted((cells - contact) @ view.T, tints)
        axes.add_collection(
            PolyCollection(list(polygons * _MM), facecolors=colours, edgecolors=colours, linewidths=0.3)
        )
        axes.set_aspect("equal")
        axes.autoscale()
        axes.margins(0.02)
        axes.set(xlabel="across the view [mm]", ylabel="up the view [mm]", title=f"seen from the {name}")
        axes.grid(alpha=0.2)
        axes.set_axisbelow(True)
    shape = max(
        (top - bottom) / (right - left)
        for (left, right), (bottom, top) in ((axes.get_xlim(), axes.get_ylim()) for axes in figure.axes)
    )
    figure.set_size_inches(9.6, min(1.3 + 4.2 * shape, 7.0))
    figure.axes[0].plot([], [], color=BLUE, lw=6, label="pinion")
    figure.axes[0].plot([], [], color=ORANGE, lw=6, label="gear")
    figure.axes[0].legend(loc="best", fontsize=8)
    figure.suptitle(f"{pair.name}, {pair.side}: teeth in mesh where the transmission error is highest", fontsize=11)
    return figure


def _teeth(pair: FlankPair, member: Member) -> FloatArray:
    """Cells (n, 4, 3) of some teeth in the frame of the real flank of the mesh, with outward normals."""
    grid = tooth_grid(pair.flanks, member, _ROWS, _COLUMNS)
    flank = _flank(pair, member)
    row, column = _ROWS // 2, _COLUMNS // 2
    points, _ = flank.solve(grid.u[row, column : column + 1], grid.height[row, column : column + 1])
    own = grid.lower if grid.sides[0] == flank.side else grid.upper
    return teeth_surface(grid, _TEETH, float(points.azimuth[0] - own[row, column]))


def _view(eye: FloatArray, up: FloatArray) -> FloatArray:
    """Axes of the picture in the mesh frame: right, up, and towards the viewer."""
    eye = eye / np.linalg.norm(eye)
    up = up - eye * (up @ eye)
    up = up / np.linalg.norm(up)
    return np.stack([np.cross(up, eye), up, eye])


def _painted(cells: FloatArray, tints: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Polygons (n, 4, 2) of the cells that face the viewer, the farthest first, and their colours."""
    normal = np.cross(cells[:, 2] - cells[:, 0], cells[:, 3] - cells[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True).clip(1e-300)
    facing = normal[:, 2] > 0.0
    cells, tints, normal = cells[facing], tints[facing], normal[facing]
    shade = 0.6 + 0.4 * np.clip(normal @ (_LIGHT / np.linalg.norm(_LIGHT)), 0.0, 1.0)
    order = np.argsort(cells[..., 2].mean(axis=1))
    return cells[order, :, :2], ((0.25 + 0.75 * tints) * shade[:, None])[order]


def projection(pair: FlankPair, member: Member, u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points (u, v) of the map of a mesh on the projection of a member [mm], same shape."""
    if member == "gear":
        return u * _MM, pair.surface.height(u, v) * _MM
    u1, h1 = pair.surface.patch(u.ravel(), v.ravel(), ("u1", "h1"))
    return u1.reshape(u.shape) * _MM, h1.reshape(u.shape) * _MM


def map_grid(pair: FlankPair) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points (u, v) over the whole map and their distance inside both blanks [m], each (rows, columns)."""
    patch = pair.surface.patch
    u, v = np.meshgrid(np.linspace(*patch.u_range, 141), np.linspace(*patch.v_range, 81))
    return u, v, pair.surface.margin(u.ravel(), v.ravel()).reshape(u.shape)


def flank_axes(axes: Axes, pair: FlankPair, member: Member) -> None:
    """Outline of a member; a dashed line limits the part that the mating flank reaches."""
    grid_u, grid_v, margin = map_grid(pair)
    outline(axes, _flank(pair, member).blank, member, 4.0)
    axes.contour(
        *projection(pair, member, grid_u, grid_v), margin, levels=[0.0], colors=_EDGE, linestyles="--", linewidths=0.9
    )
    axes.set_ylabel("above pitch cone [mm]\nroot → tip")


def member_figure(pair: FlankPair, member: Member, what: str, ax: Axes | None = None) -> tuple[Figure, Axes]:
    """Figure of the flank of a member, and its axes with a title."""
    flank = _flank(pair, member)
    title = f"{pair.name}, {pair.side}:\n{what} on the {member} ({flank.side} flank)"
    return flank_figure(flank.blank, title, ax)


def _flank(pair: FlankPair, member: Member) -> Flank:
    return pair.surface.gear if member == "gear" else pair.surface.pinion


def draw_path(axes: Axes, pair: FlankPair, member: Member) -> None:
    """Unloaded path of contact of one tooth pair without edge contact."""
    path = pair.path
    u, height = (path.u, path.height) if member == "gear" else (path.u_pinion, path.height_pinion)
    label = "unloaded path of contact"
    axes.plot(np.where(path.free, u, np.nan) * _MM, height * _MM, color=ORANGE, lw=2.2, label=label)


def ease_off_figure(pair: FlankPair, member: Member) -> Figure:
    """Ease-off over the flank of a member, contours in um; a dashed line limits the common part of both blanks."""
    figure, axes = member_figure(pair, member, "ease-off")
    u, v, margin = map_grid(pair)
    relief = pair.surface.patch(u.ravel(), v.ravel(), ("ease_off",))[0].reshape(u.shape) * _UM
    shown = np.ma.masked_where(margin < 0.0, relief)
    top = max(float(np.max(relief[margin >= 0.0], initial=0.0)), 0.01)
    levels = MaxNLocator(10).tick_values(0.0, top)
    x, y = projection(pair, member, u, v)
    colours = axes.contourf(x, y, shown, levels=levels, cmap=COLOURS)
    lines = axes.contour(x, y, shown, levels=levels[1:], colors="w", linewidths=0.7)
    axes.clabel(lines, fmt="%g", fontsize=8)
    figure.colorbar(colours, ax=axes, label="ease-off, material\nmissing on pinion [µm]", shrink=0.85)
    draw_path(axes, pair, member)
    flank_axes(axes, pair, member)
    axes.legend(loc="lower left", fontsize=8, frameon=False, ncols=2)
    return figure


def contact_lines_figure(pair: FlankPair, cycle: tuple[MeshPosition, ...]) -> Figure:
    """Potential contact lines of all positions of a pitch, coloured by equivalent radius, and the path of contact."""
    figure, axes = member_figure(pair, "gear", "contact lines")
    blank = pair.surface.gear.blank
    lines: list[FloatArray] = []
    radii = []
    for position in cycle:
        for own in _flank_lines(position):
            u = position.face_gear[own] - 0.5 * blank.face_width
            line = np.stack([u, position.height_gear[own] + blank.root(u)], axis=1) * _MM
            lines += line_pieces(line)
            radii.append(position.radius_equivalent[own])
            if position is cycle[0]:
                label = "one position, all pairs" if own[0] == 0 else None
                axes.plot(*line.T, color="k", lw=2.5, zorder=3, label=label)
    shown = axes.add_collection(LineCollection(lines, array=np.concatenate(radii) * _MM, cmap=COLOURS, linewidths=1.3))
    figure.colorbar(shown, ax=axes, label="equivalent radius\nnormal to the line [mm]", shrink=0.85)
    draw_path(axes, pair, "gear")
    flank_axes(axes, pair, "gear")
    axes.legend(loc="lower left", fontsize=8, frameon=False, ncols=2)
    return figure


def _flank_lines(position: MeshPosition) -> list[NDArray[np.int64]]:
    """Points of each contact line of a position, without those of edges."""
    edge = position.edge
    return [line for line in position.lines if edge is None or not edge.touching[line[0]]]


def radius_figure(pair: FlankPair, cycle: tuple[MeshPosition, ...]) -> Axes:
    """Equivalent radius normal to the line along selected contact lines of the cycle."""
    axes = _curve_axes(pair, "equivalent radius along contact lines", 3.6)
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
    chosen = np.unique(np.linspace(0, len(traces) - 1, _TRACES + 2).astype(int)[1:-1])
    for colour, number in zip(colormaps[COLOURS](np.linspace(0.0, 0.9, chosen.size)), chosen, strict=True):
        roll, face, radius = traces[number]
        axes.plot(face * _MM, radius * _MM, color=colour, marker=".", ms=3, label=f"{roll:+.2f}")
    axes.set(
        xlabel="along the face of the gear from the toe [mm]",
        ylabel="equivalent radius normal\nto the contact line [mm]",
        ylim=(0.0, None),
        xlim=(0.0, pair.surface.gear.blank.face_width * _MM),
    )
    title = "roll of the pair\n[pinion pitches]"
    axes.legend(title=title, fontsize=8, title_fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return axes


def _curve_axes(pair: FlankPair, what: str, height: float = 3.8) -> Axes:
    """Axes of a new figure of curves, with a title."""
    axes = axes_or_new(None, 6.6, height)
    axes.set_title(f"{pair.name}, {pair.side}:\n{what}", fontsize=10)
    axes.grid(alpha=0.3)
    return axes


def contact_pattern_figure(pair: FlankPair, pattern: ContactPattern, member: Member, ax: Axes | None = None) -> Axes:
    """Contact pattern on a member, shaded in quarters of the marking thickness, with the path of contact."""
    thickness = pattern.thickness * _UM
    _, axes = member_figure(pair, member, f"contact pattern, marking {thickness:.4g} µm,", ax)
    u, height = (pattern.gear_u, pattern.gear_height) if member == "gear" else (pattern.pinion_u, pattern.pinion_height)
    gap = np.ma.masked_where(~pattern.inside, np.where(pattern.inside, pattern.separation, 0.0) * _UM)
    levels = np.linspace(0.0, thickness, 5)
    shades = axes.contourf(u * _MM, height * _MM, gap, levels=levels, cmap=COLOURS)
    if pattern.marked.any():
        axes.contour(u * _MM, height * _MM, gap, levels=levels[-1:], colors=BLUE, linewidths=1.4)
    figure_of(axes).colorbar(shades, ax=axes, label="minimum distance\nof the flanks [µm]", shrink=0.85, format="%.3g")
    draw_path(axes, pair, member)
    flank_axes(axes, pair, member)
    axes.legend(loc="lower left", fontsize=8, frameon=False)
    return axes


def transmission_figure(side: SideGeometry) -> Axes:
    """Transmission error of one tooth pair with its neighbours, and the resulting curve of the mesh."""
    mesh, pair = side.pair.transmission, side.pair
    found = f"{mesh.peak_to_peak / ARCSEC:.4g} arcsec peak to peak"
    axes = _curve_axes(pair, f"unloaded transmission error, {found}")
    path, pitch = mesh.path, pair.surface.pitch
    roll, error = path.pinion_angle / pitch, path.transmission_error / ARCSEC
    for shift, colour, name in ((-1.0, GREY, "neighbours"), (1.0, GREY, None), (0.0, BLUE, "one tooth pair")):
        axes.plot(roll + shift, np.where(path.free, error, np.nan), color=colour, lw=1.2, label=name)
        axes.plot(roll + shift, np.where(path.free, np.nan, error), color=colour, lw=1.0, ls=":")
    if not path.free.all():
        axes.plot([], [], color=BLUE, lw=1.0, ls=":", label="edge contact")
    start = mesh.pinion_angle[0] / pitch
    turns = np.arange(-1, 3)[:, None] + mesh.pinion_angle / pitch
    axes.plot(turns.ravel(), np.tile(mesh.error, 4) / ARCSEC, color=ORANGE, lw=2.4, alpha=0.8, label="gear pair")
    low = float(mesh.error.min()) / ARCSEC
    axes.set(
        xlabel="pinion angle from the design point [pinion pitches]",
        ylabel="transmission error of the gear [arcsec]",
        xlim=(start - 0.75, start + 1.75),
        ylim=(min(3.2 * low, -1e-3), max(-0.9 * low, 1e-3)),
    )
    axes.legend(fontsize=8, ncols=2, loc="upper center", frameon=False)
    return axes


def harmonics_figure(side: SideGeometry) -> Axes:
    """Amplitudes of the transmission error at multiples of the mesh frequency."""
    axes = _curve_axes(side.pair, "harmonics of the transmission error")
    values = side.pair.transmission.harmonics / ARCSEC
    order = np.arange(1, values.size + 1)
    axes.bar_label(axes.bar(order, values, color=BLUE, width=0.6), fmt="{:.3g}", padding=3, fontsize=8)
    axes.set(
        xlabel="order of the mesh frequency [-]",
        ylabel="amplitude [arcsec]",
        ylim=(0.0, 1.15 * max(float(values.max()), 1e-6)),
        xticks=order,
    )
    return axes


def blank_figure(design: Design) -> Figure:
    """Both members in the plane of their axes, gear axis upright; a hypoid pinion is rotated into that plane.

    The mean points coincide for a bevel pair. With an offset each member is drawn in its own axial plane, as in a
    blank drawing, so that the mean points do not coincide.
    """
    figure = new_figure()
    axes = figure.add_subplot()
    shaft = design.assembly.shaft_angle
    gear, pinion = design.gear.blank, design.pinion.blank
    # directions along the axis and radially towards the mesh; the gear axis points down so that the teeth face up
    directions = {
        "gear": (np.array([0.0, 1.0]), np.array([1.0, 0.0])),
        "pinion": (np.array([np.sin(shaft), np.cos(shaft)]), np.array([-np.cos(shaft), np.sin(shaft)])),
    }
    for name, blank, colour in (("gear", gear, ORANGE), ("pinion", pinion, BLUE)):
        _member(axes, blank, *directions[name], colour, f"{name}, {blank.teeth} teeth")
    axes.plot(0.0, 0.0, marker="+", ms=12, mew=1.6, color="k")
    axes.annotate("crossing point", (0.0, 0.0), xytext=(-8, -16), textcoords="offset points", fontsize=9, ha="right")
    for style, name in (("-", "pitch cone"), ("--", "face cone"), (":", "root cone"), ("-.", "axis")):
        axes.plot([], [], color="k", lw=0.9, ls=style, label=name)
    offset = design.assembly.hypoid_offset
    axes.set(
        xlabel="from the crossing point, normal to the gear axis [mm]",
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
            # from the apex of the cone to the heel
            r, at = blank.axial(u, height)
            apex = at[1] - (at[1] - at[0]) / (r[1] - r[0]) * r[1]
            line = np.array([apex, at[1]]), np.array([0.0, r[1]])
            drawn = (line[0][:, None] * along + sign * line[1][:, None] * out) * _MM
            axes.plot(*drawn.T, color=colour, lw=0.8, ls=style, alpha=0.9)
    reach = np.array([min(0.0, float(z.min())) - 0.004, float(z.max()) + 0.012])
    axes.plot(*(reach[:, None] * along * _MM).T, color=GREY, lw=0.9, ls="-.")
