"""Bounded, robust least squares on the solver, with steps from the surrogate."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from ehl.common.arrays import BoolArray, FloatArray
from ehl.common.errors import ConvergenceError
from ehl.common.progress import report_progress
from regression.calibration import robust
from regression.calibration.prediction import UNSOLVED, FrictionSolver, Surrogate
from regression.calibration.setup import PARAMETERS

STEP = 0.08  # of the finite differences in ln(value)
REGION, MIN_REGION = 1.2, 3e-3  # largest trust region in ln(value), and the smallest, at which the search ends
MAX_ROUNDS = 25
SCALED = 5  # rounds in which the scale of the residuals is updated
MIN_GAIN = 0.5 * 0.05**2  # gain of the loss at which the search ends: a step of 0.05 standard errors
POOR = 0.5  # gain over the predicted gain below which the finite differences are computed again
# start points of the search on the surrogate, factor of their spread, largest region, rounds
STARTS, START_SPREAD, START_REGION, START_ROUNDS = 6, 5.0, 2.5, 3


@dataclass(frozen=True, eq=False)
class Target:
    """Measured friction of a fit."""

    # measured mu and its standard deviation (1 if estimated) [-]; shape (n,)
    friction: FloatArray
    sigma: FloatArray
    rows: BoolArray  # rows of the fit; shape (n,)
    stated: bool  # whether `sigma` is given

    def residuals(self, friction: FloatArray) -> FloatArray:
        """(mu - measured)/sigma of the rows of the fit."""
        return np.asarray(((friction - self.friction) / self.sigma)[self.rows])

    def scale(self, residuals: FloatArray, fitted: int) -> float:
        """Factor on Huber's c; at least 1e-5 of mu."""
        if self.stated:
            return 1.0
        least = 1e-5 * float(np.median(np.abs(self.friction[self.rows]) / self.sigma[self.rows]))
        return max(robust.spread(residuals, fitted), least)


@dataclass(frozen=True, eq=False)
class Fit:
    """Result of a search."""

    names: tuple[str, ...]  # fitted parameters
    values: dict[str, float]  # all values in SI units
    friction: FloatArray  # mu of all rows by the solver; shape (n,)
    jacobian: FloatArray  # d mu/d ln(value); shape (n, k)
    surrogate: Surrogate
    # scale of the residuals in Huber's loss, and that loss
    scale: float
    cost: float
    rounds: int
    pinned: tuple[str, ...]  # parameters that ended at a bound


def bounds_of(names: tuple[str, ...]) -> tuple[FloatArray, FloatArray]:
    """Bounds of ln(value), two arrays of shape (k,)."""
    return (np.log([PARAMETERS[name].low for name in names]), np.log([PARAMETERS[name].high for name in names]))


def surrogate_at(
    solver: FrictionSolver,
    values: dict[str, float],
    names: tuple[str, ...],
    rows: BoolArray,
    *,
    differences: bool = True,
) -> Surrogate:
    """The surrogate about these values.

    With `differences`, derivatives follow from finite differences of the solver; without, from fixed films.
    """
    moving = [name for name in names if name != UNSOLVED] if differences else []
    parts = [solver.transformed(solver.parts([values], rows)[0])]
    films = solver.films
    held = solver.held(values, films)
    sets, steps = [], []
    for name in moving:
        # away from the nearer bound
        middle = np.sqrt(PARAMETERS[name].low * PARAMETERS[name].high)
        step = STEP if values[name] < middle else -STEP
        sets.append({**values, name: values[name] * float(np.exp(step))})
        steps.append(step)
    slopes = np.zeros((*parts[0].shape, len(names)))
    if sets:
        parts += list(solver.transformed(solver.parts(sets, rows)))
    for k, (name, step) in enumerate(zip(moving, steps, strict=True)):
        change = parts[k + 1] - parts[0] - (solver.held(sets[k], films) - held)
        # a failed solution gives no slope
        slopes[..., names.index(name)] = np.nan_to_num(change / step)
    return Surrogate(solver, values, names, parts[0], slopes, films, held)


def minimise(
    surrogate: Surrogate,
    target: Target,
    scale: float,
    region: float,
    held: dict[int, float] | None = None,
    start: FloatArray | None = None,
) -> FloatArray:
    """ln(values) of the smallest loss on the surrogate within bounds and region, with fixed `held` ones, shape (k,)."""
    low, high = bounds_of(surrogate.names)
    here = surrogate.log_values
    start = here.copy() if start is None else start.copy()
    for j, value in (held or {}).items():
        start[j] = value
    free = [j for j in range(here.size) if j not in (held or {})]
    if not free:
        return start
    low, high = np.maximum(low, here - region)[free], np.minimum(high, here + region)[free]

    def place(x: FloatArray) -> FloatArray:
        full = start.copy()
        full[free] = x
        return full

    def standardised(x: FloatArray) -> FloatArray:
        return target.residuals(surrogate.at(place(x))) / scale

    def slopes(x: FloatArray) -> FloatArray:
        return np.asarray((surrogate.jacobian(place(x))[:, free] / target.sigma[:, None])[target.rows] / scale)

    inside = np.clip(start[free], low + 1e-9, high - 1e-9)
    found = least_squares(
        standardised, inside, slopes, bounds=(low, high), loss="huber", f_scale=robust.TUNING,
        xtol=1e-5, ftol=1e-7, gtol=1e-7, max_nfev=30,
    )  # fmt: skip
    return place(np.asarray(found.x))


