"""What a loaded mesh does to one flank: all contact lines of a pitch side by side, as fields over the flank.

The lines of all tooth pairs at all positions of a pitch are, in the order of their roll angle, the lines that sweep one
flank as it goes through the mesh: a grid of lines (rows) and of points along each line (columns).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from efficiency.contact.contact_lines import MeshPosition
    from efficiency.design import Design
    from efficiency.loss.result import EfficiencyResult

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]
Member = Literal["pinion", "gear"]


@dataclass(frozen=True)
class FlankMap:
    """Fields over the flank; arrays (lines, points) in SI units.

    Attributes
    ----------
    design : Design
        The pair.
    result : EfficiencyResult
        Of one operating point.
    roll : (lines,) array
        Roll angle of the tooth pair at each line [rad of the pinion].
    order : (lines, points) array
        Where each point stands among all points of the cycle, the positions one after the other.
    """

    design: Design
    result: EfficiencyResult
    roll: FloatArray
    order: IntArray

    @classmethod
    def of(cls, design: Design, result: EfficiencyResult) -> FlankMap:
        """The lines of a result in the order of their roll angle."""
        rolls, lines = [], []
        start, step = 0, float(result.pinion_angle[1] - result.pinion_angle[0])
        for load in result.load.positions:
            p = load.position
            # lines are consecutive: a new one starts where the pair changes
            for part in np.split(np.arange(p.pair.size), np.flatnonzero(np.diff(p.pair)) + 1):
                rolls.append(p.pinion_angle + float(p.pair[part[0]]) * step * result.positions)
                lines.append(start + part)
            start += p.pair.size
        sorting = np.argsort(rolls)
        return cls(design, result, np.array(rolls)[sorting], np.array(lines)[sorting])

    def of_positions(self, name: str) -> FloatArray:
        """An array of the `MeshPosition` of every point."""
        return self._grid(np.concatenate([getattr(load.position, name) for load in self.result.load.positions]))

    def of_load(self, name: str) -> FloatArray:
        """An array of the `PositionLoad` of every point: zero where there is no load."""
        return self._grid(np.concatenate([getattr(load, name) for load in self.result.load.positions]))

    def of_loaded(self, values: FloatArray) -> FloatArray:
        """Values of the loaded points; nan at the others."""
        points = self.result.points
        sizes = [load.position.pair.size for load in self.result.load.positions]
        starts = np.concatenate([[0], np.cumsum(sizes)])
        every = np.full(starts[-1], np.nan)
        every[starts[points.position] + points.index] = values
        return self._grid(every)

    def _grid(self, values: FloatArray) -> FloatArray:
        return np.asarray(values[self.order])

    @property
    def loaded(self) -> BoolArray:
        """Where there is load."""
        return np.asarray(self.of_load("force") > 0.0)

    def local(self, name: str) -> FloatArray:
        """A value of the loaded points by its name; nan without load.

        ``friction_coefficient``, ``loss_density``, a name of `ContactState` or of `LocalLubrication`.
        """
        if name == "friction_coefficient":
            return self.of_loaded(self.result.friction.mu)
        if name == "loss_density":
            return self.loss_density
        lubrication, state = self.result.lubrication, self.result.points.state
        return self.of_loaded(getattr(lubrication if hasattr(lubrication, name) else state, name))

    def place(self, member: Member = "gear") -> tuple[FloatArray, FloatArray]:
        """Blank coordinates of the points on a member [m]: along the pitch cone from the mean point, and over it."""
        part = self.design.gear if member == "gear" else self.design.pinion
        blank = part.blank.blank()
        u = self.of_positions(f"face_{member}") - 0.5 * blank.face_width
        return u, self.of_positions(f"height_{member}") + blank.root(u)

    @cached_property
    def area(self) -> FloatArray:
        """Projected area of the gear flank each point stands for [m2]."""
        u, h = self.place()
        u_line, u_point = np.gradient(u)
        h_line, h_point = np.gradient(h)
        return np.asarray(np.abs(u_line * h_point - u_point * h_line))

    @cached_property
    def loss_density(self) -> FloatArray:
        """Mean power loss of the mesh per projected area of the gear flank [W/m2]; its integral is the loss."""
        power = self.result.friction.mu * self.result.points.force * self.result.points.speed_sliding
        return self.of_loaded(power) / (self.result.positions * self.area)

    @cached_property
    def sliding(self) -> tuple[FloatArray, FloatArray]:
        """Sliding velocity, pinion against gear, in the projection of the gear flank [m/s]: along the pitch cone to
        the heel, and square to it to the tip."""
        # where the gear drives everything moves the other way
        speed = self.result.speed_pinion * (1.0 if self.result.driver == "pinion" else -1.0)
        positions = [load.position for load in self.result.load.positions]
        parts = [_projected(p, self.design.gear.blank.pitch_angle) for p in positions]
        u, h = (self._grid(np.concatenate([part[k] for part in parts])) * speed for k in (0, 1))
        return u, h


def _projected(p: MeshPosition, pitch_angle: float) -> tuple[FloatArray, FloatArray]:
    """Components of the sliding vector per unit pinion speed along and square to the pitch cone of the gear [m]."""
    sliding = p.sliding_along[:, None] * p.along + p.sliding_across[:, None] * p.across
    # the gear turns about z through the origin
    radius = np.hypot(p.position[:, 0], p.position[:, 1])
    radial = (sliding[:, 0] * p.position[:, 0] + sliding[:, 1] * p.position[:, 1]) / radius
    c, s = np.cos(pitch_angle), np.sin(pitch_angle)
    return np.asarray(radial * s + sliding[:, 2] * c), np.asarray(radial * c - sliding[:, 2] * s)
