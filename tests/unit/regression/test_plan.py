"""Plan files and their points: what they accept, mean and refuse; ranges from what gears see."""

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contacts import gear_state
from refusals import refuses

from ehl.common.data import data_names
from ehl.common.errors import InputError
from ehl.common.validation import validate
from ehl.fluid.oil import Oil
from ehl.material import Material, effective_modulus
from regression.friction.conditions import STATE_UNITS, derive, lubricant_row
from regression.plan.operating_range import WeightedPoints, operating_range, weighted_quantile
from regression.plan.plan import Plan
from regression.plan.sampling import FLASH_FRICTION, BoxSampler, PlanAxis, constrained_quantities

RANGES: dict[str, Any] = {
    "pressure_hertz": {"low": "0.4 GPa", "high": "2.4 GPa"},
    "radius_equivalent": {"low": "5 mm", "high": "80 mm", "scale": "log"},
    "speed_entrainment": {"low": 1.0, "high": 20.0, "scale": "log"},
    "slide_to_roll": {"low": 0.02, "high": 1.2, "scale": "log"},
    "temperature_oil": "80 degC",
    "roughness_rms": "0.4 um",
}
BASE: dict[str, Any] = {
    "name": "test",
    "sampling": {"size": 16, "seed": 3},
    "variables": RANGES | {"speed_entrainment": 5.0},
    "lubricant": {"oil": "fva3"},
}


def plan(change: Callable[[dict[str, Any]], object] = lambda content: None) -> Plan:
    content = copy.deepcopy(BASE)
    change(content)
    return validate(Plan, content)


def wide(**changes: Any) -> Plan:
    return validate(Plan, {**BASE, "sampling": {"size": 64, "seed": 3}, "variables": RANGES, **changes})


@pytest.mark.parametrize("name", data_names("plans"))
def test_shipped_plans_are_valid(name: str) -> None:
    shipped = Plan.from_file(name)
    assert shipped.name == name
    origin, case = next(shipped.cases())
    assert origin == ("table" if shipped.table else "sobol")
    assert case.surface.roughness_rms > 0.0


def test_cases_lie_in_their_ranges_and_lists_multiply_the_sampled_points() -> None:
    def direct(c: dict[str, Any]) -> None:
        c["lubricant"] = {"pressure_viscosity": "18 1/GPa", "eyring_stress": "5 MPa"}
        c["variables"]["viscosity_inlet"] = {"low": "5 mPa s", "high": "50 mPa s", "scale": "log"}
        c["variables"] |= {"speed_entrainment": ["2 m/s", "8 m/s"], "lengthwise_to_roll": 0.5}

    two = plan(direct)
    cases = [case for _, case in two.cases()]
    assert len(cases) == two.count == 16 * 2
    assert all(0.4e9 <= case.contact.pressure_hertz <= 2.4e9 for case in cases)
    assert all(0.005 <= case.contact.radius_equivalent <= 0.08 for case in cases)
    viscosity = [case.lubricant.lubricant().viscosity_inlet for case in cases]
    assert 0.005 <= min(viscosity) < 0.01 < 0.03 < max(viscosity) <= 0.05
    assert {case.lubricant.temperature_oil for case in cases} == {353.15}
    assert cases[0].surface.roughness_rms == pytest.approx(0.4e-6, rel=1e-14)
    pressures = [{c.contact.pressure_hertz for c in cases if c.contact.speed_entrainment == u} for u in (2.0, 8.0)]
    assert pressures[0] == pressures[1]
    assert {c.contact.speed_sliding_lengthwise / c.contact.speed_entrainment for c in cases} == {0.5}


def test_corners_are_met_exactly() -> None:
    corners = plan(lambda c: c["sampling"].update(corners=True))
    assert corners.count == 16 + 8
    met = {
        (case.contact.pressure_hertz, case.contact.radius_equivalent, case.contact.slide_to_roll)
        for origin, case in corners.cases()
        if origin == "corner"
    }
    assert met == {(p, r, s) for p in (0.4e9, 2.4e9) for r in (0.005, 0.08) for s in (0.02, 1.2)}
    few = wide(sampling={"size": 64, "corners": 5})
    assert few.count == 69
    assert few.points.origin.count("corner") == 5


