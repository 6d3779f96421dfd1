"""Three-dimensional Rayleigh-Ritz model of a tooth cell: polynomials in its blocks with minimum potential energy.

Displacements are products of three polynomials of the block coordinates, continuous across the blocks: hierarchic
functions across and over the height, Legendre polynomials along the face. The products of degrees k with
``k_a/p_a + k_b/p_b + k_c/p_c <= 1`` are used (trunk space with an order p for each direction).

One tooth with its part of the body, as blocks in curvilinear coordinates: the repeating cell of the member.

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
from ehl.common.arrays import FloatArray, IntArray
from ehl.common.errors import ConvergenceError

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
_ACROSS, _OVER, _ALONG = lobatto_nodes(7), lobatto_nodes(7), 9
_DEEP = lobatto_nodes(4)
_FINE = 41  # points of a fillet and of the root line before redistribution
# tuned: slope of the fillet at which the tooth block begins, and largest fraction of the depth of this point (this
# work); may be changed after running `test_deflection_at_nine_flank_points`
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


def turns(grid: ToothGrid) -> int:
    """Further nodes and orders along a tooth that winds by more than 5 rad, as with 1 to 3 teeth; 0 for all others.

    With them the flank of a pinion that winds by 20 rad changes by less than 0.1 % from there to 25 nodes.
    """
    return int(np.ceil(0.6 * max(grid.winding - 5.0, 0.0)))


def tooth_cell(grid: ToothGrid, rim_thickness: float, from_root: bool = False) -> ToothCell:
    """Blocks of one tooth from its flanks with fillets or root corners, at least five stations.

    The base is at a distance `rim_thickness` from the root cone, normal to the pitch cone [m]. The tooth block begins
    at half the fillets, or at the root.
    """
    u = grid.u[0]
    width = float(u[-1] - u[0])
    along = u[0] + width * lobatto_nodes(_ALONG + turns(grid))
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


Key = tuple[tuple[str, int, int], tuple[str, int, int], int]
"""Key of a function: node or bubble across (interval, degree), over the height, and degree along the face."""

# column and layer of each block: columns share the nodes 1 (right of the tooth), layers the node 1 (root)
PLACES: dict[Part, tuple[int, int]] = {"foot": (0, 0), "slot": (1, 0), "tooth": (0, 1)}
LEFT, RIGHT = ("node", 0, 0), ("node", 2, 0)
_BASE = ("node", 0, 0)
_REMEDY = "flanks, fillets or root cross; give the tooth a smaller edge radius, dedendum or addendum"
# points of the Gauss rule beyond the degree
_EXTRA = 2


@dataclass(frozen=True)
class Orders:
    """Polynomial orders across, over the height and along the face, in the tooth and in the body."""

    tooth: tuple[int, int, int]
    body: tuple[int, int, int]

    def longer(self, more: int) -> Orders:
        """The orders along the face raised by a number."""
        (*tooth, along), (*body, under) = self.tooth, self.body
        return Orders((tooth[0], tooth[1], along + more), (body[0], body[1], under + more))


ORDERS = Orders(tooth=(7, 9, 16), body=(6, 6, 14))
# tuned: convergence of line loads to 4 % (docs/tooth_compliance.md); may be changed after repeating that table


@dataclass(frozen=True)
class BlockFunctions:
    """Functions of a block."""

    block: Block
    # (n, 3) number of the one-dimensional function across and over the height (0 and 1: linear), degree along the face
    degrees: IntArray
    number: IntArray  # (n,) number of the function in the cell

    def values(self, a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
        """Values (points, n) at positions in the block."""
        na, nb, nc = self.degrees.max(axis=0)
        across, over = hierarchic_functions(int(na), a)[0], hierarchic_functions(int(nb), b)[0]
        along = legendre_polynomials(int(nc), c)[0]
        ia, ib, ic = self.degrees.T
        return across[:, ia] * over[:, ib] * along[:, ic]

    def stiffness(self, youngs_modulus: float, poisson_ratio: float) -> FloatArray:
        """Stiffness (3, n, 3, n) of the block [N/m]; `ConvergenceError` if it is folded."""
        highest = self.degrees.max(axis=0)
        rules = [gauss_rule(int(k) + _EXTRA) for k in highest]
        x, y, z = (rule[0] for rule in rules)
        jacobian = self.block.jacobian(x, y, z).reshape(-1, 3, 3)
        volume = np.linalg.det(jacobian)
        if np.any(volume * np.sign(volume[0]) <= 0.0):
            raise ConvergenceError("tooth_folded", f"the {self.block.part} of the tooth model is folded: {_REMEDY}")
        weight = np.einsum("i,j,k->ijk", *(rule[1] for rule in rules)).ravel() * np.abs(volume)
        pairs = hierarchic_functions(int(highest[0]), x), hierarchic_functions(int(highest[1]), y)
        factors = (*pairs, legendre_polynomials(int(highest[2]), z))
        ia, ib, ic = self.degrees.T

        def product(direction: int) -> FloatArray:
            one, two, three = (pair[int(axis == direction)] for axis, pair in enumerate(factors))
            plane = one[:, ia][:, None] * two[:, ib]
            return (plane[:, :, None] * three[:, ic]).reshape(weight.size, -1)

        inverse = np.linalg.inv(jacobian) * np.sqrt(weight)[:, None, None]
        reference = [product(direction) for direction in range(3)]
        gradient = np.empty((3, weight.size, ia.size))
        for i in range(3):
            np.multiply(inverse[:, i, :1], reference[0], out=gradient[i])
            for j in (1, 2):
                gradient[i] += inverse[:, i, j : j + 1] * reference[j]
        lame = youngs_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio))
        shear = youngs_modulus / (2.0 * (1.0 + poisson_ratio))
        size = ia.size
        result = np.empty((3, size, 3, size))
        laplace = np.zeros((size, size))
        for i in range(3):
            for j in range(i, 3):
                gram = gradient[i].T @ gradient[j]
                result[i, :, j] = lame * gram + shear * gram.T
                result[j, :, i] = result[i, :, j].T
                if i == j:
                    laplace += gram
        for i in range(3):
            result[i, :, i] += shear * laplace
        return result


@dataclass(frozen=True)
class RitzSolid:
    """Functions of a cell and their stiffness."""

    functions: dict[Part, BlockFunctions]
    stiffness: FloatArray  # (3 n, 3 n) of all components of all functions, component by component [N/m]
    # (m,) functions on the sides shared with the previous and the next cell, in the same order
    left: IntArray
    right: IntArray

    @property
    def count(self) -> int:
        """Number of functions."""
        return len(self.stiffness) // 3


def ritz_solid(
    cell: ToothCell, moduli: dict[Part, float], poisson_ratio: float, held: frozenset[str], orders: Orders
) -> RitzSolid:
    """Assemble a cell of parts with Young's moduli [Pa], without displacement at "base", "toe" or "heel"."""
    number: dict[Key, int] = {}
    functions = {
        block.part: _functions(block, orders, number, "base" in held) for block in (cell.foot, cell.slot, cell.tooth)
    }
    count = len(number)
    total = np.zeros((3, count, 3, count))
    for part, own in functions.items():
        stiffness = own.stiffness(moduli[part], poisson_ratio)
        for i in range(3):
            for j in range(3):
                total[i, :, j][np.ix_(own.number, own.number)] += stiffness[i, :, j]
    for end in held & {"toe", "heel"}:
        for part in ("foot", "slot"):
            _hold_end(total, functions[part], end, moduli[part])
    keys = [key for key in number if key[0] == LEFT and _shared(key)]
    left = np.array([number[key] for key in keys])
    right = np.array([number[RIGHT, key[1], key[2]] for key in keys])
    return RitzSolid(functions, total.reshape(3 * count, 3 * count), left, right)


