"""Two pitch cones that touch at the calculation point: Method 0, exact tangency, and the common part of Methods 1 to 3.

Equation numbers are those of ISO 23509:2016 as given in a public secondary source (docs/blank.md); the standard
itself was not available. Index 1 is the pinion, 2 the gear (the standard's wheel). SI units, rad.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import asin, atan, copysign, cos, degrees, hypot, pi, radians, sin, tan

import scipy

from efficiency.blanks.inputs import PairBlankInput
from efficiency.blanks.rating import Pair
from ehl.common.errors import ConvergenceError, InputError

# beyond these a bevel member cannot be cut; the pair is refused
SPIRAL_LIMIT = radians(82.0)
PITCH_ANGLE_LOWEST = radians(0.25)
PITCH_ANGLE_HIGHEST = radians(89.75)
# largest closure of Methods 1 and 2 as printed
TOLERANCE = 0.01


@dataclass(frozen=True)
class PitchCones:
    """Result of all methods: the cones at the calculation point."""

    pitch_angle: Pair  # delta_1, delta_2
    cone_distance: Pair  # R_m1, R_m2 [m], from the apex to the calculation point
    spiral: Pair  # beta_m1, beta_m2
    face_width_factor: float = 0.5  # c_be2, the share of the gear's face width outside the calculation point
    trials: int = 0  # trials of the method's iteration, 0 without iteration
    # relative residual of the condition of the method: rho_mbeta/rho_lim - 1 (Method 1), R_m1/R_mcheck - 1 (2),
    # R_mint/R_m1 - 1 (3)
    closure: float = 0.0

    @property
    def mean_diameter(self) -> Pair:
        """d_m1, d_m2 [m], Formulae (110) and (111)."""
        (cone_1, cone_2), (delta_1, delta_2) = self.cone_distance, self.pitch_angle
        return 2.0 * cone_1 * sin(delta_1), 2.0 * cone_2 * sin(delta_2)

    def limit_pressure_angle(self, zeta_mp: float) -> float:
        """alpha_lim of these cones [rad] (`limit_pressure_angle`)."""
        return limit_pressure_angle(*self.pitch_angle, *self.cone_distance, *self.spiral, zeta_mp)


def too_large(offset: float, largest: float | None = None) -> InputError:
    """The error for an offset without a pair of cones."""
    allowed = "a smaller offset"
    if largest is not None:
        allowed = f"within +-{abs(largest) * 1e3:.4g} mm for these teeth, diameter and angles"
    hint = "Beyond it a pitch angle or the spiral angle of the pinion leaves the range that can be cut."
    return InputError("hypoid_offset", f"{offset * 1e3:.6g} mm", allowed, hint)


def bevel_cones(inputs: PairBlankInput, spiral: float, mean_diameter: float | None = None) -> PitchCones:
    """Method 0, Formulae (1) to (7): both cones share the apex.

    `mean_diameter` d_m2 replaces that of the inputs for methods with their own calculation point.
    """
    ratio = inputs.teeth_gear / inputs.teeth_pinion
    denominator = cos(inputs.shaft_angle) + ratio
    delta_1 = atan(sin(inputs.shaft_angle) / denominator)
    delta_2 = inputs.shaft_angle - delta_1
    check_pitch_angles(delta_1, delta_2, inputs)
    cone = (mean_diameter or gear_mean_diameter(inputs, delta_2)) / (2.0 * sin(delta_2))
    return PitchCones((delta_1, delta_2), (cone, cone), (spiral, spiral))


def face_too_wide(inputs: PairBlankInput, outer: float) -> InputError:
    """The error of a face that reaches the apex."""
    allowed = f"below {outer * 1e3:.4g} mm, the outer cone distance; usual is up to 0.3 of it"
    return InputError("face_width_gear", f"{inputs.face_width_gear * 1e3:.6g} mm", allowed)


def check_pitch_angles(delta_1: float, delta_2: float, inputs: PairBlankInput) -> None:
    """Refuse cones that are not bevel members: needles, crown gears and internal gears."""
    if delta_2 >= PITCH_ANGLE_HIGHEST or min(delta_1, delta_2) <= PITCH_ANGLE_LOWEST:
        stated, allowed = f"{degrees(inputs.shaft_angle):.6g} deg", "pitch angles between 0.25 and 89.75 deg"
        found = f"{degrees(delta_1):.4g} deg (pinion) and {degrees(delta_2):.4g} deg (gear)"
        raise InputError("shaft_angle", stated, allowed, f"This shaft angle, ratio and offset give {found}.")


def limit_pressure_angle(
    delta_1: float, delta_2: float, cone_1: float, cone_2: float, spiral_1: float, spiral_2: float, zeta_mp: float
) -> float:
    """alpha_lim, Formulae (32), (117), (240): no sliding along the profile at the pitch point."""
    lever = (cone_1 * sin(spiral_1) - cone_2 * sin(spiral_2)) / (cone_1 * tan(delta_1) + cone_2 * tan(delta_2))
    return -atan(tan(delta_1) * tan(delta_2) / cos(zeta_mp) * lever)


def _touching(
    inputs: PairBlankInput, zeta_m: float, delta_2: float, mean_diameter_2: float, spiral_2: float
) -> PitchCones:
    """Cones whose axes include zeta_m, seen along the pitch plane; Formulae (90) to (95)."""
    sigma = inputs.shaft_angle
    delta_1 = asin(max(-1.0, min(1.0, cos(zeta_m) * sin(sigma) * cos(delta_2) - cos(sigma) * sin(delta_2))))
    zeta_mp = asin(max(-1.0, min(1.0, sin(zeta_m) * sin(sigma) / cos(delta_1))))
    spiral_1 = spiral_2 + zeta_mp
    diameter_1 = mean_diameter_2 * inputs.teeth_pinion / inputs.teeth_gear * cos(spiral_2) / cos(spiral_1)
    cone_1, cone_2 = diameter_1 / (2.0 * sin(delta_1)), mean_diameter_2 / (2.0 * sin(delta_2))
    return PitchCones((delta_1, delta_2), (cone_1, cone_2), (spiral_1, spiral_2))


def tangent_cones(inputs: PairBlankInput, delta_2: float, mean_diameter_2: float, spiral_2: float) -> PitchCones:
    """A gear cone and the pinion cone that touches it at the hypoid offset of the pair, exactly.

    The calculation point lies in the middle of the gear's face.
    The pitch plane touches both cones: sin delta_1 = cos zeta_m sin Sigma cos delta_2 - cos Sigma sin delta_2; equal
    normal modules: d_m1 = d_m2 z_1 cos beta_m2/(z_2 cos beta_m1); the offset: 2 a = sin zeta_m (d_m2 + d_m1 cos delta_2
    /cos delta_1), Formula (113). One equation for zeta_m, solved by Brent's method.
    """

    def reach(zeta_m: float) -> float:
        cones = _touching(inputs, zeta_m, delta_2, mean_diameter_2, spiral_2)
        return 0.5 * sin(zeta_m) * (mean_diameter_2 + cones.mean_diameter[0] * cos(delta_2) / cos(cones.pitch_angle[0]))

    offset = inputs.hypoid_offset
    if offset == 0.0:
        return _touching(inputs, 0.0, delta_2, mean_diameter_2, spiral_2)
    # largest zeta_m at which the pinion is a cone within the spiral limit; by bisection
    largest, high = 0.0, copysign(0.5 * pi, offset)
    for _ in range(60):
        middle = 0.5 * (largest + high)
        cones = _touching(inputs, middle, delta_2, mean_diameter_2, spiral_2)
        possible = abs(sin(middle)) * sin(inputs.shaft_angle) < cos(cones.pitch_angle[0])
        possible = possible and abs(cones.spiral[0]) < SPIRAL_LIMIT and cones.pitch_angle[0] > PITCH_ANGLE_LOWEST
        largest, high = (middle, high) if possible else (largest, middle)
    if abs(reach(largest)) <= abs(offset):
        raise too_large(offset, reach(largest))
    zeta_m = float(scipy.optimize.brentq(lambda zeta: reach(zeta) - offset, 0.0, largest, xtol=1e-15, rtol=8.9e-16))
    return _touching(inputs, zeta_m, delta_2, mean_diameter_2, spiral_2)


def gear_mean_diameter(inputs: PairBlankInput, delta_2: float) -> float:
    """d_m2 of the calculation point in the middle of the face."""
    if inputs.mean_pitch_diameter_gear is not None:
        return inputs.mean_pitch_diameter_gear
    assert inputs.outer_pitch_diameter_gear is not None
    diameter = inputs.outer_pitch_diameter_gear - inputs.face_width_gear * sin(delta_2)
    if diameter <= inputs.face_width_gear * sin(delta_2):
        raise face_too_wide(inputs, inputs.outer_pitch_diameter_gear / (2.0 * sin(delta_2)))
    return diameter


def nearest_root(
    inputs: PairBlankInput,
    closure: Callable[[float], float],
    start: float,
    step: float = radians(0.25),
    growth: float = 1.3,
    limits: tuple[float, float] = (PITCH_ANGLE_LOWEST, PITCH_ANGLE_HIGHEST),
) -> tuple[float, int]:
    """The unknown nearest to the start at which the closure of a method vanishes; number of evaluations.

    The bracket is extended from the start on both sides, so that the nearest of several roots is found. The unknown is
    the pitch angle of the gear unless step, growth of the step and limits are given.
    """
    count = 0

    def value(unknown: float) -> float:
        nonlocal count
        count += 1
        return closure(unknown)

    low = high = start
    at_low = at_high = value(start)
    if at_low == 0.0:
        return start, count
    for _ in range(120):
        trial_low, trial_high = max(low - step, limits[0]), min(high + step, limits[1])
        for new, edge, at_edge in ((trial_low, low, at_low), (trial_high, high, at_high)):
            if new == edge:
                continue
            try:
                at_new = value(new)
            except (ValueError, ZeroDivisionError):
                continue
            if at_new * at_edge <= 0.0:
                a, b = sorted((new, edge))
                root = float(scipy.optimize.brentq(value, a, b, xtol=1e-15, rtol=8.9e-16))
                # a pole changes sign as well
                if abs(value(root)) < 1e-6:
                    return root, count
            if new < start:
                low, at_low = new, at_new
            else:
                high, at_high = new, at_new
        step *= growth
    raise too_large(inputs.hypoid_offset)


def printed_trials(
    inputs: PairBlankInput, trial: Callable[[float], PitchCones], first: float, second: float, condition: str
) -> PitchCones:
    """Trials of the standard until the closure is within `TOLERANCE`; from the third on by linear interpolation."""
    old, new, before = first, second, trial(first)
    if abs(before.closure) <= TOLERANCE:
        return replace(before, trials=1)
    for count in range(2, 30):
        cones = trial(new)
        if abs(cones.closure) <= TOLERANCE:
            return replace(cones, trials=count)
        old, new, before = new, new - cones.closure * (new - old) / (cones.closure - before.closure), cones
    raise ConvergenceError(f"method_{inputs.method}", f"{condition} - 1 is {before.closure:.2g} after 30 trials")


def gear_cone_method(
    inputs: PairBlankInput,
    bevel: PitchCones,
    closure: Callable[[PitchCones], float],
    start: Callable[[], float],
    as_printed: Callable[[], tuple[PitchCones, float | None]],
) -> PitchCones:
    """Cones of Methods 2 and 3, whose unknown is the pitch angle of the gear.

    bevel: of the pair without offset.
    closure: relative residual of the condition of the method.
    start: pitch angle of the gear from which the root is searched.
    as_printed: cones by the trials of the standard; d_m2 of the touching cones, None where it follows from the pitch
        angle.
    """
    if inputs.hypoid_offset == 0.0:
        return bevel

    def touching(delta_2: float, diameter: float | None = None) -> PitchCones:
        return tangent_cones(inputs, delta_2, diameter or gear_mean_diameter(inputs, delta_2), bevel.spiral[1])

    if inputs.pitch_cones == "converged":
        delta_2, trials = nearest_root(inputs, lambda angle: closure(touching(angle)), start())
        cones = touching(delta_2)
    else:
        printed, diameter = as_printed()
        if inputs.pitch_cones == "standard":
            return printed
        cones, trials = touching(printed.pitch_angle[1], diameter), printed.trials
    return replace(cones, trials=trials, closure=closure(cones))


@dataclass(frozen=True)
class CrownGear:
    """Position of the cutter on the developed pitch cone of the gear."""

    lead: float  # nu, lead angle of the cutter; 0 for a face mill
    radius: float  # r_c0 [m]
    # cutter centre from the gear apex [m], along the element through the calculation point and normal to it
    along: float
    across: float

    @property
    def distance(self) -> float:
        """rho_P0, gear apex to cutter centre [m], Formulae (37), (79), (177)."""
        return hypot(self.along, self.across)


def crown_gear(inputs: PairBlankInput, cone_2: float, delta_2: float, spiral_2: float) -> CrownGear:
    """Cutter centre in the developed pitch plane of the gear.

    sin nu = z_0 m_mn/(2 r_c0), Formulae (35), (98), (176); rho_P0^2 = R_m2^2 + r_c0^2 - 2 R_m2 r_c0 sin(beta_m2 - nu).
    """
    rc, groups = inputs.cutter_radius, inputs.blade_groups or 0
    module = 2.0 * cone_2 * sin(delta_2) * cos(spiral_2) / inputs.teeth_gear
    least = 0.5 * groups * module
    if least >= rc:
        allowed = f"above {least * 1e3:.4g} mm with {groups} blade groups"
        raise InputError("cutter_radius", f"{rc * 1e3:.6g} mm", allowed, "Take a larger head or fewer blade groups.")
    lead = asin(least / rc)
    return CrownGear(lead, rc, cone_2 - rc * sin(spiral_2 - lead), rc * cos(spiral_2 - lead))
