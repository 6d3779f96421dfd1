"""Signs and sizes of the misalignment of an overhung pinion: tooth forces of the textbook, statics of its bearings.

Nothing of the program's contact, frames or beams is used. A left-hand pinion that turns clockwise, seen from its back,
drives with its concave flanks (Shigley's Mechanical Engineering Design, forces on bevel gears). In the frame of the
docs, x along the pinion axis to the teeth, z along the gear axis to its teeth, the force on them is (thrust,
-tangential, -radial). On the convex flanks the tangential force changes its direction and the spiral pulls the pinion
in. A right-hand pinion is the mirror image in y, and its E counts against y.
"""

import math
from functools import cache
from typing import Any

import pytest
from rebuilt_designs import mirror, rebuilt

from efficiency.design.design import Design, load_design
from efficiency.design.shaft_input import StiffnessInput
from efficiency.pair import GearPair
from ehl.common.validation import validate

NAME, TORQUE = "fm_spiral_bevel_14x39_relieved", 300.0
NEAR, FAR, RADIAL_NEAR, RADIAL_FAR, AXIAL = 0.12, 0.20, 4e9, 3e9, 2e9
MEAN = 0.0765
PRESSURE, SPIRAL = math.radians(20.0), math.radians(35.0)


@cache
def of_hand(hand: str) -> Design:
    design = load_design(NAME)
    assert design.pinion.blank.hand == "left"
    return design if hand == "left" else rebuilt(design, mirror)


def overhung(hand: str) -> Design:
    """The pinion on a shaft too thick to bend, on two springs behind it."""
    near, far = {"position": NEAR, "radial": RADIAL_NEAR, "axial": AXIAL}, {"position": FAR, "radial": RADIAL_FAR}
    shaft: dict[str, Any] = {"reference_point": MEAN, "shaft_diameter": 1.0, "bearings": [near, far]}
    design = of_hand(hand)
    stiffness = validate(StiffnessInput, {"pinion": shaft}, "assembly.stiffness")
    return design.model_copy(update={"assembly": design.assembly.model_copy(update={"stiffness": stiffness})})


def line(force: float, moment: float) -> tuple[float, float]:
    """Displacement at the crossing point and slope of a shaft on both bearings; moment about the crossing point."""
    far = (moment - NEAR * force) / (FAR - NEAR)
    near = force - far
    slope = (far / RADIAL_FAR - near / RADIAL_NEAR) / (FAR - NEAR)
    return near / RADIAL_NEAR - slope * NEAR, slope


def by_hand(side: str) -> tuple[dict[str, float], dict[str, float]]:
    """E, P, G [m] and shaft_angle_error [rad] of the left-hand pinion, and the sum of their parts without signs."""
    blank = load_design(NAME).pinion.blank
    cone, radius = blank.pitch_angle, blank.mean_cone_distance * math.sin(blank.pitch_angle)
    way = 1.0 if side == "drive" else -1.0
    tangential = TORQUE / radius
    pressure, spiral = math.tan(PRESSURE) / math.cos(SPIRAL), way * math.tan(SPIRAL)
    thrust = tangential * (pressure * math.sin(cone) + spiral * math.cos(cone))
    radial = tangential * (pressure * math.cos(cone) - spiral * math.sin(cone))
    at = blank.mean_cone_distance * math.cos(cone)
    aside, _ = line(-way * tangential, -way * tangential * at)
    # the thrust acts on the teeth, above the axis: it turns the nose of the pinion towards the gear
    (up, slope), (lift, turn) = line(-radial, -radial * at), line(0.0, -thrust * radius)
    found = {"E": aside, "P": thrust / AXIAL, "G": -up - lift, "shaft_angle_error": -slope - turn}
    return found, {name: abs(x) for name, x in found.items()} | {
        "G": abs(up) + abs(lift),
        "shaft_angle_error": abs(slope) + abs(turn),
    }


@pytest.mark.parametrize("hand", ["left", "right"])
@pytest.mark.parametrize("side", ["drive", "coast"])
def test_overhung_pinion(hand: str, side: Any) -> None:
    """An eighth: the load does not stand quite at the mean point."""
    moved = GearPair(overhung(hand)).mesh(side, positions=4, points_per_line=9).load(TORQUE).grids.mesh.deflection
    expected, parts = by_hand(side)
    for name, value in expected.items():
        assert getattr(moved, name) == pytest.approx(value, abs=0.125 * parts[name]), name
        # a wrong sign would be seen
        assert abs(value) > 0.125 * parts[name], name
