"""Family `load_share`: asperities and a heated Ree-Eyring film share the load as in the load-sharing model (ours)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy

from regression.friction.conditions import Array, Conditions
from regression.friction.families.family import BOX, Family

# steel: sqrt(46 W/(m K) * 7830 kg/m3 * 465 J/(kg K)); only scales the coefficient heat_flash
EFFUSIVITY = 12941.4
_CAP_ORDER = 8.0
# free in trials with our solver it came out at 0.7 to 0.8 and could not be told from the heat coefficients
HEAT_POWER = 0.75


def load_share_parts(c: Conditions, k: Mapping[str, float]) -> tuple[Array, Array]:
    """Asperity load share and film friction of the family `load_share`.

    A film as thick as the Hertz depth b^2/R spreads the load and relieves the viscosity of pressure (`relief`). The
    film heats and its stress falls: tau = tau_iso - tau0 beta dT with dT proportional to tau itself gives
    tau = tau_iso/(1 + heat groups); the solver's results follow it with the power `HEAT_POWER`. The cap
    mu_f <= Lambda is a smooth minimum. Roughness that the pressure flattens carries less (`share_flattening`): the
    deterministic solver shows it, the load-sharing model does not know it.
    """
    pressure = 0.25 * np.pi * c["pressure_hertz"]
    speed, sliding, stress = c["speed_entrainment"], c["speed_sliding"], c["eyring_stress"]
    beta, conductivity, film = c["temperature_viscosity"], c["thermal_conductivity"], c["film_formula"]
    inlet = (c["viscosity_inlet"] * beta * speed**2 / conductivity) ** 0.64
    film = film / (1.0 + k["inlet"] * (1.0 + 14.8 * c["slide_to_roll_total"] ** 0.83) * inlet)
    relief = 1.0 + k["relief"] * c["film_formula"] * c["radius_equivalent"] / c["half_width"] ** 2
    rise = np.log(c["viscosity_mean_pressure"] / c["viscosity_inlet"]) / relief
    strain = k["strain"] * c["viscosity_inlet"] * np.exp(rise) * sliding / (stress * film)
    isothermal = k["stress"] * stress / pressure * np.arcsinh(strain)
    heat_film = beta * stress * sliding * film / (8.0 * conductivity)
    heat_flash = beta * stress * sliding * np.sqrt(c["half_width"] / speed) / EFFUSIVITY
    fluid = isothermal / (1.0 + k["heat_film"] * heat_film + k["heat_flash"] * heat_flash) ** HEAT_POWER
    capped = fluid * (1.0 + (fluid / c["limiting_shear_coefficient"]) ** _CAP_ORDER) ** (-1.0 / _CAP_ORDER)
    flattening = c["pressure_hertz"] / 1e9 * 0.5e-6 / np.maximum(c["roughness_rms"], 1e-12)
    ratio = k["share_scale"] * c["film_ratio_formula"] * flattening ** k["share_flattening"]
    share = scipy.special.erfc(ratio ** k["share_power"])
    return np.asarray(share), np.asarray(capped)


def _load_share_log(c: Conditions, k: Mapping[str, float], boundary_friction: float) -> Array:
    share, fluid = load_share_parts(c, k)
    return np.asarray(np.log(share * boundary_friction + (1.0 - share) * fluid))


LOAD_SHARE = Family(
    "load_share",
    "load sharing of a heated Ree-Eyring film and asperities (ours)",
    "mu = X mu_b + (1 - X) F; X = erfc((share_scale (h0/Rq) g^share_flattening)^share_power);"
    " g = (p_h/1 GPa) (0.5 um/Rq);"
    " F = f (1 + (f/Lam)^8)^(-1/8); f = stress (tau0/p) asinh(strain eta v_s/(tau0 h))"
    " / (1 + heat_film beta tau0 v_s h/(8 k) + heat_flash beta tau0 v_s sqrt(b/u_r)/e)^0.75;"
    " eta = eta0 (eta_p/eta0)^(1/(1 + relief h0 R/b^2));"
    " h = h0/(1 + inlet (1 + 14.8 SR^0.83) (eta0 beta u_r^2/k)^0.64)"
    " with h0 the film of Moes (1992) over the density ratio of Dowson & Higginson at p_h, p = pi p_h/4,"
    " eta_p the viscosity at p, SR = |v_s|/u_r, b the Hertz half-width, e = 12941.4 W s^0.5/(m2 K);"
    " tau0, Lam, beta, k of the oil at inlet temperature; SI units",
    (
        "stress",
        "strain",
        "relief",
        "heat_film",
        "heat_flash",
        "inlet",
        "share_scale",
        "share_power",
        "share_flattening",
    ),
    BOX,
    _load_share_log,
    None,
    (1.0, 1.0, 0.05, 1.0, 1.0, 0.05, 1.0, 1.0, 0.0),
    (0.5, 0.1, 0.0, 0.0, 0.0, 0.0, 0.1, 0.3, -2.0),
    (2.0, 20.0, 1.0, 5.0, 5.0, 0.3, 10.0, 3.0, 2.0),
)
