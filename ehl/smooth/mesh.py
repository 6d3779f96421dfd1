"""Graded mesh of the smooth contact: node density as a sum of Lorentzians."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TIP = 1e-3  # least spike length resolved, in half-widths
LADDER_RATIO = 2.5  # widths of neighbouring rungs
INLET_MARGIN = 40.0  # inlet length over the length of the loaded zone; beyond it an open parabola


@dataclass(frozen=True)
class Features:
    """What the mesh must resolve, in half-widths; taken from a (nearby) solution.

    Place and length of the sharpest bend of the pressure in the inlet and at the outlet (the spike, where there is
    one), the exit, and the flow Q = rho H where the pressure gradient vanishes.
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
        return float(np.sqrt(1.0 + 2.0 * self.flow))

    def close_to(self, other: Features) -> bool:
        """Whether a mesh graded for ``other`` still serves."""
        ratios = (
            self.flow / other.flow,
            self.inlet_width / other.inlet_width,
            self.spike_width / other.spike_width,
        )
        widths = all(0.65 < r < 1.5 for r in ratios)
        spike = abs(self.spike - other.spike) < 0.7 * other.spike_width
        inlet = abs(self.inlet - other.inlet) < 0.7 * other.inlet_width
        return widths and spike and inlet


@dataclass(frozen=True)
class Grading:
    """Node density sum_k A_k w_k/(w_k^2 + (x - c_k)^2) on [x_in, x_exit]; frozen while the mesh is refined."""

    x_in: float
    x_exit: float
    terms: Array  # shape (3, K): centres, widths, amounts
    features: Features

    @property
    def size(self) -> float:
        """Length of the loaded zone the mesh was laid for."""
        return self.features.size

    def points(self, count: int) -> Array:
        """``count`` points, uniform in the integral of the density (a sum of arctangents)."""
        start, end = self._primitive(np.array([self.x_in, self.x_exit]))
        table_x = self._table()
        table = self._primitive(table_x)
        goal = np.linspace(start, end, count)
        # inverse cubic between the points of the table
        k = np.clip(np.searchsorted(table, goal) - 1, 0, table.size - 2)
        width = np.diff(table)
        step, rise = width[k], np.diff(table_x)[k]
        slope = 1.0 / self._density(table_x)
        low, high, t = step * slope[k], step * slope[k + 1], (goal - table[k]) / step
        x = table_x[k] + t * (low + t * (3.0 * rise - 2.0 * low - high + t * (low + high - 2.0 * rise)))
        for _ in range(6):
            step = (self._primitive(x) - goal) / self._density(x)
            x = np.clip(x - step, self.x_in, self.x_exit)
            if np.max(np.abs(step)) < 1e-7:  # the next one is its square
                break
        x[0], x[-1] = self.x_in, self.x_exit
        return x

    def _density(self, x: Array) -> Array:
        centre, width, amount = self.terms[:, :, None]
        return np.asarray((amount * width / (width * width + (x - centre) ** 2)).sum(axis=0))

    def _primitive(self, x: Array) -> Array:
        centre, width, amount = self.terms[:, :, None]
        return np.asarray((amount * np.arctan((x - centre) / width)).sum(axis=0))

    def _table(self) -> Array:
        """Points dense enough to start the inversion within Newton's reach."""
        base = np.tan(np.linspace(-1.55, 1.55, 31))
        parts = self.terms[0][:, None] + self.terms[1][:, None] * base
        x = np.unique(np.concatenate([parts.ravel(), [self.x_in, self.x_exit]]))
        return x[(x >= self.x_in) & (x <= self.x_exit)]


def _ladder(centre: float, widest: float, narrowest: float, amount: float) -> list[tuple[float, float, float]]:
    """Lorentzians of one centre with widths falling from widest to narrowest."""
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


def features_of(x: Array, pressure: Array, flow: float) -> Features:
    """Features of a solution."""
    size = float(np.sqrt(1.0 + 2.0 * flow))
    step = np.diff(x)
    slope = np.diff(pressure) / step
    bend = np.abs(np.diff(slope)) / (0.5 * (step[1:] + step[:-1]))
    # Lengths over which the pressure bends; the floor keeps the vanishing pressure of the ends out.
    length = np.sqrt(np.maximum(pressure[1:-1], 0.4) / np.maximum(bend, 1e-12))
    inner = x[1:-1]
    sweep = min(1.5 * flow ** (2.0 / 3.0), 0.5 * size)

    def sharpest(mask: NDArray[np.bool_], fallback: float) -> tuple[float, float]:
        if not mask.any():
            return fallback, sweep
        k = int(np.argmin(np.where(mask, length, np.inf)))
        return float(inner[k]), float(length[k])

    inlet, inlet_width = sharpest((inner < -0.2 * size) & (inner > -4.0 * size), -1.0)
    spike, spike_width = sharpest((inner > 0.2) & (inner < x[-1] - 1e-3 * size), 0.9 * float(x[-1]))
    return Features(
        flow,
        float(x[-1]),
        inlet,
        float(np.clip(inlet_width, 0.3 * sweep, sweep)),
        spike,
        float(np.clip(0.5 * spike_width, TIP, 0.4 * size)),
    )
