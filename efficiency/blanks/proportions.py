"""Tooth proportions: factors of depth and thickness, and the taper of the depth along the face (ISO 23509 Annex C).

Equation numbers: ISO 23509:2016 as read in a public secondary source (docs/blank.md).
"""

from dataclasses import dataclass
from math import atan, cos, degrees, pi, sin, sqrt, tan

from efficiency.blanks.inputs import DepthTypeOne, PairBlankInput
from efficiency.blanks.tangency import PitchCones
from efficiency.cutting.process import PROCESSES
from ehl.common.errors import InputError

# Annex C, from memory of it and of AGMA 2005; teeth of the pinion: factor. 12 (hypoid: 11) and more: 2
DEPTH_FACTOR_BEVEL = {6: 1.765, 7: 1.835, 8: 1.895, 9: 1.940, 10: 1.975, 11: 1.995}
DEPTH_FACTOR_HYPOID = {6: 1.75, 7: 1.80, 8: 1.85, 9: 1.90, 10: 1.95}
ADDENDUM_FACTOR_HYPOID = {6: 0.110, 7: 0.130, 8: 0.150}


@dataclass(frozen=True)
class DepthFactors:
    """Factors of the basic crown gear, in mean normal modules (data type I)."""

    profile_shift: float  # x_hm1, of the pinion; the gear has its negative
    # k_hap, k_hfp
    addendum: float
    dedendum: float
    thickness: float  # x_smn, theoretical thickness modification of the pinion
    defaults: tuple[str, ...] = ()  # recommended values that were taken


def factors(inputs: PairBlankInput, cones: PitchCones) -> DepthFactors:
    """Factors of data type I, or type II converted by Table 4, with the recommendations of Annex C."""
    depth = inputs.depth
    if isinstance(depth, DepthTypeOne):
        if depth.dedendum_factor < depth.addendum_factor:
            raise InputError(
                "depth.dedendum_factor",
                depth.dedendum_factor,
                f"at least the addendum factor {depth.addendum_factor:.4g}",
                "A negative clearance makes tip and root collide.",
            )
        return DepthFactors(
            depth.profile_shift, depth.addendum_factor, depth.dedendum_factor, depth.thickness_modification
        )
    taken: list[str] = []

    def chosen(name: str, value: float | None, recommended: float) -> float:
        if value is not None:
            return value
        taken.append(f"depth.{name} = {recommended:.4g}")
        return recommended

    k_d = chosen("depth_factor", depth.depth_factor, recommended_depth_factor(inputs))
    c_ham = chosen("gear_addendum_factor", depth.gear_addendum_factor, recommended_addendum_factor(inputs, cones))
    k_t = chosen("thickness_factor", depth.thickness_factor, recommended_thickness_factor(inputs))
    return DepthFactors(k_d * (0.5 - c_ham), 0.5 * k_d, k_d * (depth.clearance_factor + 0.5), 0.5 * k_t, tuple(taken))


def recommended_depth_factor(inputs: PairBlankInput) -> float:
    """k_d, Table C.1 (from memory)."""
    table = DEPTH_FACTOR_HYPOID if inputs.hypoid_offset > 0.0 else DEPTH_FACTOR_BEVEL
    return table.get(max(6, inputs.teeth_pinion), 2.0)


def recommended_addendum_factor(inputs: PairBlankInput, cones: PitchCones) -> float:
    """c_ham, Table C.2 (from memory; it gives the input of sample F.2 to its last digit)."""
    if inputs.hypoid_offset > 0.0 and inputs.teeth_pinion < 21:
        return ADDENDUM_FACTOR_HYPOID.get(max(6, inputs.teeth_pinion), 0.170)
    ratio = inputs.teeth_gear / inputs.teeth_pinion
    equivalent = sqrt(ratio * cos(cones.pitch_angle_1) / cos(cones.pitch_angle_2))
    return 0.210 + 0.290 / equivalent**2


def recommended_thickness_factor(inputs: PairBlankInput) -> float:
    """k_t, the curve of Figure C.1 (AGMA 2005 form, from memory; gives the input of sample F.2 to its last digit)."""
    u = inputs.teeth_gear / inputs.teeth_pinion
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
    """theta_a2, theta_f2 and the taper that was used, Annex C.5.

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
            "Below it the teeth would grow towards the toe: take a larger cutter, or taper.type = 'uniform'.",
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
