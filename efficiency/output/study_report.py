"""A parameter study as tables, files and one HTML page for print."""

from __future__ import annotations

import platform
from dataclasses import asdict, fields
from pathlib import Path
from typing import TYPE_CHECKING

from efficiency.output.data_tables import Cell, DataTable
from efficiency.output.plots_study import SHOWN, axis_label, level_text, reference_text, shown, study_figures
from efficiency.output.table_files import write_csv, write_xlsx
from efficiency.output.tables import percent
from efficiency.study.levels import MISALIGNED
from efficiency.study.points import UNITS, StudyPoint
from ehl import __version__
from ehl.view.html_report import Block, KeyFigures, Picture, Section, Text, write_report
from ehl.view.plots import save_figure
from ehl.view.table import Table

if TYPE_CHECKING:
    from efficiency.study.points import Study

_FAILED_SHOWN = 40
HEADER = ("value", "efficiency [%]", "interval [%]", "loss [W]", "mean mu [-]", "mean λ [-]", "pressure [GPa]")


def study_tables(study: Study) -> list[DataTable]:
    """Every point, the levels and the notes as tables in SI units."""
    columns = {f.name: [getattr(point, f.name) for point in study.points] for f in fields(StudyPoint)}
    rows: list[tuple[Cell, ...]] = [
        (name, UNITS[name], ", ".join(f"{value:.6g}" for value in values), study.reference.get(name, 0.0))
        for name, values in study.levels.to_dict().items()
    ]
    return [
        DataTable.of_columns("study", columns, UNITS),
        DataTable("levels", ("parameter", "unit", "values", "reference"), rows),
        DataTable("notes", ("note", "points"), list(study.notes.items())),
    ]


def section_rows(study: Study, design: str, name: str) -> list[tuple[str, ...]]:
    """Cells of the section of one design along one parameter."""
    rows = []
    for point in study.section(design, name):
        interval = "–"
        if point.efficiency_lower < point.efficiency_upper:
            interval = f"{percent(point.efficiency_lower, 2)}–{percent(point.efficiency_upper, 2)}"
        numbers = (f"{point.power_loss:.1f}", f"{point.friction_coefficient_mean:.4f}", f"{point.film_ratio:.3g}")
        rows.append(
            (
                f"{shown(name, getattr(point, name)):.4g}",
                percent(point.efficiency) if point.status != "failed" else f"failed: {point.reason}",
                interval,
                *(text if text != "nan" else "–" for text in (*numbers, f"{point.pressure_max / 1e9:.3f}")),
            )
        )
    return rows


def influence_rows(study: Study) -> list[tuple[str, ...]]:
    """(parameter, range, and for each design the range of the efficiency and its width in percentage points)."""
    rows = []
    for name in study.varied:
        levels = sorted({*getattr(study.levels, name), *((0.0,) if name in MISALIGNED else ())})
        cells = []
        for design in study.designs:
            low, high = study.influence(design, name)
            cells.append(f"{percent(low, 2)}–{percent(high, 2)} ({100.0 * (high - low):.2f})" if low == low else "–")
        rows.append((SHOWN[name][0], f"{shown(name, levels[0]):.4g} to {level_text(name, levels[-1])}", *cells))
    return rows


def print_study(study: Study) -> None:
    """Print the reference, the influence of each parameter, what failed, and the time."""
    from rich import box
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table as Printed

    console = Console()
    table = Printed(
        title=f"efficiency [%] over each parameter alone (width in points), friction {study.friction_model}, "
        f"{study.side}; reference {reference_text(study)}, {study.oil}",
        box=box.SIMPLE,
        padding=(0, 1, 0, 0),
        title_justify="left",
    )
    for name in ("parameter", "from, to", *study.designs):
        table.add_column(escape(name), overflow="fold")
    at = [percent(study.reference_point(design).efficiency) for design in study.designs]
    table.add_row("reference", "", *at)
    for row in influence_rows(study):
        table.add_row(*row)
    console.print(table)
    for note, count in list(study.notes.items())[:8]:
        console.print(f"note     {count} of {len(study.points)} points: {note}", highlight=False)
    for point in study.failed[:_FAILED_SHOWN]:
        console.print(f"failed   {point.label}: {point.reason}", highlight=False)
    console.print(timing(study), highlight=False)


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
    for name, figure, _ in figures:
        save_figure(figure, folder / f"{name}.png")
    sections = [_headline(study), Section("1. Influence of each parameter", _influence(study))]
    pictures: list[Block] = [Picture(figure, caption) for _, figure, caption in figures]
    sections.append(Section("2. Figures", pictures))
    sections.append(Section("3. Sections through the reference", _section_tables(study)))
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


def _headline(study: Study) -> Section:
    figures = [
        (f"{percent(point.efficiency, 2)} %", f"{point.design}, offset {1e3 * point.hypoid_offset:.4g} mm")
        for point in map(study.reference_point, study.designs)
    ]
    text = (
        f"Mesh efficiency at the reference: {reference_text(study)}. Every operating point is a combination of the "
        "levels of torque, speed, temperature and roughness for the aligned pair; misalignments are varied one at a "
        "time at the reference. The load is solved once for each torque and misalignment."
    )
    return Section("", [KeyFigures(figures), Text(text)])


def _influence(study: Study) -> list[Block]:
    header = ("parameter", "levels", *study.designs)
    caption = "Efficiency from least to greatest [%], and between both [percentage points]."
    return [Table(header, influence_rows(study), caption)]


def _section_tables(study: Study) -> list[Block]:
    return [
        Table(
            (axis_label(name), *HEADER[1:]),
            section_rows(study, design, name),
            f"{design}: {SHOWN[name][0]}, at {reference_text(study, name)}.",
        )
        for name in study.varied
        for design in study.designs
    ]


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


def study_json(study: Study) -> dict[str, object]:
    """For JSON."""
    return study.to_dict() | {"reference_points": [asdict(study.reference_point(d)) for d in study.designs]}
