"""Arms of the friction force about the axes of both members."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.assembly import Axis
from efficiency.contact.contact_lines import MeshPosition

FloatArray = NDArray[np.float64]


def friction_arm(position: MeshPosition, axis: Axis) -> FloatArray:
    """Arm about an axis of the unit friction force that the pinion exerts on the gear [m], (n,).

    Counted like the levers of the normal force: positive where friction on the pinion adds to the torque it needs,
    and where friction on the gear adds to the torque it delivers. That is for a driving pinion; where the gear drives
    friction pulls the other way.

    Parameters
    ----------
    position : MeshPosition
        Points, normals and sliding.
    axis : Axis
        Of the pinion or of the gear.
    """
    along, across = position.sliding_along[:, None], position.sliding_across[:, None]
    sliding = along * position.along + across * position.across
    speed = np.linalg.norm(sliding, axis=1)
    # at the pitch line friction has no direction and does no work
    force = sliding / np.where(speed > 0.0, speed, 1.0)[:, None]
    arm = position.position - axis.origin

    def turning(direction: FloatArray) -> FloatArray:
        return np.asarray(np.cross(arm, direction) @ axis.direction)

    return turning(force) * np.sign(turning(position.normal))
