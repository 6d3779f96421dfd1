"""Tables of the geometry and the unloaded contact of a pair, for the terminal and for reports."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from efficiency.output.machine_summary import FLANKS, SummaryRow, Units, summary_rows
from ehl.io.units import ARCSEC
from ehl.view.table import Table

if TYPE_CHECKING:
    from efficiency.design.design import Design
    from efficiency.geometry.pair_geometry import PairGeometry, SideGeometry

SETTING_HEADER = ("setting", "unit", *FLANKS)
FLANK_HEADER = ("flank", "spiral angle [deg]", "pressure angle, normal [deg]", "end over root [% of depth]")


def flank_rows(geometry: PairGeometry) -> list[tuple[str, ...]]:
    """Angles of the four flanks at their mean points, and where they end above the root."""
    return [
        (
            f"{name.replace('_', ' ')} ({_role(geometry.design, name)})",
            f"{math.degrees(flank.spiral_angle):.3f}",
            f"{math.degrees(flank.pressure_angle):.3f}",
            f"{100.0 * flank.lowest:.1f}" if flank.lowest > 0.0 else "–",
        )
        for name, flank in geometry.flanks.items()
    ]


def _role(design: Design, flank: str) -> str:
    member, side = flank.split("_")
    drive = design.assembly.drive_flank_pinion
    drives = side == drive if member == "pinion" else side != drive
    return "drive" if drives else "coast"


def contact_rows(geometry: PairGeometry) -> list[tuple[str, ...]]:
    """(quantity, unit, one value for each side) of the unloaded contact."""
    top, marking = "highest point", f"contact pattern ({1e6 * geometry.marking:.4g} µm)"
    rows: list[tuple[str, str, Callable[[SideGeometry], str]]] = [
        ("contact ratio, potential", "pitches", lambda s: f"{s.contact_ratio:.3f}"),
        ("unloaded contact inside the edges", "pitches", lambda s: f"{s.path_ratio:.2f}"),
        ("transmission error, peak to peak", "arcsec", lambda s: _arcsec(s.pair.transmission.peak_to_peak)),
        ("transmission error, peak to peak", "µrad", lambda s: f"{1e6 * s.pair.transmission.peak_to_peak:.4g}"),
        ("transmission error, harmonic 1", "arcsec", lambda s: _arcsec(s.pair.transmission.harmonics[0])),
        ("transmission error, harmonic 2", "arcsec", lambda s: _arcsec(s.pair.transmission.harmonics[1])),
        ("transmission error, harmonic 3", "arcsec", lambda s: _arcsec(s.pair.transmission.harmonics[2])),
        (f"{top}: from the mean point to the heel", "mm", lambda s: f"{1e3 * s.contact_u:+.3f}"),
        (f"{top}: over the pitch cone of the gear", "mm", lambda s: f"{1e3 * s.contact_height:+.3f}"),
        (f"{top}: path against the line to the heel", "deg", lambda s: f"{math.degrees(s.path_angle):+.1f}"),
        ("largest ease-off where both flanks reach", "µm", lambda s: f"{1e6 * s.ease_off[1]:.2f}"),
        (f"{marking}: share of the flank", "%", lambda s: f"{100.0 * s.pattern.area_share:.1f}"),
        (f"{marking}: length, of the face width", "%", lambda s: f"{100.0 * s.pattern.length:.1f}"),
        (f"{marking}: height, of the whole depth", "%", lambda s: f"{100.0 * s.pattern.width:.1f}"),
        ("equivalent radius normal to the lines", "mm", lambda s: _range_mm(s.radius_equivalent)),
        ("error of the ease-off", "µm", lambda s: f"{1e6 * s.pair.surface.interpolation_error:.1e}"),
        ("time", "s", lambda s: f"{s.seconds:.2f}"),
    ]
    sides = geometry.sides.values()
    return [(quantity, unit, *(text(side) for side in sides)) for quantity, unit, text in rows]


def all_notes(geometry: PairGeometry) -> list[str]:
    """What a designer should know: of the members, then of each side, then what failed."""
    notes = list(geometry.notes)
    notes += [f"{name}: {note}" for name, side in geometry.sides.items() for note in side.notes]
    return notes + [f"{name}: {reason}" for name, reason in geometry.failures.items()]


def blank_table(rows: list[SummaryRow]) -> list[tuple[str, ...]]:
    """(name, unit, pinion, gear) of the rows of a summary that belong to the members."""
    return [(words(row.name), row.unit, row.texts[0], row.texts[2]) for row in rows if row.section == "blank"]


def setting_tables(rows: list[SummaryRow]) -> dict[str, list[tuple[str, ...]]]:
    """(name, unit, four flanks) of cutters and of machine settings; what is zero everywhere is left out."""
    tables: dict[str, list[tuple[str, ...]]] = {}
    for row in rows:
        part, _, inner = row.section.partition(".")
        if part != "blank" and any(value not in (None, 0, 0.0) for value in row.values):
            name = words(f"{inner}: {row.name}" if inner else row.name)
            tables.setdefault(part, []).append((name, row.unit, *row.texts))
    return tables


def words(name: str) -> str:
    """A name of a field as words."""
    return name.replace("_", " ")


def misalignment_text(design: Design) -> str:
    """Misalignment in words, or that there is none."""
    m = design.assembly.misalignment
    parts = [f"{name} {1e3 * getattr(m, name):+.4g} mm" for name in ("E", "P", "G") if getattr(m, name) != 0.0]
    if m.alpha != 0.0:
        parts.append(f"alpha {math.degrees(m.alpha):+.4g} deg")
    return "misaligned: " + ", ".join(parts) if parts else "aligned"


def geometry_tables(geometry: PairGeometry, units: Units = "metric") -> list[Table]:
    """Blanks, cutters and machine settings, flanks and unloaded contact."""
    design = geometry.design
    summary = summary_rows(design, units)
    notes = [f"note     {note}" for note in all_notes(geometry)] + [f"{geometry.status}, {geometry.seconds:.2f} s"]
    tables = [Table(("quantity", "unit", "pinion", "gear"), blank_table(summary), f"{design.name}: blanks")]
    for part, rows in setting_tables(summary).items():
        tables.append(Table(SETTING_HEADER, rows, f"{words(part).capitalize()} of each flank"))
    tables.append(Table(FLANK_HEADER, flank_rows(geometry), "Flanks at their mean points"))
    if geometry.sides:
        title = f"Unloaded contact, {misalignment_text(design)}"
        tables.append(Table(("quantity", "unit", *geometry.sides), contact_rows(geometry), title))
    tables[-1] = replace(tables[-1], notes=notes)
    return tables


def key_side(side: SideGeometry) -> str:
    """Transmission error of a side for a headline."""
    return f"{side.pair.transmission.peak_to_peak / ARCSEC:.3g} arcsec"


def _arcsec(value: float) -> str:
    return f"{value / ARCSEC:.3f}"


def _range_mm(values: tuple[float, float]) -> str:
    return f"{1e3 * values[0]:.2f} to {1e3 * values[1]:.2f}"
