"""Friction models and families of formulas: names, flags, limits, fits; local conditions worked out by hand."""

import math
from typing import Any

import numpy as np
import pandas as pd
import pytest
from contacts import gear_state as state
from hypothesis import given
from hypothesis import strategies as st
from refusals import refuses
from samples import AXLE_OIL

from ehl.common.errors import InputError
from ehl.fluid.oil import Oil
from ehl.line_contact import LineContact, moes_1992
from ehl.state import ContactState
from regression.fitting.coefficients import fit_coefficients, parts_of
from regression.formula import friction_model
from regression.friction.conditions import conditions_of, contact_points
from regression.friction.families import FAMILIES, SHORT, short_parts
from regression.friction.families.linear import KNOTS, hats
from regression.friction.families.short import film_friction, heated_film
from regression.friction.models import FrictionFlag, FrictionModel
from regression.friction.published import XU_COEFFICIENTS
from regression.friction.published_registry import PUBLISHED, SLIDING_FLOOR

OIL = Oil.load("fva3")


@pytest.mark.parametrize("name", [*sorted(PUBLISHED), "coleman"])
def test_published_are_plausible_and_keep_the_shape(name: str) -> None:
    model = friction_model(name)
    assert isinstance(model, FrictionModel)
    estimate = model.mu(state(speed_entrainment=np.array([[2.0, 5.0, 9.0]])), oil=OIL)
    assert estimate.mu.shape == (1, 3)
    assert ((estimate.mu > 0.005) & (estimate.mu < 0.15)).all()
    assert np.isnan(estimate.lower).all() or name == "coleman"
    # pitch point, unloaded end of a line, smooth flanks, both bodies rough: a number, or a flag where unloaded
    rough = 3e-7 * np.array([1.0, 1.0, 0.0, 1.0])
    slides, pressures = np.array([0.0, 0.3, 0.3, -0.3]), 1e9 * np.array([1.0, 0.0, 1.0, 1.0])
    points = state(slide_to_roll=slides, pressure_hertz=pressures, roughness_rms_1=rough, roughness_rms_2=rough)
    estimate = model.mu(points, oil=OIL)
    defined = estimate.flag != FrictionFlag.UNDEFINED
    assert defined[[0, 2, 3]].all()
    assert np.isfinite(estimate.mu[defined]).all()
    assert (estimate.mu[defined] >= 0.0).all()


@given(ratio=st.floats(0.01, 1.5), along=st.floats(0.0, 5.0), name=st.sampled_from(sorted(PUBLISHED)))
def test_friction_does_not_depend_on_the_sign_of_sliding(ratio: float, along: float, name: str) -> None:
    both = state(slide_to_roll=np.array([ratio, -ratio]), speed_sliding_lengthwise=np.array([along, -along]))
    mu = friction_model(name).mu(both, oil=OIL).mu
    assert mu[0] == mu[1]


def test_flags_of_range_and_of_undefined_values() -> None:
    xu = friction_model("xu_kahraman_2007").mu(state(pressure_hertz=np.array([1e9, 0.1e9])), oil=OIL)
    assert xu.flag.tolist() == [FrictionFlag.OK, FrictionFlag.OUTSIDE_RANGE]
    # pitch line velocities of 1, 10 and 30 m/s at a pressure angle of 20 deg; the report has 2 to 25 m/s
    slow = friction_model("iso_tr_14179_1").mu(state(speed_entrainment=np.array([0.342, 3.42, 10.3])), oil=OIL)
    assert slow.flag.tolist() == [FrictionFlag.OUTSIDE_RANGE, FrictionFlag.OK, FrictionFlag.OUTSIDE_RANGE]
    # a nearly unloaded point at speed: the logarithm turns negative
    unloaded = state(pressure_hertz=np.array([1e9, 1e6]), speed_entrainment=15.0)
    kelley = friction_model("benedict_kelley_1961").mu(unloaded, oil=OIL)
    assert kelley.flag.tolist() == [FrictionFlag.OK, FrictionFlag.UNDEFINED]
    assert np.isnan([kelley.mu[1], kelley.lower[1], kelley.upper[1]]).all()
    # formulas that diverge are held at the least sliding
    least = friction_model("benedict_kelley_1961").mu(
        state(slide_to_roll=np.array([0.0, SLIDING_FLOOR / 5.0])), oil=OIL
    )
    assert least.mu[0] == least.mu[1]
    assert least.flag[0] == FrictionFlag.OUTSIDE_RANGE


