"""Fields of a loaded mesh over one flank, from all contact lines of a pitch.

The lines of all tooth pairs at all positions of a pitch, sorted by their roll angle, are the contact lines of one flank
during its engagement. They form a grid of lines (rows) and of points along each line (columns).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from efficiency.contact.gear_flanks import GearFlanks, Member
from efficiency.loss.efficiency_result import EfficiencyResult
from ehl.common.arrays import BoolArray, FloatArray, IntArray

# least number of lines, and of points on a line, for a field
_MIN_POINTS = 2


@dataclass(frozen=True)
class FlankMap:
    """Fields over the flank; arrays (lines, points) in SI units."""

    flanks: GearFlanks  # the pair
    result: EfficiencyResult  # result at one operating point
    roll: FloatArray  # roll angle of the tooth pair at each line [rad of the pinion]
    # indices of the points of each line among all points of the cycle, with the positions concatenated
    lines: tuple[IntArray, ...]
    edges: IntArray  # indices of the points where an edge contacts the mating flank; they lie on no contact line

    @classmethod
    def of(cls, flanks: GearFlanks, result: EfficiencyResult) -> FlankMap:
        """The lines of a result, sorted by roll angle."""
        rolls, lines, edges = [], [], [np.zeros(0, np.int64)]
        start, pitch = 0, result.cycle.pitch
        for load in result.load.positions:
            p = load.position
            for part in p.lines:
                if p.edge is not None and p.edge.touching[part[0]]:
                    edges.append(start + part)
                elif part.size >= _MIN_POINTS:
                    rolls.append(p.pinion_angle + float(p.pair[part[0]]) * pitch)
                    lines.append(start + part)
            start += p.pair.size
        order = np.argsort(rolls)
        ordered = tuple(lines[k] for k in order)
        return cls(flanks, result, np.array(rolls)[order], ordered, np.concatenate(edges))

    @property
    def drawable(self) -> bool:
        """Whether there are enough lines for a field."""
        return len(self.lines) >= _MIN_POINTS

    def _grid(self, values: FloatArray) -> FloatArray:
        """Values of all points on the grid; lines with fewer points than the longest are interpolated."""
        count = max(line.size for line in self.lines)
        return np.array(
            [
                values[line]
                if line.size == count
                else np.interp(np.linspace(0.0, line.size - 1.0, count), np.arange(line.size), values[line])
                for line in self.lines
            ]
        )

    def of_load(self, name: str) -> FloatArray:
        """An array of the `PositionLoad` at every point; zero without load."""
        return self._grid(self._every(name))

    def _every(self, name: str) -> FloatArray:
        """An array of the `PositionLoad` or of its `MeshPosition` at all points of the cycle."""
        return np.concatenate(
            [getattr(p if hasattr(p, name) else p.position, name) for p in self.result.load.positions]
        )

    def of_loaded(self, values: FloatArray) -> FloatArray:
        """Values of the loaded points; nan at the others."""
        points = self.result.points
        sizes = [load.position.pair.size for load in self.result.load.positions]
        starts = np.concatenate([[0], np.cumsum(sizes)])
        every = np.full(starts[-1], np.nan)
        every[starts[points.position] + points.index] = values
        return self._grid(every)

    @property
    def loaded(self) -> BoolArray:
        """Mask of the loaded points."""
        return np.asarray(self.of_load("force") > 0.0)

    def local(self, name: str) -> FloatArray:
        """A value at every point by name; zero or nan without load.

        name: ``friction_coefficient``, ``loss_density``, ``film_specific``, or a field of `ContactState` or
            `LocalLubrication`.
        """
        if name in ("pressure_hertz", "load_per_length"):
            return self.of_load(name)
        if name == "friction_coefficient":
            return self.of_loaded(self.result.friction.mu)
        if name == "loss_density":
            return self.loss_density
        if name == "film_specific":
            return self.of_loaded(self.result.strength.points_film_specific)
        lubrication, state = self.result.lubrication, self.result.points.state
        return self.of_loaded(getattr(lubrication if hasattr(lubrication, name) else state, name))

    def place(self, member: Member = "gear") -> tuple[FloatArray, FloatArray]:
        """Blank coordinates on a member [m]: distance from the mean point along the pitch cone, and height."""
        u, h = self._place(member)
        return self._grid(u), self._grid(h)

    def _place(self, member: Member) -> tuple[FloatArray, FloatArray]:
        blank = self.flanks.blank(member)
        u = self._every(f"face_{member}") - 0.5 * blank.face_width
        return u, self._every(f"height_{member}") + blank.root(u)

    def loaded_edges(self, member: Member = "gear") -> tuple[FloatArray, FloatArray]:
        """Blank coordinates on a member [m] of the points where an edge carries load on the mating flank."""
        u, h = self._place(member)
        at = self.edges[self._every("force")[self.edges] > 0.0]
        return u[at], h[at]

    @cached_property
    def area(self) -> FloatArray:
        """Projected area of the gear flank represented by each point [m2]."""
        u, h = self.place()
        u_line, u_point = np.gradient(u)
        h_line, h_point = np.gradient(h)
        return np.asarray(np.abs(u_line * h_point - u_point * h_line))

    @cached_property
    def loss_density(self) -> FloatArray:
        """Mean power loss of the mesh per projected area of the gear flank [W/m2].

        Its integral is the loss without the loss at edges.
        """
        points = self.result.points
        power = self.of_loaded(self.result.friction.mu * points.state.load_per_length * points.speed_sliding)
        share = np.array([line.size for line in self.lines]) / self.area.shape[1]
        lost = power * self._grid(self._every("length")) * share[:, None]
        known = self.area > 0.0
        density = np.full(lost.shape, np.nan)
        density[known] = lost[known] / (self.result.solution.positions * self.area[known])
        return density

    @cached_property
    def sliding(self) -> tuple[FloatArray, FloatArray]:
        """Sliding velocity of the pinion relative to the gear, projected onto the gear flank [m/s].

        Components along the pitch cone to the heel and normal to it to the tip.
        """
        # if the gear drives, all velocities are reversed
        at = self.result.conditions
        speed = at.speed if at.driver == "pinion" else -at.speed
        pitch_angle, u, h = self.flanks.blank("gear").pitch_angle, [], []
        c, s = np.cos(pitch_angle), np.sin(pitch_angle)
        for load in self.result.load.positions:
            p = load.position
            sliding = p.sliding_along[:, None] * p.along + p.sliding_across[:, None] * p.across
            # the gear rotates about z through the origin
            radius = np.hypot(p.position[:, 0], p.position[:, 1])
            radial = (sliding[:, 0] * p.position[:, 0] + sliding[:, 1] * p.position[:, 1]) / radius
            u.append(radial * s + sliding[:, 2] * c)
            h.append(radial * c - sliding[:, 2] * s)
        return self._grid(np.concatenate(u)) * speed, self._grid(np.concatenate(h)) * speed
