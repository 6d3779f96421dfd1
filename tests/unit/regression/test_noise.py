"""Noise floor from repeated realisations, and measured coverage of the intervals by bands of lambda."""

import math

import numpy as np
import pandas as pd
import pytest

from regression.data.result_files import SURFACE_UNITS
from regression.fitting import rows as rows_module
from regression.fitting.fit import interval_of
from regression.fitting.rows import band_noise, expected_rows, measured_noise, realisation_scatter
from regression.friction.conditions import LUBRICANT_UNITS, STATE_UNITS

POINTS, SEEDS = 400, 8


def repeated(seed: int = 1) -> pd.DataFrame:
    """Half of the points at lambda 0.3 scatter by 5 %, half at lambda 3 by 1 %."""
    random = np.random.default_rng(seed)
    frame = pd.DataFrame({name: np.ones(POINTS) for name in (*STATE_UNITS, *LUBRICANT_UNITS, *SURFACE_UNITS)})
    frame["pressure_hertz"] = np.linspace(0.5e9, 2e9, POINTS)
    frame["film_ratio"] = np.where(np.arange(POINTS) % 2 == 0, 0.3, 3.0)
    frame = frame.assign(slide_to_roll_total=0.3, temperature_oil=350.0, oil="fva3", status="converged")
    frame = frame.loc[frame.index.repeat(SEEDS)].reset_index(drop=True)
    scatter = np.where(frame["film_ratio"] < 1.0, 0.05, 0.01)
    frame["seed"] = np.tile(np.arange(SEEDS), POINTS)
    frame["friction_coefficient"] = 0.05 * (1.0 + scatter * random.standard_normal(len(frame)))
    return frame


def test_known_scatter_is_found_by_region() -> None:
    noise = measured_noise(realisation_scatter(repeated()))
    assert (noise.points, noise.realisations) == (POINTS, SEEDS)
    # the variance of 200 points with 7 degrees of freedom each is known to 1/sqrt(2*1400) = 1.9 %: three of these
    assert band_noise(noise, "film_ratio", 0.1) == pytest.approx(0.05, rel=0.057)
    assert band_noise(noise, "film_ratio", 7.0) == pytest.approx(0.01, rel=0.057)
    assert band_noise(noise, "film_ratio", 0.7) is None
    assert noise.single == pytest.approx(np.sqrt((0.05**2 + 0.01**2) / 2.0), rel=0.05)
    assert noise.mean == pytest.approx(noise.single / np.sqrt(SEEDS), rel=1e-12)
    for variable in ("pressure_hertz", "slide_to_roll_total", "temperature_oil", "film_ratio"):
        assert sum(band.count for band in noise.bands if band.variable == variable) == POINTS


def test_the_same_row_twice_is_no_realisation() -> None:
    frame = repeated()
    doubled = pd.concat([frame, frame], ignore_index=True)
    pd.testing.assert_frame_equal(realisation_scatter(doubled), realisation_scatter(frame))
    assert measured_noise(realisation_scatter(frame[frame["seed"] == 0])) is None
    assert measured_noise(realisation_scatter(frame.iloc[:0])) is None
    assert band_noise(None, "film_ratio", 1.0) is None
    # nor do failed cases or other oils count
    frame.loc[frame["seed"] == 3, "status"] = "failed"
    assert set(realisation_scatter(frame)["realisations"]) == {SEEDS - 1}
    frame["oil"] = np.where(frame["seed"] % 2 == 0, "fva3", "75w90")
    assert len(realisation_scatter(frame)) == 2 * POINTS


def test_points_of_several_profiles_become_their_mean_and_its_noise() -> None:
    # half of the profiles have a common error of 3 %, the others of 5 %
    stated = np.hypot(np.where(np.arange(POINTS * SEEDS) % 2 == 0, 0.03, 0.05), 0.02)
    frame = repeated().assign(statistical_error=0.02, friction_error=stated, friction_fluid=0.01)
    rows = expected_rows(frame)
    assert len(rows) == POINTS
    assert (rows["realisations"] == SEEDS).all()
    first = frame["friction_coefficient"].to_numpy().reshape(POINTS, SEEDS)
    np.testing.assert_allclose(rows["friction_coefficient"], first.mean(axis=1), rtol=1e-12)
    np.testing.assert_allclose(rows["statistical_error"], 0.02 / np.sqrt(SEEDS), rtol=1e-12)
    of_mean = np.sqrt((0.03**2 + 0.05**2) / 2.0 + 0.02**2 / SEEDS)
    np.testing.assert_allclose(rows["friction_error"], of_mean, rtol=1e-12)
    unknown = expected_rows(frame.assign(friction_error=np.nan))["friction_error"]
    assert unknown.isna().all()
    for ratio, scatter in ((0.3, 0.05), (3.0, 0.01)):
        noise = rows.loc[rows["film_ratio"] == ratio, "noise_variance"]
        assert noise.nunique() == 1, "one scatter for a band of lambda, whatever a point itself scatters"
        assert noise.iloc[0] == pytest.approx(scatter**2 / SEEDS, rel=0.12)


