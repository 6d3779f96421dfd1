"""Friction in the load equilibrium against the exact pitch point of a hypoid pair, and the energy balance."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from efficiency.contact.contact_lines import MeshPosition
from efficiency.contact.tooth_grid import ToothShape
from efficiency.design.design import load_design
from efficiency.loss.efficiency import MeshGrids, load_grids, mesh_efficiency
from efficiency.loss.friction_equilibrium import friction_arm, load_grids_with_friction
from efficiency.loss.kinematics import Axis, Operation
from efficiency.ltca.load_distribution import TeethElasticity
from efficiency.ltca.plate import PlateTooth
from efficiency.pair import Mesh
from ehl.fluid.oil import Oil
from ehl.io.errors import ConvergenceError, InputError
from ehl.material import Material
from regression.formula import friction_model
from regression.friction.models import ConstantFriction

OIL = Oil.load("75w90")
OPERATION = Operation(100.0, 363.15)
STEEL = Material.load("steel")


def pitch_point(spiral_1: float, spiral_2: float, pressure: float) -> MeshGrids:
    """Contact at the pitch point only: x across the teeth, y along them, z off the pitch plane.

    Both members move at the same speed along x; along y they differ by the tangents of their spiral angles.
    """
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

    def rows(vector: np.ndarray) -> np.ndarray:
        return np.tile(vector, (n, 1))

    position = MeshPosition(
        pinion_angle=0.0,
        pair=np.zeros(n, np.int64),
        position=np.zeros((n, 3)),
        normal=rows(normal),
        along=rows(np.array([0.0, 1.0, 0.0])),
        across=rows(np.array([-math.sin(pressure), 0.0, math.cos(pressure)])),
        length=np.full(n, 2e-3),
        gap=np.zeros(n),
        radius_equivalent=np.full(n, 0.012),
        lever_pinion=np.full(n, normal @ velocity_1),
        lever_gear=np.full(n, normal @ velocity_2 / ratio),
        sliding_along=np.full(n, velocity_1[1] - velocity_2[1]),
        sliding_across=np.zeros(n),
        entrainment=np.full(n, 0.01),
        height_gear=np.full(n, 3e-3),
        height_pinion=np.full(n, 3e-3),
        face_gear=np.linspace(8e-3, 12e-3, n),
        face_pinion=np.linspace(8e-3, 12e-3, n),
        transmission_error=0.0,
    )
    shape = ToothShape(10, np.array([0.0, 0.02]), np.full(2, 7e-3), np.full(2, 6e-3), np.full(2, 2.5e-3))
    tooth = PlateTooth.from_shape(shape, 0.0, pressure, STEEL)
    cycle = tuple(replace(position, pinion_angle=0.1 * k) for k in range(4))
    return MeshGrids("pitch point", "drive", cycle, cycle, TeethElasticity(tooth, tooth, STEEL, STEEL), n, tuple(axes))


@pytest.mark.parametrize("mu", [0.01, 0.05, 0.12])
@pytest.mark.parametrize(("b1", "b2"), [(50.0, 30.0), (45.0, 21.0), (35.0, 35.0), (20.0, 40.0)])
def test_hypoid_pitch_point_is_exact(mu: float, b1: float, b2: float) -> None:
    """eta = (cos a + mu tan b2)/(cos a + mu tan b1), and 1 - mu (tan b1 - tan b2)/cos a without friction in it.

    With the larger spiral angle on the gear the friction pushes the other way: |sliding| and mu change sign.
    """
    pressure, t1, t2 = math.radians(20.0), math.tan(math.radians(b1)), math.tan(math.radians(b2))
    mesh = pitch_point(math.radians(b1), math.radians(b2), pressure)
    model, cos_a = ConstantFriction(mu), math.cos(pressure)
    plain = mesh_efficiency(load_grids(mesh, 100.0), model, OIL, OPERATION)
    assert plain.efficiency == pytest.approx(1.0 - mu * abs(t1 - t2) / cos_a, rel=1e-12)
    loaded = load_grids_with_friction(mesh, 100.0, model, OIL, OPERATION)
    with_friction = mesh_efficiency(loaded, model, OIL, OPERATION)
    signed = math.copysign(mu, t1 - t2)
    assert with_friction.efficiency == pytest.approx((cos_a + signed * t2) / (cos_a + signed * t1), rel=1e-9)
    assert with_friction.friction_in_equilibrium
    assert "friction in the load equilibrium" not in with_friction.skipped


@pytest.mark.parametrize(("b1", "b2"), [(50.0, 30.0), (20.0, 40.0)])
def test_hypoid_pitch_point_with_the_gear_driving(b1: float, b2: float) -> None:
    """eta = (cos a - mu tan b1)/(cos a - mu tan b2): friction points the other way, input and output change places."""
    pressure, t1, t2 = math.radians(20.0), math.tan(math.radians(b1)), math.tan(math.radians(b2))
    mesh = pitch_point(math.radians(b1), math.radians(b2), pressure)
    model, cos_a, operation = ConstantFriction(0.05), math.cos(pressure), replace(OPERATION, driver="gear")
    result = mesh_efficiency(load_grids_with_friction(mesh, 100.0, model, OIL, operation), model, OIL, operation)
    signed = math.copysign(0.05, t1 - t2)
    assert result.efficiency == pytest.approx((cos_a - signed * t1) / (cos_a - signed * t2), rel=1e-9)
    assert result.power_output == pytest.approx(100.0 * OPERATION.speed_pinion, rel=1e-14)


def test_energy_balance_of_a_real_pair() -> None:
    """What goes in at the pinion less what comes out at the gear is the sum of mu F |v_s|."""
    mesh = Mesh.of(load_design("fm_spiral_bevel_14x39"), "drive", 4, 11).grids
    assert mesh.axes is not None
    model = friction_model("xu_kahraman_2007")
    loaded = load_grids_with_friction(mesh, 300.0, model, OIL, OPERATION)
    result = mesh_efficiency(loaded, model, OIL, OPERATION)
    for k, load in enumerate(loaded.fine.positions):
        here = result.points.position == k
        at, mu = result.points.index[here], result.friction.mu[here]
        p = load.position
        arm_pinion, arm_gear = (friction_arm(p, axis)[at] for axis in mesh.axes)
        torque_in = load.force[at] @ (p.lever_pinion[at] + mu * arm_pinion)
        torque_out = load.force[at] @ (p.lever_gear[at] + mu * arm_gear)
        assert torque_in == pytest.approx(300.0, rel=1e-9)
        lost = (torque_in - torque_out * 14 / 39) * OPERATION.speed_pinion
        assert lost == pytest.approx(result.power_loss_positions[k], rel=1e-9)
    plain = mesh_efficiency(load_grids(mesh, 300.0), model, OIL, OPERATION)
    assert result.power_loss == pytest.approx(plain.power_loss, rel=0.03)
    assert result.power_loss != plain.power_loss


def test_no_friction_changes_nothing() -> None:
    mesh = pitch_point(0.8, 0.4, 0.35)
    model = ConstantFriction(0.0)
    assert (
        mesh_efficiency(load_grids_with_friction(mesh, 50.0, model, OIL, OPERATION), model, OIL, OPERATION).efficiency
        == 1.0
    )


def test_self_locking_is_said() -> None:
    """mu tan b1 > cos a with sliding along the pinion's motion: friction alone turns the gear, no torque is needed."""
    mesh = pitch_point(math.radians(60.0), math.radians(80.0), 0.35)
    with pytest.raises(ConvergenceError, match="self_locking"):
        load_grids_with_friction(mesh, 50.0, ConstantFriction(0.6), OIL, OPERATION)


def test_axes_are_needed() -> None:
    mesh = replace(pitch_point(0.8, 0.4, 0.35), axes=None)
    with pytest.raises(InputError, match=r"mesh\.axes"):
        load_grids_with_friction(mesh, 50.0, ConstantFriction(0.05), OIL, OPERATION)


def test_friction_without_a_value_is_said() -> None:
    with pytest.raises(ConvergenceError, match="friction_undefined"):
        load_grids_with_friction(pitch_point(0.8, 0.4, 0.35), 50.0, ConstantFriction(math.nan), OIL, OPERATION)
