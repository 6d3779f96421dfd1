"""What must not change: a pair of another size, the mirror image for offsets of both signs; signs of misalignment.

The misalignment is that of an overhung pinion, from tooth forces of the textbook and statics of its bearings:
Nothing of the program's contact, frames or beams is used. A left-hand pinion that turns clockwise, seen from its back,
drives with its concave flanks (Shigley's Mechanical Engineering Design, forces on bevel gears). In the frame of the
docs, x along the pinion axis to the teeth, z along the gear axis to its teeth, the force on them is (thrust,
-tangential, -radial). On the convex flanks the tangential force changes its direction and the spiral pulls the pinion
in. A right-hand pinion is the mirror image in y, and its E counts against y.
"""

import math
from functools import cache
from math import radians
from typing import Any, get_args

import numpy as np
import pytest
from pydantic import BaseModel

import efficiency
from efficiency.contact.flank_pair import flank_pair
from efficiency.design.design import Design, load_design
from efficiency.design.shaft_input import StiffnessInput
from efficiency.machine_settings.inputs import SettingsInput, load_targets
from efficiency.mesh import Mesh
from efficiency.pair import GearPair
from ehl.common.units import ValueRange
from ehl.common.validation import validate

NAMES = ("fh_hypoid_9x34", "fm_spiral_bevel_14x39")
POWERS = {"m": 1, "1/m": -1, "m^2": 2, "1/m^2": -2, "1/m^3": -3}  # of the length, by unit


def rebuilt(design: Design, change: Any) -> Design:
    """The design with every number passed through ``change(unit, name, value)``."""

    def walk(model: BaseModel, name: str) -> dict[str, Any]:
        data: dict[str, Any] = {}
        for key, info in type(model).model_fields.items():
            value = getattr(model, key)
            optional = [part for kind in get_args(info.annotation) for part in getattr(kind, "__metadata__", ())]
            unit = next((part.unit for part in (*info.metadata, *optional) if isinstance(part, ValueRange)), None)
            if isinstance(value, BaseModel):
                value = walk(value, f"{name}.{key}")
            elif isinstance(value, float | str) and not isinstance(value, bool):
                value = change(unit, key, value)
            data[key] = value
        return data

    return Design.model_validate(walk(design, "design"))


def mirror(unit: str | None, name: str, value: Any) -> Any:
    if name == "hand":
        return {"left": "right", "right": "left"}[value]
    # of the modified roll the odd terms keep, the even ones change their sign: the cradle turns the other way
    return -value if name in ("cradle_angle", "swivel", "blank_offset", "modified_roll_2c") else value


def doubled(unit: str | None, name: str, value: Any) -> Any:
    return value * 2.0 ** POWERS.get(unit or "", 0) if isinstance(value, float) else value


@pytest.mark.parametrize("name", NAMES)
def test_a_pair_of_twice_the_size_has_the_same_pressure_and_efficiency(name: str) -> None:
    """Pressures stay where the torque grows with the cube of the lengths; 1e-4 is seen under load."""
    design = load_design(name)
    larger = rebuilt(design, doubled)
    one, other = (
        Mesh.of(pair, "drive", 6, 15, keep=True).load(torque).efficiency("constant:0.06")
        for pair, torque in ((design, 300.0), (larger, 2400.0))
    )
    assert other.status == one.status == "converged"
    assert other.pressure_hertz_max == pytest.approx(one.pressure_hertz_max, rel=5e-4)
    assert 1.0 - other.efficiency == pytest.approx(1.0 - one.efficiency, rel=5e-4)
    error = one.cycle.transmission_error_loaded
    assert other.cycle.transmission_error_loaded == pytest.approx(error, rel=5e-3)
    paths = [flank_pair(found.flanks(), "drive").path for found in (design, larger)]
    np.testing.assert_allclose(paths[0].transmission_error, paths[1].transmission_error, atol=1e-10)


def targets(hand: str, offset: float, spiral: float) -> SettingsInput:
    start = load_targets("fm_hypoid_13x42_relieved")
    changes = {"hand_pinion": hand, "hypoid_offset": offset, "mean_spiral_angle_pinion": radians(spiral)}
    return start.model_copy(update={"blank": start.blank.model_copy(update=changes)})


@pytest.mark.parametrize(("offset", "spiral"), [(0.015, 50.0), (-0.010, 30.0)])
def test_a_mirrored_pair_has_the_same_pressure_and_efficiency(offset: float, spiral: float) -> None:
    found = {}
    for hand in ("left", "right"):
        blank = targets(hand, offset, spiral).blank
        made = efficiency.blank(blank)
        assert (made.pinion.mean_spiral_angle > made.gear.mean_spiral_angle) == (offset > 0.0)
        assert made.pinion_below == ((offset > 0.0) == (hand == "left"))
        design = efficiency.settings(targets(hand, offset, spiral), transmission=False).design
        assert design.assembly.hypoid_offset == offset
        result = efficiency.GearPair(design).at("constant:0.05", grid=(4, 9))
        found[hand] = result.efficiency, result.pressure_hertz_max, result.power_loss
    # the two fits of the settings end within 1e-9 of each other; how close depends on the processor
    assert found["left"] == pytest.approx(found["right"], rel=1e-8)
    assert 0.9 < found["left"][0] < 1.0


NAME, TORQUE = "fm_spiral_bevel_14x39_relieved", 300.0
NEAR, FAR, RADIAL_NEAR, RADIAL_FAR, AXIAL = 0.12, 0.20, 4e9, 3e9, 2e9
MEAN = 0.0765
PRESSURE, SPIRAL = math.radians(20.0), math.radians(35.0)


@cache
def overhung(hand: str) -> Design:
    """The pinion on a shaft too thick to bend, on two springs behind it."""
    near, far = {"position": NEAR, "radial": RADIAL_NEAR, "axial": AXIAL}, {"position": FAR, "radial": RADIAL_FAR}
    shaft: dict[str, Any] = {"reference_point": MEAN, "shaft_diameter": 1.0, "bearings": [near, far]}
    design = load_design(NAME)
    assert design.pinion.blank.hand == "left"
    design = design if hand == "left" else rebuilt(design, mirror)
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
    sums = {"G": abs(up) + abs(lift), "shaft_angle_error": abs(slope) + abs(turn)}
    return found, {name: sums.get(name, abs(x)) for name, x in found.items()}


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
