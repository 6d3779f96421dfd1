"""The blank of a pair: every dimension of both members from the inputs (ISO 23509).

The order is that of the standard: pitch cones (clause 6), proportions (Table 4, Annex C), dimensions (clause 7),
undercut (clause 8); then slot widths and top lands (AGMA 929) and virtual gears with contact ratios (ISO 10300-1 Annex
A).
"""

from dataclasses import dataclass, fields, replace
from math import asin, cos, sin, sqrt, tan
from pathlib import Path
from typing import Any

from efficiency.blanks import dimensions, tangency
from efficiency.blanks.agma_2003 import rate_agma
from efficiency.blanks.checks import blank_warnings, check_dimensions, check_pressure_angles
from efficiency.blanks.dimensions import factors, taper_angles
from efficiency.blanks.inputs import PairBlankInput, load_blank
from efficiency.blanks.iso_10300 import rate_flank
from efficiency.blanks.lengthwise import check_trace
from efficiency.blanks.method_1 import method_1
from efficiency.blanks.method_2 import method_2
from efficiency.blanks.method_3 import method_3
from efficiency.blanks.pair_blank import MemberBlank, PairBlank
from efficiency.blanks.rating import SIDES
from efficiency.blanks.slots import SlotGeometry, slots_and_lands
from efficiency.blanks.virtual_gears import virtual_gears
from efficiency.cutting.blank import Hand
from efficiency.cutting.process import PROCESSES
from ehl.common.errors import InputError
from ehl.common.threads import one_thread

# fields of the blank that are those of the input
_OF_INPUT = ("name", "method", "process", "shaft_angle", "hypoid_offset", "blade_groups")


@dataclass(frozen=True)
class _Parts:
    """Results of the stages for the dimensions of the members."""

    cones: tangency.PitchCones
    place: dimensions.Placement
    addendums: tuple[float, float]
    dedendums: tuple[float, float]
    angles: dimensions.FaceAndRoot
    faces: dimensions.FaceWidths
    spirals: tuple[tuple[float, float], tuple[float, float]]
    thick: dimensions.Thickness
    lands: list[dict[str, Any]]
    ends: tuple[tuple[float, float], tuple[float, float]]


