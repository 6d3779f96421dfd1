"""The fitted formulas that come with the program: they belong to today's oil cards and say what they said."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ehl.fluid.oil import Oil
from ehl.state import ContactState
from regression.formula import Formula, friction_model, shipped_formulas
from regression.friction.conditions import conditions_of
from regression.friction.families import SHORT, short_parts
from regression.friction.models import FrictionFlag
from regression.sweeping.sweep import oil_hash


def shipped(name: str) -> Formula:
    model = friction_model(name)
    assert isinstance(model, Formula)
    assert model.name == name
    return model


@pytest.mark.parametrize("name", shipped_formulas())
def test_formula_belongs_to_the_oil_card(name: str) -> None:
    formula = shipped(name)
    (oil,) = formula.oils
    assert oil.name is not None
    assert oil.card_hash == oil_hash(oil.name), "the card changed: sweep and fit again"
    assert formula.data.plan.startswith("gear")
    assert formula.data.used >= 700
    # what docs/friction_formula.md says of it
    mape, p95 = (0.115, 0.36) if name.endswith("_short") else (0.065, 0.20)
    assert formula.validation.mape < mape
    assert formula.validation.p95 < p95


# pressure [Pa], radius [m], entrainment speed [m/s], SR, temperature [K], roughness [m]
POINTS = np.array(
    [
        [0.9e9, 0.015, 6.0, 0.20, 343.15, 0.3e-6],
        [1.2e9, 0.020, 3.0, 0.30, 363.15, 0.5e-6],
        [1.6e9, 0.030, 2.0, 0.60, 373.15, 0.5e-6],
    ]
)


def test_values_are_those_of_the_release() -> None:
    p, r, u, sr, t, rq = POINTS.T
    state = ContactState.of(
        pressure_hertz=p,
        radius_equivalent=r,
        effective_modulus=226.37e9,
        speed_entrainment=u,
        slide_to_roll=sr,
        temperature_oil=t,
        roughness_rms_1=rq / np.sqrt(2.0),
        roughness_rms_2=rq / np.sqrt(2.0),
    )
    found = {}
    for name in shipped_formulas():
        formula = shipped(name)
        estimate = formula.mu(state)
        assert (estimate.flag == FrictionFlag.OK).all()
        found[name] = estimate.mu
    assert set(found) == set(EXPECTED)
    for name, values in EXPECTED.items():
        # printed to six decimals
        np.testing.assert_allclose(found[name], values, rtol=0.0, atol=0.6e-6)


EXPECTED: dict[str, list[float]] = {
    "75w90": [0.026859, 0.065947, 0.063740],
    "75w90_gp": [0.030631, 0.051168, 0.046087],
    "75w90_short": [0.027564, 0.065537, 0.061496],
    "fva3": [0.041020, 0.065707, 0.058078],
    "fva3_gp": [0.044148, 0.053232, 0.042445],
    "fva3_short": [0.042022, 0.061412, 0.052627],
}


@pytest.mark.parametrize("name", ["75w90", "fva3"])
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
    dry = films(1e-60) | {"speed_sliding": 1e-6 * here["speed_sliding"]}
    with np.errstate(over="ignore"):
        share, film = short_parts(here, k)
        thicker, _ = short_parts(films(1.0 + 4.0 * unit[7]), k)
        boundary = np.exp(SHORT.log_mu(dry, k, 0.1))
    assert ((share >= 0.0) & (share <= 1.0) & (thicker <= share)).all()
    assert ((film > 0.0) & (film <= here["limiting_shear_coefficient"] * (1.0 + 1e-9))).all()
    np.testing.assert_allclose(boundary, 0.1, rtol=1e-5)
