"""Edge, blade, machine and the flank they cut, each for itself."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference_flanks import hobbed_pinion
from samples import GEAR_BLANK as BLANK

from efficiency.cutting.cutter import Blade, Protuberance, Relief
from efficiency.cutting.flank import CutFlank, Flank, index_start
from efficiency.cutting.machine import FORMATE, GENERATED, MachineSettings

MACHINE = MachineSettings(
    radial_setting=0.095, cradle_angle=1.2, machine_root_angle=1.1, roll_ratio=1.05, tilt=0.2, swivel=-0.4,
    blank_offset=0.003, sliding_base=0.002, machine_centre_to_back=-0.001,
    modified_roll_2c=0.02, modified_roll_6d=-0.03, modified_roll_24e=0.05, modified_roll_120f=-0.07,
    modified_roll_720g=0.11, helical_motion_1=0.004, helical_motion_2=0.001, helical_motion_3=0.002,
    vertical_motion_1=-0.002, vertical_motion_2=0.003, vertical_motion_3=-0.001,
)  # fmt: skip
HOB = replace(hobbed_pinion("concave").blade, phase=0.1, rake=0.2, hook=0.1)
RELIEFS = {"toprem": Relief(height=0.002, radius=0.02, angle=0.05), "flankrem": Relief(height=0.006, radius=0.1)}
BLADES = {
    "straight mill": Blade(0.1, 0.35, "concave"),
    "curved mill": Blade(0.1, 0.35, "convex", 2.0, reference_height=0.004, edge_radius=0.001),
    "hob": HOB,
    "relieved hob": replace(HOB, side="convex", **RELIEFS),
    "fillet": Blade(0.1, 0.35, "concave", edge_radius=0.001, part="fillet"),
}


def parameters(seed: int = 1, count: int = 7) -> np.ndarray:
    draw = np.random.default_rng(seed).uniform
    return np.stack([draw(-0.0005, 0.009, count), draw(-1.0, 1.0, count), draw(-0.3, 0.3, count)])


@given(st.floats(-0.0127, 0.0127), st.floats(-0.006, 0.002), st.floats(-0.02, 0.02))
def test_blank_coordinates_round_trip(u: float, h: float, apex: float) -> None:
    blank = BLANK.model_copy(update={"pitch_apex_beyond_crossing": apex})
    back = blank.coordinates(*blank.axial(np.array([u]), np.array([h])))
    np.testing.assert_allclose(np.real(back)[:, 0], [u, h], atol=1e-15)


def test_work_turns_and_shifts_as_the_trade_names_say() -> None:
    """2C/2, 6D/6, 24E/24, 120F/120, 720G/720 and the Taylor polynomials of the motions, written out."""
    m, phi = MACHINE, np.array([0.13, -0.21, 0.0])
    pose = m.at(phi)
    c, d, e, f, g = 0.02 / 2.0, -0.03 / 6.0, 0.05 / 24.0, -0.07 / 120.0, 0.11 / 720.0
    expected = 1.05 * (phi - c * phi**2 - d * phi**3 - e * phi**4 - f * phi**5 - g * phi**6)
    np.testing.assert_allclose(pose.work[0], expected, rtol=1e-14)
    np.testing.assert_allclose(pose.shift[0][1], 0.003 - 0.002 * phi + 0.003 * phi**2 / 2 - 0.001 * phi**3 / 6)
    np.testing.assert_allclose(pose.shift[0][2], -(0.002 + 0.004 * phi + 0.001 * phi**2 / 2 + 0.002 * phi**3 / 6))
    for values, ahead, behind in (
        (getattr(pose, name), *(getattr(m.at(phi + step), name) for step in (1e-6, -1e-6)))
        for name in ("work", "shift")
    ):
        for k in (0, 1):
            np.testing.assert_allclose(values[k + 1], (ahead[k] - behind[k]) / 2e-6, rtol=1e-7, atol=1e-10)


@pytest.mark.parametrize("name", BLADES)
@pytest.mark.parametrize("generated", [True, False])
def test_equation_of_meshing_and_normal_from_derivatives(name: str, generated: bool) -> None:
    """All motions on: analytic state and derivatives against complex step; n . dr/dphi; normal square to the tool."""
    machine = replace(MACHINE, generation=GENERATED if generated else FORMATE)
    flank = CutFlank(BLADES[name], machine, BLANK, index_zero=0.3)
    state, slope = flank.linearise(parameters())
    by_step = Flank.linearise(flank, parameters())
    np.testing.assert_allclose(state, by_step[0], atol=1e-15)
    np.testing.assert_allclose(slope, by_step[1], atol=1e-13 * np.abs(by_step[1]).max())
    normal = state[3:6]
    np.testing.assert_allclose((normal**2).sum(axis=0), 1.0, rtol=1e-14)
    tool = np.einsum("in,nik->nk", normal, slope[:, :3, :2])
    assert np.abs(tool).max() < 1e-15
    if generated:
        np.testing.assert_allclose(state[6], np.einsum("in,ni->n", normal, slope[:, :3, 2]), atol=1e-16)
    else:
        np.testing.assert_array_equal(state[6], parameters()[2])
        np.testing.assert_array_equal(slope[:, :6, 2], 0.0)


@pytest.mark.parametrize("name", ["straight mill", "hob", "relieved hob"])
def test_derivatives_by_settings_by_complex_step(name: str) -> None:
    """Fits differentiate by the settings: every one may carry a complex step."""
    x, flank = parameters(), CutFlank(BLADES[name], MACHINE, BLANK, 0.3)
    fields = [("blade", n) for n in ("point_radius", "blade_angle", "curvature", "radius_offset", "phase")]
    fields += [("machine", n) for n in MACHINE.__dataclass_fields__ if n != "generation"]
    for where, field in fields:
        part = getattr(flank, where)
        small = 1e-6 * max(1.0, abs(getattr(part, field)))
        exact, ahead, behind = (
            np.asarray(replace(flank, **{where: replace(part, **{field: getattr(part, field) + step})}).sweep(x)[0])
            for step in (1e-30j, small, -small)
        )
        differences = (ahead - behind) / (2.0 * small)
        np.testing.assert_allclose(exact.imag / 1e-30, differences, rtol=1e-6, atol=5e-11)


def test_edge_pieces_join_with_one_tangent_and_relieve_the_flank() -> None:
    plain = Blade(0.1, 0.35, "concave", 3.0, reference_height=0.004, edge_radius=0.0008)
    toprem, flankrem = Relief(height=0.002, radius=0.03, angle=0.04), Relief(height=0.007, radius=0.2)
    edge = replace(plain, toprem=toprem, flankrem=flankrem).profile
    assert len(edge.pieces) == 4
    for end in edge.breaks:
        below, above = (np.array(edge.at(np.array([end + k * 1e-12]))[:3])[:, 0] for k in (-1.0, 1.0))
        np.testing.assert_allclose(below, above, atol=1e-10)
    s = np.linspace(0.0, 0.011, 60)
    (xi, eta, angle, curvature), straight = edge.at(s), plain.profile.at(s)
    middle = (s > edge.breaks[1]) & (s < edge.breaks[2])
    np.testing.assert_allclose(xi[middle], straight[0][middle], atol=1e-18)
    # both reliefs put the edge further into the tooth than the profile at the same height
    longer = plain.profile.at(np.linspace(-0.001, 0.013, 5000))
    same_height = np.interp(eta, longer[1], longer[0])
    assert (xi[s < edge.breaks[1] - 1e-4] > same_height[s < edge.breaks[1] - 1e-4]).all()
    assert (xi[s > edge.breaks[2] + 1e-4] > same_height[s > edge.breaks[2] + 1e-4]).all()
    # the straight part of the toprem is turned by its angle from the profile where it starts
    start = plain.profile.at(np.array([edge.breaks[1]]))[2]
    np.testing.assert_allclose(angle[s < edge.breaks[0]], start[0] - 0.04, rtol=1e-12)
    np.testing.assert_array_equal(curvature[s < edge.breaks[0]], 0.0)
    for reached, radius in ((s > edge.breaks[2], 0.2), ((s > edge.breaks[0]) & (s < edge.breaks[1]), 0.03)):
        np.testing.assert_allclose(curvature[reached], 1.0 / radius)
    assert edge.length_at(0.002) == pytest.approx(edge.breaks[1], rel=1e-12)


def test_protuberance_stands_off_by_its_amount() -> None:
    out = Protuberance(height=0.003, amount=40e-6, radius=0.002)
    blade = Blade(0.1, 0.35, "concave", protuberance=out, edge_radius=0.0005)
    s = np.array([0.0, 0.001])
    xi, eta, angle, _ = blade.profile.at(s)
    np.testing.assert_allclose(angle, 0.35, rtol=1e-12)
    # distance from the line through the tip at the blade angle
    np.testing.assert_allclose(xi * np.cos(0.35) - eta * np.sin(0.35), 40e-6, rtol=1e-9)


@pytest.mark.parametrize("blade", [BLADES["curved mill"], replace(BLADES["straight mill"], edge_radius=0.0012)])
def test_edge_radius_touches_the_profile_and_the_tip_plane(blade: Blade) -> None:
    arc = blade.tip_arc
    ends = np.array([blade.tip, blade.profile_start])
    (xi, eta, angle, _), flank = arc.at(ends), blade.profile.at(ends)
    np.testing.assert_allclose([eta[0], angle[0]], [0.0, 0.5 * np.pi], atol=1e-16)
    np.testing.assert_allclose([xi[1], eta[1], angle[1]], [v[1] for v in flank[:3]], rtol=1e-12)
    centre = np.array([xi - blade.edge_radius * np.cos(angle), eta + blade.edge_radius * np.sin(angle)])
    np.testing.assert_allclose(centre[:, 0], centre[:, 1], atol=1e-16)
    if blade.curvature == 0.0:
        # straight blade: the well-known distance of the tangent point from the sharp point
        expected = blade.edge_radius * (1.0 - np.sin(0.35)) / np.cos(0.35)
        assert blade.profile_start == pytest.approx(expected, rel=1e-12)


def test_hob_edge_leans_by_rake_and_hook() -> None:
    flat = Blade(0.076, 0.3, "concave", reference_height=0.005, groups=13, offset_angle=0.35)
    leant = replace(flat, rake=0.1, hook=0.2)
    s = np.array([0.001, 0.008])
    plane, point = flat.edge(s)[0], leant.edge(s)[0]
    forward = np.array([-np.sin(0.35), np.cos(0.35), 0.0])
    xi, eta, *_ = flat.profile.at(s)
    leaning = xi * np.tan(0.1) + (eta - 0.005) * np.tan(0.2)
    np.testing.assert_allclose(point - plane, forward[:, None] * leaning, atol=1e-17)


def test_index_start_is_where_a_blade_faces_the_mean_point() -> None:
    start = index_start(MACHINE, BLANK)
    blade = Blade(0.1, 0.35, "concave", groups=13, offset_angle=0.0)
    flank = CutFlank(blade, MACHINE, BLANK, start)
    # the reference circle at that angle lies on the ray from the cutter axis through the mean point
    point = flank.sweep(np.array([[0.0], [start], [0.0]]))[0][:, 0]
    pose = flank.machine.at(np.zeros(1))
    centre = pose.to_work(flank.machine.cutter_centre[:, None], flank._indexed(np.array([start])))[:, 0]
    axis = flank.machine.work_axes @ flank.machine.cutter_axes[:, 2]
    radius, z = BLANK.axial(np.zeros(1), np.zeros(1))
    mean = np.array([radius[0], 0.0, z[0]])
    aside = np.cross(axis, point - centre)
    assert abs(aside @ (mean - centre)) < 1e-15
    assert (point - centre) @ (mean - centre) > 0.0
