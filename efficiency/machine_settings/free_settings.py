"""Settings a fit may change, and a machine that gives the direction of the cutter axis in place of tilt and swivel.

Direction components stay regular where there is no tilt; swivel does not.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from efficiency.cutting.flank import CutFlank
from efficiency.cutting.machine import MachineSettings
from efficiency.machine_settings.fit import Parameter
from efficiency.machine_settings.inputs import SettingsInput


@dataclass(frozen=True)
class FreeSettings:
    """Settings shared by both flanks and settings of each flank."""

    common: tuple[Parameter, ...]
    own: tuple[Parameter, ...]


AXIS = (Parameter("machine", "axis_x", 0.01), Parameter("machine", "axis_y", 0.01))
RADIAL = Parameter("machine", "radial_setting", 1e-3)
PLACES = (
    Parameter("machine", "blank_offset", 1e-3),
    Parameter("machine", "sliding_base", 1e-3),
    Parameter("machine", "machine_centre_to_back", 1e-3),
)
ROLL = Parameter("machine", "roll_ratio", 0.02)
MODIFIED = (Parameter("machine", "modified_roll_2c", 0.01), Parameter("machine", "modified_roll_6d", 0.02))
HELICAL = Parameter("machine", "helical_motion_1", 1e-3)
ANGLE = Parameter("blade", "blade_angle", 0.01)
RADIUS = Parameter("blade", "point_radius", 1e-3)
OFFSET = Parameter("blade", "radius_offset", 1e-3)
CURVATURE = Parameter("blade", "curvature", 1.0)
PHASE = Parameter("phase", "phase", 0.01)


def free_settings(inputs: SettingsInput) -> FreeSettings:
    """Free settings of the pinion.

    Face hobbing, one setting for both flanks: cutter axis, radial setting, the three places of the work and the roll
    ratio; each blade has its angle, radius, curvature and phase. Face milling has no blade phase: in one setting for
    both flanks the work rotation is shared and modified roll helps. In a setting per flank everything is the flank's
    own; cutter axis, radial setting, radius and blade alone would do for the flank, but leave the root 1 to 3 mm off.
    """
    bend = (CURVATURE,) if inputs.curved_blades else ()
    hobbed = inputs.blank.process == "face_hobbing"
    plain = (*AXIS, RADIAL, *PLACES, ROLL)
    machine = (*plain, *MODIFIED)
    if inputs.cutting.pinion == "each_flank":
        return FreeSettings((), (*machine, ANGLE, RADIUS, *bend, PHASE))
    if hobbed and inputs.cutting.radius_offsets == "none":
        return FreeSettings((*machine, HELICAL), (ANGLE, *bend, PHASE))
    if hobbed:
        return FreeSettings(plain if inputs.cutting.machine == "free_form" else machine, (ANGLE, OFFSET, *bend, PHASE))
    return FreeSettings((*machine, PHASE), (ANGLE, RADIUS, *bend))


def with_motions(free: FreeSettings) -> FreeSettings:
    """The same with modified roll and helical motion, for targets that the plain settings miss."""
    motions = (*MODIFIED, HELICAL)
    if free.common:
        return FreeSettings((*free.common, *(m for m in motions if m not in free.common)), free.own)
    return FreeSettings((), (*free.own, *(m for m in motions if m not in free.own)))


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
