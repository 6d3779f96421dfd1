"""Stage 3: distribution of the torque over the potential contact lines of all tooth pairs in mesh.

Compatibility: where two flanks touch, tooth deflection plus local approach equals the reduction of the unloaded gap by
the rotation. Equilibrium: the normal forces carry the pinion torque. Both are solved together, without friction.
The local compliance of the flanks is after Weber, with the tooth edges near the contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from efficiency.contact.contact_lines import EdgeProximity, MeshPosition
from efficiency.contact.mesh_surface import EDGES
from efficiency.ltca.edge_contact import EdgeSection, free_edge_compliance
from efficiency.ltca.equilibrium import Equilibrium, EquilibriumProblem, solve_equilibrium
from efficiency.ltca.solid_tooth import SolidTooth
from ehl.common.arrays import BoolArray, FloatArray, IntArray
from ehl.common.errors import InputError
from ehl.line_contact import hertz_half_width, hertz_pressure
from ehl.material import Material, effective_modulus


def weber_local(
    load_per_length: ArrayLike, half_width: ArrayLike, depth: ArrayLike, youngs_modulus: float, poisson_ratio: float
) -> FloatArray:
    """Approach of a Hertz line contact of half-width b to a point at the depth h below it, for one body [m].

    Plane strain of the Hertz stresses on the axis of symmetry, integrated from the surface to the depth (this work):

        d = 2 w'(1 - nu^2)/(pi E) [asinh(h/b) - nu/(1 - nu) (H sqrt(1 + H^2) - H^2)],  H = h/b.

    For h >> b it approaches the formula of Weber (1949) with ``ln(2 h/b) - nu/(2 (1 - nu))`` in the bracket, but it is
    never negative.
    """
    ratio = np.asarray(depth, float) / np.asarray(half_width, float)
    scale = 2.0 * np.asarray(load_per_length, float) * (1.0 - poisson_ratio**2) / (np.pi * youngs_modulus)
    # H sqrt(1+H^2) - H^2 without cancellation
    lateral = ratio / (np.sqrt(1.0 + ratio**2) + ratio)
    return np.asarray(scale * (np.arcsinh(ratio) - poisson_ratio / (1.0 - poisson_ratio) * lateral))


@dataclass(frozen=True)
class LocalApproach:
    """Load-deflection law of n points: local compliance of both bodies with the tooth edges near the contact."""

    length: FloatArray  # (n,) length of contact line represented by each point [m]
    radius_equivalent: FloatArray  # (n,) equivalent radius normal to the contact line [m]
    depths: Sequence[FloatArray]  # distance from the flank to the middle plane of pinion and gear tooth [m]
    free_edge: FloatArray  # (n,) additional compliance near a free edge [m2/N]
    # (n,) distance of the closest approach from the edge [m], negative beyond it; infinite without edges
    edge_distance: FloatArray
    rounding: FloatArray  # (n,) radius of the edge [m]; unused without edges
    materials: Sequence[Material]  # pinion and gear
    effective_modulus: float  # E' [Pa]

    @classmethod
    def joined(cls, parts: Sequence[LocalApproach]) -> LocalApproach:
        """Concatenated points of several laws of the same bodies."""
        depths = [np.concatenate([part.depths[k] for part in parts]) for k in (0, 1)]
        names = ("length", "radius_equivalent", "free_edge", "edge_distance", "rounding")
        arrays: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
        return replace(parts[0], depths=depths, **arrays)

    def half_width(self, load: FloatArray) -> FloatArray:
        """Hertz half-width of the flanks without edges for a load per length [m]."""
        return hertz_half_width(load, self.radius_equivalent, self.effective_modulus)

    def sections(self, load: FloatArray) -> tuple[IntArray, EdgeSection]:
        """Points whose contact reaches an edge, and their edge contact."""
        half_width = self.half_width(load)
        # a force whose contact width underflows to zero is no contact
        at = np.flatnonzero((self.edge_distance < half_width) & (half_width > 0.0))
        ratio = self.radius_equivalent[at] / self.rounding[at]
        return at, EdgeSection.of(self.edge_distance[at] / half_width[at], ratio)

    def of_flanks(self, load_per_length: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Approach of both middle planes without edges [m], and its derivative by the load per length [m2/N]."""
        b = self.half_width(load_per_length)
        total, slope = np.zeros_like(b), np.zeros_like(b)
        for depth, material in zip(self.depths, self.materials, strict=True):
            nu = material.poisson_ratio
            part = weber_local(load_per_length, b, depth, material.youngs_modulus, nu)
            scale = 2.0 * (1.0 - nu**2) / (np.pi * material.youngs_modulus)
            ratio = depth / b
            # d/dw of w f(h/b), b ~ sqrt(w): f - (H/2) f'(H)
            root = np.sqrt(1.0 + ratio**2)
            dlateral = (root - ratio) ** 2 / root
            total += part
            slope += part / load_per_length - scale * 0.5 * ratio * (1.0 / root - nu / (1.0 - nu) * dlateral)
        return total, slope

    def __call__(self, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Local approach at each point [m] and its derivative by the force [m/N], for forces above 0 [N]."""
        load = force / self.length
        approach, slope = self.of_flanks(load)
        approach, slope = approach + self.free_edge * load, slope + self.free_edge
        at, section = self.sections(load)
        if at.size:
            scale = 4.0 / (np.pi * self.effective_modulus)
            approach[at] += scale * load[at] * section.approach
            slope[at] += scale * section.approach_rate
        return approach, slope / self.length


_PLACE = ("face", "height")
_OF_LOAD = ("force", "pressure_hertz", "at_edge")
OF_POSITION = ("radius_equivalent", "entrainment", "sliding_across", "sliding_along", "lay_pinion", "lay_gear")


@dataclass(frozen=True)
class TeethElasticity:
    """Elastic properties of the teeth of both members."""

    # compliance of one tooth of each member
    pinion: SolidTooth
    gear: SolidTooth
    # elastic constants
    material_pinion: Material
    material_gear: Material
    # radius at the tip, toe and heel edges of each member [m]
    edge_rounding_pinion: float = 2e-4
    edge_rounding_gear: float = 2e-4

    @property
    def effective_modulus(self) -> float:
        """E' [Pa]."""
        return effective_modulus(self.material_pinion, self.material_gear)

    def bending(self, cycle: Sequence[MeshPosition]) -> list[FloatArray]:
        """Deflection of both teeth along the normal at each point per unit force at each point [m/N], (n, n) each.

        A load on one tooth pair deflects the others through the body between the teeth.
        """
        # the loaded flank of the driving pinion faces the teeth ahead in mesh, that of the gear those behind
        of_pinion = self.pinion.influences([(p.face_pinion, p.height_pinion, p.pair) for p in cycle])
        of_gear = self.gear.influences([(p.face_gear, p.height_gear, -p.pair) for p in cycle])
        return [pinion + gear for pinion, gear in zip(of_pinion, of_gear, strict=True)]

    def local(self, cycle: Sequence[MeshPosition]) -> list[LocalApproach]:
        """Load-deflection law of the points of each position."""
        ends = np.cumsum([p.pair.size for p in cycle])[:-1]
        both = []
        for tooth, member in ((self.pinion, "pinion"), (self.gear, "gear")):
            places = (np.concatenate([getattr(p, f"{name}_{member}") for p in cycle]) for name in _PLACE)
            both.append(np.split(tooth.depth(*places), ends))
        materials, modulus, laws = (self.material_pinion, self.material_gear), self.effective_modulus, []
        for p, depths in zip(cycle, zip(*both, strict=True), strict=True):
            size, edge = p.pair.size, p.edge
            at_edge = np.zeros(size), np.full(size, np.inf), np.ones(size)
            if edge is not None:
                at_edge = self.free_edge(edge, depths), edge.distance, self.rounding(edge)
            laws.append(LocalApproach(p.length, p.radius_equivalent, depths, *at_edge, materials, modulus))
        return laws

    def rounding(self, edge: EdgeProximity) -> FloatArray:
        """Radius of the edge next to each point, in the section in which its contact is plane [m]."""
        own = np.where(_of_gear(edge), self.edge_rounding_gear, self.edge_rounding_pinion)
        return np.asarray(own / edge.crossing)

    def free_edge(self, edge: EdgeProximity, depths: Sequence[FloatArray]) -> FloatArray:
        """Additional local compliance of the tooth whose edge is nearest to each point, per load per length [m2/N].

        `depths`: distance from the flank to the middle of the pinion and gear tooth [m].
        """
        inside = np.maximum(edge.distance, 0.0) * np.sqrt(edge.crossing)
        members = (
            (self.edge_rounding_pinion, depths[0], self.material_pinion),
            (self.edge_rounding_gear, depths[1], self.material_gear),
        )
        of_pinion, of_gear = (
            free_edge_compliance(np.hypot(inside, radius), depth, material.youngs_modulus, material.poisson_ratio)
            for radius, depth, material in members
        )
        return np.where(_of_gear(edge), of_gear, of_pinion)


def _of_gear(edge: EdgeProximity) -> BoolArray:
    """Points whose nearest edge belongs to the gear."""
    return np.asarray(edge.index < len(EDGES) // 2)


@dataclass(frozen=True)
class ElasticPosition:
    """Load-independent data of one mesh position: geometry and compliance."""

    position: MeshPosition
    bending: FloatArray  # (n, n) compliance of the teeth [m/N]
    approach: LocalApproach  # load-deflection law of the points


@dataclass(frozen=True)
class PositionLoad:
    """Load at one mesh position; arrays with one entry per point of the `MeshPosition`."""

    position: MeshPosition  # geometry of the points
    force: FloatArray  # normal force of each point [N]
    load_per_length: FloatArray  # w' [N/m]
    pressure_hertz: FloatArray  # maximum Hertz pressure of the two flanks [Pa]; zero where unloaded
    pressure_max: FloatArray  # pressure including edges: maximum of the contact if it reaches a rounded edge [Pa]
    half_width: FloatArray  # half the width of the contact, including edges [m]
    at_edge: BoolArray  # points whose contact reaches an edge
    approach: float  # pinion rotation with fixed gear, from gaps and tooth deflection [rad]
    transmission_error: float  # loaded: unloaded error minus the lag of the gear [rad of the gear]
    equilibrium: Equilibrium  # residuals, iterations, status of the solver

    @cached_property
    def torque(self) -> float:
        """Torque carried by the normal forces [N m]."""
        return float(self.position.lever_pinion @ self.force)

    def forces_at(self, torque: float) -> FloatArray:
        """Linear estimate of the forces at another torque of the normal forces [N m]."""
        return np.maximum(self.force + (torque - self.torque) * self.equilibrium.rate, 0.0)

    @property
    def share(self) -> dict[int, float]:
        """Share of the torque carried by each tooth pair."""
        torque = self.force * self.position.lever_pinion
        pairs = self.position.pair
        return {int(pair): float(torque[pairs == pair].sum() / torque.sum()) for pair in np.unique(pairs)}


@dataclass(frozen=True)
class LoadDistribution:
    """Load over one mesh cycle."""

    torque: float  # [N m]
    positions: tuple[PositionLoad, ...]  # one entry per pinion angle
    status: Literal["converged", "failed"]
    reason: str  # reason of the first failure
    tooth_outline: FloatArray  # closed outline of the gear tooth, distance from the toe and above the root cone [m]

    @property
    def cycle(self) -> tuple[MeshPosition, ...]:
        """Points of each position."""
        return tuple(p.position for p in self.positions)

    @property
    def pressure_hertz_max(self) -> float:
        """Maximum Hertz pressure of the cycle [Pa]."""
        return max(float(p.pressure_hertz.max()) for p in self.positions)

    @property
    def pressure_edge_max(self) -> float:
        """Maximum pressure of elastic contacts at rounded edges [Pa]; 0 without any."""
        return max((float(p.pressure_max[p.at_edge].max(initial=0.0)) for p in self.positions), default=0.0)

    @property
    def torque_residual(self) -> float:
        """Largest relative error of the torque balance."""
        return max(p.equilibrium.torque_residual for p in self.positions)

    @property
    def compatibility_residual(self) -> float:
        """Largest violation of compatibility relative to the approach."""
        return max(p.equilibrium.residual for p in self.positions)

    @property
    def transmission_error(self) -> FloatArray:
        """Loaded transmission error of each position [rad of the gear]."""
        return np.array([p.transmission_error for p in self.positions])

    @property
    def stiffness_tangent(self) -> FloatArray:
        """Derivative of the pinion torque by the pinion rotation with fixed gear, at each position [N m/rad]."""
        return np.array([p.equilibrium.stiffness for p in self.positions])

    @property
    def contact_ratio(self) -> float:
        """Contact ratio under load: pitches of roll with a loaded tooth pair, including edges [-]."""
        return float(np.mean([len([share for share in p.share.values() if share > 0.0]) for p in self.positions]))

    @cached_property
    def loaded(self) -> dict[str, FloatArray]:
        """Fields of the loaded points of all positions, concatenated, by name."""
        where = [np.flatnonzero(p.force > 0.0) for p in self.positions]
        pairs = list(zip(self.positions, where, strict=True))
        return {
            name: np.concatenate([getattr(p if name in _OF_LOAD else p.position, name)[at] for p, at in pairs])
            for name in (*_OF_LOAD, *OF_POSITION)
        }

    @cached_property
    def loaded_position(self) -> IntArray:
        """Number of the position of each loaded point."""
        return np.repeat(np.arange(len(self.positions)), [np.count_nonzero(p.force > 0.0) for p in self.positions])

    @cached_property
    def loaded_index(self) -> IntArray:
        """Index of each loaded point in its position."""
        return np.concatenate([np.flatnonzero(p.force > 0.0) for p in self.positions])


def elastic_cycle(cycle: Sequence[MeshPosition], teeth: TeethElasticity) -> tuple[ElasticPosition, ...]:
    """Compliance of a mesh cycle, computed once for all torques."""
    return tuple(map(ElasticPosition, cycle, teeth.bending(cycle), teeth.local(cycle)))


def distribute_load(
    cycle: Sequence[ElasticPosition],
    teeth: TeethElasticity,
    torque: float,
    normal_torques: FloatArray | None = None,
    near: LoadDistribution | Sequence[FloatArray] | None = None,
) -> LoadDistribution:
    """Solve compatibility and equilibrium at each position of a mesh cycle over one pinion pitch.

    cycle: positions with their compliance from `elastic_cycle`.
    teeth: compliance of both members.
    torque: torque on the pinion in its driving direction [N m]; `InputError` unless it is finite and above 0.
    normal_torques (positions,): torque carried by the normal forces at each position, if friction carries the rest
        [N m].
    near: solution of the same cycle at similar torques, or forces at each position, used as starting value.
    Returns: load; failed convergence is reported by its status and does not raise an error.
    """
    require_torque(torque)
    torques = [torque] * len(cycle) if normal_torques is None else list(normal_torques)
    starts: list[FloatArray | None] = [None] * len(cycle)
    if isinstance(near, Sequence):
        starts = list(near)
    elif near is not None:
        starts = [p.forces_at(float(torque)) for p, torque in zip(near.positions, torques, strict=True)]
    problems = [
        EquilibriumProblem(e.bending, e.position.gap, e.position.lever_pinion, float(torque), start)
        for e, torque, start in zip(cycle, torques, starts, strict=True)
    ]
    law = LocalApproach.joined([e.approach for e in cycle])
    solutions = solve_equilibrium(problems, law)
    angles = np.array([solution.angle for solution in solutions])
    ratios = np.array([float(np.mean(e.position.lever_pinion / e.position.lever_gear)) for e in cycle])
    errors = np.array([e.position.transmission_error for e in cycle]) - angles * ratios
    force = np.concatenate([solution.force for solution in solutions])
    loads = loads_of_forces([e.position for e in cycle], law, force, angles, errors, solutions)
    failed = [load.equilibrium.reason for load in loads if load.equilibrium.status == "failed"]
    status: Literal["converged", "failed"] = "failed" if failed else "converged"
    return LoadDistribution(torque, loads, status, failed[0] if failed else "", teeth.gear.outline())


def require_torque(torque: float) -> None:
    """`InputError` unless the pinion torque [N m] is finite and above 0."""
    if not (np.isfinite(torque) and torque > 0.0):
        hint = "It acts on the pinion in its driving direction; choose the coast side for the other direction."
        raise InputError("torque", torque, "a finite torque above 0 N m", hint)


def edge_pressures(law: LocalApproach, force: FloatArray) -> FloatArray:
    """Maximum pressure of the contacts that reach an edge, at their points [Pa]."""
    load = force / law.length
    at, section = law.sections(load)
    flank = hertz_pressure(load[at], law.radius_equivalent[at], law.effective_modulus)
    return np.asarray(flank * section.pressure_max)


def loads_of_forces(
    cycle: Sequence[MeshPosition],
    law: LocalApproach,
    force: FloatArray,
    approach: FloatArray,
    transmission_error: FloatArray,
    equilibria: Sequence[Equilibrium],
) -> tuple[PositionLoad, ...]:
    """Load per length, pressure and width of the contacts from the normal forces.

    `law` and `force` [N] are concatenated over the positions. `approach` of the pinion [rad] and `transmission_error`
    [rad of the gear] have one value per position.
    """
    load = force / law.length
    hertz = hertz_pressure(load, law.radius_equivalent, law.effective_modulus)
    pressure, half_width = hertz.copy(), law.half_width(load)
    at, section = law.sections(load)
    at_edge = np.zeros(load.size, bool)
    at_edge[at] = True
    pressure[at] *= section.pressure_max
    half_width[at] *= section.half_length
    ends = np.cumsum([p.pair.size for p in cycle])[:-1]
    parts = (np.split(values, ends) for values in (force, load, hertz, pressure, half_width))
    flags, turns, errors = np.split(at_edge, ends), approach.tolist(), transmission_error.tolist()
    return tuple(map(PositionLoad, cycle, *parts, flags, turns, errors, equilibria))