def test_plan_hash_follows_the_cases_and_not_the_words() -> None:
    assert plan().plan_hash == plan(lambda c: c.update(name="other", description="words")).plan_hash
    assert plan().plan_hash == plan(lambda c: c["variables"].update(speed_entrainment="18 km/hour")).plan_hash
    assert plan().plan_hash != plan(lambda c: c["sampling"].update(seed=4)).plan_hash
    assert plan().plan_hash != plan(lambda c: c.update(model={"accuracy": "fast"})).plan_hash


AXES: list[tuple[str, Any, str]] = [
    ("pressure_hertz", {"low": "1 GPa"}, "pressure_hertz.high"),
    ("pressure_hertz", {"low": "1 GPa", "high": "0.5 GPa"}, "pressure_hertz.high"),
    ("radius_equivalent", {"low": 8, "high": "40 mm"}, "radius_equivalent.high"),
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
    (lambda c: c["sampling"].update(corners=-1), "sampling.corners"),  # a switch or a number: one problem
    (lambda c: c["variables"].pop("pressure_hertz"), "variables.pressure_hertz"),
    (lambda c: c["variables"].update(lengthwise_to_roll=1, speed_sliding_lengthwise=1), "variables.lengthwise_to_roll"),
    (lambda c: c.update(table={"roughness_rms_1": [1e-7]}), "variables.roughness_rms"),
    (lambda c: c["sampling"].update(size=20), "sampling.size"),
    (lambda c: c["sampling"].update(size=2**20), "sampling.size"),
    (lambda c: c["sampling"].update(size=True), "sampling.size"),
    (lambda c: c["sampling"].update(seed=False), "sampling.seed"),
    (lambda c: c["lubricant"].update(oil=True), "lubricant.oil"),
    (lambda c: c.pop("sampling"), "sampling.size"),
    (lambda c: c["lubricant"].update(temperature_oil=353), "lubricant.temperature_oil"),
    (lambda c: c.update(surface={"roughness_rms_1": 1e-7}), "surface.roughness_rms_1"),
    (lambda c: c.update(surface={"profile_1": "x.csv"}), "surface.profile_1"),
    (lambda c: c.update(effective_modulus="1 mm"), "effective_modulus"),
    (lambda c: c.update(constraints={"lambda": {"low": 1}}), "constraints.lambda"),
    (lambda c: c.update(constraints={"film_ratio": {"low": 2, "high": 1}}), "constraints.film_ratio.high"),
    (lambda c: c.update(constraints={"film_ratio": {}}), "constraints.film_ratio.low"),
    (lambda c: c.update(constraints={"film_ratio": 2}), "constraints.film_ratio.low"),
    (lambda c: c.update(constraints={"load_per_length": {"high": "3 GPa"}}), "constraints.load_per_length.high"),
]


def test_bad_plans_name_their_field() -> None:
    for name, value, field in AXES:
        with refuses(f"variables.{field}"):
            plan(lambda c, given={name: value}: c["variables"].update(given))
    for change, field in CHANGES:
        with refuses(field):
            plan(change)
    for option in ("sampling.size", "=3", "a..b=3", "name.first=3"):
        with refuses("changes"):
            Plan.from_file("demo", [option])


def test_sobol_is_reproducible_nested_and_even() -> None:
    def unit(size: int, seed: int) -> np.ndarray:
        axes = {name: PlanAxis(values=(0.0, 1.0), scale="linear", sampled=True) for name in ("load", "speed", "heat")}
        points = BoxSampler(axes, "sobol", seed).inside(size, lambda columns, number: number >= 0)
        return np.column_stack([*points.columns.values()])

    small, large = unit(16, 7), unit(64, 7)
    np.testing.assert_array_equal(small, large[:16])
    assert not np.array_equal(small, unit(16, 8))
    # a (t, m, s)-net: each half of each axis holds exactly half of the points
    np.testing.assert_array_equal((large < 0.5).sum(axis=0), 32)


LIMITS = {"load_per_length": {"high": "1500 N/mm"}, "film_ratio": {"low": 0.5}, "speed_sliding": {"high": "8 m/s"}}


