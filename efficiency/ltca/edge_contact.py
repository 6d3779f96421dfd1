"""Line contact near a rounded tooth edge: pressure, half-width and approach.

Section in the plane of contact: the separation of the flanks is x^2/(2R). At the distance e from the closest approach
the edge begins, a rounding of radius r with the additional separation (x - e)^2/(2r). For e > 0 the closest approach
lies on the flank, for e < 0 beyond it, so that the edge is in contact. Both bodies are half-planes, the pressure
vanishes at both ends of the contact, and p(x) has a closed form (this work, by the finite Hilbert transform; Hertz
for e >= b, and for e <= -b sqrt(1 + R/r), with the reduced radius 1/(1/R + 1/r)).

In units of the half-width b and the Hertz pressure p_h for R at the same load, with k = R/r, the contact is
x = m + l cos(t), 0 < t < pi, and its part t < a lies on the rounding:

    l^2 (1 + (k/pi)(a - sin a cos a)) = 1,   m = -(k/pi) l (sin a - a cos a),   e = m + l cos a,
    p = l sin t + (k l/pi) (a sin t + (cos t - cos a) ln|sin((t + a)/2)/sin((t - a)/2)|).

The approach follows from the mean separation over the contact with the weight 1/sqrt(l^2 - (x - m)^2), and from the
logarithm of l; its derivative is that of a flat punch of the same half-width.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ehl.common.arrays import FloatArray

_ANGLES = 121
# tuned: distance from a side face, in depths over 6, within which a body is a corner: finite elements of the end of a
# strip; may be changed after repeating `tests/twins/free_edge.py`
_CORNER = 6.0
# last step of Newton's method on the angle a: the next one would be its square
_LAST_STEP = 1e-9
# keeps the starting value off the ends, where the derivative of a by e is singular
_MIN_SHARE = 1e-15


@dataclass(frozen=True)
class EdgeSection:
    """Contact of n sections with an edge, in units of the Hertz contact without it."""

    ratio: FloatArray  # (n,) k = R/r
    distance: FloatArray  # (n,) e/b
    angle: FloatArray  # (n,) a: 0 if the edge is outside the contact, pi if the contact lies on the rounding alone
    # (n,) l and m
    half_length: FloatArray
    middle: FloatArray

    @classmethod
    def of(cls, distance: ArrayLike, ratio: ArrayLike) -> EdgeSection:
        """Sections with an edge at distances e/b and k = R/r."""
        e, k = np.broadcast_arrays(np.asarray(distance, float), np.asarray(ratio, float))
        e, k = np.ascontiguousarray(e), np.ascontiguousarray(k)
        a = edge_angle(e, k)
        length = 1.0 / np.sqrt(1.0 + k / np.pi * (a - np.sin(a) * np.cos(a)))
        on_rounding = e <= -np.sqrt(1.0 + k)
        middle = np.where(on_rounding, e * k / (1.0 + k), -k / np.pi * length * (np.sin(a) - a * np.cos(a)))
        return cls(k, e, a, length, middle)

    @property
    def approach(self) -> FloatArray:
        """Approach in excess of Hertz at the same load, from first contact, in units of b^2/(2R)."""
        k, e, a, length, m = self.ratio, self.distance, self.angle, self.half_length, self.middle
        out = m - e
        on_rounding = out**2 * a + 2.0 * out * length * np.sin(a) + length**2 * (0.5 * a + 0.25 * np.sin(2.0 * a))
        mean = m**2 + 0.5 * length**2 + k / np.pi * on_rounding
        first_touch = np.minimum(e, 0.0) ** 2 * k / (1.0 + k)
        partly = mean - first_touch - 0.5 - np.log(length)
        return np.where(a < np.pi, partly, -np.log(length))

    @property
    def approach_rate(self) -> FloatArray:
        """Derivative of `approach` by the load per length, in units of 4/(pi E')."""
        return np.asarray(-np.log(self.half_length))

    def pressure(self, angle: FloatArray) -> FloatArray:
        """Pressure over p_h at angles t (q,) of each contact, (n, q)."""
        k, a, length = (column[:, None] for column in (self.ratio, self.angle, self.half_length))
        near = np.abs(angle - a)
        with np.errstate(divide="ignore", invalid="ignore"):
            logarithm = np.log(np.sin(0.5 * (angle + a)) / np.abs(np.sin(0.5 * (angle - a))))
        part = np.where(near > 1e-12, (np.cos(angle) - np.cos(a)) * np.where(near > 1e-12, logarithm, 0.0), 0.0)
        return np.asarray(length * (np.sin(angle) * (1.0 + k / np.pi * a) + k / np.pi * part))

    @property
    def pressure_max(self) -> FloatArray:
        """Maximum pressure over p_h."""
        angle = (np.arange(_ANGLES) + 0.5) * np.pi / _ANGLES
        p = self.pressure(angle)
        at = np.clip(np.argmax(p, axis=1), 1, _ANGLES - 2)
        each = np.arange(p.shape[0])
        before, top, after = (p[each, at + k] for k in (-1, 0, 1))
        bend = np.minimum(before - 2.0 * top + after, -1e-300)
        return np.asarray(np.maximum(p.max(axis=1), top - 0.125 * (after - before) ** 2 / bend))


def edge_angle(distance: FloatArray, ratio: FloatArray) -> FloatArray:
    """Angle a of `EdgeSection` for e/b and k (n,): Newton's method inside a bracket."""
    angle = np.where(distance < 1.0, np.pi, 0.0)
    at = np.flatnonzero((distance < 1.0) & (distance > -np.sqrt(1.0 + ratio)))
    e, k = distance[at], ratio[at] / np.pi
    # e decreases from 1 to -sqrt(1 + R/r), at both ends with the square of the angle
    share = (1.0 - e) / (1.0 + np.sqrt(1.0 + ratio[at]))
    a = np.arccos(1.0 - 2.0 * np.clip(share, _MIN_SHARE, 1.0 - _MIN_SHARE))
    low, high = np.zeros(at.size), np.full(at.size, np.pi)
    for _ in range(60):
        s, c = np.sin(a), np.cos(a)
        length = 1.0 / np.sqrt(1.0 + k * (a - s * c))
        place = length * (c - k * (s - a * c))
        beyond = place > e
        low, high = np.where(beyond, a, low), np.where(beyond, high, a)
        following = a + (place - e) / (length * s * (1.0 + k * (a + length * s * place)))
        following = np.where((following >= low) & (following <= high), following, 0.5 * (low + high))
        step = np.abs(following - a).max(initial=0.0)
        a = following
        if step < _LAST_STEP:
            break
    angle[at] = a
    return angle


def free_edge_compliance(
    distance: ArrayLike, depth: ArrayLike, youngs_modulus: float, poisson_ratio: float
) -> FloatArray:
    """Additional local compliance of a body due to a free side face, per load per length [m2/N].

    Close to the face the body is a quarter-plane loaded at its corner. The stress along its side face is
    pi/(pi^2/4 - 1) times load over distance (Michell's wedge), that on the axis of a half-plane 2/pi times. The
    difference is the rate by ln(h/c); its limit depends on the other boundaries (this work):

        (1 - nu^2)/(pi E) (pi^2 + 4)/(pi^2 - 4) ln(1 + (h/(6 c))^2).

    The factor 6 is from finite elements of the end of a strip of thickness 2h, a tooth end
    (`tests/twins/free_edge.py`). c is the distance of the load from the face, along the flank, and h the depth of the
    local approach [m]. For c/h from 0.03 to 2 and Poisson's ratios from 0.25 to 0.35 the result is within 3 % of the
    whole approach of the body to the depth h.
    """
    ratio = np.asarray(depth, float) / (_CORNER * np.asarray(distance, float))
    rate = (np.pi**2 + 4.0) / (np.pi**2 - 4.0)
    return np.asarray((1.0 - poisson_ratio**2) / (np.pi * youngs_modulus) * rate * np.log1p(ratio**2))
