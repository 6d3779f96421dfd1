"""Extrapolation guard: distribution of the fitted cases, and distance of a point from them.

There are three tests: limits of the sum and the difference of every pair of variables, the Mahalanobis distance from
the mean, and the distance to the nearest of a few representative cases. Variables are logarithms, over their standard
deviations or whitened by the covariance of the cases.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from ehl.common.errors import InputError, check_choice
from ehl.common.validation import InputModel
from regression.friction.conditions import UNITS, Array, Conditions
from regression.friction.error_tables import Finite, Positive

STORED_POINTS = 64  # number of representative cases, limited by the length of the file
# margins with which 1 to 3 % of new points of the same plan count as outside
PAIR_SLACK = 0.03  # of the spread of the cases
RADIUS_SLACK = 1.2
FAR_DISTANCE = 2.0  # over the covering radius
_MIN_SPREAD = 1e-6  # spread of ln x below which x is a constant
_DIGITS = 3  # decimals of stored coordinates
STEP = 10.0**-_DIGITS  # unit of the stored integers
_BLOCK = 256  # points of a block whose products fit into the cache


class CloudDistance(IntEnum):
    """Distance class of a point from the fitted cases."""

    INSIDE = 0
    NEAR = 1  # outside the range of cases, but within twice the covering radius of a case
    FAR = 2


class DataCloud(InputModel):
    """Distribution of the fitted cases."""

    variables: tuple[str, ...]  # positive ones of `regression.friction.conditions.UNITS`; coordinates are ln x
    mean: tuple[Finite, ...]  # of ln x
    scale: tuple[Positive, ...]  # standard deviation of ln x
    whitening: tuple[tuple[Finite, ...], ...]  # lower triangle W, z = W (ln x - mean) of unit covariance; shape (d, d)
    mahalanobis: Positive  # largest |z| of a case
    # 1000 z of the representative cases, each the farthest from the previous ones; shape (m, d)
    points: tuple[tuple[int, ...], ...]
    radius: Positive  # largest distance of a case from the nearest of `points`
    # variables i and k, counted from 0, and 1000 times the lower and upper limits of u_i + u_k and of u_i - u_k with
    # u = (ln x - mean)/scale, with a margin of 3 % of the spread of the cases; shape (d (d - 1)/2, 6)
    limits: tuple[tuple[int, int, int, int, int, int], ...]

    @model_validator(mode="after")
    def _consistent(self) -> DataCloud:
        size = len(self.variables)
        for name in self.variables:
            check_choice("variables", name, UNITS)
        if any(not 0 <= place < size for row in self.limits for place in row[:2]):
            raise InputError("limits", "an index of no variable", f"indices from 0 to {size - 1}")
        for field, rows in (("whitening", self.whitening), ("points", self.points)):
            if any(len(row) != size for row in rows):
                raise InputError(field, "rows of another length", f"rows of {size} numbers, one per variable")
        if not len(self.mean) == len(self.scale) == len(self.whitening) == size:
            raise InputError("whitening", f"{len(self.whitening)} rows", f"{size} rows, means and scales")
        if not self.points:
            raise InputError("points", "none", "at least one point")
        return self

    def whitened(self, conditions: Conditions) -> Array:
        """Whitened coordinates z of points, shape (n, d)."""
        return self._whitened(_logarithms(conditions, self.variables))

    def _whitened(self, logarithms: Array) -> Array:
        return np.asarray((logarithms - np.array(self.mean)) @ np.array(self.whitening).T)

    def distance(self, z: Array) -> Array:
        """Distance of whitened points to the nearest of `points` over the covering radius, at most 1 at cases."""
        return _nearest(z, self._points) / self.radius

    def pair_margin(self, logarithms: Array) -> Array:
        """Smallest distance of sums and differences of pairs to their limits, negative outside; for shape (n, d)."""
        u = (logarithms - np.array(self.mean)) / np.array(self.scale)
        first, second, *ends = np.array(self.limits).T
        low, high, least, most = (STEP * end for end in ends)
        margin = np.full(len(u), np.inf)
        for start in range(0, len(u), _BLOCK):
            block = slice(start, start + _BLOCK)
            one, other = u[block][:, first], u[block][:, second]
            inside = np.minimum(np.minimum(one + other - low, high - one - other), one - other - least)
            margin[block] = np.minimum(inside, most - one + other).min(axis=1, initial=np.inf)
        return margin

    @cached_property
    def _points(self) -> Array:
        return STEP * np.array(self.points)

    def extrapolation(self, conditions: Conditions) -> NDArray[np.int8]:
        """`CloudDistance` of every point, in the shape of the conditions."""
        shape = np.shape(conditions["pressure_hertz"])
        logarithms = _logarithms(conditions, self.variables)
        z = self._whitened(logarithms)
        outside = self.pair_margin(logarithms) < 0.0
        near, far = self.near_and_far(self.distance(z), np.linalg.norm(z, axis=1), outside)
        return (near.astype(np.int8) + (near & far)).reshape(shape)

    def near_and_far(
        self, distance: Array, length: Array, outside_pairs: NDArray[np.bool_]
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Whether points lie outside the range of cases, and whether they lie far from it."""
        near = (distance > RADIUS_SLACK) | (length > self.mahalanobis * RADIUS_SLACK) | outside_pairs
        return near, distance > FAR_DISTANCE


