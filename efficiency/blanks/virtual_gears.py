"""Virtual cylindrical gears and contact ratios (ISO 10300-1:2023 Annex A, Method B1).

Formula numbers as given in the public repository afuentesaz/AGMAStandards; the standard itself was not available.
"""

from dataclasses import dataclass
from math import asin, atan, cos, pi, sin, sqrt, tan

from efficiency.blanks.dimensions import Placement
from efficiency.blanks.rating import Pair
from efficiency.blanks.tangency import PitchCones
from ehl.common.errors import InputError

# default share of the face width that carries load (ISO 10300-1)
EFFECTIVE_FACE = 0.85


@dataclass(frozen=True)
class VirtualGears:
    """Virtual cylindrical gears of one flank. Pairs are (pinion, gear); lengths in m."""

    # d_v, d_va, d_vf, d_vb
    diameter: Pair
    tip_diameter: Pair
    root_diameter: Pair
    base_diameter: Pair
    centre_distance: float  # a_v
    teeth: Pair  # z_v
    # beta_v, beta_vb
    helix_angle: float
    base_helix_angle: float
    transverse_pressure_angle: float  # alpha_vet
    # m_vt, p_vet
    transverse_module: float
    base_pitch: float
    path_of_contact: float  # g_valpha
    # b_v, b_v,eff with `EFFECTIVE_FACE` of the gear's face
    face_width: float
    effective_face_width: float
    contact_ratio_profile: float  # epsilon_valpha, transverse contact ratio
    contact_ratio_profile_normal: float  # epsilon_valphan = epsilon_valpha/cos^2 beta_vb
    # epsilon_vbeta over the effective face width, and over the whole
    contact_ratio_overlap: float
    contact_ratio_overlap_full: float
    contact_ratio_total: float  # epsilon_vgamma = epsilon_valpha + epsilon_vbeta
    contact_line_inclination: float  # beta_B, of the contact line to the pitch line
    relative_radius: float  # rho_rel, equivalent radius of curvature across the contact line
    normal_teeth: Pair  # z_vn, virtual teeth in the normal section


def virtual_gears(
    cones: PitchCones,
    place: Placement,
    module: float,
    heights: tuple[Pair, Pair],
    face_width_gear: float,
    alpha_generated: float,
    alpha_limit: float,
) -> VirtualGears:
    """Virtual gears of one flank at the calculation point.

    heights: (h_am1, h_am2), (h_fm1, h_fm2) [m].
    alpha_generated: alpha_n of the flank.
    alpha_limit: alpha_lim of this flank: with reversed sign on the coast side.
    """
    deltas, alpha_effective, (spiral_1, spiral_2) = cones.pitch_angle, alpha_generated - alpha_limit, cones.spiral
    d = (cones.mean_diameter[0] / cos(deltas[0]), cones.mean_diameter[1] / cos(deltas[1]))
    helix = 0.5 * (spiral_1 + spiral_2)
    alpha_t = atan(tan(alpha_effective) / cos(helix))
    base_helix = asin(sin(helix) * cos(alpha_effective))
    base = (d[0] * cos(alpha_t), d[1] * cos(alpha_t))
    tip = (d[0] + 2.0 * heights[0][0], d[1] + 2.0 * heights[0][1])
    root = (d[0] - 2.0 * heights[1][0], d[1] - 2.0 * heights[1][1])
    module_t = module / cos(helix)
    pitch = pi * module_t * cos(alpha_t)
    # path of contact (A.18): tip circles to pitch point, both sides
    path = 0.5 * sum(sqrt(a**2 - b**2) - v * sin(alpha_t) for a, b, v in zip(tip, base, d, strict=True))
    # face width along the virtual gears (A.19) to (A.22)
    zeta = place.zeta_mp
    turn = atan(sin(deltas[1]) * tan(place.zeta_m)) - 0.5 * zeta
    share = 1.0 - tan(turn) * tan(0.5 * zeta)
    effective = EFFECTIVE_FACE * face_width_gear
    width_effective = (effective / cos(0.5 * zeta) - path * cos(alpha_t) * abs(tan(0.5 * zeta))) / share
    if width_effective <= 0.0:
        stated = f"{place.offset_pitch_plane * 1e3:.4g} mm in the pitch plane"
        allowed = "an offset that leaves both faces in contact"
        raise InputError("hypoid_offset", stated, allowed, "Take a smaller offset or a larger face width.")
    overlap = width_effective * sin(helix) / (pi * module)
    profile = path / pitch
    inclination = atan(tan(helix) * sin(alpha_effective))
    # radius of relative curvature in the normal section (A.39)
    lever = cos(alpha_generated) * (tan(alpha_generated) - tan(alpha_limit)) + tan(zeta) * tan(inclination)
    of_cones = [1.0 / (cone * tan(delta)) for cone, delta in zip(cones.cone_distance, deltas, strict=True)]
    curvature = cos(spiral_1) * cos(spiral_2) / cos(zeta) / lever * sum(of_cones)
    teeth = (d[0] / module_t, d[1] / module_t)
    normal = cos(base_helix) ** 2 * cos(helix)
    return VirtualGears(
        diameter=d,
        tip_diameter=tip,
        root_diameter=root,
        base_diameter=base,
        centre_distance=0.5 * (d[0] + d[1]),
        teeth=teeth,
        helix_angle=helix,
        base_helix_angle=base_helix,
        transverse_pressure_angle=alpha_t,
        transverse_module=module_t,
        base_pitch=pitch,
        path_of_contact=path,
        face_width=face_width_gear * width_effective / effective,
        effective_face_width=width_effective,
        contact_ratio_profile=profile,
        contact_ratio_profile_normal=profile / cos(base_helix) ** 2,
        contact_ratio_overlap=overlap,
        contact_ratio_overlap_full=overlap / EFFECTIVE_FACE,
        contact_ratio_total=profile + overlap,
        contact_line_inclination=inclination,
        relative_radius=abs(1.0 / curvature) * cos(inclination) ** 2,
        normal_teeth=(teeth[0] / normal, teeth[1] / normal),
    )
