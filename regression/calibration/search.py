"""Bounded, robust least squares on the solver: the surrogate takes the steps, the solver judges them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from ehl.common.arrays import BoolArray, FloatArray
from ehl.common.errors import ConvergenceError
from ehl.common.progress import report_progress
from regression.calibration import robust
from regression.calibration.parameters import PARAMETERS
from regression.calibration.prediction import FrictionSolver, Surrogate

STEP = 0.08  # of the finite differences in ln(value)
REGION, MIN_REGION = 1.2, 3e-3  # largest step in ln(value), and where the search gives up
MAX_ROUNDS = 25
SCALED = 5  # rounds in which the scale of the residuals follows them
# a gain of the loss below this is the end: a step of a twentieth of a standard error, in whatever direction
MIN_GAIN = 0.5 * 0.05**2
POOR = 0.5  # gain over the one foretold below which the finite differences are taken anew
# places the search on the surrogate begins from, within this factor; how far it may go; how often
STARTS, START_SPREAD, START_REGION, START_ROUNDS = 6, 5.0, 2.5, 3


@dataclass(frozen=True, eq=False)
class Target:
    """What is fitted to."""

    # measured mu and its standard deviation (1 where it is estimated) [-]; shape (n,)
    friction: FloatArray
    sigma: FloatArray
    rows: BoolArray  # rows that take part; shape (n,)
    stated: bool  # whether `sigma` is known

    def residuals(self, friction: FloatArray) -> FloatArray:
        """(mu - measured)/sigma of the rows that take part."""
        return np.asarray(((friction - self.friction) / self.sigma)[self.rows])

    def scale(self, residuals: FloatArray, fitted: int) -> float:
        """Scale Huber's c is multiplied with; never below a hundredth of a thousandth of mu."""
        if self.stated:
            return 1.0
        least = 1e-5 * float(np.median(np.abs(self.friction[self.rows]) / self.sigma[self.rows]))
        return max(robust.spread(residuals, fitted), least)


@dataclass(frozen=True, eq=False)
class Fit:
    """Where the search ended."""

    names: tuple[str, ...]  # fitted parameters
    values: dict[str, float]  # all values, SI
    friction: FloatArray  # mu of all rows by the solver there; shape (n,)
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

    With `differences`, each parameter that asks for new solutions is moved a little and all rows are solved; without,
    films are held.
    """
    moving = [name for name in names if solver.needs_solution(name)] if differences else []
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
        # a neighbour that failed says nothing of the slope
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
    """ln(values) of least loss on the surrogate within the bounds and the region; `held` ones stay, shape (k,)."""
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

    found = least_squares(
        standardised,
        np.clip(start[free], low + 1e-9, high - 1e-9),
        slopes,
        bounds=(low, high),
        loss="huber",
        f_scale=robust.TUNING,
        x_scale=1.0,
        xtol=1e-5,
        ftol=1e-7,
        gtol=1e-7,
        max_nfev=30,
    )
    return place(np.asarray(found.x))


def inverse_information(scaled: FloatArray) -> FloatArray:
    """(J^T J)^-1, with a variance of 1e12 for directions nothing is known of."""
    _, s, vt = np.linalg.svd(scaled, full_matrices=False)
    return np.asarray((vt.T * np.minimum(1.0 / np.maximum(s, 1e-150) ** 2, 1e12)) @ vt)


def best_start(
    solver: FrictionSolver, values: dict[str, float], names: tuple[str, ...], target: Target
) -> dict[str, float]:
    """A place to start from: the best of several searches on the surrogate with films held, solved, and once more.

    A limiting stress too high to act has no slope to follow, one too low hides all else: only a search from several
    sides leaves them behind.
    """
    moving = [j for j, name in enumerate(names) if solver.needs_solution(name)]
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
        # the first misfit is that of a wrong place: a loss that hardly bends there lets the whole of it count
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
        there = {**best, **dict(zip(names, map(float, np.exp(goal)), strict=True))}
        mu = solver.friction(solver.transformed(solver.parts([there], target.rows)[0]), there)
        loss = robust.loss(target.residuals(mu) / scale)
        if not loss < least:
            break
        best, least = there, loss
    return best


def search(solver: FrictionSolver, values: dict[str, float], names: tuple[str, ...], target: Target) -> Fit:
    """Least loss over the fitted parameters, from these values on.

    Each round solves all rows once. The surrogate begins with films held and is corrected along the steps; finite
    differences of the solver are taken where the search seems to have ended, and decide whether it has.

    Raises `ConvergenceError`: the search did not come to rest.
    """
    region, gained = REGION, np.inf
    surrogate = surrogate_at(solver, values, names, target.rows, differences=False)
    fresh = not surrogate.moving
    for rounds in range(1, MAX_ROUNDS + 1):
        here = surrogate.log_values
        friction = surrogate.at(here)
        residuals = target.residuals(friction)
        if rounds <= SCALED:
            # held later on: a loss that changes from round to round has no least value
            scale = target.scale(residuals, len(names))
        cost = robust.loss(residuals / scale)
        misfit = np.sqrt(np.mean((friction - target.friction)[target.rows] ** 2))
        report_progress(f"misfit {misfit:.3g}, round", rounds, MAX_ROUNDS)
        goal = minimise(surrogate, target, scale, region)
        step = np.abs(goal - here)
        foretold = cost - robust.loss(target.residuals(surrogate.at(goal)) / scale)
        if min(foretold, gained) < MIN_GAIN or region < MIN_REGION:
            # a limit that cuts makes kinks: there the surrogate foretells gains for ever that never come
            if fresh:
                jacobian = surrogate.jacobian(here)
                low, high = bounds_of(names)
                at_bound = (here - low < 1e-3) | (high - here < 1e-3)
                pinned = tuple(name for name, at in zip(names, at_bound, strict=True) if at)
                return Fit(names, surrogate.values, friction, jacobian, surrogate, scale, cost, rounds, pinned)
            surrogate, fresh = surrogate_at(solver, surrogate.values, names, target.rows), True
            region, gained = max(region, 0.1), np.inf
            continue
        moved = {**surrogate.values, **dict(zip(names, map(float, np.exp(goal)), strict=True))}
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
            # never farther than a quarter of the step that failed
            region = 0.25 * min(region, float(step.max()))
            if not fresh:
                surrogate, fresh = surrogate_at(solver, surrogate.values, names, target.rows), True
    raise ConvergenceError("calibration_rounds", f"the search did not come to rest in {MAX_ROUNDS} rounds")
