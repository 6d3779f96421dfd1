"""Geometry, load and motion of a line contact, and its dimensionless groups."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from ehl.fluid.film_formulas import moes_film

if TYPE_CHECKING:
    from ehl.fluid.lubricant import Lubricant

Values = TypeVar("Values", float, NDArray[np.float64])


def hertz_half_width(load_per_length: Values, radius_equivalent: Values, effective_modulus: float) -> Values:
    """Hertz half-width b = sqrt(8 w' R/(pi E')) of a line contact [m].

    load_per_length: w' [N/m].
    radius_equivalent: R [m].
    effective_modulus: E' with 2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 [Pa].

    Examples
    --------
    >>> round(1e6 * hertz_half_width(4e5, 0.015, 228e9), 2)
    258.87
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
