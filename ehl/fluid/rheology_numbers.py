"""Numbers of a shear law for the compiled loops; apart from those, so that a law can be described without compiling."""

from __future__ import annotations

import math
from typing import NamedTuple

NEWTONIAN, EYRING, CARREAU = range(3)
LARGE = 20.0  # of ln x: beyond it 1 + x^2 is x^2


class ShearNumbers(NamedTuple):
    """A shear law in scaled variables: stresses in a reference stress, pressure and film in the solver's units."""

    kind: int  # 0 newtonian, 1 eyring, 2 carreau
    plain: bool  # constant stress scale and a limit that only cuts off the traction: the solvers' short forms serve
    exponent: float  # of Carreau
    low: float  # stress scale: low + rise/2 (1 + tanh(steepness (p/centre - 1)))
    rise: float
    steepness: float
    centre: float
    ambient: float  # limiting stress: ambient + slope p; infinite without one
    slope: float
    smooth: bool  # the limit is approached gradually and takes part in the pressure flow
    plug: float  # 6 reference stress/(reference gradient times film unit), of the largest pressure flow


PLAIN = ShearNumbers(NEWTONIAN, True, 1.0, 1.0, 0.0, 1.0, 1.0, math.inf, 0.0, False, math.inf)
