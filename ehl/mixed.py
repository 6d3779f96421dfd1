"""A rough contact by the deterministic transient solver: surfaces from their description, and when to leave it out."""

from __future__ import annotations

import math

from ehl.contact import LineContact
from ehl.inputs import ModelInput, SurfaceInput
from ehl.lubricant import Lubricant
from ehl.material import Material
from ehl.measured_profile import load_profile
from ehl.roughness import RoughProfile, generate_profile
from ehl.transient import RoughSurfaces, TransientResult, solve_transient
from ehl.transient.accuracy import refuse_unresolvable

PROFILE_LENGTH = 32.0  # of a generated profile [b]
SHORTEST = 60  # correlation lengths a generated profile holds at least
# relative change of mu by roughness at a film ratio of 2.8, and how fast it falls with the film ratio: the largest of
# our runs (three seeds, sealed and drained: 3.1 % at 2.8, 1.2 % at 4.0, 0.3 % at 5.9 and 8.9)
ROUGHNESS_EFFECT, ROUGHNESS_RATIO, ROUGHNESS_POWER = 0.031, 2.8, 1.8
TOLERANCE = {"fast": 0.05, "standard": 0.02, "reference": 0.01}


def roughness_effect(film_ratio: float) -> float:
    """Estimated relative change of mu by roughness where films are thick (ours) [-]."""
    return float(ROUGHNESS_EFFECT * (ROUGHNESS_RATIO / film_ratio) ** ROUGHNESS_POWER)


def roughness_matters(film_ratio: float, model: ModelInput) -> bool:
    """Whether the estimated effect of roughness on mu exceeds half the tolerance asked for."""
    tolerance = model.friction_tolerance or TOLERANCE[model.accuracy]
    return model.shortcuts == "off" or roughness_effect(film_ratio) > 0.5 * tolerance


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
                    max(PROFILE_LENGTH * half_width, SHORTEST * lc),
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


def solve_mixed(
    contact: LineContact,
    lubricant: Lubricant,
    surface: SurfaceInput,
    model: ModelInput,
    bodies: tuple[Material, Material],
    *,
    thermal: bool,
) -> TransientResult:
    """Run the transient solver for one contact description.

    Parameters
    ----------
    contact, lubricant, surface, model, bodies
        As in `ehl.solve.solve_contact`.
    thermal : bool
        Whether heat matters.
    """
    for rms, path in ((surface.roughness_rms_1, surface.profile_1), (surface.roughness_rms_2, surface.profile_2)):
        if rms > 0.0 and path is None:
            accuracy = model.friction_tolerance or model.accuracy
            refuse_unresolvable(accuracy, surface.correlation_length / contact.half_width)
    return solve_transient(
        contact,
        lubricant,
        rough_surfaces(surface, contact.half_width),
        accuracy=model.friction_tolerance or model.accuracy,
        boundary_film=surface.boundary_film,
        boundary_friction=surface.boundary_friction,
        peklenik_number=math.inf if surface.peklenik_number > 1e5 else surface.peklenik_number,
        thermal=thermal,
        hardness=min(body.hardness for body in bodies),
        materials=bodies,
    )
