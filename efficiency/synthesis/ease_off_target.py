"""Wanted ease-off over the gear flank."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from efficiency.synthesis.inputs import FlankTarget

FloatArray = NDArray[np.float64]


def wanted_relief(target: FlankTarget, x: FloatArray, y: FloatArray) -> FloatArray:
    """Relief [m] at places on the face (-1 toe, 1 heel) and the working depth (-1 root, 1 tip of the gear).

    With ``X = x - contact_face - bias (y - contact_depth)`` and ``Y = y - contact_depth`` it is
    ``(heel + toe)/2 X^2 + (heel - toe)/2 X^3 + (tip + root)/2 Y^2 + (tip - root)/2 Y^3 + twist (x - contact_face) Y``:
    smooth, and the amounts of the targets at the ends of both axes for a contact in the middle.
    """
    across = y - target.contact_depth
    along = x - target.contact_face - target.bias * across
    lengthwise = _ends(along, target.crowning_toe, target.crowning_heel)
    return (
        lengthwise
        + _ends(across, target.relief_root, target.relief_tip)
        + target.twist * (x - target.contact_face) * across
    )


def _ends(x: FloatArray, low: float, high: float) -> FloatArray:
    return np.asarray((0.5 * (high + low) + 0.5 * (high - low) * x) * x * x)
