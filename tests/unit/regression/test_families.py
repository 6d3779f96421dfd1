"""Limits of every family of formulas, over and beyond the range of gears."""

from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ehl.fluid.oil import Oil
from ehl.state import ContactState
from regression.fitting.coefficients import fit_coefficients, parts_of
from regression.friction.conditions import conditions_of
from regression.friction.families import FAMILIES, SHORT, short_parts
from regression.friction.families.linear import KNOTS, hats
from regression.friction.families.short import film_friction, heated_film
from regression.friction.published import XU_COEFFICIENTS

OILS = {name: Oil.load(name) for name in ("75w90", "fva3")}
START = dict(zip(SHORT.terms, SHORT.start, strict=True))
COEFFICIENTS: dict[str, dict[str, float]] = {
    "short": START,
    "xu": dict(zip(FAMILIES["xu"].terms, XU_COEFFICIENTS, strict=True)),
    "power_law": dict(zip(FAMILIES["power_law"].terms, (-5.0, 0.3, 0.1, -0.2, 0.4, 0.3, 0.3), strict=True)),
    "regimes": {term: 0.1 + 0.02 * i for i, term in enumerate(FAMILIES["regimes"].terms)},
}
MU_B = 0.1
PLAIN = {"pressure_hertz": 1e9, "radius_equivalent": 0.01, "speed_entrainment": 1.0}

# the box of the plan gear, and beyond
BOX = {
    "pressure_hertz": (0.3e9, 2.5e9), "radius_equivalent": (0.005, 0.08), "speed_entrainment": (0.5, 20.0),
    "slide_to_roll": (0.01, 1.5), "temperature_oil": (298.15, 403.15), "roughness_rms_1": (0.05e-6, 0.6e-6),
    "correlation_length": (20e-6, 100e-6),
}  # fmt: skip
BEYOND = st.fixed_dictionaries(
    {name: st.floats(0.4 * low, 1.4 * high) for name, (low, high) in BOX.items() if name != "temperature_oil"}
    | {"temperature_oil": st.floats(283.15, 423.15), "speed_sliding_lengthwise": st.floats(0.0, 30.0)}
)
OIL = st.sampled_from(sorted(OILS))


def table(point: dict[str, float], oil: str, **changes: Any) -> dict[str, np.ndarray]:
    values = {"effective_modulus": 226e9, "roughness_rms_2": 0.2e-6, **point, **changes}
    return conditions_of(ContactState.of(**values), OILS[oil])


def friction(family: str, conditions: dict[str, np.ndarray], boundary: float = MU_B) -> np.ndarray:
    with np.errstate(over="ignore"):
        return np.exp(FAMILIES[family].log_mu(conditions, COEFFICIENTS[family], boundary))


@settings(max_examples=60, deadline=None)
@given(point=BEYOND, oil=OIL, family=st.sampled_from(sorted(FAMILIES)))
def test_friction_is_even_in_both_slidings(point: dict[str, float], oil: str, family: str) -> None:
    across, along = point["slide_to_roll"], point["speed_sliding_lengthwise"]
    signs = np.array([[1, -1, 1, -1], [1, 1, -1, -1]])
    mu = friction(family, table(point, oil, slide_to_roll=signs[0] * across, speed_sliding_lengthwise=signs[1] * along))
    assert (mu > 0.0).all()
    np.testing.assert_array_equal(mu, mu[0])


@settings(max_examples=80, deadline=None)
@given(point=BEYOND, oil=OIL, boundary=st.floats(0.03, 0.2))
def test_friction_is_bounded_and_shares_are_shares(point: dict[str, float], oil: str, boundary: float) -> None:
    conditions = table(point, oil)
    share, fluid = short_parts(conditions, START)
    limit = float(conditions["limiting_shear_coefficient"])
    assert 0.0 <= share <= 1.0
    # the spread of a thick film widens the contact, where its stress is far below the limit
    assert 0.0 < fluid <= limit * (1.0 + 1e-9)
    assert friction("short", conditions, boundary) <= max(boundary, limit) * (1.0 + 1e-9)


@settings(max_examples=60, deadline=None)
@given(point=BEYOND, oil=OIL)
def test_boundary_friction_is_the_limit_of_vanishing_films(point: dict[str, float], oil: str) -> None:
    conditions = table(point, oil)
    thin = conditions | {name: 1e-6 * conditions[name] for name in ("film_formula", "film_ratio_formula")}
    # sliding as slow as the film is thin
    thin |= {"speed_sliding": 1e-6 * conditions["speed_sliding"]}
    assert friction("short", thin) == pytest.approx(MU_B, rel=0.02)


@settings(max_examples=60, deadline=None)
@given(point=BEYOND, oil=OIL)
def test_full_film_friction_vanishes_with_the_sliding(point: dict[str, float], oil: str) -> None:
    slide = np.array([1e-3, 1e-9, 1e-200, 0.0])
    smooth = {**point, "roughness_rms_1": 0.0, "roughness_rms_2": 0.0}
    conditions = table(smooth, oil, slide_to_roll=slide, speed_sliding_lengthwise=0.0)
    fluid = short_parts(conditions, START)[1]
    assert (np.diff(fluid) < 0.0).all()
    assert fluid[3] == 0.0
    # at 2.5 GPa and 25 degC the viscosity of FVA3 exceeds 1e20 Pa s: proportional only at very little sliding
    assert fluid[2] < 1e-20


