"""What laws with a pole do near it: the law up to a stated place, from there on its tangent (ours)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def pole_growth(place: Array, last: float) -> tuple[Array, Array]:
    """g = y/(1 - y) and dg/dy, beyond `last` along the tangent there.

    Parameters
    ----------
    place : ndarray
        y [-]; the pole is at 1.
    last : float
        The last y that is taken as it is [-].
    """
    inside = np.minimum(place, last)
    slope = 1.0 / (1.0 - inside) ** 2
    return inside / (1.0 - inside) + slope * (place - inside), slope
