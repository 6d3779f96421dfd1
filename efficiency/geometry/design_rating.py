"""Load capacity of the pair of a design after ISO 10300, Method B1, as of a blank file with a table `rating`.

The calculation point is the middle of the face of both members. Spiral and pressure angles and tooth thicknesses are
those of the flanks there; cones, depths and offset are those of the design.
"""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from efficiency.blanks.agma_2003 import AgmaRating, rate_agma
from efficiency.blanks.dimensions import placement
from efficiency.blanks.iso_10300 import RZ_OF_RQ, FlankRating, rate_flank
from efficiency.blanks.pair_blank import agma_tables, rating_tables
from efficiency.blanks.rating import RatedMember, RatedPair, RatingInput, RatingLoad, as_pair
from efficiency.blanks.tangency import PitchCones
from efficiency.blanks.virtual_gears import virtual_gears
from efficiency.conditions.duty import DutyRow
from efficiency.contact.gear_flanks import MEMBERS, SIDES, Member
from efficiency.contact.tooth_grid import normal_thickness
from efficiency.cutting.cutter import FLANK_SIDES, Blade
from efficiency.design.design import Design, PairDesign
from efficiency.strength.root_mesh import EDGE_RADIUS
from ehl.common.arrays import finite_or_none
from ehl.common.errors import InputError
from ehl.common.pages import Reportable
from ehl.common.sections import Head, Medium, Section
from ehl.fluid.oil import Oil


@dataclass(frozen=True, repr=False)
class DesignRating(Reportable):
    """Load capacity of both flanks of a design."""

    name: str
    inputs: RatingInput  # torque, speed, factors, material and oil of the rating
    drive: FlankRating
    coast: FlankRating
    agma_2003: AgmaRating | None  # with a table `rating.agma_2003`
    notes: tuple[str, ...]  # values that the design does not contain
    status: str = "converged"
    reason: str = ""

    def __repr__(self) -> str:
        safety = f"S_H {min(self.drive.safety_pitting):.3g}, S_F {min(self.drive.safety_root):.3g}"
        return f"DesignRating({self.name}: drive {safety})"

    def to_dict(self) -> dict[str, Any]:
        """All values as plain numbers, lists and tables, SI units."""
        return dict(finite_or_none(asdict(self) | {"inputs": self.inputs.model_dump()}))

    def sections(self, medium: Medium = "page", *args: Any, **options: Any) -> list[Section]:
        """The rating sheet: factors of both flanks, stresses and safety factors of both members."""
        title = f"{self.name}: {self.inputs.torque:.5g} N m, {self.inputs.speed * 30.0 / math.pi:.5g} rpm at the pinion"
        both = {"drive": self.drive, "coast": self.coast}
        return [Section("", [Head(title), *rating_tables(both, self.notes), *agma_tables(self.agma_2003)])]


def rate_design(
    design: PairDesign, torque: float | None = None, speed: float | None = None, rows: Sequence[DutyRow] = ()
) -> DesignRating:
    """Load capacity of a design at a pinion torque [N m] and speed [rad/s], by default its operating point.

    The rows of a duty cycle are the load spectrum, each of the flank that it loads, instead of that of the design.
    """
    if not isinstance(design, Design):
        raise InputError("design", design.name, "a bevel or hypoid pair", "ISO 10300 does not apply to it.")
    own, notes = design.operation, []
    materials = {member: getattr(design, member).elastic_material() for member in MEMBERS}
    limits = {}
    for name in ("contact_endurance", "bending_endurance"):
        for member, material in materials.items():
            if getattr(material, name) is None:
                allowed = f"a material with {name}"
                raise InputError(f"{member}.material", material.name, allowed, "It limits the stress of the rating.")
        limits[name] = min(getattr(material, name) for material in materials.values())
    rq = 0.5 * (design.pinion.roughness_rms + design.gear.roughness_rms)
    if rq > 0.0:
        limits["flank_rz"] = RZ_OF_RQ * rq
    else:
        notes.append("the design has no roughness: Rz of the flanks 8 um")
    pair = rated_pair(design)
    for member in MEMBERS:
        radius = min((blade.edge_radius for blade in _blades(design, member)), default=0.0)
        if radius <= 0.0:
            radius = EDGE_RADIUS * pair.module_normal
            assumed = f"{1e3 * radius:.3g} mm, {EDGE_RADIUS:g} normal modules"
            notes.append(f"edge radius of the {member} assumed: {assumed}")
        limits[f"edge_radius_{member}"] = radius
    loads = {side: tuple(_steps(rows, side)) if rows else design.rating.loads for side in SIDES}
    inputs = RatingInput(
        **(design.rating.model_dump() | limits),
        torque=own.torque if torque is None else torque,
        speed=own.speed if speed is None else speed,
        viscosity_kinematic_40=Oil.load(own.oil).viscosity_kinematic_40,
    )
    drive, coast = (rate_flank(pair, inputs.model_copy(update={"loads": loads[side]}), side) for side in SIDES)
    # AGMA 2003 rates both flanks with the same numbers
    agma = rate_agma(pair, inputs.model_copy(update={"loads": loads["drive"] or loads["coast"]}))
    return DesignRating(design.name, inputs, drive, coast, agma, tuple(notes))


