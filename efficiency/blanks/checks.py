"""Refusals and warnings for a blank, with value, limit and remedy.

Limits marked M are recommendations of ISO 23509 or AGMA 2005 (unverified), D follow from the geometry, O are own
choices.
"""

from collections.abc import Iterator
from math import degrees, sin

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
SLACK = {"depth_taper": 0.05, "clearance": 1e-9}  # below the limit without a warning, deg and mm


def check_dimensions(pair: PairBlank) -> None:
    """Refuse teeth without depth, thickness or slot."""
    for name, member in (("pinion", pair.pinion), ("gear", pair.gear)):
        depths = (member.inner_whole_depth, member.outer_whole_depth)
        if min(depths) <= 0.1 * member.mean_whole_depth:
            allowed = f"a tooth depth at both ends above a tenth of the mean; the {name} has {min(depths) * 1e3:.4g} mm"
            raise InputError("taper", pair.taper, allowed, "Use a smaller face width or less taper.")
        if member.root_angle <= 0.0 or member.inner_root_diameter <= 0.0:
            angle, diameter = degrees(member.root_angle), member.inner_root_diameter * 1e3
            found = f"a root angle of {angle:.4g} deg and {diameter:.4g} mm root diameter at the toe"
            raise InputError("taper", pair.taper, f"a root cone clear of its axis; the {name} has {found}")
        if min(member.normal_thickness) <= 0.0:
            allowed = "a tooth thickness above 0: change thickness factor, addendum factor or backlash"
            raise InputError("depth", f"{min(member.normal_thickness) * 1e3:.4g} mm thick teeth of the {name}", allowed)
        if min(member.slot_width) <= 0.0:
            stated = f"{min(member.slot_width) * 1e3:.4g} mm wide slots of the {name} at the root"
            hint = "Use a smaller depth factor or pressure angle, or a thickness factor of the other sign."
            raise InputError("depth", stated, "slots wider than 0, in which the blades do not cross", hint)


def blank_warnings(pair: PairBlank) -> tuple[BlankWarning, ...]:
    """Warnings in the order of `KINDS`."""
    limits = (*_teeth(pair), *_cutter_and_face(pair), *_mesh(pair))
    return tuple(sorted(filter(_exceeded, limits), key=lambda warning: KINDS.index(warning.kind)))


def _exceeded(limit: BlankWarning) -> bool:
    if limit.side == "at most":
        return limit.value > limit.limit
    return limit.value < limit.limit - SLACK.get(limit.kind, 0.0)


def _teeth(pair: PairBlank) -> Iterator[BlankWarning]:
    """Limits of the teeth of both members."""
    module, process = pair.module_normal * 1e3, PROCESSES[pair.process]
    for point in pair.undercut:
        side = "at least" if point.member == "pinion" else "at most"
        remedy = "Change the addendum factor, raise the pressure angle or lower the depth factor."
        what = f"x_hm1, {point.member} at the {point.place}"
        yield BlankWarning("undercut", what, pair.profile_shift, point.limit, "", side, remedy)
    for name, member in (("pinion", pair.pinion), ("gear", pair.gear)):
        places = ("toe", "mean point", "heel")
        land, place = min(zip(member.top_land, places, strict=True))
        remedy = "Lower the addendum or change the thickness factor."
        if land == 0.0:
            remedy = "The tooth is pointed: lower the addendum, change the thickness factor."
        what = f"{name} at the {place}"
        yield BlankWarning("top_land", what, land * 1e3, TOP_LAND * module, "mm", "at least", remedy)
        slot, place = min(zip(member.slot_width, places, strict=True))
        remedy = "Change the thickness factor, or lower depth or pressure angle."
        what = f"{name} at the {place}"
        yield BlankWarning("slot_width", what, slot * 1e3, SLOT_WIDTH * module, "mm", "at least", remedy)
        what, ratio = f"{name}, widest over narrowest slot", max(member.slot_width) / slot
        remedy = "A blade for the wide end would cut the opposite flank at the narrow end: use another depth taper."
        yield BlankWarning("slot_taper", what, ratio, process.widest_slot, "", "at most", remedy)
        theta = degrees(min(member.addendum_angle, member.dedendum_angle))
        remedy = "The tooth depth increases towards the toe."
        yield BlankWarning("depth_taper", f"{name}, theta", theta, 0.0, "deg", "at least", remedy)


