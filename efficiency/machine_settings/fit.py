"""Least-squares fit of machine and blade settings to target flanks.

Residual: distance along the normal of the conjugate flank to the flank of the settings, minus its ease-off. Its
derivative by a setting is exact from one flank evaluation: at fixed cutting parameters the surface point moves by
dr/dp, and to first order only the component along the flank normal changes the distance, ``dd/dp = n . (dr/dp) / (n .
n_c)`` (envelope theorem). If the normal misses the flank (undercut) the same formula extrapolates the residual
linearly, so that such a point never blocks a step; it is reported and excluded from the measures.

The root of a generated member is the deepest cut of its blade tips. At a station u along the face it is the deepest
point of the tip edge s = 0: h(th, phi) at fixed u(th, phi) has its minimum there, so ``h_th u_phi - h_phi u_th = 0``.
By the envelope theorem the height changes with a setting as it does at fixed (th, phi), minus the slope of the root
times the change of u.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from efficiency.contact.ease_off import bordered, meet_flank
from efficiency.cutting.blank import Blank
from efficiency.cutting.flank import CutFlank
from efficiency.cutting.machine import dot, spin, turn
from efficiency.cutting.newton import Array
from ehl.common.arrays import BoolArray, FloatArray

_DELTA = 1e-5


def _linearised(flank: CutFlank, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Blank coordinates (2, k) of tip points and their derivatives by (th, phi), (2, 2, k)."""
    state, slope = flank.linearise(np.stack([np.zeros_like(y[0]), y[0], y[1]]))
    radius = np.hypot(state[0], state[1])
    by = np.moveaxis(slope[:, :3, 1:], 0, -1)
    outwards = (state[0] * by[0] + state[1] * by[1]) / radius
    c, s = np.cos(flank.blank.pitch_angle), np.sin(flank.blank.pitch_angle)
    rates = np.stack([outwards * s + by[2] * c, outwards * c - by[2] * s])
    return np.stack(flank.blank.coordinates(radius, state[2])), rates


@dataclass(frozen=True)
class RootState:
    """Tip points on the root."""

    parameters: FloatArray  # cutter angle and cradle roll
    error: FloatArray  # height above the root of the blank [m]
    slope: FloatArray  # dh/du along the cut root at the stations [-]
    blank: Blank  # blank of the member

    @property
    def tips(self) -> FloatArray:
        """Cutting parameters (3, k) of the tip points."""
        return np.stack([np.zeros(self.parameters.shape[1]), *self.parameters])

    def derivative(self, moved: Array, step: float) -> FloatArray:
        """Change of `error` with a setting, from the tip points (3, k) for an imaginary step of that setting."""
        radius = np.sqrt(moved[0] ** 2 + moved[1] ** 2)
        u, h = (value.imag / step for value in self.blank.coordinates(radius, moved[2]))
        return np.asarray(h - self.slope * u)


@dataclass(frozen=True)
class RootLine:
    """Target of the root."""

    u: FloatArray  # stations along the face [m]
    height: FloatArray  # target height of the root [m]
    weight: float  # residual per error of the root, [m/m]
    start: FloatArray  # cutter angle and cradle roll near the root points

    @classmethod
    def of_blank(
        cls, blank: Blank, stations: FloatArray, weight: float, u: FloatArray, h: FloatArray, parameters: FloatArray
    ) -> RootLine:
        """Root of the blank at stations [m]; the search starts from the nearest flank points, cutting parameters."""
        root = blank.root(stations)
        nearest = np.argmin((u - stations[:, None]) ** 2 + (h - root[:, None]) ** 2, axis=1)
        return cls(stations, root, weight, parameters[1:, nearest])

    def cut(self, flank: CutFlank, previous: RootState | None = None) -> RootState:
        """The root cut by the blade of a flank."""
        x = np.array(self.start if previous is None else previous.parameters)
        size = flank.blank.mean_cone_distance

        def lagrange(y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
            value, slopes = _linearised(flank, y)
            (u_th, u_phi), (h_th, h_phi) = slopes
            gap = value[0] - np.resize(self.u, y.shape[1])
            return value, slopes, np.stack([gap, (h_th * u_phi - h_phi * u_th) / size])

        shifts = _DELTA * np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]])
        value, slopes, residual = lagrange(x)
        for _ in range(12):
            # shifted points are stacked to reduce the number of calls
            moved = lagrange((x[:, None] + shifts[:, :, None]).reshape(2, -1))[2].reshape(2, 4, -1)
            matrix = np.moveaxis((moved[:, ::2] - moved[:, 1::2]) / (2.0 * _DELTA), 2, 0)
            if not np.isfinite(matrix).all() or np.abs(np.linalg.det(matrix)).min() < 1e-30:
                return RootState(x, np.full(x.shape[1], np.nan), np.zeros(x.shape[1]), flank.blank)
            step = np.linalg.solve(matrix, residual.T[..., None])[..., 0].T
            step *= np.minimum(1.0, 0.1 / np.abs(step).max(axis=0).clip(1e-300))
            x = x - step
            value, slopes, residual = lagrange(x)
            if np.abs(step).max() < 1e-5:
                break
        (u_th, u_phi), (h_th, h_phi) = slopes
        slope = (h_th * u_th + h_phi * u_phi) / (u_th * u_th + u_phi * u_phi)
        return RootState(x, value[1] - self.height, slope, flank.blank)