def inverse_information(scaled: FloatArray) -> FloatArray:
    """(J^T J)^-1, with a variance of at most 1e12 for directions without information."""
    _, s, vt = np.linalg.svd(scaled, full_matrices=False)
    return np.asarray((vt.T * np.minimum(1.0 / np.maximum(s, 1e-150) ** 2, 1e12)) @ vt)


def best_start(
    solver: FrictionSolver, values: dict[str, float], names: tuple[str, ...], target: Target
) -> dict[str, float]:
    """Start values: the best of several searches on the surrogate with fixed films, repeated from its solution.

    Several start points are necessary as a limiting stress that is too high has no effect, and one that is too low
    hides all other parameters.
    """
    moving = [j for j, name in enumerate(names) if name != UNSOLVED]
    best, least = values, np.inf
    if not moving:
        return best
    low, high = bounds_of(names)
    cube = qmc.Sobol(len(moving), seed=0).random(8)[: STARTS - 1]
    scale = 0.0
    for _ in range(START_ROUNDS):
        surrogate = surrogate_at(solver, best, names, target.rows, differences=False)
        here = surrogate.log_values
        residuals = target.residuals(surrogate.at(here))
        # the scale of the first misfit, which may be large, keeps the loss quadratic
        scale = scale or max(target.scale(residuals, 0), float(np.sqrt(np.mean(residuals**2))))
        least = min(least, robust.loss(residuals / scale))
        tried = []
        for point in (None, *cube):
            start = here.copy()
            if point is not None:
                start[moving] = np.clip(
                    here[moving] + (2.0 * point - 1.0) * np.log(START_SPREAD), low[moving], high[moving]
                )
            found = minimise(surrogate, target, scale, START_REGION, start=start)
            tried.append((robust.loss(target.residuals(surrogate.at(found)) / scale), tuple(found)))
        _, goal = min(tried)
        there = surrogate.values_at(np.array(goal))
        mu = solver.friction(solver.transformed(solver.parts([there], target.rows)[0]), there)
        loss = robust.loss(target.residuals(mu) / scale)
        if not loss < least:
            break
        best, least = there, loss
    return best


def search(solver: FrictionSolver, values: dict[str, float], names: tuple[str, ...], target: Target) -> Fit:
    """Parameters of the smallest loss, from these start values.

    Each round solves all rows once. The surrogate starts with fixed films and is corrected along the steps. At a
    possible minimum finite differences of the solver are computed, and the search continues with them if it can.

    Raises `ConvergenceError`: the search did not converge.
    """
    region, gained = REGION, np.inf
    surrogate = surrogate_at(solver, values, names, target.rows, differences=False)
    fresh = not surrogate.moving
    for rounds in range(1, MAX_ROUNDS + 1):
        here = surrogate.log_values
        friction = surrogate.at(here)
        residuals = target.residuals(friction)
        if rounds <= SCALED:
            # constant later on, so that the loss has a minimum
            scale = target.scale(residuals, len(names))
        cost = robust.loss(residuals / scale)
        misfit = np.sqrt(np.mean((friction - target.friction)[target.rows] ** 2))
        report_progress(f"misfit {misfit:.3g}, round", rounds, MAX_ROUNDS)
        goal = minimise(surrogate, target, scale, region)
        step = np.abs(goal - here)
        foretold = cost - robust.loss(target.residuals(surrogate.at(goal)) / scale)
        if min(foretold, gained) < MIN_GAIN or region < MIN_REGION:
            # at the kinks of a limit that cuts the stress off predicted gains do not occur
            if fresh:
                jacobian = surrogate.jacobian(here)
                low, high = bounds_of(names)
                at_bound = (here - low < 1e-3) | (high - here < 1e-3)
                pinned = tuple(name for name, at in zip(names, at_bound, strict=True) if at)
                return Fit(names, surrogate.values, friction, jacobian, surrogate, scale, cost, rounds, pinned)
            surrogate, fresh = surrogate_at(solver, surrogate.values, names, target.rows), True
            region, gained = max(region, 0.1), np.inf
            continue
        moved = surrogate.values_at(goal)
        parts = solver.transformed(solver.parts([moved], target.rows)[0])
        trial = surrogate.moved(moved, parts)
        there = target.residuals(trial.at(goal))
        gain = cost - robust.loss(there / scale) if np.isfinite(there).all() else -np.inf
        if gain > 0.0:
            surrogate, gained = trial, gain
            fresh = not surrogate.moving
            region = min(2.0 * region, REGION)
            if gain < POOR * foretold and not fresh:
                surrogate, fresh = surrogate_at(solver, surrogate.values, names, target.rows), True
        else:
            # at most a quarter of the failed step
            region = 0.25 * min(region, float(step.max()))
            if not fresh:
                surrogate, fresh = surrogate_at(solver, surrogate.values, names, target.rows), True
    raise ConvergenceError("calibration_rounds", f"the search did not converge in {MAX_ROUNDS} rounds")
