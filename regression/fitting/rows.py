"""Selection of the rows of a dataset for fits and for validation."""

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

# largest relative error of a fitted case. A lower limit would select cases by their result: profiles with high asperity
# friction have the smaller relative error (a limit of 0.1 increased the friction along gear meshes by 20 %)
MAX_ERROR = 1.0
MAX_POINTS = 100_000  # largest number of fitted points; more need memory but do not improve the fit
# origins of rows for validation, and the reason why they are not fitted
_KEPT = {"corner": "corner kept for checking", "path": "gear path kept for checking"}


def dataset_of(results: Results) -> Dataset:
    """Results as one dataset, joined if there are several; errors as in `regression.load_dataset`."""
    return load_dataset(results) if isinstance(results, (Dataset, str, PathLike)) else load_dataset(*results)


def usable_rows(dataset: Dataset, *, corners: bool) -> tuple[pd.DataFrame, dict[str, int]]:
    """Points for a fit of ln mu (`expected_rows`), and the number of excluded cases by reason.

    At most `MAX_POINTS`, the first ones by key. As the key is a hash of the conditions, this is a random choice.
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
    """The rows for a fit, including the corners if the formula was fitted to these as well."""
    corners = formula is not None and not any("corner" in reason for reason in formula.data.excluded)
    return usable_rows(dataset, corners=corners)[0]


def own_rows(frame: pd.DataFrame, oil: str | None) -> NDArray[np.bool_]:
    """Mask of the rows for the errors of a formula: all rows, or those of one oil."""
    return np.ones(len(frame), dtype=bool) if oil is None else (frame["oil"] == oil).to_numpy()


def checkable_rows(frame: pd.DataFrame) -> pd.DataFrame:
    """Rows for a comparison with a formula, without cases of large error."""
    usable = (frame["status"] != "failed") & (frame["friction_coefficient"] > 0.0)
    usable &= ~(frame["friction_error"] > MAX_ERROR)
    return frame[usable & (frame["slide_to_roll_total"] > 0.0)].reset_index(drop=True)


def kept_rows(dataset: Dataset, origin: str) -> pd.DataFrame:
    """Rows of an origin that is kept for validation."""
    return checkable_rows(dataset.frame[dataset.frame["origin"] == origin])


def box_of(family: Family, frame: pd.DataFrame) -> tuple[str, ...]:
    """Variables whose range a formula of these rows checks: without the lay if all roughness has the same.

    The formula then assumes isotropic roughness, with a note, and the lay does not limit its range.
    """
    one_lay = np.ptp(frame["peklenik_number"].to_numpy(dtype=float)) == 0.0
    return tuple(name for name in family.box if not (one_lay and name == "peklenik_number"))


def computed_friction(frame: pd.DataFrame) -> Array:
    """Friction coefficients of the rows of a dataset."""
    return frame["friction_coefficient"].to_numpy(dtype=float)


def boundary_friction_of(frame: pd.DataFrame) -> float | Array:
    """Boundary friction of the rows: one number, or a column if it varies."""
    values = frame["boundary_friction"].to_numpy(dtype=float)
    return float(values[0]) if np.ptp(values) == 0.0 else values
