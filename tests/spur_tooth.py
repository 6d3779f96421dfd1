"""Solid teeth of cylindrical gears: a blank whose pitch cone is the axis, so that heights are radii."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from efficiency.contact.tooth_grid import ToothGrid
from efficiency.cutting.blank import Blank
from efficiency.ltca.solid_tooth import SolidTooth, ToothBody, solid_tooth
from ehl.material import Material


def spur_tooth(
    teeth: int, root: float, tip: float, width: float, thickness: Callable[[float], float], rim: float, steel: Material
) -> SolidTooth:
    """Straight tooth from the root to the tip radius [m]; `thickness` is the arc at a radius [m]."""
    # a cone of no angle is no blank that an input may be
    blank = Blank.model_construct(
        teeth=teeth,
        pitch_angle=0.0,
        mean_cone_distance=0.5 * width,
        face_width=width,
        mean_addendum=tip,
        mean_dedendum=-root,
        addendum_angle=0.0,
        dedendum_angle=0.0,
        pitch_apex_beyond_crossing=0.0,
    )
    radii, stations = np.linspace(root, tip, 15), np.linspace(-0.5, 0.5, 7) * width
    height, u = (np.array(grid) for grid in np.meshgrid(radii, stations, indexing="ij"))
    half = np.array([0.5 * thickness(radius) / radius for radius in radii])[:, None] + 0.0 * u
    grid = ToothGrid(blank, u, height, -half, half, ("convex", "concave"), (False, False))
    return solid_tooth(grid, "concave", ToothBody(steel, rim))
