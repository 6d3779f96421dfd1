"""Running-in as plastic flattening of the asperities whose pressure reaches the hardness.

Own work, not validated: wear, tribofilms and the rounding of waves are neglected. It is off by default.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ehl.common.errors import ConvergenceError
from ehl.line_contact import LineContact
from ehl.rough.dry import solve_dry, uniform_grid
from ehl.surface.roughness import RoughProfile

# half width of a window and the distance of windows [b]: every place has at least 0.87 of the largest pressure
REACH, STEP = 2.0, 1.0
MOST_NODES = 4096
TOLERANCE = 1e-4  # of the gap, over b^2/R: about a nanometre
RUNNING_IN = "running-in"  # prefix of its notes


def flattened(profile: RoughProfile, contact: LineContact, hardness: float) -> RoughProfile:
    """The profile after one dry, frictionless pass against a smooth counterpart.

    The contact is elastic up to the hardness. Where the pressure reaches it, the remaining overlap has yielded
    (Almqvist, Sahlin, Larsson & Glavatskih 2007) and is removed from the heights. The volume is not conserved.

    profile: periodic heights [m].
    contact: radius, modulus, load.
    hardness: of the softer body [Pa].
    Returns: profile with a note on the removed height.
    Raises `ConvergenceError`: the contact does not carry the load below this hardness ("hardness_too_low").
    """
    if not math.isfinite(hardness):
        return profile
    b = contact.half_width
    spacing = max(profile.spacing, 2.0 * REACH * b / MOST_NODES)
    x = uniform_grid(contact, math.ceil(2.0 * REACH * b / spacing), REACH)
    places, heights = profile.x, profile.heights.copy()
    length, most = profile.length, 0.0
    for centre in np.arange(0.0, length, STEP * b):
        at = (x + centre) % length
        here = np.interp(at, places, heights, period=length)
        found = solve_dry(contact, x, here - here.mean(), hardness=hardness, tolerance=TOLERANCE)
        if found.reason == "hardness_too_low":
            raise ConvergenceError(found.reason, f"no contact below a hardness of {hardness:.4g} Pa carries the load")
        yielded = np.where(found.pressure >= hardness, np.maximum(-found.gap, 0.0), 0.0)
        if not yielded.any():
            continue
        most = max(most, float(yielded.max()))
        # position of each sample of the profile relative to the centre of the window
        off = (places - centre + 0.5 * length) % length - 0.5 * length
        heights -= np.interp(off, x, yielded, left=0.0, right=0.0)
    note = f"{RUNNING_IN}: asperities flattened plastically by up to {1e9 * most:.0f} nm at {hardness / 1e9:.3g} GPa"
    flat = RoughProfile.of(
        heights,
        profile.spacing,
        cutoff=profile.cutoff,
        rms_below_cutoff=profile.rms_below_cutoff,
        peklenik_number=profile.peklenik_number,
        seed=profile.seed,
        source=profile.source,
        notes=(*profile.notes, note),
    )
    return replace(flat, periodic=profile.periodic)
