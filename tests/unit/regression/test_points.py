"""Points of a plan: constraints, Latin hypercubes, factorials, oils and roughness realisations as factors."""

from typing import Any

import numpy as np
import pytest
from refusals import refuses

from ehl.common.errors import InputError
from ehl.common.validation import validate
from ehl.fluid.oil import Oil
from ehl.line_contact import blok_1937
from ehl.material import Material, effective_modulus
from regression.friction.conditions import STATE_UNITS, derive, lubricant_row
from regression.plan.plan import Plan
from regression.plan.sampling import FLASH_FRICTION, constrained_quantities

RANGES: dict[str, Any] = {
    "pressure_hertz": {"low": "0.4 GPa", "high": "2.4 GPa"},
    "radius_equivalent": {"low": "5 mm", "high": "80 mm", "scale": "log"},
    "speed_entrainment": {"low": 1.0, "high": 20.0, "scale": "log"},
    "slide_to_roll": {"low": 0.02, "high": 1.2, "scale": "log"},
    "temperature_oil": "80 degC",
    "roughness_rms": "0.4 um",
}


def plan(**changes: Any) -> Plan:
    content = {
        "name": "points",
        "sampling": {"size": 64, "seed": 3},
        "variables": RANGES,
        "lubricant": {"oil": "fva3"},
        **changes,
    }
    return validate(Plan, content)


LIMITS = {"load_per_length": {"high": "1500 N/mm"}, "film_ratio": {"low": 0.5}, "speed_sliding": {"high": "8 m/s"}}


def test_constraints_keep_the_size_and_hold_at_every_case() -> None:
    bounded = plan(constraints=LIMITS)
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
    free = plan(sampling={"size": 256, "seed": 3})
    bounded = plan(constraints=LIMITS)
    figures = bounded.constrained(free.points.columns, free.points.oils)
    inside = (figures["load_per_length"] <= 1500e3) & (figures["film_ratio"] >= 0.5) & (figures["speed_sliding"] <= 8.0)
    for name, column in bounded.points.columns.items():
        np.testing.assert_array_equal(column, free.points.columns[name][inside][:64])


def test_any_size_with_constraints_and_the_longer_plan_begins_with_the_shorter() -> None:
    short = plan(constraints=LIMITS, sampling={"size": 50})
    longer = plan(constraints=LIMITS, sampling={"size": 90})
    assert (short.count, longer.count) == (50, 90)
    for name, column in short.points.columns.items():
        np.testing.assert_array_equal(column, longer.points.columns[name][:50])


def test_constraints_nothing_passes_are_refused() -> None:
    with pytest.raises(InputError, match=r"constraints.*windows that accept 1/64.*Widen"):
        plan(constraints={"film_ratio": {"low": 1000.0}})
    listed = {**RANGES, **{name: RANGES[name]["low"] for name in list(RANGES)[:4]}}
    with pytest.raises(InputError, match=r"constraints.*at least one case"):
        plan(constraints={"film_ratio": {"low": 1000.0}}, variables=listed, sampling={})


@pytest.mark.parametrize(
    ("constraints", "field"),
    [
        ({"film_ratio": {"low": 2, "high": 1}}, "film_ratio.high"),
        ({"film_ratio": {}}, "film_ratio.low"),
        ({"film_ratio": {"least": 1}}, "film_ratio.least"),
        ({"film_ratio": 2}, "film_ratio.low"),
        ({"load_per_length": {"high": "3 GPa"}}, "load_per_length.high"),
        ({"lambda": {"low": 1}}, "lambda"),
    ],
)
def test_bad_constraints(constraints: dict[str, Any], field: str) -> None:
    with refuses(f"constraints.{field}"):
        plan(constraints=constraints)


def test_flash_temperature_of_blok() -> None:
    steel = Material.load("steel")
    # 1.11 mu w' |sqrt(u1) - sqrt(u2)| / (e sqrt(2 b)), by hand for u1 = 9 m/s, u2 = 4 m/s
    load, half_width = 1e6, 0.3e-3
    expected = 1.11 * FLASH_FRICTION * load * (3.0 - 2.0) / (steel.thermal_effusivity * (2.0 * half_width) ** 0.5)
    carried = (9.0**0.5 + 4.0**0.5) * steel.thermal_effusivity
    assert blok_1937(FLASH_FRICTION * load * 5.0, half_width, carried) == pytest.approx(expected, rel=1e-12)
    modulus = effective_modulus(steel, steel)
    state = {"pressure_hertz": 1e9, "radius_equivalent": 0.01, "effective_modulus": modulus, "temperature_oil": 353.15}
    state |= {"speed_entrainment": 6.5, "slide_to_roll": 5.0 / 6.5, "speed_sliding_lengthwise": 0.0}
    state |= {"roughness_rms_1": 0.0, "roughness_rms_2": 0.0, "correlation_length": 2e-5}
    found = constrained_quantities({n: np.array([v]) for n, v in state.items()}, (steel, steel), None)
    heat = FLASH_FRICTION * found["load_per_length"] * 5.0
    rise = blok_1937(heat, found["half_width"], np.array([carried]))
    np.testing.assert_allclose(found["temperature_flash"], 353.15 + rise, rtol=1e-12)


