"""What a roughness profile's own numbers tell of its friction, beside Rq, correlation length and lay of the finish.

    python benchmarks/profile_numbers.py gear_75w90_noise gear_75w90_thin

Of points computed with several profiles each: ln mu and the logit of the asperities' load share about their means over
the profiles, by least squares on skewness, kurtosis, correlation length, RMS slope and highest peak of the profiles of
both surfaces about theirs (all of the same Rq). Printed is the share of the variance that this explains in points left
out of the fit (five folds), by film ratio.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import pandas as pd
from common import OUT, command_line, write_rows

from ehl.rough.mixed import MIN_CORRELATION_LENGTHS, PROFILE_LENGTH
from ehl.surface.roughness import generate_profile, measured_correlation_length
from regression.data.dataset import load_dataset

BANDS = (0.0, 0.1, 0.3, 0.6, 2.0)
POINT = ["pressure_hertz", "radius_equivalent", "speed_entrainment", "slide_to_roll", "roughness_rms_1"]
NUMBERS = ("skewness", "kurtosis", "correlation_length", "slope", "peak")
FOLDS = 5
MIN_SHARE = 1e-3  # of the load on asperities: below, profiles do not touch


def numbers_of(row: pd.Series) -> list[float]:
    """`NUMBERS` of both profiles of a case, their means; over Rq and the correlation length of the finish."""
    lc = row["correlation_length"]
    length = max(PROFILE_LENGTH * row["half_width"], MIN_CORRELATION_LENGTHS * lc)
    found = []
    for surface in (1, 2):
        profile = generate_profile(1.0, lc, length, lc / 20.0, 2 * int(row["seed"]) + surface)
        slope = np.std(np.diff(profile.heights)) / profile.spacing * lc
        own = measured_correlation_length(profile.heights, profile.spacing) / lc
        found.append([profile.skewness, profile.kurtosis, own, slope, profile.heights.max()])
    return list(np.mean(found, axis=0))


def explained(about: np.ndarray, target: np.ndarray, point: np.ndarray) -> float:
    """Share of the variance of `target` explained in points left out."""
    told = np.zeros_like(target)
    for fold in range(FOLDS):
        out = point % FOLDS == fold
        told[out] = about[out] @ np.linalg.lstsq(about[~out], target[~out], rcond=None)[0]
    return float(1.0 - np.sum((target - told) ** 2) / np.sum(target**2))


def main(argv: Sequence[str] | None = None) -> None:
    """Print and write."""
    parser = command_line(__doc__)
    parser.add_argument("runs", nargs="+", metavar="RUN")
    frame = load_dataset(*parser.parse_args(argv).runs).frame
    frame = frame[(frame["status"] != "failed") & (frame["friction_coefficient"] > 0.0)]
    frame = frame[(frame["asperity_load_share"] > MIN_SHARE) & frame.duplicated(POINT, keep=False)].reset_index(
        drop=True
    )
    point = frame.groupby(POINT, sort=False).ngroup().to_numpy()
    table = pd.DataFrame([numbers_of(row) for _, row in frame.iterrows()], columns=list(NUMBERS))
    table["ln mu"] = np.log(frame["friction_coefficient"])
    share = frame["asperity_load_share"].clip(upper=1.0 - MIN_SHARE)
    table["logit of the share"] = np.log(share / (1.0 - share))
    about = table - table.groupby(point).transform("mean")
    rows = []
    for low, high in itertools.pairwise(BANDS):
        inside = ((frame["film_ratio"] >= low) & (frame["film_ratio"] < high)).to_numpy()
        if inside.sum() < 8 * len(NUMBERS):
            continue
        scaled = (about[list(NUMBERS)] / about[list(NUMBERS)].std()).to_numpy()[inside]
        for name in ("ln mu", "logit of the share"):
            target = about[name].to_numpy()[inside]
            per = dict(zip(NUMBERS, np.linalg.lstsq(scaled, target, rcond=None)[0], strict=True))
            rows.append(
                {
                    "of": name, "film_ratio_from": low, "film_ratio_to": high, "profiles": int(inside.sum()),
                    "scatter": float(target.std()), "explained": explained(scaled, target, point[inside]), **per,
                }
            )  # fmt: skip
    print(pd.DataFrame(rows).to_string(index=False, float_format=lambda number: f"{number:.3g}"))
    write_rows(OUT / "profile_numbers.csv", rows)


if __name__ == "__main__":
    main()
