"""Rows of a dataset that formulas are fitted to, and those they are checked with."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from regression.data.dataset import Dataset, load_dataset
from regression.fitting.noise import expected_rows
from regression.friction.conditions import Array
from regression.friction.families import Family
from regression.friction.fitted import FittedFormula

Results = Dataset | str | PathLike[str] | Sequence[Dataset | str | PathLike[str]]

# a case whose own error exceeds mu says nothing of it. A narrower mark would pick cases by their outcome: of several
# profiles those that rub more have the smaller relative error (a mark of 0.1 made gear meshes rub 20 % too much)
MAX_ERROR = 1.0
# points a formula is fitted to at most: a form of some coefficients learns nothing from more, and memory is for them
MAX_POINTS = 100_000
# origins that are kept for checking, and why a row of them is not fitted
_KEPT = {"corner": "corner kept for checking", "path": "gear path kept for checking"}


def dataset_of(results: Results) -> Dataset:
    """Results as one dataset; several are joined. Errors as of `regression.load_dataset`."""
    return load_dataset(results) if isinstance(results, (Dataset, str, PathLike)) else load_dataset(*results)


def usable_rows(dataset: Dataset, *, corners: bool) -> tuple[pd.DataFrame, dict[str, int]]:
    """Points ln mu can be fitted to (`expected_rows`), and how many cases were left out for which reason.

    At most `MAX_POINTS`, the first by their key, which is a hash of the conditions: as good as drawn.
    """
    frame = dataset.frame
    mu = frame["friction_coefficient"]
    reasons = pd.Series("", index=frame.index, dtype=object)
    reasons[frame["slide_to_roll_total"] <= 0.0] = "no sliding"
    reasons[~(mu > 0.0)] = "friction not positive"
    reasons[frame["friction_error"] > MAX_ERROR] = f"friction error above {100.0 * MAX_ERROR:.0f} %"
    for origin, reason in _KEPT.items():
        if origin != "corner" or not corners:
            reasons[frame["origin"] == origin] = reason
    failed = frame["status"] == "failed"
    reasons[failed] = "failed: " + frame.loc[failed, "reason"].astype(object)
    left_out = reasons[reasons != ""].value_counts().sort_index()
    excluded = {str(reason): int(count) for reason, count in left_out.items()}
    points = expected_rows(frame[reasons == ""].reset_index(drop=True))
    if len(points) > MAX_POINTS:
        excluded[f"beyond {MAX_POINTS} points"] = len(points) - MAX_POINTS
        points = points[:MAX_POINTS].copy()
    return points, excluded


def fitted_rows(dataset: Dataset, formula: FittedFormula | None = None) -> pd.DataFrame:
    """The rows formulas are fitted to; with the corners where the formula was fitted to these too."""
    corners = formula is not None and not any("corner" in reason for reason in formula.data.excluded)
    return usable_rows(dataset, corners=corners)[0]


def own_rows(frame: pd.DataFrame, oil: str | None) -> NDArray[np.bool_]:
    """Rows whose oil a formula states its errors for: all, or those of one of several oils."""
    return np.ones(len(frame), dtype=bool) if oil is None else (frame["oil"] == oil).to_numpy()


def checkable_rows(frame: pd.DataFrame) -> pd.DataFrame:
    """Rows a formula can be compared with: a case of large error of its own is no reference."""
    usable = (frame["status"] != "failed") & (frame["friction_coefficient"] > 0.0)
    usable &= ~(frame["friction_error"] > MAX_ERROR)
    return frame[usable & (frame["slide_to_roll_total"] > 0.0)].reset_index(drop=True)


def kept_rows(dataset: Dataset, origin: str) -> pd.DataFrame:
    """Rows of an origin that is kept for checking."""
    return checkable_rows(dataset.frame[dataset.frame["origin"] == origin])


def box_of(family: Family, frame: pd.DataFrame) -> tuple[str, ...]:
    """Variables whose range a formula of these rows states: not the lay where all roughness has the same.

    The formula then takes the roughness as isotropic, which is a note, and no point lies outside its range for that.
    """
    one_lay = np.ptp(frame["peklenik_number"].to_numpy(dtype=float)) == 0.0
    return tuple(name for name in family.box if not (one_lay and name == "peklenik_number"))


def computed_friction(frame: pd.DataFrame) -> Array:
    """The friction coefficients of a dataset's rows."""
    return frame["friction_coefficient"].to_numpy(dtype=float)


def boundary_friction_of(frame: pd.DataFrame) -> float | Array:
    """The boundary friction of the rows: one number, or a column where there are several."""
    values = frame["boundary_friction"].to_numpy(dtype=float)
    return float(values[0]) if np.ptp(values) == 0.0 else values
