"""Which settings are free for a way of cutting, and in what steps they are counted."""

from __future__ import annotations

from dataclasses import dataclass

from efficiency.synthesis.fit import Parameter
from efficiency.synthesis.inputs import SettingsInput


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
    """The same with modified roll and helical motion, for wishes that the plain settings leave above the limit."""
    motions = (*MODIFIED, HELICAL)
    if free.common:
        return FreeSettings((*free.common, *(m for m in motions if m not in free.common)), free.own)
    return FreeSettings((), (*free.own, *(m for m in motions if m not in free.own)))
