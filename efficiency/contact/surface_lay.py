"""Lay of the flanks: the angle between the marks of the cutter and the line of contact.

In the tangent plane of a flank the angle of a direction d counts from e1 = axis x n about the outward normal n,

    a(d) = atan2(d . (n x e1), d . e1),

which no rotation about the axis of the member changes: marks are known on the flank, lines in the mesh.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from efficiency.cutting.flank import Flank
from efficiency.cutting.rotation import cross, dot, unit

FloatArray = NDArray[np.float64]

_AXIS = np.array([[0.0], [0.0], [1.0]])  # of a member in its work frame


def tangent_angle(axis: FloatArray, normal: FloatArray, direction: FloatArray) -> FloatArray:
    """Angle of tangents (3, n) of a flank with outward normals (3, n) from axis (3, 1) x normal [rad]."""
    first = unit(cross(np.broadcast_to(axis, normal.shape), normal))
    return np.asarray(np.arctan2(dot(direction, cross(normal, first)), dot(direction, first)))


def undirected(angle: FloatArray) -> FloatArray:
    """An angle between lines, which have no sense, from -pi/2 to pi/2 [rad]."""
    return np.asarray((angle + 0.5 * np.pi) % np.pi - 0.5 * np.pi)


def mark_angles(flank: Flank, u: FloatArray, h: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Angle of the cutter's marks at blank coordinates [rad], and where the flank exists.

    Parameters
    ----------
    flank : Flank
    u, h : (n,) arrays
        Along the pitch cone from the mean point and over it [m].
    """
    points, found = flank.solve(u, h)
    angle = tangent_angle(_AXIS, points.normal, flank.marks(points))
    # lines have no sense: none may jump by pi against the first that exists
    first = angle[int(np.argmax(found))]
    return first + undirected(angle - first), found
