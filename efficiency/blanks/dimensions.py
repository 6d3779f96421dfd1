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
from efficiency.blanks.inputs import DepthTypeOne, PairBlankInput, check_pressure_angles
from efficiency.blanks.lengthwise import Trace
from efficiency.blanks.rating import Pair
from efficiency.blanks.tangency import PitchCones, limit_pressure_angle, too_large
from efficiency.cutting.process import PROCESSES
from ehl.common.errors import InputError

# Annex C and AGMA 2005, unverified; teeth of the pinion: factor. 12 (hypoid: 11) and more: 2. Hypoids with 5
# teeth: continued in equal steps; three measured pairs with 5 to 7 teeth have 1.69, 1.72, 1.78 and 0.091, 0.111, 0.132
DEPTH_FACTOR_BEVEL = {6: 1.765, 7: 1.835, 8: 1.895, 9: 1.940, 10: 1.975, 11: 1.995}
DEPTH_FACTOR_HYPOID = {5: 1.70, 6: 1.75, 7: 1.80, 8: 1.85, 9: 1.90, 10: 1.95}
ADDENDUM_FACTOR_HYPOID = {5: 0.090, 6: 0.110, 7: 0.130, 8: 0.150}
End = Literal["toe", "heel"]
ENDS: tuple[End, End] = ("toe", "heel")


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
        return DepthFactors(**depth.model_dump(exclude={"data_type"}))
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
    equivalent = sqrt(ratio * cos(cones.pitch_angle[0]) / cos(cones.pitch_angle[1]))
    return 0.210 + 0.290 / equivalent**2


def recommended_thickness_factor(inputs: PairBlankInput) -> float:
    """k_t, the curve of Figure C.1 (AGMA 2005 form, unverified; reproduces the input of sample F.2 to the last digit).

    Above a ratio of 10 the value at 10 is used (this work), because the parabola has its maximum at 11.5.
    """
    u = min(inputs.teeth_gear / inputs.teeth_pinion, 10.0)
    return -0.088 + 0.092 * u - 0.004 * u**2 + 0.0016 * (inputs.teeth_pinion - 30) * (u - 1.0)


@dataclass(frozen=True)
class ToothDepth:
    """Pressure angles and tooth depth at the calculation point, Formulae (117) to (119), (132) to (139)."""

    factors: DepthFactors
    module: float  # m_mn [m]
    module_outer: float  # m_et2 [m]
    limit_pressure_angle: float  # alpha_lim
    pressure_angles: Pair  # alpha_nD, alpha_nC, generated
    # h_am, h_fm, c at the root of the member [m]
    addendums: Pair
    dedendums: Pair
    clearances: Pair
    working_depth: float  # h_mw [m]

    @property
    def pressure_angle(self) -> float:
        """alpha_n, mean of both sides."""
        return 0.5 * sum(self.pressure_angles)


def tooth_depth(inputs: PairBlankInput, cones: PitchCones, zeta_mp: float) -> ToothDepth:
    """Pressure angles and tooth depth; an `InputError` for a member without addendum or dedendum."""
    limit = cones.limit_pressure_angle(zeta_mp)
    influence = inputs.pressure_angle.limit_influence * limit
    alphas = inputs.pressure_angle.drive + influence, inputs.pressure_angle.coast - influence
    check_pressure_angles(inputs, alphas, limit)
    factor = factors(inputs, cones)
    module = cones.mean_diameter[1] * cos(cones.spiral[1]) / inputs.teeth_gear
    high, deep, shift = factor.addendum_factor, factor.dedendum_factor, factor.profile_shift
    addendums = module * (high + shift), module * (high - shift)
    clearance = module * (deep - high)
    under = clearance if factor.clearance_factor_pinion is None else module * factor.clearance_factor_pinion
    dedendums = module * (deep - shift) + (under - clearance), module * (deep + shift)
    if min(*addendums, *dedendums) < 0.0:
        raise InputError("depth", f"addenda {addendums[0] * 1e3:.4g}, {addendums[1] * 1e3:.4g} mm", "at least 0")
    outer = cones.cone_distance[1] + cones.face_width_factor * inputs.face_width_gear
    module_outer = 2.0 * outer * sin(cones.pitch_angle[1]) / inputs.teeth_gear
    heights = addendums, dedendums, (under, clearance)
    return ToothDepth(factor, module, module_outer, limit, alphas, *heights, 2.0 * module * high)


