"""Blanks of a pair against geometry in space, and properties every blank has."""

import math
from math import cos, hypot, pi, sin, tan
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar
from twins.random_blanks import blank_content, run_case

from efficiency.blanks.inputs import PairBlankInput, load_blank
from efficiency.blanks.lengthwise import tooth_trace
from efficiency.blanks.method_1 import lengthwise_radius
from efficiency.blanks.pair import pair_blank, pitch_cones
from efficiency.blanks.pair_blank import PairBlank
from ehl.common.errors import InputError

SAMPLES = ("iso23509_f2", "iso23509_f3", "iso23509_f4", "iso23509_f5")


def blank(name: str, **changes: Any) -> PairBlank:
    return pair_blank(load_blank(name).model_copy(update={"pitch_cones": "converged", **changes}))


@st.composite
def inputs(draw: st.DrawFn, methods: tuple[int, ...] = (0, 1, 2, 3)) -> PairBlankInput:
    """Sensible pairs of all methods and processes, with offsets of both signs."""
    content = blank_content(3, draw(st.integers(0, 500)))
    assume(content["method"] in methods)
    if draw(st.sampled_from([False, False, True])):
        content["hypoid_offset"] *= -1.0
        if content["method"] == 1:  # the pinion's spiral angle is the smaller one then
            content["mean_spiral_angle_pinion"] *= 0.6
    return PairBlankInput.model_validate(content)


def drawn_blank(drawn: PairBlankInput) -> PairBlank:
    try:
        return pair_blank(drawn)
    except InputError:
        assume(False)
        raise


def mean_point(pair: PairBlank) -> np.ndarray:
    """Calculation point in the frame of the gear: axis z, pinion axis (sin Sigma, 0, cos Sigma) through (0, a, 0)."""
    r, zeta = 0.5 * pair.gear.mean_diameter, pair.offset_angle
    return np.array([r * cos(zeta), r * sin(zeta), pair.gear.crossing_to_mean_point])


@settings(max_examples=60, deadline=None)
@given(inputs())
def test_pitch_cones_touch_in_space(drawn: PairBlankInput) -> None:
    pair = drawn_blank(drawn)
    pinion, gear, size = pair.pinion, pair.gear, pair.gear.outer_diameter
    axis = np.array([sin(pair.shaft_angle), 0.0, cos(pair.shaft_angle)])
    point = mean_point(pair) - np.array([0.0, pair.hypoid_offset, 0.0])
    along = float(point @ axis)
    radial = point - along * axis
    assert along == pytest.approx(pinion.crossing_to_mean_point, abs=1e-12 * size)
    assert 2.0 * np.linalg.norm(radial) == pytest.approx(pinion.mean_diameter, rel=1e-11)
    normal_1 = cos(pinion.pitch_angle) * radial / np.linalg.norm(radial) - sin(pinion.pitch_angle) * axis
    zeta = pair.offset_angle
    normal_2 = np.array([cos(gear.pitch_angle) * cos(zeta), cos(gear.pitch_angle) * sin(zeta), -sin(gear.pitch_angle)])
    assert normal_1 == pytest.approx(-normal_2, abs=1e-10)
    # elements of both cones, from the apexes on the axes, include the difference of the spiral angles
    apex_2 = np.array([0.0, 0.0, -gear.pitch_apex_beyond_crossing])
    apex_1 = -pinion.pitch_apex_beyond_crossing * axis + np.array([0.0, pair.hypoid_offset, 0.0])
    elements = [mean_point(pair) - apex for apex in (apex_1, apex_2)]
    lengths = [pinion.mean_cone_distance, gear.mean_cone_distance]
    assert [np.linalg.norm(e) for e in elements] == pytest.approx(lengths, rel=1e-10)
    between = float(elements[0] @ elements[1]) / math.prod(lengths)
    difference = pinion.mean_spiral_angle - gear.mean_spiral_angle
    assert between == pytest.approx(cos(difference), abs=1e-10)
    # in this frame, that of a left-hand pinion, the bodies slide along the tooth: signed spiral angles of both elements
    arms = mean_point(pair) - np.array([[0.0, pair.hypoid_offset, 0.0], [0.0, 0.0, 0.0]])
    sliding = np.cross(axis, arms[0]) + np.cross([0.0, 0.0, pinion.teeth / gear.teeth], arms[1])
    assume(np.linalg.norm(sliding) > 1e-9 * size)
    for element, member in zip(elements, (pinion, gear), strict=True):
        across = float(np.cross(sliding, element) @ normal_2)
        along = float(element @ sliding)
        assert math.remainder(math.atan2(across, along) - member.mean_spiral_angle, pi) == pytest.approx(0.0, abs=1e-8)
    # equal normal modules and the common tooth direction: no sliding across the tooth in the pitch plane
    for member in (pinion, gear):
        module = member.mean_diameter / member.teeth * cos(member.mean_spiral_angle)
        assert module == pytest.approx(pair.module_normal, rel=1e-10)
    assert pair.tangency_error == pytest.approx(0.0, abs=1e-10)


