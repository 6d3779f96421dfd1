"""Refusals and warnings for a blank, with value, limit and remedy.

Limits marked M are recommendations of ISO 23509 or AGMA 2005 (unverified), D follow from the geometry, O are own
choices.
"""

from collections.abc import Iterator
from math import degrees, sin

from efficiency.blanks.inputs import PairBlankInput
from efficiency.blanks.pair_blank import BlankWarning, PairBlank
from efficiency.cutting.process import PROCESSES
from ehl.common.errors import InputError

KINDS = (
    *("undercut", "top_land", "slot_width", "slot_taper", "cutter_radius", "face_width", "spiral_angle", "offset"),
    *("clearance", "contact_ratio", "depth_taper", "common_factor", "tangency"),
)

TOP_LAND = 0.25  # of m_mn, M
SLOT_WIDTH = 0.2  # of m_mn, O: room for a blade with an edge radius
FACE_WIDTH_CONE = 0.30  # of R_e2, M
FACE_WIDTH_MODULE = 10.0  # of m_et2, M
SPIRAL_PINION = 52.0  # deg, M: about 50 in practice
OFFSET = 0.25  # of d_e2, M
CLEARANCE = 0.2  # of m_mn, M: 0.25 is usual
CONTACT_RATIO = 1.0  # D
TANGENCY = 0.005  # deg, O


def check_pressure_angles(inputs: PairBlankInput, generated: tuple[float, float], limit: float) -> None:
    """Refuse generated pressure angles outside the range of blades."""
    for name, alpha in zip(("drive", "coast"), generated, strict=True):
        if not 5.0 <= degrees(alpha) <= 40.0:
            where = f"pressure_angle.{name}"
            stated = f"{degrees(getattr(inputs.pressure_angle, name)):.4g} deg"
            hint = f"The limit pressure angle is {degrees(limit):.4g} deg: change limit_influence, offset or cutter."
            raise InputError(where, stated, f"a generated angle of 5 to 40 deg, here {degrees(alpha):.4g} deg", hint)


def check_dimensions(pair: PairBlank) -> None:
    """Refuse teeth without depth, thickness or slot."""
    for name, member in (("pinion", pair.pinion), ("gear", pair.gear)):
        depths = (member.inner_whole_depth, member.outer_whole_depth)
        if min(depths) <= 0.1 * member.mean_whole_depth:
            allowed = f"a tooth depth at both ends above a tenth of the mean; the {name} has {min(depths) * 1e3:.4g} mm"
            raise InputError("taper", pair.taper, allowed, "Use a smaller face width or less taper.")
        if member.root_angle <= 0.0 or member.inner_root_diameter <= 0.0:
            raise InputError(
                "taper",
                pair.taper,
                f"a root cone clear of its axis; the {name} has a root angle of {degrees(member.root_angle):.4g} "
                f"deg and {member.inner_root_diameter * 1e3:.4g} mm root diameter at the toe",
            )
        if min(member.normal_thickness) <= 0.0:
            allowed = "a tooth thickness above 0: change thickness factor, addendum factor or backlash"
            raise InputError("depth", f"{min(member.normal_thickness) * 1e3:.4g} mm thick teeth of the {name}", allowed)
        if min(member.slot_width) <= 0.0:
            stated = f"{min(member.slot_width) * 1e3:.4g} mm wide slots of the {name} at the root"
            hint = "Use a smaller depth factor or pressure angle, or a thickness factor of the other sign."
            raise InputError("depth", stated, "slots wider than 0, in which the blades do not cross", hint)


def blank_warnings(pair: PairBlank) -> tuple[BlankWarning, ...]:
    """Warnings in the order of `KINDS`."""
    found = [*_teeth(pair), *_cutter_and_face(pair), *_mesh(pair)]
    return tuple(sorted(found, key=lambda warning: KINDS.index(warning.kind)))


def _at_least(
    kind: str, what: str, value: float, limit: float, unit: str, remedy: str, slack: float = 0.0
) -> Iterator[BlankWarning]:
    if value < limit - slack:
        yield BlankWarning(kind, what, value, limit, unit, "at least", remedy)


def _at_most(kind: str, what: str, value: float, limit: float, unit: str, remedy: str) -> Iterator[BlankWarning]:
    if value > limit:
        yield BlankWarning(kind, what, value, limit, unit, "at most", remedy)


