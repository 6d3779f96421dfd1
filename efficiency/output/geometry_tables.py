"""Tables of the geometry and the unloaded contact of a pair, for the terminal and for reports."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from efficiency.loss.efficiency_result import pair_notes
from efficiency.output.machine_summary import FLANKS, SummaryRow, Units, summary_rows
from ehl.common.notes import Note
from ehl.common.quantities import quantity
from ehl.common.table import Column, Table

if TYPE_CHECKING:
    from efficiency.design.design import Design
    from efficiency.geometry.pair_geometry import PairGeometry, SideGeometry

SETTING_HEADER = ("setting", "unit", *FLANKS)


def flank_table(geometry: PairGeometry) -> Table:
    """Angles of the four flanks at their mean points, and their lower ends above the root."""
    columns: list[Column | str] = [
        "flank",
        Column("spiral_angle", digits=5),
        Column("pressure_angle_normal", of="spiral_angle", label="pressure angle, normal", digits=5),
        Column("lowest", of="share", label="lower end above the root, share of the depth"),
    ]
    rows = [
        (
            f"{name.replace('_', ' ')} ({_role(geometry.design, name)})",
            flank.spiral_angle,
            flank.pressure_angle,
            flank.lowest if flank.lowest > 0.0 else None,
        )
        for name, flank in geometry.flanks.items()
    ]
    return Table(columns, rows, "Flanks at their mean points", name="flanks")


def _role(design: Design, flank: str) -> str:
    member, side = flank.split("_")
    drive = design.assembly.drive_flank_pinion
    drives = side == drive if member == "pinion" else side != drive
    return "drive" if drives else "coast"


def contact_table(geometry: PairGeometry) -> Table:
    """Unloaded contact of each side."""
    top, marking = "highest point", f"contact pattern ({quantity('marking').text(geometry.marking)})"
    columns: dict[Column, Callable[[SideGeometry], float]] = {
        Column("contact_ratio", label="potential contact ratio [pitches]"): lambda s: s.contact_ratio,
        Column("path_ratio", label="unloaded contact without edge contact [pitches]"): lambda s: s.path_ratio,
        Column("peak_to_peak", label="transmission error, peak to peak"): lambda s: s.pair.transmission.peak_to_peak,
        **{
            Column(f"harmonic_{order}", of="harmonic_1", label=f"transmission error, harmonic {order}"): partial(
                _harmonic, order=order
            )
            for order in (1, 2, 3)
        },
        Column("contact_u", label=f"{top}: distance from the mean point to the heel"): lambda s: s.contact_u,
        Column("contact_height", label=f"{top}: height above the pitch cone of the gear"): lambda s: s.contact_height,
        Column("path_angle", label=f"{top}: angle of the path to the pitch line"): lambda s: s.path_angle,
        Column("ease_off", label="largest ease-off in the common part of the flanks"): lambda s: s.ease_off[1],
        Column("pattern_area", of="share", label=f"{marking}: share of the flank"): lambda s: s.pattern.area_share,
        Column("pattern_length", of="share", label=f"{marking}: length / face width"): lambda s: s.pattern.length,
        Column("pattern_width", of="share", label=f"{marking}: height / whole depth"): lambda s: s.pattern.width,
        Column("radius_equivalent_min", of="radius_equivalent", label="smallest equivalent radius"): lambda s: (
            s.radius_equivalent[0]
        ),
        Column("radius_equivalent_max", of="radius_equivalent", label="largest equivalent radius"): lambda s: (
            s.radius_equivalent[1]
        ),
        Column("ease_off_error", of="ease_off", label="error of the ease-off", digits=2): lambda s: (
            s.pair.surface.interpolation_error
        ),
        Column("seconds"): lambda s: s.seconds,
    }
    rows = [(name, *(value(side) for value in columns.values())) for name, side in geometry.sides.items()]
    title = f"Unloaded contact, {misalignment_text(geometry.design)}"
    return Table(["side", *columns], rows, title, name="unloaded_contact", vertical=True)


def _harmonic(side: SideGeometry, order: int) -> float:
    return float(side.pair.transmission.harmonics[order - 1])


def graded_notes(geometry: PairGeometry) -> list[Note]:
    """Notes on the members, on each side and on failures, the most severe first."""
    said = [("", note) for note in geometry.notes]
    said += [(name, note) for name, side in geometry.sides.items() for note in side.notes]
    return pair_notes([*said, *((name, f"no result: {reason}") for name, reason in geometry.failures.items())])


def blank_table(rows: list[SummaryRow]) -> list[tuple[str, ...]]:
    """(name, unit, pinion, gear) of the rows of a summary that belong to the members."""
    return [(words(row.name), row.unit, row.texts[0], row.texts[2]) for row in rows if row.section == "blank"]


def setting_tables(rows: list[SummaryRow]) -> dict[str, list[tuple[str, ...]]]:
    """(name, unit, four flanks) of cutters and of machine settings; rows that are zero everywhere are omitted."""
    tables: dict[str, list[tuple[str, ...]]] = {}
    for row in rows:
        part, _, inner = row.section.partition(".")
        if part != "blank" and any(value not in (None, 0, 0.0) for value in row.values):
            name = words(f"{inner}: {row.name}" if inner else row.name)
            tables.setdefault(part, []).append((name, row.unit, *row.texts))
    return tables


def words(name: str) -> str:
    """A field name in words."""
    return name.replace("_", " ")


def misalignment_text(design: Design) -> str:
    """The misalignment in words, or ``aligned``."""
    m = design.assembly.misalignment
    parts = [f"{name} {1e3 * getattr(m, name):+.4g} mm" for name in ("E", "P", "G") if getattr(m, name) != 0.0]
    if m.shaft_angle_error != 0.0:
        parts.append(f"shaft_angle_error {math.degrees(m.shaft_angle_error):+.4g} deg")
    return "misaligned: " + ", ".join(parts) if parts else "aligned"


def geometry_tables(geometry: PairGeometry, units: Units = "metric") -> list[Table]:
    """Blanks, cutters and machine settings, flanks and unloaded contact."""
    design = geometry.design
    summary = summary_rows(design, units)
    tables = [Table(("quantity", "unit", "pinion", "gear"), blank_table(summary), f"{design.name}: blanks")]
    for part, rows in setting_tables(summary).items():
        tables.append(Table(SETTING_HEADER, rows, f"{words(part).capitalize()} of each flank"))
    tables.append(flank_table(geometry))
    if geometry.sides:
        tables.append(contact_table(geometry))
    tables[-1] = replace(tables[-1], notes=(f"{geometry.status}, {geometry.seconds:.2f} s",))
    return tables


def key_side(side: SideGeometry) -> str:
    """Transmission error of a side as text."""
    return quantity("peak_to_peak").text(side.pair.transmission.peak_to_peak, 3)
