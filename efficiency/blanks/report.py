"""What the command line shows of a blank: tables of the pair, of both members, and the warnings."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from efficiency.blanks.result import PairBlank

# field, symbol; the unit follows from the kind of the quantity
_MEMBER = (
    ("pitch_angle", "δ"),
    ("face_angle", "δa"),
    ("root_angle", "δf"),
    ("addendum_angle", "θa"),
    ("dedendum_angle", "θf"),
    ("mean_spiral_angle", "βm"),
    ("outer_spiral_angle", "βe"),
    ("inner_spiral_angle", "βi"),
    ("outer_cone_distance", "Re"),
    ("mean_cone_distance", "Rm"),
    ("inner_cone_distance", "Ri"),
    ("face_width", "b"),
    ("face_width_outside", "be"),
    ("face_width_inside", "bi"),
    ("outer_diameter", "de"),
    ("mean_diameter", "dm"),
    ("inner_diameter", "di"),
    ("outer_tip_diameter", "dae"),
    ("inner_tip_diameter", "dai"),
    ("outer_root_diameter", "dfe"),
    ("inner_root_diameter", "dfi"),
    ("outer_addendum", "hae"),
    ("mean_addendum", "ham"),
    ("inner_addendum", "hai"),
    ("outer_dedendum", "hfe"),
    ("mean_dedendum", "hfm"),
    ("inner_dedendum", "hfi"),
    ("outer_whole_depth", "he"),
    ("mean_whole_depth", "hm"),
    ("inner_whole_depth", "hi"),
    ("thickness_coefficient", "xsm"),
    ("mean_normal_thickness", "smn"),
    ("mean_transverse_thickness", "smt"),
    ("mean_chordal_thickness", "smnc"),
    ("mean_chordal_addendum", "hamc"),
    ("crossing_to_mean_point", "tzm"),
    ("pitch_apex_beyond_crossing", "tz"),
    ("face_apex_beyond_crossing", "tzF"),
    ("root_apex_beyond_crossing", "tzR"),
    ("crossing_to_crown", "txo"),
    ("crossing_to_front_crown", "txi"),
)
_PAIR = (
    ("ratio", "u"),
    ("shaft_angle", "Σ"),
    ("hypoid_offset", "a"),
    ("module_normal", "mmn"),
    ("module_outer", "met2"),
    ("offset_angle", "ζm"),
    ("offset_angle_pitch_plane", "ζmp"),
    ("offset_angle_root_plane", "ζR"),
    ("offset_angle_face_plane", "ζo"),
    ("offset_pitch_plane", "ap"),
    ("limit_pressure_angle", "αlim"),
    ("pressure_angle_drive", "αnD"),
    ("pressure_angle_coast", "αnC"),
    ("effective_pressure_angle_drive", "αeD"),
    ("effective_pressure_angle_coast", "αeC"),
    ("profile_shift", "xhm1"),
    ("working_depth", "hmw"),
    ("clearance", "c"),
    ("whole_depth_pinion", "ht1"),
    ("backlash_normal", "jmn"),
    ("cutter_radius", "rc0"),
    ("cutter_lead_angle", "ν"),
    ("crown_to_cutter", "ρP0"),
    ("epicycloid_base_radius", "ρb"),
)
_CONTACT = (
    ("contact_ratio_profile", "εvα"),
    ("contact_ratio_overlap", "εvβ"),
    ("contact_ratio_total", "εvγ"),
    ("contact_ratio_overlap_full", "εvβ, whole face"),
    ("relative_radius", "ρrel"),
)
_NUMBERS = ("ratio", "profile_shift", "thickness_coefficient", "contact_ratio")


def _shown(name: str, value: float) -> tuple[str, str]:
    if name.startswith(_NUMBERS):
        return f"{value:.4f}", ""
    if "angle" in name and "module" not in name:
        return f"{degrees(value):.4f}", "deg"
    return f"{value * 1e3:.3f}", "mm"


def blank_tables(pair: PairBlank) -> None:
    """Print the blank as tables, then defaults and warnings."""
    from rich.console import Console
    from rich.table import Table

    console = Console()
    process = pair.process.replace("_", " ")
    table = Table(title=f"{pair.name}: {pair.pinion.teeth}x{pair.gear.teeth}, Method {pair.method}, {process}")
    for title in ("pair", "symbol", "value", "unit"):
        table.add_column(title, justify="right" if title == "value" else "left")
    for name, symbol in _PAIR:
        table.add_row(name, symbol, *_shown(name, getattr(pair, name)))
    console.print(table)

    table = Table(title=f"members ({pair.taper.replace('_', ' ')} depth taper)")
    for title in ("member", "symbol", "pinion", "gear", "unit"):
        table.add_column(title, justify="right" if title in ("pinion", "gear") else "left")
    table.add_row("hand", "", pair.pinion.hand, pair.gear.hand, "")
    for name, symbol in _MEMBER:
        (first, unit), (second, _) = (_shown(name, getattr(member, name)) for member in (pair.pinion, pair.gear))
        table.add_row(name, symbol, first, second, unit)
    for name, symbol in (("normal_thickness", "sn"), ("top_land", "san"), ("slot_width", "W")):
        for place, i in (("toe", 0), ("mean", 1), ("heel", 2)):
            values = (f"{getattr(member, name)[i] * 1e3:.3f}" for member in (pair.pinion, pair.gear))
            table.add_row(f"{name}, {place}", symbol, *values, "mm")
    console.print(table)

    table = Table(title="virtual gears (ISO 10300-1, 85 % of the face)")
    for title in ("contact", "symbol", "drive", "coast", "unit"):
        table.add_column(title, justify="right" if title in ("drive", "coast") else "left")
    for name, symbol in _CONTACT:
        (first, unit), (second, _) = (_shown(name, getattr(v, name)) for v in (pair.virtual_drive, pair.virtual_coast))
        table.add_row(name, symbol, first, second, unit)
    console.print(table)
    for item in pair.defaults:
        console.print(f"default  {item}", highlight=False)
    for warning in pair.warnings:
        console.print(f"[yellow]warning[/]  {warning}", highlight=False)
