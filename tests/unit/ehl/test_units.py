import math
import re
import tokenize
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from refusals import refuses

from ehl.common.errors import InputError
from ehl.common.quantities import axis_label, format_number, quantity, to_display
from ehl.common.units import ARCSEC, KELVIN, UNITS, ValueRange, _registry, parse_quantity, spellings

# every way in which engineers write a value: unit of the field, number that it means or "refused", texts
_LINES = (Path(__file__).parents[3] / "docs" / "spellings.tsv").read_text(encoding="utf-8").splitlines()[1:]
SPELLINGS = [(text, unit, value) for unit, value, *texts in (line.split("\t") for line in _LINES) for text in texts]
UNITS_READ = sorted({unit for _, unit, _ in SPELLINGS})


@pytest.mark.parametrize(("text", "unit", "expected"), SPELLINGS)
def test_text_becomes_si_or_is_refused_with_field_and_value(text: str, unit: str, expected: str) -> None:
    if expected != "refused":
        assert parse_quantity(text, unit) == pytest.approx(float(expected), rel=1e-9)
        return
    with refuses("contact.value") as caught:
        parse_quantity(text, unit, field="contact.value", bare=False)
    assert caught.value.value == text
    assert "a number in" not in caught.value.allowed  # which an option does not take


NO_NUMBERS = [True, None, [1.0], 10**400, math.nan, "35° 12' 60\"", "35° 60'", "1" * 201, "1e-99 m^-99"]
NO_DIGITS = ["2² mm", "² mm", "1₂ mm", "① mm", "-³ mm", "1.² mm", "0x10 mm", "1_0 mm"]
REFUSED = [("m", NO_NUMBERS + NO_DIGITS), ("rad", NO_NUMBERS), ("", ["0_1"]), ("rad/s", ["1500", 1500.0])]


@pytest.mark.parametrize(("unit", "values"), REFUSED)
def test_what_is_no_number_is_refused(unit: str, values: list[object]) -> None:
    for value in values:
        with refuses("length"):
            parse_quantity(value, unit, field="length", bare=unit != "rad/s")  # as an option needs its unit


@pytest.mark.parametrize("unit", sorted({*UNITS_READ} - {"rad/s"}))  # where 1/s is 1 rad/s for pint
def test_no_spelling_has_two_meanings(unit: str) -> None:
    import pint

    registry = _registry()
    compared = 0
    for name, (factor, zero) in spellings(unit).items():
        try:
            by_pint = registry.Quantity(1.0, registry.Unit(name)).to(registry.Unit(unit or "dimensionless")).magnitude
        except (pint.PintError, AttributeError, TypeError, ValueError, AssertionError, tokenize.TokenError):
            continue
        compared += 1
        assert factor + zero == pytest.approx(by_pint, rel=1e-9), name
    assert compared or unit == ""


@given(st.sampled_from(UNITS_READ), st.floats(-1e6, 1e6), st.data())
def test_spaces_and_signs_of_products_do_not_matter(unit: str, value: float, data: st.DataObject) -> None:
    name = data.draw(st.sampled_from(sorted(spellings(unit))))
    expected = parse_quantity(f"{value!r} {name}", unit)
    product = data.draw(st.sampled_from([" ", "*", "·", " * "]))
    assert parse_quantity(f"  {value!r}  {name.replace(' ', product)} ", unit) == expected


def test_numbers_too_small_and_units_that_pint_alone_reads() -> None:
    assert parse_quantity("1e-320 mm", "m") == parse_quantity(-1e-61, "m") == 0.0
    for text, unit, value in (("0.1 kcal/(kg degC)", "J/(kg*K)", 418.4), ("2 stone", "kg", 12.70058636)):
        assert parse_quantity(text, unit, bare=False) == pytest.approx(value, rel=1e-6)
    with refuses("torque"):
        ValueRange("N*m", gt=0.0).check("1e-320 N m", "torque")


ENDS = [
    ({"ge": 3.0, "le": 7.0}, (3.0, 7.0), (2.9, 7.1)),
    ({"gt": 3.0, "lt": 7.0}, (3.1, 6.9), (3.0, 7.0)),
    ({"ge": 3.0}, (3.0, 1e9), (2.9,)),
    ({"le": 7.0}, (-1e9, 7.0), (7.1,)),
]


@pytest.mark.parametrize(("limits", "inside", "outside"), ENDS)
@pytest.mark.parametrize("unit", ["m", ""])
def test_ends_of_a_range(limits: dict[str, float], inside: list[float], outside: list[float], unit: str) -> None:
    allowed = ValueRange(unit, **limits)
    for number in inside:
        assert allowed.check(f"{number} {unit}".strip(), "length") == number
    for number in outside:
        with refuses("length") as caught:
            allowed.check(f"{number} {unit}".strip(), "length")
        assert re.findall(r"\d", caught.value.allowed)[: len(limits)] == [f"{end:.0f}" for end in limits.values()]


@pytest.mark.parametrize(
    ("value", "allowed"),
    [
        ("300 degC", "at most 250 degC"),
        ("600 K", "at most 523.15 K"),
        ("600 °F", "at most 482 °F"),
        (600.0, "at most 250 degC"),
        (None, "at most 250 degC"),
    ],
)
def test_a_range_is_in_the_unit_of_the_value(value: object, allowed: str) -> None:
    assert ValueRange("K", ge=233.15, le=523.15).expected(value).partition(" (")[0].endswith(allowed)


