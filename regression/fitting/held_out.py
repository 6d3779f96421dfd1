"""Held-out friction behind a fitted formula: what its stated errors came from, for reports and figures."""

from __future__ import annotations

import numpy as np
import pandas as pd

from regression.data.dataset import Dataset
from regression.fitting.cross_validation import HeldOut, held_out_of
from regression.fitting.fit import usable_rows
from regression.friction.families import FAMILIES
from regression.friction.formula import Formula


def fitted_rows(dataset: Dataset, formula: Formula | None = None) -> pd.DataFrame:
    """The rows formulas are fitted to; with the corners where the formula was fitted to these too."""
    corners = formula is not None and not any("corner" in reason for reason in formula.data.excluded)
    return usable_rows(dataset, corners=corners)[0]


def held_out_friction(dataset: Dataset, formula: Formula) -> HeldOut:
    """Friction of the rows of `fitted_rows` by the same form fitted without their fold.

    At once for a formula this process has fitted; else it is cross-validated again.
    """
    frame, process = fitted_rows(dataset, formula), formula.residual
    return held_out_of(FAMILIES[formula.family], frame, gaussian_process=process is not None, start=process)


def process_factors(dataset: Dataset, formula: Formula) -> list[tuple[float, float, float]]:
    """exp(w s) of the interval of a formula with a Gaussian process, for each of its bands; none without.

    Returns
    -------
    list of (median, 5 %, 95 %)
        Over the held-out cases of the band: s is the process's deviation at each, w the multiple of the band.
    """
    deviation = held_out_friction(dataset, formula).deviation if formula.residual is not None else None
    if deviation is None:
        return []
    ratio = fitted_rows(dataset, formula)["film_ratio_formula"].to_numpy(dtype=float)
    factors = []
    for band in formula.interval.bands:
        inside = (ratio >= band.low) & (True if band.high is None else ratio < band.high)
        low, middle, high = np.quantile(np.exp(band.log_width * deviation[inside]), (0.05, 0.5, 0.95))
        factors.append((float(middle), float(low), float(high)))
    return factors
