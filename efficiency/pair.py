"""A gear pair, its mesh, and the mesh under load: the objects of the public interface, which tie the rooms together.

pair (design)  ->  mesh (geometry, contact lines, elastic teeth)  ->  loaded mesh (forces)  ->  efficiency

Each stage is computed once and kept by the one before it: a second torque costs only its load, a second speed only its
friction.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, wraps
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, ParamSpec, TypedDict, TypeVar, Unpack, cast

import numpy as np

from efficiency.conditions.duty import DutyCycle, DutyRow, duty_cycle, read_duty
from efficiency.conditions.grid import AXES, Condition, Grid, refuse_composite, solve_grid, solve_points
from efficiency.conditions.loss_map import LossMap, signed_axes, solve_loss_map
from efficiency.contact.assembly import DisplacedAxes
from efficiency.contact.contact_lines import EDGE_REACH, CycleLines, MeshPosition, cycle_lines, mesh_cycle
from efficiency.contact.flank_pair import FlankPair, flank_pair
from efficiency.contact.gear_flanks import MEMBERS, Side
from efficiency.design.design import Design, MemberInput, Misalignment, load_design
from efficiency.loss.axle import AxleLosses, resolve_axle
from efficiency.loss.closed_form import PitchGeometry, profile_contact_ratio
from efficiency.loss.compare import Comparison, compare_models
from efficiency.loss.efficiency import solve_balanced
from efficiency.loss.efficiency_result import Bulk, EfficiencyResult, LoadBalance
from efficiency.loss.heat_balance import CoolingInput, HeatBalance, balance_heat, thermal_resistance
from efficiency.loss.kinematics import OPERATION_LIMITS, TEXTURE, Axis, Driver, Operation, loaded_points
from efficiency.ltca.external_load import read_load, write_load
from efficiency.ltca.limits import edge_load
from efficiency.ltca.load_distribution import TeethElasticity
from efficiency.ltca.mesh_grids import LoadedGrids, MeshGrids, load_grids
from efficiency.ltca.shaft_deflection import solve_deflection
from efficiency.ltca.solid_tooth import SolidTooth, elastic_teeth
from efficiency.output.gear_output import GearOutput
from efficiency.strength.rating import LocalConditions, rate_strength
from efficiency.strength.result import Strength
from efficiency.strength.root_stress import RootTooth, root_tooth
from efficiency.vehicle.axle_test import REVOLUTIONS_PER_MILE, AxleTest, axle_test_points, solve_axle_test
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.progress import ProgressCallback
from ehl.common.units import ValueRange
from ehl.common.validation import value_range_of
from ehl.fluid.oil import Oil
from regression.formula import friction_model, shipped_formulas
from regression.friction.models import FrictionModel

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from efficiency.geometry.misalignment import MisalignmentGrid
    from efficiency.geometry.pair_geometry import PairGeometry
    from ehl.surface.finish import State
    from regression.plan.operating_range import WeightedPoints

POSITIONS, POINTS_PER_LINE = 24, 31
CONSTANT = "constant:0.05"
# beside the formulas shipped for the oil in use
DEFAULT_MODELS = (
    CONSTANT,
    "xu_kahraman_2007",
    "benedict_kelley_1961",
    "schlenk_1994",
    "arana_2019",
    "ehl:smooth",
    "ehl",
)
# where the design does not say, as a share of the mean transverse module: deburred or tumbled teeth (our choice)
EDGE_ROUNDING = 0.05
# of the mesh that finds the deflection of the shafts before the full one does
_FEW_POSITIONS, _FEW_POINTS = 8, 15
_KEPT_MESHES, _MAX_STATES = 8, 10_000
_MISALIGNMENTS = tuple(Misalignment.model_fields)

Friction = FrictionModel | str
Value = float | str
Axle = AxleLosses | Path | str | Mapping[str, Value]
_P = ParamSpec("_P")
_R = TypeVar("_R")

_RMS = value_range_of(MemberInput, "roughness_rms")
_QUANTITIES: dict[str, ValueRange] = {
    "torque": OPERATION_LIMITS["torque"],
    "speed": OPERATION_LIMITS["speed"],
    "temperature": OPERATION_LIMITS["temperature"],
    **dict.fromkeys(("roughness_rms_each", "roughness_rms_pinion", "roughness_rms_gear"), _RMS),
    **TEXTURE,
    **{name: value_range_of(Misalignment, name) for name in _MISALIGNMENTS},
}


class Conditions(TypedDict, total=False):
    """What may differ from the operating point of the design: numbers in SI units, or text with a unit."""

    speed: Value
    temperature: Value
    oil: str | Oil
    driver: Driver
    roughness_rms_each: Value
    roughness_rms_pinion: Value
    roughness_rms_gear: Value
    correlation_length: Value
    peklenik_number: Value


def _one_thread(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Matrices are small: threads of the linear algebra would only wait for each other."""

    @wraps(function)
    def run(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        with _thread_controller().limit(limits=1):
            return function(*args, **kwargs)

    return run


@lru_cache(maxsize=1)
def _thread_controller() -> Any:
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def load(name: str | Path) -> GearPair:
    """A gear pair from a design file, or a shipped one by its name.

    Parameters
    ----------
    name : str or Path
        Design file (TOML) or name of a shipped design (`ehl.shipped`).

    Returns
    -------
    GearPair

    Raises
    ------
    InputError
        Naming field, value and allowed range.

    Examples
    --------
    >>> import efficiency
    >>> efficiency.load("fm_spiral_bevel_14x39")
    GearPair(fm_spiral_bevel_14x39: 14x39, offset 0 mm, 300 N m, 125.7 rad/s, 75w90 at 363.15 K)
    """
    return GearPair(load_design(name))


def default_friction(oil: str) -> str:
    """The formula shipped for an oil, else a published one that knows pressure, speeds, viscosity and roughness."""
    from regression.formula import shipped_formulas

    shipped = shipped_formulas(oil)
    return shipped[0] if shipped else "xu_kahraman_2007"


def resolve_friction(friction: Friction, design: Design) -> FrictionModel:
    """A friction model, a fitted formula, or the model of that name.

    Parameters
    ----------
    friction : FrictionModel or str
        Solved contacts (``ehl``, ``ehl:smooth``...) or any name of `regression.friction_model`.
    design : Design
        Gives the materials of both members.
    """
    if not isinstance(friction, str):
        return friction
    if friction.partition(":")[0] == "ehl":
        from efficiency.loss.ehl_friction import ehl_friction

        return ehl_friction(friction, (design.pinion.elastic_material(), design.gear.elastic_material()))
    return friction_model(friction)


class GearPair:
    """A gear pair: design, operating point, and every question asked of them.

    Parameters
    ----------
    design : Design, str or Path
        A design, the name of a shipped one, or a design file.

    Attributes
    ----------
    design : Design
        Content of the design file.

    Examples
    --------
    >>> import efficiency
    >>> pair = efficiency.load("fm_spiral_bevel_14x39")
    >>> pair.design.pinion.blank.teeth
    14
    """

    def __init__(self, design: Design | str | Path) -> None:
        self.design = design if isinstance(design, Design) else load_design(design)
        self._meshes = lru_cache(maxsize=_KEPT_MESHES)(self._mesh)
        # misalignments change neither the bodies nor their roots
        self._bodies = lru_cache(maxsize=2)(lambda side: elastic_bodies(self.design, side))
        self._roots: dict[Side, list[RootTooth | str]] = {"drive": [], "coast": []}

    def sharing_bodies(self, design: Design) -> GearPair:
        """The pair of another design, with elastic bodies and root sections of this one.

        For designs on the same blanks whose flanks differ by ease-off: micrometres change neither.

        Parameters
        ----------
        design : Design
            The other design.
        """
        other = GearPair(design)
        other._bodies, other._roots = self._bodies, self._roots
        return other

    @property
    def name(self) -> str:
        """Name of the design."""
        return self.design.name

    def mesh(
        self,
        side: Side = "drive",
        positions: int = POSITIONS,
        points_per_line: int = POINTS_PER_LINE,
        **misalignment: Value,
    ) -> Mesh:
        """Flanks in mesh: geometry, contact lines and elastic teeth, computed once.

        Parameters
        ----------
        side : {"drive", "coast"}
            Which flanks carry the load.
        positions, points_per_line : int
            Pinion angles in a pitch (even) and points on each contact line; results state the error.
        **misalignment : float or str
            `E`, `P`, `G` [m] and `shaft_angle_error` [rad] in place of those of the design.

        Returns
        -------
        Mesh

        Raises
        ------
        InputError
            An impossible number of positions or points, or a misalignment out of range.
        ConvergenceError
            The flanks do not exist or do not mesh.
        """
        if side not in ("drive", "coast"):
            raise InputError("side", side, "drive or coast")
        for name in misalignment:
            if name not in _MISALIGNMENTS:
                raise InputError("misalignment", name, "one of " + ", ".join(_MISALIGNMENTS))
        own = self.design.assembly.misalignment.model_dump()
        given = {name: _checked(name, value) for name, value in misalignment.items()}
        return self._meshes(side, positions, points_per_line, tuple((own | given).items()))

    def _mesh(self, side: Side, positions: int, points: int, misalignment: tuple[tuple[str, float], ...]) -> Mesh:
        design = self.design.with_misalignment(**dict(misalignment))
        return replace(Mesh.of(design, side, positions, points, self._bodies(side)), roots=self._roots[side])

    def check(self, frictions: Iterable[Friction] = (), **conditions: Any) -> list[FrictionModel]:
        """Refuse friction models and conditions that cannot be used, before anything is computed.

        Parameters
        ----------
        frictions : iterable of FrictionModel or str
            Friction models or their names.
        **conditions : float, str or sequence
            Values, or lists of values, of the axes of `over`.

        Returns
        -------
        list of FrictionModel
            The models.

        Raises
        ------
        InputError
            Naming what cannot be used.
        """
        for name, values in conditions.items():
            for value in axis_values(name, values):
                if name == "oil" and isinstance(value, str):
                    Oil.load(value)
                if name == "driver" and value not in ("pinion", "gear"):
                    raise InputError("driver", value, "pinion or gear")
        return [resolve_friction(friction, self.design) for friction in frictions]

    def misaligned(self, **misalignment: Value) -> GearPair:
        """The pair with `E`, `P`, `G` [m] and `shaft_angle_error` [rad] in place of those of the design."""
        own = self.design.assembly.misalignment.model_dump()
        given = {name: _checked(name, value) for name, value in misalignment.items()}
        return GearPair(self.design.with_misalignment(**(own | given)))

    def finished(self, finish: str, state: State = "run_in") -> GearPair:
        """The pair with both flanks of a finish of `ehl.shipped("finishes")`, "new" or "run_in", with its Rq."""
        return self.sharing_bodies(self.design.with_finish(finish, state))

    def at(
        self,
        friction: Friction = CONSTANT,
        grid: tuple[int, int] | None = None,
        *,
        many: bool = False,
        **condition: Any,
    ) -> EfficiencyResult:
        """Efficiency at one condition by the names of `efficiency.conditions.grid.AXES`; `design` is the pair itself.

        Parameters
        ----------
        friction : FrictionModel or str
            Friction model or its name.
        grid : (int, int), optional
            Mesh positions and points per contact line.
        many : bool
            One of many points: faster, with a larger stated error of the torque balance.
        **condition : float or str
            `side`, `torque`, misalignments, and as in `LoadedMesh.efficiency`, `load_balance` among them.
        """
        names = ("side", *_MISALIGNMENTS)
        placed = {name: condition.pop(name) for name in names if name in condition}
        # a wrong name is told before anything is computed
        friction = resolve_friction(friction, self.design)
        mesh = self.mesh(placed.pop("side", "drive"), *(grid or ()), **placed)
        loaded = mesh.load(condition.pop("torque", None))
        return loaded.at(friction, **condition) if many else loaded.efficiency(friction, **condition)

    def over(
        self,
        friction: Friction = CONSTANT,
        *,
        grid: tuple[int, int] | None = None,
        fixed: Mapping[str, Any] | None = None,
        progress: ProgressCallback | None = None,
        strength: bool = False,
        **axes: Any,
    ) -> Grid:
        """Efficiency at all combinations of any axes.

        Parameters
        ----------
        friction : FrictionModel or str
            Friction model or its name.
        grid : (int, int), optional
            Mesh positions and points per contact line.
        fixed : mapping, optional
            What has no axis and differs from the operating point of the design.
        progress : callable, optional
            Called with a `Progress` after each point.
        strength : bool
            Columns of strength: worst grade, safety factors, integral temperature, specific film (0.1 s a point).
        **axes : sequence
            `torque`, `speed`, `temperature`, `oil`, `driver`, `roughness_rms_each`, `roughness_rms_pinion`,
            `roughness_rms_gear`, `correlation_length`, `peklenik_number`, `E`, `P`, `G`, `shaft_angle_error`, `side`,
            `design`: numbers in SI units, texts with a unit, or one text with a list (``"100, 200 N m"``). ``design``
            takes pairs, designs, names or files.

        Returns
        -------
        Grid

        Raises
        ------
        InputError
            An unknown axis, an axis without values, a value out of range.
        """
        chosen = {name: axis_values(name, values) for name, values in axes.items()}
        if "design" in chosen:
            chosen["design"] = [p if isinstance(p, GearPair) else GearPair(p) for p in chosen["design"]]
        models: dict[str, FrictionModel] = {}

        def solve(condition: Condition) -> EfficiencyResult:
            here = dict(fixed or {}) | dict(condition)
            pair: GearPair = here.pop("design", self)
            if pair.name not in models:
                models[pair.name] = resolve_friction(friction, pair.design)
            return pair.at(models[pair.name], grid, many=True, **here)

        return solve_grid(chosen, solve, progress, GearOutput(self.design), strength)

    def duty(
        self,
        file: Path | str | Sequence[DutyRow],
        friction: Friction = CONSTANT,
        *,
        oil: str | None = None,
        grid: tuple[int, int] | None = None,
        progress: ProgressCallback | None = None,
        load_balance: LoadBalance | None = None,
    ) -> DutyCycle:
        """Efficiency at every operating point of a duty cycle, and the energies of all.

        Parameters
        ----------
        file : Path, str or sequence of DutyRow
            CSV or XLSX file with the columns torque, speed, temperature and hours, each with its unit.
        friction : FrictionModel or str
            Friction model or its name.
        oil : str, optional
            Oil card in place of the design's.
        grid : (int, int), optional
            Mesh positions and points per contact line.
        progress : callable, optional
            Called with a `Progress` after each row.
        load_balance : {"frictional", "frictionless"}, optional
            As in `LoadedMesh.efficiency`.
        """
        rows = read_duty(file) if isinstance(file, Path | str) else tuple(file)
        model, card = resolve_friction(friction, self.design), oil or self.design.operation.oil

        def solve(condition: Condition) -> EfficiencyResult:
            return self.at(model, grid, many=True, oil=card, load_balance=load_balance, **condition)

        points = solve_points([row.condition for row in rows], solve, progress)
        return duty_cycle(rows, points, self.name, model.name, card, GearOutput(self.design))

    def loss_map(
        self,
        torque: Any,
        speed: Any,
        friction: Friction = CONSTANT,
        *,
        temperature: Value | None = None,
        oil: str | None = None,
        axle: Axle | None = None,
        grid: tuple[int, int] | None = None,
        progress: ProgressCallback | None = None,
        load_balance: LoadBalance | None = None,
    ) -> LossMap:
        """Torque loss over pinion torque and speed, drive and coast, for `LossMap.to_vecto`.

        Parameters
        ----------
        torque : float, str or sequence
            Of the pinion: numbers in SI units, a list ``"a, b, c unit"`` or a range ``"from:to:number unit"``. Torques
            below zero are coast: the coast flanks carry them and the gear drives.
        speed : float, str or sequence
            Of the pinion, likewise.
        friction : FrictionModel or str
            Friction model or its name.
        temperature : float or str, optional
            Of the oil [K], in place of the design's.
        oil : str, optional
            Oil card in place of the design's.
        axle : mapping, Path, str or AxleLosses, optional
            Losses beside the mesh: ``{"drag": "2 N m", "load_share": 0.005}`` (constant torque and share of the pinion
            torque) or a table file with the columns torque, speed, torque_loss; none if not given.
        grid : (int, int), optional
            Mesh positions and points per contact line.
        progress : callable, optional
            Called with a `Progress` after each point.
        load_balance : {"frictional", "frictionless"}, optional
            As in `LoadedMesh.efficiency`.

        Raises
        ------
        InputError
            A value out of range.
        """
        torques, speeds = signed_axes(torque, speed)
        kelvin = self.design.operation.temperature if temperature is None else _checked("temperature", temperature)
        model, card = resolve_friction(friction, self.design), oil or self.design.operation.oil

        def solve(condition: Condition) -> EfficiencyResult:
            return self.at(model, grid, many=True, oil=card, load_balance=load_balance, **condition)

        about = {"design": self.name, "friction_model": model.name, "oil": card}
        return solve_loss_map(torques, speeds, kelvin, solve, resolve_axle(axle), progress, **about)

    def axle_test(
        self,
        application: Literal["single", "tandem"] = "single",
        friction: Friction = CONSTANT,
        *,
        torque_max: Value | None = None,
        revolutions_per_mile: float = REVOLUTIONS_PER_MILE,
        axle: Axle | None = None,
        **options: Any,
    ) -> AxleTest:
        """Power loss at the test points of 40 CFR 1037.560, for `AxleTest.to_csv`.

        Parameters
        ----------
        application : {"single", "tandem"}
            Output torques up to 4000 N m, or up to 2000 N m.
        friction : FrictionModel or str
            Friction model or its name.
        torque_max : float or str, optional
            Greatest output torque of the axle [N m]; test points above are left out.
        revolutions_per_mile : float
            Of the smallest tyre, 100 to 2000.
        axle : mapping, Path, str or AxleLosses, optional
            Losses beside the mesh, as of `loss_map`.
        **options
            `temperature`, `oil`, `grid`, `progress`, `load_balance` of `loss_map`.

        Raises
        ------
        InputError
            A value out of range.
        """
        ratio = self.design.gear.blank.teeth / self.design.pinion.blank.teeth
        most = (
            None
            if torque_max is None
            else OPERATION_LIMITS["torque"].check(torque_max, "torque_max", bare=not isinstance(torque_max, str))
        )
        points = axle_test_points(application, revolutions_per_mile, most)
        losses = resolve_axle(axle)
        found = self.loss_map(points.pinion_torques(ratio), points.pinion_speeds(ratio), friction, **options)
        return solve_axle_test(points, found, ratio, losses)

    def duty_points(
        self, duty: Path | str | Sequence[DutyRow], oil: str | None = None, grid: tuple[int, int] = (12, 21)
    ) -> list[WeightedPoints]:
        """Contact points at every operating point of a duty cycle, for the plan of a sweep.

        The weight of a point is force times sliding speed times duration: with friction that does not change along
        the flank it is the work lost there.

        Raises
        ------
        ConvergenceError
            The flanks do not exist or do not mesh, or the load does not settle.
        """
        from regression.plan.operating_range import WeightedPoints

        card = Oil.load(oil or self.design.operation.oil)
        found = []
        for row in read_duty(duty) if isinstance(duty, Path | str) else duty:
            mesh = self.mesh(row.side, *grid)
            load = mesh.load(abs(row.torque)).grids.fine
            if load.reason:
                raise ConvergenceError(load.reason, f"{self.name} at {row.torque:g} N m")
            operation = self.design.running(abs(row.speed), row.temperature)
            points = loaded_points(load, mesh.grids.teeth.effective_modulus, operation)
            weight = points.force * points.speed_sliding * (row.hours / len(mesh.grids.fine))
            found.append(WeightedPoints(points.state, np.asarray(weight), card))
        return found

    def compare(
        self,
        frictions: Iterable[Friction] | None = None,
        torque: Value | None = None,
        *,
        side: Side = "drive",
        grid: tuple[int, int] | None = None,
        load_balance: LoadBalance | None = None,
        **conditions: Unpack[Conditions],
    ) -> Comparison:
        """Several friction models and the closed forms at one operating point; see `LoadedMesh.compare`."""
        loaded = self.mesh(side, *(grid or ())).load(torque)
        return loaded.compare(frictions, load_balance=load_balance, **conditions)

    @_one_thread
    def geometry(self, side: str = "both", marking: Value | None = None) -> PairGeometry:
        """Flanks and unloaded contact: ease-off, contact pattern, transmission error.

        Parameters
        ----------
        side : {"drive", "coast", "both"}
            Which flanks.
        marking : float or str, optional
            Thickness of the marking compound [m], by default 6.35 um.
        """
        from efficiency.geometry.pair_geometry import chosen_sides, marking_thickness, pair_geometry

        found = pair_geometry(self.design, chosen_sides(side), marking_thickness(marking))
        return replace(found, output=GearOutput(self.design))

    @_one_thread
    def misalignment(
        self,
        *,
        side: str = "drive",
        marking: Value | None = None,
        torque: Value | None = None,
        friction: Friction | None = None,
        conditions: Mapping[str, Any] | None = None,
        progress: ProgressCallback | None = None,
        **axes: Any,
    ) -> MisalignmentGrid:
        """Contact over all combinations of misalignments added to those of the design (V-H check).

        Parameters
        ----------
        side : {"drive", "coast", "both"}
            Which flanks; one study for each.
        marking : float or str, optional
            Thickness of the marking compound [m], by default 6.35 um.
        torque : float or str, optional
            Pinion torque [N m]: every state with its load, pressure, edges and loss as well.
        friction : str or model, optional
            Of the loss; by default the formula shipped for the oil, without one a constant.
        conditions : mapping, optional
            `speed`, `temperature`, `oil` and what else differs from the operating point of the design.
        progress : callable, optional
            Called with a `Progress` after each state of a side.
        **axes : sequence
            Values of `E`, `P`, `G` [m] and `shaft_angle_error` [rad]; zero where not given.
        """
        from efficiency.geometry.misalignment import MisalignmentGrid, MisalignmentStudy, misalignment_study
        from efficiency.geometry.pair_geometry import chosen_sides, marking_thickness

        thickness = marking_thickness(marking)
        if not axes:
            raise InputError("E, P, G, shaft_angle_error", None, "at least one of them with its values")
        values: dict[str, Any] = {name: tuple(axis_values(name, given)) for name, given in axes.items()}
        states = math.prod(len(part) for part in values.values())
        if states > _MAX_STATES:
            raise InputError("E, P, G, shaft_angle_error", f"{states} states", f"at most {_MAX_STATES} combinations")
        given: dict[str, Any] = {} if friction is None else {"friction": friction}
        given |= conditions or {}
        if torque is None and given:
            name = next(iter(given))
            raise InputError(name, given[name], "no value without a torque", "Without a load nothing depends on it.")
        carried: float | None = None
        model: Friction = CONSTANT
        if torque is not None:
            carried = axis_values("torque", [torque])[0]
            oil = str((conditions or {}).get("oil", self.design.operation.oil))
            model = resolve_friction(default_friction(oil) if friction is None else friction, self.design)
            self.check([model], **{**(conditions or {}), "torque": carried})

        def study(part: Side) -> MisalignmentStudy:
            def load(placed: dict[str, float]) -> EfficiencyResult:
                moved: dict[str, Any] = dict(placed)
                return self.mesh(part, **moved).load(carried).efficiency(model, **(conditions or {}))

            return misalignment_study(
                self.design,
                side=part,
                marking=thickness,
                progress=progress,
                torque=carried,
                load=None if carried is None else load,
                **values,
            )

        studies = [study(part) for part in chosen_sides(side)]
        return MisalignmentGrid(tuple(studies), GearOutput(self.design))

    def plot_contact(self, side: Side = "drive", member: Literal["pinion", "gear"] = "gear") -> Figure:
        """Contact pattern without load on a flank, as a matplotlib figure."""
        from efficiency.output.plots_geometry import contact_pattern_figure

        found = self.geometry(side)
        if side in found.failures:
            raise ConvergenceError("no_contact", found.failures[side])
        shown = found.sides[side]
        return contact_pattern_figure(shown.pair, shown.pattern, shown.pair.path, member)

    @_one_thread
    def export(
        self,
        folder: Path | str,
        what: Iterable[str] = ("tooth", "member", "grid", "summary"),
        *,
        members: Iterable[Literal["pinion", "gear"]] = ("pinion", "gear"),
        rows: int = 15,
        columns: int = 31,
        margin: float = 0.0,
        rim: Value | None = None,
        bore: Value | None = None,
        units: Literal["metric", "inch"] = "metric",
    ) -> list[str]:
        """Write solids (STL), flank grids (CSV) and the machine summary (CSV).

        Parameters
        ----------
        folder : Path or str
            Where to.
        what : iterable of {"tooth", "member", "step", "grid", "ease_off", "summary"}
            Tooth space and whole member (STL), whole member (STEP, extra ``cad``), flank points, maps of the ease-off,
            machine summary.
        members : iterable of {"pinion", "gear"}
            Which members.
        rows, columns : int
            Points from root to tip and from heel to toe, 5 to 200.
        margin : float
            Share of face and depth that grids keep off the edges, 0 to 0.3.
        rim, bore : float or str, optional
            Solids: rim below the root [m]; diameter of the bore [m], 0 for none.
        units : {"metric", "inch"}
            Of the summary.

        Returns
        -------
        list of str
            What was written, a line each.

        Raises
        ------
        InputError
            A value out of range, a folder that cannot be written.
        """
        from efficiency.output.files import (
            export_ease_off,
            export_grids,
            export_member,
            export_step,
            export_summary,
            export_tooth_space,
        )

        chosen, into = list(what), Path(folder)
        for part in chosen:
            if part not in _EXPORTS:
                raise InputError("what", part, "some of " + ", ".join(_EXPORTS))
        for name, count in (("rows", rows), ("columns", columns)):
            if not 5 <= count <= 200:
                raise InputError(name, count, "from 5 to 200")
        if not 0.0 <= margin <= 0.3:
            raise InputError("margin", margin, "from 0 to 0.3")
        length = ValueRange("m", ge=0.0, le=3.0)
        thickness = None if rim is None else length.check(rim, "rim", bare=not isinstance(rim, str))
        hole = None if bore is None else length.check(bore, "bore", bare=not isinstance(bore, str))
        written: list[str] = []
        for member in members:
            if "tooth" in chosen:
                written.append(export_tooth_space(self.design, member, into, rows, columns, thickness))
            if "member" in chosen:
                written.append(export_member(self.design, member, into, rows, columns, thickness, hole))
            if "step" in chosen:
                written.append(export_step(self.design, member, into, rows, columns, thickness, hole))
            if "grid" in chosen:
                written += export_grids(self.design, member, into, rows, columns, margin)
        if "ease_off" in chosen:
            written += export_ease_off(self.design, into)
        if "summary" in chosen:
            written += export_summary(self.design, into, units)
        return written

    def __repr__(self) -> str:
        design, point = self.design, self.design.operation
        return (
            f"GearPair({design.name}: {design.pinion.blank.teeth}x{design.gear.blank.teeth}, offset "
            f"{1e3 * design.assembly.hypoid_offset:.4g} mm, {point.torque:.4g} N m, {point.speed:.4g} rad/s, "
            f"{point.oil} at {point.temperature:.5g} K)"
        )

    def _repr_html_(self) -> str:
        design, point = self.design, self.design.operation
        rows = {
            "teeth": f"{design.pinion.blank.teeth} / {design.gear.blank.teeth}",
            "hypoid offset": f"{1e3 * design.assembly.hypoid_offset:.4g} mm",
            "shaft angle": f"{math.degrees(design.assembly.shaft_angle):.4g} deg",
            "face width": " / ".join(f"{1e3 * m.blank.face_width:.4g} mm" for m in (design.pinion, design.gear)),
            "pinion torque, speed": f"{point.torque:.4g} N m, {point.speed * 30.0 / math.pi:.4g} rpm",
            "oil": f"{point.oil}, {point.temperature:.5g} K",
        }
        cells = "".join(f"<tr><th>{escape(k)}</th><td>{escape(v)}</td></tr>" for k, v in rows.items())
        return f"<table><caption>{escape(design.name)}</caption>{cells}</table>"


_EXPORTS = ("tooth", "member", "step", "grid", "ease_off", "summary")

ElasticTeeth = tuple[SolidTooth, SolidTooth]
"""Teeth of pinion and gear as elastic bodies."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """One flank pair of a gear pair in mesh: from `GearPair.mesh`.

    Parameters
    ----------
    design : Design
        The pair, misalignments included.
    side : {"drive", "coast"}
        Which flanks are in contact.
    flanks : FlankPair
        Geometry of the flanks.
    grids : MeshGrids
        Contact lines on two grids and compliance of the teeth.
    pitch : PitchGeometry
        Data for the closed forms.
    roots : list
        Of pinion and gear, filled when they are asked for (`root_teeth`); meshes of one pair share it.
    """

    design: Design
    side: Side
    flanks: FlankPair
    grids: MeshGrids
    pitch: PitchGeometry
    roots: list[RootTooth | str] = field(default_factory=list, repr=False)
    _loaded: dict[float, LoadedMesh] = field(default_factory=dict, init=False, repr=False)

    @classmethod
    @_one_thread
    def of(
        cls,
        design: Design,
        side: Side = "drive",
        positions: int = POSITIONS,
        points_per_line: int = POINTS_PER_LINE,
        bodies: ElasticTeeth | None = None,
    ) -> Mesh:
        """Geometry, contact lines and tooth compliance of a design.

        Parameters
        ----------
        design : Design
            The pair, misalignments included.
        side : {"drive", "coast"}
            Which flanks are in contact.
        positions, points_per_line : int
            Pinion angles in a pitch (even) and points on each contact line.
        bodies : ElasticTeeth, optional
            From `elastic_bodies`, where they are known: misalignments do not change them.
        """
        flanks = design.flanks()
        pair = flank_pair(flanks, side)
        pinion, gear = (flank.mean_angles() for flank in flanks.mating(side))
        known = elastic_bodies(design, side) if bodies is None else bodies
        teeth = TeethElasticity(
            *known,
            design.pinion.elastic_material(),
            design.gear.elastic_material(),
            edge_rounding_pinion=_edge_rounding(design.pinion, design),
            edge_rounding_gear=_edge_rounding(design.gear, design),
        )

        @lru_cache(maxsize=1)
        def lines(count: int) -> CycleLines:
            return cycle_lines(pair.surface, count)

        def make_cycle(count: int, points: int, reach: float | None = None, /) -> tuple[MeshPosition, ...]:
            return mesh_cycle(pair.surface, count, points, reach, edges=True, lines=lines(count))

        placement = design.placement()
        grids = MeshGrids.build(
            design.name,
            side,
            make_cycle,
            teeth,
            positions,
            points_per_line,
            (
                Axis(placement.pinion_axis[:, 0], placement.pinion_origin[:, 0]),
                Axis(np.array([0.0, 0.0, 1.0]), np.zeros(3)),
            ),
            pair.notes,
            math.nan if pair.surface.relief else pair.transmission.peak_to_peak,
            EDGE_REACH * 2.0 * math.pi / pair.teeth_gear,
        )
        stated, stiffness = design.assembly.deflection.moves, design.assembly.stiffness
        if stated or stiffness.given:

            @lru_cache(maxsize=4)
            def deflected(torque: float) -> MeshGrids:
                placed = design.under_torque(torque).without_deflection()

                def mesh_of(axes: DisplacedAxes, count: int = positions, points: int = points_per_line) -> MeshGrids:
                    return cls.of(placed.with_axes(axes), side, count, points, known).grids

                if not stiffness.given:
                    return cls.of(placed, side, positions, points_per_line, known).grids
                small = min(positions, _FEW_POSITIONS), min(points_per_line, _FEW_POINTS)
                few = () if small == (positions, points_per_line) else (lambda axes: mesh_of(axes, *small),)
                found = solve_deflection(placed.placement(), stiffness.compliances(), torque, (*few, mesh_of))
                if found.deflection is None:
                    return found
                return replace(found, deflection=replace(found.deflection, E=design.mirror * found.deflection.E))

            grids = replace(grids, under_torque=deflected)
        return cls(design, side, pair, grids, _pitch_geometry(design, pinion, gear))

    def load(self, torque: Value | None = None) -> LoadedMesh:
        """The mesh under a pinion torque: load distribution over the mesh cycle, computed once for each torque.

        Parameters
        ----------
        torque : float or str, optional
            At the pinion shaft [N m]; the design's if not given.

        Returns
        -------
        LoadedMesh

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
        chosen = self.design.operation.torque if torque is None else _checked("torque", torque)
        if chosen not in self._loaded:
            self._loaded[chosen] = LoadedMesh(self, chosen, _load(self.grids, chosen))
        return self._loaded[chosen]

    @_one_thread
    def root_teeth(self) -> tuple[RootTooth | str, RootTooth | str]:
        """Root sections of pinion and gear, computed once; a text says why there is none."""
        if not self.roots:
            flanks, module = self.design.flanks(), self.pitch.module_normal
            solids = self.grids.teeth.pinion, self.grids.teeth.gear
            for member, solid in zip(MEMBERS, solids, strict=True):
                try:
                    self.roots.append(root_tooth(flanks, member, solid, module))
                except (ConvergenceError, InputError) as error:
                    self.roots.append(str(error))
        pinion, gear = self.roots
        return pinion, gear

    def load_from(self, path: Path | str, torque: Value | None = None) -> LoadedMesh:
        """Load distribution of another program (CSV, `efficiency.ltca.external_load`) in place of the own one.

        Parameters
        ----------
        path : Path or str
            CSV file.
        torque : float or str, optional
            Has to be that of the file [N m].
        """
        given = None if torque is None else _checked("torque", torque)
        grids = read_load(Path(path), self.flanks, self.grids.teeth, given)
        return LoadedMesh(self, grids.fine.torque, grids, Path(path))

    def over(
        self,
        friction: Friction = CONSTANT,
        *,
        fixed: Mapping[str, Any] | None = None,
        progress: ProgressCallback | None = None,
        strength: bool = False,
        **axes: Any,
    ) -> Grid:
        """Efficiency at all combinations of axes that do not change the geometry; see `GearPair.over`.

        Parameters
        ----------
        friction : FrictionModel or str
            Friction model or its name.
        fixed : mapping, optional
            What has no axis and differs from the operating point of the design.
        progress : callable, optional
            Called with a `Progress` after each point.
        strength : bool
            Columns of strength: worst grade, safety factors, integral temperature, specific film (0.1 s a point).
        **axes : sequence
            Values of `torque`, `speed`, `temperature`, `oil`, `driver`, roughness.

        Returns
        -------
        Grid
        """
        for name in axes:
            if name in AXES[: AXES.index("torque")]:
                raise InputError("axis", name, "an axis that does not change the geometry; GearPair.over takes all")
        model = resolve_friction(friction, self.design)

        def solve(condition: Condition) -> EfficiencyResult:
            here: dict[str, Any] = {**(fixed or {}), **condition}
            return self.load(here.pop("torque", None)).at(model, **here)

        chosen = {name: axis_values(name, values) for name, values in axes.items()}
        return solve_grid(chosen, solve, progress, GearOutput(self.design), strength)

    def map(
        self,
        friction: Friction = CONSTANT,
        torque: Any = None,
        speed: Any = None,
        temperature: Any = None,
        *,
        fixed: Mapping[str, Any] | None = None,
        progress: ProgressCallback | None = None,
        strength: bool = False,
    ) -> Grid:
        """Efficiency over torque, speed and temperature, in this order; what is not given is that of the design."""
        own = self.design.operation
        axes = {
            "torque": own.torque if torque is None else torque,
            "speed": own.speed if speed is None else speed,
            "temperature": own.temperature if temperature is None else temperature,
        }
        return self.over(friction, fixed=fixed, progress=progress, strength=strength, **axes)

    def __repr__(self) -> str:
        lines = f"{len(self.grids.fine)} positions, {self.grids.points_per_line} points per line"
        return f"Mesh({self.design.name}, {self.side}: {lines}, {len(self._loaded)} torques solved)"


@dataclass(frozen=True, eq=False)
class LoadedMesh:
    """A mesh under one pinion torque: from `Mesh.load`.

    Parameters
    ----------
    mesh : Mesh
        Without load.
    torque : float
        Of the pinion [N m].
    grids : LoadedGrids
        Load distribution on both grids.
    external_load : Path, optional
        File the load distribution was read from.

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

    def operation(self, **conditions: Unpack[Conditions]) -> tuple[Operation, Oil]:
        """How the pair runs, and its oil; what is not given is that of the design."""
        design = self.mesh.design
        point, given = design.operation, cast("dict[str, Any]", dict(conditions))
        oil: Any = given.pop("oil", None)
        driver: Any = given.pop("driver", None)
        known = set(_QUANTITIES) - {"torque", *_MISALIGNMENTS}
        for name in given:
            refuse_composite(name, given[name])
            if name not in known:
                raise InputError("condition", name, "one of " + ", ".join((*sorted(known), "oil", "driver")))
        values: dict[str, Any] = {name: _checked(name, v) for name, v in given.items() if v is not None}
        both = values.pop("roughness_rms_each", None)
        if both is not None:
            values = {"roughness_rms_pinion": both, "roughness_rms_gear": both} | values
        speed, temperature = values.pop("speed", point.speed), values.pop("temperature", point.temperature)
        operation = design.running(speed, temperature, driver or point.driver)
        return replace(operation, **values), oil if isinstance(oil, Oil) else Oil.load(oil or point.oil)

    def efficiency(
        self,
        friction: Friction = CONSTANT,
        *,
        load_balance: LoadBalance | None = None,
        bulk: Bulk | None = None,
        **conditions: Unpack[Conditions],
    ) -> EfficiencyResult:
        """Friction, power loss and efficiency at one operating point.

        Parameters
        ----------
        friction : FrictionModel or str
            Friction model or its name: formula file, ``constant:0.05``, a published formula, ``ehl``...
        load_balance : {"frictional", "frictionless"}, optional
            Whether friction helps to carry the torque (default), or the normal forces carry it alone, as in the paper.
            Forces of a file are taken as they are.
        bulk : {"balance", "oil"}, optional
            Bulk temperature of the teeth: by a heat balance, or that of the oil. By default the balance where the
            design states [cooling].
        **conditions : float or str
            What differs from the design: `speed` of the pinion [rad/s], oil `temperature` [K], `oil` (name of a card
            or `Oil`), `driver` ("pinion" or "gear"), `roughness_rms_each` (Rq of both flanks) or `roughness_rms_pinion`
            and `roughness_rms_gear` [m], `correlation_length` [m], `peklenik_number` [-].

        Returns
        -------
        EfficiencyResult

        Raises
        ------
        InputError
            A value that cannot be used.
        """
        operation, oil = self.operation(**conditions)
        model = resolve_friction(friction, self.mesh.design)
        if self.balances_heat(bulk):
            return self._balance(model, operation, oil, None, load_balance).result
        return self.solve(model, operation, oil, load_balance)

    def at(
        self, friction: Friction, *, load_balance: LoadBalance | None = None, **conditions: Unpack[Conditions]
    ) -> EfficiencyResult:
        """As `efficiency`, for one of many points: faster, with a larger stated error of the torque balance."""
        operation, oil = self.operation(**conditions)
        model = resolve_friction(friction, self.mesh.design)
        if self.balances_heat(None):
            return self._balance(model, operation, oil, None, load_balance, many=True).result
        return self.solve(model, operation, oil, load_balance, many=True)

    def balances_heat(self, bulk: Bulk | None) -> bool:
        """Whether the bulk temperature of the teeth comes from a heat balance: as asked for, else where it is stated.

        Raises
        ------
        InputError
            Neither "balance" nor "oil".
        """
        if bulk not in (None, "balance", "oil"):
            raise InputError("bulk", bulk, "balance or oil")
        return bulk == "balance" or (bulk is None and self.mesh.design.cooling.stated)

    def heat_balance(
        self,
        friction: Friction = CONSTANT,
        cooling: CoolingInput | None = None,
        *,
        load_balance: LoadBalance | None = None,
        **conditions: Unpack[Conditions],
    ) -> HeatBalance:
        """Bulk temperatures at which friction heat and cooling of the teeth agree; else as `efficiency`.

        Parameters
        ----------
        friction : FrictionModel or str
            Friction model or its name.
        cooling : CoolingInput, optional
            In place of the design's.
        load_balance : {"frictional", "frictionless"}, optional
            Whether friction helps to carry the torque (default), or the normal forces carry it alone, as in the paper.
            Forces of a file are taken as they are.
        **conditions : float or str
            As in `efficiency`.
        """
        operation, oil = self.operation(**conditions)
        model = resolve_friction(friction, self.mesh.design)
        return self._balance(model, operation, oil, cooling, load_balance)

    def compare(
        self,
        frictions: Iterable[Friction] | None = None,
        *,
        load_balance: LoadBalance | None = None,
        **conditions: Unpack[Conditions],
    ) -> Comparison:
        """Several friction models, a constant fitted to the best of them, and the closed forms.

        Parameters
        ----------
        frictions : iterable of FrictionModel or str, optional
            By default the formulas shipped for the oil and `DEFAULT_MODELS`.
        load_balance : {"frictional", "frictionless"}, optional
            As in `efficiency`.
        **conditions : float or str
            As in `efficiency`.

        Returns
        -------
        Comparison
        """
        operation, oil = self.operation(**conditions)
        chosen = (*shipped_formulas(oil.name), *DEFAULT_MODELS) if frictions is None else frictions
        models = [resolve_friction(friction, self.mesh.design) for friction in chosen]
        balance = self._balance_of(load_balance)
        return _compare(self.grids, models, oil, operation, self.mesh.pitch, GearOutput(self.mesh.design), balance)

    def strength(self, friction: Friction = CONSTANT, **conditions: Unpack[Conditions]) -> Strength:
        """Grades of pressure, root stress, safety factors, scuffing and micropitting.

        Parameters
        ----------
        friction : FrictionModel or str
            Friction model or its name, for temperatures and the load balance.
        **conditions : float or str
            As in `efficiency`.

        Returns
        -------
        Strength

        Examples
        --------
        >>> import efficiency
        >>> mesh = efficiency.load("fm_spiral_bevel_14x39").mesh(positions=4, points_per_line=9)
        >>> mesh.load("300 N m").strength().status
        'warning'
        """
        return self.efficiency(friction, **conditions).strength

    def strength_of(self, result: EfficiencyResult) -> Strength:
        """Strength of the teeth at the operating point of a result."""
        design, pitch = self.mesh.design, self.mesh.pitch
        pinion, gear = design.pinion.blank.teeth, design.gear.blank.teeth
        operation = result.operation
        local = LocalConditions(
            result.friction.mu,
            result.lubrication.film_central,
            result.lubrication.temperature_flash,
            operation.bulk,
            (operation.roughness_rms_pinion, operation.roughness_rms_gear),
            result.card.viscosity_kinematic_40,
            operation.speed * pinion / gear * pitch.radius_gear,
            pitch.module_normal,
        )
        teeth = self.grids.mesh.teeth
        edges = edge_load(result.load, teeth)
        return rate_strength(result.load, teeth, edges, self.mesh.root_teeth(), local, 2.0 * math.pi / pinion)

    def write_load(self, path: Path | str) -> None:
        """Write the load distribution as CSV, as `Mesh.load_from` reads it."""
        write_load(self.grids.fine, Path(path))

    @_one_thread
    def solve(
        self,
        model: FrictionModel,
        operation: Operation,
        oil: Oil,
        load_balance: LoadBalance | None = None,
        *,
        many: bool = False,
    ) -> EfficiencyResult:
        """As `efficiency`, of a model at an operation; `many` as in `efficiency.loss.efficiency.solve_balanced`."""
        result = solve_balanced(self.grids, model, oil, operation, self._balance_of(load_balance), many=many)
        return replace(result, source=self, output=GearOutput(self.mesh.design))

    def _balance_of(self, load_balance: LoadBalance | None) -> LoadBalance:
        if load_balance not in (None, "frictional", "frictionless"):
            raise InputError("load_balance", load_balance, "frictional or frictionless")
        if self.external_load is None:
            return load_balance or "frictional"
        if load_balance == "frictional":
            raise InputError("load_balance", load_balance, "frictionless: forces of a file are taken as they are")
        return "frictionless"

    def balance(self, result: EfficiencyResult, cooling: CoolingInput | None) -> HeatBalance:
        """Bulk temperatures of the teeth at the operating point of a result."""
        return self._balance(result.model, result.operation, result.card, cooling, result.load_balance)

    def _balance(
        self,
        model: FrictionModel,
        operation: Operation,
        oil: Oil,
        cooling: CoolingInput | None,
        load_balance: LoadBalance | None,
        *,
        many: bool = False,
    ) -> HeatBalance:
        design, pitch = self.mesh.design, self.mesh.pitch
        chosen = design.cooling if cooling is None else cooling
        lubricant, ratio = oil.at(operation.temperature), design.pinion.blank.teeth / design.gear.blank.teeth
        speed = operation.speed
        resistances = (
            thermal_resistance(design.pinion.blank, chosen.pinion, lubricant, speed, pitch.spiral_angle_pinion),
            thermal_resistance(design.gear.blank, chosen.gear, lubricant, speed * ratio, pitch.spiral_angle_gear),
        )
        return balance_heat(
            lambda operation: self.solve(model, operation, oil, load_balance, many=many),
            operation,
            resistances,
            (design.pinion.elastic_material(), design.gear.elastic_material()),
            warm_inlet=chosen.oil_inlet == "bulk",
        )

    def __repr__(self) -> str:
        load = self.grids.fine
        pressure = f"{load.pressure_max / 1e9:.4g} GPa" if not load.reason else f"failed, {load.reason}"
        return f"LoadedMesh({self.mesh.design.name}, {self.mesh.side}, {self.torque:.6g} N m: {pressure})"


_load, _compare = _one_thread(load_grids), _one_thread(compare_models)


def elastic_bodies(design: Design, side: Side) -> ElasticTeeth:
    """Teeth of pinion and gear as elastic bodies."""
    return elastic_teeth(design.flanks(), design.tooth_bodies(), side)


def axis_values(name: str, values: Any) -> list[Any]:
    """Values of an axis in SI units.

    Parameters
    ----------
    name : str
        One of `efficiency.conditions.grid.AXES`.
    values : float, str or sequence
        Numbers in SI units, texts with a unit, a list ``"a, b, c unit"`` or a range ``"from:to:number unit"``.

    Raises
    ------
    InputError
        None of these, or a value out of range.
    """
    refuse_composite(name, values)
    if name not in _QUANTITIES:
        return [values] if isinstance(values, str) else list(values)
    if not isinstance(values, str):
        return [_checked(name, value) for value in ([values] if isinstance(values, float | int) else values)]
    return list(_QUANTITIES[name].check_list(values, name))


def _checked(name: str, value: Value) -> float:
    """A value in SI units; a text has to say its unit."""
    return _QUANTITIES[name].check(value, name, bare=not isinstance(value, str))


def _edge_rounding(member: MemberInput, design: Design) -> float:
    """Radius of the tip, toe and heel edges of a member [m]."""
    if member.edge_rounding is not None:
        return member.edge_rounding
    gear = design.gear.blank
    module = 2.0 * gear.mean_cone_distance * math.sin(gear.pitch_angle) / gear.teeth
    return EDGE_ROUNDING * module


def _pitch_geometry(
    design: Design, angles_pinion: tuple[float, float], angles_gear: tuple[float, float]
) -> PitchGeometry:
    pinion, gear = design.pinion.blank, design.gear.blank
    pressure = 0.5 * (angles_pinion[1] + angles_gear[1])
    spiral = 0.5 * (angles_pinion[0] + angles_gear[0])
    radius_pinion, radius_gear = (b.mean_cone_distance * math.sin(b.pitch_angle) for b in (pinion, gear))
    return PitchGeometry(
        pressure_angle=pressure,
        spiral_angle_pinion=angles_pinion[0],
        spiral_angle_gear=angles_gear[0],
        pitch_angle_pinion=pinion.pitch_angle,
        pitch_angle_gear=gear.pitch_angle,
        radius_pinion=radius_pinion,
        radius_gear=radius_gear,
        module_normal=2.0 * radius_gear * math.cos(angles_gear[0]) / gear.teeth,
        contact_ratio_profile=profile_contact_ratio(pinion, gear, spiral, pressure),
    )
