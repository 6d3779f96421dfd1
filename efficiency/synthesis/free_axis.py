"""Machine with the direction of the cutter axis in place of tilt and swivel: regular at no tilt, where swivel is
not."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from efficiency.cutting.flank import CutFlank
from efficiency.cutting.machine import MachineSettings

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class FreeAxisMachine(MachineSettings):
    """Machine settings whose cutter axis is given by its components along x and y of the machine.

    The cutter is led there by the smallest rotation, ``Rz(j) Ry(i) Rz(-j)``; cutter angles therefore exceed those of
    tilt and swivel by the swivel angle. `tilt` and `swivel` are without effect.
    """

    axis_x: float = 0.0
    axis_y: float = 0.0

    @cached_property
    def cutter_axes(self) -> FloatArray:
        """Rotation from the cutter to the cradle frame."""
        x, y = self.axis_x, self.axis_y
        z = np.sqrt(1.0 - x * x - y * y)
        c = 1.0 / (1.0 + z)
        return np.array([[1.0 - c * x * x, -c * x * y, x], [-c * x * y, 1.0 - c * y * y, y], [-x, -y, z]])


def free_axis(flank: CutFlank, parameters: FloatArray) -> tuple[CutFlank, FloatArray]:
    """The same flank on a machine of free axis, and its cutting parameters (3, n) there."""
    old = flank.machine
    shared = {f.name: getattr(old, f.name) for f in fields(MachineSettings)}
    machine = FreeAxisMachine(
        **shared, axis_x=np.sin(old.tilt) * np.cos(old.swivel), axis_y=np.sin(old.tilt) * np.sin(old.swivel)
    )
    shift = np.array([[0.0], [old.swivel], [0.0]])
    return replace(flank, machine=machine, index_zero=flank.index_zero + old.swivel), parameters + shift


def tilt_and_swivel(flank: CutFlank) -> CutFlank:
    """The same flank by tilt and swivel."""
    old = flank.machine
    if not isinstance(old, FreeAxisMachine):
        return flank
    tilt = float(np.arcsin(np.hypot(old.axis_x, old.axis_y)))
    swivel = float(np.arctan2(old.axis_y, old.axis_x)) if tilt > 1e-12 else 0.0
    values = {f.name: getattr(old, f.name) for f in fields(MachineSettings)} | {"tilt": tilt, "swivel": swivel}
    return replace(flank, machine=MachineSettings(**values), index_zero=flank.index_zero - swivel)
