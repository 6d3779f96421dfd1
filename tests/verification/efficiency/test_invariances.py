"""What must not change: a pair of another size, the mirror image for offsets of both signs."""

from math import radians
from typing import Any

import numpy as np
import pytest
from rebuilt_designs import rebuilt

import efficiency
from efficiency.contact.flank_pair import flank_pair
from efficiency.design.design import load_design
from efficiency.machine_settings.inputs import SettingsInput, load_targets
from efficiency.mesh import Mesh

NAMES = ("fh_hypoid_9x34", "fm_spiral_bevel_14x39")
POWERS = {"m": 1, "1/m": -1, "m^2": 2, "1/m^2": -2, "1/m^3": -3}  # of the length, by unit


def scaled(factor: float) -> Any:
    def change(unit: str | None, name: str, value: Any) -> Any:
        return value * factor ** POWERS.get(unit or "", 0) if isinstance(value, float) else value

    return change


@pytest.mark.parametrize("name", NAMES)
def test_a_pair_of_twice_the_size_has_the_same_pressure_and_efficiency(name: str) -> None:
    """Pressures stay where the torque grows with the cube of the lengths; 1e-4 is seen under load."""
    design = load_design(name)
    larger = rebuilt(design, scaled(2.0))
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
