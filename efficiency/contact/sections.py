"""Sections across lines of contact: where relieved flanks come closest, on the lines and at the edges they end at."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.edge_lines import EdgePoints
from efficiency.contact.mesh_surface import EDGES, MeshSurface
from efficiency.contact.relief import relief_section

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class Across:
    """Sections across lines of contact, through points of the map.

    Attributes
    ----------
    surface : MeshSurface
        Map of the mesh.
    u, v : (n,) arrays
        The points.
    on_gear, on_pinion : (2, n) arrays
        Change of the map coordinates along the section [1], [1/m]: of the gear point, and of that conjugate to
        the pinion point there.
    centre : (n,) array
        Closest approach of the flanks without relief [m].
    curvature : (n,) array
        Their relative curvature [1/m].
    """

    surface: MeshSurface
    u: FloatArray
    v: FloatArray
    on_gear: FloatArray
    on_pinion: FloatArray
    centre: FloatArray
    curvature: FloatArray

    def at(self, points: NDArray[np.bool_]) -> Across:
        """Some of the sections."""
        names = [name for name in self.__dataclass_fields__ if name != "surface"]
        return Across(self.surface, *(getattr(self, name)[..., points] for name in names))

    @cached_property
    def _pinion_place(self) -> tuple[FloatArray, FloatArray]:
        """u1, h1 on the pinion and their change along the section, (2, n) each."""
        p = self.surface.patch
        by_u, by_v = p(self.u, self.v, ("u1", "h1"), du=1), p(self.u, self.v, ("u1", "h1"), dv=1)
        return p(self.u, self.v, ("u1", "h1")), by_u * self.on_pinion[0] + by_v * self.on_pinion[1]

    def places(self, x: FloatArray) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
        """Blank coordinates on gear and pinion at places (n, m) along the sections [m]."""
        u, v = self.u[:, None] + self.on_gear[0][:, None] * x, self.v[:, None] + self.on_gear[1][:, None] * x
        (u1, h1), (by_u, by_h) = self._pinion_place
        pinion = u1[:, None] + by_u[:, None] * x, h1[:, None] + by_h[:, None] * x
        return (u, self.surface.height(u, v)), pinion

    def relief(self, x: FloatArray) -> FloatArray:
        """Relief of both members at places (n, m) along the sections [m]."""
        gear, pinion = self.places(x)
        of, surface = self.surface.relief, self.surface
        return of.gear.depth(surface.gear.blank, *gear) + of.pinion.depth(surface.pinion.blank, *pinion)

    def outwards(self, edge: IntArray) -> FloatArray:
        """+1 where the section leaves the flank over an edge of `EDGES` with growing place, else -1."""
        gear, pinion = self.places(np.array([[0.0, 1e-6]]))
        signs = np.ones(edge.size)
        for first, blank, (u, h) in (
            (0, self.surface.gear.blank, gear),
            (len(EDGES) // 2, self.surface.pinion.blank, pinion),
        ):
            inside = (u, -u, blank.tip(u) - h)
            for k, distance in enumerate(inside):
                signs = np.where(edge == first + k, np.sign(distance[:, 0] - distance[:, 1]), signs)
        return signs


def relieved(across: Across, fields: dict[str, FloatArray]) -> FloatArray:
    """Put the relief into gap and radius of points of lines; how far their closest approach moves [m]."""
    moved = np.zeros(across.u.size)
    if not across.surface.relief:
        return moved
    cut = across.relief(across.centre[:, None])[:, 0] > 0.0
    if cut.any():
        own = across.at(cut)
        section = relief_section(own.relief, own.curvature, own.centre)
        moved[cut] = section.place - own.centre
        fields["minimum_gap"][cut] += section.gap
        fields["radius_equivalent"][cut] = 1.0 / section.curvature
    return moved


def relieved_edges(across: Across, fields: dict[str, FloatArray], points: EdgePoints) -> FloatArray:
    """Put the relief into the radius of edge points; distance of their closest approach inside the edge [m].

    ``relief`` of the fields becomes the gear rotation that the relief adds to what closes the sharp edge [rad].
    """
    fields["relief"] = np.zeros(across.u.size)
    if not across.surface.relief or not across.u.size:
        return -points.distance
    out = across.outwards(points.edge)
    section = relief_section(across.relief, across.curvature, out * points.distance)
    distance = -out * section.place
    # inside the flank the relief touches first, at the edge it is missing there
    sharp = 0.5 * across.curvature * points.distance**2
    added = np.where(distance >= 0.0, section.gap - sharp, across.relief(np.zeros((across.u.size, 1)))[:, 0])
    fields["relief"] = np.maximum(added, 0.0) / fields["lever_gear"]
    fields["radius_equivalent"] = 1.0 / section.curvature
    return np.asarray(distance)
