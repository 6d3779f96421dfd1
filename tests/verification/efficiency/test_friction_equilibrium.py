"""Loss and friction in the load equilibrium against exact limits, quadrature, energy balance, solved contacts."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from samples import AXLE_OIL as OIL
from samples import STEEL

import efficiency
from efficiency.contact.contact_lines import MeshPosition
from efficiency.cylindrical_gears.contact_lines import cylindrical_tooth
from efficiency.design.design import load_design
from efficiency.loss.closed_form import PitchGeometry, buckingham_type, coleman_type, lengthwise_sliding
from efficiency.loss.efficiency import balanced_efficiency, mesh_efficiency, solve_friction
from efficiency.loss.ehl_friction import EhlFriction
from efficiency.loss.kinematics import Axis, Driver, Operation, loaded_points
from efficiency.ltca.load_distribution import LoadDistribution, PositionLoad, TeethElasticity, distribute_load
from efficiency.ltca.mesh_grids import MeshGrids, load_grids
from efficiency.ltca.solid_tooth import SolidTooth
from efficiency.mesh import Mesh
from ehl.common.errors import InputError
from regression.formula import friction_model
from regression.friction.models import ConstantFriction, FrictionModel

OPERATION = Operation(100.0, 363.15)


@cache
def straight_tooth() -> SolidTooth:
    return cylindrical_tooth(20, 0.026, 0.033, 0.02, lambda r: (3e-3 - 0.25 * (r - 0.026)) / r, 6e-3, STEEL)


def pitch_point(spiral_1: float, spiral_2: float, pressure: float) -> MeshGrids:
    """Contact at the pitch point only: x across the teeth, y along them, z off the plane; equal speeds along x."""
    radius_1, radius_2 = 0.025, 0.075
    axes, speeds = [], []
    for spiral, radius, side in ((spiral_1, radius_1, 1.0), (spiral_2, radius_2, -1.0)):
        direction = side * np.array([-math.sin(spiral), math.cos(spiral), 0.0])
        axes.append(Axis(direction, np.array([0.0, 0.0, -side * radius])))
        speeds.append(np.cross(direction, -axes[-1].origin))
    ratio = speeds[0][0] / speeds[1][0]  # omega_2 per unit omega_1
    velocity_1, velocity_2 = speeds[0], ratio * speeds[1]
    normal = np.array([math.cos(pressure), 0.0, math.sin(pressure)])
    n = 5

    across = np.array([-math.sin(pressure), 0.0, math.cos(pressure)])
    vectors = {"position": np.zeros(3), "normal": normal, "along": np.array([0.0, 1.0, 0.0]), "across": across}
    numbers = {"lever_pinion": normal @ velocity_1, "lever_gear": normal @ velocity_2 / ratio, "length": 2e-3}
    numbers |= {"sliding_along": velocity_1[1] - velocity_2[1], "entrainment": 0.01, "radius_equivalent": 0.012}
    numbers |= {"height_gear": 3e-3, "height_pinion": 3e-3}
    numbers |= dict.fromkeys(("gap", "sliding_across", "lay_pinion", "lay_gear"), 0.0)
    face = np.linspace(8e-3, 12e-3, n)
    position = MeshPosition(
        pinion_angle=0.0,
        transmission_error=0.0,
        pair=np.zeros(n, np.int64),
        face_gear=face,
        face_pinion=face,
        **{name: np.tile(vector, (n, 1)) for name, vector in vectors.items()},
        **{name: np.full(n, value) for name, value in numbers.items()},
    )
    tooth = straight_tooth()
    cycle = tuple(replace(position, pinion_angle=0.1 * k) for k in range(4))
    return MeshGrids("pitch point", "drive", cycle, cycle, TeethElasticity(tooth, tooth, STEEL, STEEL), n, tuple(axes))


@pytest.mark.parametrize("mu", [0.0, 0.01, 0.05, 0.12])
@pytest.mark.parametrize(("b1", "b2"), [(50.0, 30.0), (45.0, 21.0), (35.0, 35.0), (20.0, 40.0)])
def test_hypoid_pitch_point_is_exact(mu: float, b1: float, b2: float) -> None:
    """eta = (cos a + mu tan b2)/(cos a + mu tan b1), and 1 - mu (tan b1 - tan b2)/cos a without friction in it.

    With the larger spiral angle on the gear the friction pushes the other way: |sliding| and mu change sign.
    """
    pressure, t1, t2 = math.radians(20.0), math.tan(math.radians(b1)), math.tan(math.radians(b2))
    mesh = pitch_point(math.radians(b1), math.radians(b2), pressure)
    model, cos_a = ConstantFriction(mu), math.cos(pressure)
    loaded = load_grids(mesh, 100.0)
    plain = mesh_efficiency(loaded, model, OIL, OPERATION)
    assert plain.efficiency == pytest.approx(1.0 - mu * abs(t1 - t2) / cos_a, rel=1e-12)
    assert "friction in the torque balance" in plain.skipped
    with_friction = mesh_efficiency(loaded, model, OIL, OPERATION, "frictional")
    signed = math.copysign(mu, t1 - t2)
    assert with_friction.efficiency == pytest.approx((cos_a + signed * t2) / (cos_a + signed * t1), rel=1e-12)
    assert (plain.conditions.load_balance, with_friction.conditions.load_balance) == ("frictionless", "frictional")
    assert "friction in the torque balance" not in with_friction.skipped
    # the gear drives: friction points the other way, input and output change places
    back = mesh_efficiency(loaded, model, OIL, replace(OPERATION, driver="gear"), "frictional")
    assert back.efficiency == pytest.approx((cos_a - signed * t1) / (cos_a - signed * t2), rel=1e-12)
    assert back.power_output == pytest.approx(100.0 * OPERATION.speed, rel=1e-14)


def flank_forces(mesh: Mesh, load: PositionLoad, mu: np.ndarray, driver: str) -> tuple[float, float, float]:
    """Torques about both axes and the loss per pinion speed, of force vectors summed point by point.

    Own route: velocities are omega x r of both members, friction on each points against its sliding over the other.
    """
    axes, p = mesh.grids.axes, load.position
    teeth = mesh.design.pinion.blank.teeth / mesh.design.gear.blank.teeth
    spin = 1.0 if driver == "pinion" else -1.0
    arms = [p.position - axis.origin for axis in axes]
    turns = [np.cross(axis.direction, arm) for axis, arm in zip(axes, arms, strict=True)]
    # both turn so that the flanks stay in touch: equal velocities along the normal
    sense = -np.sign(np.mean(np.sum(turns[1] * p.normal, axis=1)) * np.mean(np.sum(turns[0] * p.normal, axis=1)))
    slip = spin * (turns[0] + sense * teeth * turns[1])
    slip -= np.sum(slip * p.normal, axis=1)[:, None] * p.normal
    size = np.linalg.norm(slip, axis=1)[:, None]
    # normal force on the gear: what turns it the way it goes when the pinion drives
    out_of_pinion = p.normal * np.sign(np.mean(np.sum(turns[0] * p.normal, axis=1)))
    on_gear = load.force[:, None] * (out_of_pinion + mu[:, None] * slip / np.where(size > 0.0, size, 1.0))
    torques = [float(np.sum(np.cross(arm, on_gear) @ axis.direction)) for axis, arm in zip(axes, arms, strict=True)]
    loss = float(np.sum(mu * load.force * size[:, 0]))
    return abs(torques[0]), abs(torques[1]) * teeth, loss


def with_everywhere(load: LoadDistribution, mu: np.ndarray) -> list[np.ndarray]:
    """Friction of the loaded points at all points of each position."""
    every = [np.zeros(p.force.size) for p in load.positions]
    for k, i, value in zip(load.loaded_position, load.loaded_index, mu, strict=True):
        every[k][i] = value
    return every


def iterated(mesh: Mesh, torque: float, model: FrictionModel, operation: Operation) -> tuple[float, float]:
    """Efficiency by full solutions of the load until force vectors carry the torque, and its last change."""
    grids = load_grids(mesh.grids, torque).mesh
    wanted, before = np.full(len(grids.fine), torque), math.nan
    for _ in range(12):
        load = distribute_load(grids.elastic_fine, grids.teeth, torque, normal_torques=wanted)
        points = loaded_points(load, grids.teeth.effective_modulus, operation)
        friction = with_everywhere(load, model.mu(points.state, oil=OIL).mu)
        sums = [flank_forces(mesh, p, mu, operation.driver) for p, mu in zip(load.positions, friction, strict=True)]
        carried, _, lost = (np.array(part) for part in zip(*sums, strict=True))
        wanted = wanted * torque / carried
        loss = float(lost.mean()) / torque
        efficiency = 1.0 - loss if operation.driver == "pinion" else 1.0 / (1.0 + loss)
        if abs(efficiency - before) < 1e-11:
            break
        before = efficiency
    return efficiency, abs(efficiency - before)


PAIRS = ("fm_spiral_bevel_14x39", "fh_hypoid_9x34", "fh_hypoid_9x34_offset_10", "fm_hypoid_13x42")


@cache
def small(name: str) -> Mesh:
    return Mesh.of(load_design(name), "drive", 6, 15, keep=True)


@pytest.mark.parametrize("driver", ["pinion", "gear"])
@pytest.mark.parametrize("name", PAIRS)
def test_default_is_the_balance_by_an_independent_route(name: str, driver: Driver) -> None:
    """Full solutions iterated with force vectors: within 1e-4 points and within the stated error of the shortcut."""
    mesh = small(name)
    for torque, speed, model in (
        (300.0, 125.0, friction_model("75w90")),
        (60.0, 20.0, friction_model("75w90")),
        (150.0, 300.0, friction_model("xu_kahraman_2007")),
        (300.0, 100.0, ConstantFriction(0.11)),
    ):
        operation = Operation(speed, 363.15, 0.4e-6, 0.4e-6, driver)
        result = mesh_efficiency(load_grids(mesh.grids, torque), model, OIL, operation, "frictional")
        expected, change = iterated(mesh, torque, model, operation)
        assert change < 1e-10
        assert abs(result.efficiency - expected) < 1e-6
        assert abs(result.efficiency - expected) <= 1.5 * result.errors.balance
        assert result.errors.balance < 1e-6
        # force vectors about both axes at every position: energy in is energy out and loss
        assert result.solution.torque_residual < 1e-13
        every = with_everywhere(result.load, result.friction.mu)
        for k, (load, mu) in enumerate(zip(result.load.positions, every, strict=True)):
            about_pinion, about_gear, lost = flank_forces(mesh, load, mu, driver)
            assert about_pinion == pytest.approx(torque, rel=1e-10)
            ends = (about_pinion, about_gear) if driver == "pinion" else (about_gear, about_pinion)
            assert ends[0] == pytest.approx(ends[1] + lost, rel=1e-10)
            assert lost * speed == pytest.approx(result.cycle.power_loss[k], rel=1e-10)
        assert result.power_input == pytest.approx(result.power_output + result.power_loss, rel=1e-14)
        # one of many points is from fewer solutions; the stated error covers the difference
        run = balanced_efficiency(load_grids(mesh.grids, torque), model, OIL, operation, "frictional", many=True)
        [fast] = solve_friction([run], model, OIL)
        assert abs(fast.efficiency - expected) <= fast.errors.balance < 1e-4


def test_self_locking_is_a_status() -> None:
    """mu tan b1 > cos a with sliding along the pinion's motion: friction alone turns the gear, no torque is needed."""
    mesh = pitch_point(math.radians(60.0), math.radians(80.0), 0.35)
    result = mesh_efficiency(load_grids(mesh, 50.0), ConstantFriction(0.6), OIL, OPERATION, "frictional")
    assert (result.status, result.reason) == ("failed", "self_locking")
    assert math.isnan(result.efficiency)
    assert math.isnan(result.power_loss)
    assert any("friction exceeds the pinion torque" in note for note in result.notes)


