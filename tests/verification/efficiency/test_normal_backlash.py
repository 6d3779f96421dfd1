"""Backlash normal to the flanks: play of the exported teeth, and thickness of conjugate teeth after ISO 23509."""

import numpy as np
import pytest

from efficiency.blanks.pair import pair_blank
from efficiency.contact.contact_lines import conjugate_fields
from efficiency.contact.flank_pair import flank_pair
from efficiency.contact.gear_flanks import MEMBERS, SIDES
from efficiency.contact.tooth_grid import normal_thickness, tooth_grid
from efficiency.design.design import load_design
from efficiency.machine_settings.inputs import load_targets
from efficiency.machine_settings.solve import machine_settings


@pytest.mark.parametrize(
    "name", ["fh_spiral_bevel_12x37", "fm_hypoid_13x42", "fh_hypoid_9x34", "fm_spiral_bevel_14x39_relieved"]
)
def test_play_of_the_exported_teeth_is_the_normal_backlash(name: str) -> None:
    """Rotation of each exported pinion flank from its first contact, times its lever at the highest point."""
    flanks = load_design(name).flanks()
    grid, play = tooth_grid(flanks, "pinion", 21, 21), 0.0
    for side in SIDES:
        surface = flank_pair(flanks, side).surface
        azimuth = (grid.lower, grid.upper)[grid.sides.index(surface.pinion.side)]
        points, found = surface.pinion.solve(grid.u[15, 10:11], grid.height[15, 10:11])
        assert found.all()
        turned = azimuth[15, 10] + grid.middle - points.azimuth[0] - surface.phase
        u, depth = (np.array([x]) for x in surface.error_maximum)
        lever = conjugate_fields(surface, u, depth, np.ones(1))["lever_pinion"][0]
        play += float(abs(np.angle(np.exp(1j * turned))) * lever)
    # the lever differs by 2 % between the mean point and the highest point
    assert play == pytest.approx(flanks.normal_backlash, rel=0.02)


@pytest.mark.parametrize("name", ["fh_spiral_bevel_12x37", "fh_hypoid_9x34_relieved", "fm_spiral_bevel_14x39_relieved"])
def test_conjugate_teeth_have_the_thickness_of_iso_23509(name: str) -> None:
    """Without ease-off, at the calculation point; a thickness reduced by j_mn itself would be 7 to 10 um larger."""
    inputs = load_targets(name)
    none = dict.fromkeys(("crowning_toe", "crowning_heel", "relief_root", "relief_tip"), 0.0)
    wanted = {str(side): getattr(inputs.targets, side).model_copy(update=none) for side in SIDES}
    update = {
        "cutting": inputs.cutting.model_copy(update={"pinion": "conjugate"}),
        "targets": inputs.targets.model_copy(update=wanted),
    }
    design = machine_settings(inputs.model_copy(update=update), transmission=False).design
    blank = pair_blank(inputs.blank.model_copy(update={"gear_cutting": inputs.cutting.gear}))
    for member in MEMBERS:
        own = getattr(blank, member)
        found = normal_thickness(design.flanks(), member, np.array([-own.middle_shift]), np.zeros(1))[0]
        assert found == pytest.approx(own.mean_normal_thickness, abs=1e-6)
