"""Shear laws in the input file: what each asks for, and what it makes of the lubricant."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refuses
from samples import CONTACT, contact_case
from samples import PLAIN_OIL as NUMBERS

from ehl.common.validation import validate
from ehl.contact import Contact
from ehl.fluid.lubricant import ASSUMED_CONDUCTIVITY, PAO, PARAFFINIC, FilmConductivity
from ehl.fluid.lubricant_inputs import DirectLubricant
from ehl.fluid.oil import Oil
from ehl.fluid.rheology import RisingStress

PLAIN = {"viscosity_inlet": "10 mPa s", "pressure_viscosity": "15 1/GPa", "alpha_definition": "slope"}
CARD = {"oil": "fva3", "temperature_oil": "100 degC"}
TABLE = {"stress_low": "5 MPa", "stress_slope": 0.035, "pressure_start": "0.5 GPa", "pressure_end": "3.5 GPa"}
RISING = {"eyring_stress_law": "pressure", "eyring_stress_pressure": TABLE}
LOW_END = TABLE | {"pressure_end": "0.1 GPa"}
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
    limited = case(base | SMOOTH | {"limiting_shear_coefficient": 0.06}).lubricant.lubricant()
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
        (NUMBERS | {"eyring_stress_pressure": LOW_END}, "eyring_stress_pressure.pressure_end"),
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