@settings(max_examples=25, deadline=None)
@given(inputs())
def test_tips_keep_the_clearance_from_the_opposite_root(drawn: PairBlankInput) -> None:
    # gap between the face cone of the pinion and the root cone of the gear, smallest over both: the clearance
    pair = drawn_blank(drawn)
    pinion, gear = pair.pinion, pair.gear
    axis = np.array([sin(pair.shaft_angle), 0.0, cos(pair.shaft_angle)])

    def smallest_gap(tip_angle: float, tip_apex: float, root_angle: float, root_apex: float) -> float:
        ax, ay, az = np.array([0.0, pair.hypoid_offset, 0.0]) - tip_apex * axis

        def height(turn: float, s: float) -> float:
            # over the gear's root cone, of the point of the pinion's face cone at cone distance s and azimuth turn
            t, r = s * cos(tip_angle), s * sin(tip_angle)
            x = ax + t * axis[0] - r * cos(turn) * cos(pair.shaft_angle)
            y = ay + r * sin(turn)
            z = az + t * axis[2] + r * cos(turn) * sin(pair.shaft_angle)
            return hypot(x, y) * cos(root_angle) - (z + root_apex) * sin(root_angle)

        def ring(s: float) -> float:
            found = minimize_scalar(height, bounds=(-1.5, 1.5), args=(s,), method="bounded", options={"xatol": 1e-8})
            return float(found.fun)

        cone = pair.pinion.mean_cone_distance
        found = minimize_scalar(ring, bounds=(0.3 * cone, 1.7 * cone), method="bounded", options={"xatol": 1e-5 * cone})
        return float(found.fun)

    pairs = (
        (pinion.face_angle, pinion.face_apex_beyond_crossing, gear.root_angle, gear.root_apex_beyond_crossing),
        (pinion.root_angle, pinion.root_apex_beyond_crossing, gear.face_angle, gear.face_apex_beyond_crossing),
    )
    for cones in pairs:
        assert smallest_gap(*cones) == pytest.approx(pair.clearance, abs=1e-8 * gear.outer_diameter)


def test_lengthwise_radius_is_the_curvature_of_the_drawn_epicycloid() -> None:
    # the trace in polar coordinates of the gear apex: dphi/dR = tan beta/R; curvature from finite differences
    pair = blank("iso23509_f5")
    inputs = load_blank("iso23509_f5").model_copy(update={"pitch_cones": "converged"})
    cones = pitch_cones(inputs)
    trace = tooth_trace(inputs, cones)
    mean = cones.cone_distance[1]
    # angle of the tangent against a fixed direction: phi + beta; arc length ds = dR/cos beta
    step = 1e-4 * mean
    slopes = [trace.spiral(mean + s) for s in (-step, step)]
    turn = (slopes[1] - slopes[0]) / (2.0 * step) + tan(cones.spiral[1]) / mean
    assert 1.0 / (turn * cos(cones.spiral[1])) == pytest.approx(lengthwise_radius(inputs, cones), rel=1e-6)
    assert pair.epicycloid_base_radius < pair.crown_to_cutter


@pytest.mark.parametrize("name", ["iso23509_f3", "iso23509_f4"])
def test_spiral_angles_against_the_motion_of_a_blade(name: str) -> None:
    # developed gear cone: the cutter turns once while z0 of its z2/sin(delta2) crown teeth pass, in the other sense
    inputs = load_blank(name)
    cones = pitch_cones(inputs)
    trace = tooth_trace(inputs, cones)
    turns = (inputs.blade_groups or 0) * sin(cones.pitch_angle[1]) / inputs.teeth_gear
    for cone in cones.cone_distance[1] * np.array([0.85, 0.95, 1.0, 1.1, 1.15]):
        q = trace.generating_angle(cone)
        x, y = cone * cos(q), cone * sin(q)
        assert hypot(x - trace.crown_to_cutter, y) == pytest.approx(inputs.cutter_radius, rel=1e-12)
        u, v = -(y + turns * y), (x - trace.crown_to_cutter) + turns * x
        radial = (u * x + v * y) / (cone * hypot(u, v))
        assert abs(radial) == pytest.approx(cos(trace.spiral(cone)), abs=1e-12)


@pytest.mark.parametrize("name", ["iso23509_f3", "iso23509_f4", "iso23509_f5"])
def test_without_offset_all_methods_are_the_bevel_pair(name: str) -> None:
    bevel = blank(name, hypoid_offset=0.0)
    near, above = blank(name, hypoid_offset=1e-8), blank(name, hypoid_offset=-1e-8)
    assert bevel.pinion.pitch_angle + bevel.gear.pitch_angle == pytest.approx(bevel.shaft_angle, abs=1e-14)
    assert bevel.pinion.mean_cone_distance == pytest.approx(bevel.gear.mean_cone_distance, rel=1e-14)
    pairs = ((bevel.pinion, near.pinion), (bevel.gear, near.gear), (bevel.pinion, above.pinion))
    for member, other in pairs:
        assert other.pitch_angle == pytest.approx(member.pitch_angle, abs=1e-6)
        assert other.mean_cone_distance == pytest.approx(member.mean_cone_distance, rel=1e-5)
        assert other.pitch_apex_beyond_crossing == pytest.approx(0.0, abs=1e-6)
        assert other.outer_tip_diameter == pytest.approx(member.outer_tip_diameter, rel=0.03)


def test_middle_of_the_face_and_calculation_point_describe_the_same_cones() -> None:
    for name in SAMPLES:
        pair = blank(name)
        for member in (pair.pinion, pair.gear):
            cones = member.cones
            half = np.array([-0.5, 0.5]) * cones.face_width
            radius, z = cones.axial(half, cones.tip(half))
            assert 2.0 * radius == pytest.approx([member.inner_tip_diameter, member.outer_tip_diameter], rel=1e-12)
            assert z == pytest.approx([member.crossing_to_front_crown, member.crossing_to_crown], rel=1e-12)
            radius, _ = cones.axial(half, cones.root(half))
            assert 2.0 * radius == pytest.approx([member.inner_root_diameter, member.outer_root_diameter], rel=1e-12)


def test_blanks_are_answered_or_refused_by_a_listed_reason() -> None:
    rows = [run_case(2, index, "blank") for index in range(300)]
    assert [row["detail"] for row in rows if row["outcome"] == "wrong"] == []
    assert sum(row["outcome"] == "answered" for row in rows) >= 0.98 * len(rows)
