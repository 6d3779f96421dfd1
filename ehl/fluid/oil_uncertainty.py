"""Uncertainty of an oil card: standard deviation of each input, and factors that shift them."""

import math
from typing import Annotated, Any

from ehl.common.units import ValueRange
from ehl.common.validation import InputModel
from ehl.fluid.oil_laws import ViscosityByConstants
from ehl.fluid.viscosity import WaltherViscosity

Deviation = Annotated[float, ValueRange("", ge=0.0, le=1.0, hint="One standard deviation, relative: 0.08 is 8 %.")]
Factor = Annotated[float, ValueRange("", gt=0.0, le=100.0)]

VARIABLES = ("pressure_viscosity", "viscosity", "eyring_stress", "limiting_shear", "thermal_conductivity")

# tuned: of ln(eta/eta0) of FVA 400 oils about Gold's formula for the secant at 0.2 GPa (own evaluation)
GOLD_DEVIATION = {"mineral": 0.07, "hydrocracked": 0.08, "pao": 0.17, "polyglycol": 0.17, "ester": 0.12}
MEMORY_DEVIATION = 0.15


class CardUncertainty(InputModel):
    """Relative standard deviations of the inputs of a card."""

    pressure_viscosity: Deviation  # of ln(eta/eta0), equal for all pressures and temperatures
    viscosity: Deviation  # of eta0
    eyring_stress: Deviation
    limiting_shear: Deviation
    thermal_conductivity: Deviation
    source: str


class InputFactors(InputModel):
    """Factors on the inputs of a card."""

    pressure_viscosity: Factor = 1.0  # on ln(eta/eta0)
    viscosity: Factor = 1.0
    eyring_stress: Factor = 1.0
    limiting_shear: Factor = 1.0
    thermal_conductivity: Factor = 1.0


def standard_uncertainty(
    law: ViscosityByConstants | WaltherViscosity, gold: str | None, certainty: str
) -> dict[str, Any]:
    """Default uncertainty of a card (own estimate).

    law: viscosity over pressure.
    gold: base oil, if the pressure-viscosity coefficient is from Gold's formula without a measured value.
    certainty: of the card.
    """
    memory, spread = certainty == "unverified", law.deviation
    if isinstance(law, WaltherViscosity):
        spread = math.hypot(spread, 0.0 if gold is None else GOLD_DEVIATION.get(gold, 0.17))
    if memory:
        spread = math.hypot(spread, MEMORY_DEVIATION)
    return {
        "pressure_viscosity": round(spread, 3),
        "viscosity": 0.10 if memory else 0.05,
        # tau0 from k T/V and from 2 Lambda/alpha(p, T) differ by a factor of 1.4 to 2.3 at 1 GPa; the published law of
        # a PAO is 2.8 times the latter (docs/shear.md)
        "eyring_stress": 0.40,
        "limiting_shear": 0.25 if memory else 0.20,
        "thermal_conductivity": 0.10,
        "source": f"Estimated from the viscosity law of the card ({law.law}) and the origin of its values.",
    }
