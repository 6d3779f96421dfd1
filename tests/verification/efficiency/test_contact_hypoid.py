"""Geometry of the mesh, velocities, curvatures, gaps and teeth against exact cases and independent computations."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from flank_curvature import flank_curvature

from efficiency.contact.assembly import Assembly
from efficiency.contact.conjugate import EaseOffTarget, conjugate_flank
from efficiency.contact.contact_lines import MeshPosition, mesh_cycle
from efficiency.contact.ease_off import ConjugatePoints, conjugate_points, ease_off
from efficiency.contact.flank_pair import FlankPair, flank_pair
from efficiency.contact.gear_flanks import SIDES, Side
from efficiency.contact.mesh_surface import mesh_surface
from efficiency.contact.tooth_grid import tooth_shapes
from efficiency.cutting.machine import turn
from efficiency.design.design import Design, load_design

PAIRS: list[tuple[str, Any]] = [(name, side) for name in ("fh_hypoid_9x34", "fm_hypoid_13x42") for side in SIDES]
PAIRS.append(("fm_spiral_bevel_14x39", "drive"))


@pytest.fixture(scope="module", params=PAIRS, ids=lambda pair: f"{pair[0]}-{pair[1]}")
def pair(request: pytest.FixtureRequest) -> FlankPair:
    return flank_pair(load_design(request.param[0]).flanks(), request.param[1])


def test_sliding_is_that_of_the_rigid_bodies(pair: FlankPair) -> None:
    """No velocity along the normal, both components of the sliding in the tangent plane; pinion at 1 rad/s."""
    assembly, spin = pair.surface.assembly, pair.surface.direction
    axis = np.array([np.sin(assembly.shaft_angle), 0.0, np.cos(assembly.shaft_angle)])
    for position in mesh_cycle(pair.surface, positions=3, points_per_line=9):
        pinion = spin * np.cross(axis, position.position - np.array([0.0, assembly.offset, 0.0]))
        gear = np.cross([0.0, 0.0, -spin * assembly.teeth_pinion / assembly.teeth_gear], position.position)
        sliding = pinion - gear
        assert np.abs((sliding * position.normal).sum(axis=1)).max() < 1e-14
        np.testing.assert_allclose((sliding * position.along).sum(axis=1), position.sliding_along, atol=1e-15)
        np.testing.assert_allclose((sliding * position.across).sum(axis=1), position.sliding_across, atol=1e-15)
        total = np.hypot(position.sliding_along, position.sliding_across)
        np.testing.assert_allclose(total, np.linalg.norm(sliding, axis=1), rtol=1e-12)
        # the normal force drives the gear: power in is power out on conjugate flanks
        np.testing.assert_allclose((pinion * position.normal).sum(axis=1), position.lever_pinion, rtol=1e-12)
        ratio = position.lever_gear / position.lever_pinion
        np.testing.assert_allclose(ratio, assembly.teeth_gear / assembly.teeth_pinion, rtol=1e-12)
    # lengthwise sliding is what sets a hypoid apart
    if assembly.offset > 0.01:
        assert np.abs(position.sliding_along).min() > 3.0 * np.abs(position.sliding_across).min()


def inner(pair: FlankPair, points: int = 7) -> tuple[MeshPosition, np.ndarray, np.ndarray]:
    """Points of one position that lie 0.5 mm inside the flanks, with (u, v)."""
    surface = pair.surface
    position = mesh_cycle(pair.surface, positions=3, points_per_line=points)[1]
    u = position.face_gear - 0.5 * surface.gear.blank.face_width
    v = surface.gear.blank.fraction(u, position.height_gear + surface.gear.blank.root(u))
    return position, u, v


def test_entrainment_follows_the_line_over_the_gear(pair: FlankPair) -> None:
    """Gear points a little apart and the times the line reaches them."""
    surface = pair.surface
    position, u, v = inner(pair)
    h, small = surface.height(u, v), 2e-6
    middle, _ = surface.gear.solve(u, h)
    f2 = surface.assembly.roll(middle.position, middle.normal)[0]
    for du, dh in ((small, 0.0), (0.0, small)):
        ahead, behind = (surface.gear.solve(u + k * du, h + k * dh)[0] for k in (1.0, -1.0))
        roll = [surface.assembly.roll(p.position, p.normal)[0] / surface.assembly.ratio for p in (ahead, behind)]
        time = surface.direction * (roll[0] - roll[1])
        run = (turn(ahead.position - behind.position, f2) * position.across.T).sum(axis=0)
        # a gear point that lies `run` ahead is reached `time` later: the surface moves against the line
        surface_gear = position.entrainment - 0.5 * position.sliding_across
        np.testing.assert_allclose(-run, surface_gear * time, rtol=1e-4, atol=1e-11)


def curvature_radius(pair: FlankPair, position: MeshPosition, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Equivalent radius across the line from the curvatures of both real flanks."""
    surface = pair.surface
    on_gear, found = surface.gear.solve(u, surface.height(u, v))
    assert found.all()
    conjugate = conjugate_points(on_gear, surface.assembly)
    _, parameters, found = ease_off(conjugate, surface.pinion, surface.phase)
    assert found.all()
    facing = np.real(surface.pinion.sweep(parameters)[1])
    across, along = position.across.T, position.along.T
    gear = flank_curvature(surface.gear, on_gear.parameters)
    relative = -gear.along(turn(across, -conjugate.gear_roll), turn(along, -conjugate.gear_roll))[:, 0, 0]
    tangents = []
    for vector in (across, along):
        f1 = conjugate.gear_roll / surface.assembly.ratio
        _, own = surface.assembly.to_pinion(np.zeros_like(vector), vector, f1)
        own = turn(own, -surface.phase)
        own -= facing * (own * facing).sum(axis=0)
        tangents.append(own / np.sqrt((own**2).sum(axis=0)))
    relative -= flank_curvature(surface.pinion, parameters).along(*tangents)[:, 0, 0]
    return np.asarray(1.0 / relative)


