"""Tooth trace on the developed gear cone: circle of a face mill, epicycloid of a face hob; spiral angles along it.

One formula serves both: with base radius rho_b = rho_P0/(1 + (z_0/z_2) sin delta_2) and the angle q at the gear apex,
cos q = (R^2 + rho_P0^2 - r_c0^2)/(2 R rho_P0), tan beta = (R - rho_b cos q)/(rho_b sin q); a face mill has
rho_b = rho_P0 (Formulae (176) to (194) of ISO 23509:2016; that the circle is the case z_0 = 0 is derived here).
"""

from dataclasses import dataclass
from math import acos, asin, atan2, cos, degrees, radians, sin

from efficiency.blanks.inputs import PairBlankInput
from efficiency.blanks.rating import Pair
from efficiency.blanks.tangency import PitchCones, crown_gear
from ehl.common.errors import InputError

# largest spiral angle on the faces; for steeper pinions, of 1 to 3 teeth, the increase above their mean, and the
# maximum
SPIRAL_AT_THE_ENDS, STEEPER, STEEPEST = radians(75.0), radians(8.0), radians(85.0)


@dataclass(frozen=True)
class Trace:
    """Tooth trace of the gear."""

    cutter_radius: float  # r_c0 [m]
    cutter_lead_angle: float  # nu, lead angle of the cutter; 0 for a face mill
    crown_to_cutter: float  # rho_P0 [m], gear apex to cutter centre
    epicycloid_base_radius: float  # rho_b [m], base circle of the epicycloid; rho_P0 for a face mill

    def reaches(self, cone: float) -> bool:
        """Whether the cutter reaches cone distance R [m]."""
        return abs(cone - self.crown_to_cutter) < self.cutter_radius < cone + self.crown_to_cutter

    def generating_angle(self, cone: float) -> float:
        """q at cone distance R [m]."""
        rho = self.crown_to_cutter
        return acos((cone**2 + rho**2 - self.cutter_radius**2) / (2.0 * cone * rho))

    def spiral(self, cone: float) -> float:
        """Spiral angle of the gear at cone distance R [m]."""
        q, base = self.generating_angle(cone), self.epicycloid_base_radius
        return atan2(cone - base * cos(q), base * sin(q))

    def spirals(self, cone: float, offset_in_plane: float) -> Pair:
        """Spiral angles of both members at cone distance R of the gear and offset a_p in the pitch plane [m]."""
        gear = self.spiral(cone)
        return gear + asin(offset_in_plane / cone), gear


def tooth_trace(inputs: PairBlankInput, cones: PitchCones) -> Trace:
    """Trace through the calculation point."""
    crown = crown_gear(inputs, cones.cone_distance[1], cones.pitch_angle[1], cones.spiral[1])
    turns = inputs.indexing * sin(cones.pitch_angle[1])
    return Trace(crown.radius, crown.lead, crown.distance, crown.distance / (1.0 + turns))


def check_trace(inputs: PairBlankInput, cones: PitchCones, places: tuple[float, ...], offset_in_plane: float) -> Trace:
    """The trace, if it runs through the whole face of both members with spiral angles below the steepest.

    places: cone distances of the gear [m] that must be reached: its own ends, and those of the pinion's face.
    offset_in_plane: a_p [m].
    """
    trace = tooth_trace(inputs, cones)
    steepest = max(SPIRAL_AT_THE_ENDS, min(abs(cones.spiral[0]) + STEEPER, STEEPEST))
    if _serves(trace, places, offset_in_plane, steepest):
        return trace

    def with_radius(radius: float) -> bool:
        try:
            other = tooth_trace(inputs.model_copy(update={"cutter_radius": radius}), cones)
        except InputError:
            return False
        return _serves(other, places, offset_in_plane, steepest)

    low, high = inputs.cutter_radius, inputs.cutter_radius
    for _ in range(24):
        high *= 1.3
        if with_radius(high):
            break
    else:
        allowed = "a smaller face width, spiral angle or offset: no cutter radius keeps the spiral angles below "
        stated = f"{inputs.face_width_gear * 1e3:.6g} mm"
        raise InputError("face_width_gear", stated, f"{allowed}{degrees(steepest):.0f} deg")
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if with_radius(middle) else (middle, high)
    stated = f"{inputs.cutter_radius * 1e3:.6g} mm"
    allowed = f"about {high * 1e3:.4g} mm or more, for spiral angles below {degrees(steepest):.0f} deg everywhere"
    raise InputError("cutter_radius", stated, allowed, "Or take a smaller face width or spiral angle.")


def _serves(trace: Trace, places: tuple[float, ...], offset_in_plane: float, steepest: float) -> bool:
    for place in places:
        if abs(offset_in_plane) >= place or not trace.reaches(place):
            return False
        if max(map(abs, trace.spirals(place, offset_in_plane))) >= steepest:
            return False
    return True
