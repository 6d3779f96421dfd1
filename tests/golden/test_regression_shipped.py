"""The fitted formulas that come with the program: they belong to today's oil cards and keep the limits of friction."""

from typing import Any

import numpy as np
import pytest

from ehl.fluid.oil import Oil
from ehl.state import ContactState
from regression.fitting.rows import dataset_of, usable_rows
from regression.formula import ANY_OIL, Formula, friction_model, shipped_formulas
from regression.friction.conditions import conditions_of
from regression.friction.families import SHORT, short_parts
from regression.friction.oil_cards import card_hash

# mean and 95 % of the held-out errors of mu, each rounded up
HELD_OUT = {
    "75w90": (0.04, 0.12),
    "75w90_short": (0.115, 0.34),
    "80w90": (0.035, 0.115),
    "80w90_short": (0.11, 0.36),
    "eaxle": (0.045, 0.16),
    "eaxle_short": (0.13, 0.395),
    "fva3": (0.035, 0.125),
    "fva3_short": (0.115, 0.375),
    "gear": (0.04, 0.13),
    "pao220": (0.035, 0.11),
    "pao220_short": (0.11, 0.355),
    "pg_0_1": (0.04, 0.13),
    "pg_0_1_short": (0.12, 0.37),
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


def test_standard_errors_of_a_shipped_formula_follow_from_its_data() -> None:
    """M-estimator of soft_l1 with the contacts as clusters: H^-1 (sum of s s^T) H^-1 n/(n - p), s = J^T psi.

    psi = r (1 + z)^-1/2 and H = J^T diag((1 + z)^-3/2) J with z = (r/0.05)^2, derivatives by central differences.
    Residuals: ln mu, and a quarter of those of both parts over mu.
    """
    formula = shipped("75w90_short")
    data = dataset_of([f"gear_75w90{kind}" for kind in ("", "_mesh", "_film", "_fast", "_hot")])
    frame, _ = usable_rows(data, corners=False)
    table = {name: frame[name].to_numpy() for name in frame}
    mu, boundary, terms = table["friction_coefficient"], formula.boundary_friction, SHORT.terms

    def residuals(values: np.ndarray) -> np.ndarray:
        share, film = short_parts(table, dict(zip(terms, values, strict=True)))
        parts = (share - table["asperity_load_share"]) * boundary, film - table["friction_fluid"]
        return np.stack([np.log((share * boundary + film) / mu), *(0.25 * part / mu for part in parts)])

    best = np.array([formula.coefficients[term] for term in terms])
    steps = np.diag(1e-5 * np.maximum(np.abs(best), 0.05))
    slopes = np.stack([(residuals(best + h) - residuals(best - h)) / (2.0 * h.sum()) for h in steps], axis=-1)
    r = residuals(best)
    z = (r / 0.05) ** 2
    scores = np.einsum("ij,ijk->jk", r / np.sqrt(1.0 + z), slopes)
    inverse = np.linalg.inv(np.einsum("ij,ijk,ijl->kl", (1.0 + z) ** -1.5, slopes, slopes))
    variance = np.diag(inverse @ scores.T @ scores @ inverse) * len(mu) / (len(mu) - len(terms))
    assert formula.standard_errors == pytest.approx(dict(zip(terms, np.sqrt(variance), strict=True)), rel=0.01)
