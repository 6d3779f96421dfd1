"""Geometry, load and motion of a line contact, its dimensionless groups, and film formulas for estimates.

Groups of Moes: M = W (2U)^-1/2, L = G (2U)^1/4, with U = eta0 u_r/(E'R), W = w'/(E'R), G = alpha E'; film
H = (h/R)(2U)^-1/2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ehl.common.arrays import Values

if TYPE_CHECKING:
    from ehl.fluid.lubricant import Lubricant


def hertz_half_width(load_per_length: Values, radius_equivalent: Values, effective_modulus: float) -> Values:
    """Hertz half-width b = sqrt(8 w' R/(pi E')) of a line contact [m].

    load_per_length: w' [N/m].
    radius_equivalent: R [m].
    effective_modulus: E' with 2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 [Pa].
    """
    half_width: Values = np.sqrt(8.0 * load_per_length * radius_equivalent / (np.pi * effective_modulus))
    return half_width


def half_width_of_pressure(
    pressure_hertz: Values, radius_equivalent: Values, effective_modulus: Values | float
) -> Values:
    """Hertz half-width b = 4 R p_h/E' [m]; arguments as in `hertz_load`."""
    return 4.0 * radius_equivalent * pressure_hertz / effective_modulus


def hertz_pressure(load_per_length: Values, radius_equivalent: Values, effective_modulus: float) -> Values:
    """Maximum Hertz pressure p_h = sqrt(w' E'/(2 pi R)) [Pa]; arguments as in `hertz_half_width`."""
    pressure: Values = np.sqrt(load_per_length * effective_modulus / (2.0 * np.pi * radius_equivalent))
    return pressure


def hertz_load(pressure_hertz: Values, radius_equivalent: Values, effective_modulus: Values) -> Values:
    """Load per length w' = 2 pi p_h^2 R/E' of a line contact [N/m].

    pressure_hertz: maximum Hertz pressure p_h [Pa].
    radius_equivalent, effective_modulus: R [m] and E' [Pa].
    """
    return 2.0 * np.pi * pressure_hertz**2 * radius_equivalent / effective_modulus