def taper_angles(inputs: PairBlankInput, cones: PitchCones, tooth: ToothDepth) -> tuple[Pair, str]:
    """theta_a2, theta_f2 and the taper used, Annex C.5."""
    taper, cone, spiral = inputs.taper, cones.cone_distance[1], cones.spiral[1]
    uniform_radius = cone * sin(spiral)
    kind = PROCESSES[inputs.process].taper(inputs.cutter_radius, uniform_radius) if taper is None else taper.type
    if kind == "given":
        assert taper is not None
        assert taper.addendum_angle_gear is not None
        assert taper.dedendum_angle_gear is not None
        return (taper.addendum_angle_gear, taper.dedendum_angle_gear), kind
    if kind == "uniform":
        return (0.0, 0.0), kind
    addendum_standard = atan(tooth.dedendums[0] / cone)
    total_standard = addendum_standard + atan(tooth.dedendums[1] / cone)
    if kind == "standard":
        return (addendum_standard, total_standard - addendum_standard), kind
    if inputs.cutter_radius < uniform_radius:
        allowed = f"above R_m2 sin beta_m2 = {uniform_radius * 1e3:.4g} mm for the taper {kind!r}"
        hint = (
            "Below it the tooth depth would increase towards the toe: use a larger cutter, or taper.type = 'uniform'."
        )
        raise InputError("cutter_radius", f"{inputs.cutter_radius * 1e3:.6g} mm", allowed, hint)
    outer_cone = cone + cones.face_width_factor * inputs.face_width_gear
    total = 0.5 * pi * tooth.module_outer / (outer_cone * tan(tooth.pressure_angle) * cos(spiral))
    total *= 1.0 - uniform_radius / inputs.cutter_radius
    if kind == "tilted_root":
        total = min(total, 1.3 * total_standard)
    addendum = total * tooth.addendums[1] / tooth.working_depth
    if degrees(total) > 30.0:
        allowed = f"a taper with less than 30 deg between tips and roots, here {degrees(total):.3g} deg"
        raise InputError("taper.type", kind, allowed)
    return (addendum, total - addendum), kind


@dataclass(frozen=True)
class Placement:
    """Positions of cones and calculation point, Formulae (113) to (115), (129) to (131)."""

    # offset angle of the pinion in the axial plane and in the pitch plane
    zeta_m: float
    zeta_mp: float
    offset_pitch_plane: float  # a_p, offset in the pitch plane [m]
    crossing_to_mean_point: Pair  # t_zm1, t_zm2 [m], crossing point to calculation point along the axis
    pitch_apex_beyond_crossing: Pair  # t_z1, t_z2 [m], pitch apex beyond the crossing point


def placement(shaft_angle: float, hypoid_offset: float, cones: PitchCones) -> Placement:
    """Offset angles and apexes of the pitch cones."""
    (d_1, d_2), (cone_1, cone_2), (diameter_1, diameter_2) = cones.pitch_angle, cones.cone_distance, cones.mean_diameter
    excess = shaft_angle - 0.5 * pi
    reach = diameter_2 + diameter_1 * cos(d_2) / cos(d_1)
    if 2.0 * abs(hypoid_offset) >= reach:
        raise too_large(hypoid_offset, 0.5 * reach)
    zeta_m = asin(2.0 * hypoid_offset / reach)
    zeta_mp = asin(sin(zeta_m) * sin(shaft_angle) / cos(d_1))
    point_2 = 0.5 * diameter_1 * sin(d_2) / cos(d_1) - 0.5 * cos(zeta_m) * tan(excess) * reach
    point_1 = 0.5 * diameter_2 * cos(zeta_m) * cos(excess) - point_2 * sin(excess)
    apexes = cone_1 * cos(d_1) - point_1, cone_2 * cos(d_2) - point_2
    return Placement(zeta_m, zeta_mp, cone_2 * sin(zeta_mp), (point_1, point_2), apexes)


