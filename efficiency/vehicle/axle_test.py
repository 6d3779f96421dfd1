"""Power loss of an axle at the test points of 40 CFR 1037.560, in the format of GEM.

    P_loss = T_in omega_wheel k_a - T_out omega_wheel

with input torque, wheel speed, axle ratio k_a and output torque; T_out = 0 is the unloaded test. Equation and decimals
of the file follow the regulation. Its test points are not verified: compare them with the regulation in force.
"""

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import scipy

from efficiency.vehicle.loss_map import AxleLosses, LossMap, LossTable, require_all
from ehl.common.arrays import finite_or_none
from ehl.common.errors import ConvergenceError, InputError, check_choice
from ehl.common.files import write_file
from ehl.common.quantities import quantity
from ehl.common.table import Column, Table
from ehl.common.units import ValueRange
from regression.friction.published_registry import model_label

Application = Literal["single", "tandem"]

RPM = 2.0 * np.pi / 60.0
MILES_PER_HOUR = 65.0  # vehicle speed of the highest wheel speed of the test
REVOLUTIONS_PER_MILE = 650.0  # default tyre
_OUTPUT_TORQUES: dict[Application, tuple[float, ...]] = {
    "single": (0.0, 500.0, 1000.0, 2000.0, 3000.0, 4000.0),
    "tandem": (0.0, 250.0, 500.0, 1000.0, 1500.0, 2000.0),
}
_REVOLUTIONS = ValueRange("", ge=100.0, le=2000.0, hint="Tyre revolutions per mile, of the smallest tyre.")
_MARGIN = 1.25  # largest input torque over loss-free input torque: covers efficiencies above 0.8
SOURCE = "test points of 40 CFR 1037.560 not verified: compare them with the regulation in force"


def power_loss_40cfr1037(torque_input: float, torque_output: float, speed_wheel: float, ratio: float) -> float:
    """Power loss of 40 CFR 1037.560 [W].

    torque_input, torque_output: [N m].
    speed_wheel: [rad/s].
    ratio: drive axle ratio [-].
    """
    return torque_input * speed_wheel * ratio - torque_output * speed_wheel


@dataclass(frozen=True)
class AxleTestPoints:
    """Output torques [N m] and wheel speeds [rad/s] of the test."""

    torque_output: tuple[float, ...]
    speed_wheel: tuple[float, ...]

    def pinion_torques(self, ratio: float) -> list[float | str]:
        """Pinion torques of the loss map [N m]: loss-free torques of the test points, and a margin for the loss."""
        loaded = [torque / ratio for torque in self.torque_output if torque > 0.0]
        return [*loaded, _MARGIN * loaded[-1]]


def axle_test_points(
    application: Application = "single",
    revolutions_per_mile: float = REVOLUTIONS_PER_MILE,
    torque_max: float | None = None,
) -> AxleTestPoints:
    """Test points: output torques of the application, wheel speeds 50, 150, 250... rpm up to 65 miles per hour.

    application: single drive axle of a heavy vehicle; tandem axle, or axle of a light or medium vehicle.
    revolutions_per_mile: tyre revolutions per mile, of the smallest tyre.
    torque_max: rated output torque of the axle [N m].
    Raises `InputError`: an unknown application, a number out of range, no output torque left.
    """
    check_choice("application", application, get_args(Application))
    turns = _REVOLUTIONS.check(revolutions_per_mile, "revolutions_per_mile")
    torques = tuple(t for t in _OUTPUT_TORQUES[application] if torque_max is None or t <= torque_max)
    if len(torques) < 2:
        least = _OUTPUT_TORQUES[application][1]
        raise InputError("torque_max", f"{torque_max:g} N m", f"at least {least:g} N m, the lowest loaded test point")
    highest = MILES_PER_HOUR * turns / 60.0
    steps = max(1, int(np.ceil((highest - 50.0) / 100.0)))
    return AxleTestPoints(torques, tuple(float(50.0 + 100.0 * k) * RPM for k in range(steps + 1)))


@dataclass(frozen=True)
class AxleTestRow:
    """One test point."""

    # [rad/s], [N m], [N m], [W]
    speed_wheel: float
    torque_output: float
    torque_input: float
    power_loss: float


