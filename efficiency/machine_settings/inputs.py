"""Content of a targets file: blank, cutting method, target ease-off, operating point."""

from math import degrees, radians
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import field_validator, model_validator

from efficiency.blanks.inputs import GenerationName, PairBlankInput, load_blank
from efficiency.contact.conjugate import read_ease_off_map
from efficiency.contact.relief import MemberRelief
from efficiency.cutting.cutter import FlankSide
from efficiency.cutting.process import ECCENTRIC, PROCESSES, check_eccentricity
from efficiency.design.flank_input import from_folder
from efficiency.loss.kinematics import OperatingPoint
from ehl.common.data import named_file
from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel, read_toml, validate
from ehl.inputs import Rms
from ehl.material import Material
from ehl.surface.finish import Finish

Relief = Annotated[float, ValueRange("m", ge=0.0, le=1e-3)]
Slope = Annotated[float, ValueRange("", ge=-2.0, le=2.0)]
Twist = Annotated[float, ValueRange("m", ge=-1e-3, le=1e-3)]
Place = Annotated[float, ValueRange("", ge=-0.6, le=0.6)]


class Cutting(InputModel):
    """Cutting method of the members."""

    gear: GenerationName = "formate"  # ``"formate"`` (not generated) or ``"generated"``
    # ``"both_flanks"``: one machine setting for both flanks (completing); ``"each_flank"``: one setting per flank;
    # ``"conjugate"``: no settings, the flanks are conjugate to those of the gear plus the ease-off
    pinion: Literal["both_flanks", "each_flank", "conjugate"] = "both_flanks"
    # ``"free_form"``: any relative motion; ``"cradle"``: machine root angle near the root cone of the pinion and tilt
    # within `tilt_limit`
    machine: Literal["free_form", "cradle"] = "free_form"
    # largest tilt of a cradle machine [rad]
    tilt_limit: Annotated[float, ValueRange("rad", ge=0.0, le=radians(60.0))] = radians(30.0)
    # ``"straight"`` or ``"curved"`` pinion blades; default: straight for face milling with one setting per flank,
    # otherwise curved
    blades: Literal["straight", "curved"] | None = None
    radius_offsets: Literal["free", "none"] = "free"
    # eccentricity of both parts of a two-part head for the gear [m]; the pinion has the rest of the crowning
    gear_eccentricity: Annotated[float, ValueRange("m", ge=0.0, le=ECCENTRIC)] = 0.0


class FlankTarget(InputModel):
    """Target ease-off of one flank pair.

    Relief is zero at the contact position and increases with the square of the distance. The four amounts apply at the
    ends of the face and of the working depth for a central contact. Sides are those of the gear.
    """

    # relief at both ends of the face [m]
    crowning_toe: Relief = 40e-6
    crowning_heel: Relief = 40e-6
    # relief at root and tip of the working depth of the gear [m]
    relief_root: Relief = 12e-6
    relief_tip: Relief = 12e-6
    # inclination of the line of zero lengthwise relief: its displacement towards the heel from mid-depth to the gear
    # tip, in half face widths
    bias: Slope = 0.0
    twist: Twist = 0.0  # relief added at the corners heel-tip and toe-root, and subtracted at the other corners [m]
    # contact position, -1 at toe (root), 1 at heel (tip) of the gear
    contact_face: Place = 0.0
    contact_depth: Place = 0.0
    # target peak-to-peak unloaded transmission error over one pitch [rad], reached by a common factor on all reliefs
    transmission_error: Annotated[float, ValueRange("rad", gt=0.0, le=2e-3)] | None = None
    # path of a CSV file with an additional ease-off, measured or from another program; see `contact.conjugate`
    map: str | None = None

    @model_validator(mode="after")
    def _scaled(self) -> Self:
        if self.map is not None:
            read_ease_off_map(Path(self.map))
        if self.transmission_error is not None:
            reliefs = self.crowning_toe, self.crowning_heel, self.relief_root, self.relief_tip
            if self.map is not None:
                allowed = "no value with a map, whose ease-off is not scaled"
                raise InputError("transmission_error", self.transmission_error, allowed)
            if not max(reliefs):
                raise InputError("transmission_error", self.transmission_error, "no value if all reliefs are 0")
        return self


