"""Coverage of the intervals by bands of lambda: measured on folds that did not calibrate them."""

import hashlib
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from ehl.common.data import data_path
from regression.fitting.fit import interval_of
from regression.formula import Formula

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
        assert before.coverage is not None
        assert after.coverage is not None
        assert after.coverage < before.coverage


def test_without_folds_no_coverage_is_claimed() -> None:
    frame, error, _ = cases(400, 4)
    assert [band.coverage for band in interval_of(frame, error).bands] == [None] * 4


def test_points_without_roughness_belong_to_the_outer_band() -> None:
    frame, error, folds = cases(400, 5)
    frame.loc[frame["film_ratio_formula"] > 5.0, "film_ratio_formula"] = np.inf
    interval = interval_of(frame, error, folds)
    assert sum(band.count for band in interval.bands) == 400


def write_with_checksum(path: Path, content: dict[str, Any]) -> None:
    content.pop("checksum", None)
    content["checksum"] = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
    path.write_text(json.dumps(content), encoding="utf-8")


def test_files_without_coverage_are_read_and_coverage_is_kept(tmp_path: Path) -> None:
    content = json.loads(data_path("formulas", "fva3_short.json").read_text(encoding="utf-8"))
    for band in content["interval"]["bands"]:
        band.pop("coverage", None)
    path = tmp_path / "formula.json"
    write_with_checksum(path, content)
    assert {band.coverage for band in Formula.load(path).interval.bands} == {None}
    content["interval"]["bands"][0]["coverage"] = 0.91
    write_with_checksum(path, content)
    Formula.load(path).save(path)
    assert Formula.load(path).interval.bands[0].coverage == 0.91
