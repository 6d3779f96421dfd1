"""Geometry and unloaded contact of a pair as figures and as one HTML page for print."""

from __future__ import annotations

import platform
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from efficiency.output.geometry_tables import (
    blank_table,
    contact_table,
    flank_table,
    graded_notes,
    key_side,
    misalignment_text,
    setting_tables,
    words,
)
from efficiency.output.machine_summary import FLANKS, Units, summary_rows
from efficiency.output.plots_geometry import (
    blank_figure,
    contact_lines_figure,
    contact_pattern_figure,
    ease_off_figure,
    harmonics_figure,
    radius_figure,
    transmission_figure,
)
from efficiency.output.plots_teeth import tooth_pair_figure
from ehl import __version__
from ehl.common.pages import write_report
from ehl.common.sections import Item, KeyFigures, MainResult, Notes, Picture, Row, Section, Text
from ehl.common.table import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from efficiency.geometry.pair_geometry import PairGeometry, SideGeometry


def side_figures(side: SideGeometry) -> Iterator[tuple[str, Figure, str]]:
    """(name, figure, caption) of one side."""
    pair, path = side.pair, side.pair.path
    yield "teeth_in_mesh", tooth_pair_figure(pair), "Teeth in mesh; positions include the misalignments."
    yield (
        "ease_off_gear",
        ease_off_figure(pair, path, "gear"),
        "Ease-off on the projection of the gear. Dashed: the limit of the part both flanks reach.",
    )
    yield "ease_off_pinion", ease_off_figure(pair, path, "pinion"), "The same on the projection of the pinion."
    yield (
        "contact_pattern_gear",
        contact_pattern_figure(pair, side.pattern, path, "gear"),
        "Contact pattern: where the flanks come closer than the marking compound is thick.",
    )
    yield (
        "contact_pattern_pinion",
        contact_pattern_figure(pair, side.pattern, path, "pinion"),
        "The same on the pinion.",
    )
    yield (
        "transmission_error",
        transmission_figure(side),
        "Unloaded transmission error: the gear lags where it is negative. Dotted: an edge is in contact.",
    )
    yield "harmonics", harmonics_figure(side), "Amplitudes at multiples of the mesh frequency, all pairs together."
    yield (
        "contact_lines",
        contact_lines_figure(pair, side.cycle, path),
        "Potential contact lines of all positions in a pitch. Black: all pairs at one position.",
    )
    yield (
        "equivalent_radius",
        radius_figure(pair, side.cycle),
        "Equivalent radius normal to the contact line, along some of the lines.",
    )


def geometry_figures(geometry: PairGeometry) -> Iterator[tuple[str, Figure]]:
    """(name, figure): `blank_section`, and `drive_...`, `coast_...`."""
    for name, side in geometry.sides.items():
        for what, figure, _ in side_figures(side):
            yield f"{name}_{what}", figure
    yield "blank_section", blank_figure(geometry.design)


def write_geometry_report(geometry: PairGeometry, path: Path, units: Units = "metric") -> Path:
    """One self-contained page: blanks, settings, contact of each side, notes, versions.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    design = geometry.design
    sections = [
        _headline(geometry),
        *(Section(f"{name.capitalize()} side", _side_blocks(side)) for name, side in geometry.sides.items()),
        _contact(geometry),
        _blanks(geometry, units),
        _settings(geometry, units),
    ]
    return write_report(
        path,
        f"Gear geometry: {design.name}",
        f"{design.pinion.blank.teeth} x {design.gear.blank.teeth} teeth, {misalignment_text(design)}. "
        f"Source: {design.source or 'not stated'}",
        sections,
        f"mixed-ehl {__version__}, Python {platform.python_version()}; computed in {geometry.seconds:.2f} s. Unloaded: "
        "rigid flanks, no deflection.",
    )


def _headline(geometry: PairGeometry) -> Section:
    sides = geometry.sides
    notes = Notes(graded_notes(geometry), len(sides) + len(geometry.failures))
    if not sides:
        return Section("", [MainResult("no answer", "transmission error without load"), notes])
    first = next(iter(sides))
    known = [(key_side(side), f"{name}") for name, side in sides.items() if name != first]
    answer = MainResult(key_side(sides[first]), f"transmission error without load, {first}, peak to peak", known)
    tiles = [(f"{side.contact_ratio:.2f}", f"potential contact ratio, {name}") for name, side in sides.items()]
    return Section("", [answer, KeyFigures(tiles), notes])


def _blanks(geometry: PairGeometry, units: Units) -> Section:
    rows = blank_table(summary_rows(geometry.design, units))
    return Section(
        "Blanks",
        [
            Picture(blank_figure(geometry.design), "Axial section of both members in the plane of the axes."),
            Table(("quantity", "unit", "pinion", "gear"), rows),
        ],
    )


def _settings(geometry: PairGeometry, units: Units) -> Section:
    tables = setting_tables(summary_rows(geometry.design, units))
    return Section(
        "Cutters and machine settings",
        [
            *(
                Table((words(part), "unit", *FLANKS), rows, "What is zero for all four flanks is left out.")
                for part, rows in tables.items()
            ),
            flank_table(geometry),
        ],
    )


def _contact(geometry: PairGeometry) -> Section:
    text = Text(
        "Ease-off is the distance from the pinion flank conjugate to the real gear flank to the real pinion flank, "
        "positive where material is missing on the pinion. The transmission error is the rotation of the gear ahead of "
        "its place at constant ratio. Places on a flank: along the pitch cone from the mean point to the heel, and "
        "square to it over the pitch cone."
    )
    blocks: list[Item] = [text]
    if geometry.sides:
        blocks.append(contact_table(geometry))
    return Section("Unloaded contact in numbers", blocks)


def _side_blocks(side: SideGeometry) -> list[Item]:
    pictures = {name: Picture(figure, caption) for name, figure, caption in side_figures(side)}
    wide = pictures.pop("teeth_in_mesh")
    return [wide, Row(list(pictures.values()))]
