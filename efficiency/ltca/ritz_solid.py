"""Three-dimensional Rayleigh-Ritz model of a tooth cell: polynomials in its blocks with minimum potential energy.

Displacements are products of three polynomials of the block coordinates, continuous across the blocks: hierarchic
functions across and over the height, Legendre polynomials along the face. The products of degrees k with
``k_a/p_a + k_b/p_b + k_c/p_c <= 1`` are used (trunk space with an order p for each direction).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from efficiency.ltca.tooth_cell import Block, Part, ToothCell, gauss_rule, hierarchic_functions, legendre_polynomials
from ehl.common.arrays import FloatArray, IntArray
from ehl.common.errors import ConvergenceError

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

    def scaled(self, factor: float) -> Orders:
        """All orders times a factor, rounded, at least 2."""

        def times(orders: tuple[int, int, int]) -> tuple[int, int, int]:
            a, b, c = (max(2, round(factor * n)) for n in orders)
            return a, b, c

        return Orders(times(self.tooth), times(self.body))


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


# tuned: stiffness of a held end face over that of a body of its own size, practically rigid (ours); may be changed
# after running `test_body_and_how_it_is_held`
_HOLD = 1e4
