"""Flanks: the interface all of them share, and the flank that a cutter leaves on a blank."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from efficiency.blanks.cones import Blank
from efficiency.cutting import newton
from efficiency.cutting.cutter import Blade, FlankSide
from efficiency.cutting.machine import MachineSettings
from efficiency.cutting.newton import Array
from efficiency.cutting.rotation import cross, dot, spin, turn, unit
from ehl.io.errors import ConvergenceError

FloatArray = NDArray[np.float64]


# levels of the depth at which a flank is looked for
_PROBES = 81


@dataclass(frozen=True)
class FlankPoints:
    """Points of a flank in the work frame of its member.

    Attributes
    ----------
    parameters : (3, n) array
        Edge length s [m], cutter angle th [rad], cradle roll phi [rad] of the cutting.
    position, normal : (3, n) arrays
        Point [m] and unit normal out of the tooth.
    """

    parameters: FloatArray
    position: FloatArray
    normal: FloatArray

    @property
    def azimuth(self) -> FloatArray:
        """Angle of the points about the axis of the member [rad]."""
        return np.asarray(np.arctan2(self.position[1], self.position[0]))

    def angles(self, pitch_angle: float) -> tuple[FloatArray, FloatArray]:
        """Spiral angle and normal pressure angle of the flank at its points [rad], both unsigned.

        The spiral angle lies in the cone through the point, parallel to the pitch cone, between the flank's trace and
        the generatrix; the normal pressure angle between the flank normal and the tangent plane of that cone.
        """
        c, s = np.cos(self.azimuth), np.sin(self.azimuth)
        radial, around = self.normal[0] * c + self.normal[1] * s, self.normal[1] * c - self.normal[0] * s
        sine, cosine = np.sin(pitch_angle), np.cos(pitch_angle)
        along, out = radial * sine + self.normal[2] * cosine, radial * cosine - self.normal[2] * sine
        return np.arctan2(np.abs(along), np.abs(around)), np.arcsin(np.abs(out))


class Flank(ABC):
    """One flank of one member in its work frame: a surface of three parameters bound by one condition.

    Attributes
    ----------
    side : str
        ``"concave"`` or ``"convex"``.
    blank : Blank
        Blank of the member.
    """

    side: FlankSide
    blank: Blank

    @abstractmethod
    def sweep(self, x: Array) -> tuple[Array, Array, Array]:
        """Point, unit normal out of the tooth, and the condition that vanishes on the flank.

        The arithmetic is holomorphic: complex parameters give exact derivatives by complex step.

        Parameters
        ----------
        x : (3, n) array
            Surface parameters, real or complex. A surface of two parameters keeps the third as its condition.

        Returns
        -------
        point, normal : (3, n) arrays
            In the work frame [m], [-].
        condition : (n,) array
            Equation of meshing of a generated flank, else the third parameter.
        """

    @abstractmethod
    def guess(self) -> FloatArray:
        """Parameters (3, 1) near the place `anchor`."""

    @property
    def anchor(self) -> tuple[float, float]:
        """Blank coordinates (u, h) [m] where the search for points starts: the mean point."""
        return 0.0, 0.0

    def linearise(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Point, normal and condition, (7, n), and their derivatives by the parameters, (n, 7, 3), exact."""

        def state(y: Array) -> Array:
            point, normal, condition = self.sweep(y)
            return np.concatenate([point, normal, condition[None]])

        return newton.complex_jacobian(state, x)

    def points(self, x: FloatArray) -> FlankPoints:
        """Flank points at solved cutting parameters."""
        position, normal, _ = self.sweep(x)
        return FlankPoints(x, np.real(position), np.real(normal))

    def marks(self, points: FlankPoints) -> FloatArray:
        """Tangents (3, n) along the marks of manufacture; along the trace of the tooth where no cutter is known."""
        c, s = np.cos(points.azimuth), np.sin(points.azimuth)
        sine, cosine = np.sin(self.blank.pitch_angle), np.cos(self.blank.pitch_angle)
        cone = np.stack([c * cosine, s * cosine, np.full_like(c, -sine)])
        return np.asarray(cross(points.normal, cone))

    def solve(self, u: FloatArray, h: FloatArray) -> tuple[FlankPoints, NDArray[np.bool_]]:
        """Flank points at blank coordinates (u, h), and which of them exist.

        All points start from `anchor` and are led to their places together.
        """
        anchor, start = np.array([self.anchor]), self._start
        x = np.repeat(start, u.size, axis=1)
        target = np.stack([u, h], axis=1)
        ok = np.ones(u.size, dtype=bool)
        for share in (0.5, 1.0):
            x, ok = self._to(anchor + share * (target - anchor), x)
        return self.points(x), ok

    def mean_point(self) -> FlankPoints:
        """The point in the middle of the face on the pitch cone.

        Raises
        ------
        ConvergenceError
            The flank does not reach it.
        """
        points, found = self.solve(np.zeros(1), np.zeros(1))
        if not found.all():
            raise ConvergenceError("undercut", f"the {self.side} flank does not reach the mean point")
        return points

    def mean_angles(self) -> tuple[float, float]:
        """Spiral angle and normal pressure angle at the mean point [rad]."""
        spiral, pressure = self.mean_point().angles(self.blank.pitch_angle)
        return float(spiral[0]), float(pressure[0])

    def lowest_fraction(self, top: float = 1.0) -> float:
        """Smallest fraction of the whole depth above which the flank exists over the whole face width [-].

        Raises
        ------
        ConvergenceError
            Nothing of the flank spans the face.
        """
        fractions = np.linspace(0.0, top, _PROBES)
        u = np.linspace(0.5, -0.5, 9) * self.blank.face_width
        along, depth = (grid.ravel() for grid in np.meshgrid(u, fractions))
        found = self.solve(along, self.blank.height(along, depth))[1]
        exists = np.asarray(found.reshape(_PROBES, u.size).all(axis=1))
        if not exists[-1]:
            raise ConvergenceError("undercut", f"the {self.side} flank does not reach its tip over the whole face")
        missing = np.flatnonzero(~exists)
        return float(fractions[missing[-1] + 1]) if missing.size else 0.0

    @cached_property
    def _start(self) -> FloatArray:
        """Parameters (3, 1) of the point at `anchor`."""
        start, found = self._to(np.array([self.anchor]), self.guess())
        if not found.all():
            raise ConvergenceError(
                "flank", f"the {self.side} flank does not reach the mean point of its blank; check the settings"
            )
        return start

    def refine(self, radius: FloatArray, z: FloatArray, x: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Cutting parameters of the points at given radius and axial position, from a start nearby."""

        def linearised(y: FloatArray) -> tuple[FloatArray, FloatArray]:
            state, slope = self.linearise(y)
            here = np.hypot(state[0], state[1])
            outwards = (state[0] * slope[:, 0].T + state[1] * slope[:, 1].T) / here
            value = np.array([here - radius, state[2] - z, state[6]])
            return value, np.stack([outwards.T, slope[:, 2], slope[:, 6]], axis=1)

        size = self.blank.mean_cone_distance
        limit = np.array([0.05 * size, 0.1, 0.1])
        return newton.iterate(linearised, x, limit, np.array([1e-10 * size, 1e-10, 1e-10]))

    def _to(self, target: FloatArray, x: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        radius, z = self.blank.axial(target[:, 0], target[:, 1])
        return self.refine(radius, z, x)


@dataclass(frozen=True)
class CutFlank(Flank):
    """Flank cut by one blade on one machine setting.

    Attributes
    ----------
    blade : Blade
        Blade of the cutter.
    machine : MachineSettings
        Machine settings.
    blank : Blank
        Blank of the member.
    index_zero : float
        Cutter angle at which the indexing of face hobbing starts [rad]; without effect in face milling.
    """

    blade: Blade
    machine: MachineSettings
    blank: Blank
    index_zero: float = 0.0
    side: FlankSide = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "side", self.blade.side)

    @property
    def index_ratio(self) -> float:
        """Continuous indexing: rotation of the work about its axis per rotation of the cutter."""
        return self.blade.groups / self.blank.teeth

    def sweep(self, x: Array) -> tuple[Array, Array, Array]:
        """Point, normal and equation of meshing at cutting parameters (s, th, phi).

        The equation of meshing is ``normal . d point / d phi`` [m]; a non-generated flank has phi in its place.
        """
        s, th, phi = x
        pose = self.machine.at(phi)
        if not self.index_ratio:
            in_cutter, facing = self.blade.surface(s, th)
            point, normal = pose.place(in_cutter), pose.direct(facing)
        else:
            edge, along, _ = self.blade.edge(s)
            in_cutter = turn(edge, th)
            point = pose.place(in_cutter)
            # the indexing work turns away under the blade
            cutting = pose.direct(spin(in_cutter)) + self.index_ratio * pose.about_work(point + pose.shift[0])
            normal = -self.blade.sign * unit(cross(np.asarray(pose.direct(turn(along, th))), cutting))
        condition = dot(normal, pose.rolling(point)) if self.machine.generated else phi + 0.0 * s
        return (*pose.to_work(point, normal, self._indexed(th)), condition)

    def linearise(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """State and derivatives as in the base class, in closed form and real arithmetic."""
        s, th, phi = x
        index, pose, sign = self.index_ratio, self.machine.at(phi), self.blade.sign
        # vectors of the same kind side by side, (3, k, n): few calls for many points
        edge, along, bend = turn(np.array(self.blade.edge(s)).swapaxes(0, 1), th).swapaxes(0, 1)
        by_th = spin(edge)
        # machine frame; r with its first and second derivatives by s and th while the cradle stands
        r = pose.place(edge)
        second = pose.direct(np.array([along, by_th, bend, spin(along), spin(by_th)]).swapaxes(0, 1))
        r_s, r_t, r_ss, r_st, r_tt = second.swapaxes(0, 1)
        r_phi, still = spin(r), np.zeros_like(r)
        arms = np.array([r_s, r_t, r_phi + pose.shift[1]]).swapaxes(0, 1)
        about_arms, about = pose.about_work(arms), pose.about_work(r + pose.shift[0])
        cutting, rolling = r_t + index * about, r_phi + pose.shift[1] - pose.work[1] * about
        cutting_rates = np.array([r_st, r_tt, spin(r_t)]).swapaxes(0, 1) + index * about_arms
        rolling_rates = np.array([spin(r_s), spin(r_t), spin(r_phi) + pose.shift[2]]).swapaxes(0, 1)
        rolling_rates = rolling_rates - pose.work[1] * about_arms
        rolling_rates[:, 2] -= pose.work[2] * about
        raw = -sign * cross(r_s, cutting)
        size = np.sqrt(dot(raw, raw))
        normal = raw / size
        indexed = self._indexed(th)
        position, facing = pose.to_work(r, normal, indexed)

        by_s = np.array([r_ss, r_st, spin(r_s)]).swapaxes(0, 1)
        change = -sign * (cross(by_s, cutting[:, None]) + cross(r_s[:, None], cutting_rates)) / size
        change = change - normal[:, None] * dot(normal[:, None], change)
        moved = pose.to_work_direction(np.concatenate([arms, change], axis=1), indexed)
        # the work turns as well: with the indexing, and against the generating roll
        turned = np.array([still[0], still[0] + index, -pose.work[1] + still[0]])
        jacobian = np.empty((7, 3, x.shape[1]))
        jacobian[:3] = moved[:, :3] + turned * spin(position)[:, None]
        jacobian[3:6] = moved[:, 3:] + turned * spin(facing)[:, None]
        jacobian[6] = dot(change, rolling[:, None]) + dot(normal[:, None], rolling_rates)
        condition = dot(normal, rolling)
        if not self.machine.generated:
            jacobian[:, 2], jacobian[6], jacobian[6, 2], condition = 0.0, 0.0, 1.0, phi
        return np.concatenate([position, facing, condition[None]]), jacobian.transpose(2, 0, 1)

    def marks(self, points: FlankPoints) -> FloatArray:
        """Tangents (3, n) along the path of the blade over the flank: the cutter turns, the roll is slow beside it."""
        _, slope = self.linearise(points.parameters)
        return np.asarray(slope[:, :3, 1].T)

    def _indexed(self, th: Array) -> Array:
        """Rotation of the work by continuous indexing [rad]."""
        return self.index_ratio * (th - self.index_zero - self.blade.phase)

    def guess(self) -> FloatArray:
        """Cutting parameters near the mean point.

        The mean point is looked for around the cutter with the cradle in the middle of its roll: where the edge stands
        at its height on the blank, close to the mean cone distance, and is about to generate.
        """
        count = 180
        th = np.linspace(-np.pi, np.pi, count, endpoint=False)
        s = np.full(count, self.blade.profile.length_at(self.blank.mean_dedendum))
        x = np.stack([s, th, np.zeros(count)])
        point, _, condition = self.sweep(x)
        u, h = self.blank.coordinates(np.hypot(point[0], point[1]), point[2])
        off = (u / self.blank.face_width) ** 2 + (h / (self.blank.mean_addendum + self.blank.mean_dedendum)) ** 2
        off = off + (condition / self.blank.mean_cone_distance) ** 2
        near = (off < np.roll(off, 1)) & (off <= np.roll(off, -1))
        starts = x[:, near][:, np.argsort(off[near])[:4]]
        solved, found = self._to(np.zeros((starts.shape[1], 2)), starts)
        return solved[:, found][:, :1] if found.any() else starts[:, :1]


def index_start(machine: MachineSettings, blank: Blank) -> float:
    """Cutter angle at which a blade faces the mean point of the blank [rad]: where indexing starts by convention.

    It depends on the setting and the blank only, so that both flanks of one setting share it.
    """
    radius, z = blank.axial(np.zeros(1), np.zeros(1))
    point = np.array([radius[0], 0.0, z[0] + machine.machine_centre_to_back])
    cradle = machine.work_axes.T @ point - np.array([0.0, machine.blank_offset, -machine.sliding_base])
    cutter = machine.cutter_axes.T @ (cradle - machine.cutter_centre)
    return float(np.arctan2(cutter[1], cutter[0]))
