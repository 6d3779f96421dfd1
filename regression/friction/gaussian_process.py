"""Gaussian process on what a formula leaves of ln mu: found with scikit-learn, kept as plain numbers, evaluated here.

    r(x) = sum_j w_j k(x, z_j),  k = s^2 (1 + a + a^2/3) exp(-a),  a = sqrt(5) |(x - z)/l|       (Matern 5/2, ARD)

The weights follow from all cases with the noise of each (deterministic training conditional of Quinonero-Candela &
Rasmussen 2005: with z all cases it is the full process). Outside the box of the data r fades to exactly 0, so that the
formula keeps its limits.
"""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Annotated

import numpy as np
from pydantic import model_validator

from ehl.io.errors import InputError
from ehl.io.units import ValueRange
from ehl.io.validation import InputModel
from regression.friction.conditions import UNITS, Array, Conditions
from regression.friction.data_cloud import covering_points
from regression.friction.groups import GROUPS

Finite = Annotated[float, ValueRange("")]
Positive = Annotated[float, ValueRange("", gt=0.0)]
NotNegative = Annotated[float, ValueRange("", ge=0.0)]
POINTS = 2048  # points never fitted, of 1723 cases: 6.1 % with all, 6.4 % with 1024, 7.2 % with 512
VARIANCE_POINTS = 128  # the variance costs the square of their number
_SEARCHED = 800  # cases the likelihood of the length scales is computed on
FADE = 0.25  # of the range of a variable
_DIGITS = 5
_JITTER = 1e-10
_MIN_NOISE = 0.003**2  # of ln mu: less than any solver's own error
_CLIPPED = 3.0  # standard deviations of a noisy case


