"""Slot widths and top lands along the face (AGMA 929-B22), for generated and non-generated (Formate) gears.

Equations (16) to (81) and (164) to (182) as given in the public repository afuentesaz/AGMAStandards; the information
sheet itself was not available. They are written in cone distances; W_2 depends on the mean slot only (derived).

A Formate gear is cut by a flat tip plane that touches the root cone along one line: next to it the slot is shallower,
the tooth thicker at the pitch cone. Its profile is straight. The pinion profile deviates
from the involute by the deviation of the straight gear profile at the depth of the pinion tip. This interpretation of
Equation (180) is a choice of this work. It reproduces the printed top lands of both samples; the public source deviates
by up to 0.6 mm.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import acos, asin, cos, pi, sin, tan
from typing import Any

from efficiency.blanks.dimensions import FaceAndRoot, Placement, ToothDepth, gear_cone
from efficiency.blanks.lengthwise import Trace
from efficiency.blanks.rating import Pair
from efficiency.blanks.tangency import PitchCones

Three = tuple[float, float, float]
LANDS = ("slot_width", "normal_thickness", "top_land")


@dataclass(frozen=True)
class SlotGeometry:
    """Inputs of the slots; fields as in `efficiency.blanks.pair`.

    `cutter_tilt` is the normal tilt of the cutter of a Formate gear, Equation (48); None for a generated gear.
    """

    cones: PitchCones
    place: Placement
    trace: Trace
    angles: FaceAndRoot
    ends: tuple[Pair, Pair]
    tooth: ToothDepth
    thickness_gear: float
    backlash_in_plane: float
    pitch_share: float
    cutter_tilt: float | None = None

    def spiral_pinion(self, cone_2: float) -> float:
        """Spiral angle of the pinion at cone distance R_2 of the gear."""
        return self.trace.spirals(cone_2, self.place.offset_pitch_plane)[0]

    def spiral(self, member: int, cone: float) -> float:
        """Spiral angle of the pinion (0) or the gear (1) at its own cone distance [m]."""
        return self.trace.spiral(cone) if member else self.spiral_pinion(self.gear_cone(cone))

    def gear_cone(self, cone_1: float) -> float:
        """Cone distance of the gear opposite to one of the pinion."""
        return gear_cone(self.cones, self.place, cone_1)

    def pinion_cone(self, cone_2: float) -> float:
        """Cone distance of the pinion opposite to one of the gear, Equation (55)."""
        mean_1, mean_2 = self.cones.cone_distance
        zeta = asin(self.place.offset_pitch_plane / cone_2)
        return mean_1 + cone_2 * cos(zeta) - mean_2 * cos(self.place.zeta_mp)

    def pitch_ratio(self, cone_2: float) -> float:
        """Normal pitch over that of the mean point."""
        mean = self.cones.cone_distance[1] * cos(self.cones.spiral[1])
        return cone_2 * cos(self.trace.spiral(cone_2)) / mean

    def dedendum_pinion(self, cone_1: float) -> float:
        """h_f1 at R_1 [m]."""
        return self.tooth.dedendums[0] + (cone_1 - self.cones.cone_distance[0]) * tan(self.angles.dedendum_angle[0])

    def dedendum_gear(self, cone_2: float) -> float:
        """h_f2 at R_2 [m], Equations (59) and (60)."""
        along = cone_2 - self.cones.cone_distance[1]
        return self.tooth.dedendums[1] + along * tan(self.angles.dedendum_angle[1]) - self.root_rise(cone_2)

    def root_rise(self, cone_2: float) -> float:
        """Delta h_2 [m]: root of a Formate gear over its root cone, Equation (57); 0 for a generated one."""
        if self.cutter_tilt is None:
            return 0.0
        mean, trace = self.cones.cone_distance[1], self.trace
        radius = trace.cutter_radius * cos(self.cones.spiral[1]) ** 2
        tilted = (cone_2 - mean) ** 2 * tan(self.cutter_tilt) / (2.0 * radius)
        turn = trace.generating_angle(cone_2) - trace.generating_angle(mean)
        return tilted + cone_2 * sin(turn) ** 2 / (2.0 * tan(self.angles.root_angle[1]))

    @property
    def flare(self) -> float:
        """Growth of a slot with its height, tan alpha_nD + tan alpha_nC."""
        return tan(self.tooth.pressure_angles[0]) + tan(self.tooth.pressure_angles[1])

    def slot_gear(self, cone_2: float) -> float:
        """W_2 [m]: constant if a face mill cuts both flanks together; for a face hob it decreases by half a pitch."""
        pitch = pi * self.tooth.module
        mean = pitch - self.thickness_gear - self.tooth.dedendums[1] * self.flare
        return mean - 0.5 * self.pitch_share * pitch * (1.0 - self.pitch_ratio(cone_2))

    def slot_pinion(self, cone_2: float) -> float:
        """W_1 [m] opposite to R_2, Equation (76): pitch minus gear tooth and backlash."""
        ratio = self.pitch_ratio(cone_2)
        depth = self.dedendum_pinion(self.pinion_cone(cone_2)) + self.dedendum_gear(cone_2)
        return ratio * (pi * self.tooth.module + self.backlash_in_plane) - depth * self.flare - self.slot_gear(cone_2)

    def tooth_gear(self, cone_2: float) -> float:
        """s_n2 at R_2 [m], Equation (178)."""
        root = self.slot_pinion(cone_2) + self.dedendum_pinion(self.pinion_cone(cone_2)) * self.flare
        return root - self.pitch_ratio(cone_2) * self.backlash_in_plane

    def tooth_pinion(self, cone_1: float) -> float:
        """s_n1 at R_1 [m], Equation (177); sign of the backlash as in the printed example of Annex C."""
        cone_2 = self.gear_cone(cone_1)
        outer_1, outer_2 = self.ends[0][1], self.ends[1][1]
        outer_loss = self.backlash_in_plane * self.pitch_ratio(outer_2)
        ratio = cone_1 * cos(self.spiral_pinion(cone_2)) / (outer_1 * cos(self.spiral_pinion(self.gear_cone(outer_1))))
        return self.slot_gear(cone_2) + self.dedendum_gear(cone_2) * self.flare - ratio * outer_loss

    def involute_tooth(self, tooth: float, radius: float, height: float) -> float:
        """Thickness [m] of an involute tooth at a height over its pitch radius, in the normal section."""
        angle = tooth / radius
        for alpha in self.tooth.pressure_angles:
            angle += _involute(alpha) - _involute(acos(min(1.0, radius * cos(alpha) / (radius + height))))
        return angle * (radius + height)

    def land_pinion(self, cone_1: float) -> float:
        """s_an1 at R_1 [m], Equations (179) and (180); 0 for a pointed tooth."""
        cone_2 = self.gear_cone(cone_1)
        addendum = self.dedendum_gear(cone_2) - self.tooth.clearances[1]
        radius = cone_1 * tan(self.cones.pitch_angle[0]) / cos(self.spiral_pinion(cone_2)) ** 2
        if addendum <= -0.2 * radius:
            return 0.0
        land = self.involute_tooth(self.tooth_pinion(cone_1), radius, addendum)
        if self.cutter_tilt is not None:
            tooth = self.tooth_gear(cone_2)
            land += self.involute_tooth(tooth, self.radius_gear(cone_2), -addendum) - (tooth + addendum * self.flare)
        return max(0.0, land)

    def land_gear(self, cone_2: float) -> float:
        """s_an2 at R_2 [m], Equations (181) and (182); 0 for a pointed tooth."""
        addendum = self.dedendum_pinion(self.pinion_cone(cone_2)) - self.tooth.clearances[0]
        tooth, radius = self.tooth_gear(cone_2), self.radius_gear(cone_2)
        if addendum <= -0.2 * radius:
            return 0.0
        if self.cutter_tilt is not None:
            return max(0.0, tooth - addendum * self.flare)
        return max(0.0, self.involute_tooth(tooth, radius, addendum))

    def radius_gear(self, cone_2: float) -> float:
        """r_npt2 [m], pitch radius of the gear in its normal section, Equation (165)."""
        return cone_2 * tan(self.cones.pitch_angle[1]) / cos(self.trace.spiral(cone_2)) ** 2


def slots_and_lands(g: SlotGeometry, member: int) -> dict[str, Any]:
    """Slot width at the root, tooth thickness at the pitch cone and top land of the pinion (0) or the gear (1).

    All are normal [m], at toe, mean point and heel. A top land of 0 denotes a tooth pointed below its face cone.
    """
    functions: tuple[tuple[Callable[[float], float], ...], ...] = (
        (lambda cone: g.slot_pinion(g.gear_cone(cone)), g.tooth_pinion, g.land_pinion),
        (g.slot_gear, g.tooth_gear, g.land_gear),
    )
    mean, (toe, heel) = g.cones.cone_distance[member], g.ends[member]
    return {name: (f(toe), f(mean), f(heel)) for name, f in zip(LANDS, functions[member], strict=True)}


def _involute(angle: float) -> float:
    return tan(angle) - angle
