"""Errors of a fit over all cases and by region, and the interval from them."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ehl.common.numbers import finite_or_none
from regression.fitting.noise import BANDS, band_noise
from regression.fitting.rows import computed_friction
from regression.friction.conditions import Array
from regression.friction.error_tables import Band, ErrorInterval, NoiseFloor, Scores, WidthBand, WorstCase

INTERVAL_LEVEL = 0.9
_MIN_IN_BAND = 20  # smallest number of held-out cases of a band with its own interval


def scores(frame: pd.DataFrame, predicted: Array) -> Scores:
    """Errors of predicted friction compared with computed friction over all rows."""
    mu = computed_friction(frame)
    relative = predicted / mu - 1.0
    worst = int(np.argmax(np.abs(relative)))
    names = ("pressure_hertz", "radius_equivalent", "speed_entrainment", "slide_to_roll_total", "temperature_oil")
    case = {name: float(frame[name].iloc[worst]) for name in (*names, "roughness_rms", "friction_coefficient")}
    return Scores(
        count=len(mu),
        r2=_r2(mu, predicted),
        r2_log=_r2(np.log(mu), np.log(predicted)),
        rmse=_rms(predicted - mu),
        rmse_log=_rms(np.log(predicted / mu)),
        mape=float(np.mean(np.abs(relative))),
        p95=float(np.quantile(np.abs(relative), 0.95)),
        largest=float(np.abs(relative).max()),
        bias=float(np.mean(relative)),
        worst=WorstCase(key=str(frame["key"].iloc[worst]), relative_error=float(relative[worst]), conditions=case),
    )


def _r2(observed: Array, predicted: Array) -> float:
    total = float(np.sum((observed - observed.mean()) ** 2))
    return 1.0 - float(np.sum((observed - predicted) ** 2)) / total if total > 0.0 else 0.0


def bands(
    frame: pd.DataFrame, predicted: Array, covered: NDArray[np.bool_] | None = None, noise: NoiseFloor | None = None
) -> tuple[Band, ...]:
    """Errors by region (lambda, SR, pressure, temperature), without empty bands."""
    mu = computed_friction(frame)
    relative = predicted / mu - 1.0
    result = []
    for variable, edges in BANDS.items():
        values = frame[variable].to_numpy(dtype=float)
        finite = values[np.isfinite(values)]
        if not finite.size:
            continue
        limits = (float(finite.min()), *(e for e in edges if finite.min() < e < finite.max()), float(finite.max()))
        for low, high in itertools.pairwise(limits):
            inside = (values >= low) & ((values < high) | ((high == limits[-1]) & (values <= high)))
            if inside.any():
                error = np.abs(relative[inside])
                result.append(
                    Band(
                        variable=variable,
                        low=low,
                        high=high,
                        count=int(inside.sum()),
                        r2=_r2(mu[inside], predicted[inside]),
                        rmse=_rms(predicted[inside] - mu[inside]),
                        rmse_log=_rms(np.log(predicted[inside] / mu[inside])),
                        mape=float(error.mean()),
                        p95=float(np.quantile(error, 0.95)),
                        largest=float(error.max()),
                        bias=float(relative[inside].mean()),
                        coverage=None if covered is None else float(covered[inside].mean()),
                        noise=band_noise(noise, variable, low),
                    )
                )
    return tuple(result)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def interval_of(
    frame: pd.DataFrame,
    error: Array,
    folds: NDArray[np.int64] | None = None,
    *,
    deviation: Array | None = None,
    extrapolated: NDArray[np.bool_] | None = None,
) -> ErrorInterval:
    """ErrorInterval from the held-out errors of ln mu by bands of lambda (Mondrian), on which the errors depend most.

    frame: the fitted rows.
    error (n,): held-out absolute error of ln mu.
    folds (n,): folds of the rows, for the coverage of every band with widths from the other folds.
    deviation (n,): held-out standard deviation of ln mu by the formula; widths are then multiples of it.
    extrapolated (n,): rows outside the range of the cases of the other folds, for the error of extrapolation.
    """
    ratio = frame["film_ratio_formula"].to_numpy(dtype=float)
    score = error if deviation is None else error / deviation
    widths = _band_widths(ratio, score)
    if folds is not None:
        covered = covered_by_other_folds(ratio, score, folds)
        widths = tuple(
            band.model_copy(update={"coverage": float(covered[_inside(band, ratio)].mean())}) for band in widths
        )
    outer = error if extrapolated is None or extrapolated.sum() < _MIN_IN_BAND else error[extrapolated]
    return ErrorInterval(
        level=INTERVAL_LEVEL,
        log_width=conformal_width(score, INTERVAL_LEVEL),
        largest=float(error.max()),
        bands=widths,
        normalised=deviation is not None,
        near=conformal_width(outer, INTERVAL_LEVEL),
    )


def _band_widths(ratio: Array, error: Array) -> tuple[WidthBand, ...]:
    widths = []
    for low, high in itertools.pairwise((0.0, *BANDS["film_ratio"], math.inf)):
        inside = (ratio >= low) & (ratio < high if math.isfinite(high) else True)
        count = int(np.count_nonzero(inside))
        if count >= _MIN_IN_BAND:
            end = finite_or_none(high)
            width = conformal_width(error[inside], INTERVAL_LEVEL)
            widths.append(WidthBand(low=low, high=end, count=count, log_width=width))
    return tuple(widths)


def _inside(band: WidthBand, ratio: Array) -> NDArray[np.bool_]:
    return np.asarray((ratio >= band.low) & (True if band.high is None else ratio < band.high))


def covered_by_other_folds(ratio: Array, error: Array, folds: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether each held-out error lies within the width of its band from the errors of the other folds."""
    covered = np.zeros(len(error), dtype=bool)
    for number in np.unique(folds):
        held = folds == number
        width = np.full(len(error), conformal_width(error[~held], INTERVAL_LEVEL))
        for band in _band_widths(ratio[~held], error[~held]):
            width[_inside(band, ratio)] = band.log_width
        covered[held] = error[held] <= width[held]
    return covered


def conformal_width(error: Array, level: float) -> float:
    """The smallest width that covers ceil((n + 1) level) of n held-out errors (split conformal)."""
    rank = min(math.ceil((len(error) + 1) * level), len(error))
    return float(np.sort(error)[rank - 1])


def noise_floor(frame: pd.DataFrame) -> float:
    """RMS of the relative friction error of the solver, a lower limit for the error of a formula; 0 if unknown."""
    stated = frame["friction_error"].to_numpy(dtype=float)
    stated = stated[np.isfinite(stated)]
    return float(np.sqrt(np.mean(stated**2))) if stated.size else 0.0
