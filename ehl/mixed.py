"""A rough contact by the deterministic transient solver: its surfaces, what no mesh shows, and when to leave it out."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ehl.contact import LineContact
from ehl.errors import ConvergenceError
from ehl.heat import ThermalTraction
from ehl.inputs import ModelInput, SurfaceInput
from ehl.lubricant import Lubricant
from ehl.material import Material
from ehl.measured_profile import load_profile
from ehl.rheology import RisingStress
from ehl.roughness import LEAST_FILM, RoughProfile, generate_profile
from ehl.subgrid import BUDGET_SHARE, CUTOFF_NODES, split_surfaces
from ehl.transient import RoughSurfaces, TransientResult, solve_transient
from ehl.transient.accuracy import BUDGET, LEVELS, NODES_MIN, level_of, mesh_length, refuse_unresolvable
from ehl.transient.scaling import film_estimate

FloatArray = NDArray[np.float64]

PROFILE_LENGTH = 32.0  # of a generated profile [b]
SHORTEST = 60  # correlation lengths a generated profile holds at least
# relative change of mu by roughness at a film ratio of 2.8, and how fast it falls with the film ratio: the largest of
# our runs (three seeds, sealed and drained: 3.1 % at 2.8, 1.2 % at 4.0, 0.3 % at 5.9 and 8.9)
ROUGHNESS_EFFECT, ROUGHNESS_RATIO, ROUGHNESS_POWER = 0.031, 2.8, 1.8
# films of a shear stress far below tau0 stay viscous, and ripples of the pressure raise mu as exp(alpha p): 3 to 20 %
# where 2.4 % hold at tau0, in seven scenes down to 0.02 tau0; the inverse of the stress bounds them all
LEAST_STRESS = 0.02
REGULAR_WAVES = 1.15  # in Rq: at a film ratio of 3.9 ridges and waves change mu by 1.9 %, random profiles by 1.7
GAUSSIAN_HEIGHT = 6.0  # highest peak over deepest valley of a Gaussian profile of some sixty correlation lengths [Rq]
ROLLING_EFFECT = 0.0075  # change of ln(viscosity) in the inlet: half a per cent of the film
TOLERANCE = {"fast": 0.05, "standard": 0.02, "reference": 0.01}


def roughness_effect(film_ratio: float, stress_ratio: float = math.inf) -> float:
    """Estimated relative change of mu by roughness where films are thick (ours) [-].

    Parameters
    ----------
    film_ratio : float
        Of the hot film.
    stress_ratio : float
        Mean shear stress of the smooth film over the stress from which it thins (`film_stress_ratio`).
    """
    thinned = min(stress_ratio + LEAST_STRESS, 1.0)
    return float(ROUGHNESS_EFFECT * (ROUGHNESS_RATIO / film_ratio) ** ROUGHNESS_POWER / thinned)


def roughness_matters(film_ratio: float, model: ModelInput, stress_ratio: float = math.inf) -> bool:
    """Whether the estimated effect of roughness on mu exceeds half the tolerance asked for."""
    tolerance = model.friction_tolerance or TOLERANCE[model.accuracy]
    return model.shortcuts == "off" or roughness_effect(film_ratio, stress_ratio) > 0.5 * tolerance


def film_stress_ratio(friction: float, contact: LineContact, lubricant: Lubricant) -> float:
    """Mean shear stress of a smooth film over tau0 (the stress of Carreau's law) at the mean Hertz pressure [-].

    Infinite without sliding: there is no friction that roughness could change.
    """
    if friction == 0.0:
        return math.inf
    pressure = 0.25 * math.pi * contact.pressure_hertz
    law = lubricant.shear_law
    if law.rheology == "newtonian":
        return 0.0
    stress = law.stress(np.asarray(pressure)) if isinstance(law.stress, RisingStress) else law.stress
    return abs(friction) * pressure / float(stress)


def rolling_heat_of(heat: ThermalTraction | None, lubricant: Lubricant) -> tuple[FloatArray, FloatArray] | None:
    """x [m] and heat of the pressure-driven flow [W/m2] of the smooth film; None where it does not matter.

    It does not where it changes ln(viscosity) ahead of x = 0 by less than `ROLLING_EFFECT`: a film grows with the inlet
    viscosity to the power of about 2/3.
    """
    if heat is None:
        return None
    slope = lubricant.dlog_viscosity_dtemperature(np.zeros(1), np.array([lubricant.temperature]))
    rise = np.max(heat.temperature_rise_rolling[heat.x < 0.0], initial=0.0)
    return (heat.x, heat.rolling_heat) if abs(float(slope[0])) * rise > ROLLING_EFFECT else None


def rough_surfaces(surface: SurfaceInput, half_width: float) -> RoughSurfaces:
    """Both profiles of a contact: measured where a file is given, generated otherwise.

    The generated profile depends on seed, Rq, correlation length and contact width alone, never on the mesh.
    """
    profiles: list[RoughProfile | None] = []
    for number, (rms, path) in enumerate(
        ((surface.roughness_rms_1, surface.profile_1), (surface.roughness_rms_2, surface.profile_2)), start=1
    ):
        if path is not None:
            profiles.append(
                load_profile(
                    path,
                    cutoff_long=surface.cutoff_long,
                    cutoff_short=surface.cutoff_short,
                    peklenik_number=surface.peklenik_number,
                )
            )
        elif rms > 0.0:
            lc = surface.correlation_length
            profiles.append(
                generate_profile(
                    rms,
                    lc,
                    _profile_length(surface, half_width),
                    lc / 20.0,
                    2 * surface.seed + number,
                    skewness=surface.skewness,
                    kurtosis=surface.kurtosis,
                    peklenik_number=surface.peklenik_number,
                )
            )
        else:
            profiles.append(None)
    return RoughSurfaces(*profiles)


def roughness_heights(surface: SurfaceInput, contact: LineContact) -> tuple[float, float]:
    """Composite Rq [m], and the Rq of Gaussian surfaces as high and deep as the measured ones where that is more."""
    if not surface.measured:
        return surface.roughness_rms, surface.roughness_rms
    surfaces = rough_surfaces(surface, contact.half_width)
    return surfaces.rms, max(REGULAR_WAVES * surfaces.rms, surfaces.height / GAUSSIAN_HEIGHT)


def solve_mixed(
    contact: LineContact,
    lubricant: Lubricant,
    surface: SurfaceInput,
    model: ModelInput,
    bodies: tuple[Material, Material],
    *,
    thermal: bool,
    bulk: tuple[float, float] | None = None,
    rolling_heat: tuple[FloatArray, FloatArray] | None = None,
    window: float | None = None,
) -> TransientResult:
    """Run the transient solver for one contact description.

    Parameters
    ----------
    contact, lubricant, surface, model, bodies
        As in `ehl.solve.solve_contact`.
    thermal : bool
        Whether heat matters.
    bulk : tuple of float, optional
        Bulk temperatures of both bodies [K]; that of the oil when not given.
    rolling_heat : tuple of ndarray, optional
        Heat of the pressure-driven flow along x, of the smooth film (`rolling_heat_of`).
    window : float, optional
        Travel that is averaged over [b]; it ends by the interval of mu when not given.

    Returns
    -------
    TransientResult
        "unsettled" with the reason "mesh_budget" where the roughness is finer than any mesh in budget: the boundary
        film then stands for the fine part, and `friction_boundary_half` and `friction_boundary_double` are mu without
        it and with it at its peaks.
    """
    accuracy = model.friction_tolerance or model.accuracy
    common: dict[str, Any] = {
        "accuracy": accuracy,
        "boundary_friction": surface.boundary_friction,
        "peklenik_number": math.inf if surface.peklenik_number > 1e5 else surface.peklenik_number,
        "thermal": thermal,
        "hardness": min(body.hardness for body in bodies),
        "materials": bodies,
        "temperature_bulk": bulk,
        "rolling_heat": rolling_heat,
        "elasticity": model.elasticity,
    }
    try:
        if surface.roughness_rms > 0.0:
            refuse_unresolvable(accuracy, surface.correlation_length / contact.half_width)
        surfaces = rough_surfaces(surface, contact.half_width)
        return solve_transient(
            contact, lubricant, surfaces, boundary_film=surface.boundary_film, travel=window, **common
        )
    except ConvergenceError as error:
        if error.reason != "mesh_budget":
            raise
    return _beyond_budget(contact, lubricant, surface, common)


def _beyond_budget(
    contact: LineContact, lubricant: Lubricant, surface: SurfaceInput, common: dict[str, Any]
) -> TransientResult:
    """The waves a coarse mesh carries, over a wall of the finer ones; mu without the wall and at its peaks bound it."""
    length = mesh_length(contact, film_estimate(contact, lubricant))
    level = level_of(common["accuracy"])
    nodes = max(round(BUDGET_SHARE * BUDGET[level]), NODES_MIN)
    cutoff = CUTOFF_NODES * length / nodes * contact.half_width
    split = split_surfaces(surface, contact.half_width, _profile_length(surface, contact.half_width), cutoff)
    base = surface.boundary_film or LEAST_FILM  # by the rule only the adsorbed film is left: the rest is the wall
    low, wall, high = split.walls(contact, base)
    run = solve_transient(
        contact,
        lubricant,
        split.surfaces,
        boundary_film=wall,
        boundary_range=(low, high),
        nodes=nodes,
        travel=LEVELS[level][4],
        **common,
    )
    if run.status == "failed":
        return run
    told = (
        f"roughness below {cutoff * 1e6:.3g} um (RMS {split.rms_below * 1e6:.3g} of {split.rms * 1e6:.3g} um) is finer "
        f"than the mesh: taken as a wall {wall * 1e9:.3g} nm high, its bounds {low * 1e9:.3g} and {high * 1e9:.3g} nm "
        "make the error"
    )
    return replace(run, status="unsettled", reason="mesh_budget", notes=(*run.notes, told))


def _profile_length(surface: SurfaceInput, half_width: float) -> float:
    """Period of a generated profile [m]."""
    return max(PROFILE_LENGTH * half_width, SHORTEST * surface.correlation_length)