_STEP = 1e-30
# weight of points with an extrapolated residual: sufficient to keep them near, small enough not to affect the others
_MISSED = 0.1


Part = Literal["machine", "blade", "phase"]


@dataclass(frozen=True)
class FitParameter:
    """A free setting: the part that contains it, its name there, and the size of a natural step."""

    part: Part
    name: str
    scale: float


_LENGTHS = ("radial_setting", "blank_offset", "sliding_base", "machine_centre_to_back", "helical_motion_1")
_ROLLS = {"roll_ratio": 0.02, "modified_roll_2c": 0.01, "modified_roll_6d": 0.02}
_RADII = dict.fromkeys(("point_radius", "radius_offset", "eccentricity"), 1e-3)
# natural steps of the settings of each part [m], [rad]
_STEPS: dict[Part, dict[str, float]] = {
    "machine": {"axis_x": 0.01, "axis_y": 0.01, **dict.fromkeys(_LENGTHS, 1e-3), **_ROLLS},
    "blade": {"blade_angle": 0.01, "curvature": 1.0, **_RADII},
    "phase": {"phase": 0.01},
}
PARAMETERS = {name: FitParameter(part, name, step) for part, own in _STEPS.items() for name, step in own.items()}


@dataclass(frozen=True)
class FreeSettings:
    """Settings changed by a fit: common settings of both flanks, and settings of each flank."""

    common: tuple[FitParameter, ...]
    own: tuple[FitParameter, ...]


@dataclass(frozen=True)
class TargetFlank:
    """One pinion flank to be fitted."""

    flank: CutFlank  # flank of the start settings
    phase: float  # rotation of that flank about its axis [rad]
    # points of the conjugate pinion flank in the frame of the pinion at zero rotation [m], and unit normals out of the
    # gear tooth
    position: FloatArray
    normal: FloatArray
    relief: FloatArray  # ease-off, positive for missing material [m]
    parameters: FloatArray  # cutting parameters of the start, near the points
    root: RootLine | None = None  # target of the root


@dataclass(frozen=True)
class FittedFlank:
    """Result of the fit of a target flank."""

    flank: CutFlank
    phase: float
    parameters: FloatArray  # cutting parameters of the points
    relief: FloatArray  # distance to the conjugate flank [m], linearly extrapolated where `found` is false
    residual: FloatArray  # relief minus target [m]
    found: BoolArray  # false where the flank does not exist (undercut)
    root: RootState | None

    @property
    def outwards(self) -> float:
        """Sign of a rotation about the axis along the outward normal of the flank; the opposite one thins the tooth."""
        return float(np.sign(np.median(self.flank.points(self.parameters[:, self.found]).lever)))

    @property
    def root_error(self) -> FloatArray:
        """Height of the cut root above the target at the stations of the root line [m]."""
        return np.zeros(0) if self.root is None or not np.isfinite(self.root.error).all() else self.root.error

    @property
    def rms(self) -> float:
        """Root mean square of the residual over the existing flank [m]."""
        return float(np.sqrt(np.mean(self.residual[self.found] ** 2))) if self.found.any() else float("inf")

    @property
    def largest(self) -> float:
        """Largest residual over the existing flank [m]."""
        return float(np.abs(self.residual[self.found]).max()) if self.found.any() else float("inf")


