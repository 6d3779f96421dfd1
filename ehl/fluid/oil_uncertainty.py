"""How well the figures of an oil card are known: one standard deviation of each input, and factors that shift them."""

from __future__ import annotations

import math
from typing import Annotated, Any

from ehl.common.units import ValueRange
from ehl.common.validation import InputModel
from ehl.fluid.oil_laws import ViscosityByConstants
from ehl.fluid.viscosity import WaltherViscosity

Deviation = Annotated[float, ValueRange("", ge=0.0, le=1.0, hint="One standard deviation, relative: 0.08 is 8 %.")]
Factor = Annotated[float, ValueRange("", gt=0.0, le=100.0)]

VARIABLES = ("pressure_viscosity", "viscosity", "eyring_stress", "limiting_shear", "thermal_conductivity")

# tuned: of ln(eta/eta0) of FVA 400 oils about Gold's formula in its own sense, the secant at 0.2 GPa (computed by us)
GOLD_DEVIATION = {"mineral": 0.07, "hydrocracked": 0.08, "pao": 0.17, "polyglycol": 0.17, "ester": 0.12}
MEMORY_DEVIATION = 0.15


class CardUncertainty(InputModel):
    """One standard deviation of the inputs a card stands for, relative to their value."""

    pressure_viscosity: Deviation  # of ln(eta/eta0) under pressure, at all pressures and temperatures alike
    viscosity: Deviation  # of eta0
    eyring_stress: Deviation
    limiting_shear: Deviation
    thermal_conductivity: Deviation
    source: str


class InputFactors(InputModel):
    """Factors on the inputs of a card; 1 is the card as it is."""

    pressure_viscosity: Factor = 1.0  # on ln(eta/eta0) under pressure
    viscosity: Factor = 1.0
    eyring_stress: Factor = 1.0
    limiting_shear: Factor = 1.0
    thermal_conductivity: Factor = 1.0


def standard_uncertainty(
    law: ViscosityByConstants | WaltherViscosity, gold: str | None, certainty: str
) -> dict[str, Any]:
    """What is assumed of a card that does not say it (ours).

    law: viscosity over pressure.
    gold: base oil where Gold's formula gives the pressure-viscosity coefficient, through no measured point.
    certainty: of the card.
    """
    memory, spread = certainty == "from memory", law.deviation
    if isinstance(law, WaltherViscosity):
        spread = math.hypot(spread, 0.0 if gold is None else GOLD_DEVIATION.get(gold, 0.17))
    if memory:
        spread = math.hypot(spread, MEMORY_DEVIATION)
    return {
        "pressure_viscosity": round(spread, 3),
        "viscosity": 0.10 if memory else 0.05,
        # tau0 by k T/V and by 2 Lambda/alpha(p, T) are a factor of 1.4 to 2.3 apart at 1 GPa, the published law of one
        # PAO is 2.8 times the latter (docs/shear.md)
        "eyring_stress": 0.40,
        "limiting_shear": 0.25 if memory else 0.20,
        "thermal_conductivity": 0.10,
        "source": f"ours, by the law of the card ({law.law}) and its certainty ({certainty})",
    }
