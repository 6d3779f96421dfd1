"""Flanks: the common interface, and the flank cut on a blank by a blade."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from efficiency.cutting import newton
from efficiency.cutting.blank import Blank
from efficiency.cutting.cutter import Blade, FlankSide
from efficiency.cutting.machine import MachineSettings, cross, dot, spin, turn, unit
from efficiency.cutting.newton import Array
from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError

# levels of the depth at which the existence of a flank is checked
_PROBES = 81
# number of starting points, and cradle rolls of further starting points if none at rest converges [rad]
_STARTS, _ROLLS = 8, (-0.6, -0.3, 0.3, 0.6)


@dataclass(frozen=True)
class FlankPoints:
    """Points of a flank in the work frame of its member."""

    parameters: FloatArray  # cutting parameters: edge length s [m], cutter angle th [rad], cradle roll phi [rad]
    # point [m] and unit normal out of the tooth
    position: FloatArray
    normal: FloatArray

    @property
    def azimuth(self) -> FloatArray:
        """Angle of the points around the axis of the member [rad]."""
        return np.asarray(np.arctan2(self.position[1], self.position[0]))

    @property
    def lever(self) -> FloatArray:
        """Distance along the normal per rotation about the axis of the member [m/rad]."""
        return np.asarray(self.position[0] * self.normal[1] - self.position[1] * self.normal[0])

    def angles(self, pitch_angle: float) -> tuple[FloatArray, FloatArray]:
        """Spiral angle and normal pressure angle of the flank at its points [rad], both unsigned.

        The spiral angle is measured in the cone through the point, parallel to the pitch cone, between the trace of the
        flank and the generatrix; the pressure angle between the flank normal and the tangent plane of that cone.
        """
        c, s = np.cos(self.azimuth), np.sin(self.azimuth)
        radial, around = self.normal[0] * c + self.normal[1] * s, self.normal[1] * c - self.normal[0] * s
        sine, cosine = np.sin(pitch_angle), np.cos(pitch_angle)
        along, out = radial * sine + self.normal[2] * cosine, radial * cosine - self.normal[2] * sine
        return np.arctan2(np.abs(along), np.abs(around)), np.arcsin(np.abs(out))

    def winding(self, pitch_angle: float) -> FloatArray:
        """Change of the azimuth with the distance along the pitch cone [rad/m], with its sign."""
        x, y, _ = self.position
        sine, cosine, radius = np.sin(pitch_angle), np.cos(pitch_angle), np.hypot(x, y)
        along = (self.normal[0] * x + self.normal[1] * y) / radius * sine + self.normal[2] * cosine
        return np.asarray(-along / self.lever)


class Flank(ABC):
    """One flank of one member in its work frame: a surface of three parameters with one condition."""

    side: FlankSide
    blank: Blank  # of the member

    @abstractmethod
    def sweep(self, x: Array) -> tuple[Array, Array, Array]:
        """Point, unit normal out of the tooth, and the condition that vanishes on the flank.

        The arithmetic is holomorphic: complex parameters give exact derivatives by complex step.

        x (3, n): surface parameters, real or complex. For a surface of two parameters the third one is the condition.
        Returns: point, normal: in the work frame [m], [-]; condition: equation of meshing of a generated flank,
        otherwise the third parameter.
        """

    def guess(self) -> FloatArray:
        """Parameters (3, 1) near the point `anchor`; those of the mean point of a surface over blank coordinates."""
        return np.zeros((3, 1))

    @property
    def anchor(self) -> tuple[float, float]:
        """Blank coordinates (u, h) [m] of the starting point of searches: the mean point."""
        return 0.0, 0.0

    def linearise(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Point, normal and condition, (7, n), and their exact derivatives by the parameters, (n, 7, 3)."""

        def state(y: Array) -> Array:
            point, normal, condition = self.sweep(y)
            return np.concatenate([point, normal, condition[None]])

        return newton.complex_jacobian(state, x)

    def points(self, x: FloatArray) -> FlankPoints:
        """Flank points at solved cutting parameters."""
        position, normal, _ = self.sweep(x)
        return FlankPoints(x, np.real(position), np.real(normal))

    def marks(self, points: FlankPoints) -> FloatArray:
        """Tangents (3, n) along the lay; along the trace of the tooth for a flank without a cutter."""
        c, s = np.cos(points.azimuth), np.sin(points.azimuth)
        sine, cosine = np.sin(self.blank.pitch_angle), np.cos(self.blank.pitch_angle)
        cone = np.stack([c * cosine, s * cosine, np.full_like(c, -sine)])
        return np.asarray(cross(points.normal, cone))

    def solve(self, u: FloatArray, h: FloatArray) -> tuple[FlankPoints, NDArray[np.bool_]]:
        """Flank points at blank coordinates (u, h), and a mask of existing points.

        All points start from `anchor` and are moved to their positions together.
        """
        anchor, target = np.array([self.anchor]), np.stack([u, h], axis=1)
        x = np.repeat(self._start, u.size, axis=1)
        for share in (0.5, 1.0):
            x, ok = self._to(anchor + share * (target - anchor), x)
        return self.points(x), ok

    def mean_point(self) -> FlankPoints:
        """The point at the middle of the face width on the pitch cone."""
        points, found = self.solve(np.zeros(1), np.zeros(1))
        if not found.all():
            raise ConvergenceError("undercut", f"the {self.side} flank does not reach the mean point")
        return points

    def mean_angles(self) -> tuple[float, float]:
        """Spiral angle and normal pressure angle at the mean point [rad]."""
        spiral, pressure = self.mean_point().angles(self.blank.pitch_angle)
        return float(spiral[0]), float(pressure[0])

    def lowest_fraction(self, top: float = 1.0) -> float:
        """Smallest fraction of the whole depth above which the flank exists over the whole face width [-]."""
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
            what = f"the {self.side} flank does not reach the mean point of its blank; check the settings"
            raise ConvergenceError("flank", what)
        return start

    def refine(self, radius: FloatArray, z: FloatArray, x: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Cutting parameters of the points at given radius and axial position, from starting values nearby."""

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
    """Flank cut by one blade with one machine setting."""

    blade: Blade  # blade of the cutter
    machine: MachineSettings  # machine settings
    blank: Blank  # blank of the member
    # cutter angle at which the indexing of face hobbing starts [rad]; no effect in face milling
    index_zero: float = 0.0
    side: FlankSide = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "side", self.blade.side)

    @property
    def index_ratio(self) -> float:
        """Rotation of the work about its axis per rotation of the cutter in continuous indexing."""
        return self.blade.groups / self.blank.teeth

    @cached_property
    def _axis(self) -> Array:
        """Point (3, 1) of the cutter frame on the axis about which the blade rotates [m]; the origin of most heads."""
        angle = self.index_zero + self.blade.offset_angle + self.blade.eccentricity_angle
        return -self.blade.eccentricity * np.array([[np.cos(angle)], [np.sin(angle)], [0.0]])

    def sweep(self, x: Array) -> tuple[Array, Array, Array]:
        """Point, normal and equation of meshing at cutting parameters (s, th, phi).

        The equation of meshing is ``normal . d point / d phi`` [m]; for a non-generated flank it is replaced by phi.
        """
        s, th, phi = x
        pose = self.machine.at(phi)
        if not self.index_ratio:
            in_cutter, facing = self.blade.surface(s, th)
            point, normal = pose.place(in_cutter), pose.direct(facing)
        else:
            edge, along, _ = self.blade.edge(s)
            in_cutter = turn(edge, th)
            point = pose.place(in_cutter + self._axis)
            # the indexing work rotates away under the blade
            cutting = pose.direct(spin(in_cutter)) + self.index_ratio * pose.about_work(point + pose.shift[0])
            normal = -self.blade.sign * unit(cross(np.asarray(pose.direct(turn(along, th))), cutting))
        condition = dot(normal, pose.rolling(point)) if self.machine.generation.rolls else phi + 0.0 * s
        indexed = self._indexed(th)
        return pose.to_work(point, indexed), pose.to_work_direction(normal, indexed), condition

    def position(self, x: Array) -> Array:
        """Points (3, n) at cutting parameters, as in `sweep`."""
        s, th, phi = x
        pose = self.machine.at(phi)
        return pose.to_work(pose.place(turn(self.blade.edge(s)[0], th) + self._axis), self._indexed(th))

    def linearise(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """State and derivatives as in the base class, in closed form with real arithmetic."""
        s, th, phi = x
        index, pose, sign = self.index_ratio, self.machine.at(phi), self.blade.sign
        # vectors of the same kind are stacked, (3, k, n), to reduce the number of calls
        edge, along, bend = turn(np.array(self.blade.edge(s)).swapaxes(0, 1), th).swapaxes(0, 1)
        by_th = spin(edge)
        # machine frame; r with its first and second derivatives by s and th at fixed cradle
        r = pose.place(edge + self._axis)
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
        position, facing = pose.to_work(r, indexed), pose.to_work_direction(normal, indexed)

        by_s = np.array([r_ss, r_st, spin(r_s)]).swapaxes(0, 1)
        change = -sign * (cross(by_s, cutting[:, None]) + cross(r_s[:, None], cutting_rates)) / size
        change = change - normal[:, None] * dot(normal[:, None], change)
        moved = pose.to_work_direction(np.concatenate([arms, change], axis=1), indexed)
        # the work rotates as well: with the indexing, and against the generating roll
        turned = np.array([still[0], still[0] + index, -pose.work[1] + still[0]])
        jacobian = np.empty((7, 3, x.shape[1]))
        jacobian[:3] = moved[:, :3] + turned * spin(position)[:, None]
        jacobian[3:6] = moved[:, 3:] + turned * spin(facing)[:, None]
        jacobian[6] = dot(change, rolling[:, None]) + dot(normal[:, None], rolling_rates)
        condition = dot(normal, rolling)
        if not self.machine.generation.rolls:
            jacobian[:, 2], jacobian[6], jacobian[6, 2], condition = 0.0, 0.0, 1.0, phi
        return np.concatenate([position, facing, condition[None]]), jacobian.transpose(2, 0, 1)

    def marks(self, points: FlankPoints) -> FloatArray:
        """Tangents (3, n) along the path of the blade over the flank, neglecting the slow generating roll."""
        _, slope = self.linearise(points.parameters)
        return np.asarray(slope[:, :3, 1].T)

    def _indexed(self, th: Array) -> Array:
        """Rotation of the work by continuous indexing [rad]."""
        return self.index_ratio * (th - self.index_zero - self.blade.phase)

    def regression(self, x: FloatArray) -> FloatArray:
        """Rate of the equation of meshing that vanishes on the edge of regression [m], at flank points x (3, n).

        A flank point is at rest in the work where ``r_s ds + r_th dth + r_phi dphi = 0``. If the equation of meshing
        holds to first order along that motion, the flank has no tangent plane at this point. The rate is positive where
        the tool is nearest to the tooth. Behind the edge of regression it is negative, and another roll position cuts
        the point away.
        """
        _, slope = self.linearise(x)
        r_s, r_t, r_p = np.moveaxis(slope[:, :3], 0, -1).transpose(1, 0, 2)
        e, f, g = dot(r_s, r_s), dot(r_s, r_t), dot(r_t, r_t)
        a, b = dot(r_s, r_p), dot(r_t, r_p)
        area = e * g - f * f
        alpha, beta = (g * a - f * b) / area, (e * b - f * a) / area
        return np.asarray(slope[:, 6, 2] - alpha * slope[:, 6, 0] - beta * slope[:, 6, 1])

    @cached_property
    def _start(self) -> FloatArray:
        """Parameters (3, 1) of the mean point on the sheet of the envelope that is the flank.

        The cutter surface passes the cone of the mean point more than once: also on the opposite side of the cutter,
        and behind its edge of regression. Among the solutions, the one before the edge of regression and nearest to the
        tool position in front of the machine centre is selected.
        """
        found = self._solved(np.zeros(1))
        if not self._regular(found).any() and self.machine.generation.rolls:
            found = np.concatenate([found, self._solved(np.array(_ROLLS))], axis=1)
        regular = self._regular(found)
        if not regular.any():
            reason, what = ("undercut", "lies behind its edge of regression at") if found.size else ("flank", "misses")
            what += " the mean point of its blank"
            if (deep := self.tip_below_root) >= 0.5 * self.blank.mean_dedendum:
                what += f" (the blade tip reaches {deep * 1e3:.3g} mm below the root cone: withdraw the cutter)"
            raise ConvergenceError(reason, f"the {self.side} flank {what}; check cutter and machine settings")
        found = found[:, regular]
        pose = self.machine.at(found[2])
        turned = self.points(found).azimuth - self._indexed(found[1]) + pose.work[0]
        off = np.hypot(np.angle(np.exp(1j * turned)), found[2])
        return found[:, [int(np.argmin(off))]]

    def _solved(self, rolls: FloatArray) -> FloatArray:
        """Parameters (3, k) to which the starting points of `_candidates` converge."""
        starts = self._candidates(rolls)
        solved, reached = self._to(np.zeros((starts.shape[1], 2)), starts)
        return solved[:, reached]

    def _regular(self, x: FloatArray) -> NDArray[np.bool_]:
        """Mask of points before the edge of regression; all points of a flank that is not an envelope."""
        if not self.machine.generation.rolls or not x.size:
            return np.ones(x.shape[1], dtype=bool)
        return self.regression(x) > 0.0

    def _candidates(self, rolls: FloatArray) -> FloatArray:
        """Starting points (3, k) around the cutter at cradle rolls: intersections with the cone of the mean point.

        The edge length follows from the height of the edge above the pitch cone, for any depth of the tip. Only points
        close to the mean cone distance and close to the equation of meshing are used.
        """
        count = 180
        around = np.linspace(-np.pi, np.pi, count, endpoint=False)
        th, phi = np.tile(around, rolls.size), np.repeat(rolls, count)
        depth = self.blank.mean_dedendum
        s = np.full(th.size, self.blade.profile.length_at(depth))

        def placed(s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
            point, _, condition = self.sweep(np.stack([s, th, phi]))
            return *self.blank.place(np.real(point)), np.real(condition)

        # the height is nearly linear in the length; a vanishing slope occurs on the opposite side of the cutter
        _, height, _ = placed(s)
        for _ in range(2):
            slope = (placed(s + 1e-3 * depth)[1] - height) / (1e-3 * depth)
            s = s - np.clip(height / np.where(np.abs(slope) > 0.05, slope, np.inf), -20.0 * depth, 20.0 * depth)
            _, height, _ = placed(s)
        u, h, condition = placed(s)
        off = (u / self.blank.face_width) ** 2 + (h / (self.blank.mean_addendum + self.blank.mean_dedendum)) ** 2
        off = off + (condition / self.blank.mean_cone_distance) ** 2
        ring = off.reshape(rolls.size, count)
        near = ((ring < np.roll(ring, 1, axis=1)) & (ring <= np.roll(ring, -1, axis=1))).ravel()
        best = np.flatnonzero(near)[np.argsort(off[near])[:_STARTS]]
        return np.stack([s[best], th[best], phi[best]])

    @property
    def tip_below_root(self) -> float:
        """Largest depth of the blade tip below the root cone at mid-face, with the cradle at rest [m]."""
        th = np.linspace(-np.pi, np.pi, 360, endpoint=False)
        point = np.real(self.sweep(np.stack([np.full(360, self.blade.tip), th, np.zeros(360)]))[0])
        u, h = self.blank.place(point)
        below = (self.blank.root(u) - h)[np.abs(u) < 0.25 * self.blank.face_width]
        return float(below.max()) if below.size else 0.0


def index_start(machine: MachineSettings, blank: Blank) -> float:
    """Cutter angle at which a blade faces the mean point of the blank [rad]: start of the indexing by convention.

    It depends only on the setting and the blank, so that both flanks of one setting share it.
    """
    radius, z = blank.axial(np.zeros(1), np.zeros(1))
    point = np.array([radius[0], 0.0, z[0] + machine.machine_centre_to_back])
    cradle = machine.work_axes.T @ point - np.array([0.0, machine.blank_offset, -machine.sliding_base])
    cutter = machine.cutter_axes.T @ (cradle - machine.cutter_centre)
    return float(np.arctan2(cutter[1], cutter[0]))
