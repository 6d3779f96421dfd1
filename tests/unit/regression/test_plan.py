"""Plan files: what they accept, what they mean, and what they refuse."""

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refuses

from ehl.common.data import data_names
from ehl.common.errors import InputError
from ehl.common.validation import validate
from regression.friction.conditions import LUBRICANT_UNITS
from regression.plan.axes import PlanAxis
from regression.plan.plan import Plan
from regression.plan.sampling import BoxSampler, corner_unit, to_range

BASE: dict[str, Any] = {
    "name": "test",
    "sampling": {"size": 16, "seed": 3},
    "variables": {
        "pressure_hertz": {"low": "0.4 GPa", "high": "1.6 GPa"},
        "radius_equivalent": {"low": "8 mm", "high": "40 mm", "scale": "log"},
        "speed_entrainment": 5.0,
        "slide_to_roll": {"low": 0.02, "high": 1.2, "scale": "log"},
        "temperature_oil": "80 degC",
        "roughness_rms": "0.4 um",
    },
    "lubricant": {"oil": "fva3"},
}


def plan(change: Callable[[dict[str, Any]], object] = lambda content: None) -> Plan:
    content = copy.deepcopy(BASE)
    change(content)
    return validate(Plan, content)


@pytest.mark.parametrize("name", data_names("plans"))
def test_shipped_plans_are_valid(name: str) -> None:
    shipped = Plan.from_file(name)
    assert shipped.name == name
    origin, case = next(shipped.cases())
    assert origin == ("table" if shipped.table else "sobol")
    assert case.surface.roughness_rms > 0.0


def test_cases_lie_in_their_ranges_and_are_converted() -> None:
    cases = [case for _, case in plan().cases()]
    assert len(cases) == plan().count == 16
    assert all(0.4e9 <= case.contact.pressure_hertz <= 1.6e9 for case in cases)
    assert all(0.008 <= case.contact.radius_equivalent <= 0.040 for case in cases)
    assert {case.lubricant.temperature_oil for case in cases} == {353.15}
    assert cases[0].surface.roughness_rms == pytest.approx(0.4e-6, rel=1e-14)
    assert cases[0].surface.roughness_rms_1 == cases[0].surface.roughness_rms_2


def test_lists_multiply_the_sampled_points() -> None:
    two = plan(lambda c: c["variables"].update(speed_entrainment=["2 m/s", "8 m/s"], temperature_oil=[333, 353, 373]))
    cases = [case for _, case in two.cases()]
    assert len(cases) == two.count == 16 * 6
    pressures = [{c.contact.pressure_hertz for c in cases if c.contact.speed_entrainment == u} for u in (2.0, 8.0)]
    assert pressures[0] == pressures[1]


def test_full_factorial_lattice_without_sampling() -> None:
    def lattice(c: dict[str, Any]) -> None:
        c.pop("sampling")
        c["variables"].update(pressure_hertz=["0.5 GPa", "1 GPa"], radius_equivalent=0.01, slide_to_roll=[0.1, 0.3, 1])

    origins, cases = zip(*plan(lattice).cases(), strict=True)
    assert set(origins) == {"lattice"}
    points = {(case.contact.pressure_hertz, case.contact.slide_to_roll) for case in cases}
    assert points == {(p, s) for p in (0.5e9, 1e9) for s in (0.1, 0.3, 1.0)}


def test_corners_are_met_exactly() -> None:
    corners = plan(lambda c: c["sampling"].update(corners=True))
    assert corners.count == 16 + 8
    met = {
        (case.contact.pressure_hertz, case.contact.radius_equivalent, case.contact.slide_to_roll)
        for origin, case in corners.cases()
        if origin == "corner"
    }
    assert met == {(p, r, s) for p in (0.4e9, 1.6e9) for r in (0.008, 0.04) for s in (0.02, 1.2)}


def test_lengthwise_sliding_as_a_ratio() -> None:
    ratio = plan(lambda c: c["variables"].update(lengthwise_to_roll=0.5, speed_entrainment=[2.0, 4.0]))
    assert {c.contact.speed_sliding_lengthwise / c.contact.speed_entrainment for _, c in ratio.cases()} == {0.5}


def test_lubricant_by_numbers_may_vary() -> None:
    def direct(c: dict[str, Any]) -> None:
        c["lubricant"] = {"pressure_viscosity": "18 1/GPa", "eyring_stress": "5 MPa"}
        c["variables"]["viscosity_inlet"] = {"low": "5 mPa s", "high": "50 mPa s", "scale": "log"}

    viscosity = [case.lubricant.lubricant().viscosity_inlet for _, case in plan(direct).cases()]
    assert 0.005 <= min(viscosity) < 0.01
    assert 0.03 < max(viscosity) <= 0.05


def test_plan_hash_follows_the_cases_and_not_the_words() -> None:
    assert plan().plan_hash == plan(lambda c: c.update(name="other", description="words")).plan_hash
    assert plan().plan_hash == plan(lambda c: c["variables"].update(speed_entrainment="18 km/hour")).plan_hash
    assert plan().plan_hash != plan(lambda c: c["sampling"].update(seed=4)).plan_hash
    assert plan().plan_hash != plan(lambda c: c.update(model={"accuracy": "fast"})).plan_hash


