"""Stage 4, second half: friction against the sliding, summed over the contact lines and averaged over the cycle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from efficiency.loss.kinematics import LoadedPoints

FloatArray = NDArray[np.float64]


def position_losses(points: LoadedPoints, friction_coefficient: FloatArray, positions: int) -> FloatArray:
    """Power lost to sliding friction at each position, sum of mu F |v_s| [W].

    Parameters
    ----------
    points : LoadedPoints
        Loaded points of the cycle.
    friction_coefficient : (n,) array
        mu at each of them.
    positions : int
        Number of positions in the cycle.

    Returns
    -------
    (positions,) array
    """
    power = friction_coefficient * points.force * points.speed_sliding
    losses = np.zeros(positions)
    np.add.at(losses, points.position, power)
    return losses


def efficiency_of(power_loss: float, torque_pinion: float, speed_pinion: float) -> float:
    """Mesh efficiency ``1 - loss/(T1 omega1)`` [-] from a mean loss [W], torque [N m] and speed [rad/s]."""
    return 1.0 - power_loss / (torque_pinion * speed_pinion)
