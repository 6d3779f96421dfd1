"""Blank of one member: cones, face width, tooth height along the face (ISO 23509 terms).

Blank coordinates of a point: u, its distance along the pitch cone from the mean point towards the heel, and h, its
height square to the pitch cone, positive towards the tooth tip.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray

from ehl.common.units import ValueRange

Hand = Literal["left", "right"]
Length = Annotated[float, ValueRange("m", gt=0.0, le=3.0)]
Depth = Annotated[float, ValueRange("m", ge=0.0, le=0.2)]
Shift = Annotated[float, ValueRange("m", ge=-1.0, le=1.0)]

FloatArray = NDArray[np.float64]
Array = NDArray[np.inexact[Any]]
"""Real or complex."""


@dataclass(frozen=True)
class Blank:
    """Cones of one member, SI units and rad.

    Attributes
    ----------
    teeth : int
        Number of teeth.
    pitch_angle : float
        Pitch cone angle.
    mean_cone_distance, face_width : float
        Along the pitch cone; the mean point lies in the middle of the face.
    mean_addendum, mean_dedendum : float
        At the mean point, square to the pitch cone.
    addendum_angle, dedendum_angle : float
        Of face and root cone against the pitch cone.
    pitch_apex_beyond_crossing : float
        Distance of the pitch apex beyond the crossing point, away from the heel; 0 for a bevel pair.
    """

    teeth: int
    pitch_angle: float
    mean_cone_distance: float
    face_width: float
    mean_addendum: float
    mean_dedendum: float
    addendum_angle: float
    dedendum_angle: float
    pitch_apex_beyond_crossing: float = 0.0

    def axial(self, u: FloatArray, h: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Radius and axial position [m] of blank coordinates."""
        cone = self.mean_cone_distance + u
        c, s = np.cos(self.pitch_angle), np.sin(self.pitch_angle)
        return cone * s + h * c, cone * c - h * s - self.pitch_apex_beyond_crossing

    def coordinates(self, radius: Array, z: Array) -> tuple[Array, Array]:
        """Blank coordinates (u, h) [m] of a radius and an axial position; the inverse of `axial`."""
        c, s = np.cos(self.pitch_angle), np.sin(self.pitch_angle)
        along = z + self.pitch_apex_beyond_crossing
        return radius * s + along * c - self.mean_cone_distance, radius * c - along * s

    def root(self, u: FloatArray) -> FloatArray:
        """Height of the root cone [m], negative."""
        return -self.mean_dedendum - u * float(np.tan(self.dedendum_angle))

    def tip(self, u: FloatArray) -> FloatArray:
        """Height of the face cone [m]."""
        return self.mean_addendum + u * float(np.tan(self.addendum_angle))

    def height(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Height [m] of the fraction v of the whole depth, 0 at the root and 1 at the tip."""
        root = self.root(u)
        return root + v * (self.tip(u) - root)