def test_axes_and_a_friction_coefficient_are_needed() -> None:
    mesh, case = pitch_point(0.8, 0.4, 0.35), (OIL, OPERATION, "frictional")
    with pytest.raises(InputError, match=r"mesh\.axes"):
        mesh_efficiency(load_grids(replace(mesh, axes=None), 50.0), ConstantFriction(0.05), *case)
    nothing = mesh_efficiency(load_grids(mesh, 50.0), ConstantFriction(math.nan), *case)
    assert (nothing.status, nothing.reason) == ("failed", "friction_undefined")


def test_a_map_does_not_depend_on_the_order_of_its_points() -> None:
    """Loads are interpolated from few solutions and do not depend on the order of the points."""
    torques, speeds = [100.0, 300.0], [20.0, 300.0]
    one = small("fh_hypoid_9x34").over("75w90", torque=torques, speed=speeds).values()
    fresh = Mesh.of(load_design("fh_hypoid_9x34"), "drive", 6, 15, keep=True)
    other = fresh.over("75w90", torque=torques[::-1], speed=speeds[::-1]).values()[::-1, ::-1]
    np.testing.assert_allclose(one, other, rtol=1e-9)


@pytest.mark.parametrize("kind", ["fm_spiral_bevel_14x39", "fm_hypoid_13x42", "fh_spiral_bevel_12x37"])
def test_interval_of_the_formula_contains_solved_contacts(kind: str) -> None:
    loaded = efficiency.load(f"{kind}_relieved").mesh(positions=6, points_per_line=11).load()
    formula = loaded.efficiency()
    solved = loaded.efficiency(EhlFriction("ehl", points=24, jobs=1))
    assert solved.solution.contacts >= 20
    assert formula.outside_range_share < 0.01
    assert formula.efficiency_lower < solved.efficiency < formula.efficiency_upper
    assert solved.efficiency_lower < formula.efficiency < solved.efficiency_upper


