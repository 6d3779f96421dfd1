"""A parameter study as tables, files and one HTML page for print."""

from __future__ import annotations

import platform
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING

from efficiency.output.tables import percent
from efficiency.studies.parameter_study import MISALIGNED, StudyPoint, level_quantity
from efficiency.studies.plots import reference_text, study_figures
from ehl import __version__
from ehl.quantities import quantities
from ehl.view.html_report import Block, KeyFigures, Picture, Section, Text, write_report
from ehl.view.plots import save_figures
from ehl.view.table import Column, Table, write_csv, write_xlsx

if TYPE_CHECKING:
    from efficiency.studies.parameter_study import Study

_FAILED_SHOWN = 40
_SECTION = (
    "efficiency",
    "efficiency_lower",
    "efficiency_upper",
    "power_loss",
    "friction_coefficient_mean",
    "film_ratio",
    "pressure_max",
    "status",
    "reason",
)


def _column(name: str) -> Column:
    """A field of a study point."""
    return Column(name, of=level_quantity(name).name if name in quantities() or name in MISALIGNED else "")


def study_tables(study: Study) -> list[Table]:
    """Every point, the levels and the notes."""
    names = [f.name for f in fields(StudyPoint)]
    points = [[getattr(point, name) for name in names] for point in study.points]
    levels = [
        (name, level_quantity(name).unit, ", ".join(f"{value:.6g}" for value in values), study.reference.get(name, 0.0))
        for name, values in study.levels.to_dict().items()
    ]
    return [
        Table([_column(name) for name in names], points, name="study"),
        Table(("parameter", "SI unit", "values", Column("reference", label="reference")), levels, name="levels"),
        Table(("note", "points"), list(study.notes.items()), name="notes"),
    ]


def section_table(study: Study, design: str, name: str) -> Table:
    """The section of one design along one parameter."""
    columns = (name, *_SECTION)
    return Table(
        [_column(column) for column in columns],
        [[getattr(point, column) for column in columns] for point in study.section(design, name)],
        title=f"{design}: {level_quantity(name).label}, at {reference_text(study, name)}.",
    )


def influence_table(study: Study) -> Table:
    """For each parameter its range, and for each design the range of the efficiency and its width."""
    columns: list[Column | str] = ["parameter", "levels"]
    for design in study.designs:
        columns += [Column(f"{design}: {end}", "efficiency", f"{design}, {end}") for end in ("minimum", "maximum")]
    rows: list[tuple[object, ...]] = []
    at = [study.reference_point(design).efficiency for design in study.designs]
    rows.append(("reference", reference_text(study), *(value for value in at for _ in range(2))))
    for name in study.varied:
        levels = sorted({*getattr(study.levels, name), *((0.0,) if name in MISALIGNED else ())})
        ends = [end for design in study.designs for end in study.influence(design, name)]
        rows.append((level_quantity(name).label, level_quantity(name).span(levels[0], levels[-1]), *ends))
    notes = [f"note     {count} of {len(study.points)} points: {note}" for note, count in list(study.notes.items())[:8]]
    notes += [f"failed   {point.label}: {point.reason}" for point in study.failed[:_FAILED_SHOWN]]
    return Table(
        columns,
        rows,
        title=f"efficiency over each parameter alone, friction {study.friction_model}, {study.side}, {study.oil}",
        notes=(*notes, timing(study)),
        name="influence",
    )


def timing(study: Study) -> str:
    """How many points in what time."""
    again = f", {study.reused} of them computed before" if study.reused else ""
    workers = "process" if study.jobs == 1 else "processes"
    return f"{study.status}: {len(study.points)} points{again}, {study.seconds:.1f} s with {study.jobs} {workers}"


def write_study(study: Study, folder: Path) -> list[Path]:
    """`study.html`, `study.xlsx`, `study.csv` and the figures as PNG files.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    tables = study_tables(study)
    written = write_csv(folder, tables[:1])
    written.append(write_xlsx(folder / "study.xlsx", tables, f"parameter study: {', '.join(study.designs)}"))
    figures = list(study_figures(study))
    save_figures(figures, folder)
    sections = [_headline(study), Section("1. Influence of each parameter", [influence_table(study)])]
    pictures: list[Block] = [Picture(figure, caption) for _, figure, caption in figures]
    sections.append(Section("2. Figures", pictures))
    lines = [section_table(study, design, name) for name in study.varied for design in study.designs]
    sections.append(Section("3. Sections through the reference", lines))
    sections.append(Section("4. Notes", _notes(study)))
    page = write_report(
        folder / "study.html",
        "Parameter study: mesh efficiency",
        f"{', '.join(study.designs)}; {study.side} side, {study.oil}, friction {study.friction_model}",
        sections,
        f"mixed-ehl {__version__}, Python {platform.python_version()}. {timing(study).capitalize()}. Churning, windage "
        "and bearing losses are not part of any figure here.",
    )
    return [page, *written]


def _with_interval(point: StudyPoint) -> str:
    ends = f"{percent(point.efficiency_lower, 2)} to {percent(point.efficiency_upper, 2)}"
    return f"{percent(point.efficiency, 2)} % ({ends})"


def _headline(study: Study) -> Section:
    figures = [
        (
            _with_interval(point),
            f"{point.design}, offset {1e3 * point.hypoid_offset:.4g} mm; 90 % interval by the inputs",
        )
        for point in map(study.reference_point, study.designs)
    ]
    text = (
        f"Mesh efficiency at the reference: {reference_text(study)}. Every operating point is a combination of the "
        "levels of torque, speed, temperature and roughness for the aligned pair; misalignments are varied one at a "
        "time at the reference. The load is solved once for each torque and misalignment."
    )
    return Section("", [KeyFigures(figures), Text(text)])


def _notes(study: Study) -> list[Block]:
    blocks: list[Block] = []
    if study.failed:
        rows = [(point.label, point.reason) for point in study.failed]
        blocks.append(Table(("point that failed", "reason"), rows))
    if study.notes:
        rows = [(note, f"{count} of {len(study.points)}") for note, count in study.notes.items()]
        blocks.append(Table(("note", "points"), rows))
    outside = max((point.outside_range_share for point in study.points if point.status != "failed"), default=0.0)
    if outside > 0.0:
        blocks.append(
            Text(
                f"Up to {percent(outside, 1)} % of the sliding power of a point lies outside the stated range of "
                f"{study.friction_model}; the column outside_range_share of the files says where."
            )
        )
    return blocks or [Text("None.")]
