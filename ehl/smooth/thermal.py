"""Solver of the smooth, steady, thermal line contact by iteration of film solution and heat balance.

1. The isothermal film gives an estimate of the thermal effect.
2. If it is not negligible, film and temperatures are iterated on a coarse grid (`ehl.smooth.hot_film`).
3. Nested grids start from the previous grid and give Richardson values with errors. The temperatures of the third grid
   are extrapolated from the first two if they change little; the result has those of the last heat balance.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ehl.fluid.lubricant import Lubricant
from ehl.heat.estimate import ThermalEstimate, estimate_thermal_effect
from ehl.heat.traction import ThermalTraction, traction_of
from ehl.inputs import Accuracy, Thermal
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.smooth.continuation import PathReport
from ehl.smooth.hot_film import HeatModel, HotFilm
from ehl.smooth.newton import Level, NewtonFailure, numbers_of
from ehl.smooth.refine import GridLimit, nested, rounding_errors
from ehl.smooth.scaling import Offset, ScaledContact, scaled_contact
from ehl.smooth.solver import ROUNDED, SteadyResult, coarse_film, film_shear, solve_steady, steady_result, undisturbed

# tolerance on the change of friction and film in further rounds
ROUND_TOLERANCE: dict[str, float] = {"fast": 1e-3, "standard": 2e-4, "reference": 2e-5}
# tuned with tests/verification/ehl/test_cold_oil.py: reference temperatures of the oil above the bodies [K], for cold
# films that do not converge with the inlet temperature; the first suffices for 100 contacts from -40 degC on
WARMER = (60.0, 120.0)


@dataclass(frozen=True)
class SmoothFilm:
    """A smooth contact in thermal balance, or the isothermal one if heat is off or negligible."""

    status: Literal["converged", "failed"]
    # empty; a reason of the film solver; "no_thermal_balance", "not_finite"; or "thermal_rounds" (film and temperature
    # would change by more than 10 % in further rounds)
    reason: str
    film: SteadyResult  # with the viscosity at the film temperature; friction and grid error are the thermal ones
    isothermal: SteadyResult  # the same contact without thermal effects
    friction_fluid: float  # [-]
    # relative: grid errors of film and heat balance, the expected change in further rounds, and the error of
    # extrapolated temperatures
    friction_error: float
    film_error: float
    # highest film and surface temperature [K]
    temperature_film_max: float
    temperature_flash: float
    iterations: int  # Newton iterations of all film solutions
    heat: ThermalTraction | None = None  # temperatures on the nodes of the heat balance; None if heat was neglected
    estimate: ThermalEstimate | None = None  # basis of this decision; None with heat off
    # |heat into both bodies - power|/power, with the power from the shear stress of the film solver on its mesh [-]
    energy_residual: float = 0.0
    rounds: int = 0
    rounds_left: bool = False  # whether that change is between tolerance and 10 %
    skipped: tuple[str, ...] = ()

    @property
    def film_reduction(self) -> float:
        """film_central over its isothermal value [-]."""
        return self.film.film_central / self.isothermal.film_central


def solve_smooth(
    contact: LineContact,
    lubricant: Lubricant,
    bodies: tuple[Material, Material],
    *,
    temperature_bulk: tuple[float, float] | None = None,
    thermal: Thermal = "auto",
    accuracy: Accuracy = "standard",
    start: SteadyResult | None = None,
    start_heat: ThermalTraction | None = None,
) -> SmoothFilm:
    """Solve the smooth, steady contact with the heat of sliding and of the pressure-driven flow.

    The mobility in the Reynolds equation depends on the temperatures across the film everywhere, inlet included.

    contact, lubricant, bodies, temperature_bulk: as in `ehl.heat.traction.film_temperature`.
    thermal: "auto" neglects heat if `estimate_thermal_effect` is below its threshold.
    accuracy: as in `ehl.smooth.solver.solve_steady`.
    start: isothermal film of a neighbouring contact.
    start_heat: temperatures of a neighbouring contact.
    """
    isothermal = solve_steady(contact, lubricant, accuracy=accuracy, start=start)
    if thermal == "off":
        return _isothermal(isothermal, lubricant.temperature, lubricant.temperature)
    bulk = temperature_bulk or (lubricant.temperature, lubricant.temperature)
    central = isothermal.film_central if isothermal.status == "converged" else None
    estimate = estimate_thermal_effect(contact, lubricant, bodies, film_central=central, temperature_bulk=bulk)
    base = replace(_isothermal(isothermal, lubricant.temperature, max(bulk)), estimate=estimate)
    if isothermal.status != "converged":
        return base
    if thermal == "auto" and not estimate.matters:
        skipped = f"heat: estimated change of ln(viscosity) {estimate.viscosity_change:.2g}"
        return replace(base, skipped=(*isothermal.skipped, skipped))

    rounds, iterations, tolerance = 0, isothermal.iterations, ROUND_TOLERANCE[accuracy]
    for oil, cold, scaled, way in _ways(contact, lubricant, bulk, isothermal):
        fallbacks = [ROUNDED] if way.gamma > scaled.gamma else []
        hot = HotFilm(HeatModel(contact, oil, bodies, bulk), way, film_shear(contact, oil), tolerance)
        report, reason = PathReport(), ""
        try:
            with undisturbed():
                offset = None
                if start_heat is not None and oil is lubricant:
                    # temperatures of the neighbour, scaled to the exit of this contact
                    stretch = isothermal.x_exit / start_heat.x[-1] / contact.half_width
                    effects = start_heat.log_viscosity_offset, start_heat.log_flow_shares
                    offset = Offset.of(stretch * start_heat.x, *effects)
                film = _solved(hot, scaled, cold, offset, accuracy, report, fallbacks)
        except NewtonFailure as failure:
            reason = failure.reason
        rounds, iterations = rounds + hot.rounds, iterations + report.iterations
        if not reason:
            break
    if reason:
        # no thermal friction: zero with infinite error, not the isothermal value
        base = replace(base, friction_fluid=0.0, friction_error=math.inf, film_error=math.inf)
        return replace(base, status="failed", reason=reason, rounds=rounds, iterations=iterations)

    assert hot.found is not None
    heat = traction_of(hot.found, hot.x * contact.half_width, contact, bodies)
    if oil is not lubricant:
        own = lubricant.log_viscosity(hot.found.pressure, hot.found.temperature)
        own -= math.log(lubricant.viscosity_inlet) + lubricant.log_viscosity_ratio(hot.found.pressure)
        heat = replace(heat, log_viscosity_offset=own)
    # the share of the heat that reaches the walls is that of the heat balance
    friction, *heats = (np.trapezoid(row, heat.x) for row in (heat.shear_stress, heat.shear_heat, heat.rolling_heat))
    share = float(np.trapezoid(film.shear_stress, film.x) / friction) if friction > 0.0 else 1.0
    power = float(heats[0]) * share + float(heats[1])
    into = float(np.trapezoid(heat.heat_flux_1 + heat.heat_flux_2, heat.x))
    return replace(
        base,
        film=film,
        heat=heat,
        friction_fluid=film.friction_fluid,
        friction_error=film.friction_error + hot.change[0] + hot.extrapolated,
        film_error=film.film_error + hot.change[1] + hot.extrapolated,
        temperature_film_max=heat.temperature_film_max,
        temperature_flash=heat.temperature_flash,
        energy_residual=abs(into - power) / power if power > 0.0 else 0.0,
        rounds=rounds,
        iterations=iterations,
        rounds_left=bool(max(hot.change) > tolerance),
        skipped=(),
    )


def _ways(
    contact: LineContact, lubricant: Lubricant, bulk: tuple[float, float], isothermal: SteadyResult
) -> Iterator[tuple[Lubricant, Level, ScaledContact, ScaledContact]]:
    """The references with the scaled contact, and the contact to be solved: this one, then with a rounded spike."""
    for oil, cold, fallback in _references(contact, lubricant, bulk, isothermal):
        scaled = scaled_contact(contact, oil) if fallback else cold.scaled
        blunt = scaled.rounded()
        if fallback != ROUNDED:
            yield oil, cold, scaled, scaled
        if blunt.gamma > scaled.gamma:
            yield oil, cold, scaled, blunt


def _references(
    contact: LineContact, lubricant: Lubricant, bulk: tuple[float, float], isothermal: SteadyResult
) -> Iterator[tuple[Lubricant, Level, str]]:
    """The oil referred to the inlet temperature, then to higher ones; each with its isothermal film and its fallback.

    ln(eta) of a cold oil that is heated by sliding is the difference of two large numbers, the increase with pressure
    and the decrease by heat. With a higher reference temperature both are small, and the initial film is as thin as the
    thermal one. The equations are the same.
    """
    assert isothermal.coarse is not None
    yield lubricant, isothermal.coarse, ROUNDED if ROUNDED in isothermal.fallbacks else ""
    for warmer in WARMER:
        oil = lubricant.referred_to(0.5 * (bulk[0] + bulk[1]) + warmer)
        if film := coarse_film(contact, oil, PathReport()):
            yield oil, *film


def _solved(
    hot: HotFilm,
    scaled: ScaledContact,
    cold: Level,
    offset: Offset | None,
    accuracy: Accuracy,
    report: PathReport,
    fallbacks: list[str],
) -> SteadyResult:
    """The thermal film with its grid error, on a coarse grid and then on nested ones."""
    contact, shear = hot.model.contact, hot.shear
    try:
        near = hot.started(cold, offset)
        levels, limit = nested(near, shear, accuracy, PathReport(), fallbacks, hot.solved)
        if fallbacks[:1] == [ROUNDED]:  # the error of rounding is that of the isothermal film, which is available
            blunt = GridLimit(np.array(numbers_of(cold, shear)), rounding_errors(scaled, cold, shear, report))
            limit = replace(limit, errors=limit.errors + blunt.relative() * np.abs(limit.values))
    finally:
        report.iterations += hot.iterations
    return steady_result(contact, shear, levels, limit, near, report, fallbacks)


def isothermal_fallback(smooth: SmoothFilm) -> SmoothFilm:
    """The isothermal film of a contact without a solution of the heat balance."""
    found = _isothermal(smooth.isothermal, smooth.temperature_film_max, smooth.temperature_flash)
    return replace(found, iterations=smooth.iterations)


def _isothermal(film: SteadyResult, temperature_film: float, temperature_flash: float) -> SmoothFilm:
    return SmoothFilm(
        status=film.status,
        reason=film.reason,
        film=film,
        isothermal=film,
        friction_fluid=film.friction_fluid,
        friction_error=film.friction_error,
        film_error=film.film_error,
        temperature_film_max=temperature_film,
        temperature_flash=temperature_flash,
        iterations=film.iterations,
        skipped=film.skipped,
    )
