"""Hypoid generator: carries a cutter point to the work piece while cradle and work turn together.

Frames and signs: machine frame with its origin at the machine centre, x along the root line from toe to heel, z along
the cradle axis, teeth at z < 0; work frame with z along its axis from apex to heel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.cutting.newton import Array

FloatArray = NDArray[np.float64]


def _turn(vector: Array, angle: Array | float) -> Array:
    """Rotate (3, n) vectors about z."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2] + 0.0 * c])


def _spin(vector: Array) -> Array:
    """Velocity of (3, n) points turning about z at 1 rad/s."""
    return np.stack([-vector[1], vector[0], 0.0 * vector[2]])


@dataclass(frozen=True)
class MachineSettings:
    """Settings of one flank by their trade names, SI units and rad.

    The work turns by ``Ra (phi - C phi^2 - D phi^3)`` while the cradle turns by phi, with ``C = 2C/2``, ``D = 6D/6``.
    A positive cradle angle cuts a right-hand member, a negative one a left-hand member.
    """

    radial_setting: float
    cradle_angle: float
    machine_root_angle: float
    roll_ratio: float
    tilt: float = 0.0
    swivel: float = 0.0
    blank_offset: float = 0.0
    sliding_base: float = 0.0
    machine_centre_to_back: float = 0.0
    modified_roll_2c: float = 0.0
    modified_roll_6d: float = 0.0
    helical_motion_1: float = 0.0
    helical_motion_2: float = 0.0
    vertical_motion_1: float = 0.0
    vertical_motion_2: float = 0.0

    @property
    def cutter_centre(self) -> FloatArray:
        """Tip-plane centre of the cutter in the cradle frame [m]."""
        direction = [np.cos(self.cradle_angle), np.sin(self.cradle_angle), 0.0]
        return np.array(direction) * self.radial_setting

    @property
    def cutter_axes(self) -> FloatArray:
        """Rotation from the cutter to the cradle frame: swivel after tilt."""
        ci, si = np.cos(self.tilt), np.sin(self.tilt)
        cj, sj = np.cos(self.swivel), np.sin(self.swivel)
        tilt = np.array([[ci, 0.0, si], [0.0, 1.0, 0.0], [-si, 0.0, ci]])
        swivel = np.array([[cj, -sj, 0.0], [sj, cj, 0.0], [0.0, 0.0, 1.0]])
        return np.asarray(swivel @ tilt)

    @property
    def work_axes(self) -> FloatArray:
        """Rotation from the machine to the (not yet turned) work frame."""
        c, s = np.cos(self.machine_root_angle), np.sin(self.machine_root_angle)
        return np.array([[s, 0.0, -c], [0.0, 1.0, 0.0], [c, 0.0, s]])

    def carry(self, point: Array, normal: Array, phi: Array) -> tuple[Array, Array, Array]:
        """Cutter surface in the work frame at cradle roll phi.

        Parameters
        ----------
        point, normal : (3, n) arrays
            In the cutter frame, real or complex.
        phi : (n,) array
            Cradle roll from the design point [rad], real or complex.

        Returns
        -------
        point, normal : (3, n) arrays
            In the work frame.
        meshing : (n,) array
            ``normal . d point / d phi`` [m], zero on the generated flank.
        """
        zero = 0.0 * phi
        cradle = _turn(self.cutter_axes @ point + self.cutter_centre[:, None], phi)
        speed = _spin(cradle) + np.stack(
            [
                zero,
                self.vertical_motion_1 + self.vertical_motion_2 * phi,
                -self.helical_motion_1 - self.helical_motion_2 * phi,
            ]
        )
        shift = np.stack(
            [
                zero,
                self.blank_offset + (self.vertical_motion_1 + 0.5 * self.vertical_motion_2 * phi) * phi,
                -self.sliding_base - (self.helical_motion_1 + 0.5 * self.helical_motion_2 * phi) * phi,
            ]
        )
        back = np.stack([zero, zero, zero - self.machine_centre_to_back])
        blank = self.work_axes @ (cradle + shift) + back
        facing = self.work_axes @ _turn(self.cutter_axes @ normal, phi)
        c, d = 0.5 * self.modified_roll_2c, self.modified_roll_6d / 6.0
        work_turn = self.roll_ratio * phi * (1.0 - phi * (c + d * phi))
        work_speed = self.roll_ratio * (1.0 - phi * (2.0 * c + 3.0 * d * phi))
        meshing = np.sum(facing * (self.work_axes @ speed - work_speed * _spin(blank)), axis=0)
        return _turn(blank, -work_turn), _turn(facing, -work_turn), meshing
