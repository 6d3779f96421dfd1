"""Gaussian process on what a formula leaves: found by likelihood, kept as plain numbers, evaluated here.

    r(x) = sum_j w_j k(x, z_j),  k = s^2 (1 + a + a^2/3) exp(-a),  a = sqrt(5) |x/l - z_j|       (Matern 5/2, ARD)

A form that gives the load share of the asperities and the friction of the film beside mu has two of them, of the logit
of the share and of ln of the film's friction: each varies more smoothly than what both make of mu (`corrected_parts`).

The weights follow from all cases with the noise of each (deterministic training conditional of Quinonero-Candela &
Rasmussen 2005: with z all cases it is the full process). Outside the box of the data r fades to exactly 0, so that the
formula keeps its limits.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Annotated, Any, cast

import numpy as np
from pydantic import model_validator

from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel
from regression.friction.conditions import GROUPS, UNITS, Array, Conditions
from regression.friction.data_cloud import covering_points
from regression.friction.families import Family

Finite = Annotated[float, ValueRange("")]
Positive = Annotated[float, ValueRange("", gt=0.0)]
NotNegative = Annotated[float, ValueRange("", ge=0.0)]
Sums = Callable[[list[Array]], tuple[Array, Array]]
POINTS = 2048  # held out, of 1723 cases: 4.5 % with all, 4.6 % with 1024, 5.0 % with 512
VARIANCE_POINTS = 128  # the variance costs the square of their number
# cases the likelihood of the length scales is computed on; it costs the cube of their number. Points of 75W90 never
# fitted are met within 3.2 % with 800, 3.0 % with 1600
_SEARCHED = 1600
FADE = 0.25  # of the range of a variable
_BLOCK = 64  # points at a time: their covariances stay in the cache
_DIGITS = 4
_JITTER = 1e-10
_MIN_NOISE = 0.003**2  # of ln mu: less than any solver's own error
_CLIPPED = 3.0  # standard deviations of a noisy case
_SCALES = (1.0, 30.0)  # of the length scales: with few cases in many dimensions shorter ones fit the noise
ASPERITY_ODDS = "asperity_odds"  # X/(1 - X) of the form, an input of processes on the parts of mu
ODDS_LIMIT = 1e3  # shares nearer to 0 or 1 leave friction as it is
FILM_POWER = 1.5  # of the load share of the film, about what the forms have


class GpResidual(InputModel):
    """A Gaussian-process correction of ln mu, or of one of its parts.

    Parameters
    ----------
    variables : tuple of str
        Names of `regression.friction.conditions.UNITS` or `regression.friction.conditions.GROUPS`, or `ASPERITY_ODDS`;
        x = (ln |v| - mean)/scale.
    mean, scale : tuple of float
        Of ln v over the cases.
    low, high : tuple of float
        Range of x over the cases; beyond it the correction fades to 0 within a quarter of the range.
    length_scales : tuple of float
        Of x.
    variance : float
        s^2, of ln mu or its part.
    noise : float
        Variance that neither the formula nor the process explains.
    points : tuple of tuple of float, shape (m, d)
        z, over the length scales, each the farthest from those before it.
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
            if name not in UNITS and name not in GROUPS and name != ASPERITY_ODDS:
                raise InputError("variables", name, "one of " + ", ".join((*UNITS, *GROUPS, ASPERITY_ODDS)))
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

    def correction(self, conditions: Conditions, sums: Sums | None = None) -> tuple[Array, Array]:
        """Correction of ln mu, or its part, and its variance without noise; by ufuncs: `regression.export` records it.

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
        return self._sums(scaled, len(self.alpha))

    def mean_alone(self, scaled: list[Array]) -> tuple[Array, Array]:
        """As `sums`, with nothing taken off the variance."""
        return self._sums(scaled, 0)

    def _sums(self, scaled: list[Array], varying: int) -> tuple[Array, Array]:
        from regression.friction._kernels import matern_of_squares

        x = np.sqrt(5.0) * np.column_stack(scaled)
        # a^2 = |x|^2 + |z|^2 - 2 x z as one product
        factors = np.column_stack([x, np.einsum("ij,ij->i", x, x), np.ones(len(x))])
        mean, reduction = np.empty(len(x)), np.zeros(len(x))
        covariance = np.empty((min(_BLOCK, len(x)), len(self.points)))
        for start in range(0, len(x), _BLOCK):
            block = slice(start, start + _BLOCK)
            part = covariance[: len(x[block])]
            np.matmul(factors[block], self._stored, out=part)
            matern_of_squares(part)
            mean[block] = part @ self._weights
            if varying:
                spread = part[:, :varying] @ self.root
                reduction[block] = np.einsum("ij,ij->i", spread, spread)
        return self.variance * mean, self.variance**2 * reduction

    @cached_property
    def _stored(self) -> Array:
        z = np.sqrt(5.0) * np.array(self.points)
        return np.vstack([-2.0 * z.T, np.ones(len(z)), np.einsum("ij,ij->i", z, z)])

    @cached_property
    def _weights(self) -> Array:
        return np.array(self.weights)

    @cached_property
    def root(self) -> Array:
        """R with K^-1 = R R^T of the covariance of the first points with their noise."""
        z = np.array(self.points[: len(self.alpha)])
        covariance = matern(z, z, self.variance) + np.diag(np.array(self.alpha) + self.noise + _JITTER * self.variance)
        return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)).T)


def ask_kernel() -> None:
    """Have the kernel compiled, where it is not yet."""
    from regression.friction._kernels import matern_of_squares

    matern_of_squares(np.zeros((1, 1)))


def matern(x: Array, z: Array, variance: float) -> Array:
    """Matern 5/2 covariance of all pairs of points over the length scales, shape (n, m)."""
    from scipy.spatial.distance import cdist

    a = np.sqrt(5.0) * cdist(x, z)
    return np.asarray(variance * (1.0 + a + a**2 / 3.0) * np.exp(-a))


# what processes do, by how many there are
PROCESS_WORDS: dict[int, tuple[str, ...]] = {
    0: (),
    1: ("mu times exp(r)",),
    2: ("X/(1 - X) times exp(r)", "friction of the film over (1 - X)^1.5 times exp(r)"),
}


def corrected_form(
    form: Family,
    coefficients: Mapping[str, float],
    processes: tuple[GpResidual, ...],
    table: Conditions,
    boundary_friction: float | Array,
    sums: tuple[Sums | None, ...] = (None, None),
) -> tuple[Array, Array | None]:
    """Friction of a form corrected by its Gaussian processes, and the standard deviation of ln mu.

    The correction raises no friction above the greater of boundary friction and limiting shear: the bound of the
    physics holds by construction wherever the form keeps it.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        if len(processes) == 2 and form.parts is not None:
            # [()] gives what is recorded for an export, and of arrays the array
            share, film = (np.asarray(part)[()] for part in form.parts(table, coefficients))
            mu = share * boundary_friction + film
            found, variance = corrected_parts(
                share, film, (processes[0], processes[1]), table, boundary_friction, (sums[0], sums[1])
            )
        else:
            mu = np.exp(form.log_mu(table, coefficients, cast("float", boundary_friction)))
            if not processes:
                return mu, None
            correction, variance = processes[0].correction(table, sums[0])
            found, variance = mu * np.exp(correction), variance + processes[0].noise
        bound = np.maximum(np.maximum(boundary_friction, table["limiting_shear_coefficient"]), mu)
        return np.minimum(found, bound), np.sqrt(variance)


