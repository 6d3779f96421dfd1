"""Loss maps: torque loss over pinion torque and speed, drive and coast, with the losses of an axle outside the mesh.

Power balance at the pinion shaft, the input of an axle: T_out = ratio (T_in - T_loss) in drive and in coast. T_in and
T_out are negative in coast, T_loss = P_loss/omega1 is positive in both. The mesh loss is that at T_in; the effect of
the losses of the pinion bearings on it is of second order.

Losses of an axle outside its mesh: a measured table, or a constant and a load-dependent torque (our model).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from efficiency.conditions.conditions import axis_values, check_size
from efficiency.conditions.duty import SIGNED, DutyRow
from efficiency.conditions.grid import Evaluator, GridPoint, PointsResult
from efficiency.loss.efficiency_result import pair_notes
from efficiency.output.tables import outside_note
from ehl.common.arrays import FloatArray, finite_or_none
from ehl.common.errors import ConvergenceError, InputError, check_choice
from ehl.common.files import write_file
from ehl.common.pages import TableResult, Tabular
from ehl.common.quantities import quantity
from ehl.common.sections import Head, Medium, Notes, Section
from ehl.common.table import Table
from ehl.common.table_reader import read_table
from ehl.common.units import ValueRange
from regression.friction.published_registry import model_label

COLUMNS = {
    "torque": SIGNED["torque"],
    "speed": ValueRange("rad/s", ge=0.0, le=SIGNED["speed"].le),
    "torque_loss": ValueRange("N*m", ge=0.0, le=SIGNED["torque"].le),
}
DRAG = replace(COLUMNS["torque_loss"], hint="Torque at the pinion shaft, independent of speed.")
LOAD_SHARE = ValueRange("", ge=0.0, lt=0.5, hint="Torque lost in the bearings over the pinion torque.")
_SIMPLE = {"drag": DRAG, "load_share": LOAD_SHARE}


class AxleLosses(Protocol):
    """Torque lost outside the mesh, referred to the pinion shaft."""

    @property
    def description(self) -> str:
        """Description for titles and notes."""

    def torque_loss(self, torque: float, speed: float) -> float:
        """Torque loss [N m], at least zero, at a signed pinion torque [N m] and a pinion speed [rad/s]."""


@dataclass(frozen=True)
class SimpleAxleLosses:
    """Constant drag torque and bearing loss proportional to the pinion torque: T = drag + share |T1| (our model)."""

    drag: float = 0.0  # drag of bearings, seals and oil at the pinion shaft [N m]
    load_share: float = 0.0  # load-dependent part [-]

    def __post_init__(self) -> None:
        DRAG.check(self.drag, "drag")
        LOAD_SHARE.check(self.load_share, "load_share")

    @property
    def description(self) -> str:
        """Description for titles and notes."""
        return f"bearings and drag: {self.drag:.4g} N m + {100.0 * self.load_share:.4g} % of pinion torque (our model)"

    def torque_loss(self, torque: float, speed: float) -> float:
        """Torque loss [N m] at a signed pinion torque [N m], independent of speed."""
        return self.drag + self.load_share * abs(torque)


@dataclass(frozen=True)
class TableAxleLosses:
    """Torque loss outside the mesh, bilinear interpolation of a table over pinion torque and speed."""

    name: str  # name of the file
    torque: FloatArray  # increasing [N m], negative in coast
    speed: FloatArray  # increasing [rad/s]
    loss: FloatArray  # torque loss at the pinion shaft [N m]

    @property
    def description(self) -> str:
        """Description for titles and notes."""
        return f"bearings and drag: table {self.name}"

    def torque_loss(self, torque: float, speed: float) -> float:
        """Torque loss [N m] at a signed pinion torque [N m] and a pinion speed [rad/s].

        Raises `InputError`: the point lies outside the table.
        """
        for name, value, grid in (("torque", torque, self.torque), ("speed", speed, self.speed)):
            if not grid[0] * (1.0 - 1e-12) - 1e-9 <= value <= grid[-1] * (1.0 + 1e-12) + 1e-9:
                of = quantity(name)
                hint = "The table is not extrapolated: add rows to it, or omit the point."
                raise InputError(f"{self.name}, {of.label}", of.text(value), of.span(grid[0], grid[-1]), hint)
        at_speed = [float(np.interp(speed, self.speed, row)) for row in self.loss]
        return float(np.interp(torque, self.torque, at_speed))


def resolve_axle(axle: AxleLosses | Path | str | Mapping[str, float | str] | None) -> AxleLosses | None:
    """Losses outside the mesh from a table file, or from `drag` and `load_share` of the simple model.

    Raises `InputError`: an unusable file, an unknown name, a value out of range or without its unit.
    """
    if isinstance(axle, Path | str):
        return read_axle_losses(axle)
    if not isinstance(axle, Mapping):
        return axle
    for name in axle:
        check_choice("axle", name, _SIMPLE)
    values = {k: _SIMPLE[k].check(v, k, bare=not isinstance(v, str) or k != "drag") for k, v in axle.items()}
    return SimpleAxleLosses(**values)


def read_axle_losses(path: Path | str) -> TableAxleLosses:
    """Losses outside the mesh from a CSV or XLSX file with columns torque, speed, torque_loss on a full grid.

    Raises `InputError`: the file cannot be read, or lacks a combination of torque and speed.
    """
    path = Path(path)
    found, _ = read_table(path, COLUMNS, tuple(COLUMNS), bare=False, missing=True)
    torque, speed, loss = (np.array(found[name], dtype=np.float64) for name in COLUMNS)
    torques, i = np.unique(torque, return_inverse=True)
    speeds, j = np.unique(speed, return_inverse=True)
    grid = np.full((len(torques), len(speeds)), np.nan)
    grid[i, j] = loss
    if len(loss) != grid.size or np.isnan(grid).any():
        stated = f"{len(loss)} rows for {len(torques)} torques and {len(speeds)} speeds"
        raise InputError(path.name, stated, "every combination of torque and speed exactly once")
    return TableAxleLosses(path.name, torques, speeds, grid)


INTERVAL = ("torque_loss_lower", "torque_loss_upper")
MESH_ALONE = "mesh loss only; add bearings and drag for the loss of the axle"


@dataclass(frozen=True)
class LossPoint:
    """Torque loss at one point."""

    # pinion torque [N m], negative in coast; pinion speed [rad/s]
    torque: float
    speed: float
    # total, mesh (sliding and rolling) and axle outside the mesh [N m]
    torque_loss: float
    torque_loss_mesh: float
    torque_loss_axle: float
    outside_range_share: float  # share of the sliding power outside the range of the friction model [-]
    status: str
    reason: str
    # 90 % interval of the torque loss [N m], without uncertainty of the axle losses; nan if not computed
    torque_loss_lower: float = math.nan
    torque_loss_upper: float = math.nan


class LossTable(PointsResult, TableResult):
    """A result that is one table with notes.

    case_notes: case and note; the first note describes the losses outside the mesh.
    """

    case_notes: tuple[tuple[str, str], ...]

    @property
    def notes(self) -> Mapping[str, int]:
        """Notes with the number of cases of each."""
        return dict(Counter(note for _, note in self.case_notes))

    def sections(self, medium: Medium = "page", *args: Any, **options: Any) -> list[Section]:
        """The table and one note of each kind, that of the worst point."""
        notes = Notes(pair_notes(self.case_notes), len({case for case, _ in self.case_notes if case}))
        table = self.table() if medium == "files" else self._shown_table()
        return [Section("", [Head(table.title), table, notes])]

    def _shown_table(self) -> Table:
        """The table for terminal and page."""
        return self.table()


@dataclass(frozen=True, repr=False)
class LossMap(LossTable, Tabular):
    """Torque loss over pinion torque and speed at one oil temperature.

    Examples
    --------
    >>> import efficiency
    >>> from efficiency.vehicle.loss_map import SimpleAxleLosses
    >>> pair = efficiency.load("fm_spiral_bevel_14x39")
    >>> axle = SimpleAxleLosses(drag=1.5, load_share=0.005)
    >>> found = pair.loss_map("-200:200:3 N m", "500, 1500 rpm", axle=axle, grid=(4, 9))
    >>> found.shape
    (2, 3)
    """

    design: str
    friction_model: str
    oil: str
    temperature: float  # [K]
    points: tuple[LossPoint, ...] = field(repr=False)  # all combinations, sorted by speed, then torque
    # case and note; the first note describes the losses outside the mesh
    case_notes: tuple[tuple[str, str], ...] = field(default=(), repr=False)
    uses: frozenset[str] = field(default=frozenset(), repr=False)  # cited by `references`

    def references(self) -> set[str]:
        """Keys of the references of gear model, oil laws and friction model."""
        return set(self.uses)

    @property
    def speeds(self) -> FloatArray:
        """Pinion speeds, increasing [rad/s]."""
        return np.unique([point.speed for point in self.points])

    @property
    def torques(self) -> FloatArray:
        """Pinion torques, increasing [N m]."""
        return np.unique([point.torque for point in self.points])

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of speeds and torques."""
        return len(self.speeds), len(self.torques)

    def values(self, name: str = "torque_loss") -> FloatArray:
        """Values of one column, (speeds, torques); nan where a point failed."""
        return np.array([getattr(point, name) for point in self.points]).reshape(self.shape)

    def _dimensions(self) -> tuple[str, ...]:
        return "torque", "speed"

    def table(self) -> Table:
        """One row per point."""
        without = () if any(np.isfinite(p.torque_loss_upper) for p in self.points) else INTERVAL
        return Table.from_records(
            [{k: v for k, v in asdict(point).items() if k not in without} for point in self.points],
            title=f"{self.design}, {self.oil} at {quantity('temperature').text(self.temperature)}, "
            f"friction: {model_label(self.friction_model)}; torque loss",
            name="loss map",
        )

    def _shown_table(self) -> Table:
        """Without the state of converged points, and without the parts of the loss if it is that of the mesh alone."""
        hidden, table = [] if self.reason else ["status", "reason"], self.table()
        if not any(point.torque_loss_axle for point in self.points):
            hidden += ["torque_loss_mesh", "torque_loss_axle"]
        return table.select([name for name in table.names if name not in hidden])

    def to_dict(self) -> dict[str, Any]:
        """Points, conditions and notes in SI units, for JSON; nan becomes None."""
        names = ("design", "friction_model", "oil", "temperature", "status", "reason")
        about = {name: getattr(self, name) for name in names}
        return {**about, "points": finite_or_none(self.points), "notes": list(self.notes)}

    def __repr__(self) -> str:
        speeds, torques = self.shape
        return f"LossMap({self.design}, {self.friction_model}: {torques} torques, {speeds} speeds, {self.status})"

    def write_model(self, path: Path | str) -> Path:
        """Write the map for another program; the suffix selects the format.

        .vtlm: loss map of VECTO. .fmu: Functional Mock-up Unit (FMI 2.0). .mo: Modelica package with a
        `CombiTable2Ds` and a `lossTable` of `LossyGear`. .m: MATLAB script with the vectors of a lookup table in
        Simscape. Torques and speeds are those of the pinion. All formats except VECTO include the interval of the loss
        if the map has one.

        Returns the path.

        Raises `InputError`: an unknown suffix, too few torques or speeds, torques of one sign only for VECTO, a file
        that cannot be written; `ConvergenceError`: a point failed.
        """
        from efficiency.vehicle.map_files import FORMATS, check_axes

        path = Path(path)
        content = FORMATS.get(path.suffix.lower())
        if content is None:
            raise InputError("model", str(path), f"a file name ending in {', '.join(FORMATS)}")
        check_axes(path, self.torques, self.speeds)
        require_all(self.reason)
        write_file(path, content(self, path), "model")
        return path


