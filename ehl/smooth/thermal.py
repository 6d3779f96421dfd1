"""Smooth, steady, thermal line contact: the film solver and the heat balance, each in turn until both agree.

isothermal film -> (heat matters?) -> film and temperatures in turn on a coarse grid (`ehl.smooth.hot_film`) -> the same
on nested grids, each from the one before -> Richardson values with their errors, temperatures of the finest grid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ehl.fluid.conductivity import FilmConductivity
from ehl.fluid.lubricant import Lubricant
from ehl.heat import (
    FilmProfile,
    InletFactor,
    ThermalEstimate,
    ThermalTraction,
    estimate_thermal_effect,
    inlet_thermal_factors,
)
from ehl.heat.conduction import Conduction
from ehl.heat.traction import traction_of
from ehl.inputs import ModelInput
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.smooth import SteadyResult, solve_steady
from ehl.smooth.continuation import PathReport
from ehl.smooth.estimate import Extrapolation
from ehl.smooth.hot_film import HeatModel, HotFilm
from ehl.smooth.newton import NewtonFailure
from ehl.smooth.outputs import numbers_of
from ehl.smooth.refine import Accuracy, nested, rounding_errors
from ehl.smooth.scaling import Offset, ScaledContact, scaled_contact
from ehl.smooth.solver import ROUNDED, film_shear, steady_result, undisturbed

FloatArray = NDArray[np.float64]
Thermal = Literal["auto", "on"]

# on the change of friction and film between two rounds
ROUND_TOLERANCE: dict[str, float] = {"fast": 1e-3, "standard": 2e-4, "reference": 2e-5}


@dataclass(frozen=True)
class ThermalSteadyResult:
    """A contact in thermal balance, or the isothermal one where heat was found not to matter.

    Parameters
    ----------
    status : {"converged", "failed"}
    reason : str
        Empty; one of the film solver's; "no_thermal_balance", "not_finite"; or "thermal_rounds" (film and
        temperature still changed by more than 10 % in the last round).
    film : SteadyResult
        Pressure and film with the viscosity of the hot film; its friction is the thermal one, with its grid error.
    isothermal : SteadyResult
        The same contact without heat.
    heat : ThermalTraction or None
        Temperatures on the nodes of the heat balance; None where heat was left out.
    estimate : ThermalEstimate
        What decided that.
    friction_fluid, friction_isothermal : float
        [-].
    friction_error, film_error : float
        Relative: grid errors of film and heat balance, and half the change in the last round (all of it where that
        is above the tolerance).
    film_reduction : float
        film_central over its isothermal value [-].
    inlet_factors : InletFactor
        What published formulas say of that reduction.
    temperature_film_max, temperature_flash : float
        Highest film and surface temperature [K].
    energy_residual : float
        |heat into both bodies - power|/power, the power from the shear stress of the film solver on its own mesh [-].
    rounds : int
    iterations : int
        Newton iterations of all film solutions.
    notes : tuple of str
        Those of the heat balance, and "thermal_rounds" where the last change was between tolerance and 10 %.
    skipped : tuple of str
    """

    status: Literal["converged", "failed"]
    reason: str
    film: SteadyResult
    isothermal: SteadyResult
    heat: ThermalTraction | None
    estimate: ThermalEstimate
    friction_fluid: float
    friction_isothermal: float
    friction_error: float
    film_error: float
    film_reduction: float
    inlet_factors: InletFactor
    temperature_film_max: float
    temperature_flash: float
    energy_residual: float
    rounds: int
    iterations: int
    notes: tuple[str, ...] = ()
    skipped: tuple[str, ...] = ()


def solve_steady_thermal(
    contact: LineContact,
    lubricant: Lubricant,
    bodies: tuple[Material, Material],
    *,
    temperature_bulk: tuple[float, float] | None = None,
    thermal: Thermal = "auto",
    accuracy: Accuracy = "standard",
    start: SteadyResult | None = None,
    start_heat: ThermalTraction | None = None,
    conduction: Conduction = "jaeger",
    conductivity: FilmConductivity | None = None,
    rolling_heat: bool = True,
    film_profile: FilmProfile = "parabolic",
) -> ThermalSteadyResult:
    """Solve the smooth, steady contact with the heat of sliding and of the pressure-driven flow.

    The film temperature acts on the viscosity in the Reynolds equation itself, inlet included. The published inlet
    factors are therefore reported beside the reduction found, never multiplied in: that would count the inlet twice.

    Parameters
    ----------
    contact, lubricant, bodies, temperature_bulk, conduction, conductivity, film_profile
        As in `ehl.heat.thermal_traction`.
    thermal : {"auto", "on"}
        "auto" leaves heat out where `estimate_thermal_effect` finds that it does not matter.
    accuracy : {"fast", "standard", "reference"}
        As in `ehl.smooth.solve_steady`.
    start : SteadyResult, optional
        A neighbouring contact's isothermal film.
    start_heat : ThermalTraction, optional
        A neighbouring contact's temperatures.
    rolling_heat : bool
        Whether the pressure-driven flow heats the film (inlet heating in pure rolling). The transient solver takes
        this heat from here.

    Returns
    -------
    ThermalSteadyResult
    """
    bulk = temperature_bulk or (lubricant.temperature, lubricant.temperature)
    isothermal = solve_steady(contact, lubricant, accuracy=accuracy, start=start)
    central = isothermal.film_central if isothermal.status == "converged" else None
    estimate = estimate_thermal_effect(
        contact, lubricant, bodies, film_central=central, temperature_bulk=bulk, conductivity=conductivity
    )
    base = _without_heat(contact, lubricant, isothermal, estimate, max(bulk))
    if isothermal.status != "converged":
        return base
    if thermal == "auto" and not estimate.matters:
        skipped = f"heat: estimated change of ln(viscosity) {estimate.viscosity_change:.2g}"
        return replace(base, skipped=(*isothermal.skipped, skipped))

    law = conductivity or lubricant.film_conductivity
    model = HeatModel(contact, lubricant, bodies, bulk, rolling_heat, conduction, law, film_profile)
    scaled, tolerance = scaled_contact(contact, lubricant), ROUND_TOLERANCE[accuracy]
    ways = [scaled, scaled.rounded()] if scaled.rounded().gamma > scaled.gamma else [scaled]
    if ROUNDED in isothermal.fallbacks:
        ways = ways[1:]
    rounds, iterations = 0, isothermal.iterations
    for way in ways:
        fallbacks = [ROUNDED] if way.gamma > scaled.gamma else []
        hot, report, reason = HotFilm(model, way, film_shear(contact, lubricant), tolerance), PathReport(), ""
        try:
            with undisturbed():
                film = _solved(hot, scaled, isothermal, start_heat, accuracy, report, fallbacks)
        except NewtonFailure as failure:
            reason = failure.reason
        rounds, iterations = rounds + hot.rounds, iterations + report.iterations
        if not reason:
            break
    if reason:
        return _failed(base, reason, rounds, iterations)

    assert hot.found is not None
    heat = traction_of(hot.found, hot.x * contact.half_width, contact, lubricant, bodies, conduction)
    power = float(np.trapezoid(film.shear_stress, film.x)) * contact.speed_sliding + float(
        np.trapezoid(heat.rolling_heat, heat.x)
    )
    into = float(np.trapezoid(heat.heat_flux_1 + heat.heat_flux_2, heat.x))
    unsettled = max(hot.change) > tolerance
    last_share = 1.0 if unsettled else 0.5
    return replace(
        base,
        film=film,
        heat=heat,
        friction_fluid=film.friction_fluid,
        friction_error=film.friction_error + last_share * hot.change[0],
        film_error=film.film_error + last_share * hot.change[1],
        film_reduction=film.film_central / isothermal.film_central,
        temperature_film_max=heat.temperature_film_max,
        temperature_flash=heat.temperature_flash,
        energy_residual=abs(into - power) / power if power > 0.0 else 0.0,
        rounds=rounds,
        iterations=iterations,
        notes=(*heat.notes, *(("thermal_rounds",) if unsettled else ())),
        skipped=(),
    )


def _solved(
    hot: HotFilm,
    scaled: ScaledContact,
    isothermal: SteadyResult,
    start_heat: ThermalTraction | None,
    accuracy: Accuracy,
    report: PathReport,
    fallbacks: list[str],
) -> SteadyResult:
    """The hot film with its grid error: the one on a coarse grid, then those on nested ones."""
    contact, shear, cold = hot.model.contact, hot.shear, isothermal.coarse
    assert cold is not None
    offset = None
    if start_heat is not None:
        # the temperatures of the neighbour, stretched to this contact's exit
        stretch = isothermal.x_exit / start_heat.x[-1] / contact.half_width
        offset = Offset(stretch * start_heat.x, start_heat.log_viscosity_offset)
    try:
        near = hot.started(cold, offset)
        levels, limit = nested(near, shear, accuracy, PathReport(), fallbacks, hot.solved)
        if fallbacks[:1] == [ROUNDED]:  # judged by the film without heat, which is solved for certain
            blunt = Extrapolation(numbers_of(cold, shear).as_array(), rounding_errors(scaled, cold, shear, report))
            limit = replace(limit, errors=limit.errors + blunt.relative() * np.abs(limit.values))
    finally:
        report.iterations += hot.iterations
    return steady_result(
        contact, levels[-1].scaled, shear, levels, limit, near, report, tuple(dict.fromkeys(fallbacks))
    )


def _without_heat(
    contact: LineContact, lubricant: Lubricant, film: SteadyResult, estimate: ThermalEstimate, hottest: float
) -> ThermalSteadyResult:
    return ThermalSteadyResult(
        status=film.status,
        reason=film.reason,
        film=film,
        isothermal=film,
        heat=None,
        estimate=estimate,
        friction_fluid=film.friction_fluid,
        friction_isothermal=film.friction_fluid,
        friction_error=film.friction_error,
        film_error=film.film_error,
        film_reduction=1.0,
        inlet_factors=inlet_thermal_factors(contact, lubricant),
        temperature_film_max=lubricant.temperature,
        temperature_flash=hottest,
        energy_residual=0.0,
        rounds=0,
        iterations=film.iterations,
        skipped=film.skipped,
    )


def _failed(base: ThermalSteadyResult, reason: str, rounds: int, iterations: int) -> ThermalSteadyResult:
    """No thermal friction: zero with infinite error, never the isothermal number in its place."""
    return replace(
        base,
        status="failed",
        reason=reason,
        friction_fluid=0.0,
        friction_error=math.inf,
        film_error=math.inf,
        rounds=rounds,
        iterations=iterations,
    )


@dataclass(frozen=True)
class SmoothFilm:
    """The smooth contact with or without heat; fields as in `ThermalSteadyResult`."""

    status: str
    reason: str
    film: SteadyResult
    isothermal: SteadyResult
    heat: ThermalTraction | None
    friction_fluid: float
    film_error: float
    friction_error: float
    temperature_film_max: float
    temperature_flash: float
    iterations: int
    skipped: tuple[str, ...]
    notes: tuple[str, ...] = ()


def isothermal_fallback(smooth: SmoothFilm | ThermalSteadyResult) -> SmoothFilm:
    """The isothermal film of a contact whose heat balance was not found."""
    return _isothermal(smooth.isothermal, smooth.temperature_film_max, smooth.temperature_flash, smooth.iterations)


def _isothermal(film: SteadyResult, temperature_film: float, temperature_flash: float, iterations: int) -> SmoothFilm:
    return SmoothFilm(
        film.status,
        film.reason,
        film,
        film,
        None,
        film.friction_fluid,
        film.film_error,
        film.friction_error,
        temperature_film,
        temperature_flash,
        iterations,
        film.skipped,
    )


def smooth_film(
    contact: LineContact,
    lubricant: Lubricant,
    model: ModelInput,
    bodies: tuple[Material, Material],
    bulk: tuple[float, float],
    *,
    start: SteadyResult | None,
    start_heat: ThermalTraction | None,
) -> SmoothFilm | ThermalSteadyResult:
    """The smooth contact with the heat that `model` asks for, from film and heat of a similar contact where given."""
    if model.thermal == "off":
        film = solve_steady(contact, lubricant, accuracy=model.accuracy, start=start)
        return _isothermal(film, lubricant.temperature, lubricant.temperature, film.iterations)
    return solve_steady_thermal(
        contact,
        lubricant,
        bodies,
        temperature_bulk=bulk,
        thermal=model.thermal,
        accuracy=model.accuracy,
        start=start,
        start_heat=start_heat,
    )
