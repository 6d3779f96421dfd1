"""Error bars of the efficiency: every factor and every term, against numbers worked out apart."""

import math
from dataclasses import replace

import numpy as np
import pytest
from samples import AXLE_OIL as OIL
from samples import OPERATION, tiny_load

from efficiency.loss.efficiency import LoadedGrids, mesh_efficiency
from efficiency.loss.ehl_friction import EhlFriction, Solved, _friction
from efficiency.loss.kinematics import LoadedPoints, loaded_points
from efficiency.loss.power_loss import rolling_losses
from ehl.state import ContactState
from regression.friction.models import ConstantFriction, FrictionFlag

MU = 0.05


@pytest.fixture(scope="module")
def loaded() -> LoadedGrids:
    return tiny_load()


def loss_of(points: LoadedPoints, positions: int) -> float:
    """Mean power loss at a constant friction coefficient [W]."""
    return MU * float(points.force @ points.speed_sliding) / positions


@pytest.mark.parametrize("driver", ["pinion", "gear"])
def test_error_is_twice_what_half_the_positions_and_half_the_points_change(loaded: LoadedGrids, driver: str) -> None:
    operation = replace(OPERATION, driver=driver)
    result = mesh_efficiency(loaded, ConstantFriction(MU), OIL, operation)
    power = 200.0 * 125.0

    def efficiency_at(loss: float) -> float:
        return 1.0 - loss / power if driver == "pinion" else power / (power + loss)

    fine = loaded_points(loaded.fine, loaded.mesh.teeth.effective_modulus, operation)
    coarse = loaded_points(loaded.coarse, loaded.mesh.teeth.effective_modulus, operation)
    every = efficiency_at(loss_of(fine, 4))
    assert result.efficiency == pytest.approx(every, rel=1e-12)
    second = fine.position % 2 == 0
    half = efficiency_at(MU * float(fine.force[second] @ fine.speed_sliding[second]) / 2)
    fewer = efficiency_at(loss_of(coarse, 4))
    assert abs(half - every) > 1e-7
    assert abs(fewer - every) > 1e-7
    assert result.errors.positions == pytest.approx(2.0 * abs(half - every), rel=1e-9)
    assert result.errors.points == pytest.approx(2.0 * abs(fewer - every), rel=1e-9)
    assert result.efficiency_error == pytest.approx(2.0 * (abs(half - every) + abs(fewer - every)), rel=1e-9)


def solved(mu: np.ndarray, scatter: np.ndarray, bias: np.ndarray) -> Solved:
    rest = np.ones((4, mu.size))
    reasons = tuple("" if math.isfinite(value) else "film_jump" for value in mu)
    return Solved(np.vstack([mu, np.where(np.isfinite(mu), rest, np.nan)]), scatter, bias, reasons)


def test_error_of_the_mean_over_solved_contacts_by_hand() -> None:
    """Chance adds in squares, bias in a line: shares 1/2, 1/4, 1/4 of the sliding power.

    chance = sqrt((0.5 x 4)^2 + (0.25 x 8)^2 + (0.25 x 8)^2) 1e-4 = sqrt(12) 1e-4; bias = (0.5 + 0.5 + 0.75) 1e-3.
    """
    place, power = np.eye(3), np.array([2.0, 1.0, 1.0])
    mu, scatter = np.array([0.05, 0.04, 0.06]), np.array([4e-4, 8e-4, 8e-4])
    bias = np.array([1e-3, 2e-3, 3e-3])
    found = _friction(place, power, np.arange(3), solved(mu, scatter, bias))
    assert found.mean_error == pytest.approx((math.sqrt(12.0) * 1e-4 + 1.75e-3) / 0.05, rel=1e-12)
    np.testing.assert_allclose(found.upper - mu, scatter + bias, rtol=1e-12)
    np.testing.assert_allclose(mu - found.lower, scatter + bias, rtol=1e-12)
    assert np.all(found.flag == FrictionFlag.OK)


def test_a_contact_keeps_chance_and_bias_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 3 % of which 2 % are chance, 1 % is bias; both in units of mu."""
    from types import SimpleNamespace

    from efficiency.loss import ehl_friction as module

    def contact(*arguments: object) -> SimpleNamespace:
        return SimpleNamespace(
            status="converged", friction_coefficient=0.05, friction_error=0.03, statistical_error=0.02,
            film_central=1e-7, film_ratio=1.0, temperature_flash=360.0, rolling_traction=1e-4,
        )  # fmt: skip

    monkeypatch.setattr(module, "solve_contact", contact)
    state = ContactState.of(
        pressure_hertz=[1e9, 1e9], radius_equivalent=0.01, effective_modulus=226e9, speed_entrainment=3.0,
        slide_to_roll=0.2,
    )  # fmt: skip
    found = EhlFriction("ehl", jobs=1).mu(state, oil=OIL)
    np.testing.assert_allclose(found.upper - found.mu, 0.05 * 0.03, rtol=1e-12)
    # two equal contacts: chance over the root of two
    assert found.mean_error == pytest.approx(0.02 / math.sqrt(2.0) + 0.01, rel=1e-9)


def test_rolling_loss_is_the_work_on_both_surfaces(loaded: LoadedGrids) -> None:
    """2 t_r F u_r at each point: 2 x 1e-3 x 100 x 2 and 2 x 2e-3 x 50 x 2."""
    state = ContactState.of(
        pressure_hertz=[1e9, 1e9], radius_equivalent=0.01, effective_modulus=226e9, speed_entrainment=2.0
    )
    points = LoadedPoints(state, np.array([100.0, 50.0]), np.ones(2), np.array([0, 2]), np.array([0, 0]))
    np.testing.assert_allclose(rolling_losses(points, np.array([1e-3, 2e-3]), 3), [0.4, 0.0, 0.4], rtol=1e-12)
    result = mesh_efficiency(loaded, ConstantFriction(MU), OIL, OPERATION)
    assert result.power_loss_rolling == pytest.approx(result.cycle.power_loss_rolling.mean(), rel=1e-12)
    lost = (result.efficiency - result.efficiency_with_rolling) * result.power_input
    assert lost == pytest.approx(result.power_loss_rolling, rel=1e-9)


def test_ranges_of_a_result_run_from_the_smallest_to_the_largest_value(loaded: LoadedGrids) -> None:
    result = mesh_efficiency(loaded, ConstantFriction(MU), OIL, OPERATION)
    pressure = result.points.state.pressure_hertz
    assert result.friction_range.ranges["pressure_hertz"] == (pressure.min(), pressure.max())
    assert all(low <= high for low, high in result.friction_range.ranges.values())
    backwards = mesh_efficiency(loaded, ConstantFriction(MU), OIL, replace(OPERATION, driver="gear"))
    assert backwards.power_input == pytest.approx(200.0 * 125.0 + backwards.power_loss, rel=1e-12)
    assert backwards.power_output == pytest.approx(200.0 * 125.0, rel=1e-12)