def require_all(reason: str) -> None:
    """Raise a `ConvergenceError` for missing points, over which other programs would interpolate."""
    if reason:
        raise ConvergenceError("incomplete_map", f"{reason}: a map with missing points is not written")


def signed_axes(torque: Any, speed: Any) -> tuple[FloatArray, FloatArray]:
    """Unique, increasing pinion torques [N m] and speeds [rad/s] from lists, ranges or numbers."""
    torques, speeds = np.unique(axis_values("torque", torque, SIGNED["torque"])), np.unique(axis_values("speed", speed))
    check_size({"torque": torques, "speed": speeds})
    return torques, speeds


def solve_loss_map(
    torques: FloatArray,
    speeds: FloatArray,
    temperature: float,
    evaluator: Evaluator,
    axle: AxleLosses | None = None,
    **about: Any,
) -> LossMap:
    """Torque loss at all combinations of torque and speed.

    torques, speeds (m,): increasing [N m], [rad/s]; the mesh loss is zero at zero torque.
    temperature: oil temperature [K].
    evaluator: evaluates the efficiency at many conditions, with the interval if requested.
    axle: losses outside the mesh; its table must cover all points.
    **about: `design`, `friction_model`, `oil` of the map.
    """
    # evaluated first: a table that does not cover a point raises before the meshes are solved
    losses_axle = {(t, w): axle.torque_loss(t, w) if axle else 0.0 for t in torques for w in speeds}
    # sorted by torque, because points of equal torque share geometry and load
    places = [(t, w) for t in sorted(torques, key=lambda t: (t < 0.0, t)) if t != 0.0 for w in speeds]
    rows = [DutyRow(float(t), float(w), temperature, 1.0) for t, w in places]
    solved = dict(zip(places, evaluator.points([row.condition for row in rows]), strict=True))
    points = tuple(
        _point(float(t), float(w), losses_axle[t, w], None if t == 0.0 else solved[t, w], evaluator.interval)
        for w in speeds
        for t in torques
    )
    notes, uses = _case_notes(solved.values(), axle, about["friction_model"]), uses_of(solved.values())
    return LossMap(temperature=temperature, points=points, case_notes=notes, uses=uses, **about)


