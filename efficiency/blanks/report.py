"""Tables of a blank: the pair, both members, the virtual gears; defaults and warnings below."""

from collections.abc import Sequence
from dataclasses import fields

from efficiency.blanks.pair_blank import MemberBlank, PairBlank
from ehl.common.quantities import quantity
from ehl.common.sections import Head, Item, Medium, Section
from ehl.common.table import Column, Table

_MEMBER = tuple(f.name for f in fields(MemberBlank) if f.type is float)
_PAIR = tuple(f.name for f in fields(PairBlank) if f.type is float)
_VIRTUAL = (
    "contact_ratio_profile",
    "contact_ratio_overlap",
    "contact_ratio_total",
    "contact_ratio_overlap_full",
    "relative_radius",
)
_AT_PLACES = ("normal_thickness", "top_land", "slot_width")
_DECIMALS = 12  # in SI; what is less is rounding error


def blank_sections(pair: PairBlank, medium: Medium) -> list[Section]:
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
    tables: list[Item] = [
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
    return [Section("", [Head(title), *tables])]


def _columns(names: Sequence[str]) -> list[Column]:
    return [_column(name) for name in names]


def _column(name: str, place: str = "") -> Column:
    entry = quantity(name)
    label = f"{entry.label}, {place}" if place else entry.label
    symbol = f" ({entry.symbol})" if entry.symbol else ""
    return Column(f"{name}_{place}" if place else name, of=name, label=label + symbol, digits=6)
