"""Cut surfaces: equation of meshing, normals and curvatures against independent computations."""

from dataclasses import replace

import numpy as np
import pytest
from flank_curvature import flank_curvature
from twins.random_blanks import deeper, run_cutter

from efficiency.cutting.blank import Blank
from efficiency.cutting.cutter import Blade, Relief
from efficiency.cutting.flank import CutFlank, FlankPoints, index_start
from efficiency.cutting.machine import FORMATE, GENERATED, MachineSettings
from efficiency.design.design import load_design
from ehl.common.errors import ConvergenceError

DEG = np.pi / 180.0


def mill(side: str = "concave", curvature: float = 0.0) -> CutFlank:
    flank = load_design("fm_spiral_bevel_14x39").gear.flank(side)  # type: ignore[arg-type]
    assert isinstance(flank, CutFlank)
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


def hob(generated: bool) -> CutFlank:
    """Flank of a face-hobbed hypoid pair 9 x 34: generated pinion of a tilted head, or Formate gear."""
    if generated:
        angle, cone = 24.76494587 * DEG, 0.0611696
        apex = cone * np.cos(angle) - 0.0681769
        blank = Blank(
            teeth=9,
            pitch_angle=angle,
            mean_cone_distance=cone,
            face_width=0.031139,
            mean_addendum=0.00584,
            mean_dedendum=0.003222,
            addendum_angle=0.0,
            dedendum_angle=0.0,
            pitch_apex_beyond_crossing=apex,
        )
        machine = MachineSettings(
            0.10348436, -67.4911 * DEG, 0.0, 3.61716, 25.2058 * DEG, -19.9986 * DEG, 0.02972296, 0.02090746, -0.00132199
        )
        blade = Blade(0.076, 24.9179 * DEG, "convex", 1.47, 0.003222, radius_offset=-0.0018, groups=13)
        blade = replace(blade, offset_angle=-20.1507 * DEG, rake=-3.0 * DEG, hook=-5.0 * DEG)
    else:
        angle = 63.2125 * DEG
        blank = Blank(
            teeth=34,
            pitch_angle=angle,
            mean_cone_distance=0.082168,
            face_width=0.026,
            mean_addendum=0.002215,
            mean_dedendum=0.006847,
            addendum_angle=0.0,
            dedendum_angle=0.0,
            pitch_apex_beyond_crossing=0.011836,
        )
        machine = MachineSettings(
            0.11108769,
            43.1623 * DEG,
            angle,
            0.0,
            sliding_base=-0.006847,
            machine_centre_to_back=0.011836,
            generation=FORMATE,
        )
        blade = Blade(0.076, 24.1269 * DEG, "concave", 0.0, 0.006847, groups=13, offset_angle=20.1507 * DEG)
    return CutFlank(blade, machine, blank, index_start(machine, blank))


