"""Maps from few solved points: what is interpolated, how well, and when every point is solved."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import efficiency
from efficiency.conditions.grid import Evaluator, Grid
from efficiency.loss.efficiency_result import EfficiencyResult
from regression.formula import friction_model

MESH = efficiency.load("fm_spiral_bevel_14x39").mesh("drive", 4, 9)
MODEL = friction_model("xu_kahraman_2007")
TORQUE, SPEED = np.geomspace(60.0, 300.0, 11).tolist(), np.linspace(50.0, 300.0, 12).tolist()
RESULT = MESH.load(200.0).efficiency(MODEL)
# temperature comes from the design
POINTS = len(TORQUE) * len(SPEED)


@pytest.fixture(scope="module")
def maps() -> tuple[Any, Any]:
    """The map, and the same with every point solved."""
    few, every = (MESH.map(MODEL, TORQUE, SPEED, interval=True, every_point=every) for every in (False, True))
    return few, every


def test_interpolated_points_agree_with_solved_ones(maps: tuple[Any, Any]) -> None:
    few, every = maps
    between = np.array([bool(point.interpolated) for point in few.points]).reshape(few.shape)
    assert len(every.results) == POINTS
    assert len(few.results) == POINTS - between.sum() <= 0.5 * POINTS
    # solved points are those of the whole map
    assert np.all(few.values()[~between] == every.values()[~between])
    wrong = np.abs(few.values() - every.values())[between]
    assert np.all(wrong < few.values("efficiency_error")[between])
    assert np.all(few.values("efficiency_error")[between] > few.interpolation_error * (1.0 - few.values()[between]))
    loss = np.abs(np.log(few.values("power_loss") / every.values("power_loss")))[between]
    assert 0.0 < np.median(loss) < few.interpolation_error
    for name, tolerance in (
        ("friction_coefficient_mean", 1e-2),  # few points a line: the load itself is uneven over the torque
        ("power_loss_rolling", 1e-1),
        ("pressure_hertz_max", 3e-2),
        ("efficiency_with_rolling", 1e-4),
        ("power_input", 1e-12),
        ("power_output", 1e-3),
        ("efficiency_lower", 2e-4),
        ("efficiency_upper", 2e-4),
    ):
        np.testing.assert_allclose(
            few.values(name)[between], every.values(name)[between], rtol=tolerance, atol=0.0, err_msg=name
        )
    # edges carry from some torque on: between solved points nothing is stated of them
    assert np.isnan(few.values("pressure_edge")[between]).all()


def test_a_map_says_which_points_are_interpolated(maps: tuple[Any, Any]) -> None:
    few, every = maps
    content = json.loads(json.dumps(few.to_dict()))
    flags = [point["interpolated"] for point in content["points"]]
    assert sum(flags) == POINTS - len(few.results)
    assert content["interpolation_error"] == few.interpolation_error
    assert all(point["efficiency_lower"] < point["efficiency"] for point in content["points"])
    assert not any("strength" in point for point in content["points"])
    assert few.to_frame()["interpolated"].sum() == sum(flags)
    assert few.interpolation
    assert every.interpolation == ""
    assert not every.to_frame()["interpolated"].any()


def test_without_a_request_there_is_no_interval() -> None:
    grid = MESH.map(MODEL, [100.0, 200.0])
    assert "efficiency_lower" not in grid.to_dict()["points"][0]
    assert "inputs" not in grid.results[0].__dict__


def interpolated(axes: dict[str, list[float]], at: Any) -> Grid:
    return Evaluator(at).grid(axes, every_point=False)


def _solve(loss: Any, reason: Any = lambda torque: "") -> tuple[Any, list[float]]:
    """A solver of a law of the loss as a share of the power, and the torques it was called with."""
    called: list[float] = []

    def solve(conditions: Any) -> list[EfficiencyResult]:
        return [at(condition["torque"]) for condition in conditions]

    def at(torque: float) -> EfficiencyResult:
        called.append(torque)
        lost = torque * RESULT.conditions.speed * loss(torque)
        figures = {"power_loss": lost, "efficiency": 1.0 - loss(torque), "efficiency_error": 1e-9}
        conditions = replace(RESULT.conditions, torque=torque)
        return replace(RESULT, **figures, conditions=conditions, reason=reason(torque))

    return solve, called


def test_a_law_of_powers_is_exact() -> None:
    solve, called = _solve(lambda torque: 0.01 * (torque / 100.0) ** 0.3)
    grid = interpolated({"torque": TORQUE}, solve)
    assert len(called) < len(TORQUE)
    np.testing.assert_allclose(grid.values(), 1.0 - 0.01 * (np.array(TORQUE) / 100.0) ** 0.3, rtol=1e-12)


@pytest.mark.parametrize(
    ("loss", "reason"),
    [
        (lambda torque: 0.01 + 0.001 * np.sin(torque), lambda torque: ""),
        (lambda torque: 0.01, lambda torque: "self_locking" if torque > 290.0 else ""),
    ],
)
def test_where_interpolation_fails_every_point_is_solved(loss: Any, reason: Any) -> None:
    solve, called = _solve(loss, reason)
    grid = interpolated({"torque": TORQUE}, solve)
    assert sorted(called) == TORQUE
    assert grid.interpolation_error == 0.0
    np.testing.assert_array_equal(grid.values()[:-1], 1.0 - np.array([loss(torque) for torque in TORQUE[:-1]]))


@pytest.mark.parametrize("torques", [TORQUE[:9], [*TORQUE, TORQUE[3]]])
def test_short_axes_and_repeated_values_are_solved(torques: list[float]) -> None:
    solve, called = _solve(lambda torque: 0.01)
    interpolated({"torque": torques}, solve)
    assert sorted(called) == sorted(torques)


def test_values_in_any_order() -> None:
    solve, _ = _solve(lambda torque: 0.01 * (torque / 100.0) ** 0.3)
    mixed = TORQUE[::-1]
    np.testing.assert_allclose(
        interpolated({"torque": mixed}, solve).values(),
        interpolated({"torque": TORQUE}, solve).values()[::-1],
        rtol=1e-12,
    )


def test_a_kink_between_sparse_nodes_is_found() -> None:
    """Several values lie between the last nodes of a long axis; the error there is stated, or every point is solved."""
    torques = np.linspace(20.0, 400.0, 40).tolist()
    solve, called = _solve(lambda torque: 0.01 + 4e-6 * max(torque - 250.0, 0.0))
    grid = interpolated({"torque": torques}, solve)
    exact = 1.0 - np.array([0.01 + 4e-6 * max(torque - 250.0, 0.0) for torque in torques])
    assert np.mean(np.abs(grid.values() - exact) <= grid.values("efficiency_error")) >= 0.9
    assert len(called) == len(set(called))
