"""Numbers of one converged level: films, pressures, friction (dimensionless)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ehl.fluid.rheology import ShearLaw
from ehl.smooth.newton import Level

Array = NDArray[np.float64]

# The shear is integrated from this many lengths of the loaded zone upstream (mesh and open inlet together).
FRICTION_INLET = 100.0


@dataclass(frozen=True)
class FilmShear:
    """Film shear in units of p_h, from ln(eta/eta0), film H and pressure P.

    Parameters
    ----------
    law : ShearLaw
        Stress over rate [Pa].
    pressure_hertz : float
        [Pa].
    rate : float
        eta0 |v_s| R/(p_h b^2).
    """

    law: ShearLaw
    pressure_hertz: float
    rate: float

    @property
    def cut(self) -> bool:
        """Whether a limit cuts the stress off with a kink."""
        return self.law.limited and self.law.limit == "cut"

    def stress_at(self, log_eta: Array, film: Array, pressure: Array) -> Array:
        """Shear stress at the nodes."""
        return self._stress(self.law, log_eta, film, pressure)

    def _stress(self, law: ShearLaw, log_eta: Array, film: Array, pressure: Array) -> Array:
        if self.rate == 0.0:
            return np.zeros(film.size)
        log_viscous = math.log(self.rate * self.pressure_hertz) + log_eta - np.log(film)
        p = np.maximum(pressure, 0.0) * self.pressure_hertz
        stress = np.exp(law.log_stress(log_viscous, p)[0])
        return np.asarray(np.minimum(stress, law.limiting_stress(p)) / self.pressure_hertz)

    def friction(self, level: Level) -> float:
        """mu = (2/pi) integral of the shear stress from the friction inlet to the exit."""
        pressure, step = np.maximum(level.unknowns.pressure, 0.0), np.diff(level.x)
        law = replace(self.law, limit_slope=math.inf) if self.cut else self.law
        free = self._stress(law, level.log_eta, level.film, pressure)
        if not self.cut:
            total = float(step @ (free[1:] + free[:-1])) / 2.0
        else:
            # min of two piecewise linear functions, exactly: where they cross it exceeds the chord of its end values.
            # Never the difference of both integrals: a stiff oil's free stress is many orders above the limit.
            limit = self.law.limiting_stress(pressure * self.pressure_hertz) / self.pressure_hertz
            lower = np.minimum(free, limit)
            total = float(step @ (lower[1:] + lower[:-1])) / 2.0
            excess = free - limit
            left, right = np.abs(excess[:-1]), np.abs(excess[1:])
            crossing = (excess[:-1] > 0.0) != (excess[1:] > 0.0)
            chord = np.where(crossing, left * (right / np.where(crossing, left + right, 1.0)), 0.0)
            total += float(step @ chord) / 2.0
        # Shear is far below the stress scale in the open inlet: linear in the rate.
        total += self.rate * math.exp(level.log_eta[0]) * _open_inlet(level)[0]
        return 2.0 / math.pi * total


@dataclass(frozen=True)
class Numbers:
    """Outputs of one level, dimensionless; also the record of their errors."""

    film_central: float
    film_min: float
    friction: float
    pressure_max: float
    flow: float
    exit: float
    rolling: float

    def as_array(self) -> Array:
        """The same as an array."""
        values = (self.film_central, self.film_min, self.friction, self.pressure_max, self.flow, self.exit)
        return np.array([*values, self.rolling])


def numbers_of(level: Level, shear: FilmShear) -> Numbers:
    """Outputs of a level."""
    pressure = level.unknowns.pressure
    rolling = float((level.film[1:] + level.film[:-1]) @ np.diff(pressure)) / (2.0 * math.pi)
    rolling += level.scaled.lam * math.exp(level.log_eta[0]) * _open_inlet(level)[1] / math.pi
    return Numbers(
        _interpolate(level.x, level.film, 0.0),
        -_peak(-level.film),
        shear.friction(level),
        _peak(pressure),
        float(level.unknowns.flow),
        float(level.x[-1]),
        rolling,
    )


def friction_inlet(level: Level) -> float:
    """Where the integrals of the shear begin, in half-widths."""
    return -FRICTION_INLET * level.grid.grading.size


def _open_inlet(level: Level) -> tuple[float, float]:
    """Integrals of 1/H and of (1 - Q/H)/H from the friction inlet to the first node, H there a parabola.

    With v = 1/|x| both integrands are nearly constant, so Simpson's rule is exact to far below the grid error.
    """
    near, far = 1.0 / abs(level.x[0]), 1.0 / abs(friction_inlet(level))
    v = np.array([near, 0.5 * (near + far), far])
    film = level.film[0] + 0.5 * (1.0 / v**2 - level.x[0] ** 2)
    rule = np.array([1.0, 4.0, 1.0]) * (near - far) / 6.0
    first = rule / (v * v * film)
    return float(first.sum()), float(first @ (1.0 - level.unknowns.flow / film))


def _interpolate(x: Array, y: Array, at: float) -> float:
    """Six-point Lagrange value: between the nodes no lower order may show."""
    k = int(np.clip(np.searchsorted(x, at) - 3, 0, x.size - 6))
    nodes, values = x[k : k + 6], y[k : k + 6]
    total = 0.0
    for i in range(6):
        others = np.delete(nodes, i)
        total += values[i] * float(np.prod((at - others) / (nodes[i] - others)))
    return float(total)


def _peak(y: Array) -> float:
    """Maximum of the quartic through the five nodes around the largest value (mesh index as coordinate)."""
    k = int(np.argmax(y))
    if k < 2 or k > y.size - 3:
        return float(y[k])
    a, b, c, d, e = (float(v) for v in y[k - 2 : k + 3])
    first = (a - 8.0 * b + 8.0 * d - e) / 12.0
    second = (-a + 16.0 * b - 30.0 * c + 16.0 * d - e) / 24.0
    third = (-a + 2.0 * b - 2.0 * d + e) / 12.0
    fourth = (a - 4.0 * b + 6.0 * c - 4.0 * d + e) / 24.0
    t = 0.0
    for _ in range(8):
        slope = first + t * (2.0 * second + t * (3.0 * third + 4.0 * fourth * t))
        curvature = 2.0 * second + t * (6.0 * third + 12.0 * fourth * t)
        if curvature >= 0.0:
            break
        t = min(max(t - slope / curvature, -1.0), 1.0)
    return max(c + t * (first + t * (second + t * (third + fourth * t))), c)
