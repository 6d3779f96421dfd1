"""A pinion with one tooth that winds around its axis more than three times, and the ring of few teeth."""

import numpy as np
import pytest

import efficiency
from efficiency.blanks.inputs import PairBlankInput
from efficiency.contact.tooth_grid import tooth_grid
from efficiency.design.design import Design
from efficiency.loss.closed_form import PitchGeometry, buckingham_type, lengthwise_sliding
from efficiency.ltca.ritz_solid import Orders
from efficiency.ltca.solid_tooth import solid_tooth_of
from efficiency.machine_settings.inputs import SettingsInput
from ehl.common.validation import validate

EASE_OFF = {"crowning_toe": "10 um", "crowning_heel": "10 um", "relief_root": "4 um", "relief_tip": "4 um"}
BLANK = {
    "name": "1x60", "method": 1, "process": "face_milling", "teeth_pinion": 1, "teeth_gear": 60,
    "hypoid_offset": "30 mm", "outer_pitch_diameter_gear": "150 mm", "face_width_gear": "12 mm",
    "mean_spiral_angle_pinion": "75 deg", "cutter_radius": "60 mm", "depth": {
        "data_type": "I", "profile_shift": 0.65, "addendum_factor": 0.85, "dedendum_factor": 1.1,
        "thickness_modification": 0.06,
    },
}  # fmt: skip
MEMBER = {"material": "steel", "finish": "ground"}


@pytest.fixture(scope="module")
def design() -> Design:
    content = {
        "name": "1x60",
        "blank": BLANK,
        "cutting": {"gear": "formate", "pinion": "each_flank"},
        "targets": {"drive": EASE_OFF, "coast": EASE_OFF},
        "pinion": MEMBER,
        "gear": MEMBER,
        "operation": {"torque": "5 N m", "speed": "1500 rpm", "temperature": "60 degC", "oil": "75w90"},
    }  # fmt: skip
    made = efficiency.settings(validate(SettingsInput, content))
    assert made.status == "converged"
    # as much as the ease-off makes, 4 um over the depth: no other turn of the thread takes part
    assert made.concave.transmission.edges == ()
    assert made.concave.transmission.peak_to_peak == pytest.approx(6.36 / 206265.0, rel=0.02)
    return made.design


def test_a_pinion_with_one_tooth_runs(design: Design) -> None:
    assert tooth_grid(design.flanks(), "pinion", 7, 7).winding > 6.0 * np.pi
    pair = efficiency.GearPair(design)
    result = pair.at("constant:0.05", grid=(6, 15))
    assert result.status == "converged"
    assert 1e9 < result.pressure_hertz_max < 3e9
    # the lengthwise sliding of the pitch point, and profile sliding on top of it
    made = efficiency.blank(validate(PairBlankInput, BLANK))
    pinion, gear = made.pinion, made.gear
    angles = pinion.mean_spiral_angle, gear.mean_spiral_angle, pinion.pitch_angle, gear.pitch_angle
    sizes = 0.5 * pinion.mean_diameter, 0.5 * gear.mean_diameter, made.module_normal
    pitch = PitchGeometry(made.pressure_angle_drive, *angles, *sizes, made.virtual_drive.contact_ratio_profile)
    assert result.efficiency < lengthwise_sliding(pitch, 0.05)
    assert result.efficiency == pytest.approx(buckingham_type(pitch, 0.05), abs=0.03)


def test_the_next_tooth_of_a_ring_of_one_is_the_loaded_one(design: Design) -> None:
    body = design.pinion.tooth_body()
    tooth = solid_tooth_of(design.flanks(), body, "pinion", "drive", Orders((4, 5, 10), (4, 4, 8)))
    # far from the load, where no local deformation is subtracted
    assert tooth.ahead[0][0, -1] == pytest.approx(tooth.own[0, -1], rel=0.05, abs=1e-3 * np.abs(tooth.own).max())