def gear_cone(cones: PitchCones, place: Placement, cone_1: float) -> float:
    """Cone distance of the gear opposite to one of the pinion [m], Equation (16) of AGMA 929."""
    mean, along = cones.cone_distance[1], cone_1 - cones.cone_distance[0]
    return sqrt(mean**2 + along**2 + 2.0 * mean * along * cos(place.zeta_mp))


@dataclass(frozen=True)
class FaceAndRoot:
    """Face and root cones, Formulae (140) to (153)."""

    # zeta_R, zeta_o, offset angles of the pinion in the root plane and the face plane of the gear
    offset_angle_root_plane: float
    offset_angle_face_plane: float
    # delta_a, delta_f, theta_a, theta_f
    face_angle: Pair
    root_angle: Pair
    addendum_angle: Pair
    dedendum_angle: Pair
    # t_zF, t_zR [m], apexes beyond the crossing point
    face_apex_beyond_crossing: Pair
    root_apex_beyond_crossing: Pair


def face_and_root(
    inputs: PairBlankInput, cones: PitchCones, place: Placement, tooth: ToothDepth, taper: Pair
) -> FaceAndRoot:
    """Face and root cones: those of the pinion keep the clearance from the root and face cone of the gear.

    taper: theta_a2, theta_f2.
    """
    excess, offset = inputs.shaft_angle - 0.5 * pi, inputs.hypoid_offset
    cone, apex, clearance = cones.cone_distance[1], place.pitch_apex_beyond_crossing[1], tooth.clearances
    (theta_a, theta_f), (delta_1, delta_2) = taper, cones.pitch_angle
    face, root = delta_2 + theta_a, delta_2 - theta_f
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
    face_apex_2 = apex - (cone * sin(theta_a) - tooth.addendums[1] * cos(theta_a)) / sin(face)
    root_apex_2 = apex + (cone * sin(theta_f) - tooth.dedendums[1] * cos(theta_f)) / sin(root)
    face_apex_1 = (offset * sin(zeta_root) * cos(root) - root_apex_2 * sin(root) - clearance[1]) / sin(face_1)
    root_apex_1 = (offset * sin(zeta_face) * cos(face) - face_apex_2 * sin(face) - clearance[0]) / sin(root_1)
    thetas = (face_1 - delta_1, theta_a), (delta_1 - root_1, theta_f)
    apexes = (face_apex_1, face_apex_2), (root_apex_1, root_apex_2)
    return FaceAndRoot(zeta_root, zeta_face, (face_1, face), (root_1, root), *thetas, *apexes)


@dataclass(frozen=True)
class FaceWidths:
    """Face widths, Formulae (127), (128), (154) to (173): outside and inside the calculation point [m]."""

    # b_e, b_i
    face_width_outside: Pair
    face_width_inside: Pair
    face_width_pinion_pitch_plane: float  # b_p1, face of the pinion in the pitch plane


