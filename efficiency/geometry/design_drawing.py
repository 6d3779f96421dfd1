"""Gear data of a design for the drawings of both members: the table of a blank file with the values of the flanks."""

import math
from contextlib import suppress
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, Literal

import numpy as np

from efficiency.blanks.drawing import chordal, drawing_table
from efficiency.blanks.rating import RatedPair
from efficiency.contact.gear_flanks import MEMBERS
from efficiency.cutting.blank import Blank, blank_dimensions
from efficiency.design.design import Design
from efficiency.geometry.design_rating import rated_pair
from ehl.common.arrays import finite_or_none
from ehl.common.errors import MixedEhlError
from ehl.common.table import Table


@dataclass(frozen=True)
class DesignDrawing:
    """Gear data of a design, SI units; names as in `PairBlank` and `MemberBlank`."""

    pair: dict[str, float]
    pinion: dict[str, Any]
    gear: dict[str, Any]

    def table(self, units: Literal["metric", "inch"] = "metric") -> Table:
        """One row for each quantity with its symbol, unit, and the values of pinion and gear."""
        pair, pinion, gear = (SimpleNamespace(**part) for part in (self.pair, self.pinion, self.gear))
        return drawing_table(pair, pinion, gear, units)

    def to_dict(self) -> dict[str, Any]:
        """Values of the pair and of both members."""
        return dict(finite_or_none(self.pair | {"pinion": self.pinion, "gear": self.gear}))


def design_drawing(design: Design) -> DesignDrawing:
    """Gear data for the drawings of a design.

    Spiral and pressure angles and thicknesses are those of the flanks in the middle of the face; without flanks there
    they are omitted. The backlash at the heel is that of equal rotation.
    """
    blanks, assembly = [getattr(design, member).blank for member in MEMBERS], design.assembly
    members = [_member(blank, getattr(design, member)) for member, blank in zip(MEMBERS, blanks, strict=True)]
    pair = {
        "module_outer": members[1]["outer_diameter"] / blanks[1].teeth,
        "shaft_angle": assembly.shaft_angle,
        "hypoid_offset": assembly.hypoid_offset,
        "working_depth": sum(blank.mean_addendum for blank in blanks),
        "backlash_normal": assembly.normal_backlash,
    }
    with suppress(MixedEhlError):
        _flanks(rated_pair(design), design, pair, members)
    return DesignDrawing(pair, members[0], members[1])


def _member(blank: Blank, given: Any) -> dict[str, Any]:
    shown = {name: getattr(blank, name) for name in ("teeth", "hand", "pitch_angle", "face_width", "mean_addendum")}
    shown |= {name: getattr(blank, name) for name in ("mean_cone_distance", "pitch_apex_beyond_crossing")}
    shown |= blank_dimensions(blank) | {"mean_whole_depth": blank.mean_addendum + blank.mean_dedendum}
    if given.mounting_distance is not None:
        mounted = given.mounting_distance
        shown |= {"mounting_distance": mounted, "crown_to_back": mounted - shown["crossing_to_crown"]}
        shown["front_crown_to_back"] = mounted - shown["crossing_to_front_crown"]
    return shown


def _flanks(rated: RatedPair, design: Design, pair: dict[str, float], members: list[dict[str, Any]]) -> None:
    """Add the data of the flanks."""
    names = "module_normal", "pressure_angle_drive", "pressure_angle_coast"
    pair |= {name: getattr(rated, name) for name in names}
    if math.isfinite(rated.cutter_radius):
        pair["cutter_radius"] = rated.cutter_radius
    alpha = 0.5 * (rated.pressure_angle_drive + rated.pressure_angle_coast)
    for shown, own, sign in zip(members, (rated.pinion, rated.gear), (1.0, -1.0), strict=True):
        thick = 0.5 * math.pi + 2.0 * (own.thickness_coefficient + sign * rated.profile_shift * math.tan(alpha))
        thick *= rated.module_normal
        place = own.mean_diameter, own.mean_spiral_angle, own.pitch_angle
        chord, height, _ = chordal(thick, own.mean_addendum, *place, alpha)
        shown |= {"mean_spiral_angle": own.mean_spiral_angle, "thickness_coefficient": own.thickness_coefficient}
        shown |= {"mean_normal_thickness": thick, "mean_chordal_thickness": chord, "mean_chordal_addendum": height}
    gear = design.gear.blank
    at = np.array([0.5 * gear.face_width])
    heel = [flank.solve(at, np.zeros(1)) for flank in design.flanks().of("gear").values()]
    if all(found.all() for _, found in heel):
        outer = np.mean([points.angles(gear.pitch_angle)[0][0] for points, _ in heel])
        widened = members[1]["outer_cone_distance"] / gear.mean_cone_distance / math.cos(rated.gear.mean_spiral_angle)
        backlash = design.assembly.normal_backlash * widened
        pair["backlash_outer_normal"] = backlash * math.cos(outer)
        pair["backlash_outer_transverse"] = backlash / math.cos(alpha)
