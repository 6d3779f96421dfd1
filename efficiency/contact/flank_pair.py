"""Unloaded contact of one flank pair (TCA): ease-off, contact path, transmission error and contact pattern.

The pattern is the area where the distance of the unloaded flanks falls below the thickness of the marking compound.
Every point of the flank is nearest to its mate when the contact line passes it. The remaining separation is the
ease-off less the lag of the gear by its transmission error. The change of the lag during the passage adds
``(lever dTE/dphi)^2/(2 bend)``, about 0.02 um, which is neglected.
"""

from dataclasses import dataclass, replace

import numpy as np

from efficiency.contact.conjugate import ConjugateFlank
from efficiency.contact.contact_search import ContactPath, Transmission, transmission
from efficiency.contact.flank_grid import SHAPE, FlankGrid
from efficiency.contact.gear_flanks import GearFlanks, Side
from efficiency.contact.grid_flank import SmoothFlank
from efficiency.contact.measured_flank import MeasuredFlank
from efficiency.contact.mesh_surface import EDGES, MeshSurface, mesh_surface
from ehl.common.arrays import BoolArray, FloatArray
from ehl.common.quantities import to_display

# 0.00025 inch, the usual thickness of marking compound
MARKING = 6.35e-6
# samples along the face and over the depth
_SAMPLES = 121, 61
# tuned: fraction of the face width or depth within which a marked sample indicates contact with an edge (this work);
# may be changed freely
_RIM = 0.01


@dataclass(frozen=True)
class ContactPattern:
    """Marked part of the flanks; fields over a grid of the gear flank, (rows, columns), root to tip, toe to heel."""

    thickness: float  # thickness of the marking compound [m]
    # coordinates on both members: distance from the mean point along the pitch cone, height above that cone [m]
    gear_u: FloatArray
    gear_height: FloatArray
    pinion_u: FloatArray
    pinion_height: FloatArray
    separation: FloatArray  # minimum distance of the flanks during the mesh [m]
    inside: BoolArray  # whether both members have a flank
    area_share: float  # marked fraction of the common part of both flanks
    centre: tuple[float, float]  # centroid of the mark on the gear: u [m] and depth fraction
    # extent along the face and over the depth, as fractions of face width and whole depth of the gear
    length: float
    width: float
    edges: tuple[str, ...]  # edges at the border of the mark

    @property
    def marked(self) -> BoolArray:
        """Marked area."""
        return np.asarray(self.inside & (self.separation <= self.thickness))


@dataclass(frozen=True)
class FlankPair:
    """Tooth contact analysis of one flank pair (drive or coast) in one state of misalignment."""

    flanks: GearFlanks  # flanks of the pair
    side: Side  # flank pair in contact: ``"drive"`` or ``"coast"``
    surface: MeshSurface  # both flanks, surface of roll angle, ease-off
    transmission: Transmission  # unloaded contact path of one tooth pair, transmission error of all pairs

    @property
    def name(self) -> str:
        """Name of the pair."""
        return self.flanks.name

    @property
    def path(self) -> ContactPath:
        """Unloaded contact path of one tooth pair, one pitch to both sides of its highest point."""
        return self.transmission.path

    def pattern(self, thickness: float = MARKING) -> ContactPattern:
        """Contact pattern of the unloaded mesh for a thickness of the marking compound [m]."""
        surface = self.surface
        half = 0.5 * surface.gear.blank.face_width
        low = max(0.0, surface.patch.v_range[0])
        grid_u, grid_v = np.meshgrid(np.linspace(-half, half, _SAMPLES[0]), np.linspace(low, 1.0, _SAMPLES[1]))
        u, v = grid_u.ravel(), grid_v.ravel()
        limits = surface.limits(u, v)
        inside = limits.min(axis=0) >= 0.0
        relief, lever, roll, u1, h1 = surface.patch(u, v, ("ease_off", "lever", "roll", "u1", "h1"))
        relief = relief + surface.relief_depth(u, v)
        separation = np.where(inside, np.maximum(relief + lever * self.transmission.at(roll), 0.0), np.inf)
        marked = separation <= thickness

        depth = surface.height(u, np.ones_like(u)) - surface.height(u, np.zeros_like(u))
        weight = depth * marked
        total = weight.sum()
        centre = (float((weight * u).sum() / total), float((weight * v).sum() / total)) if total else (np.nan, np.nan)
        near = _RIM * np.array([2.0 * half, 2.0 * half, 1.0, 1.0] * 2 + [1.0])
        near[[2, 3, 6, 7, 8]] *= surface.undercut_scale
        touched = [EDGES[k] for k in range(len(EDGES)) if marked.any() and (limits[k][marked] < near[k]).any()]
        return ContactPattern(
            thickness=thickness,
            gear_u=grid_u,
            gear_height=surface.height(grid_u, grid_v),
            pinion_u=u1.reshape(grid_u.shape),
            pinion_height=h1.reshape(grid_u.shape),
            separation=separation.reshape(grid_u.shape),
            inside=inside.reshape(grid_u.shape),
            area_share=float(total / (depth * inside).sum()),
            centre=centre,
            length=float(np.ptp(u[marked]) / (2.0 * half)) if total else 0.0,
            width=float(np.ptp(v[marked])) if total else 0.0,
            edges=tuple(touched),
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the unloaded contact."""
        notes = []
        for name, flank in (("pinion", self.surface.pinion), ("gear", self.surface.gear)):
            if isinstance(flank, (ConjugateFlank, SmoothFlank)):
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
            notes.append("the position of the unloaded contact is approximate at some pinion angles")
        return tuple(notes)


def flank_pair(
    flanks: GearFlanks, side: Side = "drive", shape: tuple[int, int] = SHAPE, grid: FlankGrid | None = None
) -> FlankPair:
    """Tooth contact analysis of one side of a pair with its misalignments.

    `shape` is the number of Chebyshev coefficients of the map along the face and over the depth. `grid` holds flank
    points of the same pair from another state of misalignment. Raises `ConvergenceError` if a flank does not exist at
    its design point, the gear flank ends in the mating region, or the members do not mesh.
    """
    pinion, gear = (grid.pinion, grid.gear) if grid is not None else flanks.mating(side)
    surface = mesh_surface(gear, pinion, flanks.assembly, shape=shape, grid=grid, deviation=flanks.deviation)
    return FlankPair(flanks, side, replace(surface, relief=flanks.relief), transmission(surface))
