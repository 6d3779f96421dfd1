"""Dry contact in place of a negligible film, decided by an estimate of the load the film still carries.

share of the load off the asperities <= D gamma^0.85 (25 h/h_boundary)^1.5 max(1, alpha p_h/15)^1.5

with the smooth film h, D = 0.01 with side drainage and 0.12 in place of D gamma^0.85 in sealed valleys: ours, above
all of 18 solved contacts (`validation/mixed_shortcuts.py dry`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.fluid.lubricant import Lubricant
from ehl.heat.conduction import surface_matrices
from ehl.heat.traction import flux_to_surface_1
from ehl.inputs import ModelInput, SurfaceInput
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.rough import RoughSurfaces
from ehl.rough.batch_means import ONE_DRAW
from ehl.rough.dry import DryContactResult, solve_dry, uniform_grid
from ehl.rough.mixed import TOLERANCE, rough_surfaces
from ehl.rough.surfaces import sample_ring

# tuned: share of the load off the asperities where h is 0.04 h_boundary, its growth with the Peklenik number, power
# of film and pressure, over solved contacts; may be changed by whoever runs validation/mixed_shortcuts.py
DEFICIT_DRAINED, DEFICIT_SEALED, DEFICIT_GROWTH, DEFICIT_POWER = 0.01, 0.12, 0.85, 1.5
FILM_SHARE, STIFFENING = 0.04, 15.0
NODES_PER_LENGTH, NODES_PER_WAVE = 12.0, 2.2
NODES_MIN, NODES_MAX = 512, 8192
REACH = 2.0  # half length of the dry mesh [b]
MOMENTS = (0.0, 5.3, 9.9, 16.1, 21.7, 27.2)  # travel of the surfaces at which it is solved [b]
HEAT_NODES = 97


@dataclass(frozen=True)
class DryLimit:
    """A contact without a film."""

    film_ratio: float  # lambda [-]
    boundary_film: float  # h_boundary, the gap where the solids touch [m]
    film_mean: float  # mean gap over the middle 30 % of the Hertz width, boundary film included [m]
    pressure_max: float  # mean over a few moments [Pa]
    # relative, of leaving the film out; of the film also that of the moments taken [-]
    friction_error: float
    film_error: float
    contact: DryContactResult  # at the last of these moments
    note: str  # the estimate in words


def share_deficit(film_share: float, peklenik_number: float, stiffening: float) -> float:
    """Upper estimate of the share of the load that is not on asperities where films are negligible [-].

    film_share: smooth film over boundary film [-].
    stiffening: alpha p_h [-].
    """
    drained = min(DEFICIT_DRAINED * max(peklenik_number, 1.0) ** DEFICIT_GROWTH, DEFICIT_SEALED)
    strength = (film_share / FILM_SHARE) * max(1.0, stiffening / STIFFENING)
    return float(min(drained * strength**DEFICIT_POWER, 1.0))


def dry_limit(
    contact: LineContact,
    lubricant: Lubricant,
    film: float,
    friction_film: float,
    surface: SurfaceInput,
    model: ModelInput,
    bodies: tuple[Material, Material],
) -> DryLimit | None:
    """The dry contact where the film carries a negligible load; None where it does not, or no mesh resolves roughness.

    contact, lubricant, surface, model, bodies: as in `ehl.solve.solve_contact`.
    film: central film of the smooth contact [m].
    friction_film: friction of that film [-]: the load on the film has this friction, or none.
    """
    boundary_friction = surface.boundary_friction
    if model.shortcuts == "off" or contact.speed_sliding == 0.0 or boundary_friction == 0.0:
        return None
    tolerance = model.friction_tolerance or TOLERANCE[model.accuracy]
    stiffening = lubricant.alpha * contact.pressure_hertz

    def left_out(boundary: float) -> tuple[float, float]:
        """Share of the load on the film, and the error of mu by neglecting it."""
        share = share_deficit(film / boundary, surface.peklenik_number, stiffening)
        return share, share * max(1.0, friction_film / boundary_friction)

    if not surface.measured:
        # known before any profile is made
        if left_out(surface.film_of_contact)[1] > 0.5 * tolerance:
            return None
        if NODES_PER_LENGTH * 2.0 * REACH * contact.half_width > NODES_MAX * surface.correlation_length:
            return None
    surfaces = rough_surfaces(surface, contact, min(body.hardness for body in bodies))
    boundary = surface.film_of_contact
    deficit, error = left_out(boundary)
    if error > 0.5 * tolerance:
        return None
    solved = [_dry_contact(contact, surfaces, min(b.hardness for b in bodies), travel) for travel in MOMENTS]
    done = [result for result in solved if result is not None and result.status == "converged"]
    if len(done) < len(MOMENTS):
        return None
    middle = [float(r.gap[np.abs(r.x) < 0.3 * contact.half_width].clip(0.0).mean()) for r in done]
    mean = boundary + float(np.mean(middle))
    return DryLimit(
        film_ratio=film / surfaces.rms,
        boundary_film=boundary,
        film_mean=mean,
        pressure_max=float(np.mean([r.pressure_max for r in done])),
        friction_error=error,
        film_error=ONE_DRAW * float(np.std(middle, ddof=1)) / math.sqrt(len(middle)) / mean + film / mean,
        contact=done[-1],
        note=f"negligible, {film * 1e9:.2g} nm against a boundary film of {boundary * 1e9:.2g} nm; carries at most "
        f"{100.0 * deficit:.2g} % of the load",
    )


def _dry_contact(
    contact: LineContact, surfaces: RoughSurfaces, hardness: float, travel: float
) -> DryContactResult | None:
    """The contact of both profiles after some travel; None where no mesh resolves them."""
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
        step = profile.length / ring.size if profile.periodic else profile.spacing
        heights += np.interp(x - moved, step * np.arange(ring.size), ring, period=step * ring.size)
    return solve_dry(contact, x, heights, hardness=hardness, tolerance=1e-5)


def flash_of_rubbing(
    contact: LineContact, boundary_friction: float, bodies: tuple[Material, Material], bulk: tuple[float, float]
) -> float:
    """Maximum surface temperature of a Hertz contact with boundary friction everywhere [K].

    Bodies in touch have one temperature, so the heat divides itself (`ehl.heat.traction.flux_to_surface_1` with a
    conductance that does not hinder it). Spots are hotter than their mean: they are not in it.
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
