"""A whole axle: losses by source over torque, speed and oil temperature, and the temperature at which heat balances."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from scipy.interpolate import RegularGridInterpolator
from scipy.optimize import brentq

from efficiency.axle.axle_input import AxleInput, MethodsInput, ShaftInput, load_axle
from efficiency.axle.bearings import BEARING_METHODS, BearingState, bearing_limits
from efficiency.axle.drag import CHURNING_METHODS, SEAL_METHODS, OilBath, Wheel, churning_limits, windage_torque
from efficiency.axle.result import SOURCES, THICK_OIL, AxlePoint, AxleResult, BearingLoss, Ends, Kind, interval_ends
from efficiency.conditions.conditions import Friction, Value, Values, axis_values, checked
from efficiency.conditions.duty import SIGNED, DutyRow, duty_rows
from efficiency.conditions.grid import Condition, Evaluator, Grid, GridPoint
from efficiency.contact.gear_flanks import Side
from efficiency.design.design import Design
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.kinematics import Driver, OperatingPoint
from efficiency.ltca.shaft_forces import shaft_wrenches
from efficiency.mesh import Mesh
from efficiency.output.tables import outside_note
from efficiency.pairs import load
from efficiency.vehicle.axle_test import AxleTest
from efficiency.vehicle.loss_map import signed_axes, uses_of
from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.quantities import quantity
from ehl.common.threads import one_thread
from ehl.common.validation import validate
from ehl.fluid.oil import Oil
from ehl.fluid.viscosity import TEMPERATURE_RANGE
from regression.friction.published_registry import model_label

BALANCE = "balance"
_LONGER = 1.05  # length of the steps of the heat balance over that of the secant (this work)
NODES = 4  # of each axis of a map, at which the interval of the mesh is computed (this work)
BALANCED = 1e-4  # tolerance of the oil temperature [K]
_Nodes = Mapping[Side, Sequence[float]]  # torques of a side whose loads are known
_Loads = list[list[tuple[float, float]]]  # radial and axial load of the bearings of both shafts [N]


@dataclass(frozen=True)
class _MeshLoss:
    """Loss of the mesh, sliding and rolling, with the ends of its interval [W]."""

    loss: float = 0.0
    lower: float = 0.0
    upper: float = 0.0
    outside: float = 0.0
    reason: str = ""
    notes: tuple[str, ...] = ()
    model: str = ""
    uses: frozenset[str] = frozenset()

    @classmethod
    def failed(cls, reason: str, notes: tuple[str, ...] = ()) -> _MeshLoss:
        """Of a mesh without a solution."""
        return cls(math.nan, math.nan, math.nan, math.nan, reason, notes)

    @classmethod
    def of(cls, point: GridPoint, ends: tuple[float, float], model: str) -> _MeshLoss:
        """Of a point of a grid or duty cycle; `ends` of its interval as shares of the loss."""
        if point.reason:
            return cls.failed(point.reason, point.notes)
        loss = float(point.figure("power_loss") + point.figure("power_loss_rolling"))
        outside = float(point.figure("outside_range_share"))
        said = (*point.notes, *filter(None, (outside_note(outside, model_label(model)),)))
        return cls(loss, loss * ends[0], loss * ends[1], outside, "", said, model, uses_of([point]))


def _ends(result: EfficiencyResult | None, interval: bool = True) -> tuple[float, float]:
    """Ends of the 90 % interval of the mesh loss as shares of it; nan if it is not wanted."""
    if not interval:
        return math.nan, math.nan
    if result is None or result.reason:
        return 1.0, 1.0
    low, high = result.loss_interval
    loss = result.power_loss + result.power_loss_rolling
    return low / loss, high / loss


def _ends_of_map(grid: Grid, axes: Sequence[Sequence[float]]) -> list[tuple[float, float]]:
    """The same at every place of a map over torque, speed and temperature.

    Linear between the logarithms of at most `NODES` solved values of each axis. For `truck_hypoid` the widths are
    within 3 % over 20 to 400 N m and 200 to 4000 rpm, within 17 % over 5 to 600 N m and 50 to 6000 rpm.
    """
    shape = tuple(map(len, axes))
    solved = np.reshape([point.result is not None for point in grid.points], shape)
    lines = solved[:, 0, 0], solved[0, :, 0], solved[0, 0, :]
    few = [at[np.unique(np.round(np.linspace(0, len(at) - 1, NODES)).astype(int))] for at in map(np.flatnonzero, lines)]
    if not solved[np.ix_(*few)].all():
        few = [np.unique([0, size - 1]) for size in shape]
    nodes = np.arange(solved.size).reshape(shape)[np.ix_(*few)]
    ends = np.log([_ends(grid.points[node].result) for node in nodes.flat]).reshape(*nodes.shape, 2)
    places = [np.log(values) for values in axes]
    at_nodes = [values[some] for values, some in zip(places, few, strict=True)]
    spread = np.exp(RegularGridInterpolator(at_nodes, ends)(list(itertools.product(*places))))
    return [(low, high) for low, high in spread.tolist()]


class Axle:
    """A gear pair with the bearings and seals of its shafts, an oil sump and a housing.

    Parameters
    ----------
    axle : AxleInput, str or Path
        An axle file, the name of a shipped axle, or its content.
    grid : (int, int), optional
        Mesh positions and points per contact line.
    methods : mapping, optional
        `bearings`, `seals`, `churning` instead of the methods of the file.

    Raises
    ------
    InputError
        Naming field, value and allowed range.

    Examples
    --------
    >>> import efficiency
    >>> axle = efficiency.Axle("truck_hypoid", grid=(4, 9))
    >>> point = axle.at("200 N m", "1500 rpm", "80 degC", "constant:0.05").points[0]
    >>> point.loss_mesh < point.loss_total < point.axle_power_input
    True
    """

    def __init__(
        self,
        axle: AxleInput | Path | str,
        *,
        grid: tuple[int, int] | None = None,
        methods: Mapping[str, str] | None = None,
    ) -> None:
        self.input = axle if isinstance(axle, AxleInput) else load_axle(axle)
        self.methods = validate(MethodsInput, self.input.methods.model_dump() | dict(methods or {}), "methods")
        self.pair, self._grid = load(self.input.pair), grid
        self._wrenches: dict[tuple[Side, float], FloatArray] = {}
        self._fluids: dict[float, tuple[float, float, bool]] = {}

    def __repr__(self) -> str:
        methods = ", ".join(f"{name} {method}" for name, method in self.methods)
        return f"Axle({self.name}: {self.pair.name}, {methods})"

    @property
    def name(self) -> str:
        """Name of the axle."""
        return self.input.name

    @property
    def shafts(self) -> tuple[ShaftInput, ShaftInput]:
        """Of pinion and gear."""
        return self.input.pinion_shaft, self.input.gear_shaft

    @property
    def operation(self) -> OperatingPoint:
        """Default operating point: that of the axle file, otherwise that of the pair."""
        own = self.input.operation.model_dump(exclude_none=True)
        return self.pair.design.operation.model_copy(update=own)

    def with_methods(self, **methods: str) -> Axle:
        """The axle with other methods, as for the class; pair, meshes and loads are shared."""
        other = copy(self)
        other.methods = validate(MethodsInput, self.methods.model_dump() | methods, "methods")
        return other

    @cached_property
    def wheels(self) -> tuple[Wheel, Wheel]:
        """Pinion and gear for the churning formulas."""
        design: Any = self.pair.design
        pitch = self._mesh("drive").pitch
        if not isinstance(design, Design):
            pair, wide = design.involute, design.face_width
            sizes = [(pair.teeth[k], pair.pitch[k], pair.tip[k], wide, pair.tip[k] - pair.root[k]) for k in (0, 1)]
        else:
            sizes = []
            for blank in (design.pinion.blank, design.gear.blank):
                heel = np.array([0.5 * blank.face_width])
                outer, tip = (float(blank.axial(heel, height)[0][0]) for height in (0.0 * heel, blank.tip(heel)))
                depth = float((blank.tip(heel) - blank.root(heel))[0])
                sizes.append((blank.teeth, outer, max(tip, outer), blank.face_width, depth))
        one, two = (
            Wheel(*size, pitch.pressure_angle, abs(a)) for size, a in zip(sizes, pitch.spiral_angle, strict=True)
        )
        return one, two

    @one_thread
    def at(
        self,
        torque: Value | None = None,
        speed: Value | None = None,
        temperature: Value | None = None,
        friction: Friction | None = None,
    ) -> AxleResult:
        """Losses at one operating point.

        Parameters
        ----------
        torque : float or str, optional
            Pinion torque [N m], negative on the coast flanks; default: that of the axle.
        speed : float or str, optional
            Pinion speed [rad/s], negative in reverse; default: that of the axle.
        temperature : float or str, optional
            Oil temperature [K], or ``"balance"`` for the temperature at which housing and cooler remove the loss.
        friction : FrictionModel or str, optional
            Friction model or its name; default: that of the oil.

        Raises
        ------
        ConvergenceError
            The heat does not balance within the range of oils.
        """
        own = self.operation
        turning = SIGNED["torque"].check_given(own.torque if torque is None else torque, "torque")
        running = SIGNED["speed"].check_given(own.speed if speed is None else speed, "speed")
        if temperature == BALANCE:
            kelvin = self._balanced(turning, running, friction)
        else:
            kelvin = float(checked("temperature", own.temperature if temperature is None else temperature))
        row = DutyRow(turning, running, kelvin, 0.0)
        return self._result("point", [row], [self._mesh_loss(row, friction)])

    @one_thread
    def map(
        self,
        torque: Values,
        speed: Values,
        temperature: Values | None = None,
        friction: Friction | None = None,
        *,
        interval: bool = True,
        models: Sequence[Path | str] = (),
    ) -> AxleResult:
        """Losses at all combinations of torques (also zero and coast), speeds and oil temperatures.

        Parameters as in `at`, each a list of values, ``"a, b, c unit"`` or ``"from:to:number unit"``; without the
        `interval` of the mesh (most of the time of a map) limits are nan. `models`: as in `GearPair.loss_map`.
        """
        from efficiency.vehicle.map_files import check_axes

        torques, speeds = signed_axes(torque, speed)
        for path in models:
            check_axes(path, torques, speeds)
        kelvins = [float(t) for t in axis_values("temperature", self._stated(temperature))]
        rows = [DutyRow(float(t), float(w), kelvin, 0.0) for kelvin in kelvins for w in speeds for t in torques]
        found: dict[tuple[float, float, float], _MeshLoss] = {}
        nodes: dict[Side, list[float]] = {}
        sides: tuple[tuple[Side, float], ...] = (("drive", 1.0), ("coast", -1.0))
        for side, sign in sides:
            loaded = sorted(float(sign * t) for t in torques if sign * t > 0.0)
            if not loaded:
                continue
            axes = loaded, [float(w) for w in speeds], kelvins
            driver: Driver = "pinion" if side == "drive" else "gear"
            grid = self._mesh(side).map(friction, *axes, driver=driver)
            ends = _ends_of_map(grid, axes) if interval else itertools.repeat(_ends(None, False))
            solved = grid.results
            model = next((result.friction_model for result in solved), "")
            nodes[side] = sorted({result.conditions.torque for result in solved})
            for (t, w, kelvin), point, of_point in zip(itertools.product(*axes), grid.points, ends, strict=False):
                found[sign * t, w, kelvin] = _MeshLoss.of(point, of_point, model)
        losses = [found[row.torque, row.speed, row.temperature] if row.torque else _MeshLoss() for row in rows]
        return self._result("map", rows, losses, nodes)

    @one_thread
    def duty(
        self,
        duty: Path | str | Sequence[DutyRow],
        friction: Friction | None = None,
        *,
        tyre_radius: Value | None = None,
        temperature: Value | None = None,
    ) -> AxleResult:
        """Losses and energies of a duty cycle (`efficiency.conditions.duty.read_duty`), also of rows without torque.

        Parameters
        ----------
        duty : Path, str or sequence of DutyRow
            File, or rows.
        tyre_radius, temperature : float or str, optional
            As in `read_duty`; default temperature: that of the axle.
        """
        at: Any = {"tyre_radius": tyre_radius, "temperature": self._stated(temperature)}
        rows = duty_rows(duty, self.pair.design, **at, unloaded=True)
        return self._result("duty", rows, [self._mesh_loss(row, friction, many=True) for row in rows])

    @one_thread
    def axle_test(
        self,
        application: Literal["single", "tandem"] = "single",
        friction: Friction | None = None,
        *,
        temperature: Value | None = None,
        **options: Any,
    ) -> AxleTest:
        """Power loss at the test points of 40 CFR 1037.560; `options` as in `GearPair.axle_test`."""
        kelvin = float(checked("temperature", self._stated(temperature)))
        held: dict[str, Any] = {"temperature": kelvin, "axle": _OtherLosses(self, kelvin), "grid": self._grid}
        return self.pair.axle_test(application, friction=friction, **held, **options)

    def _stated(self, temperature: Any) -> Any:
        """The given oil temperatures of many points, or that of the axle."""
        if isinstance(temperature, str) and temperature == BALANCE:
            allowed = "a temperature: the heat balance is that of one operating point"
            raise InputError("temperature", temperature, allowed)
        return self.operation.temperature if temperature is None else temperature

    def _other_losses(
        self, row: DutyRow, loads: Sequence[Sequence[tuple[float, float]]]
    ) -> tuple[dict[str, float], tuple[BearingLoss, ...], list[str]]:
        """Losses by source without that of the mesh [W], those of each bearing under its load, and notes."""
        viscosity, density, synthetic = self._oil_at(row.temperature)
        oil, sump, wheels, bearings, notes = self._oil, self.input.sump, self.wheels, [], list[str]()
        speeds = abs(row.speed), abs(row.speed) * self.pair.design.ratio
        method, seal, seals = BEARING_METHODS[self.methods.bearings], SEAL_METHODS[self.methods.seals], 0.0
        for member, shaft, speed, forces in zip(("pinion", "gear"), self.shafts, speeds, loads, strict=True):
            for bearing, (radial, axial) in zip(shaft.bearings, forces, strict=True):
                depth = bearing.oil_depth
                if depth is None:  # the outer raceway is 1.2 mean diameters wide (SKF model)
                    depth = max(sump.oil_level - shaft.height + 0.6 * bearing.mean_diameter, 0.0)
                state = BearingState(radial, axial, speed, viscosity, depth, synthetic)
                parts = method(bearing, state)
                moment = math.fsum(parts.values())
                bearings.append(BearingLoss(member, bearing.name, radial, axial, moment, moment * speed, parts))
                notes += bearing_limits(self.methods.bearings, bearing, state)
            seals += math.fsum(seal(s.diameter, speed, oil, row.temperature) for s in shaft.seals)
        one, two = (
            max(sump.oil_level - shaft.height + wheel.radius_tip, 0.0)
            for shaft, wheel in zip(self.shafts, wheels, strict=True)
        )
        bath = OilBath((one, two), speeds, viscosity, density, sump.volume)
        notes += churning_limits(self.methods.churning, wheels, bath)
        losses = {
            "bearings": math.fsum(bearing.loss for bearing in bearings),
            "seals": seals,
            "churning": CHURNING_METHODS[self.methods.churning](wheels, bath),
            "windage": math.fsum(
                windage_torque(wheel.radius_tip, w) * w for wheel, w in zip(wheels, speeds, strict=True)
            ),
        }
        return losses, tuple(bearings), notes

    @cached_property
    def _oil(self) -> Oil:
        return Oil.load(self.pair.design.operation.oil)

    def _oil_at(self, kelvin: float) -> tuple[float, float, bool]:
        """Kinematic viscosity [m^2/s], density [kg/m^3] and whether the base oil is synthetic."""
        if kelvin not in self._fluids:
            oil, synthetic = self._oil, self._oil.base not in ("mineral", "hydrocracked")
            self._fluids[kelvin] = float(oil.viscosity_kinematic(kelvin)), float(oil.density(kelvin)), synthetic
        return self._fluids[kelvin]

    def _loads_at(self, row: DutyRow, nodes: Sequence[float] = ()) -> list[list[tuple[float, float]]]:
        """Radial and axial load of the bearings of both shafts [N].

        Between `nodes`, torques that are given, the wrench per torque is linear in the logarithm of the torque.
        """
        torque, wrenches = abs(row.torque), np.zeros((2, 6))
        if torque and (len(nodes) < 2 or torque in nodes):
            wrenches = self._wrench(row.side, torque)
        elif torque:
            place = int(np.clip(np.searchsorted(nodes, torque), 1, len(nodes) - 1))
            low, high = nodes[place - 1], nodes[place]
            share = math.log(torque / low) / math.log(high / low)
            shares = zip((low, high), (1.0 - share, share), strict=True)
            wrenches = np.asarray(sum(torque * part * self._wrench(row.side, node) / node for node, part in shares))
        return [shaft.loads(of) for shaft, of in zip(self.shafts, wrenches, strict=True)]

    def _alternatives(self, row: DutyRow, loads: _Loads) -> dict[tuple[str, str], float]:
        """Losses by the other methods [W], by source and method."""
        found = {}
        for name, field in MethodsInput.model_fields.items():
            for method in set(get_args(field.annotation)) - {getattr(self.methods, name)}:
                found[name, method] = self.with_methods(**{name: method})._other_losses(row, loads)[0][name]
        return found

    def _mesh(self, side: Side) -> Mesh:
        return self.pair.mesh(side, *(self._grid or ()))

    def _mesh_loss(
        self, row: DutyRow, friction: Friction | None, *, many: bool = False, interval: bool = True
    ) -> _MeshLoss:
        if row.torque * row.speed == 0.0:
            return _MeshLoss()

        def at(conditions: Sequence[Condition]) -> list[EfficiencyResult]:
            return [self.pair.at(friction, grid=self._grid, many=many, **condition) for condition in conditions]

        [point] = Evaluator(at).points([row.condition])
        model = point.result.friction_model if point.result is not None else ""
        return _MeshLoss.of(point, _ends(point.result, interval), model)

    def _balanced(self, torque: float, speed: float, friction: Friction | None) -> float:
        """Oil temperature at which the heat that leaves is the loss [K].

        Secant method from the highest temperature of oils downwards, with slightly longer steps.
        """
        loads = self._loads_at(DutyRow(torque, speed, 0.0, 0.0))

        @cache  # the bracket is evaluated again by the search
        def left(kelvin: float) -> float:
            row = DutyRow(torque, speed, kelvin, 0.0)
            mesh = self._mesh_loss(row, friction, interval=False)
            if mesh.reason:
                raise ConvergenceError(mesh.reason, mesh.notes[0] if mesh.notes else "")
            others = self._other_losses(row, loads)[0].values()
            return mesh.loss + math.fsum(others) - sum(self.input.housing.removed(kelvin)[:2])

        low, high = TEMPERATURE_RANGE
        cold, warm = (sum(self.input.housing.removed(kelvin)[:2]) for kelvin in (low, high))
        slope = (warm - cold) / (high - low)  # for a constant loss
        place, excess = high, left(high)
        if excess > 0.0:
            detail = (
                f"at {high - 273.15:.0f} degC, the limit of oils, the loss exceeds the removed heat by {excess:.4g} W"
            )
            raise ConvergenceError("no_heat_balance", detail)
        while excess < 0.0 and place > low:
            before = place, excess
            place = max(low, place + _LONGER * excess / slope)
            excess = left(place)
            slope = max((excess - before[1]) / (before[0] - place), 0.1 * slope)
        return float(brentq(left, place, before[0], xtol=BALANCED)) if excess > 0.0 else place

    def _wrench(self, side: Side, torque: float) -> FloatArray:
        """Mean mesh force and moment on both shafts (2, 6) [N], [N m], at a pinion torque above zero."""
        if (side, torque) not in self._wrenches:
            loaded = self._mesh(side).load(torque)
            axes = loaded.grids.mesh.axes
            if axes is None or loaded.grids.coarse.reason:
                raise ConvergenceError(loaded.grids.coarse.reason or "no_axes", f"{self.name} at {torque:g} N m")
            on_both = [shaft_wrenches(loaded.grids.coarse, *on)[0] for on in zip(axes, (-1.0, 1.0), strict=True)]
            self._wrenches[side, torque] = np.mean(on_both, axis=1)
        return self._wrenches[side, torque]

    def _result(
        self, kind: Kind, rows: Sequence[DutyRow], meshes: Sequence[_MeshLoss], nodes: _Nodes | None = None
    ) -> AxleResult:
        points, said, intervals = [], [], list[Ends]()
        bearings: tuple[BearingLoss, ...] = ()
        loads: dict[float, _Loads] = {}
        for row, mesh in zip(rows, meshes, strict=True):
            where = f"{row.torque:.4g} N m, {quantity('speed').text(row.speed)}, {row.temperature - 273.15:.4g} degC"
            try:
                if row.torque not in loads:
                    loads[row.torque] = self._loads_at(row, (nodes or {}).get(row.side, ()))
                others, bearings, notes = self._other_losses(row, loads[row.torque])
                viscosity, by_others = self._oil_at(row.temperature)[0], {}
                if viscosity > THICK_OIL[0]:
                    for (name, _), loss in self._alternatives(row, loads[row.torque]).items():
                        by_others[name] = loss / others[name] if others[name] > 0.0 < loss else 1.0
                ends = interval_ends(self.methods.bearings, viscosity, by_others)
            except ConvergenceError as error:
                others, notes = dict.fromkeys(SOURCES[1:], math.nan), []
                ends = dict.fromkeys(SOURCES[1:], (math.nan, math.nan))
                mesh = _MeshLoss.failed(error.reason, (error.detail,))
            points.append(self._point(row, mesh, others, ends))
            intervals.append(ends)
            said += [(where, note) for note in (*mesh.notes, *notes)]
        model = next((mesh.model for mesh in meshes if mesh.model), "")
        about = self.name, self.input.source, self.pair.name, model, self._oil.name, dict(self.methods), tuple(points)
        uses = frozenset(self._oil.lubricant(rows[0].temperature).references()).union(*(mesh.uses for mesh in meshes))
        more: dict[str, Any] = {"case_notes": tuple(said), "ends": tuple(intervals), "uses": uses}
        if kind != "point" or points[0].reason:
            return AxleResult(kind, *about, **more)
        by_method = self._alternatives(rows[0], loads[rows[0].torque])
        named = {f"{name} {method}": loss for (name, method), loss in by_method.items()}
        return AxleResult(kind, *about, bearings, named, **more)

    def _point(self, row: DutyRow, mesh: _MeshLoss, others: Mapping[str, float], ends: Ends) -> AxlePoint:
        total = math.fsum((mesh.loss, *others.values()))
        down = [mesh.loss - mesh.lower, *(loss * (1.0 - ends[name][0]) for name, loss in others.items())]
        up = [mesh.upper - mesh.loss, *(loss * (ends[name][1] - 1.0) for name, loss in others.items())]
        pinion = row.torque * row.speed
        put_in, given_out = (pinion, pinion - total) if pinion > 0.0 else (total - pinion, -pinion)
        housing, cooler, wall = self.input.housing.removed(row.temperature)
        efficiency = max(given_out, 0.0) / put_in if put_in > 0.0 else math.nan
        heat = {"heat_housing": housing, "heat_cooler": cooler, "heat_stored": total - housing - cooler}
        split = {f"loss_{name}": loss for name, loss in {"mesh": mesh.loss, **others}.items()}
        return AxlePoint(
            **vars(row),
            temperature_housing=wall,
            loss_total=total,
            loss_total_lower=total - math.hypot(*down),
            loss_total_upper=total + math.hypot(*up),
            **split,
            loss_mesh_lower=mesh.lower,
            loss_mesh_upper=mesh.upper,
            axle_power_input=put_in,
            axle_power_output=given_out,
            axle_efficiency=efficiency,
            **heat,
            outside_range_share=mesh.outside,
            status="failed" if mesh.reason else "converged",
            reason=mesh.reason,
        )


@dataclass(frozen=True)
class _OtherLosses:
    """Losses of an axle without its mesh at an oil temperature, for `GearPair.axle_test`."""

    axle: Axle
    temperature: float

    @property
    def description(self) -> str:
        """Description for titles and notes."""
        methods = ", ".join(f"{name} {method}" for name, method in self.axle.methods)
        return f"bearings and drag: axle {self.axle.name} ({methods})"

    def torque_loss(self, torque: float, speed: float) -> float:
        """Torque loss [N m] at a signed pinion torque [N m] and a positive pinion speed [rad/s]."""
        row = DutyRow(float(torque), float(speed), self.temperature, 0.0)
        own = self.axle.pair.design.operation.torque
        power = math.floor(math.log(abs(torque) / own, 4.0)) if torque else 0
        loads = self.axle._loads_at(row, [own * 4.0**power, own * 4.0 ** (power + 1)])
        return math.fsum(self.axle._other_losses(row, loads)[0].values()) / float(speed)
