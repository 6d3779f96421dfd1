"""Unloaded contact of one flank pair: ease-off, surface of roll angle, contact path and transmission error (TCA)."""

from __future__ import annotations

from dataclasses import dataclass, replace

from efficiency.contact.conjugate import ConjugateFlank
from efficiency.contact.flank_grid import SHAPE, FlankGrid
from efficiency.contact.gear_flanks import GearFlanks, Side
from efficiency.contact.grid_flank import GridFlank
from efficiency.contact.measured_flank import MeasuredFlank
from efficiency.contact.mesh_surface import MeshSurface, mesh_surface
from efficiency.contact.pattern import MARKING, ContactPattern, contact_pattern
from efficiency.contact.transmission import ContactPath, Transmission, transmission
from ehl.common.quantities import to_display


@dataclass(frozen=True)
class FlankPair:
    """Tooth contact analysis of one flank pair (drive or coast) in one state of misalignment.

    Attributes
    ----------
    flanks : GearFlanks
        What it was computed from.
    side : str
        ``"drive"`` or ``"coast"``: which flank pair is in contact.
    surface : MeshSurface
        Both flanks, surface of roll angle, ease-off.
    transmission : Transmission
        Unloaded contact path of one tooth pair, transmission error of all.
    """

    flanks: GearFlanks
    side: Side
    surface: MeshSurface
    transmission: Transmission

    @property
    def name(self) -> str:
        """Name of the pair."""
        return self.flanks.name

    @property
    def teeth_pinion(self) -> int:
        """Number of teeth of the pinion."""
        return self.flanks.assembly.teeth_pinion

    @property
    def teeth_gear(self) -> int:
        """Number of teeth of the gear."""
        return self.flanks.assembly.teeth_gear

    @property
    def path(self) -> ContactPath:
        """Unloaded contact path of one tooth pair, one pitch to both sides of its highest point."""
        return self.transmission.path

    def pattern(self, thickness: float = MARKING) -> ContactPattern:
        """Contact pattern for a thickness of the marking compound [m]."""
        return contact_pattern(self.surface, self.transmission, thickness)

    @property
    def notes(self) -> tuple[str, ...]:
        """What a designer has to know of the contact without load."""
        notes = []
        for name, flank in (("pinion", self.surface.pinion), ("gear", self.surface.gear)):
            if isinstance(flank, (ConjugateFlank, GridFlank, MeasuredFlank)):
                error = f"{flank.error * 1e6:.2g} um" if flank.error > 1e-9 else "below 1 nm"
                more = f"; {flank.note}" if isinstance(flank, MeasuredFlank) else ""
                notes.append(f"the {flank.side} {name} flank is {flank.origin}; error of that surface {error}{more}")
        if self.transmission.interval is not None:
            low, high = (to_display("transmission_error", x) for x in self.transmission.interval)
            notes.append(
                f"by the uncertainty of the measured flanks the unloaded transmission error is {low:.3g} to {high:.3g} "
                "arcsec peak to peak (95 %)"
            )
        missing = self.surface.undercut
        if missing is not None:
            u, v = (tuple(1e3 * x for x in missing.u), missing.fraction)
            notes.append(
                f"the {self.surface.pinion.side} pinion flank is undercut: {100.0 * missing.share:.2g} % of the mating "
                f"flank is missing, at {u[0]:.3g} to {u[1]:.3g} mm from the mean point along the gear, depth fraction "
                f"{v[0]:.2f} to {v[1]:.2f} of the gear"
            )
        if self.transmission.edges:
            notes.append("unloaded contact runs over an edge: " + ", ".join(self.transmission.edges))
        if not self.transmission.settled:
            notes.append("the place of the unloaded contact is approximate at some pinion angles")
        return tuple(notes)


def flank_pair(
    flanks: GearFlanks, side: Side = "drive", shape: tuple[int, int] = SHAPE, grid: FlankGrid | None = None
) -> FlankPair:
    """Tooth contact analysis of one side of a pair.

    Parameters
    ----------
    flanks : GearFlanks
        The pair, misalignments included.
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
    pinion, gear = (grid.pinion, grid.gear) if grid is not None else flanks.mating(side)
    surface = mesh_surface(gear, pinion, flanks.assembly, shape=shape, grid=grid)
    return FlankPair(flanks, side, replace(surface, relief=flanks.relief), transmission(surface))
