"""Energies of a duty cycle, and efficiency over any axes: each geometry and each load once.

Maps from few solved points: what is interpolated, how well, and when every point is solved.
"""

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refuses

import efficiency
import efficiency.mesh
import regression
from efficiency.conditions.conditions import split_axes
from efficiency.conditions.duty import DutyRow
from efficiency.conditions.grid import Evaluator, Grid, _largest, _nodes
from efficiency.design.design import load_design
from efficiency.loss.efficiency import load_grids
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.mesh import Mesh
from efficiency.output.tables import map_table
from efficiency.pair import GearPair
from ehl.common.data import reason_text
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.progress import Progress
from regression.formula import friction_model

DESIGN = load_design("fm_spiral_bevel_14x39")
PAIR, GRID = GearPair(DESIGN), (4, 9)
MODEL = friction_model("xu_kahraman_2007")


@pytest.fixture
def loads(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Torques whose load is distributed."""
    torques: list[float] = []

    def counted(grids: Any, torque: float) -> Any:
        torques.append(torque)
        return load_grids(grids, torque)

    monkeypatch.setattr(efficiency.mesh, "load_grids", counted)
    return torques


def test_energies_add_up(loads: list[float]) -> None:
    rows = [DutyRow(200.0, 125.0, 363.15, 2.0), DutyRow(-80.0, 200.0, 353.15, 0.5), DutyRow(200.0, 60.0, 343.15, 1.0)]
    cycle = GearPair(DESIGN).duty(rows, MODEL, grid=GRID)
    assert loads == [200.0, 80.0]
    first, coast, _ = cycle.rows
    single = PAIR.mesh("drive", *GRID).load(200.0).efficiency(MODEL, speed=125.0, temperature=363.15, many=True)
    assert first.efficiency == single.efficiency
    assert first.energy_input == pytest.approx(200.0 * 125.0 * 7200.0, rel=1e-12)
    # on the coast side the gear drives, and what the pinion takes off is the output
    assert (coast.side, coast.driver) == ("coast", "gear")
    assert coast.energy_output == pytest.approx(80.0 * 200.0 * 1800.0, rel=1e-12)
    for row in cycle.rows:
        assert row.energy_input == pytest.approx(row.energy_output + row.energy_loss, rel=1e-14)
        assert row.efficiency == pytest.approx(row.energy_output / row.energy_input, rel=1e-12)
    assert cycle.efficiency == pytest.approx(1.0 - cycle.total("energy_loss") / cycle.total("energy_input"), rel=1e-14)
    content = cycle.to_dict()
    assert json.loads(json.dumps(content)) == content
    assert content["total"]["hours"] == 3.5
    assert list(cycle.to_frame()["side"]) == ["drive", "coast", "drive"]


def test_a_failed_row_is_no_number() -> None:
    broken = replace(MODEL, local=lambda c, base: np.full(c["film_formula"].shape, np.nan))
    cycle = PAIR.duty([DutyRow(200.0, 125.0, 363.15, 2.0)], broken, grid=GRID)
    assert (cycle.status, cycle.reason) == ("failed", f"1 of 1 rows: {reason_text('friction_undefined')}")
    assert cycle.to_dict()["total"]["efficiency"] is None


def test_axes_in_any_order_and_each_load_once(loads: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[float] = []
    true = Mesh.of

    def make_mesh(design: Any, *arguments: Any) -> Mesh:
        made.append(design.assembly.misalignment.E)
        if design.assembly.misalignment.E > 0.0:
            raise ConvergenceError("no_contact")
        return true(design, *arguments)

    monkeypatch.setattr(Mesh, "of", make_mesh)
    axes = {
        "temperature": [333.15, 363.15],
        "E": [0.0, 1e-3],
        "torque": [100.0, 200.0],
        "roughness_rms_each": [2e-7, 4e-7],
    }
    done: list[Progress] = []
    found = GearPair(DESIGN).over(MODEL, grid=GRID, progress=done.append, **axes)
    assert found.shape == (2, 2, 2, 2)
    assert made[0] == 0.0
    assert loads == [100.0, 200.0]
    assert done[-1] == Progress("points", 16, 16)
    values = found.values()
    loaded = PAIR.mesh("drive", *GRID).load(200.0)
    expected = loaded.efficiency(MODEL, temperature=363.15, roughness_rms_each=4e-7, many=True)
    assert values[1, 0, 1, 1] == expected.efficiency
    # a geometry that does not mesh is a reason at its points
    assert np.isnan(values[:, 1]).all()
    assert np.isfinite(values[:, 0]).all()
    assert found.reason == f"8 of 16 points: {reason_text('no_contact')}"
    assert json.dumps(found.to_dict())
    frame = found.to_frame()
    assert len(frame) == 16
    assert set(frame["status"]) == {"converged", "failed"}
    # what reaches the reader of a single point comes with every point of a grid
    assert {"outside_range_share", "notes", "reason"} <= set(frame.columns)


def test_grid_of_a_pair_is_the_single_run() -> None:
    found = PAIR.over(MODEL, grid=GRID, torque=150.0, P=["0.05 mm"], speed=[60.0, 125.0])
    single = GearPair(DESIGN.with_misalignment(P=5e-5), keep=True).at(MODEL, grid=GRID, torque=150.0, speed=125.0)
    # one of many points: torque balance and bulk temperature from fewer contact points
    assert abs(found.values()[0, 1] - single.efficiency) < 1e-5
    assert found.results[1].errors.balance < 1e-5
    assert found.axes == {"P": (5e-5,), "speed": (60.0, 125.0)}
    assert split_axes({"torque": "100; 200 N m", "speed": "60 rad/s"}) == ({"torque": [100.0, 200.0]}, {"speed": 60.0})


@pytest.mark.parametrize(
    ("axes", "words"),
    [
        ({"offset": [1.0]}, "one of design, side, E"),
        ({"torque": []}, "at least one value"),
        ({"torque": [-1.0]}, "above 0"),
        ({"torque": "100:200 N m"}, "from:to:number unit"),
        ({"roughness_rms_each": [1e-3]}, "roughness_rms_each"),
        ({"roughness_rms_each": [1e-7], "roughness_rms_gear": [1e-7]}, "roughness_rms_each"),
    ],
)
def test_bad_axes(axes: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        PAIR.over(MODEL, **axes)


def test_a_friction_model_is_a_name_a_path_or_a_model(tmp_path: Path) -> None:
    loaded = PAIR.mesh("drive", *GRID).load(200.0)
    formula = regression.friction_model("75w90")
    formula.save(tmp_path / "formula.json")
    assert loaded.efficiency(tmp_path / "formula.json").power_loss == loaded.efficiency(formula).power_loss
    assert len(loaded.compare("constant:0.05").rows) == len(loaded.compare(["constant:0.05"]).rows)
    with refuses("friction model"):
        loaded.efficiency(0.05)  # type: ignore[arg-type]
    with refuses("duty"):
        PAIR.duty([{"torque": 100.0}], MODEL, grid=GRID)  # type: ignore[list-item]


@pytest.mark.parametrize(
    "call",
    [
        lambda **rough: PAIR.at(MODEL, grid=GRID, **rough),
        lambda **rough: PAIR.over(MODEL, grid=GRID, **rough),
        lambda **rough: PAIR.duty([DutyRow(200.0, 125.0, 363.15, 2.0)], MODEL, grid=GRID, **rough),
        lambda **rough: PAIR.mesh("drive", *GRID).load(200.0).efficiency(MODEL, **rough),
        lambda **rough: efficiency.study([DESIGN], MODEL, grid=GRID, **rough),
    ],
)
def test_composite_roughness_is_refused(call: Any) -> None:
    """Rq of both surfaces together is no Rq of a flank: the message names the keywords of the flanks."""
    with pytest.raises(InputError) as error:
        call(roughness_rms="0.4 um")
    assert error.value.field == "roughness_rms"
    assert {"roughness_rms_each", "roughness_rms_pinion", "roughness_rms_gear"} <= set(
        error.value.allowed.replace(",", " ").split()
    )


def test_strength_of_a_map_and_a_point_without_a_result() -> None:
    """The grades of each point; a point that has no geometry leaves its cells empty."""

    def solve(conditions: Any) -> Any:
        if any(condition["torque"] > 300.0 for condition in conditions):
            raise ConvergenceError("no_contact", "no tooth pair can touch")
        return [PAIR.at(MODEL, grid=GRID, many=True, **condition) for condition in conditions]

    grid = Evaluator(solve, strength=True).grid({"torque": [200.0, 400.0]})
    solved, failed = map_table(grid).records()
    strength = grid.results[0].strength
    assert solved["strength"] == strength.status
    assert solved["safety_root_pinion"] == strength.safety_root_pinion
    assert failed["safety_root_pinion"] is None
    assert (failed["status"], failed["reason"]) == ("failed", "no_contact")
    assert "strength" not in map_table(PAIR.mesh("drive", *GRID).over(MODEL, torque=[200.0])).records()[0]


def test_ratios_over_a_duty_cycle() -> None:
    """With constants the ratio of the losses is nearly that of the constants, in every row and in total."""
    pair = efficiency.load("fm_spiral_bevel_14x39_relieved")
    rows = [DutyRow(torque, 100.0, 360.0, 1.0) for torque in (60.0, 200.0)]
    found = pair.compare(["constant:0.04", "constant:0.06"], 200.0, grid=(4, 9), duty=rows).rows
    low, high = found[0], found[1]
    assert (low.energy_factor, low.loss_factor) == (1.0, 1.0)
    ratios = np.array([high.loss_factor, high.energy_factor, high.energy_factor_min, high.energy_factor_max])
    np.testing.assert_allclose(ratios, 1.5, rtol=0.03)
    assert high.energy_factor_min <= high.energy_factor <= high.energy_factor_max
    cycle = pair.duty(rows, "constant:0.06", grid=(4, 9))
    assert high.energy_loss == pytest.approx(cycle.total("energy_loss"))
    assert np.isnan(next(row for row in found if row.kind == "closed form").energy_loss)


TORQUE, SPEED = np.geomspace(60.0, 300.0, 11).tolist(), np.linspace(50.0, 300.0, 12).tolist()
# temperature comes from the design
POINTS = len(TORQUE) * len(SPEED)


@pytest.fixture(scope="module")
def maps() -> tuple[Any, Any]:
    few, every = (
        PAIR.mesh("drive", *GRID).map(MODEL, TORQUE, SPEED, interval=True, every_point=every) for every in (False, True)
    )
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
    grid = PAIR.mesh("drive", *GRID).map(MODEL, [100.0, 200.0])
    assert "efficiency_lower" not in grid.to_dict()["points"][0]
    assert "inputs" not in grid.results[0].__dict__


def interpolated(axes: dict[str, list[float]], at: Any) -> Grid:
    return Evaluator(at).grid(axes, every_point=False)


def _solve(loss: Any, reason: Any = lambda torque: "") -> tuple[Any, list[float]]:
    """A solver of a law of the loss as a share of the power, and the torques it was called with."""
    called: list[float] = []
    result = PAIR.mesh("drive", *GRID).load(200.0).efficiency(MODEL)

    def solve(conditions: Any) -> list[EfficiencyResult]:
        return [at(condition["torque"]) for condition in conditions]

    def at(torque: float) -> EfficiencyResult:
        called.append(torque)
        lost = torque * result.conditions.speed * loss(torque)
        figures = {"power_loss": lost, "efficiency": 1.0 - loss(torque), "efficiency_error": 1e-9}
        conditions = replace(result.conditions, torque=torque)
        return replace(result, **figures, conditions=conditions, reason=reason(torque))

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


def test_stated_error_is_three_times_the_largest_difference_between_nodes() -> None:
    """A law of powers at the nodes, 0.1 % more everywhere else; between nodes the larger error of both counts."""
    nodes = {TORQUE[k] for k in _nodes(TORQUE)}
    solve, called = _solve(lambda torque: 0.01 * (torque / 100.0) ** 0.3 * (1.0 if torque in nodes else math.exp(1e-3)))
    grid = interpolated({"torque": TORQUE}, solve)
    assert grid.interpolation_error == pytest.approx(3e-3, rel=1e-9)
    between = [k for k, torque in enumerate(TORQUE) if torque not in called]
    wanted = 1e-9 + 3e-3 * (1.0 - grid.values()[between])
    np.testing.assert_allclose(grid.values("efficiency_error")[between], wanted, rtol=1e-9)
    larger = _largest(np.arange(3.0), np.array([3.0, 1.0, 2.0]), np.array([0.5, 1.5, 0.0, 2.0]))
    assert larger.tolist() == [3.0, 2.0, 3.0, 2.0]


def test_a_kink_between_sparse_nodes_is_found() -> None:
    """Several values lie between the last nodes of a long axis; the error there is stated, or every point is solved."""
    torques = np.linspace(20.0, 400.0, 40).tolist()
    solve, called = _solve(lambda torque: 0.01 + 4e-6 * max(torque - 250.0, 0.0))
    grid = interpolated({"torque": torques}, solve)
    exact = 1.0 - np.array([0.01 + 4e-6 * max(torque - 250.0, 0.0) for torque in torques])
    assert np.mean(np.abs(grid.values() - exact) <= grid.values("efficiency_error")) >= 0.9
    assert len(called) == len(set(called))
