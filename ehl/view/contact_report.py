"""One contact as an HTML page: the answer, what is known of it, figures, tables, how it was computed."""

from __future__ import annotations

import math
import platform
from dataclasses import replace
from pathlib import Path
from typing import Any

from ehl import __version__
from ehl.common.html_report import (
    Answer,
    Beside,
    Block,
    Folded,
    KeyFigures,
    Notes,
    Picture,
    Section,
    Text,
    write_report,
)
from ehl.common.notes import CONTACT_NOTES, Note, group_notes
from ehl.common.quantities import quantity
from ehl.common.table import Table

_TILES = ("film_central", "film_min", "film_ratio", "pressure_max", "temperature_film_max")


def write_contact_report(path: Path, result: Any, uncertainty: Any = None) -> Path:
    """Write the page of one contact.

    Parameters
    ----------
    path : Path
        HTML file.
    result : ehl.result.ContactResult
        Also one that failed: the page says why. It and the next know of pages, not the other way round.
    uncertainty : ehl.uncertainty.result.InputUncertainty, optional
        What the inputs leave open of its friction.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    sections = [_headline(result, uncertainty)]
    if result.film is not None:
        sections.append(Section("Solution", [Picture(result.plot(), "Pressure, film and temperatures over x/b.")]))
    if uncertainty is not None and uncertainty.sources:
        bars = Picture(
            uncertainty.plot(), "What each input alone does to the friction; the error of the solution apart."
        )
        sections.append(
            Section("What the inputs leave open", [bars, Folded("Where each spread comes from", [uncertainty.table()])])
        )
    tables: list[Block] = []
    if result.status != "failed":
        tables.append(replace(result.table(), title="Results.", notes=()))
    if result.problem is not None:
        tables.append(Table.from_records([result.problem.to_dict()], title="Operating point.", vertical=True))
    sections.append(Section("Results and operating point", [Beside(tables)]))
    computed: list[Block] = [Text(f"{result.outcome.capitalize()}; {result.cost}.")]
    if result.skipped:
        computed.insert(0, Table(("left out", "because"), [_reason(text) for text in result.skipped]))
    sections.append(Section("How it was computed", computed))
    footer = f"mixed-ehl {__version__}, Python {platform.python_version()}."
    return write_report(path, "Line contact", result.operating_point, sections, footer)


def _headline(result: Any, uncertainty: Any) -> Section:
    notes = group_notes([("", note) for note in result.notes], CONTACT_NOTES)
    if result.status == "failed":
        answer = Answer("no answer", f"friction coefficient: {result.reason}")
        return Section("", [answer, Notes([Note("fault", f"failed: {result.reason}"), *notes])])
    if result.status == "unsettled":
        notes.insert(0, Note("warning", result.outcome))
    known = [_inputs(uncertainty), (_error(result.friction_error), "error of the solution")]
    if math.isfinite(result.friction_boundary_half):
        ends = sorted((result.friction_boundary_half, result.friction_boundary_double))
        known.append((f"{ends[0]:.3g} to {ends[1]:.3g}", "at half and twice the boundary film, which no theory gives"))
    tiles = []
    for name in _TILES:
        value = getattr(result, name)
        if name == "film_ratio" and not math.isfinite(value):
            tiles.append(("smooth", "surfaces, no film ratio"))
        elif math.isfinite(value):
            tiles.append((quantity(name).text(value, 3), quantity(name).label))
    if math.isfinite(result.film_ratio):
        tiles.insert(3, (f"{100.0 * result.asperity_load_share:.3g} %", "load on asperities"))
    answer = Answer(f"{result.friction_coefficient:.4g}", quantity("friction_coefficient").label, known)
    return Section("", [answer, KeyFigures(tiles), Notes(notes)])


def _inputs(uncertainty: Any) -> tuple[str, str]:
    if uncertainty is None:
        return "not computed", "interval by uncertain inputs; --uncertainty of solve, or Contact.uncertainty in Python"
    if not uncertainty.low < uncertainty.high:
        return "no interval", "; ".join(uncertainty.notes) or "no input is uncertain"
    most = ", ".join(f"{name} {half:.2g}" for name, half in list(uncertainty.groups.items())[:3])
    return (
        f"{uncertainty.low:.3g} to {uncertainty.high:.3g}",
        f"{100.0 * uncertainty.level:.0f} % interval by uncertain inputs, most by {most}",
    )


def _error(share: float) -> str:
    return f"±\N{NO-BREAK SPACE}{100.0 * share:.2g} %" if math.isfinite(share) else "not known"


def _reason(text: str) -> tuple[str, str]:
    what, _, why = text.partition(": ")
    return what, why
