"""Local approach of the flanks at a set of contact points under their loads: Hertz, free side faces, rounded edges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.ltca.compliance import LocalCompliance
from efficiency.ltca.edge_contact import EdgeSection

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class LocalApproach:
    """Local law of n points.

    Attributes
    ----------
    length : (n,) array
        Length of contact line each stands for [m].
    flanks : LocalCompliance
        Of the flanks where no edge is near.
    free_edge : (n,) array
        Additional compliance next to a free edge [m2/N].
    edge_distance : (n,) array
        From the place of closest approach to the edge [m], negative beyond it; infinite where edges are left out.
    rounding : (n,) array
        Radius of the edge [m].
    """

    length: FloatArray
    flanks: LocalCompliance
    free_edge: FloatArray
    edge_distance: FloatArray
    rounding: FloatArray

    @classmethod
    def joined(cls, parts: Sequence[LocalApproach]) -> LocalApproach:
        """The points of several laws of the same bodies, one after the other."""
        first = parts[0].flanks
        flanks = LocalCompliance(
            np.concatenate([part.flanks.radius_equivalent for part in parts]),
            [np.concatenate([part.flanks.depths[k] for part in parts]) for k in (0, 1)],
            first.materials,
            first.effective_modulus,
        )
        length, free_edge, distance, rounding = (
            np.concatenate([getattr(part, name) for part in parts])
            for name in ("length", "free_edge", "edge_distance", "rounding")
        )
        return cls(length, flanks, free_edge, distance, rounding)

    def half_width(self, load: FloatArray) -> FloatArray:
        """Hertz half-width of the flanks for a load per length, edges left out [m]."""
        radius, modulus = self.flanks.radius_equivalent, self.flanks.effective_modulus
        return np.asarray(np.sqrt(8.0 * load * radius / (np.pi * modulus)))

    def sections(self, load: FloatArray) -> tuple[IntArray, EdgeSection]:
        """Points whose contact reaches an edge, and the contact there."""
        half_width = self.half_width(load)
        # a force so small that it has no width in floating point is none
        at = np.flatnonzero((self.edge_distance < half_width) & (half_width > 0.0))
        ratio = self.flanks.radius_equivalent[at] / self.rounding[at]
        return at, EdgeSection.of(self.edge_distance[at] / half_width[at], ratio)

    def __call__(self, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Local approach at each point [m] and its derivative by the force [m/N], forces above 0 [N]."""
        load = force / self.length
        approach, slope = self.flanks.approach(load)
        approach, slope = approach + self.free_edge * load, slope + self.free_edge
        at, section = self.sections(load)
        if at.size:
            scale = 4.0 / (np.pi * self.flanks.effective_modulus)
            approach[at] += scale * load[at] * section.approach
            slope[at] += scale * section.approach_rate
        return approach, slope / self.length
