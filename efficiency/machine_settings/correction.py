"""Machine corrections from measured flanks: changes of settings that bring the next part to nominal.

The machine is assumed to be repeatable: a part cut with settings ``p + c`` deviates by ``deviation + J c``, with the
normal displacement ``J`` of the flank by each setting (exact derivatives of the cutting simulation). The corrections
minimise this deviation by least squares, weighted by the measurement uncertainty, together with the root line of a
generated member; rotation of the part about its axis is free. A setting that the points hardly determine stays near its
value: ten natural steps have the weight of the measurement uncertainty of a point (this work).

First-order settings correct pressure and spiral angle, second-order settings also crowning and twist.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import nan
from pathlib import Path
from typing import Any, Literal

import numpy as np

from efficiency.contact.gear_flanks import Member
from efficiency.contact.grid_flank import PointGrid, read_point_grid
from efficiency.contact.measured_flank import MeasuredFlank, measured_flank
from efficiency.cutting.cutter import FLANK_SIDES, FlankSide
from efficiency.cutting.flank import CutFlank, FlankPoints
from efficiency.cutting.machine import ANGLE_STEP, LENGTH_STEP, MachineSettings
from efficiency.design.design import Design, MemberInput, load_design
from efficiency.machine_settings.design_file import machine_tables
from efficiency.machine_settings.fit import FitParameter, RootLine, motion, with_setting
from ehl.common.arrays import FloatArray, finite_or_none
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.pages import Reportable
from ehl.common.quantities import quantity
from ehl.common.sections import Head, Medium, Section
from ehl.common.table import Column, Table
from ehl.common.threads import one_thread
from ehl.common.units import parse_quantity

Order = Literal[1, 2]

# settings of every machine and their natural steps
_LENGTHS = ("radial_setting", "sliding_base", "blank_offset", "machine_centre_to_back")
_FIRST = {"machine_root_angle": ANGLE_STEP, **dict.fromkeys(_LENGTHS, LENGTH_STEP)}
_SECOND = {"tilt": ANGLE_STEP, "swivel": ANGLE_STEP}
# natural steps equal to one standard deviation of a point, standard deviation of the root [m], Newton iterations
_STEPS, _ROOT, _ITERATIONS = 10.0, 20e-6, 3


@dataclass(frozen=True)
class SettingCorrection:
    """Change of one setting, in SI units."""

    setting: str  # its name in a design file
    flanks: str  # flank of the setting: ``"concave"``, ``"convex"`` or ``"both"``
    # previous value, change, new value
    nominal: float
    change: float
    corrected: float
    uncertainty: float  # standard uncertainty of the change from that of the points


@dataclass(frozen=True)
class InspectionDeviation:
    """Deviation of one flank from nominal in terms of flank inspection; positive is excess material [m]."""

    flank: str  # ``"concave"`` or ``"convex"``
    part: str  # ``"measured"``, or ``"expected"`` after the corrections
    # deviation of the points without its mean
    deviation_rms: float
    deviation_max: float
    # slope along the face to the heel, and over the depth to the tip [rad]
    spiral_angle_error: float
    pressure_angle_error: float
    # material at both ends of the face, at root and tip, at the corners heel-tip and toe-root, relative to the middle
    lengthwise_crowning: float
    profile_crowning: float
    twist: float


@dataclass(frozen=True, repr=False)
class MachineCorrections(Reportable):
    """Corrections of the machine settings of one member."""

    design: str  # name of the design
    member: Member  # ``"pinion"`` or ``"gear"``
    corrections: tuple[SettingCorrection, ...]  # changes of the settings
    deviations: tuple[InspectionDeviation, ...]  # measured and expected deviation of each flank
    text: str  # tables of the corrected settings in the format of a design file
    notes: tuple[str, ...]  # notes on the corrections

    def sections(self, medium: Medium = "page", *args: Any, **options: Any) -> list[Section]:
        """New settings of the machine, and the deviations before and after correction."""
        tables = []
        for flanks in dict.fromkeys(item.flanks for item in self.corrections):
            own = [item for item in self.corrections if item.flanks == flanks]
            parts = {"change": "change", "uncertainty": "uncertainty", "before": "nominal", "to set": "corrected"}
            rows = [(part, *(getattr(item, name) for item in own)) for part, name in parts.items()]
            of = "both flanks" if flanks == "both" else f"{flanks} flank"
            settings = (
                Column(i.setting, label=i.setting.replace("_", " "), decimals=_decimals(i.setting)) for i in own
            )
            title = f"{self.design}, {self.member}, {of}: machine corrections"
            tables.append(Table(["setting", *settings], rows, title, name=f"corrections_{flanks}", vertical=True))
        fields = (
            *("deviation_rms", "deviation_max", "spiral_angle_error", "pressure_angle_error"),
            *("lengthwise_crowning", "profile_crowning", "twist"),
        )
        heads: list[Column | str] = [
            "flank",
            *(Column(name, label=name.replace("_", " "), decimals=2) for name in fields),
        ]
        rows = [(f"{d.flank}, {d.part}", *(getattr(d, name) for name in fields)) for d in self.deviations]
        title = "Deviation from nominal, positive for excess material"
        deviations = Table(heads, rows, title, self.notes, name="deviations", vertical=True)
        head = Head(f"Machine corrections: {self.design}, {self.member}")
        return [Section("", [head, *tables, deviations])]

    def __repr__(self) -> str:
        before, after = (
            max((d.deviation_rms for d in self.deviations if d.part == part), default=nan)
            for part in ("measured", "expected")
        )
        return (
            f"MachineCorrections({self.design!r}, {self.member}: {len(self.corrections)} settings, deviation RMS "
            f"{before:.3g} -> {after:.3g} m)"
        )

    def to_dict(self) -> dict[str, Any]:
        """Content with numbers in SI units."""
        plain: dict[str, Any] = finite_or_none(self)
        del plain["text"]
        return plain


def _decimals(setting: str) -> int:
    """Decimals of a setting in its display unit: 0.1 um, 0.36 arcsec, 1e-6."""
    return 4 if quantity(setting).display in ("mm", "deg") else 6


@dataclass(frozen=True)
class _Side:
    """One measured flank: nominal flank and deviation at its points."""

    side: FlankSide
    nominal: CutFlank
    measured: MeasuredFlank
    u: FloatArray
    h: FloatArray
    points: FlankPoints  # of the nominal flank
    root: RootLine | None

    def change(self, corrected: CutFlank) -> FloatArray:
        """Displacement of the flank along its normal by corrected settings [m]."""
        points, found = corrected.solve(self.u, self.h)
        if not found.all():
            raise ConvergenceError("undercut", f"the corrected {self.side} flank does not reach all measured points")
        turned = points.azimuth - self.points.azimuth
        return np.asarray(np.angle(np.exp(1j * turned)) * self.points.lever)


@one_thread
def machine_corrections(
    design: Design | Path | str,
    grids: Sequence[Path | str] | Path | str,
    uncertainty: float | str = 1e-6,
    order: Order = 2,
) -> MachineCorrections:
    """Machine corrections of one member from measured points of its flanks.

    Parameters
    ----------
    design : Design, Path or str
        Design with the settings of the part.
    grids : path, or sequence of paths
        Points of one or both flanks; their first lines name member and flank, see `export`.
    uncertainty : float or str
        Standard uncertainty of one point along the normal [m].
    order : {1, 2}
        1: settings for pressure and spiral angle; 2: also for crowning and twist.

    Returns
    -------
    MachineCorrections

    Raises
    ------
    InputError
        A file does not belong to a flank with machine settings, or a value is out of range.
    ConvergenceError
        The corrected flank does not reach the measured points.

    Examples
    --------
    >>> import efficiency
    >>> pair = efficiency.load("fm_spiral_bevel_14x39")
    >>> written = pair.export("measured", what=["grid"], members=("pinion",), rows=9, columns=15, margin=0.05)
    >>> found = efficiency.machine_corrections("fm_spiral_bevel_14x39", "measured/pinion_concave.csv")
    >>> found.deviations[0].deviation_rms < 1e-8
    True
    """
    pair = design if isinstance(design, Design) else load_design(design)
    error = parse_quantity(uncertainty, "m", field="uncertainty")
    if not 1e-8 <= error <= 1e-4:
        raise InputError("uncertainty", f"{error * 1e6:.4g} um", "0.01 to 100 um")
    if order not in (1, 2):
        raise InputError("order", order, "1 or 2")
    read = [read_point_grid(Path(path)) for path in ([grids] if isinstance(grids, (str, Path)) else grids)]
    member = _one_member(read)
    sides = [_side(pair, member, grid, error) for grid in read]
    shared = len({item.nominal.machine for item in sides}) == 1 and getattr(pair, member).completing
    machine = sides[0].nominal.machine
    steps = _FIRST | dict(machine.generation.first_order)
    if order == 2:
        steps = steps | _SECOND | dict(machine.generation.second_order)
    if machine.tilt == 0.0:
        steps.pop("swivel", None)  # without tilt the swivel has no effect
    parameters = [FitParameter("machine", name, scale) for name, scale in steps.items()]
    # columns: common or separate settings of the flanks; a rotation of each flank
    groups: list[tuple[str, list[_Side]]] = [("both", sides)] if shared else [(item.side, [item]) for item in sides]
    rows, deviations = [], []
    corrected: dict[FlankSide, MachineSettings] = {}
    for name, group in groups:
        vector, uncertainties, expected = _solve(group, parameters, error)
        for parameter, step, sigma in zip(parameters, vector, uncertainties, strict=True):
            value = float(getattr(group[0].nominal.machine, parameter.name))
            change = float(step) * parameter.scale
            sigma = float(sigma) * parameter.scale
            rows.append(SettingCorrection(parameter.name, name, value, change, value + change, sigma))
        for item in group:
            corrected[item.side] = _corrected(item.nominal, parameters, vector).machine
            deviations.append(_deviation(item, "measured", item.measured.deviation))
            deviations.append(_deviation(item, "expected", expected[item.side]))
    settings = machine_tables(member, corrected)
    notes = _notes(pair, member, sides, order)
    return MachineCorrections(pair.name, member, tuple(rows), tuple(deviations), settings, notes)


def _one_member(grids: Sequence[PointGrid]) -> Member:
    if not grids:
        raise InputError("grids", "no file", "one or two files of points")
    members = {grid.member for grid in grids}
    flanks = [grid.flank for grid in grids]
    if members not in ({"pinion"}, {"gear"}):
        raise InputError(
            "grids",
            ", ".join(f"{grid.path}: member={grid.member or 'not stated'}" for grid in grids),
            "files of one member, pinion or gear, named in their first lines",
        )
    if len(set(flanks)) < len(flanks) or not set(flanks) <= set(FLANK_SIDES):
        raise InputError("grids", f"flank={', '.join(flank or 'not stated' for flank in flanks)}", "concave, convex")
    return "pinion" if "pinion" in members else "gear"


def _side(design: Design, member: Member, grid: PointGrid, error: float) -> _Side:
    own: MemberInput = getattr(design, member)
    side: FlankSide = "concave" if grid.flank == "concave" else "convex"
    cut, blank = getattr(own, side).nominal, own.blank
    if cut is None:
        stated = f"{design.name}: {member}.{side} without machine settings"
        raise InputError("design", stated, "a flank cut by cutter and machine")
    flank = cut.flank(side, blank)
    measured = measured_flank(grid, side, blank, error, flank)
    u = 0.5 * blank.face_width * measured.place[0]
    h = blank.height(u, 0.5 * (measured.place[1] + 1.0))
    points, _ = flank.solve(u, h)
    root = None
    if flank.machine.generation.rolls:
        stations = np.array([-0.4, 0.0, 0.4]) * blank.face_width
        line = RootLine.of_blank(blank, stations, 1.0, u, h, points.parameters)
        state = line.cut(flank)
        if np.isfinite(state.error).all():
            # the root is to keep its height
            root = replace(line, height=line.height + state.error)
    return _Side(side, flank, measured, u, h, points, root)


def _corrected(flank: CutFlank, parameters: Sequence[FitParameter], vector: FloatArray) -> CutFlank:
    for parameter, step in zip(parameters, vector, strict=True):
        value = getattr(flank.machine, parameter.name) + float(step) * parameter.scale
        flank = with_setting(flank, parameter, value)
    return flank


def _solve(
    group: Sequence[_Side], parameters: Sequence[FitParameter], error: float
) -> tuple[FloatArray, FloatArray, dict[FlankSide, FloatArray]]:
    """Steps of the settings, their standard uncertainties, and the remaining deviation of each flank [m]."""
    count = len(parameters)
    blocks: list[FloatArray] = []
    for k, item in enumerate(group):
        sigma = max(error, item.measured.scatter)
        columns, roots = [], []
        state = None if item.root is None else item.root.cut(item.nominal)
        for parameter in parameters:
            way, root = motion(item.nominal, parameter, item.points.normal, item.points.parameters, state)
            columns.append(way * parameter.scale / sigma)
            if state is not None:
                roots.append(root * parameter.scale / _ROOT)
        block = np.zeros((item.u.size, count + len(group)))
        block[:, :count] = np.stack(columns, axis=1)
        block[:, count + k] = item.points.lever / sigma
        blocks.append(block)
        if roots:
            rows = np.zeros((3, count + len(group)))
            rows[:, :count] = np.stack(roots, axis=1)
            blocks.append(rows)
    held = np.zeros((count, count + len(group)))
    held[:, :count] = np.eye(count) / _STEPS
    matrix = np.concatenate([*blocks, held])
    inverse = np.linalg.pinv(matrix, rcond=1e-12)
    vector = np.zeros(count)
    rest: dict[FlankSide, FloatArray] = {}
    for _ in range(_ITERATIONS + 1):
        values: list[FloatArray] = []
        for item in group:
            now = _corrected(item.nominal, parameters, vector)
            left = item.measured.deviation + item.change(now)
            rest[item.side] = left
            values.append(left / max(error, item.measured.scatter))
            if item.root is not None:
                values.append(item.root.cut(now).error / _ROOT)
        step = inverse @ np.concatenate([*values, vector / _STEPS])
        if len(rest) and np.abs(step[:count]).max() < 1e-6:
            break
        vector = vector - step[:count]
    return vector, np.sqrt(np.diag(inverse @ inverse.T))[:count], rest


def _deviation(item: _Side, part: str, values: FloatArray) -> InspectionDeviation:
    (x, y), lever = item.measured.place, item.points.lever
    terms = np.stack([np.ones_like(x), x, y, x * x, y * y, x * y, lever / np.abs(lever).mean()], axis=1)
    # a rotation about the axis is not a deviation of form
    left = values - terms[:, [-1]] @ np.linalg.lstsq(terms[:, [-1]], values, rcond=None)[0]
    found = np.linalg.lstsq(terms[:, :6], left, rcond=None)[0]
    blank = item.nominal.blank
    depth = blank.mean_addendum + blank.mean_dedendum
    return InspectionDeviation(
        item.side,
        part,
        float(np.sqrt(np.mean(left**2))),
        float(np.abs(left).max()),
        float(2.0 * found[1] / blank.face_width),
        float(2.0 * found[2] / depth),
        *(float(value) for value in found[3:6]),
    )


def _notes(design: Design, member: Member, sides: Sequence[_Side], order: Order) -> tuple[str, ...]:
    notes = [f"{member} {item.side}: {item.measured.note}" for item in sides]
    if getattr(design, member).completing and len(sides) == 1:
        notes.append(f"one machine setting cuts both flanks of this {member}: the other flank changes too; measure it")
    if order == 1:
        notes.append("first-order settings do not change crowning and twist")
    if note := sides[0].nominal.machine.generation.correction_note:
        notes.append(note)
    notes.append("the tooth thickness is not constrained: keep it by the depth of cut or the point width")
    return tuple(notes)
