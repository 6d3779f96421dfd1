"""The pinion conjugate to the cut gear, and its exact settings: the mirrored tool of the gear.

The pinion is cut by the same tool surface on the same cradle (see `generating`), from the opposite side: the cutter is
rotated by 180 deg about its x axis, and its tip plane is displaced by both dedenda. The blade that contacts the concave
flank of the gear from the slot becomes the inside blade of the convex flank of the pinion.

Settings of a classic cradle machine: the work at its root angle, the cutter axis near the cradle axis.

The exactly conjugate start has the gear axis as cradle axis (Formate) or the cradle of the generating gear, with the
cutter tilted by 15 to 30 deg relative to the pinion root. A cradle along another axis of the cylindroid of gear and
pinion axis (`generating`) preserves the instantaneous line of contact: the cut flank still contacts the conjugate one
along that line and deviates to second order across it. The cradle is moved in steps from the exact axis to the axis
whose machine root angle is the root angle of the pinion. At each step the tool keeps its position in space and the
settings are fitted again.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from efficiency.contact.conjugate import read_ease_off_map
from efficiency.contact.ease_off import ConjugatePoints, conjugate_points
from efficiency.cutting.cutter import FlankSide
from efficiency.cutting.flank import CutFlank
from efficiency.cutting.machine import dot, turn
from efficiency.machine_settings import generating
from efficiency.machine_settings.fit import FitResult, FittedFlank, FreeSettings, RootLine, TargetFlank, fit
from efficiency.machine_settings.gear import GearCut, PairDimensions
from efficiency.machine_settings.inputs import FlankTarget
from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError


def tool_in_space(pair: PairDimensions, flank: CutFlank, screw: generating.GeneratingScrew) -> generating.ToolPose:
    """Pose of the cutter of a flank in the mesh frame at the design point, from its settings on a cradle."""
    machine = generating.tilt_and_swivel(flank).machine
    axis, origin = pair.assembly.pinion_axis[:, 0], pair.assembly.pinion_origin[:, 0]
    z = screw.direction
    x = axis - (axis @ z) * z
    x /= np.linalg.norm(x)
    frame = np.stack([x, np.cross(z, x), z], axis=1)
    to_back, g = machine.machine_centre_to_back, machine.machine_root_angle
    work = np.array([to_back * np.cos(g), -machine.blank_offset, to_back * np.sin(g) + machine.sliding_base])
    centre = origin - frame @ work
    return generating.ToolPose(centre + frame @ machine.cutter_centre, frame @ machine.cutter_axes)


def fit_on_cradle(
    pair: PairDimensions,
    targets: Sequence[TargetFlank],
    screw: generating.GeneratingScrew,
    free: FreeSettings,
    tilt_limit: float,
) -> FitResult:
    """Fit on the cradle of a classic machine in steps; tilt beyond the limit is reduced to it and fixed.

    targets: flanks at the exactly conjugate start.
    screw: cradle of that start.
    """
    result: FitResult | None = None
    here = list(targets)
    # shares from the exact cradle to the one at the root angle of the pinion
    root = pair.pinion.pitch_angle - pair.pinion.dedendum_angle
    now = float(np.arcsin(screw.direction @ pair.assembly.pinion_axis[:, 0]))
    first, last = (generating.share_of_root_angle(pair.assembly, angle, "pinion") for angle in (now, root))
    shares = first + (last - first) * np.arange(1, _STEPS + 1) / _STEPS
    for share in shares:
        following = generating.generating_screw(pair.assembly, float(share))
        here = [_on_cradle(pair, target, screw, following) for target in here]
        # a coarse fit is sufficient for the intermediate steps
        result = fit(here, free.common, free.own, max_iterations=60 if share == shares[-1] else 12)
        here = [_from_fit(target, fitted) for target, fitted in zip(here, result.flanks, strict=True)]
        screw = following
    assert result is not None
    if max(abs(float(generating.tilt_and_swivel(f.flank).machine.tilt)) for f in result.flanks) > tilt_limit:
        for k, target in enumerate(here):
            machine = target.flank.machine
            assert isinstance(machine, generating.FreeAxisMachine)
            share = min(1.0, float(np.sin(tilt_limit)) / max(float(np.hypot(machine.axis_x, machine.axis_y)), 1e-12))
            machine = replace(machine, axis_x=share * machine.axis_x, axis_y=share * machine.axis_y)
            here[k] = replace(target, flank=replace(target.flank, machine=machine))
        common, own = ([p for p in part if p.name not in ("axis_x", "axis_y")] for part in (free.common, free.own))
        result = fit(here, common, own)
    return result


def _from_fit(target: TargetFlank, fitted: FittedFlank) -> TargetFlank:
    root = target.root
    if root is not None and fitted.root is not None:
        root = replace(root, start=fitted.root.parameters)
    return replace(target, flank=fitted.flank, phase=fitted.phase, parameters=fitted.parameters, root=root)


def _on_cradle(
    pair: PairDimensions, target: TargetFlank, old: generating.GeneratingScrew, new: generating.GeneratingScrew
) -> TargetFlank:
    """The same tool in space on another cradle; the cutting parameters are starting values."""
    axis = pair.assembly.pinion_origin[:, 0], pair.assembly.pinion_axis[:, 0]
    pose = generating.machine_pose((new.point, new.direction), axis, tool_in_space(pair, target.flank, old))
    before = generating.tilt_and_swivel(target.flank)
    shift = before.index_zero - target.flank.index_zero
    facing = (pair.assembly.pinion_frame.T @ pose.work_direction)[:2]
    was = (pair.assembly.pinion_frame.T @ generating.work_facing(old.direction, pair.assembly.pinion_axis[:, 0]))[:2]
    turned = float(np.arctan2(facing[1], facing[0]) - np.arctan2(was[1], was[0]))
    was_set = before.machine
    machine = replace(
        pose.settings,
        roll_ratio=was_set.roll_ratio * old.rate / new.rate,
        helical_motion_1=was_set.helical_motion_1 + old.pitch - new.pitch,
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
    flank, parameters = generating.free_axis(flank, parameters)
    root = target.root
    if root is not None:
        start = np.stack([root.start[0] + (parameters - target.parameters)[1, 0], root.start[1] * new.rate / old.rate])
        root = replace(root, start=start)
    return replace(target, flank=flank, phase=target.phase + turned, parameters=parameters, root=root)


_STEPS = 3  # of the cradle from the exact axis to that at the root angle
_SHAPE = (15, 9)
# stations of the root line, in face widths
_STATIONS = np.array([-0.5, 0.0, 0.5])
_FACE, _DEPTH = 0.9, (0.03, 0.97)
# starts of the grid over the depth, raised for an undercut gear
_LOWEST = (0.03, 0.06, 0.1, 0.15, 0.2, 0.3)


def opposite(side: FlankSide) -> FlankSide:
    """The mating flank."""
    return "convex" if side == "concave" else "concave"


@dataclass(frozen=True)
class FitGrid:
    """Gear points at which a pinion flank is fitted."""

    # blank coordinates on the gear [m]
    u: FloatArray
    h: FloatArray
    # position on the face, -1 at the toe and 1 at the heel, and on the working depth, -1 at the root and 1 at the tip
    # of the gear
    x: FloatArray
    y: FloatArray
    shape: tuple[int, int]  # points along the face and over the depth; the depth is the outer index
    lowest: float  # fraction of the working depth at the start of the grid


def fit_grid(pair: PairDimensions, lowest: float = _DEPTH[0], shape: tuple[int, int] = _SHAPE) -> FitGrid:
    """Grid over nine tenths of the face width and nearly the whole working depth."""
    blank = pair.gear
    axes = np.linspace(-_FACE, _FACE, shape[0]), np.linspace(lowest, _DEPTH[1], shape[1])
    x, v = (g.ravel() for g in np.meshgrid(*axes))
    u = 0.5 * x * blank.face_width
    low = blank.root(u) + pair.blank.clearance
    return FitGrid(u, low + v * (blank.tip(u) - low), x, 2.0 * v - 1.0, shape, lowest)


def grid_on_gear(pair: PairDimensions, gear: GearCut) -> FitGrid:
    """The grid, starting above the undercut of the gear if there is one."""
    for lowest in _LOWEST:
        grid = fit_grid(pair, lowest)
        if all(gear.flank(side).solve(grid.u, grid.h)[1].all() for side in ("concave", "convex")):
            return grid
    raise ConvergenceError("undercut", "a gear flank does not cover its working depth")


@dataclass(frozen=True)
class ConjugateFlankStart:
    """One pinion flank at the exactly conjugate settings."""

    flank: CutFlank
    phase: float  # its rotation about the pinion axis in the frame of the pinion at zero rotation [rad]
    points: ConjugatePoints  # conjugate points of the grid
    parameters: FloatArray  # cutting parameters of these points
    error: float  # largest distance between both [m]


def conjugate_start(pair: PairDimensions, gear: GearCut, side: FlankSide, grid: FitGrid) -> ConjugateFlankStart:
    """Exactly conjugate settings of one pinion flank."""
    cut = gear.flank(opposite(side))
    points, found = cut.solve(grid.u, grid.h)
    if not found.all():
        raise ConvergenceError("undercut", f"the {cut.side} gear flank does not cover its working depth")
    conjugate = conjugate_points(points, pair.assembly)

    assembly, screw = pair.assembly, gear.screw
    axis, tool = (assembly.pinion_origin[:, 0], assembly.pinion_axis[:, 0]), gear.tool
    # distance of both tip planes
    reach = float(sum(m.mean_dedendum * np.cos(m.dedendum_angle) for m in (pair.blank.gear, pair.blank.pinion)))
    # the gear cutter rotated by 180 deg, with its tips at the pinion root at the mean point
    turned = tool.axes @ np.diag([1.0, -1.0, -1.0])
    tool = generating.ToolPose(tool.centre - reach * tool.axes[:, 2], turned)
    pose = generating.machine_pose((screw.point, screw.direction), axis, tool)
    machine = replace(pose.settings, roll_ratio=1.0 / screw.rate, helical_motion_1=-screw.pitch)
    angle = cut.blade.blade_angle
    zero = pose.cutter_turn - gear.tool_angle
    depth = pair.blank.pinion.mean_dedendum * float(np.cos(pair.pinion.dedendum_angle))
    radius, height = pair.process.conjugate_reference(cut.blade, reach, depth)
    blade = replace(
        cut.blade,
        side=side,
        point_radius=radius,
        reference_height=height,
        offset_angle=-cut.blade.offset_angle,
        phase=0.0,
    )
    flank = CutFlank(blade, machine, pair.pinion, zero)

    # the gear flank is rotated by its blade phase; the mating pinion is rotated back by the ratio
    ahead = -cut.index_ratio * cut.blade.phase
    reference = (gear.rotation - ahead) / assembly.ratio
    facing = assembly.pinion_frame.T @ pose.work_direction
    phase = float(np.arctan2(facing[1], facing[0])) - np.pi - reference
    th = zero - (points.parameters[1] - gear.cutter_turn - gear.tool_angle)
    rolled = conjugate.gear_roll / assembly.ratio - reference
    phi = (rolled + flank.index_ratio * (th - zero)) * screw.rate
    parameters = np.stack([reach / np.cos(angle) - points.parameters[0], th, phi])
    error = float(np.abs(flank.sweep(parameters)[0] - turn(conjugate.position, -phase)).max())
    return ConjugateFlankStart(flank, phase, conjugate, parameters, error)


def target_flank(
    pair: PairDimensions, start: ConjugateFlankStart, relief: FloatArray, root_weight: float, thinning: float = 0.0
) -> TargetFlank:
    """Target of a flank fit, from its conjugate start.

    relief (n,): ease-off at the points of the grid [m].
    root_weight: residual per root error; with 0 the root is not fitted, only evaluated.
    thinning: angle by which the flank is moved back from contact [rad].
    """
    flank, parameters = generating.free_axis(start.flank, start.parameters)
    conjugate = start.points
    phase = start.phase
    if thinning:
        points = flank.points(parameters)
        rate = np.median(points.lever / dot(points.normal, turn(conjugate.normal, -phase)))
        phase -= float(np.sign(rate)) * thinning
    place = pair.pinion.place(conjugate.position)
    stations = _STATIONS * pair.pinion.face_width
    line = RootLine.of_blank(pair.pinion, stations, root_weight, *place, parameters)
    root = line if np.isfinite(line.cut(flank).error).all() else None
    return TargetFlank(flank, phase, conjugate.position, conjugate.normal, relief, parameters, root)


def backlash_angle(pair: PairDimensions) -> float:
    """Rotation of each pinion flank that produces the backlash of the pair [rad].

    The thickness is reduced by j_mn/cos(alpha_n), half of it at each flank (ISO 23509 (202), (204)).
    """
    blank = pair.blank
    radius, _ = pair.pinion.axial(np.array([-blank.pinion.middle_shift]), np.zeros(1))
    alpha = 0.5 * (blank.pressure_angle_drive + blank.pressure_angle_coast)
    lever = float(radius[0]) * np.cos(blank.pinion.mean_spiral_angle) * np.cos(alpha)
    return float(0.5 * blank.backlash_normal / lever)


def target_relief(target: FlankTarget, x: FloatArray, y: FloatArray) -> FloatArray:
    """Relief [m] at positions on the face (-1 toe, 1 heel) and the working depth (-1 root, 1 tip of the gear).

    With ``X = x - contact_face - bias (y - contact_depth)`` and ``Y = y - contact_depth`` it is
    ``(heel + toe)/2 X^2 + (heel - toe)/2 X^3 + (tip + root)/2 Y^2 + (tip - root)/2 Y^3 + twist (x - contact_face) Y``.
    This function is smooth and has the amounts of the targets at the ends of both axes for a central contact. A map is
    added.
    """
    across = y - target.contact_depth
    along = x - target.contact_face - target.bias * across
    twist = target.twist * (x - target.contact_face) * across
    lengthwise = _ends(along, target.crowning_toe, target.crowning_heel)
    relief = lengthwise + _ends(across, target.relief_root, target.relief_tip) + twist
    return relief if target.map is None else relief + read_ease_off_map(Path(target.map))(x, y)


def _ends(x: FloatArray, low: float, high: float) -> FloatArray:
    return np.asarray((0.5 * (high + low) + 0.5 * (high - low) * x) * x * x)
