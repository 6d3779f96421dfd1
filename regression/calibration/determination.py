"""Identifiability of each parameter: standard errors, correlations, profile intervals, and a note in words."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.common.quantities import quantity
from regression.calibration import robust
from regression.calibration.parameters import PARAMETERS
from regression.calibration.prediction import FrictionSolver
from regression.calibration.robust import Noise
from regression.calibration.search import Fit, Target, bounds_of, inverse_information, minimise

# half width of the 95 % interval of ln(value): up to a factor of 1.5 is a value, up to 3 a weak one, beyond none
DETERMINED, IDENTIFIABLE = math.log(1.5), math.log(3.0)
ALONE = 0.9  # share of what is known of a parameter that may come from one row
MAX_PROFILE, MAX_PROFILE_REACH = 5, 6.0  # solutions of all rows for each side of a profile; over the first step
CLOSE_ROOT = 0.1  # of the quantile: near enough to interpolate
COLLINEAR = 0.95  # correlation above which two parameters are identifiable together only


@dataclass(frozen=True, eq=False)
class Determination:
    """Standard errors and correlations of the fitted parameters."""

    names: tuple[str, ...]
    errors: FloatArray  # standard errors of ln(value); shape (k,)
    alone: FloatArray  # the same if all other parameters were known; shape (k,)
    correlation: FloatArray  # shape (k, k)
    main_row: tuple[int, ...]  # row that adds most to the information on each parameter, given the others
    main_share: FloatArray  # its share of the information of all rows; shape (k,)
    widening: float  # factor on the errors for residuals that go together along the curves; 1 without


def determination_of(fit: Fit, target: Target, noise: Noise, labels: tuple[str, ...]) -> Determination:
    """Standard errors at the end of a search.

    Residuals whose neighbours along the curves go together (p < 0.01) count as fewer measurements:
    errors grow by sqrt((1 + r)/(1 - r)).
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
    # what a row adds to each parameter beside the others: rows of J (J^T J)^-1
    added = (scaled @ covariance) ** 2
    share = added / np.maximum(added.sum(axis=0), 1e-300)
    rows = np.flatnonzero(target.rows)[share.argmax(axis=0)]
    return Determination(
        fit.names,
        widening * errors,
        np.minimum(widening * alone, 1e6),
        correlation,
        tuple(int(row) for row in rows),
        share.max(axis=0),
        widening,
    )


def least_identifiable(fit: Fit, found: Determination, width: FloatArray) -> str | None:
    """The least identifiable parameter, if it is not identifiable at all; None where all are.

    fit, found: the search, and what it says of its end.
    width (k,): half widths of the 95 % intervals of ln(value).
    """
    not_identifiable = [
        name in fit.pinned or share > ALONE for name, share in zip(fit.names, found.main_share, strict=True)
    ]
    width = np.where(not_identifiable, np.inf, width)
    # of two that are known together only, the one that moves the friction least goes first
    order = np.lexsort((found.alone, np.minimum(width, 10.0 * IDENTIFIABLE)))
    worst = int(order[-1])
    return fit.names[worst] if width[worst] > IDENTIFIABLE else None


