"""Running-in as plastic flattening: the peaks of a profile that a hard contact presses beyond their hardness.

Ours, and not proven: wear, tribofilms and the rounding of waves are left out. Off unless asked for.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ehl.common.errors import ConvergenceError
from ehl.line_contact import LineContact
from ehl.rough.dry import solve_dry, uniform_grid
from ehl.surface.roughness import RoughProfile

# half the width of a window and the step to the next [b]: every place sees 0.87 of the largest pressure or more
REACH, STEP = 2.0, 1.0
MOST_NODES = 4096
# of the gap, over b^2/R: about a nanometre
TOLERANCE = 1e-4
RUNNING_IN = "running-in"  # how its notes begin


def flattened(profile: RoughProfile, contact: LineContact, hardness: float) -> RoughProfile:
    """The profile after it has rolled once, dry and without friction, against a smooth counterpart.

    The contact is elastic up to the hardness; where the pressure reaches it, the overlap that is left is material
    yielded (Almqvist, Sahlin, Larsson & Glavatskih 2007) and is taken off the heights. The volume is not put elsewhere.

    profile: periodic heights [m].
    contact: radius, modulus, load.
    hardness: of the softer body [Pa].
    Returns: with a note on the height taken off.
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
        # where a sample of the profile lies in the window, around its middle
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