@settings(max_examples=60, deadline=None)
@given(point=BEYOND, oil=OIL, family=st.sampled_from(["regimes", "short"]))
def test_friction_is_continuous_across_the_regimes(point: dict[str, float], oil: str, family: str) -> None:
    speed = point["speed_entrainment"] * np.geomspace(1e-2, 1e2, 8001)
    slide = point["slide_to_roll"]
    conditions = table({**point, "speed_sliding_lengthwise": 0.0}, oil, speed_entrainment=speed, slide_to_roll=slide)
    log_mu = FAMILIES[family].log_mu(conditions, COEFFICIENTS[family], MU_B)
    assert np.isfinite(log_mu).all()
    # speed changes by 0.12 % from point to point; flat roughness lets go of the film with its 10th to 20th power
    assert np.abs(np.diff(log_mu)).max() < 0.04
    if family != "regimes":  # no bends either
        assert np.abs(np.diff(log_mu, 2)).max() < 2e-3


def test_regimes_add_up_and_stand_at_their_knots() -> None:
    shares = np.array(hats(np.geomspace(1e-3, 1e3, 400)))
    np.testing.assert_allclose(shares.sum(axis=0), 1.0, rtol=1e-12)
    assert ((shares >= 0.0) & (shares <= 1.0)).all()
    np.testing.assert_allclose(np.array(hats(np.array(KNOTS))), np.eye(len(KNOTS)), atol=1e-12)


def test_film_friction_of_a_newtonian_oil_of_constant_viscosity() -> None:
    # no heat, low stress, viscosity that does not rise: mu = eta v_s/(h p_mean)
    conditions = table(PLAIN, "fva3", slide_to_roll=1e-6)
    viscosity = conditions["viscosity_inlet"]
    conditions |= {"viscosity_mean_pressure": viscosity, "temperature_viscosity": 0.0 * viscosity}
    k = dict.fromkeys(SHORT.terms, 0.0) | {"strain": 1.0}
    film = heated_film(conditions, k)
    np.testing.assert_allclose(film, conditions["film_formula"], rtol=1e-12)
    expected = conditions["viscosity_inlet"] * conditions["speed_sliding"] / (film * 0.25e9 * np.pi)
    np.testing.assert_allclose(film_friction(conditions, k, film), expected, rtol=1e-5)


def test_film_friction_reaches_the_limiting_shear_stress() -> None:
    conditions, k = table(PLAIN, "fva3", slide_to_roll=1.0), START | {"relief_thick": 0.0}
    factors = {"temperature_viscosity": 0.0, "eyring_stress": 1e6, "viscosity_inlet": 1e6}  # no heat
    conditions |= {name: factor * conditions[name] for name, factor in factors.items()}
    fluid = film_friction(conditions, k, heated_film(conditions, k))
    assert fluid == pytest.approx(OILS["fva3"].limiting_stress[1], rel=2e-4)


def rows(oils: tuple[str, ...], count: int, seed: int) -> pd.DataFrame:
    """Points in the box of the plan whose friction is that of `short` with its start values."""
    random = np.random.default_rng(seed)
    parts = []
    for oil in oils:
        share = random.random((count, len(BOX)))
        point = {n: low * (high / low) ** share[:, k] for k, (n, (low, high)) in enumerate(BOX.items())}
        conditions = table(point, oil, roughness_rms_2=0.0)
        parts.append(pd.DataFrame(conditions).assign(friction_coefficient=friction("short", conditions)))
    return pd.concat(parts, ignore_index=True).assign(friction_error=0.0, boundary_friction=MU_B)


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_fit_finds_the_coefficients_behind_the_friction_within_their_errors(noise: float) -> None:
    truth = {term: 1.2 * value for term, value in START.items()}
    table_of = rows(("75w90", "fva3"), 200, 1)
    log_mu = SHORT.log_mu({name: table_of[name].to_numpy() for name in table_of}, truth, MU_B)
    log_mu += noise * np.random.default_rng(3).standard_normal(len(table_of))
    fitted = fit_coefficients(SHORT, table_of.assign(friction_coefficient=np.exp(log_mu)), MU_B)
    assert not fitted.dropped
    if noise == 0.0:
        assert fitted.values == pytest.approx(truth, rel=1e-5)
        return
    # 15 values: none beyond 3.5 standard errors, RMS near one
    distance = [abs(fitted.values[term] - truth[term]) / fitted.standard_errors[term] for term in SHORT.terms]
    assert max(distance) < 3.5
    assert 0.3 < np.sqrt(np.mean(np.square(distance))) < 1.8


def test_fit_meets_both_parts_of_the_friction() -> None:
    table_of = rows(("75w90",), 200, 4)
    conditions = {name: table_of[name].to_numpy() for name in table_of}
    share, film = short_parts(conditions, START)
    known = table_of.assign(asperity_load_share=share, friction_fluid=film)
    # as if a fifth of what the asperities carry were film
    hidden = known.assign(asperity_load_share=0.8 * share, friction_fluid=film + 0.2 * share * MU_B)

    def carried(frame: pd.DataFrame) -> float:
        k = fit_coefficients(SHORT, frame, MU_B).values
        return float(short_parts(conditions, k)[0].sum() / share.sum())

    assert carried(known) == pytest.approx(1.0, abs=1e-3)
    # mu alone would say 1 again
    assert carried(hidden) < 0.98
    assert carried(table_of) == pytest.approx(1.0, abs=1e-3)
    assert parts_of(SHORT, table_of) is None
    assert parts_of(FAMILIES["power_law"], known) is None