@one_thread
def pair_blank(inputs: PairBlankInput | Path | str) -> PairBlank:
    """Blank of a bevel or hypoid pair after ISO 23509.

    Parameters
    ----------
    inputs : PairBlankInput, Path or str
        Inputs, a blank file, or the name of a shipped blank.

    Returns
    -------
    PairBlank

    Raises
    ------
    InputError
        The combination has no geometry; it states field, value and allowed range.
    ConvergenceError
        The iteration as printed ("standard", "tangent") does not reach its tolerance.

    Examples
    --------
    >>> import efficiency
    >>> f"{1e3 * efficiency.blank('iso23509_f4').module_normal:.3f} mm"
    '4.028 mm'
    """
    if isinstance(inputs, Path | str):
        inputs = load_blank(inputs)
    cones = pitch_cones(inputs)
    place = dimensions.placement(inputs.shaft_angle, inputs.hypoid_offset, cones)
    # limit pressure angle, and the generated ones of drive and coast side, Formulae (117) to (119)
    alpha_lim = cones.limit_pressure_angle(place.zeta_mp)
    influence = inputs.pressure_angle.limit_influence * alpha_lim
    alphas = inputs.pressure_angle.drive + influence, inputs.pressure_angle.coast - influence
    check_pressure_angles(inputs, alphas, alpha_lim)
    alpha_n = 0.5 * sum(alphas)

    # tooth depth at the calculation point, Formulae (132) to (139)
    factor = factors(inputs, cones)
    module = cones.mean_diameter_2 * cos(cones.spiral_2) / inputs.teeth_gear
    high, deep, shift = factor.addendum_factor, factor.dedendum_factor, factor.profile_shift
    addendums = module * (high + shift), module * (high - shift)
    dedendums = module * (deep - shift), module * (deep + shift)
    clearance = module * (deep - high)
    under = clearance if factor.clearance_factor_pinion is None else module * factor.clearance_factor_pinion
    dedendums = dedendums[0] + (under - clearance), dedendums[1]
    clearances = under, clearance
    working_depth = 2.0 * module * high
    if min(*addendums, *dedendums) < 0.0:
        raise InputError("depth", f"addenda {addendums[0] * 1e3:.4g}, {addendums[1] * 1e3:.4g} mm", "at least 0")

    outer_2 = cones.cone_distance_2 + cones.face_width_factor * inputs.face_width_gear
    module_outer = 2.0 * outer_2 * sin(cones.pitch_angle_2) / inputs.teeth_gear
    theta_a, theta_f, taper = taper_angles(inputs, cones, alpha_n, module_outer, addendums[1], dedendums, working_depth)
    angles = dimensions.face_and_root(
        inputs, cones, place, (theta_a, theta_f), (addendums[1], dedendums[1]), clearances
    )
    faces = dimensions.face_widths(
        inputs, cones, place, angles, module, working_depth, dedendums[1] - clearance, addendums[0]
    )
    first, second = cones.cone_distance_1, cones.cone_distance_2
    inside, outside = faces.face_width_inside, faces.face_width_outside
    ends = (first - inside[0], first + outside[0]), (second - inside[1], second + outside[1])
    # tooth trace; spiral angles of both members at toe and heel, Formulae (174) to (194)
    toe, heel = (
        sqrt(second**2 + along**2 + 2.0 * second * along * cos(place.zeta_mp))
        for along in (cone - first for cone in ends[0])
    )
    trace = check_trace(inputs, cones, (*ends[1], toe, heel), place.offset_pitch_plane)
    at_toe, at_heel = (trace.spiral(cone) + asin(place.offset_pitch_plane / cone) for cone in (toe, heel))
    spirals = (at_toe, at_heel), (trace.spiral(ends[1][0]), trace.spiral(ends[1][1]))
    outer = outer_2, spirals[1][1]
    thick = dimensions.thickness(inputs, cones, module, factor, alpha_n, outer, addendums)
    blade = inputs.inside_blade_angle_gear
    slots = SlotGeometry(
        cones=cones,
        place=place,
        trace=trace,
        angles=angles,
        ends=ends,
        module=module,
        dedendums=dedendums,
        clearance=clearances,
        thickness_gear=thick.mean_normal_thickness[1],
        backlash_in_plane=thick.backlash_normal / cos(alpha_n),
        pressure_angles=alphas,
        pitch_share=PROCESSES[inputs.process].pitch_share,
        # normal tilt of the cutter of a Formate gear, Equation (48) of AGMA 929
        cutter_tilt=None if inputs.gear_generation.rolls else 0.0 if blade is None else blade - alphas[0],
    )
    parts = _Parts(cones, place, addendums, dedendums, angles, faces, spirals, thick, slots_and_lands(slots), ends)
    pinion, gear = _member(inputs, parts, 0), _member(inputs, parts, 1)
    virtual_drive, virtual_coast = (
        virtual_gears(cones, place, module, (addendums, dedendums), inputs.face_width_gear, alpha, alpha - limit, limit)
        for alpha, limit in zip(alphas, (alpha_lim, -alpha_lim), strict=True)
    )
    undercut = dimensions.undercut_limits(inputs, cones, place, trace, ends, module, factor, (theta_a, theta_f), alphas)
    if not inputs.gear_generation.rolls:
        # a straight-sided slot that is not generated has no undercut
        undercut = tuple(point for point in undercut if point.member == "pinion")
    touching = tangency.tangent_cones(inputs, cones.pitch_angle_2, cones.mean_diameter_2, cones.spiral_2)
    pair = PairBlank(
        **{name: getattr(inputs, name) for name in _OF_INPUT},
        **_named(PairBlank, cones, place, angles, faces, trace, factor, thick),
        gear_cutting=inputs.gear_generation.name,
        pinion=pinion,
        gear=gear,
        ratio=inputs.teeth_gear / inputs.teeth_pinion,
        module_normal=module,
        module_outer=module_outer,
        offset_angle=place.zeta_m,
        offset_angle_pitch_plane=place.zeta_mp,
        limit_pressure_angle=alpha_lim,
        pressure_angle_drive=alphas[0],
        pressure_angle_coast=alphas[1],
        effective_pressure_angle_drive=alphas[0] - alpha_lim,
        effective_pressure_angle_coast=alphas[1] + alpha_lim,
        working_depth=working_depth,
        clearance=clearance,
        clearance_pinion=under,
        whole_depth_pinion=_whole_depth(pinion),
        backlash_outer_normal=thick.backlash_normal * (outer_2 * cos(spirals[1][1])) / (second * cos(cones.spiral_2)),
        backlash_outer_transverse=thick.backlash_normal / cos(alpha_n) * outer_2 / (second * cos(cones.spiral_2)),
        taper=taper,
        virtual_drive=virtual_drive,
        virtual_coast=virtual_coast,
        undercut=undercut,
        tangency_error=cones.spiral_1 - touching.spiral_1,
        defaults=(*inputs.defaults, *factor.recommended, *(() if inputs.taper else (f"taper.type = {taper}",))),
    )
    check_dimensions(pair)
    # below a contact ratio of 1 (a warning) there is no contact line in the middle
    meshes = min(virtual_drive.contact_ratio_total, virtual_coast.contact_ratio_total) > 1.0
    rated = [rate_flank(pair, inputs.rating, side) for side in SIDES] if inputs.rating and meshes else [None, None]
    agma = rate_agma(pair, inputs.rating) if inputs.rating else None
    return replace(pair, warnings=blank_warnings(pair), rating_drive=rated[0], rating_coast=rated[1], rating_agma=agma)


