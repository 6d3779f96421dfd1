"""A whole axle: forces from the mesh, power and heat balance, intervals, maps, duty cycles, files for vehicles."""

import csv
import json
import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import efficiency
from efficiency.axle.axle import Axle
from efficiency.axle.axle_input import AxleInput, load_axle
from efficiency.axle.result import SCATTER, SOURCES, AxlePoint, AxleResult
from ehl.common.data import data_path
from ehl.common.errors import ConvergenceError, InputError

TRUCK, EAXLE, GRID, MODEL = "truck_hypoid", "eaxle_helical", (4, 9), "constant:0.05"
LOSSES = [f"loss_{name}" for name in SOURCES]


@cache
def axle(name: str = TRUCK, **methods: str) -> Axle:
    return efficiency.Axle(name, grid=GRID, methods=methods)


@cache
def point(torque: float = 200.0, speed: float = 157.0, temperature: Any = 353.15, name: str = TRUCK) -> AxlePoint:
    return axle(name).at(torque, speed, temperature, MODEL).points[0]


def changed(name: str = TRUCK, **parts: dict[str, Any]) -> Axle:
    content = load_axle(name).model_dump()
    for table, values in parts.items():
        content[table] |= values
    made = Axle(AxleInput.model_validate(content), grid=GRID)
    made.pair = axle(name).pair  # its meshes are known
    return made


@pytest.mark.parametrize("name", [TRUCK, EAXLE])
@pytest.mark.parametrize("side", ["drive", "coast"])
def test_forces_of_the_mesh_balance_the_torques(name: str, side: Any) -> None:
    """Forces on both shafts are opposite; their moments about the axes are the torques."""
    pinion, gear = axle(name)._wrench(side, 150.0)
    assert np.linalg.norm(pinion[:3]) == pytest.approx(np.linalg.norm(gear[:3]), rel=1e-9)
    assert abs(pinion[5]) == pytest.approx(150.0, rel=1e-4)
    assert abs(gear[5]) == pytest.approx(150.0 / axle(name).pair.design.ratio, rel=2e-3)


def test_forces_of_a_helical_pair_by_hand() -> None:
    """Tangential T/r, axial tan(beta) of it, radial tan(alpha_wt) of it."""
    pinion, _ = axle(EAXLE)._wrench("drive", 150.0)
    pair = axle(EAXLE).pair.design.involute  # type: ignore[attr-defined]
    tangential = 150.0 / (pair.base[0] / math.cos(pair.working_angle))
    helix = math.atan(math.tan(pair.base_helix) / math.cos(pair.working_angle))
    assert abs(pinion[2]) == pytest.approx(tangential * math.tan(helix), rel=1e-3)
    across = math.hypot(pinion[0], pinion[1])
    assert across == pytest.approx(tangential / math.cos(pair.working_angle), rel=1e-3)


@pytest.mark.parametrize(("torque", "speed"), [(200.0, 157.0), (-100.0, 157.0), (0.0, 157.0), (-200.0, -50.0)])
@pytest.mark.parametrize("name", [TRUCK, EAXLE])
def test_power_and_heat_balance(name: str, torque: float, speed: float) -> None:
    found = point(torque, speed, name=name)
    scale = max(abs(torque * speed), found.loss_total)
    assert found.axle_power_input - found.axle_power_output == pytest.approx(found.loss_total, abs=1e-12 * scale)
    assert math.fsum(getattr(found, name) for name in LOSSES) == pytest.approx(found.loss_total, rel=1e-12)
    heat = found.heat_housing + found.heat_cooler + found.heat_stored
    assert heat == pytest.approx(found.loss_total, abs=1e-12 * (abs(found.heat_housing) + scale))
    assert abs(torque * speed) in (found.axle_power_input, found.axle_power_output, -found.axle_power_output)
    assert found.loss_total_lower < found.loss_total < found.loss_total_upper