def _steps(rows: Sequence[DutyRow], side: str) -> list[RatingLoad]:
    used = [row for row in rows if row.side == side and row.torque != 0.0 and row.speed != 0.0 and row.hours > 0.0]
    return [RatingLoad(torque=abs(row.torque), speed=abs(row.speed), hours=row.hours) for row in used]


def _blades(design: Design, member: Member) -> list[Blade]:
    """Blades of the flanks of a member; those of a measured flank are nominal, other points have none."""
    part = getattr(design, member)
    nominal = ((side, getattr(part, side).nominal) for side in FLANK_SIDES)
    return [own.cutter.blade(side, part.blank.hand) for side, own in nominal if own is not None]


def rated_pair(design: Design) -> RatedPair:
    """Geometry of a design for the rating."""
    design = design.with_misalignment()
    flanks, blanks = design.flanks(), [getattr(design, member).blank for member in MEMBERS]
    # (drive, coast), (pinion, gear): spiral angle, pressure angle
    angles = np.array([[flank.mean_angles() for flank in flanks.mating(side)] for side in SIDES])
    spirals, alphas = np.abs(angles[..., 0].mean(axis=0)), angles[..., 1].mean(axis=1)
    one, two = blanks
    distances = one.mean_cone_distance, two.mean_cone_distance
    cones = PitchCones((one.pitch_angle, two.pitch_angle), distances, as_pair(spirals))
    diameters = cones.mean_diameter
    place = placement(design.assembly.shaft_angle, design.assembly.hypoid_offset, cones)
    limit = cones.limit_pressure_angle(place.zeta_mp)
    if flanks.loaded_side("pinion", "drive") == "convex":
        limit = -limit
    module = diameters[1] * math.cos(cones.spiral[1]) / two.teeth
    shift = 0.5 * (one.mean_addendum - two.mean_addendum) / module
    middle, alpha = np.zeros(1), float(alphas.mean())
    widths = (normal_thickness(flanks, member, middle, middle)[0] for member in MEMBERS)
    members = [
        RatedMember(
            blank.teeth,
            blank.pitch_angle,
            blank.mean_cone_distance,
            diameter,
            diameter + blank.face_width * math.sin(blank.pitch_angle),
            blank.face_width,
            float(spiral),
            blank.mean_addendum,
            blank.mean_addendum + blank.mean_dedendum,
            0.5 * (float(width) / module - 0.5 * math.pi) - sign * shift * math.tan(alpha),
        )
        for blank, diameter, spiral, width, sign in zip(blanks, diameters, spirals, widths, (1.0, -1.0), strict=True)
    ]
    heights = (one.mean_addendum, two.mean_addendum), (one.mean_dedendum, two.mean_dedendum)
    drive, coast = (
        virtual_gears(cones, place, module, heights, two.face_width, alpha, own)
        for alpha, own in zip(map(float, alphas), (limit, -limit), strict=True)
    )
    cut = [blade.point_radius for blade in _blades(design, "gear")]
    return RatedPair(
        pinion=members[0],
        gear=members[1],
        ratio=1.0 / design.ratio,
        hypoid_offset=design.assembly.hypoid_offset,
        cutter_radius=float(np.mean(cut)) if cut else math.inf,  # without effect if the flanks are given by points
        module_normal=module,
        offset_angle=place.zeta_m,
        offset_angle_pitch_plane=place.zeta_mp,
        pressure_angle_drive=float(alphas[0]),
        pressure_angle_coast=float(alphas[1]),
        effective_pressure_angle_drive=float(alphas[0]) - limit,
        effective_pressure_angle_coast=float(alphas[1]) + limit,
        profile_shift=shift,
        dedendum_factor=0.5 * sum(heights[1]) / module,
        virtual_drive=drive,
        virtual_coast=coast,
    )
