"""What the data tell of each parameter: standard errors, correlations, profile intervals, and a verdict in words."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from regression.calibration import robust
from regression.calibration.parameters import PARAMETERS
from regression.calibration.prediction import FrictionSolver
from regression.calibration.robust import Noise
from regression.calibration.search import Fit, Target, bounds_of, inverse_information, minimise

Array = NDArray[np.float64]

# half width of the 95 % interval of ln(value): up to a factor of 1.5 is a value, up to 3 a weak one, beyond none
DETERMINED, TOLD = math.log(1.5), math.log(3.0)
ALIKE = 0.95  # correlation above which two parameters are told to be known together only


@dataclass(frozen=True, eq=False)
class Determination:
    """Standard errors and correlations of the fitted parameters.

    Parameters
    ----------
    names : tuple of str
    errors : ndarray, shape (k,)
        Standard errors of ln(value).
    alone : ndarray, shape (k,)
        The same if all other parameters were known.
    correlation : ndarray, shape (k, k)
    widening : float
        Factor on the errors for residuals that go together along the curves; 1 without.
    """

    names: tuple[str, ...]
    errors: Array
    alone: Array
    correlation: Array
    widening: float


def determination_of(fit: Fit, target: Target, noise: Noise, labels: tuple[str, ...]) -> Determination:
    """Standard errors at the end of a search.

    Residuals whose neighbours along the curves go together (beyond chance, p < 0.01) count as fewer measurements:
    errors grow by sqrt((1 + r)/(1 - r)).
    """
    scaled = (fit.jacobian / target.sigma[:, None])[target.rows]
    covariance = noise.covariance_scale * inverse_information(scaled)
    residuals = target.residuals(fit.friction) / noise.scale
    used = tuple(label for label, row in zip(labels, target.rows, strict=True) if row)
    together, chance = robust.serial_correlation(np.clip(residuals, -robust.TUNING, robust.TUNING), used)
    widening = math.sqrt((1.0 + together) / (1.0 - together)) if chance < together < 0.98 else 1.0
    errors = np.sqrt(np.diag(covariance))
    alone = np.sqrt(noise.covariance_scale) / np.maximum(np.linalg.norm(scaled, axis=0), 1e-150)
    correlation = covariance / np.outer(errors, errors)
    return Determination(fit.names, widening * errors, np.minimum(widening * alone, 1e6), correlation, widening)


def least_known(fit: Fit, found: Determination, quantile: float) -> str | None:
    """The parameter the data tell least of, if they do not tell it at all; None where all are told."""
    width = quantile * found.errors
    width = np.where([name in fit.pinned for name in fit.names], np.inf, width)
    # of two that are known together only, the one that moves the friction least goes first
    order = np.lexsort((found.alone, np.minimum(width, 10.0 * TOLD)))
    worst = int(order[-1])
    return fit.names[worst] if width[worst] > TOLD else None


def why_untold(name: str, fit: Fit, found: Determination, quantile: float) -> str:
    """Why the data do not tell a parameter, in words."""
    j = fit.names.index(name)
    parameter = PARAMETERS[name]
    if quantile * found.alone[j] > TOLD:
        return (
            f"hardly moves the friction of these rows: even with all else known its 95 % interval would span a factor "
            f"of {_factor(quantile * found.alone[j])} both ways"
        )
    if name in fit.pinned:
        bound = parameter.low if fit.values[name] < math.sqrt(parameter.low * parameter.high) else parameter.high
        shown = f"{bound * parameter.shown:.3g} {parameter.shown_unit}".removesuffix(" -")
        return f"the fit runs to the end of its range, {shown}: the data set no limit on that side"
    others = [k for k in range(len(fit.names)) if k != j]
    if others:
        partner = max(others, key=lambda k: abs(found.correlation[j, k]))
        if abs(found.correlation[j, partner]) > ALIKE:
            return (
                f"is known only together with {fit.names[partner]} (correlation {found.correlation[j, partner]:+.3f}): "
                f"alone it would be told within a factor of {_factor(quantile * found.alone[j])}"
            )
    width = _factor(quantile * found.errors[j])
    return f"its 95 % interval spans a factor of {width} both ways beside the other parameters"


def _factor(log_width: float) -> str:
    return f"{math.exp(log_width):.2g}" if log_width < math.log(1e3) else "more than 1000"


def profile_intervals(
    solver: FrictionSolver, fit: Fit, target: Target, noise: Noise, found: Determination
) -> list[tuple[float, float]]:
    """95 % intervals of ln(value) by profiles of the loss on the solver.

    At both ends of the interval by standard errors the others are chosen by the surrogate and all rows solved; the
    signed root of the deviance, drawn as a parabola through the three points, says where the interval really ends
    (Bates & Watts 1988, section 6.1).
    """
    low, high = bounds_of(fit.names)
    here = np.log([fit.values[name] for name in fit.names])
    base = robust.loss(target.residuals(fit.friction) / noise.scale)
    ends = []
    for j in range(len(fit.names)):
        sides = []
        for sign, bound in ((-1.0, low[j]), (1.0, high[j])):
            step = sign * min(noise.quantile * found.errors[j], abs(bound - here[j]))
            sides.append(step if abs(step) > 1e-9 else sign * 1e-9)
        ends.append((j, sides))
    sets = [
        _with(fit, minimise(fit.surrogate, target, fit.scale, 10.0, {j: here[j] + s})) for j, ss in ends for s in ss
    ]
    parts = solver.transformed(solver.parts([fit.values, *sets], target.rows))[1:]
    intervals = []
    for j, sides in ends:
        roots = []
        for k, step in enumerate(sides):
            values, part = sets[2 * j + k], parts[2 * j + k]
            rise = robust.loss(target.residuals(solver.friction(part, values)) / noise.scale) - base
            deviance = rise * robust.DEVIANCE / found.widening**2
            roots.append(math.copysign(math.sqrt(max(deviance, 0.0)), step))
        intervals.append(_interval(here[j], sides, roots, noise.quantile, found.errors[j]))
    return [(max(a, low[j]), min(b, high[j])) for j, (a, b) in enumerate(intervals)]


def _with(fit: Fit, log_values: Array) -> dict[str, float]:
    return {**fit.values, **dict(zip(fit.names, map(float, np.exp(log_values)), strict=True))}


def _interval(
    centre: float, steps: list[float], roots: list[float], quantile: float, error: float
) -> tuple[float, float]:
    """Where the signed root of the deviance reaches the quantile on both sides."""
    ends = []
    for side, (step, root) in enumerate(zip(steps, roots, strict=True)):
        # slope and curvature of root(step) through this end, the centre and the other end
        other, other_root = steps[1 - side], roots[1 - side]
        if not np.isfinite(root) or abs(root) < 0.05:
            ends.append(centre + math.copysign(quantile * error, step))
            continue
        matrix = np.array([[step, step * step], [other, other * other]])
        slope, bend = np.linalg.solve(matrix, [root, other_root]) if np.isfinite(other_root) else (root / step, 0.0)
        wanted = math.copysign(quantile, step)
        inside = slope * slope + 4.0 * bend * wanted
        if slope > 0.0 and inside > 0.0:
            end = 2.0 * wanted / (slope + math.sqrt(inside))
        else:
            end = step * quantile / abs(root)
        # a parabola is no witness far outside its points
        ends.append(centre + float(np.clip(abs(end), 0.3 * abs(step), 3.0 * abs(step))) * math.copysign(1.0, step))
    return ends[0], ends[1]
