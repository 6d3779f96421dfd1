"""Smooth function behind noisy values on a rectangle, with its uncertainty.

The function is free up to an order, has terms of second order of one common size beyond that, and a field that
changes over a length along the face and another over the depth: a Gaussian process. How large the terms and the
field are, and how long the lengths, is not known; all of it counts by prior and likelihood. Sizes are half-Cauchy: a
deviation may be nothing at all or hundreds of micrometres, and the values decide. What scatters about the function is
noise, at least the stated one, the likeliest size of it above that.

Taking the likeliest sizes and lengths alone, or those about them, tells the uncertainty too small: where the likeliest
field is none at all, one of a third of the noise is nearly as likely.

Source: Rasmussen and Williams, Gaussian Processes for Machine Learning (2006), 2.7 and 5.4.1; half-Cauchy sizes:
Gelman, Bayesian Analysis 1 (2006), 515. Kernel and scales are ours.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

FloatArray = NDArray[np.float64]

# sizes [um], scales of their half-Cauchy priors, and lengths in half sides
_SIZES = np.geomspace(0.02, 300.0, 15)
_SCALE_SECOND, _SCALE_FIELD = 3.0, 1.0
_LENGTHS = (0.4, 0.8, 1.6, 5.0)
# sets of sizes and lengths that stand for all of them, and the prior size of the free terms [um]
_SETS, _FREE = 24, 1e3
# noise is looked for up to this many times the stated one, to this share
_LOUDER, _NOISE_STEP = 300.0, 0.02


@dataclass(frozen=True)
class Sizes:
    """One set of what is not known: sizes [um] of the terms of second order and of the field, its lengths."""

    second: float
    field: float
    lengths: tuple[float, float]
    weight: float


@dataclass(frozen=True)
class SmoothField:
    """Smooth function with its uncertainty; see `smooth_field`.

    Attributes
    ----------
    place : (2, n) array
        Where there are values, from -1 to 1.
    values : (n,) array
        Noisy values [um].
    order : int
        The function is free up to it.
    noise : float
        Scatter of the values, 1 sigma [um].
    sets : tuple of Sizes
        What stands for all sizes and lengths, by their weights.
    """

    place: FloatArray
    values: FloatArray
    order: int
    noise: float
    sets: tuple[Sizes, ...]

    def mean(self, place: FloatArray) -> FloatArray:
        """Expected function at (2, m) places [um], (m,)."""
        return self._moments(place, False)[0]

    def covariance(self, place: FloatArray) -> FloatArray:
        """Covariance of the function [um^2], without noise, (m, m)."""
        return self._moments(place, True)[1]

    def _moments(self, place: FloatArray, spread: bool) -> tuple[FloatArray, FloatArray]:
        """Mean and, if asked for, covariance over all sets."""
        weights = np.array([each.weight for each in self.sets])
        means, within = [], np.zeros((place.shape[1], place.shape[1]))
        for each in self.sets:
            own = self._kernel(each, self.place, self.place) + self.noise**2 * np.eye(self.values.size)
            across, factor = self._kernel(each, place, self.place), cho_factor(own, lower=True)
            means.append(across @ cho_solve(factor, self.values))
            if spread:
                known = across @ cho_solve(factor, across.T)
                within += each.weight * (self._kernel(each, place, place) - known)
        mean = weights @ np.array(means)
        apart = np.array(means) - mean
        return np.asarray(mean), np.asarray(within + (weights * apart.T) @ apart)

    def _kernel(self, sizes: Sizes, first: FloatArray, second: FloatArray) -> FloatArray:
        """Prior covariance between places [um^2]."""
        free = _FREE**2 * _terms(first, 0, self.order) @ _terms(second, 0, self.order).T
        quadratic = sizes.second**2 * _terms(first, 2, 2) @ _terms(second, 2, 2).T
        return np.asarray(free + quadratic + sizes.field**2 * _correlation(first, second, sizes.lengths))


def smooth_field(place: FloatArray, values: FloatArray, noise: float, order: int) -> SmoothField:
    """Smooth function behind values.

    Parameters
    ----------
    place : (2, n) array
        From -1 to 1.
    values : (n,) array
        [um].
    noise : float
        Least scatter of the values, 1 sigma [um].
    order : int
        Up to which the function is free; from 2 on the terms of second order have no size of their own.
    """
    free = np.linalg.qr(_terms(place, 0, order), mode="complete")[0][:, _terms(place, 0, order).shape[1] :].T
    quadratic = free @ _terms(place, 2, 2)
    pairs, parts = list(product(_LENGTHS, _LENGTHS)), []
    for lengths in pairs:
        variance, own = np.linalg.eigh(free @ _correlation(place, place, lengths) @ free.T)
        parts.append((np.maximum(variance, 0.0), own.T @ (free @ values), own.T @ quadratic))
    second = _SIZES if order < 2 else np.zeros(1)
    step = np.log(_SIZES)  # even in the logarithm: a density per size counts times the size
    prior = step - np.log1p((_SIZES / _SCALE_FIELD) ** 2)
    prior = prior[:, None] + (step - np.log1p((_SIZES / _SCALE_SECOND) ** 2) if order < 2 else np.zeros(1))

    def evidence(scatter: float) -> FloatArray:
        return np.stack([prior + _likelihood(*part, _SIZES, second, scatter) for part in parts])

    def louder(logarithm: float) -> float:
        return -float(np.logaddexp.reduce(evidence(noise * np.exp(logarithm)), axis=None))

    scatter = noise
    if louder(_NOISE_STEP) < louder(0.0):
        from scipy.optimize import minimize_scalar

        found = minimize_scalar(
            louder, bounds=(0.0, np.log(_LOUDER)), method="bounded", options={"xatol": 0.5 * _NOISE_STEP}
        )
        scatter = noise * float(np.exp(found.x))
    weight = evidence(scatter)
    weight = np.exp(weight - weight.max())
    # even steps of their cumulative weight: each set as often as it counts
    summed = np.cumsum(weight) / weight.sum()
    chosen, often = np.unique(np.searchsorted(summed, (np.arange(_SETS) + 0.5) / _SETS), return_counts=True)
    sets = []
    for index, times in zip(chosen, often, strict=True):
        pair, size, term = np.unravel_index(index, weight.shape)
        sets.append(Sizes(float(second[term]), float(_SIZES[size]), pairs[int(pair)], float(times) / _SETS))
    return SmoothField(place, values, order, scatter, tuple(sets))


def _terms(place: FloatArray, least: int, most: int) -> FloatArray:
    """Powers of both places with orders from least to most, (n, terms)."""
    x, y = place
    return np.stack([x ** (k - j) * y**j for k in range(least, most + 1) for j in range(k + 1)], axis=1)


def _correlation(first: FloatArray, second: FloatArray, lengths: tuple[float, float]) -> FloatArray:
    """Of the field between places, (n, m)."""
    apart = sum(((a[:, None] - b) / length) ** 2 for a, b, length in zip(first, second, lengths, strict=True))
    return np.asarray(np.exp(-0.5 * apart))


def _likelihood(
    variance: FloatArray, values: FloatArray, terms: FloatArray, sizes: FloatArray, second: FloatArray, noise: float
) -> FloatArray:
    """Logarithm of the likelihood of values with uncorrelated field and noise and terms beside, (sizes, second)."""
    total = sizes[:, None] ** 2 * variance + noise**2
    alone = -0.5 * np.sum(np.log(total) + values**2 / total, axis=1)
    weighed = terms / total[:, :, None]
    # determinant and inverse by the terms (Woodbury)
    inner = np.eye(terms.shape[1]) + second[:, None, None] ** 2 * (terms.T @ weighed)[:, None]
    along = second[:, None] * (values @ weighed)[:, None]
    gained = np.sum(along * np.linalg.solve(inner, along[..., None])[..., 0], axis=-1)
    return np.asarray(alone[:, None] - 0.5 * np.linalg.slogdet(inner)[1] + 0.5 * gained)
