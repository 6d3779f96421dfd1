"""Cutting processes: face milling, face hobbing with one-part and two-part heads, as objects in `PROCESSES`.

An object holds all properties that depend on the indexing of the head: the blade of a design file, the lengthwise
curve, defaults and limits of the blank, the blade of the conjugate pinion and the settings of a fit. Whether the
profile is generated depends on the machine (`efficiency.cutting.machine.GENERATIONS`). The indexing is a number
(`CutFlank.index_ratio`): the work rotates by blade groups over teeth per rotation of the cutter, zero for a face mill.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import replace
from math import gcd, tan
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from efficiency.cutting.blank import Depth, Hand, Length
from efficiency.cutting.cutter import Blade, FlankSide, Protuberance, Relief
from efficiency.cutting.machine import Turn
from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel

BladeAngle = Annotated[float, ValueRange("rad", gt=-0.35, lt=0.9)]
Curvature = Annotated[float, ValueRange("1/m", ge=-100.0, le=100.0)]
RakeAngle = Annotated[float, ValueRange("rad", ge=-0.6, le=0.6)]

# settings of a pinion fit, by the names of `machine_settings.fit.PARAMETERS`
PLAIN = ("axis_x", "axis_y", "radial_setting", "blank_offset", "sliding_base", "machine_centre_to_back", "roll_ratio")
MODIFIED = ("modified_roll_2c", "modified_roll_6d")
MOTIONS = (*MODIFIED, "helical_motion_1")

CUTTER_TAPERED = 1.1  # smallest r_c0/(R_m2 sin beta_m2) of tapered face-milled teeth (AGMA 2005, unverified)
CUTTER_UNIFORM = 1.5  # largest ratio for face-milled uniform depth (AGMA 2005, unverified)


class BladeInput(InputModel):
    """Edge of one blade: straight or an arc, with edge radius and reliefs tangent to it."""

    blade_angle: BladeAngle  # angle of the edge to the cutter axis at the reference height [rad]
    blade_curvature: Curvature = 0.0  # curvature at the reference height [1/m]; 0 for a straight edge
    reference_height: Depth = 0.0  # height above the blade tip [m]; 0 is the tip plane
    edge_radius: Depth = 0.0  # radius at the blade tip [m]
    # reliefs of the profile
    toprem: Relief | None = None
    protuberance: Protuberance | None = None
    flankrem: Relief | None = None

    @model_validator(mode="after")
    def _edge(self) -> Self:
        if self.toprem is not None and self.protuberance is not None:
            raise InputError("protuberance", "given together with a toprem", "either toprem or protuberance")
        low = self.toprem or self.protuberance
        if low is not None and self.flankrem is not None and self.flankrem.height <= low.height:
            height = f"{self.flankrem.height * 1e3:.6g} mm"
            raise InputError("flankrem.height", height, f"above {low.height * 1e3:.6g} mm")
        if low is not None and self.edge_radius >= low.height:
            raise InputError("edge_radius", f"{self.edge_radius * 1e3:.6g} mm", f"below {low.height * 1e3:.6g} mm")
        return self

    def blade(self, side: FlankSide, hand: Hand) -> Blade:
        """The blade that cuts one flank of a member."""
        raise NotImplementedError

    def _blade(self, side: FlankSide, radius: float, **head: Any) -> Blade:
        names = ("blade_angle", "reference_height", "edge_radius", "toprem", "protuberance", "flankrem")
        own = {name: getattr(self, name) for name in names}
        return Blade(point_radius=radius, side=side, curvature=self.blade_curvature, **own, **head)


class RadiusLimit(NamedTuple):
    """Recommended limit of the cutter radius: its side, ``"at least"`` or ``"at most"``, and the remedy."""

    side: str
    limit: float
    remedy: str


class CuttingProcess(ABC):
    """Indexing of the head and dependent properties."""

    name: ClassVar[str]  # in files
    cutter: ClassVar[type[BladeInput]]  # table `cutter` of a flank in a design file
    # whether the position of a blade around the head is a setting that rotates its flank about its axis
    blade_phase: ClassVar[bool] = False
    # fraction of half a pitch by which the slot of a gear narrows towards the toe, 0 to 1 (AGMA 929)
    pitch_share: ClassVar[float] = 0.0
    # largest ratio of widest to narrowest slot of one member; infinite if the head changes the slot along the face
    widest_slot: ClassVar[float] = np.inf
    root_weight: ClassVar[float] = 0.03  # residual per root error of a pinion whose flanks share one setting
    curved_blades: ClassVar[bool] = False  # whether pinion blades may be curved if each flank has its own setting
    # default answers of a new targets file: taper, gear_cutting, pinion_cutting, blade_groups
    usual: ClassVar[dict[str, str]]

    @property
    def label(self) -> str:
        """Name in a sentence and in a setting sheet."""
        return self.name.replace("_", " ")

    @abstractmethod
    def check_blade_groups(self, groups: int | None) -> None:
        """Raise an `InputError` for an invalid number of blade groups."""

    def taper(self, cutter_radius: float, uniform_radius: float) -> str:
        """Usual depth taper for r_c0 and R_m2 sin beta_m2 [m]."""
        return "uniform"

    def radius_limit(self, taper: str, uniform_radius: float) -> RadiusLimit | None:
        """Recommended limit of the cutter radius for R_m2 sin beta_m2, in the same unit."""
        return None

    def common_factors(self, groups: int, teeth: tuple[int, int]) -> Iterator[tuple[str, int]]:
        """Pairs of numbers that should have no common factor, and their greatest common factor."""
        return iter(())

    @abstractmethod
    def cutter_table(self, blade: Blade, mirror: float) -> dict[str, str | float | int]:
        """A blade as table `cutter` of a design file; `mirror` is +1 for a right-hand member."""

    @abstractmethod
    def conjugate_reference(self, blade: Blade, reach: float, depth: float) -> tuple[float, float]:
        """Radius and reference height [m] of the pinion blade with the reversed profile of the gear blade.

        blade: blade of the gear.
        reach: distance of both tip planes [m].
        depth: dedendum of the pinion along its cutter axis [m].
        """

    @abstractmethod
    def shared_settings(self, free_form: bool, radius_offsets: bool) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Common settings of both pinion flanks and settings of each flank, if one setting cuts both.

        free_form: any relative motion; otherwise the machine is a cradle machine.
        radius_offsets: whether each blade may be displaced normal to its cutting direction.
        """


