"""The fitted formulas that come with the program: they belong to today's oil cards and keep the limits of friction."""

from typing import Any

import numpy as np
import pytest

from ehl.fluid.oil import Oil
from ehl.state import ContactState
from regression.formula import ANY_OIL, Formula, friction_model, shipped_formulas
from regression.friction.conditions import conditions_of
from regression.friction.families import SHORT, short_parts
from regression.friction.oil_cards import card_hash

# mean and 95 % of the held-out errors of mu, each rounded up
HELD_OUT = {
    "75w90": (0.035, 0.12),
    "75w90_short": (0.105, 0.315),
    "80w90": (0.035, 0.105),
    "80w90_short": (0.1, 0.33),
    "eaxle": (0.04, 0.135),
    "eaxle_short": (0.115, 0.35),
    "fva3": (0.035, 0.11),
    "fva3_short": (0.105, 0.33),
    "gear": (0.04, 0.12),
    "pao220": (0.04, 0.115),
    "pao220_short": (0.105, 0.315),
    "pg_0_1": (0.04, 0.12),
    "pg_0_1_short": (0.115, 0.34),
}


def shipped(name: str) -> Formula:
    model = friction_model(name)
    assert model.name == name
    return model


@pytest.mark.parametrize("name", shipped_formulas())
def test_formula_belongs_to_the_oil_card(name: str) -> None:
    """And its held-out error is that measured at the fit, rounded up."""
    formula = shipped(name)
    for oil in formula.oils:
        assert oil.card_hash == card_hash(Oil.load(oil.name)), "the card changed: sweep and fit again"
    oils = {"75w90", "fva3", "eaxle", "80w90", "pao220", "pg_0_1"} if name == ANY_OIL else {name.removesuffix("_short")}
    assert {oil.name for oil in formula.oils} == oils
    assert (formula.interval.other_oil is not None) == (name == ANY_OIL)
    assert formula.data.plan.startswith("gear")
    assert formula.data.used >= 700
    mape, p95 = HELD_OUT[name]
    assert formula.validation.mape < mape
    assert formula.validation.p95 < p95


@pytest.mark.parametrize("name", [name for name in shipped_formulas() if name != ANY_OIL and "_short" not in name])
def test_limits_hold_for_the_shipped_coefficients(name: str) -> None:
    """Far beyond the range of gears, as the property tests of the families do with their start values."""
    k, oil, random = shipped(name).coefficients, Oil.load(name), np.random.default_rng(0)
    unit = random.random((8, 4000))
    state = ContactState.of(
        pressure_hertz=0.1e9 * 35.0 ** unit[0],
        radius_equivalent=0.003 * 50.0 ** unit[1],
        effective_modulus=226e9,
        speed_entrainment=0.2 * 200.0 ** unit[2],
        slide_to_roll=0.003 * 1000.0 ** unit[3],
        speed_sliding_lengthwise=30.0 * unit[4],
        temperature_oil=random.choice([285.0, 350.0, 420.0], 4000),
        roughness_rms_1=0.02e-6 * 75.0 ** unit[5],
        roughness_rms_2=0.2e-6,
        correlation_length=8e-6 * 37.0 ** unit[6],
    )
    here = conditions_of(state, oil)

    def films(factor: Any) -> dict[str, Any]:
        return here | {film: factor * here[film] for film in ("film_formula", "film_ratio_formula")}

    # the share of the asperities falls as a power of the film, with exponents from 0.1 on
    dry = films(1e-80) | {"speed_sliding": 1e-6 * here["speed_sliding"]}
    with np.errstate(over="ignore"):
        share, film = short_parts(here, k)
        thicker, _ = short_parts(films(1.0 + 4.0 * unit[7]), k)
        boundary = np.exp(SHORT.log_mu(dry, k, 0.1))
    assert ((share >= 0.0) & (share <= 1.0) & (thicker <= share)).all()
    assert ((film > 0.0) | (share == 1.0)).all()
    assert (film <= here["limiting_shear_coefficient"] * (1.0 + 1e-9)).all()
    np.testing.assert_allclose(boundary, 0.1, rtol=1e-5)
