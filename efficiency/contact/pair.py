"""The geometry of one gear pair and one flank pair in mesh: what stages 1 and 2 of the method leave behind."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from efficiency.blanks.cones import ToothShape
from efficiency.contact.conjugate import ConjugateFlank
from efficiency.contact.flank_grid import SHAPE, FlankGrid
from efficiency.contact.grid_flank import GridFlank
from efficiency.contact.mesh_surface import MeshSurface, mesh_surface
from efficiency.contact.pattern import MARKING, ContactPattern, contact_pattern
from efficiency.contact.thickness import tooth_shapes
from efficiency.contact.transmission import ContactPath, Transmission, transmission
from efficiency.design.design import Design

Side = Literal["drive", "coast"]


@dataclass(frozen=True)
class FlankPair:
    """Geometry of a pair, for one side (drive or coast) and one set of misalignments.

    Attributes
    ----------
    design : Design
        What it was computed from.
    side : str
        ``"drive"`` or ``"coast"``: which flank pair is in contact.
    surface : MeshSurface
        Both flanks, surface of roll angle, ease-off.
    transmission : Transmission
        Unloaded contact path of one tooth pair, transmission error of all.
    """

    design: Design
    side: Side
    surface: MeshSurface
    transmission: Transmission

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

    @property
    def path(self) -> ContactPath:
        """Unloaded contact path of one tooth pair, one pitch to both sides of its highest point."""
        return self.transmission.path

    def pattern(self, thickness: float = MARKING) -> ContactPattern:
        """Contact pattern for a thickness of the marking compound [m]."""
        return contact_pattern(self.surface, self.transmission, thickness)

    @property
    def shape_pinion(self) -> ToothShape:
        """Depth and thickness of one tooth of the pinion along its face."""
        return self._shapes[0]

    @property
    def shape_gear(self) -> ToothShape:
        """Depth and thickness of one tooth of the gear along its face."""
        return self._shapes[1]

    @cached_property
    def _shapes(self) -> tuple[ToothShape, ToothShape]:
        return tooth_shapes(self.design)

    @property
    def notes(self) -> tuple[str, ...]:
        """What a designer has to know of the contact without load."""
        notes = []
        for name, flank in (("pinion", self.surface.pinion), ("gear", self.surface.gear)):
            if isinstance(flank, (ConjugateFlank, GridFlank)):
                error = f"{flank.error * 1e6:.2g} um" if flank.error > 1e-9 else "below 1 nm"
                notes.append(f"the {flank.side} {name} flank is {flank.origin}; error of that surface {error}")
        gone = self.surface.absent
        if gone is not None:
            u, v = (tuple(1e3 * x for x in gone.u), gone.fraction)
            notes.append(
                f"the {self.surface.pinion.side} pinion flank is undercut: {100.0 * gone.share:.2g} % of the mating "
                f"flank is missing, at {u[0]:.3g} to {u[1]:.3g} mm from the mean point along the gear, depth fraction "
                f"{v[0]:.2f} to {v[1]:.2f} of the gear"
            )
        if self.transmission.edges:
            notes.append("unloaded contact runs over an edge: " + ", ".join(self.transmission.edges))
        if not self.transmission.settled:
            notes.append("the place of the unloaded contact is approximate at some pinion angles")
        return tuple(notes)


def flank_pair(
    design: Design, side: Side = "drive", shape: tuple[int, int] = SHAPE, grid: FlankGrid | None = None
) -> FlankPair:
    """Compute the geometry of a pair.

    Parameters
    ----------
    design : Design
        Design, misalignments included.
    side : str
        ``"drive"`` or ``"coast"``.
    shape : (int, int)
        Chebyshev coefficients of the map along the face and over the depth; its error estimate tells what it costs.
    grid : FlankGrid, optional
        Flank points solved before for the same pair in another state of misalignment.

    Raises
    ------
    ConvergenceError
        A flank does not exist at its design point, the gear flank ends in the mating region, or the members do not
        mesh.
    """
    pinion, gear = (grid.pinion, grid.gear) if grid is not None else design.flanks(side)
    surface = mesh_surface(gear, pinion, design.placement(), shape=shape, grid=grid)
    return FlankPair(design, side, surface, transmission(surface))
