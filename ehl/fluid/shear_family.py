"""Shear of oils that have no figures of their own, by base oil: Eyring stress, limiting stress, shear modulus.

A figure on the card goes before these; their uncertainties stand in `ehl.fluid.oil_uncertainty`. Why Ree-Eyring with
these stresses is the default stands in docs/shear.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ehl.common.units import KELVIN

STRESS_TEMPERATURE = 40.0 + KELVIN


@dataclass(frozen=True)
class ShearFamily:
    """Shear of one base oil.

    Parameters
    ----------
    stress : float
        tau0 at 40 degC [Pa].
    limit_ambient, limit_slope : float
        tau_L0 [Pa] and Lambda [-] of tau_L = tau_L0 + Lambda p.
    source : str
        Where the figures come from.
    """

    stress: float
    limit_ambient: float
    limit_slope: float
    source: str

    def eyring_stress(self, temperature: Any) -> Any:
        """tau0 = k T/V of a flowing piece of the molecule of constant volume V [Pa]; `temperature` in K."""
        return self.stress * temperature / STRESS_TEMPERATURE


# apparent modulus of the film alone, the compliance of the bodies apart: 0.3 to 1 GPa were found for 5P4E and Santotrac
# by traction (from memory); other oils are taken as the softest of them (ours, uncertain by a factor of 3 either way)
SHEAR_MODULUS = 0.3e9

FAMILIES = {
    "mineral": ShearFamily(8.8e6, 0.0, 0.047, "tau0 published for FVA 3, Lambda for LVI 260"),
    "hydrocracked": ShearFamily(5.8e6, 4e6, 0.0395, "tau0 by the formula for FVA 3, of HC + PMA1; limit as PAO (ours)"),
    "pao": ShearFamily(
        7.0e6, 4e6, 0.0395, "tau0 by the formula for FVA 3: 5.4 to 8.7 MPa with and without thickener; limit published"
    ),
    "ester": ShearFamily(5.5e6, 0.0, 0.035, "tau0 by the formula for FVA 3: 4.7 to 6.3 MPa; limit below PAO (ours)"),
    "polyglycol": ShearFamily(4.75e6, 0.0, 0.044, "tau0 by the formula for FVA 3: 4.5 to 5.0 MPa; Lambda published"),
}
