"""Tip and end relief: what a shop takes off a finished flank next to its tip, toe and heel.

Relief is a depth square to the flank that grows from nothing at its length from the edge to its amount at the edge.
Across a line of contact the flanks part as x^2/(2R) from their closest approach; relief adds r(x). Where both are least
together is the closest approach of the relieved flanks: it moves away from the edge, the gap there grows, the curvature
changes. Before and after the path of the flanks the edge itself touches only where the flank next to it does not come
first.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from efficiency.cutting.blank import Blank

FloatArray = NDArray[np.float64]
ReliefForm = Literal["linear", "parabolic", "circular"]

# samples of the sections: over the range, then between the neighbours of the lowest one
_COARSE, _FINE = 41, 21
# the curvature of relief is that over so much to both sides: about the half-width of a loaded contact [m]
_WIDTH = 1e-4


@dataclass(frozen=True)
class EdgeRelief:
    """Relief next to one edge.

    Attributes
    ----------
    amount : float
        Depth at the edge, square to the flank [m].
    length : float
        From the edge to where it begins, over the blank [m].
    form : {"linear", "parabolic", "circular"}
        A flat chamfer, a parabola, or an arc; the last two are tangent to the flank.
    """

    amount: float
    length: float
    form: ReliefForm = "parabolic"

    def depth(self, distance: FloatArray) -> FloatArray:
        """Depth [m] at distances from the edge [m]; beyond the edge the form goes on."""
        reach = np.maximum(self.length - distance, 0.0)
        if self.form == "linear":
            return np.asarray(self.amount * reach / self.length)
        if self.form == "parabolic":
            return np.asarray(self.amount * (reach / self.length) ** 2)
        radius = 0.5 * (self.length**2 + self.amount**2) / self.amount
        return np.asarray(radius - np.sqrt(radius**2 - np.minimum(reach, 0.999 * radius) ** 2))


@dataclass(frozen=True)
class MemberRelief:
    """Relief of the flanks of a member; None where an edge has none.

    Where two meet in a corner the deeper one counts: each was taken off the flank by itself.
    """

    tip: EdgeRelief | None = None
    toe: EdgeRelief | None = None
    heel: EdgeRelief | None = None

    def depth(self, blank: Blank, u: FloatArray, h: FloatArray) -> FloatArray:
        """Depth [m] at blank coordinates (u, h) [m]."""
        half = 0.5 * blank.face_width
        depths = [np.zeros(np.broadcast_shapes(np.shape(u), np.shape(h)))]
        for relief, distance in ((self.tip, blank.tip(u) - h), (self.toe, u + half), (self.heel, half - u)):
            if relief is not None:
                depths.append(relief.depth(distance))
        return np.asarray(np.max(depths, axis=0))

    def __bool__(self) -> bool:
        return any(part is not None for part in (self.tip, self.toe, self.heel))


@dataclass(frozen=True)
class PairRelief:
    """Relief of both members."""

    pinion: MemberRelief = field(default_factory=MemberRelief)
    gear: MemberRelief = field(default_factory=MemberRelief)

    def __bool__(self) -> bool:
        return bool(self.pinion) or bool(self.gear)


@dataclass(frozen=True)
class ReliefSection:
    """Closest approach of relieved flanks in sections across their lines of contact.

    Attributes
    ----------
    place : (n,) array
        Where it lies across the line [m].
    gap : (n,) array
        Separation there over that of the closest approach without relief [m].
    curvature : (n,) array
        Relative curvature there [1/m].
    """

    place: FloatArray
    gap: FloatArray
    curvature: FloatArray


def relief_section(
    depth: Callable[[FloatArray], FloatArray], curvature: FloatArray, centre: FloatArray
) -> ReliefSection:
    """Least of ``curvature (x - centre)^2/2 + depth(x)`` in n sections.

    Parameters
    ----------
    depth : callable
        Relief [m] at places (n, m) across the lines [m].
    curvature : (n,) array
        Of the flanks without relief, positive [1/m].
    centre : (n,) array
        Their closest approach [m].
    """
    at_centre = depth(centre[:, None])[:, 0]
    # farther away the parabola alone is higher than relief makes the centre
    reach = np.sqrt(2.0 * at_centre / curvature)
    place, rows = centre, np.arange(centre.size)
    for count in (_COARSE, _FINE, _FINE):
        x = place[:, None] + reach[:, None] * np.linspace(-1.0, 1.0, count)
        gap = 0.5 * curvature[:, None] * (x - centre[:, None]) ** 2 + depth(x)
        least = np.argmin(gap, axis=1)
        place, reach = x[rows, least], reach * (2.0 / (count - 1))
    lowest = gap[rows, least]
    around = depth(place[:, None] + _WIDTH * np.array([-1.0, 0.0, 1.0]))
    bend = np.maximum((around[:, 0] - 2.0 * around[:, 1] + around[:, 2]) / _WIDTH**2, 0.0)
    return ReliefSection(place, lowest, curvature + bend)
