"""Compliance of a round shaft on bearings at a point of its axis.

Exact beam elements with shear (Timoshenko) between bearings and point, springs at the bearings.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def shaft_compliance(
    at: float,
    bearings: list[tuple[float, float, float]],
    diameter: float,
    bore: float,
    youngs_modulus: float,
    poisson_ratio: float,
) -> FloatArray:
    """Displacement of a point of a shaft under unit forces and moments there, (6, 6) [m/N], [rad/N], [rad/(N m)].

    Rotation about the axis is held at the bearing farthest from the point.

    Parameters
    ----------
    at : float
        Place of the point along the axis z [m].
    bearings : list of tuple
        Place [m], radial and axial stiffness [N/m] of each: at least two places, and one with axial stiffness.
    diameter, bore : float
        Of the shaft [m].
    youngs_modulus, poisson_ratio : float
        Of the shaft [Pa], [-].
    """
    places = np.unique([at, *(place for place, _, _ in bearings)])
    area = math.pi / 4.0 * (diameter**2 - bore**2)
    inertia = math.pi / 64.0 * (diameter**4 - bore**4)
    shear = youngs_modulus / (2.0 * (1.0 + poisson_ratio))
    ratio = bore / diameter
    # shear coefficient of a hollow circle (Cowper 1966)
    square = (1.0 + ratio**2) ** 2
    cowper = (
        6.0
        * (1.0 + poisson_ratio)
        * square
        / ((7.0 + 6.0 * poisson_ratio) * square + (20.0 + 12.0 * poisson_ratio) * ratio**2)
    )
    bending, pull = np.zeros((2 * places.size, 2 * places.size)), np.zeros((places.size, places.size))
    for i, length in enumerate(np.diff(places)):
        phi = 12.0 * youngs_modulus * inertia / (cowper * shear * area * length**2)
        a, b, c = 6.0 * length, (4.0 + phi) * length**2, (2.0 - phi) * length**2
        beam = np.array([[12.0, a, -12.0, a], [a, b, -a, c], [-12.0, -a, 12.0, -a], [a, c, -a, b]])
        bending[2 * i : 2 * i + 4, 2 * i : 2 * i + 4] += youngs_modulus * inertia / (length**3 * (1.0 + phi)) * beam
        pull[i : i + 2, i : i + 2] += youngs_modulus * area / length * np.array([[1.0, -1.0], [-1.0, 1.0]])
    for place, radial, axial in bearings:
        node = int(np.searchsorted(places, place))
        bending[2 * node, 2 * node] += radial
        pull[node, node] += axial
    node = int(np.searchsorted(places, at))
    own = slice(2 * node, 2 * node + 2)
    # deflection and slope under force and moment, in the plane x-z; in y-z the rotation about x is minus the slope
    plane = np.linalg.solve(bending, np.eye(2 * places.size))[own, own]
    found = np.zeros((6, 6))
    found[np.ix_((0, 4), (0, 4))] = plane
    flip = np.array([1.0, -1.0])
    found[np.ix_((1, 3), (1, 3))] = plane * np.outer(flip, flip)
    found[2, 2] = np.linalg.solve(pull, np.eye(places.size))[node, node]
    found[5, 5] = max(abs(at - place) for place, _, _ in bearings) / (shear * 2.0 * inertia)
    return 0.5 * (found + found.T)
