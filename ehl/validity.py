"""Validity of a contact result: rejected results, and limits of the model with their errors.

`checked` is applied to every result. A `Limit` is a note with its parts of the errors of mu and film; the status
follows from the sum of those that count.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ehl.common.quantities import percent
from ehl.common.units import KELVIN
from ehl.fluid.lubricant import Lubricant
from ehl.heat.conduction import PECLET_FLOOR, peclet_number
from ehl.heat.estimate import convection_error
from ehl.inputs import ContactProblem
from ehl.result import ContactResult
from ehl.rough.mixed import SHEAR_STRENGTH
from ehl.rough.multilevel import ERROR_ALLOWED

# reasons for which a result is rejected, independently of the residuals of the solver
REASONS = ("not_finite", "negative", "shear_strength", "inaccurate", "film_above_radius")

LIMIT_TEMPERATURE = 1000.0  # temperature above which no law of the oil is valid [K]
# factor on the share of hot spots in the friction of a transient solution, which is evaluated in one step only
HOT_NODE_WEIGHT = 2.0
DECOMPOSITION_TEMPERATURE = 300.0 + KELVIN  # oils decompose [K]
MAX_SMOOTH_ERROR = 0.1  # relative discretisation error above which a smooth result is rejected [-]
NOTED = 0.02  # smallest change of smooth friction by a neglected effect with a note
MOLECULAR_FILM = 1e-9  # thickness of a few molecules [m]
BULK_NOTED = 1.0  # smallest difference of bulk and oil temperature with a note [K]
FILM_EXPONENT = 0.67  # of the inlet viscosity in the film thickness
# largest film over the radius: lubrication theory neglects terms of the order of h/R, and at such distances starvation,
# inertia and gravity dominate
MAX_FILM = 0.1
# change of ln(eta) by an extrapolated law above which a result does not count as converged (own choice)
MAX_EXTRAPOLATION = 0.5
# shear strength of liquids, as slope over pressure and at ambient pressure; traction fluids reach 0.12 and 3 MPa
STRENGTH_SLOPE, STRENGTH_AMBIENT = 0.15, 5e6
# change of mu and film with half and twice the depth of the temperature field of a body at rest (docs/heat.md)
AT_REST = (0.005, 0.035)
# error of one-dimensional conduction over the Peclet number of the surface in rough contacts (docs/heat.md)
CONDUCTION_ERROR = ((0.5, 1.0, 2.0, 5.0, 50.0), (0.22, 0.14, 0.08, 0.04, 0.006))


@dataclass(frozen=True)
class Limit:
    """A limit of the model that concerns a result."""

    note: str  # for the user; empty if the effect is small
    # its relative parts of the errors of mu and film [-]
    friction: float = 0.0
    film: float = 0.0
    decisive: bool = False  # whether this limit alone makes a result unsettled
    counts: bool = True  # towards the status; not what neither another input nor another setting changes


def checked(result: ContactResult, problem: ContactProblem, *, rounds_left: bool = False) -> ContactResult:
    """The result with all limits of the model in its notes, errors and status.

    result: with the errors of the solution.
    problem: its inputs.
    rounds_left: whether film and heat would change by more than their tolerance in further rounds.
    Returns: the result; failed with one of `REASONS` if it is rejected.
    """
    reason = rejection_reason(result, problem)
    if reason:
        return ContactResult("failed", reason, iterations=result.iterations)
    limits, tolerance = list(limits_of(result, problem)), problem.model.tolerance
    beyond, film = (
        float(sum(parts)) for parts in zip(*((limit.friction, limit.film) for limit in limits), strict=True)
    )
    notes = dict.fromkeys((*result.notes, *(limit.note for limit in limits if limit.note)))
    found = replace(
        result, friction_error=result.friction_error + beyond, film_error=result.film_error + film, notes=tuple(notes)
    )
    if found.status != "converged":
        return found
    mu = found.friction_coefficient
    if mu > 0.0 and friction_above_limit_temperature(result) > 0.5 * tolerance * mu:
        return replace(found, status="unsettled", reason="too_hot")
    if found.transient is not None and found.mesh_error > ERROR_ALLOWED * tolerance:
        return replace(found, status="unsettled", reason="mesh_error")
    if rounds_left and found.transient is None and found.mesh_error > tolerance:
        return replace(found, status="unsettled", reason="thermal_rounds")
    counted = sum(limit.friction for limit in limits if limit.counts)
    if counted > ERROR_ALLOWED * tolerance or any(limit.decisive for limit in limits):
        return replace(found, status="unsettled", reason="beyond_laws")
    return found


def rejection_reason(result: ContactResult, problem: ContactProblem) -> str:
    """Reason of rejection, one of `REASONS`, or empty."""
    numbers = (result.friction_coefficient, result.film_central, result.film_min, result.pressure_max)
    if not all(math.isfinite(value) for value in (*numbers, result.friction_error, result.film_error)):
        return "not_finite"
    if min(numbers) < 0.0 or not 0.0 <= result.asperity_load_share <= 1.0 + 1e-9:
        return "negative"
    if max_shear_stress(result) > SHEAR_STRENGTH:
        return "shear_strength"
    if result.transient is None and result.dry is None and max(result.mesh_error, result.film_error) > MAX_SMOOTH_ERROR:
        return "inaccurate"
    if max(result.film_central, result.film_min) > MAX_FILM * problem.line.radius_equivalent:
        return "film_above_radius"
    return ""


def friction_above_limit_temperature(result: ContactResult) -> float:
    """Part of mu from film above 1000 K [-], which is uncertain as no law of the oil is valid there.

    For a transient solution the larger of two shares is used: twice the share of the hot nodes in the last step, and
    the share of the pressure at nodes whose mean temperature is that high.
    """
    if max(result.temperature_film_max, result.temperature_flash) <= LIMIT_TEMPERATURE:
        return 0.0
    if result.transient is not None:
        state, profiles = result.transient.run.state, result.transient.profiles
        shear, load = float(state.shear.sum()), float(profiles.pressure_fluid.sum())
        spots = float(state.shear[state.temperature > LIMIT_TEMPERATURE].sum()) / shear if shear > 0.0 else 0.0
        hot_load = float(profiles.pressure_fluid[profiles.temperature_film > LIMIT_TEMPERATURE].sum())
        mean = hot_load / load if load > 0.0 else 0.0
        return min(max(HOT_NODE_WEIGHT * spots, mean), 1.0) * result.friction_fluid
    heat = result.heat
    if heat is None:
        return 0.0
    power = float(np.trapezoid(heat.shear_stress, heat.x))
    hot = np.where(heat.temperature_film > LIMIT_TEMPERATURE, heat.shear_stress, 0.0)
    return result.friction_fluid * float(np.trapezoid(hot, heat.x)) / power if power > 0.0 else 0.0


def max_shear_stress(result: ContactResult) -> float:
    """Largest shear stress of the film [Pa]; for a transient solution that of the last step, at least the mean."""
    if result.transient is not None:
        run = result.transient.run
        mean = result.friction_fluid * math.pi / 4.0  # over the Hertz width, in p_h
        return max(float(run.state.shear.max()), mean) * run.problem.units.pressure
    if result.dry is not None:
        return 0.0
    assert result.film is not None
    return float(result.film.shear_stress.max())


def limits_of(result: ContactResult, problem: ContactProblem) -> Iterator[Limit]:
    """Limits of the model that concern a result."""
    line, lubricant = problem.line, problem.lubricant
    yield Limit("", film=max(result.film_central, 0.0) / line.radius_equivalent)
    yield from _limits_of_oil(result, problem)
    if result.film_min < MOLECULAR_FILM:
        yield Limit(f"minimum film {result.film_min * 1e9:.2g} nm: thinner than a few oil molecules")
    hottest = max(result.temperature_film_max, result.temperature_flash)
    mu, part = result.friction_coefficient, friction_above_limit_temperature(result)
    if part > 0.0 or hottest > LIMIT_TEMPERATURE:
        note = (
            f"temperatures up to {hottest:.0f} K: no law of the oil is valid; the hot film contributes {part:.2g} to "
            "mu, which is included in the error"
        )
        yield Limit(note, part / mu if mu > 0.0 else 0.0)
    elif result.temperature_film_max > DECOMPOSITION_TEMPERATURE:
        yield Limit(f"film temperature {result.temperature_film_max - KELVIN:.0f} degC: oils decompose")
    hardness = problem.hardness
    if result.pressure_max > hardness:
        yield Limit(
            f"pressure of {result.pressure_max / 1e9:.3g} GPa above the hardness {hardness / 1e9:.3g} GPa: yielding"
        )
    gamma = problem.surface.peklenik_number
    if gamma < 1.0 and result.dry is None and result.asperity_load_share > 0.0:
        # two-dimensional solutions have 9, 3 and 11 % less mu at 0.5, 0.5 and 0.7, where asperities give 0.15, 0.63 and
        # 0.46 of it; without film both have the boundary friction. With little boundary friction a wrong load share
        # changes the friction of the film
        share = min(result.asperity_load_share, 1.0)
        part = max(result.friction_asperity / mu, share) if mu > 0.0 else share
        error = 0.25 * min((1.0 - gamma) / 0.3, 1.0) * (1.0 - share) * math.sqrt(min(part, 1.0))
        note = (
            f"Peklenik number {gamma:.2g}, marks along the motion: compared with three two-dimensional solutions only; "
            f"an uncertainty of mu of {100.0 * error:.0f} % is included in the error"
        )
        yield Limit(note if error > NOTED else "", error, counts=False)
    if result.heat is not None:
        yield from _limits_of_heat(result, problem)
    if problem.model.thermal != "off":
        yield from _bulk_limit(lubricant, problem.temperature_bulk)


def _limits_of_oil(result: ContactResult, problem: ContactProblem) -> Iterator[Limit]:
    """Laws of the oil outside their measured range, and friction above the shear strength of liquids.

    The uncertainty of an extrapolated law is part of the input uncertainty (`Contact.uncertainty`).
    """
    line, lubricant, mu = problem.line, problem.lubricant, result.friction_coefficient
    if lubricant.extrapolated:
        yield Limit(
            "oil temperature outside the measured range of the oil: ln(eta0) of its law differs by "
            f"{lubricant.extrapolated:.2g} from the tangent over 1/T at the end of the range",
            decisive=lubricant.extrapolated > MAX_EXTRAPOLATION,
        )
    if line.pressure_hertz > lubricant.pressure_valid:
        difference = lubricant.continuation_difference(line.pressure_hertz)
        yield Limit(
            f"pressure of {line.pressure_hertz / 1e9:.3g} GPa above {lubricant.pressure_valid / 1e9:.3g} GPa, the "
            "measured range of the oil: its law is extrapolated; the tangent at the end of the range differs by "
            f"{100.0 * difference:+.0f} % in ln(eta/eta0); a traction curve at this pressure reduces the "
            "uncertainty (`mixed-ehl calibrate`)",
            decisive=abs(difference) > MAX_EXTRAPOLATION,
        )
    film = result.film
    if film is not None and result.friction_fluid > 0.0:
        most = STRENGTH_SLOPE + STRENGTH_AMBIENT * (film.x_exit - film.x_inlet) / line.load_per_length
        if result.friction_fluid > most:
            yield Limit(
                f"fluid friction {result.friction_fluid:.3g} above {most:.2g}, the shear strength of liquids: the "
                "shear law has no limiting stress at this pressure",
                (result.friction_fluid - most) / mu,
            )


def _limits_of_heat(result: ContactResult, problem: ContactProblem) -> Iterator[Limit]:
    """Simplified convection and conduction of heat."""
    line, smooth, isothermal = problem.line, result.film, result.isothermal
    assert smooth is not None
    assert isothermal is not None
    if not line.speed_sliding > 0.0:
        return
    share = result.friction_fluid / result.friction_coefficient if result.friction_coefficient > 0.0 else 0.0
    film = smooth.film_central
    thinning = film / isothermal.film_central
    carried = convection_error(line, problem.lubricant, film, thinning)
    note = ""
    if carried.friction_change > NOTED:
        note = (
            f"convection of heat by a thick film is simplified (film Peclet number {carried.peclet_film:.2g}, film "
            f"{thinning:.2g} of the isothermal one): smooth friction may be wrong by about "
            f"{percent(carried.friction_change)} and the smooth film by {percent(carried.film_change)}"
        )
    yield Limit(note, share * carried.friction_change, carried.film_change)
    speeds = zip((line.speed_1, line.speed_2), problem.bodies, strict=True)
    peclet = min(peclet_number(speed, line.half_width, body) for speed, body in speeds)
    if peclet < PECLET_FLOOR:
        note = f"Peclet number {peclet:.2g} of a surface: its temperature field is limited to a depth of 10 half-widths"
        yield Limit(note, share * AT_REST[0], AT_REST[1])
    if result.transient is not None and smooth.friction_fluid > 0.0 < isothermal.friction_fluid:
        # relative error of the thermal change of friction; the transient solution has a note on it
        error = float(np.interp(math.log(max(peclet, 1e-300)), np.log(CONDUCTION_ERROR[0]), CONDUCTION_ERROR[1]))
        yield Limit("", share * error * abs(math.log(smooth.friction_fluid / isothermal.friction_fluid)))


def _bulk_limit(lubricant: Lubricant, bulk: tuple[float, float]) -> Iterator[Limit]:
    """Note on the effect of bulk temperatures that differ from the oil temperature on the film."""
    mean = 0.5 * (bulk[0] + bulk[1])
    difference = mean - lubricant.temperature
    if abs(difference) < BULK_NOTED:
        return
    warm, oil = np.array([mean]), np.array([lubricant.temperature])
    ambient = np.zeros(1)
    ratio = math.exp(float((lubricant.log_viscosity(ambient, warm) - lubricant.log_viscosity(ambient, oil))[0]))
    word = "warmer" if difference > 0.0 else "colder"
    yield Limit(
        f"bodies {abs(difference):.0f} K {word} than the oil: the oil enters at their temperature, which changes its "
        f"viscosity by a factor of {ratio:.2f} and the film by about {ratio**FILM_EXPONENT:.2f}"
    )