def test_constraints_keep_the_size_and_hold_at_every_case() -> None:
    bounded = wide(constraints=LIMITS)
    cases = [case for _, case in bounded.cases()]
    assert len(cases) == bounded.count == 64
    for case in cases:
        contact = case.line_contact()
        assert contact.load_per_length <= 1500e3 * (1 + 1e-12)
        assert contact.speed_sliding <= 8.0
    figures = bounded.constrained(bounded.points.columns, bounded.points.oils)
    assert figures["film_ratio"].min() >= 0.5
    # what the case itself computes
    loads = [case.line_contact().load_per_length for case in cases]
    np.testing.assert_allclose(figures["load_per_length"], loads, rtol=1e-12)
    assert 0.05 < bounded.points.rejected["load_per_length"] < 0.6


def test_constrained_points_are_those_of_the_free_sequence_that_pass() -> None:
    """With their roughness, and in any number."""
    free = wide(sampling={"size": 256, "seed": 3})
    bounded, short = wide(constraints=LIMITS), wide(constraints=LIMITS, sampling={"size": 50, "seed": 3})
    figures = bounded.constrained(free.points.columns, free.points.oils)
    inside = (figures["load_per_length"] <= 1500e3) & (figures["film_ratio"] >= 0.5) & (figures["speed_sliding"] <= 8.0)
    for name, column in bounded.points.columns.items():
        np.testing.assert_array_equal(column, free.points.columns[name][inside][:64])
        np.testing.assert_array_equal(column[:50], short.points.columns[name])
    assert bounded.points.seed.tolist() == free.points.seed[inside][:64].tolist()


def test_constraints_nothing_passes_are_refused() -> None:
    listed = {**RANGES, **{name: RANGES[name]["low"] for name in list(RANGES)[:4]}}
    for change in ({}, {"variables": listed, "sampling": {}}):
        with refuses("constraints"):
            wide(constraints={"film_ratio": {"low": 1000.0}}, **change)


def test_flash_temperature_of_blok() -> None:
    steel = Material.load("steel")
    modulus = effective_modulus(steel, steel)
    state = {"pressure_hertz": 1e9, "radius_equivalent": 0.01, "effective_modulus": modulus, "temperature_oil": 353.15}
    state |= {"speed_entrainment": 6.5, "slide_to_roll": 5.0 / 6.5, "speed_sliding_lengthwise": 0.0}
    state |= {"roughness_rms_1": 0.0, "roughness_rms_2": 0.0, "correlation_length": 2e-5}
    found = constrained_quantities({n: np.array([v]) for n, v in state.items()}, (steel, steel), None)
    # 1.11 mu w' |sqrt(u1) - sqrt(u2)| / (e sqrt(2 b)), by hand for u1 = 9 m/s, u2 = 4 m/s
    rise = 1.11 * FLASH_FRICTION * found["load_per_length"] * (3.0 - 2.0)
    rise /= steel.thermal_effusivity * (2.0 * found["half_width"]) ** 0.5
    np.testing.assert_allclose(found["temperature_flash"], 353.15 + rise, rtol=1e-12)


def test_latin_hypercube_has_one_point_in_each_row() -> None:
    sampled = wide(sampling={"method": "latin_hypercube", "size": 40, "seed": 2})
    assert set(sampled.points.origin) == {"latin"}
    assert sampled.count == 40
    pressure = np.sort(sampled.points.columns["pressure_hertz"])
    assert ((pressure - 0.4e9) / 2e9 * 40).astype(int).tolist() == list(range(40))


def test_levels_and_factorial_plans() -> None:
    levels = {**RANGES, "pressure_hertz": {"low": 0.5e9, "high": 2e9, "scale": "log", "levels": 3}}
    mixed = wide(variables=levels)
    assert sorted(set(mixed.points.columns["pressure_hertz"])) == pytest.approx([0.5e9, 1e9, 2e9], rel=1e-14)
    factorial = wide(variables=levels, sampling={"method": "factorial", "levels": 4})
    assert factorial.count == 3 * 4**3 == len(factorial.points)
    assert set(factorial.points.origin) == {"lattice"}
    speeds = sorted(set(factorial.points.columns["speed_entrainment"]))
    assert speeds == pytest.approx([20.0 ** (k / 3) for k in range(4)], rel=1e-14)
    with refuses("sampling.levels"):
        wide(sampling={"method": "factorial"})
    with refuses("variables.pressure_hertz.levels"):
        wide(variables={**RANGES, "pressure_hertz": {"low": 1e9, "high": 2e9, "levels": 1}})