def why_not_identifiable(
    name: str, fit: Fit, found: Determination, quantile: float, interval: ParameterInterval | None = None
) -> str:
    """Why a parameter is not identifiable, in words."""
    j = fit.names.index(name)
    parameter = PARAMETERS[name]
    if quantile * found.alone[j] > IDENTIFIABLE:
        return (
            f"hardly moves the friction of these rows: even with all else known its 95 % interval would span a factor "
            f"of {_factor(quantile * found.alone[j])} both ways"
        )
    if interval is not None and math.isfinite(interval.low) != math.isfinite(interval.high):
        least = math.isfinite(interval.low)
        end = quantity(parameter.name).text(math.exp(interval.low if least else interval.high), 3)
        return f"they say only that it is at {'least' if least else 'most'} {end} (95 %)"
    if found.main_share[j] > ALONE:
        return f"rests on row {found.main_row[j] + 1} below the header alone; no other row confirms it"
    if name in fit.pinned:
        bound = parameter.low if fit.values[name] < math.sqrt(parameter.low * parameter.high) else parameter.high
        shown = quantity(parameter.name).text(bound, 3)
        return f"the fit runs to the end of its range, {shown}: the data set no limit on that side"
    others = [k for k in range(len(fit.names)) if k != j]
    if others:
        partner = max(others, key=lambda k: abs(found.correlation[j, k]))
        if abs(found.correlation[j, partner]) > COLLINEAR:
            return (
                f"is known only together with {fit.names[partner]} (correlation {found.correlation[j, partner]:+.3f}): "
                f"alone its interval would span a factor of {_factor(quantile * found.alone[j])}"
            )
    width = _factor(quantile * found.errors[j])
    return f"its 95 % interval spans a factor of {width} both ways beside the other parameters"


def _factor(log_width: float) -> str:
    return f"{math.exp(log_width):.2g}" if log_width < math.log(1e3) else "more than 1000"


@dataclass(frozen=True)
class ParameterInterval:
    """95 % interval of one ln(value); an end the data do not set is infinite."""

    low: float
    high: float

    @property
    def half_width(self) -> float:
        """Half of it; infinite where one end is."""
        return 0.5 * (self.high - self.low)


def within_range(name: str, interval: ParameterInterval) -> ParameterInterval:
    """The interval with the range of the parameter where the data set no end."""
    low, high = math.log(PARAMETERS[name].low), math.log(PARAMETERS[name].high)
    return ParameterInterval(max(interval.low, low), min(interval.high, high))


def intervals_by_errors(fit: Fit, noise: Noise, found: Determination) -> list[ParameterInterval]:
    """Intervals by standard errors."""
    here = np.log([fit.values[name] for name in fit.names])
    width = noise.quantile * found.errors
    return [ParameterInterval(float(a), float(b)) for a, b in zip(here - width, here + width, strict=True)]


def profile_intervals(
    solver: FrictionSolver, fit: Fit, target: Target, noise: Noise, found: Determination
) -> list[ParameterInterval]:
    """Intervals by profiles of the loss on the solver (Bates & Watts 1988, section 6.1).

    One parameter is set aside, the others are chosen by the surrogate, all rows are solved, and the deviance of the
    loss is taken. Its root is 1.96 (or Student's quantile) at the end of the interval; the step is drawn out or in
    until it is, at most `MAX_PROFILE_STEPS` times a side. Where even `MAX_PROFILE_REACH` such steps do not get
    there, or a bound of the parameter comes first, the data set no limit on that side.
    """
    low, high = bounds_of(fit.names)
    here = np.log([fit.values[name] for name in fit.names])
    base = robust.loss(target.residuals(fit.friction) / noise.scale)
    quantile = noise.quantile * found.widening

    def roots(sides: list[_Side]) -> None:
        sets = [
            _with(fit, minimise(fit.surrogate, target, fit.scale, 10.0, {s.at: here[s.at] + s.step})) for s in sides
        ]
        parts = solver.transformed(solver.parts([fit.values, *sets], target.rows))[1:]
        for side, values, part in zip(sides, sets, parts, strict=True):
            rise = robust.loss(target.residuals(solver.friction(part, values)) / noise.scale) - base
            # a place that cannot be solved is beyond any limit
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
    return [
        ParameterInterval(float(here[j] - sides[2 * j].end), float(here[j] + sides[2 * j + 1].end))
        for j in range(len(fit.names))
    ]


class _Side:
    """One side of a profile: how far to step, and what was found there."""

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
        """The next step, or the end."""
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


def _with(fit: Fit, log_values: FloatArray) -> dict[str, float]:
    return {**fit.values, **dict(zip(fit.names, map(float, np.exp(log_values)), strict=True))}
