"""Torque balance with friction: normal forces that carry the pinion torque together with the friction forces.

Friction is computed at estimated forces, then the torque of both, corrected normal forces, and friction at these. One
correction is often sufficient, because friction changes little with the load. The loss is the sum of mu F |v_s|. The
final forces are scaled so that torque and energy are in balance to rounding (`efficiency.loss.efficiency`).
"""

import math

import numpy as np

from efficiency.loss.kinematics import Operation, loaded_points
from efficiency.ltca.mesh_grids import FrictionBalance, LoadedGrids
from efficiency.ltca.tangent_load import MANY, ONE, TangentLoad
from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError
from regression.friction.models import COLEMAN_FRICTION, Request, Run

ROUNDS = 40
# stated error of the efficiency that requires another round, for one point and for one of many
WORTH, WORTH_MANY = 1e-7, 2e-6
# change of ln(mu) by ln(normal force): estimate for the next round, and bound in the stated error (this work; up to
# 0.52 measured along the mesh of a hypoid with a fitted formula)
EXPECTED, BOUND = 0.1, 0.7
# relative error of the loss over the square of the step of a tangent (this work; up to 0.15 measured with 6 x 15
# points)
TANGENT = 0.3


def balance_friction(loaded: LoadedGrids, operation: Operation, *, many: bool = False) -> Run[LoadedGrids]:
    """Load over the cycle with normal and friction forces that carry the pinion torque together.

    For a model with solved contacts the forces are those of a formula of the same oil; the contacts are solved once.

    loaded: the mesh under that torque without friction, with the axes of both members.
    operation: speed, oil temperature, roughness.
    many: for one of many points: fewer solutions of the load are shared by all points, and friction is evaluated on the
        coarse grid; the stated error is larger.
    Returns forces that `efficiency.loss.efficiency.mesh_efficiency` brings into balance with its friction.
    Raises `InputError`: the mesh has no axes.
    Raises `ConvergenceError`: ``self_locking`` if friction exceeds the torque, ``load_balance_limit`` if the iteration
        does not converge.
    """
    torque, modulus = loaded.coarse.torque, loaded.mesh.teeth.effective_modulus
    # if the gear drives, all sliding velocities are reversed
    way = 1.0 if operation.driver == "pinion" else -1.0
    fine, coarse = loaded.tangents(way)
    ratio = np.exp(-way * COLEMAN_FRICTION * coarse.arm_ratio)
    power = torque * operation.speed * len(loaded.mesh.coarse)
    grid, worth, longest = (coarse, WORTH_MANY, MANY) if many else (fine, WORTH, ONE)
    for rounds in range(1, ROUNDS + 1):
        load = grid.at(torque * ratio)
        points = loaded_points(load, modulus, operation)
        mu = (yield Request(points.state))[1].mu
        # missing friction is reported with the loss
        mu = np.where(np.isfinite(mu), mu, COLEMAN_FRICTION)
        share = carried_share(load, points.force, mu, way)
        if np.any(share <= 0.0):
            raise ConvergenceError("self_locking", "friction exceeds the pinion torque")
        ratio = ratio / share
        moved = float(np.abs(np.log(share)).mean())
        lost = float(np.sum(mu * points.force * points.speed_sliding)) / power
        feedback = EXPECTED * float(np.abs(np.log(ratio)).mean())
        if balance_error(lost, feedback * moved, 0.0) < worth or load.reason:
            balance = FrictionBalance(way, rounds)
            loads = (grid.at(torque * ratio, longest) for grid in (fine, coarse))
            return LoadedGrids(loaded.mesh, next(loads), next(loads), balance)
    raise ConvergenceError("load_balance_limit", f"torque imbalance of {moved:.2g} after {ROUNDS} rounds")


def carried_share(load: TangentLoad, force: FloatArray, mu: FloatArray, way: float) -> FloatArray:
    """Torque about the pinion axis of normal and friction forces at each position, over the pinion torque [-]."""
    loads, at = load.loads, load.at
    torque = force * (loads.lever[at] + way * mu * loads.arm[at])
    carried = np.bincount(load.loaded_position, torque, len(loads.cycle))
    return np.asarray(carried / load.torque)


def closed(load: TangentLoad, mu: FloatArray, way: float) -> tuple[TangentLoad, float]:
    """Forces of each position scaled into balance with friction, and their mean relative change.

    The forces are unchanged if friction is not available everywhere; the change is infinite if friction exceeds the
    torque.
    """
    share = carried_share(load, load.loaded["force"], mu, way)
    if not np.all(np.isfinite(share)):
        return load, 0.0
    if np.any(share <= 0.0):
        return load, math.inf
    found = load.scaled(1.0 / share)
    residual = np.abs(carried_share(found, found.loaded["force"], mu, way) - 1.0).max()
    found.__dict__["balance_residual"] = float(residual)
    return found, float(np.abs(np.log(share)).mean())


def balance_error(loss: float, moved: float, distance: float) -> float:
    """Error of the efficiency from the change of forces since friction was computed, and from their tangents [-].

    loss: loss over the power at the pinion [-].
    moved: mean relative change of the forces since friction was computed [-].
    distance: step of the tangents relative to the torque [-].
    """
    return loss * (BOUND * moved + TANGENT * distance**2)