def test_load_sharing_reaches_the_boundary_value() -> None:
    slow = state(speed_entrainment=1e-4, roughness_rms_1=2e-6, roughness_rms_2=2e-6)
    for name, boundary in (("arana_2019", 0.065), ("doleschel_2002", 0.10), ("matsumoto_morikawa_2014", 0.10)):
        assert float(friction_model(name).mu(slow, oil=OIL).mu) == pytest.approx(boundary, rel=0.02)
    # the base oil enters the lubricant factor
    mineral = friction_model("schlenk_1994").mu(state(), oil=OIL)
    pao = friction_model("schlenk_1994").mu(state(), oil="pao100")
    viscosity = OIL.at(363.15).viscosity_inlet / Oil.load("pao100").at(363.15).viscosity_inlet
    assert float(pao.mu / mineral.mu) == pytest.approx(0.8 * viscosity**0.05, rel=1e-12)


@pytest.mark.parametrize("name", ["constant", "constant:x", "constant:-0.1", "constant:nan", "xu_2007", "nothing.json"])
def test_bad_names_are_refused(name: str) -> None:
    with pytest.raises(InputError) as caught:
        friction_model(name)
    assert caught.value.value == name


def test_conditions_of_two_points_by_hand() -> None:
    """1 GPa and 12 mm at 4 m/s; sliding 1.2 m/s across and 0.5 m/s along the line, the second point smooth."""
    given = {"slide_to_roll": -0.3, "speed_sliding_lengthwise": 0.5, "effective_modulus": 228e9}
    rough = {"roughness_rms_1": [0.3e-6, 0.0], "roughness_rms_2": [0.4e-6, 0.0]}
    kept = {"pressure_hertz": 1e9, "speed_entrainment": 4.0, "temperature_oil": [353.15, 373.15]}
    found = conditions_of(state(**kept, **given, **rough), AXLE_OIL)
    half_width = 4.0 * 0.012 * 1e9 / 228e9
    load = 0.5 * math.pi * half_width * 1e9
    by_hand = {"half_width": half_width, "load_per_length": load, "speed_sum": 8.0, "speed_sliding": 1.3}
    for name, value in (by_hand | {"slide_to_roll_total": 1.3 / 4.0, "roughness_rms": [0.5e-6, 0.0]}).items():
        np.testing.assert_allclose(found[name], value, rtol=1e-12)
    for k, temperature in enumerate((353.15, 373.15)):
        oil = AXLE_OIL.at(temperature)
        line = LineContact(0.012, 228e9, load, 4.0)
        speed, _, _ = line.dowson_groups(oil)
        incompressible = moes_1992(*line.moes_groups(oil)) * 0.012 * math.sqrt(2.0 * speed)
        # Dowson & Higginson at 1 GPa
        film = incompressible / (1.0 + 0.6 / 2.7)
        assert found["film_formula"][k] == pytest.approx(film, rel=1e-9)
        assert found["viscosity_inlet"][k] == pytest.approx(oil.viscosity_inlet, rel=1e-12)
        assert found["viscosity_kinematic"][k] == pytest.approx(oil.viscosity_inlet / oil.density, rel=1e-12)
        mean = float(oil.viscosity(np.array([0.25e9 * math.pi]))[0])
        assert found["viscosity_mean_pressure"][k] == pytest.approx(mean, rel=1e-9)
    assert found["film_ratio_formula"][0] == pytest.approx(found["film_formula"][0] / 0.5e-6, rel=1e-12)
    assert found["film_ratio_formula"][1] == math.inf


