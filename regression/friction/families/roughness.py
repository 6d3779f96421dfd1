"""Load share of the asperities of rough, sliding contacts, which `rough_share` and `short` have in common (ours)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from regression.friction.conditions import MIN_ROUGHNESS, Array, Conditions, boundary_film, flattening

_MAX_EXPONENT = 300.0  # of an exponent
_THICK = 3.0  # lambda from which the roughness leaves no trace in the film's friction
# of fits of `rough_share` to both shipped oils, where they came out alike
SLOPE_POWER = 0.75  # of lc/Rq
_PRESSURE, _PRESSURE_POWER, _SLIDING_POWER = 0.005, 0.4, 0.2  # of the sharpness j; p_h/E' of 1.1 GPa on steel
_ACROSS = 0.15  # |s|/(1 + SR) at which sliding across the line counts


def asperity_share(c: Conditions, film: Array, k: Mapping[str, float], slope_power: float = SLOPE_POWER) -> Array:
    """Load share of the asperities under a film [m], X = 1/(1 + Q^j).

    Q = squeeze (h'/h_b)^n exp(squeeze_tail (h'/Rq)^2) P^(squeeze_flattening exp(-h/Rq)) (1 + slide A)
    g/(g + lay/P)/(1 + narrow P^2 lc/b)

    The film is measured by the boundary film h_b = 30 nm + (2.1 nm Rq)^1/2 of the default rule
    (`ehl.surface.roughness.boundary_film`): it, and not Rq, decides which film the asperities reach through. The
    exponent n = squeeze_film (0.01 lc/Rq)^slope_power (1 + lc/b)^squeeze_width says how suddenly they do: flatter
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
    power = k["squeeze_film"] * (0.01 * length / rough) ** slope_power * (1.0 + waves) ** k["squeeze_width"]
    log_resistance = (
        np.log(k["squeeze"])
        + power * np.log(lifted / boundary_film(c))
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
