"""Height at which the blade tips cut the root of a generated member.

At a station u along the face the root is the deepest point that the tip edge s = 0 reaches: h(th, phi) at fixed u(th,
phi) has its minimum there, so ``h_th u_phi - h_phi u_th = 0``. By the envelope theorem the height then changes with a
setting as it does at fixed (th, phi), minus the slope of the root times the change of u.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.blanks.cones import Blank
from efficiency.cutting.flank import CutFlank
from efficiency.cutting.newton import Array

FloatArray = NDArray[np.float64]

_DELTA = 1e-5


def _coordinates(flank: CutFlank, y: Array) -> Array:
    """Blank coordinates (u, h) of tip points at (th, phi)."""
    point = flank.sweep(np.stack([0.0 * y[0], y[0], y[1]]))[0]
    return np.stack(flank.blank.coordinates(np.sqrt(point[0] ** 2 + point[1] ** 2), point[2]))


def _linearised(flank: CutFlank, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Blank coordinates (2, k) of tip points and their derivatives by (th, phi), (2, 2, k)."""
    state, slope = flank.linearise(np.stack([np.zeros_like(y[0]), y[0], y[1]]))
    radius = np.hypot(state[0], state[1])
    by = np.moveaxis(slope[:, :3, 1:], 0, -1)
    outwards = (state[0] * by[0] + state[1] * by[1]) / radius
    c, s = np.cos(flank.blank.pitch_angle), np.sin(flank.blank.pitch_angle)
    value = np.stack(flank.blank.coordinates(radius, state[2]))
    return np.real(value), np.stack([outwards * s + by[2] * c, outwards * c - by[2] * s])


@dataclass(frozen=True)
class RootState:
    """Tip points on the root.

    Attributes
    ----------
    parameters : (2, k) array
        Cutter angle and cradle roll.
    error : (k,) array
        Height over the blank's root [m].
    slope : (k,) array
        dh/du along the cut root at the stations, per metre.
    blank : Blank
        Blank of the member.
    """

    parameters: FloatArray
    error: FloatArray
    slope: FloatArray
    blank: Blank

    def derivative(self, moved: CutFlank, step: float) -> FloatArray:
        """Change of `error` with a setting, from the flank with that setting moved by an imaginary step."""
        u, h = _coordinates(moved, self.parameters.astype(np.complex128)).imag / step
        return np.asarray(h - self.slope * u)


@dataclass(frozen=True)
class RootLine:
    """Where the root should be.

    Attributes
    ----------
    u : (k,) array
        Stations along the face [m].
    height : (k,) array
        Wanted height of the root [m].
    weight : float
        Residual per error of the root, [m/m].
    start : (2, k) array
        Cutter angle and cradle roll near the root points.
    """

    u: FloatArray
    height: FloatArray
    weight: float
    start: FloatArray

    def cut(self, flank: CutFlank, previous: RootState | None = None) -> RootState:
        """The root as the flank's blade cuts it."""
        x = np.array(self.start if previous is None else previous.parameters)
        size = flank.blank.mean_cone_distance

        def lagrange(y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
            value, slopes = _linearised(flank, y)
            (u_th, u_phi), (h_th, h_phi) = slopes
            return value, slopes, np.stack([value[0] - self.u, (h_th * u_phi - h_phi * u_th) / size])

        value, slopes, residual = lagrange(x)
        for _ in range(12):
            columns = []
            for k in range(2):
                shift = np.zeros((2, 1))
                shift[k] = _DELTA
                columns.append((lagrange(x + shift)[2] - lagrange(x - shift)[2]) / (2.0 * _DELTA))
            matrix = np.moveaxis(np.stack(columns, axis=-1), 0, 1)
            if not np.isfinite(matrix).all() or np.abs(np.linalg.det(matrix)).min() < 1e-30:
                return RootState(x, np.full(x.shape[1], np.nan), np.zeros(x.shape[1]), flank.blank)
            step = np.linalg.solve(matrix, residual.T[..., None])[..., 0].T
            step *= np.minimum(1.0, 0.1 / np.abs(step).max(axis=0).clip(1e-300))
            x = x - step
            value, slopes, residual = lagrange(x)
            if np.abs(step).max() < 1e-5:
                break
        (u_th, u_phi), (h_th, h_phi) = slopes
        slope = (h_th * u_th + h_phi * u_phi) / (u_th * u_th + u_phi * u_phi)
        return RootState(x, value[1] - self.height, slope, flank.blank)
