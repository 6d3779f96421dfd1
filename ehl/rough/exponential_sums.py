"""Sums of exponentials for the logarithmic kernel of elasticity and the inverse-root kernel of heat conduction.

The integrated influence coefficients of the line contact, ``K_d = -int ln|d - s| ds`` over one cell, are a
logarithm of the distance plus a constant. The constant is a rigid shift of the gap, which the approach of the bodies
compensates. It may be chosen freely but must be the same in all operators of one gap: ``kernel_constant(n)``.

With ``K_d ~ sum_m w_m phi_m^d`` a product ``K q`` is two first-order recursions per mode, and the Newton matrix is
quasi-separable. One mode has ``phi = 0``, which makes ``K_0`` exact.
"""

import json
import math
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.resources import files
from itertools import product, starmap

import numpy as np
from scipy.optimize import OptimizeResult, least_squares, nnls
from scipy.special import iti0k0

from ehl.common.arrays import FloatArray


@dataclass(frozen=True)
class ExponentialSum:
    """``sum_m weights_m ratios_m^d`` for d = 0, 1, ..."""

    # the last ratio is zero; shape (modes,)
    weights: FloatArray
    ratios: FloatArray
    # largest deviation from the kernel over the fitted range: absolute (unit of the kernel) for the logarithm, relative
    # for the inverse root
    error: float

    def evaluate(self, distance: FloatArray) -> FloatArray:
        """The sum at whole-number distances."""
        return np.asarray(np.power.outer(self.ratios, distance).T @ self.weights)


FASTEST_RATE = 4.0  # of a long sum, per node


def kernel_constant(n: int) -> float:
    """Constant added to the logarithmic coefficients of n nodes, n a power of two: ln n + 1.3 (own choice).

    The fit requires a kernel that decays over the range; 1.3 is near the optimum for 10 to 14 modes.
    """
    return float(np.log(n) + 1.3)


def log_coefficients(n: int) -> FloatArray:
    """``-int ln|d - s| ds`` over the unit cell around s = 0, for d = 0 .. n-1 (no constant added)."""
    d = np.arange(n, dtype=float)
    above, below = d + 0.5, d - 0.5
    return -(above * (np.log(above) - 1.0) - below * (np.log(np.abs(below)) - 1.0))


def range_of(n: int) -> int:
    """Fitted range for n nodes: the next power of two."""
    return 1 << max(n - 1, 63).bit_length()


@cache
def _tabulated() -> dict[str, ExponentialSum]:
    """Fits of `validation/log_kernel_table.py`, by nodes and modes."""
    text = files("ehl.rough").joinpath("log_kernel.json").read_text(encoding="utf-8")
    return {
        name: ExponentialSum(np.array(fit["weights"]), np.array(fit["ratios"]), fit["error"])
        for name, fit in json.loads(text).items()
    }


def log_kernel(n: int, modes: int) -> ExponentialSum:
    """`fit_log_kernel` from a table, identical in every process; fitted where the table has no entry."""
    return _tabulated().get(f"{n} {modes}") or fit_log_kernel(n, modes)


@lru_cache(maxsize=32)
def fit_log_kernel(n: int, modes: int) -> ExponentialSum:
    """Fit ``log_coefficients(n) + kernel_constant(n)``; n a power of two (`range_of`).

    The logarithms of weights and decay rates are fitted by Levenberg-Marquardt from several geometric starts. All
    weights but that of ratio zero are positive because the integrated logarithm is completely monotone.
    """
    kernel = log_coefficients(n) + kernel_constant(n)
    d = np.unique(np.concatenate([np.arange(1, min(n, 20)), np.round(np.geomspace(min(20, n - 1), n - 1, 300))]))
    target = kernel[d.astype(int)]
    m = modes - 1

    def unpack(z: FloatArray) -> tuple[FloatArray, FloatArray]:
        return np.exp(np.clip(z[:m], -40.0, 25.0)), np.exp(np.clip(z[m:], -14.0, 2.6))

    def residual(z: FloatArray) -> FloatArray:
        weights, rates = unpack(z)
        return np.asarray(np.exp(-np.outer(d, rates)) @ weights - target)

    def jacobian(z: FloatArray) -> FloatArray:
        weights, rates = unpack(z)
        terms = np.exp(-np.outer(d, rates)) * weights
        return np.hstack([terms, -terms * d[:, None] * rates])

    def from_start(slow: float, fast: float) -> OptimizeResult:
        start = np.concatenate([np.full(m, np.log(np.log(4.0 * n) / m)), np.log(np.geomspace(slow / n, fast, m))])
        return least_squares(
            residual, start, jac=jacobian, method="lm", max_nfev=400, xtol=1e-12, ftol=1e-12, gtol=1e-12
        )

    best = min(starmap(from_start, product((0.2, 0.5), (1.0, 2.5))), key=lambda fit: fit.cost)
    weights, rates = unpack(best.x)
    order = np.argsort(rates)
    weights = np.append(weights[order], kernel[0] - weights.sum())
    ratios = np.append(np.exp(-rates[order]), 0.0)
    fitted = ExponentialSum(weights, ratios, 0.0)
    error = float(np.abs(fitted.evaluate(np.arange(n, dtype=float)) - kernel).max())
    return ExponentialSum(weights, ratios, error)


