"""Error tables of a formula file: scores, bands, noise, intervals."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel
from regression.friction.conditions import Array

Finite = Annotated[float, ValueRange("")]
Positive = Annotated[float, ValueRange("", gt=0.0)]
Width = Annotated[float, ValueRange("", ge=0.0)]
Share = Annotated[float, ValueRange("", ge=0.0, le=1.0)]


class WorstCase(InputModel):
    """The case with the largest relative error."""

    key: str
    relative_error: Finite
    conditions: dict[str, Finite]


class Errors(InputModel):
    """Errors of predicted friction compared with computed friction; relative ones are (predicted - computed)/computed.

    `coverage` is the share of the cases within their interval, None if unknown.
    """

    count: int
    r2: Finite
    rmse: Finite
    rmse_log: Finite
    mape: Finite
    p95: Finite
    largest: Finite
    bias: Finite
    coverage: Share | None = None


class Scores(Errors):
    """Errors over all cases; `extrapolated` is the share of the cases outside the range of data, None if unknown."""

    r2_log: Finite
    worst: WorstCase
    extrapolated: Share | None = None


class Band(Errors):
    """Cross-validated errors within one band of one variable.

    `noise` is the relative standard deviation of one roughness realisation, None if unknown.
    """

    variable: str
    low: Finite
    high: Finite
    noise: Width | None = None


class NoiseBand(InputModel):
    """Relative standard deviation of mu over roughness realisations within one band, RMS of the points.

    `single` is that of one realisation, `mean` that of the mean of all realisations of a point.
    """

    variable: str
    low: Finite | None
    high: Finite | None
    count: int
    single: Width
    mean: Width


class NoiseFloor(InputModel):
    """Scatter of mu over repeated roughness realisations, a lower limit for the error of formulas of these data."""

    points: int
    realisations: Annotated[float, ValueRange("", ge=2.0)]
    single: Width
    mean: Width
    bands: tuple[NoiseBand, ...]


class WidthBand(InputModel):
    """Half width of the interval within one band of `film_ratio_formula` (low <= value < high).

    `coverage` is the share of the held-out cases of the band within widths calibrated on the other folds.
    """

    low: Finite
    high: Finite | None
    count: int
    log_width: Width
    coverage: Share | None = None

    @model_validator(mode="after")
    def _ordered(self) -> WidthBand:
        if self.high is not None and self.high <= self.low:
            raise InputError("high", self.high, f"above the low end {self.low:.6g}")
        return self

    def holds(self, film_ratio: Array) -> NDArray[np.bool_]:
        """Whether each film ratio lies in the band."""
        inside = film_ratio >= self.low
        return inside if self.high is None else inside & (film_ratio < self.high)


class ErrorInterval(InputModel):
    """Interval of the cross-validated error of ln mu: mu exp(-w) to mu exp(+w).

    `log_width` covers the share `level` of all held-out cases, that of a band the same share of its cases. There is no
    calibration outside the data: near them the width is at least that of the widest band, outside the range it grows
    with the distance, and far from the data it is `largest`, the largest error. With `normalised`, widths are multiples
    of the standard deviation by the networks of the formula. `of_means` is their ratio to those that cover single
    profiles: 1 without points of several profiles, whose mean is the friction of a finish. `other_oil` covers the same
    share of the cases of each oil with a formula fitted without it; None for fewer than three oils.
    """

    level: Annotated[float, ValueRange("", gt=0.0, lt=1.0)]
    log_width: Width
    largest: Width
    bands: tuple[WidthBand, ...] = ()
    normalised: bool = False
    near: Width = 0.0
    of_means: Width = 1.0
    other_oil: Width | None = None

    def width(self, film_ratio: Array, deviation: Array | None = None) -> Array:
        """Half width at every point: that of its band, or of all cases without a band.

        film_ratio: `film_ratio_formula` [-].
        deviation: standard deviation of ln mu by the formula; required for a normalised interval.
        """
        width = np.full_like(film_ratio, self.log_width)
        for band in self.bands:
            width = np.where(band.holds(film_ratio), band.log_width, width)
        return width * deviation if self.normalised and deviation is not None else width
