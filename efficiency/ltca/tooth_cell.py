"""One tooth with its part of the body, as blocks in curvilinear coordinates: the repeating cell of the member.

Three blocks are images of a unit cube by polynomials. The foot under the tooth and the body under the slot extend from
the held base to the root; the tooth is on the foot. Coordinates of a cube: a across (increasing azimuth), b from the
base to the tip, c along the face from toe to heel. Flanks and root line are those of `tooth_grid`. The polynomials of
geometry and displacements on [0, 1] come first.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.polynomial import legendre

from efficiency.contact.chebyshev import cubic_spline
from efficiency.contact.tooth_grid import ToothGrid
from ehl.common.arrays import FloatArray

Part = Literal["foot", "tooth", "slot"]
Pair = tuple[FloatArray, FloatArray]
"""Values and derivatives, each (points, functions)."""


@lru_cache(maxsize=32)
def lobatto_nodes(count: int) -> FloatArray:
    """Gauss-Lobatto points of [0, 1], at least two, including both ends."""
    # the roots are real, but NumPy 2.5 returns complex numbers
    inner = legendre.legroots(legendre.legder(np.eye(count)[count - 1])).real
    nodes = np.asarray(0.5 * (1.0 + np.concatenate([[-1.0], np.sort(inner), [1.0]])))
    nodes.setflags(write=False)
    return nodes


@lru_cache(maxsize=32)
def gauss_rule(count: int) -> tuple[FloatArray, FloatArray]:
    """Points and weights of the Gauss rule on [0, 1]."""
    points, weights = (0.5 * (shift + x) for shift, x in zip((1.0, 0.0), legendre.leggauss(count), strict=True))
    points.setflags(write=False)
    weights.setflags(write=False)
    return points, weights


def legendre_polynomials(degree: int, x: FloatArray) -> Pair:
    """Legendre polynomials in ``2 x - 1`` up to a degree."""
    s = 2.0 * x - 1.0
    slopes = legendre.legval(s, legendre.legder(np.eye(degree + 1)))
    return np.asarray(legendre.legvander(s, degree)), np.asarray(2.0 * np.broadcast_to(slopes.T, (x.size, degree + 1)))


def hierarchic_functions(degree: int, x: FloatArray) -> Pair:
    """``1 - x``, ``x``, and integrals of Legendre polynomials, which vanish at both ends (Szabo & Babuska 1991)."""
    p = legendre.legvander(2.0 * x - 1.0, degree)
    values, slopes = [1.0 - x, x], [-np.ones_like(x), np.ones_like(x)]
    for k in range(2, degree + 1):
        values.append((p[:, k] - p[:, k - 2]) / np.sqrt(2.0 * (2.0 * k - 1.0)))
        slopes.append(np.sqrt(2.0 * (2.0 * k - 1.0)) * p[:, k - 1])
    return np.stack(values, axis=-1), np.stack(slopes, axis=-1)


def lagrange_values(nodes: FloatArray, x: FloatArray) -> FloatArray:
    """Lagrange polynomials of nodes, (points, functions)."""
    return np.asarray(legendre.legvander(2.0 * x - 1.0, nodes.size - 1) @ _to_legendre(tuple(nodes.tolist())))


def lagrange_polynomials(nodes: FloatArray, x: FloatArray) -> Pair:
    """Lagrange polynomials of nodes and their derivatives."""
    values, slopes = legendre_polynomials(nodes.size - 1, x)
    inverse = _to_legendre(tuple(nodes.tolist()))
    return values @ inverse, slopes @ inverse


@lru_cache(maxsize=32)
def _to_legendre(nodes: tuple[float, ...]) -> FloatArray:
    """Matrix from values at nodes to Legendre coefficients."""
    return np.asarray(np.linalg.inv(legendre.legvander(2.0 * np.array(nodes) - 1.0, len(nodes) - 1)))


# tuned: nodes of the polynomials that map a cube to its block (across, over the height, along the face), within
# 14 um of the flanks; may be changed after running `test_cell_follows_the_flanks`
_ACROSS, _OVER, _ALONG = lobatto_nodes(7), lobatto_nodes(7), lobatto_nodes(9)
_DEEP = lobatto_nodes(4)
_FINE = 41  # points of a fillet and of the root line before redistribution
# tuned: slope of the fillet at which the tooth block begins, and largest fraction of the depth of this point (ours);
# may be changed after running `test_deflection_at_nine_flank_points`
_STEEPNESS, _HIGHEST = 1.0, 0.25


@dataclass(frozen=True)
class Block:
    """Polynomial image of the unit cube."""

    part: Part
    nodes: FloatArray  # (na, nb, nc, 3) points at the Gauss-Lobatto nodes of the cube [m]

    def place(self, a: FloatArray, b: FloatArray, c: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points (n, 3) [m] and their derivatives (n, 3 coordinates of the cube, 3) at n points of the cube."""
        (fa, da), (fb, db), (fc, dc) = self._polynomials(a, b, c)
        by_c = np.moveaxis(self.nodes, 2, 0).reshape(fc.shape[1], -1)
        shape = (a.size, *self.nodes.shape[:2], 3)
        here, ahead = (fc @ by_c).reshape(shape), (dc @ by_c).reshape(shape)

        def image(across: FloatArray, over: FloatArray, along: FloatArray) -> FloatArray:
            return np.asarray(np.einsum("pj,pjx->px", over, np.einsum("pi,pijx->pjx", across, along)))

        tangents = image(da, fb, here), image(fa, db, here), image(fa, fb, ahead)
        return image(fa, fb, here), np.stack(tangents, axis=1)

    def jacobian(self, a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
        """Derivatives (na, nb, nc, 3 coordinates of the cube, 3) on a tensor grid of the cube [m]."""
        polynomials = self._polynomials(a, b, c)
        columns = []
        for direction in range(3):
            factors = [pair[int(axis == direction)] for axis, pair in enumerate(polynomials)]
            columns.append(np.einsum("ai,bj,ck,ijkx->abcx", *factors, self.nodes, optimize=True))
        return np.stack(columns, axis=-2)

    def _polynomials(self, *coordinates: FloatArray) -> list[Pair]:
        counts = self.nodes.shape[:3]
        return [lagrange_polynomials(lobatto_nodes(n), x) for n, x in zip(counts, coordinates, strict=True)]


@dataclass(frozen=True)
class ToothCell:
    """Blocks of one pitch of a member, and the location of points on its flanks."""

    teeth: int  # number of teeth of the member
    # the slot follows the tooth in increasing azimuth
    foot: Block
    tooth: Block
    slot: Block
    width: float  # face width [m]
    stations: FloatArray  # (k,) distance of `floor` and `top` from the toe [m]
    # (k,) height of the lower end and of the tip of the tooth block above the root cone [m]
    floor: FloatArray
    top: FloatArray

    @property
    def pitch(self) -> float:
        """Angular pitch [rad]."""
        return 2.0 * np.pi / self.teeth

    def on_flank(self, face: FloatArray, height: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Coordinates (b, c) in the tooth block, clipped, from distances from the toe and above the root cone [m]."""
        along = np.clip(face / self.width, 0.0, 1.0)
        floor, top = (np.interp(along * self.width, self.stations, h) for h in (self.floor, self.top))
        return np.clip((height - floor) / (top - floor), 0.0, 1.0), along


def tooth_cell(grid: ToothGrid, rim_thickness: float, from_root: bool = False) -> ToothCell:
    """Blocks of one tooth from its flanks with fillets or root corners, at least five stations.

    The base is at a distance `rim_thickness` from the root cone, normal to the pitch cone [m]. The tooth block begins
    at half the fillets, or at the root.
    """
    u = grid.u[0]
    width = float(u[-1] - u[0])
    along = u[0] + width * _ALONG
    bottom, tip = grid.height[0], grid.height[-1]
    share = (grid.height - bottom) / (tip - bottom)
    start = 0.0 if from_root else _start(grid, share)
    fractions = start + (1.0 - start) * _OVER

    def smooth(values: FloatArray) -> FloatArray:
        return cubic_spline(u, values, along)

    def flank(azimuth: FloatArray, at: FloatArray) -> FloatArray:
        columns = zip(share.T, azimuth.T, strict=True)
        return np.stack([cubic_spline(x, y, at) for x, y in columns], axis=-1)

    lower, upper = (smooth(flank(azimuth, fractions)) for azimuth in (grid.lower, grid.upper))
    low, depth = smooth(bottom), smooth(tip - bottom)
    height = low + fractions[:, None] * depth
    base = smooth(grid.blank.root(u)) - rim_thickness

    def block(part: Part, azimuth: FloatArray, heights: FloatArray) -> Block:
        shape = np.broadcast_shapes(azimuth.shape, heights.shape)
        whole = [np.broadcast_to(x, shape) for x in (azimuth, along, heights)]
        return Block(part, grid.point(*whole))

    a, deep = _ACROSS[:, None, None], _DEEP[None, :, None]
    tooth = block("tooth", lower + a * (upper - lower), height[None])
    left, right, following = lower[0], upper[0], lower[0] + grid.pitch
    foot = block("foot", left + a * (right - left) + 0.0 * deep, base + deep * (height[0] - base))
    line_azimuth, sunk = _root_line(grid, flank, start)
    top, line = smooth(line_azimuth)[:, None], (low + smooth(sunk) * depth)[:, None]
    below = right + a * (following - right)
    slot = block("slot", below + deep * (top - below), base + deep * (line - base))
    root = grid.blank.root(u)
    floor = bottom + start * (tip - bottom)
    return ToothCell(grid.blank.teeth, foot, tooth, slot, width, u - u[0], floor - root, tip - root)


def _start(grid: ToothGrid, share: FloatArray) -> float:
    """Fraction of the depth at which the tooth block begins: at half the fillets, 0 at sharp corners."""
    radius, _ = grid.blank.axial(grid.u, grid.height)
    highest = 0.0
    for azimuth in (grid.lower, -grid.upper):
        slope = radius * np.gradient(azimuth, axis=0) / np.gradient(grid.height, axis=0)
        steep = np.where((slope > _STEEPNESS) & (share < _HIGHEST), share, 0.0)
        highest = max(highest, float(steep.max(axis=0).mean()))
    return highest


def _root_line(
    grid: ToothGrid, flank: Callable[[FloatArray, FloatArray], FloatArray], start: float
) -> tuple[FloatArray, FloatArray]:
    """Root line from one tooth along its fillet and the root to the next tooth: azimuth and fraction of the depth.

    Both are at the nodes across, with equal parts of the length of the line, for each station (nodes, stations).
    """
    down = np.linspace(start, 0.0, _FINE) if start > 0.0 else np.zeros(1)
    right, following = flank(grid.upper, down), flank(grid.lower, down) + grid.pitch
    land = np.linspace(0.0, 1.0, _FINE)[1:-1, None]
    azimuth = np.concatenate([right, right[-1] + land * (following[-1] - right[-1]), following[::-1]])
    fraction = np.concatenate([down, np.zeros(land.size), down[::-1]])
    radius, _ = grid.blank.axial(grid.u[0], grid.height[0])
    depth = grid.height[-1] - grid.height[0]
    steps = np.hypot(np.diff(azimuth, axis=0) * radius, np.diff(fraction)[:, None] * depth)
    length = np.concatenate([np.zeros((1, depth.size)), np.cumsum(steps, axis=0)])
    length /= length[-1]

    def shared(values: FloatArray) -> FloatArray:
        return np.stack([np.interp(_ACROSS, x, y) for x, y in zip(length.T, values.T, strict=True)], axis=-1)

    return shared(azimuth), shared(np.broadcast_to(fraction[:, None], azimuth.shape))