def moes_1992(load: Values, lubricant: Values) -> Values:
    """Film thickness H = (h/R)(2U)^-1/2 at dp/dx = 0, a blend of all four regimes.

    Moes (1992), Wear 159: H = [(H_RI^(7/3) + H_EI^(7/3))^(3s/7) + (H_RP^(-7/2) + H_EP^(-7/2))^(-2s/7)]^(1/s),
    s = (7 + 8 exp(-2 H_EI/H_RI))/5, H_RI = 3/M, H_EI = 2.621 M^(-1/5), H_RP = 1.287 L^(2/3),
    H_EP = 1.311 M^(-1/8) L^(3/4). The coefficients are unverified; they agree with reference solutions of this program
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


def gupta_1992(loading: Values, slide_to_roll: Values) -> Values:
    """Film factor 1/(1 + 0.213 (1 + 2.23 |SR|^0.83) L^0.64) of inlet heating (Gupta et al. 1992, as quoted).

    Its numerator 1 - 13.2 (p_h/E') L^0.42 is omitted: without it the factor is -14 to +9 % from 64 films solved with
    heat (two oils, 60 and 90 degC, 0.6 and 1.2 GPa, 4 and 12 m/s, SR 0.02 to 1).

    loading: L = eta0 beta u_r^2/k [-].
    slide_to_roll: SR [-].
    """
    factor: Values = 1.0 / (1.0 + 0.213 * (1.0 + 2.23 * abs(slide_to_roll) ** 0.83) * loading**0.64)
    return factor


def blok_1937(heat: Values, half_width: Values, carried: Values) -> Values:
    """Flash temperature of a band contact, 1.11 q/(sqrt(2 b) (B1 sqrt|u1| + B2 sqrt|u2|)), B = sqrt(k rho c) [K].

    Hertz distribution of the heat, both surfaces fast (Peclet numbers well above 2) and at the same temperature in the
    contact. A surface at rest takes no heat.

    heat: q = mu w' |v_s| [W/m].
    half_width: b [m].
    carried: B1 sqrt|u1| + B2 sqrt|u2|.
    """
    rise: Values = 1.11 * heat / (np.sqrt(2.0 * half_width) * carried)
    return rise


@dataclass(frozen=True)
class LineContact:
    """Two bodies in line contact; x is normal to the contact line, y along it."""

    radius_equivalent: float  # radius R of the equivalent cylinder on a plane [m]
    effective_modulus: float  # E' with 2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 [Pa]
    load_per_length: float  # w' [N/m]
    speed_entrainment: float  # u_r = (u1 + u2)/2 along x [m/s]; positive
    slide_to_roll: float = 0.0  # (u1 - u2)/u_r, signed [-]
    speed_sliding_lengthwise: float = 0.0  # sliding along y [m/s]

    @classmethod
    def from_pressure(
        cls,
        *,
        radius_equivalent: float,
        effective_modulus: float,
        pressure_hertz: float,
        speed_entrainment: float,
        slide_to_roll: float = 0.0,
        speed_sliding_lengthwise: float = 0.0,
    ) -> LineContact:
        """The contact with the given maximum Hertz pressure: w' = 2 pi p_h^2 R/E'."""
        load = hertz_load(pressure_hertz, radius_equivalent, effective_modulus)
        return cls(
            radius_equivalent, effective_modulus, load, speed_entrainment, slide_to_roll, speed_sliding_lengthwise
        )

    @property
    def half_width(self) -> float:
        """Hertz half-width b = sqrt(8 w' R/(pi E')) [m]."""
        return float(hertz_half_width(self.load_per_length, self.radius_equivalent, self.effective_modulus))

    @property
    def pressure_hertz(self) -> float:
        """Maximum Hertz pressure p_h = E' b/(4 R) [Pa]."""
        return self.effective_modulus * self.half_width / (4.0 * self.radius_equivalent)

    @property
    def speed_1(self) -> float:
        """Surface velocity u1 along x [m/s]."""
        return self.speed_entrainment * (1.0 + 0.5 * self.slide_to_roll)

    @property
    def speed_2(self) -> float:
        """Surface velocity u2 along x [m/s]."""
        return self.speed_entrainment * (1.0 - 0.5 * self.slide_to_roll)

    @property
    def speed_sliding(self) -> float:
        """Length of the sliding vector (u1 - u2, v_y) [m/s]."""
        return math.hypot(self.slide_to_roll * self.speed_entrainment, self.speed_sliding_lengthwise)

    @property
    def slide_to_roll_total(self) -> float:
        """|sliding vector|/u_r [-]."""
        return self.speed_sliding / abs(self.speed_entrainment)

    @property
    def sliding_cosine(self) -> float:
        """cos of the angle between the sliding vector and x; 1 without sliding."""
        speed = self.speed_sliding
        return abs(self.slide_to_roll * self.speed_entrainment) / speed if speed > 0.0 else 1.0

    def dowson_groups(self, lubricant: Lubricant) -> tuple[float, float, float]:
        """Dowson-Higginson groups (U, W, G): eta0 u_r/(E'R), w'/(E'R), alpha_film E' [-]."""
        scale = self.effective_modulus * self.radius_equivalent
        return (
            lubricant.viscosity_inlet * self.speed_entrainment / scale,
            self.load_per_length / scale,
            lubricant.pressure_viscosity_film * self.effective_modulus,
        )

    def moes_groups(self, lubricant: Lubricant) -> tuple[float, float]:
        """Moes groups (M, L): W (2U)^-1/2 and G (2U)^1/4 [-]."""
        speed, load, material = self.dowson_groups(lubricant)
        return load / math.sqrt(2.0 * speed), material * (2.0 * speed) ** 0.25

    def film_moes(self, lubricant: Lubricant) -> float:
        """Smooth isothermal central film by the formula of Moes (1992) [m]."""
        body = (self.load_per_length, self.radius_equivalent, self.effective_modulus)
        eta, alpha = lubricant.viscosity_inlet, lubricant.pressure_viscosity_film
        return float(moes_film(eta, abs(self.speed_entrainment), *body, alpha))
