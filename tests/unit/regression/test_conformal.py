"""Coverage of the intervals by bands of lambda: measured on folds that did not calibrate them."""

import math

import numpy as np
import pandas as pd
import pytest

from regression.fitting.fit import interval_of
from regression.fitting.rows import drawn_rows

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
    rows = drawn_rows(frame)
    assert rows.sum() == counted
    assert rows[:3].any() == (counted > drawn)