class FaceMillingCutter(BladeInput):
    """One blade of a face mill; see also `BladeInput`."""

    type: Literal["face_milling"] = "face_milling"
    point_radius: Length | None = None  # radius of the (extended) profile at the tip plane [m]
    # alternatively: mean radius and distance of the blades of a spread-blade cutter [m]
    cutter_radius: Length | None = None
    point_width: Depth | None = None

    @model_validator(mode="after")
    def _radius(self) -> Self:
        spread = self.cutter_radius, self.point_width
        if self.point_radius is None and None in spread:
            allowed = "a length such as '114.3 mm', or cutter_radius and point_width instead"
            raise InputError("point_radius", None, allowed)
        if self.point_radius is not None and spread != (None, None):
            raise InputError("point_radius", "given together with cutter_radius or point_width", "only one of the two")
        if self.point_radius is None and 0.5 * float(self.point_width or 0.0) >= float(self.cutter_radius or 0.0):
            raise InputError("point_width", self.point_width, "below the cutter diameter")
        return self

    def blade(self, side: FlankSide, hand: Hand) -> Blade:
        """The blade that cuts one flank; a face mill is used for both hands."""
        sign = 1.0 if side == "concave" else -1.0
        radius = self.point_radius
        if radius is None:
            assert self.cutter_radius is not None
            assert self.point_width is not None
            radius = self.cutter_radius + sign * 0.5 * self.point_width
        return self._blade(side, radius + sign * self.reference_height * tan(self.blade_angle))


