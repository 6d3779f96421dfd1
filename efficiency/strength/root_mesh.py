"""Finite-element mesh of one pitch of a member: a tooth with its cut fillets and its part of the rim.

Sections are cones normal to the pitch cone at stations along the face. Each section is flattened (azimuth times radius
and cosine of the spiral angle across, height up), and all have the same topology. Two layers of elements follow flank,
fillet and root from the middle of one slot to the tip. The core of the tooth, the rim under it and the rim under the
slots fill the rest. The pitch is cut at the middle of the slots, so that both cuts are equal.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.chebyshev import cubic_spline
from efficiency.contact.gear_flanks import GearFlanks, Member
from efficiency.contact.tooth_grid import RootProfile, ToothGrid, root_profile
from efficiency.cutting.flank import CutFlank
from efficiency.strength.hexahedra import CORNERS_AND_EDGES
from ehl.common.arrays import FloatArray, IntArray
from ehl.common.errors import ConvergenceError, InputError

# tuned: default edge radius of a cutter, in mean normal modules (this work; basic racks have 0.2 to 0.4); may be
# changed freely, the value of a design has priority
EDGE_RADIUS = 0.25
# fractions of it that are tried in turn if the slot is too narrow
_RADII = (1.0, 0.75, 0.5)
_FINE = 400  # points of one side of the outline before redistribution
# tuned: weight of curvature over length in the distribution of nodes along the outline (this work); may be changed
# after running `test_stress_converges_with_the_elements`
_BEND = 1.5
# tuned: thickness of the surface layers over the thickness of the tooth at the fillets and at the tip, and of the outer
# layer over both (this work); may be changed after running `test_stress_converges_with_the_elements`
_LAYER, _LAYER_TIP, _OUTER = 0.16, 0.22, 0.4
# tuned: weights across, up and along with the shortest factorisation for shipped designs (this work); may be changed
# freely
_SPLIT = np.array([2.0, 1.0, 3.0])


@dataclass(frozen=True)
class Counts:
    """Numbers of elements of a pitch."""

    # along the outline from the middle of the slot to the middle of the fillet, and from there to the tip
    low: int = 4
    high: int = 6
    layer: int = 2  # in the surface layers
    # across the core of the tooth, and down the rim
    across: int = 2
    deep: int = 2
    along: int = 12  # along the face


@dataclass(frozen=True)
class Outline:
    """One side of a tooth from the middle of the slot to the tip, at stations along the face."""

    azimuth: FloatArray  # (n, k) about the axis of the member, from the middle of the tooth [rad]
    height: FloatArray  # (n, k) above the pitch cone [m]


@dataclass(frozen=True)
class RootMesh:
    """Nodes and elements of a pitch."""

    counts: Counts
    nodes: FloatArray  # [m]
    elements: IntArray  # nodes in the order of `CORNERS_AND_EDGES`: along the outline, inward, along the face
    places: FloatArray  # centres of the elements in element lengths, weighted for the bisection
    rim: NDArray[np.bool_]  # elements of the body under the root
    # nodes of the two cuts, in the same order
    left: IntArray
    right: IntArray
    # nodes of the surfaces that can be held
    base: NDArray[np.bool_]
    toe: NDArray[np.bool_]
    heel: NDArray[np.bool_]
    # elements at the surface of the lower (0) and upper (1) side: along the outline from the slot, along the face
    surface: tuple[IntArray, IntArray]
    stations: FloatArray  # distance from the toe [m]
    outlines: tuple[Outline, Outline]  # lower and upper side at all nodes
    columns: FloatArray  # distance of `radius` and `chord` from the toe [m]
    # radius of the fillets of the lower and the upper side between their tangents of 30 and 60 deg [m]
    radius: tuple[FloatArray, FloatArray]
    chord: FloatArray  # thickness of the tooth between the tangents of 30 deg [m]
    fillet: str  # origin of the fillets, in words


def root_mesh(
    flanks: GearFlanks, member: Member, grid: ToothGrid, rim_thickness: float, module: float, counts: Counts
) -> RootMesh:
    """Mesh of one pitch of a member; `ConvergenceError` if no fillet fits.

    `grid`: the flanks of the tooth at some stations; `module`: the mean normal module, for the default edge radius of a
    cutter [m].
    """
    if not (np.isfinite(module) and module > 0.0):
        raise InputError("module", module, "a finite length above 0 m")
    curves, fillet = _curves(flanks, member, grid, module)
    u = grid.u[0]
    at = np.linspace(u[0], u[-1], 2 * counts.along + 1)
    middle = grid.height.shape[0] // 2
    radius = grid.blank.axial(grid.u[middle], grid.height[middle])[0]
    turn = np.gradient(0.5 * (grid.lower + grid.upper)[middle], u)
    flat = radius / np.sqrt(1.0 + (radius * turn) ** 2)  # length across a tooth per angle
    flattened = [[curve * np.array([scale, 1.0]) for curve, scale in zip(side, flat, strict=True)] for side in curves]
    outlines = [cubic_spline(u, _nodes_along(side, u, counts), at) for side in flattened]
    notches = [np.array([_notch(curve) for curve in side]).T for side in flattened]
    scale = cubic_spline(u, flat, at)
    base = cubic_spline(u, grid.blank.root(u), at) - rim_thickness
    section, elements, rim, places, surface, cuts, bottom = _section(outlines, base, counts)
    planes = np.arange(2 * counts.along + 1)
    azimuth, height = section[:, 0] / scale, section[:, 1]
    points = grid.point(azimuth, np.broadcast_to(at, azimuth.shape), height)  # (m, planes, 3)
    number = np.full((section.shape[0], planes.size), -1)
    # only corners are between the planes
    corners = np.unique(elements[:, _section_nodes(corners=True)])
    used = np.zeros(number.shape, bool)
    used[np.unique(elements[:, _section_nodes(corners=False)])[:, None], planes[::2]] = True
    used[corners[:, None], planes[1::2]] = True
    number[used] = np.arange(used.sum())
    nodes = points[used]
    lattice = CORNERS_AND_EDGES + 1
    own = 3 * lattice[:, 0] + lattice[:, 1]
    whole = np.stack([number[elements[:, own], 2 * k + lattice[:, 2]] for k in range(counts.along)], axis=1)
    spots = np.empty((*whole.shape[:2], 3))
    spots[..., :2], spots[..., 2] = places[:, None], np.arange(counts.along)

    def along(section_nodes: IntArray) -> IntArray:
        found = number[section_nodes]
        return np.asarray(found[found >= 0])

    def where(section_nodes: IntArray, at_planes: IntArray) -> NDArray[np.bool_]:
        mask = np.zeros(len(nodes), bool)
        found = number[np.ix_(section_nodes, at_planes)]
        mask[found[found >= 0]] = True
        return mask

    in_rim = np.unique(elements[rim])
    index = np.arange(whole.shape[0] * counts.along).reshape(-1, counts.along)
    sides = tuple(Outline(line[:, 0] / scale, line[:, 1]) for line in outlines)
    return RootMesh(
        counts=counts,
        nodes=nodes,
        elements=whole.reshape(-1, 20),
        places=(_SPLIT * spots).reshape(-1, 3),
        rim=np.repeat(rim, counts.along),
        left=along(cuts[0]),
        right=along(cuts[1]),
        base=where(bottom, planes),
        toe=where(in_rim, planes[:1]),
        heel=where(in_rim, planes[-1:]),
        surface=(index[surface[0]], index[surface[1]]),
        stations=at - u[0],
        outlines=(sides[0], sides[1]),
        columns=u - u[0],
        radius=(notches[0][0], notches[1][0]),
        chord=np.abs(notches[1][1] - notches[0][1]),
        fillet=fillet,
    )


def _section_nodes(*, corners: bool) -> IntArray:
    """Indices of the corners of an element of a section with nine nodes, or of corners and middles of sides."""
    parity = np.array([[i % 2, j % 2] for i in range(3) for j in range(3)]).sum(axis=1)
    return np.flatnonzero(parity == 0 if corners else parity < 2)


def _section(
    outlines: Sequence[FloatArray], base: FloatArray, counts: Counts
) -> tuple[FloatArray, IntArray, NDArray[np.bool_], FloatArray, tuple[IntArray, IntArray], list[IntArray], IntArray]:
    """Nodes (m, 2, k) of the flattened sections, elements (e, 9) and their attributes."""
    low = 2 * counts.low
    inner = [_layer(line, other, counts) for line, other in zip(outlines, outlines[::-1], strict=True)]
    layers = 2 * counts.layer + 1
    thick = np.concatenate([np.linspace(0.0, _OUTER, layers // 2 + 1), np.linspace(_OUTER, 1.0, layers // 2 + 1)[1:]])
    blocks: list[FloatArray] = []
    for line, ends in zip(outlines, inner, strict=True):
        blocks.append(line[:, None] + thick[None, :, None, None] * (ends - line)[:, None])
    left, right = inner
    t = np.linspace(0.0, 1.0, 2 * counts.across + 1)[None, :, None, None]
    core = left[low:, None] * (1.0 - t) + right[low:, None] * t
    blocks.append(core)
    down = np.linspace(0.0, 1.0, 2 * counts.deep + 1) ** 1.3
    floor = [np.stack([x, base]) for x in (left[0, 0], left[low, 0], right[low, 0], right[0, 0])]
    for x, y in ((1, 0), (2, 3)):
        # the base under the fillets is wider than the tooth
        floor[x][0] = 0.75 * floor[x][0] + 0.25 * floor[y][0]
    foot = core[0][:, None]
    under = floor[1] * (1.0 - t[0]) + floor[2] * t[0]
    blocks.append(foot + down[None, :, None, None] * (under[:, None] - foot))
    for ends, (x, y) in zip(inner, ((0, 1), (3, 2)), strict=True):
        top = ends[: low + 1]
        length = np.linalg.norm(np.diff(top, axis=0), axis=1)
        share = np.concatenate([np.zeros((1, length.shape[1])), np.cumsum(length, axis=0)]) / length.sum(axis=0)
        under = floor[x] * (1.0 - share[:, None]) + floor[y] * share[:, None]
        blocks.append(top[:, None] + down[None, :, None, None] * (under - top)[:, None])
    points = np.concatenate([block.reshape(-1, 2, base.size) for block in blocks])
    middle = points[:, :, base.size // 2]
    scale = 1e-7 * float(np.ptp(middle[:, 0]))
    order = np.lexsort(np.round(middle.T / (1e3 * scale)))
    number = np.empty(len(points), np.int64)
    number[order] = np.cumsum(
        np.concatenate([[False], np.linalg.norm(np.diff(middle[order], axis=0), axis=1) > 1e3 * scale])
    )
    nodes = np.empty((number.max() + 1, 2, base.size))
    nodes[number] = points
    start, elements, rim = 0, [], []
    lattices: list[IntArray] = []
    for k, block in enumerate(blocks):
        rows, columns = block.shape[:2]
        lattice: IntArray = number[start : start + rows * columns].reshape(rows, columns)
        start += lattice.size
        lattices.append(lattice)
        own = [lattice[i : rows - 2 + i : 2, j : columns - 2 + j : 2].ravel() for i in range(3) for j in range(3)]
        elements.append(np.stack(own, axis=-1))
        rim.append(np.full(len(elements[-1]), k > 2))
    count = counts.layer
    one = np.arange((counts.low + counts.high) * count).reshape(-1, count)
    surface = one[:, 0], one[:, 0] + one.size
    cuts = [np.concatenate([lattices[k][0], lattices[k + 4][0, 1:]]) for k in (0, 1)]
    bottom = np.unique(np.concatenate([lattices[k][:, -1] for k in (3, 4, 5)]))
    whole = np.concatenate(elements)
    size = float(np.ptp(middle[:, 0])) / (2.0 * counts.low + counts.across)
    places = nodes[whole[:, 4], :, base.size // 2] / size
    return nodes, whole, np.concatenate(rim), places, surface, cuts, bottom


def _layer(line: FloatArray, other: FloatArray, counts: Counts) -> FloatArray:
    """Inner side (n, 2, k) of the surface layers of one side of the outline; `other` is the other side."""
    low = 2 * counts.low
    inwards = np.sign(other[-1, 0] - line[-1, 0])
    tangent = np.gradient(line, axis=0)
    angle = np.unwrap(np.arctan2(tangent[:, 1], tangent[:, 0] * inwards), axis=0) - 0.5 * np.pi
    # vertical in the middle of the slot, inside the pitch, horizontal at the tip
    place = np.arange(len(line))[:, None]
    angle[0] = -0.5 * np.pi
    angle = np.clip(angle, -0.5 * np.pi, 0.25 * np.pi)
    blend = np.clip((place - low) / (len(line) - 1 - low), 0.0, 1.0) ** 2
    angle = angle * (1.0 - blend)
    for _ in range(3):
        angle[1:-1] = 0.25 * angle[:-2] + 0.5 * angle[1:-1] + 0.25 * angle[2:]
    chord = np.abs(line[:, 0] - other[:, 0])
    root, tip = _LAYER * chord[low], np.minimum(_LAYER * chord[low], _LAYER_TIP * chord[-1])
    depth = root + (tip - root) * np.clip((place - low) / (len(line) - 1 - low), 0.0, 1.0)
    return np.asarray(line + depth[:, None] * np.stack([inwards * np.cos(angle), np.sin(angle)], axis=1))


def _nodes_along(curves: Sequence[FloatArray], u: FloatArray, counts: Counts) -> FloatArray:
    """Nodes (n, 2, k) along one side of the flattened sections, given by curves from the middle of the slot.

    Corners, including the middle of the fillet, are evenly distributed in length and curvature. Their fractions of the
    length of the curve vary smoothly along the face.
    """
    lengths = [np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(c, axis=0), axis=1))]) for c in curves]
    shares = np.stack([_shares(c, length, counts) for c, length in zip(curves, lengths, strict=True)], axis=-1)
    smooth = np.polynomial.polynomial.polyfit(u / np.ptp(u), shares.T, 2)
    shares = np.maximum.accumulate(np.clip(np.polynomial.polynomial.polyval(u / np.ptp(u), smooth), 0.0, 1.0), axis=0)
    corners = np.arange(len(shares))
    found = []
    for curve, length, share in zip(curves, lengths, shares.T, strict=True):
        at = length[-1] * np.interp(np.arange(2 * corners.size - 1), 2 * corners, share)
        found.append(np.stack([np.interp(at, length, x) for x in curve.T], axis=-1))
    return np.stack(found, axis=-1)


def _notch(curve: FloatArray) -> tuple[float, float]:
    """Mean radius of a fillet between its tangents of 60 and 30 deg to the tooth axis, and place of the latter.

    The curve (n, 2) begins in the middle of the slot [m].
    """
    step = np.diff(curve, axis=0)
    steep = np.arctan2(np.abs(step[:, 0]), step[:, 1])
    first, last = (int(np.argmax(steep <= angle)) for angle in (np.pi / 3.0, np.pi / 6.0))
    last = max(last, first + 1)
    length = float(np.linalg.norm(step[first:last], axis=1).sum())
    return length / max(float(steep[first] - steep[last]), 1e-3), float(curve[last, 0])


def _shares(curve: FloatArray, length: FloatArray, counts: Counts) -> FloatArray:
    """Corners of the elements along a curve (n, 2), as fractions of its length."""
    even = np.linspace(0.0, 1.0, _FINE)
    fine = np.stack([np.interp(even * length[-1], length, x) for x in curve.T], axis=-1)
    turn = np.unwrap(np.arctan2(*np.diff(fine, axis=0).T[::-1]))
    bend = np.abs(np.gradient(turn))
    kernel = np.hanning(_FINE // 10)
    bend = np.convolve(bend, kernel / kernel.sum(), mode="same")
    # the middle of the fillet is at half of the angle to the flank, at most 45 deg
    away = np.maximum.accumulate(np.abs(turn - turn[0]))
    half = max(int(np.argmax(away > min(0.5 * away[-1], 0.25 * np.pi))), _FINE // 20)
    share = np.concatenate([[0.0], np.cumsum(1.0 / bend.size + _BEND * bend / bend.sum())])
    low, high = np.linspace(0.0, share[half], counts.low + 1), np.linspace(share[half], share[-1], counts.high + 1)
    return np.asarray(np.interp(np.concatenate([low, high[1:]]), share, even))


def _curves(flanks: GearFlanks, member: Member, grid: ToothGrid, module: float) -> tuple[list[list[FloatArray]], str]:
    """Azimuth and height (n, 2) of both sides, slot to tip, at the columns of the grid; origin of the fillets."""
    given = [flank.blade.edge_radius if isinstance(flank, CutFlank) else 0.0 for flank in flanks.of(member).values()]
    stated = all(radius > 0.0 for radius in given)
    default = f"assumed, edge radius {EDGE_RADIUS:g} normal modules (none in the design)"
    origin = "cut, edge radius of the design" if stated else default
    error: ConvergenceError | None = None
    for share in _RADII:
        radius = share * EDGE_RADIUS * module
        try:
            roots = _cut_fillets(flanks, member, grid, radius)
            sides = [_side(root, grid, radius, k) for k, root in enumerate(roots)]
        except ConvergenceError as found:
            error = found
            continue
        if not stated and share < 1.0:
            origin = f"assumed, edge radius {share * EDGE_RADIUS:.3g} normal modules: no larger one fits the slot"
        joined = [_joined(low, high, grid.pitch) for low, high in zip(*sides, strict=True)]
        return [[pair[k] for pair in joined] for k in (0, 1)], origin
    raise error or ConvergenceError("no_fillet", "no fillet fits between the flanks")


def _joined(low: FloatArray, high: FloatArray, pitch: float) -> tuple[FloatArray, FloatArray]:
    """Both sides of a slot (azimuth and height, tip first) cut in its middle and reversed: slot first."""
    following = low + np.array([pitch, 0.0])
    if high[-1, 0] < following[-1, 0]:
        middle = 0.5 * (high[-1] + following[-1])
        return np.concatenate([(middle - [pitch, 0.0])[None], low[::-1]]), np.concatenate([middle[None], high[::-1]])
    # the fillets cross, and each cutter removes material of the other one
    order = np.argsort(following[:, 0])
    ahead = high[:, 0] >= following[:, 0].min()
    gap = high[ahead, 1] - np.interp(high[ahead, 0], following[order, 0], following[order, 1])
    found = np.flatnonzero(gap <= 0.0)
    if not found.size or not ahead.any():
        raise ConvergenceError("no_fillet", "the fillets of a slot do not meet")
    first = int(np.flatnonzero(ahead)[found[0]])
    middle = np.array([high[first, 0], np.interp(high[first, 0], following[order, 0], following[order, 1])])
    other = low[low[:, 0] + pitch > middle[0]]
    start = (middle - [pitch, 0.0])[None]
    return np.concatenate([start, other[::-1]]), np.concatenate([middle[None], high[:first][::-1]])


def _side(root: RootProfile | None, grid: ToothGrid, radius: float, upper: int) -> list[FloatArray]:
    """Azimuth and height (n, 2) of one side of the tooth, tip first, at the columns of the grid."""
    azimuth = grid.upper if upper else grid.lower
    curves = []
    middle = grid.height.shape[0] // 2
    mean = grid.blank.axial(grid.u[middle], grid.height[middle])[0]
    scale = mean / np.sqrt(1.0 + (mean * np.gradient(azimuth[middle], grid.u[0])) ** 2)
    for column in range(grid.u.shape[1]):
        height = grid.height[:, column]
        low = height[0] if root is None else root.start[column]
        levels = np.linspace(height[-1], low, 40)
        flank = np.stack([cubic_spline(height, azimuth[:, column], levels), levels], axis=-1)
        if root is None:
            flat = np.array([scale[column] if upper else -scale[column], 1.0])
            curves.append(_with_arc(flank * flat, float(grid.blank.root(grid.u[0, column])), radius) / flat)
            continue
        fillet = np.stack([root.azimuth[:, column], root.height[:, column]], axis=-1)
        fillet[:, 0] += flank[-1, 0] - fillet[0, 0]
        curves.append(np.concatenate([flank, fillet[1:]]))
    return curves


def _with_arc(flank: FloatArray, root: float, radius: float) -> FloatArray:
    """A flank (n, 2), tip first, joined to a horizontal root by an arc [m]; it faces increasing first coordinates.

    Raises `ConvergenceError` if the flank does not reach the root or the arc does not fit.
    """
    # linear extrapolation below its last point
    slope = flank[-1] - flank[-2]
    ahead = flank[-1] + slope / np.linalg.norm(slope) * np.linspace(0.0, 3.0, 13)[1:, None] * radius
    line = np.concatenate([flank, ahead])
    fine = np.linspace(0.0, 1.0, 40)[:-1]
    line = np.concatenate([*(a + fine[:, None] * (b - a) for a, b in pairwise(line)), line[-1:]])
    tangent = np.gradient(line, axis=0)
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=-1)
    centres = line + radius * normal / np.linalg.norm(normal, axis=1)[:, None]
    above = centres[:, 1] - (root + radius)
    found = np.flatnonzero((above[:-1] > 0.0) & (above[1:] <= 0.0))
    if not found.size:
        raise ConvergenceError("no_fillet", f"no fillet of radius {radius * 1e3:.3g} mm fits between flank and root")
    k = int(found[0])
    share = above[k] / (above[k] - above[k + 1])
    centre, touch = (x[k] + share * (x[k + 1] - x[k]) for x in (centres, line))
    start = np.arctan2(*(touch - centre)[::-1]) % (2.0 * np.pi)
    angle = np.linspace(start, 1.5 * np.pi, 41)
    arc = centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return np.concatenate([flank[flank[:, 1] > touch[1]], arc])


def _cut_fillets(
    flanks: GearFlanks, member: Member, grid: ToothGrid, radius: float
) -> tuple[RootProfile | None, RootProfile | None]:
    """Fillets cut on both sides, with the given radius for cutters without edge radius; None if unavailable."""
    cut: list[CutFlank] = []
    for side in grid.sides:
        flank = flanks.of(member)[side]
        if not isinstance(flank, CutFlank):
            return None, None
        if not flank.blade.edge_radius > 0.0:
            try:
                flank = replace(flank, blade=replace(flank.blade, edge_radius=radius))
            except (InputError, ConvergenceError, ValueError):
                return None, None
        cut.append(flank)
    stations = grid.u.shape[1]
    low, high = (root_profile(flank, stations, flanks.clearance(member)) for flank in cut)
    if (low is None) != (high is None):
        # a slot has one root: if one side is cut to full depth, the other is used as cut
        low, high = (root_profile(flank, stations, np.inf) for flank in cut)
    return (None, None) if low is None or high is None else (low, high)