def test_latin_hypercube_has_one_point_in_each_row() -> None:
    sampled = plan(sampling={"method": "latin_hypercube", "size": 40, "seed": 2})
    assert set(sampled.points.origin) == {"latin"}
    assert sampled.count == 40
    pressure = np.sort(sampled.points.columns["pressure_hertz"])
    assert ((pressure - 0.4e9) / 2e9 * 40).astype(int).tolist() == list(range(40))


def test_levels_and_factorial_plans() -> None:
    levels = {**RANGES, "pressure_hertz": {"low": 0.5e9, "high": 2e9, "scale": "log", "levels": 3}}
    mixed = plan(variables=levels)
    assert mixed.count == 3 * 64
    assert sorted(set(mixed.points.columns["pressure_hertz"])) == pytest.approx([0.5e9, 1e9, 2e9], rel=1e-14)
    factorial = plan(variables=levels, sampling={"method": "factorial", "levels": 4})
    assert factorial.count == 3 * 4**3 == len(factorial.points)
    assert set(factorial.points.origin) == {"lattice"}
    speeds = sorted(set(factorial.points.columns["speed_entrainment"]))
    assert speeds == pytest.approx([20.0 ** (k / 3) for k in range(4)], rel=1e-14)
    with pytest.raises(InputError, match=r"sampling.levels is missing"):
        plan(sampling={"method": "factorial"})
    with pytest.raises(InputError, match=r"levels.*whole number from 2"):
        plan(variables={**RANGES, "pressure_hertz": {"low": 1e9, "high": 2e9, "levels": 1}})


def test_several_oils_meet_the_same_points() -> None:
    both = plan(lubricant={"oil": ["fva3", "75w90"]})
    assert both.oils == ("fva3", "75w90")
    assert both.oil is None
    oils, pressures = [], []
    for _, case in both.cases():
        oils.append(case.lubricant.oil)
        pressures.append(case.contact.pressure_hertz)
    assert oils == ["fva3"] * 64 + ["75w90"] * 64
    assert pressures[:64] == pressures[64:]
    # constraints see each oil's own viscosity
    viscosities = {oil: Oil.load(oil).at(353.15).viscosity_inlet for oil in both.oils}
    assert viscosities["fva3"] != viscosities["75w90"]
    with pytest.raises(InputError, match=r"different names"):
        plan(lubricant={"oil": ["fva3", "fva3"]})


def test_film_ratio_of_the_constraint_is_that_of_the_dataset() -> None:
    both = plan(lubricant={"oil": ["fva3", "75w90"]}, constraints={"film_ratio": {"low": 1e-3}})
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
    rough = plan(sampling={"size": 16, "realisations": 3})
    seeds = [case.surface.seed for _, case in rough.cases()]
    assert rough.count == len(seeds) == 48
    assert seeds == list(range(1, 49))
    pressures = rough.points.columns["pressure_hertz"].reshape(16, 3)
    assert (pressures == pressures[:, :1]).all()
    same = plan(sampling={"size": 16, "realisations": 3, "same_profile": True}, surface={"seed": 5})
    assert [case.surface.seed for _, case in same.cases()] == [5, 6, 7] * 16
    # a constrained plan keeps the roughness of a point
    free = plan(sampling={"size": 256, "seed": 3})
    bounded = plan(constraints=LIMITS)
    by_point = dict(zip(free.points.columns["pressure_hertz"], free.points.seed, strict=True))
    assert [by_point[p] for p in bounded.points.columns["pressure_hertz"]] == bounded.points.seed.tolist()


def test_variables_of_the_surface() -> None:
    lengths = {"low": "20 um", "high": "100 um"}
    rough = plan(variables=RANGES | {"correlation_length": lengths, "boundary_friction": [0.08, 0.12]})
    surfaces = [case.surface for _, case in rough.cases()]
    assert len(surfaces) == 128
    assert {surface.boundary_friction for surface in surfaces} == {0.08, 0.12}
    assert all(20e-6 <= surface.correlation_length <= 100e-6 for surface in surfaces)
    with pytest.raises(InputError, match=r"surface.boundary_friction.*variables"):
        plan(variables={**RANGES, "boundary_friction": [0.08, 0.12]}, surface={"boundary_friction": 0.1})


def test_a_number_of_corners() -> None:
    few = plan(sampling={"size": 64, "corners": 5})
    assert few.count == 69
    assert few.points.origin.count("corner") == 5
    all_corners = plan(sampling={"size": 64, "corners": True})
    assert all_corners.count == 64 + 16 == len(all_corners.points)


def test_default_plan_is_what_it_says() -> None:
    default = Plan.from_file("gear")
    assert default.count == len(default.points) == 512
    figures = default.constrained(default.points.columns, default.points.oils)
    ratio = figures["film_ratio"]
    # from boundary to full film, a good part of the cases on each side
    assert np.mean(ratio < 0.5) > 0.15
    assert np.mean(ratio > 3.0) > 0.1
    assert np.mean((ratio > 0.5) & (ratio < 3.0)) > 0.2
    other = Plan.from_file("gear", ["lubricant.oil=fva3"])
    assert other.count == 512
    assert other.oil == "fva3"


@pytest.mark.parametrize("change", ["sampling.size", "=3", "a..b=3", "name.first=3"])
def test_bad_changes(change: str) -> None:
    with pytest.raises(InputError, match="changes"):
        Plan.from_file("demo", [change])
