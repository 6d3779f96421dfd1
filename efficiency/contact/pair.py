"""The geometry of one gear pair and one flank pair in mesh: what stages 1 and 2 of the method leave behind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from efficiency.blank.cones import ToothShape
from efficiency.contact.mesh_surface import MeshSurface, mesh_surface
from efficiency.contact.thickness import tooth_shapes
from efficiency.contact.transmission import ContactPath, contact_path
from efficiency.design import Design

Side = Literal["drive", "coast"]


@dataclass(frozen=True)
class GearPair:
    """Geometry of a pair, for one side (drive or coast) and one set of misalignments.

    Attributes
    ----------
    design : Design
        What it was computed from.
    side : str
        ``"drive"`` or ``"coast"``: which flank pair is in contact.
    surface : MeshSurface
        Both flanks, surface of roll angle, ease-off.
    path : ContactPath
        Unloaded contact path and transmission error of one tooth pair, half a pitch to both sides of its highest point.
    shape_pinion, shape_gear : ToothShape
        Depth and thickness of one tooth of each member along its face.
    """

    design: Design
    side: Side
    surface: MeshSurface
    path: ContactPath
    shape_pinion: ToothShape
    shape_gear: ToothShape

    @property
    def name(self) -> str:
        """Name of the design."""
        return self.design.name

    @property
    def teeth_pinion(self) -> int:
        """Number of teeth of the pinion."""
        return self.design.pinion.blank.teeth

    @property
    def teeth_gear(self) -> int:
        """Number of teeth of the gear."""
        return self.design.gear.blank.teeth


def gear_pair(design: Design, side: Side = "drive") -> GearPair:
    """Compute the geometry of a pair.

    Parameters
    ----------
    design : Design
        Design, misalignments included.
    side : str
        ``"drive"`` or ``"coast"``.

    Raises
    ------
    ConvergenceError
        A flank does not exist in the mating region (undercut), or the members do not mesh.
    """
    pinion, gear = design.flanks(side)
    surface = mesh_surface(gear, pinion, design.placement())
    path = contact_path(surface, surface.crest_roll + np.linspace(-0.5, 0.5, 41) * surface.pitch)
    shape_pinion, shape_gear = tooth_shapes(design)
    return GearPair(design, side, surface, path, shape_pinion, shape_gear)
