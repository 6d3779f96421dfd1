"""Family `short`: friction of asperities and of a thermal film (own work).

`asperity_share` gives the load share of the asperities; the film has the rest at the mean pressure. The family is for
contacts with resolved roughness. The film is a closed form of a thermal Ree-Eyring film in a line contact, with the
shear stress at the mean pressure.
"""

from collections.abc import Mapping

import numpy as np

from ehl.fluid.lubricant import PAO
from ehl.fluid.viscosity import ROELANDS_LOG_VISCOSITY
from ehl.surface.roughness import EP_FILM
from regression.friction.conditions import MIN_ROUGHNESS, Array, Conditions, flattening
from regression.friction.families.family import ROUGH_BOX, Family

# steel: sqrt(46 W/(m K) * 7830 kg/m3 * 465 J/(kg K))
EFFUSIVITY = 12941.4
CAP_ORDER = 8.0
# from fits to 75W90 and FVA3: equal for both, or not separable from the fitted coefficients
INLET_SLIDING, INLET_SLIDING_POWER, INLET_HEAT, INLET_LOAD, INLET_POWER = 2.0, 1.7, 0.9, 0.15, 0.6
# fitted to 1024 smooth contacts of 75W90 and of FVA3, with remaining errors of 2.0 and 2.5 %
HEAT_FILM, HEAT_FLASH, HEAT_POWER, RELIEF_POWER = 1.8, 1.15, 0.75, 2.0 / 3.0
_MAX_EXPONENT = 300.0  # of an exponent
_THICK = 3.0  # lambda above which roughness has no effect on film friction
# from fits to 75W90 and FVA3 with equal results
SLOPE_POWER = 0.75  # of lc/Rq
_PRESSURE, _PRESSURE_POWER, _SLIDING_POWER = 0.005, 0.4, 0.2  # of the exponent j; p_h/E' of 1.1 GPa on steel
_ACROSS = 0.15  # scale of |s|/(1 + SR) for the effect of sliding across the line


def heated_film(c: Conditions, k: Mapping[str, float]) -> Array:
    """Central film with inlet heating [m].

    h = h0/(1 + inlet (1 + 2 SR^1.7) L^0.9 M^0.15)^0.6 with the thermal loading parameter L = eta0 beta u^2/k and
    M = W (2U)^-1/2. The form is that of the published inlet factors (Murch & Wilson, Gupta).
    """
    speed = np.abs(c["speed_entrainment"])
    loading = c["viscosity_inlet"] * c["temperature_viscosity"] * speed**2 / c["thermal_conductivity"]
    scale = c["effective_modulus"] * c["radius_equivalent"]
    load = c["load_per_length"] / scale / np.sqrt(2.0 * c["viscosity_inlet"] * speed / scale)
    sliding = 1.0 + INLET_SLIDING * c["slide_to_roll_total"] ** INLET_SLIDING_POWER
    factor = 1.0 + k["inlet"] * sliding * loading**INLET_HEAT * load**INLET_LOAD
    return np.asarray(c["film_formula"] / factor**INLET_POWER)


def film_friction(c: Conditions, k: Mapping[str, float], film: Array, ripple: Array | float = 0.0) -> Array:
    """Friction of the thermal film, at most Lambda.

    A film of the order of the Hertz depth b^2/R carries the load with a lower pressure over a wider band
    (`relief_thick`). Between ambient and mean pressure the viscosity is that of the modulus law through both. Heating
    reduces the stress tau0 asinh(x) to tau0 a/(1 + theta tanh a)^0.75, with a = asinh x and theta = tau0 beta dT/tau
    from the film and both surfaces. beta increases with pressure as for Roelands, times the oil property
    `heat_pressure` (near 0 if the pressure-viscosity coefficient decreases with temperature). The conductivity of the
    film is that of `PAO`, with a difference of at most 5 %. The limiting stress is a smooth minimum.

    c, k: conditions and coefficients.
    film: film thickness [m].
    ripple: relative increase of the mean viscosity by pressure ripples in a film of Newtonian shear.
    """
    mean = 0.25 * np.pi * c["pressure_hertz"]
    speed, sliding, stress = np.abs(c["speed_entrainment"]), c["speed_sliding"], c["eyring_stress"]
    viscosity, beta = c["viscosity_inlet"], c["temperature_viscosity"]
    rise = np.log(c["viscosity_mean_pressure"] / viscosity)
    # modulus law g(p) = p/(c0 + c1 p) with slope alpha at 0 and `rise` at the mean pressure
    bend = rise / np.maximum(c["pressure_viscosity"] * mean, 1e-9)
    thick = c["film_formula"] * c["radius_equivalent"] / c["half_width"] ** 2
    # constant load: the pressure is divided and the width multiplied by this factor
    relief = (1.0 + k["relief_thick"] * thick) ** RELIEF_POWER
    ratio = 0.5 * np.abs(c["slide_to_roll"])
    surfaces = 0.5 * (np.sqrt(1.0 + ratio) + np.sqrt(np.abs(1.0 - ratio)))
    flash = HEAT_FLASH * np.sqrt(c["half_width"] * relief / speed) / (EFFUSIVITY * surfaces)
    pole = np.maximum(np.log(viscosity) + ROELANDS_LOG_VISCOSITY, 1.0)
    local = 1.0 / relief
    exponent = np.minimum(rise * local / (bend * (1.0 - local) + local), _MAX_EXPONENT)
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


