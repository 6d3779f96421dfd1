"""Gear data for the drawings of both members, of a blank or of a design."""

from math import cos, sin
from typing import Literal

from ehl.common.quantities import quantity
from ehl.common.table import Table

# the gear data of a drawing, of the pair and of each member
_DRAWING_PAIR = (
    *("module_normal", "module_outer", "pressure_angle_drive", "pressure_angle_coast", "shaft_angle", "hypoid_offset"),
    *("cutter_radius", "working_depth", "backlash_normal", "backlash_outer_normal", "backlash_outer_transverse"),
)
_DRAWING = (
    *("mean_spiral_angle", "pitch_angle", "face_angle", "root_angle", "outer_diameter", "outer_tip_diameter"),
    *("inner_tip_diameter", "outer_cone_distance", "mean_cone_distance", "face_width", "outer_addendum"),
    *("outer_dedendum", "outer_whole_depth", "mean_addendum", "mean_whole_depth", "mean_normal_thickness"),
    *("mean_chordal_thickness", "mean_chordal_addendum", "thickness_coefficient", "pitch_apex_beyond_crossing"),
    *("face_apex_beyond_crossing", "root_apex_beyond_crossing", "crossing_to_crown", "crossing_to_front_crown"),
    *("mounting_distance", "crown_to_back", "front_crown_to_back"),
)
_INCH = 25.4  # mm


def drawing_table(pair: object, pinion: object, gear: object, units: Literal["metric", "inch"] = "metric") -> Table:
    """Table of gear data: one row for each quantity with symbol, unit, and the values of pinion and gear.

    Attributes of the arguments have the names of `PairBlank` and `MemberBlank`; missing ones are shown as a dash.
    """
    teeth, hands = (tuple(str(getattr(m, name)) for m in (pinion, gear)) for name in ("teeth", "hand"))
    rows: list[tuple[str, ...]] = [
        ("number of teeth", "z", "", *teeth),
        ("number of teeth of the mate", "z", "", *teeth[::-1]),
        ("hand of spiral", "", "", *hands),
    ]
    if hasattr(pair, "process") and hasattr(pair, "gear_cutting"):
        process = str(pair.process).replace("_", " ")
        rows.append(("cutting", "", "", process, f"{process}, {pair.gear_cutting}"))

    def add(name: str, *owners: object) -> None:
        entry, texts = quantity(name), []
        inch = units == "inch" and entry.display == "mm"
        for value in (getattr(owner, name, None) for owner in owners):
            shown = None if value is None else float(entry.to_display(value)) / (_INCH if inch else 1.0)
            texts.append("–" if shown is None else f"{round(shown, 6):.{4 if inch else 3}f}")
        rows.append((entry.label, entry.symbol, "in" if inch else entry.display, *texts))

    for name in _DRAWING_PAIR:
        add(name, pair, pair)
    for name in _DRAWING:
        add(name, pinion, gear)
    lengths = "inches" if units == "inch" else "mm"
    heads = ("quantity", "symbol", "unit", "pinion", "gear")
    return Table(heads, rows, f"gear data for drawings (lengths in {lengths}, angles in deg)", name="drawing")


def chordal(
    thickness: float, addendum: float, diameter: float, spiral: float, pitch_angle: float, alpha_n: float
) -> tuple[float, float, float]:
    """s_mnc, h_amc, d_mn [m] of a mean normal thickness, mean addendum and mean diameter, Formulae (208) to (215)."""
    curved = diameter / ((1.0 - (sin(spiral) * cos(alpha_n)) ** 2) * cos(pitch_angle))
    rise = addendum + 0.5 * curved * cos(pitch_angle) * (1.0 - cos(thickness / curved))
    return curved * sin(thickness / curved), rise, curved
