"""Relative position of the members: shaft angle, offset, misalignments, and the roll angle of a gear point.

Mesh frame: z along the gear axis, the pinion axis (sin S, 0, cos S) through the foot of the common normal. The gear is
rotated by f2 about z, the pinion by f1 about its axis, f2 = -(N1/N2) f1. Misalignments: E along the offset, P along the
pinion axis, G along the gear axis, shaft_angle_error added to the shaft angle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from efficiency.cutting.machine import cross, dot, spin, turn
from efficiency.cutting.newton import AnyArray
from ehl.common.arrays import FloatArray


@dataclass(frozen=True)
class Assembly:
    """Position of the members in the mesh frame with their misalignments."""

    # numbers of teeth
    teeth_pinion: int
    teeth_gear: int
    shaft_angle: float  # nominal shaft angle [rad]
    # y coordinate of the pinion axis [m]; positive is below centre for a left-hand pinion and a right-hand gear
    offset: float = 0.0
    # misalignments [m], [rad]
    E: float = 0.0
    P: float = 0.0
    G: float = 0.0
    shaft_angle_error: float = 0.0

    @property
    def aligned(self) -> Assembly:
        """The members without misalignment."""
        return replace(self, E=0.0, P=0.0, G=0.0, shaft_angle_error=0.0)

    @property
    def ratio(self) -> float:
        """Gear rotation over pinion rotation about the axes of the mesh frame, negative."""
        return -self.teeth_pinion / self.teeth_gear

    @property
    def pinion_axis(self) -> FloatArray:
        """Unit vector (3, 1) of the pinion axis, from apex to heel."""
        angle = self.shaft_angle + self.shaft_angle_error
        return np.array([[np.sin(angle)], [0.0], [np.cos(angle)]])

    @property
    def pinion_origin(self) -> FloatArray:
        """Origin (3, 1) of the work frame of the pinion [m]."""
        return np.asarray(np.array([[0.0], [self.offset + self.E], [0.0]]) + self.P * self.pinion_axis)

    @property
    def axes(self) -> tuple[Axis, Axis]:
        """Axes of pinion and gear."""
        gear = Axis(np.array([0.0, 0.0, 1.0]), np.zeros(3))
        return Axis(self.pinion_axis[:, 0], self.pinion_origin[:, 0]), gear

    @property
    def pinion_frame(self) -> FloatArray:
        """Rotation from the frame of the pinion to the mesh frame."""
        axis = self.pinion_axis[:, 0]
        frame: FloatArray = np.array([[axis[2], 0.0, axis[0]], [0.0, 1.0, 0.0], [-axis[0], 0.0, axis[2]]])
        return frame

    def gear_in_mesh(self, point: AnyArray, f2: AnyArray) -> AnyArray:
        """Gear points (3, n) at gear rotation f2 in the mesh frame [m]."""
        return np.asarray(turn(point, f2) + np.array([[0.0], [0.0], [self.G]]))

    def to_pinion(self, point: AnyArray, normal: AnyArray, f1: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Mesh-frame points and vectors in the frame of the pinion rotated by f1."""
        frame = self.pinion_frame.T
        back = -(np.pi + f1)
        return turn(frame @ (point - self.pinion_origin), back), turn(frame @ normal, back)

    def pinion_in_mesh(self, point: FloatArray, f1: FloatArray) -> FloatArray:
        """Pinion points (3, n) at pinion rotation f1 in the mesh frame [m]."""
        return np.asarray(self.pinion_frame @ turn(point, np.pi + f1) + self.pinion_origin)

    def levers(self, point: FloatArray, normal: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lever arms of a unit force along the normal about the pinion and the gear axis [m], mesh frame."""
        pinion = dot(self.pinion_axis, cross(point - self.pinion_origin, normal))
        return pinion, point[0] * normal[1] - point[1] * normal[0]

    def sliding(self, point: AnyArray) -> AnyArray:
        """Velocity of the pinion minus that of the gear at mesh points, pinion at +1 rad/s about its axis [m/s]."""
        return self.about_pinion(point - self.pinion_origin) - self.ratio * spin(point)

    def about_pinion(self, vector: AnyArray) -> AnyArray:
        """Vector product of the pinion axis with (3, n) vectors."""
        return cross(self.pinion_axis, vector)

    def slid(self, move: AnyArray) -> AnyArray:
        """Change of `sliding` with the displacement of the mesh point."""
        return self.about_pinion(move) - self.ratio * spin(move)

    def roll(self, point: FloatArray, normal: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gear rotation f2 [rad] at which gear points contact the conjugate pinion (nan without contact), and its rate.

        The equation of meshing ``n . (v1 - v2) = 0`` is ``a cos f2 + b sin f2 + c = 0`` with constants of the point,
        solved in closed form. Of its two roots the one with positive rate is used: the gear point then separates from
        the pinion before and after contact; at the other root it would penetrate it. All points of a flank are
        therefore on one branch.

        Points and normals (3, n) in the gear frame; the rate is the derivative of ``n . (v1 - v2)`` by the pinion
        rotation, pinion at 1 rad/s [m/s/rad].
        """
        axis, origin = self.pinion_axis[:, 0], self.pinion_origin[:, 0]
        # moment of the normal about the mesh origin, rotated with the gear, plus the displacement of the gear along z
        moment = cross(point, normal)
        shifted = np.cross(axis, np.array([0.0, 0.0, self.G]) - origin)
        a = axis[0] * moment[0] + axis[1] * moment[1] + shifted[0] * normal[0] + shifted[1] * normal[1]
        b = axis[1] * moment[0] - axis[0] * moment[1] + shifted[1] * normal[0] - shifted[0] * normal[1]
        c = axis[2] * moment[2] + shifted[2] * normal[2] - self.ratio * moment[2]
        size = np.hypot(a, b)
        with np.errstate(invalid="ignore"):
            half = np.arccos(-c / size)
        azimuth = np.arctan2(point[1], point[0])
        # the rate is -ratio size sin(half), and the ratio is negative
        f2 = np.arctan2(b, a) + half
        f2 = np.angle(np.exp(1j * (f2 + azimuth))) - azimuth
        return f2, self.ratio * (b * np.cos(f2) - a * np.sin(f2))


@dataclass(frozen=True)
class Axis:
    """Axis of one member in the mesh frame: unit direction (3,) and a point on it (3,) [m]."""

    direction: NDArray[np.float64]
    origin: NDArray[np.float64]


@dataclass(frozen=True)
class DisplacedAxes:
    """Displaced axes of both members."""

    # misalignments [m], [rad]; E positive along y of the mesh frame
    E: float
    P: float
    G: float
    shaft_angle_error: float
    frame: FloatArray  # (3, 3) columns x, y, z of the displaced mesh frame in the frame of the assembly
    origin: FloatArray  # (3,) its origin in that frame [m]

    def distance(self, other: DisplacedAxes) -> tuple[float, float]:
        """Largest change of E, P, G [m], and of shaft_angle_error [rad]."""
        lengths = max(abs(self.E - other.E), abs(self.P - other.P), abs(self.G - other.G))
        return lengths, abs(self.shaft_angle_error - other.shaft_angle_error)


@dataclass(frozen=True)
class RigidMove:
    """Small displacement of a member: displacement of a reference point, and rotation about it."""

    reference: FloatArray  # (3,) point on the axis, mesh frame [m]
    shift: FloatArray  # (3,) [m]
    rotation: FloatArray  # (3,) rotation vector [rad]

    def turned(self, vector: FloatArray) -> FloatArray:
        """A vector after the rotation."""
        return np.asarray(scipy.spatial.transform.Rotation.from_rotvec(self.rotation).apply(vector))

    def moved(self, point: FloatArray) -> FloatArray:
        """A point of the member after the displacement [m]."""
        return np.asarray(self.reference + self.shift + self.turned(point - self.reference))


def displaced_axes(placed: Assembly, pinion: RigidMove, gear: RigidMove) -> DisplacedAxes:
    """Misalignments of displaced members; exact for displacements of any size.

    The result includes the misalignments of `placed`. The displacements are in the mesh frame of `placed`.
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
    E, turned = float(between @ normal) - placed.offset, float(np.arctan2(sine, cosine)) - placed.shaft_angle
    frame = np.column_stack([np.cross(normal, axis_gear), normal, axis_gear])
    return DisplacedAxes(E, P, G, turned, frame, origin=apex_gear - G * axis_gear)