class FaceMilling(CuttingProcess):
    """Single indexing: the lengthwise tooth curve is a circle."""

    name = "face_milling"
    cutter = FaceMillingCutter
    widest_slot = 2.0
    usual: ClassVar = {
        "taper": "tilted_root",
        "gear_cutting": "generated",
        "pinion_cutting": "each_flank",
        "blade_groups": "",
    }

    def check_blade_groups(self, groups: int | None) -> None:
        """Raise an `InputError` for any number; a face mill has no blade groups."""
        if groups is not None:
            raise InputError("blade_groups", groups, "no value: a face mill has no blade groups")

    def taper(self, cutter_radius: float, uniform_radius: float) -> str:
        """Tapered depth unless the cutter is small."""
        return "tilted_root" if cutter_radius > uniform_radius else "uniform"

    def radius_limit(self, taper: str, uniform_radius: float) -> RadiusLimit | None:
        """Large cutters for tapered depth, small ones for uniform depth."""
        if uniform_radius <= 0.0:
            return None
        if taper != "uniform":
            return RadiusLimit("at least", CUTTER_TAPERED * uniform_radius, "Smaller cutters require uniform depth.")
        return RadiusLimit("at most", CUTTER_UNIFORM * uniform_radius, "Larger cutters require tapered depth.")

    def cutter_table(self, blade: Blade, mirror: float) -> dict[str, str | float | int]:
        """Point radius of the profile extended to the tip plane."""
        tip = blade.point_radius - blade.sign * blade.reference_height * float(np.tan(blade.blade_angle))
        table: dict[str, str | float | int] = {"type": self.name, "point_radius": tip, "blade_angle": blade.blade_angle}
        if blade.curvature:
            table |= {"blade_curvature": blade.curvature, "reference_height": blade.reference_height}
        return table

    def conjugate_reference(self, blade: Blade, reach: float, depth: float) -> tuple[float, float]:
        """Values at the pitch plane, where the radius depends least on the blade angle."""
        return blade.point_radius + blade.sign * (reach - depth) * np.tan(blade.blade_angle), depth

    def shared_settings(self, free_form: bool, radius_offsets: bool) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Settings without blade phase: the rotation of the work is shared, and modified roll is used."""
        return (*PLAIN, *MODIFIED, "phase"), ("blade_angle", "point_radius", "curvature")


class FaceHobbingCutter(BladeInput):
    """One blade of each group of a face-hobbing head; see also `BladeInput`."""

    type: Literal["face_hobbing"]
    cutter_radius: Length  # radius of the profile at the reference height [m]
    blade_groups: Annotated[int, Field(ge=1, le=60)]  # number of blade groups of the head
    # angle of the plane of the profile to the axial plane, at the cutter radius [rad]
    blade_offset_angle: Annotated[float, ValueRange("rad", ge=0.0, lt=1.2)]
    # displacement of the profile outwards, normal to the cutting direction [m]
    radius_offset: Annotated[float, ValueRange("m", ge=-0.05, le=0.05)] = 0.0
    blade_phase: Turn = 0.0  # position of the blade around the cutter axis [rad]
    # angles of the front face [rad]
    rake_angle: RakeAngle = 0.0
    hook_angle: RakeAngle = 0.0

    def blade(self, side: FlankSide, hand: Hand) -> Blade:
        """The blade that cuts one flank; the head of a left-hand member is mirrored."""
        mirror = 1.0 if hand == "right" else -1.0
        angles = {"offset_angle": self.blade_offset_angle, "phase": self.blade_phase}
        angles |= {"rake": self.rake_angle, "hook": self.hook_angle}
        head = {name: mirror * angle for name, angle in angles.items()}
        return self._blade(side, self.cutter_radius, radius_offset=self.radius_offset, groups=self.blade_groups, **head)


class FaceHobbing(CuttingProcess):
    """Continuous indexing: the lengthwise tooth curve is an epicycloid, the slot width depends on the blade phase."""

    name = "face_hobbing"
    cutter: ClassVar[type[BladeInput]] = FaceHobbingCutter
    blade_phase = True
    pitch_share = 1.0
    root_weight = 0.02
    curved_blades = True
    usual: ClassVar = {"taper": "uniform", "gear_cutting": "formate", "pinion_cutting": "both_flanks"}

    def check_blade_groups(self, groups: int | None) -> None:
        """Raise an `InputError` for a missing number of blade groups."""
        if groups is None:
            raise InputError("blade_groups", None, "the number of blade groups of the face-hobbing head")

    def common_factors(self, groups: int, teeth: tuple[int, int]) -> Iterator[tuple[str, int]]:
        """Numbers without common factors, so that each blade group and tooth meets all teeth of the mate."""
        numbers = {"z_0": groups, "z_1": teeth[0], "z_2": teeth[1]}
        for one, other in (("z_1", "z_2"), ("z_0", "z_1"), ("z_0", "z_2")):
            yield f"{one} and {other}", gcd(numbers[one], numbers[other])

    def cutter_table(self, blade: Blade, mirror: float) -> dict[str, str | float | int]:
        """Radius at the reference height, offset angle and phase."""
        return {
            "type": self.name,
            "cutter_radius": blade.point_radius,
            "blade_groups": blade.groups,
            "blade_offset_angle": mirror * blade.offset_angle,
            "blade_angle": blade.blade_angle,
            "reference_height": blade.reference_height,
            "radius_offset": blade.radius_offset,
            "blade_curvature": blade.curvature,
            "blade_phase": mirror * blade.phase,
        }

    def conjugate_reference(self, blade: Blade, reach: float, depth: float) -> tuple[float, float]:
        """The reference point of the gear blade relative to the other tip plane."""
        return blade.point_radius, reach - blade.reference_height

    def shared_settings(self, free_form: bool, radius_offsets: bool) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Cutter axis, radial setting, work position and roll ratio; each blade has angle, radius and phase."""
        if not radius_offsets:
            return (*PLAIN, *MOTIONS), ("blade_angle", "curvature", "phase")
        plain = PLAIN if free_form else (*PLAIN, *MODIFIED)
        return plain, ("blade_angle", "radius_offset", "curvature", "phase")


