"""Report sections of one contact: friction coefficient with uncertainty, figures, tables, computation."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ehl.common.notes import CONTACT_NOTES, Note, group_notes
from ehl.common.quantities import quantity
from ehl.common.sections import Folded, Head, Item, KeyFigures, MainResult, Medium, Notes, Picture, Row, Section, Text
from ehl.common.table import Table
from ehl.uncertainty.result import plot_sources
from ehl.view.plots import plot_contact

if TYPE_CHECKING:
    from ehl.uncertainty.result import InputUncertainty

_TILES = ("film_central", "film_min", "film_ratio", "pressure_max", "temperature_film_max")


def contact_sections(result: Any, medium: Medium, uncertainty: InputUncertainty | None) -> list[Section]:
    """Sections of one contact, including one that failed."""
    if medium != "page":
        operating_point = [] if result.problem is None else [operating_point_table(result)]
        more = [] if uncertainty is None else [uncertainty.table()]
        head = Head(f"Line contact, {result.operating_point}")
        return [Section("", [head, result.table(), *(operating_point if medium == "files" else []), *more])]
    sections = [_headline(result, uncertainty)]
    if result.film is not None:
        solution = Picture(lambda: plot_contact(result), "Pressure, film and temperatures over x/b.", "solution")
        sections.append(Section("Solution", [solution]))
    if uncertainty is not None and uncertainty.sources:
        caption = "Change of friction by each input alone; the error of the solution is separate."
        bars = Picture(lambda: plot_sources(uncertainty), caption, "uncertainty")
        sections.append(Section("Input uncertainty", [bars, Folded("Sources in numbers", [uncertainty.table()])]))
    tables: list[Item] = []
    if result.status != "failed":
        tables.append(replace(result.table(), title="Results.", notes=()))
    if result.problem is not None:
        tables.append(replace(operating_point_table(result), title="Operating point."))
    sections.append(Section("Results and operating point", [Row(tables)]))
    computed: list[Item] = [Text(f"{result.outcome.capitalize()}; {result.cost}.")]
    if result.skipped:
        computed.insert(0, Table(("neglected", "reason"), [_reason(text) for text in result.skipped]))
    sections.append(Section("How it was computed", computed))
    return sections


def operating_point_table(result: Any) -> Table:
    """Inputs of a contact."""
    assert result.problem is not None
    return Table.from_records([result.problem.to_dict()], name="operating point", vertical=True)


def _headline(result: Any, uncertainty: InputUncertainty | None) -> Section:
    head = Head("Line contact", result.operating_point)
    notes = group_notes([("", note) for note in result.notes], CONTACT_NOTES)
    if result.status == "failed":
        answer = MainResult("no answer", f"friction coefficient: {result.reason}")
        return Section("", [head, answer, Notes([Note("fault", f"failed: {result.reason}"), *notes])])
    if result.status == "unsettled":
        notes.insert(0, Note("warning", result.outcome))
    known = [_inputs(uncertainty), (_error(result.friction_error), "error of the solution")]
    if math.isfinite(result.friction_boundary_half):
        ends = sorted((result.friction_boundary_half, result.friction_boundary_double))
        known.append((f"{ends[0]:.3g} to {ends[1]:.3g}", "at half and twice the boundary film, an empirical input"))
    tiles = []
    for name in _TILES:
        value = getattr(result, name)
        if name == "film_ratio" and not math.isfinite(value):
            tiles.append(("smooth", "surfaces without a film ratio"))
        elif math.isfinite(value):
            tiles.append((quantity(name).text(value, 3), quantity(name).label))
    if math.isfinite(result.film_ratio):
        tiles.insert(3, (f"{100.0 * result.asperity_load_share:.3g} %", "load on asperities"))
    answer = MainResult(f"{result.friction_coefficient:.4g}", quantity("friction_coefficient").label, known)
    return Section("", [head, answer, KeyFigures(tiles), Notes(notes)])


def _inputs(uncertainty: InputUncertainty | None) -> tuple[str, str]:
    if uncertainty is None:
        return "not computed", "interval by uncertain inputs (solve --uncertainty, or Contact.uncertainty in Python)"
    if not uncertainty.low < uncertainty.high:
        return "no interval", "; ".join(uncertainty.notes) or "no input is uncertain"
    most = ", ".join(f"{name} {half:.2g}" for name, half in list(uncertainty.groups.items())[:3])
    meaning = f"{100.0 * uncertainty.level:.0f} % interval by uncertain inputs, largest contributions: {most}"
    return f"{uncertainty.low:.3g} to {uncertainty.high:.3g}", meaning


def _error(share: float) -> str:
    return f"±\N{NO-BREAK SPACE}{100.0 * share:.2g} %" if math.isfinite(share) else "unknown"


def _reason(text: str) -> tuple[str, str]:
    what, _, why = text.partition(": ")
    return what, why
