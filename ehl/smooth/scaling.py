"""Dimensionless form of the smooth contact in x/b, p/p_h and h R/b^2."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.fluid.lookup import LawTable, law_table
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.rheology import PLAIN, ShearNumbers
from ehl.line_contact import LineContact
from ehl.smooth._kernels import Groups, monotone_cubic

# tuned with validation/smooth_campaign.py: flow by the shear thinning that rounds a spike, over the flow at the edge of
# the Hertz pressure
ROUNDING = 3e-3


@dataclass(frozen=True)
class Offset:
    """Effects of heat on the film over x/b, monotone between the nodes and constant beyond them.

    rows: change of ln(viscosity), and ln of `ehl.heat.traction.flow_shares`; shape (3, n).
    """

    x: FloatArray
    rows: FloatArray

    @classmethod
    def of(cls, x: FloatArray, change: FloatArray, shares: FloatArray | None = None) -> Offset:
        """From a change of ln(viscosity); without ln of the shares they are 1."""
        return cls(x, np.vstack([change, np.zeros((2, x.size)) if shares is None else shares]))

    def moved(self, points: FloatArray) -> Offset:
        """The same at other, increasing points."""
        return Offset(points, np.array([monotone_cubic(self.x, row, points)[0] for row in self.rows]))


_NO_OFFSET = Offset(np.zeros(0), np.zeros((3, 0)))


@dataclass(frozen=True)
class ScaledContact:
    """Dimensionless groups of one contact."""

    lam: float  # viscous number 12 eta0 u_r R^2/(b^3 p_h) = 3 pi^2/(8 M^2)
    table: LawTable  # viscosity and density over pressure in p_h
    gamma: float  # shear number eta0 |v_s| R/(stress b^2); 0 for a Newtonian fluid
    cross: float  # cos^2 of the angle between sliding and x
    log_viscosity: float  # ln(eta/eta0) at p_h
    stiffness: float = 1.0  # factor on ln(eta/eta0); differs from 1 during continuation only
    offset: Offset | None = None  # effects of heat along x
    shear: ShearNumbers = PLAIN  # the shear law; pressures in p_h, stresses in the reference stress of gamma
    # shear number that widens the spike of a Newtonian fluid for the mesh and hardly changes the film
    rounding: float = 0.0

    @property
    def groups(self) -> Groups:
        """Groups for the compiled kernels."""
        offset = self.offset or _NO_OFFSET
        return Groups(self.lam, self.table, self.gamma, self.cross, self.stiffness, self.shear, offset.x, offset.rows)

    @property
    def moes_load(self) -> float:
        """Moes load number M."""
        return moes_load(self.lam)

    def rounded(self, factor: float = 1.0) -> ScaledContact:
        """The contact with at least `factor` times the shear number that rounds the spike, as a Ree-Eyring fluid."""
        gamma = max(self.gamma, factor * self.rounding)
        return replace(self, gamma=gamma, shear=self.shear if self.gamma > 0.0 else PLAIN)

    def easier(self, lam: float, stiffness: float, gamma: float) -> ScaledContact:
        """The contact at other viscous and shear numbers, with ln(eta/eta0) scaled by ``stiffness``."""
        log_viscosity = self.log_viscosity * stiffness
        return replace(self, lam=lam, gamma=gamma, stiffness=self.stiffness * stiffness, log_viscosity=log_viscosity)


def moes_load(lam: float) -> float:
    """Moes load number M for a viscous number."""
    return math.pi * math.sqrt(3.0 / (8.0 * lam))


def scaled_contact(contact: LineContact, lubricant: Lubricant) -> ScaledContact:
    """Scaled form of a contact and its lubricant."""
    radius, b, p_h = contact.radius_equivalent, contact.half_width, contact.pressure_hertz
    speed = abs(contact.speed_entrainment)
    lam = 12.0 * lubricant.viscosity_inlet * speed * radius**2 / (b**3 * p_h)
    gamma, cross = 0.0, 1.0
    law = lubricant.shear_law
    reference = law.reference(p_h)
    if contact.speed_sliding > 0.0 and not (law.plain and law.rheology == "newtonian"):
        gamma = lubricant.viscosity_inlet * contact.speed_sliding * radius / (reference * b**2)
        cross = contact.sliding_cosine**2
    return ScaledContact(
        lam,
        law_table(lubricant, p_h, heated=False),
        gamma,
        cross,
        float(lubricant.log_viscosity_ratio(np.array([p_h]))[0]),
        shear=law.numbers(p_h, reference, b / radius),
        rounding=_rounding(contact, lubricant, lam),
    )


def _rounding(contact: LineContact, lubricant: Lubricant, lam: float) -> float:
    """Shear number that rounds the spike.

    The flow by shear thinning alone is gamma H^2 P'/lam. At the edge of the Hertz pressure, one exit length of about
    H^(2/3) inside, P' is about H^(-1/3) and at least 1. With this gamma the flow is a small share of H.
    """
    film = contact.film_moes(lubricant) * contact.radius_equivalent / contact.half_width**2
    return float(ROUNDING * lam / film * min(1.0, film ** (1.0 / 3.0)))
