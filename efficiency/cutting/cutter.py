"""Cutter blade of a face mill or a face-hob head: its edge in the head and the surface it sweeps.

Cutter frame: tip plane z = 0, blade body at z < 0. The outside blade cuts the concave flank, the inside blade the
convex flank. The edge of a face-mill blade lies in an axial plane. That of a face-hob blade lies in a plane turned from
there by the blade offset angle, so that it is square to the cutting velocity at the reference radius; rake and hook
angle lean it out of that plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from efficiency.cutting.edge import Edge, Piece, Protuberance, Relief, profile, tip_arc
from efficiency.cutting.newton import Array
from efficiency.cutting.rotation import cross, spin, turn, unit

FlankSide = Literal["concave", "convex"]
FLANK_SIDES: tuple[FlankSide, FlankSide] = ("concave", "convex")
EdgePart = Literal["flank", "fillet"]


@dataclass(frozen=True)
class Blade:
    """One blade, or one group of equal blades, of a cutter: numbers of `BladeInput`, which a fit may differentiate."""

    # radius of the profile at the reference height [m]; with no reference height at the tip plane (profile extended)
    point_radius: float
    blade_angle: float
    side: FlankSide  # flank it cuts: ``"concave"`` (outside blade) or ``"convex"`` (inside blade)
    # of the profile [1/m]; positive turns the edge away from the axis direction with growing distance from the tip
    curvature: float = 0.0
    reference_height: float = 0.0
    edge_radius: float = 0.0
    toprem: Relief | None = None
    protuberance: Protuberance | None = None
    flankrem: Relief | None = None
    radius_offset: float = 0.0  # shift of the blade square to its cutting direction, outwards [m]
    groups: int = 0  # blade groups of a face-hob head (starts); 0 for a face mill
    # angle of the blade plane against the axial plane [rad]; positive for the head of a right-hand member
    offset_angle: float = 0.0
    phase: float = 0.0  # angle by which the blade is ahead in the head, in the sense of growing cutter angle [rad]
    # lean of the edge forward, in the sense of growing cutter angle, per distance from the reference point outwards and
    # into the blade body [rad]
    rake: float = 0.0
    hook: float = 0.0
    # part of the edge that cuts: the profile with its reliefs, ``"flank"``, or the edge radius, ``"fillet"``
    part: EdgePart = "flank"

    @property
    def sign(self) -> float:
        """+1 for the outside blade, -1 for the inside blade."""
        return 1.0 if self.side == "concave" else -1.0

    @cached_property
    def profile(self) -> Edge:
        """Profile with its reliefs, in the blade plane."""
        return profile(
            self.blade_angle, self.curvature, self.reference_height, self.toprem, self.protuberance, self.flankrem
        )

    @cached_property
    def tip_arc(self) -> Piece | None:
        """Arc of the edge radius; None for a sharp corner."""
        return tip_arc(self.profile, self.edge_radius) if self.edge_radius else None

    @property
    def profile_start(self) -> float:
        """Length s where the profile begins above the edge radius, or at a sharp corner [m]."""
        return float(np.real(self.tip_arc.s)) if self.tip_arc else self.profile.length_at(0.0)

    @property
    def tip(self) -> float:
        """Length s of the end of the edge radius at the tip plane, or of a sharp corner [m]."""
        if self.tip_arc is None:
            return self.profile.length_at(0.0)
        return self.profile_start - float(np.real((0.5 * np.pi - self.tip_arc.angle) * self.edge_radius))

    def edge(self, s: Array) -> tuple[Array, Array, Array]:
        """Edge in the head at cutter angle zero: points, their first and their second derivative by s.

        s (n,): length along the edge [m], projected to the blade plane; real or complex.
        Returns: point, tangent, bend: in the cutter frame [m], [-], [1/m].
        """
        cutting = self.profile if self.part == "flank" or self.tip_arc is None else Edge((self.tip_arc,))
        xi, eta, angle, curvature = cutting.at(s)
        across, climb = self.sign * np.sin(angle), np.cos(angle)
        shift, bend, sink = self.sign * xi, self.sign * curvature * climb, -self.sign * curvature * across
        if self.offset_angle == 0.0 and self.rake == 0.0 and self.hook == 0.0:
            zero = 0.0 * xi
            radius = self.point_radius + self.radius_offset + shift
            return np.array([radius, zero, -eta]), np.array([across, zero, -climb]), np.array([bend, zero, -sink])
        rake, hook = np.tan(self.rake), np.tan(self.hook)
        c, d = np.cos(self.offset_angle), np.sin(self.offset_angle)

        def in_head(outwards: Array, deeper: Array) -> Array:
            """Components along the blade plane and into the body; the lean puts them forward, square to the plane."""
            lead = outwards * rake + deeper * hook
            return np.array([outwards * c - lead * d, outwards * d + lead * c, -deeper])

        start = np.array(
            [[self.point_radius + self.radius_offset * c], [self.radius_offset * d], [-self.reference_height]]
        )
        point = start + in_head(shift, eta - self.reference_height)
        return point, in_head(across, climb), in_head(bend, sink)

    def surface(self, s: Array, th: Array) -> tuple[Array, Array]:
        """Surface of revolution that the edge sweeps around the cutter axis, and its normal out of the tooth.

        s (n,): length along the edge [m]; real or complex.
        th (n,): cutter angle [rad]; real or complex.
        Returns: point, normal: in the cutter frame [m], [-].
        """
        edge, along, _ = self.edge(s)
        point, tangent = turn(edge, th), turn(along, th)
        return point, -self.sign * unit(cross(tangent, spin(point)))
