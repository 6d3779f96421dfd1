"""Misalignment study and contact pattern: values, files, figures, command."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from refusals import refuses
from samples import BEVEL

import efficiency
from efficiency.contact.contact_lines import mesh_cycle
from efficiency.contact.contact_search import contact_path
from efficiency.contact.flank_pair import FlankPair, flank_pair
from efficiency.contact.relief import FlankDeviation, flank_tolerances
from efficiency.design.design import load_design
from efficiency.geometry.misalignment import MisalignmentGrid, MisalignmentStudy, misalignment_study
from efficiency.output.misalignment_report import map_figure, section_contacts, section_points


@pytest.fixture(scope="module")
def study() -> MisalignmentStudy:
    return misalignment_study(BEVEL, E=[-1e-4, 0.0, 2e-4], P=[0.0, 5e-5])


@pytest.fixture(scope="module")
def pair() -> FlankPair:
    return flank_pair(BEVEL.flanks())


def test_points_of_the_study_are_those_of_single_pairs(study: MisalignmentStudy, tmp_path: Path) -> None:
    assert [(p.E, p.P) for p in study.points] == [(e, p) for e in (-1e-4, 0.0, 2e-4) for p in (0.0, 5e-5)]
    for point in study.points[::2]:
        alone = flank_pair(BEVEL.with_misalignment(E=point.E, P=point.P).flanks())
        assert point.peak_to_peak == pytest.approx(alone.transmission.peak_to_peak, rel=1e-4)
        assert point.error_maximum_u == pytest.approx(alone.surface.error_maximum[0], abs=1e-7)
        assert point.pattern_area == pytest.approx(alone.pattern().area_share, abs=2e-3)
        assert point.edges == ", ".join(alone.transmission.edges)
    assert study.varied == ["E", "P"]
    # the contact walks along the face with the offset
    along = [point for point in study.points if point.P == 0.0]
    assert (np.diff([point.error_maximum_u for point in along]) < 0.0).all()
    assert (np.diff([point.pattern_u for point in along]) < 0.0).all()
    assert [point.status for point in along[1:]] == ["converged", "edge contact"]
    assert json.dumps(study.to_dict(), allow_nan=False)
    frame = pd.read_csv(MisalignmentGrid(BEVEL, (study,)).report(tmp_path / "study.csv"))
    np.testing.assert_allclose(frame["peak_to_peak [rad]"], [p.peak_to_peak for p in study.points], rtol=1e-12)


def test_pattern_is_where_the_flanks_come_close(pair: FlankPair) -> None:
    """The separation of the pattern against the gaps of the contact lines at their positions."""
    pattern = pair.pattern(8e-6)
    assert pattern.marked.any()
    assert pattern.centre[0] == pytest.approx(pair.surface.error_maximum[0], abs=1.5e-3)
    assert 0.0 < pattern.width <= 1.0
    assert (pattern.separation[pattern.inside] >= 0.0).all()
    surface = pair.surface
    for position in mesh_cycle(pair.surface, positions=3, points_per_line=9):
        u = position.face_gear - 0.5 * surface.gear.blank.face_width
        v = surface.gear.blank.fraction(u, position.height_gear + surface.gear.blank.root(u))
        relief, lever = surface.patch(u, v, ("ease_off", "lever"))
        turned = pair.transmission.at(np.full(1, position.pinion_angle))[0]
        # counted from the closest of the points, not from the closest place
        difference = relief + lever * turned - position.gap
        assert np.abs(difference).max() < 0.4e-6


def test_pattern_grows_with_the_marking_and_lies_around_the_path(pair: FlankPair) -> None:
    thin, thick = pair.pattern(2e-6), pair.pattern(12e-6)
    assert 0.0 < thin.area_share < thick.area_share < 1.0
    assert thin.length < thick.length
    assert (thick.marked | ~thin.marked).all()
    path = contact_path(pair.surface, pair.surface.error_maximum_roll + np.linspace(-0.3, 0.3, 5) * pair.surface.pitch)
    for u, h in zip(path.u, path.height, strict=True):
        near = np.argmin((thin.gear_u - u) ** 2 + (thin.gear_height - h) ** 2)
        assert thin.marked.ravel()[near]
    # the same points on the pinion: toe to toe, tip to root
    assert np.corrcoef(thin.gear_u.ravel(), thin.pinion_u.ravel())[0, 1] > 0.9
    assert np.corrcoef(thin.gear_height.ravel(), thin.pinion_height.ravel())[0, 1] < -0.9
    # a pinion far too high in the mesh runs on the tip of the gear
    moved = flank_pair(BEVEL.with_misalignment(E=2e-4).flanks())
    assert (pair.transmission.edges, moved.transmission.edges) == ((), ("gear tip",))
    assert "gear tip" in moved.pattern().edges


def test_random_states_have_the_given_deviations_and_a_distribution() -> None:
    study = misalignment_study(BEVEL, E=[5e-5], shaft_angle_error=[2e-4], samples=8)
    states = np.array([[point.E, point.P, point.shaft_angle_error] for point in study.points])
    assert states.shape == (8, 3)
    assert states[:, 1].tolist() == [0.0] * 8
    assert states[:, 0].std() == pytest.approx(5e-5, rel=0.3)
    assert states[:, 2].std() == pytest.approx(2e-4, rel=0.3)
    mean, deviation, low, middle, high = study.distribution()["peak_to_peak"]
    errors = [point.peak_to_peak for point in study.points]
    assert (mean, deviation) == pytest.approx((np.mean(errors), np.std(errors, ddof=1)))
    assert min(errors) <= low < middle < high <= max(errors)
    again = misalignment_study(BEVEL, E=[5e-5], shaft_angle_error=[2e-4], samples=8)
    assert [point.E for point in again.points] == [point.E for point in study.points]
    for wrong, random in (([0.0, 5e-5], {"samples": 8}), ([-5e-5], {"samples": 8}), ([], {})):
        with refuses("E"):
            misalignment_study(BEVEL, E=wrong, **random)
    with refuses("assembly.misalignment.E"):
        misalignment_study(BEVEL, E=[5e-3])
    with refuses("samples"):
        efficiency.GearPair(BEVEL).misalignment(E="0.05 mm", samples=1)


def test_random_flanks_have_the_deviations_of_their_grade() -> None:
    study = misalignment_study(BEVEL, E=[2e-5], samples=16, accuracy_grade=7)
    made = np.array([list(point.deviation.model_dump().values()) for point in study.points])
    assert made.std(axis=0) == pytest.approx(list(study.tolerances.model_dump().values()), rel=0.3)
    pair = efficiency.GearPair(BEVEL)
    for wrong in ({"samples": 4, "accuracy_grade": 12}, {"E": "0.02 mm", "accuracy_grade": 6}):
        with refuses("accuracy_grade"):
            pair.misalignment(**wrong)
    stated = BEVEL.with_deviation(FlankDeviation(lengthwise_crowning=2e-5))
    shorter, usual = (flank_pair(d.flanks()).pattern().length for d in (stated, BEVEL))
    assert shorter < usual


def test_blade_angle_error_is_a_profile_slope() -> None:
    """The blade angle of a Formate gear with teeth of uniform depth: ease-off within 4 % of the slope."""
    design, turn = load_design("fh_hypoid_9x34"), 3e-4
    gear = design.gear
    blade = gear.convex.cutter.model_copy(update={"blade_angle": gear.convex.cutter.blade_angle + turn})
    cut = gear.model_copy(update={"convex": gear.convex.model_copy(update={"cutter": blade})})
    slope = turn * (gear.blank.mean_addendum + gear.blank.mean_dedendum) / np.cos(blade.blade_angle)
    stated = design.with_deviation(FlankDeviation(profile_slope=slope))
    pairs = [design, design.model_copy(update={"gear": cut}), stated]
    face, share = np.meshgrid(np.linspace(-0.4, 0.4, 9) * gear.blank.face_width, np.linspace(0.4, 0.95, 7))
    place = face.ravel(), share.ravel()
    maps = [flank_pair(each.flanks()).surface.patch(*place, ("ease_off", "lever")) for each in pairs]
    lever = maps[0][1]
    # apart from a rotation about the axis, which the contact removes
    one, other = (x[0] - maps[0][0] - lever * (lever @ (x[0] - maps[0][0])) / (lever @ lever) for x in maps[1:])
    assert np.ptp(one) > 1.4e-6
    assert np.abs(one - other).max() < 0.04 * slope


@pytest.mark.usefixtures("commands_alone")
def test_tolerance_of_a_pair_on_the_command_line(mixed_ehl: Any) -> None:
    options = ("--samples=2", "--accuracy-grade=6", "--torque=300 N m", "--friction=constant:0.05")
    [study] = json.loads(mixed_ehl("misalignment", BEVEL.name, *options, "--json").out)["studies"]
    assert 0.9 < study["distribution"]["efficiency"][0] < 1.0


def test_sections_and_figures_pass_through_the_aligned_pair(study: MisalignmentStudy) -> None:
    values, points = section_points(study, "E")
    np.testing.assert_allclose(values, [-0.1, 0.0, 0.2], atol=1e-12)
    assert all(point.P == 0.0 for point in points)
    expected = np.degrees([point.peak_to_peak for point in points]) * 3600.0
    shown = np.asarray(map_figure(study).axes[0].collections[0].get_array()).reshape(2, 3)
    assert shown[0, 1] == pytest.approx(expected[1])
    contacts = section_contacts(BEVEL, study, "E")
    assert [value for value, _, _ in contacts] == [-1e-4, 0.0, 2e-4]
    for (_, _, pattern), point in zip(contacts, points, strict=True):
        assert pattern.area_share == pytest.approx(point.pattern_area, rel=1e-9)


def test_states_at_a_torque_are_those_of_the_loaded_pair(mixed_ehl: Any) -> None:
    """The V-H check under load: same numbers as the pair set up in that state, next to the unloaded ones."""
    options = ("--torque", "300 N m", "--friction", "constant:0.05", "--speed", "1500 rpm")
    outcome = mixed_ehl("misalignment", BEVEL.name, "--E", "-0.1:0.1:2 mm", *options, "--json")
    (found,) = json.loads(outcome.out)["studies"]
    assert found["E"] == pytest.approx([-1e-4, 1e-4])
    pair = efficiency.GearPair(BEVEL)
    for point in found["points"]:
        result = pair.mesh("drive", E=point["E"]).load("300 N m").efficiency("constant:0.05", speed="1500 rpm")
        for name in ("efficiency", "pressure_hertz_max", "edge_load_share", "transmission_error_loaded", "power_loss"):
            assert point[name] == pytest.approx(result.value(name), rel=1e-9)
        assert 0.3 < point["transmission_error_loaded"] / point["peak_to_peak"] < 1.0
    # the offset moves the load along the face
    assert found["points"][0]["load_centre_u"] - found["points"][1]["load_centre_u"] > 1e-3


@pytest.mark.parametrize("grade", [5, 6])
def test_two_standard_deviations_are_the_tolerance(grade: int) -> None:
    """Slope: range of the deviation; form: its band about the mean line. Root of the sum of squares of both members."""
    design, module = load_design("fh_hypoid_9x34"), 4.0
    blanks = design.pinion.blank, design.gear.blank
    # ISO 1328-1:2013, um, of module, reference diameter and face width in mm
    laws: dict[str, Callable[[float, float], float]] = {
        "profile_slope": lambda d, b: 0.4 * module + 0.001 * d + 4.0,
        "profile_crowning": lambda d, b: 0.55 * module + 5.0,
        "lengthwise_slope": lambda d, b: 0.05 * math.sqrt(d) + 0.35 * math.sqrt(b) + 4.0,
        "lengthwise_crowning": lambda d, b: 0.07 * math.sqrt(d) + 0.45 * math.sqrt(b) + 4.0,
    }
    laws["twist"] = laws["lengthwise_crowning"]
    sizes = [(2e3 * x.mean_cone_distance * math.sin(x.pitch_angle), 1e3 * x.face_width) for x in blanks]
    sigma = flank_tolerances(grade, 1e-3 * module, *blanks).model_dump()
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, 21) * blanks[1].face_width, np.linspace(0.0, 1.0, 21))
    plane = np.stack([np.ones(u.size), u.ravel() / blanks[1].face_width, v.ravel()], axis=1)
    for name, law in laws.items():
        depth = FlankDeviation(**{name: 2.0 * sigma[name]}).depth(blanks[1], u, v).ravel()
        mean = 0.0 if name.endswith("slope") else plane @ np.linalg.lstsq(plane, depth, rcond=None)[0]
        allowed = math.sqrt(2.0) ** (grade - 5) * math.hypot(*(law(*size) for size in sizes))
        assert 1e6 * np.ptp(depth - mean) == pytest.approx(allowed, rel=1e-9)
