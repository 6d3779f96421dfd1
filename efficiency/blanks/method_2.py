"""Method 2 of ISO 23509 (Oerlikon): the pinion apex lies on the line from the gear apex to the cutter centre.

Equation numbers: ISO 23509:2016 as given in a public secondary source (docs/blank.md).
"""

from dataclasses import dataclass, replace
from functools import partial
from math import asin, atan, atan2, cos, radians, sin, tan

from efficiency.blanks import tangency
from efficiency.blanks.inputs import PairBlankInput
from efficiency.blanks.tangency import PitchCones, bevel_cones
from ehl.common.errors import ConvergenceError, InputError


def method_2(inputs: PairBlankInput) -> PitchCones:
    """Oerlikon cones; a given outer diameter of the gear is obtained by repetition with its mean diameter."""
    spiral = inputs.mean_spiral_angle_gear
    assert spiral is not None

    def closure(cones: PitchCones) -> float:
        return cones.cone_distance[0] / apex_on_cutter_line(inputs, cones, cones.spiral[0] - spiral) - 1.0

    def as_printed() -> tuple[PitchCones, float]:
        cones = _as_printed_any_diameter(inputs, spiral)
        return cones, cones.mean_diameter[1]

    bevel = bevel_cones(inputs, spiral)
    return tangency.gear_cone_method(inputs, bevel, closure, lambda: _start_angle(inputs, spiral), as_printed)


def _as_printed_any_diameter(inputs: PairBlankInput, spiral: float) -> PitchCones:
    if inputs.mean_pitch_diameter_gear is not None:
        return _as_printed(inputs, spiral)
    delta_2 = bevel_cones(inputs, spiral).pitch_angle[1]
    for _ in range(60):
        update = {
            "mean_pitch_diameter_gear": tangency.gear_mean_diameter(inputs, delta_2),
            "outer_pitch_diameter_gear": None,
        }
        cones = _as_printed(inputs.model_copy(update=update), spiral)
        if abs(cones.pitch_angle[1] - delta_2) < 1e-13:
            return cones
        delta_2 = cones.pitch_angle[1]
    raise ConvergenceError("method_2", "the mean diameter that belongs to the outer one was not found")


def apex_on_cutter_line(inputs: PairBlankInput, cones: PitchCones, zeta_mp: float) -> float:
    """R_mcheck [m], Formulae (79) to (82): where the line gear apex - cutter centre meets the element of the pinion.

    Law of sines in the pitch plane, R_m2 sin phi_6/sin(pi - zeta_mp - phi_6) with phi_6 the angle at the gear apex.
    """
    cone = cones.cone_distance[1]
    crown = tangency.crown_gear(inputs, cone, cones.pitch_angle[1], cones.spiral[1])
    return cone * crown.across / (crown.across * cos(zeta_mp) + crown.along * sin(zeta_mp))


@dataclass(frozen=True)
class _Start:
    """Formulae (42) to (56), quantities that are constant during the trials; delta_2 is the first trial value."""

    zeta: float
    factor: float
    diameter_1: float
    eta_1: float
    lead: float
    delta_2: float


def _start(inputs: PairBlankInput, spiral: float, diameter: float) -> _Start:
    sigma, offset, rc = inputs.shaft_angle, inputs.hypoid_offset, inputs.cutter_radius
    ratio = inputs.teeth_gear / inputs.teeth_pinion
    delta_1 = atan(sin(sigma) / (ratio + cos(sigma)))
    delta_2 = sigma - delta_1
    lead = tangency.crown_gear(inputs, diameter / (2.0 * sin(delta_2)), delta_2, spiral).lead
    zeta = asin(2.0 * offset / diameter / (1.0 + cos(delta_2) / (ratio * cos(delta_1))))
    factor = cos(spiral) / cos(spiral + zeta)
    diameter_1 = factor * diameter / ratio
    phi_2 = atan2(ratio * cos(zeta), ratio / tan(delta_2) + (factor - 1.0) * sin(sigma))
    cone = diameter / (2.0 * sin(phi_2))
    eta_1 = atan2(rc * cos(lead) - cone * sin(spiral), rc * sin(lead) + cone * cos(spiral))
    phi_3 = atan2(tan(spiral + eta_1), sin(phi_2))
    delta_1 = atan2(
        diameter_1 * sin(sigma), diameter * cos(zeta) + diameter_1 * cos(sigma) - 2.0 * offset / tan(phi_3 + zeta)
    )
    return _Start(zeta, factor, diameter_1, eta_1, lead, atan(tan(sigma - delta_1) * cos(zeta)))


