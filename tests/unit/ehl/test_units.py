from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ehl.common.errors import InputError
from ehl.common.units import UNITS, ValueRange, _registry, parse_quantity


@pytest.mark.parametrize(
    ("text", "unit", "expected"),
    [
        ("1.8 GPa", "Pa", 1.8e9),
        ("10mm", "m", 0.01),
        ("18 1/GPa", "1/Pa", 18e-9),
        ("80 degC", "K", 353.15),
        ("80 °C", "K", 353.15),
        ("-40 degC", "K", 233.15),
        ("300 K", "K", 300.0),
        ("1500 rpm", "rad/s", 1500 * 2 * math.pi / 60),
        ("250 N m", "N*m", 250.0),
        ("0.3 um", "m", 0.3e-6),
        ("0.3 µm", "m", 0.3e-6),
        ("96.9 cSt", "m^2/s", 96.9e-6),
        ("40 mPa s", "Pa*s", 0.04),
        ("20 deg", "rad", math.radians(20.0)),
        ("0.3", "", 0.3),
        ("30 %", "", 0.3),
        (5, "m/s", 5.0),
    ],
)
def test_text_becomes_si(text: object, unit: str, expected: float) -> None:
    assert parse_quantity(text, unit) == pytest.approx(expected, rel=1e-12)


@given(st.floats(-1e6, 1e6))
def test_number_and_its_text_agree(value: float) -> None:
    assert parse_quantity(f"{value!r} MPa", "Pa") == pytest.approx(value * 1e6, rel=1e-12)


@pytest.mark.parametrize("value", ["10 s", "abc", "", "10 wombats", "nan", "inf m", True, None, [1.0], "1 2 m", "; m"])
def test_what_is_no_length_is_refused_with_field_and_value(value: object) -> None:
    with pytest.raises(InputError) as caught:
        parse_quantity(value, "m", field="contact.radius_equivalent")
    assert "contact.radius_equivalent" in str(caught.value)


def test_bare_number_is_refused_where_it_is_ambiguous() -> None:
    with pytest.raises(InputError, match="ambiguous"):
        parse_quantity("1500", "rad/s", field="--speed", bare=False)


def test_range_is_named_with_its_unit() -> None:
    with pytest.raises(InputError, match="above 0 m and at most 10 m"):
        ValueRange("m", gt=0.0, le=10.0).check(-1.0, "radius")
    assert ValueRange("m", gt=0.0, le=10.0).check("1 cm", "radius") == pytest.approx(0.01)


TORQUE = ValueRange("N*m", gt=0.0, le=1000.0)


def test_list_takes_its_unit_from_the_last_entry() -> None:
    assert TORQUE.check_list("100, 200,300 N m", "--torque") == [100.0, 200.0, 300.0]
    assert TORQUE.check_list("1 kN m, 200 N m", "--torque") == [1000.0, 200.0]
    for text in ("100", "100, 200", "100 N m, 200", "", ","):
        with pytest.raises(InputError, match="--torque"):
            TORQUE.check_list(text, "--torque")
    with pytest.raises(InputError, match=r"--torque = '2000 N m' .*at most 1000 N\*m"):
        TORQUE.check_list("100, 2000 N m", "--torque")


def test_range_counts_its_values_with_both_ends() -> None:
    assert TORQUE.check_list("50:200:4 N m", "--torque") == [50.0, 100.0, 150.0, 200.0]
    assert TORQUE.check_list("0.2:0.1:2kN m", "--torque") == [200.0, 100.0]
    for text in (
        "50:200 N m",
        "50:200:1 N m",
        "50:200:4",
        "50:200:4.5 N m",
        "1:2:3:4 N m",
        "50:200:20000 N m",
        "::",
        "1:2:3",
    ):
        with pytest.raises(InputError, match="from:to:number unit"):
            TORQUE.check_list(text, "--torque")
    with pytest.raises(InputError, match="at most 1000"):
        TORQUE.check_list("50:2000:4 N m", "--torque")


@pytest.mark.parametrize("name", UNITS)
def test_common_units_convert_to_the_last_bit_as_by_pint(name: str) -> None:
    unit, _, _ = UNITS[name]
    registry = _registry()
    for value in (0.1, -1.7, 12.34567890123, 2.3e-7, 8.9e8):
        quantity = registry.Quantity(value, registry.Unit(name))
        assert parse_quantity(f"{value!r} {name}", unit) == quantity.to(registry.Unit(unit)).magnitude