AXES: list[tuple[str, Any, str]] = [
    ("pressure_hertz", {"low": "1 GPa"}, "pressure_hertz.high"),
    ("pressure_hertz", {"low": "1 GPa", "high": "3 mm"}, "pressure_hertz.high"),
    ("pressure_hertz", {"low": "1 GPa", "high": "0.5 GPa"}, "pressure_hertz.high"),
    ("pressure_hertz", {"low": "1 GPa", "high": float("nan")}, "pressure_hertz.high"),
    ("slide_to_roll", {"low": 0, "high": 1, "scale": "log"}, "slide_to_roll.low"),
    ("slide_to_roll", {"low": 0, "high": 1, "scale": "cubic"}, "slide_to_roll.scale"),
    ("slide_to_roll", {"low": 0, "high": 1, "step": 2}, "slide_to_roll.step"),
    ("radius_equivalent", "-1 mm", "radius_equivalent.value"),
    ("radius_equivalent", [], "radius_equivalent.values"),
    ("radius_equivalent", [0.01, "10 mm"], "radius_equivalent.values"),
    ("radius", 0.01, "radius"),
    ("roughness_rms_1", 1e-7, "roughness_rms"),
    ("speed_entrainment", list(range(1, 1002)), "speed_entrainment.values"),
]
CHANGES: list[tuple[Callable[[dict[str, Any]], object], str]] = [
    (lambda c: c.update(name="a\x1b[31m"), "name"),
    (lambda c: c["sampling"].update(corners=-1), "sampling.corners"),  # a switch or a number: one problem
    (lambda c: c["variables"].pop("pressure_hertz"), "variables.pressure_hertz"),
    (lambda c: c["variables"].update(lengthwise_to_roll=1, speed_sliding_lengthwise=1), "variables.lengthwise_to_roll"),
    (lambda c: c.update(table={"roughness_rms_1": [1e-7]}), "variables.roughness_rms"),
    (lambda c: c["sampling"].update(size=20), "sampling.size"),
    (lambda c: c["sampling"].update(size=0), "sampling.size"),
    (lambda c: c["sampling"].update(size=2**20), "sampling.size"),
    (lambda c: c.pop("sampling"), "sampling.size"),
    (lambda c: c["variables"].pop("temperature_oil"), "variables.temperature_oil"),
    (lambda c: c["lubricant"].update(temperature_oil=353), "lubricant.temperature_oil"),
    (lambda c: c["lubricant"].update(oil="fva9"), "lubricant.oil"),
    (lambda c: c.update(model={"accuracy": "best"}), "model.accuracy"),
    (lambda c: c.update(surface={"roughness_rms_1": 1e-7}), "surface.roughness_rms_1"),
    (lambda c: c.update(surface={"profile_1": "x.csv"}), "surface.profile_1"),
    (lambda c: c.update(effective_modulus="1 mm"), "effective_modulus"),
]


def test_bad_plans_name_their_field() -> None:
    for name, value, field in AXES:
        with refuses(f"variables.{field}"):
            plan(lambda c, given={name: value}: c["variables"].update(given))
    for change, field in CHANGES:
        with refuses(field):
            plan(change)


def test_unreadable_plans(tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text("name = ")
    for path in (tmp_path / "none.toml", tmp_path / "plan.toml", tmp_path):
        with pytest.raises(InputError):
            Plan.from_file(path)


def test_sobol_is_reproducible_nested_and_even() -> None:
    def unit(size: int, seed: int) -> np.ndarray:
        axes = {name: PlanAxis(values=(0.0, 1.0), scale="linear", sampled=True) for name in ("load", "speed", "heat")}
        return np.column_stack([*BoxSampler(axes, "sobol", seed).inside(size, None).columns.values()])

    small, large = unit(16, 7), unit(64, 7)
    np.testing.assert_array_equal(small, large[:16])
    assert not np.array_equal(small, unit(16, 8))
    # a (t, m, s)-net: each half of each axis holds exactly half of the points
    np.testing.assert_array_equal((large < 0.5).sum(axis=0), 32)


def test_ends_of_ranges_are_exact() -> None:
    for scale in ("linear", "log"):
        ends = to_range(np.array([0.0, 1.0]), 0.1, 0.7, scale)
        assert ends.tolist() == [0.1, 0.7]
    assert float(to_range(np.array(0.5), 1.0, 100.0, "log")) == pytest.approx(10.0, rel=1e-14)
    assert corner_unit(3).shape == (8, 3)


@pytest.mark.parametrize("oil", ["fva3", "75w90", "pao100", "5p4e"])
def test_the_oil_at_many_points_is_that_at_each(oil: str) -> None:
    plan = Plan.from_file("demo", [f"lubricant.oil={oil}"])
    points = plan.points.columns
    table = plan.conditions({name: column[:20] for name, column in points.items()}, [None] * 20)
    for row in range(20):
        one = plan.conditions({name: column[row : row + 1] for name, column in points.items()}, [None])
        for name in LUBRICANT_UNITS:
            assert one[name][0] == pytest.approx(table[name][row], rel=1e-15), name
