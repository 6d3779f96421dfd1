"""Fits of known formulas with their error bars, and Sobol indices against closed forms."""

import numpy as np
import pytest
from small_plans import gear_plan, swept

from ehl.common.errors import InputError
from ehl.fluid.oil import Oil
from regression.data.dataset import Dataset
from regression.fitting.coefficients import linear_fit
from regression.fitting.fit import fit_formula
from regression.fitting.sensitivity import formula_sensitivity, sobol_indices
from regression.formula import Formula
from regression.friction.families import FAMILIES, XU
from regression.friction.published import XU_COEFFICIENTS

PLAN = gear_plan("recovery", {"size": 128, "seed": 2}, roughness_rms={"low": "0.2 um", "high": "0.6 um"})


@pytest.fixture(scope="module")
def xu_data(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return swept(tmp_path_factory.mktemp("recovery"), PLAN, "xu_kahraman_2007")


@pytest.fixture(scope="module")
def design(xu_data: Dataset) -> np.ndarray:
    """The design matrix of the Xu form over a gear's range."""
    return XU.design({name: xu_data.frame[name].to_numpy() for name in xu_data.frame})


def test_published_coefficients_come_back_through_the_whole_pipeline(xu_data: Dataset) -> None:
    formula = fit_formula(xu_data, "xu")
    found = np.array([formula.coefficients[term] for term in XU.terms])
    # condition number about 1e2: round-off of 1e-16 grows to 1e-13 or so
    np.testing.assert_allclose(found, XU_COEFFICIENTS, rtol=1e-10)
    assert formula.fit.largest < 1e-11
    assert formula.validation.largest < 1e-10
    assert formula.fit.r2_log == pytest.approx(1.0, abs=1e-14)


def test_standard_errors_agree_with_monte_carlo(design: np.ndarray) -> None:
    truth, sigma = np.array(XU_COEFFICIENTS), 0.1
    random = np.random.default_rng(11)
    exact = design @ truth
    runs = [linear_fit(XU.terms, design, exact + sigma * random.standard_normal(exact.size)) for _ in range(600)]

    def table(pick: str) -> np.ndarray:
        return np.array([[getattr(run, pick)[term] for term in XU.terms] for run in runs])

    values, stated = table("values"), table("standard_errors")
    scatter = values.std(axis=0, ddof=1)
    # 600 runs know a standard deviation to 3 %; four of those
    np.testing.assert_allclose(np.sqrt((stated**2).mean(axis=0)), scatter, rtol=0.12)
    np.testing.assert_array_less(np.abs(values.mean(axis=0) - truth), 4.0 * scatter / np.sqrt(600))


def test_variance_inflation_against_its_definition(design: np.ndarray) -> None:
    fitted = linear_fit(XU.terms, design, design @ np.array(XU_COEFFICIENTS))
    for index, term in enumerate(XU.terms[1:], start=1):
        others = np.delete(design, index, axis=1)
        beta, *_ = np.linalg.lstsq(others, design[:, index], rcond=None)
        residual = design[:, index] - others @ beta
        share = residual @ residual / np.sum((design[:, index] - design[:, index].mean()) ** 2)
        assert fitted.variance_inflation[term] == pytest.approx(1.0 / share, rel=1e-8)


NAMES = ("x1", "x2", "x3")


def ishigami(unit: np.ndarray) -> np.ndarray:
    x = np.pi * (2.0 * unit - 1.0)
    return np.asarray(np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0]))


def test_ishigami() -> None:
    """Closed form (Ishigami & Homma 1990): V1 = (1 + b pi^4/5)^2/2, V2 = a^2/8, V13 = b^2 pi^8 (1/18 - 1/50)."""
    v1 = 0.5 * (1.0 + 0.1 * np.pi**4 / 5.0) ** 2
    v2, v13 = 7.0**2 / 8.0, 0.1**2 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    v = v1 + v2 + v13
    found = sobol_indices(ishigami, NAMES, size=16384)
    np.testing.assert_allclose(found.first, [v1 / v, v2 / v, 0.0], atol=0.01)
    np.testing.assert_allclose(found.total, [(v1 + v13) / v, v2 / v, v13 / v], atol=0.01)
    assert found.evaluations == 5 * 16384
    for values, interval in ((found.first, found.first_interval), (found.total, found.total_interval)):
        assert (interval[:, 0] <= values).all()
        assert (values <= interval[:, 1]).all()
        assert (interval[:, 1] - interval[:, 0] < 0.12).all()


def test_intervals_narrow_with_the_sample_and_the_seed_decides_all() -> None:
    few, many = (sobol_indices(ishigami, NAMES, size=size) for size in (256, 4096))
    assert np.ptp(many.first_interval, axis=1).max() < 0.5 * np.ptp(few.first_interval, axis=1).max()
    again = sobol_indices(ishigami, NAMES, size=256)
    np.testing.assert_array_equal(again.total_interval, few.total_interval)


def test_a_power_law_has_the_indices_of_its_exponents() -> None:
    family = FAMILIES["power_law"]
    exponents = {"speed": -0.5, "sliding": 0.2, "roughness": 0.4, "radius": 0.1, "constant": -3.0}
    coefficients = dict.fromkeys(family.terms, 0.0) | exponents
    changes = {"family": "power_law", "equation": family.equation, "coefficients": coefficients}
    formula = Formula.load("fva3_short").model_copy(update=changes)
    found = formula_sensitivity(formula, Oil.load("fva3"), size=2048)
    names = {"speed_entrainment": "speed", "slide_to_roll_total": "sliding", "roughness_rms": "roughness"}
    names |= {"radius_equivalent": "radius"}
    variance = {name: (exponents[term] * np.log(np.divide(*formula.ranges[name]))) ** 2 for name, term in names.items()}
    total = sum(variance.values())
    for name, share in zip(found.names, found.total, strict=True):
        assert share == pytest.approx(variance.get(name, 0.0) / total, abs=0.01)
    with pytest.raises(InputError, match="varies"):
        sobol_indices(lambda u: np.ones(len(u)), NAMES, size=64)