def test_equivalent_radius_against_the_curvatures_of_both_flanks(pair: FlankPair) -> None:
    """Mesh kinematics against both cuts: exact for the conjugate flank; with an ease-off to first order in it."""
    position, u, v = inner(pair)
    exact = curvature_radius(pair, position, u, v)
    off = np.abs(position.radius_equivalent / exact - 1.0)
    # the tilt of the ease-off moves the place of contact where the radius changes fast, at the ends of lines
    assert np.median(off) < 0.015
    assert off.max() < 0.12
    surface = pair.surface
    flank = conjugate_flank(surface.gear, surface.pinion.blank, surface.assembly, EaseOffTarget())
    conjugate = replace(pair, surface=mesh_surface(surface.gear, flank, surface.assembly))
    position, u, v = inner(conjugate)
    np.testing.assert_allclose(curvature_radius(conjugate, position, u, v), position.radius_equivalent, rtol=1e-6)


def separation(pair: FlankPair, angle: float, back: float, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Exact distance along the gear normal to the real pinion flank at a pinion angle, gear turned back."""
    surface = pair.surface
    points, found = surface.gear.solve(u, surface.height(u, v))
    assert found.all()
    f1 = np.full(u.shape, surface.direction * angle + surface.roll_zero)
    f2 = surface.assembly.ratio * f1 - surface.forward * back
    in_mesh = surface.assembly.gear_in_mesh(points.position, f2)
    position, normal = surface.assembly.to_pinion(in_mesh, turn(points.normal, f2), f1)
    distance, _, found = ease_off(ConjugatePoints(f2, f2, position, normal), surface.pinion, surface.phase)
    return np.where(found, distance, np.inf)


def test_gap_is_the_least_distance_of_the_real_flanks_across_the_line(pair: FlankPair) -> None:
    surface = pair.surface
    position, u, v = inner(pair, 5)
    angle = position.pinion_angle + position.pair * surface.pitch
    back = -position.transmission_error
    for k in np.unique(position.pair):
        own = position.pair == k
        shifts = np.linspace(-0.4e-3, 0.4e-3, 9)
        # across the line in map coordinates: square to the lines of equal roll angle
        (roll_u,), (roll_v,) = (surface.patch(u[own], v[own], ("roll",), du=a, dv=1 - a) for a in (1, 0))
        ru, rv = (surface.patch(u[own], v[own], ("x", "y", "z"), du=a, dv=1 - a) for a in (1, 0))
        e, f, g = (ru * ru).sum(axis=0), (ru * rv).sum(axis=0), (rv * rv).sum(axis=0)
        up, vp = g * roll_u - f * roll_v, e * roll_v - f * roll_u
        size = np.linalg.norm(ru * up + rv * vp, axis=0)
        up, vp, at = up / size, vp / size, float(angle[own][0])
        rows = [separation(pair, at, back, u[own] + s * up, v[own] + s * vp) for s in shifts]
        least = []
        for column in np.array(rows).T:
            a, b, c = np.polyfit(shifts[np.isfinite(column)], column[np.isfinite(column)], 2)
            least.append(c - 0.25 * b * b / a)
        difference = np.array(least) - position.gap[own]
        # counted from the closest of these points
        assert np.ptp(difference) < 0.3e-6


def test_undercut_is_told_and_leaves_no_gap_in_the_numbers() -> None:
    """The drive flank of the face-hobbed hypoid pinion is undercut at the toe of its root, near the tip of the gear."""
    pair = flank_pair(load_design("fh_hypoid_9x34").flanks(), "drive")
    absent = pair.surface.undercut
    assert 0.01 < absent.share < 0.05
    assert absent.u[0] == pytest.approx(-0.013)
    assert absent.fraction[0] > 0.9
    pattern = pair.pattern()
    assert not pattern.inside[pattern.gear_u < -0.0129][-1]
    for position in mesh_cycle(pair.surface, positions=8, points_per_line=21):
        for name in ("gap", "radius_equivalent", "length", "entrainment", "height_pinion"):
            assert np.isfinite(getattr(position, name)).all()
        assert (position.radius_equivalent > 0.0).all()
    shape = tooth_shapes(pair.flanks)[0]
    assert np.isfinite(shape.thickness_root).all()


@pytest.mark.parametrize("side", SIDES)
def test_interpolation_error_is_estimated(design: Design, side: Side) -> None:
    """The patch against exact points between its nodes; the estimate from the tail is not too small."""
    surface, random = flank_pair(design.flanks(), side).surface, np.random.default_rng(3)
    u, v = (random.uniform(*ends, 60) for ends in (surface.patch.u_range, surface.patch.v_range))
    on_gear, found = surface.gear.solve(u, surface.height(u, v))
    assert found.all()
    relief, _, found = ease_off(conjugate_points(on_gear, surface.assembly), surface.pinion, surface.phase)
    assert found.all()
    worst = np.abs(surface.patch(u, v, ("ease_off",))[0] - relief).max()
    assert worst < max(surface.interpolation_error, 1e-14)
    assert surface.interpolation_error < 1e-9


@pytest.mark.parametrize("hand", ["left", "right"])
def test_positive_misalignments_move_the_members_as_documented(hand: str) -> None:
    """E enlarges the offset, P and G move pinion and gear towards the heel, the shaft angle opens with its error.

    From a heel point of each member, turned about axes fitted to three places of it: no formula of the assembly.
    """
    mirror = 1.0 if hand == "left" else -1.0
    nominal = Assembly(9, 34, 1.5, mirror * 0.03)
    heel_pinion, heel_gear = np.array([[0.02], [0.0], [0.09]]), np.array([[0.08], [0.0], [0.03]])

    def lines(assembly: Assembly) -> list[tuple[np.ndarray, np.ndarray]]:
        """Point and direction of both axes by the circles that the heel points run on, towards the heel."""
        found = []
        for place, point in ((assembly.pinion_in_mesh, heel_pinion), (assembly.gear_in_mesh, heel_gear)):
            a, b, c, d = (place(point, np.array([angle]))[:, 0] for angle in (0.0, np.pi / 2, np.pi, 1.5 * np.pi))
            axis = np.cross(b - a, c - a)
            # the apex lies before the circle: towards the heel is away from the crossing point
            found.append(((a + b + c + d) / 4.0, axis / np.linalg.norm(axis)))
        return found

    def measures(assembly: Assembly) -> tuple[float, float]:
        (p, a), (q, b) = lines(assembly)
        normal = np.cross(a, b)
        return abs(float((p - q) @ normal)) / float(np.linalg.norm(normal)), float(np.arccos(a @ b))

    before, after = lines(nominal), lines(replace(nominal, P=1e-4, G=2e-4))
    for (centre, axis), (shifted, _), amount in zip(before, after, (1e-4, 2e-4), strict=True):
        assert (shifted - centre) @ axis == pytest.approx(amount, abs=1e-12)
        assert np.linalg.norm(shifted - centre) == pytest.approx(amount, abs=1e-12)
        assert centre @ axis > 0.02
    distance, angle = measures(nominal)
    assert (distance, angle) == pytest.approx((0.03, 1.5), abs=1e-12)
    assert measures(replace(nominal, E=mirror * 1e-4))[0] == pytest.approx(distance + 1e-4, abs=1e-12)
    assert measures(replace(nominal, shaft_angle_error=1e-3))[1] == pytest.approx(angle + 1e-3, abs=1e-9)
    # as a design states it: E of the design adds to its offset, whatever the hand
    pair = load_design("fh_hypoid_9x34")
    wide, near = (measures(pair.with_misalignment(E=e).placement())[0] for e in (1e-4, 0.0))
    assert wide == pytest.approx(near + 1e-4, abs=1e-12)
