"""Family `short`: friction of asperities and of a thermal film (own work).

`asperity_share` gives the load share of the asperities; the film has the rest at the mean pressure. The family is for
contacts with resolved roughness.
"""

from collections.abc import Mapping

import numpy as np

from regression.friction.conditions import Array, Conditions
from regression.friction.families import heated_film as film_form
from regression.friction.families.family import ROUGH_BOX, Family

_FILM_POWER = 1.5  # of the load share of the film, from fits to both shipped oils


def short_parts(c: Conditions, k: Mapping[str, float]) -> tuple[Array, Array]:
    """Asperity load share X, and friction of the film with the rest of the load."""
    hot = film_form.heated_film(c, k)
    share = film_form.asperity_share(c, hot, k)
    film = film_form.film_friction(c, k, hot, film_form.film_ripple(c, hot, k)) * film_form.valley_film(c, hot, k)
    return share, np.asarray(film * (1.0 - share) ** _FILM_POWER)


def short_log_mu(c: Conditions, k: Mapping[str, float], boundary_friction: float) -> Array:
    """ln mu of both parts."""
    share, film = short_parts(c, k)
    return np.asarray(np.log(share * boundary_friction + film))


# term: start, lower and upper bound
_TERMS: dict[str, tuple[float, float, float]] = {
    "strain": (0.8, 0.05, 20.0),
    "relief_thick": (0.3, 0.0, 3.0),
    "heat_pressure": (0.3, 0.0, 5.0),
    "inlet": (0.25, 0.0, 10.0),
    "ripple": (0.9, 0.0, 10.0),
    "valleys": (0.06, 0.0, 2.0),
    "squeeze": (4.0, 0.001, 1e3),
    "squeeze_film": (1.5, 0.1, 20.0),
    "squeeze_width": (0.5, 0.0, 5.0),
    "squeeze_tail": (0.7, 0.0, 20.0),
    "squeeze_flattening": (1.7, 0.0, 5.0),
    "slide": (0.7, 0.0, 100.0),
    "lay": (1.6, 0.0, 100.0),
    "whole": (0.2, 0.0, 10.0),
    "narrow": (6.0, 0.0, 100.0),
}
_EQUATION = (
    f"mu = X mu_b + (1 - X)^{_FILM_POWER:g} F; {film_form.SHARE_EQUATION}"
    f" n = squeeze_film (0.01 lc/Rq)^{film_form.SLOPE_POWER:g} (1 + lc/b)^squeeze_width;"
    " F = (1 + (Rq/h)^2)^(-valleys/2) r t (1 + (t/(Lam p/r))^8)^(-1/8)/p;"
    " t = tau0 a/(1 + heat tanh a)^0.75, a = asinh(x (1 + V/(1 + x))), x = strain eta v_s/(tau0 h);"
    " eta = eta0 exp(g), g = G y/(c (1 - y) + y), y = 1/r, r = (1 + relief_thick h0 R/b^2)^(2/3),"
    " G = ln(eta_p/eta0), c = G/(alpha p), p = pi p_h/4; p_i = p/r;"
    f" {film_form.FILM_EQUATION}"
)


_START, _LOWER, _UPPER = zip(*_TERMS.values(), strict=True)
SHORT = Family(
    "short",
    "asperities and thermal film, fifteen coefficients (this work)",
    _EQUATION,
    tuple(_TERMS),
    ROUGH_BOX,
    short_log_mu,
    start=_START,
    lower=_LOWER,
    upper=_UPPER,
    parts=short_parts,
)