def _cutter_and_face(pair: PairBlank) -> Iterator[BlankWarning]:
    """Limits of cutter, face width, spiral angles and offset."""
    gear = pair.gear
    ratio, remedy = gear.face_width / gear.outer_cone_distance, "The toe becomes small: reduce the face width."
    yield BlankWarning("face_width", "b_2/R_e2", ratio, FACE_WIDTH_CONE, "", "at most", remedy)
    limit, remedy = FACE_WIDTH_MODULE * pair.module_outer * 1e3, "Ten outer modules are usual: reduce the face width."
    yield BlankWarning("face_width", "b_2", gear.face_width * 1e3, limit, "mm", "at most", remedy)
    natural = gear.mean_cone_distance * sin(gear.mean_spiral_angle) * 1e3
    cutter = PROCESSES[pair.process].radius_limit(pair.taper, natural)
    if cutter is not None:
        radius = pair.cutter_radius * 1e3
        yield BlankWarning("cutter_radius", "r_c0", radius, cutter.limit, "mm", cutter.side, cutter.remedy)
    for name, member in (("pinion", pair.pinion), ("gear", gear)):
        mean, inner = degrees(member.mean_spiral_angle), degrees(member.inner_spiral_angle)
        remedy = "Axial forces and sliding increase: lower the spiral angle or the offset."
        yield BlankWarning("spiral_angle", f"{name}, beta_m", mean, SPIRAL_PINION, "deg", "at most", remedy)
        remedy = "The spiral angle changes its sign at the toe: use a larger cutter or spiral angle."
        yield BlankWarning("spiral_angle", f"{name}, beta_i", inner, 0.0, "deg", "at least", remedy)
    limit, remedy = OFFSET * gear.outer_diameter * 1e3, "Sliding and heat increase with the offset."
    yield BlankWarning("offset", "a", abs(pair.hypoid_offset) * 1e3, limit, "mm", "at most", remedy)


def _mesh(pair: PairBlank) -> Iterator[BlankWarning]:
    """Limits of clearance, contact ratios, numbers of teeth and tangency."""
    limit = CLEARANCE * pair.module_normal * 1e3
    remedy = "Raise the clearance factor: the edge radius of the mating blade needs space."
    clearance = 1e3 * min(pair.clearance, pair.clearance_pinion)
    yield BlankWarning("clearance", "c", clearance, limit, "mm", "at least", remedy)
    remedy = "One tooth pair leaves the mesh before the next one enters: raise spiral angle, face width or depth."
    for side, virtual in (("drive", pair.virtual_drive), ("coast", pair.virtual_coast)):
        total = virtual.contact_ratio_total
        yield BlankWarning("contact_ratio", f"total, {side} side", total, CONTACT_RATIO, "", "at least", remedy)
    remedy = "The same teeth always meet: use numbers of teeth without a common factor."
    teeth = pair.pinion.teeth, pair.gear.teeth
    for what, factor in PROCESSES[pair.process].common_factors(pair.blade_groups or 0, teeth):
        yield BlankWarning("common_factor", what, factor, 1, "", "at most", remedy)
    what, error = "spiral angle of the pinion against touching cones", abs(degrees(pair.tangency_error))
    remedy = "The iteration of the standard stops early: use pitch_cones = 'tangent' or 'converged' for flanks."
    yield BlankWarning("tangency", what, error, TANGENCY, "deg", "at most", remedy)