def asperity_share(c: Conditions, film: Array, k: Mapping[str, float]) -> Array:
    """Load share of the asperities under a film [m], X = 1/(1 + Q^j).

    Q = squeeze (h'/h_b)^n exp(squeeze_tail (h'/Rq)^2) P^(squeeze_flattening exp(-h/Rq)) (1 + slide A)
    g/(g + lay/P)/(1 + narrow P^2 lc/b)

    The scale of the film is the boundary film h_b = 30 nm of extreme-pressure additives rather than Rq. The transition
    is sharper for flatter roughness, n = squeeze_film (0.01 lc/Rq)^0.75 (1 + lc/b)^squeeze_width.
    P = p_h lc/(0.5 E' Rq) is the Hertz pressure over the pressure that flattens the roughness; it affects thin films.
    Sliding s across the line generates films between asperities, A = |s|/(0.15 (1 + SR)). Marks across the motion
    (Peklenik number gamma above 1) retain the oil, marks along it drain it: g = gamma^(2/(1 + lc/b)). This effect
    decreases with the ratio of wavelength to contact width. Long waves increase the film (h' = h (1 + whole lc/b)) and
    are flattened as a whole (narrow). The transition is sharper at high pressure and with sliding across the line:
    j = (p_h/(0.005 E'))^0.4 (1 + A)^0.2.
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
    """Factor on film friction: below lambda 1 most of the film is sheared in valleys deeper than the mean film."""
    rough = np.maximum(c["roughness_rms"], MIN_ROUGHNESS)
    return np.asarray((1.0 + (rough / film) ** 2) ** (-0.5 * k["valleys"]))


def film_ripple(c: Conditions, film: Array, k: Mapping[str, float]) -> Array:
    """Relative increase of the shear strain of the film by pressure ripples of the roughness."""
    ratio = film / np.maximum(c["roughness_rms"], MIN_ROUGHNESS)
    return np.asarray(k["ripple"] / (1.0 + (ratio / _THICK) ** 4))


_FILM_POWER = 1.5  # of the load share of the film, from fits to 75W90 and FVA3


def short_parts(c: Conditions, k: Mapping[str, float]) -> tuple[Array, Array]:
    """Asperity load share X, and friction of the film with the rest of the load."""
    hot = heated_film(c, k)
    share = asperity_share(c, hot, k)
    film = film_friction(c, k, hot, film_ripple(c, hot, k)) * valley_film(c, hot, k)
    return share, np.asarray(film * (1.0 - share) ** _FILM_POWER)


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
    f"mu = X mu_b + (1 - X)^{_FILM_POWER:g} F;"
    " X = 1/(1 + Q^j); j = (p_h/(0.005 E'))^0.4 (1 + A)^0.2, A = |s|/(0.15 (1 + SR));"
    " Q = squeeze (h'/h_b)^n exp(squeeze_tail (h'/Rq)^2) P^(squeeze_flattening exp(-h/Rq)) (1 + slide A)"
    " g/(g + lay/P)/(1 + narrow P^2 lc/b), g = gamma^(2/(1 + lc/b));"
    " h' = h (1 + whole lc/b), h_b = 30 nm,"
    " P = p_h lc/(0.5 E' Rq), lc the correlation length of the roughness, gamma its Peklenik number, b the Hertz"
    " half-width, s = slide_to_roll across the line, SR = |v_s|/u_r;"
    f" n = squeeze_film (0.01 lc/Rq)^{SLOPE_POWER:g} (1 + lc/b)^squeeze_width;"
    " F = (1 + (Rq/h)^2)^(-valleys/2) r t (1 + (t/(Lam p/r))^8)^(-1/8)/p;"
    " t = tau0 a/(1 + heat tanh a)^0.75, a = asinh(x (1 + V/(1 + x))), x = strain eta v_s/(tau0 h);"
    " eta = eta0 exp(g), g = G y/(c (1 - y) + y), y = 1/r, r = (1 + relief_thick h0 R/b^2)^(2/3),"
    " G = ln(eta_p/eta0), c = G/(alpha p), p = pi p_h/4; p_i = p/r;"
    " heat = beta (1 + heat_pressure g/(ln eta0 + 9.67)) tau0 v_s (1.8 h/(8 k_i) + 1.15 (r b/u_r)^0.5/(e m)),"
    " k_i = k (1 + 1.4 p_i/(1 + 0.34 p_i)) with p_i in GPa, m = ((1 + |s|/2)^0.5 + |1 - |s|/2|^0.5)/2;"
    " V = ripple/(1 + (h/(3 Rq))^4);"
    " h = h0/(1 + inlet (1 + 2 SR^1.7) (eta0 beta u_r^2/k)^0.9 M^0.15)^0.6"
    " with h0 the film of Moes (1992) over the density ratio of Dowson & Higginson at p_h, M = W (2U)^-1/2;"
    " eta_p the viscosity at p, e = 12941.4 W s^0.5/(m2 K);"
    " tau0, Lam, alpha, beta, k of the oil at inlet temperature; SI units"
)

_START, _LOWER, _UPPER = zip(*_TERMS.values(), strict=True)
SHORT = Family(
    "short",
    "asperities and thermal film, fifteen coefficients (this work)",
    _EQUATION,
    tuple(_TERMS),
    ROUGH_BOX,
    start=_START,
    lower=_LOWER,
    upper=_UPPER,
    parts=short_parts,
)