def corrected_parts(
    share: Array,
    film: Array,
    processes: tuple[GpResidual, GpResidual],
    conditions: Conditions,
    boundary_friction: float | Array,
    sums: tuple[Sums | None, Sums | None] = (None, None),
) -> tuple[Array, Array]:
    """mu of corrected parts and the variance of its logarithm; by ufuncs, so that `regression.export` records it.

    Parameters
    ----------
    share, film : array, shape (n,)
        Asperity load share and friction of the film by the form.
    processes : tuple of GpResidual
        Of the logit of the share, and of ln of the film's friction over (1 - share)^1.5.
    conditions : mapping
        Columns of shape (n,).
    boundary_friction : float or array of shape (n,)
    sums : tuple of callable, optional
        As of `GpResidual.correction`, of either process.

    Returns
    -------
    mu, variance : array, shape (n,)
    """
    odds = asperity_odds(share)
    seen = {**conditions, ASPERITY_ODDS: np.clip(odds, 1.0 / ODDS_LIMIT, ODDS_LIMIT)}
    (shift, share_variance), (stretch, film_variance) = (
        process.correction(seen, own) for process, own in zip(processes, sums, strict=True)
    )
    moved = odds * np.exp(shift)
    asperities = moved / (1.0 + moved) * boundary_friction
    sheared = film * ((1.0 + odds) / (1.0 + moved)) ** FILM_POWER * np.exp(stretch)
    mu = asperities + sheared
    by_share = (asperities - FILM_POWER * sheared * moved) / (1.0 + moved) / mu
    # d ln mu/d logit, and d ln mu/d ln film
    variance = by_share**2 * (share_variance + processes[0].noise)
    return mu, variance + (sheared / mu) ** 2 * (film_variance + processes[1].noise)


