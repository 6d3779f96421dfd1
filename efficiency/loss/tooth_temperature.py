"""Bulk temperature of the teeth by the published estimate of ISO/TR 15144-1 (after Oster 1982): hotter with the loss.

The friction of the estimate is that of the normal forces alone on the coarse grid, with the form of a fitted formula;
the loss at the temperature found differs from it by less than the scatter of the estimate (ours: 30 % of the rise).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Literal

import numpy as np

from efficiency.loss.kinematics import Operation
from ehl.common.validation import InputModel
from ehl.fluid.viscosity import TEMPERATURE_RANGE

Lubrication = Literal["dip", "spray", "submerged"]
# X_S of the report
LUBRICATION_FACTORS: dict[str, float] = {"dip": 1.0, "spray": 1.2, "submerged": 0.2}
# scatter of the estimate (ours), standard deviation of the rise
SCATTER = 0.30
_CLOSE, _ROUNDS = 0.02, 40  # [K]


class CoolingInput(InputModel):
    """Table [cooling]: how the teeth are lubricated."""

    lubrication: Lubrication = "dip"  # factor 1, 1.2 and 0.2 on the rise of their bulk temperature


def iso_15144_bulk_rise(power_loss: float, centre_distance: float, face_width: float, factor: float = 1.0) -> float:
    """Rise of the bulk temperature of both members over the oil [K].

    ``7400 (P mu_m H_v/(a b))^0.72 X_S/(1.2 X_Ca)``, ISO/TR 15144-1:2014, formula (84), P mu_m H_v the loss in kW, a and
    b in mm; read in a public transcription. X_Ca, a factor of tip relief of 1 to about 1.5, is taken as 1.

    power_loss: sliding friction [W].
    centre_distance, face_width: [m]; of a bevel or hypoid pair the sum of the mean pitch radii and the smaller face
        width (ours).
    factor: X_S [-].
    """
    density = 1e-3 * max(power_loss, 0.0) / (1e6 * centre_distance * face_width)
    return float(7400.0 * density**0.72 * factor / 1.2)


def warmed(operation: Operation, rise: float) -> Operation:
    """The operation with teeth so much warmer than the oil [K], which enters the contacts as warm as they are."""
    bulk = min(operation.temperature + rise, TEMPERATURE_RANGE[1])
    return replace(operation, temperature_bulk_pinion=bulk, temperature_bulk_gear=bulk, temperature_inlet=bulk)


def warm_operation(
    loss: Callable[[Operation], float], operation: Operation, size: tuple[float, float], factor: float
) -> Operation:
    """The operation with the bulk temperature that its own loss makes.

    loss: power loss at an operation [W].
    operation: with cold teeth.
    size: centre distance and face width [m].
    factor: X_S [-].
    """
    rise, most = 0.0, TEMPERATURE_RANGE[1] - operation.temperature
    for _ in range(_ROUNDS):
        found = min(iso_15144_bulk_rise(loss(warmed(operation, rise)), *size, factor), most)
        if not np.isfinite(found):
            return operation
        # the loss changes by about 1 % a kelvin either way: the mean damps what swings
        step, rise = found - rise, found if abs(found - rise) < 2.0 else 0.5 * (found + rise)
        if abs(step) < _CLOSE:
            break
    return warmed(operation, rise)
