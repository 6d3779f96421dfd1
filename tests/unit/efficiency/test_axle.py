"""A whole axle: forces, heat balance, intervals, maps, duty cycles; losses of bearings, seals and gears by hand."""

import csv
import json
import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refuses

import efficiency
from efficiency.axle import bearings, drag
from efficiency.axle.axle import NODES, Axle
from efficiency.axle.axle_input import AxleInput, HousingInput, ShaftInput, load_axle
from efficiency.axle.result import SCATTER, SOURCES, AxlePoint, AxleResult
from ehl.common.data import data_path
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.table import Table
from ehl.common.validation import validate
from ehl.fluid.oil import Oil

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


@pytest.mark.parametrize(("torque", "speed", "driving"), [(-100.0, 157.0, "gear"), (-100.0, -157.0, "pinion")])
def test_coast_flanks_in_regeneration_and_in_reverse(torque: float, speed: float, driving: str) -> None:
    """The wheels drive the pinion against its torque; in reverse the pinion drives on the same flanks."""
    found, drive = point(torque, speed, name=EAXLE), point(100.0, 157.0, name=EAXLE)
    assert found.axle_power_output == pytest.approx(15700.0 if driving == "gear" else 15700.0 - found.loss_total)
    # involute teeth are alike on both flanks: the loss differs by the driver alone
    assert (found.loss_mesh == pytest.approx(drive.loss_mesh, rel=1e-9)) == (driving == "pinion")
    # the same seals and oil; the thrust of the helix changes its direction
    assert found.loss_bearings == pytest.approx(drive.loss_bearings, rel=0.3)


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


def test_load_loss_of_a_measured_truck_axle() -> None:
    """Slope over the torque from 850 to 2100 N m within 20 %."""
    own = efficiency.Axle("heavy_truck_hypoid", grid=(6, 9))
    for speed in (44.8, 134.4):
        rows = [(t, loss) for w, t, loss in measured("vecto_tractor") if abs(w - speed) < 0.1 and 800.0 < t < 2200.0]
        (low, first), (high, last) = rows[0], rows[-1]
        computed = [own.at(torque, speed, 343.15).points[0].loss_total / speed for torque in (low, high)]
        assert computed[1] - computed[0] == pytest.approx(last - first, rel=0.2)


def test_hot_oil_has_an_interval() -> None:
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


def test_interval_of_a_map_is_that_of_its_points() -> None:
    """Also between the ends of its axes, where it is up to a fifth wider than on a line between them."""
    speeds = [15.7, 30.0, 60.0, 94.2, 157.0, 220.0, 314.0]
    found = axle().map([200.0], speeds, 353.15, "75w90")
    assert len(speeds) > NODES
    for speed, of_map in zip(speeds, found.points, strict=True):
        single = axle().at(200.0, speed, 353.15, "75w90").points[0]
        assert (of_map.loss_mesh_lower, of_map.loss_mesh_upper) == pytest.approx(
            (single.loss_mesh_lower, single.loss_mesh_upper), rel=1e-2
        )
    without = axle().map([0.0, 200.0], 157.0, 353.15, "75w90", interval=False)
    assert without.values() == pytest.approx([point(0.0).loss_total, found.points[4].loss_total], rel=1e-3)
    assert list(np.isfinite(without.values("loss_total_upper"))) == [True, False]


def test_loss_map_and_axle_test() -> None:
    found = map_of_axle().loss_map(353.15)
    assert found.shape == (2, 4)
    assert found.values() == pytest.approx(found.values("torque_loss_mesh") + found.values("torque_loss_axle"))
    assert found.values("torque_loss_axle").min() > 0.0
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
    assert energy["mesh"][2] == pytest.approx(3600.0 * found.points[0].loss_mesh_upper, rel=1e-12)
    assert energy["total"][1] < energy["total"][0] == found.energy() < energy["total"][2]


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
    found = json.loads(outcome.out)["points"][0]
    assert found["loss_bearings"] == pytest.approx(point().loss_bearings)
    assert found["loss_seals"] != pytest.approx(point().loss_seals, rel=0.01)