class GpResidual(InputModel):
    """A Gaussian-process correction of ln mu.

    Parameters
    ----------
    variables : tuple of str
        Names of `regression.friction.conditions.UNITS` or `regression.friction.groups.GROUPS`;
        x = (ln |v| - mean)/scale.
    mean, scale : tuple of float
        Of ln v over the cases.
    low, high : tuple of float
        Range of x over the cases; beyond it the correction fades to 0 within a quarter of the range.
    length_scales : tuple of float
        Of x.
    variance : float
        s^2, of ln mu.
    noise : float
        Variance of ln mu that neither the formula nor the process explains.
    points : tuple of tuple of float, shape (m, d)
        z, each the farthest from those before it in units of the length scales.
    weights : tuple of float, shape (m,)
    alpha : tuple of float, shape (v,)
        Noise variance at the first v points, which the variance of the process is computed from.
    """

    variables: tuple[str, ...]
    mean: tuple[Finite, ...]
    scale: tuple[Positive, ...]
    low: tuple[Finite, ...]
    high: tuple[Finite, ...]
    length_scales: tuple[Positive, ...]
    variance: Positive
    noise: NotNegative
    points: tuple[tuple[Finite, ...], ...]
    weights: tuple[Finite, ...]
    alpha: tuple[NotNegative, ...]

    @model_validator(mode="after")
    def _consistent(self) -> GpResidual:
        size = len(self.variables)
        for name in self.variables:
            if name not in UNITS and name not in GROUPS:
                raise InputError("variables", name, "one of " + ", ".join((*UNITS, *GROUPS)))
        for field in ("mean", "scale", "low", "high", "length_scales"):
            if len(getattr(self, field)) != size:
                raise InputError(field, f"{len(getattr(self, field))} numbers", f"{size}, one per variable")
        if any(len(row) != size for row in self.points):
            raise InputError("points", "rows of another length", f"rows of {size} numbers, one per variable")
        if len(self.weights) != len(self.points):
            raise InputError("weights", f"{len(self.weights)} numbers", f"{len(self.points)}, one per point")
        if not 0 < len(self.alpha) <= len(self.points):
            raise InputError("alpha", f"{len(self.alpha)} numbers", f"1 to {len(self.points)}, for the first points")
        return self

    def coordinates(self, conditions: Conditions) -> Array:
        """x of points, shape (n, d)."""
        return np.asarray((_logarithms(conditions, self.variables) - np.array(self.mean)) / np.array(self.scale))

    def correction(
        self, conditions: Conditions, sums: Callable[[list[Array]], tuple[Array, Array]] | None = None
    ) -> tuple[Array, Array]:
        """Correction of ln mu and its variance, noise excluded; by ufuncs, so that `regression.export` records it.

        Parameters
        ----------
        conditions : mapping
            Columns of shape (n,).
        sums : callable, optional
            In place of `sums`.

        Returns
        -------
        correction, variance : array, shape (n,)
        """
        excess, scaled = [], []
        for k, name in enumerate(self.variables):
            with np.errstate(divide="ignore"):
                place = (np.clip(np.log(np.abs(_values(conditions, name))), -1e3, 1e3) - self.mean[k]) / self.scale[k]
            low, high = self.low[k], self.high[k]
            span = high - low
            excess.append(np.maximum(low - place, place - high) / span)
            # where the correction has faded the kernel need not be finite
            scaled.append(np.clip(place, low - span, high + span) / self.length_scales[k])
        fading = np.clip(1.0 - functools.reduce(np.maximum, excess) / FADE, 0.0, 1.0)
        mean, reduction = (sums or self.sums)(scaled)
        return fading * fading * (3.0 - 2.0 * fading) * mean, np.maximum(self.variance - reduction, 0.0)

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Mean and standard deviation of the process at coordinates x, shape (n, d), without fading."""
        mean, reduction = self.sums(list((x / np.array(self.length_scales)).T))
        return mean, np.sqrt(np.maximum(self.variance - reduction, 0.0))

    def sums(self, scaled: list[Array]) -> tuple[Array, Array]:
        """Mean of the process, and what the stored points take off its variance.

        Parameters
        ----------
        scaled : list of array
            Coordinates over the length scales, one array per variable.
        """
        lengths = np.array(self.length_scales)
        covariance = matern(np.column_stack(scaled) * lengths, self._points, lengths, self.variance)
        spread = covariance[:, : len(self.alpha)] @ self.root
        return covariance @ np.array(self.weights), np.sum(spread**2, axis=1)

    def _kernel(self, x: Array, z: Array) -> Array:
        return matern(x, z, np.array(self.length_scales), self.variance)

    @cached_property
    def _points(self) -> Array:
        return np.array(self.points)

    @cached_property
    def root(self) -> Array:
        """R with K^-1 = R R^T of the covariance of the first points with their noise."""
        z = self._points[: len(self.alpha)]
        covariance = self._kernel(z, z) + np.diag(np.array(self.alpha) + self.noise + _JITTER * self.variance)
        return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)).T)


def matern(x: Array, z: Array, length_scales: Array, variance: float) -> Array:
    """Matern 5/2 covariance of all pairs, shape (n, m)."""
    from scipy.spatial.distance import cdist

    a = np.sqrt(5.0) * cdist(x / length_scales, z / length_scales)
    return np.asarray(variance * (1.0 + a + a**2 / 3.0) * np.exp(-a))


def fit_residual(
    table: Mapping[str, Array],
    residual: Array,
    noise: Array,
    variables: tuple[str, ...],
    *,
    count: int = POINTS,
    variance_count: int = VARIANCE_POINTS,
    start: GpResidual | None = None,
) -> GpResidual:
    """The Gaussian process of a residual of ln mu.

    Parameters
    ----------
    table : mapping
        Columns of the cases, shape (n,).
    residual : array, shape (n,)
        ln mu computed minus ln mu of the formula.
    noise : array, shape (n,)
        Variance of each case's ln mu as its solver states it.
    variables : tuple of str
        Inputs; those that do not vary are left out.
    count, variance_count : int
        Points kept, and how many of them the variance uses.
    start : GpResidual, optional
        Of the same variables: where the search for the length scales begins.

    Raises
    ------
    InputError
        No variable varies.
    """
    names = tuple(
        n for n in variables if np.isfinite(_values(table, n)).all() and np.ptp(_logarithms(table, (n,))) > 1e-6
    )
    if not names:
        raise InputError("run", "data that do not vary", "cases that vary at least one variable")
    logs = _logarithms(table, names)
    mean, scale = logs.mean(axis=0), logs.std(axis=0)
    x = (logs - mean) / scale
    residual = _without_outliers(residual, noise)
    length_scales, variance, white = _likeliest(
        x, residual, noise, start if start is not None and start.variables == names else None
    )
    chosen, _ = covering_points(x / length_scales, count)
    points = np.round(x[chosen], _DIGITS)
    kept = min(variance_count, len(points))
    return GpResidual(
        variables=names,
        mean=tuple(map(float, mean)),
        scale=tuple(map(float, scale)),
        low=tuple(map(float, x.min(axis=0))),
        high=tuple(map(float, x.max(axis=0))),
        length_scales=tuple(map(float, length_scales)),
        variance=variance,
        noise=white,
        points=tuple(tuple(map(float, row)) for row in points),
        weights=tuple(map(float, _weights(x, points, residual, noise + white, length_scales, variance))),
        alpha=tuple(map(float, noise[chosen][:kept])),
    )


def _weights(x: Array, z: Array, residual: Array, noise: Array, length_scales: Array, variance: float) -> Array:
    """(K_zz + K_zx N^-1 K_xz) w = K_zx N^-1 r as a least-squares problem, which squares no condition number."""
    root = np.sqrt(noise + _JITTER * variance)
    inner = matern(z, z, length_scales, variance) + _JITTER * variance * np.eye(len(z))
    rows = np.vstack([matern(x, z, length_scales, variance) / root[:, None], np.linalg.cholesky(inner).T])
    q, r = np.linalg.qr(rows)
    return np.asarray(np.linalg.solve(r, q.T @ np.concatenate([residual / root, np.zeros(len(z))])))


def _without_outliers(residual: Array, noise: Array) -> Array:
    """Residuals of noisy cases, no farther from zero than their noise and the usual residual explain."""
    usual = 1.4826 * float(np.median(np.abs(residual)))
    limit = np.where(noise > 0.0, _CLIPPED * np.sqrt(noise + usual**2), np.inf)
    return np.asarray(np.clip(residual, -limit, limit))


def _likeliest(x: Array, residual: Array, noise: Array, start: GpResidual | None) -> tuple[Array, float, float]:
    """Length scales, variance and unexplained noise of greatest likelihood, by scikit-learn on some of the cases."""
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

    some = np.sort(np.random.default_rng(1).permutation(len(x))[:_SEARCHED])
    level = max(float(np.var(residual)), 1e-12)
    # with few cases in many dimensions shorter length scales fit the noise
    of_variance, of_scales, of_noise = (1e-3 * level, 1e3 * level), (1.0, 30.0), (_MIN_NOISE, 10.0 * level + 1.0)
    variance, length_scales, white = level, np.full(x.shape[1], 3.0), max(0.1 * level, _MIN_NOISE)
    if start is not None:
        variance, white = float(np.clip(start.variance, *of_variance)), float(np.clip(start.noise, *of_noise))
        length_scales = np.clip(np.array(start.length_scales), *of_scales)
    kernel = ConstantKernel(variance, of_variance) * Matern(length_scales, of_scales, nu=2.5) + WhiteKernel(
        white, of_noise
    )
    with warnings.catch_warnings():
        # a length scale at its bound is a variable without effect
        warnings.simplefilter("ignore", ConvergenceWarning)
        found = GaussianProcessRegressor(kernel, alpha=noise[some] + _JITTER * level).fit(x[some], residual[some])
    best = found.kernel_
    return np.asarray(best.k1.k2.length_scale), float(best.k1.k1.constant_value), float(best.k2.noise_level)


def _values(table: Conditions, name: str) -> Array:
    return GROUPS[name](table) if name in GROUPS else table[name]


def _logarithms(table: Conditions, names: tuple[str, ...]) -> Array:
    with np.errstate(divide="ignore"):
        logs = np.column_stack([np.log(np.abs(np.asarray(_values(table, name), dtype=float))) for name in names])
    # a smooth surface has an infinite film ratio: as far away as numbers need
    return np.asarray(np.clip(logs, -1e3, 1e3))
