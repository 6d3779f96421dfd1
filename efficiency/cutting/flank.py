"""Flanks: the interface all of them share, and the flank that a cutter leaves on a blank."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from efficiency.blank.cones import Blank
from efficiency.cutting import newton
from efficiency.cutting.cutter import Blade, FlankSide
from efficiency.cutting.machine import MachineSettings
from efficiency.cutting.newton import Array
from ehl.errors import ConvergenceError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class FlankPoints:
    """Points of a flank in the work frame of its member.

    Attributes
    ----------
    parameters : (3, n) array
        Edge length s [m], cutter angle th [rad], cradle roll phi [rad] of the cutting.
    position, normal : (3, n) arrays
        Point [m] and unit normal out of the tooth.
    """

    parameters: FloatArray
    position: FloatArray
    normal: FloatArray

    @property
    def azimuth(self) -> FloatArray:
        """Angle of the points about the axis of the member [rad]."""
        return np.asarray(np.arctan2(self.position[1], self.position[0]))

    def angles(self, pitch_angle: float) -> tuple[FloatArray, FloatArray]:
        """Spiral angle and normal pressure angle of the flank at its points [rad], both unsigned.

        The spiral angle lies in the cone through the point, parallel to the pitch cone, between the flank's trace and
        the generatrix; the normal pressure angle between the flank normal and the tangent plane of that cone.
        """
        c, s = np.cos(self.azimuth), np.sin(self.azimuth)
        radial, around = self.normal[0] * c + self.normal[1] * s, self.normal[1] * c - self.normal[0] * s
        sine, cosine = np.sin(pitch_angle), np.cos(pitch_angle)
        along, out = radial * sine + self.normal[2] * cosine, radial * cosine - self.normal[2] * sine
        return np.arctan2(np.abs(along), np.abs(around)), np.arcsin(np.abs(out))


class Flank(ABC):
    """One flank of one member in its work frame: a surface of three parameters bound by one condition.

    Attributes
    ----------
    side : str
        ``"concave"`` or ``"convex"``.
    blank : Blank
        Blank of the member.
    """

    side: FlankSide
    blank: Blank

    @abstractmethod
    def sweep(self, x: Array) -> tuple[Array, Array, Array]:
        """Point, unit normal out of the tooth, and the condition that vanishes on the flank.

        The arithmetic is holomorphic: complex parameters give exact derivatives by complex step.

        Parameters
        ----------
        x : (3, n) array
            Surface parameters, real or complex. A surface of two parameters keeps the third as its condition.

        Returns
        -------
        point, normal : (3, n) arrays
            In the work frame [m], [-].
        condition : (n,) array
            Equation of meshing of a generated flank, else the third parameter.
        """

    @abstractmethod
    def guess(self) -> FloatArray:
        """Parameters (3, 1) near the mean point."""

    def points(self, x: FloatArray) -> FlankPoints:
        """Flank points at solved cutting parameters."""
        position, normal, _ = self.sweep(x)
        return FlankPoints(x, np.real(position), np.real(normal))

    def solve(self, u: FloatArray, h: FloatArray) -> tuple[FlankPoints, NDArray[np.bool_]]:
        """Flank points at blank coordinates (u, h), and which of them exist.

        All points start from the mean point of the blank and are led to their places together.
        """
        start, found = self._to(np.zeros((1, 2)), self.guess())
        if not found.all():
            raise ConvergenceError(
                "flank", f"the {self.side} flank does not reach the mean point of its blank; check the settings"
            )
        x = np.repeat(start, u.size, axis=1)
        target = np.stack([u, h], axis=1)
        ok = np.ones(u.size, dtype=bool)
        for share in (0.5, 1.0):
            x, ok = self._to(share * target, x)
        return self.points(x), ok

    def refine(self, radius: FloatArray, z: FloatArray, x: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Cutting parameters of the points at given radius and axial position, from a start nearby."""

        def residual(y: Array) -> Array:
            point, _, meshing = self.sweep(y)
            return np.stack([np.sqrt(point[0] ** 2 + point[1] ** 2) - radius, point[2] - z, meshing])

        size = self.blank.mean_cone_distance
        limit = np.array([0.05 * size, 0.1, 0.1])
        return newton.solve(residual, x, limit, np.array([1e-10 * size, 1e-10, 1e-10]))

    def _to(self, target: FloatArray, x: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        radius, z = self.blank.axial(target[:, 0], target[:, 1])
        return self.refine(radius, z, x)


@dataclass(frozen=True)
class CutFlank(Flank):
    """Flank cut by one blade on one machine setting."""

    blade: Blade
    machine: MachineSettings
    blank: Blank
    side: FlankSide = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "side", self.blade.side)

    def sweep(self, x: Array) -> tuple[Array, Array, Array]:
        """Point, normal and equation of meshing at cutting parameters (s, th, phi)."""
        point, normal = self.blade.surface(x[0], x[1])
        return self.machine.carry(point, normal, x[2])

    def guess(self) -> FloatArray:
        """Cutting parameters near the mean point: the blank's mean point seen from the cutter, nothing turned."""
        m = self.machine
        radius, z = self.blank.axial(np.zeros(1), np.zeros(1))
        blank = np.array([radius[0], 0.0, z[0] + m.machine_centre_to_back])
        cradle = m.work_axes.T @ blank - np.array([0.0, m.blank_offset, -m.sliding_base])
        cutter = m.cutter_axes.T @ (cradle - m.cutter_centre)
        s = -cutter[2] / np.cos(self.blade.blade_angle)
        return np.array([[s], [np.arctan2(cutter[1], cutter[0])], [0.0]])
