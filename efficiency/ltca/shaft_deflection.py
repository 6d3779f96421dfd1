"""Deflection of shafts, bearings and housing under the mesh force, solved with the contact.

mesh force and its moment, mean of the cycle  ->  K^-1  ->  moved axes  ->  misalignment  ->  contact  ->  mesh force

The forces are the normal forces that carry the torque. Friction is neglected in the load of the shafts, because it
would require a mesh for each friction model, speed and driving member. For the hypoid pair of the tests, friction
changes the displacements by 6 % and the loss by 0.5 % at a friction coefficient of 0.05, and by 13 % and 1 % at 0.1.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from efficiency.contact.assembly import Assembly, DisplacedAxes, RigidMove, displaced_axes
from efficiency.ltca.load_distribution import LoadDistribution
from efficiency.ltca.mesh_grids import MeshGrids, ShaftDeflection, load_grids
from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError

# tuned: last change of E, P, G [m] and of the shaft angle [rad], a tenth of a visible change of a transmission error
# (this work); may be lowered freely
TOLERANCE, TOLERANCE_ANGLE = 1e-7, 1e-6
ROUNDS = 12
# number of earlier rounds for the response of the load to a displacement
REMEMBERED = 3


@dataclass(frozen=True)
class MemberCompliance:
    """Compliance of a member for a force and a moment at a point of its axis."""

    # (6, 6) displacement [m] and rotation [rad] along x, y, z under force [N] and moment [N m], in the frame of the
    # member: z along its axis from the crossing point to the teeth, y = gear axis x pinion axis, x = y x z
    matrix: FloatArray
    reference: float  # position of the point on the axis, from the crossing point [m]

    def move(self, frame: FloatArray, apex: FloatArray, points: FloatArray, forces: FloatArray) -> RigidMove:
        """Displacement under forces (n, 3) [N] at points (n, 3) [m]; axes and apex of the member in the mesh frame."""
        at = apex + self.reference * frame[:, 2]
        force, moment = forces.sum(axis=0), np.cross(points - at, forces).sum(axis=0)
        found = self.matrix @ np.concatenate([frame.T @ force, frame.T @ moment])
        return RigidMove(at, frame @ found[:3], frame @ found[3:])


def shaft_compliance(
    at: float,
    bearings: list[tuple[float, float, float]],
    diameter: float,
    bore: float,
    youngs_modulus: float,
    poisson_ratio: float,
) -> FloatArray:
    """Displacement of a point of a shaft under unit forces and moments there, (6, 6) [m/N], [rad/N], [rad/(N m)].

    Timoshenko beam elements between bearings and point, springs at the bearings. The point is at a position [m] on the
    axis z. Bearings are (position, radial and axial stiffness) [m], [N/m], at two or more positions, at least one of
    them with axial stiffness. Rotation about the axis is fixed at the bearing farthest from the point.
    """
    places = np.unique([at, *(place for place, _, _ in bearings)])
    area = math.pi / 4.0 * (diameter**2 - bore**2)
    inertia = math.pi / 64.0 * (diameter**4 - bore**4)
    shear = youngs_modulus / (2.0 * (1.0 + poisson_ratio))
    # shear coefficient of a hollow circle (Cowper 1966)
    ratio, nu = bore / diameter, poisson_ratio
    square = (1.0 + ratio**2) ** 2
    cowper = 6.0 * (1.0 + nu) * square / ((7.0 + 6.0 * nu) * square + (20.0 + 12.0 * nu) * ratio**2)
    bending, pull = np.zeros((2 * places.size, 2 * places.size)), np.zeros((places.size, places.size))
    for i, length in enumerate(np.diff(places)):
        phi = 12.0 * youngs_modulus * inertia / (cowper * shear * area * length**2)
        a, b, c = 6.0 * length, (4.0 + phi) * length**2, (2.0 - phi) * length**2
        beam = np.array([[12.0, a, -12.0, a], [a, b, -a, c], [-12.0, -a, 12.0, -a], [a, c, -a, b]])
        bending[2 * i : 2 * i + 4, 2 * i : 2 * i + 4] += youngs_modulus * inertia / (length**3 * (1.0 + phi)) * beam
        pull[i : i + 2, i : i + 2] += youngs_modulus * area / length * np.array([[1.0, -1.0], [-1.0, 1.0]])
    for place, radial, axial in bearings:
        node = int(np.searchsorted(places, place))
        bending[2 * node, 2 * node] += radial
        pull[node, node] += axial
    node = int(np.searchsorted(places, at))
    own = slice(2 * node, 2 * node + 2)
    # deflection and slope under force and moment, in the plane x-z; in y-z the rotation about x is minus the slope
    plane = np.linalg.solve(bending, np.eye(2 * places.size))[own, own]
    found = np.zeros((6, 6))
    found[np.ix_((0, 4), (0, 4))] = plane
    flip = np.array([1.0, -1.0])
    found[np.ix_((1, 3), (1, 3))] = plane * np.outer(flip, flip)
    found[2, 2] = np.linalg.solve(pull, np.eye(places.size))[node, node]
    found[5, 5] = max(abs(at - place) for place, _, _ in bearings) / (shear * 2.0 * inertia)
    return 0.5 * (found + found.T)


Compliances = tuple[MemberCompliance | None, MemberCompliance | None]
"""Compliances of pinion and gear; None for a rigid member."""


def axes_under_load(
    placed: Assembly, compliances: Compliances, load: LoadDistribution, now: DisplacedAxes
) -> DisplacedAxes:
    """Axes of members displaced by a load.

    `placed` are the axes without load; `now` are the axes to whose mesh frame the load refers.
    """
    forces = np.concatenate([p.force[:, None] * p.position.normal for p in load.positions])
    points = np.concatenate([p.position.position for p in load.positions])
    forces = forces @ now.frame.T / len(load.positions)
    points = points @ now.frame.T + now.origin
    frames = placed.pinion_frame, np.eye(3)
    apexes = placed.pinion_origin[:, 0], np.array([0.0, 0.0, placed.G])
    # the normals point into the gear
    moves = [
        RigidMove(apex, np.zeros(3), np.zeros(3)) if given is None else given.move(frame, apex, points, sign * forces)
        for given, frame, apex, sign in zip(compliances, frames, apexes, (-1.0, 1.0), strict=True)
    ]
    return displaced_axes(placed, moves[0], moves[1])


def solve_deflection(
    placed: Assembly, compliances: Compliances, torque: float, meshes: Sequence[Callable[[DisplacedAxes], MeshGrids]]
) -> MeshGrids:
    """The mesh at the misalignment that its own load produces, by fixed-point iteration with Anderson acceleration.

    `placed` and `compliances` are the axes without load and the members; `torque` is that of the pinion [N m]. `meshes`
    make the mesh at other misalignments: first with few points for an approximation, last for the result. If the load
    has no solution, the mesh is returned as placed, and its load states the reason. Raises `ConvergenceError` with
    ``deflection_limit`` if the misalignments do not converge.
    """
    rest = RigidMove(np.zeros(3), np.zeros(3), np.zeros(3))
    now = displaced_axes(placed, rest, rest)
    rounds = 0
    steps: list[tuple[FloatArray, FloatArray]] = []
    for mesh_at in meshes:
        before: tuple[FloatArray, FloatArray] | None = None
        for _ in range(ROUNDS):
            mesh, rounds = mesh_at(now), rounds + 1
            load = load_grids(mesh, torque).coarse
            if load.reason:
                return meshes[-1](now)
            found = axes_under_load(placed, compliances, load, now)
            change, turned = found.distance(now)
            if change < TOLERANCE and turned < TOLERANCE_ANGLE:
                break
            put, left = _vector(now), _vector(found) - _vector(now)
            if before is not None:
                steps = [*steps, (put - before[0], left - before[1])][-REMEMBERED:]
            before = put, left
            now = _moved(found, put + left - _secant(steps, left))
        else:
            raise ConvergenceError(
                "deflection_limit",
                f"E, P, G still change by {change * 1e6:.3g} um and the shaft angle by {turned * 1e6:.3g} urad after "
                f"{ROUNDS} rounds: shafts and bearings are too compliant for this torque",
            )
    turned = now.shaft_angle_error - placed.shaft_angle_error
    moved = (now.E - placed.E, now.P - placed.P, now.G - placed.G, turned)
    return replace(mesh, deflection=ShaftDeflection(*moved, rounds, change))


def _vector(axes: DisplacedAxes) -> FloatArray:
    """E, P, G and shaft_angle_error on one scale [m]."""
    return np.array([axes.E, axes.P, axes.G, axes.shaft_angle_error * TOLERANCE / TOLERANCE_ANGLE])


def _moved(axes: DisplacedAxes, vector: FloatArray) -> DisplacedAxes:
    E, P, G, turned = map(float, vector)
    return replace(axes, E=E, P=P, G=G, shaft_angle_error=turned * TOLERANCE_ANGLE / TOLERANCE)


def _secant(steps: list[tuple[FloatArray, FloatArray]], left: FloatArray) -> FloatArray:
    """Correction of the plain iteration: combination of earlier steps with the smallest residual (Anderson).

    `steps`: changes of the displacement and of its residual in earlier rounds; `left` (4,): residual, the displacement
    under the load minus the assumed one.
    """
    if not steps:
        return np.zeros(4)
    put, residuals = (np.array(part).T for part in zip(*steps, strict=True))
    size = np.linalg.norm(residuals, axis=0)
    size[size == 0.0] = 1.0
    share = np.linalg.lstsq(residuals / size, left, rcond=1e-3)[0] / size
    return np.asarray((put + residuals) @ share)
