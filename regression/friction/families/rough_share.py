"""Family `rough_share`: asperities between squeezed and sliding roughness, and a heated film (ours).

For contacts whose roughness was resolved: the transient solver shows what decides the load on the asperities at a given
film ratio. (1) Pressure that flattens the roughness, P = p_h lc/(E' Rq): the flatter, the more suddenly asperities take
over as the film thins. (2) Sliding across the line: roughness that slides past its partner generates films of its own,
roughness that rolls along with it is squeezed all the way. (3) Shear and heat of all sliding, which thin those films.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from regression.friction.conditions import Array, Conditions
from regression.friction.families.family import BOX, Family
from regression.friction.families.heated_film import EFFUSIVITY, film_friction, heated_film

_MIN_ROUGHNESS = 1e-12  # [m]
_MIN_SLIDING = 1e-9  # [m/s]
_THICK = 3.0  # lambda from which the roughness leaves no trace in the film's friction
_MAX_EXPONENT = 300.0  # of an exponent
_FLAT = 20.0  # P/0.3 from which flatter roughness makes no sharper change (hardly any data beyond)


def rough_share_parts(c: Conditions, k: Mapping[str, float]) -> tuple[Array, Array]:
    """Asperity load share X and friction of the film that carries the rest.

    X = 1/(1 + squeezed (1 + sliding)): `squeezed` is the resistance of films between asperities that stay opposite one
    another, `sliding` what their motion past one another adds; neither holds where the film is thinner than the
    boundary film, `touch` Rq. X falls from 1 to 0 as lambda grows.
    """
    rough = np.maximum(c["roughness_rms"], _MIN_ROUGHNESS)
    waves = c["half_width"] / c["correlation_length"] / 20.0
    hot = heated_film(c, k)
    plain = hot / rough
    # waves longer than the contact are shape to it, not roughness
    ratio = plain * (1.0 + k["narrow"] / (20.0 * waves))
    flattening = c["pressure_hertz"] * c["correlation_length"] / (c["effective_modulus"] * rough) / 0.3
    hertz = c["pressure_hertz"] / (0.0045 * c["effective_modulus"])
    stress, entrainment = c["eyring_stress"], np.abs(c["speed_entrainment"])
    sliding_speed = np.maximum(c["speed_sliding"], _MIN_SLIDING)
    shear = c["viscosity_inlet"] * sliding_speed / (stress * rough) / 0.01
    # M of Moes: load over the square root of twice the speed group
    line = c["effective_modulus"] * c["radius_equivalent"]
    load = c["load_per_length"] / np.sqrt(2.0 * c["viscosity_inlet"] * entrainment * line) / 30.0
    power = k["squeeze_film"] * np.exp(
        k["film_hertz"] * np.log(hertz)
        + k["film_flattening"] * np.log(flattening / (1.0 + flattening / _FLAT))
        + k["film_load"] * np.log(load)
    )
    squeezed = (
        np.log(k["squeeze"])
        + power * np.log(ratio)
        + k["squeeze_tail"] * ratio * np.exp(k["tail_shear"] * np.log(shear))
        + k["squeeze_flattening"] * np.log(flattening)
        + k["squeeze_hertz"] * np.log(hertz)
        - np.log1p((k["touch"] / plain) ** 2)
    )
    rise = np.maximum(np.log(c["viscosity_mean_pressure"] / c["viscosity_inlet"]), 1e-3) / 5.0
    limit = c["limiting_shear_coefficient"] * c["pressure_hertz"] / stress / 10.0
    flash = c["temperature_viscosity"] * stress * sliding_speed * np.sqrt(c["half_width"] / entrainment) / EFFUSIVITY
    log_sliding = (
        k["slide_flattening"] * np.log(flattening)
        + k["slide_waves"] * np.log(waves)
        + k["slide_viscosity"] * np.log(rise)
        + k["slide_total"] * np.log1p(c["slide_to_roll_total"])
        + k["slide_shear"] * np.log(shear)
        + k["slide_limit"] * np.log(limit)
        + k["slide_flash"] * np.log1p(20.0 * flash)
    )
    across = np.abs(c["slide_to_roll"]) / 0.2
    sliding = k["slide"] * across ** k["slide_power"] * np.exp(np.minimum(log_sliding, _MAX_EXPONENT))
    share = 1.0 / (1.0 + np.exp(np.minimum(squeezed, _MAX_EXPONENT)) * (1.0 + sliding))
    ripple = k["ripple"] * waves ** k["ripple_waves"] / (1.0 + (ratio / _THICK) ** 4)
    film = film_friction(c, k, hot, ripple) * (1.0 - share) ** k["film_power"]
    return np.asarray(share), np.asarray(film)


def _rough_share_log(c: Conditions, k: Mapping[str, float], boundary_friction: float) -> Array:
    share, film = rough_share_parts(c, k)
    return np.asarray(np.log(share * boundary_friction + film))


# term: start, lower and upper bound
_TERMS: dict[str, tuple[float, float, float]] = {
    "stress": (1.0, 0.5, 2.0),
    "strain": (1.04, 0.1, 20.0),
    "relief": (0.11, 0.0, 3.0),
    "relief_thick": (0.08, 0.0, 3.0),
    "spread": (0.2, 0.0, 1.0),
    "heat_film": (2.0, 0.0, 5.0),
    "heat_flash": (1.0, 0.0, 5.0),
    "heat_pressure": (0.6, 0.0, 5.0),
    "heat_power": (0.7, 0.3, 1.5),
    "inlet": (0.3, 0.0, 3.0),
    "inlet_sliding": (2.0, 0.0, 10.0),
    "inlet_power": (0.6, 0.2, 3.0),
    "ripple": (0.6, 0.0, 3.0),
    "ripple_waves": (0.2, 0.0, 2.0),
    "film_power": (1.8, 1.0, 6.0),
    "narrow": (1.2, 0.0, 10.0),
    "touch": (0.11, 0.0, 0.5),
    "squeeze": (1.9, 0.01, 100.0),
    "squeeze_film": (0.84, 0.02, 5.0),
    "film_hertz": (-0.84, -3.0, 3.0),
    "film_flattening": (0.74, -2.0, 2.0),
    "film_load": (-0.25, -2.0, 2.0),
    "squeeze_tail": (1.7, 0.0, 6.0),
    "tail_shear": (-0.24, -2.0, 2.0),
    "squeeze_flattening": (2.0, 0.0, 5.0),
    "squeeze_hertz": (-0.84, -6.0, 6.0),
    "slide": (11.0, 0.0, 1e4),
    "slide_power": (2.1, 0.1, 5.0),
    "slide_flattening": (3.2, 0.0, 8.0),
    "slide_waves": (0.8, -4.0, 4.0),
    "slide_viscosity": (1.0, -6.0, 6.0),
    "slide_total": (-3.0, -9.0, 6.0),
    "slide_shear": (0.95, -4.0, 4.0),
    "slide_limit": (-3.4, -6.0, 6.0),
    "slide_flash": (-1.0, -6.0, 6.0),
}

_EQUATION = (
    "mu = X mu_b + (1 - X)^film_power F; X = 1/(1 + Q (1 + Z)); l = h/Rq (1 + narrow lc/b);"
    " Q = squeeze l^n exp(squeeze_tail l S^tail_shear) P^squeeze_flattening H^squeeze_hertz/(1 + (touch Rq/h)^2);"
    " n = squeeze_film H^film_hertz (P/(1 + P/20))^film_flattening (M/30)^film_load;"
    " Z = slide |s/0.2|^slide_power P^slide_flattening B^slide_waves N^slide_viscosity (1 + SR)^slide_total"
    " S^slide_shear (Lam p_h/(10 tau0))^slide_limit (1 + 20 beta tau0 v_s (b/u_r)^0.5/e)^slide_flash;"
    " P = p_h lc/(0.3 E' Rq), H = p_h/(0.0045 E'), S = eta0 v_s/(0.01 tau0 Rq), B = b/(20 lc), N = G/5,"
    " s = slide_to_roll across the line,"
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
    start=tuple(start for start, _, _ in _TERMS.values()),
    lower=tuple(lower for _, lower, _ in _TERMS.values()),
    upper=tuple(upper for _, _, upper in _TERMS.values()),
    parts=rough_share_parts,
)
