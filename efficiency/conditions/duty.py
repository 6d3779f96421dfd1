"""Duty cycle of a pair: operating points from a file, and the energy input, output and loss of the mesh."""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from efficiency.conditions.grid import GridPoint, PointsResult
from efficiency.contact.gear_flanks import Side
from efficiency.design.design import PairDesign
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.kinematics import OPERATION_LIMITS, Driver
from ehl.common.arrays import finite_or_none
from ehl.common.errors import InputError
from ehl.common.table_reader import read_table
from ehl.common.units import ValueRange
from ehl.uncertainty.result import LEVEL, Change, InputUncertainty, combined

if TYPE_CHECKING:
    import pandas

_LOG = logging.getLogger("mixed_ehl")
HOUR = 3600.0
_OIL = OPERATION_LIMITS["temperature"]
_MAX_TORQUE, _MAX_SPEED = (float(OPERATION_LIMITS[name].le or 1e6) for name in ("torque", "speed"))
SIGNED = {
    "torque": ValueRange("N*m", ge=-_MAX_TORQUE, le=_MAX_TORQUE, hint="Negative on the coast side."),
    "speed": ValueRange("rad/s", ge=-_MAX_SPEED, le=_MAX_SPEED, hint="Negative in reverse."),
}
COLUMNS: dict[str, ValueRange | None] = {**SIGNED, "temperature": _OIL, "hours": ValueRange("h", ge=0.0)}
_RECORDED: dict[str, ValueRange | None] = {
    "vehicle_speed": ValueRange("m/s", ge=-150.0, le=150.0),
    "wheel_torque": ValueRange("N*m", ge=-_MAX_TORQUE * 100.0, le=_MAX_TORQUE * 100.0),
    "time": ValueRange("s"),
}
TYRE_RADIUS = ValueRange("m", gt=0.05, lt=2.0)
RATIO = ValueRange("", gt=0.0, le=200.0, hint="Revolutions of the pinion per revolution of the wheels.")


@dataclass(frozen=True)
class DutyRow:
    """One operating point of a duty cycle."""

    torque: float  # pinion torque [N m]; negative if the coast flanks carry it
    speed: float  # pinion speed [rad/s]; negative in reverse
    temperature: float  # oil temperature [K]
    hours: float  # duration [h]

    @property
    def condition(self) -> dict[str, Any]:
        """The operating point by names of `efficiency.conditions.grid.AXES`."""
        return {
            "side": self.side,
            "torque": abs(self.torque),
            "speed": abs(self.speed),
            "temperature": self.temperature,
            "driver": self.driver,
        }

    @property
    def side(self) -> Side:
        """Loaded flanks."""
        return "drive" if self.torque > 0.0 else "coast"

    @property
    def driver(self) -> Driver:
        """Driving member: the pinion if its torque acts in the direction of rotation."""
        return "pinion" if self.torque * self.speed > 0.0 else "gear"


def read_duty(
    path: Path | str,
    *,
    tyre_radius: float | str | None = None,
    ratio: float | None = None,
    temperature: float | str | None = None,
    unloaded: bool = False,
) -> tuple[DutyRow, ...]:
    """Read a duty cycle: CSV or XLSX with the columns torque, speed, temperature and hours, each with its unit.

    Recorded vehicle data are read as well: `time` of each row instead of hours, `vehicle_speed` instead of the pinion
    speed, `wheel_torque` (both wheels) instead of the pinion torque. Rows without torque, speed or duration are
    ignored.

    tyre_radius: rolling radius of the tyres, for `vehicle_speed` [m].
    ratio: revolutions of the pinion per revolution of the wheels, for `vehicle_speed` and `wheel_torque`.
    temperature: oil temperature if the file has none [K].
    unloaded: keep rows without torque, in which an axle has drag losses.
    Raises `InputError` with row and column, or if no row remains.
    """
    path = Path(path)
    given = {"ratio": (ratio, RATIO), "tyre_radius": (tyre_radius, TYRE_RADIUS), "temperature": (temperature, _OIL)}
    turns, radius, held = (
        None if value is None else limits.check(value, name) for name, (value, limits) in given.items()
    )
    table, numbers = read_table(path, COLUMNS | _RECORDED, bare=False, missing=True)
    columns = {name: np.array(values, dtype=float) for name, values in table.items()}
    size = len(next(iter(columns.values())))
    if "time" in columns and "hours" not in columns:
        # the time to the next row; the last one has the median
        steps = np.diff(columns["time"])
        if not len(steps) or not np.all(steps > 0.0):
            hint = "Durations are given in the column hours, such as 'hours [s]'."
            at = int(np.argmin(steps > 0.0)) + 1 if len(steps) else 0
            where, last = f"{path.name}, row {numbers[at]}, time", columns["time"][max(at - 1, 0)]
            allowed = f"increasing times of a recording, here above {last:g} s" if at else "at least two times"
            raise InputError(where, f"{columns['time'][at]:g} s", allowed, hint)
        columns["hours"] = np.append(steps, np.median(steps)) / HOUR
    if "temperature" not in columns and held is not None:
        columns["temperature"] = np.full(size, held)
    for own, recorded in (("speed", "vehicle_speed"), ("torque", "wheel_torque")):
        if own not in columns and recorded in columns:
            if turns is None or (own == "speed" and radius is None):
                needed = "tyre_radius" if own == "speed" and radius is None else "ratio"
                raise InputError(needed, None, f"required, because the file has {recorded}")
            columns[own] = columns[recorded] * (turns / radius if own == "speed" and radius else 1.0 / turns)
    for name in COLUMNS:
        if name not in columns:
            raise InputError(f"{path.name}, column {name}", None, f"columns {', '.join(COLUMNS)}")
    rows = [DutyRow(*(float(x) for x in row)) for row in zip(*(columns[name] for name in COLUMNS), strict=True)]
    loaded = tuple(row for row in rows if (unloaded or row.torque != 0.0) and row.speed != 0.0 and row.hours > 0.0)
    if not loaded:
        raise InputError(path.name, f"{len(rows)} rows", "at least one row with torque, speed and hours")
    if len(loaded) < len(rows):
        what = "speed or duration" if unloaded else "torque, speed or duration"
        left_out = math.fsum(row.hours for row in rows) - math.fsum(row.hours for row in loaded)
        _LOG.info("%s: rows without %s, omitted: %d (%.4g h)", path.name, what, len(rows) - len(loaded), left_out)
    return loaded


