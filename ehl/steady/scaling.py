"""Dimensionless form of the smooth contact: x/b, p/p_h, h R/b^2, and the groups that remain."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ehl.contact import LineContact
from ehl.lubricant import Lubricant
from ehl.rheology.numbers import PLAIN, ShearNumbers

Array = NDArray[np.float64]
Offset = Callable[[Array], Array]


@dataclass(frozen=True)
class Scene:
    """Groups of one contact, as the kernels need them.

    Parameters
    ----------
    lam : float
        Viscous number 12 eta0 u_r R^2/(b^3 p_h) = 3 pi^2/(8 M^2).
    law : int
        Viscosity law (0 barus, 1 roelands, 2 modulus).
    constants : ndarray, shape (3,)
        Its constants [SI].
    fluid : ndarray, shape (5,)
        p_h [Pa]; density coefficients times p_h; gamma = eta0 |v_s| R/(stress b^2) (0 for a Newtonian fluid);
        cos^2 of the angle between sliding and x.
    log_viscosity : float
        ln(eta/eta0) at p_h.
    offset : callable or None
        Added to ln(eta/eta0) at x/b (film temperature of an outer loop).
    shear : ShearNumbers
        The shear law; pressures in p_h, stresses in the one gamma refers to.
    """

    lam: float
    law: int
    constants: Array
    fluid: Array
    log_viscosity: float
    offset: Offset | None = None
    shear: ShearNumbers = PLAIN

    @property
    def moes_load(self) -> float:
        """Moes load number M."""
        return math.pi * math.sqrt(3.0 / (8.0 * self.lam))

    @property
    def gamma(self) -> float:
        """Shear number eta0 |v_s| R/(tau0 b^2)."""
        return float(self.fluid[3])

    def easier(self, lam: float, stiffness: float, gamma: float) -> Scene:
        """The scene at other viscous and shear numbers, with ln(eta/eta0) and its offset scaled by ``stiffness``."""
        constants = self.constants.copy()
        if self.law == 2:
            constants[:2] /= stiffness
        else:
            constants[0] *= stiffness
        offset = self.offset
        fluid = self.fluid.copy()
        fluid[3] = gamma
        scaled = None if offset is None else (lambda x: stiffness * offset(x))
        return replace(
            self, lam=lam, constants=constants, fluid=fluid, log_viscosity=self.log_viscosity * stiffness, offset=scaled
        )


def scene_of(contact: LineContact, lubricant: Lubricant, offset: Offset | None = None) -> Scene:
    """Scene of a contact and its lubricant; ``offset`` takes x in half-widths."""
    radius, b, p_h = contact.radius_equivalent, contact.half_width, contact.pressure_hertz
    speed = abs(contact.speed_entrainment)
    lam = 12.0 * lubricant.viscosity_inlet * speed * radius**2 / (b**3 * p_h)
    gamma, cross = 0.0, 1.0
    law = lubricant.shear_law
    reference = law.reference(p_h)
    if contact.speed_sliding > 0.0 and not (law.plain and law.rheology == "newtonian"):
        gamma = lubricant.viscosity_inlet * contact.speed_sliding * radius / (reference * b**2)
        cross = contact.sliding_cosine**2
    a, c = lubricant.density_constants
    fluid = np.array([p_h, a * p_h, c * p_h, gamma, cross])
    stiffness = float(lubricant.log_viscosity_ratio(np.array([p_h]))[0])
    constants = np.asarray(lubricant.law_constants, dtype=float)
    shear = law.numbers(p_h, reference, b / radius)
    return Scene(lam, lubricant.law_code, constants, fluid, stiffness, offset, shear)
