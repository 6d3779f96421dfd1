"""What the edges of the teeth carry: shares of the load, pressure at the edge and how uncertain it is."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.mesh_surface import EDGES
from efficiency.ltca.edge_contact import EdgeSection
from efficiency.ltca.load_distribution import LoadDistribution, TeethElasticity

FloatArray = NDArray[np.float64]

# the radius of an edge is seldom known better than by this factor
_RADIUS_FACTOR = 2.0


@dataclass(frozen=True)
class EdgeLoad:
    """Load at the tip, toe and heel edges over one mesh cycle.

    Attributes
    ----------
    share : float
        Of the torque, where the contact reaches an edge [-].
    share_extended : float
        Of the torque, carried by edges before and after the path of the smooth flanks [-].
    shares : dict of str to float
        Share of the torque at each edge [-]; only edges that carry.
    pressure : float
        Greatest elastic pressure at an edge [Pa]; 0 where none carries.
    pressure_lower, pressure_upper : float
        The same load on edges of twice and of half the radius [Pa].
    edge : str
        Where the greatest one is, such as ``gear tip``; empty where no edge carries.
    position, point : int
        Its mesh position and point.
    """

    share: float = 0.0
    share_extended: float = 0.0
    shares: dict[str, float] = field(default_factory=dict)
    pressure: float = 0.0
    pressure_lower: float = 0.0
    pressure_upper: float = 0.0
    edge: str = ""
    position: int = -1
    point: int = -1


def edge_load(load: LoadDistribution, teeth: TeethElasticity) -> EdgeLoad:
    """Load and pressure at the edges."""
    count = len(load.positions)
    shares: dict[str, float] = {}
    extended, peak, lower, upper = 0.0, 0.0, 0.0, 0.0
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
        distance = near.distance[at] / (4.0 * p.position.radius_equivalent[at] * flank / teeth.effective_modulus)
        blunt, sharp = (
            float((flank * EdgeSection.of(distance, ratio * factor).pressure_max).max())
            for factor in (1.0 / _RADIUS_FACTOR, _RADIUS_FACTOR)
        )
        lower, upper = max(lower, blunt), max(upper, sharp)
    if not shares:
        return EdgeLoad()
    return EdgeLoad(float(sum(shares.values())), extended, shares, peak, lower, upper, edge, number, point)