@dataclass(frozen=True)
class FitResult:
    """Result of a fit."""

    flanks: tuple[FittedFlank, ...]
    iterations: int
    converged: bool  # whether the last accepted step changed the sum of squares by less than the tolerance

    @property
    def rms(self) -> float:
        """Largest residual of the flanks, root mean square [m]."""
        return max(flank.rms for flank in self.flanks)


def with_setting(flank: CutFlank, parameter: FitParameter, value: complex) -> CutFlank:
    """The flank with one machine or blade setting changed."""
    part = replace(getattr(flank, parameter.part), **{parameter.name: value})
    return replace(flank, **{parameter.part: part})


def motion(
    flank: CutFlank, parameter: FitParameter, facing: Array, parameters: FloatArray, root: RootState | None
) -> tuple[FloatArray, FloatArray]:
    """Change of points (3, n) along a direction, and of the height of the root, by a machine or blade setting."""
    count = parameters.shape[1]
    every = parameters if root is None else np.concatenate([parameters, root.tips], axis=1)
    value = getattr(getattr(flank, parameter.part), parameter.name)
    moved = with_setting(flank, parameter, value + 1j * _STEP).position(every)
    change = dot(facing, np.asarray(moved[:, :count].imag) / _STEP)
    return np.real(change), np.zeros(0) if root is None else root.derivative(moved[:, count:], _STEP)


def _changed(flank: CutFlank, phase: float, parameter: FitParameter, step: float) -> tuple[CutFlank, float]:
    if parameter.part == "phase":
        return flank, phase + step
    return with_setting(flank, parameter, getattr(getattr(flank, parameter.part), parameter.name) + step), phase


def measure(
    target: TargetFlank,
    flank: CutFlank,
    phase: float,
    start: FloatArray,
    root: RootState | None = None,
    held: BoolArray | None = None,
) -> FittedFlank:
    """Distance of a flank to the conjugate points, and the height of its root.

    Points once missed remain linear (`held` false), because alternating points would make the sum of squares
    discontinuous.
    """
    position, normal = turn(target.position, -phase), turn(target.normal, -phase)
    point, facing, _ = flank.sweep(start)
    linear = np.real(dot(facing, point - position) / dot(facing, normal))
    x, found = meet_flank(flank, position, normal, start, linear, max_iterations=12)
    found &= np.isfinite(x).all(axis=0) & (np.abs(x[3] - linear) < 0.02 * flank.blank.mean_cone_distance)
    if held is not None:
        found &= held
    if found.any():
        # the bordered determinant changes its sign at the limit of undercut, behind which is the other branch
        slope = flank.linearise(np.where(found, x[:3], x[:3, found][:, :1]))[1]
        determinant = np.linalg.det(bordered(slope, -normal))
        found &= determinant * np.sign(np.median(determinant[found])) > 0.0
    relief = np.where(found, x[3], linear)
    parameters = np.where(found, x[:3], start)
    state = None if target.root is None else target.root.cut(flank, root)
    return FittedFlank(flank, phase, parameters, relief, relief - target.relief, found, state)


def _derivatives(
    target: TargetFlank, now: FittedFlank, parameters: Sequence[FitParameter], weighed: bool
) -> FloatArray:
    """Rows of points, and of a weighted root, over the settings, (n + k, m), in metres per scale."""
    point, facing, _ = now.flank.sweep(now.parameters)
    share = 1.0 / dot(facing, turn(target.normal, -now.phase))
    root_state = now.root if weighed else None
    columns = []
    for parameter in parameters:
        if parameter.part == "phase":
            change = np.real(dot(facing, spin(point)))
            root = np.zeros(0 if root_state is None else root_state.error.size)
        else:
            change, root = motion(now.flank, parameter, facing, now.parameters, root_state)
        columns.append(np.concatenate([change * np.real(share), root]) * parameter.scale)
    return np.stack(columns, axis=1)


