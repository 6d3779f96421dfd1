"""How a design file gives one flank: cutter and machine settings by their trade names, points, or an ease-off."""

from __future__ import annotations

from math import acos, sin, tan
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from efficiency.blanks.cones import Blank
from efficiency.contact.assembly import Assembly
from efficiency.contact.conjugate import EaseOff, EaseOffTarget, conjugate_flank, read_ease_off_map
from efficiency.contact.gear_flanks import Member
from efficiency.contact.grid_flank import grid_flank, read_point_grid
from efficiency.contact.measured_flank import measured_flank
from efficiency.cutting.cutter import Blade, FlankSide
from efficiency.cutting.edge import Protuberance, Relief
from efficiency.cutting.flank import CutFlank, Flank, index_start
from efficiency.cutting.machine import MachineSettings
from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel

Hand = Literal["left", "right"]

Length = Annotated[float, ValueRange("m", gt=0.0, le=3.0)]
Depth = Annotated[float, ValueRange("m", ge=0.0, le=0.2)]
Shift = Annotated[float, ValueRange("m", ge=-1.0, le=1.0)]
Turn = Annotated[float, ValueRange("rad", ge=-3.1416, le=3.1416)]
BladeAngle = Annotated[float, ValueRange("rad", gt=-0.35, lt=0.9)]
Curvature = Annotated[float, ValueRange("1/m", ge=-100.0, le=100.0)]
Small = Annotated[float, ValueRange("rad", ge=-0.6, le=0.6)]
Relieved = Annotated[float, ValueRange("m", ge=-2e-3, le=2e-3)]
Place = Annotated[float, ValueRange("", ge=-1.0, le=1.0)]
Groups = Annotated[int, Field(ge=1, le=60)]


class ReliefInput(InputModel):
    """Toprem or flankrem: an arc tangent to the profile.

    Attributes
    ----------
    height : float
        Where it begins, over the blade tip [m].
    radius : float
        Of the arc [m].
    angle : float, optional
        Turn of the profile after which it goes straight on [rad].
    """

    height: Length
    radius: Length
    angle: Annotated[float, ValueRange("rad", gt=0.0, le=0.5)] | None = None

    def relief(self) -> Relief:
        """Numbers of the relief."""
        return Relief(self.height, self.radius, self.angle)


class ProtuberanceInput(InputModel):
    """Blade thickened below a height over its tip.

    Attributes
    ----------
    height : float
        Over the blade tip below which the blade is thicker [m].
    amount : float
        By which it is thicker [m].
    radius : float
        Of both arcs that lead there [m].
    """

    height: Length
    amount: Annotated[float, ValueRange("m", gt=0.0, le=2e-3)]
    radius: Length

    @model_validator(mode="after")
    def _arcs_reach(self) -> Self:
        if self.amount >= 2.0 * self.radius:
            raise InputError("amount", f"{self.amount * 1e3:.6g} mm", "below twice the radius of its arcs")
        # both arcs lie between the start and the tip plane
        run = 2.0 * self.radius * acos(1.0 - 0.5 * self.amount / self.radius)
        if run >= self.height:
            raise InputError(
                "radius",
                f"{self.radius * 1e3:.6g} mm",
                f"so small that both arcs ({run * 1e3:.3g} mm) fit below the height of {self.height * 1e3:.3g} mm",
            )
        return self

    def relief(self) -> Protuberance:
        """Numbers of the protuberance."""
        return Protuberance(self.height, self.amount, self.radius)


class BladeInput(InputModel):
    """Edge of one blade: straight or an arc, with edge radius and reliefs tangent to it.

    Attributes
    ----------
    blade_angle : float
        Of the edge to the cutter axis at the reference height [rad].
    blade_curvature : float
        There [1/m]; 0 for a straight edge.
    reference_height : float
        Over the blade tip [m]; 0 is the tip plane.
    edge_radius : float
        At the blade tip [m].
    toprem, protuberance, flankrem : optional
        Reliefs of the profile.
    """

    blade_angle: BladeAngle
    blade_curvature: Curvature = 0.0
    reference_height: Depth = 0.0
    edge_radius: Depth = 0.0
    toprem: ReliefInput | None = None
    protuberance: ProtuberanceInput | None = None
    flankrem: ReliefInput | None = None

    @model_validator(mode="after")
    def _edge(self) -> Self:
        if self.toprem is not None and self.protuberance is not None:
            raise InputError("protuberance", "given together with a toprem", "either toprem or protuberance")
        low = self.toprem or self.protuberance
        if low is not None and self.flankrem is not None and self.flankrem.height <= low.height:
            raise InputError(
                "flankrem.height", f"{self.flankrem.height * 1e3:.6g} mm", f"above {low.height * 1e3:.6g} mm"
            )
        if low is not None and self.edge_radius >= low.height:
            raise InputError("edge_radius", f"{self.edge_radius * 1e3:.6g} mm", f"below {low.height * 1e3:.6g} mm")
        return self

    def _blade(self, side: FlankSide, radius: float, **head: Any) -> Blade:
        return Blade(
            point_radius=radius,
            blade_angle=self.blade_angle,
            side=side,
            curvature=self.blade_curvature,
            reference_height=self.reference_height,
            edge_radius=self.edge_radius,
            toprem=None if self.toprem is None else self.toprem.relief(),
            protuberance=None if self.protuberance is None else self.protuberance.relief(),
            flankrem=None if self.flankrem is None else self.flankrem.relief(),
            **head,
        )


