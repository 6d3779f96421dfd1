"""Limits of a loaded mesh: load and pressure at the edges of the teeth, pressure above the hardness."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from efficiency.contact.mesh_surface import EDGES
from efficiency.ltca.edge_contact import EdgeSection
from efficiency.ltca.load_distribution import LoadDistribution, TeethElasticity
from ehl.common.arrays import FloatArray
from ehl.common.units import ARCSEC
from ehl.line_contact import half_width_of_pressure

# points within this fraction of the face width or tooth height from the middle belong to neither side
_MIDDLE = 1.0 / 6.0
# tuned: largest transmission error of matching flanks (this work); may be changed freely
_LARGE_ERROR = 100.0 * ARCSEC
# tuned: elastic pressure at an edge over the hardness above which it certainly yields (this work); may be changed
# freely
_EDGE_YIELD = 2.0
# tuned: share of the torque above which edge load is noted (this work); may be changed freely
EDGE_NOTE = 1e-3
# tuned: share of the torque above which edge load is a warning, and largest share of a design sized for a load (this
# work); may be changed freely
EDGE_LIMIT = 5e-3
# tuned: uncertainty factor of the radius of an edge (this work); may be changed freely, pressures of a result depend on
# it
_RADIUS_FACTOR = 2.0


@dataclass(frozen=True)
class EdgeLoad:
    """Load at the tip, toe and heel edges over one mesh cycle."""

    share: float = 0.0  # share of the torque where the contact reaches an edge [-]
    share_extended: float = 0.0  # share carried by edges before and after the path of the smooth flanks [-]
    # share of the torque at each loaded edge [-]
    shares: dict[str, float] = field(default_factory=dict)
    pressure: float = 0.0  # maximum elastic pressure at an edge [Pa]; 0 without edge load
    # maximum pressure for edges of twice and of half the radius [Pa]
    pressure_lower: float = 0.0
    pressure_upper: float = 0.0
    edge: str = ""  # edge of the maximum pressure, such as ``gear tip``; empty without edge load
    # mesh position and point of the maximum pressure
    position: int = -1
    point: int = -1

    def towards(self, other: EdgeLoad, share: float) -> EdgeLoad:
        """Linear interpolation to a neighbouring load, at least zero; the place is that of the nearer load."""
        near = other if share > 0.5 else self

        def between(here: float, there: float) -> float:
            return max((1.0 - share) * here + share * there, 0.0)

        names = ("share", "share_extended", "pressure", "pressure_lower", "pressure_upper")
        values: dict[str, Any] = {name: between(getattr(self, name), getattr(other, name)) for name in names}
        edges = dict.fromkeys((*self.shares, *other.shares))
        shares = {edge: between(self.shares.get(edge, 0.0), other.shares.get(edge, 0.0)) for edge in edges}
        return replace(near, shares=shares, **values)


def edge_load(load: LoadDistribution, teeth: TeethElasticity) -> EdgeLoad:
    """Load and pressure at the edges."""
    count = len(load.positions)
    shares: dict[str, float] = {}
    extended, peak = 0.0, 0.0
    sections: list[FloatArray] = []
    edge, number, point = "", -1, -1
    for k, p in enumerate(load.positions):
        near = p.position.edge
        at = np.flatnonzero(p.at_edge)
        if near is None or not at.size:
            continue
        torque = p.force * p.position.lever_pinion
        part = torque / (float(torque.sum()) * count)
        for index in np.unique(near.index[at]):
            name = EDGES[index]
            shares[name] = shares.get(name, 0.0) + float(part[at[near.index[at] == index]].sum())
        extended += float(part[near.touching].sum())
        first = at[np.argmax(p.pressure_max[at])]
        if p.pressure_max[first] > peak:
            peak, edge, number, point = float(p.pressure_max[first]), EDGES[near.index[first]], k, int(first)
        radius = teeth.rounding(near)[at]
        ratio = p.position.radius_equivalent[at] / radius
        flank = p.pressure_hertz[at]
        width = half_width_of_pressure(flank, p.position.radius_equivalent[at], teeth.effective_modulus)
        distance = near.distance[at] / width
        sections.append(np.stack([distance, ratio, flank]))
    if not shares:
        return EdgeLoad()
    distance, ratio, flank = np.concatenate(sections, axis=1)
    lower, upper = (
        float((flank * EdgeSection.of(distance, ratio * factor).pressure_max).max())
        for factor in (1.0 / _RADIUS_FACTOR, _RADIUS_FACTOR)
    )
    return EdgeLoad(float(sum(shares.values())), extended, shares, peak, lower, upper, edge, number, point)


def hardness(teeth: TeethElasticity) -> float:
    """Hardness of the softer member [Pa]."""
    return min(teeth.material_pinion.hardness, teeth.material_gear.hardness)


def points_above_hardness(load: LoadDistribution, teeth: TeethElasticity) -> tuple[int, int]:
    """Number of points with a Hertz pressure above the hardness of the softer member, and of loaded points."""
    pressure = load.loaded["pressure_hertz"]
    return int(np.count_nonzero(pressure > hardness(teeth))), pressure.size


def edges_yield(load: LoadDistribution, teeth: TeethElasticity) -> bool:
    """Whether an edge certainly yields, so that the elastic load distribution is invalid."""
    return load.pressure_edge_max > _EDGE_YIELD * hardness(teeth)


def flank_place(load: LoadDistribution, teeth: TeethElasticity, number: int, point: int) -> str:
    """Position of a point of a mesh position on the gear flank, as text."""
    position = load.cycle[number]
    face, height = float(position.face_gear[point]), float(position.height_gear[point])
    width, depth = teeth.gear.face_width, float(teeth.gear.whole_depth(face))
    return (
        f"{_side(face / width, 'toe', 'heel')}, {_side(height / depth, 'root', 'tip')} of the gear flank "
        f"({face * 1e3:.2f} of {width * 1e3:.2f} mm from the toe, {height * 1e3:.2f} of {depth * 1e3:.2f} mm above the "
        f"root, position {number + 1} of {len(load.cycle)})"
    )


def limit_notes(
    load: LoadDistribution, teeth: TeethElasticity, unloaded: float, edges: EdgeLoad | None = None
) -> tuple[str, ...]:
    """Notes on the load: pressure above the hardness, load at edges, flanks that do not match.

    `unloaded` is the peak-to-peak transmission error without load [rad]; `edges` the edge load, if known.
    """
    notes = []
    above, loaded = points_above_hardness(load, teeth)
    if above:
        number = int(np.argmax([p.pressure_hertz.max() for p in load.positions]))
        pressure = load.positions[number].pressure_hertz
        place = flank_place(load, teeth, number, int(np.argmax(pressure)))
        notes.append(
            f"Hertz pressure above the {hardness(teeth) / 1e9:.3g} GPa hardness of the softer member at {above} of "
            f"{loaded} loaded points, up to {pressure.max() / 1e9:.4g} GPa, {place}; the teeth would yield"
        )
    edges = edges or edge_load(load, teeth)
    if edges_yield(load, teeth):
        notes.append(
            f"elastic pressure of {edges.pressure / 1e9:.3g} GPa at the {edges.edge}, more than {_EDGE_YIELD:g} times "
            f"the {hardness(teeth) / 1e9:.3g} GPa hardness: the edge yields and the load distribution is unknown; add "
            "relief there, more crowning, or reduce the torque"
        )
    if edges.share >= EDGE_NOTE:
        notes.append(_edge_note(edges, load, teeth))
    if unloaded > _LARGE_ERROR:
        notes.append(
            f"the unloaded transmission error, {unloaded / ARCSEC:.0f} arcsec peak to peak, is above "
            f"{_LARGE_ERROR / ARCSEC:.0f} arcsec: the two flanks do not match, check the machine settings"
        )
    return tuple(notes)


def _edge_note(edges: EdgeLoad, load: LoadDistribution, teeth: TeethElasticity) -> str:
    names = ", ".join(f"{name} {100.0 * share:.2g} %" for name, share in edges.shares.items())
    radius = teeth.edge_rounding_gear if edges.edge.startswith("gear") else teeth.edge_rounding_pinion
    yields = edges.pressure > hardness(teeth)
    text = (
        f"{edges_carry(edges, yields)} of the torque ({names}), {100.0 * edges.share_extended:.2g} % before and after "
        f"the path of the smooth flanks; elastic pressure at the {edges.edge} edge, radius {radius * 1e3:.3g} mm, up "
        f"to {edges.pressure / 1e9:.3g} GPa ({edges.pressure_lower / 1e9:.3g} to {edges.pressure_upper / 1e9:.3g} GPa "
        f"for twice and half the radius), {flank_place(load, teeth, edges.position, edges.point)}"
    )
    return text + f"; above the {hardness(teeth) / 1e9:.3g} GPa hardness: local yielding of the edge" * yields


def edges_carry(edges: EdgeLoad, severe: bool) -> str:
    """Beginning of a note on edge load, whose kind is a warning if it is `severe` or at least `EDGE_LIMIT`."""
    return f"edges carry {'' if severe or edges.share >= EDGE_LIMIT else 'only '}{100.0 * edges.share:.2g} %"


def _side(share: float, low: str, high: str) -> str:
    if abs(share - 0.5) <= _MIDDLE:
        return f"midway {low} to {high}"
    return f"near the {low if share < 0.5 else high}"
