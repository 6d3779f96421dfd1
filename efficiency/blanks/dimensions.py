"""Gear dimensions of both members (ISO 23509 clause 7), from pitch cones and tooth proportions.

Equation numbers: ISO 23509:2016 as given in a public secondary source (docs/blank.md). Index 1 is the pinion, 2 the
gear.

Undercut check (clause 8): limits of the profile shift at toe and heel, Formulae (227) to (258). The source also uses
the gear's limit (258) as a lower bound of x_hm1; because the gear has -x_hm1, it is an upper bound here.

Tooth proportions: factors of depth and thickness, and the taper of the depth along the face (ISO 23509 Annex C).
"""

from dataclasses import dataclass
from math import asin, atan, cos, degrees, floor, pi, sin, sqrt, tan
from typing import Literal

from efficiency.blanks.drawing import chordal
from efficiency.blanks.inputs import DepthTypeOne, PairBlankInput
from efficiency.blanks.lengthwise import Trace
from efficiency.blanks.tangency import PitchCones, limit_pressure_angle, too_large
from efficiency.cutting.process import PROCESSES
from ehl.common.errors import InputError

# Annex C and AGMA 2005, unverified; teeth of the pinion: factor. 12 (hypoid: 11) and more: 2. Hypoids with 5
# teeth: continued in equal steps; three measured pairs with 5 to 7 teeth have 1.69, 1.72, 1.78 and 0.091, 0.111, 0.132
DEPTH_FACTOR_BEVEL = {6: 1.765, 7: 1.835, 8: 1.895, 9: 1.940, 10: 1.975, 11: 1.995}
DEPTH_FACTOR_HYPOID = {5: 1.70, 6: 1.75, 7: 1.80, 8: 1.85, 9: 1.90, 10: 1.95}
ADDENDUM_FACTOR_HYPOID = {5: 0.090, 6: 0.110, 7: 0.130, 8: 0.150}


@dataclass(frozen=True)
class DepthFactors:
    """Factors of the basic crown gear, in mean normal modules (data type I)."""

    profile_shift: float  # x_hm1, of the pinion; the gear has its negative
    # k_hap, k_hfp
    addendum_factor: float
    dedendum_factor: float
    thickness_modification: float  # x_smn, theoretical, of the pinion
    recommended: tuple[str, ...] = ()  # recommended values used as defaults
    # between pinion root and gear tips, if different from the other clearance
    clearance_factor_pinion: float | None = None


def factors(inputs: PairBlankInput, cones: PitchCones) -> DepthFactors:
    """Factors of data type I, or type II converted by Table 4, with the recommendations of Annex C."""
    depth = inputs.depth
    if isinstance(depth, DepthTypeOne):
        if depth.dedendum_factor < depth.addendum_factor:
            allowed = f"at least the addendum factor {depth.addendum_factor:.4g}"
            hint = "With a negative clearance tip and root interfere."
            raise InputError("depth.dedendum_factor", depth.dedendum_factor, allowed, hint)
        return DepthFactors(
            depth.profile_shift, depth.addendum_factor, depth.dedendum_factor, depth.thickness_modification
        )
    taken: list[str] = []

    def chosen(name: str, value: float | None, recommended: float) -> float:
        if value is not None:
            return value
        taken.append(f"depth.{name} = {recommended:.4g}")
        return recommended

    table = DEPTH_FACTOR_HYPOID if inputs.hypoid_offset else DEPTH_FACTOR_BEVEL
    # k_d of Table C.1 (unverified)
    recommended_depth = table.get(max(min(table), inputs.teeth_pinion), 2.0)
    k_d = chosen("depth_factor", depth.depth_factor, recommended_depth)
    c_ham = chosen("gear_addendum_factor", depth.gear_addendum_factor, recommended_addendum_factor(inputs, cones))
    k_t = chosen("thickness_factor", depth.thickness_factor, recommended_thickness_factor(inputs))
    under = None if depth.clearance_factor_pinion is None else k_d * depth.clearance_factor_pinion
    dedendum = k_d * (depth.clearance_factor + 0.5)
    return DepthFactors(k_d * (0.5 - c_ham), 0.5 * k_d, dedendum, 0.5 * k_t, tuple(taken), under)


