"""Contact pattern: where the unloaded flanks come closer than the marking compound is thick, on both members.

While the mesh turns without load, the gear lags by its transmission error and every point of the flank comes closest to
its mate when the contact line passes it. The separation left then is the ease-off less what the lag closes; the change
of the lag while the line passes adds ``(lever dTE/dphi)^2/(2 bend)``, some 0.02 um, and is left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.mesh_surface import EDGES, MeshSurface
from efficiency.contact.transmission import Transmission

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# 0.00025 inch, the usual thickness of marking compound
MARKING = 6.35e-6
_SHAPE = (121, 61)
# the pattern touches an edge where a marked sample lies within this share of the face width or depth from it
_RIM = 0.01


@dataclass(frozen=True)
class ContactPattern:
    """Marked part of the flanks; all fields over a grid of the gear flank, (rows, columns), root to tip, toe to heel.

    Attributes
    ----------
    thickness : float
        Of the marking compound [m].
    gear_u, gear_height, pinion_u, pinion_height : (rows, columns) arrays
        Where the points lie on both members: from the mean point along the pitch cone, over that cone [m].
    separation : (rows, columns) array
        Least distance of the flanks during the mesh [m].
    inside : (rows, columns) bool array
        Where both members have a flank.
    area_share : float
        Marked share of the part both flanks have.
    centre : (float, float)
        Centroid of the mark on the gear: u [m] and share of its depth.
    length, width : float
        Extent along the face and over the depth, as shares of face width and whole depth of the gear.
    edges : tuple of str
        Edges that the mark runs into.
    """

    thickness: float
    gear_u: FloatArray
    gear_height: FloatArray
    pinion_u: FloatArray
    pinion_height: FloatArray
    separation: FloatArray
    inside: BoolArray
    area_share: float
    centre: tuple[float, float]
    length: float
    width: float
    edges: tuple[str, ...]

    @property
    def marked(self) -> BoolArray:
        """Where the compound is pressed away."""
        return np.asarray(self.inside & (self.separation <= self.thickness))


def contact_pattern(
    surface: MeshSurface, mesh: Transmission, thickness: float = MARKING, shape: tuple[int, int] = _SHAPE
) -> ContactPattern:
    """Contact pattern of the unloaded mesh.

    Parameters
    ----------
    surface : MeshSurface
        Map of the mesh.
    mesh : Transmission
        Its transmission error.
    thickness : float
        Of the marking compound [m].
    shape : (int, int)
        Samples along the face and over the depth.
    """
    half = 0.5 * surface.gear.blank.face_width
    low = max(0.0, surface.patch.v_range[0])
    grid_u, grid_v = np.meshgrid(np.linspace(-half, half, shape[0]), np.linspace(low, 1.0, shape[1]))
    u, v = grid_u.ravel(), grid_v.ravel()
    limits = surface.limits(u, v)
    inside = limits.min(axis=0) >= 0.0
    relief, lever, roll, u1, h1 = surface.patch(u, v, ("ease_off", "lever", "roll", "u1", "h1"))
    relief = relief + surface.relief_depth(u, v)
    separation = np.where(inside, np.maximum(relief + lever * mesh.at(roll), 0.0), np.inf)
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