class FaceMillingCutter(BladeInput):
    """One blade of a face mill; see also `BladeInput`.

    Attributes
    ----------
    point_radius : float, optional
        Radius of the (extended) profile at the tip plane [m].
    cutter_radius, point_width : float, optional
        In its place: mean radius and distance of the blades of a spread-blade cutter [m].
    """

    type: Literal["face_milling"] = "face_milling"
    point_radius: Length | None = None
    cutter_radius: Length | None = None
    point_width: Depth | None = None

    @model_validator(mode="after")
    def _radius(self) -> Self:
        spread = self.cutter_radius, self.point_width
        if self.point_radius is None and None in spread:
            raise InputError(
                "point_radius", None, "a length such as '114.3 mm', or cutter_radius and point_width instead"
            )
        if self.point_radius is not None and spread != (None, None):
            raise InputError("point_radius", "given together with cutter_radius or point_width", "only one of the two")
        if self.point_radius is None and 0.5 * float(self.point_width or 0.0) >= float(self.cutter_radius or 0.0):
            raise InputError("point_width", self.point_width, "below the cutter diameter")
        return self

    def blade(self, side: FlankSide, hand: Hand) -> Blade:
        """Numbers of the blade that cuts one flank; a face mill suits both hands."""
        sign = 1.0 if side == "concave" else -1.0
        radius = self.point_radius
        if radius is None:
            assert self.cutter_radius is not None
            assert self.point_width is not None
            radius = self.cutter_radius + sign * 0.5 * self.point_width
        return self._blade(side, radius + sign * self.reference_height * tan(self.blade_angle))


class FaceHobbingCutter(BladeInput):
    """One blade of each group of a face-hobbing head; see also `BladeInput`.

    Attributes
    ----------
    cutter_radius : float
        Radius of the profile at the reference height [m].
    blade_groups : int
        Of the head.
    blade_offset_angle : float
        Of the plane of the profile to the axial plane, at the cutter radius [rad].
    radius_offset : float
        Moves the profile outwards, square to the cutting direction [m].
    blade_phase : float
        Position of the blade around the cutter axis [rad].
    rake_angle, hook_angle : float
        Of the front face [rad].
    """

    type: Literal["face_hobbing"]
    cutter_radius: Length
    blade_groups: Groups
    blade_offset_angle: Annotated[float, ValueRange("rad", ge=0.0, lt=1.2)]
    radius_offset: Annotated[float, ValueRange("m", ge=-0.05, le=0.05)] = 0.0
    blade_phase: Turn = 0.0
    rake_angle: Small = 0.0
    hook_angle: Small = 0.0

    def blade(self, side: FlankSide, hand: Hand) -> Blade:
        """Numbers of the blade that cuts one flank; the head of a left-hand member is the mirror image."""
        mirror = 1.0 if hand == "right" else -1.0
        return self._blade(
            side,
            self.cutter_radius,
            radius_offset=self.radius_offset,
            groups=self.blade_groups,
            offset_angle=mirror * self.blade_offset_angle,
            phase=mirror * self.blade_phase,
            rake=mirror * self.rake_angle,
            hook=mirror * self.hook_angle,
        )


class MachineInput(InputModel):
    """Machine settings that generated and non-generated members share.

    Attributes
    ----------
    radial_setting : float
        Cutter centre from the cradle axis [m].
    cradle_angle : float
        Of the cutter centre around the cradle axis; positive for a right-hand member [rad].
    machine_root_angle : float
        Of the work axis to the machine plane [rad].
    tilt, swivel : float
        Of the cutter axis [rad].
    blank_offset, sliding_base, machine_centre_to_back : float
        Position of the work [m].
    """

    radial_setting: Length
    cradle_angle: Turn
    machine_root_angle: Turn
    tilt: Turn = 0.0
    swivel: Turn = 0.0
    blank_offset: Shift = 0.0
    sliding_base: Shift = 0.0
    machine_centre_to_back: Shift = 0.0