def test_remedies() -> None:
    """The unit that was meant; the hint of the field where none makes a value fit; the nearest spelling of a unit."""
    pressure = ValueRange("Pa", ge=5e7, le=8e9)
    for bare, allowed, meant in (
        (25, ValueRange("m", gt=0.0, le=1.0), "25 mm"),
        (90, ValueRange("K", ge=233.0, le=523.0), "90 degC"),
        (1.2, pressure, "1.2 GPa"),
        (1200.0, pressure, "1200 MPa"),
    ):
        with refuses("field") as caught:
            allowed.check(bare, "field")
        assert meant in caught.value.hint
    with refuses("field") as caught:
        pressure.check(4.9e7, "field")  # of no other unit
    assert caught.value.hint.rpartition("'")[0].rpartition(" ")[2] == ""
    for value in (-1, "-1 m", 1e12):
        with pytest.raises(InputError) as caught:
            ValueRange("m", gt=0.0, le=1.0, hint="Measure it.").check(value, "field")
        assert caught.value.hint == "Measure it."
    for text, unit, meant in (("5 Nmm2x", "Pa", "N/mm2"), ("5 mpa s", "m", "mm")):
        with pytest.raises(InputError) as caught:
            parse_quantity(text, unit)
        assert caught.value.hint.endswith(f"{meant!r}?") is (meant != "mm")


TORQUE = ValueRange("N*m", gt=0.0, le=1000.0)


def test_list_takes_its_unit_from_the_last_entry() -> None:
    assert TORQUE.check_list("100, 200; 300 N m", "--torque") == [100.0, 200.0, 300.0]
    assert TORQUE.check_list("1 kN m, 200 N m", "--torque") == [1000.0, 200.0]
    wrong = ["100", "100, 200", "100 N m, 200", "", ",", "1,5 kN m", "100,200 N m", "1,5; 2 kN m", "100, 2000 N m"]
    for text in [*wrong, "5, 200 N m; 1 kN m"]:
        with refuses("--torque"):
            TORQUE.check_list(text, "--torque")


def test_range_counts_its_values_with_both_ends() -> None:
    assert TORQUE.check_list("50:200:4 N m", "--torque") == [50.0, 100.0, 150.0, 200.0]
    assert TORQUE.check_list("0.2:0.1:2kN m", "--torque") == [200.0, 100.0]
    assert ValueRange("m").check_list("-0.1:0.1:7 m", "E")[3] == 0.0
    for unit in ("N*m", "", "K"):
        with pytest.raises(InputError) as caught:
            ValueRange(unit).check_list("5:6", "field")
        assert len(ValueRange(unit).check_list(caught.value.allowed.split("'")[-2], "field")) == 4
    wrong = ["50:200", "50:200:1", "50:200:4.5", "1:2:3:4", "50:200:20000", "50:2000:4"]
    for text in [*(f"{numbers} N m" for numbers in wrong), "50:200:4", "::", "1:2:3"]:
        with refuses("--torque"):
            TORQUE.check_list(text, "--torque")


@pytest.mark.parametrize("name", UNITS)
def test_units_of_output_convert_as_by_pint(name: str) -> None:
    unit, _, _ = UNITS[name]
    registry = _registry()
    for value in (0.1, -1.7, 12.34567890123, 2.3e-7, 8.9e8):
        expected = registry.Quantity(value, registry.Unit(name)).to(registry.Unit(unit)).magnitude
        assert parse_quantity(f"{value!r} {name}", unit) == pytest.approx(expected, rel=1e-15)


def test_values_in_display_units() -> None:
    for name in ("pressure_hertz", "temperature_oil", "speed", "efficiency"):
        for value in (1e-12, 3.7, 1e12):
            assert quantity(name).to_si(to_display(name, value)) == pytest.approx(value, rel=1e-12, abs=1e-10)
    assert to_display("temperature_oil", KELVIN + 80.0) == pytest.approx(80.0)
    assert to_display("peak_to_peak", np.array([ARCSEC, 2 * ARCSEC])) == pytest.approx([1.0, 2.0])
    assert axis_label("temperature_oil") == "oil temperature [°C]"
    assert quantity("viscosity_inlet").text(0.04) == "40 mPa s"
    assert quantity("pressure_hertz").span(5e8, 1.25e9) == "0.5 to 1.25 GPa"
    given = ((123456.7, 3), (0.099996, 4), (9.9999, 3), (0.0, 4), (math.inf, 4))
    assert [format_number(*number) for number in given] == ["123457", "0.1000", "10.0", "0", "–"]


@given(st.floats(-1e15, 1e15), st.integers(2, 9))
def test_numbers_keep_their_significant_digits(value: float, digits: int) -> None:
    text = format_number(value, digits)
    assert float(text) == pytest.approx(value, rel=0.6 * 10.0 ** (1 - digits))
    if 1.0 <= abs(value) < 1e8:
        assert text.partition(".")[0].lstrip("-") in (str(int(abs(value))), str(round(abs(value))))
