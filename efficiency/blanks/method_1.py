"""Method 1 of ISO 23509 (Gleason): the lengthwise curvature of the tooth equals the limit curvature.

The unknown is eta, the offset angle of the gear in the axial plane. Equation numbers: ISO 23509:2016 as given in a
public secondary source (docs/blank.md).
"""

from dataclasses import dataclass, replace
from math import asin, atan, atan2, cos, degrees, exp, inf, log, pi, sin, tan

from efficiency.blanks import tangency
from efficiency.blanks.inputs import PairBlankInput
from ehl.common.errors import InputError

# share of the gear radius below which rounding hides the limit curvature: cones of a bevel pair
NO_OFFSET = 1e-7


def method_1(inputs: PairBlankInput) -> tangency.PitchCones:
    """Gleason cones. As in the standard: second trial with eta increased by a tenth, then linear interpolation.

    The step of a tenth is not stated in the source; it reproduces the printed numbers of Annex F.3.
    """
    start = _start(inputs)
    if abs(inputs.hypoid_offset) <= NO_OFFSET * start.radius_2:
        bevel = tangency.bevel_cones(inputs, start.desired, 2.0 * start.radius_2)
        return replace(bevel, face_width_factor=_face_width_factor(inputs, bevel))

    def of_eta(eta: float) -> tangency.PitchCones:
        return trial(inputs, start, eta)

    if inputs.pitch_cones != "converged":
        return tangency.printed_trials(inputs, of_eta, start.eta, 1.1 * start.eta, "rho_mbeta/rho_lim")

    def of_log(log_eta: float) -> tangency.PitchCones:
        return of_eta(start.eta * exp(log_eta))

    root, count = tangency.nearest_root(inputs, lambda x: of_log(x).closure, 0.0, log(1.03), 1.0, (-inf, inf))
    return replace(of_log(root), trials=count)


@dataclass(frozen=True)
class _Start:
    """Formulae (8) to (16): desired spiral angle, mean radii [m], hypoid dimension factor K_1, first eta."""

    desired: float
    radius_1: float
    radius_2: float
    factor: float
    eta: float


def _start(inputs: PairBlankInput) -> _Start:
    assert inputs.mean_spiral_angle_pinion is not None
    desired, offset = inputs.mean_spiral_angle_pinion, inputs.hypoid_offset
    ratio, excess = inputs.teeth_gear / inputs.teeth_pinion, inputs.shaft_angle - 0.5 * pi
    if ratio * sin(excess) >= 1.0:
        allowed = f"below {degrees(asin(1.0 / ratio) + 0.5 * pi):.4g} deg for this ratio"
        hint = "Beyond it the gear would be a crown gear or an internal gear."
        raise InputError("shaft_angle", f"{degrees(inputs.shaft_angle):.6g} deg", allowed, hint)
    delta_2 = atan(ratio * cos(excess) / (1.2 * (1.0 - ratio * sin(excess))))
    radius_2 = 0.5 * tangency.gear_mean_diameter(inputs, delta_2)
    largest = radius_2 / sin(delta_2)
    if abs(offset) >= largest:
        raise tangency.too_large(offset, largest)
    epsilon = asin(offset / largest)
    factor = tan(desired) * sin(epsilon) + cos(epsilon)
    radius_1 = radius_2 * factor / ratio
    lever = radius_2 * (tan(delta_2) * cos(excess) - sin(excess)) + radius_1
    return _Start(desired, radius_1, radius_2, factor, atan(offset / lever))


def trial(inputs: PairBlankInput, start: _Start, eta: float) -> tangency.PitchCones:
    """One trial, Formulae (17) to (33) and (41); the cones touch exactly at every eta."""
    excess = inputs.shaft_angle - 0.5 * pi
    r_1, r_2 = start.radius_1, start.radius_2
    sin_epsilon = (inputs.hypoid_offset - r_1 * sin(eta)) / r_2
    intermediate = atan(sin(eta) / (tan(asin(sin_epsilon)) * cos(excess)) + tan(excess) * cos(eta))
    epsilon_p = asin(sin_epsilon * cos(excess) / cos(intermediate))
    spiral = atan((start.factor - cos(epsilon_p)) / sin(epsilon_p))
    growth = sin(epsilon_p) * (tan(start.desired) - tan(spiral))
    r_1 += r_2 * growth * inputs.teeth_pinion / inputs.teeth_gear

    epsilon = asin((inputs.hypoid_offset - r_1 * sin(eta)) / r_2)
    delta_1 = atan(sin(eta) / (tan(epsilon) * cos(excess)) + tan(excess) * cos(eta))
    epsilon_p = asin(sin(epsilon) * cos(excess) / cos(delta_1))
    spiral_1 = atan((start.factor + growth - cos(epsilon_p)) / sin(epsilon_p))
    spiral_2 = spiral_1 - epsilon_p
    delta_2 = atan2(sin(epsilon) / tan(eta) / cos(excess) + cos(epsilon) * tan(excess), 1.0)
    distances = r_1 / sin(delta_1), r_2 / sin(delta_2)
    cones = tangency.PitchCones((delta_1, delta_2), distances, (spiral_1, spiral_2))
    closure = lengthwise_radius(inputs, cones) * limit_curvature(cones, epsilon_p) - 1.0
    return replace(cones, face_width_factor=_face_width_factor(inputs, cones), closure=closure)


def limit_curvature(cones: tangency.PitchCones, zeta_mp: float) -> float:
    """1/rho_lim [1/m], Formula (33): the lengthwise curvature at which pitch-plane sliding keeps its direction."""
    (b_1, b_2), (cone_1, cone_2), (d_1, d_2) = cones.spiral, cones.cone_distance, cones.pitch_angle
    alpha = cones.limit_pressure_angle(zeta_mp)
    bend = tan(b_1) / (cone_1 * tan(d_1)) + tan(b_2) / (cone_2 * tan(d_2))
    level = 1.0 / (cone_1 * cos(b_1)) - 1.0 / (cone_2 * cos(b_2)) - tan(alpha) * bend
    return cos(alpha) * level / (tan(b_1) - tan(b_2))


def lengthwise_radius(inputs: PairBlankInput, cones: tangency.PitchCones) -> float:
    """rho_mbeta, lengthwise radius of curvature of the tooth [m]: r_c0 or the epicycloid's, Formulae (34) to (40)."""
    spiral, cone = cones.spiral[1], cones.cone_distance[1]
    crown = tangency.crown_gear(inputs, cone, cones.pitch_angle[1], spiral)
    radius, lead = crown.radius, crown.lead
    # from the gear apex, normal to the flank: tan of the angle to the cutter centre, Formulae (38) and (52)
    eta = atan2(radius * cos(lead) - cone * sin(spiral), radius * sin(lead) + cone * cos(spiral))
    both = tan(spiral) + tan(eta)
    return cone * cos(spiral) * (tan(spiral) + tan(eta) / (1.0 + tan(lead) * both))


def _face_width_factor(inputs: PairBlankInput, cones: tangency.PitchCones) -> float:
    """c_be2, Formula (41); one half if the mean diameter is given."""
    outer = inputs.outer_pitch_diameter_gear
    if outer is None:
        return 0.5
    return (0.5 * outer / sin(cones.pitch_angle[1]) - cones.cone_distance[1]) / inputs.face_width_gear
