"""Friction coefficient of one lubricated contact: smooth film, heat, roughness and their errors."""

import math
import time
from dataclasses import replace

import numpy as np

from ehl.common.errors import ConvergenceError
from ehl.common.threads import one_thread
from ehl.elastic_shear import elastic_shear, rubbing_friction
from ehl.inputs import ContactProblem
from ehl.result import ContactResult
from ehl.rough import mixed
from ehl.rough.dry_limit import DryLimit, dry_limit, flash_of_rubbing
from ehl.smooth.thermal import isothermal_fallback, solve_smooth
from ehl.validity import checked

NO_INLET_HEAT = "heat of the pressure-driven flow neglected: no thermal solution of the smooth contact"
ELASTIC_REPORTED = 1e-3  # smallest neglected elastic part of mu that is reported
# results of a transient solution
_OF_RUN = (
    *("status", "reason", "friction_coefficient", "friction_fluid", "friction_asperity", "film_min", "pressure_max"),
    *("asperity_load_share", "roughness_load_share", "temperature_film_max", "temperature_flash", "film_error"),
    *("friction_error", "mesh_error", "statistical_error", "realisation_error"),
    *("friction_boundary_half", "friction_boundary_double"),
)


@one_thread
def solve_contact(
    problem: ContactProblem, start: ContactResult | None = None, *, window: float | None = None
) -> ContactResult:
    """Solve one contact; a failure to converge is a status, not an exception.

    start: solution of a similar contact for a warm start.
    window: averaging window of transient friction [b]; default: until the interval of mu is reached. Comparisons by
        small differences require a common window.
    Raises `InputError`: a profile or a number of the surfaces is invalid.
    """
    clock = time.perf_counter()
    result = _solve(problem, start, window)
    return replace(result, problem=problem, seconds=time.perf_counter() - clock)


def _solve(problem: ContactProblem, start: ContactResult | None, window: float | None) -> ContactResult:
    contact, lubricant = problem.line, problem.lubricant
    smooth = solve_smooth(
        contact,
        lubricant,
        problem.bodies,
        temperature_bulk=problem.temperature_bulk,
        thermal=problem.model.thermal,
        accuracy=problem.model.accuracy,
        start=start.isothermal if start is not None else None,
        start_heat=start.heat if start is not None else None,
    )
    # a transient solution has its own heat balance and can start from the isothermal film
    lost_heat = smooth.status != "converged" and problem.rough and smooth.isothermal.status == "converged"
    if lost_heat:
        smooth = isothermal_fallback(smooth)
    if smooth.status != "converged":
        return ContactResult("failed", smooth.reason, iterations=smooth.iterations)
    # one entry per subject: the last, which has the best estimate
    film, skipped = smooth.film, list({text.partition(":")[0]: text for text in smooth.skipped}.values())
    elastic = elastic_shear(film.x, film.pressure, film.film, film.shear_stress, contact, lubricant)
    if elastic.left_out > ELASTIC_REPORTED:
        skipped.append(f"elastic shear: estimated change of friction below {100.0 * elastic.left_out:.2g} %")
    friction = smooth.friction_fluid * elastic.ratio
    film = replace(film, shear_stress=elastic.stress, friction_fluid=film.friction_fluid * elastic.ratio)
    # error of the heat balance, which does not include the elastic part of the shear
    cooled = 0.0
    if elastic.ratio != 1.0 and smooth.isothermal.friction_fluid > 0.0:
        cooling = max(1.0 - smooth.friction_fluid / smooth.isothermal.friction_fluid, 0.0)
        cooled = abs(1.0 - elastic.ratio) * cooling
    # an effect that was neglected because of an estimate is part of the error
    left_out = smooth.estimate if smooth.heat is None else None

    result = ContactResult(
        status="converged",
        reason="",
        friction_coefficient=friction,
        friction_fluid=friction,
        friction_asperity=0.0,
        film_central=film.film_central,
        film_min=film.film_min,
        pressure_max=film.pressure_max,
        film_ratio=math.inf,
        asperity_load_share=0.0,
        roughness_load_share=0.0,
        rolling_traction=film.rolling_traction,
        temperature_film_max=smooth.temperature_film_max,
        temperature_flash=smooth.temperature_flash,
        film_error=smooth.film_error + (left_out.film_change if left_out else 0.0),
        friction_error=smooth.friction_error
        + (left_out.friction_change if left_out else 0.0)
        + elastic.left_out
        + elastic.error
        + cooled,
        mesh_error=smooth.friction_error,
        statistical_error=0.0,
        realisation_error=0.0,
        notes=elastic.notes(),
        iterations=smooth.iterations,
        film=film,
        isothermal=smooth.isothermal,
        heat=smooth.heat,
    )
    if problem.rough:
        result = _rough(result, problem, skipped, heated=lost_heat, window=window)
    else:
        skipped.append("roughness and time: both surfaces are smooth")
    if result.status == "failed":
        return result
    notes = tuple(dict.fromkeys((*mixed.profile_notes(problem.surface), *result.notes)))
    result = replace(result, notes=notes, skipped=tuple(skipped))
    return checked(result, problem, rounds_left=smooth.rounds_left and not lost_heat)


