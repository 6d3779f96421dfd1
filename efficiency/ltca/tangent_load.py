"""Load distribution over a mesh cycle with position-dependent torque, interpolated from a few solutions.

Friction carries a part of the torque that changes with speed, oil and position. The cycle is solved on demand at the
normal torques of some friction coefficients. The forces at other torques follow from the derivative, with an error of
second order in their distribution.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.contact_lines import MeshPosition
from efficiency.ltca import load_distribution
from efficiency.ltca.limits import EdgeLoad, edge_load
from efficiency.ltca.load_distribution import ElasticPosition, LoadDistribution, PositionLoad, TeethElasticity
from ehl.common.arrays import FloatArray, IntArray
from ehl.line_contact import half_width_of_pressure, hertz_pressure

# friction coefficients at which the cycle is solved: the first, and their distance; change of torque between two
# tuned: the three are choices of this work; may be changed after checking the stated error of the torque balance
FRICTION, FRICTION_STEP, TORQUE_STEP = 0.06, 0.08, 0.10
# tuned: largest step of the linear estimate over the torque, for one point and for one of many (this work); may be
# lowered freely at the cost of time
ONE, MANY = 0.01, 0.06
_KEPT = 8


class TangentLoads:
    """Loads of one cycle at any torques of the normal forces.

    cycle: points and compliance.
    teeth: compliance of both members.
    torque: torque of normal and friction forces together [N m].
    arms (n,): lever arms of the unit friction force about the pinion axis at the points of each position [m].
    arm_ratio (positions,): torque of friction with a coefficient of 1 over that of the normal forces [-].
    way (1, -1): 1 if friction on the pinion adds to the torque by its lever arm, -1 if the gear drives.
    start: a solution used as starting value, or one by the step of the friction coefficient.
    lever, arm: levers of the normal forces and of friction about the pinion axis at the points of all positions [m].
    """

    def __init__(
        self,
        cycle: Sequence[ElasticPosition],
        teeth: TeethElasticity,
        torque: float,
        arms: Sequence[FloatArray],
        arm_ratio: FloatArray,
        way: float,
        start: LoadDistribution | Callable[[int], Sequence[FloatArray]],
    ) -> None:
        self.cycle, self.teeth, self.torque, self.arm_ratio = tuple(cycle), teeth, torque, arm_ratio
        self.positions: tuple[MeshPosition, ...] = tuple(elastic.position for elastic in self.cycle)
        self._solved: dict[int, LoadDistribution] = {}
        self._own: list[LoadDistribution] = []
        self._edges: dict[int, tuple[LoadDistribution, EdgeLoad, EdgeLoad]] = {}
        self._start, self._first = start, way * FRICTION
        self._step = min(FRICTION_STEP, TORQUE_STEP / max(float(np.abs(arm_ratio).max()), 1e-9))
        sizes = [p.pair.size for p in self.positions]
        self.starts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
        self.number = np.repeat(np.arange(len(sizes)), sizes)
        self.index = np.arange(self.number.size) - self.starts[self.number]
        self.fields = {
            name: np.concatenate([getattr(p, name) for p in self.positions]) for name in load_distribution.OF_POSITION
        }
        self.lever = np.concatenate([p.lever_pinion for p in self.positions])
        self.arm = np.concatenate(list(arms))
        self.law = load_distribution.LocalApproach.joined([elastic.approach for elastic in self.cycle])
        self._ratio = np.array([float(np.mean(p.lever_pinion / p.lever_gear)) for p in self.positions])
        self._unloaded = np.array([p.transmission_error for p in self.positions])

    def torque_of(self, force: FloatArray, lever: FloatArray) -> FloatArray:
        """Sum of force times lever over the points of each position."""
        return np.asarray(np.add.reduceat(force * lever, self.starts))

    def at(self, normal_torques: FloatArray, longest: float = MANY) -> TangentLoad:
        """Load for given torques of the normal forces at each position [N m].

        If the nearest solution of the friction coefficients deviates by more than the fraction `longest` of the torque,
        that torque itself is solved.
        """
        arm = self.arm_ratio
        friction = -float(np.log(normal_torques / self.torque) @ arm) / max(float(arm @ arm), 1e-12)
        step = round((friction - self._first) / self._step)
        node = self.node(step)
        if _distance(node, normal_torques) > longest:
            node = min((node, *self._own), key=lambda other: _distance(other, normal_torques))
        if _distance(node, normal_torques) > longest:
            node = load_distribution.distribute_load(self.cycle, self.teeth, self.torque, normal_torques, node)
            self._own = [*self._own[1 - _KEPT :], node]
        return self._from(node, normal_torques)

    def node(self, step: int) -> LoadDistribution:
        """Solution at the normal torques of a step of the friction coefficient."""
        if step not in self._solved:
            torques = self.torque * np.exp(-(self._first + step * self._step) * self.arm_ratio)
            # always the same start, so that a load does not depend on earlier solutions
            start = self._start(step) if callable(self._start) else self._start
            self._solved[step] = load_distribution.distribute_load(self.cycle, self.teeth, self.torque, torques, start)
        return self._solved[step]

    def _from(self, node: LoadDistribution, torques: FloatArray) -> TangentLoad:
        force = np.concatenate([p.forces_at(float(t)) for p, t in zip(node.positions, torques, strict=True)])
        # tensile forces are set to zero, and the others carry the torque
        force *= (torques / self.torque_of(force, self.lever))[self.number]
        solved = [p.equilibrium for p in node.positions]
        change = torques - np.array([p.torque for p in node.positions])
        angle = np.array([e.angle for e in solved]) + change / np.array([e.stiffness for e in solved])
        errors = self._unloaded - angle * self._ratio
        return TangentLoad(self, node, force, angle, errors, float(np.max(np.abs(change) / torques)))

    def edges(self, load: TangentLoad) -> EdgeLoad:
        """Load at the edges, interpolated between a solution and a torque one step above."""
        own = np.array([p.torque for p in load.node.positions])
        if id(load.node) not in self._edges:
            here, beyond = (self._from(load.node, own * factor) for factor in (1.0, 1.0 + 0.5 * TORQUE_STEP))
            # keeps the node alive, so that its id is not used again
            self._edges[id(load.node)] = load.node, edge_load(here, self.teeth), edge_load(beyond, self.teeth)
        _, at_node, at_step = self._edges[id(load.node)]
        share = float(np.mean(self.torque_of(load.force, self.lever) / own - 1.0)) / (0.5 * TORQUE_STEP)
        return at_node.towards(at_step, share)


def _distance(node: LoadDistribution, torques: FloatArray) -> float:
    """Largest relative deviation of torques of the normal forces from those of a solution."""
    return float(np.max(np.abs(torques / np.array([p.torque for p in node.positions]) - 1.0)))


class TangentLoad(LoadDistribution):
    """Load over one mesh cycle by linear estimate: a `LoadDistribution` whose parts are computed on first access."""

    def __init__(
        self,
        loads: TangentLoads,
        node: LoadDistribution,
        force: FloatArray,
        angle: FloatArray,
        errors: FloatArray,
        distance: float,
    ) -> None:
        own = {"loads": loads, "node": node, "force": force, "angle": angle, "errors": errors, "distance": distance}
        base = {name: getattr(node, name) for name in ("torque", "status", "reason", "tooth_outline")}
        # attributes of a frozen class
        self.__dict__.update(own | base | {"balance_residual": 0.0})

    loads: TangentLoads  # loads of the cycle
    node: LoadDistribution  # solution from which the estimate starts
    force: FloatArray  # (n,) normal forces at the points of all positions [N]
    angle: FloatArray  # (positions,) approach of the pinion [rad]
    errors: FloatArray  # (positions,) loaded transmission error [rad of the gear]
    distance: float  # largest relative step of the torque [-]
    balance_residual: float

    def scaled(self, factor: FloatArray) -> TangentLoad:
        """The same with the forces of each position times a factor close to 1."""
        force = self.force * factor[self.loads.number]
        return TangentLoad(self.loads, self.node, force, self.angle, self.errors, self.distance)

    @cached_property
    def positions(self) -> tuple[PositionLoad, ...]:
        """Load of each position."""
        solved = [p.equilibrium for p in self.node.positions]
        return load_distribution.loads_of_forces(
            self.loads.positions, self.loads.law, self.force, self.angle, self.errors, solved
        )

    @property
    def cycle(self) -> tuple[MeshPosition, ...]:
        """Points of each position."""
        return self.loads.positions

    @property
    def pressure_hertz_max(self) -> float:
        """Maximum Hertz pressure of the cycle [Pa]."""
        return float(self.loaded["pressure_hertz"].max())

    @cached_property
    def pressure_edge_max(self) -> float:
        """Maximum pressure of elastic contacts at rounded edges [Pa]; 0 without any."""
        return float(load_distribution.edge_pressures(self.loads.law, self.force).max(initial=0.0))

    @property
    def torque_residual(self) -> float:
        """Worst relative error of the torque balance."""
        return self.balance_residual

    @property
    def compatibility_residual(self) -> float:
        """Largest violation of compatibility of the underlying solution relative to the approach."""
        return self.node.compatibility_residual

    @property
    def transmission_error(self) -> FloatArray:
        """Loaded transmission error of each position [rad of the gear]."""
        return self.errors

    @property
    def stiffness_tangent(self) -> FloatArray:
        """Derivative of the pinion torque by the pinion rotation with fixed gear, at each position [N m/rad]."""
        return self.node.stiffness_tangent

    @cached_property
    def at(self) -> IntArray:
        """Indices of the loaded points among those of all positions."""
        return np.flatnonzero(self.force > 0.0)

    @cached_property
    def loaded(self) -> dict[str, FloatArray]:
        """Fields of the loaded points of all positions, concatenated, by name."""
        at, law = self.at, self.loads.law
        force, radius, modulus = self.force[at], law.radius_equivalent[at], law.effective_modulus
        pressure = hertz_pressure(force / law.length[at], radius, modulus)
        at_edge = law.edge_distance[at] < half_width_of_pressure(pressure, radius, modulus)
        of_load: dict[str, NDArray[Any]] = {"force": force, "pressure_hertz": pressure, "at_edge": at_edge}
        return of_load | {name: values[at] for name, values in self.loads.fields.items()}

    @cached_property
    def loaded_position(self) -> IntArray:
        """Number of the position of each of them."""
        return np.asarray(self.loads.number[self.at])

    @cached_property
    def loaded_index(self) -> IntArray:
        """Number of each of them in its position."""
        return np.asarray(self.loads.index[self.at])