def face_widths(
    inputs: PairBlankInput, cones: PitchCones, place: Placement, tooth: ToothDepth, angles: FaceAndRoot
) -> FaceWidths:
    """Face width of the pinion by the rule of its method; a pair without offset takes that of the gear."""
    width, share, plane = inputs.face_width_gear, cones.face_width_factor, place.offset_pitch_plane
    outside, inside = share * width, (1.0 - share) * width
    outer, inner = cones.cone_distance[1] + outside, cones.cone_distance[1] - inside
    if abs(plane) >= inner:
        stated = f"{inputs.hypoid_offset * 1e3:.6g} mm"
        allowed = (
            f"a_p (here {abs(plane) * 1e3:.4g} mm) below the inner cone distance of the gear, {inner * 1e3:.4g} mm"
        )
        raise InputError("hypoid_offset", stated, allowed, "Take a smaller offset or face width.")
    in_plane = sqrt(outer**2 - plane**2) - sqrt(inner**2 - plane**2)
    if inputs.hypoid_offset == 0.0:
        pinion = outside, inside
    elif inputs.method == 1:
        pinion = _face_of_method_1(inputs, cones, place, tooth, angles)
    elif inputs.method == 2:
        total = width * (1.0 + tan(place.zeta_mp) ** 2)
        pinion = share * total, (1.0 - share) * total
    else:
        # the standard rounds this face to whole millimetres
        total = floor(1e3 * (in_plane + 3.0 * tooth.module * abs(tan(place.zeta_mp))) + 1.0) / 1e3
        mean = cones.cone_distance[1] * cos(place.zeta_mp)
        pinion_inside = mean - sqrt(inner**2 - plane**2) + 0.5 * (total - in_plane)
        pinion = total - pinion_inside, pinion_inside
    if pinion[1] >= cones.cone_distance[0]:
        allowed = f"a pinion face that ends before its apex; here {pinion[1] * 1e3:.4g} mm inside a cone distance of "
        raise InputError("face_width_gear", f"{width * 1e3:.6g} mm", f"{allowed}{cones.cone_distance[0] * 1e3:.4g} mm")
    return FaceWidths((pinion[0], outside), (pinion[1], inside), in_plane)


def _face_of_method_1(
    inputs: PairBlankInput, cones: PitchCones, place: Placement, tooth: ToothDepth, angles: FaceAndRoot
) -> Pair:
    """b_e1, b_i1 [m], Formulae (159) to (166)."""
    ratio, share, (d_1, d_2) = inputs.teeth_gear / inputs.teeth_pinion, cones.face_width_factor, cones.pitch_angle
    theta, face = angles.addendum_angle[0], angles.face_angle[0]
    turn = atan(sin(place.zeta_mp) * cos(d_2) / (ratio * cos(d_1) + cos(d_2) * cos(place.zeta_mp)))
    growth = tooth.working_depth * abs(sin(angles.offset_angle_root_plane)) * (1.0 - 1.0 / ratio)
    along = inputs.face_width_gear * cos(turn) / cos(place.zeta_mp - turn) / cos(theta) * cos(face)
    reserve, rise = (tooth.dedendums[1] - tooth.clearances[1]) * sin(d_1), tooth.addendums[0] * sin(d_1)
    upstream = share * along + growth - reserve + rise
    downstream = (1.0 - share) * along + growth + reserve - rise
    return upstream / cos(face) * cos(theta), downstream / (cos(d_1) - tan(theta) * sin(d_1))


@dataclass(frozen=True)
class Thickness:
    """Mean tooth thickness, Formulae (201) to (215)."""

    thickness_coefficient: Pair  # x_sm1, x_sm2, thickness modification with backlash
    # s_mn, s_mt [m]
    mean_normal_thickness: Pair
    mean_transverse_thickness: Pair
    # s_mnc, h_amc, d_mn [m], the diameter of the tooth's curvature in the normal section
    mean_chordal_thickness: Pair
    mean_chordal_addendum: Pair
    mean_normal_diameter: Pair
    backlash_normal: float  # j_mn [m], mean normal backlash, measured normal to the flanks


