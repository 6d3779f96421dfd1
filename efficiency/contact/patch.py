"""Smooth fields on a rectangle by Chebyshev interpolation: exact derivatives, error estimate from the tail."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Patch:
    """Several scalar fields over ``u_range x v_range``.

    Attributes
    ----------
    names : tuple of str
        Names of the fields, in the order of the last axis of `coefficients`.
    u_range, v_range : (float, float)
        The rectangle.
    coefficients : (nu, nv, k) array
        Tensor Chebyshev coefficients.
    """

    names: tuple[str, ...]
    u_range: tuple[float, float]
    v_range: tuple[float, float]
    coefficients: FloatArray

    @staticmethod
    def nodes(
        u_range: tuple[float, float], v_range: tuple[float, float], shape: tuple[int, int]
    ) -> tuple[FloatArray, FloatArray]:
        """Chebyshev points of the rectangle, flattened with v running fastest; both (nu nv,)."""
        axes = []
        for (low, high), count in zip((u_range, v_range), shape, strict=True):
            axes.append(0.5 * (low + high) + 0.5 * (high - low) * chebyshev.chebpts1(count))
        u, v = np.meshgrid(*axes, indexing="ij")
        return u.ravel(), v.ravel()

    @classmethod
    def fit(
        cls,
        u_range: tuple[float, float],
        v_range: tuple[float, float],
        shape: tuple[int, int],
        fields: dict[str, FloatArray],
    ) -> Patch:
        """Interpolate values given at `nodes`, each (nu nv,)."""
        values = np.stack(list(fields.values()), axis=-1).reshape(*shape, len(fields))
        for axis, count in enumerate(shape):
            matrix = chebyshev.chebvander(chebyshev.chebpts1(count), count - 1)
            values = np.moveaxis(np.tensordot(np.linalg.inv(matrix), values, axes=(1, axis)), 0, axis)
        return cls(tuple(fields), u_range, v_range, values)

    def extended(self, fields: dict[str, FloatArray]) -> Patch:
        """The same patch with more fields, given at its nodes."""
        more = Patch.fit(self.u_range, self.v_range, self.shape, fields)
        joined = np.concatenate([self.coefficients, more.coefficients], axis=-1)
        return replace(self, names=self.names + more.names, coefficients=joined)

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
        """Values or derivatives of some fields at n points.

        Parameters
        ----------
        u, v : (n,) arrays
            Points; outside the rectangle the polynomials are continued.
        names : tuple of str
            Fields wanted.
        du, dv : int
            Order of the derivative along u and v.

        Returns
        -------
        (len(names), n) array
        """
        c = self.coefficients[:, :, [self.names.index(name) for name in names]]
        basis = []
        for axis, (order, (low, high), at) in enumerate(
            ((du, self.u_range, u), (dv, self.v_range, v)),
        ):
            scale = 2.0 / (high - low)
            if order:
                c = np.asarray(chebyshev.chebder(c, order, scl=scale, axis=axis), dtype=np.float64)
            basis.append(chebyshev.chebvander((np.asarray(at) - low) * scale - 1.0, c.shape[axis] - 1))
        first = np.tensordot(basis[0], c, axes=(1, 0))
        return np.asarray(np.einsum("nbk,nb->kn", first, basis[1]))