def duty_rows(duty: Path | str | Sequence[DutyRow], design: PairDesign, **options: Any) -> tuple[DutyRow, ...]:
    """Given rows, or those of a file: `options` of `read_duty`, with ratio and oil temperature of the design."""
    if not isinstance(duty, Path | str):
        rows = tuple(duty)
        if all(isinstance(row, DutyRow) for row in rows):
            return rows
        raise InputError("duty", type(duty).__name__, "a file, or a sequence of DutyRow")
    own = {"ratio": 1.0 / design.ratio, "temperature": design.operation.temperature}
    return read_duty(duty, **own | {name: value for name, value in options.items() if value is not None})


@dataclass(frozen=True)
class DutyEnergy:
    """Energies at one operating point of the duty cycle."""

    # flanks in contact and driving member
    side: str
    driver: Driver
    # torque [N m] and speed [rad/s], absolute values; oil temperature [K]
    torque: float
    speed: float
    temperature: float
    hours: float  # duration [h]
    # efficiency and its numerical error [-]
    efficiency: float
    efficiency_error: float
    # energies [J]; the rolling loss is not part of `energy_loss`
    energy_input: float
    energy_output: float
    energy_loss: float
    energy_loss_rolling: float
    outside_range_share: float  # share of the sliding power outside the range of the friction model [-]
    status: str
    reason: str


@dataclass(frozen=True, repr=False)
class DutyCycle(PointsResult):
    """Energies of all rows of a duty cycle.

    Parameters
    ----------
    design, friction_model, oil : str
        Design, friction model and oil card.
    rows : tuple of DutyEnergy
        Rows in the order of the file.
    points : tuple of GridPoint
        Points of the rows with their results; not in `to_dict`.

    Examples
    --------
    >>> import efficiency
    >>> from efficiency.conditions.duty import DutyRow
    >>> rows = [DutyRow(torque=300.0, speed=157.0, temperature=363.15, hours=2.0)]
    >>> cycle = efficiency.load("fm_spiral_bevel_14x39").duty(rows, "constant:0.05", grid=(4, 9))
    >>> cycle.total("hours")
    2.0
    """

    presenter = "efficiency.output.gear_report:duty"
    kind_of_points = "rows"

    design: str
    friction_model: str
    oil: str
    rows: tuple[DutyEnergy, ...]
    points: tuple[GridPoint, ...] = field(repr=False, compare=False)

    @property
    def results(self) -> tuple[EfficiencyResult, ...]:
        """Results of the rows that have one."""
        return tuple(point.result for point in self.points if point.result is not None)

    def total(self, name: str) -> float:
        """Sum over all rows of energy_input, energy_output, energy_loss, energy_loss_rolling [J] or hours [h]."""
        return math.fsum(getattr(row, name) for row in self.rows)

    @property
    def efficiency(self) -> float:
        """Total energy output over total energy input [-]; nan if a row failed."""
        return self.total("energy_output") / self.total("energy_input")

    @property
    def inputs(self) -> InputUncertainty:
        """Interval of that efficiency from uncertain inputs, with fully correlated errors of all rows."""
        return cycle_uncertainty(self.rows, [point.result for point in self.points], self.efficiency)

    @property
    def efficiency_error(self) -> float:
        """Numerical error of the efficiency, with fully correlated errors of all rows [-]."""
        return math.fsum(row.efficiency_error * row.energy_input for row in self.rows) / self.total("energy_input")

    def to_frame(self) -> pandas.DataFrame:
        """One row per operating point: energies [J] and scalar values, SI units."""
        import pandas

        notes = ["; ".join(point.notes) for point in self.points]
        return pandas.DataFrame([asdict(row) for row in self.rows]).assign(notes=notes)

    def __repr__(self) -> str:
        return (
            f"DutyCycle({self.design}, {self.oil}, {self.friction_model}: {len(self.rows)} rows, efficiency "
            f"{self.efficiency:.6f}, {self.status})"
        )

    def to_dict(self) -> dict[str, Any]:
        """Rows and totals, for JSON; not-a-number becomes None."""
        names = ("hours", "energy_input", "energy_output", "energy_loss", "energy_loss_rolling")
        total = {name: self.total(name) for name in names}
        inputs = self.inputs
        total |= {"efficiency": self.efficiency, "efficiency_error": self.efficiency_error}
        total |= {"efficiency_lower": inputs.low, "efficiency_upper": inputs.high}
        head = {name: getattr(self, name) for name in ("design", "friction_model", "oil", "status", "reason")}
        return head | {
            "total": finite_or_none(total),
            "uncertainty": inputs.to_dict(),
            "rows": finite_or_none(self.rows),
            "notes": list(self.notes),
        }


