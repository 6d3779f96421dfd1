"""Thermal conductivity of the film under pressure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Values = TypeVar("Values", float, Array)


@dataclass(frozen=True)
class FilmConductivity:
    """k/k0 = 1 + c1 p/(1 + c2 p), measured up to 1.1 GPa, extrapolated above.

    Larsson, R., Larsson, P. O., Eriksson, E., Sjöberg, M. & Höglund, E. (2000), Proc. IMechE J 214; form and constants
    read in public codes that cite the paper, not in the paper itself.

    Parameters
    ----------
    c1, c2 : float
        [1/Pa]; those of a polyalphaolefin where not given. Zeros keep the conductivity at its ambient value.

    Examples
    --------
    >>> round(FilmConductivity()(1e9, 0.14) / 0.14, 3)
    2.045
    """

    c1: float = 1.40e-9
    c2: float = 0.34e-9

    def __call__(self, pressure: Values, ambient: Any) -> Values:
        """Conductivity [W/(m K)] at pressure [Pa], from its value at ambient pressure."""
        found: Values = ambient * (1.0 + self.c1 * pressure / (1.0 + self.c2 * pressure))
        return found


PAO = FilmConductivity()
PARAFFINIC = FilmConductivity(1.72e-9, 0.54e-9)
CONDUCTIVITY_FAMILIES = {"pao": PAO, "mineral": PARAFFINIC}