class Targets(InputModel):
    """Ease-off of both flank pairs and weight of the root of the pinion."""

    # the drive side is the concave pinion flank
    drive: FlankTarget = FlankTarget()
    coast: FlankTarget = FlankTarget()
    # residual per metre of root error; default: 0.02 for face hobbing with one setting for both flanks, otherwise 0.03
    root_weight: Annotated[float, ValueRange("", ge=0.0, le=1.0)] | None = None

    def of(self, side: FlankSide) -> FlankTarget:
        """Target of a pinion flank."""
        return self.drive if side == "concave" else self.coast


class MemberTargets(InputModel):
    """Inputs of a member in addition to its flanks: material, finish by name or roughness, relief."""

    material: str = "steel"
    finish: str | None = None
    roughness_rms: Rms = 0.4e-6
    edge_relief: MemberRelief = MemberRelief()

    @model_validator(mode="after")
    def _known(self) -> Self:
        Material.load(self.material)
        if self.finish is not None:
            Finish.load(self.finish, "run_in")
        return self


class SettingsInput(InputModel):
    """Content of a targets file.

    `blank` is a table, or the name or path of a blank file.
    """

    name: str
    source: str = ""
    blank: PairBlankInput
    cutting: Cutting = Cutting()
    targets: Targets = Targets()
    pinion: MemberTargets = MemberTargets()
    gear: MemberTargets = MemberTargets()
    operation: OperatingPoint

    @field_validator("blank", mode="before")
    @classmethod
    def _by_name(cls, value: Any) -> Any:
        return load_blank(value).model_dump() if isinstance(value, str) else value

    @model_validator(mode="after")
    def _one_way_of_cutting(self) -> Self:
        if self.blank.gear_cutting not in (None, self.cutting.gear):
            allowed = f"{self.blank.gear_cutting}, the gear_cutting of the blank"
            hint = "Change one of both, or omit gear_cutting in the blank."
            raise InputError("cutting.gear", self.cutting.gear, allowed, hint)
        if value := self.cutting.gear_eccentricity:
            if "eccentricity" not in PROCESSES[self.blank.process].cutter.model_fields:
                allowed = "no value: only a two-part head has eccentric axes"
                raise InputError("cutting.gear_eccentricity", f"{value * 1e3:.4g} mm", allowed)
            check_eccentricity(value, self.blank.cutter_radius, field="cutting.gear_eccentricity")
        if (angle := self.blank.inside_blade_angle_gear) is not None:
            allowed = "no value, because the settings keep the cutter axis normal to the root cone"
            hint = "The blade angles then follow from the pressure angles; omit it."
            raise InputError("blank.inside_blade_angle_gear", f"{degrees(angle):.6g} deg", allowed, hint)
        return self

    @model_validator(mode="after")
    def _ease_off_alone(self) -> Self:
        if self.cutting.pinion == "conjugate":
            for side in ("drive", "coast"):
                target: FlankTarget = getattr(self.targets, side)
                if target.map is not None:
                    hint = "Give it as ease_off.map of the flank in the design file."
                    raise InputError(f"targets.{side}.map", target.map, "no map for a conjugate pinion", hint)
                for one, other in (("crowning_toe", "crowning_heel"), ("relief_root", "relief_tip")):
                    if getattr(target, one) != getattr(target, other):
                        allowed = f"equal to {one} for a conjugate pinion"
                        raise InputError(f"targets.{side}.{other}", getattr(target, other), allowed)
        return self

    @property
    def curved_blades(self) -> bool:
        """Whether pinion blades may be curved."""
        if self.cutting.blades is not None:
            return self.cutting.blades == "curved"
        return PROCESSES[self.blank.process].curved_blades or self.cutting.pinion == "both_flanks"


def targets_next_to(design: Path) -> Path:
    """Path of the targets file that belongs to a design file."""
    return design.with_name(f"{design.stem}_targets{design.suffix}")


def load_targets(name: str | Path) -> SettingsInput:
    """Read and validate a targets file or shipped targets."""
    path = named_file("targets", "targets", name)
    return validate(SettingsInput, from_folder(read_toml(path, "targets"), path.parent))