def _rough(
    smooth: ContactResult, problem: ContactProblem, skipped: list[str], *, heated: bool, window: float | None
) -> ContactResult:
    """Transient solution with roughness, unless the film is so thick or so thin that an estimate suffices."""
    assert smooth.isothermal is not None
    contact, lubricant, model = problem.line, problem.lubricant, problem.model
    rms, height = mixed.roughness_heights(problem.surface, contact)
    known = mixed.SmoothFriction()
    if not heated:
        assert smooth.film is not None
        # the film with thermal effects separates the surfaces; at 20 m/s it is half as thick as the isothermal one
        known = mixed.SmoothFriction(
            smooth.film.film_central, mixed.film_stress_ratio(smooth.friction_fluid, contact, lubricant)
        )
        if height > 0.0 and not mixed.roughness_matters(known.film / height, model, known.stress_ratio):
            effect = mixed.roughness_effect(known.film / height, known.stress_ratio)
            skipped.append(f"roughness and time: estimated change of friction {100.0 * effect:.2g} %")
            film_ratio = smooth.isothermal.film_central / rms
            return replace(smooth, film_ratio=film_ratio, friction_error=smooth.friction_error + effect)
    thermal = heated or smooth.heat is not None
    dry = dry_limit(problem, smooth.isothermal.film_central, smooth.friction_fluid)
    if dry is not None:
        skipped.append(f"film: {dry.note}")
        return _dry(smooth, dry, problem, thermal=thermal)
    try:
        film_heat = mixed.film_heat_of(smooth.heat, problem.line, lubricant)
        run = mixed.solve_mixed(problem, known, thermal=thermal, film_heat=film_heat, window=window)
    except ConvergenceError as error:
        return ContactResult("failed", error.reason, iterations=smooth.iterations)
    if run.status == "failed":
        return ContactResult("failed", run.reason, iterations=smooth.iterations, transient=run)
    middle = float(np.interp(0.0, run.profiles.x, run.profiles.film))
    if run.subgrid_error > 0.0:
        skipped.append(f"waves finer than the mesh: friction uncertain by {100.0 * run.subgrid_error:.2g} %")
    return replace(
        smooth,
        **{name: getattr(run, name) for name in _OF_RUN},
        film_central=middle,
        film_ratio=smooth.isothermal.film_central / rms,
        notes=(*smooth.notes, *((NO_INLET_HEAT,) if heated else ()), *run.notes),
        transient=run,
    )


def _dry(smooth: ContactResult, dry: DryLimit, problem: ContactProblem, *, thermal: bool) -> ContactResult:
    """Result with the whole load on the asperities."""
    friction, bulk = rubbing_friction(problem.line, problem.surface.boundary_friction), problem.temperature_bulk
    hot = flash_of_rubbing(problem.line, friction, problem.bodies, bulk) if thermal else max(bulk)
    return replace(
        smooth,
        friction_coefficient=friction,
        friction_fluid=0.0,
        friction_asperity=friction,
        film_central=dry.film_mean,
        film_min=dry.boundary_film,
        pressure_max=dry.pressure_max,
        film_ratio=dry.film_ratio,
        asperity_load_share=1.0,
        roughness_load_share=1.0,
        rolling_traction=0.0,
        temperature_film_max=hot,
        temperature_flash=hot,
        film_error=dry.film_error,
        friction_error=dry.friction_error,
        mesh_error=0.0,
        statistical_error=0.0,
        realisation_error=0.0,
        heat=None,
        dry=dry.contact,
    )
