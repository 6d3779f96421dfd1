"""Graded mesh of the smooth contact: node density as a sum of Lorentzians."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.smooth._kernels import graded_points, sharpest

TIP = 1e-3  # smallest resolved spike length, in half-widths
LADDER_RATIO = 2.5  # widths of neighbouring rungs
INLET_MARGIN = 40.0  # inlet length over the length of the loaded zone; beyond it an open parabola


@dataclass(frozen=True)
class Features:
    """Features of a solution that the mesh must resolve, in half-widths.

    Place and length of the largest curvature of the pressure in the inlet and at the outlet (the spike, if any), the
    exit, and the flow Q = rho H at zero pressure gradient.
    """

    flow: float
    exit: float
    inlet: float
    inlet_width: float
    spike: float
    spike_width: float

    @property
    def size(self) -> float:
        """Length of the loaded zone: the half-width, or sqrt(2 Q) where the film is thicker than the indentation."""
        return math.sqrt(1.0 + 2.0 * self.flow)

    def close_to(self, other: Features) -> bool:
        """Whether a mesh graded for ``other`` is suitable."""
        ratios = (self.flow / other.flow, self.inlet_width / other.inlet_width, self.spike_width / other.spike_width)
        widths = all(0.65 < r < 1.5 for r in ratios)
        spike = abs(self.spike - other.spike) < 0.7 * other.spike_width
        inlet = abs(self.inlet - other.inlet) < 0.7 * other.inlet_width
        return widths and spike and inlet


@dataclass(frozen=True)
class Grading:
    """Node density sum_k A_k w_k/(w_k^2 + (x - c_k)^2) on [x_in, x_exit]; frozen while the mesh is refined."""

    x_in: float
    x_exit: float
    terms: FloatArray  # shape (3, K): centres, widths, amounts
    features: Features

    def points(self, count: int) -> FloatArray:
        """``count`` points, uniform in the integral of the density (a sum of arctangents)."""
        x = np.empty(count)
        graded_points(self.terms, self.x_in, self.x_exit, x)
        return x


def _ladder(centre: float, widest: float, narrowest: float, amount: float) -> list[tuple[float, float, float]]:
    """Lorentzians of one centre with widths decreasing from widest to narrowest."""
    steps = max(0, math.ceil(math.log(widest / narrowest) / math.log(LADDER_RATIO)))
    if steps == 0:
        return [(centre, narrowest, amount)]
    return [(centre, widest * (narrowest / widest) ** (k / steps), amount) for k in range(steps + 1)]


def grade(features: Features) -> Grading:
    """Mesh grading for a contact with these features."""
    size = features.size
    x_in = -INLET_MARGIN * size
    terms = [(0.0, size, 1.0)]
    far = 4.0 * size
    while far < abs(x_in):
        terms.append((-size, far, 0.35))
        far *= 4.0
    widest = 0.5 * size
    terms += _ladder(features.inlet, widest, min(features.inlet_width, widest), 0.30)
    sweep = min(1.5 * features.flow ** (2.0 / 3.0), 0.4 * size)
    terms += _ladder(features.exit, widest, sweep, 0.2)
    terms += _ladder(features.spike, widest, min(features.spike_width, widest), 0.2)
    return Grading(x_in, features.exit, np.array(terms).T.copy(), features)


def features_of(x: FloatArray, pressure: FloatArray, flow: float) -> Features:
    """Features of a solution."""
    size = math.sqrt(1.0 + 2.0 * flow)
    end = float(x[-1])
    sweep = min(1.5 * flow ** (2.0 / 3.0), 0.5 * size)
    # curvature lengths of the pressure; the lower bound excludes the vanishing pressure at the ends
    (inlet, inlet_width), (spike, spike_width) = (
        found if (found := sharpest(x, pressure, 0.4, start, stop))[1] > 0.0 else (fallback, sweep)
        for start, stop, fallback in ((-4.0 * size, -0.2 * size, -1.0), (0.2, end - 1e-3 * size, 0.9 * end))
    )
    return Features(
        flow, end, inlet, min(max(inlet_width, 0.3 * sweep), sweep), spike, min(max(0.5 * spike_width, TIP), 0.4 * size)
    )