def cycle_uncertainty(
    rows: Sequence[DutyEnergy], results: Sequence[EfficiencyResult | None], efficiency: float
) -> InputUncertainty:
    """Interval of the efficiency of all rows together; each input is changed in all rows at once.

    rows, results: energies and results of the rows.
    efficiency: energy output over energy input [-].
    """
    known = [result for result in results if result is not None and not result.reason]
    if len(known) < len(rows) or not 0.0 < efficiency < 1.0:
        return InputUncertainty("efficiency", efficiency, math.nan, math.nan, LEVEL, ())
    sources = {source.name: source for result in known for source in result.inputs.sources}

    def change(name: str, end: str) -> float:
        put_in = given_out = 0.0
        for row, result in zip(rows, known, strict=True):
            moved = {source.name: getattr(source, end) for source in result.inputs.sources}
            eta = moved.get(name, result.efficiency)
            # the power of the pinion is given
            put_in += row.energy_input if row.driver == "pinion" else row.energy_output / eta
            given_out += eta * row.energy_input if row.driver == "pinion" else row.energy_output
        return math.log((1.0 - given_out / put_in) / (1.0 - efficiency))

    changes = [
        Change(name, source.group, source.sd, change(name, "below"), change(name, "above"), source.note)
        for name, source in sources.items()
    ]
    notes = tuple(dict.fromkeys(note for result in known for note in result.inputs.notes))
    squares = [float(end) for end in combined(changes)]
    # ratio of the combined change to the root sum of squares, for each row
    shares = np.array([_share_of_squares(result.inputs) for result in known])
    left = np.average(shares, axis=0, weights=[row.energy_loss for row in rows])
    ends = [float(end * share) for end, share in zip(squares, left, strict=True)]

    def figure(log_change: float) -> float:
        return 1.0 - (1.0 - efficiency) * math.exp(log_change)

    return InputUncertainty.of("efficiency", efficiency, changes, figure, LEVEL, notes, lambda scores: ends)


def _share_of_squares(found: InputUncertainty) -> tuple[float, float]:
    """Both ends of ln(loss) for all inputs together, over the root sum of squares of the single changes."""
    value = 1.0 - found.value
    alone = [
        Change(one.name, one.group, one.sd, math.log((1.0 - one.below) / value), math.log((1.0 - one.above) / value))
        for one in found.sources
    ]
    down, up = (float(end) for end in combined(alone))
    low, high = math.log((1.0 - found.high) / value), math.log((1.0 - found.low) / value)
    return (low / down if down else 1.0), (high / up if up else 1.0)


def row_energy(row: DutyRow, point: GridPoint) -> DutyEnergy:
    """Energies of a row of a duty cycle from its point of `efficiency.conditions.grid.Evaluator.points`."""
    seconds, result = row.hours * HOUR, point.result

    def value(name: str) -> float:
        return math.nan if result is None else float(result.value(name))

    powers = ("input", "output", "loss", "loss_rolling")
    names = ("efficiency", "efficiency_error", "outside_range_share")
    figures: dict[str, Any] = {name: value(name) for name in names}
    figures |= {f"energy_{name}": value(f"power_{name}") * seconds for name in powers}
    return DutyEnergy(**row.condition, **figures, hours=row.hours, status=point.status, reason=point.reason)
