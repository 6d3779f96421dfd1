"""Published film-thickness formulas of the smooth line contact.

Arguments are the groups of Dowson and Higginson, U = eta0 u_r/(E'R) with the mean speed, W = w'/(E'R), G = alpha E', or
those of Moes, M = W (2U)^-1/2, L = G (2U)^1/4. Results are h/R or H = (h/R)(2U)^-1/2.
"""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Values = TypeVar("Values", float, NDArray[np.float64])


def moes_1992(load: Values, lubricant: Values) -> Values:
    """Film thickness H = (h/R)(2U)^-1/2 at dp/dx = 0, a blend of all four regimes.

    Moes (1992), J. Tribol. 114: H = [(H_RI^(7/3) + H_EI^(7/3))^(3s/7) + (H_RP^(-7/2) + H_EP^(-7/2))^(-2s/7)]^(1/s),
    s = (7 + 8 exp(-2 H_EI/H_RI))/5, H_RI = 3/M, H_EI = 2.621 M^(-1/5), H_RP = 1.287 L^(2/3),
    H_EP = 1.311 M^(-1/8) L^(3/4). The coefficients are from memory; they agree with reference solutions of this program
    within 7 % (M 1.7 to 744, L 2 to 15; see the literature tests).

    load: M [-].
    lubricant: L [-].
    """
    rigid_iso, elastic_iso = 3.0 / load, 2.621 * load**-0.2
    piezo = np.maximum(lubricant, 1e-30)  # the isoviscous part remains for L = 0
    rigid_piezo, elastic_piezo = 1.287 * piezo ** (2 / 3), 1.311 * load**-0.125 * piezo**0.75
    blend = (7.0 + 8.0 * np.exp(-2.0 * elastic_iso / rigid_iso)) / 5.0
    film_iso = (rigid_iso ** (7 / 3) + elastic_iso ** (7 / 3)) ** (3.0 * blend / 7.0)
    film_piezo = (rigid_piezo**-3.5 + elastic_piezo**-3.5) ** (-2.0 * blend / 7.0)
    film: Values = (film_iso + film_piezo) ** (1.0 / blend)
    return film


def moes_film(viscosity: Values, speed: Values, load: Values, radius: Values, modulus: Values, alpha: Values) -> Values:
    """Isothermal film of `moes_1992` [m].

    viscosity, speed: eta0 [Pa s] and |u_r| [m/s].
    load, radius, modulus: w' [N/m], R [m] and E' [Pa].
    alpha: [1/Pa].
    """
    root = np.sqrt(2.0 * viscosity * speed / (modulus * radius))
    # a small load keeps the formula finite at an unloaded point
    moes_load = np.maximum(load / (modulus * radius) / root, 1e-6)
    film: Values = moes_1992(moes_load, alpha * modulus * np.sqrt(root)) * radius * root
    return film


def dowson_higginson_1968(speed: Values, load: Values, material: Values) -> Values:
    """Minimum film h_min/R = 2.65 U^0.70 G^0.54 W^-0.13 (Dowson & Higginson; exponents of 1968)."""
    film: Values = 2.65 * speed**0.70 * material**0.54 * load**-0.13
    return film


def pan_hamrock_1989_minimum(speed: Values, load: Values, material: Values) -> Values:
    """Minimum film h_min/R = 1.714 U^0.694 G^0.568 W^-0.128 (Pan & Hamrock 1989, J. Tribol. 111; from memory)."""
    film: Values = 1.714 * speed**0.694 * material**0.568 * load**-0.128
    return film


def pan_hamrock_1989_central(speed: Values, load: Values, material: Values) -> Values:
    """Central film h_c/R = 2.922 U^0.692 G^0.470 W^-0.166 (Pan & Hamrock 1989, J. Tribol. 111; from memory)."""
    film: Values = 2.922 * speed**0.692 * material**0.470 * load**-0.166
    return film