def data_cloud(table: Mapping[str, Array], variables: tuple[str, ...], count: int = STORED_POINTS) -> DataCloud | None:
    """The distribution of the fitted cases; None if fewer than two variables vary.

    table: columns of the cases.
    variables: those with a limited range; constant ones, and those with zeros, are omitted.
    count: largest number of stored points.
    """
    kept = tuple(n for n in variables if (table[n] > 0.0).all() and np.ptp(np.log(table[n])) > _MIN_SPREAD)
    kept = _independent(table, kept)
    if len(kept) < 2:
        return None
    logs = _logarithms(table, kept)
    mean, scale = np.round(logs.mean(axis=0), _DIGITS), np.round(logs.std(axis=0), _DIGITS + 1)
    whitening = np.round(np.linalg.inv(np.linalg.cholesky(np.cov(logs, rowvar=False))), _DIGITS)
    z = (logs - mean) @ whitening.T
    chosen, radius = covering_points(z, count)
    return DataCloud(
        variables=kept,
        mean=tuple(map(float, mean)),
        scale=tuple(map(float, scale)),
        whitening=tuple(tuple(map(float, row)) for row in whitening),
        mahalanobis=float(np.linalg.norm(z, axis=1).max()),
        points=tuple(tuple(round(float(v) * 10.0**_DIGITS) for v in row) for row in z[chosen]),
        # margin for the rounding of coordinates
        radius=radius + STEP * len(kept) ** 0.5,
        limits=_pair_limits((logs - mean) / scale),
    )


def _logarithms(table: Conditions, names: tuple[str, ...]) -> Array:
    with np.errstate(divide="ignore"):
        logs = np.column_stack([np.log(np.ravel(np.asarray(table[name], dtype=float))) for name in names])
    # finite logarithms of zero roughness or sliding, which are far from all data
    return np.asarray(np.clip(logs, -1e3, 1e3))


def _independent(table: Mapping[str, Array], names: tuple[str, ...]) -> tuple[str, ...]:
    """Variables that are no function of previous ones; for one oil viscosity is a function of temperature."""
    kept: list[str] = []
    for name in names:
        trial = _logarithms(table, (*kept, name))
        if kept:
            others = trial[:, :-1] - trial[:, :-1].mean(axis=0)
            basis = np.column_stack([np.ones(len(others)), others, others**2])
            rest = trial[:, -1] - basis @ np.linalg.lstsq(basis, trial[:, -1], rcond=None)[0]
            if len(rest) > basis.shape[1] and np.std(rest) < 0.02 * np.std(trial[:, -1]):
                continue
        kept.append(name)
    return tuple(kept)


def _nearest(z: Array, points: Array) -> Array:
    """Distance of every row of z to the nearest of the points."""
    square = np.sum(z**2, axis=1)
    factors, constants = -2.0 * points, np.sum(points**2, axis=1)[:, None]
    for start in range(0, len(z), _BLOCK):
        square[start : start + _BLOCK] += (factors @ z[start : start + _BLOCK].T + constants).min(axis=0)
    return np.asarray(np.sqrt(np.maximum(square, 0.0)))


def covering_points(z: Array, count: int) -> tuple[NDArray[np.int64], float]:
    """Representative points, each the farthest from the previous ones (Gonzalez 1985), and the covering radius.

    z: shape (n, d).
    count: largest number of points.
    Returns: indices, the most central point first; radius: largest distance of a point from a representative one, or a
    typical distance of neighbours if all points are chosen.
    """
    chosen = [int(np.argmin(np.sum(z**2, axis=1)))]
    distance = np.linalg.norm(z - z[chosen[0]], axis=1)
    while len(chosen) < min(count, len(z)) and distance.max() > 0.0:
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.linalg.norm(z - z[chosen[-1]], axis=1))
    if len(chosen) == len(z):
        # all are chosen: the distance of neighbours is the scale
        apart = np.linalg.norm(z[:, None] - z[None], axis=2) + np.diag(np.full(len(z), np.inf))
        return np.array(chosen), float(np.quantile(apart.min(axis=1), 0.99))
    return np.array(chosen), float(distance.max())


def _pair_limits(u: Array) -> tuple[tuple[int, int, int, int, int, int], ...]:
    """Limits of the sum and the difference of every pair of columns, rounded outwards."""
    rows = []
    for i, k in itertools.combinations(range(u.shape[1]), 2):
        ends: list[int] = []
        for values in (u[:, i] + u[:, k], u[:, i] - u[:, k]):
            slack = PAIR_SLACK * float(np.ptp(values))
            ends += [
                math.floor((values.min() - slack) * 10.0**_DIGITS),
                math.ceil((values.max() + slack) * 10.0**_DIGITS),
            ]
        rows.append((i, k, ends[0], ends[1], ends[2], ends[3]))
    return tuple(rows)


def in_convex_hull(points: Array, cases: Array) -> NDArray[np.bool_]:
    """Whether points are convex combinations of cases, by one linear program (HiGHS) each."""
    from scipy.optimize import linprog

    centre, spread = cases.mean(axis=0), np.maximum(np.ptp(cases, axis=0), 1e-300)
    equations = np.vstack([((cases - centre) / spread).T, np.ones(len(cases))])
    inside = []
    for row in (np.atleast_2d(points) - centre) / spread:
        found = linprog(np.zeros(len(cases)), A_eq=equations, b_eq=[*row, 1.0], bounds=(0.0, None), method="highs")
        inside.append(found.status == 0)
    return np.array(inside)
