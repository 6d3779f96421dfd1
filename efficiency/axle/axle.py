"""A whole axle: losses by source over torque, speed and oil temperature, and the temperature at which heat balances."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
import scipy

from efficiency.axle.axle_input import AxleInput, MethodsInput, ShaftInput, load_axle
from efficiency.axle.bearings import BEARING_METHODS, BearingState, bearing_limits
from efficiency.axle.drag import CHURNING_METHODS, SEAL_METHODS, Wheel, windage_torque
from efficiency.axle.result import AxlePoint, AxleResult, BearingLoss
from efficiency.conditions.conditions import Friction, Value, Values, axis_values, checked
from efficiency.conditions.duty import SIGNED, DutyRow, read_duty
from efficiency.conditions.grid import Condition, GridPoint, solve_points
from efficiency.contact.assembly import Axis
from efficiency.contact.gear_flanks import Side
from efficiency.cylindrical_gears.design import CylindricalDesign
from efficiency.design.design import PairDesign
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.ltca.load_distribution import LoadDistribution
from efficiency.mesh import LoadedMesh
from efficiency.pairs import load
from efficiency.vehicle.axle_test import AxleTest
from efficiency.vehicle.loss_map import signed_axes
from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.threads import one_thread
from ehl.common.validation import validate
from ehl.fluid.oil import Oil
from ehl.fluid.viscosity import TEMPERATURE_RANGE

BALANCE = "balance"
# standard deviation of ln(loss) of the methods, and the factor to the ends of a 90 % interval (ours)
SCATTER = {"skf": 0.25, "palmgren": 0.35, "seals": 0.3, "churning": 0.8, "windage": 0.7}
_NINETY = 1.645
_CLOSE = 1e-9  # [K] of the temperature at which heat balances


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

    @classmethod
    def failed(cls, reason: str, notes: tuple[str, ...] = ()) -> _MeshLoss:
        """Of a mesh without a solution."""
        return cls(math.nan, math.nan, math.nan, math.nan, reason, notes)

    @classmethod
    def of(cls, point: GridPoint, ends: tuple[float, float], model: str) -> _MeshLoss:
        """Of a point whose loss over that of the ends of its interval is known."""
        if point.reason:
            return cls.failed(point.reason, point.notes)
        loss = float(point.figure("power_loss") + point.figure("power_loss_rolling"))
        outside = float(point.figure("outside_range_share"))
        return cls(loss, loss * ends[0], loss * ends[1], outside, "", point.notes, model)


class Axle:
    """A gear pair with the bearings and seals of its shafts, an oil sump and a housing.

    Parameters
    ----------
    axle : AxleInput, str or Path
        An axle file, the name of a shipped axle, or its content.
    grid : (int, int), optional
        Mesh positions and points per contact line.
    methods : mapping, optional
        `bearings`, `seals`, `churning` in place of the methods of the file.

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

    @property
    def name(self) -> str:
        """Name of the axle."""
        return self.input.name

    @property
    def shafts(self) -> tuple[ShaftInput, ShaftInput]:
        """Of pinion and gear."""
        return self.input.pinion_shaft, self.input.gear_shaft

    @cached_property
    def wheels(self) -> tuple[Wheel, Wheel]:
        """Pinion and gear as the churning formulas take them."""
        design: PairDesign = self.pair.design
        pitch = self._mesh("drive").pitch
        angles = pitch.spiral_angle_pinion, pitch.spiral_angle_gear
        if isinstance(design, CylindricalDesign):
            pair, wide = design.involute, design.face_width
            sizes = [(pair.teeth[k], pair.pitch[k], pair.tip[k], wide, pair.tip[k] - pair.root[k]) for k in (0, 1)]
        else:
            sizes = []
            for blank in (design.pinion.blank, design.gear.blank):
                heel = np.array([0.5 * blank.face_width])
                outer, tip = (float(blank.axial(heel, height)[0][0]) for height in (0.0 * heel, blank.tip(heel)))
                depth = float((blank.tip(heel) - blank.root(heel))[0])
                sizes.append((blank.teeth, outer, max(tip, outer), blank.face_width, depth))
        one, two = (Wheel(*size, pitch.pressure_angle, abs(a)) for size, a in zip(sizes, angles, strict=True))
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
            Of the pinion, below zero on the coast flanks; the design's if not given [N m].
        speed : float or str, optional
            Of the pinion, below zero in reverse [rad/s].
        temperature : float or str, optional
            Of the oil [K], or ``"balance"``: that at which housing and cooler remove the loss.
        friction : FrictionModel or str, optional
            Friction model or its name; that of the oil if not given.

        Raises
        ------
        ConvergenceError
            The heat does not balance within the range of oils.
        """
        own = self.pair.design.operation
        turning = _signed("torque", own.torque if torque is None else torque)
        running = _signed("speed", own.speed if speed is None else speed)
        if temperature == BALANCE:
            kelvin = self._balanced(turning, running, friction)
        else:
            kelvin = float(checked("temperature", own.temperature if temperature is None else temperature))
        row = DutyRow(turning, running, kelvin, 0.0)
        return self._result("point", [row], [self._mesh_loss(row, friction)])

    @one_thread
    def map(
        self, torque: Values, speed: Values, temperature: Values | None = None, friction: Friction | None = None
    ) -> AxleResult:
        """Losses at all combinations of torques, zero and coast among them, speeds and oil temperatures.

        Parameters as of `at`, each a list of values, ``"a, b, c unit"`` or ``"from:to:number unit"``.
        """
        torques, speeds = signed_axes(torque, speed)
        own = self.pair.design.operation.temperature
        kelvins = [float(t) for t in axis_values("temperature", own if temperature is None else temperature)]
        rows = [DutyRow(float(t), float(w), kelvin, 0.0) for kelvin in kelvins for w in speeds for t in torques]
        found: dict[tuple[float, float, float], _MeshLoss] = {}
        sides: tuple[tuple[Side, float], ...] = (("drive", 1.0), ("coast", -1.0))
        for side, sign in sides:
            loaded = sorted(float(sign * t) for t in torques if sign * t > 0.0)
            if loaded:
                axes = loaded, [float(w) for w in speeds], kelvins
                for place, mesh in self._mesh_map(side, axes, friction).items():
                    found[sign * place[0], place[1], place[2]] = mesh
        losses = [found[row.torque, row.speed, row.temperature] if row.torque else _MeshLoss() for row in rows]
        return self._result("map", rows, losses)

    def _mesh_map(
        self, side: Side, axes: tuple[list[float], ...], friction: Friction | None
    ) -> dict[tuple[float, ...], _MeshLoss]:
        """Mesh losses of one side over torque, speed, temperature; the interval from that at the ends of the axes."""
        mesh, held = self._mesh(side), {"driver": "pinion" if side == "drive" else "gear", "friction": friction}
        few = [sorted({values[0], values[-1]}) for values in axes]
        names = ("torque", "speed", "temperature")
        coarse = mesh.over(**dict(zip(names, few, strict=True)), interval=True, **held)
        spread = []
        for name in ("efficiency_upper", "efficiency_lower"):
            ends = np.log((1.0 - coarse.values(name)) / (1.0 - coarse.values()))
            for axis, (some, every) in enumerate(zip(few, axes, strict=True)):
                moved = np.moveaxis(ends, axis, -1)
                lines = [np.interp(every, some, line) for line in moved.reshape(-1, len(some))]
                ends = np.moveaxis(np.reshape(lines, (*moved.shape[:-1], len(every))), -1, axis)
            spread.append(np.exp(ends).ravel())
        grid = mesh.map(**dict(zip(names, axes, strict=True)), **held)
        model = coarse.results[0].friction_model if coarse.results else ""
        places = itertools.product(*axes)
        ends = zip(*spread, strict=True)
        return {at: _MeshLoss.of(point, end, model) for at, point, end in zip(places, grid.points, ends, strict=True)}

    @one_thread
    def duty(
        self,
        duty: Path | str | Sequence[DutyRow],
        friction: Friction | None = None,
        *,
        tyre_radius: Value | None = None,
        temperature: Value | None = None,
    ) -> AxleResult:
        """Losses and energies of a duty cycle (`efficiency.conditions.duty.read_duty`), rows without torque among them.

        Parameters
        ----------
        duty : Path, str or sequence of DutyRow
            File, or rows.
        friction : FrictionModel or str, optional
            As of `at`.
        tyre_radius, temperature : float or str, optional
            As of `read_duty`; the temperature is that of the design where not given.
        """
        if isinstance(duty, Path | str):
            design = self.pair.design
            kelvin = design.operation.temperature if temperature is None else temperature
            ratio = 1.0 / design.ratio
            rows = read_duty(duty, tyre_radius=tyre_radius, ratio=ratio, temperature=kelvin, unloaded=True)
        else:
            rows = tuple(duty)
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
        """Power loss at the test points of 40 CFR 1037.560; `options` as of `GearPair.axle_test`."""
        own = self.pair.design.operation.temperature
        kelvin = float(checked("temperature", own if temperature is None else temperature))
        held: dict[str, Any] = {
            "temperature": kelvin,
            "axle": _OtherLosses(self, kelvin),
            "grid": self._grid,
            "friction": friction,
        }
        return self.pair.axle_test(application, **held, **options)

    @one_thread
    def losses_without_mesh(
        self, row: DutyRow, *, many: bool = False
    ) -> tuple[dict[str, float], tuple[BearingLoss, ...], list[str]]:
        """Losses by source without that of the mesh [W], those of each bearing, and notes, at an operating point.

        `many`: one of many points, with bearing loads interpolated over the torque.
        """
        oil, sump, design = self._oil, self.input.sump, self.pair.design
        viscosity, density = (float(of(row.temperature)) for of in (oil.viscosity_kinematic, oil.density))
        losses, bearings, notes = dict.fromkeys(("bearings", "seals", "churning", "windage"), 0.0), [], list[str]()
        speeds, wrench = (abs(row.speed), abs(row.speed) * design.ratio), self._wrench_at(row, many=many)
        synthetic = oil.base not in ("mineral", "hydrocracked")
        for k, (shaft, wheel, speed) in enumerate(zip(self.shafts, self.wheels, speeds, strict=True)):
            loads = shaft.loads(wrench[k])
            for bearing, (radial, axial) in zip(shaft.bearings, loads, strict=True):
                depth = bearing.oil_depth
                if depth is None:  # the outer raceway is 1.2 mean diameters wide (SKF model)
                    depth = max(sump.oil_level - shaft.height + 0.6 * bearing.mean_diameter, 0.0)
                state = BearingState(radial, axial, speed, viscosity, depth, synthetic)
                parts = BEARING_METHODS[self.methods.bearings](bearing, state)
                moment = math.fsum(parts.values())
                member = "gear" if k else "pinion"
                bearings.append(BearingLoss(member, bearing.name, radial, axial, moment, moment * speed, parts))
                notes += bearing_limits(self.methods.bearings, bearing, state)
            seal = SEAL_METHODS[self.methods.seals]
            losses["seals"] += math.fsum(seal(s.diameter, speed, oil, row.temperature) for s in shaft.seals)
            dip = max(sump.oil_level - shaft.height + wheel.radius_tip, 0.0)
            churning = CHURNING_METHODS[self.methods.churning](wheel, dip, speed, viscosity, density, sump.volume)
            losses["churning"] += churning * speed
            losses["windage"] += windage_torque(wheel.radius_tip, speed) * speed
        losses["bearings"] = math.fsum(bearing.loss for bearing in bearings)
        return losses, tuple(bearings), notes

    @cached_property
    def _oil(self) -> Oil:
        return Oil.load(self.pair.design.operation.oil)

    def _mesh(self, side: Side) -> Any:
        return self.pair.mesh(side, *(self._grid or ()))

    def _mesh_loss(
        self, row: DutyRow, friction: Friction | None, *, many: bool = False, interval: bool = True
    ) -> _MeshLoss:
        if row.torque * row.speed == 0.0:
            return _MeshLoss()

        def solve(condition: Condition) -> EfficiencyResult:
            return self.pair.at(grid=self._grid, many=many, **condition, friction=friction)

        try:
            point = solve_points([row.condition], solve, interval=interval)[0]
        except InputError:  # inputs of the interval beyond the temperatures of oils; another error comes again
            if not interval:
                raise
            found = self._mesh_loss(row, friction, many=many, interval=False)
            return replace(found, notes=(*found.notes, "the interval of the mesh loss is not known so near 200 degC"))
        if not interval or point.result is None or point.reason:
            return _MeshLoss.of(point, (1.0, 1.0), "")
        names, lost = ("efficiency_upper", "efficiency_lower"), 1.0 - point.result.efficiency
        lower, upper = ((1.0 - float(point.requested[name])) / lost for name in names)
        return _MeshLoss.of(point, (lower, upper), point.result.friction_model)

    def _balanced(self, torque: float, speed: float, friction: Friction | None) -> float:
        """Oil temperature at which the heat that leaves is the loss [K]."""

        def left(kelvin: float) -> float:
            row = DutyRow(torque, speed, kelvin, 0.0)
            mesh = self._mesh_loss(row, friction, many=True, interval=False)
            if mesh.reason:
                raise ConvergenceError(mesh.reason, mesh.notes[0] if mesh.notes else "")
            return (
                mesh.loss
                + math.fsum(self.losses_without_mesh(row)[0].values())
                - sum(self.input.housing.removed(kelvin)[:2])
            )

        low, high = TEMPERATURE_RANGE
        if left(high) > 0.0:
            detail = f"at {high - 273.15:.0f} degC, the most of an oil, {left(high):.4g} W more are lost than removed"
            raise ConvergenceError("no_heat_balance", detail)
        return float(scipy.optimize.brentq(left, low, high, xtol=_CLOSE, rtol=1e-14)) if left(low) > 0.0 else low

    def _wrench(self, side: Side, torque: float) -> FloatArray:
        """Mean mesh force and moment on both shafts (2, 6) [N], [N m], at a pinion torque above zero."""
        if (side, torque) not in self._wrenches:
            loaded: LoadedMesh = self._mesh(side).load(torque)
            axes = loaded.grids.mesh.axes
            if axes is None or loaded.grids.coarse.reason:
                raise ConvergenceError(loaded.grids.coarse.reason or "no_axes", f"{self.name} at {torque:g} N m")
            on_both = [
                shaft_wrench(loaded.grids.coarse, axis, sign) for axis, sign in zip(axes, (-1.0, 1.0), strict=True)
            ]
            self._wrenches[side, torque] = np.array(on_both)
        return self._wrenches[side, torque]

    def _wrench_at(self, row: DutyRow, *, many: bool) -> FloatArray:
        """The same at an operating point; one of many is interpolated between torques a factor of 4 apart."""
        torque = abs(row.torque)
        if torque == 0.0:
            return np.zeros((2, 6))
        if not many:
            return self._wrench(row.side, torque)
        own = self.pair.design.operation.torque
        low, share = divmod(math.log(torque / own, 4.0), 1.0)
        nodes = own * 4.0**low, own * 4.0 ** (low + 1.0)
        below, above = (self._wrench(row.side, node) / node for node in nodes)
        return np.asarray(torque * ((1.0 - share) * below + share * above))

    def _result(
        self, kind: Literal["point", "map", "duty"], rows: Sequence[DutyRow], meshes: Sequence[_MeshLoss]
    ) -> AxleResult:
        points, said = [], []
        bearings: tuple[BearingLoss, ...] = ()
        for row, mesh in zip(rows, meshes, strict=True):
            where = f"{row.torque:.4g} N m, {row.speed * 30.0 / math.pi:.4g} rpm, {row.temperature - 273.15:.4g} degC"
            try:
                others, bearings, notes = self.losses_without_mesh(row, many=kind == "map")
            except ConvergenceError as error:
                others, notes = dict.fromkeys(("bearings", "seals", "churning", "windage"), math.nan), []
                mesh = _MeshLoss.failed(error.reason, (error.detail,))
            points.append(self._point(row, mesh, others))
            said += [(where, note) for note in (*mesh.notes, *notes)]
        model = next((mesh.model for mesh in meshes if mesh.model), "")
        shown = bearings if kind == "point" else ()
        about = self.name, self.input.source, self.pair.name, model, self._oil.name
        return AxleResult(kind, *about, dict(self.methods), tuple(points), shown, tuple(said))

    def _point(self, row: DutyRow, mesh: _MeshLoss, others: Mapping[str, float]) -> AxlePoint:
        total = math.fsum((mesh.loss, *others.values()))
        down, up = [mesh.loss - mesh.lower], [mesh.upper - mesh.loss]
        for name, loss in others.items():
            scatter = name
            if name == "bearings":
                scatter = "skf" if self.methods.bearings == "skf" else "palmgren"
            factor = math.exp(_NINETY * SCATTER[scatter])
            down.append(loss - loss / factor)
            up.append(loss * factor - loss)
        pinion = row.torque * row.speed
        if pinion > 0.0:
            put_in, given_out = pinion, pinion - total
        else:
            put_in, given_out = total - pinion, -pinion
        housing, cooler, wall = self.input.housing.removed(row.temperature)
        efficiency = max(given_out, 0.0) / put_in if put_in > 0.0 else math.nan
        at = {"torque": row.torque, "speed": row.speed, "temperature": row.temperature, "hours": row.hours}
        heat = {"heat_housing": housing, "heat_cooler": cooler, "heat_stored": total - housing - cooler}
        split = {f"loss_{name}": loss for name, loss in {"mesh": mesh.loss, **others}.items()}
        return AxlePoint(
            **at,
            temperature_housing=wall,
            loss_total=total,
            loss_total_lower=total - math.hypot(*down),
            loss_total_upper=total + math.hypot(*up),
            **split,
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
        """What it is, in one line."""
        methods = ", ".join(f"{name} {method}" for name, method in self.axle.methods)
        return f"bearings and drag: axle {self.axle.name} ({methods})"

    def torque_loss(self, torque: float, speed: float) -> float:
        """At a signed pinion torque [N m] and a pinion speed above zero [rad/s], [N m]."""
        losses = self.axle.losses_without_mesh(DutyRow(float(torque), float(speed), self.temperature, 0.0), many=True)[
            0
        ]
        return math.fsum(losses.values()) / float(speed)


def shaft_wrench(load: LoadDistribution, axis: Axis, sign: float) -> FloatArray:
    """Mean of the normal forces of a mesh cycle on a shaft [N], and their moment about the origin of its axis [N m].

    (6,) along two directions square to the axis and along it; the normals point into the gear: sign -1 for the pinion.
    """
    forces = np.concatenate([p.force[:, None] * p.position.normal for p in load.positions])
    points = np.concatenate([p.position.position for p in load.positions]) - axis.origin
    count = sign / len(load.positions)
    force, moment = count * forces.sum(axis=0), count * np.cross(points, forces).sum(axis=0)
    along = axis.direction
    first = np.eye(3)[int(np.argmin(np.abs(along)))]
    first = first - along * (first @ along)
    first = first / np.linalg.norm(first)
    frame = np.array([first, np.cross(along, first), along])
    return np.concatenate([frame @ force, frame @ moment])


def _signed(name: str, value: Value) -> float:
    """Torque or speed of any sign in SI units."""
    return float(SIGNED[name].check(value, name, bare=not isinstance(value, str)))