def uses_of(points: Iterable[GridPoint]) -> frozenset[str]:
    """Keys of the references of the results at some points."""
    return frozenset().union(*(point.result.references() for point in points if point.result is not None))


def _case_notes(points: Iterable[GridPoint], axle: AxleLosses | None, model: str) -> tuple[tuple[str, str], ...]:
    first, found = MESH_ALONE if axle is None else axle.description, []
    for point in points:
        outside = "" if point.reason else outside_note(point.figure("outside_range_share"), model_label(model))
        at = point.condition if point.result is None else vars(point.result.conditions)
        torque = at["torque"] if at["driver"] == "pinion" else -at["torque"]  # negative in coast
        place = f"{quantity('torque').text(torque)}, {quantity('speed').text(at['speed'])}"
        failed = "no result: " * (point.result is None)
        found += [(place, failed + note) for note in (*point.notes, outside) if note]
    return (("", first), *found)


def _point(torque: float, speed: float, loss_axle: float, point: GridPoint | None, interval: bool) -> LossPoint:
    if point is None:
        ends = [loss_axle, loss_axle] if interval else []
        return LossPoint(torque, speed, loss_axle, 0.0, loss_axle, 0.0, "converged", "", *ends)
    result = point.result
    if result is None or point.reason:
        return LossPoint(torque, speed, math.nan, math.nan, loss_axle, math.nan, "failed", point.reason)
    mesh = (result.power_loss + result.power_loss_rolling) / speed
    ends = [loss_axle + end / speed for end in result.loss_interval] if interval else []
    total, outside = mesh + loss_axle, result.outside_range_share
    return LossPoint(torque, speed, total, mesh, loss_axle, outside, point.status, "", *ends)
