"""Load share of the asperities of rough, sliding contacts, which `rough_share` and `short` have in common (ours)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from regression.friction.conditions import Array, Conditions
from regression.friction.groups import MIN_ROUGHNESS, boundary_film, flattening

_MAX_EXPONENT = 300.0  # of an exponent
_THICK = 3.0  # lambda from which the roughness leaves no trace in the film's friction
SLOPE_POWER = 0.6  # of lc/Rq, in fits of `rough_share` to both shipped oils


def asperity_share(c: Conditions, film: Array, k: Mapping[str, float], slope_power: float = SLOPE_POWER) -> Array:
    """Load share of the asperities under a film [m], X = 1/(1 + Q).

    Q = squeeze (h'/h_b)^n exp(squeeze_tail (h'/Rq)^2) P^squeeze_flattening (1 + slide |s|/(0.15 (1 + SR)))
    gamma^2/(gamma^2 + lay/P)/(1 + narrow P^2 lc/b)

    The film is measured by the boundary film h_b = 30 nm + (2.1 nm Rq)^1/2 of the default rule
    (`ehl.surface.roughness.boundary_film`): it, and not Rq, decides which film the asperities reach through. The
    exponent n = squeeze_film (0.01 lc/Rq)^slope_power says how suddenly they do: flatter roughness touches more evenly.
    P = p_h lc/(0.5 E' Rq) is the pressure over the one that flattens the roughness. Sliding s across the line makes
    films between asperities; marks across the motion (Peklenik number gamma above 1) hold the oil, marks along it let
    it out; waves as long as the contact is wide lift it (h' = h (1 + whole lc/b)) and are squeezed as a whole (narrow).
    """
    rough = np.maximum(c["roughness_rms"], MIN_ROUGHNESS)
    length, width = c["correlation_length"], c["half_width"]
    pressed = flattening(c)
    lifted = film * (1.0 + k["whole"] * length / width)
    across = np.abs(c["slide_to_roll"]) / (0.15 * (1.0 + c["slide_to_roll_total"]))
    log_resistance = (
        np.log(k["squeeze"])
        + k["squeeze_film"] * (0.01 * length / rough) ** slope_power * np.log(lifted / boundary_film(c))
        + k["squeeze_tail"] * (lifted / rough) ** 2
        + k["squeeze_flattening"] * np.log(pressed)
        + np.log1p(k["slide"] * across)
        - np.log1p(k["lay"] / (pressed * c["peklenik_number"] ** 2))
        - np.log1p(k["narrow"] * pressed**2 * length / width)
    )
    return np.asarray(1.0 / (1.0 + np.exp(np.minimum(log_resistance, _MAX_EXPONENT))))


def film_ripple(c: Conditions, film: Array, k: Mapping[str, float]) -> Array:
    """What the waves of the roughness add to the strain of the film they roll through."""
    ratio = film / np.maximum(c["roughness_rms"], MIN_ROUGHNESS)
    return np.asarray(k["ripple"] / (1.0 + (ratio / _THICK) ** 4))


SHARE_EQUATION = (
    "X = 1/(1 + Q);"
    " Q = squeeze (h'/h_b)^n exp(squeeze_tail (h'/Rq)^2) P^squeeze_flattening (1 + slide |s|/(0.15 (1 + SR)))"
    " gamma^2/(gamma^2 + lay/P)/(1 + narrow P^2 lc/b); h' = h (1 + whole lc/b), h_b = 30 nm + (2.1 nm Rq)^0.5,"
    " P = p_h lc/(0.5 E' Rq), lc the correlation length of the roughness, gamma its Peklenik number, b the Hertz"
    " half-width, s = slide_to_roll across the line, SR = |v_s|/u_r;"
)