def recommended_addendum_factor(inputs: PairBlankInput, cones: PitchCones) -> float:
    """c_ham, Table C.2 (unverified; it reproduces the input of sample F.2 to the last digit)."""
    if inputs.hypoid_offset and inputs.teeth_pinion < 21:
        return ADDENDUM_FACTOR_HYPOID.get(max(5, inputs.teeth_pinion), 0.170)
    ratio = inputs.teeth_gear / inputs.teeth_pinion
    equivalent = sqrt(ratio * cos(cones.pitch_angle_1) / cos(cones.pitch_angle_2))
    return 0.210 + 0.290 / equivalent**2


def recommended_thickness_factor(inputs: PairBlankInput) -> float:
    """k_t, the curve of Figure C.1 (AGMA 2005 form, unverified; reproduces the input of sample F.2 to the last digit).

    Above a ratio of 10 the value at 10 is used (this work), because the parabola has its maximum at 11.5.
    """
    u = min(inputs.teeth_gear / inputs.teeth_pinion, 10.0)
    return -0.088 + 0.092 * u - 0.004 * u**2 + 0.0016 * (inputs.teeth_pinion - 30) * (u - 1.0)


def taper_angles(
    inputs: PairBlankInput,
    cones: PitchCones,
    alpha_n: float,
    outer_module: float,
    addendum_2: float,
    dedendums: tuple[float, float],
    working_depth: float,
) -> tuple[float, float, str]:
    """theta_a2, theta_f2 and the taper used, Annex C.5.

    alpha_n: mean normal pressure angle.
    outer_module: m_et2 [m].
    addendum_2: h_am2 [m].
    dedendums: h_fm1, h_fm2 [m].
    working_depth: h_mw [m].
    """
    taper = inputs.taper
    cone, spiral = cones.cone_distance_2, cones.spiral_2
    uniform_radius = cone * sin(spiral)
    if taper is None:
        kind = PROCESSES[inputs.process].taper(inputs.cutter_radius, uniform_radius)
    else:
        kind = taper.type
    if kind == "given":
        assert taper is not None
        assert taper.addendum_angle_gear is not None
        assert taper.dedendum_angle_gear is not None
        return taper.addendum_angle_gear, taper.dedendum_angle_gear, kind
    if kind == "uniform":
        return 0.0, 0.0, kind
    addendum_standard = atan(dedendums[0] / cone)
    total_standard = addendum_standard + atan(dedendums[1] / cone)
    if kind == "standard":
        return addendum_standard, total_standard - addendum_standard, kind
    if inputs.cutter_radius < uniform_radius:
        raise InputError(
            "cutter_radius",
            f"{inputs.cutter_radius * 1e3:.6g} mm",
            f"above R_m2 sin beta_m2 = {uniform_radius * 1e3:.4g} mm for the taper {kind!r}",
            "Below it the tooth depth would increase towards the toe: use a larger cutter, or taper.type = 'uniform'.",
        )
    outer_cone = cone + cones.face_width_factor * inputs.face_width_gear
    total = (
        0.5
        * pi
        * outer_module
        / (outer_cone * tan(alpha_n) * cos(spiral))
        * (1.0 - uniform_radius / inputs.cutter_radius)
    )
    if kind == "tilted_root":
        total = min(total, 1.3 * total_standard)
    addendum = total * addendum_2 / working_depth
    if degrees(total) > 30.0:
        raise InputError(
            "taper.type", kind, f"a taper with less than 30 deg between tips and roots, here {degrees(total):.3g} deg"
        )
    return addendum, total - addendum, kind


@dataclass(frozen=True)
class Placement:
    """Positions of cones and calculation point, Formulae (113) to (115), (129) to (131)."""

    # offset angle of the pinion in the axial plane and in the pitch plane
    zeta_m: float
    zeta_mp: float
    offset_pitch_plane: float  # a_p, offset in the pitch plane [m]
    crossing_to_mean_point: tuple[float, float]  # t_zm1, t_zm2 [m], crossing point to calculation point along the axis
    pitch_apex_beyond_crossing: tuple[float, float]  # t_z1, t_z2 [m], pitch apex beyond the crossing point


def placement(shaft_angle: float, hypoid_offset: float, cones: PitchCones) -> Placement:
    """Offset angles and apexes of the pitch cones."""
    d_1, d_2 = cones.pitch_angle_1, cones.pitch_angle_2
    excess = shaft_angle - 0.5 * pi
    reach = cones.mean_diameter_2 + cones.mean_diameter_1 * cos(d_2) / cos(d_1)
    if 2.0 * abs(hypoid_offset) >= reach:
        raise too_large(hypoid_offset, 0.5 * reach)
    zeta_m = asin(2.0 * hypoid_offset / reach)
    zeta_mp = asin(sin(zeta_m) * sin(shaft_angle) / cos(d_1))
    point_2 = 0.5 * cones.mean_diameter_1 * sin(d_2) / cos(d_1) - 0.5 * cos(zeta_m) * tan(excess) * reach
    point_1 = 0.5 * cones.mean_diameter_2 * cos(zeta_m) * cos(excess) - point_2 * sin(excess)
    return Placement(
        zeta_m,
        zeta_mp,
        cones.cone_distance_2 * sin(zeta_mp),
        (point_1, point_2),
        (cones.cone_distance_1 * cos(d_1) - point_1, cones.cone_distance_2 * cos(d_2) - point_2),
    )


