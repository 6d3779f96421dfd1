"""Dry contact instead of a negligible film, selected by an estimate of the load share of the film.

load share of the film <= D (25 h/h_boundary)^1.5 max(1, alpha p_h/15)^1.5

with the smooth film h and D = min(0.01 max(gamma, 1)^0.85, 0.12), 0.12 in sealed valleys. The estimate (own
work) exceeds the share of all of 18 solved contacts (`validation/mixed_shortcuts.py dry`).
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from ehl.common.arrays import FloatArray
from ehl.heat.conduction import surface_matrices
from ehl.heat.traction import flux_to_surface_1
from ehl.inputs import ContactProblem
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.rough import RoughSurfaces
from ehl.rough.dry import DryContactResult, solve_dry, uniform_grid
from ehl.rough.mixed import rough_surfaces
from ehl.rough.surfaces import sample_ring

# tuned on solved contacts (validation/mixed_shortcuts.py): load share of the film at h = 0.04 h_boundary, its growth
# with the Peklenik number, power of film and pressure
DEFICIT_DRAINED, DEFICIT_SEALED, DEFICIT_GROWTH, DEFICIT_POWER = 0.01, 0.12, 0.85, 1.5
FILM_SHARE, STIFFENING = 0.04, 15.0
NODES_PER_LENGTH, NODES_PER_WAVE = 12.0, 2.2
NODES_MIN, NODES_MAX = 512, 8192
REACH = 2.0  # half length of the dry mesh [b]
MOMENTS = (0.0, 5.3, 9.9, 16.1, 21.7, 27.2)  # travel of the surfaces at the solved times [b]
HEAT_NODES = 97


@dataclass(frozen=True)
class DryLimit:
    """A contact without a film."""

    film_ratio: float  # lambda [-]
    boundary_film: float  # h_boundary, the gap of touching solids [m]
    film_mean: float  # mean gap over the middle 30 % of the Hertz width, boundary film included [m]
    pressure_max: float  # mean over a few times [Pa]
    # relative error by neglecting the film [-]; that of the film includes the sampling error
    friction_error: float
    film_error: float
    contact: DryContactResult  # at the last time
    note: str  # the estimate as text


def share_deficit(film_share: float, peklenik_number: float, stiffening: float) -> float:
    """Upper estimate of the load share of a negligible film [-].

    film_share: smooth film over boundary film [-].
    stiffening: alpha p_h [-].
    """
    drained = min(DEFICIT_DRAINED * max(peklenik_number, 1.0) ** DEFICIT_GROWTH, DEFICIT_SEALED)
    strength = (film_share / FILM_SHARE) * max(1.0, stiffening / STIFFENING)
    return float(min(drained * strength**DEFICIT_POWER, 1.0))


def dry_limit(problem: ContactProblem, film: float, friction_film: float) -> DryLimit | None:
    """Dry contact if the film carries a negligible load, else None; None also if no mesh resolves the roughness.

    film: central film of the smooth contact [m].
    friction_film: friction of that film [-]; the load on the film has between this friction and none.
    """
    contact, surface, model = problem.line, problem.surface, problem.model
    boundary_friction = surface.boundary_friction
    if model.shortcuts == "off" or contact.speed_sliding == 0.0 or boundary_friction == 0.0:
        return None
    stiffening = problem.lubricant.alpha * contact.pressure_hertz

    def left_out(boundary: float) -> tuple[float, float]:
        """Load share of the film, and the error of mu by neglecting it."""
        share = share_deficit(film / boundary, surface.peklenik_number, stiffening)
        return share, share * max(1.0, friction_film / boundary_friction)

    if not surface.measured:
        # decided before any profile is generated
        unresolved = NODES_PER_LENGTH * 2.0 * REACH * contact.half_width > NODES_MAX * surface.correlation_length
        if unresolved or left_out(surface.film_of_contact)[1] > 0.5 * model.tolerance:
            return None
    surfaces = rough_surfaces(surface, contact)
    boundary = surface.film_of_contact
    deficit, error = left_out(boundary)
    if error > 0.5 * model.tolerance:
        return None
    solved = [_dry_contact(contact, surfaces, problem.hardness, travel) for travel in MOMENTS]
    done = [result for result in solved if result is not None and result.status == "converged"]
    if len(done) < len(MOMENTS):
        return None
    middle = [float(r.gap[np.abs(r.x) < 0.3 * contact.half_width].clip(0.0).mean()) for r in done]
    mean = boundary + float(np.mean(middle))
    sampling = float(stdtrit(len(middle) - 1, 0.95)) * float(np.std(middle, ddof=1)) / math.sqrt(len(middle))
    return DryLimit(
        film_ratio=film / surfaces.rms,
        boundary_film=boundary,
        film_mean=mean,
        pressure_max=float(np.mean([r.pressure_max for r in done])),
        friction_error=error,
        film_error=sampling / mean + film / mean,
        contact=done[-1],
        note=f"negligible, {film * 1e9:.2g} nm against a boundary film of {boundary * 1e9:.2g} nm; carries at most "
        f"{100.0 * deficit:.2g} % of the load",
    )


def _dry_contact(
    contact: LineContact, surfaces: RoughSurfaces, hardness: float, travel: float
) -> DryContactResult | None:
    """The contact of both profiles after some travel; None if no mesh resolves them."""
    finest = min(surfaces.shortest_correlation_length / NODES_PER_LENGTH, surfaces.shortest_wavelength / NODES_PER_WAVE)
    count = max(NODES_MIN, math.ceil(2.0 * REACH * contact.half_width / finest))
    if count > NODES_MAX:
        return None
    x = uniform_grid(contact, count, REACH)
    heights = np.zeros_like(x)
    for profile, speed in ((surfaces.profile_1, contact.speed_1), (surfaces.profile_2, contact.speed_2)):
        if profile is None or profile.rms == 0.0:
            continue
        ring = sample_ring(profile, float(x[1] - x[0]))
        moved = travel * contact.half_width * speed / contact.speed_entrainment
        step = profile.length / ring.size
        heights += np.interp(x - moved, step * np.arange(ring.size), ring, period=step * ring.size)
    return solve_dry(contact, x, heights, hardness=hardness, tolerance=1e-5)


def flash_of_rubbing(
    contact: LineContact, boundary_friction: float, bodies: tuple[Material, Material], bulk: tuple[float, float]
) -> float:
    """Maximum surface temperature of a Hertz contact with boundary friction everywhere [K].

    Both surfaces have the same temperature, which determines the partition of heat (`flux_to_surface_1` of
    `ehl.heat.traction` with a large conductance). Temperature peaks of single asperities are not included.
    """
    b = contact.half_width
    x = b * np.linspace(-1.2, 1.2, HEAT_NODES)
    heat = boundary_friction * contact.speed_sliding * contact.pressure_hertz
    flux: FloatArray = heat * np.sqrt(np.maximum(1.0 - (x / b) ** 2, 0.0))
    rise = surface_matrices(x, contact, bodies)
    conductance = np.full_like(x, 1e3 / max(float(np.max(rise[0] + rise[1])), 1e-300))
    division, constant = flux_to_surface_1(conductance, rise[0], rise[1], bulk[1] - bulk[0])
    into_1 = division @ flux + constant
    return float(max(np.max(bulk[0] + rise[0] @ into_1), np.max(bulk[1] + rise[1] @ (flux - into_1)), *bulk))