def _shared(key: Key) -> bool:
    """Whether a function extends into the body."""
    kind, interval, _ = key[1]
    return (kind == "node" and interval < 2) or (kind == "bubble" and interval == 0)


def _functions(block: Block, orders: Orders, number: dict[Key, int], base_held: bool) -> BlockFunctions:
    """Functions of a block, numbered in order of appearance."""
    column, layer = PLACES[block.part]
    highest = [max(pair) for pair in zip(orders.tooth, orders.body, strict=True)]
    degrees, numbers = [], []
    for ia in range(highest[0] + 1):
        across = ("node", column + ia, 0) if ia < 2 else ("bubble", column, ia)
        for ib in range(highest[1] + 1):
            over = ("node", layer + ib, 0) if ib < 2 else ("bubble", layer, ib)
            if base_held and over == _BASE:
                continue
            # functions that move the root belong to the tooth along the whole pitch
            fine = over == ("node", 1, 0) or layer == 1
            limit = orders.tooth if fine and not (across[0] == "bubble" and column == 1) else orders.body
            for ic in range(limit[2] + 1):
                used = [0 if k < 2 else k for k in (ia, ib, ic)]
                if sum(k / p for k, p in zip(used, limit, strict=True)) <= 1.0 + 1e-9:
                    degrees.append((ia, ib, ic))
                    numbers.append(number.setdefault((across, over, ic), len(number)))
    return BlockFunctions(block, np.array(degrees), np.array(numbers))


def _hold_end(total: FloatArray, own: BlockFunctions, end: str, modulus: float) -> None:
    """Springs on an end face of the body, much stiffer than the body."""
    degrees = own.degrees.max(axis=0)
    (a, wa), (b, wb) = gauss_rule(int(degrees[0]) + _EXTRA), gauss_rule(int(degrees[1]) + _EXTRA)
    across, over = np.repeat(a, b.size), np.tile(b, a.size)
    along = np.full(across.size, 0.0 if end == "toe" else 1.0)
    _, tangents = own.block.place(across, over, along)
    area = np.linalg.norm(np.cross(tangents[:, 0], tangents[:, 1]), axis=1) * np.outer(wa, wb).ravel()
    values = own.values(across, over, along)
    spring = _HOLD * modulus / np.sqrt(area.sum()) * (values.T @ (area[:, None] * values))
    for i in range(3):
        total[i, :, i][np.ix_(own.number, own.number)] += spring


# tuned: stiffness of a held end face over that of a body of its own size, practically rigid (this work); may be changed
# after running `test_body_and_how_it_is_held`
_HOLD = 1e4
