"""Result of the steady smooth solver."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ehl.smooth.newton import Level

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SteadyResult:
    """Smooth, steady line contact; SI units.

    ``film_central``, ``film_min``, ``pressure_max`` and ``friction_fluid`` are extrapolated over three grids and the
    ``*_error`` are relative estimates of the error of exactly these values (grid error). The profiles are those
    of the finest grid.

    Attributes
    ----------
    status : {"converged", "failed"}
    reason : str
        "" or the reason of the failure, one of `ehl.smooth.REASONS`.
    x, pressure, film, shear_stress : ndarray
        Profiles on the graded mesh [m, Pa, m, Pa]; x = 0 is the centre of the undeformed parabola.
    film_central, film_min : float
        h at x = 0 and the smallest h [m].
    pressure_max : float
        [Pa].
    friction_fluid : float
        Integral of the film shear along the sliding vector over w', from x_inlet to x_exit [-]. Never negative:
        the direction is that of the sliding.
    rolling_traction : float
        Integral of (h/2) dp/dx over w' from x_inlet to x_exit [-]; converges only like 1/|x_inlet|.
    flow : float
        Mass flow over (rho0 u_r) = rho/rho0 h where dp/dx = 0 [m].
    mass_residual, load_residual : float
        Largest imbalance of the flow over the flow, and of the load over the load.
    x_inlet : float
        Where the integrals of friction and rolling traction begin [m]. The mesh begins at x[0]; upstream of it the
        inlet is an open parabola, whose pressure, load and shear are taken in closed form (fully flooded).
    x_exit : float
        Where pressure and its gradient vanish [m].
    fallbacks, skipped : tuple of str
        What was done differently from the plain way, and what was left out and why.
    """

    status: Literal["converged", "failed"]
    reason: str
    x: Array
    pressure: Array
    film: Array
    shear_stress: Array
    film_central: float
    film_min: float
    pressure_max: float
    friction_fluid: float
    rolling_traction: float
    flow: float
    film_central_error: float
    film_min_error: float
    pressure_max_error: float
    friction_error: float
    iterations: int
    nodes: int
    mass_residual: float
    load_residual: float
    x_inlet: float
    x_exit: float
    fallbacks: tuple[str, ...] = ()
    skipped: tuple[str, ...] = ()
    coarse: Level | None = field(default=None, repr=False, compare=False)

    @property
    def film_error(self) -> float:
        """Relative error estimate of the films, the larger of both."""
        return max(self.film_central_error, self.film_min_error)
