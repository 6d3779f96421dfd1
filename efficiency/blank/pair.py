"""The blank of a pair: every dimension of both members from what the designer typed (ISO 23509).

The chain reads as the standard: pitch cones (clause 6), proportions (Table 4, Annex C), dimensions (clause 7), undercut
(clause 8); to it come slot widths and top lands (AGMA 929) and virtual gears with contact ratios (ISO 10300-1 Annex A).
"""

from __future__ import annotations

from dataclasses import replace
from math import asin, cos, sin, sqrt, tan

from efficiency.blank.checks import blank_warnings, check_dimensions, check_pressure_angles
from efficiency.blank.dimensions import face_and_root, face_widths, placement, thickness
from efficiency.blank.inputs import PairBlankInput
from efficiency.blank.lengthwise import check_trace
from efficiency.blank.pitch_cones import pitch_cones
from efficiency.blank.proportions import factors, taper_angles
from efficiency.blank.result import MemberBlank, PairBlank
from efficiency.blank.slots import SlotGeometry, slots_and_lands
from efficiency.blank.tangency import limit_pressure_angle, tangent_cones
from efficiency.blank.undercut import undercut_limits
from efficiency.blank.virtual_gears import virtual_gears
from ehl.errors import InputError


def pair_blank(inputs: PairBlankInput) -> PairBlank:
    """Blank of a pair.

    Raises
    ------
    InputError
        The combination has no geometry; it names field, value and what would be allowed.
    ConvergenceError
        The iteration as printed ("standard", "tangent") does not reach its tolerance.
    """
    cones = pitch_cones(inputs)
    place = placement(inputs, cones)
    factor = factors(inputs, cones)
    module = cones.mean_diameter_2 * cos(cones.spiral_2) / inputs.teeth_gear
    alpha_lim = limit_pressure_angle(
        cones.pitch_angle_1,
        cones.pitch_angle_2,
        cones.cone_distance_1,
        cones.cone_distance_2,
        cones.spiral_1,
        cones.spiral_2,
        place.zeta_mp,
    )
    shift_alpha = inputs.pressure_angle.limit_influence * alpha_lim
    alpha_drive, alpha_coast = inputs.pressure_angle.drive + shift_alpha, inputs.pressure_angle.coast - shift_alpha
    check_pressure_angles(inputs, (alpha_drive, alpha_coast), alpha_lim)
    alpha_n = 0.5 * (alpha_drive + alpha_coast)

    # tooth depth at the calculation point, Formulae (132) to (139)
    addendums = module * (factor.addendum + factor.profile_shift), module * (factor.addendum - factor.profile_shift)
    dedendums = module * (factor.dedendum - factor.profile_shift), module * (factor.dedendum + factor.profile_shift)
    clearance = module * (factor.dedendum - factor.addendum)
    working_depth = 2.0 * module * factor.addendum
    if min(*addendums, *dedendums) < 0.0:
        raise InputError("depth", f"addenda {addendums[0] * 1e3:.4g}, {addendums[1] * 1e3:.4g} mm", "none below 0")
    outer_2 = cones.cone_distance_2 + cones.face_width_factor * inputs.face_width_gear
    inner_2 = outer_2 - inputs.face_width_gear
    module_outer = 2.0 * outer_2 * sin(cones.pitch_angle_2) / inputs.teeth_gear
    theta_a, theta_f, taper = taper_angles(inputs, cones, alpha_n, module_outer, addendums[1], dedendums, working_depth)
    angles = face_and_root(inputs, cones, place, (theta_a, theta_f), (addendums[1], dedendums[1]), clearance)
    faces = face_widths(inputs, cones, place, angles, module, working_depth, dedendums[1] - clearance, addendums[0])

    # spiral angles along both faces, Formulae (174) to (194)
    def opposite(along: float) -> float:
        mean = cones.cone_distance_2
        return sqrt(mean**2 + along**2 + 2.0 * mean * along * cos(place.zeta_mp))

    facing = opposite(-faces.inside[0]), opposite(faces.outside[0])
    trace = check_trace(inputs, cones, (inner_2, outer_2, *facing), place.offset_in_plane)
    spirals_1 = tuple(trace.spiral(cone) + asin(place.offset_in_plane / cone) for cone in facing)
    spirals_2 = trace.spiral(inner_2), trace.spiral(outer_2)
    thick = thickness(
        inputs, cones, module, factor.profile_shift, factor.thickness, alpha_n, (outer_2, spirals_2[1]), addendums
    )
    ends = (
        (cones.cone_distance_1 - faces.inside[0], cones.cone_distance_1 + faces.outside[0]),
        (inner_2, outer_2),
    )
    lands = slots_and_lands(
        SlotGeometry(
            cones,
            place,
            trace,
            angles,
            ends,
            module,
            dedendums,
            clearance,
            thick.normal[1],
            thick.backlash_normal / cos(alpha_n),
            (alpha_drive, alpha_coast),
            0.0 if inputs.blade_groups is None else 1.0,
        )
    )
    hands = inputs.hand_pinion, inputs.hand_gear or ("right" if inputs.hand_pinion == "left" else "left")
    members = []
    for i in (0, 1):
        delta = (cones.pitch_angle_1, cones.pitch_angle_2)[i]
        mean = (cones.cone_distance_1, cones.cone_distance_2)[i]
        inner, outer = ends[i]
        rise, fall = tan(angles.addendum_angle[i]), tan(angles.dedendum_angle[i])
        add = addendums[i] - faces.inside[i] * rise, addendums[i] + faces.outside[i] * rise
        ded = dedendums[i] - faces.inside[i] * fall, dedendums[i] + faces.outside[i] * fall
        point = place.crossing_to_point[i]
        spirals = (spirals_1, spirals_2)[i]
        members.append(
            MemberBlank(
                teeth=(inputs.teeth_pinion, inputs.teeth_gear)[i],
                hand=hands[i],
                pitch_angle=delta,
                face_angle=angles.face_angle[i],
                root_angle=angles.root_angle[i],
                addendum_angle=angles.addendum_angle[i],
                dedendum_angle=angles.dedendum_angle[i],
                outer_cone_distance=outer,
                mean_cone_distance=mean,
                inner_cone_distance=inner,
                face_width=faces.outside[i] + faces.inside[i],
                face_width_outside=faces.outside[i],
                face_width_inside=faces.inside[i],
                outer_diameter=2.0 * outer * sin(delta),
                mean_diameter=2.0 * mean * sin(delta),
                inner_diameter=2.0 * inner * sin(delta),
                outer_tip_diameter=2.0 * (outer * sin(delta) + add[1] * cos(delta)),
                inner_tip_diameter=2.0 * (inner * sin(delta) + add[0] * cos(delta)),
                outer_root_diameter=2.0 * (outer * sin(delta) - ded[1] * cos(delta)),
                inner_root_diameter=2.0 * (inner * sin(delta) - ded[0] * cos(delta)),
                outer_addendum=add[1],
                mean_addendum=addendums[i],
                inner_addendum=add[0],
                outer_dedendum=ded[1],
                mean_dedendum=dedendums[i],
                inner_dedendum=ded[0],
                outer_whole_depth=add[1] + ded[1],
                mean_whole_depth=addendums[i] + dedendums[i],
                inner_whole_depth=add[0] + ded[0],
                outer_spiral_angle=spirals[1],
                mean_spiral_angle=(cones.spiral_1, cones.spiral_2)[i],
                inner_spiral_angle=spirals[0],
                thickness_coefficient=thick.coefficient[i],
                mean_normal_thickness=thick.normal[i],
                mean_transverse_thickness=thick.transverse[i],
                mean_normal_diameter=thick.normal_diameter[i],
                mean_chordal_thickness=thick.chordal[i],
                mean_chordal_addendum=thick.chordal_addendum[i],
                crossing_to_mean_point=point,
                pitch_apex_beyond_crossing=place.pitch_apex[i],
                face_apex_beyond_crossing=angles.face_apex[i],
                root_apex_beyond_crossing=angles.root_apex[i],
                crossing_to_crown=point + faces.outside[i] * cos(delta) - add[1] * sin(delta),
                crossing_to_front_crown=point - faces.inside[i] * cos(delta) - add[0] * sin(delta),
                slot_width=(lands.slot_pinion, lands.slot_gear)[i],
                normal_thickness=(lands.thickness_pinion, lands.thickness_gear)[i],
                top_land=(lands.land_pinion, lands.land_gear)[i],
            )
        )
    pinion, gear = members
    virtual = [
        virtual_gears(
            cones,
            place,
            module,
            (addendums, dedendums),
            inputs.face_width_gear,
            generated,
            generated - limit,
            limit,
        )
        for generated, limit in ((alpha_drive, alpha_lim), (alpha_coast, -alpha_lim))
    ]
    touching = tangent_cones(inputs, cones.pitch_angle_2, cones.mean_diameter_2, cones.spiral_2)
    crown = pinion.face_apex_beyond_crossing + pinion.crossing_to_crown
    pair = PairBlank(
        name=inputs.name,
        method=inputs.method,
        process=inputs.process,
        pinion=pinion,
        gear=gear,
        ratio=inputs.teeth_gear / inputs.teeth_pinion,
        shaft_angle=inputs.shaft_angle,
        hypoid_offset=inputs.hypoid_offset,
        cutter_radius=inputs.cutter_radius,
        blade_groups=inputs.blade_groups,
        module_normal=module,
        module_outer=module_outer,
        offset_angle=place.zeta_m,
        offset_angle_pitch_plane=place.zeta_mp,
        offset_angle_root_plane=angles.zeta_root,
        offset_angle_face_plane=angles.zeta_face,
        offset_pitch_plane=place.offset_in_plane,
        limit_pressure_angle=alpha_lim,
        pressure_angle_drive=alpha_drive,
        pressure_angle_coast=alpha_coast,
        effective_pressure_angle_drive=alpha_drive - alpha_lim,
        effective_pressure_angle_coast=alpha_coast + alpha_lim,
        profile_shift=factor.profile_shift,
        addendum_factor=factor.addendum,
        dedendum_factor=factor.dedendum,
        thickness_modification=factor.thickness,
        working_depth=working_depth,
        clearance=clearance,
        whole_depth_pinion=crown / cos(pinion.face_angle) * sin(pinion.addendum_angle + pinion.dedendum_angle)
        - (pinion.root_apex_beyond_crossing - pinion.face_apex_beyond_crossing) * sin(pinion.root_angle),
        face_width_factor=cones.face_width_factor,
        face_width_pinion_pitch_plane=faces.in_pitch_plane,
        cutter_lead_angle=trace.lead,
        crown_to_cutter=trace.centre_distance,
        epicycloid_base_radius=trace.base_radius,
        backlash_normal=thick.backlash_normal,
        taper=taper,
        virtual_drive=virtual[0],
        virtual_coast=virtual[1],
        undercut=undercut_limits(
            cones,
            place,
            trace,
            ends,
            (inputs.teeth_pinion, inputs.teeth_gear),
            module,
            factor.addendum,
            factor.profile_shift,
            (theta_a, theta_f),
            (alpha_drive, alpha_coast),
        ),
        trials=cones.trials,
        closure=cones.closure,
        tangency_error=cones.spiral_1 - touching.spiral_1,
        defaults=(*inputs.defaults, *factor.defaults, *(() if inputs.taper else (f"taper.type = {taper}",))),
    )
    check_dimensions(pair)
    return replace(pair, warnings=blank_warnings(pair))