@pytest.mark.parametrize(("name", "least"), [(TRUCK, 3.0), (EAXLE, 2.0)])
def test_limits(name: str, least: float) -> None:
    """At rest nothing is lost, but the bearings resist; without oil nothing churns; cold oil drags more."""
    still = axle(name).at(200.0, 0.0, 353.15, MODEL)
    assert still.points[0].loss_total == 0.0
    assert math.isnan(still.points[0].axle_efficiency)
    assert all(bearing.moment > 0.0 for bearing in still.bearings)
    assert point(0.0, name=name).loss_mesh == 0.0
    dry = changed(name, sump={"oil_level": -1.0}).at(0.0, 157.0, 353.15).points[0]
    assert dry.loss_churning == 0.0 < dry.loss_bearings
    assert dry.loss_total < point(0.0, name=name).loss_total
    cold = axle(name).at(0.0, 157.0, 233.15, MODEL)
    assert least < cold.points[0].loss_total / point(0.0, name=name).loss_total < 100.0
    assert any("end of the range" in note for note in cold.notes)


@pytest.mark.parametrize(("torque", "speed", "driving"), [(-100.0, 157.0, "gear"), (-100.0, -157.0, "pinion")])
def test_coast_flanks_in_regeneration_and_in_reverse(torque: float, speed: float, driving: str) -> None:
    """The wheels drive the pinion against its torque; in reverse the pinion drives on the same flanks."""
    found, drive = point(torque, speed, name=EAXLE), point(100.0, 157.0, name=EAXLE)
    assert found.axle_power_output == pytest.approx(15700.0 if driving == "gear" else 15700.0 - found.loss_total)
    # involute teeth are alike on both flanks: the loss differs by the driver alone
    assert (found.loss_mesh == pytest.approx(drive.loss_mesh, rel=1e-9)) == (driving == "pinion")
    # the same bearings, seals and oil; the thrust of the helix changes its direction
    assert found.loss_seals == drive.loss_seals
    assert found.loss_bearings == pytest.approx(drive.loss_bearings, rel=0.3)
    assert 0.9 < found.axle_efficiency < 1.0


def test_split_by_source() -> None:
    found = axle().at(200.0, 157.0, 353.15, MODEL)
    parts = found.split()
    total = parts.pop("total")
    for place, name in enumerate(("", "_lower", "_upper")):
        assert total[place] == pytest.approx(getattr(found.points[0], f"loss_total{name}"), rel=1e-12)
    assert math.fsum(value for value, *_ in parts.values()) == pytest.approx(total[0], rel=1e-12)
    assert math.fsum(share for *_, share in parts.values()) == pytest.approx(1.0)
    assert all(low <= value <= high for value, low, high, _ in parts.values())
    chosen = dict.fromkeys(("bearings", "seals", "churning"), "iso_14179_2")
    other = axle(**chosen).at(200.0, 157.0, 353.15, MODEL)
    assert found.alternatives == {
        f"{name} iso_14179_2": pytest.approx(getattr(other.points[0], f"loss_{name}"), rel=1e-12) for name in chosen
    }
    assert other.points[0].loss_mesh == found.points[0].loss_mesh
    assert set(other.bearings[0].parts) == {"load", "no load"}
    with pytest.raises(InputError):
        map_of_axle().split()