def test_several_oils_meet_the_same_points() -> None:
    both = wide(lubricant={"oil": ["fva3", "75w90"]})
    assert both.oils == ("fva3", "75w90")
    cases = [case for _, case in both.cases()]
    assert [case.lubricant.oil for case in cases] == ["fva3"] * 64 + ["75w90"] * 64
    assert [c.contact.pressure_hertz for c in cases[:64]] == [c.contact.pressure_hertz for c in cases[64:]]
    with refuses("lubricant.oil"):
        wide(lubricant={"oil": ["75W-90", "75w90"]})
    speeds = [wide(variables={**RANGES, "speed_entrainment": of([2.0, 4.0])}).count for of in (tuple, np.array)]
    assert speeds == [128, 128]


def test_film_ratio_of_the_constraint_is_that_of_the_dataset() -> None:
    both = wide(lubricant={"oil": ["fva3", "75w90"]}, constraints={"film_ratio": {"low": 1e-3}})
    figures = both.constrained(both.points.columns, both.points.oils)
    for index in (0, 70, 127):
        case = both.case_at(index)
        contact = case.line_contact()
        sources = (contact, case.lubricant, case.surface)
        row = {name: getattr(part, name) for name in STATE_UNITS for part in sources if hasattr(part, name)}
        row |= lubricant_row(case.lubricant.lubricant(), contact.pressure_hertz)
        ratio = derive({name: np.array([value]) for name, value in row.items()})["film_ratio_formula"]
        assert figures["film_ratio"][index] == pytest.approx(float(ratio[0]), rel=1e-10)


def test_every_point_has_a_roughness_of_its_own_and_realisations_are_a_factor() -> None:
    rough = wide(sampling={"size": 16, "realisations": 3})
    seeds = [case.surface.seed for _, case in rough.cases()]
    assert rough.count == len(seeds) == 48
    assert seeds == list(range(1, 49))
    pressures = rough.points.columns["pressure_hertz"].reshape(16, 3)
    assert (pressures == pressures[:, :1]).all()
    same = wide(sampling={"size": 16, "realisations": 3, "same_profile": True}, surface={"seed": 5})
    assert [case.surface.seed for _, case in same.cases()] == [5, 6, 7] * 16


def test_variables_of_the_surface() -> None:
    lengths = {"low": "20 um", "high": "100 um"}
    rough = wide(variables=RANGES | {"correlation_length": lengths, "boundary_friction": [0.08, 0.12]})
    surfaces = [case.surface for _, case in rough.cases()]
    assert len(surfaces) == 128
    assert {surface.boundary_friction for surface in surfaces} == {0.08, 0.12}
    assert all(20e-6 <= surface.correlation_length <= 100e-6 for surface in surfaces)
    with refuses("surface.boundary_friction"):
        wide(variables={**RANGES, "boundary_friction": [0.08, 0.12]}, surface={"boundary_friction": 0.1})


OIL = Oil.load("fva3")


def points(count: int = 400, **changes: Any) -> WeightedPoints:
    random = np.random.default_rng(3)
    values = {
        "pressure_hertz": random.uniform(0.5e9, 1.5e9, count),
        "radius_equivalent": 0.01 * 3.0 ** random.random(count),
        "speed_entrainment": 2.0 * 4.0 ** random.random(count),
        "slide_to_roll": random.uniform(-0.6, 0.6, count),
        "speed_sliding_lengthwise": random.uniform(-2.0, 2.0, count),
    }
    state = gear_state(**values | {"roughness_rms_2": 0.4e-6} | changes)
    return WeightedPoints(state, np.ones(state.size), OIL)