def _start_angle(inputs: PairBlankInput, spiral: float) -> float:
    """First trial of delta_2, or that of the bevel pair if the approximations of the standard fail."""
    bevel = bevel_cones(inputs, spiral)
    try:
        start = _start(inputs, spiral, bevel.mean_diameter[1]).delta_2
    except (ValueError, ZeroDivisionError, InputError):
        return bevel.pitch_angle[1]
    return start if 0.1 < start < bevel.pitch_angle[1] else bevel.pitch_angle[1]


def _as_printed(inputs: PairBlankInput, spiral: float) -> PitchCones:
    """Trials until |R_m1/R_mcheck - 1| <= 0.01, Formula (82).

    The source does not state how delta_2,imp changes after the first trial. Here the second trial differs by 0.1 deg,
    and linear interpolation follows. The printed sample F.4 stops at the first.
    """
    diameter = inputs.mean_pitch_diameter_gear
    assert diameter is not None
    start = _start(inputs, spiral, diameter)
    first, second = start.delta_2, start.delta_2 + radians(0.1)
    trial = partial(_trial, inputs, spiral, diameter, start)
    return tangency.printed_trials(inputs, trial, first, second, "R_m1/R_mcheck")


def _trial(inputs: PairBlankInput, spiral: float, diameter: float, start: _Start, delta: float) -> PitchCones:
    """One trial of delta_2,imp, Formulae (57) to (82)."""
    sigma, offset = inputs.shaft_angle, inputs.hypoid_offset
    ratio = inputs.teeth_gear / inputs.teeth_pinion
    # improved offset angles, (57) to (62)
    eta_p = atan(sin(start.zeta) * cos(delta) / cos(sigma - delta))
    lever = diameter * tan(delta) + start.diameter_1 * cos(eta_p) * sin(spiral + start.eta_1) / cos(sigma - delta)
    eta_app = atan(2.0 * offset / lever)
    zeta = asin(
        2.0 * offset / diameter - start.factor * tan(eta_app) * sin(delta) * cos(eta_p) / (ratio * cos(sigma - delta))
    )
    zeta_p = atan(tan(zeta) * sin(sigma) / cos(sigma - delta))
    diameter_1 = cos(spiral) / cos(spiral + zeta_p) * diameter / ratio
    # improved pitch angles, (63) to (66); lambda = 90 deg - beta_m2 + nu
    across = diameter / (2.0 * inputs.cutter_radius) - sin(spiral - start.lead) * sin(delta)
    phi_4 = atan2(cos(spiral - start.lead) * sin(sigma), across)
    delta_1 = atan2(
        diameter_1 * sin(sigma),
        diameter * cos(zeta) + diameter_1 * cos(sigma) * cos(eta_p) - 2.0 * offset / tan(phi_4 + zeta),
    )
    delta_2 = atan(tan(sigma - delta_1) * cos(zeta_p))
    # offset angles and pinion cone, (67) to (77)
    phi_5 = atan(tan(delta_2) / cos(zeta))
    eta_p = atan(tan(eta_app) * sin(phi_5) / cos(sigma - phi_5))
    eta = atan(2.0 * offset / (diameter * tan(delta_2) + diameter_1 * cos(eta_p) * sin(phi_5) / cos(sigma - phi_5)))
    zeta_m = asin(tan(delta_2) * tan(eta))
    zeta_mp = atan(tan(zeta_m) * sin(sigma) / cos(sigma - delta_2))
    spiral_1 = spiral + zeta_mp
    diameter_1 = diameter * cos(spiral) / (ratio * cos(spiral_1))
    xi = atan2(sin(sigma) * cos(zeta_m), cos(sigma)) - delta_2
    delta_1 = atan(tan(xi) * cos(zeta_mp))
    cone_1, cone_2 = diameter_1 / (2.0 * sin(delta_1)), diameter / (2.0 * sin(delta_2))
    cones = PitchCones((delta_1, delta_2), (cone_1, cone_2), (spiral_1, spiral))
    return replace(cones, closure=cone_1 / apex_on_cutter_line(inputs, cones, zeta_mp) - 1.0)