def pitch_cones(inputs: PairBlankInput) -> tangency.PitchCones:
    """Pitch cones by the method of the input.

    Method 1 (Gleason): the lengthwise curvature equals the limit curvature. Method 2 (Oerlikon): the pinion apex lies
    on the line from the gear apex to the cutter centre; Method 3 (Klingelnberg): the mean cone
    distance of the pinion follows from the cutter. Without offset all of them are Method 0.
    """
    try:
        cones = (method_0, method_1, method_2, method_3)[inputs.method](inputs)
    except (ValueError, ZeroDivisionError) as error:
        if isinstance(error, InputError):
            raise
        raise tangency.too_large(inputs.hypoid_offset) from None
    tangency.check_pitch_angles(cones.pitch_angle_1, cones.pitch_angle_2, inputs)
    if max(abs(cones.spiral_1), abs(cones.spiral_2)) >= tangency.SPIRAL_LIMIT:
        raise tangency.too_large(inputs.hypoid_offset)
    inner = cones.cone_distance_2 - (1.0 - cones.face_width_factor) * inputs.face_width_gear
    if inner <= 0.0:
        raise tangency.face_too_wide(inputs, inner + inputs.face_width_gear)
    return cones


def method_0(inputs: PairBlankInput) -> tangency.PitchCones:
    """Bevel pairs: the cones share their apex."""
    assert inputs.mean_spiral_angle_gear is not None
    return tangency.bevel_cones(inputs, inputs.mean_spiral_angle_gear)


def _named(kind: type[PairBlank | MemberBlank], *stages: object) -> dict[str, Any]:
    """Results of the stages that are fields of the blank under the same name."""
    known = {f.name for f in fields(kind)}
    return {name: value for stage in stages for name, value in vars(stage).items() if name in known}


def _member(inputs: PairBlankInput, parts: _Parts, i: int) -> MemberBlank:
    """Dimensions of the pinion (0) or the gear (1), Formulae (195) to (200), (216) to (225)."""
    cones, faces, place = parts.cones, parts.faces, parts.place
    delta, point = (cones.pitch_angle_1, cones.pitch_angle_2)[i], place.crossing_to_mean_point[i]
    at_places: dict[str, Any] = {}
    crowns: list[float] = []
    for at, along, cone, spiral in (
        ("outer", faces.face_width_outside[i], parts.ends[i][1], parts.spirals[i][1]),
        ("mean", 0.0, (cones.cone_distance_1, cones.cone_distance_2)[i], (cones.spiral_1, cones.spiral_2)[i]),
        ("inner", -faces.face_width_inside[i], parts.ends[i][0], parts.spirals[i][0]),
    ):
        addendum = parts.addendums[i] + along * tan(parts.angles.addendum_angle[i])
        dedendum = parts.dedendums[i] + along * tan(parts.angles.dedendum_angle[i])
        crowns.append(point + along * cos(delta) - addendum * sin(delta))
        at_places |= {
            f"{at}_cone_distance": cone,
            f"{at}_diameter": 2.0 * cone * sin(delta),
            f"{at}_addendum": addendum,
            f"{at}_dedendum": dedendum,
            f"{at}_whole_depth": addendum + dedendum,
            f"{at}_spiral_angle": spiral,
        }
        if at != "mean":
            at_places[f"{at}_tip_diameter"] = 2.0 * (cone * sin(delta) + addendum * cos(delta))
            at_places[f"{at}_root_diameter"] = 2.0 * (cone * sin(delta) - dedendum * cos(delta))
    name = ("pinion", "gear")[i]
    mounted: float | None = getattr(inputs, f"mounting_distance_{name}")
    if mounted is not None and mounted <= crowns[0]:
        where = f"mounting_distance_{name}"
        allowed = f"above {1e3 * crowns[0]:.5g} mm, the distance of the outer tip circle from the crossing point"
        raise InputError(where, f"{1e3 * mounted:.6g} mm", allowed, "The locating face is behind the teeth.")
    other: Hand = "right" if inputs.hand_pinion == "left" else "left"
    return MemberBlank(
        teeth=(inputs.teeth_pinion, inputs.teeth_gear)[i],
        hand=(inputs.hand_pinion, inputs.hand_gear or other)[i],
        pitch_angle=delta,
        **{name: both[i] for name, both in _named(MemberBlank, parts.angles, faces, place, parts.thick).items()},
        **at_places,
        face_width=faces.face_width_outside[i] + faces.face_width_inside[i],
        crossing_to_crown=crowns[0],
        crossing_to_front_crown=crowns[2],
        **parts.lands[i],
        mounting_distance=mounted,
    )


def _whole_depth(pinion: MemberBlank) -> float:
    """h_t1, outer whole depth normal to the root cone [m], Formula (226)."""
    crown = pinion.face_apex_beyond_crossing + pinion.crossing_to_crown
    apexes = pinion.root_apex_beyond_crossing - pinion.face_apex_beyond_crossing
    between = sin(pinion.addendum_angle + pinion.dedendum_angle)
    return crown / cos(pinion.face_angle) * between - apexes * sin(pinion.root_angle)
