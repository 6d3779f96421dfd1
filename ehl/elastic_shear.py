"""Elastic part of the shear (Maxwell model): at small slip the film does not reach its viscous stress.

Along the motion of the film, with the tangential compliance k of the bodies in series,

    (h/G + k) D(tau)/Dt + h rate(tau) = v_s

where the viscous law gives rate(tau*) = v_s/h at the stress tau* without the elastic part, and
rate(tau)/rate(tau*) = sinh(tau/tau0)/sinh(tau*/tau0) for Ree-Eyring. For Carreau the stress G replaces tau0; for a
Newtonian film the ratio is tau/tau*. The elastic part affects film friction only: at such small slips shear thinning of
the pressure flow is small. Most friction power becomes heat locally, as the elastic energy is recovered.
"""

import math
from dataclasses import dataclass

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.fluid._kernels import march_stress
from ehl.fluid.lubricant import Lubricant
from ehl.line_contact import LineContact

# tuned with tests/verification/ehl/test_elastic_shear.py: estimated share of mu below which the elastic part is
# neglected, and from which on it is fully included
SHARE_NEGLECTED, SHARE_FULL = 0.005, 0.01
SUBDIVISION = 4  # steps of the first-order integration per cell of the mesh


def body_compliance(contact: LineContact) -> float:
    """Tangential displacement of both surfaces per shear stress, k = 8 b/(pi E') [m/Pa].

    An elastic foundation of this compliance has the initial slope mu = 2 R SR/b of Carter (1926) for equal bodies.
    """
    return 8.0 * contact.half_width / (math.pi * contact.effective_modulus)


def rubbing_friction(contact: LineContact, boundary_friction: float) -> float:
    """Friction of asperity contacts: mu_b in full slip, less where part of the contact sticks (Carter 1926) [-].

    mu = mu_b (1 - (1 - s/s_b)^2) for slips s = v_s/u below s_b = mu_b b/R, with the initial slope 2 R/b. The law is
    that of a smooth contact of equal bodies; it is applied to the load on the asperities (own assumption).
    """
    full = boundary_friction * contact.half_width / contact.radius_equivalent
    slip = contact.slide_to_roll_total
    return boundary_friction if slip >= full else boundary_friction * (1.0 - (1.0 - slip / full) ** 2)


def elastic_share(contact: LineContact, lubricant: Lubricant, film: float, stress: float) -> float:
    """Upper estimate of the relative reduction of friction by the elastic part [-].

    A stress that grows linearly from zero at the edge to its full value over the way l loses l/2 of the width 2 b.

    contact, lubricant: speeds and shear modulus.
    film: central film thickness [m].
    stress: largest shear stress [Pa].
    """
    if math.isinf(lubricant.shear_modulus) or contact.speed_sliding == 0.0:
        return 0.0
    compliance = film / lubricant.shear_modulus + body_compliance(contact)
    way = stress * compliance * abs(contact.speed_entrainment) / contact.speed_sliding
    return way / (4.0 * contact.half_width)


def isothermal_stress(contact: LineContact, lubricant: Lubricant, film: float) -> float:
    """Shear stress of the viscous law at the Hertz pressure and the inlet temperature [Pa]."""
    pressure = np.array([contact.pressure_hertz])
    return float(lubricant.shear_stress(pressure, np.array([film]), contact.speed_sliding)[0])


def counted(share: float) -> float:
    """Weight of the elastic part: 0 below `SHARE_NEGLECTED`, 1 above `SHARE_FULL`, linear between."""
    return min(max((share - SHARE_NEGLECTED) / (SHARE_FULL - SHARE_NEGLECTED), 0.0), 1.0)


@dataclass(frozen=True)
class ElasticShear:
    """Effect of the elastic part on the friction of a smooth film."""

    estimate: float  # upper estimate of its share of mu [-]
    left_out: float  # neglected part of this share [-]
    ratio: float  # mu with the elastic part over mu without it [-]
    error: float  # of mu by the first-order integration: 1.5 times the change from steps twice as long [-]
    stress: FloatArray  # shear stress on the nodes of the film [Pa]; shape (n,)

    def notes(self) -> tuple[str, ...]:
        """Note on the change of friction; empty if the elastic part was neglected."""
        if self.ratio == 1.0:
            return ()
        return (f"elastic shear of film and bodies changes smooth friction by {100.0 * (self.ratio - 1.0):.2g} %",)


def elastic_shear(
    x: FloatArray,
    pressure: FloatArray,
    film: FloatArray,
    viscous: FloatArray,
    contact: LineContact,
    lubricant: Lubricant,
) -> ElasticShear:
    """Elastic part of the shear of a steady film, zero if its estimate is negligible.

    x, pressure, film, viscous, contact, lubricant: as in `elastic_stress`.
    """
    central = float(np.interp(0.0, x, film))
    estimate = elastic_share(contact, lubricant, central, float(np.max(viscous)))
    share = counted(estimate)
    if share == 0.0:
        return ElasticShear(estimate, estimate, 1.0, 0.0, viscous)
    stresses = [
        viscous + share * (elastic_stress(x, pressure, film, viscous, contact, lubricant, parts) - viscous)
        for parts in (SUBDIVISION, SUBDIVISION // 2)
    ]
    ratio, coarse = (float(np.trapezoid(stress, x) / np.trapezoid(viscous, x)) for stress in stresses)
    error = 1.5 * abs(ratio - coarse) / max(ratio, 1e-300)
    return ElasticShear(estimate, (1.0 - share) * estimate, ratio, error, stresses[0])


def elastic_stress(
    x: FloatArray,
    pressure: FloatArray,
    film: FloatArray,
    viscous: FloatArray,
    contact: LineContact,
    lubricant: Lubricant,
    subdivision: int = SUBDIVISION,
) -> FloatArray:
    """Shear stress with its elastic part on the nodes of a steady film [Pa].

    x, pressure, film (n,): nodes [m], pressure [Pa], film thickness [m].
    viscous (n,): stress of the viscous law at the temperature of the film [Pa].
    contact, lubricant: speeds, bodies and shear modulus.
    subdivision: integration steps per cell.
    """
    law = lubricant.shear_law
    fine = np.interp(np.arange(subdivision * (x.size - 1) + 1) / subdivision, np.arange(x.size), x)
    p, h, final = (np.interp(fine, x, row) for row in (np.maximum(pressure, 0.0), film, viscous))
    newtonian = law.rheology == "newtonian"
    scale = np.full_like(fine, math.inf) if newtonian else law.scale(p)
    compliance = h / lubricant.shear_modulus + body_compliance(contact)
    slip = contact.speed_sliding / abs(contact.speed_entrainment)
    gain = np.concatenate([[0.0], slip * np.diff(fine) / compliance[1:]])
    return np.asarray(march_stress(final, scale, law.limiting_stress(p), gain)[::subdivision])
