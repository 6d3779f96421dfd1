"""Misalignment of two members whose axes have been displaced, by the common normal of the moved axis lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.assembly import Assembly

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class DisplacedAxes:
    """Where the axes of both members went.

    Attributes
    ----------
    E, P, G, shaft_angle_error : float
        Misalignments [m], shaft_angle_error [rad]; E positive along y of the mesh frame.
    frame : (3, 3) array
        Columns x, y, z of the displaced mesh frame in the frame of the assembly.
    origin : (3,) array
        Its origin there [m].
    """

    E: float
    P: float
    G: float
    shaft_angle_error: float
    frame: FloatArray
    origin: FloatArray

    def distance(self, other: DisplacedAxes) -> tuple[float, float]:
        """Largest change of E, P, G [m], and of shaft_angle_error [rad]."""
        lengths = max(abs(self.E - other.E), abs(self.P - other.P), abs(self.G - other.G))
        return lengths, abs(self.shaft_angle_error - other.shaft_angle_error)


@dataclass(frozen=True)
class RigidMove:
    """Small displacement of a member: of a reference point, and the rotation about it.

    Attributes
    ----------
    reference : (3,) array
        Point on the axis, mesh frame [m].
    shift : (3,) array
        [m].
    rotation : (3,) array
        Rotation vector [rad].
    """

    reference: FloatArray
    shift: FloatArray
    rotation: FloatArray

    def turned(self, vector: FloatArray) -> FloatArray:
        """A vector after the rotation (Rodrigues)."""
        angle = float(np.linalg.norm(self.rotation))
        if angle == 0.0:
            return vector
        axis = self.rotation / angle
        across = np.cross(axis, vector)
        found: FloatArray = vector + np.sin(angle) * across + (1.0 - np.cos(angle)) * np.cross(axis, across)
        return found

    def moved(self, point: FloatArray) -> FloatArray:
        """A point of the member after the displacement [m]."""
        return np.asarray(self.reference + self.shift + self.turned(point - self.reference))


def displaced_axes(placed: Assembly, pinion: RigidMove, gear: RigidMove) -> DisplacedAxes:
    """Misalignments of members that stood as placed and were moved; exact, whatever the size of the moves.

    Parameters
    ----------
    placed : Assembly
        Before, misalignments included; what comes out includes them too.
    pinion, gear : RigidMove
        In the mesh frame of `placed`.
    """
    apex_gear = gear.moved(np.array([0.0, 0.0, placed.G]))
    apex_pinion = pinion.moved(placed.pinion_origin[:, 0])
    axis_gear = gear.turned(np.array([0.0, 0.0, 1.0]))
    axis_pinion = pinion.turned(placed.pinion_axis[:, 0])
    normal = np.cross(axis_gear, axis_pinion)
    sine, cosine = float(np.linalg.norm(normal)), float(axis_gear @ axis_pinion)
    normal = normal / sine
    between = apex_pinion - apex_gear
    # distances of the apexes from the feet of the common normal, along each axis
    along_gear, along_pinion = float(between @ axis_gear), float(between @ axis_pinion)
    P = (along_pinion - cosine * along_gear) / sine**2
    G = -(along_gear - cosine * along_pinion) / sine**2
    return DisplacedAxes(
        E=float(between @ normal) - placed.offset,
        P=P,
        G=G,
        shaft_angle_error=float(np.arctan2(sine, cosine)) - placed.shaft_angle,
        frame=np.column_stack([np.cross(normal, axis_gear), normal, axis_gear]),
        origin=apex_gear - G * axis_gear,
    )
