"""Start-up of the coarsest mesh until roughness, macroscopic pressure and heat are settled, with bounded work.

The work is checked every few b. If even the shortest windows would exceed the bound of the plan, the run continues with
the reduced plan (`reduced_plan`), or ends if another model can replace it. Work is counted in iterations, not timed,
so that results do not depend on the machine.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError
from ehl.rough.accuracy import FRONT_STARTUP, SETTLING, RunPlan, reduced_plan
from ehl.rough.averaging import Window
from ehl.rough.multilevel import FINER_STEP, least_levels
from ehl.rough.scaling import RunProblem

FIRST_LOOK = 0.3  # travel of the first check, before the roughness and most of the work [b]
WARMING_ROUNDS, WARMING_TRAVEL = 2, 0.5  # rounds of preheating; travel for its mean flux [b]


def start_up(
    window: Window, plan: RunPlan, levels: int, correlation_length: float, problem: Callable[[RunPlan], RunProblem]
) -> tuple[RunPlan, FloatArray | None, float]:
    """Advance the coarsest mesh until it is settled.

    window: of the coarsest mesh.
    levels: number of meshes of the accuracy.
    correlation_length: of the roughness [b].
    problem: returns the problem of the coarsest mesh for a plan.
    Returns: plan, reduced if its bound requires it; flux: mean heat flux into the surfaces for the finer meshes [W/m2],
    shape (2, n); warming: travel of their preheating [b].
    Raises `ConvergenceError`: "mesh_budget": the shortest run would take more than `plan.give_up`.
    """
    thermal = window.run.problem.settings.thermal
    bounded = plan.window_max > plan.window_min
    per_half_width = window.run.problem.units.steps_per_half_width
    wait = plan.settling - SETTLING if thermal and bounded and not plan.preheating else 0.0
    steps = round(plan.startup * per_half_width) + round(wait * per_half_width)
    look = round(FRONT_STARTUP * per_half_width) if bounded else steps
    first = round(FIRST_LOOK * per_half_width) if bounded and math.isfinite(plan.give_up) else look
    while window.steps < steps:
        before, piece = window.work, min(look if window.steps else first, steps - window.steps) / per_half_width
        window.start(piece)
        left = (steps - window.steps) / per_half_width
        rate = (window.work - before) / piece
        if bounded and not plan.reduced and window.work + least_work(plan, rate, left, levels) > plan.bound:
            plan = reduced_plan(plan, correlation_length)
            window.batch = plan.batch
            window.run = window.run.branch(problem(plan))
            steps = round(plan.startup * per_half_width)
            left = (steps - window.steps) / per_half_width
        if bounded and window.work + least_work(plan, rate, left, levels) > plan.give_up:
            raise ConvergenceError("mesh_budget", "a mesh that resolves the roughness takes more work than allowed")
    if plan.preheating:
        return plan, warmed(window, plan), plan.preheating
    if thermal and bounded:
        # the finer meshes are preheated by the flux of the coarsest over the same travel
        return plan, window.mean_flux(WARMING_TRAVEL), window.run.travel
    return plan, None, 0.0


def least_work(plan: RunPlan, rate: float, left: float, levels: int) -> float:
    """Work of the rest of the start-up and one block on the smallest number of meshes.

    rate: work per b of travel on the coarsest mesh.
    left: remaining travel of the start-up [b].
    levels: number of meshes of the accuracy.
    """
    least = least_levels(plan, levels)
    return rate * left + sum(
        rate * (4.0 * FINER_STEP) ** k * (SETTLING * (least - max(k, 1)) + plan.block) for k in range(least)
    )


def warmed(window: Window, plan: RunPlan) -> FloatArray:
    """Preheat the surfaces of a run by its mean heat flux, in place of a longer start-up; returns that flux."""
    for _ in range(WARMING_ROUNDS):
        flux = window.mean_flux(WARMING_TRAVEL)
        window.run.preheat(plan.preheating, flux)
    return window.mean_flux(WARMING_TRAVEL)
