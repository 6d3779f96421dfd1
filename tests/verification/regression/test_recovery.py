"""Does the fit find what is known to be in the data, and are its error bars right?"""

import numpy as np
import pytest
from small_plans import gear_plan, swept

from regression.data.dataset import Dataset
from regression.fitting.coefficients import linear_fit
from regression.fitting.fit import fit_formula
from regression.friction.families import XU
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
