"""Contact of elastic bodies with given gaps: compatibility and equilibrium with compressive forces.

Find forces F >= 0 and the approach angle with, for ``g = C F + d(F) + gap - lever angle``,

    g >= 0,  F g = 0  at every point,   sum(lever F) = torque,

with a symmetric positive semidefinite compliance C and the local compliance d(F) of each point, concave and increasing.
The solution is unique. It is computed by Newton's method on d, with a primal-dual active set for each linear
complementarity problem. If that cycles, an active set with single changes is used, which always terminates.
"""

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ehl.common.arrays import FloatArray

BoolArray = NDArray[np.bool_]
Local = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""Deflection [m] and its derivative [m/N] at each point from the (positive) force at it [N]."""

Reason = Literal["", "newton_limit", "active_set_limit"]
TOLERANCE = 1e-11
NEWTON_LIMIT = 60
_FLOOR = 1e-13
_EXCHANGES = 40  # of a primal-dual active set


@dataclass(frozen=True)
class Equilibrium:
    """Solution of the contact problem."""

    force: FloatArray  # (n,) normal force at each point [N]
    angle: float  # approach angle about the axis of the levers [rad]
    # derivatives at constant set of loaded points: of the torque by the angle [N m/rad], of the forces by the torque
    # (n,) [1/m]
    stiffness: float
    rate: FloatArray
    residual: float  # maximum violation of compatibility (penetration, or gap under load) over the maximum approach [-]
    torque_residual: float  # |sum(lever force) - torque|/torque [-]
    iterations: int  # Newton steps
    exchanges: int  # linear systems solved for the active sets
    fallbacks: int  # Newton steps in which the primal-dual active set cycled
    status: Literal["converged", "failed"]
    reason: Reason  # of failure; empty otherwise


@dataclass(frozen=True)
class EquilibriumProblem:
    """One contact problem without its local compliance."""

    compliance: FloatArray  # (n, n) C [m/N]
    gap: FloatArray  # (n,) unloaded separation, at least 0 [m]
    lever: FloatArray  # (n,) lever arm of each normal force [m], positive
    torque: float  # to be carried [N m], positive
    start: FloatArray | None = None  # estimate of the forces, such as those at a similar torque


def solve_equilibrium(problems: Sequence[EquilibriumProblem], local: Local) -> list[Equilibrium]:
    """Forces and approach of mesh positions, independent problems with parallel Newton steps.

    local: local deflection and its derivative from the forces of all problems, concatenated.
    A failure is reported by ``status``; it does not raise an error.
    """
    parts = np.split(np.arange(sum(p.gap.size for p in problems)), np.cumsum([p.gap.size for p in problems])[:-1])
    runs = [_newton(problem) for problem in problems]
    force = np.concatenate([next(run) for run in runs])
    results: dict[int, Equilibrium] = {}
    while len(results) < len(runs):
        deflection, slope = local(force)
        for k, (run, at) in enumerate(zip(runs, parts, strict=True)):
            if k in results:
                continue
            try:
                force[at] = run.send((deflection[at], slope[at]))
            except StopIteration as end:
                results[k] = end.value
    return [results[k] for k in range(len(runs))]


def _newton(problem: EquilibriumProblem) -> Generator[FloatArray, tuple[FloatArray, FloatArray], Equilibrium]:
    """Newton's method on one problem; yields forces and receives the local deflection and its derivative."""
    compliance, gap, lever, torque = problem.compliance, problem.gap, problem.lever, problem.torque
    typical = torque / float(lever.sum())
    floor = _FLOOR * typical
    exchanges = fallbacks = 0
    residual, angle, stiffness = np.inf, 0.0, 0.0
    reason: Reason = "newton_limit"
    iterations = 0
    start = problem.start
    point = force = np.full(gap.size, typical) if start is None else np.maximum(start, floor)
    rate = np.zeros(gap.size)
    deflection, slope = yield point
    if start is None or not (start > 0.0).any():
        active = _touching(compliance @ force + deflection, typical, gap, lever, torque)
    else:
        active = start > 0.0
    for _ in range(NEWTON_LIMIT):
        iterations += 1
        matrix = compliance.copy()
        matrix.reshape(-1)[:: gap.size + 1] += slope
        offset = gap + deflection - slope * point
        solution = _primal_dual(matrix, offset, lever, torque, active)
        if solution is None:
            fallbacks += 1
            solution = _one_by_one(matrix, offset, lever, torque)
        if solution is None:
            reason = "active_set_limit"
            break
        force, angle, stiffness, active, count, rate = solution
        exchanges += count
        point = np.maximum(force, floor)
        deflection, slope = yield point
        overlap = lever * angle - gap - compliance @ force
        wrong = np.where(force > 0.0, np.abs(overlap - deflection), overlap)
        residual = max(float(wrong.max()), 0.0) / (angle * float(lever.max()))
        if residual < TOLERANCE:
            reason = ""
            break
    return Equilibrium(
        force=force,
        angle=angle,
        stiffness=stiffness,
        rate=rate,
        residual=residual,
        torque_residual=abs(float(lever @ force) / torque - 1.0),
        iterations=iterations,
        exchanges=exchanges,
        fallbacks=fallbacks,
        status="failed" if reason else "converged",
        reason=reason,
    )


