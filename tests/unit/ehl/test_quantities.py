"""The table of quantities: units that fit, round trips, numbers as a reader sees them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ehl.common.quantities import axis_label, format_number, quantities, quantity, si_unit, to_display
from ehl.common.units import ARCSEC, KELVIN, UNITS, parse_quantity


def test_entries_are_complete_and_their_display_unit_belongs_to_their_unit() -> None:
    for entry in quantities().values():
        assert entry.label, entry.name
        assert entry.definition, entry.name
        if entry.unit:
            assert parse_quantity(f"1 {entry.unit}", entry.unit) == 1.0
        if entry.display != entry.unit:
            assert UNITS[entry.display][0] == entry.unit, entry.name


@given(st.floats(1e-12, 1e12))
def test_display_units_round_trip(value: float) -> None:
    for name in ("pressure_hertz", "film_central", "temperature_oil", "speed", "peak_to_peak", "efficiency"):
        entry = quantity(name)
        assert entry.to_si(entry.to_display(value)) == pytest.approx(value, rel=1e-12, abs=1e-10)


def test_values_in_display_units() -> None:
    assert to_display("temperature_oil", KELVIN + 80.0) == pytest.approx(80.0)
    assert to_display("peak_to_peak", np.array([ARCSEC, 2 * ARCSEC])) == pytest.approx([1.0, 2.0])
    assert to_display("speed", np.pi) == pytest.approx(30.0)
    assert axis_label("film_central") == "central film thickness [nm]"
    assert axis_label("temperature_oil") == "oil temperature [°C]"
    assert si_unit("viscosity_inlet") == "Pa*s"
    assert quantity("viscosity_inlet").text(0.04) == "40 mPa s"
    assert quantity("pressure_hertz").span(5e8, 1.25e9) == "0.5 to 1.25 GPa"


@given(st.floats(-1e15, 1e15), st.integers(2, 9))
def test_numbers_keep_their_significant_digits(value: float, digits: int) -> None:
    text = format_number(value, digits)
    assert float(text) == pytest.approx(value, rel=0.6 * 10.0 ** (1 - digits))
    if 1.0 <= abs(value) < 1e8:
        assert text.partition(".")[0].lstrip("-") in (str(int(abs(value))), str(round(abs(value))))


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [(123456.7, 3, "123457"), (0.099996, 4, "0.1000"), (9.9999, 3, "10.0"), (0.0, 4, "0"), (float("inf"), 4, "–")],
)
def test_numbers_as_text(value: float, digits: int, text: str) -> None:
    assert format_number(value, digits) == text