@dataclass(frozen=True)
class FaceAndRoot:
    """Face and root cones, Formulae (140) to (153)."""

    # zeta_R, zeta_o, offset angles of the pinion in the root plane and the face plane of the gear
    offset_angle_root_plane: float
    offset_angle_face_plane: float
    # delta_a, delta_f of pinion and gear
    face_angle: tuple[float, float]
    root_angle: tuple[float, float]
    # theta_a, theta_f
    addendum_angle: tuple[float, float]
    dedendum_angle: tuple[float, float]
    # t_zF, t_zR [m], apexes beyond the crossing point
    face_apex_beyond_crossing: tuple[float, float]
    root_apex_beyond_crossing: tuple[float, float]


def face_and_root(
    inputs: PairBlankInput,
    cones: PitchCones,
    place: Placement,
    taper: tuple[float, float],
    heights_2: tuple[float, float],
    clearance: tuple[float, float],
) -> FaceAndRoot:
    """Face and root cones: those of the pinion keep the clearance from the root and face cone of the gear.

    taper: theta_a2, theta_f2.
    heights_2: h_am2, h_fm2 [m].
    clearance: c at the root of the pinion and of the gear [m].
    """
    excess, offset = inputs.shaft_angle - 0.5 * pi, inputs.hypoid_offset
    cone, apex = cones.cone_distance_2, place.pitch_apex_beyond_crossing[1]
    theta_a, theta_f = taper
    face, root = cones.pitch_angle_2 + theta_a, cones.pitch_angle_2 - theta_f
    if root <= 0.0 or face >= 0.5 * pi + 0.2:
        raise InputError("taper", f"{theta_a:.4g}, {theta_f:.4g} rad", "a root angle of the gear above 0")

    def offset_angle(angle: float, theta: float) -> float:
        lever = cone * cos(theta) - apex * cos(angle)
        phi = atan(offset * tan(excess) * cos(angle) / lever)
        return asin(offset * cos(phi) * sin(angle) / lever) - phi

    def opposite(angle: float, zeta: float) -> float:
        return asin(sin(excess) * sin(angle) + cos(excess) * cos(angle) * cos(zeta))

    zeta_root, zeta_face = offset_angle(root, theta_f), offset_angle(face, theta_a)
    face_1, root_1 = opposite(root, zeta_root), opposite(face, zeta_face)
    face_apex_2 = apex - (cone * sin(theta_a) - heights_2[0] * cos(theta_a)) / sin(face)
    root_apex_2 = apex + (cone * sin(theta_f) - heights_2[1] * cos(theta_f)) / sin(root)
    face_apex_1 = (offset * sin(zeta_root) * cos(root) - root_apex_2 * sin(root) - clearance[1]) / sin(face_1)
    root_apex_1 = (offset * sin(zeta_face) * cos(face) - face_apex_2 * sin(face) - clearance[0]) / sin(root_1)
    return FaceAndRoot(
        zeta_root,
        zeta_face,
        (face_1, face),
        (root_1, root),
        (face_1 - cones.pitch_angle_1, theta_a),
        (cones.pitch_angle_1 - root_1, theta_f),
        (face_apex_1, face_apex_2),
        (root_apex_1, root_apex_2),
    )


@dataclass(frozen=True)
class FaceWidths:
    """Face widths, Formulae (127), (128), (154) to (173): outside and inside the calculation point [m]."""

    # b_e, b_i of pinion and gear
    face_width_outside: tuple[float, float]
    face_width_inside: tuple[float, float]
    face_width_pinion_pitch_plane: float  # b_p1, face of the pinion in the pitch plane


