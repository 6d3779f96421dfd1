"""The blank of a pair: every dimension of both members from the inputs (ISO 23509).

The order is that of the standard: pitch cones (clause 6), proportions (Table 4, Annex C), dimensions (clause 7),
undercut (clause 8); then slot widths and top lands (AGMA 929) and virtual gears with contact ratios (ISO 10300-1 Annex
A).
"""

from dataclasses import fields, replace
from math import cos, sin, tan
from pathlib import Path
from typing import Any

from efficiency.blanks import dimensions, tangency
from efficiency.blanks.agma_2003 import rate_agma
from efficiency.blanks.checks import blank_warnings, check_dimensions
from efficiency.blanks.inputs import PairBlankInput, load_blank
from efficiency.blanks.iso_10300 import rate_flank
from efficiency.blanks.lengthwise import Trace, check_trace
from efficiency.blanks.method_1 import method_1
from efficiency.blanks.method_2 import method_2
from efficiency.blanks.method_3 import method_3
from efficiency.blanks.pair_blank import MemberBlank, PairBlank
from efficiency.blanks.rating import SIDES, Pair
from efficiency.blanks.slots import SlotGeometry, slots_and_lands
from efficiency.blanks.virtual_gears import virtual_gears
from efficiency.cutting.blank import Hand
from efficiency.cutting.process import PROCESSES
from ehl.common.errors import InputError
from ehl.common.threads import one_thread

# fields of the blank that are those of the input
_OF_INPUT = ("name", "method", "process", "shaft_angle", "hypoid_offset", "blade_groups")


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
    tooth = dimensions.tooth_depth(inputs, cones, place.zeta_mp)
    thetas, taper = dimensions.taper_angles(inputs, cones, tooth)
    angles = dimensions.face_and_root(inputs, cones, place, tooth, thetas)
    faces = dimensions.face_widths(inputs, cones, place, tooth, angles)
    trace, ends = _trace(inputs, cones, place, faces)
    outer_2, spiral_2 = ends[1][1], trace.spiral(ends[1][1])
    thick = dimensions.thickness(inputs, cones, tooth, (outer_2, spiral_2))
    # normal tilt of the cutter of a Formate gear, Equation (48) of AGMA 929
    blade, tilt = inputs.inside_blade_angle_gear, None
    if not inputs.gear_generation.rolls:
        tilt = 0.0 if blade is None else blade - tooth.pressure_angles[0]
    slots = SlotGeometry(
        cones,
        place,
        trace,
        angles,
        ends,
        tooth,
        thickness_gear=thick.mean_normal_thickness[1],
        backlash_in_plane=thick.backlash_normal / cos(tooth.pressure_angle),
        pitch_share=PROCESSES[inputs.process].pitch_share,
        cutter_tilt=tilt,
    )
    pinion, gear = (_member(inputs, slots, faces, thick, i) for i in (0, 1))
    heights, limit = (tooth.addendums, tooth.dedendums), tooth.limit_pressure_angle
    drive, coast = (
        virtual_gears(cones, place, tooth.module, heights, inputs.face_width_gear, alpha, own)
        for alpha, own in zip(tooth.pressure_angles, (limit, -limit), strict=True)
    )
    undercut = dimensions.undercut_limits(inputs, cones, place, tooth, trace, ends, thetas)
    if not inputs.gear_generation.rolls:
        # a straight-sided slot that is not generated has no undercut
        undercut = tuple(point for point in undercut if point.member == "pinion")
    touching = tangency.tangent_cones(inputs, cones.pitch_angle[1], cones.mean_diameter[1], cones.spiral[1])
    across = cones.cone_distance[1] * cos(cones.spiral[1])
    pair = PairBlank(
        **{name: getattr(inputs, name) for name in _OF_INPUT},
        **_named(PairBlank, cones, place, angles, faces, trace, tooth, tooth.factors, thick),
        gear_cutting=inputs.gear_generation.name,
        pinion=pinion,
        gear=gear,
        ratio=inputs.teeth_gear / inputs.teeth_pinion,
        module_normal=tooth.module,
        offset_angle=place.zeta_m,
        offset_angle_pitch_plane=place.zeta_mp,
        pressure_angle_drive=tooth.pressure_angles[0],
        pressure_angle_coast=tooth.pressure_angles[1],
        effective_pressure_angle_drive=tooth.pressure_angles[0] - limit,
        effective_pressure_angle_coast=tooth.pressure_angles[1] + limit,
        clearance=tooth.clearances[1],
        clearance_pinion=tooth.clearances[0],
        whole_depth_pinion=_whole_depth(pinion),
        backlash_outer_normal=thick.backlash_normal * (outer_2 * cos(spiral_2)) / across,
        backlash_outer_transverse=thick.backlash_normal / cos(tooth.pressure_angle) * outer_2 / across,
        taper=taper,
        virtual_drive=drive,
        virtual_coast=coast,
        undercut=undercut,
        tangency_error=cones.spiral[0] - touching.spiral[0],
        defaults=(*inputs.defaults, *tooth.factors.recommended, *(() if inputs.taper else (f"taper.type = {taper}",))),
    )
    check_dimensions(pair)
    # below a contact ratio of 1 (a warning) there is no contact line in the middle
    meshes = min(drive.contact_ratio_total, coast.contact_ratio_total) > 1.0
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
    tangency.check_pitch_angles(*cones.pitch_angle, inputs)
    if max(map(abs, cones.spiral)) >= tangency.SPIRAL_LIMIT:
        raise tangency.too_large(inputs.hypoid_offset)
    inner = cones.cone_distance[1] - (1.0 - cones.face_width_factor) * inputs.face_width_gear
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


