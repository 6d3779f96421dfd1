"""Loss, result, map and what they refuse, on a small real mesh."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass

import numpy as np
import pytest

from efficiency import efficiency as stage
from efficiency.design import load_design
from efficiency.efficiency import LoadedMesh, Mesh, load_mesh, mesh_efficiency
from efficiency.gear_mesh import gear_mesh
from efficiency.kinematics import LoadedPoints, Operation, join_states
from efficiency.load_distribution import distribute_load
from efficiency.loss import efficiency_of, position_losses
from efficiency.map import efficiency_map
from efficiency.plots_load import (
    plot_comparison,
    plot_flank_pressure,
    plot_friction_and_loss,
    plot_load_sharing,
    plot_map,
    plot_transmission_error,
)
from efficiency.run import Conditions, run_compare, run_gear, run_map
from ehl.errors import InputError
from ehl.oil import Oil
from ehl.state import ContactState
from regression.friction_models import ConstantFriction, FrictionEstimate, FrictionFlag

DESIGN = load_design("fm_spiral_bevel_14x39")
OIL = Oil.load("75w90")
OPERATION = Operation(125.0, 363.15, 0.4e-6, 0.4e-6)


@dataclass(frozen=True)
class FromPressure:
    """mu proportional to pressure, with an interval of 10 % and flags above a pressure."""

    name: str = "test"
    limit: float = 1e9
    worse: FrictionFlag = FrictionFlag.OUTSIDE_RANGE

    def evaluate(self, state: ContactState, oil: Oil) -> FrictionEstimate:
        mu = 0.05 * state.pressure_hertz / 1e9
        beyond = state.pressure_hertz > self.limit
        if self.worse is FrictionFlag.NOT_CONVERGED:
            mu = np.where(beyond, np.nan, mu)
        return FrictionEstimate(mu, 0.9 * mu, 1.1 * mu, np.where(beyond, self.worse, 0).astype(np.int8))


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    return gear_mesh(DESIGN, "drive", 4, 9).mesh


@pytest.fixture(scope="module")
def loaded(mesh: Mesh) -> LoadedMesh:
    return load_mesh(mesh, 200.0)


def test_power_is_friction_force_times_sliding_speed() -> None:
    state = ContactState.of(
        pressure_hertz=[1e9, 1e9, 1e9], radius_equivalent=0.01, effective_modulus=226e9, speed_entrainment=2.0
    )
    points = LoadedPoints(
        state, np.array([100.0, 50.0, 10.0]), np.array([1.0, 2.0, 3.0]), np.array([0, 0, 2]), np.array([0, 1, 0])
    )
    np.testing.assert_allclose(position_losses(points, np.array([0.1, 0.05, 0.2]), 3), [15.0, 0.0, 6.0])
    assert efficiency_of(7.0, 10.0, 7.0) == pytest.approx(0.9)


def test_interval_of_the_friction_model_becomes_one_of_the_efficiency(loaded: LoadedMesh) -> None:
    result = mesh_efficiency(loaded, FromPressure(), OIL, OPERATION)
    loss = 1.0 - result.efficiency
    assert 1.0 - result.efficiency_lower == pytest.approx(1.1 * loss, rel=1e-12)
    assert 1.0 - result.efficiency_upper == pytest.approx(0.9 * loss, rel=1e-12)


def test_points_outside_the_range_are_told(loaded: LoadedMesh) -> None:
    result = mesh_efficiency(loaded, FromPressure(), OIL, OPERATION)
    pressure = result.points.state.pressure_hertz
    power = result.points.force * result.points.speed_sliding
    assert result.outside_range_share == pytest.approx(power[pressure > 1e9].sum() / power.sum())
    assert result.flags["outside_range"] == np.count_nonzero(pressure > 1e9) > 0
    assert result.status == "converged"


def test_missing_friction_is_a_failure_not_a_number(loaded: LoadedMesh) -> None:
    result = mesh_efficiency(loaded, FromPressure(worse=FrictionFlag.NOT_CONVERGED), OIL, OPERATION)
    assert (result.status, result.reason) == ("failed", "friction_not_converged")
    assert math.isnan(result.efficiency)
    assert result.to_dict()["efficiency"] is None


def test_failed_load_is_a_failure(mesh: Mesh, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("efficiency.equilibrium.NEWTON_LIMIT", 1)
    result = mesh_efficiency(load_mesh(mesh, 200.0), ConstantFriction(0.05), OIL, OPERATION)
    assert (result.status, result.reason) == ("failed", "load_newton_limit")


def test_result_is_json(loaded: LoadedMesh) -> None:
    content = mesh_efficiency(loaded, ConstantFriction(0.05), OIL, OPERATION).to_dict()
    assert json.loads(json.dumps(content)) == content
    assert content["speed_pinion"] == 125.0
    assert len(content["power_loss_positions"]) == content["positions"] == 4
    assert content["power_loss"] == pytest.approx((1.0 - content["efficiency"]) * content["power_input"])
    assert set(content["ranges"]) == set(stage.RANGES)


def test_faster_is_the_same_share_of_loss_for_constant_friction(loaded: LoadedMesh) -> None:
    slow, fast = (
        mesh_efficiency(loaded, ConstantFriction(0.05), OIL, Operation(speed, 363.15)) for speed in (10.0, 400.0)
    )
    assert fast.efficiency == pytest.approx(slow.efficiency, rel=1e-13)
    assert fast.power_loss == pytest.approx(40.0 * slow.power_loss, rel=1e-12)


@pytest.mark.parametrize("torque", [0.0, -300.0, float("nan"), float("inf")])
def test_impossible_torque_is_refused(mesh: Mesh, torque: float) -> None:
    with pytest.raises(InputError, match=r"torque = .* above 0 N m"):
        distribute_load(mesh.fine, mesh.teeth, torque)
    with pytest.raises(InputError, match="torque"):
        run_gear(DESIGN, conditions=Conditions(torque=torque))


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan")])
def test_impossible_speed_is_refused(speed: float) -> None:
    with pytest.raises(InputError, match="speed"):
        run_gear(DESIGN, conditions=Conditions(speed=speed))


@pytest.mark.parametrize("temperature", [90.0, 600.0, float("nan")])
def test_impossible_temperature_is_refused(temperature: float) -> None:
    with pytest.raises(InputError, match=r"temperature.*K"):
        run_gear(DESIGN, conditions=Conditions(temperature_oil=temperature))


def test_impossible_roughness_is_refused() -> None:
    with pytest.raises(InputError, match="roughness_rms_gear"):
        Operation(100.0, 363.15, 0.0, -1e-7)


@pytest.mark.parametrize(("positions", "points"), [(5, 9), (2, 9), (4, 3)])
def test_impossible_resolution_is_refused(positions: int, points: int) -> None:
    with pytest.raises(InputError, match=r"positions|points_per_line"):
        run_gear(DESIGN, positions=positions, points_per_line=points)


def test_names_are_checked_before_anything_is_computed() -> None:
    with pytest.raises(InputError, match="friction model"):
        run_gear(DESIGN, "coulomb")
    with pytest.raises(InputError, match="friction model"):
        run_gear(DESIGN, "ehl:rough")
    with pytest.raises(InputError, match="oil"):
        run_gear(DESIGN, conditions=Conditions(oil="butter"))
    with pytest.raises(InputError, match="design"):
        run_gear("no_such_design")


def test_join_states_keeps_order() -> None:
    one = ContactState.of(
        pressure_hertz=[1e9, 2e9], radius_equivalent=0.01, effective_modulus=2e11, speed_entrainment=1.0
    )
    other = ContactState.of(pressure_hertz=[3e9], radius_equivalent=0.02, effective_modulus=2e11, speed_entrainment=1.0)
    both = join_states(one, other)
    np.testing.assert_array_equal(both.pressure_hertz, [1e9, 2e9, 3e9])
    np.testing.assert_array_equal(both.radius_equivalent, [0.01, 0.01, 0.02])


def test_run_functions_agree_and_figures_show_the_result(mesh: Mesh) -> None:
    result = run_gear(DESIGN, "xu_kahraman_2007", positions=4, points_per_line=9)
    assert result.torque_pinion == DESIGN.operation.torque
    comparison = run_compare(DESIGN, ("xu_kahraman_2007",), positions=4, points_per_line=9)
    assert comparison.rows[0].efficiency == result.efficiency
    assert len(comparison.rows) == 3
    map_ = run_map(DESIGN, "xu_kahraman_2007", [300.0, 100.0], [], [333.15, 363.15], positions=4, points_per_line=9)
    assert map_.shape == (2, 1, 2)
    assert map_.values()[0, 0, 1] == result.efficiency
    assert json.dumps(map_.to_dict())

    assert plot_flank_pressure(result).axes[0].collections
    sharing = plot_load_sharing(result).axes[0].lines[0].get_ydata()
    assert np.max(sharing) == pytest.approx(max(max(p.share.values()) for p in result.load.positions))
    assert len(plot_transmission_error(result).axes[0].lines) == 2
    loss = plot_friction_and_loss(result).axes[1].lines[0].get_ydata()
    np.testing.assert_array_equal(loss, result.power_loss_positions)
    assert len(plot_comparison(comparison).axes[0].patches) == 3
    assert [len(axes.lines) for axes in plot_map(map_).axes] == [2, 2]


def test_map_refuses_an_empty_list_and_reports_progress(mesh: Mesh) -> None:
    seen: list[tuple[int, int]] = []
    arguments = (mesh, ConstantFriction(0.05), OIL, [100.0, 200.0], lambda s, t: Operation(s, t))
    efficiency_map(*arguments, [100.0], [363.15], lambda done, total: seen.append((done, total)))
    assert seen == [(1, 2), (2, 2)]
    with pytest.raises(InputError, match="speed"):
        efficiency_map(*arguments, [], [363.15])