def face_widths(
    inputs: PairBlankInput,
    cones: PitchCones,
    place: Placement,
    angles: FaceAndRoot,
    module: float,
    working_depth: float,
    reserve: float,
    addendum_1: float,
) -> FaceWidths:
    """Face width of the pinion by the rule of its method; a pair without offset takes that of the gear.

    reserve: h_fm2 - c [m].
    """
    width, share, plane = inputs.face_width_gear, cones.face_width_factor, place.offset_pitch_plane
    outside, inside = share * width, (1.0 - share) * width
    outer, inner = cones.cone_distance_2 + outside, cones.cone_distance_2 - inside
    if abs(plane) >= inner:
        raise InputError(
            "hypoid_offset",
            f"{inputs.hypoid_offset * 1e3:.6g} mm",
            f"a_p (here {abs(plane) * 1e3:.4g} mm) below the inner cone distance of the gear, {inner * 1e3:.4g} mm",
            "Take a smaller offset or face width.",
        )
    mean = cones.cone_distance_2 * cos(place.zeta_mp)
    in_plane = sqrt(outer**2 - plane**2) - sqrt(inner**2 - plane**2)
    if inputs.hypoid_offset == 0.0:
        pinion = outside, inside
    elif inputs.method == 1:
        # Formulae (159) to (166)
        ratio = inputs.teeth_gear / inputs.teeth_pinion
        d_1, d_2 = cones.pitch_angle_1, cones.pitch_angle_2
        theta, face = angles.addendum_angle[0], angles.face_angle[0]
        turn = atan(sin(place.zeta_mp) * cos(d_2) / (ratio * cos(d_1) + cos(d_2) * cos(place.zeta_mp)))
        growth = working_depth * abs(sin(angles.offset_angle_root_plane)) * (1.0 - 1.0 / ratio)
        along = width * cos(turn) / cos(place.zeta_mp - turn) / cos(theta) * cos(face)
        far = share * along + growth - reserve * sin(d_1)
        near = (1.0 - share) * along + growth + reserve * sin(d_1)
        pinion = (
            (far + addendum_1 * sin(d_1)) / cos(face) * cos(theta),
            (near - addendum_1 * sin(d_1)) / (cos(d_1) - tan(theta) * sin(d_1)),
        )
    elif inputs.method == 2:
        total = width * (1.0 + tan(place.zeta_mp) ** 2)
        pinion = share * total, (1.0 - share) * total
    else:
        # the standard rounds this face to whole millimetres
        total = floor(1e3 * (in_plane + 3.0 * module * abs(tan(place.zeta_mp))) + 1.0) / 1e3
        pinion_inside = mean - sqrt(inner**2 - plane**2) + 0.5 * (total - in_plane)
        pinion = total - pinion_inside, pinion_inside
    if pinion[1] >= cones.cone_distance_1:
        raise InputError(
            "face_width_gear",
            f"{width * 1e3:.6g} mm",
            f"a pinion face that ends before its apex; here {pinion[1] * 1e3:.4g} mm inside a cone distance of "
            f"{cones.cone_distance_1 * 1e3:.4g} mm",
        )
    return FaceWidths((pinion[0], outside), (pinion[1], inside), in_plane)


@dataclass(frozen=True)
class Thickness:
    """Mean tooth thickness, Formulae (201) to (215)."""

    thickness_coefficient: tuple[float, float]  # x_sm1, x_sm2, thickness modification with backlash
    # s_mn, s_mt [m]
    mean_normal_thickness: tuple[float, float]
    mean_transverse_thickness: tuple[float, float]
    mean_normal_diameter: tuple[float, float]  # d_mn [m], diameter of the tooth's curvature in the normal section
    # s_mnc, h_amc [m]
    mean_chordal_thickness: tuple[float, float]
    mean_chordal_addendum: tuple[float, float]
    backlash_normal: float  # j_mn [m], mean normal backlash, measured normal to the flanks