def measured(name: str) -> list[tuple[float, float, float]]:
    """Speed [rad/s], torque and torque loss [N m] of a measured axle."""
    with data_path("reference", "axle_maps.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    keys = ("speed_rpm", "torque_Nm", "torque_loss_Nm")
    found = [tuple(float(row[key]) for key in keys) for row in rows if row["axle"] == name]
    return [(n * math.pi / 30.0, torque, loss) for n, torque, loss in found]


@pytest.mark.parametrize(("name", "kelvin"), [("ro440", 353.15), ("vecto_tractor", 343.15)])
def test_drag_of_measured_truck_axles(name: str, kelvin: float) -> None:
    """Two axles of the ratio of the shipped one: each point inside the interval, the mean within 10 %."""
    ratios = []
    for speed, torque, loss in measured(name):
        if torque == 0.0:
            found = axle("heavy_truck_hypoid").at(0.0, speed, kelvin).points[0]
            assert found.loss_total_lower < loss * speed < found.loss_total_upper
            ratios.append(found.loss_total / (loss * speed))
    assert math.exp(np.mean(np.log(ratios))) == pytest.approx(1.0, abs=0.1)


@cache
def heavy_axle() -> Axle:
    return efficiency.Axle("heavy_truck_hypoid", grid=(6, 9))


@pytest.mark.parametrize("speed", [44.8, 134.4])
def test_load_loss_of_a_measured_truck_axle(speed: float) -> None:
    """Slope over the torque from 850 to 2100 N m within 20 %."""
    rows = [(t, loss) for w, t, loss in measured("vecto_tractor") if abs(w - speed) < 0.1 and 800.0 < t < 2200.0]
    (low, first), (high, last) = rows[0], rows[-1]
    computed = [heavy_axle().at(torque, speed, 343.15).points[0].loss_total / speed for torque in (low, high)]
    assert computed[1] - computed[0] == pytest.approx(last - first, rel=0.2)


def test_hot_oil_has_an_interval() -> None:
    """Teeth near 200 degC, where the laws of oils end."""
    found = axle().at(200.0, 400.0, 465.0, "75w90").points[0]
    assert found.status == "converged"
    assert found.loss_mesh_lower < found.loss_mesh < found.loss_mesh_upper


def test_interval_in_thick_oil_reaches_to_the_other_methods() -> None:
    found = axle().at(0.0, 157.0, 243.15)
    parts = found.split()
    for name, other in found.alternatives.items():
        _, low, high, _ = parts[name.split()[0]]
        assert low * (1.0 - 1e-12) <= other <= high * (1.0 + 1e-12)
    warm = axle().at(0.0, 157.0, 353.15)
    assert warm.alternatives["bearings iso_14179_2"] < warm.split()["bearings"][1]


def test_interval_covers_nine_of_ten() -> None:
    """Losses drawn from the stated scatter of each source fall into the interval of their sum."""
    found, rng = point(0.0), np.random.default_rng(3)
    scatter = {"loss_bearings": "skf", "loss_seals": "seals", "loss_churning": "churning", "loss_windage": "windage"}
    drawn = sum(getattr(found, name) * np.exp(SCATTER[sd] * rng.normal(size=20000)) for name, sd in scatter.items())
    inside = np.mean((drawn > found.loss_total_lower) & (drawn < found.loss_total_upper))
    assert 0.86 < inside < 0.94


def test_temperature_at_which_heat_balances() -> None:
    balanced = point(200.0, 157.0, "balance")
    assert 300.0 < balanced.temperature < 440.0
    assert abs(balanced.heat_stored) < 1e-4 * balanced.loss_total
    cooled = changed(housing={"cooler_conductance": 100.0, "coolant_temperature": 313.15})
    assert cooled.at(200.0, 157.0, "balance", MODEL).points[0].temperature < balanced.temperature - 10.0
    with pytest.raises(ConvergenceError, match="no_heat_balance"):
        changed(housing={"area": 0.01}).at(200.0, 157.0, "balance", MODEL)


@cache
def map_of_axle() -> AxleResult:
    return axle().map([-150.0, 0.0, 60.0, 200.0], [50.0, 157.0], [313.15, 353.15], MODEL)


def test_map_has_the_losses_of_points() -> None:
    points = {(p.torque, p.speed, p.temperature): p for p in map_of_axle().points}
    assert len(points) == 16
    for torque in (-150.0, 0.0, 200.0):
        single, of_map = point(torque), points[torque, 157.0, 353.15]
        assert of_map.loss_total == pytest.approx(single.loss_total, rel=2e-3)
        # by interpolated loads of the bearings
        assert of_map.loss_bearings == pytest.approx(single.loss_bearings, rel=5e-3)
        assert of_map.loss_total_upper == pytest.approx(single.loss_total_upper, rel=2e-2)
    assert map_of_axle().values("loss_total").min() > 0.0


def test_files_for_vehicle_simulation(tmp_path: Path) -> None:
    found = map_of_axle().loss_map(353.15)
    assert found.shape == (2, 4)
    assert found.values() == pytest.approx(found.values("torque_loss_mesh") + found.values("torque_loss_axle"))
    assert found.values("torque_loss_axle").min() > 0.0
    assert np.all(found.values("torque_loss_lower") < found.values())
    assert np.all(found.values() < found.values("torque_loss_upper"))
    lines = found.write_model(tmp_path / "axle.vtlm").read_text().splitlines()
    assert len(lines) == 1 + 3 * 4
    with pytest.raises(InputError):
        map_of_axle().loss_map(400.0)
    test = axle().axle_test("tandem", MODEL, temperature=353.15, torque_max="500 N m", revolutions_per_mile=150.0)
    idle = next(row for row in test.rows if row.torque_output == 0.0)
    drag = axle().at(0.0, idle.speed_wheel * test.ratio, 353.15, MODEL).points[0].loss_total
    # at no output the pinion carries the drag, which loads mesh and bearings a little
    assert drag < idle.power_loss < 1.15 * drag


def test_duty_cycle_counts_rows_without_torque(tmp_path: Path) -> None:
    path = tmp_path / "duty.csv"
    path.write_text("torque [N m],speed [rad/s],temperature [K],hours [h]\n200,157,353.15,1\n0,157,353.15,2\n")
    found = axle().duty(path, MODEL)
    assert len(found.points) == 2
    by_hand = 3600.0 * (found.points[0].loss_total + 2.0 * point(0.0).loss_total)
    assert found.energy() == pytest.approx(by_hand, rel=1e-9)
    energy = found.split()
    assert energy["total"][0] == found.energy()
    assert energy["mesh"][2] == pytest.approx(3600.0 * found.points[0].loss_mesh_upper, rel=1e-12)
    assert energy["total"][1] < energy["total"][0] < energy["total"][2]
    assert found.points[0].loss_total == pytest.approx(point().loss_total, rel=1e-3)


def test_failed_mesh_is_a_failed_point() -> None:
    found = axle().at(1e5, 157.0, 353.15, MODEL)
    assert found.status == "failed"
    assert math.isnan(found.points[0].loss_total)
    assert found.reason


def test_command(mixed_ehl: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(efficiency, "Axle", lambda name, **given: Axle(name, grid=GRID, **given))
    at = ("--torque", "200 N m", "--speed", "157 rad/s", "--temperature", "353.15 K", "--friction", MODEL)
    outcome = mixed_ehl("axle", TRUCK, *at, "--seals", "iso_14179_2", "--json")
    assert outcome.code == 0, outcome.err
    found = json.loads(outcome.out)
    assert found["status"] == "converged"
    assert [bearing["bearing"] for bearing in found["bearings"]] == ["head", "tail", "back", "front"]
    assert found["points"][0]["loss_bearings"] == pytest.approx(point().loss_bearings)
    assert found["points"][0]["loss_seals"] != pytest.approx(point().loss_seals, rel=0.01)


def test_friction_outside_its_range_is_a_warning() -> None:
    """At 117 kW the teeth of the pair are hotter than the data of the formula."""
    hot = axle().at("250 N m", "4500 rpm", "90 degC")
    assert hot.points[0].outside_range_share > 0.9
    assert sum("lies outside the range" in note for note in hot.notes) == 1
    own = axle().at()
    assert (own.points[0].torque, own.points[0].temperature) == pytest.approx((250.0, 353.15))
    assert own.points[0].speed == pytest.approx(50.0 * math.pi)
    assert not any("lies outside the range" in note for note in own.notes)
