"""One lubricated contact, from its inputs to its friction coefficient.

smooth film  ->  heat (where it matters)  ->  roughness (where there is any)  ->  friction with its error
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from typing import Any

from ehl.contact import LineContact
from ehl.errors import ConvergenceError
from ehl.heat import ThermalTraction
from ehl.inputs import Case, ModelInput, SurfaceInput
from ehl.load_sharing import load_sharing
from ehl.lubricant import Lubricant
from ehl.material import Material
from ehl.steady import SteadyResult, solve_steady
from ehl.thermal_steady import ThermalSteadyResult, solve_steady_thermal

_PROFILES = ("film", "isothermal", "heat")


@dataclass(frozen=True)
class ContactResult:
    """What one contact gave; SI units, names of docs/nomenclature.md.

    Parameters
    ----------
    status : str
        "converged" or "failed"; where it failed all figures are nan and `reason` says why.
    reason : str
        One word of the solver's list of reasons; empty when converged.
    friction_coefficient, friction_fluid, friction_asperity : float
        mu = fluid + asperity part [-]; rolling traction is not in it.
    film_central, film_min : float
        h at x = 0 and the smallest h [m].
    pressure_max : float
        [Pa].
    film_ratio : float
        lambda: smooth isothermal film_central over the composite Rq [-]; infinity for smooth surfaces.
    asperity_load_share : float
        Share of the load carried by asperity contact [-].
    rolling_traction : float
        Traction of the pressure gradient over w' [-], apart from friction.
    temperature_film_max, temperature_flash : float
        Largest film temperature and larger flash temperature [K]; the inlet temperature where heat was skipped.
    film_error, friction_error : float
        Relative error estimates of the discretisation [-].
    skipped : tuple of str
        What was left out, and the estimate that allowed it.
    iterations : int
        Newton iterations, all grids and paths together.
    seconds : float
        Wall time.
    film, isothermal : SteadyResult
        The solution, for plots, and the one without heat, for warm starts.
    heat : ThermalTraction
        Temperature profiles; None where heat was left out.
    """

    status: str
    reason: str
    friction_coefficient: float
    friction_fluid: float
    friction_asperity: float
    film_central: float
    film_min: float
    pressure_max: float
    film_ratio: float
    asperity_load_share: float
    rolling_traction: float
    temperature_film_max: float
    temperature_flash: float
    film_error: float
    friction_error: float
    skipped: tuple[str, ...]
    iterations: int
    seconds: float
    film: SteadyResult | None = field(default=None, repr=False, compare=False)
    isothermal: SteadyResult | None = field(default=None, repr=False, compare=False)
    heat: ThermalTraction | None = field(default=None, repr=False, compare=False)

    def to_dict(self) -> dict[str, Any]:
        """Scalars for JSON; not-a-number and infinity become None."""
        values = {name: getattr(self, name) for name in self.__dataclass_fields__ if name not in _PROFILES}
        values["skipped"] = list(self.skipped)
        return {
            name: None if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in values.items()
        }


def _failed(reason: str, iterations: int, seconds: float) -> ContactResult:
    nan = math.nan
    return ContactResult(
        "failed", reason, nan, nan, nan, nan, nan, nan, nan, nan, nan, nan, nan, nan, nan, (), iterations, seconds
    )


def solve_contact(
    contact: LineContact,
    lubricant: Lubricant,
    surface: SurfaceInput,
    model: ModelInput,
    bodies: tuple[Material, Material],
    bulk: tuple[float, float],
    start: ContactResult | None = None,
) -> ContactResult:
    """Solve one contact; a failure is a status, never an exception.

    Parameters
    ----------
    contact, lubricant, surface, model
        Geometry, load and motion; the oil at its inlet temperature; roughness; the physics asked for.
    bodies : tuple of Material
        Both bodies, for heat.
    bulk : tuple of float
        Their bulk temperatures [K].
    start : ContactResult, optional
        Solution of a similar contact, as a warm start.
    """
    clock = time.perf_counter()
    smooth = _smooth_film(contact, lubricant, model, bodies, bulk, start)
    if smooth.status != "converged":
        return _failed(smooth.reason, smooth.iterations, time.perf_counter() - clock)
    film, skipped = smooth.film, list(smooth.skipped)

    if surface.roughness_rms > 0.0:
        film_ratio = smooth.isothermal.film_central / surface.roughness_rms
    else:
        film_ratio = math.inf
        skipped.append("roughness: both surfaces are smooth")
    sharing = load_sharing(film_ratio, smooth.friction_fluid, surface.boundary_friction, model.load_sharing)
    skipped.append("time: smooth surfaces and the load-sharing model have no transient")

    return ContactResult(
        status="converged",
        reason="",
        friction_coefficient=sharing.friction_fluid + sharing.friction_asperity,
        friction_fluid=sharing.friction_fluid,
        friction_asperity=sharing.friction_asperity,
        film_central=film.film_central,
        film_min=film.film_min,
        pressure_max=film.pressure_max,
        film_ratio=film_ratio,
        asperity_load_share=sharing.asperity_load_share,
        rolling_traction=film.rolling_traction,
        temperature_film_max=smooth.temperature_film_max,
        temperature_flash=smooth.temperature_flash,
        film_error=film.film_error,
        friction_error=smooth.friction_error,
        skipped=tuple(skipped),
        iterations=smooth.iterations,
        seconds=time.perf_counter() - clock,
        film=film,
        isothermal=smooth.isothermal,
        heat=smooth.heat,
    )


@dataclass(frozen=True)
class _SmoothFilm:
    """The smooth contact with or without heat; fields as in `ThermalSteadyResult`."""

    status: str
    reason: str
    film: SteadyResult
    isothermal: SteadyResult
    heat: ThermalTraction | None
    friction_fluid: float
    friction_error: float
    temperature_film_max: float
    temperature_flash: float
    iterations: int
    skipped: tuple[str, ...]


def _smooth_film(
    contact: LineContact,
    lubricant: Lubricant,
    model: ModelInput,
    bodies: tuple[Material, Material],
    bulk: tuple[float, float],
    start: ContactResult | None,
) -> _SmoothFilm | ThermalSteadyResult:
    warm = start.isothermal if start is not None else None
    if model.thermal == "off":
        film = solve_steady(contact, lubricant, accuracy=model.accuracy, start=warm)
        return _SmoothFilm(
            film.status,
            film.reason,
            film,
            film,
            None,
            film.friction_fluid,
            film.friction_error,
            lubricant.temperature,
            max(bulk),
            film.iterations,
            film.skipped,
        )
    return solve_steady_thermal(
        contact, lubricant, bodies, temperature_bulk=bulk, thermal=model.thermal, accuracy=model.accuracy, start=warm
    )


def solve_case(case: Case, start: ContactResult | None = None) -> ContactResult:
    """Solve the contact of one input file; a failure is a status (`require_converged` makes it an error)."""
    return solve_contact(
        case.line_contact(),
        case.lubricant.lubricant(),
        case.surface,
        case.model,
        (case.solid_1.body(), case.solid_2.body()),
        case.bulk_temperatures(),
        start,
    )


def require_converged(result: ContactResult) -> ContactResult:
    """The result, or a `ConvergenceError` where there is none."""
    if result.status != "converged":
        raise ConvergenceError(result.reason, f"after {result.iterations} iterations")
    return result
