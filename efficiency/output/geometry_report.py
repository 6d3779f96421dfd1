"""Tables and report sections of the geometry and the unloaded contact of a pair."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

from matplotlib.axes import Axes

from efficiency.contact.gear_flanks import MEMBERS, SIDES
from efficiency.design.design import Design
from efficiency.geometry.design_drawing import design_drawing
from efficiency.geometry.pair_geometry import PairGeometry, SideGeometry
from efficiency.loss.efficiency_result import pair_notes
from efficiency.output import plots_geometry as plots
from efficiency.output.machine_summary import Units, settings_tables
from ehl.common.errors import InputError
from ehl.common.notes import Note
from ehl.common.quantities import quantity
from ehl.common.sections import Head, Item, KeyFigures, MainResult, Medium, Notes, Picture, Row, Section, Text, picture
from ehl.common.table import Column, Table


def flank_table(geometry: PairGeometry) -> Table:
    """Angles of the four flanks at their mean points, and their lower ends above the root."""
    columns: list[Column | str] = [
        "flank",
        Column("spiral_angle", digits=5),
        Column("pressure_angle_normal", of="spiral_angle", label="pressure angle, normal", digits=5),
        Column("lowest", of="share", label="lower end / depth"),
    ]
    flanks, rows = geometry.design.flanks(), []
    sides = {f"{member}_{flanks.loaded_side(member, side)}": side for member in MEMBERS for side in SIDES}
    for name, flank in geometry.flanks.items():
        head = f"{name.replace('_', ' ')} ({sides[name]})"
        rows.append((head, flank.spiral_angle, flank.pressure_angle, flank.lowest or None))
    return Table(columns, rows, "Flanks at their mean points", name="flanks")


def contact_table(geometry: PairGeometry) -> Table:
    """Unloaded contact of each side."""
    top, marking = "highest point", f"contact pattern ({quantity('marking').text(geometry.marking)})"
    harmonic = "transmission error, harmonic"
    columns: dict[Column, Callable[[SideGeometry], float]] = {
        Column("contact_ratio", label="potential contact ratio [pitches]"): lambda s: s.contact_ratio,
        Column("path_ratio", label="unloaded contact without edge contact [pitches]"): lambda s: s.path_ratio,
        Column("peak_to_peak", label="transmission error, peak to peak"): lambda s: s.pair.transmission.peak_to_peak,
        Column("harmonic_1", label=f"{harmonic} 1"): lambda s: s.pair.transmission.harmonics[0],
        Column("harmonic_2", of="harmonic_1", label=f"{harmonic} 2"): lambda s: s.pair.transmission.harmonics[1],
        Column("harmonic_3", of="harmonic_1", label=f"{harmonic} 3"): lambda s: s.pair.transmission.harmonics[2],
        Column("contact_u", label=f"{top}: distance from the mean point to the heel"): lambda s: s.contact_u,
        Column("contact_height", label=f"{top}: height above the pitch cone of the gear"): lambda s: s.contact_height,
        Column("path_angle", label=f"{top}: angle of the path to the pitch line"): lambda s: s.path_angle,
        Column("ease_off", label="largest ease-off in the common part of the flanks"): lambda s: s.ease_off[1],
        Column("pattern_area", of="share", label=f"{marking}: share of the flank"): lambda s: s.pattern.area_share,
        Column("pattern_length", of="share", label=f"{marking}: length / face width"): lambda s: s.pattern.length,
        Column("pattern_width", of="share", label=f"{marking}: height / whole depth"): lambda s: s.pattern.width,
        Column("radius_equivalent_min", "radius_equivalent", "smallest equivalent radius"): lambda s: (
            s.radius_equivalent[0]
        ),
        Column("radius_equivalent_max", "radius_equivalent", "largest equivalent radius"): lambda s: (
            s.radius_equivalent[1]
        ),
        Column("ease_off_error", "ease_off", "error of the ease-off", 2): lambda s: s.pair.surface.interpolation_error,
        Column("seconds"): lambda s: s.seconds,
    }
    rows = [(name, *(value(side) for value in columns.values())) for name, side in geometry.sides.items()]
    title = f"Unloaded contact, {misalignment_text(geometry.design)}"
    return Table(["side", *columns], rows, title, name="unloaded_contact", vertical=True)


def graded_notes(geometry: PairGeometry) -> list[Note]:
    """Notes on the members, on each side and on failures, the most severe first."""
    said = [("", note) for note in geometry.notes]
    said += [(name, note) for name, side in geometry.sides.items() for note in side.notes]
    return pair_notes([*said, *((name, f"no result: {reason}") for name, reason in geometry.failures.items())])


def misalignment_text(design: Design) -> str:
    """The misalignment as text, or ``aligned``."""
    m = design.assembly.misalignment
    parts = [f"{name} {1e3 * getattr(m, name):+.4g} mm" for name in ("E", "P", "G") if getattr(m, name) != 0.0]
    if m.shaft_angle_error != 0.0:
        parts.append(f"shaft_angle_error {math.degrees(m.shaft_angle_error):+.4g} deg")
    return "misaligned: " + ", ".join(parts) if parts else "aligned"


def geometry_tables(geometry: PairGeometry, units: Units) -> list[Table]:
    """Blanks, cutters and machine settings, flanks and unloaded contact."""
    design = geometry.design
    tables = [design_drawing(design).table(units), *settings_tables(design, units), flank_table(geometry)]
    tables += [contact_table(geometry)] if geometry.sides else []
    tables[-1] = replace(tables[-1], notes=(f"{geometry.status}, {geometry.seconds:.2f} s",))
    return tables


def key_side(side: SideGeometry) -> str:
    """Transmission error of a side as text."""
    return quantity("peak_to_peak").text(side.pair.transmission.peak_to_peak, 3)


AXIAL_SECTION = "Axial section of both members in the plane of the axes."


def side_figures(side: SideGeometry) -> Iterator[Picture]:
    """Figures of one side; the first one is wide."""
    pair, of = side.pair, f"{side.side}_"
    caption = "Teeth in mesh; positions include the misalignments."
    yield picture(of + "teeth_in_mesh", caption, plots.tooth_pair_figure, pair)
    caption = "Ease-off on the projection of the gear. The dashed line limits the common part of both flanks."
    for member, text in (("gear", caption), ("pinion", "Ease-off on the projection of the pinion.")):
        yield picture(of + f"ease_off_{member}", text, plots.ease_off_figure, pair, member)
    caption = "Contact pattern: area where the distance of the flanks is below the thickness of the marking compound."
    for member, text in (("gear", caption), ("pinion", "Contact pattern on the pinion.")):
        yield picture(of + f"contact_pattern_{member}", text, plots.contact_pattern_figure, pair, side.pattern, member)
    caption = "Unloaded transmission error, negative where the gear lags. The dotted line indicates edge contact."
    yield picture(of + "transmission_error", caption, plots.transmission_figure, side)
    caption = "Amplitudes at multiples of the mesh frequency, for all tooth pairs together."
    yield picture(of + "harmonics", caption, plots.harmonics_figure, side)
    caption = "Potential contact lines of all positions of a pitch. Black: all tooth pairs at one position."
    yield picture(of + "contact_lines", caption, plots.contact_lines_figure, pair, side.cycle)
    caption = "Equivalent radius normal to the contact line, along selected lines."
    yield picture(of + "equivalent_radius", caption, plots.radius_figure, pair, side.cycle)


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
    of_sides = {name: list(side_figures(side)) for name, side in geometry.sides.items()}
    axial_section = picture("blank_section", AXIAL_SECTION, plots.blank_figure, design)
    return [
        Section("", [head, *_headline(geometry), _notes(geometry)]),
        *(Section(f"{name.capitalize()} side", [wide, Row(others)]) for name, (wide, *others) in of_sides.items()),
        _contact(geometry),
        Section("Blanks", [axial_section, design_drawing(design).table(units)]),
        Section("Cutters and machine settings", [*settings_tables(design, units), flank_table(geometry)]),
    ]


def plot_geometry(geometry: PairGeometry, ax: Axes | None) -> Axes:
    """Contact pattern on the gear, of the drive side if it was computed."""
    if not geometry.sides:
        raise InputError("plot", geometry.reason, "a geometry with at least one computed side")
    side = next(iter(geometry.sides.values()))
    return plots.contact_pattern_figure(side.pair, side.pattern, "gear", ax)


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


def _contact(geometry: PairGeometry) -> Section:
    text = Text(
        "Ease-off is the distance from the pinion flank conjugate to the real gear flank to the real pinion flank, "
        "positive where material is missing on the pinion. The transmission error is the deviation of the gear "
        "rotation from constant ratio, positive if the gear leads. Coordinates on a flank are the distance from the "
        "mean point along the pitch cone, positive to the heel, and the height above the pitch cone."
    )
    tables = [contact_table(geometry)] if geometry.sides else []
    return Section("Unloaded contact: numerical results", [text, *tables])