class GeneratedMachine(MachineInput):
    """Settings of a generated flank by their trade names; see also `MachineInput`.

    Attributes
    ----------
    roll_ratio : float
        Rotation of the work over that of the cradle [-].
    modified_roll_2c, modified_roll_6d, modified_roll_24e, modified_roll_120f, modified_roll_720g : float
        Coefficients of modified roll by their trade names [-].
    helical_motion_1, helical_motion_2, helical_motion_3 : float
        Derivatives of the sliding base by the cradle roll [m/rad^n].
    vertical_motion_1, vertical_motion_2, vertical_motion_3 : float
        Derivatives of the vertical position by the cradle roll [m/rad^n].
    """

    process: Literal["generated"] = "generated"
    roll_ratio: Annotated[float, ValueRange("", gt=0.0, le=100.0)]
    modified_roll_2c: Annotated[float, ValueRange("", ge=-1.0, le=1.0)] = 0.0
    modified_roll_6d: Annotated[float, ValueRange("", ge=-10.0, le=10.0)] = 0.0
    modified_roll_24e: Annotated[float, ValueRange("", ge=-100.0, le=100.0)] = 0.0
    modified_roll_120f: Annotated[float, ValueRange("", ge=-1000.0, le=1000.0)] = 0.0
    modified_roll_720g: Annotated[float, ValueRange("", ge=-10000.0, le=10000.0)] = 0.0
    helical_motion_1: Shift = 0.0
    helical_motion_2: Shift = 0.0
    helical_motion_3: Shift = 0.0
    vertical_motion_1: Shift = 0.0
    vertical_motion_2: Shift = 0.0
    vertical_motion_3: Shift = 0.0

    def settings(self) -> MachineSettings:
        """Numbers of the settings."""
        return MachineSettings(**self.model_dump(exclude={"process"}))


class FormateMachine(MachineInput):
    """Settings of a non-generated (Formate) flank: the cradle stands still, the cutter plunges or only indexes."""

    process: Literal["formate"]

    def settings(self) -> MachineSettings:
        """Numbers of the settings."""
        return MachineSettings(**self.model_dump(exclude={"process"}), roll_ratio=0.0, generated=False)


class CutFlankInput(InputModel):
    """A flank given by the cutter and the machine settings that cut it.

    Attributes
    ----------
    cutter : FaceMillingCutter or FaceHobbingCutter
        Blade of the flank.
    machine : GeneratedMachine or FormateMachine
        Settings of the cradle machine.
    """

    cutter: Annotated[FaceMillingCutter | FaceHobbingCutter, Field(discriminator="type")]
    machine: Annotated[GeneratedMachine | FormateMachine, Field(discriminator="process")]

    def require_hand(self, hand: Hand) -> None:
        """Refuse a cradle angle of the other hand.

        The centre of the cutter lies beside the mean point, towards +y for a right-hand member: in face milling and
        face hobbing, generated or not. The mean point is near y = -blank offset, over the work axis.
        """
        centre = self.machine.radial_setting * sin(self.machine.cradle_angle) + self.machine.blank_offset
        if (centre > 0.0) != (hand == "right"):
            raise InputError(
                "machine.cradle_angle",
                self.machine.cradle_angle,
                ("positive" if hand == "right" else "negative") + f" for a {hand}-hand member",
            )

    def flank(self, side: FlankSide, hand: Hand, blank: Blank) -> Flank:
        """The flank on a blank."""
        machine = self.machine.settings()
        return CutFlank(self.cutter.blade(side, hand), machine, blank, index_start(machine, blank))


