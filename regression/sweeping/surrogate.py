"""A Gaussian process over the points of a plan: ln mu, and where it is least certain.

Linear trend and process on the transformed inputs (the unit cube of the plan's ranges, and the logarithm of the film
ratio); hyperparameters by maximum likelihood. Leave-one-out residuals are exact for fixed hyperparameters (Rasmussen &
Williams 2006, eq. 5.12).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from regression.friction.gaussian_process import matern

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# points the hyperparameters are found with; the process itself takes all
FIT_POINTS = 400
# noise over signal of a case without result: its neighbourhood counts as nearly visited, without a value
FAILED_NOISE = 0.1
# weight of the overall success rate, in cases, against that of the neighbours
PRIOR_CASES = 0.1


@dataclass(frozen=True)
class FrictionSurrogate:
    """A fitted process.

    Parameters
    ----------
    inputs : (n, d) array
        Standardised inputs of all points, those without a result last.
    results : int
        How many have a result.
    scales : (d,) array
        Length scales.
    signal : float
        Variance of the process.
    noise : (n,) array
        Variance of the noise at each point.
    residual : (results,) array
        Leave-one-out errors of ln mu.
    """

    inputs: Array
    results: int
    scales: Array
    signal: float
    noise: Array
    residual: Array

    def correlation(self, a: Array, b: Array) -> Array:
        """Matern 5/2 correlation between two sets of points, shape (len(a), len(b))."""
        return matern(a, b, self.scales, 1.0)

    def covariance(self, points: Array) -> Array:
        """Covariance of ln mu at new points, given all points known: (m, m)."""
        cross = self.signal * self.correlation(self.inputs, points)
        known = self.signal * self.correlation(self.inputs, self.inputs) + np.diag(self.noise)
        return np.asarray(
            self.signal * self.correlation(points, points) - cross.T @ cho_solve(cho_factor(known), cross)
        )

    def success_probability(self, points: Array) -> Array:
        """Probability of a result at new points: the share of results among their neighbours, shrunk to that of all."""
        count, dimension = self.inputs.shape
        # as far as points of an even filling are apart
        near = matern(points, self.inputs, np.full(dimension, count ** (-1.0 / dimension)), 1.0)
        rate = self.results / count
        return np.asarray((PRIOR_CASES * rate + near[:, : self.results].sum(axis=1)) / (PRIOR_CASES + near.sum(axis=1)))


def fit_surrogate(inputs: Array, log_mu: Array, own_error: Array, failed: Array) -> FrictionSurrogate:
    """Fit the process to the points with a result.

    Parameters
    ----------
    inputs : (n, d) array
        Of the points with a result.
    log_mu : (n,) array
        ln mu there.
    own_error : (n,) array
        Relative error each result states of itself; its square is noise.
    failed : (k, d) array
        Inputs of the points without a result.
    """
    import warnings

    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

    design = np.column_stack([np.ones(len(inputs)), inputs])
    trend, *_ = np.linalg.lstsq(design, log_mu, rcond=None)
    residual = log_mu - design @ trend
    spread = float(residual.std()) or 1.0
    y = residual / spread
    stated = (own_error / spread) ** 2
    dimension = inputs.shape[1]
    kernel = ConstantKernel(1.0, (1e-2, 1e2)) * Matern(np.ones(dimension), (0.05, 50.0), nu=2.5) + WhiteKernel(
        1e-3, (1e-8, 1.0)
    )
    # a fixed choice: the same data give the same process
    chosen = np.random.default_rng(0).permutation(len(inputs))[:FIT_POINTS]
    process = GaussianProcessRegressor(kernel, alpha=1e-10 + stated[chosen], random_state=0)
    with warnings.catch_warnings():
        # a length scale at its bound means that the variable has no influence
        warnings.simplefilter("ignore", ConvergenceWarning)
        process.fit(inputs[chosen], y[chosen])
    found = process.kernel_
    signal, white = float(found.k1.k1.constant_value), float(found.k2.noise_level)
    scales = np.broadcast_to(np.asarray(found.k1.k2.length_scale, dtype=float), (dimension,)).copy()
    noise = np.concatenate([white + 1e-10 + stated, np.full(len(failed), FAILED_NOISE * signal)])
    everything = np.vstack([inputs, failed]) if len(failed) else inputs
    surrogate = FrictionSurrogate(everything, len(inputs), scales, signal, noise, y)
    known = signal * surrogate.correlation(inputs, inputs) + np.diag(noise[: len(inputs)])
    inverse = np.linalg.inv(known)
    left_out = spread * (inverse @ y) / np.diag(inverse)
    return FrictionSurrogate(
        everything, len(inputs), scales, signal * spread**2, noise * spread**2, np.asarray(left_out)
    )


def choose_batch(surrogate: FrictionSurrogate, candidates: Array, weight: Array, size: int) -> list[int]:
    """Indices of the candidates that lower the weighted variance where it is largest, one after the other.

    A point that is chosen counts as known for the next: its variance falls and that of its neighbours with it, so that
    a batch does not crowd. Where cases fail, the probability of a result lowers the score.

    Parameters
    ----------
    surrogate : FrictionSurrogate
        What is known.
    candidates : (m, d) array
        Standardised inputs.
    weight : (m,) array
        What the variance counts for at each.
    size : int
        How many are chosen; at most m.
    """
    covariance = surrogate.covariance(candidates)
    value = weight * surrogate.success_probability(candidates)
    noise = float(np.median(surrogate.noise[: surrogate.results]))
    open_ = np.ones(len(candidates), dtype=bool)
    chosen: list[int] = []
    for _ in range(min(size, len(candidates))):
        score = np.where(open_, value * np.diag(covariance), -np.inf)
        best = int(np.argmax(score))
        chosen.append(best)
        open_[best] = False
        column = covariance[:, best].copy()
        covariance -= np.outer(column, column) / (column[best] + noise)
    return chosen
