"""Generated flank: the envelope of the cutter surface, found point by point from the equation of meshing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.blank.cones import Blank
from efficiency.cutting import newton
from efficiency.cutting.cutter import Blade
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


@dataclass(frozen=True)
class Flank:
    """One generated flank of one member: blade, machine settings, blank."""

    blade: Blade
    machine: MachineSettings
    blank: Blank

    def sweep(self, x: Array) -> tuple[Array, Array, Array]:
        """Point, normal and equation of meshing at cutting parameters (s, th, phi), each (3, n), (3, n), (n,)."""
        point, normal = self.blade.surface(x[0], x[1])
        return self.machine.carry(point, normal, x[2])

    def points(self, x: FloatArray) -> FlankPoints:
        """Flank points at solved cutting parameters."""
        position, normal, _ = self.sweep(x)
        return FlankPoints(x, np.real(position), np.real(normal))

    def solve(self, u: FloatArray, h: FloatArray) -> tuple[FlankPoints, NDArray[np.bool_]]:
        """Flank points at blank coordinates (u, h), and which of them exist.

        All points start from the mean point of the blank and are led to their places together.
        """
        start, found = self._to(np.zeros((1, 2)), self._guess())
        if not found.all():
            raise ConvergenceError(
                "flank", f"the {self.blade.side} flank does not reach the mean point of its blank; check the settings"
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

    def _guess(self) -> FloatArray:
        """Cutting parameters near the mean point: the blank's mean point seen from the cutter, nothing turned."""
        m = self.machine
        radius, z = self.blank.axial(np.zeros(1), np.zeros(1))
        blank = np.array([radius[0], 0.0, z[0] + m.machine_centre_to_back])
        cradle = m.work_axes.T @ blank - np.array([0.0, m.blank_offset, -m.sliding_base])
        cutter = m.cutter_axes.T @ (cradle - m.cutter_centre)
        s = -cutter[2] / np.cos(self.blade.blade_angle)
        return np.array([[s], [np.arctan2(cutter[1], cutter[0])], [0.0]])