@pytest.mark.parametrize("torque", [200.0, -150.0])
def test_shown_powers_differ_by_the_shown_loss(torque: float) -> None:
    found = axle().at(torque, 157.0, 353.15, MODEL)
    tables = [item for item in found.sections("terminal")[0].items if isinstance(item, Table)]
    of_point, by_source = ({c.name: c.text(v) for c, v in zip(t.columns, t.rows[-1], strict=True)} for t in tables[:2])
    powers = [float(of_point[f"axle_power_{way}"]) for way in ("input", "output")]
    loss = float(by_source["loss_total"])
    assert powers[0] - powers[1] == pytest.approx(loss, abs=1.01 * 10.0 ** (math.floor(math.log10(loss)) - 1))
    assert powers[0] == pytest.approx(found.points[0].axle_power_input, abs=loss / 20.0)


def test_command_with_a_vehicle_speed(mixed_ehl: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(efficiency, "Axle", lambda name, **given: Axle(name, grid=GRID, **given))
    (path := tmp_path / "duty.csv").write_text("speed [km/h],torque [N m],temperature [K],hours [h]\n36,200,353.15,1\n")
    outcome = mixed_ehl("axle", TRUCK, "--duty", path, "--tyre-radius", "0.32 m", "--friction", MODEL, "--json")
    assert outcome.code == 0, outcome.err
    [found] = json.loads(outcome.out)["points"]
    assert found["speed"] == pytest.approx(10.0 / 0.32 * 34.0 / 9.0, rel=1e-12)


def test_friction_outside_its_range_is_a_warning() -> None:
    """At 377 kW the teeth of the pair are hotter than the data of the formula."""
    hot = axle().at("600 N m", "6000 rpm", "110 degC")
    assert hot.points[0].outside_range_share > 0.9
    assert sum("lies outside the range" in note for note in hot.notes) == 1
    assert not any("lies outside the range" in note for note in axle().at().notes)


RPM = 2.0 * math.pi / 60.0
SIZE = {"position": 0.0, "bore": 0.05, "outside_diameter": 0.09, "width": 0.02}
TAPERED: dict[str, Any] = SIZE | {"type": "tapered_roller", "series": "302", "thrust": "outwards", "axial_factor": 1.4}
BALL: dict[str, Any] = SIZE | {"type": "deep_groove_ball", "series": "62", "bore": 0.04, "outside_diameter": 0.08}
DEEP_GROOVE = BALL | {"static_load_rating": 19000.0, "thrust": "both"}
ROLLER = BALL | {"type": "cylindrical_roller", "series": "2"}
WHEEL = drag.Wheel(41, 0.1, 0.105, 0.03, 0.01, math.radians(20.0), math.radians(30.0))
PINION = drag.Wheel(10, 0.025, 0.03, 0.025, 0.01, math.radians(20.0), math.radians(30.0))


def bearing(**given: Any) -> bearings.BearingInput:
    return bearings.BearingInput.model_validate({"name": "one"} | given)


def test_skf_moments_by_hand() -> None:
    """d_m = 70 mm, 1500 rpm, 20 cSt, Fr = 4 kN, Fa = 1.5 kN; each line of the model with a pocket calculator."""
    state = bearings.BearingState(4000.0, 1500.0, 1500.0 * RPM, 20e-6)
    rolling, sliding = bearings.skf_load_variables(bearing(**TAPERED), 4000.0, 1500.0)
    # 1.76e-6 70^2.38 = 0.043337; (4000 + 10.9 1.4 1500)^0.31 = 23.614
    assert rolling == pytest.approx(1.0234, rel=1e-4)
    assert sliding == pytest.approx(0.55388 * 8200.0, rel=1e-4)  # 0.017 70^0.82 = 0.55388
    found = bearings.skf_moment(bearing(**TAPERED), state)
    # phi_ish = 0.96761, phi_rs = 0.96608, (nu n)^0.6 = 485.6; phi_bl = 0.0343, mu_sl = 0.006047
    assert found["rolling"] == pytest.approx(1e-3 * 0.96761 * 0.96608 * 1.0234 * 485.6, rel=2e-3)
    assert found["sliding"] == pytest.approx(1e-3 * 0.006047 * 4541.8, rel=2e-3)
    assert found["drag"] == found["seal"] == 0.0
    wet = bearings.skf_moment(bearing(**TAPERED), bearings.BearingState(4000.0, 1500.0, 1500.0 * RPM, 20e-6, 0.02))
    # t = 2.039, R_s = 2123.8 mm^2: 4.73 N mm; V_M = 4.29e-4, K_roll = 1.47e-11, C_w = 0.6631: 18.07 N mm
    assert wet["drag"] == pytest.approx(1e-3 * (4.73 + 18.07), rel=2e-3)
    assert wet["rolling"] == pytest.approx(found["rolling"] / 0.96608, rel=1e-4)  # no starvation in the bath


@pytest.mark.parametrize(
    ("given", "rating", "coefficient"),
    [(DEEP_GROOVE, 32500.0, 0.0015), (ROLLER, 62000.0, 0.0011), (TAPERED, 98000.0, 0.0018)],
)
def test_both_methods_near_the_printed_coefficients_of_friction(given: Any, rating: float, coefficient: float) -> None:
    """``M = mu P d/2`` with mu of the same catalogue, printed for P = 0.1 C and normal running."""
    load = 0.1 * rating
    simple = 0.5 * coefficient * load * given["bore"]
    for method in bearings.BEARING_METHODS.values():
        moment = sum(method(bearing(**given), bearings.BearingState(load, 0.0, 1500.0 * RPM, 20e-6)).values())
        assert moment == pytest.approx(simple, rel=0.3)


def test_skf_moments_of_independent_programs() -> None:
    """Numbers that public programs give, computed with them; their starvation is that of grease (6e-8), ours of oil."""
    # github.com/cfernandesFEUP/Gear-Calculation, bearings.py: NJ 406, 3 kN, 1500 rpm, 32 cSt; 5 kN, 300 rpm, 80 cSt
    nj406 = bearing(**ROLLER | {"series": "4", "bore": 0.03, "outside_diameter": 0.09, "width": 0.023})
    for state, rolling, sliding in (
        (bearings.BearingState(3000.0, 0.0, 1500.0 * RPM, 32e-6), 138.261, 5.50156),
        (bearings.BearingState(5000.0, 400.0, 300.0 * RPM, 80e-6), 111.877, 96.1661),
    ):
        found = bearings.skf_moment(nj406, state)
        assert (found["rolling"], found["sliding"]) == pytest.approx((1e-3 * rolling, 1e-3 * sliding), rel=1e-5)
    # a public calculation of the losses of a passenger e-axle (Getrieberechnung_Einstufig.m): 16011, 2000 rpm, 9 cSt
    size = {"bore": 0.055, "outside_diameter": 0.09, "width": 0.011, "static_load_rating": 26000.0}
    ball = bearing(**BALL | size | {"series": "160", "thrust": "both"})
    found = bearings.skf_moment(ball, bearings.BearingState(2500.0, 800.0, 2000.0 * RPM, 9e-6, synthetic=True))
    assert found["sliding"] == pytest.approx(63.6376e-3, rel=1e-5)
    assert found["rolling"] == pytest.approx(91.6170e-3 * 0.967582**-0.5, rel=1e-5)
    # a third one, of bearings under oil: 40 x 80 mm, 3000 rpm, 20 cSt, its diagram read as 0.0012 in place of 0.00124
    drag = bearings.skf_moment(bearing(**BALL), bearings.BearingState(1.0, 0.0, 3000.0 * RPM, 20e-6, 1.0))["drag"]
    assert drag == pytest.approx(1e-3 * (31.2409 * 1.24 / 1.2 + 10.0134), rel=1e-4)


@pytest.mark.parametrize("depth", [0.0, 0.02])
def test_rolling_moment_never_falls_in_colder_oil(depth: float) -> None:
    """Starvation would bring it to zero in cold oil outside of a bath."""
    states = [bearings.BearingState(4000.0, 1500.0, 1500.0 * RPM, nu, depth) for nu in np.geomspace(1e-5, 1.0, 40)]
    moments = [bearings.skf_moment(bearing(**TAPERED), state)["rolling"] for state in states]
    assert np.all(np.diff(moments) >= -1e-9)
    limits = [bearings.bearing_limits("skf", bearing(**TAPERED), state) for state in states]
    noted = [any("rolling" in note for note in notes) for notes in limits]
    assert noted[-1]
    assert not noted[0]


def test_palmgren_by_hand() -> None:
    """f0 = 6, nu n = 30000: 1e-7 6 965.5 70^3 N mm; P1 = 2 1.4 1500 = 4200 N > Fr: 4e-4 4200 70 N mm."""
    found = bearings.palmgren_moment(bearing(**TAPERED), bearings.BearingState(4000.0, 1500.0, 1500.0 * RPM, 20e-6))
    assert found["no load"] == pytest.approx(0.19870, rel=1e-4)
    assert found["load"] == pytest.approx(0.1176, rel=1e-9)
    slow = bearings.palmgren_moment(bearing(**TAPERED), bearings.BearingState(0.0, 0.0, 99.9 * RPM, 20e-6))["no load"]
    fast = bearings.palmgren_moment(bearing(**TAPERED), bearings.BearingState(0.0, 0.0, 100.1 * RPM, 20e-6))["no load"]
    assert fast == pytest.approx(slow, rel=0.01)  # both branches meet at nu n = 2000
    # printed in a public study: f0 = 1.7, nu = 30 cSt, d_m = 45 mm, 10 500 rpm: 0.072 N m
    printed = bearing(**BALL | {"bore": 0.03, "outside_diameter": 0.06}, f0=1.7)
    found = bearings.palmgren_moment(printed, bearings.BearingState(0.0, 0.0, 10500.0 * RPM, 30e-6))
    assert found["no load"] == pytest.approx(0.072, rel=5e-3)
    stated = bearing(**TAPERED, f0=3.0)
    found = bearings.palmgren_moment(stated, bearings.BearingState(0.0, 0.0, 157.0, 20e-6))
    assert found["no load"] == pytest.approx(0.09932, rel=2e-3)


def test_seals_of_bearings_and_limits_of_speed_and_oil() -> None:
    sealed = bearing(**TAPERED, seal_diameter=0.06, seal_constants=(0.018, 2.25, 15.0))
    state = bearings.BearingState(4000.0, 1500.0, 1500.0 * RPM, 20e-6)
    assert bearings.skf_moment(sealed, state)["seal"] == pytest.approx(1e-3 * (0.018 * 60.0**2.25 + 15.0))
    still = bearings.skf_moment(bearing(**TAPERED), bearings.BearingState(4000.0, 1500.0, 0.0, 20e-6, 0.02))
    # at rest the starting torque: mu = 0.15 on the sliding load alone
    assert still == {"rolling": 0.0, "sliding": pytest.approx(0.15e-3 * 4541.8, rel=1e-4), "seal": 0.0, "drag": 0.0}
    unloaded = bearings.skf_moment(bearing(**TAPERED), bearings.BearingState(0.0, 0.0, 100.0, 20e-6))
    assert sum(unloaded.values()) == 0.0
    cold = bearings.BearingState(4000.0, 1500.0, 1500.0 * RPM, 0.05, 0.02)
    assert math.isfinite(sum(bearings.skf_moment(bearing(**TAPERED), cold).values()))
    assert bearings.bearing_limits("skf", bearing(**TAPERED), cold)
    assert bearings.bearing_limits("skf", bearing(**TAPERED), state) == []
    assert bearings.bearing_limits("iso_14179_2", bearing(**TAPERED), cold) == []
    fast = bearings.BearingState(4000.0, 1500.0, 20000.0 * RPM, 20e-6)
    assert all(bearings.bearing_limits(method, bearing(**TAPERED), fast) for method in bearings.BEARING_METHODS)


def test_seals_by_hand() -> None:
    """50 mm, 1500 rpm; 75W-90 of 97.5 cSt: lg lg 98.3 = 0.29941."""
    oil, kelvin = Oil.load("75w90"), 90.0 + 273.15
    assert drag.iso_14179_2_seal(0.05, 1500.0 * RPM, oil, kelvin) == pytest.approx(28.84, rel=1e-3)
    by_hand = (145.0 - 144.0 + 350.0 * 0.29941) * 1e-7 * 2500.0 * 1500.0
    assert drag.linke_seal(0.05, 1500.0 * RPM, oil, kelvin) == pytest.approx(by_hand, rel=1e-4)
    assert drag.linke_seal(0.05, -157.0, oil, kelvin) == drag.linke_seal(0.05, 157.0, oil, kelvin)
    assert drag.linke_seal(0.05, 157.0, oil, 233.15) > drag.linke_seal(0.05, 157.0, oil, kelvin)


def test_churning_by_hand() -> None:
    """R = 100 mm, b = 30 mm, h = 50 mm: theta = 60 deg; wetted 12284 + 6283 + 10057 mm^2; V = D^3 or more."""
    wetted = 0.012284 + 0.0062832 + 2.0 * 41 * 1.047198 * 0.01 * 0.03 / (math.pi * 0.939693 * 0.866025)
    viscous = 1.366 * 0.25**0.45 * 2.0**0.1 * 0.254929**-0.6 * 1000.0**-0.21  # 5 rad/s, 15 cSt, V = 2 D^3
    at_5 = 0.5 * 820.0 * 25.0 * 1e-3 * wetted * viscous
    assert drag.changenet_velex_torque(WHEEL, 0.05, 5.0, 15e-6, 820.0, 0.016) == pytest.approx(at_5, rel=1e-3)
    inertial = 3.644 * 0.25**0.1 * 2.0**-0.35 * 25.4929**-0.88 * 0.15**0.85  # 50 rad/s
    at_50 = 0.5 * 820.0 * 2500.0 * 1e-3 * wetted * inertial
    assert drag.changenet_velex_torque(WHEEL, 0.05, 50.0, 15e-6, 820.0, 0.016) == pytest.approx(at_50, rel=1e-3)
    # less oil than was measured counts as V = D^3
    of_sump = [
        drag.changenet_velex_torque(WHEEL, 0.05, 50.0, 15e-6, 820.0, v) for v in (0.001, 0.2**3 * drag.SMALL_SUMP)
    ]
    assert of_sump[0] == of_sump[1]
    # Mauz: C1 = 0.063 5 + 0.0128 27, C2 = 5/80 + 0.2, v = 5 m/s
    assert drag.iso_14179_2_torque(0.05, 0.03, 5.0) == pytest.approx(0.6606 * math.exp(0.13125), rel=1e-4)


@pytest.mark.parametrize("method", drag.CHURNING_METHODS.values())
def test_churning_of_a_stage(method: Any) -> None:
    """Nothing without oil or at rest; more where the gears dip deeper; a dry pinion adds nothing."""

    def loss(*depths: float, speed: float = 50.0) -> float:
        return float(method((PINION, WHEEL), drag.OilBath(depths, (4.0 * speed, speed), 15e-6, 820.0, 0.01)))  # type: ignore[arg-type]

    assert loss(0.0, 0.0) == loss(0.02, 0.05, speed=0.0) == 0.0
    assert loss(0.02, 0.05) > loss(0.0, 0.05) > loss(0.0, 0.02) > 0.0
    assert loss(0.02, 0.0) > 0.0


def test_stage_of_iso_14179_2_has_one_torque() -> None:
    """Depths 20 and 50 mm, the smaller face, speed of the gear; not one torque for each gear."""
    bath = drag.OilBath((0.02, 0.05), (200.0, 50.0), 15e-6, 820.0, 0.01)
    by_hand = 50.0 * (0.063 * 7.0 + 0.0128 * 2.5**3) * math.exp((7.0 / 80.0 + 0.2) * 0.5)
    assert drag.CHURNING_METHODS["iso_14179_2"]((PINION, WHEEL), bath) == pytest.approx(by_hand, rel=1e-9)


def test_regimes_of_churning_and_windage_are_joined() -> None:
    speeds = np.linspace(15.0, 60.0, 400)
    torques = np.array([drag.changenet_velex_torque(WHEEL, 0.05, w, 15e-6, 820.0, 0.016) for w in speeds])
    assert np.max(np.abs(np.diff(torques))) < 0.02 * torques.max()
    # windage of a disc, turbulent at Re = 66 667: C = 0.146 Re^-0.2; laminar at 3333: 3.87 Re^-0.5 (Schlichting)
    assert drag.windage_torque(0.1, 100.0) == pytest.approx(0.6 * 1e4 * 1e-5 * 0.146 * 66666.7**-0.2, rel=1e-5)
    assert drag.windage_torque(0.1, 5.0) == pytest.approx(0.6 * 25.0 * 1e-5 * 3.87 * 3333.33**-0.5, rel=1e-5)
    assert drag.windage_torque(0.1, 0.0) == 0.0


def shaft(preload: float = 0.0, third: tuple[Any, ...] = ()) -> ShaftInput:
    one = TAPERED | {"name": "a", "position": 0.1, "thrust": "outwards", "axial_factor": 2.0}
    two = TAPERED | {"name": "b", "position": 0.2, "thrust": "inwards", "axial_factor": 1.0}
    return ShaftInput.model_validate({"preload": preload, "bearings": (one, two, *third)})


def test_shaft_on_two_bearings_by_hand() -> None:
    """1 kN at the origin, 0.1 m before the first of two bearings 0.1 m apart: 2 kN and 1 kN."""
    (first, axial_1), (second, axial_2) = shaft().loads(np.array([600.0, 800.0, 0.0, 0.0, 0.0, 5.0]))
    assert (first, second) == pytest.approx((2000.0, 1000.0))
    # induced 0.5 Fr/Y: 500 N each, no outer axial force
    assert (axial_1, axial_2) == pytest.approx((500.0, 500.0))
    # an axial force at a radius of 50 mm: its moment is 100 N m, couple of 1 kN
    couple = shaft().loads(np.array([0.0, 0.0, 2000.0, 0.0, 100.0, 0.0]))
    assert [radial for radial, _ in couple] == pytest.approx([1000.0, 1000.0])
    assert [axial for _, axial in couple] == pytest.approx([2500.0, 500.0])


@pytest.mark.parametrize(
    ("pushed", "expected"), [(0.0, (3e3, 3e3)), (2e3, (4e3, 2e3)), (9e3, (9.5e3, 500.0)), (-9e3, (500.0, 9.5e3))]
)
def test_preload_of_a_shaft(pushed: float, expected: tuple[float, float]) -> None:
    """Springs share an outer force until one bearing is relieved to the force it needs for its radial load."""
    found = shaft(3e3).loads(np.array([600.0, 800.0, pushed, 0.0, 0.0, 0.0]))
    assert [axial for _, axial in found] == pytest.approx(expected)


def test_three_bearings_carry_the_load() -> None:
    pilot = (ROLLER | {"name": "pilot", "position": -0.05},)
    found = shaft(third=pilot).loads(np.array([1000.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    assert len(found) == 3
    assert all(radial < 1000.0 for radial, _ in found)


def test_heat_through_housing_and_cooler() -> None:
    """100 and 25 W/(m^2 K) in series: 20; 60 K over the air, 0.5 m^2: 600 W, wall at 20 + 48 degC."""
    housing = HousingInput(area=0.5, heat_transfer=25.0, oil_heat_transfer=100.0, cooler_conductance=10.0)
    wall, cooler, temperature = housing.removed(353.15)
    assert (wall, cooler, temperature) == pytest.approx((600.0, 200.0, 341.15))


@pytest.mark.parametrize(
    ("field", "value"), [("series", "999"), ("axial_factor", 0.0), ("thrust", "both"), ("bore", 0.2)]
)
def test_impossible_bearings_are_refused(field: str, value: Any) -> None:
    with refuses(field):
        validate(bearings.BearingInput, TAPERED | {"name": "one", field: value})
    with pytest.raises(InputError):
        validate(ShaftInput, {"bearings": (TAPERED | {"name": "a"},)})
