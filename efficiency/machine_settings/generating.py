"""Which tool on which cradle cuts a pinion exactly conjugate to a gear, and the machine settings of a tool in space.

Let T1, T2 be the twists of pinion and gear in mesh, per radian of the pinion. A generating gear that moves with the
twist ``T = share T1 + (1 - share) T2`` touches the gear where ``n . (T - T2) = share n . (T1 - T2) = 0`` and the pinion
where ``n . (T - T1) = (share - 1) n . (T1 - T2) = 0``: along the same line, the contact line of the pair. Both members
cut by the same tool surface on this cradle are therefore exactly conjugate. With share = 0 the cradle is the gear
itself, and its tool surface is the tooth of a Formate gear; between crossed axes any other share is a screw, so the
cradle then needs helical motion. For face hobbing the tool surface is swept by turning cutter and both members; the
argument is the same, because the index motions of gear and pinion again differ by a multiple of T1 - T2. Derived here.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
import scipy

from efficiency.contact.assembly import Assembly
from efficiency.cutting.flank import CutFlank
from efficiency.cutting.machine import MachineSettings
from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError


@dataclass(frozen=True)
class GeneratingScrew:
    """Cradle of the generating gear in the mesh frame."""

    point: FloatArray  # a point of its axis [m]
    direction: FloatArray  # unit vector along its axis, into the pinion blank
    rate: float  # cradle turn per radian of the pinion
    pitch: float  # advance along `direction` per radian of the cradle [m]


def generating_screw(assembly: Assembly, share: float) -> GeneratingScrew:
    """Cradle whose twist is ``share`` times the pinion's plus ``1 - share`` times the gear's."""
    pinion_axis, pinion_origin = assembly.pinion_axis[:, 0], assembly.pinion_origin[:, 0]
    turn = share * pinion_axis + (1.0 - share) * assembly.ratio * np.array([0.0, 0.0, 1.0])
    speed = share * np.cross(pinion_origin, pinion_axis)
    square = float(turn @ turn)
    rate = float(np.sqrt(square))
    return GeneratingScrew(np.cross(turn, speed) / square, turn / rate, rate, float(turn @ speed) / square)


def share_of_root_angle(assembly: Assembly, root_angle: float, member: str = "gear") -> float:
    """Share that inclines the cradle so that a member has a given machine root angle."""

    def excess(share: float) -> float:
        direction = generating_screw(assembly, share).direction
        sine = -direction[2] if member == "gear" else float(direction @ assembly.pinion_axis[:, 0])
        return float(np.arcsin(sine)) - root_angle

    low, high = 0.0, 0.999
    if excess(low) * excess(high) > 0.0:
        raise InputError(
            f"{member}.root_angle",
            f"{np.degrees(root_angle):.5g} deg",
            "an angle the cradle can have between the members",
        )
    return float(scipy.optimize.brentq(excess, low, high, xtol=1e-15))


@dataclass(frozen=True)
class ToolPose:
    """Tip-plane centre of a cutter and its axes as columns; the third points from the body to the tips."""

    centre: FloatArray
    axes: FloatArray

    def moved(self, rotation: FloatArray, shift: FloatArray) -> ToolPose:
        """The pose after a rotation and a shift."""
        return ToolPose(rotation @ self.centre + shift, rotation @ self.axes)


@dataclass(frozen=True)
class MachinePose:
    """Settings that put a tool at a pose before a work piece."""

    settings: MachineSettings  # without motions
    cutter_turn: float  # what a cutter angle measured in the pose has to grow by to be one of the machine
    work_direction: FloatArray  # where the x axis of the unturned work frame points

    def machine(self, roll_ratio: float, helical_motion_1: float) -> MachineSettings:
        """The settings with a roll ratio and helical motion [m/rad]."""
        return replace(self.settings, roll_ratio=roll_ratio, helical_motion_1=helical_motion_1)


def work_facing(cradle_direction: FloatArray, work_direction: FloatArray) -> FloatArray:
    """Where the x axis of the unturned work frame points: square to the work axis, in its plane with the cradle."""
    sine = float(cradle_direction @ work_direction)
    cosine = float(np.sqrt(1.0 - sine * sine))
    return np.asarray(sine * ((work_direction - sine * cradle_direction) / cosine) - cosine * cradle_direction)


def machine_pose(
    cradle_point: FloatArray,
    cradle_direction: FloatArray,
    work_point: FloatArray,
    work_direction: FloatArray,
    tool: ToolPose,
) -> MachinePose:
    """Settings of a hypoid generator from the lines of cradle and work axis and the pose of the cutter.

    The machine centre is put where the tip-plane centre projects on the cradle axis; only this choice of the gauge
    leaves the tip-plane centre in the machine plane.

    cradle_point, cradle_direction (3,): axis of the cradle, the direction into the blank.
    work_point, work_direction (3,): origin of the work frame and its axis from apex to heel.
    tool: cutter, in the same frame.
    """
    sine = float(cradle_direction @ work_direction)
    cosine = float(np.sqrt(1.0 - sine * sine))
    x = (work_direction - sine * cradle_direction) / cosine
    machine = np.stack([x, np.cross(cradle_direction, x), cradle_direction])
    centre = cradle_point + ((tool.centre - cradle_point) @ cradle_direction) * cradle_direction
    cutter = machine @ (tool.centre - centre)
    work = machine @ (work_point - centre)
    axes = machine @ tool.axes
    tilt = float(np.arctan2(np.hypot(axes[0, 2], axes[1, 2]), axes[2, 2]))
    swivel = float(np.arctan2(axes[1, 2], axes[0, 2])) if tilt > 1e-12 else 0.0
    to_back = float(work[0] / cosine)
    settings = MachineSettings(
        radial_setting=float(np.hypot(cutter[0], cutter[1])),
        cradle_angle=float(np.arctan2(cutter[1], cutter[0])),
        machine_root_angle=float(np.arcsin(sine)),
        roll_ratio=1.0,
        tilt=tilt,
        swivel=swivel,
        blank_offset=float(-work[1]),
        sliding_base=float(work[2] - to_back * sine),
        machine_centre_to_back=to_back,
    )
    left = settings.cutter_axes.T @ axes
    facing = work_facing(cradle_direction, work_direction)
    return MachinePose(settings, float(np.arctan2(left[1, 0], left[0, 0])), facing)


@dataclass(frozen=True)
class FreeAxisMachine(MachineSettings):
    """Machine settings whose cutter axis is given by its components along x and y of the machine.

    Components stay regular where there is no tilt; the swivel does not. The smallest rotation, ``Rz(j) Ry(i) Rz(-j)``,
    leads the cutter there; cutter angles therefore exceed those of tilt and swivel by the swivel angle. `tilt` and
    `swivel` are without effect.
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