@dataclass(frozen=True, repr=False)
class AxleTest(LossTable):
    """Power loss at the test points."""

    map: LossMap  # loss map of the mesh
    ratio: float  # axle ratio [-]
    # sorted by wheel speed, then output torque; empty if a point of the map failed
    rows: tuple[AxleTestRow, ...] = field(repr=False)
    # case and note; the first note describes the losses outside the mesh
    case_notes: tuple[tuple[str, str], ...] = field(default=(), repr=False)

    @property
    def reason(self) -> str:
        """Reason for a failure of the loss map."""
        return self.map.reason

    def table(self) -> Table:
        """One row per test point."""
        of = self.map
        return Table(
            ("speed_wheel", "torque_output", "torque_input", Column("power_loss", label="power loss")),
            [tuple(asdict(row).values()) for row in self.rows],
            title=f"{of.design}, ratio {self.ratio:.4g}, {of.oil} at "
            f"{quantity('temperature').text(of.temperature)}, friction: "
            f"{model_label(of.friction_model)}; power loss by 40 CFR 1037.560",
            name="axle test",
        )

    def to_dict(self) -> dict[str, Any]:
        """Test points, conditions and notes in SI units, for JSON."""
        about = {name: getattr(self.map, name) for name in ("design", "friction_model", "oil", "temperature")}
        state = {"ratio": self.ratio, "status": self.status, "reason": self.reason}
        return {**about, **state, "rows": finite_or_none(self.rows), "notes": list(self.notes)}

    def __repr__(self) -> str:
        return f"AxleTest({self.map.design}, {self.map.friction_model}: {len(self.rows)} test points, {self.status})"

    def to_csv(self, path: Path | str) -> Path:
        """Write wheel speed (0.1 rpm), output torque (0.01 N m) and power loss (0.0001 kW), the decimals of GEM.

        Raises `InputError`: the file cannot be written; `ConvergenceError`: a point failed.
        """
        require_all(self.reason)
        lines = ["Wheel speed [r/min],Output torque [N m],Power loss [kW]"]
        lines += [f"{r.speed_wheel / RPM:.1f},{r.torque_output:.2f},{r.power_loss * 1e-3:.4f}" for r in self.rows]
        path = Path(path)
        write_file(path, "\n".join(lines) + "\n", "cfr1037")
        return path


def solve_axle_test(points: AxleTestPoints, mesh: LossMap, ratio: float, axle: AxleLosses | None = None) -> AxleTest:
    """Input torque and power loss at the test points, from a loss map of the mesh.

    Solves ``T_in - T_loss(T_in) = T_out/k_a``. ``T_loss/T_in`` of the mesh is a monotone cubic interpolant of ``T_in``,
    constant below the lowest torque of the map.

    points: test points.
    mesh: loss map without axle losses at `points.pinion_torques` and the wheel speeds times the ratio.
    ratio: axle ratio [-].
    axle: losses outside the mesh.
    Raises `ConvergenceError`: the loss exceeds a fifth of the input torque at the largest output torque.
    """
    first = mesh.case_notes[:1] if axle is None else (("", axle.description),)
    notes = (*first, ("", SOURCE), *mesh.case_notes[1:])
    if mesh.reason:
        return AxleTest(mesh, ratio, (), notes)
    torques, rows = mesh.torques, []
    for speed, wheel, losses in zip(mesh.speeds, points.speed_wheel, mesh.values("torque_loss_mesh"), strict=True):
        share = scipy.interpolate.PchipInterpolator(torques, losses / torques)
        for output in points.torque_output:

            def surplus(
                torque: float, speed: float = speed, share: Any = share, given: float = output / ratio
            ) -> float:
                loss_axle = axle.torque_loss(torque, speed) if axle else 0.0
                return torque - float(share(max(torque, torques[0]))) * torque - loss_axle - given

            if surplus(float(torques[-1])) <= 0.0:
                where = f"{quantity('torque_output').text(output)} and {quantity('speed_wheel').text(wheel)}"
                raise ConvergenceError("loss_too_large", f"the loss exceeds a fifth of the input torque at {where}")
            torque = float(scipy.optimize.brentq(surplus, 0.0, float(torques[-1]), xtol=1e-12))
            rows.append(AxleTestRow(wheel, output, torque, power_loss_40cfr1037(torque, output, wheel, ratio)))
    return AxleTest(mesh, ratio, tuple(rows), notes)
