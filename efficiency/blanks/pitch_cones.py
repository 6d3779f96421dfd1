"""Pitch cones of a pair by Methods 0 to 3 (ISO 23509 clause 6)."""

from __future__ import annotations

from efficiency.blanks.inputs import PairBlankInput
from efficiency.blanks.method_1 import method_1
from efficiency.blanks.method_2 import method_2
from efficiency.blanks.method_3 import method_3
from efficiency.blanks.tangency import (
    SPIRAL_LIMIT,
    PitchCones,
    bevel_cones,
    check_pitch_angles,
    face_too_wide,
    too_large,
)
from ehl.common.errors import InputError


def pitch_cones(inputs: PairBlankInput) -> PitchCones:
    """Pitch cones by the method of the input.

    Method 1 (Gleason) curves the tooth lengthwise as the limit curvature asks for; Method 2 (Oerlikon) puts the pinion
    apex on the line from the gear apex to the cutter centre; Method 3 (Klingelnberg) takes the mean cone distance of
    the pinion from the cutter. Without offset all of them are Method 0.
    """
    try:
        cones = (method_0, method_1, method_2, method_3)[inputs.method](inputs)
    except (ValueError, ZeroDivisionError) as error:
        if isinstance(error, InputError):
            raise
        raise too_large(inputs.hypoid_offset) from None
    check_pitch_angles(cones.pitch_angle_1, cones.pitch_angle_2, inputs)
    if not -SPIRAL_LIMIT < cones.spiral_2 <= cones.spiral_1 < SPIRAL_LIMIT:
        raise too_large(inputs.hypoid_offset)
    inner = cones.cone_distance_2 - (1.0 - cones.face_width_factor) * inputs.face_width_gear
    if inner <= 0.0:
        raise face_too_wide(inputs, inner + inputs.face_width_gear)
    return cones


def method_0(inputs: PairBlankInput) -> PitchCones:
    """Bevel pairs: the cones share their apex."""
    assert inputs.mean_spiral_angle_gear is not None
    return bevel_cones(inputs, inputs.mean_spiral_angle_gear, inputs.mean_pitch_diameter_gear)
