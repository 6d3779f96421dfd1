"""Tables of a blank: the pair, both members, the virtual gears; defaults and warnings below."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ehl.common.quantities import quantity
from ehl.common.table import Column, Table

if TYPE_CHECKING:
    from efficiency.blanks.pair_blank import PairBlank

_MEMBER = (
    "pitch_angle",
    "face_angle",
    "root_angle",
    "addendum_angle",
    "dedendum_angle",
    "mean_spiral_angle",
    "outer_spiral_angle",
    "inner_spiral_angle",
    "outer_cone_distance",
    "mean_cone_distance",
    "inner_cone_distance",
    "face_width",
    "face_width_outside",
    "face_width_inside",
    "outer_diameter",
    "mean_diameter",
    "inner_diameter",
    "outer_tip_diameter",
    "inner_tip_diameter",
    "outer_root_diameter",
    "inner_root_diameter",
    "outer_addendum",
    "mean_addendum",
    "inner_addendum",
    "outer_dedendum",
    "mean_dedendum",
    "inner_dedendum",
    "outer_whole_depth",
    "mean_whole_depth",
    "inner_whole_depth",
    "thickness_coefficient",
    "mean_normal_thickness",
    "mean_transverse_thickness",
    "mean_chordal_thickness",
    "mean_chordal_addendum",
    "crossing_to_mean_point",
    "pitch_apex_beyond_crossing",
    "face_apex_beyond_crossing",
    "root_apex_beyond_crossing",
    "crossing_to_crown",
    "crossing_to_front_crown",
)
_PAIR = (
    "ratio",
    "shaft_angle",
    "hypoid_offset",
    "module_normal",
    "module_outer",
    "offset_angle",
    "offset_angle_pitch_plane",
    "offset_angle_root_plane",
    "offset_angle_face_plane",
    "offset_pitch_plane",
    "limit_pressure_angle",
    "pressure_angle_drive",
    "pressure_angle_coast",
    "effective_pressure_angle_drive",
    "effective_pressure_angle_coast",
    "profile_shift",
    "working_depth",
    "clearance",
    "whole_depth_pinion",
    "backlash_normal",
    "cutter_radius",
    "cutter_lead_angle",
    "crown_to_cutter",
    "epicycloid_base_radius",
)
_VIRTUAL = (
    "contact_ratio_profile",
    "contact_ratio_overlap",
    "contact_ratio_total",
    "contact_ratio_overlap_full",
    "relative_radius",
)
_AT_PLACES = ("normal_thickness", "top_land", "slot_width")
_DECIMALS = 12  # in SI; what is less is rounding error


def blank_tables(pair: PairBlank) -> list[Table]:
    """Tables of the pair, of both members, and of its virtual gears; defaults and warnings below the last."""
    places = [(name, i, place) for name in _AT_PLACES for i, place in enumerate(("toe", "mean", "heel"))]
    members = [
        (
            name,
            *(round(getattr(member, field), _DECIMALS) for field in _MEMBER),
            *(round(getattr(member, field)[i], _DECIMALS) for field, i, _ in places),
        )
        for name, member in (("pinion", pair.pinion), ("gear", pair.gear))
    ]
    virtual = [
        (side, *(getattr(gears, field) for field in _VIRTUAL))
        for side, gears in (("drive", pair.virtual_drive), ("coast", pair.virtual_coast))
    ]
    process, taper = pair.process.replace("_", " "), pair.taper.replace("_", " ")
    title = f"{pair.name}: {pair.pinion.teeth}x{pair.gear.teeth}, Method {pair.method}, {process}"
    at_places = [_column(name, place) for name, _, place in places]
    notes = [f"default: {item}" for item in pair.defaults] + [f"warning: {item}" for item in pair.warnings]
    return [
        Table(
            _columns(_PAIR),
            [[round(getattr(pair, name), _DECIMALS) for name in _PAIR]],
            title,
            name="pair",
            vertical=True,
        ),
        Table(
            ["member", *_columns(_MEMBER), *at_places],
            members,
            f"members ({taper} depth taper; pinion {pair.pinion.hand} hand, gear {pair.gear.hand} hand)",
            name="members",
            vertical=True,
        ),
        Table(
            ["side", *_columns(_VIRTUAL)],
            virtual,
            "virtual gears (ISO 10300-1, 85 % of the face)",
            notes,
            "virtual_gears",
            vertical=True,
        ),
    ]


def _columns(names: Sequence[str]) -> list[Column]:
    return [_column(name) for name in names]


def _column(name: str, place: str = "") -> Column:
    entry = quantity(name)
    label = f"{entry.label}, {place}" if place else entry.label
    symbol = f" ({entry.symbol})" if entry.symbol else ""
    return Column(f"{name}_{place}" if place else name, of=name, label=label + symbol, digits=6)
