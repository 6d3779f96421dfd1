"""Power loss: friction times sliding, summed over the contact lines and averaged over the cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from efficiency.loss.kinematics import Driver, LoadedPoints
from ehl.common.arrays import FloatArray

if TYPE_CHECKING:
    from efficiency.loss.efficiency_result import EfficiencyResult

HEIGHTS = ("root", "middle", "tip")
FACES = ("toe", "middle", "heel")


def position_losses(points: LoadedPoints, friction_coefficient: FloatArray, positions: int) -> FloatArray:
    """Power lost to sliding friction at each position, sum of mu F |v_s| [W].

    points: loaded points of the cycle.
    friction_coefficient (n,): mu at each of them.
    positions: number of positions in the cycle.
    """
    return _by_position(points, friction_coefficient * points.force * points.speed_sliding, positions)


def rolling_losses(points: LoadedPoints, rolling_traction: FloatArray, positions: int) -> FloatArray:
    """Power lost to the pressure-driven flow at each position, sum of 2 F t_r u_r [W].

    The loss is the work on both surfaces, ``u_r integral(h dp)``; ``t_r`` is ``integral(h/2 dp)/w'``.

    points: loaded points of the cycle.
    rolling_traction (n,): traction of each surface over the load [-].
    positions: number of positions in the cycle.
    """
    return _by_position(points, 2.0 * rolling_traction * points.force * points.state.speed_entrainment, positions)


def _by_position(points: LoadedPoints, power: FloatArray, positions: int) -> FloatArray:
    return np.asarray(np.bincount(points.position, power, positions), dtype=np.float64)


def efficiency_of(power_loss: float, torque: float, speed: float, driver: Driver = "pinion") -> float:
    """Mesh efficiency, output power over input power [-].

    With the pinion driving ``1 - loss/(T1 omega1)``, with the gear driving ``T1 omega1/(T1 omega1 + loss)``.

    power_loss: mean loss [W].
    torque, speed: of the pinion shaft [N m], [rad/s].
    driver: driving member.
    """
    pinion = torque * speed
    return 1.0 - power_loss / pinion if driver == "pinion" else pinion / (pinion + power_loss)


def loss_of(efficiency: float, torque: float, speed: float, driver: Driver = "pinion") -> float:
    """Mean loss at a mesh efficiency [W], the inverse of `efficiency_of`; parameters as there."""
    return torque * speed * (1.0 - efficiency if driver == "pinion" else 1.0 / efficiency - 1.0)


def loss_by_region(result: EfficiencyResult) -> FloatArray:
    """Share of the sliding loss in nine regions of the gear flank, thirds of its height and face width, (3, 3).

    Returns: rows root, middle, tip; columns toe, middle, heel of the gear; their sum is 1; nan without loss.
    """
    points, outline = result.points, result.load.tooth_outline
    face, height = (result.points.values(result.load.cycle, name) for name in ("face_gear", "height_gear"))
    width = float(outline[0].max() - outline[0].min())
    row, column = height / local_height(outline, face), (face - outline[0].min()) / width
    inside: list[FloatArray] = [np.clip(share, 0.0, 1.0) for share in (row, column)]
    power = result.friction.mu * points.force * points.speed_sliding
    whole = ((0.0, 1.0), (0.0, 1.0))
    shares = np.histogram2d(inside[0], inside[1], 3, whole, weights=power)[0]
    total = shares.sum()
    return shares / total if total > 0.0 else np.full((3, 3), np.nan)


def local_height(outline: FloatArray, face: FloatArray) -> FloatArray:
    """Height of a flank at distances from the toe [m]: the upper side of its closed outline (2, k)."""
    x, y = outline
    inside = np.clip(face, x.min(), x.max())[:, None]
    x0, x1, y0, y1 = x[:-1], x[1:], y[:-1], y[1:]
    run = np.where(x1 == x0, 1.0, x1 - x0)
    height = y0 + (inside - x0) / run * (y1 - y0)
    met = (inside >= np.minimum(x0, x1)) & (inside <= np.maximum(x0, x1)) & (x1 != x0)
    return np.asarray(np.where(met, height, -np.inf).max(axis=1))


def friction_along_mesh(result: EfficiencyResult) -> FloatArray:
    """Friction coefficient at each position of the mesh cycle, weighted with the sliding power; nan without sliding."""
    count = result.solution.positions
    sliding, mu = position_losses(result.points, np.ones(result.points.force.size), count), np.full(count, np.nan)
    np.divide(result.cycle.power_loss, sliding, out=mu, where=sliding > 0.0)
    return mu
