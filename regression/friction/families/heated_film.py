"""A heated Ree-Eyring film over a line contact and the load share of asperities in it, in closed form (ours).

The stress is taken at the mean pressure of the line contact.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ehl.fluid.conductivity import PAO
from ehl.fluid.viscosity import ROELANDS_LOG_VISCOSITY
from ehl.surface.roughness import EP_FILM
from regression.friction.conditions import MIN_ROUGHNESS, Array, Conditions, flattening

# steel: sqrt(46 W/(m K) * 7830 kg/m3 * 465 J/(kg K))
EFFUSIVITY = 12941.4
CAP_ORDER = 8.0
# of fits to both shipped oils: free they came out alike, or could not be told from the coefficients that stayed
INLET_SLIDING, INLET_SLIDING_POWER, INLET_HEAT, INLET_LOAD, INLET_POWER = 2.0, 1.7, 0.9, 0.15, 0.6
# of 1024 smooth contacts of each shipped oil, which leave 2.0 and 2.5 % with them
HEAT_FILM, HEAT_FLASH, HEAT_POWER, RELIEF_POWER = 1.8, 1.15, 0.75, 2.0 / 3.0
_MAX_EXPONENT = 300.0  # of an exponent
_THICK = 3.0  # lambda from which the roughness leaves no trace in the film's friction
# of fits to both shipped oils, where they came out alike
SLOPE_POWER = 0.75  # of lc/Rq
_PRESSURE, _PRESSURE_POWER, _SLIDING_POWER = 0.005, 0.4, 0.2  # of the sharpness j; p_h/E' of 1.1 GPa on steel
_ACROSS = 0.15  # |s|/(1 + SR) at which sliding across the line counts


def heated_film(c: Conditions, k: Mapping[str, float]) -> Array:
    """Central film: the isothermal one over what inlet heating takes away [m].

    h = h0/(1 + inlet (1 + 2 SR^1.7) L^0.9 M^0.15)^0.6 with the thermal loading
    L = eta0 beta u^2/k and M = W (2U)^-1/2; the form is that of the published inlet factors (Murch & Wilson, Gupta).
    """
    speed = np.abs(c["speed_entrainment"])
    loading = c["viscosity_inlet"] * c["temperature_viscosity"] * speed**2 / c["thermal_conductivity"]
    scale = c["effective_modulus"] * c["radius_equivalent"]
    load = c["load_per_length"] / scale / np.sqrt(2.0 * c["viscosity_inlet"] * speed / scale)
    sliding = 1.0 + INLET_SLIDING * c["slide_to_roll_total"] ** INLET_SLIDING_POWER
    factor = 1.0 + k["inlet"] * sliding * loading**INLET_HEAT * load**INLET_LOAD
    return np.asarray(c["film_formula"] / factor**INLET_POWER)


def film_friction(c: Conditions, k: Mapping[str, float], film: Array, ripple: Array | float = 0.0) -> Array:
    """Friction of the heated film; at most Lambda.

    A film as thick as the Hertz depth b^2/R carries the load with less pressure over a wider band (`relief_thick`).
    The viscosity between ambient and mean pressure is that of the modulus law through both. The stress tau0 asinh(x)
    falls with the temperature it makes itself: tau = tau0 a/(1 + theta tanh a)^0.75 with a = asinh x and
    theta = tau0 beta dT/tau from the film and both surfaces. beta rises with pressure as that of Roelands does, times
    `heat_pressure`, a property of the oil (near 0 where its pressure-viscosity falls with temperature). Under pressure
    the film conducts as `PAO` whatever the card says, 5 % apart at most. The cap is a smooth minimum.

    Parameters
    ----------
    c, k : mapping
        Conditions and coefficients.
    film : array
        [m].
    ripple : array
        Relative rise of the mean viscosity by pressures that ripple, where the film shears as a Newtonian one.
    """
    mean = 0.25 * np.pi * c["pressure_hertz"]
    speed, sliding, stress = np.abs(c["speed_entrainment"]), c["speed_sliding"], c["eyring_stress"]
    viscosity, beta = c["viscosity_inlet"], c["temperature_viscosity"]
    rise = np.log(c["viscosity_mean_pressure"] / viscosity)
    # modulus law g(p) = p/(c0 + c1 p) through slope alpha at 0 and `rise` at the mean pressure
    bend = rise / np.maximum(c["pressure_viscosity"] * mean, 1e-9)
    thick = c["film_formula"] * c["radius_equivalent"] / c["half_width"] ** 2
    # load = pressure times width: what the one loses the other gains
    relief = (1.0 + k["relief_thick"] * thick) ** RELIEF_POWER
    ratio = 0.5 * np.abs(c["slide_to_roll"])
    surfaces = 0.5 * (np.sqrt(1.0 + ratio) + np.sqrt(np.abs(1.0 - ratio)))
    flash = HEAT_FLASH * np.sqrt(c["half_width"] * relief / speed) / (EFFUSIVITY * surfaces)
    pole = np.maximum(np.log(viscosity) + ROELANDS_LOG_VISCOSITY, 1.0)
    local = 1.0 / relief
    exponent = np.minimum(rise * local / (bend * (1.0 - local) + local), 300.0)
    pressure = local * mean
    conductivity = PAO(pressure, c["thermal_conductivity"])
    strain = k["strain"] * viscosity * np.exp(exponent) * sliding / (stress * film)
    strain = strain * (1.0 + ripple / (1.0 + strain))
    isothermal = np.arcsinh(strain)
    resistance = sliding * (HEAT_FILM * film / (8.0 * conductivity) + flash)
    heat = beta * (1.0 + k["heat_pressure"] * exponent / pole) * stress * resistance
    shear = stress * isothermal / (1.0 + heat * np.tanh(isothermal)) ** HEAT_POWER
    limit = np.maximum(c["limiting_shear_coefficient"] * pressure, 1e-9)
    capped = shear * (1.0 + (shear / limit) ** CAP_ORDER) ** (-1.0 / CAP_ORDER)
    return np.asarray(relief * capped / mean)


FILM_EQUATION = (
    "heat = beta (1 + heat_pressure g/(ln eta0 + 9.67)) tau0 v_s (1.8 h/(8 k_i) + 1.15 (r b/u_r)^0.5/(e m)),"
    " k_i = k (1 + 1.4 p_i/(1 + 0.34 p_i)) with p_i in GPa, m = ((1 + |s|/2)^0.5 + |1 - |s|/2|^0.5)/2;"
    " V = ripple/(1 + (h/(3 Rq))^4);"
    " h = h0/(1 + inlet (1 + 2 SR^1.7) (eta0 beta u_r^2/k)^0.9 M^0.15)^0.6"
    " with h0 the film of Moes (1992) over the density ratio of Dowson & Higginson at p_h, M = W (2U)^-1/2;"
    " eta_p the viscosity at p, e = 12941.4 W s^0.5/(m2 K);"
    " tau0, Lam, alpha, beta, k of the oil at inlet temperature; SI units"
)


def asperity_share(c: Conditions, film: Array, k: Mapping[str, float]) -> Array:
    """Load share of the asperities under a film [m], X = 1/(1 + Q^j).

    Q = squeeze (h'/h_b)^n exp(squeeze_tail (h'/Rq)^2) P^(squeeze_flattening exp(-h/Rq)) (1 + slide A)
    g/(g + lay/P)/(1 + narrow P^2 lc/b)

    The film is measured by the boundary film h_b = 30 nm of extreme-pressure additives: it, and not Rq, decides which
    film the asperities reach through. The
    exponent n = squeeze_film (0.01 lc/Rq)^0.75 (1 + lc/b)^squeeze_width says how suddenly they do: flatter
    roughness touches more evenly. P = p_h lc/(0.5 E' Rq) is the pressure over the one that flattens the roughness,
    which matters where films are thin. Sliding s across the line makes films between asperities, A = |s|/(0.15 (1 +
    SR)); marks across the motion (Peklenik number gamma above 1) hold the oil, marks along it let it out,
    g = gamma^(2/(1 + lc/b)), less where a wave is as long as the contact is wide; such waves lift it
    (h' = h (1 + whole lc/b)) and are squeezed as a whole (narrow). Touching sets in more sharply under pressure and
    where the roughness slides across: j = (p_h/(0.005 E'))^0.4 (1 + A)^0.2.
    """
    rough = np.maximum(c["roughness_rms"], MIN_ROUGHNESS)
    length = c["correlation_length"]
    waves = length / c["half_width"]
    pressed = flattening(c)
    lifted = film * (1.0 + k["whole"] * waves)
    across = np.abs(c["slide_to_roll"]) / (_ACROSS * (1.0 + c["slide_to_roll_total"]))
    power = k["squeeze_film"] * (0.01 * length / rough) ** SLOPE_POWER * (1.0 + waves) ** k["squeeze_width"]
    log_resistance = (
        np.log(k["squeeze"])
        + power * np.log(lifted / EP_FILM)
        + k["squeeze_tail"] * (lifted / rough) ** 2
        + k["squeeze_flattening"] * np.exp(-film / rough) * np.log(pressed)
        + np.log1p(k["slide"] * across)
        - np.log1p(k["lay"] / (pressed * c["peklenik_number"] ** (2.0 / (1.0 + waves))))
        - np.log1p(k["narrow"] * pressed**2 * waves)
    )
    sharpness = (c["pressure_hertz"] / (_PRESSURE * c["effective_modulus"])) ** _PRESSURE_POWER
    sharpness = sharpness * (1.0 + across) ** _SLIDING_POWER
    return np.asarray(1.0 / (1.0 + np.exp(np.minimum(sharpness * log_resistance, _MAX_EXPONENT))))


def valley_film(c: Conditions, film: Array, k: Mapping[str, float]) -> Array:
    """Factor on the friction of the film: below lambda 1 most of it is sheared in valleys, deeper than its mean."""
    rough = np.maximum(c["roughness_rms"], MIN_ROUGHNESS)
    return np.asarray((1.0 + (rough / film) ** 2) ** (-0.5 * k["valleys"]))


def film_ripple(c: Conditions, film: Array, k: Mapping[str, float]) -> Array:
    """What the waves of the roughness add to the strain of the film they roll through."""
    ratio = film / np.maximum(c["roughness_rms"], MIN_ROUGHNESS)
    return np.asarray(k["ripple"] / (1.0 + (ratio / _THICK) ** 4))


SHARE_EQUATION = (
    "X = 1/(1 + Q^j); j = (p_h/(0.005 E'))^0.4 (1 + A)^0.2, A = |s|/(0.15 (1 + SR));"
    " Q = squeeze (h'/h_b)^n exp(squeeze_tail (h'/Rq)^2) P^(squeeze_flattening exp(-h/Rq)) (1 + slide A)"
    " g/(g + lay/P)/(1 + narrow P^2 lc/b), g = gamma^(2/(1 + lc/b));"
    " h' = h (1 + whole lc/b), h_b = 30 nm + (2.1 nm Rq)^0.5,"
    " P = p_h lc/(0.5 E' Rq), lc the correlation length of the roughness, gamma its Peklenik number, b the Hertz"
    " half-width, s = slide_to_roll across the line, SR = |v_s|/u_r;"
)
