"""Stage 3: how the torque spreads over all potential contact lines of all tooth pairs in mesh.

Compatibility: where two flanks touch, tooth deflection plus local approach equals what the rotation closes of the
unloaded gap. Equilibrium: the normal forces carry the pinion torque. Both are solved together, without friction.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.contact_lines import MeshPosition
from efficiency.load.compliance import LocalCompliance, Tooth
from efficiency.load.equilibrium import Equilibrium, solve_equilibrium
from ehl.errors import InputError
from ehl.material import Material, effective_modulus

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class TeethElasticity:
    """Elastic properties of the teeth of both members.

    Parameters
    ----------
    pinion, gear : Tooth
        Bending and shear of one tooth of each member.
    material_pinion, material_gear : Material
        Elastic constants.
    """

    pinion: Tooth
    gear: Tooth
    material_pinion: Material
    material_gear: Material

    @property
    def effective_modulus(self) -> float:
        """E' [Pa]."""
        return effective_modulus(self.material_pinion, self.material_gear)

    def bending(self, position: MeshPosition) -> FloatArray:
        """Deflection of both teeth along the normal at each point per unit force at each point [m/N], (n, n).

        Points of different tooth pairs do not feel each other: the body between the teeth is rigid.
        """
        matrix = np.zeros((position.pair.size, position.pair.size))
        for pair in np.unique(position.pair):
            at = np.flatnonzero(position.pair == pair)
            matrix[np.ix_(at, at)] = self.pinion.influence(
                position.face_pinion[at], position.height_pinion[at]
            ) + self.gear.influence(position.face_gear[at], position.height_gear[at])
        return matrix

    def local(self, position: MeshPosition) -> LocalCompliance:
        """Local compliance of both teeth at each point."""
        depths = (
            self.pinion.depth(position.face_pinion, position.height_pinion),
            self.gear.depth(position.face_gear, position.height_gear),
        )
        materials = (self.material_pinion, self.material_gear)
        return LocalCompliance(position.radius_equivalent, depths, materials, self.effective_modulus)


@dataclass(frozen=True)
class PositionLoad:
    """Load at one mesh position; arrays with one entry per point of the `MeshPosition`.

    Attributes
    ----------
    position : MeshPosition
        Where the points are.
    force : (n,) array
        Normal force of each point [N].
    load_per_length : (n,) array
        w' [N/m].
    pressure_hertz : (n,) array
        Maximum Hertz pressure [Pa]; zero where unloaded.
    approach : float
        Pinion rotation against a held gear that closes gaps and deflects teeth [rad].
    transmission_error : float
        Loaded: unloaded one minus the lag of the gear by the approach [rad of the gear].
    equilibrium : Equilibrium
        Residuals, iterations, status of the solver.
    """

    position: MeshPosition
    force: FloatArray
    load_per_length: FloatArray
    pressure_hertz: FloatArray
    approach: float
    transmission_error: float
    equilibrium: Equilibrium

    @property
    def share(self) -> dict[int, float]:
        """Share of the torque carried by each tooth pair."""
        torque = self.force * self.position.lever_pinion
        return {
            int(pair): float(torque[self.position.pair == pair].sum() / torque.sum())
            for pair in np.unique(self.position.pair)
        }


@dataclass(frozen=True)
class LoadDistribution:
    """Load over one mesh cycle.

    Attributes
    ----------
    torque_pinion : float
        [N m].
    positions : tuple of PositionLoad
        One entry per pinion angle.
    status : {"converged", "failed"}
    reason : str
        First failure's reason.
    tooth_outline : (2, k) array
        Closed outline of the gear tooth, distance from the toe and over the root cone [m].
    """

    torque_pinion: float
    positions: tuple[PositionLoad, ...]
    status: Literal["converged", "failed"]
    reason: str
    tooth_outline: FloatArray

    @property
    def pressure_max(self) -> float:
        """Greatest Hertz pressure of the cycle [Pa]."""
        return max(float(p.pressure_hertz.max()) for p in self.positions)

    @property
    def torque_residual(self) -> float:
        """Worst relative error of the torque balance."""
        return max(p.equilibrium.torque_residual for p in self.positions)

    @property
    def compatibility_residual(self) -> float:
        """Worst violation of compatibility relative to the approach."""
        return max(p.equilibrium.residual for p in self.positions)

    @property
    def transmission_error(self) -> FloatArray:
        """Loaded transmission error of each position [rad of the gear]."""
        return np.array([p.transmission_error for p in self.positions])


def distribute_load(
    cycle: tuple[MeshPosition, ...],
    teeth: TeethElasticity,
    torque_pinion: float,
    normal_torques: FloatArray | None = None,
) -> LoadDistribution:
    """Solve compatibility and equilibrium at each position of a mesh cycle.

    Parameters
    ----------
    cycle : tuple of MeshPosition
        Positions of one pinion pitch.
    teeth : TeethElasticity
        Compliance of both members.
    torque_pinion : float
        Torque on the pinion in its driving direction [N m].
    normal_torques : (positions,) array, optional
        Torque carried by the normal forces at each position, where friction carries the rest [N m].

    Returns
    -------
    LoadDistribution
        A position that does not converge is a recorded status, not an error.

    Raises
    ------
    InputError
        The torque is not positive and finite.
    """
    require_torque(torque_pinion)
    torques = [torque_pinion] * len(cycle) if normal_torques is None else list(normal_torques)
    loads = tuple(
        _load_position(position, teeth, float(torque)) for position, torque in zip(cycle, torques, strict=True)
    )
    failed = [load.equilibrium.reason for load in loads if load.equilibrium.status == "failed"]
    status: Literal["converged", "failed"] = "failed" if failed else "converged"
    return LoadDistribution(torque_pinion, loads, status, failed[0] if failed else "", teeth.gear.outline())


def require_torque(torque_pinion: float) -> None:
    """`InputError` unless the pinion torque [N m] is finite and above 0."""
    if not (np.isfinite(torque_pinion) and torque_pinion > 0.0):
        raise InputError(
            "torque",
            torque_pinion,
            "a finite torque above 0 N m",
            "It acts on the pinion in its driving direction; choose the coast side for the other direction.",
        )


def _load_position(position: MeshPosition, teeth: TeethElasticity, torque: float) -> PositionLoad:
    local = teeth.local(position)
    length = position.length

    def local_deflection(force: FloatArray) -> tuple[FloatArray, FloatArray]:
        approach, slope = local.approach(force / length)
        return approach, slope / length

    solution = solve_equilibrium(teeth.bending(position), local_deflection, position.gap, position.lever_pinion, torque)
    load = solution.force / length
    modulus = teeth.effective_modulus
    ratio = float(np.mean(position.lever_pinion / position.lever_gear))
    return PositionLoad(
        position=position,
        force=solution.force,
        load_per_length=load,
        pressure_hertz=np.sqrt(load * modulus / (2.0 * np.pi * position.radius_equivalent)),
        approach=solution.angle,
        transmission_error=position.transmission_error - solution.angle * ratio,
        equilibrium=solution,
    )