def test_weighted_quantiles() -> None:
    values = np.array([3.0, 1.0, 2.0, 10.0])
    # equal weights: the quantiles of Hazen
    levels = np.linspace(0.05, 0.95, 7)
    expected = np.quantile(values, levels, method="hazen")
    np.testing.assert_allclose(weighted_quantile(values, np.ones(4), levels), expected, rtol=1e-14)
    # a weight of two is the point twice, in the middle of which the level is the same
    repeated = np.repeat(np.random.default_rng(1).random(50), 4)
    single = weighted_quantile(repeated[::4], np.full(50, 4.0), levels)
    np.testing.assert_allclose(single, np.quantile(repeated[::4], levels, method="hazen"), rtol=1e-14)
    # points without weight do not count, whatever they are
    assert weighted_quantile([1.0, 5.0, 99.0], [1.0, 1.0, 0.0], 1.0) == 5.0
    for bad in (([], []), ([1.0], [0.0]), ([1.0, 2.0], [1.0, -1.0]), ([1.0], [np.nan]), ([1.0], [1.0, 2.0])):
        with refuses("weights"):
            weighted_quantile(*bad, 0.5)


def test_ranges_hold_the_share_of_the_weight_asked_for() -> None:
    part = points()
    weighted = WeightedPoints(part.state, part.state.pressure_hertz * part.state.speed_sliding, OIL)
    ranges = operating_range([weighted], 0.9)
    for name, values in (
        ("pressure_hertz", part.state.pressure_hertz),
        ("speed_entrainment", part.state.speed_entrainment),
        ("slide_to_roll", np.abs(part.state.slide_to_roll)),
    ):
        inside = (values >= ranges[name].low) & (values <= ranges[name].high)
        assert weighted.weight[inside].sum() / weighted.weight.sum() == pytest.approx(0.9, abs=0.01)
        assert ranges[name].minimum == values.min()
        assert ranges[name].maximum == values.max() == ranges.to_frame().loc[name, "maximum"]
    # sliding weighs: what slides more is seen more
    assert ranges["slide_to_roll"].median > operating_range([part], 0.9)["slide_to_roll"].median
    assert {"lengthwise_to_roll", "temperature_oil", "roughness_rms", "film_ratio"} <= set(ranges.variables)
    with pytest.raises(InputError):
        operating_range([])
    with refuses("coverage"):
        operating_range([points()], 0.2)


def test_the_plan_holds_the_ranges_and_is_one(tmp_path: Path) -> None:
    texture = {"correlation_length": 45e-6}
    hot = points(temperature_oil=393.15, **texture)
    ranges = operating_range([points(**texture), hot], 0.95)
    text = ranges.plan_text("seen", ("fva3", "75w90"), size=40, description='what "gears" see')
    (tmp_path / "seen.toml").write_text(text)
    plan = Plan.from_file(tmp_path / "seen.toml")
    assert ranges.plan("seen", ["fva3", "75w90"], size=40).plan_hash == plan.plan_hash
    assert plan.description == 'what "gears" see'
    assert plan.count == 80
    assert plan.oils == ("fva3", "75w90")
    for name, axis in plan.variables.items():
        if axis.sampled:
            (low, high), seen = axis.values, ranges[name]
            assert low <= seen.low < seen.high <= high
            # a tenth more at each end, and the rounding
            scale = np.log if axis.scale == "log" else np.asarray
            assert low == 0.0 or np.ptp(scale([low, high])) == pytest.approx(
                1.2 * np.ptp(scale([seen.low, seen.high])), rel=0.05
            )
    # one roughness, one value
    assert plan.variables["roughness_rms"].values == pytest.approx((0.5e-6,), rel=0.01)
    assert plan.variables["correlation_length"].values == pytest.approx((45e-6,), rel=0.01)
    window = plan.constraints["film_ratio"]
    assert window.low < ranges["film_ratio"].low < ranges["film_ratio"].high < window.high


def test_spur_gears_have_no_lengthwise_sliding_and_a_pitch_point(tmp_path: Path) -> None:
    spur = points(speed_sliding_lengthwise=0.0, slide_to_roll=np.linspace(-1e-5, 0.4, 400))
    text = operating_range([spur], 1.0).plan_text("spur", ("fva3",), size=32)
    assert "lengthwise_to_roll = 0.0" in text
    (tmp_path / "spur.toml").write_text(text)
    low, _ = Plan.from_file(tmp_path / "spur.toml").variables["slide_to_roll"].values
    assert 1e-4 < low <= 1e-3


def test_refusals() -> None:
    with pytest.raises(InputError):
        operating_range([])
    with refuses("coverage"):
        operating_range([points()], 0.2)
