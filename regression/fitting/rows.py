"""Selection of the rows of a dataset for fits and for validation.

Noise floor: scatter of mu over realisations of the roughness at equal conditions, and means over realisations.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from os import PathLike

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from regression.data.dataset import Dataset, load_dataset
from regression.data.result_files import SURFACE_UNITS
from regression.friction.conditions import LUBRICANT_UNITS, STATE_UNITS, Array
from regression.friction.error_tables import NoiseBand, NoiseFloor
from regression.friction.families import Family
from regression.friction.fitted import FittedFormula

NORMAL_90 = 1.645  # half width of the 90 % interval of a normal variable over its standard deviation
# edges of the bands of reported errors; outer bands are open
BANDS: dict[str, tuple[float, ...]] = {
    "film_ratio": (0.5, 1.0, 2.0),
    "slide_to_roll_total": (0.05, 0.2, 0.5, 1.0),
    "pressure_hertz": (0.7e9, 1.0e9, 1.5e9),
    "temperature_oil": (333.15, 353.15, 373.15),
}
# edges of the bands of lambda with a common scatter; individual values would favour cases with high asperity friction
_SCATTER_EDGES = (0.1, 0.2, 0.35, 0.5, 1.0, 2.0)
_MIN_POINTS = 4  # smallest number of repeated points in such a band
# outputs that are averaged over the profiles of a point
_AVERAGED = (
    "friction_coefficient", "friction_fluid", "friction_asperity", "film_central", "film_min", "asperity_load_share",
    "roughness_load_share", "film_ratio",
)  # fmt: skip
# columns that are equal at one point
_SAME = [*dict.fromkeys((*STATE_UNITS, *LUBRICANT_UNITS, *(name for name in SURFACE_UNITS if name != "seed"), "oil"))]


def realisation_scatter(frame: pd.DataFrame) -> pd.DataFrame:
    """Scatter of every point with more than one roughness seed."""
    usable = frame[(frame["status"] != "failed") & (frame["friction_coefficient"] > 0.0)]
    usable = usable.drop_duplicates([*_SAME, "seed"])
    grouped = usable.groupby(_SAME, dropna=False, sort=True)
    points = grouped[list(BANDS)].mean() if not usable.empty else pd.DataFrame(columns=list(BANDS))
    # without the keys, some of which are also variables of bands
    points = points.reset_index(drop=True)
    mu = grouped["friction_coefficient"].agg(["count", "mean", "std"]).reset_index(drop=True)
    scatter = points.assign(realisations=mu["count"], single=mu["std"] / mu["mean"])
    scatter = scatter[scatter["realisations"] >= 2].reset_index(drop=True)
    return scatter.assign(mean=scatter["single"] / np.sqrt(scatter["realisations"].to_numpy(dtype=float)))


def measured_noise(scatter: pd.DataFrame) -> NoiseFloor | None:
    """Noise floor by region, RMS over the points; None without repeated points."""
    if scatter.empty:
        return None
    bands = []
    for variable, edges in BANDS.items():
        place = np.searchsorted(edges, scatter[variable].to_numpy(dtype=float), side="right")
        ends = list(itertools.pairwise((None, *edges, None)))
        for number in np.unique(place):
            (low, high), inside = ends[number], scatter[place == number]
            scattered = {name: rms(inside[name]) for name in ("single", "mean")}
            bands.append(NoiseBand(variable=variable, low=low, high=high, count=len(inside), **scattered))
    return NoiseFloor(
        points=len(scatter),
        realisations=float(scatter["realisations"].mean()),
        single=rms(scatter["single"]),
        mean=rms(scatter["mean"]),
        bands=tuple(bands),
    )


def band_noise(noise: NoiseFloor | None, variable: str, inside: float) -> float | None:
    """Scatter of one realisation in the band of a variable at a value; None if unknown."""
    if noise is None:
        return None
    for band in noise.bands:
        low = -math.inf if band.low is None else band.low
        high = math.inf if band.high is None else band.high
        if band.variable == variable and low <= inside < high:
            return band.single
    return None


def statistical_variance(frame: pd.DataFrame) -> Array:
    """Variance of ln mu from the 90 % interval of the time mean of each case; 0 without an interval."""
    half_width = frame["statistical_error"].to_numpy(dtype=float)
    return np.asarray(np.nan_to_num(half_width, nan=0.0) / NORMAL_90) ** 2


def expected_rows(frame: pd.DataFrame) -> pd.DataFrame:
    """One row for each point with the means over its roughness profiles, the expected friction of a finish.

    frame: usable rows of a dataset, sorted by key.
    Returns: the first row of each point with its outputs replaced by means, with the columns `realisations`, the number
    of profiles, and `noise_variance`, the variance of ln mu: the scatter of single profiles in the band of lambda over
    their number, or `statistical_variance` without repeated points. Errors are root mean squares over the profiles; the
    part of the time means is independent between them and decreases with the root of their number.
    """
    group = frame.groupby(_SAME, dropna=False, sort=False).ngroup().to_numpy()
    first = ~pd.Series(group).duplicated().to_numpy()
    count = np.bincount(group)[group[first]]
    rows = frame[first].reset_index(drop=True)
    scatter = realisation_scatter(frame)
    if scatter.empty:
        return rows.assign(realisations=1, noise_variance=statistical_variance(rows))
    means = frame[[name for name in _AVERAGED if name in frame]].groupby(group, sort=False).mean()
    rows[means.columns] = means.to_numpy()
    statistical = frame["statistical_error"].fillna(0.0).pow(2)
    # of the mesh and the model, common to all profiles; nan if no profile has an error
    common = (frame["friction_error"].pow(2) - statistical).clip(lower=0.0).groupby(group, sort=False).mean().to_numpy()
    independent = statistical.groupby(group, sort=False).mean().to_numpy() / count
    rows["friction_error"], rows["statistical_error"] = np.sqrt(common + independent), np.sqrt(independent)
    place = np.searchsorted(_SCATTER_EDGES, scatter["film_ratio"].to_numpy(dtype=float), side="right")
    squared = scatter["single"].to_numpy(dtype=float) ** 2
    band = np.full(len(_SCATTER_EDGES) + 1, float(squared.mean()))
    for number in np.unique(place):
        if np.sum(place == number) >= _MIN_POINTS:
            band[number] = squared[place == number].mean()
    single = band[np.searchsorted(_SCATTER_EDGES, rows["film_ratio"].to_numpy(dtype=float), side="right")]
    return rows.assign(realisations=count, noise_variance=single / count)


def rms(values: pd.Series[float] | NDArray[np.float64]) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.asarray(values, dtype=float) ** 2)))


Results = Dataset | str | PathLike[str] | Sequence[Dataset | str | PathLike[str]]

# largest relative error of a fitted case. A lower limit would select cases by their result: profiles with high asperity
# friction have the smaller relative error (a limit of 0.1 increased the friction along gear meshes by 20 %)
MAX_ERROR = 1.0
MAX_POINTS = 100_000  # largest number of fitted points; more need memory but do not improve the fit
_FEWEST_DRAWN = 64  # rows from which an interval is determined
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


def drawn_rows(frame: pd.DataFrame) -> NDArray[np.bool_]:
    """Mask of the rows whose held-out errors count: those drawn in the ranges of a plan, all rows with few of these.

    Points of a table may be chosen where a formula is uncertain: with their errors the intervals would be too wide.
    """
    drawn = (frame["origin"] != "table").to_numpy()
    return drawn if drawn.sum() >= _FEWEST_DRAWN else np.ones(len(frame), dtype=bool)


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
