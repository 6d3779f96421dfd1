"""Settings of a classic cradle machine: the work at its root angle, the cutter axis near the cradle axis.

The exactly conjugate start has the gear axis as cradle axis (Formate) or the cradle of the generating gear, with the
cutter tilted by 15 to 30 deg relative to the pinion root. A cradle along another axis of the cylindroid of gear and
pinion axis (`generating`) preserves the instantaneous line of contact: the cut flank still contacts the conjugate one
along that line and deviates to second order across it. The cradle is moved in steps from the exact axis to the axis
whose machine root angle is the root angle of the pinion. At each step the tool keeps its position in space and the
settings are fitted again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from efficiency.cutting.flank import CutFlank
from efficiency.machine_settings.fit import FitParameter, FitResult, FittedFlank, FreeSettings, TargetFlank, fit
from efficiency.machine_settings.gear import PairDimensions
from efficiency.machine_settings.generating import (
    FreeAxisMachine,
    GeneratingScrew,
    ToolPose,
    free_axis,
    generating_screw,
    machine_pose,
    share_of_root_angle,
    tilt_and_swivel,
    work_facing,
)
from ehl.common.arrays import FloatArray


def cradle_shares(pair: PairDimensions, screw: GeneratingScrew, steps: int) -> FloatArray:
    """Shares from the exact cradle to the one at the root angle of the pinion, without the exact one."""
    root = pair.pinion.pitch_angle - pair.pinion.dedendum_angle
    last = share_of_root_angle(pair.assembly, root, "pinion")
    now = float(np.arcsin(screw.direction @ pair.assembly.pinion_axis[:, 0]))
    first = share_of_root_angle(pair.assembly, now, "pinion")
    return first + (last - first) * np.arange(1, steps + 1) / steps


def tool_in_space(pair: PairDimensions, flank: CutFlank, screw: GeneratingScrew) -> ToolPose:
    """Pose of the cutter of a flank in the mesh frame at the design point, from its settings on a cradle."""
    machine = tilt_and_swivel(flank).machine
    axis, origin = pair.assembly.pinion_axis[:, 0], pair.assembly.pinion_origin[:, 0]
    z = screw.direction
    x = axis - (axis @ z) * z
    x /= np.linalg.norm(x)
    frame = np.stack([x, np.cross(z, x), z], axis=1)
    to_back, g = machine.machine_centre_to_back, machine.machine_root_angle
    work = np.array([to_back * np.cos(g), -machine.blank_offset, to_back * np.sin(g) + machine.sliding_base])
    centre = origin - frame @ work
    return ToolPose(centre + frame @ machine.cutter_centre, frame @ machine.cutter_axes)


def fit_on_cradle(
    pair: PairDimensions,
    targets: Sequence[TargetFlank],
    screw: GeneratingScrew,
    free: FreeSettings,
    tilt_limit: float,
    steps: int = 3,
) -> FitResult:
    """Fit on the cradle of a classic machine in steps; tilt beyond the limit is reduced to it and fixed.

    targets: flanks at the exactly conjugate start.
    screw: cradle of that start.
    """
    result: FitResult | None = None
    here = list(targets)
    shares = cradle_shares(pair, screw, steps)
    for share in shares:
        following = generating_screw(pair.assembly, float(share))
        here = [_on_cradle(pair, target, screw, following) for target in here]
        # a coarse fit is sufficient for the intermediate steps
        result = fit(here, free.common, free.own, max_iterations=60 if share == shares[-1] else 12)
        here = [_from_fit(target, fitted) for target, fitted in zip(here, result.flanks, strict=True)]
        screw = following
    assert result is not None
    if max(_tilt(flank.flank) for flank in result.flanks) > tilt_limit:
        here = [_tilted_back(target, tilt_limit) for target in here]
        held = FreeSettings(_without_axis(free.common), _without_axis(free.own))
        result = fit(here, held.common, held.own)
    return result


def _from_fit(target: TargetFlank, fitted: FittedFlank) -> TargetFlank:
    root = target.root
    if root is not None and fitted.root is not None:
        root = replace(root, start=fitted.root.parameters)
    return replace(target, flank=fitted.flank, phase=fitted.phase, parameters=fitted.parameters, root=root)


def _tilt(flank: CutFlank) -> float:
    return abs(float(tilt_and_swivel(flank).machine.tilt))


def _tilted_back(target: TargetFlank, limit: float) -> TargetFlank:
    machine = target.flank.machine
    assert isinstance(machine, FreeAxisMachine)
    share = min(1.0, float(np.sin(limit)) / max(float(np.hypot(machine.axis_x, machine.axis_y)), 1e-12))
    machine = replace(machine, axis_x=share * machine.axis_x, axis_y=share * machine.axis_y)
    return replace(target, flank=replace(target.flank, machine=machine))


def _without_axis(parameters: tuple[FitParameter, ...]) -> tuple[FitParameter, ...]:
    return tuple(parameter for parameter in parameters if parameter.name not in ("axis_x", "axis_y"))


def _on_cradle(pair: PairDimensions, target: TargetFlank, old: GeneratingScrew, new: GeneratingScrew) -> TargetFlank:
    """The same tool in space on another cradle; the cutting parameters are starting values."""
    axis = pair.assembly.pinion_origin[:, 0], pair.assembly.pinion_axis[:, 0]
    pose = machine_pose(new.point, new.direction, *axis, tool_in_space(pair, target.flank, old))
    before = tilt_and_swivel(target.flank)
    shift = before.index_zero - target.flank.index_zero
    facing = (pair.assembly.pinion_frame.T @ pose.work_direction)[:2]
    was = (pair.assembly.pinion_frame.T @ work_facing(old.direction, pair.assembly.pinion_axis[:, 0]))[:2]
    turned = float(np.arctan2(facing[1], facing[0]) - np.arctan2(was[1], was[0]))
    was_set = before.machine
    machine = replace(
        pose.machine(was_set.roll_ratio * old.rate / new.rate, was_set.helical_motion_1 + old.pitch - new.pitch),
        modified_roll_2c=was_set.modified_roll_2c,
        modified_roll_6d=was_set.modified_roll_6d,
    )
    # the angular position of the cutter about its axis is kept as well
    own = tool_in_space(pair, before, old).axes
    turned_cutter = tool_in_space(pair, replace(before, machine=machine), new).axes.T @ own
    ahead = float(np.arctan2(turned_cutter[1, 0], turned_cutter[0, 0]))
    parameters = target.parameters + np.array([[0.0], [shift + ahead], [0.0]])
    parameters[2] *= new.rate / old.rate
    flank = replace(before, machine=machine, index_zero=before.index_zero + ahead)
    flank, parameters = free_axis(flank, parameters)
    root = target.root
    if root is not None:
        start = np.stack([root.start[0] + (parameters - target.parameters)[1, 0], root.start[1] * new.rate / old.rate])
        root = replace(root, start=start)
    return replace(target, flank=flank, phase=target.phase + turned, parameters=parameters, root=root)
