"""Lubricants: laws, cards, their uncertainty, shear laws in the input file, and the command `oil`."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from refusals import refuses
from samples import CONTACT, contact_case
from samples import PLAIN_OIL as NUMBERS

import ehl
from ehl.common.data import data_names, data_path
from ehl.common.units import KELVIN
from ehl.common.validation import read_toml, validate
from ehl.contact import Contact
from ehl.fluid.lookup import law_table
from ehl.fluid.lubricant import ASSUMED_CONDUCTIVITY, PAO, PARAFFINIC, FilmConductivity, Lubricant
from ehl.fluid.lubricant_inputs import DirectLubricant
from ehl.fluid.oil import Oil
from ehl.fluid.oil_sheet import source_points
from ehl.fluid.rheology import RisingStress, stress_at
from regression.friction.oil_cards import card_hash

LAWS = {
    "barus": Lubricant(0.02, 18e-9, viscosity_law="barus"),
    "roelands": Lubricant(0.02, 18e-9, viscosity_law="roelands"),
    "modulus": Oil.load("fva3").at(353.15),
    # with the temperature slope of another law
    "modulus with beta": replace(Oil.load("fva3").at(353.15), temperature_constants=()),
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
    """FVA 400 constants (bar, degC) of HC + PMA1 with the published secant of 9.68 1/GPa, and of PAO/E + PMA1."""
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
    ambient = plain.log_viscosity(np.zeros(1), warm[:1])
    expected = ambient + 1.2 * (plain.log_viscosity(PRESSURE, warm) - ambient)
    np.testing.assert_allclose(thick.log_viscosity(PRESSURE, warm), expected, rtol=1e-12)
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


def test_points_of_every_source_are_met_by_the_card() -> None:
    """Points computed from the printed constants, not by the card: 1 % in eta at every pressure and temperature."""
    cards = {row.split(",")[0] for row in data_path("reference", "oil_points.csv").read_text().splitlines()[4:]}
    assert cards <= set(data_names("oils"))
    assert len(cards) > 20
    for card in cards:
        oil = ehl.Oil.load(card)
        for temperature, pressure, viscosity in source_points().get(card, []):
            found = float(oil.at(temperature).viscosity(np.array(pressure)))
            assert found == pytest.approx(viscosity, rel=0.01), (card, temperature - KELVIN, pressure)


@pytest.mark.parametrize("name", ["75w90", "squalane", "pao 97.5/13.3"])
def test_a_saved_card_is_the_same_oil(name: str, tmp_path: Path) -> None:
    oil = ehl.Oil.load(name)
    oil.save(tmp_path / "mine.toml")
    again = ehl.Oil.load(str(tmp_path / "mine.toml"))
    assert again == oil
    with refuses("path"):
        oil.save(tmp_path / "mine.txt")


def test_command_writes_a_generic_card(mixed_ehl: Any, tmp_path: Path) -> None:
    card = tmp_path / "my_oil.toml"
    assert mixed_ehl("oil", "--base", "ester", "--nu40", "97 cSt", "--nu100", "14 cSt", "-o", card).code == 0
    oil = ehl.Oil.load(str(card))
    assert oil.name == "my_oil"
    assert oil.at(363.15) == ehl.Oil.load("ester 97/14").at(363.15)


PLAIN = {"viscosity_inlet": "10 mPa s", "pressure_viscosity": "15 1/GPa", "alpha_definition": "slope"}
CARD = {"oil": "fva3", "temperature_oil": "100 degC"}
TABLE = {"stress_low": "5 MPa", "stress_slope": 0.035, "pressure_start": "0.5 GPa", "pressure_end": "3.5 GPa"}
RISING = {"eyring_stress_law": "pressure", "eyring_stress_pressure": TABLE}
CARREAU = {"rheology": "carreau", "carreau_stress": "4 MPa", "carreau_exponent": 0.5}
SMOOTH = {"limiting_shear": "smooth", "limiting_shear_ambient": "2 MPa"}


def case(lubricant: dict[str, Any]) -> Contact:
    return contact_case(lubricant=lubricant)


@pytest.mark.parametrize("base", [NUMBERS, CARD])
def test_laws_and_their_figures(base: dict[str, Any]) -> None:
    carreau = case(base | CARREAU).lubricant.lubricant()
    assert (carreau.rheology, carreau.shear_law.stress, carreau.shear_law.exponent) == ("carreau", 4e6, 0.5)
    rising = case(base | RISING).lubricant.lubricant()
    figures = {"stress_low": 5e6, "stress_slope": 0.035, "pressure_start": 0.5e9, "pressure_end": 3.5e9}
    assert rising.shear_law.stress == RisingStress(**figures)
    own = {"limiting_shear_coefficient": 0.06, "thermal_conductivity": 0.2}
    limited = case(base | SMOOTH | own).lubricant.lubricant()
    assert limited.thermal_conductivity == 0.2
    law = limited.shear_law
    assert (law.limit, law.limit_slope, law.limit_ambient, law.plain) == ("smooth", 0.06, 2e6, False)
    constant = case(base | {"eyring_stress": "6 MPa"}).lubricant.lubricant().shear_law
    assert (constant.plain, constant.stress) == (True, 6e6)
    assert constant.limited is (base is CARD)  # by the limiting stress of its base oil


def test_a_card_without_a_stress_of_its_own_follows_its_base_oil() -> None:
    law = case(CARD).lubricant.lubricant().shear_law
    # mineral oil: 4.08 MPa, 0.0322 MPa/K above 40 degC and 8.9 MPa/GPa
    assert law.scale(np.array([0.0, 1e9])) == pytest.approx([6.012e6, 14.88e6], rel=1e-3)
    assert law.limiting_stress(np.array([1e9]))[0] == pytest.approx(65e6)


def test_card_of_the_axle_oil_carries_its_published_law() -> None:
    axle = {"oil": "75w90", "temperature_oil": "100 degC"}
    own, rising = (case(axle | more).lubricant.lubricant() for more in ({}, {"eyring_stress_law": "pressure"}))
    # the law of its base oil, at 1 GPa between k T/V and the published law of the oil
    assert 8.3e6 < own.shear_law.scale(np.array([1e9]))[0] < 36e6
    assert isinstance(rising.eyring_stress, RisingStress)
    assert rising.shear_law.scale(np.array([2e9]))[0] == pytest.approx(60e6, rel=1e-6)
    own = case(axle | {"eyring_stress_law": "pressure", "eyring_stress_pressure": TABLE | {"stress_slope": 0.02}})
    assert own.lubricant.lubricant().shear_law.scale(np.array([2e9]))[0] == pytest.approx(37.5e6, rel=1e-6)


@pytest.mark.parametrize(
    ("lubricant", "field"),
    [
        (NUMBERS | {"rheology": "carreau"}, "carreau_stress"),
        (NUMBERS | CARREAU | {"carreau_exponent": None}, "carreau_exponent"),
        (NUMBERS | CARREAU | {"carreau_exponent": 0.05}, "carreau_exponent"),
        (NUMBERS | {"eyring_stress_law": "pressure"}, "eyring_stress_pressure"),
        (CARD | {"eyring_stress_law": "pressure"}, "eyring_stress_pressure"),
        (CARD | {"eyring_stress_law": "constant"}, "eyring_stress"),
        (NUMBERS | {"eyring_stress_pressure": TABLE | {"pressure_end": 1e8}}, "eyring_stress_pressure.pressure_end"),
        (NUMBERS | {"limiting_shear": "smooth", "limiting_shear_coefficient": 0.05}, "limiting_shear_ambient"),
        (NUMBERS | SMOOTH, "limiting_shear_coefficient"),
        (CARD | {"limiting_shear": "sharp"}, "limiting_shear"),
        (NUMBERS | {"conductivity_pressure": {"c1": "-1 1/GPa", "c2": 0.0}}, "conductivity_pressure.c1"),
        (NUMBERS | {"conductivity_pressure": "ester"}, "conductivity_pressure"),
    ],
)
def test_a_law_requires_its_figures(lubricant: dict[str, Any], field: str) -> None:
    with refuses(f"lubricant.{field}"):
        case(lubricant)


@pytest.mark.parametrize(
    ("lubricant", "names"),
    [
        (NUMBERS | CARREAU | {"eyring_stress": 5e6}, {"lubricant.eyring_stress"}),
        (NUMBERS | {"carreau_stress": 5e6}, {"lubricant.carreau_stress"}),
        (NUMBERS | {"eyring_stress_pressure": TABLE}, {"lubricant.eyring_stress_pressure"}),
        (NUMBERS | RISING | {"eyring_stress": 5e6}, {"lubricant.eyring_stress"}),
        (NUMBERS, set()),
    ],
)
def test_figures_without_effect_are_named(lubricant: dict[str, Any], names: set[str]) -> None:
    assert {text.partition(" ")[0] for text in case(lubricant).unused_inputs()} == names


@pytest.mark.parametrize(
    ("given", "law"),
    [
        ("mineral", PARAFFINIC),
        ({"c1": "1.72 1/GPa", "c2": "0.5 1/GPa"}, FilmConductivity(c1=1.72e-9, c2=0.5e-9)),
        ({"c1": 0.0, "c2": 0.0}, FilmConductivity(c1=0.0, c2=0.0)),
    ],
)
def test_conductivity_under_pressure(given: Any, law: FilmConductivity, tmp_path: Path) -> None:
    one = validate(DirectLubricant, PLAIN | {"conductivity_pressure": given})
    assert one.lubricant().film_conductivity == law
    assert validate(DirectLubricant, one.model_dump()) == one
    card = Oil.load("fva3")
    content = card.model_dump() | {"conductivity_pressure": given}
    changed = validate(Oil, content, "card")
    assert changed.at(353.15).film_conductivity == law
    changed.save(tmp_path / "card.toml")
    assert Oil.load(str(tmp_path / "card.toml")).conductivity_pressure == changed.conductivity_pressure


def test_conductivity_without_a_law_is_that_of_the_base_oil_or_assumed_and_said_so() -> None:
    for name, law in (("fva3", PARAFFINIC), ("75w90", PAO), ("estr", PAO), ("pagd", PAO)):
        card = Oil.load(name)
        assert card.at(353.15).film_conductivity == law
        assert (ASSUMED_CONDUCTIVITY in card.remarks()) == (name in ("estr", "pagd"))
    one = validate(DirectLubricant, PLAIN)
    assert one.lubricant().film_conductivity == PAO
    assert ASSUMED_CONDUCTIVITY in one.remarks()
    assert not validate(DirectLubricant, PLAIN | {"conductivity_pressure": "pao"}).remarks()


@pytest.mark.parametrize("name", ["75W90", "75w-90", "75W 90"])
def test_names_of_shipped_things_ignore_case(name: str) -> None:
    words = {"oil": name, "finish": "Ground", "additive": "ep", "solid_1": "STEEL", "accuracy": "Fast"}
    contact = Contact(**CONTACT, temperature_oil="80 C", **words)
    assert (contact.lubricant.oil, contact.surface.finish, contact.surface.additive) == ("75w90", "ground", "EP")
    assert (contact.solid_1.material, contact.model.accuracy) == ("steel", "fast")