SPIRALS, CONES = (math.radians(48.0), math.radians(22.0)), (math.radians(25.0), math.radians(63.0))
WITHOUT_HEIGHT = PitchGeometry(math.radians(20.0), SPIRALS, CONES, (0.03, 0.085), 1e-8, contact_ratio_profile=1.2)


@pytest.mark.parametrize("mu", [0.02, 0.08])
def test_closed_forms_without_profile_sliding(mu: float) -> None:
    """Teeth of vanishing height: both become the lengthwise identity; the frictionless one differs by mu squared."""
    pair = WITHOUT_HEIGHT
    exact = lengthwise_sliding(pair, mu)
    assert coleman_type(pair, mu) == pytest.approx(exact, abs=1e-6)
    assert buckingham_type(pair, mu) == pytest.approx(exact, abs=1e-6)
    tangents = math.tan(math.radians(48.0)) - math.tan(math.radians(22.0))
    cos_n = math.cos(math.radians(20.0))
    linear = 1.0 - mu * tangents / cos_n
    assert abs(exact - linear) < 2.0 * mu**2


def test_a_driving_gear_is_the_pinion_with_friction_reversed() -> None:
    """eta = (cos a - mu tan b1)/(cos a - mu tan b2), and both ways there and back lose alike to first order."""
    pair = WITHOUT_HEIGHT
    back = lengthwise_sliding(pair, 0.05, driver="gear")
    cos_n, t1, t2 = (math.cos(math.radians(20.0)), math.tan(math.radians(48.0)), math.tan(math.radians(22.0)))
    assert back == pytest.approx((cos_n - 0.05 * t1) / (cos_n - 0.05 * t2), rel=1e-14)
    assert back == pytest.approx(1.0 / (1.0 + 0.05 * (t1 - t2) / cos_n), abs=2.0 * 0.05**2)
    for form in (coleman_type, buckingham_type):
        assert form(pair, 0.05, "gear") == pytest.approx(back, abs=1e-6)
