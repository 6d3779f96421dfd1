"""What a fit is checked with: gear paths, repeated realisations, several oils and boundary frictions, the networks."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from contacts import gear_state
from refusals import refuses
from small_plans import gear_plan, swept

from ehl.fluid.oil import Oil
from ehl.state import ContactState
from regression.data.dataset import Dataset, columns, load_dataset
from regression.fitting import cross_validation
from regression.fitting.coefficients import fit_form
from regression.fitting.fit import fit_families, fit_formula
from regression.fitting.rows import checkable_rows, computed_friction, fitted_rows, usable_rows
from regression.formula import Formula
from regression.friction.conditions import conditions_of
from regression.friction.data_cloud import CloudDistance
from regression.friction.families import FAMILIES, SHORT
from regression.friction.fitted import NETWORK, FittedFormula
from regression.friction.models import FrictionFlag
from regression.friction.oil_cards import card_hash, hashes_of_cards

PLAN = gear_plan("checks", {"size": 128, "corners": 16})
LINEAR = {name: FAMILIES[name] for name in ("power_law", "xu")}


def of_short(data: Dataset) -> Dataset:
    """The same contacts with the friction of the family `short` at its start values."""
    frame, start = data.frame, dict(zip(SHORT.terms, SHORT.start, strict=True))
    mu_b = frame["boundary_friction"].to_numpy()
    return replace(data, frame=frame.assign(friction_coefficient=np.exp(SHORT.log_mu(columns(frame), start, mu_b))))


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return swept(tmp_path_factory.mktemp("one"), PLAN)


@pytest.fixture(scope="module")
def two_oils(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return of_short(swept(tmp_path_factory.mktemp("two"), PLAN | {"lubricant": {"oil": ["fva3", "75w90"]}}))


def state(**changes: Any) -> ContactState:
    values = {"pressure_hertz": 1.0e9, "radius_equivalent": 0.018, "speed_entrainment": 4.0, "slide_to_roll": 0.2}
    return gear_state(**(values | {"roughness_rms_1": 0.25e-6, "roughness_rms_2": 0.25e-6} | changes))


@pytest.fixture(scope="module")
def network(dataset: Dataset) -> FittedFormula:
    return fit_formula(rubbing_more(dataset), NETWORK)


def rubbing_more(data: Dataset) -> Dataset:
    """Friction of `short` at its start values, times what no coefficient of it can give."""
    found = of_short(data)
    frame = found.frame
    wave = 1.0 + 0.4 * np.tanh(2.0 * np.log(frame["pressure_hertz"] / 1e9))
    mu = frame["friction_coefficient"] * wave
    return replace(found, frame=frame.assign(friction_coefficient=mu, asperity_load_share=np.nan))


def test_networks_halve_the_held_out_error_and_survive_the_file(dataset, network, tmp_path):
    plain = fit_formula(rubbing_more(dataset), "short")
    assert network.validation.mape < 0.5 * plain.validation.mape
    assert network.interval.normalised
    assert network.label == NETWORK
    network.save(tmp_path / "f.json")
    upper = Formula.load(tmp_path / "f.json").evaluate(columns(dataset.frame)).upper
    np.testing.assert_allclose(upper, network.evaluate(columns(dataset.frame)).upper, rtol=1e-12)


def test_networks_of_workers(dataset: Dataset, network: FittedFormula, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("regression.fitting.fit._WORTH_WORKERS", 0.0)
    monkeypatch.setattr(cross_validation, "_KEPT", {})
    again = fit_formula(rubbing_more(dataset), NETWORK, jobs=2)
    assert again.to_json() == network.to_json()


def test_networks_of_several_oils_are_tuned_to_each(two_oils: Dataset) -> None:
    frame, _ = usable_rows(rubbing_more(two_oils), corners=False)
    form = fit_form(SHORT, frame, network=True, by_oil=True)
    assert set(form.networks) == {"fva3", "75w90"}
    forms, mu = (form, replace(form, networks={})), computed_friction(frame)
    tuned, common = (np.abs(np.log(each.friction(frame)[0] / mu)).mean() for each in forms)
    assert tuned < common


def test_networks_of_other_oils_are_tuned_to_few_contacts(monkeypatch: pytest.MonkeyPatch) -> None:
    # the file of this oil does not name FVA3, so that its networks are tuned to contacts of FVA3
    monkeypatch.setattr(cross_validation, "TUNED", "eaxle")
    data = load_dataset("gear_fva3_mesh")
    part = replace(data, frame=data.frame.iloc[:64].reset_index(drop=True))
    monkeypatch.setattr(cross_validation, "_KEPT", {})
    tuned, rest = fit_formula(part, NETWORK), checkable_rows(data.frame.iloc[64:])
    shipped = Formula.load("eaxle")
    before, after = (np.abs(np.log(f.evaluate(columns(rest)).mu / computed_friction(rest))) for f in (shipped, tuned))
    assert after.mean() < 0.7 * before.mean()
    assert tuned.data.tuned == "eaxle"
    assert tuned.coefficients == FittedFormula.load("eaxle").coefficients
    # tuned networks describe what the others did, and their errors are those of held-out contacts
    low, high = tuned.ranges["speed_entrainment"]
    assert low <= FittedFormula.load("eaxle").ranges["speed_entrainment"][0]
    assert high >= rest["speed_entrainment"].quantile(0.99)
    assert 0.5 * after.mean() < tuned.validation.mape < 2.0 * after.mean()
    inside = tuned.evaluate(columns(rest))
    covered = (inside.lower <= computed_friction(rest)) & (computed_friction(rest) <= inside.upper)
    assert covered.mean() > 0.8


def test_the_interval_of_tuned_networks_does_not_depend_on_the_noise_of_their_source(monkeypatch, tmp_path):
    shipped, data = FittedFormula.load("eaxle"), load_dataset("gear_fva3_mesh")
    part = replace(data, frame=data.frame.iloc[:64].reset_index(drop=True))
    found = []
    for noise in (0.0, 0.05):
        network = shipped.network.model_copy(update={"noise": noise})
        shipped.model_copy(update={"network": network}).save(tmp_path / "source.json")
        monkeypatch.setattr(cross_validation, "TUNED", str(tmp_path / "source.json"))
        monkeypatch.setattr(cross_validation, "_KEPT", {})
        found.append(fit_formula(part, NETWORK))
    assert found[0].data.tuned == "source.json"
    assert found[1].network.model_dump() == found[0].network.model_dump()
    assert found[1].interval == found[0].interval


def test_networks_are_not_tuned_to_what_they_contain(dataset: Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    frame = usable_rows(load_dataset("gear_fva3_mesh"), corners=False)[0]
    # contacts of the shipped networks
    assert cross_validation.networks_to_tune(SHORT, frame, "mine + gear_mesh") is None
    assert cross_validation.networks_to_tune(SHORT, frame, "mine") is not None
    doubled = frame.assign(friction_coefficient=2.0 * frame["friction_coefficient"])
    assert cross_validation.networks_to_tune(SHORT, doubled, "mine") is None
    without_parts, _ = usable_rows(rubbing_more(dataset), corners=False)
    assert cross_validation.networks_to_tune(SHORT, without_parts, "mine") is None
    monkeypatch.setattr(cross_validation, "OWN_NETWORKS", len(frame) - 1)
    assert cross_validation.networks_to_tune(SHORT, frame, "mine") is None


def test_factors_of_the_interval_are_those_of_the_oil_of_the_formula(monkeypatch: pytest.MonkeyPatch) -> None:
    formula, data = Formula.load("fva3"), load_dataset("gear_fva3", "gear_eaxle")
    rows = fitted_rows(data, formula)
    spread = np.where(rows["oil"] == "fva3", 0.01, 0.5)
    nothing = np.zeros(len(rows), dtype=bool)
    found = cross_validation.HeldOut(computed_friction(rows), spread, np.zeros(len(rows), dtype=np.int64), nothing)
    monkeypatch.setattr(cross_validation, "held_out_friction", lambda *given: found)
    factors = cross_validation.interval_factors(data, formula)
    assert len(factors) == len(formula.interval.bands)
    for band, (middle, low, high) in zip(formula.interval.bands, factors, strict=True):
        expected = np.exp(band.log_width * np.hypot(0.01, formula.network.noise))
        assert (low, middle, high) == pytest.approx((expected,) * 3)


def test_networks_keep_limits_and_bounds(dataset: Dataset, network: FittedFormula) -> None:
    interval = network.interval.model_copy(update={"normalised": False})
    bare = network.model_copy(update={"network": None, "interval": interval})
    oil, rough = Oil.load("fva3"), np.array([2e-6, 2e-6, 0.0])
    speeds = np.array([1e-5, 1e-3, 300.0])
    far = conditions_of(state(speed_entrainment=speeds, roughness_rms_1=rough, roughness_rms_2=rough), oil)
    np.testing.assert_allclose(network.evaluate(far).mu, bare.evaluate(far).mu, rtol=1e-12)
    assert network.evaluate(far).mu[0] == pytest.approx(network.boundary_friction, rel=0.02)
    mu = network.evaluate(columns(dataset.frame)).mu
    assert (mu <= max(network.boundary_friction, oil.limiting_stress[1]) + 1e-12).all()
    none = network.evaluate(conditions_of(state(slide_to_roll=np.array([0.0, 1e-6, -1e-6])), oil)).mu
    assert none[0] == 0.0
    assert none[1] == none[2]
    # slopes are continuous where the sliding of the data begins and where the data end
    for name, ends in (("slide_to_roll", "slide_to_roll_total"), ("pressure_hertz", "pressure_hertz")):
        at = network.ranges[ends][0]
        steps = at * (1.0 + 1e-4 * np.arange(-2.0, 3.0))
        value = network.evaluate(conditions_of(state(**{name: steps}), oil)).mu
        slopes = np.diff(value)
        assert slopes[1] == pytest.approx(slopes[2], rel=2e-2)


def test_networks_are_ranked_with_the_families(dataset: Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("regression.fitting.fit.FAMILIES", LINEAR)
    monkeypatch.setattr("regression.fitting.coefficients._STEPS", (100, 100))  # enough to be the best
    formulas = fit_families(rubbing_more(dataset), nested=True)
    assert formulas[0].network is not None
    held_out = [formula.validation.mape for formula in formulas]
    assert held_out == sorted(held_out)
    best = formulas[1]
    assert best.validation.mape <= best.nested.mape < 1.3 * best.validation.mape


def test_nested_choice_never_sees_its_fold(dataset: Dataset) -> None:
    frame, _ = usable_rows(dataset, corners=False)
    mu, chosen = cross_validation.nested_cross_validate(list(LINEAR.values()), frame)
    assert sum(chosen.values()) == 10
    changed, first = frame.copy(), cross_validation.fold_numbers(frame) == 0
    changed.loc[first, "friction_coefficient"] *= 3.0
    again, _ = cross_validation.nested_cross_validate(list(LINEAR.values()), changed)
    np.testing.assert_array_equal(again[first], mu[first])
    assert (again[~first] != mu[~first]).any()


def test_gear_paths_are_checked_and_not_fitted(dataset: Dataset) -> None:
    sobol = dataset.frame["origin"] == "sobol"
    some = dataset.frame.index[sobol][:30]
    frame = dataset.frame.copy()
    frame.loc[some, "origin"] = "path"
    within = fit_formula(replace(dataset, frame=frame), "power_law")
    assert within.paths.count == 30
    paths = replace(dataset, frame=dataset.frame.loc[some].reset_index(drop=True))
    rest = replace(dataset, frame=dataset.frame.drop(index=some).reset_index(drop=True))
    extrapolated = fit_formula(rest, "power_law", paths=paths)
    assert extrapolated.paths == within.paths
    assert extrapolated.coefficients == within.coefficients
    assert fit_formula(dataset, "power_law").paths is None


def test_corners_lie_beside_the_cloud_and_state_their_coverage(dataset: Dataset) -> None:
    formula = fit_formula(dataset, "short")
    corner = dataset.frame[dataset.frame["origin"] == "corner"]
    assert formula.corners.count == len(corner) == 16
    assert formula.corners.worst.key in set(corner["key"])
    assert fit_formula(dataset, "power_law", corners=True).corners is None
    assert (formula.corners.extrapolated or 0.0) > 0.8
    assert formula.corners.coverage is not None
    # extrapolated, the interval is at least that of the held-out cases that were extrapolated
    value = formula.evaluate(columns(corner))
    extrapolated = formula.extrapolation(columns(corner)) >= CloudDistance.NEAR
    assert (np.log(value.upper / value.mu)[extrapolated] >= formula.interval.near - 1e-12).all()


@pytest.mark.parametrize(("points", "profiles", "expected"), [(60, 16, (0.5, 0.75)), (240, 1, (0.85, 1.15))])
def test_interval_of_means_over_profiles_is_narrower(dataset, points, profiles, expected):
    """Friction with a scatter of 15 % by the profile; a mean over 16 keeps a quarter; the formula errs as well."""
    random = np.random.default_rng(8)
    scattered = dataset.frame["friction_coefficient"] * np.exp(0.15 * random.standard_normal(len(dataset.frame)))
    plain = replace(dataset, frame=dataset.frame.assign(friction_coefficient=scattered))
    frame = pd.concat([dataset.frame[dataset.frame["origin"] != "corner"][:points]] * profiles, ignore_index=True)
    frame["seed"] = np.arange(len(frame))
    frame["key"] = [f"{number:064x}" for number in range(len(frame))]
    frame["friction_coefficient"] *= np.exp(0.15 * random.standard_normal(len(frame)))
    alone = fit_formula(plain, "power_law").interval
    formula = fit_formula(plain, "power_law", noise=replace(dataset, frame=frame))
    found = formula.interval
    assert (formula.noise.single if formula.noise else 0.15) == pytest.approx(0.15, rel=0.15)
    assert (formula.noise is None) is (profiles == 1)
    assert alone.of_means == 1.0
    assert expected[0] < found.of_means < expected[1]
    for before, after in zip((alone, *alone.bands), (found, *found.bands), strict=True):
        assert after.log_width == pytest.approx(found.of_means * before.log_width)
    assert [band.coverage for band in found.bands] == [band.coverage for band in alone.bands]  # of single profiles


def test_band_table_is_that_of_plain_numpy(dataset: Dataset) -> None:
    formula = fit_formula(dataset, "power_law")
    for variable in ("film_ratio", "pressure_hertz"):
        bands = [band for band in formula.bands if band.variable == variable]
        counts = [band.count for band in bands]
        assert sum(counts) == formula.validation.count
        for name, power in (("rmse_log", 2.0), ("mape", 1.0), ("coverage", 1.0)):
            mean = np.average([(getattr(band, name) or 0.0) ** power for band in bands], weights=counts)
            assert mean == pytest.approx(getattr(formula.validation, name) ** power, rel=1e-12)
        assert max(band.largest or 0.0 for band in bands) == formula.validation.largest


def test_several_oils_are_all_recorded_and_all_known(two_oils: Dataset) -> None:
    formula = fit_formula(two_oils, "short")
    hashes = {name: card_hash(Oil.load(name)) for name in ("75w90", "fva3")}
    assert {o.name: o.card_hash for o in formula.oils} == hashes
    # the cards cannot be identified if one has changed
    assert hashes_of_cards(("fva3",), "x") == {"fva3": "x"}
    assert hashes_of_cards(("nothing", "fva3"), "x") == {"nothing": None, "fva3": None}
    assert formula.validation.mape < 0.1
    flags = {name: int(formula.mu(state(), oil=name).flag) for name in ("fva3", "75w90", "pao100")}
    assert flags["fva3"] == flags["75w90"] == FrictionFlag.OK
    assert flags["pao100"] >= FrictionFlag.OTHER_OIL
    # each row carries the figures of its own oil
    one = two_oils.frame[two_oils.frame["oil"] == "75w90"]
    own = ContactState.of(**{n: one[n].to_numpy() for n in ContactState.__dataclass_fields__ if n in one})
    conditions = conditions_of(own, Oil.load("75w90"))
    np.testing.assert_allclose(conditions["viscosity_inlet"], one["viscosity_inlet"], rtol=1e-12)
    np.testing.assert_allclose(formula.evaluate(conditions).mu, formula.evaluate(columns(one)).mu, rtol=1e-9)


def test_errors_of_one_of_several_oils(two_oils: Dataset) -> None:
    """Coefficients, range, errors and interval of the rows of that oil, with the folds of all."""
    frame = two_oils.frame
    mu = frame["friction_coefficient"] * frame["oil"].map({"75w90": 1.0, "fva3": 1.1})
    two_oils = replace(two_oils, frame=frame.assign(friction_coefficient=mu))
    every, one = fit_formula(two_oils, "short"), fit_formula(two_oils, "short", oil="75w90")
    only = fit_form(SHORT, usable_rows(two_oils, corners=False)[0].query("oil == '75w90'"))
    assert one.coefficients == only.coefficients.values
    assert one.coefficients != every.coefficients
    assert [identity.name for identity in one.oils] == ["75w90"]
    rows, _ = usable_rows(two_oils, corners=False)
    own = (rows["oil"] == "75w90").to_numpy()
    assert one.validation.count == own.sum() < every.validation.count == len(rows)
    held_out = cross_validation.held_out_friction(two_oils, one).mu
    error = np.abs(held_out / computed_friction(rows) - 1.0)[own]
    assert one.validation.mape == pytest.approx(error.mean(), rel=1e-12)
    assert one.ranges["viscosity_inlet"][1] == pytest.approx(rows["viscosity_inlet"][own].max(), rel=0.01)
    with refuses("oil"):
        fit_formula(two_oils, "short", oil="eaxle")


def test_interval_of_an_oil_that_was_not_fitted() -> None:
    formula = Formula.load("gear")
    other = formula.evaluate(conditions_of(state(), Oil.load("minr")), Oil.load("minr"))
    assert float(other.upper / other.mu) >= np.exp(formula.interval.other_oil) * (1.0 - 1e-12)
    assert float(other.lower / other.mu) <= np.exp(-formula.interval.other_oil) * (1.0 + 1e-12)
    assert int(other.flag) >= FrictionFlag.OTHER_OIL


@pytest.mark.usefixtures("little_training")
def test_several_boundary_frictions_serve_a_family_that_takes_them(tmp_path: Path) -> None:
    variables = PLAN["variables"] | {"boundary_friction": [0.08, 0.10, 0.12]}
    data = of_short(swept(tmp_path, PLAN | {"sampling": {"size": 64}, "variables": variables}))
    formula = fit_formula(data, "short")
    assert formula.boundary_friction_range == (0.08, 0.12)
    assert formula.validation.mape < 0.1
    conditions = conditions_of(state(speed_entrainment=1e-3), Oil.load("fva3"))
    for mu_b in (0.08, 0.12):
        assert float(formula.with_options(mu_b).evaluate(conditions).mu) == pytest.approx(mu_b, rel=0.03)
    with refuses("boundary_friction"):
        fit_formula(data, "xu")
    assert {"short", "xu"} & {formula.family for formula in fit_families(data)} == {"short"}
