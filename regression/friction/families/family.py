"""What a family of friction formulas is: its equation, its coefficients and their bounds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from regression.friction.conditions import Array, Conditions


@dataclass(frozen=True)
class Family:
    """One form of the friction formula.

    Parameters
    ----------
    name : str
        What `mixed-ehl fit --family` takes.
    title : str
        One line for reports.
    equation : str
        The equation in words a reader can type into a calculator.
    terms : tuple of str
        Names of the coefficients.
    box : tuple of str
        Variables whose range the formula states and checks.
    log_mu : callable
        ln mu from conditions, coefficients and boundary friction.
    design : callable or None
        Columns of the linear problem ln mu = X b, one per term; None where the family is nonlinear.
    start, lower, upper : tuple of float
        Start and bounds of the coefficients of a nonlinear family.
    parts : callable or None
        Asperity load share and the friction of the film, which with the share times mu_b adds up to mu; given where
        the fit is to meet both parts.
    """

    name: str
    title: str
    equation: str
    terms: tuple[str, ...]
    box: tuple[str, ...]
    log_mu: Callable[[Conditions, Mapping[str, float], float], Array]
    design: Callable[[Conditions], Array] | None = None
    start: tuple[float, ...] = ()
    lower: tuple[float, ...] = ()
    upper: tuple[float, ...] = ()
    parts: Callable[[Conditions, Mapping[str, float]], tuple[Array, Array]] | None = None


BOX = (
    "pressure_hertz",
    "radius_equivalent",
    "speed_entrainment",
    "slide_to_roll_total",
    "temperature_oil",
    "viscosity_inlet",
    "roughness_rms",
)
# of the families that know how the roughness lies
ROUGH_BOX = (*BOX, "correlation_length", "peklenik_number")
