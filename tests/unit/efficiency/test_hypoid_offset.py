"""Offsets of both signs: blank, settings, load, efficiency, closed forms."""

from math import radians

import pytest

import efficiency
from efficiency.loss.closed_form import Driver, PitchGeometry, buckingham_type, coleman_type, lengthwise_sliding
from efficiency.machine_settings.inputs import SettingsInput, load_targets


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


@pytest.mark.fast
@pytest.mark.parametrize("driver", ["pinion", "gear"])
def test_closed_forms_lose_power_with_both_signs(driver: Driver) -> None:
    # spiral angles exchanged: the same lengthwise sliding, friction on the other side of the normal force
    for first, second in ((45.0, 30.0), (30.0, 45.0)):
        pair = PitchGeometry(radians(20.0), radians(first), radians(second), 0.3, 1.2, 0.027, 0.075, 2.6e-3, 1.1)
        lengthwise = lengthwise_sliding(pair, 0.05, driver=driver)
        assert 0.95 < buckingham_type(pair, 0.05, driver) < lengthwise < 1.0
        assert coleman_type(pair, 0.05, driver) == pytest.approx(buckingham_type(pair, 0.05, driver), abs=0.01)
