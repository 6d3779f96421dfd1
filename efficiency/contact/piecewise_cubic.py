"""Curves of piecewise cubics through given points, by their slopes there.

They are those of ``scipy.interpolate``, which takes longer to load than the geometry of a pair to compute.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def cubic_spline(x: FloatArray, y: FloatArray, at: FloatArray) -> FloatArray:
    """Cubic spline whose third derivative is continuous at the points next to both ends (not-a-knot), continued.

    Parameters
    ----------
    x : (n,) array
        Increasing, at least four.
    y : (..., n) array
        Values.
    at : (m,) array
        Where the spline is wanted.

    Returns
    -------
    (..., m) array
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
        right[..., end] = ((near + 2.0 * (near + far)) * far * secant[..., end] + near**2 * secant[..., away]) / (
            near + far
        )
    slopes = np.asarray(np.linalg.solve(matrix, right.reshape(-1, x.size).T)).T.reshape(y.shape)
    return _hermite(x, y, slopes, at)


def akima_curve(x: FloatArray, y: FloatArray, at: FloatArray) -> FloatArray:
    """Modified Akima interpolation: slopes from the four secants around each point, so that a kink stays where it is.

    Akima (1970), J. ACM 17, 589 (from memory); the weights ``|m4 - m3| + |m4 + m3|/2`` keep flat parts flat.

    Parameters
    ----------
    x, y : (n,) arrays
        Points, x increasing.
    at : (m,) array
        Where the curve is wanted.

    Returns
    -------
    (m,) array
        nan outside the points.
    """
    secant = np.diff(y) / np.diff(x)
    # two more secants at each end, on a parabola
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
    """Cubics with given values and slopes at their ends, the outermost ones continued."""
    piece = np.clip(np.searchsorted(x, at, side="right") - 1, 0, x.size - 2)
    step = np.diff(x)[piece]
    rise, t = (y[..., 1:] - y[..., :-1])[..., piece], (at - x[piece]) / step
    first, last = slopes[..., piece] * step, slopes[..., piece + 1] * step
    bend = first + last - 2.0 * rise
    return np.asarray(y[..., piece] + t * (first + t * (rise - first - bend * (1.0 - t))))