def test_points_of_one_profile_stay_what_they_are() -> None:
    frame = repeated().assign(statistical_error=0.0329)
    single = frame[frame["seed"] == 0].reset_index(drop=True)
    rows = expected_rows(single)
    # 90 % of a normal error lie within 1.645 deviations
    stated = pd.DataFrame({"statistical_error": [0.0329, np.nan, 0.0]})
    np.testing.assert_allclose(rows_module.statistical_variance(stated), [0.02**2, 0.0, 0.0], rtol=1e-12)
    np.testing.assert_array_equal(rows["friction_coefficient"], single["friction_coefficient"])
    np.testing.assert_allclose(rows["noise_variance"], 0.02**2, rtol=1e-12)


SCALES = (0.005, 0.02, 0.04, 0.1)


def cases(count: int, seed: int) -> tuple[pd.DataFrame, np.ndarray, np.ndarray]:
    """Film ratios over all bands, errors whose size is the band's, folds in turn."""
    random = np.random.default_rng(seed)
    ratio = np.exp(random.uniform(math.log(0.1), math.log(10.0), count))
    scale = np.array(SCALES)[np.searchsorted([0.5, 1.0, 2.0], ratio, side="right")]
    error = np.abs(scale * random.standard_normal(count))
    return pd.DataFrame({"film_ratio_formula": ratio}), error, np.arange(count) % 10


def test_measured_coverage_is_nominal_in_each_band_and_that_of_new_errors() -> None:
    interval = interval_of(*cases(4000, 1))
    frame, new, _ = cases(4000, 2)
    ratio = frame["film_ratio_formula"].to_numpy()
    width = interval.width(ratio)
    assert len(interval.bands) == 4
    for band, scale in zip(interval.bands, SCALES, strict=True):
        # 90 % of a normal error lie within 1.645 of its deviation
        assert band.log_width == pytest.approx(1.645 * scale, rel=0.1)
        spread = math.sqrt(0.09 / band.count)
        assert band.coverage == pytest.approx(0.9, abs=2.0 * spread)
        inside = (ratio >= band.low) & (ratio < (band.high or math.inf))
        # both the calibration and the check are samples
        assert np.mean(new[inside] <= width[inside]) == pytest.approx(0.9, abs=3.0 * math.sqrt(2.0) * spread)


def test_coverage_shows_a_fold_unlike_the_others() -> None:
    frame, error, folds = cases(2000, 3)
    alike = interval_of(frame, error, folds)
    unlike = interval_of(frame, np.where(folds < 2, 10.0 * error + 1.0, error), folds)
    # 400 of 2000 cases err by more than the rest: the other fold alike holds them just below nominal
    for before, after in zip(alike.bands, unlike.bands, strict=True):
        assert after.coverage < before.coverage
    # without folds no coverage is claimed; smooth contacts belong to the outer band
    frame.loc[frame["film_ratio_formula"] > 5.0, "film_ratio_formula"] = np.inf
    bands = interval_of(frame, error).bands
    assert [band.coverage for band in bands] == [None] * 4
    assert sum(band.count for band in bands) == 2000


@pytest.mark.parametrize(("drawn", "counted"), [(64, 64), (63, 66), (0, 3)])
def test_chosen_points_do_not_widen_the_interval(drawn: int, counted: int) -> None:
    """Points of a table count only where few others were drawn."""
    frame = pd.DataFrame({"origin": ["table"] * 3 + ["sobol"] * drawn})
    rows = rows_module.drawn_rows(frame)
    assert rows.sum() == counted
    assert rows[:3].any() == (counted > drawn)
