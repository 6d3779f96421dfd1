"""Slopes of ln mu for inputs that a friction formula does not contain, over the film ratio (own work).

The table was computed by `validation/input_sensitivities.py`: means over solved contacts in the range of gears.
"""

from __future__ import annotations

import csv
from functools import cache

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.common.data import data_path
from ehl.uncertainty.spread import Spread

FILE = "sensitivities.csv"
FILM_RATIOS = (0.1, 0.2, 0.4, 0.8, 1.6, 3.2)


@cache
def _slopes() -> dict[str, tuple[FloatArray, FloatArray, FloatArray]]:
    """For each input: ln of the film ratios, slopes of ln mu below and above the value."""
    rows: dict[str, list[tuple[float, ...]]] = {}
    with data_path(FILE).open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            numbers = tuple(float(row[name]) for name in ("film_ratio", "slope_below", "slope_above"))
            rows.setdefault(row["input"], []).append(numbers)
    return {name: (np.log(found[:, 0]), found[:, 1], found[:, 2]) for name, found in _arrays(rows)}


def _arrays(rows: dict[str, list[tuple[float, ...]]]) -> list[tuple[str, FloatArray]]:
    return [(name, np.array(sorted(found))) for name, found in rows.items()]


def stated_change(
    name: str, spread: Spread, film_ratio: FloatArray, score: float
) -> tuple[FloatArray, FloatArray] | None:
    """Change of ln mu with an input `score` standard deviations below and above; None for an input without a table.

    Linear in ln(film ratio) between the entries and constant beyond them. For smooth surfaces only the properties of
    the bodies have an effect.
    """
    if name not in _slopes():
        return None
    nodes, below, above = _slopes()[name]
    place = np.log(np.clip(film_ratio, 1e-6, 1e6))
    felt = np.where(np.isfinite(film_ratio) | (name in ("temperature_bulk", "conductivity_solid")), 1.0, 0.0)
    down, up = spread.shift(-score), spread.shift(score)
    return felt * down * np.interp(place, nodes, below), felt * up * np.interp(place, nodes, above)
