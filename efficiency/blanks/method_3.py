"""Method 3 of ISO 23509 (Klingelnberg): the mean cone distance of the pinion follows from the cutter.

Equation numbers: ISO 23509:2016 as given in a public secondary source (docs/blank.md).
"""

from dataclasses import replace
from math import acos, asin, atan, cos, sin, tan

from efficiency.blanks.inputs import PairBlankInput
from efficiency.blanks.tangency import PitchCones, bevel_cones, crown_gear, gear_cone_method, gear_mean_diameter
from ehl.common.errors import ConvergenceError

TOLERANCE = 1e-4


def method_3(inputs: PairBlankInput) -> PitchCones:
    """Klingelnberg cones. As in the standard: the formulas repeated until |R_mint - R_m1| <= 0.0001 R_m1."""
    spiral = inputs.mean_spiral_angle_gear
    assert spiral is not None
    bevel = bevel_cones(inputs, spiral)

    def closure(cones: PitchCones) -> float:
        return cutter_cone_distance(inputs, cones) / cones.cone_distance[0] - 1.0

    return gear_cone_method(
        inputs, bevel, closure, lambda: bevel.pitch_angle[1], lambda: (_as_printed(inputs, spiral, bevel), None)
    )


def cutter_cone_distance(inputs: PairBlankInput, cones: PitchCones) -> float:
    """R_mint [m], Formulae (98) to (105)."""
    (spiral_1, spiral), (delta_1, delta_2), cone = cones.spiral, cones.pitch_angle, cones.cone_distance[1]
    zeta_mp = spiral_1 - spiral
    zeta_m = asin(sin(zeta_mp) * cos(delta_1) / sin(inputs.shaft_angle))
    lead = crown_gear(inputs, cone, delta_2, spiral).lead
    theta = atan(sin(delta_2) * tan(zeta_m))
    a_3 = inputs.cutter_radius * cos(spiral - lead) ** 2
    a_4 = cone * cos(spiral + theta) * cos(spiral)
    a_5 = sin(zeta_mp) * cos(theta) * cos(lead)
    a_6 = cone * cos(spiral) + inputs.cutter_radius * sin(lead)
    a_7 = cos(spiral_1) * cos(spiral + theta) - sin(spiral + theta - lead) * sin(zeta_mp) / cos(spiral - lead)
    return a_3 * a_4 / (a_5 * a_6 + a_3 * a_7)


def _as_printed(inputs: PairBlankInput, spiral: float, bevel: PitchCones) -> PitchCones:
    """Formulae (84) to (108): successive substitution of both pitch angles and the hypoid dimension factor F."""
    sigma = inputs.shaft_angle
    ratio = inputs.teeth_gear / inputs.teeth_pinion
    (delta_1, delta_2), factor = bevel.pitch_angle, 1.0
    for count in range(1, 200):
        diameter = gear_mean_diameter(inputs, delta_2)
        zeta_m = asin(2.0 * inputs.hypoid_offset / (diameter * (1.0 + factor * cos(delta_2) / (ratio * cos(delta_1)))))
        delta_1 = asin(cos(zeta_m) * sin(sigma) * cos(delta_2) - cos(sigma) * sin(delta_2))
        zeta_mp = asin(sin(zeta_m) * sin(sigma) / cos(delta_1))
        factor = cos(spiral) / cos(spiral + zeta_mp)
        diameter_1 = diameter * factor / ratio
        distances = diameter_1 / (2.0 * sin(delta_1)), diameter / (2.0 * sin(delta_2))
        cones = PitchCones((delta_1, delta_2), distances, (spiral + zeta_mp, spiral), trials=count)
        cone = cutter_cone_distance(inputs, cones)
        closure = cone / distances[0] - 1.0
        delta_1 = asin(diameter_1 / (2.0 * cone))
        delta_2 = acos(
            (sin(delta_1) * cos(zeta_m) * sin(sigma) + cos(delta_1) * cos(zeta_mp) * cos(sigma))
            / (1.0 - (sin(sigma) * sin(zeta_m)) ** 2)
        )
        if abs(closure) <= TOLERANCE:
            share = 0.5
            if inputs.outer_pitch_diameter_gear is not None:
                # the last delta_2 moves the middle of the face off the calculation point; the outer diameter stays
                outer_cone = inputs.outer_pitch_diameter_gear / (2.0 * sin(delta_2))
                share = (outer_cone - distances[1]) / inputs.face_width_gear
            return replace(cones, pitch_angle=(delta_1, delta_2), face_width_factor=share, closure=closure)
    raise ConvergenceError("method_3", f"R_mint/R_m1 - 1 is {closure:.2g} after 200 trials")
