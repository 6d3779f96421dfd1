"""Stage 4, second half: friction against the sliding, summed over the contact lines and averaged over the cycle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from efficiency.loss.kinematics import Driver, LoadedPoints

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


def rolling_losses(points: LoadedPoints, rolling_traction: FloatArray, positions: int) -> FloatArray:
    """Power lost to the pressure-driven flow at each position, sum of 2 F t_r u_r [W].

    The work on both surfaces, ``u_r integral(h dp)``, is what that flow dissipates; ``t_r`` is ``integral(h/2 dp)/w'``.

    Parameters
    ----------
    points : LoadedPoints
        Loaded points of the cycle.
    rolling_traction : (n,) array
        Of each surface over the load [-].
    positions : int
        Number of positions in the cycle.

    Returns
    -------
    (positions,) array
    """
    power = 2.0 * rolling_traction * points.force * points.state.speed_entrainment
    losses = np.zeros(positions)
    np.add.at(losses, points.position, power)
    return losses


def efficiency_of(power_loss: float, torque: float, speed: float, driver: Driver = "pinion") -> float:
    """Mesh efficiency, power out over power in [-].

    The torque is that at the pinion shaft: with the pinion driving ``1 - loss/(T1 omega1)``, with the gear driving
    ``T1 omega1/(T1 omega1 + loss)``.

    Parameters
    ----------
    power_loss : float
        Mean loss [W].
    torque, speed : float
        [N m], [rad/s].
    driver : {"pinion", "gear"}
        Member the power comes from.
    """
    pinion = torque * speed
    return 1.0 - power_loss / pinion if driver == "pinion" else pinion / (pinion + power_loss)