def asperity_odds(share: Array) -> Array:
    """X/(1 - X); finite at X = 1."""
    return share / np.maximum(1.0 - share, 1e-12)


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
    """The Gaussian process of a residual of ln mu or of one of its parts.

    Parameters
    ----------
    table : mapping
        Columns of the cases, shape (n,).
    residual : array, shape (n,)
        Computed minus formula: ln mu, logit of the share or ln of the film's friction.
    noise : array, shape (n,)
        Variance of each case's, by chance.
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
    if len(chosen) == len(x):
        x, residual, noise, chosen = x[chosen], residual[chosen], noise[chosen], np.arange(len(x))
    points = np.round(x[chosen] / length_scales, _DIGITS)
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
        weights=tuple(map(float, _weights(x / length_scales, points, residual, noise + white, variance))),
        alpha=tuple(map(float, noise[chosen][:kept])),
    )


def _weights(x: Array, z: Array, residual: Array, noise: Array, variance: float) -> Array:
    """(K_zz + K_zx N^-1 K_xz) w = K_zx N^-1 r as a least-squares problem, which squares no condition number.

    Where z are all cases, in the order of x, it is (K_zz + N) w = r.
    """
    floor = noise + _JITTER * variance
    if len(x) == len(z):
        return np.asarray(np.linalg.solve(matern(z, z, variance) + np.diag(floor), residual))
    root = np.sqrt(floor)
    inner = matern(z, z, variance) + _JITTER * variance * np.eye(len(z))
    rows = np.vstack([matern(x, z, variance) / root[:, None], np.linalg.cholesky(inner).T])
    q, r = np.linalg.qr(rows)
    return np.asarray(np.linalg.solve(r, q.T @ np.concatenate([residual / root, np.zeros(len(z))])))


def _without_outliers(residual: Array, noise: Array) -> Array:
    """Residuals of noisy cases, no farther from zero than their noise and the usual residual explain."""
    usual = 1.4826 * float(np.median(np.abs(residual)))
    limit = np.where(noise > 0.0, _CLIPPED * np.sqrt(noise + usual**2), np.inf)
    return np.asarray(np.clip(residual, -limit, limit))


def _likeliest(x: Array, residual: Array, noise: Array, start: GpResidual | None) -> tuple[Array, float, float]:
    """Length scales, variance and unexplained noise of greatest likelihood, on some of the cases."""
    from scipy.optimize import Bounds, minimize

    some = np.sort(np.random.default_rng(1).permutation(len(x))[:_SEARCHED])
    level, size = max(float(np.var(residual)), 1e-12), x.shape[1]
    ends = np.log([_SCALES] * size + [(1e-3 * level, 1e3 * level), (_MIN_NOISE, 10.0 * level + 1.0)])
    first = np.log(np.array([*np.full(size, 3.0), level, max(0.1 * level, _MIN_NOISE)]))
    if start is not None:
        first = np.log(np.array([*start.length_scales, start.variance, max(start.noise, _MIN_NOISE)]))
    cases = x[some], residual[some], noise[some] + _JITTER * level
    found = minimize(
        _unlikelihood,
        np.asarray(np.clip(first, ends[:, 0], ends[:, 1])),
        args=cases,
        jac=True,
        method="L-BFGS-B",
        bounds=Bounds(ends[:, 0], ends[:, 1]),
    ).x
    best = np.exp(found)
    return best[:size], float(best[size]), float(best[size + 1])


def _unlikelihood(logs: Any, x: Array, residual: Array, noise: Array) -> tuple[float, Array]:
    """-ln of the marginal likelihood but for a constant, and its gradient, over ln of length scales, s^2 and noise."""
    from scipy.linalg import cho_factor, cho_solve
    from scipy.spatial.distance import pdist, squareform

    size, parameters = x.shape[1], np.exp(logs)
    scaled, variance, white = x / parameters[:size], parameters[size], parameters[size + 1]
    a = np.sqrt(5.0) * squareform(pdist(scaled))
    decay = variance * np.exp(-a)
    kernel = decay * (1.0 + a + a**2 / 3.0)
    factor = cho_factor(kernel + np.diag(noise + white), lower=True)
    weights, inverse = cho_solve(factor, residual), cho_solve(factor, np.eye(len(x)))
    value = 0.5 * float(residual @ weights) + float(np.sum(np.log(np.diag(factor[0]))))
    slope = inverse - np.outer(weights, weights)
    # dk/d ln l_i = s^2 5/3 (1 + a) exp(-a) (x_i - z_i)^2/l_i^2
    pairs = slope * (decay * (1.0 + a) * (5.0 / 3.0))
    along = pairs.sum(axis=1) @ scaled**2 - np.sum(scaled * (pairs @ scaled), axis=0)
    return value, np.array([*along, 0.5 * np.sum(slope * kernel), 0.5 * white * np.trace(slope)])


def _values(table: Conditions, name: str) -> Array:
    return GROUPS[name](table) if name in GROUPS else table[name]


def _logarithms(table: Conditions, names: tuple[str, ...]) -> Array:
    with np.errstate(divide="ignore"):
        logs = np.column_stack([np.log(np.abs(np.asarray(_values(table, name), dtype=float))) for name in names])
    # a smooth surface has an infinite film ratio: as far away as numbers need
    return np.asarray(np.clip(logs, -1e3, 1e3))
