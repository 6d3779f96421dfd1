"""Family `short`: thirteen coefficients for a spreadsheet; asperities over a heated film at the mean pressure (ours).

The film laws of `rough_share` with most of their numbers fixed and one pressure in place of three, and a share of the
asperities that knows three things: the film ratio, the pressure that flattens the roughness, and sliding across the
line, which builds films between asperities.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from regression.friction.conditions import Array, Conditions
from regression.friction.families.family import BOX, Family
from regression.friction.families.heated_film import MEAN, film_friction, heated_film

_MIN_ROUGHNESS = 1e-12  # [m]
_THICK = 3.0  # lambda from which the roughness leaves no trace in the film's friction
_MAX_EXPONENT = 300.0
# of fits to both shipped oils, where they came out alike
_FIXED = {
    "stress": 1.0,
    "relief": 0.0,
    "spread": 0.0,
    "heat_pressure": 0.6,
    "heat_power": 0.9,
    "inlet_sliding": 2.0,
    "inlet_power": 0.6,
}


def short_parts(c: Conditions, k: Mapping[str, float]) -> tuple[Array, Array]:
    """Asperity load share X and friction of the film that carries the rest."""
    k = {**_FIXED, **k}
    rough = np.maximum(c["roughness_rms"], _MIN_ROUGHNESS)
    hot = heated_film(c, k)
    plain = hot / rough
    ratio = plain * (1.0 + k["narrow"] * c["correlation_length"] / c["half_width"])
    flattening = c["pressure_hertz"] * c["correlation_length"] / (c["effective_modulus"] * rough) / 0.3
    squeezed = (
        np.log(k["squeeze"])
        + k["squeeze_film"] * flattening * np.log(ratio)
        + k["squeeze_tail"] * ratio
        + k["squeeze_flattening"] * np.log(flattening)
        - np.log1p((k["touch"] / plain) ** 2)
    )
    across = np.abs(c["slide_to_roll"]) / 0.2 * flattening / (1.0 + c["slide_to_roll_total"])
    share = 1.0 / (1.0 + np.exp(np.minimum(squeezed, _MAX_EXPONENT)) * (1.0 + k["slide"] * across**2))
    ripple = k["ripple"] / (1.0 + (plain / _THICK) ** 4)
    return np.asarray(share), np.asarray((1.0 - share) * film_friction(c, k, hot, ripple, MEAN))


def _short_log(c: Conditions, k: Mapping[str, float], boundary_friction: float) -> Array:
    share, film = short_parts(c, k)
    return np.asarray(np.log(share * boundary_friction + film))


# term: start, lower and upper bound
_TERMS: dict[str, tuple[float, float, float]] = {
    "strain": (0.7, 0.05, 20.0),
    "relief_thick": (0.09, 0.0, 3.0),
    "ripple": (1.5, 0.0, 10.0),
    "heat_film": (1.2, 0.0, 8.0),
    "heat_flash": (0.5, 0.0, 6.0),
    "inlet": (0.5, 0.0, 6.0),
    "narrow": (0.1, 0.0, 3.0),
    "touch": (0.12, 0.0, 0.5),
    "squeeze": (1.0, 0.01, 100.0),
    "squeeze_film": (0.27, 0.0, 5.0),
    "squeeze_tail": (2.7, 0.0, 10.0),
    "squeeze_flattening": (1.6, 0.0, 5.0),
    "slide": (1.3, 0.0, 1e4),
}

_EQUATION = (
    "mu = X mu_b + (1 - X) F; X = 1/(1 + Q (1 + slide (|s| P/(0.2 (1 + SR)))^2));"
    " Q = squeeze l^(squeeze_film P) exp(squeeze_tail l) P^squeeze_flattening/(1 + (touch Rq/h)^2);"
    " l = h/Rq (1 + narrow lc/b); P = p_h lc/(0.3 E' Rq); s = slide_to_roll across the line, SR = |v_s|/u_r;"
    " F = t (1 + (t/(Lam p/r))^8)^(-1/8)/p; t = tau0 a/(1 + heat tanh a)^0.9, a = asinh(x (1 + V/(1 + x))),"
    " x = strain eta v_s/(tau0 h), V = ripple/(1 + (h/(3 Rq))^4);"
    " eta = eta0 exp(g), g = G y/(c (1 - y) + y), y = 1/r, r = 1 + relief_thick h0 R/b^2,"
    " G = ln(eta_p/eta0), c = G/(alpha p), p = pi p_h/4;"
    " heat = beta (1 + 0.6 g/(ln eta0 + 9.67)) tau0 v_s (heat_film h/(8 k_i) + heat_flash (b/u_r)^0.5/(e m)),"
    " k_i = k (1 + 1.4 p_i/(1 + 0.34 p_i)) with p_i = p/r in GPa, m = ((1 + |s|/2)^0.5 + |1 - |s|/2|^0.5)/2;"
    " h = h0/(1 + inlet (1 + 2 SR^1.7) (eta0 beta u_r^2/k)^0.9 M^0.15)^0.6 with h0 the film of Moes (1992) over the"
    " density ratio of Dowson & Higginson at p_h, M = W (2U)^-1/2, lc the correlation length of the roughness,"
    " eta_p the viscosity at p, b the Hertz half-width, e = 12941.4 W s^0.5/(m2 K);"
    " tau0, Lam, alpha, beta, k of the oil at inlet temperature; SI units"
)

SHORT = Family(
    "short",
    "asperities over a heated film, thirteen coefficients (ours)",
    _EQUATION,
    tuple(_TERMS),
    (*BOX, "correlation_length"),
    _short_log,
    start=tuple(start for start, _, _ in _TERMS.values()),
    lower=tuple(lower for _, lower, _ in _TERMS.values()),
    upper=tuple(upper for _, _, upper in _TERMS.values()),
    parts=short_parts,
)
