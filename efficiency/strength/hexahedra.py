"""Quadratic hexahedra with 20 nodes, and the Cholesky factors of their stiffness by nested dissection.

The elements are bisected recursively. Each part is condensed onto the nodes that it shares with the others; two parts
are then joined and condensed again (multifrontal method; George 1973). All operations are on dense blocks, in the
precision of the stiffness.
"""

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from ehl.common.arrays import BoolArray, FloatArray, IntArray
from ehl.common.errors import ConvergenceError

CORNERS_AND_EDGES = np.array([p for p in product((-1, 0, 1), repeat=3) if p.count(0) <= 1])
"""Positions of the nodes in the cube from -1 to 1, (20, 3): corners and middles of edges."""
FACE = np.flatnonzero(CORNERS_AND_EDGES[:, 1] == -1)
"""Nodes of the face with the second coordinate -1."""
# largest number of elements of a part that is not split
_LEAF = 48


def shape_functions(places: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values (p, 20) and derivatives (p, 20, 3) of the shape functions at points (p, 3) of the cube."""
    x, node = places[:, None, :], CORNERS_AND_EDGES.astype(float)
    middle = node == 0.0
    factor = np.where(middle, 1.0 - x**2, 1.0 + x * node)
    slope = np.where(middle, -2.0 * x, node + 0.0 * x)
    corner = ~middle.any(axis=1)
    last = np.where(corner, np.sum(x * node, axis=2) - 2.0, 1.0)
    scale = np.where(corner, 0.125, 0.25)
    whole = factor.prod(axis=2) * scale
    slopes = []
    for axis in range(3):
        others = np.delete(factor, axis, axis=2).prod(axis=2) * scale
        slopes.append(others * slope[..., axis] * last + np.where(corner, whole * node[:, axis], 0.0))
    return whole * last, np.stack(slopes, axis=-1)


Real = NDArray[np.floating[Any]]
"""Array of numbers of single or double precision."""
Precision = type[np.floating[Any]]


def element_stiffness(
    corners: FloatArray, youngs_modulus: FloatArray, poisson_ratio: float, precision: Precision = np.float64
) -> Real:
    """Stiffness (e, 60, 60) of elements from their nodes (e, 20, 3) [m] and Young's moduli (e,) [Pa].

    The unknowns are ordered by node; `precision` is that of the result. Raises `ConvergenceError` for a folded element.
    """
    points, factors = np.polynomial.legendre.leggauss(3)
    places = np.stack([x.ravel() for x in np.meshgrid(points, points, points, indexing="ij")], axis=-1)
    weights = np.einsum("i,j,k->ijk", factors, factors, factors).ravel()
    _, slopes = shape_functions(places)
    jacobian = np.matmul(slopes.transpose(0, 2, 1)[None], corners[:, None])
    volume = np.linalg.det(jacobian)
    if np.any(volume * np.sign(volume[:, :1]) <= 0.0):
        folded = "finite elements of the tooth root are folded: change the edge radius of the cutter"
        raise ConvergenceError("root_folded", folded)
    gradient = np.matmul(np.linalg.inv(jacobian), slopes.transpose(0, 2, 1)[None])
    gradient *= np.sqrt(np.abs(volume) * weights)[..., None, None]
    flat = gradient.reshape(*gradient.shape[:2], 60).astype(precision)
    gram = np.matmul(flat.transpose(0, 2, 1), flat).reshape(-1, 3, 20, 3, 20)
    shear = (youngs_modulus / (2.0 * (1.0 + poisson_ratio))).astype(precision)[:, None, None, None, None]
    lame = shear * 2.0 * poisson_ratio / (1.0 - 2.0 * poisson_ratio)
    matrix = lame * gram + shear * gram.transpose(0, 3, 2, 1, 4)
    trace = shear[:, 0, :, 0] * np.einsum("einim->enm", gram)
    for axis in range(3):
        matrix[:, axis, :, axis] += trace
    return np.ascontiguousarray(matrix.transpose(0, 2, 1, 4, 3)).reshape(-1, 60, 60)


@dataclass(frozen=True)
class _Front:
    """A part of the body, condensed onto its shared nodes."""

    nodes: IntArray  # nodes of the border
    count: IntArray  # number of elements of the part at each node
    stiffness: Real


@dataclass(frozen=True)
class _Step:
    """Unknowns eliminated from a front."""

    inner: IntArray
    outer: IntArray
    factor: Real  # lower Cholesky factor of the inner block
    coupling: Real  # factor^-1 times the block inner, outer


class Factors:
    """Cholesky factors of a body condensed onto some of its nodes.

    elements (e, 20): nodes of the elements.
    stiffness (e, 60, 60)
    places (e, 3): centres of the elements for the bisection, in element lengths.
    kept (n,): nodes that remain.
    held (n,): nodes without displacement.
    border (m,): the remaining nodes.
    stiffness (3 m, 3 m): condensed stiffness [N/m].
    """

    def __init__(
        self, elements: IntArray, stiffness: Real, places: FloatArray, kept: BoolArray, held: BoolArray
    ) -> None:
        self._kept, self._held = kept, held
        self._total = np.bincount(elements.ravel(), minlength=kept.size)
        self._at = np.empty(kept.size, np.int64)
        self._steps: list[_Step] = []
        front = self._condensed(elements, stiffness, places)
        self.border, self.stiffness = front.nodes, front.stiffness

    def _condensed(self, elements: IntArray, stiffness: Real, places: FloatArray) -> _Front:
        if len(elements) <= _LEAF:
            nodes, count = np.unique(elements, return_counts=True)
            free = ~self._held[nodes]
            nodes, count, leave = self._ordered(nodes[free], count[free])
            matrix = np.zeros((3 * nodes.size + 1,) * 2, stiffness.dtype)
            self._at[:] = -1
            self._at[nodes] = np.arange(nodes.size)
            for element, own in zip(elements, stiffness, strict=True):
                at = self._at[element]
                unknowns = np.where((at >= 0)[:, None], 3 * at[:, None] + np.arange(3), 3 * nodes.size).ravel()
                matrix[unknowns[:, None], unknowns] += own
            return self._eliminated(_Front(nodes, count, matrix[:-1, :-1]), leave)
        # whole rows of elements on one side
        values = places[:, int(np.argmax(np.ptp(places, axis=0)))]
        order = np.argsort(values, kind="stable")
        half = int(np.searchsorted(values[order], values[order[order.size // 2]] - 1e-9))
        half = half if half > order.size // 4 else order.size // 2
        parts = [self._condensed(elements[own], stiffness[own], places[own]) for own in (order[:half], order[half:])]
        nodes, where = np.unique(np.concatenate([part.nodes for part in parts]), return_inverse=True)
        count = np.bincount(where, np.concatenate([part.count for part in parts])).astype(np.int64)
        nodes, count, leave = self._ordered(nodes, count)
        matrix = np.zeros((3 * nodes.size,) * 2, stiffness.dtype)
        self._at[nodes] = np.arange(nodes.size)
        for part in parts:
            unknowns = degrees_of_freedom(self._at[part.nodes])
            # row by row is faster than two indices of the whole
            for row, own in zip(unknowns.tolist(), part.stiffness, strict=True):
                matrix[row][unknowns] += own
        return self._eliminated(_Front(nodes, count, matrix), leave)

    def _ordered(self, nodes: IntArray, count: IntArray) -> tuple[IntArray, IntArray, int]:
        """Nodes and counts, first those without elements of another part, and the number of these."""
        done = (count == self._total[nodes]) & ~self._kept[nodes]
        order = np.concatenate([np.flatnonzero(done), np.flatnonzero(~done)])
        return nodes[order], count[order], int(done.sum())

    def _eliminated(self, front: _Front, leave: int) -> _Front:
        if not leave:
            return front
        size = 3 * leave
        try:
            factor = scipy.linalg.cholesky(front.stiffness[:size, :size], lower=True, check_finite=False)
        except scipy.linalg.LinAlgError as error:
            raise ConvergenceError("tooth_not_held", "the stiffness of the tooth is not positive definite") from error
        coupling = scipy.linalg.solve_triangular(factor, front.stiffness[:size, size:], lower=True, check_finite=False)
        rest = front.stiffness[size:, size:]
        rest -= coupling.T @ coupling
        self._steps.append(
            _Step(degrees_of_freedom(front.nodes[:leave]), degrees_of_freedom(front.nodes[leave:]), factor, coupling)
        )
        return _Front(front.nodes[leave:], front.count[leave:], rest)

    def condensed_load(self, force: Real) -> Real:
        """Forces (3 n, k), in place: condensed on the border, after forward substitution elsewhere."""
        for step in self._steps:
            part = force[step.inner]
            if not part.any():
                continue
            part = scipy.linalg.solve_triangular(step.factor, part, lower=True, check_finite=False)
            force[step.inner] = part
            force[step.outer] -= step.coupling.T @ part
        return force

    def displacement(self, reduced: Real, wanted: BoolArray) -> Real:
        """Displacement (3 n, k), in place, from forward-substituted forces and the displacement of the border.

        Only that of the wanted nodes (n,) is complete.
        """
        needed = np.repeat(wanted, 3)
        steps = []
        for step in self._steps:
            if needed[step.inner].any():
                needed[step.outer] = True
                steps.append(step)
        for step in reversed(steps):
            part = reduced[step.inner] - step.coupling @ reduced[step.outer]
            reduced[step.inner] = scipy.linalg.solve_triangular(
                step.factor, part, lower=True, trans="T", check_finite=False
            )
        return reduced


def degrees_of_freedom(nodes: IntArray) -> IntArray:
    """Numbers of the three unknowns of each node."""
    return np.asarray((3 * nodes[:, None] + np.arange(3)).ravel())
