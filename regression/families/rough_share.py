"""Family `rough_share`: asperities between squeezed and sliding roughness, and a heated film (ours).

For contacts whose roughness was resolved: the transient solver shows what decides the load on the asperities at a given
film ratio. (1) Pressure that flattens the roughness, P = p_h lc/(E' Rq). (2) Sliding across the line: roughness that
slides past its partner generates films of its own, roughness that rolls along with it is squeezed all the way. Sliding
along the line does neither, so both enter with slide_to_roll and not with its total.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from regression.conditions import Array, Conditions
from regression.families.family import BOX, Family
from regression.families.heated_film import film_friction, heated_film

_LEAST_ROUGHNESS = 1e-12  # [m]
_THICK = 3.0  # lambda from which the roughness leaves no trace in the film's friction


def rough_share_parts(c: Conditions, k: Mapping[str, float]) -> tuple[Array, Array]:
    """Asperity load share X and friction of the film that carries the rest.

    X = 1/(1 + squeezed (1 + sliding)): `squeezed` is the resistance of films between asperities that stay opposite one
    another, `sliding` what their motion past one another adds; neither holds where the film is thinner than the
    boundary film, `touch` Rq. All grow with lambda, so that X falls from 1 to 0.
    """
    rough = np.maximum(c["roughness_rms"], _LEAST_ROUGHNESS)
    waves = c["half_width"] / c["correlation_length"] / 20.0
    # waves longer than the contact are shape to it, not roughness
    plain = c["film_formula"] / rough
    ratio = plain * (1.0 + k["narrow"] / (20.0 * waves))
    flattening = c["pressure_hertz"] * c["correlation_length"] / (c["effective_modulus"] * rough) / 0.3
    rise = np.maximum(np.log(c["viscosity_mean_pressure"] / c["viscosity_inlet"]), 1e-3) / 5.0
    across = np.abs(c["slide_to_roll"]) / 0.2
    squeezed = (
        np.log(k["squeeze"])
        + k["squeeze_film"] * np.log(ratio)
        + k["squeeze_tail"] * ratio
        + k["squeeze_pressure"] * np.log(flattening)
        + k["squeeze_waves"] * np.log(waves)
        + k["squeeze_viscosity"] * np.log(rise)
        - np.log1p((k["touch"] / plain) ** 3)
    )
    log_sliding = (
        k["slide_film"] * np.log(ratio)
        + k["slide_pressure"] * np.log(flattening)
        + k["slide_waves"] * np.log(waves)
        + k["slide_viscosity"] * np.log(rise)
        + k["slide_heat"] * np.log1p(c["slide_to_roll_total"])
    )
    sliding = k["slide"] * across ** k["slide_power"] * np.exp(np.minimum(log_sliding, 300.0))
    share = 1.0 / (1.0 + np.exp(np.minimum(squeezed, 300.0)) * (1.0 + sliding))
    ripple = k["ripple"] * waves ** k["ripple_waves"] / (1.0 + (ratio / _THICK) ** 4)
    return np.asarray(share), film_friction(c, k, heated_film(c, k), ripple)


def _rough_share_log(c: Conditions, k: Mapping[str, float], boundary_friction: float) -> Array:
    share, film = rough_share_parts(c, k)
    return np.asarray(np.log(share * boundary_friction + film * (1.0 - share) ** k["film_power"]))


# term: start, lower and upper bound
_TERMS: dict[str, tuple[float, float, float]] = {
    "stress": (1.03, 0.5, 2.0),
    "strain": (1.04, 0.1, 20.0),
    "relief": (0.11, 0.0, 3.0),
    "relief_thick": (0.08, 0.0, 3.0),
    "spread": (0.13, 0.0, 1.0),
    "heat_film": (1.5, 0.0, 5.0),
    "heat_flash": (0.85, 0.0, 5.0),
    "heat_pressure": (1.2, 0.0, 5.0),
    "heat_power": (0.68, 0.3, 1.5),
    "inlet": (0.22, 0.0, 3.0),
    "inlet_sliding": (1.5, 0.0, 10.0),
    "inlet_power": (0.7, 0.2, 3.0),
    "ripple": (0.55, 0.0, 3.0),
    "ripple_waves": (0.5, 0.0, 2.0),
    "film_power": (2.4, 1.0, 6.0),
    "squeeze": (1.2, 0.05, 100.0),
    "squeeze_film": (0.4, 0.0, 5.0),
    "squeeze_tail": (2.2, 0.0, 6.0),
    "squeeze_pressure": (1.4, 0.0, 5.0),
    "squeeze_waves": (0.0, -2.0, 2.0),
    "squeeze_viscosity": (-0.2, -3.0, 3.0),
    "touch": (0.08, 0.0, 0.5),
    "narrow": (2.0, 0.0, 10.0),
    "slide": (3.0, 0.0, 1e3),
    "slide_film": (1.7, 0.0, 8.0),
    "slide_pressure": (3.7, 0.0, 8.0),
    "slide_waves": (-0.4, -4.0, 4.0),
    "slide_viscosity": (-0.3, -4.0, 4.0),
    "slide_heat": (-3.2, -6.0, 6.0),
    "slide_power": (2.0, 0.2, 5.0),
}

_EQUATION = (
    "mu = X mu_b + (1 - X)^film_power F; X = 1/(1 + Q (1 + Z)); l = h0/Rq (1 + narrow lc/b);"
    " Q = squeeze l^squeeze_film exp(squeeze_tail l) P^squeeze_pressure B^squeeze_waves N^squeeze_viscosity"
    "/(1 + (touch Rq/h0)^3);"
    " Z = slide |s/0.2|^slide_power l^slide_film P^slide_pressure B^slide_waves N^slide_viscosity"
    " (1 + SR)^slide_heat; P = p_h lc/(0.3 E' Rq), B = b/(20 lc), N = G/5, s = slide_to_roll across the line,"
    " SR = |v_s|/u_r; F = (1 + spread T)^0.5 sum_i w_i t_i (1 + (t_i/(Lam p_i))^8)^(-1/8)/p over p_i = q_i p/r,"
    " q = 1.2594, 1.0977, 0.58446, w = 5/18, 8/18, 5/18; p = pi p_h/4; r = 1 + relief T^0.5 + relief_thick T,"
    " T = h0 R/b^2;"
    " t = stress tau0 a/(1 + heat tanh a)^heat_power, a = asinh(x (1 + V/(1 + x))), x = strain eta v_s/(tau0 h);"
    " eta = eta0 exp(g), g = G y/(c (1 - y) + y), y = p_i/p, G = ln(eta_p/eta0), c = G/(alpha p);"
    " heat = beta (1 + heat_pressure g/(ln eta0 + 9.67)) tau0 v_s"
    " (heat_film h/(8 k_i) + heat_flash (b/u_r)^0.5/(e m)), k_i = k (1 + 1.4 p_i/(1 + 0.34 p_i)) with p_i in GPa,"
    " m = ((1 + |s|/2)^0.5 + |1 - |s|/2|^0.5)/2; V = ripple B^ripple_waves/(1 + (l/3)^4);"
    " h = h0/(1 + inlet (1 + inlet_sliding SR^1.7) (eta0 beta u_r^2/k)^0.9 M^0.15)^inlet_power"
    " with h0 the film of Moes (1992) over the density ratio of Dowson & Higginson at p_h, M = W (2U)^-1/2,"
    " lc the correlation length of the roughness, eta_p the viscosity at p, b the Hertz half-width,"
    " e = 12941.4 W s^0.5/(m2 K); tau0, Lam, alpha, beta, k of the oil at inlet temperature; SI units"
)

ROUGH_SHARE = Family(
    "rough_share",
    "squeezed and sliding roughness over a heated Ree-Eyring film (ours)",
    _EQUATION,
    tuple(_TERMS),
    (*BOX, "correlation_length"),
    _rough_share_log,
    None,
    *(tuple(column) for column in zip(*_TERMS.values(), strict=True)),
)
