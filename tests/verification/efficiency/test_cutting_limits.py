"""Fillet, root line, undercut against closed forms and a search over all positions of the blade; deep cutters."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from flank_curvature import flank_curvature
from reference_flanks import hobbed_gear, hobbed_pinion
from scipy.interpolate import CubicSpline
from twins.random_blanks import deeper, run_cutter

from efficiency.cutting.flank import CutFlank
from efficiency.cutting.limits import FlankLimits, columns, fillet, flank_limits
from efficiency.design.design import load_design
from ehl.common.errors import ConvergenceError


def bevel_gear(side: str) -> CutFlank:
    flank = load_design("fm_spiral_bevel_14x39").gear.flank(side)  # type: ignore[arg-type]
    # the file rounds: here the tip plane touches the root cone exactly
    blank = flank.blank
    sink = blank.mean_cone_distance * np.sin(blank.dedendum_angle) - blank.mean_dedendum * np.cos(blank.dedendum_angle)
    root_angle = blank.pitch_angle - blank.dedendum_angle
    machine = replace(flank.machine, machine_root_angle=root_angle, sliding_base=sink)
    return replace(flank, blade=replace(flank.blade, edge_radius=0.8e-3), machine=machine)


@cache
def limits(edge_radius: float = 0.0) -> FlankLimits:
    return flank_limits(hobbed_pinion("concave", edge_radius=edge_radius))


def tooth_boundary(flank: CutFlank, u: float, h: float, part: str) -> tuple[float, float]:
    """Deepest cut into the tooth at one place of the blank over all cradle rolls: no equation of meshing is used.

    At each roll the surface of the blade meets the circle of that place at some azimuth; the farthest into the tooth is
    what remains. Returned are the sense of azimuth into the tooth, and the azimuth counted in that sense.
    """
    cut = fillet(flank) if part == "fillet" else flank
    rounded = fillet(flank).blade
    low, high = (rounded.tip, rounded.profile_start) if part == "fillet" else (rounded.profile_start, np.inf)
    radius, z = flank.blank.axial(np.array([u]), np.array([h]))
    start, found = flank.solve(np.array([u]), flank.blank.height(np.array([u]), np.array([0.6])))
    assert found.all()
    phis = np.linspace(-0.4, 0.4, 2001)
    x = np.repeat(start.parameters, phis.size, axis=1)
    if part == "fillet":
        x[0] = 0.5 * (low + high)
    x[2] = phis
    for _ in range(40):
        state, slope = cut.linearise(x)
        here = np.hypot(state[0], state[1])
        out = (state[0][:, None] * slope[:, 0] + state[1][:, None] * slope[:, 1]) / here[:, None]
        matrix = np.stack([out, slope[:, 2]], axis=1)[:, :, :2]
        step = np.linalg.solve(matrix, np.stack([here - radius, state[2] - z], axis=1)[..., None])[..., 0].T
        shrink = np.minimum(1.0, (np.array([[2e-4], [0.02]]) / np.abs(step).clip(1e-300)).min(axis=0))
        x[:2] -= shrink * step
    state, _ = cut.linearise(x)
    reached = (np.hypot(np.hypot(state[0], state[1]) - radius, state[2] - z) < 1e-12) & (x[0] >= low) & (x[0] <= high)
    outwards = state[4] * state[0] - state[3] * state[1]
    into = -np.sign(np.median(outwards[reached]))
    azimuth = np.arctan2(state[1], state[0])[reached]
    return into, float((into * np.angle(np.exp(1j * (azimuth - start.azimuth[0])))).max()) + into * start.azimuth[0]


@pytest.mark.parametrize("side", ["concave", "convex"])
def test_root_of_an_untilted_generated_gear_is_its_root_cone(side: str) -> None:
    found = flank_limits(bevel_gear(side))
    np.testing.assert_allclose(found.root_error, 0.0, atol=1e-12)
    assert not found.undercut.any()
    assert np.isnan(found.regression).all()
    # the profile ends rho (1 - sin a) over the tip plane, and generates before and after the tip plane is deepest
    rise = 0.8e-3 * (1.0 - np.sin(bevel_gear(side).blade.blade_angle))
    assert (found.start - found.root > rise).all()
    assert (found.start - found.root < 3.0 * rise).all()


@pytest.mark.parametrize("side", ["concave", "convex"])
def test_fillet_joins_the_flank_with_its_tangent_plane_and_ends_square_to_the_root(side: str) -> None:
    flank = bevel_gear(side)
    found = flank_limits(flank)
    ends = flank.points(found.fillet.parameters[0])
    np.testing.assert_allclose(found.fillet.position[0], ends.position, atol=1e-15)
    np.testing.assert_allclose(found.fillet.normal[0], ends.normal, atol=1e-12)
    # at the root line the surface is tangent to the root cone: its normal is that of the cone
    blank = flank.blank
    azimuth = np.arctan2(found.fillet.position[-1, 1], found.fillet.position[-1, 0])
    cone = blank.pitch_angle - blank.dedendum_angle
    outwards = np.stack([np.cos(cone) * np.cos(azimuth), np.cos(cone) * np.sin(azimuth), -np.sin(cone) + 0.0 * azimuth])
    np.testing.assert_allclose(found.fillet.normal[-1], outwards, atol=1e-9)


def test_undercut_is_where_the_curvature_has_no_bound() -> None:
    """Independent of the regression condition: a principal radius of the flank vanishes at the edge of regression."""
    flank, found = hobbed_pinion("concave", edge_radius=0.0), limits()
    at = np.flatnonzero(found.undercut)[:4]
    u = found.u[at]
    start, _ = flank.solve(u, flank.blank.height(u, np.full(u.size, 0.6)))
    top = start.parameters[0]
    radii = []
    for distance in (4e-5, 1e-5):
        x = columns(flank, u, top + np.linspace(0.0, 1.0, 30)[:, None] * (0.0 - top), start.parameters)
        rows = [np.interp(0.0, -x.regression[:, k], x.parameters[:, 0, k]) for k in range(u.size)]
        s = np.array(rows) + distance
        near = columns(flank, u, top + np.linspace(0.0, 1.0, 30)[:, None] * (s - top), start.parameters)
        shape = flank_curvature(flank, near.parameters[-1])
        radii.append((1.0 / np.abs(shape.principal)).min(axis=0))
        assert (flank.regression(near.parameters[-1]) * near.regression[0] > 0.0).all()
    assert (radii[0] < 4e-4).all()
    assert (radii[1] < 0.5 * radii[0]).all()


def test_undercut_of_the_hobbed_pinion_lies_at_its_toe() -> None:
    """The recipe names the first 3 of 15 columns of its grid (with an edge of 0.8 mm here)."""
    rounded = limits(0.8e-3)
    assert np.flatnonzero(rounded.undercut).tolist() == [0, 1, 2]
    assert rounded.u[np.nanargmax(rounded.start - rounded.regression)] == pytest.approx(-15.57e-3, abs=5e-6)


def test_flank_and_fillet_are_what_all_positions_of_the_blade_leave() -> None:
    """Undercut station: above the crossing the flank stands, below it the fillet, each the deepest cut of all rolls."""
    flank, found = hobbed_pinion("concave", edge_radius=0.8e-3), limits(0.8e-3)
    for k in (0, 9):
        u, edge = float(found.u[k]), float(found.start[k])
        for h in (edge + 0.2e-3, edge + 1.5e-3):
            points, ok = flank.solve(np.array([u]), np.array([h]))
            assert ok.all()
            into, boundary = tooth_boundary(flank, u, h, "flank")
            assert into * boundary == pytest.approx(points.azimuth[0], abs=2e-7)
        h = float(edge - 0.5 * (edge - found.root[k]))
        rows = found.fillet
        azimuth = np.arctan2(rows.position[:, 1, k], rows.position[:, 0, k])
        on_fillet = CubicSpline(rows.height[::-1, k], azimuth[::-1])(h)
        into, boundary = tooth_boundary(flank, u, h, "fillet")
        assert into * boundary == pytest.approx(float(on_fillet), abs=1e-6)


def test_fillet_and_undercut_flank_change_over_at_the_height_named() -> None:
    flank, found = hobbed_pinion("concave", edge_radius=0.2e-3), limits(0.2e-3)
    u, start, lost = float(found.u[0]), float(found.start[0]), float((found.start - found.regression)[0])
    assert lost > 1e-5
    for h, part in ((start + 0.5 * lost, "flank"), (start - 0.5 * lost, "fillet")):
        depth = {name: tooth_boundary(flank, u, h, name)[1] for name in ("flank", "fillet")}
        assert max(depth, key=lambda name: depth[name]) == part


def test_face_hobbing_without_indexing_is_face_milling() -> None:
    """A head of no groups: the offset blade plane sweeps a hyperboloid, close to the cone of a face mill."""
    gear = hobbed_gear("concave")
    still = replace(gear, blade=replace(gear.blade, groups=0, offset_angle=0.0))
    lifted = gear.blade.reference_height * np.tan(gear.blade.blade_angle)
    blade = replace(still.blade, reference_height=0.0, point_radius=gear.blade.point_radius - lifted)
    flat = replace(still, blade=blade)
    u = np.linspace(-0.4, 0.4, 9) * gear.blank.face_width
    v = np.linspace(0.35, 0.95, 9)
    one, other = (flank.solve(u, gear.blank.height(u, v))[0] for flank in (still, flat))
    np.testing.assert_allclose(one.position, other.position, atol=1e-14)


@pytest.mark.parametrize("index", range(12))
def test_a_blade_that_reaches_too_deep_cuts_the_same_flank(index: int) -> None:
    # the surface that cuts is the same: the search has to stay on its sheet of the envelope
    assert run_cutter(1, index) == "answered"


def test_a_mean_point_behind_the_edge_of_regression_is_refused_with_the_root_that_is_too_deep() -> None:
    flank = load_design("fh_hypoid_9x34").flank("pinion", "concave")
    # the pitch cone lowered by 0.7 dedendums: its mean point lies where the shipped pinion is undercut
    blank = flank.blank
    low = 0.7 * blank.mean_dedendum
    apex = low / np.sin(blank.pitch_angle)
    changes = {
        "mean_cone_distance": blank.mean_cone_distance - apex * np.cos(blank.pitch_angle),
        "mean_addendum": blank.mean_addendum + low,
        "mean_dedendum": blank.mean_dedendum - low,
        "pitch_apex_beyond_crossing": blank.pitch_apex_beyond_crossing - apex,
    }
    lowered = blank.model_copy(update=changes)
    deep = deeper(replace(flank, blank=lowered), 10e-3)
    with pytest.raises(ConvergenceError, match=r"behind its edge of regression .* mm below the root cone: withdraw"):
        deep.solve(np.zeros(1), np.zeros(1))


def test_depth_of_the_blade_tip_below_the_root() -> None:
    flank = load_design("fm_spiral_bevel_14x39").flank("gear", "concave")
    # no tilt: the tip plane moves by the depth itself
    assert deeper(flank, 4e-3).tip_below_root - flank.tip_below_root == pytest.approx(4e-3, abs=5e-5)
