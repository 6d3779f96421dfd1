"""Smooth fields on a rectangle by Chebyshev polynomials, and curves of piecewise cubics.

Polynomials have exact derivatives and an error estimate from their highest coefficients. A field given on the whole
rectangle is interpolated. If a part is missing (undercut) or the points are scattered (a measured grid), the
polynomials are fitted by least squares to more points than coefficients. Combinations of coefficients that the points
do not determine are set to zero by the rank of the system. Inside the region of the points this converges like
interpolation; values outside it are meaningless.

The piecewise cubics replace those of ``scipy.interpolate``, whose import takes longer than computing the geometry of a
pair.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import scipy
from numpy.polynomial import chebyshev

from efficiency.cutting.newton import Array
from ehl.common.arrays import FloatArray

Range = tuple[float, float]
# relative size of pivots below which the points do not determine a direction
_RANK = 1e-13


@lru_cache(maxsize=32)
def _derivative(count: int) -> FloatArray:
    """Matrix from Chebyshev coefficients to those of the derivative, (count, count)."""
    matrix: FloatArray = np.zeros((count, count))
    if count > 1:
        matrix[:-1] = chebyshev.chebder(np.eye(count), axis=0)
    return matrix


@lru_cache(maxsize=32)
def _interpolation(count: int) -> FloatArray:
    """Matrix from values at the Chebyshev points to coefficients, (count, count)."""
    return np.asarray(np.linalg.inv(chebyshev.chebvander(chebyshev.chebpts1(count), count - 1)))


@dataclass(frozen=True)
class Patch:
    """Several scalar fields over ``u_range x v_range``."""

    names: tuple[str, ...]  # names of the fields, in the order of the last axis of `coefficients`
    # rectangle
    u_range: Range
    v_range: Range
    coefficients: FloatArray  # (nu, nv, k) tensor Chebyshev coefficients

    @staticmethod
    def nodes(u_range: Range, v_range: Range, shape: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
        """Chebyshev points of the rectangle, flattened with v as the inner index; both (nu nv,)."""
        axes = []
        for (low, high), count in zip((u_range, v_range), shape, strict=True):
            axes.append(0.5 * (low + high) + 0.5 * (high - low) * chebyshev.chebpts1(count))
        u, v = np.meshgrid(*axes, indexing="ij")
        return u.ravel(), v.ravel()

    @classmethod
    def fit(cls, u_range: Range, v_range: Range, shape: tuple[int, int], fields: dict[str, FloatArray]) -> Patch:
        """Interpolate values given at `nodes`, each (nu nv,)."""
        values = np.stack(list(fields.values()), axis=-1).reshape(*shape, len(fields))
        for axis, count in enumerate(shape):
            values = np.moveaxis(np.tensordot(_interpolation(count), values, axes=(1, axis)), 0, axis)
        return cls(tuple(fields), u_range, v_range, values)

    def joined(self, other: Patch) -> Patch:
        """The fields of two patches over the same rectangle with the same shape."""
        return replace(
            self,
            names=self.names + other.names,
            coefficients=np.concatenate([self.coefficients, other.coefficients], axis=-1),
        )

    def lowered(self, shape: tuple[int, int]) -> Patch:
        """The fields without their highest coefficients; for values at nodes, the least-squares fit of that shape."""
        return replace(self, coefficients=self.coefficients[: shape[0], : shape[1]])

    def raised(self, shape: tuple[int, int]) -> Patch:
        """The fields with additional zero coefficients."""
        more = [(0, new - old) for new, old in zip(shape, self.shape, strict=True)]
        return replace(self, coefficients=np.pad(self.coefficients, [*more, (0, 0)]))

    @property
    def shape(self) -> tuple[int, int]:
        """Number of Chebyshev nodes along u and v."""
        return self.coefficients.shape[0], self.coefficients.shape[1]

    @property
    def tail(self) -> dict[str, float]:
        """Interpolation error estimate of each field: the sum of its highest coefficients in both directions."""
        size = np.abs(self.coefficients)
        rim = size[-2:, :].sum(axis=(0, 1)) + size[:-2, -2:].sum(axis=(0, 1))
        return dict(zip(self.names, rim.tolist(), strict=True))

    def __call__(self, u: FloatArray, v: FloatArray, names: tuple[str, ...], du: int = 0, dv: int = 0) -> FloatArray:
        """Values, or derivatives of order `du`, `dv`, of named fields at n points, (len(names), n).

        Outside the rectangle the polynomials are extrapolated.
        """
        along, over = self._basis(u, v, du, dv)
        return np.asarray(np.real(self._sum(along, over, names)), dtype=np.float64)

    def matrix(self, u: FloatArray, v: FloatArray, du: int = 0, dv: int = 0) -> FloatArray:
        """Values, or derivatives of order `du`, `dv`, of the products of polynomials at n points, (n, nu nv)."""
        along, over = self._basis(u, v, du, dv)
        return np.asarray(along.T[:, :, None] * over.T[:, None, :], np.float64).reshape(u.size, -1)

    def slopes(self, u: Array, v: Array, names: tuple[str, ...]) -> tuple[Array, Array, Array]:
        """Values and first derivatives along u and v at n points, real or complex, each (len(names), n)."""
        along, over = self._basis(u, v, 0, 0)
        scale_u, scale_v = self._scales
        along_u = (_derivative(along.shape[0]) * scale_u).T @ along
        over_v = (_derivative(over.shape[0]) * scale_v).T @ over
        return self._sum(along, over, names), self._sum(along_u, over, names), self._sum(along, over_v, names)

    @property
    def _scales(self) -> tuple[float, float]:
        return 2.0 / (self.u_range[1] - self.u_range[0]), 2.0 / (self.v_range[1] - self.v_range[0])

    def _basis(self, u: Array, v: Array, du: int, dv: int) -> tuple[Array, Array]:
        """Chebyshev polynomials (or their derivatives) of both directions at n points, (nu, n) and (nv, n)."""
        basis = []
        for at, order, (low, _), scale, count in zip(
            (u, v), (du, dv), (self.u_range, self.v_range), self._scales, self.shape, strict=True
        ):
            rows = chebyshev.chebvander((np.asarray(at) - low) * scale - 1.0, count - 1).T
            for _ in range(order):
                rows = (_derivative(count) * scale).T @ rows
            basis.append(rows)
        return basis[0], basis[1]

    def _sum(self, along: Array, over: Array, names: tuple[str, ...]) -> Array:
        chosen = self.coefficients.T[[self.names.index(name) for name in names]]
        first = chosen.reshape(-1, along.shape[0]) @ along
        return np.asarray(np.einsum("kbn,bn->kn", first.reshape(len(names), *over.shape), over))


class PointFit:
    """Least-squares fit of patches to values at fixed points (n,), recommended twice as many as coefficients."""

    def __init__(self, u_range: Range, v_range: Range, shape: tuple[int, int], u: FloatArray, v: FloatArray) -> None:
        self._empty = Patch(("none",), u_range, v_range, np.zeros((*shape, 1)))
        matrix = self._empty.matrix(u, v)
        self._basis, triangle, self._order = scipy.linalg.qr(matrix, mode="economic", pivoting=True, check_finite=False)
        size = np.abs(np.diag(triangle))
        self._rank = int(np.count_nonzero(size > _RANK * size[0]))
        self._triangle = triangle[: self._rank, : self._rank]

    def __call__(self, fields: dict[str, FloatArray]) -> Patch:
        """Patch of values at the points."""
        values = np.stack(list(fields.values()), axis=-1)
        solution = np.zeros((self._order.size, values.shape[1]))
        right = (self._basis.T @ values)[: self._rank]
        solution[self._order[: self._rank]] = scipy.linalg.solve_triangular(self._triangle, right, check_finite=False)
        shape = (*self._empty.shape, len(fields))
        return replace(self._empty, names=tuple(fields), coefficients=solution.reshape(shape))


def cubic_spline(x: FloatArray, y: FloatArray, at: FloatArray) -> FloatArray:
    """Not-a-knot cubic spline, extrapolated: its third derivative is continuous at the points next to both ends.

    At least four increasing x (n,) with values y (..., n); values at `at` (m,) are (..., m).
    """
    step = np.diff(x)
    secant = np.diff(y) / step
    matrix, right = np.zeros((x.size, x.size)), np.empty_like(y)
    # the second derivative is continuous
    row = np.arange(1, x.size - 1)
    matrix[row, row - 1], matrix[row, row] = step[1:], 2.0 * (step[:-1] + step[1:])
    matrix[row, row + 1] = step[:-1]
    right[..., 1:-1] = 3.0 * (step[1:] * secant[..., :-1] + step[:-1] * secant[..., 1:])
    for end, away in ((0, 1), (-1, -2)):
        near, far = step[end], step[away]
        matrix[end, end], matrix[end, away] = far, near + far
        right[..., end] = (near + 2.0 * (near + far)) * far * secant[..., end] + near**2 * secant[..., away]
        right[..., end] /= near + far
    slopes = np.asarray(np.linalg.solve(matrix, right.reshape(-1, x.size).T)).T.reshape(y.shape)
    return _hermite(x, y, slopes, at)


def akima_curve(x: FloatArray, y: FloatArray, at: FloatArray) -> FloatArray:
    """Modified Akima interpolation: slopes from the four secants around each point, so that kinks remain local.

    Akima (1970), J. ACM 17, 589 (unverified); the weights ``|m4 - m3| + |m4 + m3|/2`` keep flat parts flat. The result
    is nan outside the points.
    """
    secant = np.diff(y) / np.diff(x)
    # two additional secants at each end, by parabolic extrapolation
    front = 2.0 * secant[0] - secant[1]
    back = 2.0 * secant[-1] - secant[-2]
    m = np.concatenate([[2.0 * front - secant[0], front], secant, [back, 2.0 * back - secant[-1]]])
    weight = np.abs(np.diff(m)) + 0.5 * np.abs(m[1:] + m[:-1])
    after, before = weight[2:], weight[:-2]
    total = after + before
    even = total <= 1e-9 * total.max(initial=0.0)
    slopes = np.where(even, 0.5 * (m[3:] + m[:-3]), after * m[1:-2] + before * m[2:-1]) / np.where(even, 1.0, total)
    return np.where((at >= x[0]) & (at <= x[-1]), _hermite(x, y, slopes, at), np.nan)


def _hermite(x: FloatArray, y: FloatArray, slopes: FloatArray, at: FloatArray) -> FloatArray:
    """Cubics with given values and slopes at their ends, the outermost ones extrapolated."""
    piece = np.clip(np.searchsorted(x, at, side="right") - 1, 0, x.size - 2)
    step = np.diff(x)[piece]
    rise, t = (y[..., 1:] - y[..., :-1])[..., piece], (at - x[piece]) / step
    first, last = slopes[..., piece] * step, slopes[..., piece + 1] * step
    bend = first + last - 2.0 * rise
    return np.asarray(y[..., piece] + t * (first + t * (rise - first - bend * (1.0 - t))))
