"""Report sections of a parameter study."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from efficiency.loss.efficiency_result import pair_notes
from efficiency.output.gear_report import SPIN
from efficiency.output.notes import outside_note
from efficiency.output.tables import percent
from efficiency.studies.parameter_study import MISALIGNED, StudyPoint, level_quantity
from efficiency.studies.plots import causes_of, influence_figure, reference_text, span_text, study_figures
from ehl.common.notes import Note
from ehl.common.quantities import quantities
from ehl.common.sections import Head, Item, KeyFigures, MainResult, Medium, Notes, Section, Text
from ehl.common.table import Column, Table
from regression.friction.published_registry import model_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from efficiency.studies.parameter_study import Study

_FAILED_SHOWN = 40
_OUTCOME = ("status", "reason")
_SECTION = (
    *("efficiency", "efficiency_lower", "efficiency_upper", "power_loss", "friction_coefficient_mean"),
    *("film_ratio", "pressure_max", *_OUTCOME),
)


def _column(name: str) -> Column:
    """Column of a field of a study point."""
    return Column(name, of=level_quantity(name).name if name in quantities() or name in MISALIGNED else "")


def study_tables(study: Study) -> list[Table]:
    """All points, the levels and the notes."""
    points = Table.from_records([point.scalars() for point in study.points]).records()
    levels = [
        (name, level_quantity(name).unit, ", ".join(f"{value:.6g}" for value in values), study.reference.get(name, 0.0))
        for name, values in study.levels.to_dict().items()
    ]
    return [
        Table([_column(name) for name in points[0]], [tuple(point.values()) for point in points], name="study"),
        Table(("parameter", "SI unit", "values", Column("reference", label="reference")), levels, name="levels"),
        Table(("note", "points"), list(study.notes.items()), name="notes"),
    ]


def section_table(study: Study, design: str, name: str) -> Table:
    """The section of one design along one parameter."""
    columns = (name, *(_SECTION if study.failed else _SECTION[: -len(_OUTCOME)]))
    return Table(
        [_column(column) for column in columns],
        [[getattr(point, column) for column in columns] for point in study.section(design, name)],
        title=f"{design}: {level_quantity(name).label}, at {reference_text(study, name)}.",
    )


def influence_table(study: Study) -> Table:
    """Levels of each parameter, and minimum and maximum efficiency of each design."""
    columns: list[Column | str] = ["parameter", "levels"]
    for design in study.designs:
        columns += [Column(f"{design}: {end}", "efficiency", f"{design}, {end}") for end in ("minimum", "maximum")]
    rows: list[tuple[object, ...]] = []
    at = [study.reference_point(design).efficiency for design in study.designs]
    rows.append(("reference", reference_text(study), *(value for value in at for _ in range(2))))
    for name in study.varied:
        ends = [end for design in study.designs for end in study.influence(design, name)]
        rows.append((level_quantity(name).label, span_text(study, name), *ends))
    model = model_label(study.friction_model)
    failed = (f"failed   {point.label}: {point.reason}" for point in study.failed[:_FAILED_SHOWN])
    return Table(
        columns,
        rows,
        title=f"efficiency over each single parameter, {study.side}, {study.oil}, friction: {model}",
        notes=(*failed, timing(study)),
        name="influence",
    )


def study_notes(study: Study) -> list[Note]:
    """Notes on all points, one for each kind with its count and worst point, the most severe first."""
    said = []
    for point in study.points:
        said += [(point.label, note) for note in point.notes]
        if point.status == "failed":
            said.append((point.label, f"no result: {point.reason}"))
        elif outside := outside_note(point.outside_range_share, model_label(study.friction_model)):
            said.append((point.label, outside))
    return pair_notes(said)


def timing(study: Study) -> str:
    """Status, number of points and wall time."""
    again = f", {study.reused} of them from an earlier run" if study.reused else ""
    workers = "process" if study.jobs == 1 else "processes"
    return f"{study.status}: {len(study.points)} points{again}, {study.seconds:.1f} s with {study.jobs} {workers}"


def study_sections(study: Study, medium: Medium) -> list[Section]:
    """Sections of a study: influence of each parameter, uncertainty, efficiency over the parameters, all points."""
    title = f"parameter study: {', '.join(study.designs)}"
    if medium == "files":
        return [Section("", [Head(title), *study_tables(study)])]
    if medium == "terminal":
        return [Section("", [influence_table(study), Notes(study_notes(study), len(study.points))])]
    pictures = {picture.name: picture for picture in study_figures(study)}
    influence, causes = pictures.pop("influence"), pictures.pop("causes", None)
    head = Head(
        "Parameter study: mesh efficiency",
        f"{', '.join(study.designs)}; {study.side} side, {study.oil}, friction: {model_label(study.friction_model)}",
        f"{timing(study).capitalize()}. {SPIN}",
    )
    cuts = [section_table(study, design, name) for name in study.varied for design in study.designs]
    model = model_label(study.friction_model)
    certain = f"The friction model ({model}) has no uncertain inputs and therefore no interval."
    return [
        Section("", [head, *_headline(study)]),
        Section("Influence of each parameter", [influence, replace(influence_table(study), title="", notes=())]),
        Section("Sources of uncertainty", [causes, causes_table(study)] if causes else [Text(certain)]),
        Section("Efficiency over the parameters", list(pictures.values())),
        Section("Sections through the reference", cuts),
        Section("Method", _computed(study)),
    ]


def plot_study(study: Study, ax: Axes | None) -> Axes:
    """Range of the efficiency over each single parameter."""
    return influence_figure(study, ax)


def causes_table(study: Study) -> Table:
    """Half width of the interval of the efficiency from each cause of uncertainty, at the reference of each design."""
    points = [study.reference_point(design) for design in study.designs]
    columns: list[Column | str] = ["cause", *(Column(p.design, of="efficiency_error", label=p.design) for p in points)]
    rows = [(cause, *(p.causes.get(cause, 0.0) for p in points)) for cause in causes_of(study)]
    title = "Half width of the efficiency from each single cause, in percentage points; combine as root sum of squares."
    return Table(columns, rows, title=title, name="causes")


def _headline(study: Study) -> list[Item]:
    points = [study.reference_point(design) for design in study.designs]
    first = points[0]
    tiles = [
        (f"{percent(p.efficiency, 2)} %", f"{p.design}, {_interval(p)}, offset {1e3 * p.hypoid_offset:.4g} mm")
        for p in points[1:10]
    ]
    widths = [(name, *study.influence(first.design, name)) for name in study.varied]
    widths = sorted((w for w in widths if math.isfinite(w[1])), key=lambda w: w[1] - w[2])
    tiles += [
        (f"{percent(high - low, 2)} points", f"range over {level_quantity(name).label}, {span_text(study, name)}")
        for name, low, high in widths[:4]
    ]
    known = []
    if first.efficiency_lower < first.efficiency_upper:
        known.append((_interval(first), "90 % interval from uncertain inputs"))
    if math.isfinite(first.efficiency_error):
        known.append((f"±\N{NO-BREAK SPACE}{100.0 * first.efficiency_error:.1g} %", "numerical error"))
    ends = [point.efficiency for point in study.points if math.isfinite(point.efficiency)]
    if ends:
        span = f"{percent(min(ends), 2)} to {percent(max(ends), 2)} %"
        known.append((span, f"range of all {len(study.points)} points"))
    value = f"{percent(first.efficiency, 2)} %" if math.isfinite(first.efficiency) else "no result"
    answer = MainResult(value, f"mesh efficiency of {first.design} at {reference_text(study)}", known)
    notes = Notes(study_notes(study), len(study.points))
    return [answer, *([KeyFigures(tiles)] if tiles else []), notes]


def _interval(point: StudyPoint) -> str:
    return f"{percent(point.efficiency_lower, 2)} to {percent(point.efficiency_upper, 2)} %"


def _computed(study: Study) -> list[Item]:
    blocks: list[Item] = [
        Text(
            "Every operating point is a combination of the levels of torque, speed, temperature and roughness for the "
            "aligned pair; misalignments are varied one at a time at the reference. The load is solved once for each "
            "torque and misalignment. All points are in study.csv and study.xlsx."
        )
    ]
    if study.failed:
        rows = [(point.label, point.reason) for point in study.failed]
        blocks.append(Table(("failed point", "reason"), rows))
    return blocks
