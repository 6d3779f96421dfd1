"""Duty cycles read and computed, plans from them, efficiency over any axes, maps from few solved points."""

import json
import math
from dataclasses import replace
from functools import partial, partialmethod
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refuses

import efficiency
import efficiency.mesh
from efficiency.conditions.conditions import split_axes
from efficiency.conditions.duty import DutyRow, read_duty
from efficiency.conditions.grid import Evaluator, Grid, _largest, _nodes
from efficiency.design.design import load_design
from efficiency.loss.efficiency import mesh_efficiency
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.kinematics import Operation
from efficiency.ltca.mesh_grids import load_grids
from efficiency.mesh import Mesh
from efficiency.pair import GearPair
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.progress import Progress
from ehl.fluid.oil import Oil
from regression.formula import friction_model
from regression.plan.plan import Plan

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


def test_a_failed_row_is_no_number() -> None:
    broken = replace(MODEL, local=lambda c, base: np.full(c["film_formula"].shape, np.nan))
    cycle = PAIR.duty([DutyRow(200.0, 125.0, 363.15, 2.0)], broken, grid=GRID)
    assert (cycle.status, cycle.to_dict()["total"]["efficiency"]) == ("failed", None)


def test_axes_in_any_order_and_each_load_once(loads: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[float] = []
    true = Mesh.of

    def make_mesh(design: Any, *arguments: Any) -> Mesh:
        made.append(design.assembly.misalignment.E)
        if design.assembly.misalignment.E > 0.0:
            raise ConvergenceError("no_contact")
        return true(design, *arguments)

    monkeypatch.setattr(Mesh, "of", make_mesh)
    axes = {"temperature": [333.15, 363.15], "E": [0.0, 1e-3], "torque": [100.0, 200.0]}
    axes |= {"roughness_rms_each": [2e-7, 4e-7]}
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
    assert json.dumps(found.to_dict())
    assert found.to_frame()["status"].value_counts().to_dict() == {"converged": 8, "failed": 8}
    assert split_axes({"torque": "100; 200 N m", "speed": "60 rad/s"}) == ({"torque": [100.0, 200.0]}, {"speed": 60.0})


@pytest.mark.parametrize(
    ("axes", "words"),
    [
        ({"offset": [1.0]}, "one of design, side, E"),
        ({"torque": []}, "torque"),
        ({"torque": "100:200 N m"}, "torque"),
        ({"roughness_rms_each": [1e-3]}, "roughness_rms_each"),
        ({"roughness_rms_each": [1e-7], "roughness_rms_gear": [1e-7]}, "roughness_rms_each"),
    ],
)
def test_bad_axes(axes: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        PAIR.over(MODEL, **axes)


def test_a_friction_model_is_a_name_a_path_or_a_model(tmp_path: Path) -> None:
    loaded, formula = PAIR.mesh("drive", *GRID).load(200.0), friction_model("75w90")
    formula.save(tmp_path / "formula.json")
    assert loaded.efficiency(tmp_path / "formula.json").power_loss == loaded.efficiency(formula).power_loss
    with refuses("friction model"):
        loaded.efficiency(0.05)  # type: ignore[arg-type]
    with refuses("duty"):
        PAIR.duty([{"torque": 100.0}], MODEL, grid=GRID)  # type: ignore[list-item]


@pytest.mark.parametrize("call", [PAIR.at, PAIR.over, partial(efficiency.study, [DESIGN]), partial(PAIR.duty, [])])
def test_composite_roughness_is_refused(call: Any) -> None:
    with refuses("roughness_rms"):
        call(MODEL, grid=GRID, roughness_rms="0.4 um")


def test_ratios_over_a_duty_cycle() -> None:
    """With constants the ratio of the losses is nearly that of the constants, in every row and in total."""
    pair = efficiency.load("fm_spiral_bevel_14x39_relieved")
    rows = [DutyRow(torque, 100.0, 360.0, 1.0) for torque in (60.0, 200.0)]
    found = pair.compare(["constant:0.04", "constant:0.06", "constant:0.04"], 200.0, grid=(4, 9), duty=rows).rows
    low, high = found[0], found[1]
    assert [row.name for row in found].count("constant:0.04") == 1
    assert (low.energy_factor, low.loss_factor) == (1.0, 1.0)
    ratios = np.array([high.loss_factor, high.energy_factor, high.energy_factor_min, high.energy_factor_max])
    np.testing.assert_allclose(ratios, 1.5, rtol=0.03)
    cycle = pair.duty(rows, "constant:0.06", grid=(4, 9))
    assert high.energy_loss == pytest.approx(cycle.total("energy_loss"))
    assert np.isnan(next(row for row in found if row.kind == "closed form").energy_loss)


TORQUE, SPEED = np.geomspace(60.0, 300.0, 11).tolist(), np.linspace(50.0, 300.0, 12).tolist()
# temperature comes from the design
POINTS = len(TORQUE) * len(SPEED)


def test_interpolated_points_agree_with_solved_ones() -> None:
    mesh = PAIR.mesh("drive", *GRID)
    few, every = (mesh.map(MODEL, TORQUE, SPEED, interval=True, every_point=every) for every in (False, True))
    between = np.array([bool(point.interpolated) for point in few.points]).reshape(few.shape)
    assert len(every.results) == POINTS
    assert [p["interpolated"] for p in json.loads(json.dumps(few.to_dict()))["points"]] == between.ravel().tolist()
    assert len(few.results) == POINTS - between.sum() <= 0.5 * POINTS
    # solved points are those of the whole map
    assert np.all(few.values()[~between] == every.values()[~between])
    wrong = np.abs(few.values() - every.values())[between]
    assert np.all(wrong < few.values("efficiency_error")[between])
    assert np.all(few.values("efficiency_error")[between] > few.interpolation_error * (1.0 - few.values()[between]))
    loss = np.abs(np.log(few.values("power_loss") / every.values("power_loss")))[between]
    assert 0.0 < np.median(loss) < few.interpolation_error
    # few points a line: the load itself is uneven over the torque
    tolerances = {"friction_coefficient_mean": 1e-2, "power_loss_rolling": 1e-1, "pressure_hertz_max": 3e-2}
    tolerances |= {"efficiency_with_rolling": 1e-4, "power_input": 1e-12, "power_output": 1e-3}
    tolerances |= {"efficiency_lower": 2e-4, "efficiency_upper": 2e-4}
    for name, tolerance in tolerances.items():
        found, wanted = (grid.values(name)[between] for grid in (few, every))
        np.testing.assert_allclose(found, wanted, rtol=tolerance, atol=0.0, err_msg=name)
    # edges carry from some torque on: between solved points nothing is stated of them
    assert np.isnan(few.values("pressure_edge")[between]).all()


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
    for torques in (TORQUE, TORQUE[::-1]):
        grid = interpolated({"torque": torques}, solve)
        np.testing.assert_allclose(grid.values(), 1.0 - 0.01 * (np.array(torques) / 100.0) ** 0.3, rtol=1e-12)
    assert len(called) < 2 * len(TORQUE)


@pytest.mark.parametrize(
    ("torques", "loss", "locked"),
    [
        (TORQUE, lambda torque: 0.01 + 0.001 * np.sin(torque), math.inf),
        (TORQUE, lambda torque: 0.01, 290.0),
        (TORQUE[:9], lambda torque: 0.01, math.inf),
        ([*TORQUE, TORQUE[3]], lambda torque: 0.01, math.inf),
    ],
)
def test_every_point_is_solved(torques: list[float], loss: Any, locked: float) -> None:
    """Where interpolation fails, on short axes and with repeated values."""
    solve, called = _solve(loss, lambda torque: "self_locking" if torque > locked else "")
    grid = interpolated({"torque": torques}, solve)
    assert sorted(called) == sorted(torques)
    assert grid.interpolation_error == 0.0
    np.testing.assert_array_equal(grid.values()[:-1], 1.0 - np.array([loss(torque) for torque in torques[:-1]]))


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


DUTY = """torque [N m],speed [rpm],temperature [degC],hours [h],# gear
300,1200,90,100,third
-80,2000,80,20,coast
0,500,40,5,idle
"""


@pytest.fixture
def duty(tmp_path: Path) -> Path:
    path = tmp_path / "duty.csv"
    path.write_text(DUTY)
    return path


def test_duty_cycles_are_read(duty: Path) -> None:
    rows = read_duty(duty)
    assert [(row.side, row.driver, row.hours) for row in rows] == [("drive", "pinion", 100.0), ("coast", "gear", 20.0)]
    assert (rows[0].speed, rows[0].temperature) == pytest.approx((40.0 * np.pi, 363.15))
    # all bad rows are named
    duty.write_text(DUTY + "x,500,40,5,no number\n100,500,900,5,too hot\n100,500,40,-1,no duration\n")
    with refuses("duty.csv, row 5, torque") as caught:
        read_duty(duty)
    assert [problem.field.rpartition(" ")[2] for problem in caught.value.problems] == ["torque", "temperature", "hours"]
    assert not caught.value.problems[1].hint  # the unit is correct


def test_a_recording_of_a_vehicle(mixed_ehl: Any, tmp_path: Path) -> None:
    path = tmp_path / "cycle.csv"
    lines = ["Logger V3;2026-01-01", "Zeit [s];Geschwindigkeit [km/h];Radmoment [Nm];Gang"]
    lines += ["0,0;36,0;1.114,3;3", "1,0;72;-557,1;3", "3,0;Bad;200;3", "4,0;36,0;0;3"]
    path.write_bytes("\r\n".join(lines).encode("cp1252"))
    rows = read_duty(path, tyre_radius="0.32 m", ratio=39.0 / 14.0, temperature="80 C")
    assert [row.torque for row in rows] == pytest.approx([400.0, -200.0], rel=1e-3)
    assert [row.speed for row in rows] == pytest.approx([10.0 / 0.32 * 39 / 14, 20.0 / 0.32 * 39 / 14])
    assert [row.hours * 3600.0 for row in rows] == pytest.approx([1.0, 3.0])
    assert rows[0].temperature == pytest.approx(353.15)
    for name, value in (("ratio", math.nan), ("tyre_radius", "0 m"), ("temperature", "1e300 degC")):
        with refuses(name):  # also where the file does not need it
            read_duty(path, **{"tyre_radius": "0.32 m", "ratio": 2.0, "temperature": "80 C"} | {name: value})
    with refuses("tyre_radius"):
        read_duty(path, ratio=2.0, temperature=353.0)
    outcome = mixed_ehl("duty", DESIGN.name, path, "--tyre-radius", "0.32 m", "--json")
    assert (outcome.code, ": 1 (0.0005556 h)" in outcome.err) == (0, True), outcome.err  # the last row has no torque
    assert json.loads(outcome.out)["total"]["hours"] == pytest.approx(4.0 / 3600.0)
    path.write_text("time [s],speed [km/h],torque [Nm],temperature [C]\n1,36,100,80\n1,36,100,80\n")
    with refuses("cycle.csv, row 3, time"):
        read_duty(path, tyre_radius=0.3, ratio=2.0)


def test_reverse_is_a_negative_speed() -> None:
    """Driven backwards the coast flanks carry the torque and the power still comes from the pinion."""
    assert (DutyRow(-80.0, -100.0, 363.15, 1.0).side, DutyRow(-80.0, -100.0, 363.15, 1.0).driver) == ("coast", "pinion")
    assert (DutyRow(80.0, -100.0, 363.15, 1.0).side, DutyRow(80.0, -100.0, 363.15, 1.0).driver) == ("drive", "gear")


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("torque [N m]", "torque", "^duty.csv, column torque"),
        (",hours [h]", ",# hours", "column hours"),
        ("1200", "-120000", "row 2, speed"),
        (DUTY[DUTY.index("300") :], "0,500,40,5,idle\n", "1 rows"),
    ],
)
def test_bad_duties(duty: Path, old: str, new: str, word: str) -> None:
    duty.write_text(DUTY.replace(old, new))
    with pytest.raises(InputError, match=word):
        read_duty(duty)


