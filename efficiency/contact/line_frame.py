"""Directions of the contact lines on the gear flank: along a line of constant roll angle, and square to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.assembly import dot
from efficiency.contact.patch import Patch

FloatArray = NDArray[np.float64]

POSITION = ("x", "y", "z")


@dataclass(frozen=True)
class LineFrame:
    """Tangents of the gear flank at points of contact lines, gear frame.

    Attributes
    ----------
    along : (3, n) array
        Unit tangent of the line of constant roll angle, towards the heel.
    gradient : (3, n) array
        Tangential gradient of the roll angle [rad/m]: the line runs over the gear at ``1/|gradient|`` per unit speed.
    rates_gradient, rates_along : (2, n) arrays
        Change of (u, v) per metre along the gradient and along the line.
    """

    along: FloatArray
    gradient: FloatArray
    rates_gradient: FloatArray
    rates_along: FloatArray


def line_frame(patch: Patch, u: FloatArray, v: FloatArray) -> LineFrame:
    """Directions of the contact lines through points of the gear flank."""
    ru, rv = patch(u, v, POSITION, du=1), patch(u, v, POSITION, dv=1)
    (roll_u,), (roll_v,) = patch(u, v, ("roll",), du=1), patch(u, v, ("roll",), dv=1)
    along = (ru * roll_v - rv * roll_u) * np.sign(roll_v)
    stretch = np.sqrt(dot(along, along))
    rates_along = np.stack([roll_v, -roll_u]) * np.sign(roll_v) / stretch
    e, f, g = dot(ru, ru), dot(ru, rv), dot(rv, rv)
    area = e * g - f * f
    up, vp = (g * roll_u - f * roll_v) / area, (e * roll_v - f * roll_u) / area
    gradient = ru * up + rv * vp
    size = np.sqrt(dot(gradient, gradient))
    return LineFrame(along / stretch, gradient, np.stack([up, vp]) / size, rates_along)
