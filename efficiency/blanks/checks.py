"""What is refused, and what a designer is warned of, with number, limit and remedy.

Limits marked M are recommendations of ISO 23509 or AGMA 2005 from memory, D follow from the geometry, O are ours.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees, gcd, sin

from efficiency.blanks.inputs import PairBlankInput
from efficiency.blanks.result import BlankWarning, PairBlank
from ehl.io.errors import InputError

KINDS = (
    "undercut",
    "top_land",
    "slot_width",
    "slot_taper",
    "cutter_radius",
    "face_width",
    "spiral_angle",
    "offset",
    "clearance",
    "contact_ratio",
    "depth_taper",
    "common_factor",
    "tangency",
)

TOP_LAND = 0.25  # of m_mn, M
SLOT_WIDTH = 0.2  # of m_mn, O: room for a blade with an edge radius
FACE_WIDTH_CONE = 0.30  # of R_e2, M
FACE_WIDTH_MODULE = 10.0  # of m_et2, M
CUTTER_TAPERED = 1.1  # smallest r_c0/(R_m2 sin beta_m2) of tapered teeth, M
CUTTER_UNIFORM = 1.5  # largest for face-milled uniform depth, M
SPIRAL_PINION = 52.0  # deg, M: about 50 in practice
OFFSET = 0.25  # of d_e2, M
CLEARANCE = 0.2  # of m_mn, M: 0.25 is usual
CONTACT_RATIO = 1.0  # D
TANGENCY = 0.005  # deg, O


def check_pressure_angles(inputs: PairBlankInput, generated: tuple[float, float], limit: float) -> None:
    """Refuse generated pressure angles no blade can have."""
    for name, alpha in zip(("drive", "coast"), generated, strict=True):
        if not 5.0 <= degrees(alpha) <= 40.0:
            raise InputError(
                f"pressure_angle.{name}",
                f"{degrees(getattr(inputs.pressure_angle, name)):.4g} deg",
                f"a generated angle of 5 to 40 deg, here {degrees(alpha):.4g} deg",
                f"The limit pressure angle is {degrees(limit):.4g} deg: change limit_influence, offset or cutter.",
            )


def check_dimensions(pair: PairBlank) -> None:
    """Refuse teeth without depth, thickness or slot.

    Raises
    ------
    InputError
        Naming the field that makes it impossible.
    """
    for name, member in (("pinion", pair.pinion), ("gear", pair.gear)):
        depths = (member.inner_whole_depth, member.outer_whole_depth)
        if min(depths) <= 0.1 * member.mean_whole_depth:
            raise InputError(
                "taper",
                pair.taper,
                f"a tooth depth at both ends above a tenth of the mean one; the {name} has {min(depths) * 1e3:.4g} mm",
                "Take a smaller face width or less taper.",
            )
        if member.root_angle <= 0.0 or member.inner_root_diameter <= 0.0:
            raise InputError(
                "taper",
                pair.taper,
                f"a root cone that stays off its axis; the {name} has a root angle of {degrees(member.root_angle):.4g} "
                f"deg and {member.inner_root_diameter * 1e3:.4g} mm root diameter at the toe",
            )
        if min(member.normal_thickness) <= 0.0:
            raise InputError(
                "depth",
                f"{min(member.normal_thickness) * 1e3:.4g} mm thick teeth of the {name}",
                "a tooth thickness above 0: change thickness factor, addendum factor or backlash",
            )
        if min(member.slot_width) <= 0.0:
            raise InputError(
                "depth",
                f"{min(member.slot_width) * 1e3:.4g} mm wide slots of the {name} at the root",
                "slots wider than 0: blades cross",
                "Take a smaller depth factor, pressure angle or thickness factor of the other sign.",
            )


def blank_warnings(pair: PairBlank) -> tuple[BlankWarning, ...]:
    """Warnings in the order of `KINDS`."""
    found = [*_teeth(pair), *_cutter_and_face(pair), *_mesh(pair)]
    return tuple(sorted(found, key=lambda warning: KINDS.index(warning.kind)))


def _teeth(pair: PairBlank) -> Iterator[BlankWarning]:
    module = pair.module_normal
    for point in pair.undercut:
        if point.undercut:
            yield BlankWarning(
                "undercut",
                f"x_hm1, {point.member} at the {point.place}",
                pair.profile_shift,
                point.limit,
                "",
                "at least" if point.member == "pinion" else "at most",
                "Change the addendum factor, raise the pressure angle or lower the depth factor.",
            )
    for name, member in (("pinion", pair.pinion), ("gear", pair.gear)):
        places = ("toe", "mean point", "heel")
        land, place = min(zip(member.top_land, places, strict=True))
        if land < TOP_LAND * module:
            yield BlankWarning(
                "top_land",
                f"{name} at the {place}",
                land * 1e3,
                TOP_LAND * module * 1e3,
                "mm",
                "at least",
                "The tooth is pointed: lower the addendum, change the thickness factor."
                if land == 0.0
                else "Lower the addendum or change the thickness factor.",
            )
        slot, place = min(zip(member.slot_width, places, strict=True))
        if slot < SLOT_WIDTH * module:
            yield BlankWarning(
                "slot_width",
                f"{name} at the {place}",
                slot * 1e3,
                SLOT_WIDTH * module * 1e3,
                "mm",
                "at least",
                "Change the thickness factor, or lower depth or pressure angle.",
            )
        if pair.process == "face_milling" and max(member.slot_width) > 2.0 * slot:
            yield BlankWarning(
                "slot_taper",
                f"{name}, widest over narrowest slot",
                max(member.slot_width) / slot,
                2.0,
                "",
                "at most",
                "The blade for the wide end cuts the other flank at the narrow one: take another depth taper.",
            )
        theta = min(member.addendum_angle, member.dedendum_angle)
        if degrees(theta) < -0.05:
            yield BlankWarning(
                "depth_taper",
                f"{name}, theta",
                degrees(theta),
                0.0,
                "deg",
                "at least",
                "The tooth grows towards the toe.",
            )


def _cutter_and_face(pair: PairBlank) -> Iterator[BlankWarning]:
    gear = pair.gear
    ratio = gear.face_width / gear.outer_cone_distance
    if ratio > FACE_WIDTH_CONE:
        yield BlankWarning(
            "face_width", "b_2/R_e2", ratio, FACE_WIDTH_CONE, "", "at most", "The toe becomes small: narrow the face."
        )
    if gear.face_width > FACE_WIDTH_MODULE * pair.module_outer:
        yield BlankWarning(
            "face_width",
            "b_2",
            gear.face_width * 1e3,
            FACE_WIDTH_MODULE * pair.module_outer * 1e3,
            "mm",
            "at most",
            "Ten outer modules are usual: narrow the face.",
        )
    natural = gear.mean_cone_distance * sin(gear.mean_spiral_angle)
    if pair.process == "face_milling" and natural > 0.0:
        if pair.taper != "uniform" and pair.cutter_radius < CUTTER_TAPERED * natural:
            yield _cutter(pair, CUTTER_TAPERED * natural, "at least", "Smaller cutters ask for uniform depth.")
        if pair.taper == "uniform" and pair.cutter_radius > CUTTER_UNIFORM * natural:
            yield _cutter(pair, CUTTER_UNIFORM * natural, "at most", "Larger cutters ask for tapered depth.")
    for name, member in (("pinion", pair.pinion), ("gear", gear)):
        if degrees(member.mean_spiral_angle) > SPIRAL_PINION:
            yield BlankWarning(
                "spiral_angle",
                f"{name}, beta_m",
                degrees(member.mean_spiral_angle),
                SPIRAL_PINION,
                "deg",
                "at most",
                "Axial forces and sliding grow: lower the spiral angle or the offset.",
            )
        if member.inner_spiral_angle < 0.0:
            yield BlankWarning(
                "spiral_angle",
                f"{name}, beta_i",
                degrees(member.inner_spiral_angle),
                0.0,
                "deg",
                "at least",
                "The tooth turns back at the toe: take a larger cutter or spiral angle.",
            )
    if pair.hypoid_offset > OFFSET * gear.outer_diameter:
        yield BlankWarning(
            "offset",
            "a",
            pair.hypoid_offset * 1e3,
            OFFSET * gear.outer_diameter * 1e3,
            "mm",
            "at most",
            "Sliding and heat grow with the offset.",
        )


def _cutter(pair: PairBlank, limit: float, side: str, remedy: str) -> BlankWarning:
    return BlankWarning("cutter_radius", "r_c0", pair.cutter_radius * 1e3, limit * 1e3, "mm", side, remedy)


def _mesh(pair: PairBlank) -> Iterator[BlankWarning]:
    if pair.clearance < CLEARANCE * pair.module_normal * (1.0 - 1e-9):
        yield BlankWarning(
            "clearance",
            "c",
            pair.clearance * 1e3,
            CLEARANCE * pair.module_normal * 1e3,
            "mm",
            "at least",
            "Raise the clearance factor: the edge radius of the mating blade needs room.",
        )
    for side, virtual in (("drive", pair.virtual_drive), ("coast", pair.virtual_coast)):
        if virtual.contact_ratio_total < CONTACT_RATIO:
            yield BlankWarning(
                "contact_ratio",
                f"total, {side} side",
                virtual.contact_ratio_total,
                CONTACT_RATIO,
                "",
                "at least",
                "A tooth leaves the mesh before the next one enters: raise spiral angle, face width or depth.",
            )
    teeth = pair.pinion.teeth, pair.gear.teeth
    pairs = [("z_1 and z_2", *teeth)]
    if pair.blade_groups is not None:
        pairs += [("z_0 and z_1", pair.blade_groups, teeth[0]), ("z_0 and z_2", pair.blade_groups, teeth[1])]
    for name, first, second in pairs:
        if gcd(first, second) > 1 and first > 1 and pair.process == "face_hobbing":
            yield BlankWarning(
                "common_factor",
                name,
                gcd(first, second),
                1,
                "",
                "at most",
                "Errors of one blade group or tooth always meet the same teeth; take numbers without common factor.",
            )
    if abs(degrees(pair.tangency_error)) > TANGENCY:
        yield BlankWarning(
            "tangency",
            "spiral angle of the pinion against touching cones",
            abs(degrees(pair.tangency_error)),
            TANGENCY,
            "deg",
            "at most",
            "The method as printed stops early: take pitch_cones = 'tangent' or 'converged' for flanks.",
        )