def test_contradicting_points_are_refused() -> None:
    """Ratios above 2 are bodies that move in opposite directions."""
    point = {"pressure_hertz": 1e9, "radius_equivalent": 0.012, "speed_entrainment": 4.0, "temperature_oil": 353.15}
    assert contact_points(**point, slide_to_roll=2.0).slide_to_roll == 2.0
    changes: list[tuple[dict[str, Any], str]] = [
        ({"temperature": 353.15}, "temperature"),
        ({"speed_entrainment": []}, "speed_entrainment"),
        ({"speed_entrainment": [1.0, 2.0], "slide_to_roll": [0.1, 0.2, 0.3]}, "speed_entrainment, slide_to_roll"),
        *(({"slide_to_roll": ratio}, "slide_to_roll") for ratio in (2.1, -3.0, [0.1, 2.5])),
    ]
    for change, field in changes:
        with refuses(field):
            contact_points(**point | {"slide_to_roll": 0.2} | change)


CARDS = {name: Oil.load(name) for name in ("75w90", "fva3")}
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
DRAWN = st.sampled_from(sorted(CARDS))


def table(point: dict[str, float], oil: str, **changes: Any) -> dict[str, np.ndarray]:
    values = {"effective_modulus": 226e9, "roughness_rms_2": 0.2e-6, **point, **changes}
    return conditions_of(ContactState.of(**values), CARDS[oil])


def friction(family: str, conditions: dict[str, np.ndarray], boundary: float = MU_B) -> np.ndarray:
    with np.errstate(over="ignore"):
        return np.exp(FAMILIES[family].log_mu(conditions, COEFFICIENTS[family], boundary))


@given(point=BEYOND, oil=DRAWN, family=st.sampled_from(sorted(FAMILIES)))
def test_friction_is_even_in_both_slidings(point: dict[str, float], oil: str, family: str) -> None:
    across, along = point["slide_to_roll"], point["speed_sliding_lengthwise"]
    signs = np.array([[1, -1, 1, -1], [1, 1, -1, -1]])
    mu = friction(family, table(point, oil, slide_to_roll=signs[0] * across, speed_sliding_lengthwise=signs[1] * along))
    assert (mu > 0.0).all()
    np.testing.assert_array_equal(mu, mu[0])


@given(point=BEYOND, oil=DRAWN, boundary=st.floats(0.03, 0.2))
def test_friction_is_bounded_and_shares_are_shares(point: dict[str, float], oil: str, boundary: float) -> None:
    conditions = table(point, oil)
    share, fluid = short_parts(conditions, START)
    limit = float(conditions["limiting_shear_coefficient"])
    assert 0.0 <= share <= 1.0
    # the spread of a thick film widens the contact, where its stress is far below the limit
    assert 0.0 < fluid <= limit * (1.0 + 1e-9)
    assert friction("short", conditions, boundary) <= max(boundary, limit) * (1.0 + 1e-9)


@given(point=BEYOND, oil=DRAWN)
def test_boundary_friction_is_the_limit_of_vanishing_films(point: dict[str, float], oil: str) -> None:
    conditions = table(point, oil)
    thin = conditions | {name: 1e-6 * conditions[name] for name in ("film_formula", "film_ratio_formula")}
    # sliding as slow as the film is thin
    thin |= {"speed_sliding": 1e-6 * conditions["speed_sliding"]}
    assert friction("short", thin) == pytest.approx(MU_B, rel=0.02)


@given(point=BEYOND, oil=DRAWN)
def test_full_film_friction_vanishes_with_the_sliding(point: dict[str, float], oil: str) -> None:
    slide = np.array([1e-3, 1e-9, 1e-200, 0.0])
    smooth = {**point, "roughness_rms_1": 0.0, "roughness_rms_2": 0.0}
    conditions = table(smooth, oil, slide_to_roll=slide, speed_sliding_lengthwise=0.0)
    fluid = short_parts(conditions, START)[1]
    assert (np.diff(fluid) < 0.0).all()
    assert fluid[3] == 0.0
    # at 2.5 GPa and 25 degC the viscosity of FVA3 exceeds 1e20 Pa s: proportional only at very little sliding
    assert fluid[2] < 1e-20


@given(point=BEYOND, oil=DRAWN, family=st.sampled_from(["regimes", "short"]))
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
    assert fluid == pytest.approx(CARDS["fva3"].limiting_stress[1], rel=2e-4)


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
    # mu alone would give 1 again
    assert carried(hidden) < 0.98
    assert carried(table_of) == pytest.approx(1.0, abs=1e-3)
    assert parts_of(SHORT, table_of) is None
    assert parts_of(FAMILIES["power_law"], known) is None
