"""Whether a result may be believed, and what a reader must know of it beside its numbers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ehl.fluid.lubricant import KELVIN, Lubricant
from ehl.heat import carried_shear_heat
from ehl.rough.mixed import ERROR_ALLOWED

if TYPE_CHECKING:
    from ehl.contact import LineContact
    from ehl.solve import ContactResult

# what may not stand as converged, whatever a solver's residuals say
REASONS = ("not_finite", "negative", "shear_strength", "inaccurate")

SHEAR_STRENGTH = 1e9  # about the shear modulus of a glassy oil: a larger stress is an error of the shear law [Pa]
TOO_HOT = 1000.0  # no law of the oil means anything there [K]
HOT_SPOTS = 2.0  # the share of hot spots in the friction of a run is counted so many times: it is seen in one step only
HOT = 300.0 + KELVIN  # oils decompose [K]
LEAST_ACCURATE = 0.1  # relative discretisation error from which a smooth result is no result [-]
CARRIED = 0.02  # change of smooth friction by shear heat that the film carries along, from which it is told
MOLECULES = 1e-9  # films below this are thinner than a few molecules [m]


def disbelief(result: ContactResult) -> str:
    """Reason why a result cannot stand, one of `REASONS`; empty where it can."""
    numbers = (result.friction_coefficient, result.film_central, result.film_min, result.pressure_max)
    if not all(math.isfinite(value) for value in (*numbers, result.friction_error, result.film_error)):
        return "not_finite"
    if min(numbers) < 0.0 or not 0.0 <= result.asperity_load_share <= 1.0 + 1e-9:
        return "negative"
    if largest_shear(result) > SHEAR_STRENGTH:
        return "shear_strength"
    if result.transient is None and result.dry is None and max(result.mesh_error, result.film_error) > LEAST_ACCURATE:
        return "inaccurate"
    return ""


def unresolved(result: ContactResult, tolerance: float) -> bool:
    """Whether the mesh of a rough run leaves an error far above the tolerance asked for."""
    return result.transient is not None and result.mesh_error > ERROR_ALLOWED * tolerance


def hot_friction(result: ContactResult) -> float:
    """Part of mu that films above 1000 K make [-]: no law of the oil holds there, so that all of it is uncertain.

    Of a rough run the larger of two: the share of the hot nodes in the last step, counted twice, and the share of the
    pressure under the nodes that are so hot in the mean.
    """
    if max(result.temperature_film_max, result.temperature_flash) <= TOO_HOT:
        return 0.0
    if result.transient is not None:
        state, profiles = result.transient.run.state, result.transient.profiles
        shear, load = float(state.shear.sum()), float(profiles.pressure_fluid.sum())
        spots = float(state.shear[state.temperature > TOO_HOT].sum()) / shear if shear > 0.0 else 0.0
        mean = float(profiles.pressure_fluid[profiles.temperature_film > TOO_HOT].sum()) / load if load > 0.0 else 0.0
        return min(max(HOT_SPOTS * spots, mean), 1.0) * result.friction_fluid
    heat = result.heat
    if heat is None:
        return 0.0
    power = float(np.trapezoid(heat.shear_stress, heat.x))
    hot = np.where(heat.temperature_film > TOO_HOT, heat.shear_stress, 0.0)
    return result.friction_fluid * float(np.trapezoid(hot, heat.x)) / power if power > 0.0 else 0.0


def largest_shear(result: ContactResult) -> float:
    """Largest shear stress of the film [Pa]; with roughness of the last step, or the mean of all where it is larger."""
    if result.transient is not None:
        run = result.transient.run
        mean = result.friction_fluid * math.pi / 4.0  # over the Hertz width, in p_h
        return max(float(run.state.shear.max()), mean) * run.problem.units.pressure
    if result.dry is not None:
        return 0.0
    assert result.film is not None
    return float(result.film.shear_stress.max())


def notes_of(result: ContactResult, contact: LineContact, lubricant: Lubricant, hardness: float) -> tuple[str, ...]:
    """Limits of the model that a result touches."""
    notes = []
    if lubricant.extrapolated:
        notes.append("oil card read outside the temperatures it was measured at")
    if result.film_min < MOLECULES:
        notes.append(f"smallest film {result.film_min * 1e9:.2g} nm: thinner than a few molecules of oil")
    if max(result.temperature_film_max, result.temperature_flash) > TOO_HOT:
        notes.append(
            f"spots at {max(result.temperature_film_max, result.temperature_flash):.0f} K: no law of the oil holds "
            f"there; they make {hot_friction(result):.2g} of mu, counted as error"
        )
    elif result.temperature_film_max > HOT:
        notes.append(f"film at {result.temperature_film_max - KELVIN:.0f} degC: oils decompose there")
    if result.pressure_max > hardness:
        notes.append(
            f"pressure {result.pressure_max / 1e9:.3g} GPa above the hardness {hardness / 1e9:.3g} GPa: bodies yield"
        )
    if result.heat is not None and contact.speed_sliding > 0.0:
        assert result.film is not None
        assert result.isothermal is not None
        film = result.film.film_central
        carried = carried_shear_heat(contact, lubricant, film, film / result.isothermal.film_central)
        if carried.friction_change > CARRIED:
            notes.append(
                f"film Peclet number {carried.peclet_film:.2g}: shear heat the film carries along is left out, at most "
                f"about {100.0 * carried.friction_change:.2g} % of smooth friction and "
                f"{100.0 * carried.film_change:.2g} % of the smooth film"
            )
    return tuple(notes)
