"""Mesh stiffness and forces of the mesh on both shafts over the mesh cycle.

The force of each contact point is ``F (n + mu s)``: normal force along the common normal n, friction along the sliding
direction s (of the pinion relative to the gear; against it where the gear drives). Both shafts carry equal and opposite
forces at the same points, so that force, moment and power balance by construction.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from efficiency.contact.assembly import Axis
from efficiency.ltca.load_distribution import LoadDistribution
from efficiency.ltca.mesh_grids import MeshGrids
from ehl.common.arrays import FloatArray, finite_or_none
from ehl.common.errors import InputError

_SIGNS = {"pinion": -1.0, "gear": 1.0}  # the normals point into the gear


@dataclass(frozen=True)
class ShaftForces:
    """Force of the mesh on one shaft at each position.

    The directions are those of the mean point of the force in the cycle: axial along the axis, radial normal to it
    through that point, tangential normal to both.
    """

    axial: FloatArray  # positive away from the crossing point of the axes, out of the mesh [N]; parallel axes: along it
    radial: FloatArray  # positive away from the other member [N]
    tangential: FloatArray  # positive in the direction of the torque [N]
    torque: FloatArray  # about the axis [N m]
    radius: float  # distance of the mean point from the axis [m]
    place: float  # position of the mean point on the axis, from the crossing point [m]


@dataclass(frozen=True)
class MeshForces:
    """Mesh stiffness and shaft forces over one pinion pitch."""

    pinion_angle: FloatArray  # angle of each position [rad]
    # derivative of the pinion torque by the pinion rotation with fixed gear [N m/rad]; nan for a load read from a file
    stiffness: FloatArray
    pinion: ShaftForces
    gear: ShaftForces

    def to_dict(self) -> dict[str, Any]:
        """Content for JSON, SI units; not-a-number becomes None."""
        return dict(finite_or_none(self))


def shaft_wrenches(
    load: LoadDistribution, axis: Axis, sign: float, friction: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Force [N] of each position on a shaft and its moment about the origin of its axis [N m], and the mean point.

    load: forces of a mesh cycle.
    axis: axis of the member.
    sign: 1 for the gear, into which the normals point; -1 for the pinion.
    friction: friction coefficients of the loaded points, negative where the gear drives; default: none.
    Returns: (positions, 6) along two directions normal to the axis and along it; mean point of the forces (3,) in
    these directions from that origin [m].
    """
    cycle, at = load.cycle, np.flatnonzero(np.concatenate([p.force for p in load.positions]) > 0.0)
    arms, vectors = (np.concatenate([getattr(p, name) for p in cycle])[at] for name in ("position", "normal"))
    force, arms = load.loaded["force"], arms - axis.origin
    if friction is not None:
        vectors = vectors + friction[:, None] * np.concatenate([p.sliding_direction for p in cycle])[at]
    direction = axis.direction
    first = np.eye(3)[int(np.argmin(np.abs(direction)))]
    first = first - direction * (first @ direction)
    first = first / np.linalg.norm(first)
    frame = np.array([first, np.cross(direction, first), direction])
    vectors = sign * force[:, None] * vectors
    both = np.concatenate([vectors @ frame.T, np.cross(arms, vectors) @ frame.T], axis=1)
    number = load.loaded_position
    found = np.stack([np.bincount(number, column, len(cycle)).astype(float) for column in both.T], axis=1)
    return found, frame @ (force @ arms) / force.sum()


def mesh_forces(load: LoadDistribution, mesh: MeshGrids, friction: FloatArray | None = None) -> MeshForces:
    """Mesh stiffness and shaft forces of a load of a mesh; `friction` as in `shaft_wrenches`."""
    if mesh.axes is None:
        raise InputError("mesh.axes", None, "the axes of both members")
    shafts = {}
    for (name, sign), axis in zip(_SIGNS.items(), mesh.axes, strict=True):
        wrench, mean = shaft_wrenches(load, axis, sign, friction)
        radius = float(np.hypot(mean[0], mean[1]))
        outwards = mean[:2] / radius
        around, torque = wrench[:, :2] @ np.array([-outwards[1], outwards[0]]), wrench[:, 5]
        way = float(np.sign(torque.mean()))
        forces = wrench[:, 2], -wrench[:, :2] @ outwards, way * around, way * torque
        shafts[name] = ShaftForces(*forces, radius, float(mean[2]))
    angles = np.array([p.pinion_angle for p in load.cycle])
    return MeshForces(angles, np.array(load.stiffness_tangent), shafts["pinion"], shafts["gear"])
