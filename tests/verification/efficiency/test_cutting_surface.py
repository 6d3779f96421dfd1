"""Cut surfaces: normals and curvatures against independent computations."""

from dataclasses import replace

import numpy as np
import pytest
from flank_curvature import flank_curvature
from reference_flanks import hobbed_gear, hobbed_pinion
from twins.random_blanks import deeper, run_cutter

from efficiency.cutting.flank import CutFlank, FlankPoints
from efficiency.cutting.machine import FORMATE
from efficiency.design.design import load_design
from ehl.common.errors import ConvergenceError

DEG = np.pi / 180.0


def mill(side: str = "concave", curvature: float = 0.0) -> CutFlank:
    flank = load_design("fm_spiral_bevel_14x39").gear.flank(side)  # type: ignore[arg-type]
    return replace(flank, blade=replace(flank.blade, curvature=curvature))


def tilted_mill() -> CutFlank:
    """All motions on: tilt, modified roll, helical and vertical motion."""
    flank = mill("convex", 1.5)
    machine = replace(
        flank.machine,
        tilt=0.03,
        swivel=-0.5,
        modified_roll_2c=0.02,
        modified_roll_6d=-0.05,
        modified_roll_24e=0.1,
        helical_motion_1=0.002,
        vertical_motion_1=-0.001,
        vertical_motion_2=0.002,
    )
    return replace(flank, machine=machine)


# generated pinion of a tilted head with rake and hook, and Formate gear
HOB = hobbed_pinion("convex", rake=-3.0 * DEG, hook=-5.0 * DEG)
FLANKS = {
    "face-milled": mill(),
    "face-milled, all motions": tilted_mill(),
    "face-milled, Formate": replace(mill(), machine=replace(mill().machine, generation=FORMATE)),
    "face-hobbed, generated, rake and hook": HOB,
    "face-hobbed, Formate": hobbed_gear("concave"),
}


def grid(flank: CutFlank, columns: int = 5, rows: int = 4) -> tuple[np.ndarray, np.ndarray]:
    u, v = np.meshgrid(np.linspace(-0.4, 0.4, columns) * flank.blank.face_width, np.linspace(0.35, 0.95, rows))
    return u.ravel(), flank.blank.height(u.ravel(), v.ravel())


def solved(flank: CutFlank, u: np.ndarray, h: np.ndarray) -> FlankPoints:
    points, found = flank.solve(u, h)
    assert found.all()
    return points


def slopes(flank: CutFlank, u: np.ndarray, h: np.ndarray, step: float = 6e-5) -> list[tuple[np.ndarray, np.ndarray]]:
    """Derivatives of position and normal by u and by h: central differences of sixth order of solved points."""
    result = []
    for du, dh in ((step, 0.0), (0.0, step)):
        total_r, total_n = np.zeros((3, u.size)), np.zeros((3, u.size))
        for k, weight in ((1, 45.0), (2, -9.0), (3, 1.0)):
            ahead, behind = solved(flank, u + k * du, h + k * dh), solved(flank, u - k * du, h - k * dh)
            total_r += weight * (ahead.position - behind.position) / (60.0 * step)
            total_n += weight * (ahead.normal - behind.normal) / (60.0 * step)
        result.append((total_r, total_n))
    return result


@pytest.mark.parametrize("name", FLANKS)
def test_normals_and_curvatures_against_differences_of_normals(name: str) -> None:
    """Weingarten: dn = -W dr, sixth-order differences of solved points.

    Concave flanks of right-hand members and convex ones of left-hand members look towards growing azimuth.
    """
    flank = FLANKS[name]
    u, h = grid(flank)
    points = solved(flank, u, h)
    around = points.normal[1] * points.position[0] - points.normal[0] * points.position[1]
    right = flank.machine.cradle_angle > 0.0
    assert (around * (1.0 if (flank.side == "concave") == right else -1.0) > 0.0).all()
    shape = flank_curvature(flank, points.parameters)
    differences = slopes(flank, u, h)
    largest = np.abs(shape.matrix).max(axis=(1, 2))
    for along, bend in differences:
        a, b = (along * shape.tangent_1).sum(axis=0), (along * shape.tangent_2).sum(axis=0)
        step = np.stack([a, b], axis=1)
        predicted = -np.einsum("nij,nj->ni", shape.matrix, step)
        measured = np.stack([(bend * shape.tangent_1).sum(axis=0), (bend * shape.tangent_2).sum(axis=0)], axis=1)
        size = largest * np.linalg.norm(step, axis=1)
        assert (np.abs(measured - predicted).max(axis=1) / size).max() < 1e-6


def test_face_hobbing_without_indexing_is_face_milling() -> None:
    """A head of no groups: the offset blade plane sweeps a hyperboloid, close to the cone of a face mill."""
    gear = hobbed_gear("concave")
    still = replace(gear, blade=replace(gear.blade, groups=0, offset_angle=0.0))
    lifted = gear.blade.reference_height * np.tan(gear.blade.blade_angle)
    flat = replace(
        still, blade=replace(still.blade, reference_height=0.0, point_radius=gear.blade.point_radius - lifted)
    )
    u, h = grid(still)
    np.testing.assert_allclose(solved(still, u, h).position, solved(flat, u, h).position, atol=1e-14)


@pytest.mark.parametrize("index", range(12))
def test_a_blade_that_reaches_too_deep_cuts_the_same_flank(index: int) -> None:
    # the surface that cuts is the same: the search has to stay on its sheet of the envelope
    assert run_cutter(1, index)[0] == "answered"


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
