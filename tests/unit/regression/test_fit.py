"""The fit's bookkeeping: rows left out, folds, bands, intervals, refusals."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from refusals import refuses
from small_plans import gear_plan, swept

from regression.data.dataset import Dataset
from regression.fitting import rows as rows_module
from regression.fitting.coefficients import linear_fit
from regression.fitting.cross_validation import cell_groups, fold_numbers
from regression.fitting.fit import conformal_width, fit_families, fit_formula, interval_of, noise_floor, scores
from regression.fitting.rows import usable_rows

PLAN = gear_plan(
    "fit", {"size": 64, "corners": True}, temperature_oil="80 degC", roughness_rms={"low": "0.2 um", "high": "0.6 um"}
)


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return swept(tmp_path_factory.mktemp("fit"), PLAN)


def changed(dataset: Dataset, rows: list[int], **values: object) -> Dataset:
    frame = dataset.frame.copy()
    for name, value in values.items():
        frame.loc[rows, name] = value
    return replace(dataset, frame=frame)


def test_rows_that_cannot_be_fitted_are_left_out_and_counted(dataset: Dataset) -> None:
    sobol = list(np.flatnonzero(dataset.frame["origin"] == "sobol"))
    worse = changed(dataset, sobol[:5], friction_coefficient=[0.0, 0.0, 0.0, -0.01, -0.01])
    worse = changed(worse, sobol[5:6], status="failed", reason="time_cap")
    worse = changed(worse, sobol[6:8], status="unsettled", friction_error=[0.9, 1.1])
    frame, excluded = usable_rows(worse, corners=False)
    assert excluded == {
        "corner kept for checking": 32,
        "failed: time_cap": 1,
        "friction error above 100 %": 1,
        "friction not positive": 5,
    }
    assert len(frame) == 57
    assert (frame["friction_coefficient"] > 0.0).all()
    assert len(usable_rows(worse, corners=True)[0]) == 89
    formula = fit_formula(worse, "power_law")
    assert formula.data.excluded == excluded
    assert (formula.data.count, formula.data.used) == (96, 57)


def test_formula_states_ranges_identity_and_errors(dataset: Dataset) -> None:
    formula = fit_formula(dataset, "power_law")
    # one oil temperature: the viscosity is a constant
    assert set(formula.dropped) == {"viscosity"}
    assert (formula.coefficients["viscosity"], "viscosity" in formula.standard_errors) == (0.0, False)
    fitted, _ = usable_rows(dataset, corners=False)
    low, high = formula.ranges["pressure_hertz"]
    # rounded outwards to three digits
    assert low <= fitted["pressure_hertz"].min() < 1.01 * low
    assert high >= fitted["pressure_hertz"].max() > 0.99 * high
    assert (low, high) == (float(f"{low:.3g}"), float(f"{high:.3g}"))
    assert formula.data.hash == dataset.data_hash == changed(dataset, [0], seconds=99.0).data_hash
    for change in ({"friction_coefficient": 0.0123}, {"reason": "x"}):
        assert changed(dataset, [0], **change).data_hash != dataset.data_hash
    assert [(oil.name, oil.card_hash) for oil in formula.oils] == [("fva3", dataset.oil_hash)]
    assert formula.validation.mape >= formula.fit.mape > 0.0
    assert formula.fit.worst.key in set(fitted["key"])
    assert formula.fit.largest == abs(formula.fit.worst.relative_error)
    assert formula.interval.log_width <= formula.interval.largest


def test_whole_cells_are_held_out(dataset: Dataset) -> None:
    groups, folds = cell_groups(dataset.frame), fold_numbers(dataset.frame)
    for group in np.unique(groups):
        assert np.unique(folds[groups == group]).size == 1
    assert np.unique(folds).size == 10
    # cells are a grid of 4 x 4 over the ranges
    low = dataset.frame["pressure_hertz"] < 0.7e9
    assert set(groups[low] // 4) == {0}
    assert groups.max() == 15
    # one cell: rows in turn
    frame = pd.DataFrame({"pressure_hertz": np.full(25, 1e9), "radius_equivalent": np.full(25, 0.01)})
    np.testing.assert_array_equal(fold_numbers(frame), np.arange(25) % 10)


def test_scores_of_a_known_error(dataset: Dataset) -> None:
    frame = dataset.frame
    predicted = frame["friction_coefficient"].to_numpy() * 1.02
    predicted[7] *= 1.5
    result = scores(frame, predicted)
    assert result.largest == pytest.approx(0.53, rel=1e-9)
    assert result.worst.key == frame["key"][7]
    assert result.p95 == pytest.approx(0.02, rel=1e-9)
    assert result.bias == pytest.approx(result.mape, rel=1e-12)
    assert result.rmse == pytest.approx(np.sqrt(np.mean((predicted - frame["friction_coefficient"]) ** 2)), rel=1e-12)
    mu = frame["friction_coefficient"].to_numpy()
    assert scores(frame, 1.02 * mu).rmse_log == pytest.approx(np.log(1.02))
    # an error of half a standard deviation leaves a quarter of the variance
    assert scores(frame, mu + 0.5 * mu.std()).r2 == pytest.approx(0.75)
    assert scores(frame, mu * np.exp(0.5 * np.log(mu).std())).r2_log == pytest.approx(0.75)


def test_conformal_width_covers_new_errors() -> None:
    random = np.random.default_rng(5)
    covered = [
        np.mean(np.abs(random.standard_normal(200)) <= conformal_width(np.abs(random.standard_normal(40)), 0.9))
        for _ in range(300)
    ]
    # split conformal: at least 0.9 in the mean, at most 0.9 + 1/41; three standard errors of 300 trials
    assert 0.9 - 0.009 <= np.mean(covered) <= 0.9 + 1 / 41 + 0.009


def test_noise_floor_is_the_rms_standard_deviation_of_the_stated_errors(dataset: Dataset) -> None:
    assert noise_floor(dataset.frame) == 0.0
    stated = changed(dataset, [0, 1], friction_error=[3e-3, 4e-3])
    # 90 % of a normal distribution lie within 1.6449 standard deviations
    assert noise_floor(stated.frame) == pytest.approx(np.sqrt(12.5e-6) / 1.6449, rel=1e-3)


def test_refusals(dataset: Dataset, tmp_path: Path) -> None:
    with refuses("target"):
        dataset.save(tmp_path)
    with refuses("family"):
        fit_formula(dataset, "spline")
    with refuses("run"):
        fit_formula(replace(dataset, frame=dataset.frame.iloc[:10]), "xu")
    with refuses("run"):
        fit_families(replace(dataset, frame=dataset.frame[dataset.frame["origin"] == "sobol"].iloc[:5]))
    with refuses("boundary_friction"):
        fit_formula(changed(dataset, list(range(96)), boundary_friction=np.linspace(0.08, 0.1, 96)), "xu")
    x = np.linspace(1.0, 2.0, 30)
    with refuses("run"):
        linear_fit(("c", "a", "b"), np.column_stack([np.ones(30), x, 2.0 * x]), x)


def test_bands_with_too_few_cases_have_no_interval_of_their_own(dataset: Dataset) -> None:
    frame = dataset.frame
    ratio = frame["film_ratio_formula"].to_numpy()
    result = interval_of(frame, np.where(ratio < 0.5, 0.01, 0.1))
    counts = [int(((ratio >= low) & (ratio < high)).sum()) for low, high in ((0, 0.5), (0.5, 1), (1, 2), (2, np.inf))]
    assert [band.count for band in result.bands] == [count for count in counts if count >= 20]
    assert min(counts) < 20 <= max(counts)
    assert result.bands[0].log_width == (0.01 if counts[0] >= 20 else 0.1)


def test_more_points_than_a_form_needs_are_left_out_and_said(dataset: Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    every = fit_formula(dataset, "power_law")
    monkeypatch.setattr(rows_module, "MAX_POINTS", 48)
    some = fit_formula(dataset, "power_law")
    assert (some.data.count, some.data.used) == (every.data.count, 48)
    assert some.data.excluded["beyond 48 points"] == every.data.used - 48
    # those that are taken are spread over all of the conditions, and give the same form within its errors
    taken = usable_rows(dataset, corners=False)[0]
    assert np.ptp(np.log(taken["speed_entrainment"])) > 0.9 * np.ptp(np.log(dataset.frame["speed_entrainment"]))
    for name, value in every.coefficients.items():
        assert abs(some.coefficients[name] - value) < 5.0 * max(some.standard_errors.get(name, 0.0), 1e-12)
