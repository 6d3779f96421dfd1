"""A gear pair: the central object of the public interface.

pair (design)  ->  mesh (geometry, contact lines, elastic teeth)  ->  loaded mesh (forces)  ->  efficiency
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self, Unpack

import numpy as np

from efficiency.conditions.conditions import (
    ConditionValues,
    Friction,
    HeldValues,
    PairAxes,
    PairConditionValues,
    Value,
    Values,
    axis_values,
    checked,
    resolve_friction,
    split_axes,
)
from efficiency.conditions.grid import Condition, Evaluator, Grid
from efficiency.contact.gear_flanks import Side
from efficiency.design.design import MISALIGNMENTS, Design, load_design
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.kinematics import OPERATION_LIMITS, loaded_points
from efficiency.mesh import POINTS_PER_LINE, POSITIONS, Mesh, elastic_bodies
from ehl.common.errors import ConvergenceError, InputError, check_choice, check_count
from ehl.common.figures import interactive
from ehl.common.progress import ProgressCallback
from ehl.common.quantities import quantity
from ehl.common.table import Table
from ehl.common.threads import one_thread
from ehl.fluid.oil import Oil
from ehl.surface.finish import State
from regression.friction.models import FrictionModel

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from efficiency.conditions.duty import DutyCycle, DutyRow
    from efficiency.geometry.design_drawing import DesignDrawing
    from efficiency.geometry.design_rating import DesignRating
    from efficiency.geometry.misalignment import MisalignmentGrid, MisalignmentStudy
    from efficiency.geometry.pair_geometry import PairGeometry
    from efficiency.loss.compare import Comparison
    from efficiency.strength.root_stress import RootTooth
    from efficiency.vehicle.axle_test import AxleTest
    from efficiency.vehicle.loss_map import AxleLosses, LossMap
    from regression.plan.operating_range import WeightedPoints

    Axle = AxleLosses | Path | str | Mapping[str, Value]

_KEPT_MESHES, _MAX_STATES = 8, 10_000
# default standard deviation of E, P and G of random states [m]: half of the box of the load sizing
_SPREAD = 2.5e-5


class GearPair:
    """A gear pair: its design and operating point.

    Parameters
    ----------
    design : Design, str or Path
        A design, the name of a shipped one, or a design file.
    keep : bool
        Store elastic bodies, roots and geometry on disk for later processes, as pairs from `load` do.

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

    def __init__(self, design: Design | str | Path, *, keep: bool = False) -> None:
        self._keep = keep
        self.design = load_design(design) if isinstance(design, str | Path) else design
        self._meshes = lru_cache(maxsize=_KEPT_MESHES)(self._mesh)
        # misalignments change neither the elastic bodies nor their roots
        self._bodies = lru_cache(maxsize=2)(lambda side: elastic_bodies(self.design, side, keep))
        self._roots: dict[Side, list[RootTooth | str]] = {"drive": [], "coast": []}

    def __getstate__(self) -> dict[str, Any]:
        # results are computed again after unpickling, or read from disk
        return {"design": self.design, "keep": self._keep}

    def __setstate__(self, state: dict[str, Any]) -> None:
        type(self).__init__(self, **state)

    def sharing_bodies(self, design: Design) -> Self:
        """The pair of another design on the same blanks, with the elastic bodies and root sections of this pair.

        The flanks differ by the ease-off (micrometres), which does not change them noticeably.
        """
        other = type(self)(design)
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
            Loaded flanks.
        positions, points_per_line : int
            Pinion angles in a pitch (even) and points on each contact line; results state the numerical error.
        **misalignment : float or str
            `E`, `P`, `G` [m] and `shaft_angle_error` [rad] instead of those of the design.

        Raises
        ------
        InputError
            An invalid number of positions or points, or a misalignment out of range.
        ConvergenceError
            The flanks do not exist or do not mesh.
        """
        return self._meshes(
            checked("side", side), positions, points_per_line, tuple(self._placed(misalignment).items())
        )

    @one_thread
    def _mesh(self, side: Side, positions: int, points: int, misalignment: tuple[tuple[str, float], ...]) -> Mesh:
        design = self.design.with_misalignment(**dict(misalignment))
        mesh = Mesh.of(design, side, positions, points, self._bodies(side), self._keep)
        return replace(mesh, roots=self._roots[side])

    def _placed(self, given: Mapping[str, Value]) -> dict[str, float]:
        """Misalignments of the design, with the given ones instead of its own."""
        for name in given:
            check_choice("misalignment", name, MISALIGNMENTS)
        own = self.design.assembly.misalignment.model_dump()
        return own | {name: checked(name, value) for name, value in given.items()}

    def check(self, frictions: Iterable[Friction | None] = (), **conditions: Unpack[PairAxes]) -> list[FrictionModel]:
        """Validate friction models and conditions, as in `over`, before the computation; returns the friction models.

        Raises
        ------
        InputError
            An invalid friction model or condition.
        """
        split_axes(conditions)
        return [resolve_friction(friction, self.design, conditions.get("oil")) for friction in frictions]

    def misaligned(self, **misalignment: Value) -> Self:
        """The pair with `E`, `P`, `G` [m] and `shaft_angle_error` [rad] instead of those of the design."""
        if not misalignment:
            return self
        placed = self._placed(misalignment)
        return type(self)(self.design.with_misalignment(**placed), keep=self._keep)

    def finished(self, finish: str, state: State = "run_in") -> Self:
        """The pair with a finish of `ehl.shipped("finishes")` on both flanks, "new" or "run_in", with its Rq."""
        return self.sharing_bodies(self.design.with_finish(finish, state))

    @one_thread
    def at(
        self,
        friction: Friction | None = None,
        *,
        grid: tuple[int, int] | None = None,
        many: bool = False,
        **condition: Unpack[PairConditionValues],
    ) -> EfficiencyResult:
        """Efficiency at one condition; `friction` and `grid` as in `over`.

        Parameters
        ----------
        many : bool
            For one of many points: faster, with a larger stated error of the torque balance.
        **condition : float or str
            `side`, `torque`, misalignments, and the conditions of `LoadedMesh.efficiency`.
        """
        return self._at_each(friction, [condition], grid, many=many)[0]

    def _at_each(
        self, friction: Friction | None, conditions: Sequence[Mapping[str, Any]], grid: Any, *, many: bool = True
    ) -> list[EfficiencyResult]:
        """Efficiencies at conditions that have geometry, torque and oil in common."""
        apart = ("side", *MISALIGNMENTS, "torque")
        every = [{name: value for name, value in here.items() if name not in apart} for here in conditions]
        placed = {name: conditions[0][name] for name in apart[:-1] if name in conditions[0]}
        # an invalid name is rejected before the computation
        friction = resolve_friction(friction, self.design, conditions[0].get("oil"))
        mesh = self.mesh(placed.pop("side", "drive"), *(grid or ()), **placed)
        return mesh.load(conditions[0].get("torque")).efficiencies(friction, every, many=many)

    def _evaluator(
        self,
        friction: Friction | None,
        grid: tuple[int, int] | None,
        held: Mapping[str, Any],
        progress: ProgressCallback | None = None,
        strength: bool = False,
        interval: bool = False,
    ) -> tuple[Evaluator, dict[str, str]]:
        """Evaluator of many conditions, and names of design, friction model and oil."""
        held = split_axes(held)[1]
        model = resolve_friction(friction, self.design, held.get("oil"))
        oil = held.get("oil", self.design.operation.oil)

        def at(conditions: Sequence[Condition]) -> list[EfficiencyResult]:
            return self._at_each(model, [{**held, **condition} for condition in conditions], grid)

        about = {"design": self.name, "friction_model": model.name, "oil": getattr(oil, "name", oil)}
        return Evaluator(at, progress, strength, interval), about

    @one_thread
    def over(
        self,
        friction: Friction | None = None,
        *,
        grid: tuple[int, int] | None = None,
        progress: ProgressCallback | None = None,
        strength: bool = False,
        interval: bool = False,
        **conditions: Unpack[PairAxes],
    ) -> Grid:
        """Efficiency at all combinations of conditions.

        Parameters
        ----------
        friction : FrictionModel or str, optional
            Friction model or its name; default: the formula of the oil.
        grid : (int, int), optional
            Mesh positions and points per contact line.
        progress : callable, optional
            Called with a `Progress` after each point.
        strength : bool
            Add strength: most severe grade, safety factors, integral temperature, specific film (0.1 s per point).
        interval : bool
            Add the 90 % interval from uncertain inputs (0.05 s per point).
        **conditions : value or sequence
            `torque`, `speed`, `temperature`, `oil`, `driver`, `roughness_rms_each`, `roughness_rms_pinion`,
            `roughness_rms_gear`, `correlation_length`, `peklenik_number`, `E`, `P`, `G`, `shaft_angle_error`, `side`,
            `design`, and `load_balance` and `bulk` of `LoadedMesh.efficiency`. Numbers are in SI units, texts have a
            unit. Several values, as a sequence or as one text (``"100, 200 N m"``), are an axis of the grid; a single
            value applies to all points. ``design`` accepts pairs, designs, names or files.

        Raises
        ------
        InputError
            An unknown condition, an axis without values, a value out of range.
        """
        axes, held = split_axes(conditions)
        designs = axes.get("design", [held.pop("design", self)])
        pairs = [design if isinstance(design, GearPair) else GearPair(design) for design in designs]
        evaluators = {pair.name: pair._evaluator(friction, grid, held)[0] for pair in pairs}
        if "design" in axes:
            axes["design"] = pairs

        def at(conditions: Sequence[Condition]) -> Sequence[EfficiencyResult]:
            pair: GearPair = conditions[0].get("design", pairs[0])
            return evaluators[pair.name].at([{n: v for n, v in here.items() if n != "design"} for here in conditions])

        return Evaluator(at, progress, strength, interval).grid(axes)

    @one_thread
    def duty(
        self,
        file: Path | str | Sequence[DutyRow],
        friction: Friction | None = None,
        *,
        grid: tuple[int, int] | None = None,
        tyre_radius: Value | None = None,
        ratio: float | None = None,
        temperature: Value | None = None,
        progress: ProgressCallback | None = None,
        **conditions: Unpack[HeldValues],
    ) -> DutyCycle:
        """Efficiency at every operating point of a duty cycle, and the total energies; further options as in `over`.

        Parameters
        ----------
        file : Path, str or sequence of DutyRow
            CSV or XLSX file with the columns torque, speed, temperature and hours, each with its unit, or recorded
            vehicle data (`efficiency.conditions.duty.read_duty`).
        tyre_radius, ratio, temperature : float or str, optional
            As in `read_duty`; default: ratio of the pair, temperature of the design.
        **conditions : float or str
            Conditions of all points that differ from the design, as in `LoadedMesh.efficiency`.
        """
        from efficiency.conditions.duty import DutyCycle, duty_rows, row_energy

        rows = duty_rows(file, self.design, tyre_radius=tyre_radius, ratio=ratio, temperature=temperature)
        evaluator, about = self._evaluator(friction, grid, conditions, progress)
        points = tuple(evaluator.points([row.condition for row in rows]))
        return DutyCycle(**about, rows=tuple(map(row_energy, rows, points)), points=points)

    @one_thread
    def drawing(self) -> DesignDrawing | None:
        """Gear data for the drawings of both members, with `table()` and `to_dict()`; None for a cylindrical pair.

        Angles and thicknesses are those of the flanks in the middle of the face.

        Examples
        --------
        >>> efficiency.load("fm_spiral_bevel_14x39").drawing().table().rows[0]
        ('number of teeth', 'z', '', '14', '39')
        """
        from efficiency.geometry.design_drawing import design_drawing

        return design_drawing(self.design) if isinstance(self.design, Design) else None

    @one_thread
    def rating(
        self,
        torque: Value | None = None,
        speed: Value | None = None,
        duty: Path | str | Sequence[DutyRow] | None = None,
    ) -> DesignRating:
        """Load capacity after ISO 10300, Method B1: stresses, S_H and S_F of both members and both flanks.

        Nominal stresses of virtual gears with K factors (table `rating` of the design), independent of the loaded tooth
        contact that `EfficiencyResult.strength` uses.

        Parameters
        ----------
        torque, speed : float or str, optional
            At the pinion [N m], [rad/s]; default: operating point of the design.
        duty : Path, str or sequence of DutyRow, optional
            Duty cycle as load spectrum instead of `rating.loads`; each row loads the flank of the sign of its torque.

        Raises
        ------
        InputError
            A value out of range, a material without endurance limits, blades that leave no root.

        Examples
        --------
        >>> import efficiency
        >>> rated = efficiency.load("fh_hypoid_9x34").rating("250 N m")
        >>> [f"{factor:.2f}" for factor in rated.drive.safety_root]
        ['1.48', '1.32']
        """
        from efficiency.conditions.duty import duty_rows
        from efficiency.geometry.design_rating import rate_design

        at = {name: None if x is None else checked(name, x) for name, x in (("torque", torque), ("speed", speed))}
        return rate_design(self.design, **at, rows=() if duty is None else duty_rows(duty, self.design))

    @one_thread
    def loss_map(
        self,
        torque: Values,
        speed: Values,
        friction: Friction | None = None,
        *,
        temperature: Value | None = None,
        axle: Axle | None = None,
        grid: tuple[int, int] | None = None,
        progress: ProgressCallback | None = None,
        interval: bool = False,
        models: Iterable[Path | str] = (),
        **conditions: Unpack[HeldValues],
    ) -> LossMap:
        """Torque loss over pinion torque and speed, drive and coast, for `LossMap.write_model`; see also `over`.

        Parameters
        ----------
        torque, speed : float, str or sequence
            Of the pinion: numbers in SI units, a list ``"a, b, c unit"`` or a range ``"from:to:number unit"``. For
            negative torques the coast flanks are loaded and the gear drives.
        temperature : float or str, optional
            Oil temperature; default: that of the design.
        axle : mapping, Path, str or AxleLosses, optional
            Losses outside the mesh: ``{"drag": "2 N m", "load_share": 0.005}`` (constant torque and fraction of the
            pinion torque) or a table file with the columns torque, speed, torque_loss; default: none.
        interval : bool
            Columns of the 90 % interval by uncertain inputs (0.05 s a point).
        models : iterable of Path or str
            Files for `LossMap.write_model`: torques and speeds that a format does not accept are refused first.
        **conditions : float or str
            Conditions of all points that differ from the design, as in `LoadedMesh.efficiency`.

        Raises
        ------
        InputError
            A value out of range.
        """
        from efficiency.vehicle.loss_map import resolve_axle, signed_axes, solve_loss_map
        from efficiency.vehicle.map_files import check_axes

        torques, speeds = signed_axes(torque, speed)
        for path in models:
            check_axes(path, torques, speeds)
        kelvin = checked("temperature", self.design.operation.temperature if temperature is None else temperature)
        evaluator, about = self._evaluator(friction, grid, conditions, progress, interval=interval)
        return solve_loss_map(torques, speeds, kelvin, evaluator, resolve_axle(axle), **about)

    @one_thread
    def axle_test(
        self,
        application: Literal["single", "tandem"] = "single",
        friction: Friction | None = None,
        *,
        temperature: Value | None = None,
        torque_max: Value | None = None,
        revolutions_per_mile: float | None = None,
        axle: Axle | None = None,
        grid: tuple[int, int] | None = None,
        progress: ProgressCallback | None = None,
        **conditions: Unpack[HeldValues],
    ) -> AxleTest:
        """Power loss at the test points of 40 CFR 1037.560, for `AxleTest.to_csv`; further options as in `loss_map`.

        Parameters
        ----------
        application : {"single", "tandem"}
            Output torques up to 4000 N m, or up to 2000 N m.
        torque_max : float or str, optional
            Largest output torque of the axle [N m]; test points above it are omitted.
        revolutions_per_mile : float, optional
            Revolutions of the smallest tyre per mile, 100 to 2000; default: 650.

        Raises
        ------
        InputError
            A value out of range.
        """
        from efficiency.vehicle.axle_test import REVOLUTIONS_PER_MILE, axle_test_points, solve_axle_test
        from efficiency.vehicle.loss_map import resolve_axle

        ratio = 1.0 / self.design.ratio
        turns = REVOLUTIONS_PER_MILE if revolutions_per_mile is None else revolutions_per_mile
        most = None if torque_max is None else OPERATION_LIMITS["torque"].check_given(torque_max, "torque_max")
        points, losses = axle_test_points(application, turns, most), resolve_axle(axle)
        speeds: Any = np.array(points.speed_wheel) * ratio
        at: dict[str, Any] = {"temperature": temperature, "grid": grid, "progress": progress, **conditions}
        found = self.loss_map(points.pinion_torques(ratio), speeds, friction, **at)
        return solve_axle_test(points, found, ratio, losses)

    @one_thread
    def duty_points(
        self, duty: Path | str | Sequence[DutyRow], oil: str | None = None, grid: tuple[int, int] = (12, 21)
    ) -> list[WeightedPoints]:
        """Contact points at every operating point of a duty cycle, for the plan of a sweep.

        The weight of a point is force times sliding speed times duration. With a constant friction coefficient it is
        proportional to the energy loss.

        Raises
        ------
        ConvergenceError
            The flanks do not exist or do not mesh, or the load distribution does not converge.
        """
        from efficiency.conditions.duty import duty_rows
        from regression.plan.operating_range import WeightedPoints

        card = Oil.load(oil or self.design.operation.oil)
        found = []
        for row in duty_rows(duty, self.design):
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
        duty: Path | str | Sequence[DutyRow] | None = None,
        **conditions: Unpack[ConditionValues],
    ) -> Comparison:
        """Friction models and closed forms at a point, and over a `duty` cycle if given; see `LoadedMesh.compare`."""
        from efficiency.loss.compare import over_duty

        found = self.mesh(side, *(grid or ())).load(torque).compare(frictions, **conditions)
        if duty is None:
            return found
        return over_duty(found, lambda name: self.duty(duty, name, grid=grid, oil=found.conditions.oil))

    @one_thread
    def geometry(self, side: str = "both", marking: Value | None = None) -> PairGeometry:
        """Flanks and unloaded contact: ease-off, contact pattern, transmission error; keywords as in `misalignment`."""
        from efficiency.geometry.pair_geometry import chosen_sides, marking_thickness, pair_geometry

        return pair_geometry(self.design, chosen_sides(side), marking_thickness(marking))

    @one_thread
    def misalignment(
        self,
        *,
        E: Values | None = None,
        P: Values | None = None,
        G: Values | None = None,
        shaft_angle_error: Values | None = None,
        side: str = "drive",
        marking: Value | None = None,
        torque: Value | None = None,
        friction: Friction | None = None,
        progress: ProgressCallback | None = None,
        samples: int | None = None,
        accuracy_grade: int | None = None,
        **conditions: Unpack[ConditionValues],
    ) -> MisalignmentGrid:
        """Contact over all combinations of misalignments added to those of the design (V-H check), or over random ones.

        Parameters
        ----------
        E, P, G, shaft_angle_error : float, str or sequence, optional
            Values of each misalignment [m], [rad]; default: zero.
        side : {"drive", "coast", "both"}
            Flank pairs, with one study for each.
        marking : float or str, optional
            Thickness of the marking compound [m]; default: 6.35 um.
        torque : float or str, optional
            Pinion torque [N m] at which load, pressure, edge load and loss of every state are computed.
        friction, progress : optional
            As in `over`.
        samples : int, optional
            Number of random states (tolerance analysis): each misalignment is normal, its value the standard deviation;
            without any, E, P and G have 0.025 mm.
        accuracy_grade : int, optional
            With `samples`: grade of ISO 1328-1 (1 to 11) of the flanks; slopes, crowning and twist are random too.
        **conditions : float or str
            With a torque: conditions that differ from the design, as in `LoadedMesh.efficiency`.
        """
        from efficiency.geometry.misalignment import MisalignmentGrid, misalignment_study
        from efficiency.geometry.pair_geometry import chosen_sides, marking_thickness

        axes = dict(zip(MISALIGNMENTS, (E, P, G, shaft_angle_error), strict=True))
        values: dict[str, Any] = {
            name: tuple(axis_values(name, given)) for name, given in axes.items() if given is not None
        }
        if not values and samples is not None:
            values = dict.fromkeys(("E", "P", "G"), (_SPREAD,))
        if not values:
            raise InputError(", ".join(MISALIGNMENTS), None, "at least one of them with its values")
        if accuracy_grade is not None:
            check_count("accuracy_grade", accuracy_grade, 1, 11)
            if samples is None:
                raise InputError("accuracy_grade", accuracy_grade, "no value without samples")
        if samples is not None:
            check_count("samples", samples, 2, _MAX_STATES)
        elif (states := math.prod(map(len, values.values()))) > _MAX_STATES:
            raise InputError(", ".join(MISALIGNMENTS), f"{states} states", f"at most {_MAX_STATES} combinations")
        for name, value in {"friction": friction, **conditions}.items():
            if torque is None and value is not None:
                raise InputError(name, value, "no value without a torque", "It affects only the loaded contact.")
        carried = None if torque is None else checked("torque", torque)
        [model] = self.check([friction], **conditions)

        def study(part: Side, thickness: float) -> MisalignmentStudy:
            def load(moved: Design) -> EfficiencyResult:
                here: dict[str, Any] = {"side": part, "torque": carried, **conditions}
                return self.sharing_bodies(moved).at(model, **here)

            return misalignment_study(
                self.design,
                side=part,
                marking=thickness,
                progress=progress,
                torque=carried,
                load=None if carried is None else load,
                samples=samples,
                accuracy_grade=accuracy_grade,
                **values,
            )

        studies = tuple(study(part, marking_thickness(marking)) for part in chosen_sides(side))
        return MisalignmentGrid(self.design, studies)

    def plot_contact(
        self, side: Side = "drive", member: Literal["pinion", "gear"] = "gear", ax: Axes | None = None
    ) -> Axes:
        """Plot the unloaded contact pattern on a flank."""
        from efficiency.output.plots_geometry import contact_pattern_figure

        found = self.geometry(side)
        if side in found.failures:
            raise ConvergenceError("no_contact", found.failures[side])
        shown = found.sides[side]
        with interactive():
            return contact_pattern_figure(shown.pair, shown.pattern, member, ax)

    @one_thread
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
        """Write solids (STL), flank grids (CSV) and the machine summary (CSV); returns one line for each file.

        Parameters
        ----------
        folder : Path or str
            Output folder.
        what : iterable of {"tooth", "member", "step", "grid", "ease_off", "summary"}
            Tooth space and whole member (STL), whole members and the mounted pair (STEP, extra ``cad``), flank points,
            maps of the ease-off, machine summary.
        members : iterable of {"pinion", "gear"}
            Members to export.
        rows, columns : int
            Points from root to tip and from heel to toe, 5 to 200.
        margin : float
            Distance of the grids from the edges as a fraction of face width and depth, 0 to 0.3.
        rim, bore : float or str, optional
            Solids: rim thickness below the root [m]; diameter of the bore [m], 0 for no bore.
        units : {"metric", "inch"}
            Units of the summary.

        Raises
        ------
        InputError
            A value out of range, or a folder that cannot be written.
        """
        from efficiency.output.files import export_design

        return export_design(self.design, Path(folder), what, members, rows, columns, margin, rim, bore, units)

    def __repr__(self) -> str:
        point = self.design.operation
        return (
            f"{type(self).__name__}({self.name}: {self._teeth_text()}, {point.torque:.4g} N m, "
            f"{point.speed:.4g} rad/s, {point.oil} at {point.temperature:.5g} K)"
        )

    def _teeth_text(self) -> str:
        pinion, gear = self.design.pinion.blank, self.design.gear.blank
        return f"{pinion.teeth}x{gear.teeth}, offset {1e3 * self.design.assembly.hypoid_offset:.4g} mm"

    def _repr_html_(self) -> str:
        design, point = self.design, self.design.operation
        rows = [
            ("teeth", f"{design.pinion.blank.teeth} / {design.gear.blank.teeth}"),
            ("hypoid offset", f"{1e3 * design.assembly.hypoid_offset:.4g} mm"),
            ("shaft angle", f"{math.degrees(design.assembly.shaft_angle):.4g} deg"),
            ("face width", " / ".join(f"{1e3 * m.blank.face_width:.4g} mm" for m in (design.pinion, design.gear))),
            ("pinion torque, speed", f"{point.torque:.4g} N m, {quantity('speed').text(point.speed)}"),
            ("oil", f"{point.oil}, {point.temperature - 273.15:.4g} degC"),
        ]
        return Table(("quantity", "pinion / gear"), rows, title=design.name).html()
