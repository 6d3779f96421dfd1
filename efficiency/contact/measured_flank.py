"""Measured flank: nominal flank of the machine settings plus a smooth deviation with a known uncertainty.

An inspection machine gives points with noise. Their deviation from the nominal flank, along its normal, is a smooth
field over face and depth. Thickness, pressure and spiral angle are free; crowning and twist have a common size; the
remainder varies over a correlation length. The mean of the field is the flank, its covariance is the uncertainty of the
flank, and of the transmission error. Without a nominal flank the deviation refers to a polynomial through the points,
free to fourth order, and the uncertainty is larger.

The field is a Gaussian process with three parts: free terms up to an order, terms of second order with one common size,
and a part with one length along the face and another over the depth. Sizes (half-Cauchy priors) and lengths are unknown
and integrated over by prior and likelihood. The maximum-likelihood estimate alone underestimates the uncertainty: a
zero field and a field of a third of the noise are nearly equally likely. The scatter about the function is noise, at
least the stated one.

Source: Rasmussen and Williams, Gaussian Processes for Machine Learning (2006), 2.7 and 5.4.1; half-Cauchy sizes:
Gelman, Bayesian Analysis 1 (2006), 515. Kernel and scales are choices of this work.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
import scipy
from numpy.typing import NDArray

from efficiency.contact.chebyshev import Patch, PointFit
from efficiency.contact.conjugate import regular_points
from efficiency.contact.grid_flank import PointGrid, SmoothFlank, normal_sense, placed_points
from efficiency.cutting.blank import Blank
from efficiency.cutting.cutter import FlankSide
from efficiency.cutting.flank import Flank
from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError, InputError

# coefficients of the azimuth over face and depth, and extension of the fit beyond the blank
_SHAPE = (20, 14)
_BEYOND = 0.06
# for an undercut root: trial distances of the lower limit from the lowest point, fractions of the depth
_RAISED = (0.0, 0.01, 0.02, 0.03, 0.05, 0.08, 0.12, 0.2)
# order of the free part of the deviation with and without a nominal flank
_ORDER, _ORDER_ALONE = 1, 4
# largest deviation of a cut or ground flank from its nominal one [m]
_FARTHEST = 0.5e-3
# tuned: ratio of scatter to stated uncertainty above which the scatter is reported (this work); may be changed freely
_SCATTER = 1.3

# tuned: sizes [um], scales of their half-Cauchy priors, and lengths in half sides (this work); may be changed after
# running `test_stated_uncertainty_covers`
_SIZES = np.geomspace(0.02, 300.0, 15)
_SCALE_SECOND, _SCALE_FIELD = 3.0, 1.0
_LENGTHS = (0.4, 0.8, 1.6, 5.0)
# outliers by dirt (this work): deviation from neighbours in robust standard deviations or uncertainties; largest share
_DIRTY, _MOST_DIRTY = 8.0, 0.05
_HUBER, _ROBUST, _ROUNDS = 1.5, 1.4826, 10
# number of sets of sizes and lengths for the integration, and prior size of the free terms [um]
_SETS, _FREE = 24, 1e3
# largest ratio of noise to the stated one, and relative accuracy of the noise
_LOUDER, _NOISE_STEP = 300.0, 0.02


@dataclass(frozen=True)
class Sizes:
    """One set of hyperparameters: sizes [um] of the terms of second order and of the field, lengths of the field."""

    second: float
    field: float
    lengths: tuple[float, float]
    weight: float


@dataclass(frozen=True)
class SmoothField:
    """Smooth function with its uncertainty; see `smooth_field`."""

    place: FloatArray  # (2, n) positions of the values, from -1 to 1
    values: FloatArray  # (n,) noisy values [um]
    order: int  # order up to which the function is free
    noise: float  # scatter of the values, 1 sigma [um]
    sets: tuple[Sizes, ...]  # sets of sizes and lengths with their weights

    def mean(self, place: FloatArray) -> FloatArray:
        """Expected function at (2, m) positions [um], (m,)."""
        return self._moments(place, False)[0]

    def covariance(self, place: FloatArray) -> FloatArray:
        """Covariance of the function [um^2], without noise, (m, m)."""
        return self._moments(place, True)[1]

    def _moments(self, place: FloatArray, spread: bool) -> tuple[FloatArray, FloatArray]:
        """Mean and, if required, covariance over all sets."""
        weights = np.array([each.weight for each in self.sets])
        means, within = [], np.zeros((place.shape[1], place.shape[1]))
        for each in self.sets:
            own = self._kernel(each, self.place, self.place) + self.noise**2 * np.eye(self.values.size)
            across, factor = self._kernel(each, place, self.place), scipy.linalg.cho_factor(own, lower=True)
            means.append(across @ scipy.linalg.cho_solve(factor, self.values))
            if spread:
                known = across @ scipy.linalg.cho_solve(factor, across.T)
                within += each.weight * (self._kernel(each, place, place) - known)
        mean = weights @ np.array(means)
        apart = np.array(means) - mean
        return np.asarray(mean), np.asarray(within + (weights * apart.T) @ apart)

    def _kernel(self, sizes: Sizes, first: FloatArray, second: FloatArray) -> FloatArray:
        """Prior covariance between positions [um^2]."""
        free = _FREE**2 * _terms(first, 0, self.order) @ _terms(second, 0, self.order).T
        quadratic = sizes.second**2 * _terms(first, 2, 2) @ _terms(second, 2, 2).T
        return np.asarray(free + quadratic + sizes.field**2 * _correlation(first, second, sizes.lengths))


def smooth_field(place: FloatArray, values: FloatArray, noise: float, order: int) -> SmoothField:
    """Smooth function fitted to values (n,) [um] at positions (2, n) from -1 to 1.

    `noise` is the least scatter of the values, 1 sigma [um]. The function is free up to `order`; from order 2 the terms
    of second order have no own size.
    """
    free = np.linalg.qr(_terms(place, 0, order), mode="complete")[0][:, _terms(place, 0, order).shape[1] :].T
    quadratic = free @ _terms(place, 2, 2)
    pairs, parts = list(product(_LENGTHS, _LENGTHS)), []
    for lengths in pairs:
        variance, own = np.linalg.eigh(free @ _correlation(place, place, lengths) @ free.T)
        parts.append((np.maximum(variance, 0.0), own.T @ (free @ values), own.T @ quadratic))
    second = _SIZES if order < 2 else np.zeros(1)
    step = np.log(_SIZES)  # even steps in the logarithm: a density per size is multiplied by the size
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
    # even steps of the cumulative weight: each set occurs in proportion to its weight
    summed = np.cumsum(weight) / weight.sum()
    chosen, often = np.unique(np.searchsorted(summed, (np.arange(_SETS) + 0.5) / _SETS), return_counts=True)
    sets = []
    for index, times in zip(chosen, often, strict=True):
        pair, size, term = np.unravel_index(index, weight.shape)
        sets.append(Sizes(float(second[term]), float(_SIZES[size]), pairs[int(pair)], float(times) / _SETS))
    return SmoothField(place, values, order, scatter, tuple(sets))


def _terms(place: FloatArray, least: int, most: int) -> FloatArray:
    """Powers of both coordinates with orders from least to most, (n, terms)."""
    x, y = place
    return np.stack([x ** (k - j) * y**j for k in range(least, most + 1) for j in range(k + 1)], axis=1)


def _correlation(first: FloatArray, second: FloatArray, lengths: tuple[float, float]) -> FloatArray:
    """Correlation of the field between positions, (n, m)."""
    apart = sum(((a[:, None] - b) / length) ** 2 for a, b, length in zip(first, second, lengths, strict=True))
    return np.asarray(np.exp(-0.5 * apart))


def _likelihood(
    variance: FloatArray, values: FloatArray, terms: FloatArray, sizes: FloatArray, second: FloatArray, noise: float
) -> FloatArray:
    """Log likelihood of values with uncorrelated field, noise and further terms, (sizes, second)."""
    total = sizes[:, None] ** 2 * variance + noise**2
    alone = -0.5 * np.sum(np.log(total) + values**2 / total, axis=1)
    weighed = terms / total[:, :, None]
    # determinant and inverse of the terms (Woodbury)
    inner = np.eye(terms.shape[1]) + second[:, None, None] ** 2 * (terms.T @ weighed)[:, None]
    along = second[:, None] * (values @ weighed)[:, None]
    gained = np.sum(along * np.linalg.solve(inner, along[..., None])[..., 0], axis=-1)
    return np.asarray(alone[:, None] - 0.5 * np.linalg.slogdet(inner)[1] + 0.5 * gained)


@dataclass(frozen=True)
class MeasuredFlank(SmoothFlank):
    """Nominal flank plus the smooth part of measured deviations; see `measured_flank`."""

    place: FloatArray  # (2, n) measured points: u over half the face width, depth fraction from -1 to 1
    deviation: FloatArray  # (n,) measured minus nominal along the normal, positive outwards, without its mean [m]
    offset: float  # mean deviation as an angle about the axis: thickness, or rotation of the grid [rad]
    # stated measurement uncertainty, and scatter of the points about the flank, both 1 sigma [m]
    stated: float
    scatter: float
    field: SmoothField  # deviation over face and depth
    dirty: tuple[str, ...] = ()  # omitted outliers, which deviate from all neighbours

    def covariance(self, u: FloatArray, h: FloatArray) -> FloatArray:
        """Covariance of the flank along its normal at blank coordinates [m^2], (n, n)."""
        return self.field.covariance(_place(self.blank, u, h)) * 1e-12

    @property
    def note(self) -> str:
        """Note on the measurement."""
        text = f"standard uncertainty of one point {self.stated * 1e6:.2g} um"
        if self.scatter > _SCATTER * self.stated:
            text += f", but the points scatter by {self.scatter * 1e6:.2g} um about a smooth flank; this value is used"
        if self.dirty:
            text += f"; omitted outliers: {', '.join(self.dirty)}"
        return text


def measured_flank(
    grid: PointGrid, side: FlankSide, blank: Blank, uncertainty: float, nominal: Flank | None = None
) -> MeasuredFlank:
    """Smooth flank fitted to measured points; given normals are not used, because they are not measured.

    grid, side, blank: points, side of the flank, blank of the member.
    uncertainty: standard uncertainty of one point along the normal [m].
    nominal: nominal flank.
    Raises `InputError` if the points are not those of this flank and blank; `ConvergenceError` if the nominal flank
    does not exist on its blank.
    """
    u, v, h, azimuth = placed_points(grid, side, blank)
    sense = normal_sense(side, blank)
    half = (0.5 + _BEYOND) * blank.face_width
    ranges = (-half, half), (-_BEYOND, 1.0 + _BEYOND)
    measured = (float(u.min()), float(u.max())), (float(v.min()), float(v.max()))
    if nominal is None:
        base = PointFit(*measured, (3, 3), u, v)({"azimuth": azimuth})
        flank = SmoothFlank(side, blank, sense, base, "", 0.0)
        at, here = flank.points(np.stack([u, h, np.zeros_like(u)])), np.ones(u.size, dtype=bool)
        (reference,) = base(u, v, ("azimuth",))
        nodes = Patch.nodes(*ranges, _SHAPE)
        points = flank.points(np.stack([nodes[0], blank.height(*nodes), np.zeros_like(nodes[0])]))
    else:
        at, here = nominal.solve(u, h)
        reference = at.azimuth
        nodes_u, nodes_v, points, regular = regular_points(nominal, *ranges, _SHAPE)
        for raised in _RAISED:
            if regular.all():
                break
            # near a limit of undercut the azimuth is not polynomial: the fit ends at the lowest point, or above it
            # where the limit rises at toe and heel, because a missing node would leave a corner undetermined
            ranges = ranges[0], (measured[1][0] + raised, 1.0 + _BEYOND)
            nodes_u, nodes_v, points, regular = regular_points(nominal, *ranges, _SHAPE)
        if not regular.all():
            raise ConvergenceError("undercut", f"the nominal {side} flank does not exist at the measured points")
        nodes = nodes_u, nodes_v
    if here.sum() < 0.8 * here.size:
        raise ConvergenceError("undercut", f"the nominal {side} flank does not exist at a fifth of the measured points")
    u, h, levers, ahead = u[here], h[here], at.lever[here], np.exp(1j * (azimuth - reference)[here])

    def deviations() -> tuple[float, FloatArray]:
        mean = np.mean(ahead)
        return float(np.angle(mean)), np.angle(ahead / mean) * levers

    offset, deviation = deviations()
    place = _place(blank, u, h)
    clean = ~_dirty(place, deviation * 1e6, uncertainty * 1e6)
    rows, columns = grid.row[here], grid.column[here]
    dirty = tuple(f"row {rows[k]}, column {columns[k]} ({deviation[k] * 1e6:+.3g} um)" for k in np.flatnonzero(~clean))
    if dirty:
        here[np.flatnonzero(here)[~clean]] = False
        u, ahead, levers, place = u[clean], ahead[clean], levers[clean], place[:, clean]
        offset, deviation = deviations()
    worst = int(np.argmax(np.abs(deviation)))
    if abs(deviation[worst]) > _FARTHEST:
        where = f"{grid.path}, row {grid.row[here][worst]}, column {grid.column[here][worst]}"
        stated = f"{deviation[worst] * 1e3:.4g} mm from the nominal flank"
        hint = "Check that the points are those of this member and flank, and their units."
        raise InputError(where, stated, f"within {_FARTHEST * 1e3:g} mm of it", hint)
    field = smooth_field(place, deviation * 1e6, uncertainty * 1e6, _ORDER if nominal is not None else _ORDER_ALONE)

    node_height = blank.height(*nodes)
    smooth = field.mean(_place(blank, nodes[0], node_height)) * 1e-6
    around = points.azimuth
    middle = around[int(np.argmin(np.sum(_place(blank, nodes[0], node_height) ** 2, axis=0)))]
    total = middle + np.angle(np.exp(1j * (around - middle))) + offset + smooth / points.lever
    patch = Patch.fit(*ranges, _SHAPE, {"azimuth": total})
    apart = patch(u, v[here], ("azimuth",))[0] - reference[here] - offset - field.mean(place) * 1e-6 / levers
    missed = max(float(np.abs(np.angle(np.exp(1j * apart)) * levers).max()), patch.tail["azimuth"] * abs(levers).max())
    spread = np.sqrt(np.maximum(np.diag(field.covariance(place)), 0.0)).max() * 1e-6
    return MeasuredFlank(
        side,
        blank,
        sense,
        patch,
        f"the points of {grid.path}",
        2.0 * float(spread) + missed,
        place=place,
        deviation=deviation,
        offset=offset,
        stated=uncertainty,
        scatter=field.noise * 1e-6,
        field=field,
        dirty=dirty,
    )


def _dirty(place: FloatArray, deviation: FloatArray, uncertainty: float) -> NDArray[np.bool_]:
    """Outliers that deviate from all neighbours, such as dirt or a burr; none if they are too many [um].

    The residual of a robust fit of third order (Huber's loss, reweighted least squares) is compared with the median of
    the eight nearest points, which a smooth deviation of higher order changes as well.
    """
    terms = _terms(place, 0, 3)
    weight = np.ones(deviation.size)
    for _ in range(_ROUNDS):
        root = np.sqrt(weight)
        left = deviation - terms @ np.linalg.lstsq(terms * root[:, None], deviation * root, rcond=None)[0]
        scale = max(_ROBUST * float(np.median(np.abs(left))), 0.1 * uncertainty)
        weight = np.minimum(1.0, _HUBER * scale / np.maximum(np.abs(left), 1e-12))
    apart = np.sum((place[:, :, None] - place[:, None, :]) ** 2, axis=0)
    nearest = np.argsort(apart, axis=1)[:, 1:9]
    jump = np.abs(left - np.median(left[nearest], axis=1))
    found = np.asarray(jump > _DIRTY * max(_ROBUST * float(np.median(jump)), uncertainty))
    return found if found.mean() <= _MOST_DIRTY else np.zeros(deviation.size, dtype=bool)


def _place(blank: Blank, u: FloatArray, h: FloatArray) -> FloatArray:
    """Face and depth from -1 to 1, (2, n)."""
    return np.stack([2.0 * u / blank.face_width, 2.0 * blank.fraction(u, h) - 1.0])
