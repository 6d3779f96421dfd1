"""Flank known as a surface, not by how it was cut: its azimuth as a smooth function of the blank coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from efficiency.blanks.cones import Blank
from efficiency.contact.patch import Patch
from efficiency.cutting.cutter import FlankSide
from efficiency.cutting.flank import Flank
from efficiency.cutting.newton import Array

FloatArray = NDArray[np.float64]
Hand = Literal["left", "right"]


def normal_sense(side: FlankSide, hand: Hand) -> float:
    """+1 where the normal out of the tooth looks towards growing azimuth about the axis, else -1."""
    return 1.0 if (side == "concave") == (hand == "right") else -1.0


@dataclass(frozen=True)
class SmoothFlank(Flank):
    """Surface ``azimuth(u, v)``: u along the pitch cone from the mean point, v the fraction of the whole depth.

    The surface parameters are the blank coordinates u and h [m]; the third one is its own condition.

    Attributes
    ----------
    side : str
        ``"concave"`` or ``"convex"``.
    blank : Blank
        Blank of the member.
    sense : float
        +1 or -1, see `normal_sense`.
    patch : Patch
        Field ``azimuth`` [rad].
    origin : str
        Where the surface comes from, in words for results.
    error : float
        Estimated distance from the surface it stands for, along the normal [m].
    """

    side: FlankSide
    blank: Blank
    sense: float
    patch: Patch
    origin: str
    error: float

    def sweep(self, x: Array) -> tuple[Array, Array, Array]:
        """Point, unit normal and the third parameter at (u, h, third)."""
        u, h = x[0], x[1]
        blank = self.blank
        sine, cosine = np.sin(blank.pitch_angle), np.cos(blank.pitch_angle)
        radius, z = blank.axial(u, h)
        low, high = (float(cone(np.zeros(1))[0]) for cone in (blank.root, blank.tip))
        slope_low, slope_high = float(blank.root(np.ones(1))[0]) - low, float(blank.tip(np.ones(1))[0]) - high
        depth = high - low + (slope_high - slope_low) * u
        v = (h - low - slope_low * u) / depth
        (azimuth,), (by_u,), (by_v,) = self.patch.slopes(u, v, ("azimuth",))
        by_h = by_v / depth
        by_u = by_u - by_v * (slope_low + v * (slope_high - slope_low)) / depth
        c, s = np.cos(azimuth), np.sin(azimuth)
        point = np.stack([radius * c, radius * s, z + 0.0 * azimuth])
        # gradient of azimuth - azimuth(u, h), in radial, circumferential and axial direction, times the radius
        out = np.stack(
            [
                -radius * (by_u * sine + by_h * cosine),
                np.ones_like(azimuth),
                -radius * (by_u * cosine - by_h * sine),
            ]
        )
        normal = self.sense * out / np.sqrt(np.sum(out * out, axis=0))
        turned = np.stack([c * normal[0] - s * normal[1], s * normal[0] + c * normal[1], normal[2]])
        return point, turned, x[2] + 0.0 * azimuth

    def guess(self) -> FloatArray:
        """The mean point."""
        return np.zeros((3, 1))
