"""Huber loss: scale of the residuals, and covariance of the fitted parameters.

Huber (1981), Robust Statistics: psi(r) = clip(r, -c, c); covariance of an M-estimate of regression, section 7.6.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy import special, stats

from ehl.common.arrays import FloatArray

TUNING = 1.5  # c over the standard deviation: 96 % efficiency for Gaussian noise
FAR = 4.0  # standard deviations above which a residual is listed as an outlier


# E[psi'], E[psi^2] and sqrt(E[psi^2])/E[psi'] for standard normal residuals
PSI_SLOPE = 2.0 * float(stats.norm.cdf(TUNING)) - 1.0
PSI_SQUARED = PSI_SLOPE - 2.0 * TUNING * float(stats.norm.pdf(TUNING)) + TUNING**2 * (1.0 - PSI_SLOPE)
INEFFICIENCY = math.sqrt(PSI_SQUARED) / PSI_SLOPE
# factor that makes the increase of the loss chi-square distributed with one degree of freedom per parameter
DEVIANCE = 2.0 * PSI_SLOPE / PSI_SQUARED


def loss(standardised: FloatArray) -> float:
    """Sum of Huber's rho, r^2/2 within c and c|r| - c^2/2 beyond."""
    return float(np.sum(special.huber(TUNING, standardised)))


def spread(residuals: FloatArray, fitted: int) -> float:
    """Robust standard deviation of residuals about 0, 1.4826 times their median magnitude, for `fitted` parameters."""
    free = max(residuals.size - fitted, 1)
    return float(1.4826 * np.median(np.abs(residuals)) * math.sqrt(residuals.size / free))


@dataclass(frozen=True)
class Noise:
    """Scale of the residuals."""

    scale: float  # standard deviation over the stated one of each row; over 1 for estimated noise
    covariance_scale: float  # covariance over (J^T J)^-1 of the standardised problem
    chi_square: float  # sum of bounded squares over its expectation with the stated noise; nan for estimated noise
    quantile: float  # of the 95 % interval: Student's t with the free rows for estimated noise, else 1.96
    larger_than_stated: bool = False  # whether the stated noise is too small (p < 0.01) and the estimated one is used


def noise_of(residuals: FloatArray, fitted: int, *, stated: bool, tuned_to: float) -> Noise:
    """Scale of standardised residuals, and the factors for intervals.

    residuals (n,): over the stated standard deviation of each row (over 1 without).
    fitted: number of parameters.
    stated: whether the noise is stated.
    tuned_to: factor on Huber's c in the fit.
    """
    free = max(residuals.size - fitted, 1)
    psi = np.clip(residuals / tuned_to, -TUNING, TUNING)
    inside = float(np.mean(np.abs(residuals) < TUNING * tuned_to))
    inside = max(inside, 0.2)
    squares = float(np.sum(psi**2)) / free
    # Huber 1981, eq. 7.6.10: small-sample factor for the spread of psi'
    factor = 1.0 + fitted / residuals.size * (1.0 - inside) / inside
    estimated = factor**2 * squares / inside**2 * tuned_to**2
    student = float(stats.t.ppf(0.975, free))
    scale = tuned_to * math.sqrt(squares / PSI_SQUARED)
    if not stated:
        return Noise(scale, estimated, math.nan, student)
    chi = squares / PSI_SQUARED
    # psi^2 of a Gaussian has the variance E[psi^4] - E[psi^2]^2, which is below that of the chi-square distribution
    if chi > float(stats.chi2.ppf(0.99, free)) / free:
        return Noise(scale, estimated, chi, student, larger_than_stated=True)
    return Noise(1.0, INEFFICIENCY**2, chi, float(stats.norm.ppf(0.975)))


def serial_correlation(residuals: FloatArray, labels: tuple[str, ...]) -> tuple[float, float]:
    """Correlation of neighbours along the curves, and its 99 % quantile for independent residuals."""
    first, second = [], []
    for label in dict.fromkeys(labels):
        here = residuals[[i for i, other in enumerate(labels) if other == label]]
        first += list(here[:-1])
        second += list(here[1:])
    if len(first) < 8:
        return 0.0, 1.0
    a, b = np.array(first), np.array(second)
    spread_of = float(np.sqrt(np.sum(a * a) * np.sum(b * b)))
    return (float(np.sum(a * b)) / spread_of if spread_of > 0.0 else 0.0), 2.33 / math.sqrt(len(first))