def _touching(deflection: FloatArray, force: float, gap: FloatArray, lever: FloatArray, torque: float) -> BoolArray:
    """First active set: loaded points of independent springs with `deflection` under `force`."""
    touch, stiffness = gap / lever, force * lever / deflection
    order = np.argsort(touch)
    # torque at the angle of first contact of each further spring
    rate = np.cumsum((stiffness * lever)[order])
    carried = touch[order] * rate - np.cumsum((stiffness * gap)[order])
    return np.asarray(touch <= touch[order[np.searchsorted(carried, torque) - 1]])


_Solution = tuple[FloatArray, float, float, BoolArray, int, FloatArray]


def _linear(
    matrix: FloatArray, offset: FloatArray, lever: FloatArray, torque: float, active: BoolArray
) -> tuple[FloatArray, float, float, FloatArray]:
    """Forces on the active points (zero elsewhere), angle, dT/d(angle) and dF/dT, with all active points in contact."""
    at = active.nonzero()[0]
    arms = lever.take(at)
    sides, own = np.array([arms, offset.take(at)]).T, matrix.take(at, 0).take(at, 1)
    try:
        # by NumPy: the import of scipy.linalg takes longer than all solutions of an operating point
        inverse = np.linalg.solve(own, sides)
        stiffness, carried = (arms @ inverse).tolist()
    except np.linalg.LinAlgError:
        stiffness = carried = 0.0
    if not stiffness > 0.0:
        # a compliance that is indefinite by rounding
        inverse = np.linalg.lstsq(own, sides, rcond=None)[0]
        stiffness, carried = (arms @ inverse).tolist()
    angle = (torque + carried) / stiffness
    force, rate = np.zeros((2, offset.size))
    force[at] = angle * inverse[:, 0] - inverse[:, 1]
    rate[at] = inverse[:, 0] / stiffness
    return force, angle, stiffness, rate


def _primal_dual(
    matrix: FloatArray, offset: FloatArray, lever: FloatArray, torque: float, active: BoolArray
) -> _Solution | None:
    """All points in tension leave and all penetrating points enter at once; None without convergence."""
    for count in range(1, _EXCHANGES + 1):
        force, angle, stiffness, rate = _linear(matrix, offset, lever, torque, active)
        following = np.where(active, force > 0.0, matrix @ force + offset < lever * angle)
        if following.tobytes() == active.tobytes():
            return force, angle, stiffness, active, count, rate
        if not np.count_nonzero(following):
            return None
        active = following
    return None


def _one_by_one(matrix: FloatArray, offset: FloatArray, lever: FloatArray, torque: float) -> _Solution | None:
    """Primal active set from a feasible point: the energy decreases with each change, so that no set repeats."""
    active = np.ones(offset.size, bool)
    force = np.full(offset.size, torque / float(lever.sum()))
    for count in range(1, 20 * offset.size + 1):
        target, angle, stiffness, rate = _linear(matrix, offset, lever, torque, active)
        pulling = active & (target <= 0.0)
        if pulling.any():
            share = np.full(offset.size, np.inf)
            share[pulling] = force[pulling] / (force[pulling] - target[pulling])
            first = int(np.argmin(share))
            force = force + share[first] * (target - force)
            force[first], active[first] = 0.0, False
            continue
        force = target
        separation = np.where(active, 0.0, matrix @ force + offset - lever * angle)
        deepest = int(np.argmin(separation))
        if separation[deepest] >= -1e-15 * angle * float(lever.max()):
            return force, angle, stiffness, active, count, rate
        active[deepest] = True
    return None
