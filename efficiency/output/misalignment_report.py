"""Report sections of a misalignment study."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from efficiency.design.design import MISALIGNMENTS
from efficiency.geometry.misalignment import LOADED
from efficiency.ltca.limits import EDGE_LIMIT
from efficiency.output.plots_misalignment import misalignment_figures, misalignment_quantity, plot_misalignment
from ehl.common.data import reason_text
from ehl.common.quantities import quantity
from ehl.common.sections import Folded, Head, Item, Medium, Row, Section
from ehl.common.table import Column, Table

if TYPE_CHECKING:
    from efficiency.geometry.misalignment import MisalignmentGrid, MisalignmentStudy

__all__ = ["misalignment_sections", "plot_misalignment"]
_ROWS = 60


def misalignment_table(study: MisalignmentStudy) -> Table:
    """One row per state: varied misalignments, transmission error, contact positions, pattern, edges.

    At a torque, positions and sizes are those under load.
    """
    names, shares = study.varied, ("pattern_length", "pattern_area")
    fields: tuple[str, ...] = ("peak_to_peak", *LOADED)
    if study.torque is None:
        fields = ("peak_to_peak", "error_maximum_u", "pattern_u", *shares)
        what, edges = f"unloaded contact, marking {1e6 * study.marking:.4g} µm", "edge in contact"
    else:
        what, edges = f"contact at {quantity('torque').text(study.torque)} of the pinion", "unloaded edge contact"
    return Table(
        [
            *(Column(name, of=misalignment_quantity(name).name, label=name) for name in names),
            *(Column(n, of="share", label=n.replace("_", " ")) if n in shares else n for n in fields),
            Column("edges", label=f"{edges}, or reason of failure"),
        ],
        [
            [*(getattr(point, name) for name in (*names, *fields)), reason_text(point.reason) or point.edges]
            for point in study.points[:_ROWS]
        ],
        title=f"{study.design}, {study.side}: {what}",
        notes=_notes(study),
    )


def distribution_table(study: MisalignmentStudy) -> Table:
    """Mean, standard deviation and quantiles of each result over random misalignments."""
    spread = ", ".join(f"{name} {misalignment_quantity(name).text(getattr(study, name)[0])}" for name in study.varied)
    found = study.distribution()
    columns = ["statistic", *found]
    names = ("mean", "standard deviation", "5 %", "median", "95 %")
    rows = [(name, *(values[i] for values in found.values())) for i, name in enumerate(names)]
    title = f"{study.design}, {study.side}: {study.samples} random states, standard deviations {spread or 'none'}"
    notes = _notes(study)
    if study.accuracy_grade is not None:
        made = ", ".join(f"{n.replace('_', ' ')} {1e6 * x:.2g} µm" for n, x in study.tolerances.model_dump().items())
        notes.append(
            f"flanks of grade {study.accuracy_grade} (ISO 1328-1), standard deviations of both together: {made}"
        )
    return Table(columns, rows, title, notes, "distribution", vertical=True)


def _notes(study: MisalignmentStudy) -> list[str]:
    count = len(study.points)
    failed = sum(point.status == "failed" for point in study.points)
    edges = sum(point.status == "edge contact" for point in study.points)
    notes = [
        f"{study.status}: {count} states, {edges} with unloaded edge contact, {failed} failed, {study.seconds:.2f} s"
    ]
    if study.torque is not None and failed < count:
        worst = max((p for p in study.points if p.status != "failed"), key=lambda p: p.edge_load_share)
        if worst.edge_load_share >= EDGE_LIMIT:
            place = ", ".join(
                f"{name} {misalignment_quantity(name).text(getattr(worst, name))}" for name in study.varied
            )
            share = 100.0 * worst.edge_load_share
            remedy = "add relief or stiffen the mounting"
            notes.insert(0, f"edges carry up to {share:.2g} % of the torque ({place}): {remedy}")
    if count > _ROWS:
        notes.insert(0, f"{count - _ROWS} of {count} states are omitted here; --csv writes all of them")
    return notes


def misalignment_sections(grid: MisalignmentGrid, medium: Medium) -> list[Section]:
    """Contact in all states: a table for each side and figures; files hold all states in one table."""
    first = grid.studies[0]
    kind = "Tolerance analysis" if first.samples else "Misalignment study"
    head = Head(f"{kind}: {first.design}", f"marking {1e6 * first.marking:.4g} µm")
    if medium == "files":
        records = grid.to_frame().to_dict("list")
        known = {name: misalignment_quantity(name).name for name in MISALIGNMENTS} | {
            "crest_u": "error_maximum_u",
            "crest_depth": "error_maximum_depth",
        }
        columns = {Column(str(name), of=known.get(str(name), "")): values for name, values in records.items()}
        return [Section("", [head, Table.from_columns(columns, name="misalignment")])]
    tables = [misalignment_table(study) for study in grid.studies]
    if first.samples:
        found: list[Item] = [head, *(distribution_table(study) for study in grid.studies)]
        if medium == "page":
            states = Folded("Random states", [replace(table, notes=()) for table in tables])
            found += [*misalignment_figures(grid.pair, grid.studies), states]
        return [Section("", found)]
    if medium == "terminal":
        return [Section("", [head, *tables])]
    wide, *others = misalignment_figures(grid.pair, grid.studies)
    return [Section("", [head]), Section("Contact", [wide, Row(others)]), Section("Numerical results", tables)]
