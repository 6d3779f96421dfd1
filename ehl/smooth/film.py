"""The smooth contact under a rough one: its film with heat, without, or without the heat balance that was not found."""

from __future__ import annotations

from dataclasses import dataclass

from ehl.fluid.lubricant import Lubricant
from ehl.heat import ThermalTraction
from ehl.inputs import ModelInput
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.smooth import SteadyResult, solve_steady
from ehl.smooth.thermal import ThermalSteadyResult, solve_steady_thermal


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
