"""Face-milling cutter blade: the edge that sweeps a surface of revolution around the cutter axis.

Cutter frame: tip plane z = 0, blade body at z < 0. The outside blade cuts the concave flank, the inside blade the
convex flank. Plane-sided blades are straight; a curved blade is an arc tangent to the straight edge at the tip.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from efficiency.cutting.newton import Array

FlankSide = Literal["concave", "convex"]


@dataclass(frozen=True)
class Blade:
    """One blade of a face-milling cutter.

    Attributes
    ----------
    point_radius : float
        Radius of the edge at the tip plane [m].
    blade_angle : float
        Angle of the edge at the tip against the cutter axis [rad].
    side : str
        Flank it cuts: ``"concave"`` (outside blade) or ``"convex"`` (inside blade).
    curvature : float
        Curvature of the edge [1/m], 0 for a straight edge; positive turns the edge away from the axis direction
        with growing distance from the tip.
    """

    point_radius: float
    blade_angle: float
    side: FlankSide
    curvature: float = 0.0

    @property
    def sign(self) -> float:
        """+1 for the outside blade, -1 for the inside blade."""
        return 1.0 if self.side == "concave" else -1.0

    def surface(self, s: Array, th: Array) -> tuple[Array, Array]:
        """Cutter surface and its normal out of the tooth that is left standing.

        Parameters
        ----------
        s : (n,) array
            Length along the edge from the tip [m]; real or complex.
        th : (n,) array
            Angle around the cutter axis [rad]; real or complex.

        Returns
        -------
        point, normal : (3, n) arrays
            In the cutter frame [m], [-].
        """
        turn = 0.5 * self.curvature * s
        chord = s * np.sinc(turn / np.pi)
        radius = self.point_radius + self.sign * chord * np.sin(self.blade_angle + turn)
        slope = self.blade_angle + 2.0 * turn
        point = np.stack(
            [radius * np.cos(th), radius * np.sin(th), -chord * np.cos(self.blade_angle + turn) + 0.0 * th]
        )
        flat = -self.sign * np.cos(slope)
        normal = np.stack([flat * np.cos(th), flat * np.sin(th), -np.sin(slope) + 0.0 * th])
        return point, normal
