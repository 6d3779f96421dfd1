"""Cutting edge in the plane of its blade: arcs and straight pieces tangent to each other.

Blade plane: xi towards the cut flank, eta from the tip plane into the blade body. The angle of the edge is measured
from the eta axis (the cutter axis), so ``d(xi, eta)/ds = (sin, cos)``; s increases away from the tip. All arithmetic is
holomorphic in s and in the parameters of the edge.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import acos
from typing import Annotated, Any, Self

import numpy as np
from pydantic import model_validator

from efficiency.cutting.blank import Length
from efficiency.cutting.newton import Array
from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel

# parameters of an edge may have a complex step
Scalar = Any


class Relief(InputModel):
    """Toprem or flankrem: part of an edge that deviates from the profile along an arc and removes more material."""

    height: Length  # height of the start of the arc above the tip plane [m]
    radius: Length  # radius of the arc [m]
    # angle of the arc, which a straight line continues [rad]; None: the arc extends to the end
    angle: Annotated[float, ValueRange("rad", gt=0.0, le=0.5)] | None = None


class Protuberance(InputModel):
    """Thickening of the blade below a height: two arcs, then an edge parallel to the profile."""

    height: Length  # height of the start above the tip plane [m]
    # normal distance of the parallel edge from the profile [m]
    amount: Annotated[float, ValueRange("m", gt=0.0, le=2e-3)]
    radius: Length  # radius of both arcs [m], at least half the amount

    @model_validator(mode="after")
    def _arcs_reach(self) -> Self:
        if self.amount >= 2.0 * self.radius:
            raise InputError("amount", f"{self.amount * 1e3:.6g} mm", "below twice the radius of its arcs")
        # both arcs lie between the start and the tip plane
        run = 2.0 * self.radius * acos(1.0 - 0.5 * self.amount / self.radius)
        if run >= self.height:
            raise InputError(
                "radius",
                f"{self.radius * 1e3:.6g} mm",
                f"small enough that both arcs ({run * 1e3:.3g} mm) fit below the height of {self.height * 1e3:.3g} mm",
            )
        return self


@dataclass(frozen=True)
class Piece:
    """Arc or straight line through a given point."""

    s: Scalar  # length along the edge at the point [m]
    # the point [m]
    xi: Scalar
    eta: Scalar
    angle: Scalar  # angle of the edge there [rad]
    curvature: Scalar  # derivative of the angle by s [1/m], 0 for a straight line

    def at(self, s: Scalar) -> tuple[Array, Array, Array, Array]:
        """xi, eta, angle and curvature at lengths s; the same formula applies to arcs and lines."""
        length = s - self.s
        turn = 0.5 * self.curvature * length
        chord = length * np.sinc(turn / np.pi)
        xi = self.xi + chord * np.sin(self.angle + turn)
        eta = self.eta + chord * np.cos(self.angle + turn)
        return xi, eta, self.angle + 2.0 * turn, self.curvature + 0.0 * length

    def continued(self, s: Scalar, curvature: Scalar) -> Piece:
        """Tangent continuation from length s with another curvature."""
        xi, eta, angle, _ = self.at(s)
        return Piece(s, xi, eta, angle, curvature)

    def length_at(self, height: float) -> Scalar:
        """Length s where eta has a given value, by Newton's method."""
        s = self.s
        for _ in range(8):
            _, eta, angle, _ = self.at(s)
            s = s - (eta - height) / np.cos(angle)
        return s


@dataclass(frozen=True)
class Edge:
    """Pieces of an edge in order of s; the first and the last one are unbounded."""

    pieces: tuple[Piece, ...]
    breaks: tuple[Scalar, ...] = ()  # lengths s at the ends of pieces [m], one less than pieces

    def at(self, s: Array) -> tuple[Array, Array, Array, Array]:
        """xi, eta, angle and curvature at lengths s."""
        if not self.breaks:
            return self.pieces[0].at(s)
        own = np.searchsorted(np.real(np.array(self.breaks)), np.real(s))
        values = np.array([[p.s, p.xi, p.eta, p.angle, p.curvature] for p in self.pieces])
        return Piece(*values[own].T).at(s)

    def length_at(self, height: float) -> float:
        """Length s at a height above the tip plane."""
        ends = [float(np.real(self.pieces[k].at(end)[1])) for k, end in enumerate(self.breaks)]
        return float(np.real(self.pieces[int(np.searchsorted(ends, height))].length_at(height)))


def profile(
    angle: float,
    curvature: float,
    reference_height: float,
    toprem: Relief | None = None,
    protuberance: Protuberance | None = None,
    flankrem: Relief | None = None,
) -> Edge:
    """Edge that cuts the flank: main profile with toprem or protuberance below and flankrem above it.

    The profile has xi = 0 and the given angle at the reference height; s is measured from the tip plane along the
    tangent at that point.
    """
    start = reference_height / np.cos(angle)
    main = Piece(start, 0.0, reference_height, angle, curvature)
    pieces = [main]
    breaks: list[Scalar] = []
    if toprem is not None:
        low = main.length_at(toprem.height)
        arc = main.continued(low, 1.0 / toprem.radius)
        pieces, breaks = [arc, *pieces], [low, *breaks]
        if toprem.angle is not None:
            end = low - toprem.angle * toprem.radius
            pieces, breaks = [arc.continued(end, 0.0), *pieces], [end, *breaks]
    if protuberance is not None:
        low = main.length_at(protuberance.height)
        length = protuberance.radius * np.arccos(1.0 - 0.5 * protuberance.amount / protuberance.radius)
        away = main.continued(low, 1.0 / protuberance.radius)
        back = away.continued(low - length, -1.0 / protuberance.radius)
        parallel = back.continued(low - 2.0 * length, 0.0)
        pieces, breaks = [parallel, back, away, *pieces], [low - 2.0 * length, low - length, low, *breaks]
    if flankrem is not None:
        high = main.length_at(flankrem.height)
        arc = main.continued(high, 1.0 / flankrem.radius)
        pieces, breaks = [*pieces, arc], [*breaks, high]
        if flankrem.angle is not None:
            end = high + flankrem.angle * flankrem.radius
            pieces, breaks = [*pieces, arc.continued(end, 0.0)], [*breaks, end]
    return Edge(tuple(pieces), tuple(breaks))


def tip_arc(edge: Edge, radius: float) -> Piece:
    """Arc of the edge radius, tangent to the lowest piece of an edge and to the tip plane."""
    lowest = edge.pieces[0]
    s = lowest.s
    for _ in range(8):
        # the centre of the arc lies one radius above the tip plane and one radius inside the edge
        _, eta, angle, _ = lowest.at(s)
        s = s - (eta - radius * (1.0 - np.sin(angle))) / (np.cos(angle) * (1.0 + radius * lowest.curvature))
    return lowest.continued(s, -1.0 / radius)
