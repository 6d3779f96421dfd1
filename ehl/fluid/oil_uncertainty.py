"""How well the figures of an oil card are known: one standard deviation of each input, and factors that shift them."""

from __future__ import annotations

import math
from typing import Annotated, Any

from ehl.common.units import ValueRange
from ehl.common.validation import InputModel

Deviation = Annotated[float, ValueRange("", ge=0.0, le=1.0, hint="One standard deviation, relative: 0.08 is 8 %.")]
Factor = Annotated[float, ValueRange("", gt=0.0, le=100.0)]

VARIABLES = ("pressure_viscosity", "viscosity", "eyring_stress", "limiting_shear", "thermal_conductivity")

# of ln(eta/eta0) of FVA 400 oils about Gold's formula in its own sense, the secant at 0.2 GPa (computed by us)
GOLD_DEVIATION = {"mineral": 0.07, "hydrocracked": 0.08, "pao": 0.17, "polyglycol": 0.17, "ester": 0.12}
# of ln(eta/eta0) by Roelands through a true slope or secant: it bends alike for all oils, and they do not (ours:
# -19 to +13 % at 0.8 GPa over seven oils)
ROELANDS_DEVIATION = 0.12
# of two published sets of the modulus law for one oil, FVA 3: 6 to 9 % at 0.8 GPa
MODULUS_DEVIATION = 0.08
# fits of viscometers up to 1 GPa by free volume or glass transition (ours)
MEASURED_DEVIATION = 0.05
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


def standard_uncertainty(law: str, alpha_law: str, base: str, anchored: bool, certainty: str) -> dict[str, Any]:
    """What is assumed of a card that does not say it, by its law and certainty (ours).

    Parameters
    ----------
    law, alpha_law : str
        Viscosity over pressure and pressure-viscosity coefficient of the card.
    base : str
        Base oil.
    anchored : bool
        Whether Gold's formula goes through a measured point.
    certainty : str
        Of the card.
    """
    memory = certainty == "from memory"
    if law in ("roelands", "barus"):
        level = GOLD_DEVIATION.get(base, 0.17) if alpha_law == "gold" and not anchored else 0.0
        spread = math.hypot(ROELANDS_DEVIATION, level)
    else:
        spread = MODULUS_DEVIATION if law == "modulus" else MEASURED_DEVIATION
    if memory:
        spread = math.hypot(spread, MEMORY_DEVIATION)
    return {
        "pressure_viscosity": round(spread, 3),
        "viscosity": 0.10 if memory else 0.05,
        "eyring_stress": 0.30,
        "limiting_shear": 0.25 if memory else 0.15,
        "thermal_conductivity": 0.10,
        "source": f"ours, by the law of the card ({law}) and its certainty ({certainty})",
    }