FLANKS = {
    "face-milled": mill(),
    "face-milled, all motions": tilted_mill(),
    "face-milled, Formate": replace(mill(), machine=replace(mill().machine, generation=FORMATE)),
    "face-hobbed, generated, rake and hook": hob(True),
    "face-hobbed, Formate": hob(False),
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
def test_normals_point_out_of_the_tooth(name: str) -> None:
    """Concave flanks of right-hand members and convex ones of left-hand members look towards growing azimuth."""
    flank = FLANKS[name]
    points = solved(flank, *grid(flank))
    around = points.normal[1] * points.position[0] - points.normal[0] * points.position[1]
    right = flank.machine.cradle_angle > 0.0
    assert (around * (1.0 if (flank.side == "concave") == right else -1.0) > 0.0).all()


@pytest.mark.parametrize("name", FLANKS)
def test_curvatures_against_differences_of_normals(name: str) -> None:
    """Weingarten: dn = -W dr, sixth-order differences of solved points."""
    flank = FLANKS[name]
    u, h = grid(flank)
    points = solved(flank, u, h)
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


def relative_motion(flank: CutFlank, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angular velocity of the tool against the work and the work axis, machine frame, cradle at 1 rad/s."""
    pose = flank.machine.at(phi)
    axis = np.asarray(flank.machine.work_axes[2], dtype=np.float64)[:, None]
    return np.array([[0.0], [0.0], [1.0]]) - axis * np.real(pose.work[1]), axis


def test_curvature_of_the_envelope_from_that_of_the_tool() -> None:
    """Face mill with straight blades: the tool is a cone of known curvature, the envelope differs by a rank-one term.

    With the tool's curvature W_t, the velocity v and angular velocity w of the tool against the work, and
    g = -W_t v - w x n the gradient of the equation of meshing f along the tool, the flank has
    W = W_t - g g^T/(df/dphi - g.v).
    """
    flank = replace(FLANKS["face-milled, all motions"], blade=replace(tilted_mill().blade, curvature=0.0))
    u, h = grid(flank)
    x = solved(flank, u, h).parameters
    shape = flank_curvature(flank, x)
    blade, machine, pose = flank.blade, flank.machine, flank.machine.at(x[2])
    point, normal = (np.real(a) for a in blade.surface(x[0], x[1]))
    place, facing = np.real(pose.place(point)), np.real(pose.direct(normal))
    around = np.stack([-np.sin(x[1]), np.cos(x[1]), 0.0 * x[1]])
    ring = np.real(pose.direct(around))
    # out of the tooth is towards the cutter axis for the outside blade: hollow, positive
    bend = blade.sign * np.cos(blade.blade_angle) / np.hypot(point[0], point[1])

    def tool(vector: np.ndarray) -> np.ndarray:
        return ring * (bend * (ring * vector).sum(axis=0))

    spin, _ = relative_motion(flank, x[2])
    velocity = np.real(pose.rolling(place))
    gradient = -tool(velocity) - np.cross(np.broadcast_to(spin, facing.shape), facing, axis=0)
    gradient -= facing * (gradient * facing).sum(axis=0)
    small = 1e-4
    rates = [np.real(flank.sweep(x + np.array([[0.0], [0.0], [k * small]]))[2]) for k in (-2, -1, 1, 2)]
    by_phi = (rates[0] - 8.0 * rates[1] + 8.0 * rates[2] - rates[3]) / (12.0 * small)
    share = by_phi - (gradient * velocity).sum(axis=0)
    np.testing.assert_allclose(share, flank.regression(x), rtol=1e-8)

    indexed = np.zeros(u.size)
    tangents = [shape.tangent_1, shape.tangent_2]
    back = [pose.machine.work_axes.T @ turn_back(t, np.real(indexed - pose.work[0])) for t in tangents]
    expected = np.empty_like(shape.matrix)
    for i in range(2):
        for j in range(2):
            rank_one = (back[i] * gradient).sum(axis=0) * (back[j] * gradient).sum(axis=0) / share
            expected[:, i, j] = (back[i] * tool(back[j])).sum(axis=0) - rank_one
    scale = np.abs(expected).max()
    assert np.abs(shape.matrix - expected).max() / scale < 1e-8
    assert machine.generation is GENERATED


def turn_back(vector: np.ndarray, angle: np.ndarray) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * vector[0] + s * vector[1], -s * vector[0] + c * vector[1], vector[2]])


def test_principal_directions_are_square_and_belong_to_their_curvatures() -> None:
    flank = FLANKS["face-hobbed, generated, rake and hook"]
    points = solved(flank, *grid(flank))
    shape = flank_curvature(flank, points.parameters)
    first, second = shape.directions
    assert np.abs((first * second).sum(axis=0)).max() < 1e-12
    assert np.abs((first * points.normal).sum(axis=0)).max() < 1e-12
    for k, direction in enumerate((first, second)):
        own = shape.along(direction, np.cross(points.normal, direction, axis=0))
        np.testing.assert_allclose(own[:, 0, 0], shape.principal[k], rtol=1e-9)
        assert np.abs(own[:, 0, 1]).max() < 1e-9 * np.abs(shape.principal).max()


def test_toprem_and_flankrem_take_material_at_root_and_tip_only() -> None:
    plain = mill()
    blade = replace(plain.blade, toprem=Relief(height=0.0015, radius=0.05), flankrem=Relief(height=0.005, radius=0.15))
    relieved = replace(plain, blade=blade)
    blank = plain.blank
    u, h = np.zeros(61), np.linspace(-5.2e-3, 1.5e-3, 61)
    first, second = solved(plain, u, h), solved(relieved, u, h)
    radius = np.hypot(first.position[0], first.position[1])
    around = first.normal[1] * first.position[0] - first.normal[0] * first.position[1]
    deeper = -np.sign(around) * (second.azimuth - first.azimuth) * radius
    s = second.parameters[0]
    low, high = (float(np.real(end)) for end in blade.profile.breaks)
    kept = (s > low) & (s < high)
    assert np.abs(deeper[kept]).max() < 1e-12
    assert (deeper[s < low - 1e-4] > 0.0).all()
    assert (deeper[s > high + 1e-4] > 0.0).all()
    # flankrem: the depth of an arc over its tangent, times the share of the normal that lies along the circle
    far = int(np.argmax(s))
    sag = 0.5 * (s[far] - high) ** 2 / 0.15
    across = np.abs(around[far]) / radius[far]
    assert deeper[far] == pytest.approx(sag / across, rel=0.05)
    assert blank.teeth == 39


def test_mirror_image_of_a_hobbed_member() -> None:
    """The other hand: settings that lie to the side change sign, indexing does not; the flank is the mirror image."""
    right = hob(True)
    m, b = right.machine, right.blade
    machine = replace(m, cradle_angle=-m.cradle_angle, swivel=-m.swivel, blank_offset=-m.blank_offset)
    blade = replace(b, offset_angle=-b.offset_angle, phase=-b.phase, rake=-b.rake, hook=-b.hook)
    left = CutFlank(blade, machine, right.blank, index_start(machine, right.blank))
    u, h = grid(right)
    one, other = solved(right, u, h), solved(left, u, h)
    mirror = np.array([[1.0], [-1.0], [1.0]])
    np.testing.assert_allclose(other.position, mirror * one.position, atol=1e-12)
    np.testing.assert_allclose(other.normal, mirror * one.normal, atol=1e-10)


def test_face_hobbing_without_indexing_is_face_milling() -> None:
    """A head of no groups: the offset blade plane sweeps a hyperboloid, close to the cone of a face mill."""
    gear = hob(False)
    still = replace(gear, blade=replace(gear.blade, groups=0, offset_angle=0.0))
    flat = replace(still, blade=replace(still.blade, reference_height=0.0, point_radius=still.blade.point_radius))
    lifted = gear.blade.reference_height * np.tan(gear.blade.blade_angle)
    flat = replace(flat, blade=replace(flat.blade, point_radius=gear.blade.point_radius - lifted))
    u, h = grid(still)
    np.testing.assert_allclose(solved(still, u, h).position, solved(flat, u, h).position, atol=1e-14)


@pytest.mark.parametrize("index", range(12))
def test_a_blade_that_reaches_too_deep_cuts_the_same_flank(index: int) -> None:
    # the surface that cuts is the same: the search has to stay on its sheet of the envelope
    assert run_cutter(1, index)[0] == "answered"


def test_a_mean_point_behind_the_edge_of_regression_is_refused_with_the_root_that_is_too_deep() -> None:
    flank = load_design("fh_hypoid_9x34").flank("pinion", "concave")
    assert isinstance(flank, CutFlank)
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
    assert isinstance(flank, CutFlank)
    # no tilt: the tip plane moves by the depth itself
    assert deeper(flank, 4e-3).tip_below_root - flank.tip_below_root == pytest.approx(4e-3, abs=5e-5)
