"""The blank file of a bevel or hypoid pair: inputs in the terms of ISO 23509.

Where the standard recommends a value it is the default; `PairBlank.defaults` lists the values used.
"""

from collections.abc import Iterator
from math import degrees, pi, radians
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator

from efficiency.blanks.rating import RatingInput
from efficiency.cutting.blank import Hand, Length
from efficiency.cutting.machine import GENERATIONS, Generation
from efficiency.cutting.process import PROCESSES
from ehl.common.data import named_file
from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel, Name, read_toml, validate

if TYPE_CHECKING:
    ProcessName = str
    GenerationName = str
else:
    ProcessName = Literal[tuple(PROCESSES)]
    GenerationName = Literal[tuple(GENERATIONS)]
_SIGN = "Sign as in ISO 23509: a positive offset increases the spiral angle of the pinion."
_GEAR = "Spiral angles up to 65 deg can be cut; usual are 25 to 50 deg."
_PINION = "Usual are 35 to 50 deg; up to 80 deg with 1 to 3 teeth."
Offset = Annotated[float, ValueRange("m", ge=-0.5, le=0.5, hint=_SIGN)]
SpiralAngle = Annotated[float, ValueRange("rad", ge=0.0, le=radians(65.0), hint=_GEAR)]
SpiralAnglePinion = Annotated[float, ValueRange("rad", ge=0.0, le=radians(80.0), hint=_PINION)]
PressureAngle = Annotated[float, ValueRange("rad", ge=radians(8.0), le=radians(35.0))]
TaperAngle = Annotated[float, ValueRange("rad", ge=0.0, le=radians(15.0))]
Teeth = Annotated[int, Field(ge=1, le=300)]


class PressureAngles(InputModel):
    """Design pressure angles of both sides, and the influence of the limit pressure angle on the generated ones."""

    drive: PressureAngle = radians(20.0)
    coast: PressureAngle = radians(20.0)
    limit_influence: Annotated[float, ValueRange("", ge=0.0, le=1.0)] = 1.0


class DepthTypeOne(InputModel):
    """Data type I: factors of the basic crown gear, in mean normal modules."""

    data_type: Literal["I"]
    profile_shift: Annotated[float, ValueRange("", ge=-1.0, le=1.0)] = 0.0
    addendum_factor: Annotated[float, ValueRange("", ge=0.5, le=1.5)] = 1.0
    dedendum_factor: Annotated[float, ValueRange("", ge=0.5, le=2.0)] = 1.25
    thickness_modification: Annotated[float, ValueRange("", ge=-0.3, le=0.3)] = 0.0


class DepthTypeTwo(InputModel):
    """Data type II: addendum, depth, clearance and thickness factors; defaults as recommended by the standard."""

    data_type: Literal["II"] = "II"
    gear_addendum_factor: Annotated[float, ValueRange("", gt=0.0, lt=1.0)] | None = None
    depth_factor: Annotated[float, ValueRange("", ge=1.0, le=3.0)] | None = None
    clearance_factor: Annotated[
        float, ValueRange("", ge=0.0, le=0.5, hint="With a negative clearance tip and root interfere.")
    ] = 0.125
    # clearance between pinion root and gear tips; default: that of the gear root
    clearance_factor_pinion: Annotated[float, ValueRange("", ge=0.0, le=0.5)] | None = None
    thickness_factor: Annotated[float, ValueRange("", ge=-0.6, le=0.6)] | None = None


class DepthTaper(InputModel):
    """Change of the tooth depth along the face: by a rule, or by the two angles of the gear."""

    type: Literal["uniform", "standard", "duplex", "tilted_root", "given"] = "tilted_root"
    addendum_angle_gear: TaperAngle | None = None
    dedendum_angle_gear: TaperAngle | None = None

    @model_validator(mode="after")
    def _angles_belong_to_given(self) -> Self:
        for name in ("addendum_angle_gear", "dedendum_angle_gear"):
            value = getattr(self, name)
            if (value is not None) != (self.type == "given"):
                allowed = "an angle, as type is 'given'" if self.type == "given" else "no value unless type is 'given'"
                raise InputError(name, value, allowed)
        return self


class Backlash(InputModel):
    """Backlash at the heel or at the mean point, normal to the flank or along the pitch circle."""

    type: Literal["none", "outer_normal", "outer_transverse", "mean_normal", "mean_transverse"] = "none"
    value: Annotated[float, ValueRange("m", ge=0.0, le=5e-3)] = 0.0

    @model_validator(mode="after")
    def _value_belongs_to_type(self) -> Self:
        if self.type == "none" and self.value > 0.0:
            raise InputError("type", self.type, "where the backlash is measured, as a value is given")
        return self


