"""Shipped designs made from targets: the files hold what the targets ask for, and can be made again."""

from dataclasses import replace

import numpy as np
import pytest

from efficiency.blanks.pair import pair_blank
from efficiency.contact.ease_off import conjugate_points, ease_off, pinion_phase
from efficiency.contact.tooth_grid import normal_thickness
from efficiency.design.design import load_design
from efficiency.machine_settings.conjugate import fit_grid, target_relief
from efficiency.machine_settings.gear import pair_dimensions
from efficiency.machine_settings.inputs import load_targets
from efficiency.machine_settings.settings_result import SettingsResult
from efficiency.machine_settings.solve import machine_settings
from ehl.common.data import data_names


@pytest.mark.parametrize("name", data_names("targets"))
def test_design_has_the_wanted_ease_off(name: str) -> None:
    inputs, design = load_targets(name), load_design(name)
    pair = pair_dimensions(replace(pair_blank(inputs.blank), gear_cutting=inputs.cutting.gear))
    grid = fit_grid(pair)
    for side, target in (("drive", inputs.targets.drive), ("coast", inputs.targets.coast)):
        pinion, gear = design.flanks().mating("drive" if side == "drive" else "coast")
        points, found = gear.solve(grid.u, grid.h)
        assert found.all()
        conjugate = conjugate_points(points, design.placement())
        middle = gear.points(points.parameters[:, 67:68])
        phase = pinion_phase(conjugate_points(middle, design.placement()), pinion)
        relief, _, found = ease_off(conjugate, pinion, phase)
        position, normal = conjugate.position, conjugate.normal
        residual = (relief - target_relief(target, grid.x, grid.y))[found]
        arm = (position[0] * normal[1] - position[1] * normal[0])[found]
        residual -= arm * (arm @ residual) / (arm @ arm)
        assert np.sum(~found) <= 4
        assert np.sqrt(np.mean(residual**2)) < 2e-6
        assert np.abs(residual).max() < 9e-6


@pytest.fixture(scope="module")
def result() -> SettingsResult:
    return machine_settings(load_targets("fh_hypoid_9x34"), transmission=False)


def test_design_is_made_again_from_its_targets(result: SettingsResult) -> None:
    shipped = load_design("fh_hypoid_9x34")
    assert result.status == "converged"
    assert result.design.gear == shipped.gear
    assert result.design.pinion.blank == shipped.pinion.blank
    assert result.design.assembly == shipped.assembly
    for side in ("concave", "convex"):
        made, kept = result.design.flank("pinion", side), shipped.flank("pinion", side)
        u, h = (g.ravel() for g in np.meshgrid(np.linspace(-0.01, 0.01, 4), np.linspace(-0.001, 0.005, 4)))
        there, found = kept.solve(u, h)
        here, _ = made.solve(u, h)
        assert found.all()
        # the turn of a flank about its axis is free within the tolerance of the fit
        turned = here.azimuth - there.azimuth
        assert np.abs((turned - turned.mean()) * np.hypot(there.position[0], there.position[1])).max() < 1e-7


def test_undercut_is_named_where_it_is(result: SettingsResult) -> None:
    drive, coast = result.flanks
    # one more or less may lie on either side of the limit
    assert 2 <= len(drive.undercut) <= 4
    assert {point.place for point in drive.undercut} == {"toe, tip of the gear"}
    assert len(coast.undercut) <= 1
    assert np.isnan(drive.residual_map[:, 2]).sum() == len(drive.undercut)


@pytest.mark.parametrize("name", ["fh_hypoid_9x34", "fh_hypoid_9x34_offset_10", "fh_spiral_bevel_12x37"])
def test_blade_phases_leave_the_tooth_that_touching_flanks_and_backlash_ask_for(name: str) -> None:
    design, place = load_design(name), np.zeros(1)
    (one, _), (other, _) = (design.flank("pinion", side).solve(place, place) for side in ("concave", "convex"))
    blank = design.pinion.blank
    angle = (other.azimuth - one.azimuth) % (2.0 * np.pi / blank.teeth)
    spiral = 0.5 * (one.angles(blank.pitch_angle)[0] + other.angles(blank.pitch_angle)[0])
    cut = np.hypot(one.position[0], one.position[1]) * angle * np.cos(spiral)
    # turned until they touch one point of each flank, against the mean of the fit on both: a few micrometres
    assert cut == pytest.approx(normal_thickness(design.flanks(), "pinion", place, place), abs=5e-6)
    assert normal_thickness(design.flanks(), "gear", place, place) == pytest.approx(
        pair_blank(load_targets(name).blank).gear.mean_normal_thickness, abs=1e-8
    )
