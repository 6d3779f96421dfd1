"""Identifiability of each parameter: standard errors, correlations, profile intervals, and a note."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.common.quantities import quantity
from regression.calibration import robust
from regression.calibration.prediction import FrictionSolver
from regression.calibration.robust import Noise
from regression.calibration.search import Fit, Target, bounds_of, inverse_information, minimise
from regression.calibration.setup import PARAMETERS

# half width of the 95 % interval of ln(value): determined up to a factor of 1.5, weakly identified up to a factor of 3
DETERMINED, IDENTIFIABLE = math.log(1.5), math.log(3.0)
ALONE = 0.9  # largest share of the information on a parameter from one row
MAX_PROFILE, MAX_PROFILE_REACH = 5, 6.0  # solutions of all rows for each side of a profile; largest over first step
CLOSE_ROOT = 0.1  # of the quantile: close enough for interpolation
COLLINEAR = 0.95  # correlation above which two parameters are only jointly identifiable


@dataclass(frozen=True, eq=False)
class Determination:
    """Standard errors and correlations of the fitted parameters."""

    names: tuple[str, ...]
    errors: FloatArray  # standard errors of ln(value); shape (k,)
    alone: FloatArray  # standard errors for known other parameters; shape (k,)
    correlation: FloatArray  # shape (k, k)
    main_row: tuple[int, ...]  # row with the largest information on each parameter, given the others
    main_share: FloatArray  # its share of the information of all rows; shape (k,)
    widening: float  # factor on the errors for correlated residuals along the curves; 1 without


def determination_of(fit: Fit, target: Target, noise: Noise, labels: tuple[str, ...]) -> Determination:
    """Standard errors at the end of a search.

    Residuals that are correlated along the curves (p < 0.01) count as fewer measurements: errors are increased by a
    factor of sqrt((1 + r)/(1 - r)).
    """
    scaled = (fit.jacobian / target.sigma[:, None])[target.rows]
    covariance = noise.covariance_scale * inverse_information(scaled)
    residuals = target.residuals(fit.friction) / noise.scale
    used = tuple(label for label, row in zip(labels, target.rows, strict=True) if row)
    together, random_limit = robust.serial_correlation(np.clip(residuals, -robust.TUNING, robust.TUNING), used)
    widening = math.sqrt((1.0 + together) / (1.0 - together)) if random_limit < together < 0.98 else 1.0
    errors = np.sqrt(np.diag(covariance))
    alone = np.sqrt(noise.covariance_scale) / np.maximum(np.linalg.norm(scaled, axis=0), 1e-150)
    correlation = covariance / np.outer(errors, errors)
    # information of a row on each parameter given the others: rows of J (J^T J)^-1
    added = (scaled @ covariance) ** 2
    share = added / np.maximum(added.sum(axis=0), 1e-300)
    rows = np.flatnonzero(target.rows)[share.argmax(axis=0)]
    chosen = tuple(int(row) for row in rows)
    alone = np.minimum(widening * alone, 1e6)
    return Determination(fit.names, widening * errors, alone, correlation, chosen, share.max(axis=0), widening)


def least_identifiable(fit: Fit, found: Determination, width: FloatArray) -> str | None:
    """The least identifiable parameter, or None if all are identifiable.

    fit, found: result of the search, and its standard errors.
    width (k,): half widths of the 95 % intervals of ln(value).
    """
    not_identifiable = [
        name in fit.pinned or share > ALONE for name, share in zip(fit.names, found.main_share, strict=True)
    ]
    width = np.where(not_identifiable, np.inf, width)
    # of two jointly identifiable parameters the one with the smaller effect on friction is removed first
    order = np.lexsort((found.alone, np.minimum(width, 10.0 * IDENTIFIABLE)))
    worst = int(order[-1])
    return fit.names[worst] if width[worst] > IDENTIFIABLE else None


def why_not_identifiable(name: str, fit: Fit, found: Determination, quantile: float, interval: FloatArray) -> str:
    """Reason why a parameter with this interval of ln(value) is not identifiable."""
    j = fit.names.index(name)
    parameter = PARAMETERS[name]
    if quantile * found.alone[j] > IDENTIFIABLE:
        width = _factor(quantile * found.alone[j])
        return f"the friction of these rows hardly depends on it; 95 % interval if the others are known: factor {width}"
    least, most = np.isfinite(interval)
    if least != most:
        end = quantity(name).text(math.exp(interval[0] if least else interval[1]), 3)
        return f"the data give only {'a lower' if least else 'an upper'} limit of {end} (95 %)"
    if found.main_share[j] > ALONE:
        return f"row {found.main_row[j] + 1} below the header is the only one with information on it"
    if name in fit.pinned:
        bound = parameter.low if fit.values[name] < math.sqrt(parameter.low * parameter.high) else parameter.high
        shown = quantity(name).text(bound, 3)
        return f"the fit is at the end of its range, {shown}: the data give no limit on that side"
    others = [k for k in range(len(fit.names)) if k != j]
    if others:
        partner = max(others, key=lambda k: abs(found.correlation[j, k]))
        if abs(found.correlation[j, partner]) > COLLINEAR:
            width, rho = _factor(quantile * found.alone[j]), found.correlation[j, partner]
            return (
                f"its correlation with {fit.names[partner]} is {rho:+.3f}; 95 % interval with known others: factor "
                f"{width}"
            )
    return f"the 95 % interval is wide: factor {_factor(quantile * found.errors[j])} in both directions"


def _factor(log_width: float) -> str:
    return f"{math.exp(log_width):.2g}" if log_width < math.log(1e3) else "more than 1000"


def intervals_by_errors(fit: Fit, noise: Noise, found: Determination) -> FloatArray:
    """Lower and upper end of the 95 % interval of each ln(value) from standard errors, shape (k, 2)."""
    here, width = np.log([fit.values[name] for name in fit.names]), noise.quantile * found.errors
    return np.column_stack([here - width, here + width])


def profile_intervals(
    solver: FrictionSolver, fit: Fit, target: Target, noise: Noise, found: Determination
) -> FloatArray:
    """Intervals as in `intervals_by_errors` from profiles of the loss on the solver (Bates & Watts 1988, section 6.1).

    One parameter is shifted, the others are optimised on the surrogate, and all rows are solved. The root of the
    deviance of the loss is 1.96 (or the quantile of Student's t) at the end of the interval. The step is adapted at
    most `MAX_PROFILE` times on each side. If `MAX_PROFILE_REACH` first steps do not suffice, or the parameter reaches
    its bound, the end on that side is infinite.
    """
    low, high = bounds_of(fit.names)
    here = np.log([fit.values[name] for name in fit.names])
    base = robust.loss(target.residuals(fit.friction) / noise.scale)
    quantile = noise.quantile * found.widening

    def roots(sides: list[_Side]) -> None:
        goals = [minimise(fit.surrogate, target, fit.scale, 10.0, {s.at: here[s.at] + s.step}) for s in sides]
        sets = [fit.surrogate.values_at(goal) for goal in goals]
        parts = solver.transformed(solver.parts([fit.values, *sets], target.rows))[1:]
        for side, values, part in zip(sides, sets, parts, strict=True):
            rise = robust.loss(target.residuals(solver.friction(part, values)) / noise.scale) - base
            # a point without a solution is outside the interval
            side.root = math.sqrt(max(robust.DEVIANCE * rise, 0.0)) if math.isfinite(rise) else math.inf

    sides = [
        _Side(j, sign, min(noise.quantile * found.errors[j], room), room)
        for j in range(len(fit.names))
        for sign, room in ((-1.0, here[j] - low[j]), (1.0, high[j] - here[j]))
    ]
    for _ in range(MAX_PROFILE):
        open_sides = [side for side in sides if not side.done]
        if not open_sides:
            break
        roots(open_sides)
        for side in open_sides:
            side.follow(quantile)
    below, above = np.array([side.end for side in sides]).reshape(-1, 2).T
    return np.column_stack([here - below, here + above])


class _Side:
    """One side of a profile: step and result."""

    def __init__(self, at: int, sign: float, size: float, room: float) -> None:
        self.at, self.sign, self.size, self.room = at, sign, max(size, 1e-6), room
        self.first = self.size
        self.root = math.nan
        self.below, self.above = (0.0, 0.0), (math.inf, math.inf)
        self.end = math.inf
        self.done = False

    @property
    def step(self) -> float:
        return self.sign * self.size

    def follow(self, quantile: float) -> None:
        """Set the next step or the end."""
        if self.root < quantile:
            self.below = (self.size, self.root)
        else:
            self.above = (self.size, self.root)
        (a, root_a), (b, root_b) = self.below, self.above
        if math.isfinite(b):
            share = (quantile - root_a) / (root_b - root_a) if math.isfinite(root_b) else 0.5
            self.end = a + (b - a) * share
            self.done = abs(self.root - quantile) < CLOSE_ROOT * quantile
        else:
            self.done = self.size >= min(self.room, MAX_PROFILE_REACH * self.first)
            self.end = self.size * quantile / self.root if self.root > (1.0 - CLOSE_ROOT) * quantile else math.inf
            self.done = self.done or math.isfinite(self.end)
        reach = self.end if math.isfinite(b) else self.size * min(max(quantile / max(self.root, 1e-3), 1.3), 2.5)
        self.size = min(reach, self.room, MAX_PROFILE_REACH * self.first)
