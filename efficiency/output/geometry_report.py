"""Report sections of the geometry and the unloaded contact of a pair."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

from efficiency.output.geometry_tables import (
    blank_table,
    contact_table,
    flank_table,
    geometry_tables,
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
from ehl.common.errors import InputError
from ehl.common.sections import Head, Item, KeyFigures, MainResult, Medium, Notes, Picture, Row, Section, Text
from ehl.common.table import Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from efficiency.geometry.pair_geometry import PairGeometry, SideGeometry


AXIAL_SECTION = "Axial section of both members in the plane of the axes."


def side_figures(side: SideGeometry) -> Iterator[Picture]:
    """Figures of one side; the first one is wide."""
    pair, path, name = side.pair, side.pair.path, side.side

    def picture(what: str, caption: str, draw: Callable[..., Figure | Axes], *args: Any) -> Picture:
        return Picture(partial(draw, *args), caption, f"{name}_{what}")

    yield picture("teeth_in_mesh", "Teeth in mesh; positions include the misalignments.", tooth_pair_figure, pair)
    caption = "Ease-off on the projection of the gear. The dashed line limits the common part of both flanks."
    yield picture("ease_off_gear", caption, ease_off_figure, pair, path, "gear")
    yield picture("ease_off_pinion", "Ease-off on the projection of the pinion.", ease_off_figure, pair, path, "pinion")
    caption = "Contact pattern: area where the distance of the flanks is below the thickness of the marking compound."
    for member, text in (("gear", caption), ("pinion", "Contact pattern on the pinion.")):
        yield picture(f"contact_pattern_{member}", text, contact_pattern_figure, pair, side.pattern, path, member)
    caption = "Unloaded transmission error, negative where the gear lags. The dotted line indicates edge contact."
    yield picture("transmission_error", caption, transmission_figure, side)
    caption = "Amplitudes at multiples of the mesh frequency, for all tooth pairs together."
    yield picture("harmonics", caption, harmonics_figure, side)
    caption = "Potential contact lines of all positions of a pitch. Black: all tooth pairs at one position."
    yield picture("contact_lines", caption, contact_lines_figure, pair, side.cycle, path)
    caption = "Equivalent radius normal to the contact line, along selected lines."
    yield picture("equivalent_radius", caption, radius_figure, pair, side.cycle)


def geometry_sections(geometry: PairGeometry, medium: Medium, units: Units = "metric") -> list[Section]:
    """Blanks, settings, contact of each side, notes."""
    design = geometry.design
    if medium != "page":
        return [Section("", [Head(f"{design.name}: geometry"), *geometry_tables(geometry, units), _notes(geometry)])]
    teeth = f"{design.pinion.blank.teeth} x {design.gear.blank.teeth} teeth"
    head = Head(
        f"Gear geometry: {design.name}",
        f"{teeth}, {misalignment_text(design)}. Source: {design.source or 'not stated'}",
        f"Computed in {geometry.seconds:.2f} s for unloaded, rigid flanks.",
    )
    return [
        Section("", [head, *_headline(geometry), _notes(geometry)]),
        *(Section(f"{name.capitalize()} side", _side_items(side)) for name, side in geometry.sides.items()),
        _contact(geometry),
        _blanks(geometry, units),
        _settings(geometry, units),
    ]


def plot_geometry(geometry: PairGeometry, ax: Axes | None) -> Axes:
    """Contact pattern on the gear, of the drive side if it was computed."""
    if not geometry.sides:
        raise InputError("plot", geometry.reason, "a geometry with at least one computed side")
    side = next(iter(geometry.sides.values()))
    return contact_pattern_figure(side.pair, side.pattern, side.pair.path, "gear", ax)


def _notes(geometry: PairGeometry) -> Notes:
    return Notes(graded_notes(geometry), len(geometry.sides) + len(geometry.failures))


def _headline(geometry: PairGeometry) -> list[Item]:
    sides = geometry.sides
    if not sides:
        return [MainResult("no result", "transmission error without load")]
    first = next(iter(sides))
    known = [(key_side(side), f"{name}") for name, side in sides.items() if name != first]
    label = f"transmission error without load, {first}, peak to peak"
    tiles = [(f"{side.contact_ratio:.2f}", f"potential contact ratio, {name}") for name, side in sides.items()]
    return [MainResult(key_side(sides[first]), label, known), KeyFigures(tiles)]


def _blanks(geometry: PairGeometry, units: Units) -> Section:
    rows = blank_table(summary_rows(geometry.design, units))
    picture = Picture(partial(blank_figure, geometry.design), AXIAL_SECTION, "blank_section")
    return Section("Blanks", [picture, Table(("quantity", "unit", "pinion", "gear"), rows)])


def _settings(geometry: PairGeometry, units: Units) -> Section:
    note = "Settings that are zero for all four flanks are omitted."
    tables = setting_tables(summary_rows(geometry.design, units)).items()
    settings = [Table((words(part), "unit", *FLANKS), rows, note) for part, rows in tables]
    return Section("Cutters and machine settings", [*settings, flank_table(geometry)])


def _contact(geometry: PairGeometry) -> Section:
    text = Text(
        "Ease-off is the distance from the pinion flank conjugate to the real gear flank to the real pinion flank, "
        "positive where material is missing on the pinion. The transmission error is the deviation of the gear "
        "rotation from constant ratio, positive if the gear leads. Coordinates on a flank are the distance from the "
        "mean point along the pitch cone, positive to the heel, and the height above the pitch cone."
    )
    tables = [contact_table(geometry)] if geometry.sides else []
    return Section("Unloaded contact: numerical results", [text, *tables])


def _side_items(side: SideGeometry) -> list[Item]:
    wide, *others = side_figures(side)
    return [wide, Row(others)]
