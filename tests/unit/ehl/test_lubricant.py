import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from refusals import refuses

from ehl.common.data import data_names, data_path
from ehl.common.units import KELVIN
from ehl.common.validation import read_toml, validate
from ehl.fluid.lookup import law_table
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from ehl.fluid.rheology import stress_at
from regression.friction.oil_cards import card_hash

LAWS = {
    "barus": Lubricant(0.02, 18e-9, viscosity_law="barus"),
    "roelands": Lubricant(0.02, 18e-9, viscosity_law="roelands"),
    "modulus": Oil.load("fva3").at(353.15),
}
PRESSURE = np.linspace(0.0, 2e9, 41)


@pytest.mark.parametrize("law", LAWS)
def test_temperature_form_reduces_to_the_inlet_temperature(law: str) -> None:
    lubricant = LAWS[law]
    at_inlet = lubricant.log_viscosity(PRESSURE, np.full_like(PRESSURE, lubricant.temperature))
    np.testing.assert_allclose(at_inlet, np.log(lubricant.viscosity(PRESSURE)), rtol=1e-12)
    warmer = lubricant.log_viscosity(PRESSURE, np.full_like(PRESSURE, lubricant.temperature + 20.0))
    assert np.all(warmer < at_inlet)


def test_75w90_lies_between_its_lower_and_upper_case() -> None:
    """FVA 400 constants (bar, degC) of HC + PMA1 with the published 9.68 1/GPa as secant, and of PAO/E + add. + PMA1.

    Both within one and a half of the card's standard deviations, from 40 to 150 degC.
    """
    lower, upper = (411.5, 4.797, 36.10e-3, 0.4055e-4), (361.6, 3.544, 55.47e-3, -0.6858e-4)

    def rise(constants: tuple[float, ...], bar: float, celsius: float) -> float:
        a1, a2, b1, b2 = constants
        return bar / (a1 + a2 * celsius + (b1 + b2 * celsius) * bar)

    card = Oil.load("75w90")
    at_100 = card.at(373.15)
    assert (at_100.viscosity_inlet, at_100.density) == pytest.approx((0.0106, 799.3), rel=2e-3)
    secant = rise(lower, 2000.0, 100.0) / 0.2
    for celsius in (40.0, 70.0, 100.0, 130.0, 150.0):
        for bar in (2000.0, 4000.0, 8000.0, 12000.0):
            middle = float(card.at(celsius + KELVIN).log_viscosity_ratio(np.array(bar * 1e5)))
            low, high = 9.68 / secant * rise(lower, bar, celsius), rise(upper, bar, celsius)
            assert 2.0 / middle == pytest.approx(1.0 / low + 1.0 / high, rel=1e-3)
            assert np.abs(np.log([low, high]) - math.log(middle)).max() < 1.5 * card.uncertainty.pressure_viscosity


@pytest.mark.parametrize("name", data_names("oils"))
def test_every_card_thins_with_temperature_and_states_its_uncertainty(name: str) -> None:
    oil = Oil.load(name)
    known = oil.uncertainty
    assert 0.03 <= known.pressure_viscosity <= 0.3
    others = ("viscosity", "eyring_stress", "limiting_shear", "thermal_conductivity")
    assert all(0.0 < getattr(known, key) <= 0.5 for key in others)
    assert known.source
    values = [oil.at(KELVIN + celsius) for celsius in (40.0, 60.0, 80.0, 100.0, 120.0)]
    for figure in ("viscosity_inlet", "pressure_viscosity"):
        assert np.all(np.diff([getattr(lubricant, figure) for lubricant in values]) < 0.0)
    stress = [stress_at(lubricant.eyring_stress, np.array([0.0, 1e9])) for lubricant in values]
    assert np.all((np.array(stress) > 4e6) & (np.array(stress) < 2.1e7))
    assert np.all(np.diff(stress, axis=0) > 0.0)
    assert np.all(np.diff(stress, axis=1) > 0.0)
    assert not oil.at(float(np.mean(oil.temperature_valid))).extrapolated
    assert oil.at(KELVIN - 30.0).extrapolated
    step = 0.03
    for temperature in (-40.0, 0.0, 40.0, 80.0, 130.0, 200.0):
        log_eta = [math.log(oil.viscosity_dynamic(temperature + KELVIN + i * step)) for i in (-2, -1, 1, 2)]
        # five points: wrong by the fourth power of the step
        slope = (log_eta[0] - 8.0 * log_eta[1] + 8.0 * log_eta[2] - log_eta[3]) / (12.0 * step)
        assert oil.temperature_viscosity(temperature + KELVIN) == pytest.approx(-slope, rel=1e-10)


