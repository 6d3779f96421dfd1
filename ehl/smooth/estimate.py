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

    def relative(self) -> Array:
        """Errors over the size of the values; zero where both vanish."""
        return self.errors / np.maximum(np.abs(self.values), 1e-300)


# An error of order h^3 left in the extrapolated value is 1/7 of its last change: the factor 2 on it, and the share of
# the last raw change that guards against accidental zeros, were chosen on one Sobol set of contacts and checked on
# others (validation/smooth_accuracy.py). The share falls with the sixth power of the mesh size from its value on the
# grids 49, 97, 193.
CHANGE_SHARE = 2.0 / 7.0
RAW_SHARE = 0.03
RAW_INTERVALS = 48
RAW_BOUNDS = (0.002, 0.1)
# With heat the order is less regular, and a change that is zero by accident says less: chosen on 128 contacts of the
# gear range and 128 of a far wider one.
HOT_CHANGE_SHARE, HOT_RAW_SHARE = 0.8, 0.2
FLOOR = 5e-7  # what ending the mesh in an open parabolic inlet leaves (measured against four times the length)


def extrapolate(levels: list[Array], coarsest: int, *, hot: bool = False) -> Extrapolation:
    """Second-order Richardson over grids n, 2n - 1, 4n - 3.

    The value is the extrapolation of the two finest. Its error is judged by how far it moved from the extrapolation
    of the two coarser ones.

    Parameters
    ----------
    levels : list of ndarray
        Outputs of the grids, coarse to fine; the last three count.
    coarsest : int
        Nodes of the coarsest of these three.
    hot : bool
        Whether each grid has its own heat balance.
    """
    coarse, middle, fine = levels[-3:]
    value = fine + (fine - middle) / 3.0
    before = middle + (middle - coarse) / 3.0
    change_share, share = CHANGE_SHARE, float(np.clip(RAW_SHARE * (RAW_INTERVALS / (coarsest - 1)) ** 6, *RAW_BOUNDS))
    if hot:
        change_share, share = HOT_CHANGE_SHARE, HOT_RAW_SHARE
    errors = change_share * np.abs(value - before) + share * np.abs(fine - middle) + FLOOR * np.abs(value)
    return Extrapolation(value, errors)