def test_weights_are_the_work_lost() -> None:
    """With a constant mu, mu times the weights is the energy the efficiency of the same mesh loses."""
    row = DutyRow(300.0, 125.0, 363.15, 2.0)
    (part,) = PAIR.duty_points([row], grid=(4, 9))
    operation = Operation(row.speed, row.temperature, DESIGN.pinion.roughness_rms, DESIGN.gear.roughness_rms)
    loaded = PAIR.mesh("drive", 4, 9).load(300.0).grids
    result = mesh_efficiency(loaded, friction_model("constant:0.05"), Oil.load("75w90"), operation)
    assert 0.05 * part.weight.sum() == pytest.approx(2.0 * result.power_loss, rel=1e-12)


def test_a_duty_becomes_a_plan(mixed_ehl: Any, duty: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(GearPair, "duty_points", partialmethod(GearPair.duty_points, grid=(4, 9)))
    target = tmp_path / "seen.toml"
    assert mixed_ehl("plan", DESIGN.name, "--duty", duty, "-o", target, "--size", "48", "--oil", "fva3").code == 0
    plan = Plan.from_file(target)
    assert plan.oils == ("fva3",)
    pressure, temperature = (plan.variables[name].values for name in ("pressure_hertz", "temperature_oil"))
    assert 0.1e9 < pressure[0] < 1e9 < pressure[1] < 2.5e9
    assert temperature[0] < 353.15 < 363.15 < temperature[1]
    assert mixed_ehl("sweep", target, "--estimate").code == 0


@pytest.mark.parametrize(("head", "units", "hours"), [("hours", "", 5.0), ("hours", "N m,rpm,degC,s\n", 5.0 / 3600.0)])
def test_a_column_named_after_its_unit(tmp_path: Path, head: str, units: str, hours: float) -> None:
    path = tmp_path / "duty.csv"
    first = "torque,speed,temperature" if units else "torque [N m],speed [rpm],temperature [degC]"
    path.write_text(f"{first},{head}\n{units}100,1500,80,5\n", encoding="utf-8")
    assert [row.hours for row in read_duty(path)] == pytest.approx([hours])
