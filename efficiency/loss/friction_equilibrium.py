"""Option: friction in the load equilibrium.

The friction force turns both members too, so the normal forces that carry a pinion torque are not those of the
frictionless mesh. The loss is still the sum of mu F |v_s|; only the forces change.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.contact_lines import MeshPosition
from efficiency.loss.efficiency import LoadedGrids, MeshGrids, load_grids
from efficiency.loss.kinematics import Axis, Operation, join_states, loaded_points
from efficiency.ltca.load_distribution import LoadDistribution, distribute_load
from ehl.fluid.oil import Oil
from ehl.io.errors import ConvergenceError, InputError
from regression.friction.models import FrictionFlag, FrictionModel

FloatArray = NDArray[np.float64]

TOLERANCE = 1e-10
LIMIT = 30


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


def load_grids_with_friction(
    mesh: MeshGrids,
    torque_pinion: float,
    friction: FrictionModel,
    oil: Oil,
    operation: Operation,
    frictionless: LoadedGrids | None = None,
) -> LoadedGrids:
    """Load over the cycle when normal and friction forces together carry the pinion torque.

    The frictionless problem is solved for a torque at each position that is corrected until the sum of both kinds of
    force carries ``torque_pinion``.

    Parameters
    ----------
    mesh : MeshGrids
        With the axes of both members.
    torque_pinion : float
        [N m].
    friction : FrictionModel
        Evaluated anew in each round.
    oil : Oil
        Oil card.
    operation : Operation
        Speed, oil temperature, roughness.
    frictionless : LoadedGrids, optional
        The mesh under that torque without friction, where it is known.

    Raises
    ------
    InputError
        The torque is not above 0, or the mesh has no axes.
    ConvergenceError
        ``self_locking`` where friction takes the whole torque, ``friction_rounds`` where the torques do not settle,
        ``friction_not_converged`` and ``friction_undefined`` where the friction model fails.
    """
    # deflected and with lines as long as the load without friction needs them
    mesh = (frictionless or load_grids(mesh, torque_pinion)).mesh
    if mesh.axes is None:
        raise InputError("mesh.axes", None, "the axes of both members, for the arms of the friction forces")
    grids = (mesh.elastic_fine, mesh.elastic_coarse)
    # where the gear drives, everything slides the other way
    way = 1.0 if operation.driver == "pinion" else -1.0
    arms = [[way * friction_arm(elastic.position, mesh.axes[0]) for elastic in cycle] for cycle in grids]
    torques = [np.full(len(cycle), torque_pinion) for cycle in grids]
    modulus = mesh.teeth.effective_modulus
    for _ in range(LIMIT):
        loads = [
            distribute_load(cycle, mesh.teeth, torque_pinion, normal_torques=values)
            for cycle, values in zip(grids, torques, strict=True)
        ]
        points = [loaded_points(load, modulus, operation) for load in loads]
        estimate = friction.evaluate(join_states(*(p.state for p in points)), oil)
        mu = estimate.mu
        if not np.all(np.isfinite(mu)):
            failed = np.any(estimate.flag == FrictionFlag.NOT_CONVERGED)
            reason = "friction_not_converged" if failed else "friction_undefined"
            raise ConvergenceError(reason, f"{friction.name} in the load equilibrium")
        off = 0.0
        for k, part in enumerate(np.split(mu, [points[0].force.size])):
            carried = _carried(loads[k], points[k].position, points[k].index, part, arms[k])
            if np.any(carried <= 0.0):
                raise ConvergenceError("self_locking", "friction takes the whole pinion torque")
            off = max(off, float(np.max(np.abs(carried / torque_pinion - 1.0))))
            torques[k] = torques[k] * torque_pinion / carried
        if off < TOLERANCE:
            return LoadedGrids(mesh, loads[0], loads[1], friction_in_equilibrium=True)
    raise ConvergenceError("friction_rounds", f"torque off by {off:.2g} after {LIMIT} rounds")


def _carried(
    load: LoadDistribution,
    position: NDArray[np.int64],
    index: NDArray[np.int64],
    mu: FloatArray,
    arms: list[FloatArray],
) -> FloatArray:
    """Pinion torque of normal and friction forces at each position [N m]."""
    total = np.zeros(len(load.positions))
    for k, (p, arm) in enumerate(zip(load.positions, arms, strict=True)):
        at = position == k
        force, here = p.force[index[at]], index[at]
        total[k] = force @ (p.position.lever_pinion[here] + mu[at] * arm[here])
    return total
