"""Random smooth contacts of the gear range, shared by the smooth benchmarks."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.stats import qmc

from ehl.fluid.lubricant import Lubricant
from ehl.line_contact import LineContact

MODULUS = 2.264e11
# p_h [Pa], R [m], u_r [m/s], eta0 [Pa s], alpha [1/Pa], tau0 [Pa], slide-to-roll; logarithmic but for alpha
LOW = np.array([0.3e9, 0.005, 0.2, 0.003, 10e-9, 3e6, 0.01])
HIGH = np.array([2.5e9, 0.08, 20.0, 0.15, 25e-9, 10e6, 1.5])
LINEAR = 4


def contact_of(values: np.ndarray, rheology: str) -> tuple[LineContact, Lubricant]:
    """Contact and lubricant of one row of (p_h, R, u_r, eta0, alpha, tau0, slide-to-roll)."""
    p_h, radius, speed, viscosity, alpha, stress, slip = (float(v) for v in values)
    contact = LineContact.from_pressure(
        radius_equivalent=radius,
        effective_modulus=MODULUS,
        pressure_hertz=p_h,
        speed_entrainment=speed,
        slide_to_roll=slip,
    )
    lubricant = Lubricant(viscosity, alpha, "roelands", rheology="eyring", eyring_stress=stress)
    if rheology == "newtonian":
        lubricant = Lubricant(viscosity, alpha, "roelands")
    return contact, lubricant


def gear_range(count: int, seed: int) -> Iterator[np.ndarray]:
    """Rows of a scrambled Sobol sample of the gear range."""
    for share in qmc.Sobol(LOW.size, rng=seed).random(count):
        values = LOW * (HIGH / LOW) ** share
        values[LINEAR] = LOW[LINEAR] + (HIGH - LOW)[LINEAR] * share[LINEAR]
        yield values


def neighbour(values: np.ndarray, sign: float) -> np.ndarray:
    """The contact a mesh position further: a few per cent in load, curvature, speed and slip."""
    moved = values.copy()
    moved[[0, 1, 2, 6]] *= 1.0 + sign * np.array([0.03, 0.02, 0.01, 0.1])
    return moved
