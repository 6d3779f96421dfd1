"""Machine: transformation of a cutter point to the work, with rotation of cradle, work and face-hobbing head.

One chain for generated and non-generated (Formate) members, face milling and face hobbing. Frames and signs: machine
frame with its origin at the machine centre, x along the root line from toe to heel, z along the cradle axis, teeth at
z < 0; work frame with z along its axis from apex to heel. Properties that depend on generation are objects in
`GENERATIONS`.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Annotated, Literal

import numpy as np

from efficiency.cutting.blank import Length, Shift
from efficiency.cutting.newton import AnyArray, Array
from ehl.common.arrays import FloatArray
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel


def turn(vector: AnyArray, angle: AnyArray | float) -> AnyArray:
    """Rotate vectors about z."""
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2] + 0.0 * c])


def spin(vector: AnyArray) -> AnyArray:
    """Velocity of points for a rotation about z at 1 rad/s."""
    return np.asarray([-vector[1], vector[0], 0.0 * vector[2]])


def dot(a: AnyArray, b: AnyArray) -> AnyArray:
    """Scalar product without complex conjugation (holomorphic)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def cross(a: AnyArray, b: AnyArray) -> AnyArray:
    """Vector product."""
    return np.asarray([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def unit(vector: AnyArray) -> AnyArray:
    """Vectors of length one."""
    return np.divide(vector, np.sqrt(dot(vector, vector)))


def rotation(angle: float) -> FloatArray:
    """Matrix of a rotation about z."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


Turn = Annotated[float, ValueRange("rad", ge=-3.1416, le=3.1416)]

# natural steps of settings in a correction [m], [rad]
LENGTH_STEP, ANGLE_STEP = 1e-4, 1e-3
# coefficients of modified roll by their trade names
MODIFIED_ROLL = ("2c", "6d", "24e", "120f", "720g")


@dataclass(frozen=True)
class Generation:
    """Generation of the profile of a flank."""

    name: str  # name in files
    label: str  # name in a sentence
    words: tuple[str, ...]  # names in setting sheets
    # whether cradle and work roll, so that the flank is the envelope of the tool: it satisfies the equation of meshing,
    # may be undercut, and its root is cut deepest at one roll
    rolls: bool
    # settings of a machine correction in addition to those of every machine, with their natural steps
    first_order: tuple[tuple[str, float], ...]
    second_order: tuple[tuple[str, float], ...] = ()
    correction_note: str = ""  # limitation of a correction


GENERATED = Generation(
    name="generated",
    label="generated",
    words=("generated",),
    rolls=True,
    first_order=(("roll_ratio", 1e-3),),
    second_order=(("modified_roll_2c", 1e-3), ("helical_motion_1", LENGTH_STEP)),
)
FORMATE = Generation(
    name="formate",
    label="Formate",
    words=("formate", "non-generated", "helixform"),
    rolls=False,
    first_order=(("cradle_angle", ANGLE_STEP),),
    correction_note="the root of a Formate member is not constrained: check its depth after changing the sliding base",
)
GENERATIONS = {generation.name: generation for generation in (GENERATED, FORMATE)}


def _polynomial(coefficients: tuple[float, ...], phi: Array) -> tuple[Array, Array, Array]:
    """Value, first and second derivative of ``sum c_k phi^k/k!``, k from 0."""
    value, rate, bend = 0.0 * phi, 0.0 * phi, 0.0 * phi
    degree = max((k for k, coefficient in enumerate(coefficients) if coefficient), default=0)
    for k in range(degree, 0, -1):
        value = (coefficients[k] + value) * phi / k
        rate = coefficients[k] + rate * phi / k
        bend = coefficients[k] + bend * phi / (k - 1) if k > 1 else bend
    return coefficients[0] + value, rate, bend


@dataclass(frozen=True)
class MachineSettings:
    """Settings of one flank, SI units and rad: numeric values of `MachineInput` for differentiation.

    Symbols: radial setting Sr, cradle angle q (positive for a right-hand member), blank offset Em, sliding base Xb,
    machine centre to back Xd, tilt i about y, then swivel j about z, about the tip-plane centre. Roll ratio Ra and
    modified roll 2C, 6D, 24E, 120F, 720G: the work rotates by ``Ra (phi - C phi^2 - D phi^3 - E phi^4 - F phi^5 - G
    phi^6)`` while the cradle rotates by phi. Cradle and work are at rest if `generation` does not roll.
    """

    radial_setting: float
    cradle_angle: float
    machine_root_angle: float
    roll_ratio: float
    tilt: float = 0.0
    swivel: float = 0.0
    blank_offset: float = 0.0
    sliding_base: float = 0.0
    machine_centre_to_back: float = 0.0
    modified_roll_2c: float = 0.0
    modified_roll_6d: float = 0.0
    modified_roll_24e: float = 0.0
    modified_roll_120f: float = 0.0
    modified_roll_720g: float = 0.0
    helical_motion_1: float = 0.0
    helical_motion_2: float = 0.0
    helical_motion_3: float = 0.0
    vertical_motion_1: float = 0.0
    vertical_motion_2: float = 0.0
    vertical_motion_3: float = 0.0
    generation: Generation = GENERATED

    @cached_property
    def cutter_centre(self) -> FloatArray:
        """Tip-plane centre of the cutter in the cradle frame [m]."""
        return np.array([np.cos(self.cradle_angle), np.sin(self.cradle_angle), 0.0]) * self.radial_setting

    @cached_property
    def cutter_axes(self) -> FloatArray:
        """Rotation from the cutter to the cradle frame: swivel after tilt."""
        c, s = np.cos(self.tilt), np.sin(self.tilt)
        tilt = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
        return np.asarray(rotation(self.swivel) @ tilt)

    @cached_property
    def work_axes(self) -> FloatArray:
        """Rotation from the machine to the (not yet rotated) work frame; its last row is the work axis."""
        c, s = np.cos(self.machine_root_angle), np.sin(self.machine_root_angle)
        return np.array([[s, 0.0, -c], [0.0, 1.0, 0.0], [c, 0.0, s]])

    def at(self, phi: Array) -> Pose:
        """The machine at cradle rolls phi, (n,) [rad]; for a non-generated flank it is at rest."""
        zero = 0.0 * phi
        if not self.generation.rolls:
            phi = zero
        modified = [getattr(self, f"modified_roll_{name}") for name in MODIFIED_ROLL]
        vertical = (self.blank_offset, self.vertical_motion_1, self.vertical_motion_2, self.vertical_motion_3)
        helical = (self.sliding_base, self.helical_motion_1, self.helical_motion_2, self.helical_motion_3)
        ratio = self.roll_ratio if self.generation.rolls else 0.0
        turned = _polynomial((0.0, 1.0, *(-c for c in modified)), phi)
        offset, base = _polynomial(vertical, phi), _polynomial(helical, phi)
        return Pose(
            machine=self,
            roll=phi,
            shift=tuple(np.array([zero, y, -x]) for y, x in zip(offset, base, strict=True)),
            work=tuple(ratio * angle for angle in turned),
        )


class MachineInput(InputModel):
    """Table `machine` of a flank: common settings of all machines."""

    process: str
    radial_setting: Length  # distance of the cutter centre from the cradle axis [m]
    cradle_angle: Turn  # angle of the cutter centre around the cradle axis; positive for a right-hand member [rad]
    machine_root_angle: Turn  # angle of the work axis to the machine plane [rad]
    # angles of the cutter axis [rad]
    tilt: Turn = 0.0
    swivel: Turn = 0.0
    # position of the work [m]
    blank_offset: Shift = 0.0
    sliding_base: Shift = 0.0
    machine_centre_to_back: Shift = 0.0

    def settings(self) -> MachineSettings:
        """Numeric values of the settings."""
        numbers = {"roll_ratio": 0.0, **self.model_dump(exclude={"process"})}
        return MachineSettings(**numbers, generation=GENERATIONS[self.process])


class GeneratedMachine(MachineInput):
    """Settings of a generated flank by their trade names; see also `MachineInput`."""

    process: Literal["generated"] = "generated"
    roll_ratio: Annotated[float, ValueRange("", gt=0.0, le=400.0)]  # rotation of the work over that of the cradle [-]
    # coefficients of modified roll by their trade names [-]
    modified_roll_2c: Annotated[float, ValueRange("", ge=-1.0, le=1.0)] = 0.0
    modified_roll_6d: Annotated[float, ValueRange("", ge=-10.0, le=10.0)] = 0.0
    modified_roll_24e: Annotated[float, ValueRange("", ge=-100.0, le=100.0)] = 0.0
    modified_roll_120f: Annotated[float, ValueRange("", ge=-1000.0, le=1000.0)] = 0.0
    modified_roll_720g: Annotated[float, ValueRange("", ge=-10000.0, le=10000.0)] = 0.0
    # derivatives of the sliding base by the cradle roll [m/rad^n]
    helical_motion_1: Shift = 0.0
    helical_motion_2: Shift = 0.0
    helical_motion_3: Shift = 0.0
    # derivatives of the vertical position by the cradle roll [m/rad^n]
    vertical_motion_1: Shift = 0.0
    vertical_motion_2: Shift = 0.0
    vertical_motion_3: Shift = 0.0


class FormateMachine(MachineInput):
    """Settings of a non-generated (Formate) flank: the cradle is at rest, the cutter plunges or only indexes."""

    process: Literal["formate"]


MACHINE_INPUTS: dict[str, type[MachineInput]] = {"generated": GeneratedMachine, "formate": FormateMachine}


def machine_table(machine: MachineSettings) -> dict[str, str | float]:
    """Settings as table `machine` of a design file: required settings, and others that are nonzero."""
    known = MACHINE_INPUTS[machine.generation.name].model_fields
    table: dict[str, str | float] = {"process": machine.generation.name}
    for field in fields(MachineSettings):
        if field.name not in known:
            continue
        value = float(getattr(machine, field.name))
        if known[field.name].is_required() or value != 0.0:
            table[field.name] = value
    return table


@dataclass(frozen=True)
class Pose:
    """Machine at given cradle rolls."""

    machine: MachineSettings
    roll: Array  # cradle roll [rad]
    # from the machine to the work origin: offset and sliding base, and their derivatives by the cradle roll [m]
    shift: tuple[Array, ...]
    work: tuple[Array, ...]  # generating rotation of the work, and its derivatives by the cradle roll [rad]

    def direct(self, vector: Array) -> Array:
        """Directions (3, n) or (3, k, n) from the cutter to the machine frame."""
        return turn((self.machine.cutter_axes @ vector.reshape(3, -1)).reshape(vector.shape), self.roll)

    def place(self, point: Array) -> Array:
        """Points (3, n) from the cutter to the machine frame [m]."""
        return turn(self.machine.cutter_axes @ point + self.machine.cutter_centre[:, None], self.roll)

    def about_work(self, arm: Array) -> Array:
        """Velocity of points for a rotation about the work axis at 1 rad/s, arm from a point of the axis [m/s]."""
        c, s = self.machine.work_axes[2, 0], self.machine.work_axes[2, 2]
        return np.array([-s * arm[1], s * arm[0] - c * arm[2], c * arm[1]])

    def rolling(self, point: Array) -> Array:
        """Velocity of the tool relative to the work at machine-frame points, cradle at 1 rad/s [m/s]."""
        return spin(point) + self.shift[1] - self.work[1] * self.about_work(point + self.shift[0])

    def to_work(self, point: Array, indexed: Array | float) -> Array:
        """Machine-frame points in the frame of the work, rotated by the roll and indexed by an angle [m]."""
        back = np.array([[0.0], [0.0], [self.machine.machine_centre_to_back]])
        return turn(self.machine.work_axes @ (point + self.shift[0]) - back, indexed - self.work[0])

    def to_work_direction(self, vector: Array, indexed: Array | float) -> Array:
        """Machine-frame directions (3, n) or (3, k, n) in the frame of the rotated work."""
        return turn((self.machine.work_axes @ vector.reshape(3, -1)).reshape(vector.shape), indexed - self.work[0])
