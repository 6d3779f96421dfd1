"""Newton's method for many small systems at once, with Jacobians by complex step (exact to rounding)."""

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ehl.common.arrays import FloatArray

# real or complex
Array = NDArray[np.inexact[Any]]
AnyArray = TypeVar("AnyArray", NDArray[np.float64], Array)

_STEP = 1e-30
_STALLED = 4


def complex_jacobian(function: Callable[[Array], Array], x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Value and Jacobian of a holomorphic function at many points.

    function: maps (m, n) to (k, n): n independent points with m unknowns each.
    x (m, n): points.
    """
    columns = []
    value: FloatArray | None = None
    for i in range(x.shape[0]):
        shifted = x.astype(np.complex128)
        shifted[i] += 1j * _STEP
        moved = function(shifted)
        columns.append(np.asarray(moved.imag / _STEP, dtype=np.float64))
        if value is None:
            value = np.asarray(moved.real, dtype=np.float64)
    assert value is not None
    return value, np.moveaxis(np.stack(columns, axis=-1), 0, 1)


def iterate(
    linearise: Callable[[FloatArray], tuple[FloatArray, FloatArray]],
    start: FloatArray,
    step_limit: FloatArray,
    tolerance: FloatArray,
    max_iterations: int = 30,
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Newton's method at n points together; returns the points and a mask of converged ones.

    linearise: value (m, n) and Jacobian (n, m, m) of the function at x (m, n).
    start (m, n): starting points.
    step_limit (m,): largest step of each unknown in one iteration.
    tolerance (m,): a point has converged if its last step is below this value in every unknown.
    max_iterations: maximum number of iterations.
    """
    x = np.array(start, dtype=np.float64)
    done = np.zeros(x.shape[1], dtype=bool)
    most, stalled = 0, 0
    for _ in range(max_iterations):
        value, jacobian = linearise(x)
        # a singular point is not moved and remains marked as not converged
        scale = np.abs(np.linalg.det(jacobian / np.abs(jacobian).max(axis=2, keepdims=True).clip(1e-300)))
        regular = np.isfinite(value).all(axis=0) & (scale > 1e-13)
        step = np.zeros_like(x)
        if regular.any():
            step[:, regular] = np.linalg.solve(jacobian[regular], value[:, regular].T[..., None])[..., 0].T
        shrink = np.minimum(1.0, (step_limit[:, None] / np.abs(step).clip(1e-300)).min(axis=0))
        x -= shrink * step
        done = regular & (np.abs(step) <= tolerance[:, None]).all(axis=0)
        # if no further point converges for several iterations, the others have no solution (undercut)
        stalled = stalled + 1 if int(done.sum()) <= most else 0
        most = max(most, int(done.sum()))
        if done.all() or (most and stalled >= _STALLED):
            break
    return x, done
