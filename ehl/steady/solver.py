"""Smooth, steady, isothermal line contact: the method in one screen.

scene -> (neighbour | path from an easy contact) -> mesh graded for what was found -> three nested grids
-> Richardson values with their errors.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ehl.contact import LineContact
from ehl.lubricant import Lubricant
from ehl.steady.estimate import Extrapolation, extrapolate
from ehl.steady.mesh import grade
from ehl.steady.newton import Grid, Level, NewtonFailure, Unknowns, solve_level
from ehl.steady.outputs import ShearLaw, friction_inlet, numbers_of
from ehl.steady.path import PathReport, cold_path, features_of_level, grid_for, transfer
from ehl.steady.result import SteadyResult
from ehl.steady.scaling import Scene, scene_of

Array = NDArray[np.float64]
Accuracy = Literal["fast", "standard", "reference"]

# Coarsest of the three nested grids, and the error estimate above which a finer grid is added.
COARSEST: dict[str, int] = {"fast": 33, "standard": 49, "reference": 129}
TOLERANCE: dict[str, float] = {"fast": 5e-3, "standard": 2e-3, "reference": 2e-4}
MOST_NODES = 2100
PATH_NODES = 97
REASONS = ("path_stalled", "path_limit", "singular_matrix", "damping_exhausted", "iteration_limit", "start_infeasible")


def solve_steady(
    contact: LineContact,
    lubricant: Lubricant,
    *,
    accuracy: Accuracy = "standard",
    start: SteadyResult | None = None,
    film_log_viscosity_offset: Callable[[Array], Array] | None = None,
) -> SteadyResult:
    """Solve the smooth, steady line contact; isothermal unless an offset is given.

    Reynolds d/dx(rho h^3/(12 eta) S dp/dx) = u_r d(rho h)/dx with p = dp/dx = 0 at the exit, elastic film and load.

    Parameters
    ----------
    contact, lubricant
        SI records.
    accuracy : {"fast", "standard", "reference"}
        Films and friction to about 1 %, 0.5 %, 0.05 % (the measured errors are far below).
    start : SteadyResult, optional
        Result of a neighbouring contact.
    film_log_viscosity_offset : callable, optional
        Maps x [m] (array) to what is added to ln(eta) there, e.g. by the film temperature. Must be continuous.

    Returns
    -------
    SteadyResult
        Never raises for a contact that cannot be solved: status "failed" and a reason of `REASONS`.
    """
    b = contact.half_width
    offset = None
    if film_log_viscosity_offset is not None:
        given = film_log_viscosity_offset

        def offset(x: Array) -> Array:
            return np.asarray(given(x * b), dtype=float)

    scene = scene_of(contact, lubricant, offset)
    report = PathReport()
    fallbacks: list[str] = []
    shear = shear_law(contact, lubricant)
    try:
        near = _near(scene, start, report, fallbacks)
        levels, limit = _nested(scene, near, shear, accuracy, report, fallbacks)
    except NewtonFailure as failure:
        return _failed(failure.reason, report)
    return _result(contact, scene, shear, levels, limit, near, report, tuple(fallbacks))


def _near(scene: Scene, start: SteadyResult | None, report: PathReport, fallbacks: list[str]) -> Level:
    """A solution of the scene on a coarse grid graded for it."""
    if start is not None and start.coarse is not None:
        try:
            level = solve_level(start.coarse.grid, scene, start.coarse.unknowns, tolerance=1e-4, max_iterations=12)
            report.iterations += level.iterations
            return _settled(scene, level, report)
        except NewtonFailure as failure:
            report.iterations += failure.iterations
            fallbacks.append("neighbour_too_far")
    try:
        return _settled(scene, cold_path(scene, PATH_NODES, report), report)
    except NewtonFailure:
        fallbacks.append("finer_path")
    return _settled(scene, cold_path(scene, 2 * PATH_NODES - 1, report), report)


def _settled(scene: Scene, level: Level, report: PathReport) -> Level:
    """Re-grade until the mesh fits the solution on it."""
    for _ in range(4):
        features = features_of_level(level)
        if features.close_to(level.features):
            break
        grid = grid_for(features, level.x.size)
        report.grids += 1
        level = solve_level(grid, scene, transfer(level, grid), tolerance=1e-4)
        report.iterations += level.iterations
    return level


def _nested(
    scene: Scene, near: Level, shear: ShearLaw, accuracy: Accuracy, report: PathReport, fallbacks: list[str]
) -> tuple[list[Level], Extrapolation]:
    """Solutions on nested grids of one grading, at least three, until the error estimate is met."""
    grading = grade(features_of_level(near))
    nodes = COARSEST[accuracy]
    levels: list[Level] = []
    while True:
        grid = Grid.of(grading, grading.points(2 * nodes - 1))
        guess = transfer(levels[-1] if levels else near, grid)
        if len(levels) >= 2:
            guess = _corrected(levels, guess)
        nodes = 2 * nodes - 1
        try:
            level = solve_level(grid, scene, guess)
        except NewtonFailure as failure:
            report.iterations += failure.iterations
            if len(levels) >= 3:
                fallbacks.append("tolerance_not_met")
                break
            if nodes > MOST_NODES // 4:
                raise
            levels.clear()
            fallbacks.append("coarse_grid_dropped")
            continue
        report.iterations += level.iterations
        report.grids += 1
        levels.append(level)
        if len(levels) >= 3:
            limit = extrapolate([numbers_of(level, shear).as_array() for level in levels])
            if np.all(limit.relative()[:3] < TOLERANCE[accuracy]):
                break
            if nodes > MOST_NODES:
                fallbacks.append("tolerance_not_met")
                break
    return levels, limit


def _corrected(levels: list[Level], guess: Unknowns) -> Unknowns:
    """Start on the third grid: the second one plus a quarter of its change from the first."""
    first, second = levels[-2].unknowns, levels[-1].unknowns
    change = 0.25 * (second.pressure[::2] - first.pressure)
    coarse_index = np.arange(change.size) * 4.0
    pressure = guess.pressure + np.interp(np.arange(guess.pressure.size), coarse_index, change)
    return Unknowns(
        pressure,
        guess.h00 + 0.25 * (second.h00 - first.h00),
        guess.flow + 0.25 * (second.flow - first.flow),
        guess.stretch + 0.25 * (second.stretch - first.stretch),
    )


def shear_law(contact: LineContact, lubricant: Lubricant) -> ShearLaw:
    """Dimensionless shear law of the film."""
    eyring = lubricant.rheology == "eyring"
    stress = lubricant.eyring_stress if eyring else contact.pressure_hertz
    rate = lubricant.viscosity_inlet * contact.speed_sliding * contact.radius_equivalent
    return ShearLaw(
        eyring,
        stress / contact.pressure_hertz,
        rate / (stress * contact.half_width**2),
        lubricant.limiting_shear_coefficient,
    )


def _result(
    contact: LineContact,
    scene: Scene,
    shear: ShearLaw,
    levels: list[Level],
    limit: Extrapolation,
    near: Level,
    report: PathReport,
    fallbacks: tuple[str, ...],
) -> SteadyResult:
    values, relative = limit.values, limit.relative()
    fine = levels[-1]
    b, p_h = contact.half_width, contact.pressure_hertz
    height = b * b / contact.radius_equivalent
    skipped = ["heat: isothermal"] if scene.offset is None else []
    return SteadyResult(
        status="converged",
        reason="",
        x=b * fine.x,
        pressure=p_h * fine.unknowns.pressure,
        film=height * fine.film,
        shear_stress=p_h * shear.stress_at(fine.log_eta, fine.film, fine.unknowns.pressure),
        film_central=height * float(values[0]),
        film_min=height * float(values[1]),
        friction_fluid=float(values[2]),
        pressure_max=p_h * float(values[3]),
        flow=height * float(values[4]),
        rolling_traction=b / contact.radius_equivalent * float(values[6]),
        film_central_error=float(relative[0]),
        film_min_error=float(relative[1]),
        friction_error=float(relative[2]),
        pressure_max_error=float(relative[3]),
        iterations=report.iterations,
        nodes=fine.x.size,
        mass_residual=fine.mass_residual,
        load_residual=fine.load_residual,
        fallbacks=fallbacks,
        skipped=tuple(skipped),
        x_inlet=b * friction_inlet(fine),
        x_exit=b * float(values[5]),
        coarse=near,
    )


def _failed(reason: str, report: PathReport) -> SteadyResult:
    """Result without a solution: zeros with infinite error, so that no NaN travels on."""
    empty = np.zeros(0)
    return SteadyResult(
        "failed", reason, empty, empty, empty, empty, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        math.inf, math.inf, math.inf, math.inf, report.iterations, 0, math.inf, math.inf, 0.0, 0.0,
    )  # fmt: skip