def fit(
    targets: Sequence[TargetFlank],
    common: Sequence[FitParameter],
    own: Sequence[FitParameter],
    *,
    ridge: float = 1e-8,
    tolerance: float = 5e-3,
    max_iterations: int = 60,
) -> FitResult:
    """Levenberg-Marquardt fit of one or two flanks.

    targets: one flank, or both flanks of a member with one setting.
    common, own: common settings of all flanks, and settings of each flank.
    ridge: regularisation towards the start [m per scale].
    tolerance: the fit ends if two successive accepted steps reduce the sum of squares by less than this fraction.
    """
    parameters = [*common, *own]
    count, flanks = len(common), len(targets)
    total = count + flanks * len(own)
    columns = [[*range(count), *range(count + k * len(own), count + (k + 1) * len(own))] for k in range(flanks)]

    def place(vector: FloatArray, previous: Sequence[FittedFlank] | None) -> tuple[FittedFlank, ...]:
        placed = []
        for k, target in enumerate(targets):
            flank, phase = target.flank, target.phase
            for parameter, step in zip(parameters, vector[columns[k]], strict=True):
                flank, phase = _changed(flank, phase, parameter, float(step) * parameter.scale)
            start = target.parameters if previous is None else previous[k].parameters
            root = None if previous is None else previous[k].root
            held = None if previous is None else previous[k].found
            placed.append(measure(target, flank, phase, start, root, held))
        return tuple(placed)

    def rows(state: Sequence[FittedFlank], vector: FloatArray) -> FloatArray:
        parts = []
        for target, now in zip(targets, state, strict=True):
            parts.append(now.residual * np.where(now.found, 1.0, _MISSED))
            if target.root is not None and target.root.weight > 0.0:
                assert now.root is not None
                parts.append(now.root.error * target.root.weight)
        return np.concatenate([*parts, ridge * vector])

    def jacobian(state: Sequence[FittedFlank]) -> FloatArray:
        blocks = []
        for k, (target, now) in enumerate(zip(targets, state, strict=True)):
            weighed = target.root is not None and target.root.weight > 0.0
            block = _derivatives(target, now, parameters, weighed)
            block[: now.residual.size] *= np.where(now.found, 1.0, _MISSED)[:, None]
            block[now.residual.size :] *= target.root.weight if target.root else 0.0
            wide = np.zeros((block.shape[0], total))
            wide[:, columns[k]] = block
            blocks.append(wide)
        return np.concatenate([*blocks, ridge * np.eye(total)])

    vector = np.zeros(total)
    state = place(vector, None)
    values = rows(state, vector)
    cost = float(values @ values)
    damping, growth, small = 1e-5, 2.0, 0
    iteration, converged = 0, False
    while iteration < max_iterations and not converged:
        iteration += 1
        matrix = jacobian(state)
        normal = matrix.T @ matrix
        gradient = matrix.T @ values
        diagonal = np.diag(normal).copy()
        for _ in range(15):
            step = -np.linalg.solve(normal + damping * np.diag(diagonal), gradient)
            trial = place(vector + step, state)
            values_new = rows(trial, vector + step)
            cost_new = float(values_new @ values_new)
            if np.isfinite(cost_new) and cost_new < cost:
                break
            damping, growth = damping * growth, 2.0 * growth
        else:
            break
        # the gain ratio of the accepted step determines the damping (Nielsen 1999)
        predicted = float(-2.0 * gradient @ step - step @ normal @ step)
        ratio = (cost - cost_new) / predicted if predicted > 0.0 else 0.0
        damping, growth = max(damping * max(1.0 / 9.0, 1.0 - (2.0 * ratio - 1.0) ** 3), 1e-14), 2.0
        gain = (cost - cost_new) / cost
        vector, state, values, cost = vector + step, trial, values_new, cost_new
        small = small + 1 if gain < tolerance else 0
        converged = small >= 2 or gain < 1e-6
    final = [
        measure(target, now.flank, now.phase, now.parameters, now.root)
        for target, now in zip(targets, state, strict=True)
    ]
    return FitResult(tuple(final), iteration, converged)
