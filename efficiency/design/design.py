"""The design file of a gear pair: blanks, cutters, machine settings, assembly, oil and operating point.

Storage of elastic bodies, roots and geometry on disk, identified by the content of the design.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeVar

import numpy as np
from pydantic import Field, model_validator

from efficiency.blanks.rating import RatingFactors
from efficiency.contact.assembly import Assembly, DisplacedAxes
from efficiency.contact.gear_flanks import MEMBERS, GearFlanks, Member, Side
from efficiency.contact.relief import FlankDeviation, MemberRelief, PairRelief
from efficiency.cutting.blank import Blank, Depth, Length, blank_dimensions
from efficiency.cutting.cutter import FLANK_SIDES, FlankSide
from efficiency.cutting.flank import Flank
from efficiency.design import flank_input
from efficiency.design.flank_input import ConjugateFlankInput, CutFlankInput, FlankInput, FlankTable
from efficiency.design.shaft_input import MISALIGNMENTS as MISALIGNMENTS
from efficiency.design.shaft_input import Deflection as Deflection
from efficiency.design.shaft_input import Misalignment as Misalignment
from efficiency.design.shaft_input import StiffnessInput
from efficiency.loss.kinematics import Driver, OperatingPoint, Operation
from efficiency.loss.lubrication import CoolingInput
from efficiency.ltca.solid_tooth import Bodies, ToothBody
from ehl.common.data import data_names, data_path, named_file
from ehl.common.errors import InputError
from ehl.common.private_files import kept
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel, Name, read_toml, validate
from ehl.common.version import __version__
from ehl.inputs import RA, PeklenikNumber, Rms
from ehl.inputs import Length as TextureLength
from ehl.material import Material
from ehl.surface.finish import FLANK_SKEWNESS, Finish, State
from ehl.uncertainty.spread import UncertaintyInput

Surface = Literal["base", "toe", "heel"]
Modulus = Annotated[float, ValueRange("Pa", gt=0.0, le=1e15)]

# default rim thickness over whole depth: above this backup ratio AGMA 2001 (unverified) does not count a rim as thin
BACKUP_RATIO = 1.2
# largest fractions of the distance from the root to the axis, for the default rim and a given one
_TO_AXIS, _MAX_TO_AXIS = 0.5, 0.9


class BodyInput(InputModel):
    """Body under the teeth: from the root cone to its base, between the end faces of the teeth.

    The base is the seat of a ring gear, the bore or core of a pinion.
    """

    # distance of the base from the root cone, normal to the pitch cone [m]; default: 1.2 whole depths, at most half the
    # distance to the axis
    rim_thickness: Length | None = None
    held: Annotated[tuple[Surface, ...], Field(min_length=1)] = ("base",)  # surfaces fixed to the shaft
    # Young's modulus of the body [Pa]; default: that of the teeth. A very large one makes the body rigid, a small one
    # represents a web.
    youngs_modulus: Modulus | None = None

    def thickness(self, blank: Blank) -> float:
        """Rim thickness for a blank [m]."""
        ends = np.array([-0.5, 0.5]) * blank.face_width
        to_axis = float(blank.axial(ends, blank.root(ends))[0].min()) / math.cos(blank.pitch_angle)
        if self.rim_thickness is None:
            return min(BACKUP_RATIO * (blank.mean_addendum + blank.mean_dedendum), _TO_AXIS * to_axis)
        if self.rim_thickness > _MAX_TO_AXIS * to_axis:
            allowed = f"at most {_MAX_TO_AXIS * to_axis * 1e3:.6g} mm, {_MAX_TO_AXIS:g} of the way from root to axis"
            raise InputError("body.rim_thickness", f"{self.rim_thickness * 1e3:.6g} mm", allowed)
        return self.rim_thickness


class FlankSurfaceInput(InputModel):
    """Table [surface]: common texture of both flanks, as [surface] of a contact file."""

    # correlation length across the contact line [m]; default: from the finishes of the members, without a finish 40 Rq
    correlation_length: TextureLength | None = None
    # correlation length along the contact line over that across it [-]; default: from the angle between lay and contact
    # line, without a finish 1
    peklenik_number: PeklenikNumber | None = None


EdgeRounding = Annotated[
    float, ValueRange("m", ge=1e-6, le=5e-3, hint="Radius at the tip, toe and heel edges of the teeth, as in '0.2 mm'.")
]


class MemberSurface(InputModel):
    """Common inputs of members of all kinds of pairs: material and finish."""

    instead = dict.fromkeys(("ra", "rq", "roughness_ra", "roughness"), "Give Rq as roughness_rms. " + RA)

    material: str = "steel"  # name of a material card
    finish: str | None = None  # finish of the flanks: ground, lapped, honed, superfinished, milled
    finish_state: State = "run_in"  # state of that finish
    roughness_rms: Rms = 0.0  # Rq of the flanks [m]; default: that of the finish, without a finish 0

    @model_validator(mode="after")
    def _finished(self) -> Self:
        Material.load(self.material)
        finish = self.surface_finish()
        if finish is not None and "roughness_rms" not in self.model_fields_set:
            self.__dict__["roughness_rms"] = finish.roughness_rms.value
        return self

    def surface_finish(self) -> Finish | None:
        """Finish of the flanks, or None."""
        return None if self.finish is None else Finish.load(self.finish, self.finish_state)

    def elastic_material(self) -> Material:
        """Material of the member."""
        return Material.load(self.material)


class PairDesign(InputModel):
    """Common inputs of designs of all kinds of pairs: members with a finish, oil, operating point."""

    # name and origin
    name: Name
    source: str = ""
    operation: OperatingPoint  # default operating point
    cooling: CoolingInput = CoolingInput()  # lubrication of the teeth
    surface: FlankSurfaceInput = FlankSurfaceInput()  # texture of the flanks
    uncertainty: UncertaintyInput = UncertaintyInput()  # spreads instead of those of the oil card and the defaults
    if TYPE_CHECKING:
        pinion: Any
        gear: Any

        @property
        def ratio(self) -> float:
            """Speed of the gear over that of the pinion [-]."""

        @property
        def common_face_width(self) -> float:
            """Common face width of both members [m]."""

    def with_finish(self, finish: str, state: State = "run_in") -> Self:
        """The pair with a shipped finish on both flanks, with its Rq and correlation lengths."""
        rms = Finish.load(finish, state).roughness_rms.value
        made = {"finish": finish, "finish_state": state, "roughness_rms": rms}
        members: dict[str, Any] = {name: getattr(self, name).model_copy(update=made) for name in MEMBERS}
        return self.model_copy(update={**members, "surface": FlankSurfaceInput()})

    def surface_skewness(self) -> float:
        """Skewness of the heights of both flanks together [-]; `FLANK_SKEWNESS` for members without a finish."""
        members = [getattr(self, name) for name in MEMBERS]
        if not any(member.roughness_rms for member in members):
            return FLANK_SKEWNESS
        finishes = [member.surface_finish() for member in members]
        each = [FLANK_SKEWNESS if finish is None else finish.skewness.value for finish in finishes]
        weights = [member.roughness_rms**3 for member in members]
        return float(np.average(each, weights=weights))

    def running(self, speed: float, temperature: float, driver: Driver = "pinion") -> Operation:
        """Operation at a pinion speed [rad/s] and an oil temperature [K]."""
        return Operation(
            speed,
            temperature,
            self.pinion.roughness_rms,
            self.gear.roughness_rms,
            driver,
            correlation_length=self.surface.correlation_length,
            peklenik_number=self.surface.peklenik_number,
            uncertainty=self.spreads(),
            finish_pinion=self.pinion.surface_finish(),
            finish_gear=self.gear.surface_finish(),
        )

    def spreads(self) -> UncertaintyInput:
        """Spreads of the inputs: as stated, or from the finish if both rough members have the same.

        The Peklenik number of two different finishes has the range of a given one.
        """
        members = [member for member in (self.pinion, self.gear) if member.roughness_rms > 0.0]
        texture = self.surface.model_dump(exclude_none=True)
        finishes = {(member.finish, member.finish_state) for member in members}
        if len(finishes) != 1 or members[0].finish is None:
            if any(member.finish is not None for member in members):
                texture.setdefault("peklenik_number", 1.0)
            return self.uncertainty.of_surface(roughness_rms=1e-6, **texture) if texture else self.uncertainty
        one = members[0]
        own = Finish.load(one.finish, one.finish_state).roughness_rms.value
        given = [member.roughness_rms for member in members if member.roughness_rms != own]
        known = texture | ({"roughness_rms": given[0]} if given else {})
        return self.uncertainty.of_surface(finish=one.finish, finish_state=one.finish_state, **known)


class MemberInput(MemberSurface):
    """One member: blank, both flanks, material and surface.

    Tables `cutter` and `machine` on the level of `concave` and `convex` hold common values of both flanks (completing,
    spread blade); the tables of a flank add to them or override them.
    """

    blank: Blank  # cones and teeth
    # flanks: by cutter and machine settings, by points, or (pinion only) by an ease-off
    concave: FlankInput
    convex: FlankInput
    # radius of the tip, toe and heel edges [m]; default: 0.05 of the mean transverse module
    edge_rounding: EdgeRounding | None = None
    edge_relief: MemberRelief = MemberRelief()  # relief of the flanks at tip, toe and heel
    body: BodyInput = BodyInput()  # body under the teeth
    # from the crossing point to the locating face behind the teeth, along the axis [m]
    mounting_distance: Length | None = None

    @model_validator(mode="before")
    @classmethod
    def _share(cls, content: Any) -> Any:
        if not isinstance(content, dict) or not {"cutter", "machine"} & content.keys():
            return content
        own = dict(content)
        for part in ("cutter", "machine"):
            shared = own.pop(part, {})
            if not isinstance(shared, dict):
                raise InputError(part, shared, f"a table [{part}] with the common values of both flanks")
            for side in ("concave", "convex"):
                flank = own.get(side, {})
                if not isinstance(flank, dict) or not isinstance(flank.get(part, {}), dict):
                    continue
                if "ease_off" in flank or ("grid" in flank and "measurement_uncertainty" not in flank):
                    continue
                own[side] = flank | {part: shared | flank.get(part, {})}
        return own

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        self.body.thickness(self.blank)
        self.edge_relief.check(self.blank)
        crown = blank_dimensions(self.blank)["crossing_to_crown"]
        if self.mounting_distance is not None and self.mounting_distance <= crown:
            text = f"{1e3 * self.mounting_distance:.6g} mm"
            allowed = f"above {1e3 * crown:.5g} mm, the distance of the outer tip circle from the crossing point"
            raise InputError("mounting_distance", text, allowed, "The locating face is behind the teeth.")
        for side in FLANK_SIDES:
            getattr(self, side).check(side, self.blank)
        return self

    @property
    def completing(self) -> bool:
        """Whether one machine setting cuts both flanks."""
        one, other = self.concave, self.convex
        return isinstance(one, CutFlankInput) and isinstance(other, CutFlankInput) and one.machine == other.machine

    def flank(self, side: FlankSide) -> Flank:
        """One of the two flanks; `Design.flank` also returns those that follow from the mate."""
        given: FlankTable = getattr(self, side)
        return _flank(given, side, self.blank, given.version)

    def tooth_body(self) -> ToothBody:
        """Material of the teeth and the body under them."""
        rim = self.body.thickness(self.blank)
        return ToothBody(self.elastic_material(), rim, frozenset(self.body.held), self.body.youngs_modulus)


@lru_cache(maxsize=32)
def _flank(given: FlankTable, side: FlankSide, blank: Blank, _version: int) -> Flank:
    """The flank, shared by both flank pairs and the teeth, because it stores starting values of its points."""
    return given.flank(side, blank)


class AssemblyInput(InputModel):
    """Position of the axes and which flanks drive."""

    shaft_angle: Annotated[float, ValueRange("rad", ge=0.5, le=2.6)]  # angle of the axes [rad]
    # distance of the axes [m]; 0 for a spiral bevel pair, positive if it increases the spiral angle of the pinion
    hypoid_offset: Annotated[float, ValueRange("m", ge=-0.5, le=0.5)] = 0.0
    drive_flank_pinion: FlankSide = "concave"  # loaded pinion flank on the drive side
    normal_backlash: Depth = 0.0  # backlash normal to the flanks at the mean point [m]
    misalignment: Misalignment = Misalignment()  # misalignment without load
    deflection: Deflection = Deflection()  # stated displacements under load
    flank_deviation: FlankDeviation = FlankDeviation()  # of the flanks in contact from their design
    # shafts, bearings and housing whose deflection is solved together with the contact
    stiffness: StiffnessInput = StiffnessInput()


class Design(PairDesign):
    """A gear pair: the content of a design file."""

    assembly: AssemblyInput
    pinion: MemberInput
    gear: MemberInput
    rating: RatingFactors = RatingFactors()  # factors, life and load spectrum of the load capacity after ISO 10300

    @model_validator(mode="after")
    def _pair(self) -> Self:
        if self.pinion.blank.hand == self.gear.blank.hand:
            raise InputError("pinion.blank.hand", self.pinion.blank.hand, "the opposite of the gear's hand")
        if self.pinion.blank.teeth > self.gear.blank.teeth:
            allowed = f"at most the {self.gear.blank.teeth} teeth of the gear"
            raise InputError("pinion.blank.teeth", self.pinion.blank.teeth, allowed)
        for member in MEMBERS:
            for side in FLANK_SIDES:
                getattr(getattr(self, member), side).check_member(member, side)
        return self

    def with_misalignment(self, **misalignment: float) -> Design:
        """The pair misaligned by `E`, `P`, `G` [m] and `shaft_angle_error` [rad]; default: zero."""
        return self._assembled(misalignment=validate(Misalignment, misalignment, "assembly.misalignment"))

    def with_deviation(self, deviation: FlankDeviation) -> Design:
        """The pair with a deviation of its flanks instead of its own."""
        return self._assembled(flank_deviation=deviation)

    def _assembled(self, **changes: InputModel) -> Design:
        return self.model_copy(update={"assembly": self.assembly.model_copy(update=changes)})

    def under_torque(self, torque: float, side: Side = "drive") -> Design:
        """The pair with the deflections at a pinion torque [N m] on flanks of a side added to its misalignment."""
        given, start = self.assembly.deflection, self.assembly.misalignment
        if not given.moves:
            return self
        moved = given.at(torque if side == "drive" else -torque)
        return self.with_misalignment(**{name: getattr(start, name) + more for name, more in moved.items()})

    def without_deflection(self) -> Design:
        """The pair with rigid shafts and bearings."""
        return self._assembled(deflection=Deflection(), stiffness=StiffnessInput())

    def with_axes(self, axes: DisplacedAxes) -> Design:
        """The pair with the misalignments of the displaced axes of `placement`."""
        try:
            return self.with_misalignment(
                E=self.mirror * axes.E, P=axes.P, G=axes.G, shaft_angle_error=axes.shaft_angle_error
            )
        except InputError as error:
            name = error.field.rpartition(".")[2]
            allowed, hint = f"{name} of {error.allowed} under load", "Check units, frame and reference of the matrices."
            raise InputError("assembly.stiffness", f"{name} = {error.value}", allowed, hint) from None

    @property
    def mirror(self) -> float:
        """Sign of offset and E in the mesh frame, which is that of a left-hand pinion; a right-hand one is mirrored."""
        return 1.0 if self.pinion.blank.hand == "left" else -1.0

    def placement(self) -> Assembly:
        """Position of the members with their misalignments."""
        a, moved = self.assembly, self.assembly.misalignment.model_dump()
        return Assembly(
            teeth_pinion=self.pinion.blank.teeth,
            teeth_gear=self.gear.blank.teeth,
            shaft_angle=a.shaft_angle,
            offset=self.mirror * a.hypoid_offset,
            **moved | {"E": self.mirror * moved["E"]},
        )

    def flank(self, member: Member, side: FlankSide) -> Flank:
        """One flank of one member; a pinion flank given by its ease-off is conjugate in the aligned pair."""
        given = getattr(self.pinion, side)
        if member == "gear" or not isinstance(given, ConjugateFlankInput):
            return (self.gear if member == "gear" else self.pinion).flank(side)
        mate = self.gear.flank("convex" if side == "concave" else "concave")
        return given.conjugate(mate, self.pinion.blank, self.with_misalignment().placement())

    def flanks(self) -> GearFlanks:
        """The four flanks in the assembly with its misalignments."""
        pinion, gear = ({side: self.flank(member, side) for side in FLANK_SIDES} for member in MEMBERS)
        given = self.assembly
        relief = PairRelief(self.pinion.edge_relief, self.gear.edge_relief)
        loaded, backlash = given.drive_flank_pinion, given.normal_backlash
        return GearFlanks(
            self.name, pinion, gear, self.placement(), loaded, backlash, relief, deviation=given.flank_deviation
        )

    @property
    def ratio(self) -> float:
        """Speed of the gear over that of the pinion [-]."""
        return self.pinion.blank.teeth / self.gear.blank.teeth

    @property
    def common_face_width(self) -> float:
        """Common face width of both members [m]."""
        return min(self.pinion.blank.face_width, self.gear.blank.face_width)

    def tooth_bodies(self) -> Bodies:
        """Material and body under the teeth of pinion and gear."""
        return self.pinion.tooth_body(), self.gear.tooth_body()


def bevel_names() -> list[str]:
    """Names of the shipped designs of bevel and hypoid pairs."""
    return [
        name for name in data_names("designs") if read_toml(data_path("designs", f"{name}.toml")).get("kind") is None
    ]


def load_design(name: str | Path) -> Design:
    """Read and validate a design file or a shipped design.

    name: name of a shipped design, or path of a TOML file.
    Returns: the design; paths of point files are relative to the folder of the file.
    """
    path = named_file("design", "designs", name)
    content = read_toml(path, "design")
    if content.get("kind") == "cylindrical":
        raise InputError("design", str(name), "a bevel or hypoid pair", "The design is of a cylindrical pair.")
    return validate(Design, flank_input.from_folder(content, path.parent))


T = TypeVar("T")
Kind = Literal["bodies", "roots", "mesh"]

_PACKAGE = Path(__file__).resolve().parents[1]
# sources that affect the results
_SOURCES = ("blanks", "contact", "cutting", "design", "geometry", "ltca", "strength")
_FOLDER = "designs"


def kept_of_design(kind: Kind, design: Design, what: tuple[object, ...], make: Callable[[], T]) -> T:
    """A result of a design from disk; if it is not found, it is computed and stored.

    kind: bodies and roots depend on the members, the mesh also on their position.
    design: the pair, including the content of files of its flanks.
    what: further inputs of the result: side, positions...
    make: function that computes the result.
    """
    try:
        key = _key(kind, design, what)
    except OSError:  # sources in an archive
        return make()
    return kept(_FOLDER, key, make)


def _key(kind: Kind, design: Design, what: tuple[object, ...]) -> str:
    moved = None if kind == "mesh" else {"assembly": {"misalignment", "deflection", "stiffness", "flank_deviation"}}
    members = design.model_dump_json(include={"name", "pinion", "gear", "assembly"}, exclude=moved)
    materials = [(b.material, b.rim_thickness, sorted(b.held), b.youngs_modulus) for b in design.tooth_bodies()]
    digest = hashlib.sha256(repr((kind, what, members, materials)).encode())
    digest.update(_version())
    for member in MEMBERS:
        for side in FLANK_SIDES:
            flank = getattr(getattr(design, member), side)
            for name in ("grid", "map"):
                if path := getattr(flank, name, None):
                    digest.update(hashlib.sha256(Path(path).read_bytes()).digest())
    return digest.hexdigest()


@cache
def _version() -> bytes:
    """Hash of the sources, of the NumPy version and of its instruction sets, which affect the last digits."""
    used = np.show_config(mode="dicts")["SIMD Extensions"]["found"]
    digest = hashlib.sha256(repr((__version__, np.__version__, used)).encode())
    files = [file for name in _SOURCES for file in sorted((_PACKAGE / name).glob("*.py"))]
    for file in (*files, _PACKAGE / "mesh.py"):
        digest.update(hashlib.sha256(file.read_bytes()).digest())
    return digest.digest()
