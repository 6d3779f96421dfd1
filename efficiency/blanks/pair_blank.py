"""Blank of a pair: every dimension of both members, and design warnings."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from math import nan, tan
from typing import Any

from efficiency.blanks.agma_2003 import AgmaRating
from efficiency.blanks.dimensions import UndercutLimit
from efficiency.blanks.drawing import drawing_table
from efficiency.blanks.iso_10300 import FlankRating
from efficiency.blanks.slots import Three
from efficiency.blanks.virtual_gears import VirtualGears
from efficiency.cutting.blank import Blank, Hand
from ehl.common.arrays import finite_or_none
from ehl.common.pages import Reportable
from ehl.common.quantities import quantity
from ehl.common.sections import Folded, Head, Item, Medium, Section
from ehl.common.table import Column, Table


@dataclass(frozen=True)
class BlankWarning:
    """A design warning."""

    kind: str  # one of `efficiency.blanks.checks.KINDS`
    place: str  # member and place, or the measured quantity
    # in `unit`; the warning says on which side of the limit the value should be
    value: float
    limit: float
    unit: str  # mm, deg or empty
    side: str  # "at least" or "at most"
    remedy: str  # what to change

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        name = self.kind.replace("_", " ")
        return (
            f"{name}, {self.place}: {self.value:.4g}{unit}, should be {self.side} {self.limit:.4g}{unit}. {self.remedy}"
        )


@dataclass(frozen=True)
class MemberBlank:
    """Blank of one member: lengths [m], angles [rad]; outer is the heel, inner the toe, mean the calculation point."""

    teeth: int  # z
    hand: Hand  # hand of spiral
    # delta, delta_a, delta_f
    pitch_angle: float
    face_angle: float
    root_angle: float
    # theta_a, theta_f
    addendum_angle: float
    dedendum_angle: float
    # R_e, R_m, R_i
    outer_cone_distance: float
    mean_cone_distance: float
    inner_cone_distance: float
    # b, and b_e, b_i from the calculation point
    face_width: float
    face_width_outside: float
    face_width_inside: float
    # d_e, d_m, d_i of the pitch cone
    outer_diameter: float
    mean_diameter: float
    inner_diameter: float
    # d_ae, d_ai
    outer_tip_diameter: float
    inner_tip_diameter: float
    # d_fe, d_fi
    outer_root_diameter: float
    inner_root_diameter: float
    # h_ae, h_am, h_ai
    outer_addendum: float
    mean_addendum: float
    inner_addendum: float
    # h_fe, h_fm, h_fi
    outer_dedendum: float
    mean_dedendum: float
    inner_dedendum: float
    # h_e, h_m, h_i, normal to the pitch cone
    outer_whole_depth: float
    mean_whole_depth: float
    inner_whole_depth: float
    # beta_e, beta_m, beta_i
    outer_spiral_angle: float
    mean_spiral_angle: float
    inner_spiral_angle: float
    thickness_coefficient: float  # x_sm
    # s_mn, s_mt, circular, at the pitch cone
    mean_normal_thickness: float
    mean_transverse_thickness: float
    mean_normal_diameter: float  # d_mn
    # s_mnc, h_amc
    mean_chordal_thickness: float
    mean_chordal_addendum: float
    crossing_to_mean_point: float  # t_zm, along the axis
    # t_z, t_zF, t_zR
    pitch_apex_beyond_crossing: float
    face_apex_beyond_crossing: float
    root_apex_beyond_crossing: float
    # t_xo, t_xi
    crossing_to_crown: float
    crossing_to_front_crown: float
    # W, s_n, s_an at toe, mean point and heel (AGMA 929, generated teeth)
    slot_width: Three
    normal_thickness: Three
    top_land: Three
    mounting_distance: float | None = None  # from the crossing point to the locating face, along the axis

    @property
    def crown_to_back(self) -> float | None:
        """From the outer tip circle to the locating face, along the axis [m]; None without mounting distance."""
        return None if self.mounting_distance is None else self.mounting_distance - self.crossing_to_crown

    @property
    def front_crown_to_back(self) -> float | None:
        """From the inner tip circle to the locating face, along the axis [m]; None without mounting distance."""
        return None if self.mounting_distance is None else self.mounting_distance - self.crossing_to_front_crown

    @property
    def middle_shift(self) -> float:
        """Middle of the face beyond the calculation point, along the pitch cone towards the heel [m]."""
        return 0.5 * (self.face_width_outside - self.face_width_inside)

    @property
    def cones(self) -> Blank:
        """Blank of the flanks (table `blank` of a design file); its mean point is the middle of the face."""
        shift = self.middle_shift
        own: dict[str, Any] = {name: getattr(self, name) for name in Blank.model_fields}
        own["mean_cone_distance"] += shift
        own["mean_addendum"] += shift * tan(self.addendum_angle)
        own["mean_dedendum"] += shift * tan(self.dedendum_angle)
        return Blank(**own)


@dataclass(frozen=True, repr=False)
class PairBlank(Reportable):
    """Blank of a pair: lengths in m, angles in rad."""

    name: str
    method: int
    process: str
    gear_cutting: str
    pinion: MemberBlank
    gear: MemberBlank
    ratio: float  # u = z_2/z_1
    # Sigma, a
    shaft_angle: float
    hypoid_offset: float
    cutter_radius: float  # r_c0
    blade_groups: int | None  # z_0; None for a face mill
    module_normal: float  # m_mn, mean normal module
    module_outer: float  # m_et2, outer transverse module of the gear
    # zeta_m, zeta_mp
    offset_angle: float
    offset_angle_pitch_plane: float
    # zeta_R, zeta_o
    offset_angle_root_plane: float
    offset_angle_face_plane: float
    offset_pitch_plane: float  # a_p
    limit_pressure_angle: float  # alpha_lim
    # alpha_nD, alpha_nC, generated
    pressure_angle_drive: float
    pressure_angle_coast: float
    # alpha_eD, alpha_eC
    effective_pressure_angle_drive: float
    effective_pressure_angle_coast: float
    # x_hm1, k_hap, k_hfp, x_smn
    profile_shift: float
    addendum_factor: float
    dedendum_factor: float
    thickness_modification: float
    # h_mw, c
    working_depth: float
    clearance: float  # of the gear root from the pinion tips
    clearance_pinion: float  # of the pinion root from the gear tips
    whole_depth_pinion: float  # h_t1, outer whole depth of the pinion normal to its root cone
    face_width_factor: float  # c_be2
    face_width_pinion_pitch_plane: float  # b_p1
    cutter_lead_angle: float  # nu; 0 for a face mill
    # rho_P0, rho_b; equal for a face mill
    crown_to_cutter: float
    epicycloid_base_radius: float
    backlash_normal: float  # j_mn, mean normal backlash
    # j_en, j_et2: at the heel of the gear, normal to the flanks and along the pitch circle
    backlash_outer_normal: float
    backlash_outer_transverse: float
    taper: str  # depth taper used
    # virtual cylindrical gears of both flanks
    virtual_drive: VirtualGears
    virtual_coast: VirtualGears
    undercut: tuple[UndercutLimit, ...]  # limits of x_hm1
    # trials of the method; residual of its condition; deviation of the spiral angle of the pinion from that of exactly
    # touching cones
    trials: int
    closure: float
    tangency_error: float
    defaults: tuple[str, ...]  # recommended values used as defaults
    warnings: tuple[BlankWarning, ...] = ()  # design warnings
    # load capacity of both flanks, if the file has a table `rating`
    rating_drive: FlankRating | None = None
    rating_coast: FlankRating | None = None
    rating_agma: AgmaRating | None = None  # after AGMA 2003, with a table `rating.agma_2003`

    def __repr__(self) -> str:
        return (
            f"PairBlank({self.name!r}: {self.pinion.teeth}x{self.gear.teeth}, Method {self.method}, {self.process}, "
            f"hypoid_offset={self.hypoid_offset:.4g} m, module_normal={self.module_normal:.4g} m, "
            f"{len(self.warnings)} warnings)"
        )

    status = "converged"  # a combination without geometry is an error
    reason = ""

    @property
    def pinion_below(self) -> bool:
        """Whether the pinion axis is below the gear axis, seen on the gear teeth with the pinion to the right."""
        return (self.hypoid_offset > 0.0) == (self.pinion.hand == "left")

    def to_dict(self) -> dict[str, Any]:
        """All values as plain numbers, lists and tables: SI units, names of docs/nomenclature.md."""
        return dict(finite_or_none(asdict(self)))

    def drawing_table(self) -> Table:
        """Gear data for the drawings of both members, with symbol and unit (mm, deg)."""
        return drawing_table(self, self.pinion, self.gear)

    def sections(self, medium: Medium = "page", *args: Any, **options: Any) -> list[Section]:
        """Tables of the pair, of both members, and of its virtual gears; defaults and warnings below the last table."""
        places = [(name, i, place) for name in _AT_PLACES for i, place in enumerate(("toe", "mean", "heel"))]
        members = []
        for name, member in (("pinion", self.pinion), ("gear", self.gear)):
            values = [*(getattr(member, field) for field in _MEMBER), *(getattr(member, n)[i] for n, i, _ in places)]
            members.append((name, *(round(value, _DECIMALS) for value in values)))
        pair = [[round(getattr(self, name), _DECIMALS) for name in _PAIR]]
        virtual = [
            (side, *(getattr(gears, field) for field in _VIRTUAL))
            for side, gears in (("drive", self.virtual_drive), ("coast", self.virtual_coast))
        ]
        process, taper = self.process.replace("_", " "), self.taper.replace("_", " ")
        title = f"{self.name}: {self.pinion.teeth}x{self.gear.teeth}, Method {self.method}, {process}"
        hands = f"pinion {self.pinion.hand} hand, gear {self.gear.hand} hand"
        if self.hypoid_offset:
            hands += f", pinion axis {'below' if self.pinion_below else 'above'} the gear axis"
        at_places = [_column(name, place) for name, _, place in places]
        notes = [f"default: {item}" for item in self.defaults] + [f"warning: {item}" for item in self.warnings]
        of_members, of_virtual = (
            f"members ({taper} depth taper; {hands})",
            "virtual gears (ISO 10300-1, 85 % of the face)",
        )
        heads: list[Column | str] = ["member", *_columns(_MEMBER), *at_places]
        tables: list[Item] = [
            Table(_columns(_PAIR), pair, title, name="pair", vertical=True),
            Table(heads, members, of_members, name="members", vertical=True),
            Table(["side", *_columns(_VIRTUAL)], virtual, of_virtual, notes, "virtual_gears", vertical=True),
        ]
        if medium == "page":
            tables.append(Folded("Gear data for drawings", [self.drawing_table()]))
        elif medium == "files":
            tables.append(self.drawing_table())
        if self.rating_drive and self.rating_coast:
            tables += rating_tables({"drive": self.rating_drive, "coast": self.rating_coast})
        tables += agma_tables(self.rating_agma)
        return [Section("", [Head(title), *tables])]


def rating_tables(flanks: Mapping[str, FlankRating], notes: Sequence[str] = ()) -> list[Item]:
    """The rating sheet after ISO 10300: common values, and values of each member."""
    return _rating(flanks, "load capacity after ISO 10300, Method B1", ("rating", "safety"), notes)


def agma_tables(rated: AgmaRating | None) -> list[Item]:
    """The rating sheet after AGMA 2003, empty without one."""
    title = "load capacity after AGMA 2003"
    return _rating({"both": rated}, title, ("rating_agma", "safety_agma")) if rated else []


def _rating(
    flanks: Mapping[str, FlankRating | AgmaRating], title: str, names: tuple[str, str], notes: Sequence[str] = ()
) -> list[Item]:
    first = next(iter(flanks.values()))
    shared = [f.name for f in fields(first) if f.type == "float"]
    members = {}
    for side, flank in flanks.items():
        every = vars(flank) | (vars(flank.spectrum) if flank.spectrum else {})
        members[side] = {name: value for name, value in every.items() if isinstance(value, tuple)}
    # a flank that no step of the spectrum loads has no damage
    own = list(dict.fromkeys(name for values in members.values() for name in values))
    unknown = nan, nan
    rows = [
        (side, member, *(values.get(name, unknown)[i] for name in own))
        for side, values in members.items()
        for i, member in enumerate(("pinion", "gear"))
    ]
    note = "after public sources, not the standard: not a certified calculation"
    common = [(side, *(getattr(flank, name) for name in shared)) for side, flank in flanks.items()]
    heads: list[Column | str] = ["side", "member", *_columns(own, 4)]
    return [
        Table(["side", *_columns(shared, 4)], common, title, name=names[0], vertical=True),
        Table(heads, rows, "stresses and safety", [*notes, note], names[1], vertical=True),
    ]


_MEMBER = tuple(f.name for f in fields(MemberBlank) if f.type is float)
_PAIR = tuple(f.name for f in fields(PairBlank) if f.type is float)
_VIRTUAL = (
    *("contact_ratio_profile", "contact_ratio_overlap", "contact_ratio_total"),
    *("contact_ratio_overlap_full", "relative_radius"),
)
_AT_PLACES = ("normal_thickness", "top_land", "slot_width")
_DECIMALS = 12  # in SI; smaller values are rounding error


def _columns(names: Sequence[str], digits: int = 6) -> list[Column]:
    return [_column(name, digits=digits) for name in names]


def _column(name: str, place: str = "", digits: int = 6) -> Column:
    entry = quantity(name)
    label = f"{entry.label}, {place}" if place else entry.label
    symbol = f" ({entry.symbol})" if entry.symbol else ""
    return Column(f"{name}_{place}" if place else name, of=name, label=label + symbol, digits=digits)
