"""Geometry of the mesh against exact cases and against second, independent algorithms."""

from dataclasses import replace

import numpy as np
import pytest

from efficiency.contact.assembly import Assembly
from efficiency.contact.ease_off import ConjugatePoints, conjugate_points, ease_off
from efficiency.contact.flank_pair import FlankPair, flank_pair
from efficiency.contact.mesh_surface import MeshSurface, mesh_surface
from efficiency.cutting.cutter import Blade
from efficiency.cutting.flank import CutFlank
from efficiency.design.design import Design, load_design

SIDES = ("drive", "coast")


@pytest.fixture(scope="module", params=SIDES)
def pair(request: pytest.FixtureRequest, design: Design) -> FlankPair:
    return flank_pair(design.flanks(), request.param)


def crown_pinion(gear: CutFlank, pinion: CutFlank) -> CutFlank:
    """Pinion cut by the gear's own cutter surface on the gear's own cradle: exactly conjugate.

    Cradle and both members share one instantaneous axis (the common pitch line) when the machine centre is the common
    apex and the roll ratio that of the pitch cones; all three then touch along the same lines (Olivier's second
    principle). Seen from the pinion the cradle axis points the other way: the machine frame is turned by half a turn
    about its x axis, and the outside of the cutter becomes an inside.
    """
    machine, blade, depth = gear.machine, gear.blade, 0.01
    other = "convex" if blade.side == "concave" else "concave"
    radius = blade.point_radius + blade.sign * depth * np.tan(blade.blade_angle)
    settings = replace(
        machine,
        cradle_angle=-machine.cradle_angle,
        machine_root_angle=0.5 * np.pi - machine.machine_root_angle,
        roll_ratio=machine.roll_ratio * gear.blank.teeth / pinion.blank.teeth,
        sliding_base=-(machine.sliding_base + depth),
    )
    return CutFlank(Blade(float(radius), blade.blade_angle, other), settings, pinion.blank)


@pytest.fixture(scope="module", params=SIDES)
def conjugate(request: pytest.FixtureRequest, design: Design) -> MeshSurface:
    pinion, gear = design.flanks().mating(request.param)
    return mesh_surface(gear, crown_pinion(gear, pinion), design.placement())


def points_inside(surface: MeshSurface, count: int = 60) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(3)
    (u0, u1), (v0, v1) = surface.patch.u_range, surface.patch.v_range
    return random.uniform(u0, u1, count), random.uniform(v0, v1, count)


def exact_conjugate(surface: MeshSurface, u: np.ndarray, v: np.ndarray) -> ConjugatePoints:
    points, found = surface.gear.solve(u, surface.height(u, v))
    assert found.all()
    return conjugate_points(points, surface.assembly)


def test_exactly_conjugate_pinion_has_no_ease_off(conjugate: MeshSurface) -> None:
    u, v = points_inside(conjugate)
    relief, _, found = ease_off(exact_conjugate(conjugate, u, v), conjugate.pinion, conjugate.phase)
    assert found.all()
    assert np.abs(relief).max() < 1e-13
    assert np.abs(conjugate.patch(u, v, ("ease_off",))).max() < 1e-13


def test_interpolation_error_is_estimated(pair: FlankPair) -> None:
    """The patch against exact points between its nodes; the estimate from the tail is not too small."""
    surface = pair.surface
    u, v = points_inside(surface)
    relief, _, found = ease_off(exact_conjugate(surface, u, v), surface.pinion, surface.phase)
    assert found.all()
    worst = np.abs(surface.patch(u, v, ("ease_off",))[0] - relief).max()
    assert worst < max(surface.interpolation_error, 1e-14)
    assert surface.interpolation_error < 1e-9


@pytest.mark.parametrize("hand", ["left", "right"])
def test_positive_misalignments_move_the_members_as_documented(hand: str) -> None:
    """E enlarges the offset, P and G move pinion and gear from the apex towards the heel, the shaft-angle error opens
    the shaft angle.

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
