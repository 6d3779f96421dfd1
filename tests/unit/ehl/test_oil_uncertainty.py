import math
from dataclasses import replace

import numpy as np
import pytest
from refusals import refuses

from ehl.common.data import data_path
from ehl.common.validation import read_toml, validate
from ehl.fluid.lookup import law_table
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from regression.friction.oil_cards import card_hash

PRESSURE = np.array([0.0, 0.2e9, 0.8e9, 1.6e9])
LAWS = {
    "barus": Lubricant(0.02, 18e-9, viscosity_law="barus"),
    "roelands": Lubricant(0.02, 18e-9, viscosity_law="roelands"),
    "modulus": Oil.load("fva3").at(353.15),
}


@pytest.mark.parametrize("law", LAWS)
def test_the_factor_multiplies_the_rise_with_pressure_and_leaves_ambient_viscosity(law: str) -> None:
    plain, thick = LAWS[law], replace(LAWS[law], pressure_rise_factor=1.2)
    warm = np.full(4, 373.15)
    ambient = plain.log_viscosity(np.zeros(4), warm)
    rise = plain.log_viscosity(PRESSURE, warm) - ambient
    np.testing.assert_allclose(thick.log_viscosity(PRESSURE, warm), ambient + 1.2 * rise, rtol=1e-12)
    np.testing.assert_allclose(thick.log_viscosity_ratio(PRESSURE), 1.2 * plain.log_viscosity_ratio(PRESSURE))
    assert thick.pressure_law.by_pressure(np.zeros(1))[0] == pytest.approx(thick.alpha, rel=1e-12)
    up, down = (thick.log_viscosity(PRESSURE, warm + s) for s in (0.01, -0.01))
    np.testing.assert_allclose(thick.dlog_viscosity_dtemperature(PRESSURE, warm), (up - down) / 0.02, rtol=1e-6)


def test_the_solvers_table_has_the_factor() -> None:
    plain, thick = (law_table(replace(LAWS["modulus"], pressure_rise_factor=f), 1e9, True) for f in (1.0, 1.2))
    np.testing.assert_allclose(thick.row[:, 0], 1.2 * plain.row[:, 0], rtol=1e-12)
    assert not np.allclose(thick.sheet, plain.sheet)


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


def test_varied_twice_adds_up_and_keeps_the_card_of_a_formula() -> None:
    card = Oil.load("fva3")
    twice = card.varied(viscosity=1.0).varied(viscosity=1.0, eyring_stress=0.5)
    assert twice.factors == card.varied(viscosity=2.0, eyring_stress=0.5).factors
    assert card_hash(twice) == card_hash(card)
    assert card.varied() == card


def test_a_rising_eyring_stress_is_varied_too() -> None:
    card = Oil.load("75w90")
    plain, high = (oil.eyring_stress_pressure for oil in (card, card.varied(eyring_stress=1.0)))
    assert plain is not None
    assert high is not None
    ratio = high(np.array([0.2e9, 1e9, 3e9])) / plain(np.array([0.2e9, 1e9, 3e9]))
    np.testing.assert_allclose(ratio, math.exp(card.uncertainty.eyring_stress), rtol=1e-12)


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
