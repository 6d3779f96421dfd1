"""Uncertainty of the friction of one contact from solutions at both ends of the interval of each input."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

from ehl.common.runner import run_tasks
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from ehl.fluid.oil_laws import VARIABLES
from ehl.fluid.rheology import PressureStress
from ehl.inputs import ContactProblem
from ehl.uncertainty.result import LEVEL, Change, InputUncertainty, score_of
from ehl.uncertainty.spread import GROUPS, LATERAL_CAUSE, Spread, UncertaintyInput, lateral_spread

Moving = Callable[[ContactProblem, float], ContactProblem]
Case = TypeVar("Case")

THICK = 3.0  # film ratio above which the effect of roughness is negligible
FILMS = (5e-9, 300e-9)  # allowed range of the boundary film [m]
# of the parameters of the surfaces
LIMITS = {
    "correlation_length": (0.0, math.inf),
    "boundary_film": FILMS,
    "boundary_friction": (0.0, 1.0),
}


def varied_lubricant(lubricant: Lubricant, name: str, factor: float) -> Lubricant:
    """The lubricant with one property of `ehl.fluid.oil_laws.VARIABLES` times a factor."""
    stress = lubricant.eyring_stress
    scaled = stress.scaled(factor) if isinstance(stress, PressureStress) else factor * stress
    changes: dict[str, dict[str, Any]] = {
        "pressure_viscosity": {"pressure_rise_factor": factor * lubricant.pressure_rise_factor},
        "viscosity": {"viscosity_inlet": factor * lubricant.viscosity_inlet},
        "eyring_stress": {"eyring_stress": scaled},
        "limiting_shear": {
            "limiting_shear_coefficient": factor * lubricant.limiting_shear_coefficient,
            "limiting_shear_ambient": factor * lubricant.limiting_shear_ambient,
        },
        "thermal_conductivity": {"thermal_conductivity": factor * lubricant.thermal_conductivity},
    }
    return replace(lubricant, **changes[name])


@dataclass(frozen=True)
class UncertainInput(Generic[Case]):
    """One uncertain input of a case; `moved` returns the case with it shifted by some standard deviations."""

    name: str  # of the input
    input: str  # of its spread
    spread: Spread
    moved: Callable[[Case, float], Case]


def shifted(case: Case, inputs: Sequence[UncertainInput[Case]], score: float, parts: Mapping[str, float]) -> Case:
    """A case with several inputs shifted, each by its part of the score."""
    for entry in inputs:
        if parts.get(entry.name):
            case = entry.moved(case, score * parts[entry.name])
    return case


def uncertain_contact_inputs(
    problem: ContactProblem, spreads: UncertaintyInput, oil: Oil | None, film_ratio: float
) -> list[UncertainInput[ContactProblem]]:
    """All uncertain inputs of a contact; for thick films without those of the roughness."""
    surface, rough = problem.surface, problem.rough and film_ratio <= THICK
    found: list[UncertainInput[ContactProblem]] = []

    def entry(name: str, input: str, spread: Spread, at: Moving) -> None:
        if not spread.known:
            found.append(UncertainInput(name, input, spread, at))

    def of_surface(fields: Sequence[str], spread: Spread, low: float, high: float) -> Moving:
        def at(given: ContactProblem, z: float) -> ContactProblem:
            values = {field: getattr(given.surface, field) for field in fields}
            if "boundary_film" in values:
                values["boundary_film"] = given.surface.film_of_contact
            changed = {field: min(max(spread.at(value, z), low), high) for field, value in values.items()}
            return replace(given, surface=given.surface.model_copy(update=changed))

        return at

    def of_oil(name: str, spread: Spread) -> Moving:
        return lambda given, z: replace(given, lubricant=varied_lubricant(given.lubricant, name, spread.at(1.0, z)))

    if oil is not None:
        for name in VARIABLES:
            spread = _beyond_measured(name, spreads.spread(name, oil), problem)
            entry(name, name, spread, of_oil(name, spread))
    rms = [name for name in ("roughness_rms_1", "roughness_rms_2") if getattr(surface, name) > 0.0]
    groups = [rms] if spreads.shared_rms else [[name] for name in rms]
    if surface.running_in != "none":  # friction depends on Rq after running-in
        groups = [["running_in"]]
    if rough:
        spread = spreads.spread("roughness_rms")
        for fields in groups:
            name = fields[0] if len(fields) == 1 else "roughness_rms"
            entry(name, "roughness_rms", spread, of_surface(fields, spread, 0.0, math.inf))
        for name, limits in LIMITS.items():
            spread = spreads.spread(name)
            entry(name, name, spread, of_surface([name], spread, *limits))

        def laid(given: ContactProblem, z: float) -> ContactProblem:
            length, gamma = spreads.lay_moved(given.surface.correlation_length, given.surface.peklenik_number, z)
            changed = {"correlation_length": float(length), "peklenik_number": float(gamma)}
            return replace(given, surface=given.surface.model_copy(update=changed))

        entry("peklenik_number", "peklenik_number", spreads.spread("peklenik_number"), laid)
    if problem.model.thermal != "off":
        bulk = spreads.spread("temperature_bulk")

        def warmer(given: ContactProblem, z: float) -> ContactProblem:
            one, two = (bulk.at(value, z) for value in given.temperature_bulk)
            return replace(given, temperature_bulk=(one, two))

        entry("temperature_bulk", "temperature_bulk", bulk, warmer)
        steel = spreads.spread("conductivity_solid")

        def conducting(given: ContactProblem, z: float) -> ContactProblem:
            one, two = (
                body.model_copy(update={"thermal_conductivity": steel.at(body.thermal_conductivity, z)})
                for body in given.bodies
            )
            return replace(given, bodies=(one, two))

        entry("conductivity_solid", "conductivity_solid", steel, conducting)
    return found


def _beyond_measured(name: str, spread: Spread, problem: ContactProblem) -> Spread:
    """The spread of an oil property, increased if its laws are extrapolated.

    The difference from the tangent of the laws counts as the half-width of a 90 % interval.
    """
    lubricant, pressure = problem.lubricant, problem.line.pressure_hertz
    differences = {
        "viscosity": lubricant.extrapolated,
        "pressure_viscosity": abs(lubricant.continuation_difference(pressure)),
    }
    more = differences.get(name, 0.0) / score_of(0.9)
    if more == 0.0 or spread.known:
        return spread
    below, sd = math.hypot(spread.below, more), math.hypot(spread.sd, more)
    return replace(spread, sd=sd, sd_below=below, source=f"{spread.source}; law beyond its measured range")


def contact_uncertainty(
    problem: ContactProblem,
    solve: Callable[[ContactProblem], tuple[float, float, float]],
    spreads: UncertaintyInput,
    oil: Oil | None,
    level: float = LEVEL,
    jobs: int | None = None,
) -> InputUncertainty:
    """Interval of the friction coefficient of a contact, solved with each input at both ends of its interval.

    problem: the contact.
    solve: friction coefficient [-], its relative error [-] and the film ratio [-] of a problem.
    spreads: standard deviations of the inputs.
    oil: data with its uncertainty; without it the oil properties are treated as exact.
    level: coverage of the interval [-].
    jobs: worker processes; default: all available cores.
    Raises `InputError`: the level is not between 0 and 1.
    """
    score = score_of(level)
    mu, error, ratio = solve(problem)
    inputs = uncertain_contact_inputs(problem, spreads, oil, ratio)

    def friction(problems: Sequence[ContactProblem]) -> list[float]:
        return [found[0] for found in run_tasks(problems, solve, jobs=jobs)]

    lateral = spreads.spread(LATERAL_CAUSE)
    rough = score * float(lateral_spread(ratio, lateral.sd)) if problem.rough and ratio <= THICK else 0.0

    def together(scores: Sequence[Mapping[str, float]]) -> list[float]:
        found = friction([shifted(problem, inputs, score, each) for each in scores])
        return [
            math.log(end / mu) + rough * each.get(LATERAL_CAUSE, 0.0) if end > 0.0 < mu else math.nan
            for end, each in zip(found, scores, strict=True)
        ]

    ends = friction([entry.moved(problem, z) for entry in inputs for z in (-score, score)])
    notes = [] if oil else ["the lubricant has no oil card: its properties are treated as exact"]
    notes.append(f"error of the solution {100.0 * error:.2g} %: smaller changes are not resolved")
    changes, lost = [], []
    for entry, below, above in zip(inputs, ends[::2], ends[1::2], strict=True):
        if not (math.isfinite(below) and math.isfinite(above) and min(below, above, mu) > 0.0):
            lost.append(entry.name)
            continue
        note = f"{entry.spread.source}; solved at both ends"
        values = math.log(below / mu), math.log(above / mu)
        changes.append(Change(entry.name, GROUPS[entry.input], entry.spread.sd, *values, note))
    if rough > 0.0:
        changes.append(Change(LATERAL_CAUSE, GROUPS[LATERAL_CAUSE], rough / score, -rough, rough, lateral.source))
    if lost:
        notes.append(f"no solution at both ends, not included in the interval: {', '.join(lost)}")
    name = "friction_coefficient"
    return InputUncertainty.of(name, mu, changes, lambda ln: mu * math.exp(ln), level, notes, together)
