"""Curvature of generated flanks, exact to round-off, and the relative curvature of two flanks in contact.

A flank is given by three cutting parameters bound by the equation of meshing. Its tangents and the change of its normal
along them follow from the derivatives by all three and the tangent plane of that equation; no surface is differentiated
numerically. Curvature is positive where the flank is hollow seen from outside the tooth, negative where it bulges.
"""

from dataclasses import dataclass

import numpy as np

from efficiency.cutting.flank import Flank
from efficiency.cutting.machine import cross, dot
from ehl.common.arrays import FloatArray


@dataclass(frozen=True)
class ShapeOperator:
    """Symmetric curvature matrix [1/m], (n, 2, 2), in orthonormal tangents in the frame of the member, (3, n)."""

    tangent_1: FloatArray
    tangent_2: FloatArray
    matrix: FloatArray

    @property
    def principal(self) -> FloatArray:
        """Principal curvatures, ascending, (2, n) [1/m]."""
        return np.asarray(np.linalg.eigvalsh(self.matrix).T)

    @property
    def directions(self) -> tuple[FloatArray, FloatArray]:
        """Unit vectors along the principal directions, in the order of `principal`, (3, n) each."""
        vectors = np.linalg.eigh(self.matrix)[1]
        first, second = (self.tangent_1 * vectors[:, 0, k] + self.tangent_2 * vectors[:, 1, k] for k in (0, 1))
        return first, second

    def along(self, tangent_1: FloatArray, tangent_2: FloatArray) -> FloatArray:
        """The matrix in other orthonormal tangents of the same planes, (n, 2, 2) [1/m]."""
        turn = np.array([[dot(new, old) for old in (self.tangent_1, self.tangent_2)] for new in (tangent_1, tangent_2)])
        turn = np.moveaxis(turn, -1, 0)
        return np.asarray(turn @ self.matrix @ np.swapaxes(turn, 1, 2))


def flank_curvature(flank: Flank, parameters: FloatArray) -> ShapeOperator:
    """Curvature of a flank at points given by their cutting parameters, (3, n)."""
    value, jacobian = flank.linearise(parameters)
    normal = value[3:6]
    # directions in the space of cutting parameters that stay on the flank; lengths are scaled to angles
    scale = np.array([flank.blank.mean_cone_distance, 1.0, 1.0])
    gradient = jacobian[:, 6, :] * scale
    start = np.eye(3)[np.argmin(np.abs(gradient), axis=1)]
    first = np.cross(gradient, start)
    second = np.cross(gradient, first)
    moves = np.stack([first / np.linalg.norm(first, axis=1)[:, None], second / np.linalg.norm(second, axis=1)[:, None]])
    steps = np.einsum("nij,knj->kin", jacobian[:, :6, :] * scale, moves)
    r1, r2, n1, n2 = steps[0, :3], steps[1, :3], steps[0, 3:], steps[1, 3:]

    t1 = r1 / np.sqrt(dot(r1, r1))
    t2 = cross(normal, t1)
    # columns of the map from the two moves to the tangents, and of the change of the normal
    to_tangent = np.array([[dot(r1, t1), dot(r2, t1)], [dot(r1, t2), dot(r2, t2)]])
    change = np.array([[dot(n1, t1), dot(n2, t1)], [dot(n1, t2), dot(n2, t2)]])
    to_tangent, change = np.moveaxis(to_tangent, -1, 0), np.moveaxis(change, -1, 0)
    matrix = -change @ np.linalg.inv(to_tangent)
    return ShapeOperator(t1, t2, 0.5 * (matrix + np.swapaxes(matrix, 1, 2)))
