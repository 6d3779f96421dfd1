"""Noise floor: what mu scatters over repeated realisations of the roughness at otherwise equal conditions."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from regression.data.row_format import SURFACE_UNITS
from regression.friction.conditions import LUBRICANT_UNITS, STATE_UNITS, Array
from regression.friction.error_tables import NoiseBand, NoiseFloor

# edges of the bands errors are reported in; outer bands are open
BANDS: dict[str, tuple[float, ...]] = {
    "film_ratio": (0.5, 1.0, 2.0),
    "slide_to_roll_total": (0.05, 0.2, 0.5, 1.0),
    "pressure_hertz": (0.7e9, 1.0e9, 1.5e9),
    "temperature_oil": (333.15, 353.15, 373.15),
}
_SAME = [*STATE_UNITS, *LUBRICANT_UNITS, *(name for name in SURFACE_UNITS if name != "seed"), "oil"]


def realisation_scatter(frame: pd.DataFrame) -> pd.DataFrame:
    """Scatter of every point that was computed with more than one roughness seed.

    Parameters
    ----------
    frame : DataFrame
        Rows of a dataset.

    Returns
    -------
    DataFrame
        One row per point: the variables of `BANDS`, `realisations` k, the relative standard deviation of one
        realisation `single` (k - 1 degrees of freedom), and that of their mean, `mean` = single/sqrt(k).
    """
    usable = frame[(frame["status"] != "failed") & (frame["friction_coefficient"] > 0.0)]
    usable = usable.drop_duplicates([*dict.fromkeys(_SAME), "seed"])
    grouped = usable.groupby(list(dict.fromkeys(_SAME)), dropna=False, sort=True)
    points = grouped[list(BANDS)].mean() if not usable.empty else pd.DataFrame(columns=list(BANDS))
    # a key that is also a variable of a band would stand there twice
    points = points.reset_index(drop=True)
    mu = grouped["friction_coefficient"].agg(["count", "mean", "std"]).reset_index(drop=True)
    scatter = points.assign(realisations=mu["count"], single=mu["std"] / mu["mean"])
    scatter = scatter[scatter["realisations"] >= 2].reset_index(drop=True)
    return scatter.assign(mean=scatter["single"] / np.sqrt(scatter["realisations"].to_numpy(dtype=float)))


def measured_noise(scatter: pd.DataFrame) -> NoiseFloor | None:
    """Noise floor by region, RMS over the points; None where no point was repeated."""
    if scatter.empty:
        return None
    bands = []
    for variable, edges in BANDS.items():
        place = np.searchsorted(edges, scatter[variable].to_numpy(dtype=float), side="right")
        for number in np.unique(place):
            inside = scatter[place == number]
            bands.append(
                NoiseBand(
                    variable=variable,
                    low=edges[number - 1] if number > 0 else None,
                    high=edges[number] if number < len(edges) else None,
                    count=len(inside),
                    single=_rms(inside["single"]),
                    mean=_rms(inside["mean"]),
                )
            )
    return NoiseFloor(
        points=len(scatter),
        realisations=float(scatter["realisations"].mean()),
        single=_rms(scatter["single"]),
        mean=_rms(scatter["mean"]),
        bands=tuple(bands),
    )


def band_noise(noise: NoiseFloor | None, variable: str, inside: float) -> float | None:
    """Scatter of one realisation in the band of a variable that holds a value; None where it was not measured."""
    if noise is None:
        return None
    for band in noise.bands:
        low = -math.inf if band.low is None else band.low
        high = math.inf if band.high is None else band.high
        if band.variable == variable and low <= inside < high:
            return band.single
    return None


def statistical_variance(frame: pd.DataFrame) -> Array:
    """Variance of ln mu that each case's own 90 % interval of the time mean stands for; 0 where none is stated."""
    half_width = frame["statistical_error"].to_numpy(dtype=float)
    return np.asarray(np.nan_to_num(half_width, nan=0.0) / 1.645) ** 2


def _rms(values: pd.Series[float] | NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(np.asarray(values, dtype=float) ** 2)))
