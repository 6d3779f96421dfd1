"""Numbers of one converged level: films, pressures, friction (dimensionless)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

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

    @cached_property
    def _free(self) -> ShearLaw:
        """The law without the limit that cuts it off."""
        return replace(self.law, limit_slope=math.inf) if self.cut else self.law

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
        if law.limited:
            stress = np.minimum(stress, law.limiting_stress(p))
        return np.asarray(stress / self.pressure_hertz)

    def friction(self, level: Level, open_inlet: float) -> float:
        """mu = (2/pi) integral of the shear stress from the friction inlet to the exit.

        `open_inlet` is the integral of 1/H over its part before the mesh.
        """
        pressure, step = np.maximum(level.unknowns.pressure, 0.0), np.diff(level.x)
        free = self._stress(self._free, level.log_eta, level.film, pressure)
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
        total += self.rate * math.exp(level.log_eta[0]) * open_inlet
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
    shear_length, flow_length = _open_inlet(level)
    rolling += level.scaled.lam * math.exp(level.log_eta[0]) * flow_length / math.pi
    return Numbers(
        _interpolate(level.x, level.film, 0.0),
        -_peak(-level.film),
        shear.friction(level, shear_length),
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
    start = float(level.x[0])
    near, far = 1.0 / abs(start), 1.0 / abs(friction_inlet(level))
    shear, flow = 0.0, 0.0
    for v, weight in ((near, 1.0), (0.5 * (near + far), 4.0), (far, 1.0)):
        film = float(level.film[0]) + 0.5 * (1.0 / v**2 - start**2)
        part = weight * (near - far) / 6.0 / (v * v * film)
        shear += part
        flow += part * (1.0 - level.unknowns.flow / film)
    return shear, flow


def _interpolate(x: Array, y: Array, at: float) -> float:
    """Six-point Lagrange value: between the nodes no lower order may show."""
    k = int(np.clip(np.searchsorted(x, at) - 3, 0, x.size - 6))
    nodes, values = x[k : k + 6].tolist(), y[k : k + 6].tolist()
    for order in range(1, 6):  # Neville's scheme
        for i in range(6 - order):
            far, near = nodes[i + order], nodes[i]
            values[i] = ((at - far) * values[i] + (near - at) * values[i + 1]) / (near - far)
    return float(values[0])


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
