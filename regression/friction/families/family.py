"""`Family`: equation, coefficients and bounds of a family of friction formulas."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from regression.friction.conditions import Array, Conditions


@dataclass(frozen=True)
class Family:
    """One form of the friction formula: linear in ln mu (`design`), or with both parts of mu (`parts`)."""

    name: str  # for `mixed-ehl fit --family`
    title: str  # one line for reports
    equation: str  # as text with all definitions
    terms: tuple[str, ...]  # names of the coefficients
    box: tuple[str, ...]  # variables with a checked range
    # columns X of the linear problem ln mu = X b, one per term; None for a nonlinear family
    design: Callable[[Conditions], Array] | None = None
    # start and bounds of the coefficients of a nonlinear family
    start: tuple[float, ...] = ()
    lower: tuple[float, ...] = ()
    upper: tuple[float, ...] = ()
    # asperity load share s and film friction f of mu = s mu_b + f; None for a linear family
    parts: Callable[[Conditions, Mapping[str, float]], tuple[Array, Array]] | None = None

    def log_mu(self, c: Conditions, coefficients: Mapping[str, float], boundary_friction: float | Array) -> Array:
        """ln mu; boundary friction has no effect on a linear family."""
        if self.design is not None:
            return np.asarray(self.design(c) @ np.array([coefficients[term] for term in self.terms]))
        assert self.parts is not None
        share, film = self.parts(c, coefficients)
        return np.asarray(np.log(share * boundary_friction + film))


BOX = (
    *("pressure_hertz", "radius_equivalent", "speed_entrainment", "slide_to_roll_total"),
    *("temperature_oil", "viscosity_inlet", "roughness_rms"),
)
# of families that depend on correlation length and lay
ROUGH_BOX = (*BOX, "correlation_length", "peklenik_number")