# smallest eccentricity of a part (hollow flank) and largest one, at most a fifth of the cutter radius (ours) [m]
HOLLOW, ECCENTRIC = -5e-3, 0.02


def check_eccentricity(value: float, radius: float, crowned: str = "", field: str = "eccentricity") -> None:
    """Raise an `InputError` for an eccentricity outside the range of a head of a given radius [m].

    crowned: flank of the pinion whose crowning requires the eccentricity.
    """
    limit = min(ECCENTRIC, 0.2 * radius)
    if not HOLLOW <= value <= limit:
        allowed = f"{HOLLOW * 1e3:g} to {limit * 1e3:.4g} mm with a cutter radius of {radius * 1e3:.5g} mm"
        remedy = f"Increase crowning_toe and crowning_heel of the {crowned} pinion flank, or reduce its bias."
        if value > limit:
            remedy = f"It reaches about {limit / value:.0%} of the lengthwise crowning of the {crowned} pinion flank."
        raise InputError(field, f"{value * 1e3:.4g} mm", allowed, remedy if crowned else "")


class TwoPartCutter(FaceHobbingCutter):
    """One blade of each group of a two-part head, whose part for that flank has its own axis; see also `BladeInput`."""

    type: Literal["two_part_face_hobbing"]  # type: ignore[assignment]
    # displacement of the axis of this part from that of the machine [m]: by the same amount the outside blades have a
    # larger radius and the inside blades a smaller one, so that positive values crown the tooth
    eccentricity: Annotated[float, ValueRange("m", ge=HOLLOW, le=ECCENTRIC)]
    # angle from the normal of the cutting direction at the mean point to the direction of that displacement [rad]
    eccentricity_angle: Turn = 0.0

    @model_validator(mode="after")
    def _eccentric(self) -> Self:
        check_eccentricity(self.eccentricity, self.cutter_radius)
        return self

    def blade(self, side: FlankSide, hand: Hand) -> Blade:
        """The blade that cuts one flank."""
        blade = super().blade(side, hand)
        angle = self.eccentricity_angle if hand == "right" else -self.eccentricity_angle
        return replace(blade, eccentricity=blade.sign * self.eccentricity, eccentricity_angle=angle)


class TwoPartFaceHobbing(FaceHobbing):
    """Continuous indexing with a two-part head: eccentric axes of outside and inside blades crown the tooth."""

    name = "two_part_face_hobbing"
    cutter = TwoPartCutter
    usual: ClassVar = {"taper": "uniform", "gear_cutting": "generated", "pinion_cutting": "both_flanks"}

    def cutter_table(self, blade: Blade, mirror: float) -> dict[str, str | float | int]:
        """Values of a face-hobbing head and the eccentricity."""
        value, direction = blade.sign * blade.eccentricity, mirror * blade.eccentricity_angle
        check_eccentricity(value, blade.point_radius, blade.side)
        return super().cutter_table(blade, mirror) | {"eccentricity": value, "eccentricity_angle": direction}

    def shared_settings(self, free_form: bool, radius_offsets: bool) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Settings as in face hobbing, on a cradle machine without tilt; each part has its eccentricity."""
        common = PLAIN if free_form else tuple(name for name in PLAIN if not name.startswith("axis"))
        return common, ("blade_angle", "eccentricity", "curvature", "phase")


_ALL = (FaceMilling(), FaceHobbing(), TwoPartFaceHobbing())
PROCESSES: dict[str, CuttingProcess] = {process.name: process for process in _ALL}
