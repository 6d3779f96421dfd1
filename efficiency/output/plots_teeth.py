"""Picture of the teeth in mesh: shaded surfaces of several teeth of both members at one position."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb

from efficiency.contact.tooth_grid import ToothGrid, tooth_grid
from ehl.common.arrays import FloatArray
from ehl.common.figures import BLUE, ORANGE, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from efficiency.contact.flank_pair import FlankPair


_ROWS, _COLUMNS = 7, 17


@dataclass(frozen=True)
class _View:
    """Axes of the picture in the mesh frame: right, up, and towards the viewer."""

    right: FloatArray
    up: FloatArray
    eye: FloatArray

    @classmethod
    def of(cls, eye: FloatArray, up: FloatArray) -> _View:
        eye = eye / np.linalg.norm(eye)
        up = up - eye * (up @ eye)
        up = up / np.linalg.norm(up)
        return cls(np.cross(up, eye), up, eye)


def tooth_pair_figure(pair: FlankPair, teeth: int = 3) -> Figure:
    """Several teeth of both members at the position of maximum transmission error, seen from heel and from toe.

    pair: the mesh; positions include the misalignments.
    teeth: number of teeth shown of each member, odd.
    """
    figure = new_figure(9.6, 4.0)
    surface, assembly = pair.surface, pair.surface.assembly
    angle = surface.direction * surface.error_maximum_roll + surface.roll_zero
    sheets: list[tuple[FloatArray, str]] = []
    for member, colour in (("gear", ORANGE), ("pinion", BLUE)):
        for sheet in _teeth(pair, "gear" if member == "gear" else "pinion", teeth):
            flat = sheet.reshape(-1, 3).T
            if member == "gear":
                placed = assembly.gear_in_mesh(flat, np.full(flat.shape[1], assembly.ratio * angle))
            else:
                placed = assembly.pinion_in_mesh(flat, np.full(flat.shape[1], angle + surface.phase))
            sheets.append((placed.T.reshape(sheet.shape), colour))
    contact = _contact_point(pair, angle)
    # along the face to the heel, and out of the gear teeth
    along, out = _directions(contact, surface.gear.blank.pitch_angle)
    aside = np.cross(out, along)
    for axes, side, name in zip(figure.subplots(1, 2), (1.0, -1.0), ("heel", "toe"), strict=True):
        view = _View.of(side * along + 0.35 * side * aside + 0.45 * out, out)
        polygons, colours = _painted(sheets, view)
        centre = np.array([contact @ view.right, contact @ view.up]) * 1e3
        axes.add_collection(
            PolyCollection(list(polygons * 1e3 - centre), facecolors=colours, edgecolors=colours, linewidths=0.3)
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


def _teeth(pair: FlankPair, member: Literal["pinion", "gear"], teeth: int) -> list[FloatArray]:
    """Surfaces (a, b, 3) of several teeth in the frame of the real flank of the mesh, with outward normals."""
    grid = tooth_grid(pair.flanks, member, _ROWS, _COLUMNS)
    flank = pair.surface.gear if member == "gear" else pair.surface.pinion
    row, column = _ROWS // 2, _COLUMNS // 2
    points, _ = flank.solve(grid.u[row, column : column + 1], grid.height[row, column : column + 1])
    own = grid.lower if grid.sides[0] == flank.side else grid.upper
    shift = float(points.azimuth[0] - own[row, column])
    sheets = []
    for k in range(teeth):
        turn = shift + (k - teeth // 2) * grid.pitch
        sheets += _tooth_sheets(grid, grid.lower + turn, grid.upper + turn)
    return sheets


def _tooth_sheets(grid: ToothGrid, low: FloatArray, high: FloatArray) -> list[FloatArray]:
    """Both flanks, top land, the root to the next tooth, and both end faces including a part of the rim."""
    u, h = grid.u, grid.height
    share = np.linspace(0.0, 1.0, 4)[:, None]
    land = low[-1] + share * (high[-1] - low[-1])
    root = high[0] + share * (low[0] + grid.pitch - high[0])
    sheets = [
        grid.point(low, u, h),
        grid.point(high, u, h).swapaxes(0, 1),
        grid.point(land, u[-1], h[-1]),
        grid.point(root, u[0], h[0]),
    ]
    depth = 0.35 * (grid.blank.mean_addendum + grid.blank.mean_dedendum)
    for end in (0, -1):
        face = low[:, end] + share * (high[:, end] - low[:, end])
        levels = np.broadcast_to(h[:, end], face.shape)
        sheet = grid.point(face, np.full(face.shape, u[0, end]), levels)
        rim = np.concatenate([face[:, 0], root[1:, end]])
        under = grid.point(
            np.stack([rim, rim], axis=1), np.full((rim.size, 2), u[0, end]), h[0, end] - np.array([depth, 0.0])
        )
        # the normal of azimuth times height points out of the toe; it is reversed at the heel
        sheets += [sheet, under] if end == 0 else [sheet.swapaxes(0, 1), under.swapaxes(0, 1)]
    return sheets


def _contact_point(pair: FlankPair, angle: float) -> FloatArray:
    """Maximum of the ease-off in the mesh frame (3,)."""
    surface = pair.surface
    u, v = (np.array([value]) for value in surface.error_maximum)
    return surface.assembly.gear_in_mesh(
        surface.patch(u, v, ("x", "y", "z")), np.array([surface.assembly.ratio * angle])
    )[:, 0]


def _directions(point: FloatArray, pitch_angle: float) -> tuple[FloatArray, FloatArray]:
    """Generatrix of the pitch cone of the gear through a point, to the heel, and the normal of the cone."""
    radial = np.array([point[0], point[1], 0.0]) / np.hypot(point[0], point[1])
    axial = np.array([0.0, 0.0, 1.0])
    c, s = np.cos(pitch_angle), np.sin(pitch_angle)
    return s * radial + c * axial, c * radial - s * axial


def _painted(sheets: list[tuple[FloatArray, str]], view: _View) -> tuple[FloatArray, FloatArray]:
    """Polygons (n, 4, 2) that face the viewer, the farthest first, and their colours."""
    quads, tints = [], []
    for sheet, colour in sheets:
        corners = np.stack([sheet[:-1, :-1], sheet[1:, :-1], sheet[1:, 1:], sheet[:-1, 1:]], axis=2).reshape(-1, 4, 3)
        quads.append(corners)
        tints.append(np.tile(to_rgb(colour), (len(corners), 1)))
    corners, tint = np.concatenate(quads), np.concatenate(tints)
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True).clip(1e-300)
    facing = normal @ view.eye > 0.0
    corners, tint, normal = corners[facing], tint[facing], normal[facing]
    light = 0.55 * view.eye + 0.55 * view.up - 0.45 * view.right
    shade = 0.6 + 0.4 * np.clip(normal @ (light / np.linalg.norm(light)), 0.0, 1.0)
    pale = 0.25 + 0.75 * tint
    order = np.argsort((corners @ view.eye).mean(axis=1))
    flat = np.stack([corners @ view.right, corners @ view.up], axis=-1)
    return flat[order], (pale * shade[:, None])[order]