@given(ratio=st.floats(-30.0, 60.0))
def test_eyring_shear_in_logarithms_is_asinh(ratio: float) -> None:
    """tau = tau0 asinh(eta u_s/(tau0 h)), whatever the size of the argument."""
    lubricant = Lubricant(0.02, 1e-9, viscosity_law="barus", rheology="eyring", eyring_stress=5e6)
    film = 0.02 / (5e6 * math.exp(ratio))
    expected = 5e6 * math.asinh(math.exp(ratio))
    assert lubricant.shear_stress(np.zeros(1), np.array([film]), 1.0)[0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("law", LAWS)
def test_the_factor_multiplies_the_rise_with_pressure(law: str) -> None:
    plain, thick = LAWS[law], replace(LAWS[law], pressure_rise_factor=1.2)
    warm = np.full_like(PRESSURE, 373.15)
    np.testing.assert_allclose(thick.log_viscosity_ratio(PRESSURE), 1.2 * plain.log_viscosity_ratio(PRESSURE))
    np.testing.assert_allclose(thick.log_viscosity(np.zeros(1), warm[:1]), plain.log_viscosity(np.zeros(1), warm[:1]))
    assert thick.pressure_law.by_pressure(np.zeros(1))[0] == pytest.approx(thick.alpha, rel=1e-12)
    up, down = (thick.log_viscosity(PRESSURE, warm + s) for s in (0.01, -0.01))
    np.testing.assert_allclose(thick.dlog_viscosity_dtemperature(PRESSURE, warm), (up - down) / 0.02, rtol=1e-6)
    if law == "modulus":
        tables = [law_table(oil, 1e9, True) for oil in (plain, thick)]
        np.testing.assert_allclose(tables[1].row[:, 0], 1.2 * tables[0].row[:, 0], rtol=1e-12)
        assert not np.allclose(tables[1].sheet, tables[0].sheet)


@pytest.mark.parametrize("steps", [-1.0, 2.0])
def test_varied_shifts_each_input_by_its_standard_deviation(steps: float) -> None:
    card = Oil.load("75w90")
    known = card.uncertainty
    plain = card.at(363.15)
    shifted = {
        "viscosity": lambda oil: oil.viscosity_inlet,
        "eyring_stress": lambda oil: oil.eyring_stress(1e9),
        "limiting_shear": lambda oil: oil.limiting_shear_coefficient,
        "thermal_conductivity": lambda oil: oil.thermal_conductivity,
    }
    for name, read in shifted.items():
        found = card.varied(**{name: steps}).at(363.15)
        assert read(found) / read(plain) == pytest.approx(math.exp(steps * getattr(known, name)), rel=1e-12)
        for other in shifted.keys() - {name}:
            assert shifted[other](found) == pytest.approx(shifted[other](plain), rel=1e-12)
    thick = card.varied(pressure_viscosity=steps).at(363.15)
    ratio = thick.log_viscosity_ratio(PRESSURE[1:]) / plain.log_viscosity_ratio(PRESSURE[1:])
    np.testing.assert_allclose(ratio, math.exp(steps * known.pressure_viscosity), rtol=1e-12)
    own, rising = (oil.eyring_stress_pressure(PRESSURE) for oil in (card, card.varied(eyring_stress=steps)))
    np.testing.assert_allclose(rising / own, math.exp(steps * known.eyring_stress), rtol=1e-12)


def test_varied_twice_adds_up_and_keeps_the_card_of_a_formula() -> None:
    card = Oil.load("fva3")
    twice = card.varied(viscosity=1.0).varied(viscosity=1.0, eyring_stress=0.5)
    assert twice.factors == card.varied(viscosity=2.0, eyring_stress=0.5).factors
    assert card_hash(twice) == card_hash(card)
    assert card.varied() == card


def test_a_card_states_its_own_uncertainty_and_the_rest_is_assumed() -> None:
    content = read_toml(data_path("oils", "fva3.toml"))
    content.pop("uncertainty", None)
    assumed = validate(Oil, content)
    own = validate(Oil, content | {"uncertainty": {"viscosity": 0.02}})
    assert own.uncertainty.viscosity == 0.02
    assert own.uncertainty.pressure_viscosity == assumed.uncertainty.pressure_viscosity
    assert card_hash(own) == card_hash(assumed)
    with refuses("uncertainty.viscosity"):
        validate(Oil, content | {"uncertainty": {"viscosity": 2.0}})
    with refuses("alpha"):
        Oil.load("fva3").varied(alpha=1.0)
    with refuses("temperature_oil"):
        Oil.load("fva3").at(80.0)
