"""The four flanks of a gear pair and the position of its members: input of all contact computations."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from efficiency.contact.assembly import Assembly
from efficiency.contact.ease_off import conjugate_points, pinion_phase
from efficiency.contact.relief import FlankDeviation, PairRelief
from efficiency.cutting.blank import Blank
from efficiency.cutting.cutter import FlankSide
from efficiency.cutting.flank import Flank
from ehl.common.errors import ConvergenceError

Member = Literal["pinion", "gear"]
Side = Literal["drive", "coast"]
MEMBERS: tuple[Member, ...] = ("pinion", "gear")
SIDES: tuple[Side, ...] = ("drive", "coast")


@dataclass(frozen=True)
class GearFlanks:
    """Flanks of a pair in its assembly."""

    name: str  # name of the pair
    # flank of each side, ``"concave"`` and ``"convex"``
    pinion: Mapping[FlankSide, Flank]
    gear: Mapping[FlankSide, Flank]
    assembly: Assembly  # position of the members with their misalignments
    drive_flank_pinion: FlankSide = "concave"  # loaded pinion flank on the drive side
    normal_backlash: float = 0.0  # backlash normal to the flanks at the mean point, removed from the pinion tooth [m]
    relief: PairRelief = field(default_factory=PairRelief)  # relief of the flanks at their edges
    deviation: FlankDeviation = field(default_factory=FlankDeviation)  # of the flanks from their design

    def of(self, member: Member) -> Mapping[FlankSide, Flank]:
        """Both flanks of a member."""
        return self.pinion if member == "pinion" else self.gear

    def blank(self, member: Member) -> Blank:
        """Blank of a member."""
        return self.of(member)["concave"].blank

    def clearance(self, member: Member) -> float:
        """Clearance between the root of a member and the tip of its mate at the mean point, at least 0 [m]."""
        mate = self.blank("gear" if member == "pinion" else "pinion")
        return max(self.blank(member).mean_dedendum - mate.mean_addendum, 0.0)

    def loaded_side(self, member: Member, side: Side) -> FlankSide:
        """The loaded flank of a member on the drive or the coast side."""
        concave = (self.drive_flank_pinion == "concave") == ((member == "pinion") == (side == "drive"))
        return "concave" if concave else "convex"

    def mating(self, side: Side) -> tuple[Flank, Flank]:
        """Pinion and gear flank in contact on the drive or the coast side."""
        return self.pinion[self.loaded_side("pinion", side)], self.gear[self.loaded_side("gear", side)]

    @cached_property
    def pinion_phases(self) -> dict[FlankSide, float]:
        """Rotation of each pinion flank for contact with its gear flank in the aligned pair [rad]."""
        phases: dict[FlankSide, float] = {}
        for side in SIDES:
            pinion, gear = self.mating(side)
            middle = np.array([0.5 * (gear.blank.mean_addendum - pinion.blank.mean_addendum)])
            points, found = gear.solve(np.zeros(1), middle)
            if not found.all():
                raise ConvergenceError("undercut", f"the {gear.side} gear flank does not reach its design point")
            phases[pinion.side] = pinion_phase(conjugate_points(points, self.assembly.aligned), pinion)
        return phases
