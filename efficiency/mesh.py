"""One flank pair in mesh, without and with load: geometry, contact lines, elastic teeth, forces, efficiency.

Each stage is computed once: another torque requires only its load, another speed only its friction.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, Unpack

import numpy as np

from efficiency.conditions.conditions import (
    AXES,
    GEOMETRY_AXES,
    Conditions,
    ConditionValues,
    Friction,
    HeldValues,
    MeshAxes,
    Value,
    Values,
    axis_values,
    checked,
    resolve_friction,
    split_axes,
)
from efficiency.conditions.grid import Condition, Evaluator, Grid
from efficiency.contact.contact_lines import EDGE_REACH, CycleLines, MeshPosition, cycle_lines, mesh_cycle
from efficiency.contact.flank_pair import FlankPair, flank_pair
from efficiency.contact.gear_flanks import MEMBERS, Side
from efficiency.design.design import Design, MemberInput, PairDesign, kept_of_design
from efficiency.loss.closed_form import PitchGeometry
from efficiency.loss.efficiency import balanced_efficiency, solve_friction
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.kinematics import Operation, loaded_points
from efficiency.loss.lubrication import LUBRICATION_FACTORS, warming
from efficiency.ltca.external_load import read_load, write_load
from efficiency.ltca.limits import edge_load
from efficiency.ltca.load_distribution import ElasticPosition, TeethElasticity, elastic_cycle
from efficiency.ltca.mesh_grids import LoadedGrids, MeshGrids, both_cycles, load_grids
from efficiency.ltca.shaft_deflection import solve_deflection
from efficiency.ltca.shaft_forces import MeshForces, mesh_forces
from efficiency.ltca.solid_tooth import SolidTooth, elastic_teeth
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.progress import ProgressCallback
from ehl.common.table import Table
from ehl.common.threads import one_thread
from regression.formula import shipped_formulas
from regression.friction.models import COLEMAN_FRICTION, FrictionModel, Request, Run

if TYPE_CHECKING:
    from efficiency.loss.compare import Comparison
    from efficiency.strength.result import Strength
    from efficiency.strength.root_stress import RootTooth

POSITIONS, POINTS_PER_LINE = 24, 31
# default edge radius as a fraction of the mean transverse module: deburred or tumbled teeth (this work)
EDGE_ROUNDING = 0.05
# size of the coarse mesh for the first solution of the shaft deflection
_FEW_POSITIONS, _FEW_POINTS = 8, 15
# for many operating points: every n-th contact point is used for the bulk temperature (this work)
_EVERY = 4
_KEPT_TORQUES = 4  # maximum number of stored meshes with deflected shafts

T = TypeVar("T")
ElasticTeeth = tuple[SolidTooth, SolidTooth]
"""Teeth of pinion and gear as elastic bodies."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """One flank pair of a gear pair in mesh: from `GearPair.mesh`.

    Parameters
    ----------
    design : PairDesign
        The pair with its misalignments.
    side : {"drive", "coast"}
        Flanks in contact.
    flanks : FlankPair, optional
        Geometry of the flanks; None for a cylindrical pair with its involute flanks.
    grids : MeshGrids
        Contact lines on two grids and compliance of the teeth.
    pitch : PitchGeometry
        Data for the closed forms.
    roots : list
        Roots of pinion and gear, computed by `root_teeth` and shared by all meshes of a pair.
    keep : bool
        Whether geometry, bodies and roots are stored on disk (`efficiency.design.design`).
    """

    design: PairDesign
    side: Side
    flanks: FlankPair | None
    grids: MeshGrids
    pitch: PitchGeometry
    roots: list[RootTooth | str] = field(default_factory=list, repr=False)
    keep: bool = False
    _loaded: dict[float, LoadedMesh] = field(default_factory=dict, init=False, repr=False)

    @classmethod
    @one_thread
    def of(
        cls,
        design: Design,
        side: Side = "drive",
        positions: int = POSITIONS,
        points_per_line: int = POINTS_PER_LINE,
        bodies: ElasticTeeth | None = None,
        keep: bool = False,
    ) -> Mesh:
        """Geometry, contact lines and tooth compliance of a design with its misalignments; see `GearPair.mesh`.

        Parameters
        ----------
        bodies : ElasticTeeth, optional
            Bodies from an earlier call of `elastic_bodies`; misalignments do not change them.
        keep : bool
            Store geometry, bodies and roots on disk, and read stored ones.
        """
        flanks = design.flanks()
        pinion, gear = (flank.mean_angles() for flank in flanks.mating(side))
        known = elastic_bodies(design, side, keep) if bodies is None else bodies
        teeth = TeethElasticity(
            *known,
            design.pinion.elastic_material(),
            design.gear.elastic_material(),
            edge_rounding_pinion=_edge_rounding(design.pinion, design),
            edge_rounding_gear=_edge_rounding(design.gear, design),
        )

        def geometry() -> tuple[FlankPair, tuple[ElasticPosition, ...], tuple[ElasticPosition, ...]]:
            found = flank_pair(flanks, side)
            fine, coarse = both_cycles(_CycleMaker(found), positions, points_per_line)
            return found, elastic_cycle(fine, teeth), elastic_cycle(coarse, teeth)

        kept = partial(_kept_mesh, design, (side, positions, points_per_line))
        pair, fine, coarse = kept(None, geometry) if keep else geometry()
        grids = MeshGrids(
            design.name,
            side,
            tuple(at.position for at in fine),
            tuple(at.position for at in coarse),
            teeth,
            points_per_line,
            design.placement().axes,
            pair.notes,
            math.nan if pair.surface.relief else pair.transmission.peak_to_peak,
            _CycleMaker(pair),
            EDGE_REACH * 2.0 * math.pi / design.gear.blank.teeth,
            kept=kept if keep else None,
        )
        grids.__dict__.update(elastic_fine=fine, elastic_coarse=coarse)
        stated, stiffness = design.assembly.deflection.moves, design.assembly.stiffness
        if stated or stiffness.given:
            grids = replace(grids, under_torque=_UnderTorque(design, side, positions, points_per_line, known))
        pitch = PitchGeometry.of(design.pinion.blank, design.gear.blank, pinion, gear)
        return cls(design, side, pair, grids, pitch, keep=keep)

    @property
    def bevel(self) -> Design:
        """The design of a bevel or hypoid pair; `InputError` for a cylindrical one."""
        if isinstance(self.design, Design):
            return self.design
        raise InputError("design", self.design.name, "a bevel or hypoid pair", "The design is of a cylindrical pair.")

    @one_thread
    def load(self, torque: Value | None = None) -> LoadedMesh:
        """The mesh under a pinion torque: load distribution over the mesh cycle, computed once for each torque.

        Parameters
        ----------
        torque : float or str, optional
            Torque at the pinion shaft [N m]; default: that of the design.

        Raises
        ------
        InputError
            A torque out of range.

        Examples
        --------
        >>> import efficiency
        >>> mesh = efficiency.load("fm_spiral_bevel_14x39").mesh(positions=4, points_per_line=9)
        >>> mesh.load("200 N m").efficiency("constant:0.05").status
        'converged'
        """
        chosen = self.design.operation.torque if torque is None else checked("torque", torque)
        if chosen not in self._loaded:
            self._loaded[chosen] = LoadedMesh(self, chosen, load_grids(self.grids, chosen))
        return self._loaded[chosen]

    @one_thread
    def root_teeth(self) -> tuple[RootTooth | str, RootTooth | str]:
        """Root sections of pinion and gear, computed once; a text states why a root has none."""
        if not self.roots:
            found = kept_of_design("roots", self.bevel, (self.side,), self._roots) if self.keep else self._roots()
            self.roots.extend(found)
        pinion, gear = self.roots
        return pinion, gear

    def _roots(self) -> list[RootTooth | str]:
        from efficiency.strength.root_stress import root_tooth

        flanks, module, teeth = self.bevel.flanks(), self.pitch.module_normal, self.grids.teeth
        found: list[RootTooth | str] = []
        for member, solid in zip(MEMBERS, (teeth.pinion, teeth.gear), strict=True):
            try:
                found.append(root_tooth(flanks, member, solid, module))
            except (ConvergenceError, InputError) as error:
                found.append(str(error))
        return found

    @one_thread
    def load_from(self, path: Path | str, torque: Value | None = None) -> LoadedMesh:
        """Load distribution of another program (CSV, `efficiency.ltca.external_load`) instead of the computed one.

        A `torque` [N m] must be that of the file.
        """
        given = None if torque is None else checked("torque", torque)
        if self.flanks is None:
            raise InputError("load_from", str(path), "no load distribution for a cylindrical pair")
        grids = read_load(Path(path), self.flanks, self.grids.teeth, given)
        return LoadedMesh(self, grids.fine.torque, grids, Path(path))

    @one_thread
    def over(
        self,
        friction: Friction | None = None,
        *,
        progress: ProgressCallback | None = None,
        strength: bool = False,
        interval: bool = False,
        every_point: bool = True,
        **conditions: Unpack[MeshAxes],
    ) -> Grid:
        """Efficiency at all combinations of conditions that do not change the geometry; see `GearPair.over`.

        Parameters
        ----------
        every_point : bool
            Solve every point, or interpolate as in `map`.
        """
        axes, held = split_axes(conditions, AXES[len(GEOMETRY_AXES) :])
        model = resolve_friction(friction, self.design, conditions.get("oil"))

        def at(conditions: Sequence[Condition]) -> list[EfficiencyResult]:
            every: list[dict[str, Any]] = [{**held, **condition} for condition in conditions]
            [loaded, *_] = [self.load(here.pop("torque", None)) for here in every]
            return loaded.efficiencies(model, every)

        return Evaluator(at, progress, strength, interval).grid(axes, every_point=every_point)

    @one_thread
    def map(
        self,
        friction: Friction | None = None,
        torque: Values | None = None,
        speed: Values | None = None,
        temperature: Values | None = None,
        *,
        progress: ProgressCallback | None = None,
        strength: bool = False,
        interval: bool = False,
        every_point: bool = False,
        **conditions: Unpack[HeldValues],
    ) -> Grid:
        """Map over torque, speed and temperature, in this order (default: those of the design); see `GearPair.over`.

        An axis with ten or more values is interpolated between seven of them (`efficiency.conditions.grid`).
        Interpolated points have figures with their error, but no `EfficiencyResult`. With `strength` or `every_point`
        all are solved.
        """
        own = self.design.operation
        given = {"torque": torque, "speed": speed, "temperature": temperature}
        axes: dict[str, Any] = {
            name: axis_values(name, getattr(own, name) if values is None else values) for name, values in given.items()
        }
        options: dict[str, Any] = {"progress": progress, "strength": strength, "interval": interval}
        return self.over(friction, every_point=every_point, **options, **axes, **conditions)

    def __repr__(self) -> str:
        lines = f"{len(self.grids.fine)} positions, {self.grids.points_per_line} points per line"
        return f"Mesh({self.design.name}, {self.side}: {lines}, {len(self._loaded)} torques solved)"

    def _repr_html_(self) -> str:
        record = {
            "side": self.side, "positions": len(self.grids.fine), "points_per_line": self.grids.points_per_line,
            "transmission_error_unloaded": self.grids.unloaded_error,
        }  # fmt: skip
        return Table.from_records([record], title=self.design.name, vertical=True).html()


@dataclass(frozen=True, eq=False)
class LoadedMesh:
    """A mesh under one pinion torque: from `Mesh.load`.

    Parameters
    ----------
    mesh : Mesh
        The unloaded mesh.
    torque : float
        Pinion torque [N m].
    grids : LoadedGrids
        Load distribution on both grids.
    external_load : Path, optional
        File from which the load distribution was read.

    Examples
    --------
    >>> import efficiency
    >>> mesh = efficiency.load("fm_spiral_bevel_14x39").mesh(positions=4, points_per_line=9)
    >>> mesh.load("300 N m").torque
    300.0
    """

    mesh: Mesh
    torque: float
    grids: LoadedGrids
    external_load: Path | None = None

    @property
    def design(self) -> PairDesign:
        """The design of the pair with its misalignments."""
        return self.mesh.design

    @property
    def has_strength(self) -> bool:
        """Whether the strength of the teeth can be rated: for bevel and hypoid pairs."""
        return isinstance(self.mesh.design, Design)

    @one_thread
    def efficiency(
        self, friction: Friction | None = None, *, many: bool = False, **conditions: Unpack[ConditionValues]
    ) -> EfficiencyResult:
        """Friction, power loss and efficiency under one operating condition.

        Parameters
        ----------
        friction : FrictionModel or str, optional
            Friction model or its name: formula file, ``constant:0.05``, a published formula, ``ehl``...; default: the
            formula of the oil.
        many : bool
            For one of many points: faster, with a larger stated error of the torque balance.
        **conditions : float or str
            Values that differ from the design, by names of `efficiency.conditions.conditions.Conditions`: pinion
            `speed` [rad/s], oil `temperature` [K], `oil`, `driver`, `roughness_rms_each` (Rq of both flanks) or
            `roughness_rms_pinion` and `roughness_rms_gear` [m], `correlation_length` [m], `peklenik_number` [-],
            `load_balance`, `bulk`.

        Raises
        ------
        InputError
            An invalid value.
        """
        return self.efficiencies(friction, [conditions], many=many)[0]

    @one_thread
    def efficiencies(
        self, friction: Friction | None, conditions: Sequence[Mapping[str, Any]], *, many: bool = True
    ) -> list[EfficiencyResult]:
        """Efficiency at several conditions with the same oil, keywords of `efficiency`; friction is evaluated together.

        Examples
        --------
        >>> import efficiency
        >>> loaded = efficiency.load("fm_spiral_bevel_14x39").mesh(positions=4, points_per_line=9).load("300 N m")
        >>> [r.status for r in loaded.efficiencies("constant:0.05", [{"speed": 100.0}, {"speed": 200.0}])]
        ['converged', 'converged']
        """
        model = resolve_friction(friction, self.design, conditions[0].get("oil"))
        places = [self._conditions(here) for here in conditions]
        clock = time.perf_counter()

        def run(at: Conditions) -> Run[EfficiencyResult]:
            operation = at.operation if at.bulk == "oil" else (yield from self._warm(model, at, many=many))
            return (yield from balanced_efficiency(self.grids, model, at.oil, operation, at.load_balance, many=many))

        found = solve_friction([run(at) for at in places], model, places[0].oil)
        seconds = (time.perf_counter() - clock) / len(found)
        return [replace(result, seconds=seconds, case=replace(result.case, mesh=self)) for result in found]

    @one_thread
    def compare(self, frictions: Iterable[Friction] | None = None, **conditions: Unpack[ConditionValues]) -> Comparison:
        """Several friction models, a constant fitted to the reference model, and the closed forms.

        Parameters
        ----------
        frictions : FrictionModel or str, or iterable of them, optional
            Default: the formulas shipped for the oil, `constant:0.05`, four published ones, solved contacts.
        """
        from efficiency.loss.compare import DEFAULT_MODELS, compare_models

        at = self._conditions(conditions)
        names = [frictions] if isinstance(frictions, (str, FrictionModel)) else list(frictions or ())
        defaults = (*shipped_formulas(at.oil.name), *DEFAULT_MODELS)
        resolved = (resolve_friction(friction, self.design) for friction in names or defaults)
        models = list({model.name: model for model in resolved}.values())  # each once
        # the same bulk temperature for all models
        operation = at.operation
        if at.bulk != "oil":
            [operation] = solve_friction([self._warm(models[0], at)], models[0], at.oil)
        return compare_models(self.grids, models, at.oil, operation, self.mesh.pitch, at.load_balance)

    @one_thread
    def forces(self, result: EfficiencyResult | None = None) -> MeshForces:
        """Mesh stiffness [N m/rad] and forces [N] on both shafts at the positions of a pinion pitch.

        Parameters
        ----------
        result : EfficiencyResult, optional
            Result whose forces are taken, with friction if it is in the torque balance; default: normal forces alone.

        Raises
        ------
        ConvergenceError
            No load distribution.

        Examples
        --------
        >>> import efficiency
        >>> loaded = efficiency.load("fm_spiral_bevel_14x39").mesh(positions=4, points_per_line=9).load("300 N m")
        >>> f"{loaded.forces().pinion.torque.mean():.4g} N m"
        '300 N m'
        """
        grids, mu = self.grids, None
        load = grids.fine if result is None else result.load
        if load.reason:
            raise ConvergenceError(load.reason, f"no forces at {self.torque:g} N m")
        if result is not None and result.conditions.load_balance == "frictional":
            mu = result.friction.mu if result.conditions.driver == "pinion" else -result.friction.mu
        return mesh_forces(load, grids.mesh, mu)

    @one_thread
    def strength_of(self, result: EfficiencyResult) -> Strength:
        """Strength of the teeth at the operating point of a result."""
        from efficiency.strength.rating import LocalConditions, rate_strength, scuffing_temperature

        design, pitch = self.mesh.bevel, self.mesh.pitch
        operation = result.case.operation
        card = result.case.card
        # the drive side of ISO 23509 is the concave flank of the pinion
        concave = (design.assembly.drive_flank_pinion == "concave") == (self.mesh.side == "drive")
        local = LocalConditions(
            result.friction.mu,
            result.lubrication.film_central,
            result.lubrication.temperature_flash,
            operation.bulk,
            (operation.roughness_rms_pinion, operation.roughness_rms_gear),
            card.viscosity_kinematic_40,
            operation.speed * design.ratio * pitch.radius[1],
            pitch.module_normal,
            pitch.hypoid_factor(concave=concave),
            math.nan
            if card.fzg_stage is None
            else scuffing_temperature(card.fzg_stage, card.viscosity_kinematic_40, card.base),
            math.nan if card.film_permissible is None else card.film_permissible,
        )
        teeth, pitch_angle = self.grids.mesh.teeth, 2.0 * math.pi / design.pinion.blank.teeth
        edges = edge_load(result.load, teeth)
        return rate_strength(result.load, teeth, edges, self.mesh.root_teeth(), local, pitch_angle)

    def write_load(self, path: Path | str, result: EfficiencyResult | None = None) -> None:
        """Write the load distribution as CSV in the format of `Mesh.load_from`.

        Parameters
        ----------
        path : Path or str
            Output file.
        result : EfficiencyResult, optional
            Result whose forces are written. They include friction in the torque balance, so that the file reproduces
            the loss. Default: the normal forces alone.
        """
        if result is None or result.conditions.load_balance == "frictionless":
            return write_load(self.grids.fine, self.grids.thermal, Path(path))
        friction = f"{result.friction_model}, {result.conditions.driver} driving"
        points, positions = result.points, []
        for number, position in enumerate(result.load.positions):
            here = points.position == number
            pressure = np.array(position.pressure_hertz)
            pressure[points.index[here]] = points.state.pressure_hertz[here]
            positions.append(replace(position, pressure_hertz=pressure))
        load = replace(self.grids.fine, positions=tuple(positions))
        return write_load(load, self.grids.thermal, Path(path), friction)

    def _conditions(self, given: Mapping[str, Any]) -> Conditions:
        """Conditions of the mesh; the forces of a file are not changed by friction."""
        at = Conditions.of(self.design, given)
        if self.external_load is None:
            return at
        if given.get("load_balance") == "frictional":
            allowed = "frictionless, because the forces of a file are not changed"
            raise InputError("load_balance", "frictional", allowed)
        return replace(at, load_balance="frictionless")

    def _warm(self, model: FrictionModel, at: Conditions, *, many: bool = False) -> Run[Operation]:
        """The operation with bulk temperatures from the loss of the normal forces.

        For many operating points friction is computed at a quarter of the contact points; this changes the rise by less
        than 1 %.
        """
        operation = at.operation
        load, modulus = self.grids.thermal, self.grids.mesh.teeth.effective_modulus
        smooth: dict[str, Any] = dict.fromkeys(("roughness_rms_pinion", "roughness_rms_gear"), 0.0)
        rough = not getattr(model, "smooth", False)
        points = loaded_points(load, modulus, operation if rough else replace(operation, **smooth))
        some = slice(None, None, _EVERY if many else 1)
        sliding = points.force * points.speed_sliding
        power = sliding[some] * (sliding.sum() / max(sliding[some].sum(), 1e-300) / len(load.positions))
        state = points.state.at(some)
        pitch, design = self.mesh.pitch, self.design
        size = sum(pitch.radius), design.common_face_width
        run = warming(operation, size, LUBRICATION_FACTORS[design.cooling.lubrication])
        trial = next(run)
        while True:
            oil_in, bulk_1, bulk_2 = (np.full_like(power, value) for value in (trial.inlet, *trial.bulk))
            warm = replace(state, temperature_oil=oil_in, temperature_bulk_1=bulk_1, temperature_bulk_2=bulk_2)
            mu = (yield Request(warm))[1].mu
            try:
                trial = run.send(float(np.sum(np.where(np.isfinite(mu), mu, COLEMAN_FRICTION) * power)))
            except StopIteration as end:
                found: Operation = end.value
                return found

    def __repr__(self) -> str:
        load = self.grids.fine
        pressure = f"{load.pressure_hertz_max / 1e9:.4g} GPa" if not load.reason else f"failed, {load.reason}"
        return f"LoadedMesh({self.mesh.design.name}, {self.mesh.side}, {self.torque:.6g} N m: {pressure})"

    def _repr_html_(self) -> str:
        load = self.grids.fine
        record: dict[str, Any] = {"side": self.mesh.side, "torque": self.torque, "status": load.reason or "converged"}
        if not load.reason:
            record |= {
                "pressure_hertz_max": load.pressure_hertz_max, "contact_ratio": load.contact_ratio,
                "transmission_error_loaded": float(np.ptp(load.transmission_error)),
                "edge_load_share": self.grids.edges.share,
            }  # fmt: skip
        return Table.from_records([record], title=self.mesh.design.name, vertical=True).html()


@dataclass(eq=False)
class _CycleMaker:
    """Mesh cycles of a flank pair; the contact lines of all positions are traced once."""

    pair: FlankPair
    _lines: tuple[int, CycleLines] | None = field(default=None, repr=False)

    def __call__(self, count: int, points: int, reach: float | None = None, /) -> tuple[MeshPosition, ...]:
        if self._lines is None or self._lines[0] != count:
            self._lines = count, cycle_lines(self.pair.surface, count)
        return mesh_cycle(self.pair.surface, count, points, reach, edges=True, lines=self._lines[1])


def _kept_mesh(design: Design, size: tuple[object, ...], what: object, make: Callable[[], T]) -> T:
    """Results of a mesh of one size on disk."""
    return kept_of_design("mesh", design, size if what is None else (*size, what), make)


@dataclass(eq=False)
class _UnderTorque:
    """The mesh of a design with deflected shafts and bearings as a function of the pinion torque."""

    design: Design
    side: Side
    positions: int
    points: int
    bodies: ElasticTeeth
    _found: dict[float, MeshGrids] = field(default_factory=dict, repr=False)

    def __call__(self, torque: float) -> MeshGrids:
        if torque not in self._found:
            if len(self._found) == _KEPT_TORQUES:
                del self._found[next(iter(self._found))]
            self._found[torque] = self._deflected(torque)
        return self._found[torque]

    def _deflected(self, torque: float) -> MeshGrids:
        placed = self.design.under_torque(torque, self.side).without_deflection()
        stiffness = self.design.assembly.stiffness

        def mesh_of(design: Design, positions: int = self.positions, points: int = self.points) -> MeshGrids:
            return Mesh.of(design, self.side, positions, points, self.bodies).grids

        if not stiffness.given:
            return mesh_of(placed)
        small = min(self.positions, _FEW_POSITIONS), min(self.points, _FEW_POINTS)
        few = () if small == (self.positions, self.points) else (lambda axes: mesh_of(placed.with_axes(axes), *small),)
        whole = lambda axes: mesh_of(placed.with_axes(axes))  # noqa: E731
        found = solve_deflection(placed.placement(), stiffness.compliances(), torque, (*few, whole))
        if found.deflection is None:
            return found
        return replace(found, deflection=replace(found.deflection, E=self.design.mirror * found.deflection.E))


def elastic_bodies(design: Design, side: Side, keep: bool = False) -> ElasticTeeth:
    """Teeth of pinion and gear as elastic bodies; with `keep` they are stored on disk."""

    def make() -> ElasticTeeth:
        return elastic_teeth(design.flanks(), design.tooth_bodies(), side)

    return kept_of_design("bodies", design, (side,), make) if keep else make()


def _edge_rounding(member: MemberInput, design: Design) -> float:
    """Radius of the tip, toe and heel edges of a member [m]."""
    if member.edge_rounding is not None:
        return member.edge_rounding
    gear = design.gear.blank
    module = 2.0 * gear.mean_cone_distance * math.sin(gear.pitch_angle) / gear.teeth
    return EDGE_ROUNDING * module
