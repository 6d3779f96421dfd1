"""Mesh on two grids and its load at a torque, with contact lines of adequate length for that load.

Light loads touch a small part of each line, heavy loads push edges further into the mating flank. The grid is adapted:
where few points are loaded, the lines are limited to the range that the load can close. Where the approach exceeds the
largest gap of the edge search, edges are searched further.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from efficiency.contact.assembly import Axis
from efficiency.contact.contact_lines import MAX_POINTS_PER_LINE, MAX_POSITIONS, MeshPosition
from efficiency.ltca import load_distribution
from efficiency.ltca.limits import EdgeLoad, edge_load, limit_notes
from efficiency.ltca.load_distribution import ElasticPosition, LoadDistribution, TeethElasticity
from efficiency.ltca.tangent_load import TangentLoad, TangentLoads
from ehl.common.arrays import FloatArray, IntArray
from ehl.common.errors import InputError, check_count

# tuned: share of loaded points on the most loaded line below which the lines are shortened (this work); may be changed
# after running `test_error_estimate_covers_a_finer_grid`
_MIN_LOADED_SHARE = 0.4
# tuned: length of lines and edges over the approach of the load (this work); may be raised freely
_MARGIN = 1.2

MakeCycle = Callable[[int, int, float | None], tuple[MeshPosition, ...]]
"""Mesh cycle from the numbers of positions and points per contact line, and the reach, as `mesh_cycle`."""


@dataclass(frozen=True)
class MeshGrids:
    """Geometry of the mesh on two grids, and the compliance of the teeth."""

    # names of the design and of the flank pair
    design: str
    side: str
    # the same positions with all and with about half of the points per contact line
    fine: tuple[MeshPosition, ...]
    coarse: tuple[MeshPosition, ...]
    teeth: TeethElasticity  # compliance of both members
    points_per_line: int  # points per line of the fine grid
    axes: tuple[Axis, Axis] | None = None  # axes of pinion and gear, for the lever arms of the friction forces
    notes: tuple[str, ...] = ()  # notes on the geometry
    # unloaded peak-to-peak transmission error of all pairs together [rad]; nan if it follows from the positions
    transmission_error: float = math.nan
    # function that makes lines for another reach; None: fixed lines
    make_cycle: MakeCycle | None = field(default=None, repr=False, compare=False)
    reach: float = math.inf  # gear rotation up to which edges are followed [rad]
    deflection: ShaftDeflection | None = None  # deflection of shafts and bearings, if solved with the contact
    # mesh with shafts and bearings deflected by a pinion torque [N m]; None: rigid shafts and bearings
    under_torque: Callable[[float], MeshGrids] | None = field(default=None, repr=False, compare=False)
    # function that stores lines for another reach on disk, by the exponent of the reach; None: they are not stored
    kept: Callable[[int, Callable[[], Any]], Any] | None = field(default=None, repr=False, compare=False)
    _refitted: dict[int, MeshGrids] = field(default_factory=dict, init=False, repr=False, compare=False)

    @property
    def unloaded_error(self) -> float:
        """Unloaded peak-to-peak transmission error [rad]."""
        if math.isnan(self.transmission_error):
            return float(np.ptp([p.transmission_error for p in self.fine]))
        return self.transmission_error

    @cached_property
    def elastic_fine(self) -> tuple[ElasticPosition, ...]:
        """The fine grid with its compliance."""
        return load_distribution.elastic_cycle(self.fine, self.teeth)

    @cached_property
    def elastic_coarse(self) -> tuple[ElasticPosition, ...]:
        """The coarse grid with its compliance."""
        return load_distribution.elastic_cycle(self.coarse, self.teeth)

    @cached_property
    def friction_arms(self) -> tuple[list[FloatArray], list[FloatArray]]:
        """Lever arms of the unit friction force about the pinion axis at the points of both grids [m]."""
        if self.axes is None:
            raise InputError("mesh.axes", None, "the axes of both members, for the lever arms of the friction forces")
        fine, coarse = ([friction_arm(p, self.axes[0]) for p in cycle] for cycle in (self.fine, self.coarse))
        return fine, coarse

    @cached_property
    def _from_coarse(self) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
        """Indices of both neighbours of each fine point among all coarse points, and their weights.

        Linear interpolation of the load per length along each contact line; zero on lines without coarse points.
        """
        left, right, share, known = [], [], [], []
        start = 0
        for fine, coarse in zip(self.fine, self.coarse, strict=True):
            here = {int(coarse.line_number[line[0]]): line for line in coarse.lines}
            for line in fine.lines:
                own = here.get(int(fine.line_number[line[0]]), np.zeros(1, np.int64))
                chord = coarse.position[own[-1]] - coarse.position[own[0]]
                places, targets = coarse.position[own] @ chord, fine.position[line] @ chord
                above = np.clip(np.searchsorted(places, targets), 1, max(own.size - 1, 1)) % own.size
                below = np.maximum(above - 1, 0)
                width = places[above] - places[below]
                part = np.divide(targets - places[below], width, out=np.zeros(line.size), where=width > 0.0)
                left.append(start + own[below])
                right.append(start + own[above])
                share.append(np.clip(part, 0.0, 1.0))
                known.append(np.full(line.size, float(int(fine.line_number[line[0]]) in here)))
            start += coarse.pair.size
        low, high, part = np.concatenate(left), np.concatenate(right), np.concatenate(share)
        return low, high, part, np.concatenate(known) * np.concatenate([p.length for p in self.fine])

    def on_fine(self, load: LoadDistribution) -> list[FloatArray]:
        """Estimate of the forces at the points of each position of the fine grid from a load on the coarse grid [N]."""
        low, high, part, length = self._from_coarse
        per_length = np.concatenate([p.load_per_length for p in load.positions])
        force = length * ((1.0 - part) * per_length[low] + part * per_length[high])
        return np.split(force, np.cumsum([p.pair.size for p in self.fine])[:-1])

    def fitted(self, load: LoadDistribution) -> MeshGrids:
        """The mesh with lines and edges of adequate length for a load solved on one of the grids."""
        if self.make_cycle is None:
            return self
        closed = max(
            float(np.max(p.approach * p.position.lever_pinion / p.position.lever_gear)) for p in load.positions
        )
        shares = []  # of the loaded points on the most loaded line
        for p in load.positions:
            line = p.position.lines[int(np.argmax([p.force[at].sum() for at in p.position.lines]))]
            shares.append(np.count_nonzero(p.force[line]) / line.size)
        if _MARGIN * closed <= self.reach and np.mean(shares) >= _MIN_LOADED_SHARE:
            return self
        # in powers of two, so that similar torques share their lines
        step = math.ceil(math.log2(_MARGIN * closed))
        if step not in self._refitted:
            make_cycle, reach, points = self.make_cycle, 2.0**step, self.points_per_line

            def make() -> list[tuple[ElasticPosition, ...]]:
                cycles = (make_cycle(len(self.fine), count, reach) for count in (points, (points + 1) // 2))
                return [load_distribution.elastic_cycle(cycle, self.teeth) for cycle in cycles]

            found = make() if self.kept is None else self.kept(step, make)
            fine, coarse = (tuple(elastic.position for elastic in cycle) for cycle in found)
            refitted = replace(self, fine=fine, coarse=coarse, make_cycle=None, reach=reach)
            refitted.__dict__.update(elastic_fine=found[0], elastic_coarse=found[1])
            self._refitted[step] = refitted
        return self._refitted[step]


def both_cycles(
    make_cycle: MakeCycle, positions: int, points_per_line: int
) -> tuple[tuple[MeshPosition, ...], tuple[MeshPosition, ...]]:
    """Fine and coarse grid of a mesh cycle; the error estimate requires an even number of positions."""
    check_count("positions", positions, 4, MAX_POSITIONS, even=True)
    check_count("points_per_line", points_per_line, 5, MAX_POINTS_PER_LINE)
    return make_cycle(positions, points_per_line, None), make_cycle(positions, (points_per_line + 1) // 2, None)


def friction_arm(position: MeshPosition, axis: Axis) -> FloatArray:
    """Lever arm about an axis of the unit friction force that the pinion exerts on the gear [m], (n,).

    The sign is that of the levers of the normal force: positive if friction on the pinion increases the required
    torque, and if friction on the gear increases the delivered torque. A driving gear reverses the friction.
    """
    arm = position.position - axis.origin

    def turning(direction: FloatArray) -> FloatArray:
        return np.asarray(np.cross(arm, direction) @ axis.direction)

    return turning(position.sliding_direction) * np.sign(turning(position.normal))


@dataclass(frozen=True)
class ShaftDeflection:
    """Additional misalignment due to the deflection of shafts, bearings and housing."""

    # as in the misalignment of a design: E, P, G [m], shaft_angle_error [rad]
    E: float
    P: float
    G: float
    shaft_angle_error: float
    rounds: int  # solutions of the loaded contact
    change: float  # change of E, P, G by one more solution [m]


@dataclass(frozen=True)
class FrictionBalance:
    """Contribution of friction to the torque."""

    way: float  # 1 if friction on the pinion adds to the torque by its lever arm, -1 if the gear drives
    rounds: int  # corrections of the forces


@dataclass(frozen=True)
class _FromCoarse:
    """Starting values of the fine grid; a class, so that meshes can be sent to other processes."""

    mesh: MeshGrids
    coarse: TangentLoads

    def __call__(self, step: int) -> Sequence[FloatArray]:
        return self.mesh.on_fine(self.coarse.node(step))


class LoadedGrids:
    """A mesh under one torque: the load on both of its grids.

    mesh: loaded mesh, with deflection and with lines of adequate length for the load.
    fine: load on the fine grid; None: solved without friction on first access.
    coarse: load on the coarse grid.
    balance: None if the normal forces alone carry the torque.
    thermal: load for the bulk temperature of the teeth; default: the coarse one.
    """

    def __init__(
        self,
        mesh: MeshGrids,
        fine: LoadDistribution | None,
        coarse: LoadDistribution,
        balance: FrictionBalance | None = None,
        thermal: LoadDistribution | None = None,
    ) -> None:
        self.mesh, self.coarse, self.balance = mesh, coarse, balance
        self.thermal = coarse if thermal is None else thermal
        self._fine, self._tangents = fine, dict[float, tuple[TangentLoads, TangentLoads]]()

    @cached_property
    def fine(self) -> LoadDistribution:
        """Load on the fine grid."""
        if self._fine is not None:
            return self._fine
        start = self.mesh.on_fine(self.coarse)
        return load_distribution.distribute_load(
            self.mesh.elastic_fine, self.mesh.teeth, self.coarse.torque, near=start
        )

    def tangents(self, way: float) -> tuple[TangentLoads, TangentLoads]:
        """Loads of fine and coarse grid with friction as a part of the torque; `way` is -1 if the gear drives."""
        if way not in self._tangents:
            mesh, torque, (arms, arms_coarse) = self.mesh, self.coarse.torque, self.mesh.friction_arms
            loads = zip(self.coarse.positions, arms_coarse, strict=True)
            ratio = np.array([float(p.force @ arm) / p.torque for p, arm in loads])
            coarse = TangentLoads(mesh.elastic_coarse, mesh.teeth, torque, arms_coarse, ratio, way, self.coarse)
            start = _FromCoarse(mesh, coarse)
            fine = TangentLoads(mesh.elastic_fine, mesh.teeth, torque, arms, ratio, way, start)
            self._tangents[way] = fine, coarse
        return self._tangents[way]

    @cached_property
    def edges(self) -> EdgeLoad:
        """Load and pressure at the edges."""
        fine = self.fine
        return fine.loads.edges(fine) if isinstance(fine, TangentLoad) else edge_load(fine, self.mesh.teeth)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Notes on geometry and load."""
        return self.mesh.notes + limit_notes(self.fine, self.mesh.teeth, self.mesh.unloaded_error, self.edges)


def load_grids(mesh: MeshGrids, torque: float) -> LoadedGrids:
    """Load over the cycle for a pinion torque [N m]; `InputError` unless it is above 0.

    The mesh of the result is deflected and has lines of adequate length for the load.
    """
    load_distribution.require_torque(torque)
    if mesh.under_torque is not None:
        mesh = mesh.under_torque(torque)
    coarse = load_distribution.distribute_load(mesh.elastic_coarse, mesh.teeth, torque)
    fitted = mesh.fitted(coarse)
    if fitted is not mesh:
        coarse = load_distribution.distribute_load(fitted.elastic_coarse, mesh.teeth, torque)
    return LoadedGrids(fitted, None, coarse)
