"""Rotation about the z axis and vector products of (3, n) arrays, real or complex."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from efficiency.cutting.newton import Array

AnyArray = TypeVar("AnyArray", NDArray[np.float64], Array)
"""Real or complex array."""


def turn(vector: AnyArray, angle: AnyArray | float) -> AnyArray:
    """Rotate vectors about z."""
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2] + 0.0 * c])


def spin(vector: AnyArray) -> AnyArray:
    """Velocity of points for a rotation about z at 1 rad/s."""
    return np.asarray([-vector[1], vector[0], 0.0 * vector[2]])


def dot(a: AnyArray, b: AnyArray) -> AnyArray:
    """Scalar product without complex conjugation (holomorphic)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def cross(a: AnyArray, b: AnyArray) -> AnyArray:
    """Vector product."""
    return np.asarray([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def unit(vector: AnyArray) -> AnyArray:
    """Vectors of length one."""
    return np.divide(vector, np.sqrt(dot(vector, vector)))