def thickness(
    inputs: PairBlankInput,
    cones: PitchCones,
    module: float,
    factor: DepthFactors,
    alpha_n: float,
    outer: tuple[float, float],
    addendums: tuple[float, float],
) -> Thickness:
    """Tooth thickness at the calculation point.

    outer: R_e2 [m] and beta_e2.
    addendums: h_am1, h_am2 [m].
    """
    mean_over_outer = cones.cone_distance_2 * cos(cones.spiral_2) / (outer[0] * cos(outer[1]))
    # backlash at the mean point along the normal section of the pitch plane, s_mn1 + s_mn2 = pi m_mn - loss
    loss = (
        inputs.backlash.value
        * {
            "none": 0.0,
            "outer_normal": mean_over_outer / cos(alpha_n),
            "outer_transverse": cones.cone_distance_2 * cos(cones.spiral_2) / outer[0],
            "mean_normal": 1.0 / cos(alpha_n),
            "mean_transverse": cos(cones.spiral_2),
        }[inputs.backlash.type]
    )
    thinner = loss / (4.0 * module)
    modification, shift = factor.thickness_modification, factor.profile_shift
    coefficient = (modification - thinner, -modification - thinner)
    half = 0.5 * pi * module
    normal = (
        half + 2.0 * module * (coefficient[0] + shift * tan(alpha_n)),
        half + 2.0 * module * (coefficient[1] - shift * tan(alpha_n)),
    )
    spirals = cones.spiral_1, cones.spiral_2
    one = chordal(normal[0], addendums[0], cones.mean_diameter_1, spirals[0], cones.pitch_angle_1, alpha_n)
    two = chordal(normal[1], addendums[1], cones.mean_diameter_2, spirals[1], cones.pitch_angle_2, alpha_n)
    return Thickness(
        coefficient,
        normal,
        (normal[0] / cos(spirals[0]), normal[1] / cos(spirals[1])),
        (one[2], two[2]),
        (one[0], two[0]),
        (one[1], two[1]),
        loss * cos(alpha_n),
    )


@dataclass(frozen=True)
class UndercutLimit:
    """Limit of x_hm1 at one end of one member: smallest for the pinion, largest for the gear."""

    member: Literal["pinion", "gear"]
    place: Literal["toe", "heel"]
    limit: float
    undercut: bool


def undercut_limits(
    inputs: PairBlankInput,
    cones: PitchCones,
    place: Placement,
    trace: Trace,
    ends: tuple[tuple[float, float], tuple[float, float]],
    module: float,
    factor: DepthFactors,
    gear_taper: tuple[float, float],
    pressure_angles: tuple[float, float],
) -> tuple[UndercutLimit, ...]:
    """Limits at toe and heel of both members.

    ends: (R_i1, R_e1), (R_i2, R_e2) [m].
    gear_taper: theta_a2, theta_f2.
    pressure_angles: alpha_nD, alpha_nC.
    """
    d_1, d_2 = cones.pitch_angle_1, cones.pitch_angle_2
    alpha_n = 0.5 * sum(pressure_angles)
    mean_2 = cones.cone_distance_2
    teeth, addendum_factor, shift = (
        (inputs.teeth_pinion, inputs.teeth_gear),
        factor.addendum_factor,
        factor.profile_shift,
    )
    results: list[UndercutLimit] = []

    def virtual(z: int, spiral: float, delta: float) -> float:
        return z / ((1.0 - (sin(spiral) * cos(alpha_n)) ** 2) * cos(spiral) * cos(delta))

    for name, cone_1 in zip(("toe", "heel"), ends[0], strict=True):
        back = cones.cone_distance_1 - cone_1
        cone_2 = sqrt(mean_2**2 + back**2 - 2.0 * mean_2 * back * cos(place.zeta_mp))
        b_2 = trace.spiral(cone_2)
        b_1 = b_2 + asin(place.offset_pitch_plane / cone_2)
        diameter_2 = 2.0 * cone_2 * sin(d_2)
        effective = diameter_2 * teeth[0] * cos(b_2) / (teeth[1] * cos(b_1))
        alpha_lim = limit_pressure_angle(d_1, d_2, 0.5 * effective / sin(d_1), cone_2, b_1, b_2, place.zeta_mp)
        alpha = min(pressure_angles[0] - alpha_lim, pressure_angles[1] + alpha_lim)
        tool = addendum_factor + (cone_2 - mean_2) * tan(gear_taper[0]) / module
        local = diameter_2 / teeth[1] * cos(b_2)
        least = 1.1 * tool - virtual(teeth[0], b_1, d_1) * local * sin(alpha) ** 2 / (2.0 * module)
        least += (effective - 2.0 * cone_1 * sin(d_1)) * cos(d_1) / (2.0 * module)
        results.append(UndercutLimit("pinion", "toe" if name == "toe" else "heel", least, shift < least))
    for name, cone_2 in zip(("toe", "heel"), ends[1], strict=True):
        b_2 = trace.spiral(cone_2)
        tool = addendum_factor + (cone_2 - mean_2) * tan(gear_taper[1]) / module
        local = 2.0 * cone_2 * sin(d_2) / teeth[1] * cos(b_2)
        needed = 1.1 * tool - virtual(teeth[1], b_2, d_2) * local * sin(min(pressure_angles)) ** 2 / (2.0 * module)
        results.append(UndercutLimit("gear", "toe" if name == "toe" else "heel", -needed, shift > -needed))
    return tuple(results)