def bessel_kernel(wave_number: float, modes: int, newton_modes: int) -> tuple[ExponentialSum, ExponentialSum]:
    """``int K0(k |d - s|) ds`` over unit cells as a long sum of exponentials and as a short one for the Newton matrix.

    The trapezoidal rule turns K0(z) = int_0^inf exp(-z cosh t) dt (DLMF 10.32.9) into a sum of exponentials. The long
    sum has its rates, the short one geometric rates. The weights follow from non-negative least squares. One mode has
    the ratio zero, which makes the coefficient of distance 0 exact; `error` is the largest absolute deviation.

    wave_number: k times the node spacing [-].
    modes, newton_modes: of both sums, the mode of ratio zero included.
    """
    distance = np.unique(np.round(np.geomspace(1.0, max(12.0 / wave_number, 12.0), 120)))
    target = np.array([quad_bessel(wave_number, d) for d in distance])
    here = quad_bessel(wave_number, 0.0)

    def closed(weights: FloatArray, rates: FloatArray) -> ExponentialSum:
        ratios = np.exp(-rates)
        error = float(np.abs(np.power.outer(ratios, distance).T @ weights - target).max())
        return ExponentialSum(np.append(weights, here - weights.sum()), np.append(ratios, 0.0), error)

    step = math.acosh(max(FASTEST_RATE / wave_number, 1.5)) / (modes - 2)
    rates = wave_number * np.cosh(step * np.arange(modes - 1))
    weights = nnls(np.exp(-np.outer(distance, rates)), target)[0]
    long = closed(weights, rates)

    def short(slow: float, fast: float) -> ExponentialSum:
        rates = np.geomspace(slow * wave_number, max(fast, 3.0 * slow * wave_number), newton_modes - 1)
        return closed(nnls(np.exp(-np.outer(distance, rates)), target)[0], rates)

    return long, min(starmap(short, product((1.05, 1.2, 1.5), (0.5, 1.0, 2.0))), key=lambda fit: fit.error)


def quad_bessel(wave_number: float, distance: float) -> float:
    """``int K0(k |d - s|) ds`` over the unit cell around s = 0, from the integral of K0."""
    ends = [wave_number * (distance - 0.5), wave_number * (distance + 0.5)]
    lower, upper = (math.copysign(float(iti0k0(abs(z))[1]), z) for z in ends)
    return (upper - lower) / wave_number


@lru_cache(maxsize=32)
def fit_root_kernel(n: int, modes: int = 10) -> ExponentialSum:
    """``int_j^{j+1} dt/sqrt(t)``, j = 0 .. n-1, as a sum of exponentials in j (`error` is relative).

    Non-negative least squares over fixed geometric rates, the best of several sets of rates.
    """
    near = min(30, n)
    j = np.unique(np.concatenate([np.arange(1, near), np.round(np.geomspace(near, n, 200))])).astype(float)
    target = 2.0 / (np.sqrt(j + 1.0) + np.sqrt(j))

    def fitted(fast: float, slow: float) -> ExponentialSum:
        ratios = np.exp(-np.geomspace(slow / n, fast, modes - 1))
        terms = np.power.outer(ratios, j).T / target[:, None]
        weights, _ = nnls(terms, np.ones(j.size))
        error = float(np.abs(terms @ weights - 1.0).max())
        return ExponentialSum(np.append(weights, 2.0 - weights.sum()), np.append(ratios, 0.0), error)

    return min(starmap(fitted, product((1.0, 1.5, 2.0, 3.0), (0.3, 0.6, 1.0, 1.5))), key=lambda fit: fit.error)
