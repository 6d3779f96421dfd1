"""Settings of the gear from blank and cutter.

The cutter axis is normal to the root cone at the mean point; the position of the cutter centre gives the mean trace the
mean spiral angle. A face-hobbed gear then has exact spiral and pressure angles, with both blades at the reference
radius on the pitch plane; the phase of the blades determines the slot. For a face-milled gear two point radii, two
blade angles and the position of the cutter centre along the root line follow from five conditions: slot width, two
pressure angles, mean spiral angle and nominal cutter radius. Without this solution the finite slot width causes an
error of about 0.8 deg of the pressure angle of each flank of a Formate gear, and an error of the order of the dedendum
angle for a generated one.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from efficiency.blanks.pair_blank import PairBlank
from efficiency.contact.assembly import Assembly
from efficiency.cutting.blank import Blank
from efficiency.cutting.cutter import FLANK_SIDES, Blade, FlankSide
from efficiency.cutting.flank import CutFlank
from efficiency.cutting.machine import GENERATIONS, Generation, MachineSettings, rotation
from efficiency.cutting.process import PROCESSES, CuttingProcess
from efficiency.machine_settings import generating
from efficiency.machine_settings.generating import ToolPose
from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError


@dataclass(frozen=True)
class PairDimensions:
    """Dimensions of a pair for machine settings, SI units and rad."""

    blank: PairBlank  # its drive side is the concave pinion and convex gear flank
    assembly: Assembly  # position of the axes, aligned
    hand_gear: float  # +1 for a right-hand gear, -1 for a left-hand one
    # blanks of the members
    pinion: Blank
    gear: Blank
    process: CuttingProcess  # indexing of the head
    generation: Generation  # generation of the gear profile
    offset_angle: float  # azimuth of the mean point of the gear in the mesh frame [rad]
    # calculation point of the gear [m]: distance from the middle of the face towards the heel; radius, axial position
    calculation_gear: float
    point_gear: tuple[float, float]
    slot_angle: float  # angular width of a gear slot at that point [rad]

    def pressure(self, side: FlankSide) -> float:
        """Normal pressure angle of a gear flank [rad]."""
        return self.blank.pressure_angle_coast if side == "concave" else self.blank.pressure_angle_drive


def pair_dimensions(blank: PairBlank) -> PairDimensions:
    """Dimensions of a pair from its blank."""
    hand = 1.0 if blank.gear.hand == "right" else -1.0
    assembly = Assembly(blank.pinion.teeth, blank.gear.teeth, blank.shaft_angle, hand * blank.hypoid_offset)
    gear, shift = blank.gear.cones, -blank.gear.middle_shift
    radius, z = (float(x[0]) for x in gear.axial(np.array([shift]), np.zeros(1)))
    tooth = blank.gear.mean_normal_thickness / (radius * np.cos(blank.gear.mean_spiral_angle))
    return PairDimensions(
        blank,
        assembly,
        hand,
        pinion=blank.pinion.cones,
        gear=gear,
        process=PROCESSES[blank.process],
        generation=GENERATIONS[blank.gear_cutting],
        offset_angle=hand * blank.offset_angle,
        calculation_gear=shift,
        point_gear=(radius, z),
        slot_angle=float(2.0 * np.pi / gear.teeth - tooth),
    )


@dataclass(frozen=True)
class GearCut:
    """The cut gear and its tool in space."""

    concave: CutFlank
    convex: CutFlank
    tool: ToolPose  # cutter in the mesh frame at the design point
    screw: generating.GeneratingScrew  # cradle of the generating gear; the gear itself for a Formate gear
    tool_angle: float  # cutter angle of the mean point in the axes of `tool` [rad]
    cutter_turn: float  # difference of the cutter angle of the gear machine from that in the axes of `tool` [rad]
    rotation: float  # azimuth of the work frame of the gear in the mesh frame at the design point [rad]

    def flank(self, side: FlankSide) -> CutFlank:
        """One of the two flanks."""
        return self.concave if side == "concave" else self.convex


def cut_gear(pair: PairDimensions, eccentricity: float = 0.0) -> GearCut:
    """Both flanks of the gear, with an eccentricity of the parts of a two-part head [m]."""
    cut = GEAR_CUTS[pair.process.name](pair)
    if not eccentricity:
        return cut

    def moved(flank: CutFlank) -> CutFlank:
        return replace(flank, blade=replace(flank.blade, eccentricity=flank.blade.sign * eccentricity))

    return replace(cut, concave=moved(cut.concave), convex=moved(cut.convex))


def _tool(pair: PairDimensions, shift: float) -> tuple[ToolPose, float]:
    """Cutter on the root at the calculation point of the gear, which has azimuth 0; and its cutter angle."""
    blank, hand = pair.gear, pair.hand_gear
    root = blank.pitch_angle - blank.dedendum_angle
    axes = np.array([[np.sin(root), 0.0, -np.cos(root)], [0.0, 1.0, 0.0], [np.cos(root), 0.0, np.sin(root)]])
    radius, z = pair.point_gear
    foot = np.array([radius, 0.0, z]) + pair.blank.gear.mean_dedendum * np.cos(blank.dedendum_angle) * axes[:, 2]
    along, rc = pair.blank.gear.mean_spiral_angle - pair.blank.cutter_lead_angle, pair.blank.cutter_radius
    centre = foot + axes @ np.array([shift - rc * np.sin(along), hand * rc * np.cos(along), 0.0])
    return ToolPose(centre, axes), float(np.arctan2(-hand * np.cos(along), np.sin(along)))


def _cut(
    pair: PairDimensions, tool: ToolPose, angle: float, blades: tuple[Blade, Blade], to_back: float | None = None
) -> GearCut:
    """The gear cut by a tool and its blades with the cutter angle of the mean point [rad].

    `to_back`: machine centre to back of a Formate gear, by default for a machine centre at the root apex [m].
    """
    placed = tool.turned(rotation(pair.offset_angle))
    if pair.generation.rolls:
        root = pair.gear.pitch_angle - pair.gear.dedendum_angle
        screw = generating.generating_screw(pair.assembly, generating.share_of_root_angle(pair.assembly, root))
        pose = generating.machine_pose(
            (screw.point, -screw.direction), (np.zeros(3), np.array([0.0, 0.0, 1.0])), placed
        )
        machine = replace(pose.settings, roll_ratio=-pair.assembly.ratio / screw.rate, helical_motion_1=-screw.pitch)
        cutter_turn, facing = pose.cutter_turn, pose.work_direction
        azimuth = float(np.arctan2(facing[1], facing[0]))
    else:
        # Formate: the machine centre lies on the gear axis
        x, y, z = tool.axes.T
        if to_back is None:
            to_back = -float(tool.centre @ z / z[2])
        centre = tool.centre + np.array([0.0, 0.0, to_back])
        machine = MachineSettings(
            radial_setting=float(np.hypot(centre @ x, centre @ y)),
            cradle_angle=float(np.arctan2(centre @ y, centre @ x)),
            machine_root_angle=float(np.arcsin(z[2])),
            roll_ratio=1.0,
            sliding_base=-float(centre @ z),
            machine_centre_to_back=to_back,
            generation=pair.generation,
        )
        screw, cutter_turn, azimuth = generating.generating_screw(pair.assembly, 0.0), 0.0, pair.offset_angle
    concave, convex = (CutFlank(blade, machine, pair.gear, angle + cutter_turn) for blade in blades)
    return GearCut(concave, convex, placed, screw, angle, cutter_turn, azimuth)


def _hobbed(pair: PairDimensions) -> GearCut:
    """Both blades at the reference radius on the pitch plane; the slot follows from their phase."""
    tool, angle = _tool(pair, 0.0)
    index = (pair.blank.blade_groups or 0) / pair.gear.teeth
    blades = []
    for side in FLANK_SIDES:
        # the slot lies between the flanks, symmetric to the azimuth of the mean point
        ahead = (-0.5 if side == "concave" else 0.5) * pair.hand_gear * pair.slot_angle
        blades.append(
            Blade(
                pair.blank.cutter_radius,
                pair.pressure(side),
                side,
                reference_height=pair.blank.gear.mean_dedendum,
                groups=pair.blank.blade_groups or 0,
                offset_angle=pair.hand_gear * pair.blank.cutter_lead_angle,
                phase=-ahead / index,
            )
        )
    # Formate: the machine centre at the pitch apex
    return _cut(pair, tool, angle, (blades[0], blades[1]), pair.gear.pitch_apex_beyond_crossing)


def _milled(pair: PairDimensions) -> GearCut:
    """Point radii, blade angles and cutter position by Newton's method for the calculation point of both flanks."""
    depth, radius, mean_spiral = pair.blank.gear.mean_dedendum, pair.point_gear[0], pair.blank.gear.mean_spiral_angle
    place = np.array([pair.calculation_gear]), np.zeros(1)
    alphas = [pair.pressure(side) for side in FLANK_SIDES]
    wanted = np.array([pair.slot_angle * radius, *alphas, mean_spiral, pair.blank.cutter_radius])
    width = pair.slot_angle * radius * np.cos(mean_spiral) - depth * np.tan(alphas).sum()
    scale = np.array([1e-3, 1e-3, 0.01, 0.01, 1e-3])
    taper = pair.gear.dedendum_angle * np.sin(mean_spiral) * pair.generation.rolls
    radii = pair.blank.cutter_radius + 0.5 * width, pair.blank.cutter_radius - 0.5 * width
    x = np.array([*radii, alphas[0] - taper, alphas[1] + taper, 0.0])

    def cut(x: FloatArray) -> GearCut:
        tool, angle = _tool(pair, float(x[4]))
        blades = Blade(float(x[0]), float(x[2]), "concave"), Blade(float(x[1]), float(x[3]), "convex")
        return _cut(pair, tool, angle, blades)

    def excess(x: FloatArray) -> FloatArray:
        azimuth, spiral, pressure, made = [], [], [], cut(x)
        for side in FLANK_SIDES:
            points, found = made.flank(side).solve(*place)
            if not found.all():
                raise ConvergenceError("gear_settings", f"the {side} gear flank does not reach its calculation point")
            azimuth.append(float(points.azimuth[0]))
            # spiral angle, positive for the hand of the member
            turn = radius * float(points.winding(pair.gear.pitch_angle)[0])
            spiral.append(pair.hand_gear * float(np.arctan(turn)))
            pressure.append(float(points.angles(pair.gear.pitch_angle)[1][0]))
        slot = np.angle(np.exp(1j * (azimuth[1] - azimuth[0]))) * pair.hand_gear
        made_to = np.array([slot * radius, *pressure, 0.5 * (spiral[0] + spiral[1]), 0.5 * (x[0] + x[1])])
        return np.asarray((made_to - wanted) / np.array([1e-3, 0.01, 0.01, 0.01, 1e-3]))

    for _ in range(8):
        value = excess(x)
        if np.abs(value).max() < 1e-9:
            break
        columns = [(excess(x + 1e-3 * scale * unit) - value) / 1e-3 for unit in np.eye(5)]
        try:
            x = x - scale * np.linalg.solve(np.stack(columns, axis=1), value)
        except np.linalg.LinAlgError:
            what = "radii, angles and position of the gear cutter are not determined"
            raise ConvergenceError("gear_settings", what) from None
    else:
        if np.abs(value).max() > 1e-6:
            raise ConvergenceError("gear_settings", "no point radii and blade angles give the slot of the gear")
    return cut(x)


GEAR_CUTS: dict[str, Callable[[PairDimensions], GearCut]] = {
    "face_milling": _milled,
    "face_hobbing": _hobbed,
    "two_part_face_hobbing": _hobbed,
}