class PairBlankInput(InputModel):
    """Blank of a pair: the content of a blank file.

    `pitch_cones` selects the end of the iteration of Methods 1 to 3: "converged", to rounding error, with cones
    in exact contact; "tangent", to the tolerance of the standard, then in exact contact; "standard", as there.

    `gear_cutting`: the gear tooth is generated (default) or Formate, with straight profile;
    `inside_blade_angle_gear` is the blade angle that cuts the convex flank of a Formate gear, by default its pressure
    angle: the cutter axis is then normal to the root cone.
    """

    name: Name
    source: str = ""
    method: Literal[0, 1, 2, 3]
    process: ProcessName
    pitch_cones: Literal["converged", "tangent", "standard"] = "converged"
    teeth_pinion: Teeth
    teeth_gear: Teeth
    hand_pinion: Hand = "left"
    hand_gear: Hand | None = None
    shaft_angle: Annotated[float, ValueRange("rad", ge=radians(30.0), le=radians(150.0))] = pi / 2.0
    hypoid_offset: Offset = 0.0
    outer_pitch_diameter_gear: Length | None = None
    mean_pitch_diameter_gear: Length | None = None
    face_width_gear: Length
    mean_spiral_angle_gear: SpiralAngle | None = None
    mean_spiral_angle_pinion: SpiralAnglePinion | None = None
    cutter_radius: Length
    blade_groups: Annotated[int, Field(ge=1, le=50)] | None = None
    gear_cutting: GenerationName | None = None
    inside_blade_angle_gear: PressureAngle | None = None
    pressure_angle: PressureAngles = PressureAngles()
    depth: Annotated[DepthTypeOne | DepthTypeTwo, Field(discriminator="data_type")] = DepthTypeTwo()
    taper: DepthTaper | None = None
    backlash: Backlash = Backlash()
    # from the crossing point to the locating face behind the teeth, along the axis [m]
    mounting_distance_pinion: Length | None = None
    mounting_distance_gear: Length | None = None
    rating: RatingInput | None = None

    @property
    def defaults(self) -> tuple[str, ...]:
        """Inputs that the file omits, with their default values; lengths in mm, angles in deg."""
        return tuple(_left_out(self, ""))

    @model_validator(mode="after")
    def _one_of_each(self) -> Self:
        given = [name for name in ("outer_pitch_diameter_gear", "mean_pitch_diameter_gear") if getattr(self, name)]
        if len(given) != 1:
            missing = None if not given else "both diameters"
            raise InputError("outer_pitch_diameter_gear", missing, "exactly one of this and mean_pitch_diameter_gear")
        member, other = ("pinion", "gear") if self.method == 1 else ("gear", "pinion")
        if getattr(self, f"mean_spiral_angle_{member}") is None:
            raise InputError(f"mean_spiral_angle_{member}", None, f"an angle: Method {self.method} starts from it")
        surplus = getattr(self, f"mean_spiral_angle_{other}")
        if surplus is not None:
            where = f"mean_spiral_angle_{other}"
            raise InputError(where, surplus, f"no value: Method {self.method} takes mean_spiral_angle_{member}")
        return self

    @property
    def gear_generation(self) -> Generation:
        """Generation of the gear profile."""
        return GENERATIONS[self.gear_cutting or "generated"]

    @property
    def indexing(self) -> float:
        """Rotation of the gear about its axis per rotation of the cutter; 0 for a face mill."""
        return (self.blade_groups or 0) / self.teeth_gear

    @model_validator(mode="after")
    def _cutting(self) -> Self:
        PROCESSES[self.process].check_blade_groups(self.blade_groups)
        if self.inside_blade_angle_gear is not None and self.gear_generation.rolls:
            stated = f"{degrees(self.inside_blade_angle_gear):.6g} deg"
            hint = 'Use gear_cutting = "formate", or omit the blade angle.'
            raise InputError("inside_blade_angle_gear", stated, "no value: the gear is generated", hint)
        return self

    @model_validator(mode="after")
    def _pair(self) -> Self:
        if self.hand_gear == self.hand_pinion:
            allowed = "the opposite of the pinion's hand"
            raise InputError("hand_gear", self.hand_gear, allowed, "Two equal hands do not mesh.")
        if self.teeth_gear < self.teeth_pinion:
            raise InputError("teeth_gear", self.teeth_gear, f"at least the {self.teeth_pinion} teeth of the pinion")
        if self.method == 0 and self.hypoid_offset:
            allowed = "0 in Method 0 (bevel pairs)"
            raise InputError("hypoid_offset", self.hypoid_offset, allowed, "Hypoid pairs require Method 1, 2 or 3.")
        return self


_UNSAID = ("source", "data_type", "value")
_SHOWN = {"rad": ("deg", degrees(1.0)), "m": ("mm", 1e3), "Pa": ("MPa", 1e-6), "m^2/s": ("mm2/s", 1e6)}


def _left_out(model: InputModel, where: str) -> Iterator[str]:
    for name, info in type(model).model_fields.items():
        value = getattr(model, name)
        if isinstance(value, InputModel):
            yield from _left_out(value, f"{where}{name}.")
        elif name not in model.model_fields_set and value not in (None, ()) and name not in _UNSAID:
            unit = next((item.unit for item in info.metadata if isinstance(item, ValueRange)), "")
            shown, factor = _SHOWN.get(unit, (unit, 1.0))
            yield f"{where}{name} = {value if not unit else f'{factor * value:.6g} {shown}'}"


def check_pressure_angles(inputs: PairBlankInput, generated: tuple[float, float], limit: float) -> None:
    """Refuse generated pressure angles outside the range of blades."""
    for name, alpha in zip(("drive", "coast"), generated, strict=True):
        if not 5.0 <= degrees(alpha) <= 40.0:
            stated = f"{degrees(getattr(inputs.pressure_angle, name)):.4g} deg"
            hint = f"The limit pressure angle is {degrees(limit):.4g} deg: change limit_influence, offset or cutter."
            allowed = f"a generated angle of 5 to 40 deg, here {degrees(alpha):.4g} deg"
            raise InputError(f"pressure_angle.{name}", stated, allowed, hint)


def load_blank(name: str | Path) -> PairBlankInput:
    """Read and check a blank file, or a shipped blank by its name."""
    path = named_file("blank", "blanks", name)
    return validate(PairBlankInput, read_toml(path, "blank"))