class GridFlankInput(InputModel):
    """A flank given by points, measured or of another program.

    Attributes
    ----------
    grid : str
        Path of the CSV file, see `contact.grid_flank`.
    measurement_uncertainty : float, optional
        Standard uncertainty of one point along the normal [m]: the points are then smoothed, see
        `contact.measured_flank`.
    cutter, machine : optional
        What the flank should be (nominal settings): the points then tell the deviation from it.
    """

    grid: str
    measurement_uncertainty: Annotated[float, ValueRange("m", ge=1e-8, le=1e-4)] | None = None
    cutter: Annotated[FaceMillingCutter | FaceHobbingCutter, Field(discriminator="type")] | None = None
    machine: Annotated[GeneratedMachine | FormateMachine, Field(discriminator="process")] | None = None

    @model_validator(mode="after")
    def _readable(self) -> Self:
        read_point_grid(Path(self.grid))
        if (self.cutter is None) != (self.machine is None):
            missing = "cutter" if self.cutter is None else "machine"
            raise InputError(missing, None, "given together with the other of cutter and machine: the nominal flank")
        if self.cutter is not None and self.measurement_uncertainty is None:
            raise InputError(
                "measurement_uncertainty", None, "a length such as '1 um' where a nominal flank is given with the grid"
            )
        return self

    def require(self, member: Member, side: FlankSide) -> None:
        """Refuse a file that says it holds another flank."""
        read = read_point_grid(Path(self.grid))
        if read.member not in ("", member) or read.flank not in ("", side):
            raise InputError(
                f"{member}.{side}.grid",
                f"{self.grid} of the {read.flank} {read.member} flank",
                f"points of the {side} {member} flank",
                "Name the file of this flank, or correct member and flank in its first line.",
            )

    @property
    def nominal(self) -> CutFlankInput | None:
        """Settings of the nominal flank, where they are given."""
        if self.cutter is None or self.machine is None:
            return None
        return CutFlankInput(cutter=self.cutter, machine=self.machine)

    def flank(self, side: FlankSide, hand: Hand, blank: Blank) -> Flank:
        """The flank through the points."""
        grid = read_point_grid(Path(self.grid))
        if self.measurement_uncertainty is None:
            return grid_flank(grid, side, blank, hand)
        nominal = None if self.nominal is None else self.nominal.flank(side, hand, blank)
        return measured_flank(grid, side, blank, hand, self.measurement_uncertainty, nominal)


class EaseOffTerm(InputModel):
    """One further term of an ease-off: ``relief length^i depth^j``, both from -1 to 1.

    Attributes
    ----------
    length_power, depth_power : int
        Powers of length and depth.
    relief : float
        Coefficient [m].
    """

    length_power: Annotated[int, Field(ge=0, le=8)]
    depth_power: Annotated[int, Field(ge=0, le=8)]
    relief: Relieved


class EaseOffInput(InputModel):
    """Ease-off of a pinion flank from the conjugate one, over face and working depth; see `EaseOffTarget`.

    Attributes
    ----------
    lengthwise_crowning, profile_crowning, twist : float
        Reliefs [m].
    bias : float
        Lean of the lengthwise crowning [-].
    contact_face, contact_depth : float
        Point without relief, from -1 to 1.
    terms : tuple of EaseOffTerm
        Further terms.
    map : str, optional
        Path of a CSV file with a table of the ease-off, added to the rest.
    """

    lengthwise_crowning: Relieved = 0.0
    profile_crowning: Relieved = 0.0
    bias: Annotated[float, ValueRange("", ge=-5.0, le=5.0)] = 0.0
    twist: Relieved = 0.0
    contact_face: Place = 0.0
    contact_depth: Place = 0.0
    terms: tuple[EaseOffTerm, ...] = ()
    map: str | None = None

    @model_validator(mode="after")
    def _readable(self) -> Self:
        if self.map is not None:
            read_ease_off_map(Path(self.map))
        return self

    def target(self) -> EaseOffTarget:
        """Numbers of the ease-off, without its map."""
        centre = self.contact_face, self.contact_depth
        terms = tuple((term.length_power, term.depth_power, term.relief) for term in self.terms)
        return EaseOffTarget(self.lengthwise_crowning, self.profile_crowning, self.bias, self.twist, centre, terms)

    def relief(self) -> EaseOff:
        """The whole ease-off: what the map gives is added."""
        target = self.target()
        if self.map is None:
            return target
        given = read_ease_off_map(Path(self.map))
        return lambda length, depth: target(length, depth) + given(length, depth)


class ConjugateFlankInput(InputModel):
    """A pinion flank that no setting has to cut: conjugate to its gear flank, less an ease-off.

    Attributes
    ----------
    ease_off : EaseOffInput
        Material missing on the pinion.
    """

    ease_off: EaseOffInput

    def flank(self, gear: Flank, blank: Blank, assembly: Assembly) -> Flank:
        """The flank conjugate to a gear flank in an assembly."""
        return conjugate_flank(gear, blank, assembly, self.ease_off.relief())


def _way(content: Any) -> str:
    """Which way of giving a flank its keys show."""
    for key in ("grid", "ease_off"):
        if key in content if isinstance(content, dict) else hasattr(content, key):
            return key
    return "cut"


FlankInput = Annotated[
    Annotated[CutFlankInput, Tag("cut")]
    | Annotated[GridFlankInput, Tag("grid")]
    | Annotated[ConjugateFlankInput, Tag("ease_off")],
    Discriminator(_way),
]
