"""Families `rough_share` and `short`: asperities that reach through a heated film (ours).

For contacts whose roughness was resolved: `asperity_share` gives the load the asperities carry, and the film carries
the rest. `rough_share` takes the friction of the film at three pressures of the Hertz ellipse, `short` at the mean
pressure, with two exponents fixed where they came out alike for both shipped oils.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from regression.friction.conditions import Array, Conditions
from regression.friction.families.family import ROUGH_BOX, Family
from regression.friction.families.heated_film import (
    FILM_EQUATION,
    MEAN,
    SHARE_EQUATION,
    SLOPE_POWER,
    asperity_share,
    film_friction,
    film_ripple,
    heated_film,
    valley_film,
)

_FILM_POWER = 1.5  # of the share of the film, in fits of `rough_share` to both shipped oils
Parts = Callable[[Conditions, Mapping[str, float]], tuple[Array, Array]]


def rough_share_parts(c: Conditions, k: Mapping[str, float]) -> tuple[Array, Array]:
    """Asperity load share X and friction of the film that carries the rest."""
    hot = heated_film(c, k)
    share = asperity_share(c, hot, k, k["squeeze_slope"])
    film = film_friction(c, k, hot, film_ripple(c, hot, k)) * valley_film(c, hot, k) * (1.0 - share) ** k["film_power"]
    return share, np.asarray(film)


def short_parts(c: Conditions, k: Mapping[str, float]) -> tuple[Array, Array]:
    """As `rough_share_parts`, of the family `short`."""
    hot = heated_film(c, k)
    share = asperity_share(c, hot, k)
    film = film_friction(c, k, hot, film_ripple(c, hot, k), MEAN) * valley_film(c, hot, k)
    return share, np.asarray(film * (1.0 - share) ** _FILM_POWER)


# term: start, lower and upper bound
_TERMS: dict[str, tuple[float, float, float]] = {
    "strain": (0.8, 0.1, 20.0),
    "relief_thick": (0.3, 0.0, 3.0),
    "heat_pressure": (0.3, 0.0, 5.0),
    "inlet": (0.25, 0.0, 10.0),
    "ripple": (0.9, 0.0, 10.0),
    "valleys": (0.06, 0.0, 2.0),
    "film_power": (1.45, 0.5, 6.0),
    "squeeze": (4.0, 0.001, 1e3),
    "squeeze_film": (1.5, 0.1, 20.0),
    "squeeze_slope": (SLOPE_POWER, 0.0, 2.0),
    "squeeze_width": (0.5, 0.0, 5.0),
    "squeeze_tail": (0.7, 0.0, 20.0),
    "squeeze_flattening": (1.7, 0.0, 5.0),
    "slide": (0.7, 0.0, 100.0),
    "lay": (1.6, 0.0, 100.0),
    "whole": (0.2, 0.0, 10.0),
    "narrow": (6.0, 0.0, 100.0),
}
_SHORT_TERMS = {term: box for term, box in _TERMS.items() if term not in ("film_power", "squeeze_slope")}
_SHORT_TERMS["strain"] = (0.8, 0.05, 20.0)

_EQUATION = (
    f"mu = X mu_b + (1 - X)^film_power F; {SHARE_EQUATION} n = squeeze_film (0.01 lc/Rq)^squeeze_slope"
    " (1 + lc/b)^squeeze_width; F = (1 + (Rq/h)^2)^(-valleys/2) r sum_i w_i t_i"
    " (1 + (t_i/(Lam p_i))^8)^(-1/8)/p over p_i = q_i p/r, q = 1.2593, 1.0976, 0.58454, w = 5/18, 8/18, 5/18;"
    " p = pi p_h/4; r = (1 + relief_thick h0 R/b^2)^(2/3);"
    " t = tau0 a/(1 + heat tanh a)^0.75, a = asinh(x (1 + V/(1 + x))), x = strain eta v_s/(tau0 h);"
    " eta = eta0 exp(g), g = G y/(c (1 - y) + y), y = p_i/p, G = ln(eta_p/eta0), c = G/(alpha p);"
    f" {FILM_EQUATION}"
)
_SHORT_EQUATION = (
    f"mu = X mu_b + (1 - X)^{_FILM_POWER:g} F; {SHARE_EQUATION}"
    f" n = squeeze_film (0.01 lc/Rq)^{SLOPE_POWER:g} (1 + lc/b)^squeeze_width;"
    " F = (1 + (Rq/h)^2)^(-valleys/2) r t (1 + (t/(Lam p/r))^8)^(-1/8)/p;"
    " t = tau0 a/(1 + heat tanh a)^0.75, a = asinh(x (1 + V/(1 + x))), x = strain eta v_s/(tau0 h);"
    " eta = eta0 exp(g), g = G y/(c (1 - y) + y), y = 1/r, r = (1 + relief_thick h0 R/b^2)^(2/3),"
    " G = ln(eta_p/eta0), c = G/(alpha p), p = pi p_h/4; p_i = p/r;"
    f" {FILM_EQUATION}"
)


def _family(
    name: str, title: str, equation: str, terms: Mapping[str, tuple[float, float, float]], parts: Parts
) -> Family:
    def log_mu(c: Conditions, k: Mapping[str, float], boundary_friction: float) -> Array:
        share, film = parts(c, k)
        return np.asarray(np.log(share * boundary_friction + film))

    start, lower, upper = zip(*terms.values(), strict=True)
    return Family(name, title, equation, tuple(terms), ROUGH_BOX, log_mu, None, start, lower, upper, parts)


ROUGH_SHARE = _family(
    "rough_share",
    "asperities that reach through a heated Ree-Eyring film (ours)",
    _EQUATION,
    _TERMS,
    rough_share_parts,
)
SHORT = _family(
    "short",
    "asperities over a heated film, fifteen coefficients (ours)",
    _SHORT_EQUATION,
    _SHORT_TERMS,
    short_parts,
)