def _teeth(pair: PairBlank) -> Iterator[BlankWarning]:
    module, process = pair.module_normal * 1e3, PROCESSES[pair.process]
    for point in pair.undercut:
        check = _at_least if point.member == "pinion" else _at_most
        remedy = "Change the addendum factor, raise the pressure angle or lower the depth factor."
        what = f"x_hm1, {point.member} at the {point.place}"
        yield from check("undercut", what, pair.profile_shift, point.limit, "", remedy)
    for name, member in (("pinion", pair.pinion), ("gear", pair.gear)):
        places = ("toe", "mean point", "heel")
        land, place = min(zip(member.top_land, places, strict=True))
        remedy = "Lower the addendum or change the thickness factor."
        if land == 0.0:
            remedy = "The tooth is pointed: lower the addendum, change the thickness factor."
        yield from _at_least("top_land", f"{name} at the {place}", land * 1e3, TOP_LAND * module, "mm", remedy)
        slot, place = min(zip(member.slot_width, places, strict=True))
        remedy = "Change the thickness factor, or lower depth or pressure angle."
        yield from _at_least("slot_width", f"{name} at the {place}", slot * 1e3, SLOT_WIDTH * module, "mm", remedy)
        what, ratio = f"{name}, widest over narrowest slot", max(member.slot_width) / slot
        remedy = "A blade for the wide end would cut the opposite flank at the narrow end: use another depth taper."
        yield from _at_most("slot_taper", what, ratio, process.widest_slot, "", remedy)
        theta = degrees(min(member.addendum_angle, member.dedendum_angle))
        remedy = "The tooth depth increases towards the toe."
        yield from _at_least("depth_taper", f"{name}, theta", theta, 0.0, "deg", remedy, slack=0.05)


def _cutter_and_face(pair: PairBlank) -> Iterator[BlankWarning]:
    gear = pair.gear
    ratio, remedy = gear.face_width / gear.outer_cone_distance, "The toe becomes small: reduce the face width."
    yield from _at_most("face_width", "b_2/R_e2", ratio, FACE_WIDTH_CONE, "", remedy)
    limit, remedy = FACE_WIDTH_MODULE * pair.module_outer * 1e3, "Ten outer modules are usual: reduce the face width."
    yield from _at_most("face_width", "b_2", gear.face_width * 1e3, limit, "mm", remedy)
    natural = gear.mean_cone_distance * sin(gear.mean_spiral_angle) * 1e3
    cutter = PROCESSES[pair.process].radius_limit(pair.taper, natural)
    if cutter is not None:
        check = _at_least if cutter.side == "at least" else _at_most
        yield from check("cutter_radius", "r_c0", pair.cutter_radius * 1e3, cutter.limit, "mm", cutter.remedy)
    for name, member in (("pinion", pair.pinion), ("gear", gear)):
        mean, inner = degrees(member.mean_spiral_angle), degrees(member.inner_spiral_angle)
        remedy = "Axial forces and sliding increase: lower the spiral angle or the offset."
        yield from _at_most("spiral_angle", f"{name}, beta_m", mean, SPIRAL_PINION, "deg", remedy)
        remedy = "The spiral angle changes its sign at the toe: use a larger cutter or spiral angle."
        yield from _at_least("spiral_angle", f"{name}, beta_i", inner, 0.0, "deg", remedy)
    limit, remedy = OFFSET * gear.outer_diameter * 1e3, "Sliding and heat increase with the offset."
    yield from _at_most("offset", "a", abs(pair.hypoid_offset) * 1e3, limit, "mm", remedy)


def _mesh(pair: PairBlank) -> Iterator[BlankWarning]:
    limit = CLEARANCE * pair.module_normal * 1e3
    remedy = "Raise the clearance factor: the edge radius of the mating blade needs space."
    yield from _at_least(
        "clearance", "c", 1e3 * min(pair.clearance, pair.clearance_pinion), limit, "mm", remedy, slack=1e-9 * limit
    )
    remedy = "One tooth pair leaves the mesh before the next one enters: raise spiral angle, face width or depth."
    for side, virtual in (("drive", pair.virtual_drive), ("coast", pair.virtual_coast)):
        total = virtual.contact_ratio_total
        yield from _at_least("contact_ratio", f"total, {side} side", total, CONTACT_RATIO, "", remedy)
    remedy = "The same teeth always meet: use numbers of teeth without a common factor."
    teeth = pair.pinion.teeth, pair.gear.teeth
    for what, factor in PROCESSES[pair.process].common_factors(pair.blade_groups or 0, teeth):
        yield from _at_most("common_factor", what, factor, 1, "", remedy)
    what, error = "spiral angle of the pinion against touching cones", abs(degrees(pair.tangency_error))
    remedy = "The iteration of the standard stops early: use pitch_cones = 'tangent' or 'converged' for flanks."
    yield from _at_most("tangency", what, error, TANGENCY, "deg", remedy)