def thickness(inputs: PairBlankInput, cones: PitchCones, tooth: ToothDepth, outer: tuple[float, float]) -> Thickness:
    """Tooth thickness at the calculation point.

    outer: R_e2 [m] and beta_e2.
    """
    alpha_n, module, across = tooth.pressure_angle, tooth.module, cones.cone_distance[1] * cos(cones.spiral[1])
    # backlash at the mean point along the normal section of the pitch plane, s_mn1 + s_mn2 = pi m_mn - loss
    shares = {
        "none": 0.0,
        "outer_normal": across / (outer[0] * cos(outer[1])) / cos(alpha_n),
        "outer_transverse": across / outer[0],
        "mean_normal": 1.0 / cos(alpha_n),
        "mean_transverse": cos(cones.spiral[1]),
    }
    loss = inputs.backlash.value * shares[inputs.backlash.type]
    thinner = loss / (4.0 * module)
    modification, rise = tooth.factors.thickness_modification, tooth.factors.profile_shift * tan(alpha_n)
    coefficient = modification - thinner, -modification - thinner
    half = 0.5 * pi * module
    normal = half + 2.0 * module * (coefficient[0] + rise), half + 2.0 * module * (coefficient[1] - rise)
    transverse = normal[0] / cos(cones.spiral[0]), normal[1] / cos(cones.spiral[1])
    places = zip(normal, tooth.addendums, cones.mean_diameter, cones.spiral, cones.pitch_angle, strict=True)
    chords, heights, diameters = zip(*(chordal(*place, alpha_n) for place in places), strict=True)
    return Thickness(coefficient, normal, transverse, chords, heights, diameters, loss * cos(alpha_n))


@dataclass(frozen=True)
class UndercutLimit:
    """Limit of x_hm1 at one end of one member: smallest for the pinion, largest for the gear."""

    member: Literal["pinion", "gear"]
    place: End
    limit: float
    undercut: bool


def undercut_limits(
    inputs: PairBlankInput,
    cones: PitchCones,
    place: Placement,
    tooth: ToothDepth,
    trace: Trace,
    ends: tuple[Pair, Pair],
    gear_taper: Pair,
) -> tuple[UndercutLimit, ...]:
    """Limits at toe and heel of both members.

    ends: (R_i1, R_e1), (R_i2, R_e2) [m].
    gear_taper: theta_a2, theta_f2.
    """
    (d_1, d_2), (drive, coast), mean_2 = cones.pitch_angle, tooth.pressure_angles, cones.cone_distance[1]
    z_1, z_2, alpha_n = inputs.teeth_pinion, inputs.teeth_gear, tooth.pressure_angle
    shift, module = tooth.factors.profile_shift, tooth.module
    results: list[UndercutLimit] = []

    def tool(cone_2: float, theta: float) -> float:
        return 1.1 * (tooth.factors.addendum_factor + (cone_2 - mean_2) * tan(theta) / module)

    def involute(z: int, spiral: float, delta: float, local: float, alpha: float) -> float:
        virtual = z / ((1.0 - (sin(spiral) * cos(alpha_n)) ** 2) * cos(spiral) * cos(delta))
        return virtual * local * sin(alpha) ** 2 / (2.0 * module)

    for name, cone_1 in zip(ENDS, ends[0], strict=True):
        cone_2 = gear_cone(cones, place, cone_1)
        b_1, b_2 = trace.spirals(cone_2, place.offset_pitch_plane)
        diameter_2 = 2.0 * cone_2 * sin(d_2)
        effective = diameter_2 * z_1 * cos(b_2) / (z_2 * cos(b_1))
        alpha_lim = limit_pressure_angle(d_1, d_2, 0.5 * effective / sin(d_1), cone_2, b_1, b_2, place.zeta_mp)
        alpha = min(drive - alpha_lim, coast + alpha_lim)
        least = tool(cone_2, gear_taper[0]) - involute(z_1, b_1, d_1, diameter_2 / z_2 * cos(b_2), alpha)
        least += (effective - 2.0 * cone_1 * sin(d_1)) * cos(d_1) / (2.0 * module)
        results.append(UndercutLimit("pinion", name, least, shift < least))
    for name, cone_2 in zip(ENDS, ends[1], strict=True):
        b_2 = trace.spiral(cone_2)
        local = 2.0 * cone_2 * sin(d_2) / z_2 * cos(b_2)
        most = involute(z_2, b_2, d_2, local, min(drive, coast)) - tool(cone_2, gear_taper[1])
        results.append(UndercutLimit("gear", name, most, shift > most))
    return tuple(results)
