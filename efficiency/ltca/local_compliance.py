"""Local compliance of the flanks in contact (Weber), with the tooth edges near the contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from efficiency.ltca.edge_contact import EdgeSection
from ehl.common.arrays import FloatArray, IntArray
from ehl.line_contact import hertz_half_width
from ehl.material import Material


def weber_local(
    load_per_length: ArrayLike, half_width: ArrayLike, depth: ArrayLike, youngs_modulus: float, poisson_ratio: float
) -> FloatArray:
    """Approach of a Hertz line contact of half-width b to a point at the depth h below it, for one body [m].

    Plane strain of the Hertz stresses on the axis of symmetry, integrated from the surface to the depth (ours):

        d = 2 w'(1 - nu^2)/(pi E) [asinh(h/b) - nu/(1 - nu) (H sqrt(1 + H^2) - H^2)],  H = h/b.

    For h >> b it approaches the formula of Weber (1949) with ``ln(2 h/b) - nu/(2 (1 - nu))`` in the bracket, but it is
    never negative.
    """
    ratio = np.asarray(depth, float) / np.asarray(half_width, float)
    scale = 2.0 * np.asarray(load_per_length, float) * (1.0 - poisson_ratio**2) / (np.pi * youngs_modulus)
    # H sqrt(1+H^2) - H^2 without cancellation
    lateral = ratio / (np.sqrt(1.0 + ratio**2) + ratio)
    return np.asarray(scale * (np.arcsinh(ratio) - poisson_ratio / (1.0 - poisson_ratio) * lateral))


@dataclass(frozen=True)
class LocalCompliance:
    """Nonlinear local compliance of both bodies at a set of contact points."""

    radius_equivalent: FloatArray  # (n,) equivalent radius normal to the contact line [m]
    depths: Sequence[FloatArray]  # distance from the flank to the middle plane of pinion and gear tooth [m]
    materials: Sequence[Material]  # pinion and gear
    effective_modulus: float  # E' [Pa]

    def approach(self, load_per_length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Approach of both middle planes [m] and its derivative by the load per length [m2/N], for loads above 0."""
        b = hertz_half_width(load_per_length, self.radius_equivalent, self.effective_modulus)
        total, slope = np.zeros_like(b), np.zeros_like(b)
        for depth, material in zip(self.depths, self.materials, strict=True):
            nu = material.poisson_ratio
            part = weber_local(load_per_length, b, depth, material.youngs_modulus, nu)
            scale = 2.0 * (1.0 - nu**2) / (np.pi * material.youngs_modulus)
            ratio = depth / b
            # d/dw of w f(h/b), b ~ sqrt(w): f - (H/2) f'(H)
            root = np.sqrt(1.0 + ratio**2)
            dlateral = (root - ratio) ** 2 / root
            total += part
            slope += part / load_per_length - scale * 0.5 * ratio * (1.0 / root - nu / (1.0 - nu) * dlateral)
        return total, slope


@dataclass(frozen=True)
class LocalApproach:
    """Load-deflection law of n points."""

    length: FloatArray  # (n,) length of contact line represented by each point [m]
    flanks: LocalCompliance  # compliance of the flanks without edges
    free_edge: FloatArray  # (n,) additional compliance near a free edge [m2/N]
    # (n,) distance of the closest approach from the edge [m], negative beyond it; infinite without edges
    edge_distance: FloatArray
    rounding: FloatArray  # (n,) radius of the edge [m]

    @classmethod
    def joined(cls, parts: Sequence[LocalApproach]) -> LocalApproach:
        """Concatenated points of several laws of the same bodies."""
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
        """Hertz half-width of the flanks without edges for a load per length [m]."""
        return hertz_half_width(load, self.flanks.radius_equivalent, self.flanks.effective_modulus)

    def sections(self, load: FloatArray) -> tuple[IntArray, EdgeSection]:
        """Points whose contact reaches an edge, and their edge contact."""
        half_width = self.half_width(load)
        # a force whose contact width underflows to zero is no contact
        at = np.flatnonzero((self.edge_distance < half_width) & (half_width > 0.0))
        ratio = self.flanks.radius_equivalent[at] / self.rounding[at]
        return at, EdgeSection.of(self.edge_distance[at] / half_width[at], ratio)

    def __call__(self, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Local approach at each point [m] and its derivative by the force [m/N], for forces above 0 [N]."""
        load = force / self.length
        approach, slope = self.flanks.approach(load)
        approach, slope = approach + self.free_edge * load, slope + self.free_edge
        at, section = self.sections(load)
        if at.size:
            scale = 4.0 / (np.pi * self.flanks.effective_modulus)
            approach[at] += scale * load[at] * section.approach
            slope[at] += scale * section.approach_rate
        return approach, slope / self.length