def _trace(
    inputs: PairBlankInput, cones: tangency.PitchCones, place: dimensions.Placement, faces: dimensions.FaceWidths
) -> tuple[Trace, tuple[Pair, Pair]]:
    """Tooth trace, Formulae (174) to (194), and cone distances of both members at toe and heel [m]."""
    widths = zip(cones.cone_distance, faces.face_width_inside, faces.face_width_outside, strict=True)
    ends_1, ends_2 = ((cone - inside, cone + outside) for cone, inside, outside in widths)
    toe, heel = (dimensions.gear_cone(cones, place, cone) for cone in ends_1)
    return check_trace(inputs, cones, (*ends_2, toe, heel), place.offset_pitch_plane), (ends_1, ends_2)


def _member(
    inputs: PairBlankInput, slots: SlotGeometry, faces: dimensions.FaceWidths, thick: dimensions.Thickness, i: int
) -> MemberBlank:
    """Dimensions of the pinion (0) or the gear (1), Formulae (195) to (200), (216) to (225)."""
    cones, place, angles, tooth, (inner, outer) = slots.cones, slots.place, slots.angles, slots.tooth, slots.ends[i]
    delta, point = cones.pitch_angle[i], place.crossing_to_mean_point[i]
    at_places: dict[str, Any] = {}
    crowns: list[float] = []
    for at, along, cone in (
        ("outer", faces.face_width_outside[i], outer),
        ("mean", 0.0, cones.cone_distance[i]),
        ("inner", -faces.face_width_inside[i], inner),
    ):
        addendum = tooth.addendums[i] + along * tan(angles.addendum_angle[i])
        dedendum = tooth.dedendums[i] + along * tan(angles.dedendum_angle[i])
        crowns.append(point + along * cos(delta) - addendum * sin(delta))
        at_places |= {
            f"{at}_cone_distance": cone,
            f"{at}_diameter": 2.0 * cone * sin(delta),
            f"{at}_addendum": addendum,
            f"{at}_dedendum": dedendum,
            f"{at}_whole_depth": addendum + dedendum,
            f"{at}_spiral_angle": cones.spiral[i] if at == "mean" else slots.spiral(i, cone),
        }
        if at != "mean":
            at_places[f"{at}_tip_diameter"] = 2.0 * (cone * sin(delta) + addendum * cos(delta))
            at_places[f"{at}_root_diameter"] = 2.0 * (cone * sin(delta) - dedendum * cos(delta))
    where = f"mounting_distance_{('pinion', 'gear')[i]}"
    mounted: float | None = getattr(inputs, where)
    if mounted is not None and mounted <= crowns[0]:
        allowed = f"above {1e3 * crowns[0]:.5g} mm, the distance of the outer tip circle from the crossing point"
        raise InputError(where, f"{1e3 * mounted:.6g} mm", allowed, "The locating face is behind the teeth.")
    other: Hand = "right" if inputs.hand_pinion == "left" else "left"
    return MemberBlank(
        teeth=(inputs.teeth_pinion, inputs.teeth_gear)[i],
        hand=(inputs.hand_pinion, inputs.hand_gear or other)[i],
        **{name: both[i] for name, both in _named(MemberBlank, cones, angles, faces, place, thick).items()},
        **at_places,
        face_width=faces.face_width_outside[i] + faces.face_width_inside[i],
        crossing_to_crown=crowns[0],
        crossing_to_front_crown=crowns[2],
        **slots_and_lands(slots, i),
        mounting_distance=mounted,
    )


def _whole_depth(pinion: MemberBlank) -> float:
    """h_t1, outer whole depth normal to the root cone [m], Formula (226)."""
    crown = pinion.face_apex_beyond_crossing + pinion.crossing_to_crown
    apexes = pinion.root_apex_beyond_crossing - pinion.face_apex_beyond_crossing
    between = sin(pinion.addendum_angle + pinion.dedendum_angle)
    return crown / cos(pinion.face_angle) * between - apexes * sin(pinion.root_angle)
