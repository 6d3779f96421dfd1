"""Rotation about the z axis and vector products of (3, n) arrays, real or complex."""

from __future__ import annotations

import numpy as np

from efficiency.cutting.newton import Array


def turn(vector: Array, angle: Array | float) -> Array:
    """Rotate vectors about z."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2] + 0.0 * c])


def spin(vector: Array) -> Array:
    """Velocity of points that turn about z at 1 rad/s."""
    return np.array([-vector[1], vector[0], 0.0 * vector[2]])


def dot(a: Array, b: Array) -> Array:
    """Scalar product; holomorphic, nothing is conjugated."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def cross(a: Array, b: Array) -> Array:
    """Vector product."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def unit(vector: Array) -> Array:
    """Vectors of length one."""
    return np.divide(vector, np.sqrt(dot(vector, vector)))
