"""Graded mesh of the smooth contact: node density as a sum of Lorentzians."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ehl.common.arrays import FloatArray

TIP = 1e-3  # smallest resolved spike length, in half-widths
LADDER_RATIO = 2.5  # widths of neighbouring rungs
_TABLE = np.tan(np.linspace(-1.55, 1.55, 21))  # points about each centre, in widths
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

    @property
    def size(self) -> float:
        """Length of the loaded zone of the graded features."""
        return self.features.size

    def points(self, count: int) -> FloatArray:
        """``count`` points, uniform in the integral of the density (a sum of arctangents)."""
        table_x = self._table()
        table, density = self._integral(table_x)
        goal = table[0] + (table[-1] - table[0]) / (count - 1) * np.arange(count)
        # inverse cubic between the points of the table
        k = np.minimum(np.maximum(np.searchsorted(table, goal) - 1, 0), table.size - 2)
        steps, slope = np.diff(table), 1.0 / density
        step, rise = steps[k], np.diff(table_x)[k]
        low, high, t = step * slope[k], step * slope[1:][k], (goal - table[k]) / step
        x = table_x[k] + t * (low + t * (3.0 * rise - 2.0 * low - high + t * (low + high - 2.0 * rise)))
        for _ in range(6):
            integral, density = self._integral(x)
            miss = integral - goal
            x = np.minimum(np.maximum(x - miss / density, self.x_in), self.x_exit)
            if np.abs(miss).max() < 1e-4:  # quadratic convergence
                break
        x[0], x[-1] = self.x_in, self.x_exit
        return np.asarray(x)

    def _integral(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Integral of the density, and the density."""
        centre, width, amount = self.terms
        place = (x - centre[:, None]) * (1.0 / width)[:, None]
        integral = amount @ np.arctan(place)
        np.multiply(place, place, out=place)
        place += 1.0
        return integral, (amount / width) @ np.reciprocal(place, out=place)

    def _table(self) -> FloatArray:
        """Points dense enough for the start of Newton's method in the inversion."""
        parts = self.terms[0][:, None] + self.terms[1][:, None] * _TABLE
        x = np.sort(parts, axis=None)
        x = x[np.searchsorted(x, self.x_in, "right") : np.searchsorted(x, self.x_exit)]
        return np.concatenate([[self.x_in], x[:-1][x[1:] > x[:-1]], x[-1:], [self.x_exit]])


def _ladder(centre: float, widest: float, narrowest: float, amount: float) -> list[tuple[float, float, float]]:
    """Lorentzians of one centre with widths decreasing from widest to narrowest."""
    steps = max(0, int(np.ceil(np.log(widest / narrowest) / np.log(LADDER_RATIO))))
    if steps == 0:
        return [(centre, narrowest, amount)]
    widths = widest * (narrowest / widest) ** (np.arange(steps + 1) / steps)
    return [(centre, float(w), amount) for w in widths]


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
    step = x[1:] - x[:-1]
    slope = (pressure[1:] - pressure[:-1]) / step
    bend = np.abs(slope[1:] - slope[:-1]) / (0.5 * (step[1:] + step[:-1]))
    # curvature lengths of the pressure; the lower bound excludes the vanishing pressure at the ends
    length = np.sqrt(np.maximum(pressure[1:-1], 0.4) / np.maximum(bend, 1e-12))
    inner, end = x[1:-1], float(x[-1])
    sweep = min(1.5 * flow ** (2.0 / 3.0), 0.5 * size)

    def sharpest(start: float, stop: float, fallback: float) -> tuple[float, float]:
        first, last = np.searchsorted(inner, start, "right"), np.searchsorted(inner, stop)
        if not first < last:
            return fallback, sweep
        k = first + int(np.argmin(length[first:last]))
        return float(inner[k]), float(length[k])

    inlet, inlet_width = sharpest(-4.0 * size, -0.2 * size, -1.0)
    spike, spike_width = sharpest(0.2, end - 1e-3 * size, 0.9 * end)
    return Features(
        flow, end, inlet, min(max(inlet_width, 0.3 * sweep), sweep), spike, min(max(0.5 * spike_width, TIP), 0.4 * size)
    )
