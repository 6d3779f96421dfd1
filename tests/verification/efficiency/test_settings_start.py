"""Machine settings against independent computations: conjugate start, derivatives, root line, teeth, backlash."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import newton

from efficiency.blanks.inputs import load_blank
from efficiency.blanks.pair import pair_blank
from efficiency.contact.contact_lines import conjugate_fields
from efficiency.contact.ease_off import conjugate_points, ease_off, pinion_phase
from efficiency.contact.flank_pair import flank_pair
from efficiency.contact.gear_flanks import MEMBERS, SIDES
from efficiency.contact.tooth_grid import normal_thickness, tooth_grid
from efficiency.cutting.cutter import FLANK_SIDES
from efficiency.design.design import load_design
from efficiency.machine_settings.conjugate import conjugate_start, fit_grid, target_flank, target_relief
from efficiency.machine_settings.fit import FitParameter, _derivatives, measure, with_setting
from efficiency.machine_settings.gear import PairDimensions, cut_gear, pair_dimensions
from efficiency.machine_settings.generating import free_axis, tilt_and_swivel
from efficiency.machine_settings.inputs import load_targets
from efficiency.machine_settings.solve import machine_settings
from ehl.common.data import data_names


def geometry(name: str, generated: bool, left_hand_gear: bool = False) -> PairDimensions:
    inputs = load_blank(name)
    if left_hand_gear:
        inputs = inputs.model_copy(update={"hand_pinion": "right", "hand_gear": "left"})
    return pair_dimensions(replace(pair_blank(inputs), gear_cutting="generated" if generated else "formate"))


@pytest.mark.parametrize("generated", [False, True])
@pytest.mark.parametrize(
    ("name", "left_hand_gear"),
    [
        ("fh_hypoid_9x34", False), ("fh_hypoid_9x34", True), ("fm_hypoid_13x42", False),
        ("fh_spiral_bevel_12x37", True), ("iso23509_f2", False),
    ],
)  # fmt: skip
def test_the_mirrored_gear_cutter_cuts_the_conjugate_pinion(name: str, generated: bool, left_hand_gear: bool) -> None:
    pair = geometry(name, generated, left_hand_gear)
    gear = cut_gear(pair)
    grid = fit_grid(pair, 0.1, (5, 4))
    for side in FLANK_SIDES:
        start = conjugate_start(pair, gear, side, grid)
        assert start.error < 1e-13
        condition = start.flank.sweep(start.parameters)[2]
        assert np.abs(condition).max() < 1e-12


def test_formate_gear_has_the_angles_of_its_blank() -> None:
    for name in ("fh_hypoid_9x34", "fm_hypoid_13x42"):
        pair = geometry(name, False)
        gear = cut_gear(pair)
        spirals = []
        for side in FLANK_SIDES:
            points, _ = gear.flank(side).solve(np.array([pair.calculation_gear]), np.zeros(1))
            spiral, pressure = points.angles(pair.gear.pitch_angle)
            spirals.append(float(spiral[0]))
            assert float(pressure[0]) == pytest.approx(pair.pressure(side), abs=1e-9)
        assert np.mean(spirals) == pytest.approx(pair.blank.gear.mean_spiral_angle, abs=1e-9)


def test_derivatives_of_the_residual_by_settings_against_differences() -> None:
    pair = geometry("fh_hypoid_9x34", False)
    gear = cut_gear(pair)
    start = conjugate_start(pair, gear, "convex", fit_grid(pair, 0.1, (5, 4)))
    wanted = target_flank(pair, start, np.zeros(20), 0.02)
    now = measure(wanted, wanted.flank, wanted.phase, wanted.parameters)
    machine = {"axis_x": 0.01, "roll_ratio": 0.02, "blank_offset": 1e-3, "modified_roll_2c": 0.01}
    parameters = [FitParameter("machine", name, scale) for name, scale in machine.items()]
    parameters += [FitParameter("blade", name, scale) for name, scale in (("blade_angle", 0.01), ("curvature", 1.0))]
    parameters.append(FitParameter("phase", "phase", 0.01))
    exact = _derivatives(wanted, now, parameters, True)
    for k, parameter in enumerate(parameters):
        rows = []
        for step in (1e-4 * parameter.scale, -1e-4 * parameter.scale):
            flank, phase = wanted.flank, wanted.phase
            if parameter.part == "phase":
                phase += step
            else:
                flank = with_setting(flank, parameter, getattr(getattr(flank, parameter.part), parameter.name) + step)
            moved = measure(wanted, flank, phase, now.parameters, now.root)
            rows.append(np.concatenate([moved.relief, moved.root_error]))
        difference = (rows[0] - rows[1]) / 2e-4
        np.testing.assert_allclose(exact[:, k], difference, rtol=0.0, atol=2e-6 * np.abs(difference).max())


def test_free_axis_is_the_same_flank() -> None:
    pair = geometry("fh_hypoid_9x34", False)
    start = conjugate_start(pair, cut_gear(pair), "concave", fit_grid(pair, 0.1, (5, 4)))
    flank, parameters = free_axis(start.flank, start.parameters)
    np.testing.assert_allclose(flank.sweep(parameters)[0], start.flank.sweep(start.parameters)[0], atol=1e-15)
    back = tilt_and_swivel(flank)
    assert back.machine.tilt == pytest.approx(start.flank.machine.tilt, abs=1e-12)
    np.testing.assert_allclose(back.sweep(start.parameters)[0], start.flank.sweep(start.parameters)[0], atol=1e-14)


def test_root_line_is_the_lowest_point_of_the_tip() -> None:
    pair = geometry("fm_hypoid_13x42", False)
    start = conjugate_start(pair, cut_gear(pair), "concave", fit_grid(pair, 0.1, (5, 4)))
    wanted = target_flank(pair, start, np.zeros(20), 0.02)
    flank, root = wanted.flank, wanted.root
    state = root.cut(flank)

    def place(angle: float, phi: float) -> np.ndarray:
        point = flank.sweep(np.array([[0.0], [angle], [phi]]))[0]
        return np.real(flank.blank.coordinates(np.hypot(point[0], point[1]), point[2]))[:, 0]

    for k, near in enumerate(state.parameters.T):
        heights = []
        # the cradle roll is scanned around the solution
        for phi in near[1] + np.linspace(-0.01, 0.01, 21):
            start = {"x0": near[0], "x1": near[0] + 1e-6, "tol": 1e-12}
            angle = newton(lambda angle, phi=phi, k=k: place(angle, phi)[0] - root.u[k], **start)
            heights.append(place(angle, phi)[1] - root.height[k])
        assert 0 < np.argmin(heights) < 20
        assert state.error[k] == pytest.approx(min(heights), abs=1e-9)


@pytest.mark.parametrize("name", data_names("targets"))
def test_design_has_the_wanted_ease_off(name: str) -> None:
    inputs, design = load_targets(name), load_design(name)
    pair = pair_dimensions(replace(pair_blank(inputs.blank), gear_cutting=inputs.cutting.gear))
    grid = fit_grid(pair)
    for side in SIDES:
        pinion, gear = design.flanks().mating(side)
        points, found = gear.solve(grid.u, grid.h)
        assert found.all()
        conjugate = conjugate_points(points, design.placement())
        middle = gear.points(points.parameters[:, 67:68])
        phase = pinion_phase(conjugate_points(middle, design.placement()), pinion)
        relief, _, found = ease_off(conjugate, pinion, phase)
        position, normal = conjugate.position, conjugate.normal
        residual = (relief - target_relief(getattr(inputs.targets, side), grid.x, grid.y))[found]
        arm = (position[0] * normal[1] - position[1] * normal[0])[found]
        residual -= arm * (arm @ residual) / (arm @ arm)
        assert np.sum(~found) <= 4
        assert np.sqrt(np.mean(residual**2)) < 2e-6
        assert np.abs(residual).max() < 9e-6


def test_design_is_made_again_from_its_targets() -> None:
    result = machine_settings(load_targets("fh_hypoid_9x34"), transmission=False)
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
    wanted = pair_blank(load_targets(name).blank).gear.mean_normal_thickness
    assert normal_thickness(design.flanks(), "gear", place, place) == pytest.approx(wanted, abs=1e-8)


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
    cutting = inputs.cutting.model_copy(update={"pinion": "conjugate"})
    update = {"cutting": cutting, "targets": inputs.targets.model_copy(update=wanted)}
    design = machine_settings(inputs.model_copy(update=update), transmission=False).design
    blank = pair_blank(inputs.blank.model_copy(update={"gear_cutting": inputs.cutting.gear}))
    for member in MEMBERS:
        own = getattr(blank, member)
        found = normal_thickness(design.flanks(), member, np.array([-own.middle_shift]), np.zeros(1))[0]
        assert found == pytest.approx(own.mean_normal_thickness, abs=1e-6)
