"""Value and grid error from levels of one grading."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Extrapolation:
    """Richardson values of the outputs and their error estimates (absolute)."""

    values: Array
    errors: Array
    orders: Array


def extrapolate(levels: list[Array]) -> Extrapolation:
    """Second-order Richardson over grids n, 2n - 1, 4n - 3 (coarse to fine).

    The value is the extrapolation of the two finest; its error is judged by how far it moved from the extrapolation of
    the two coarser ones.
    """
    coarse, middle, fine = levels[-3:]
    value = fine + (fine - middle) / 3.0
    before = middle + (middle - coarse) / 3.0
    with np.errstate(divide="ignore", invalid="ignore"):
        orders = np.log2(np.abs((middle - coarse) / (fine - middle)))
    return Extrapolation(value, np.abs(value - before), orders)
