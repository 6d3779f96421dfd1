"""How a design file gives one flank: cutter and machine settings by their trade names, points, or an ease-off."""

from __future__ import annotations

from functools import reduce
from math import sin
from operator import or_
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import Discriminator, Field, Tag, model_validator

from efficiency.contact.assembly import Assembly
from efficiency.contact.conjugate import EaseOffTarget, conjugate_flank
from efficiency.contact.gear_flanks import Member
from efficiency.contact.grid_flank import grid_flank, read_point_grid
from efficiency.contact.measured_flank import measured_flank
from efficiency.cutting.blank import Blank, Hand
from efficiency.cutting.cutter import FlankSide
from efficiency.cutting.flank import CutFlank, Flank, index_start
from efficiency.cutting.machine import MACHINE_INPUTS, MachineInput
from efficiency.cutting.process import PROCESSES, BladeInput
from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel

if TYPE_CHECKING:
    CutterInput = BladeInput
    MachineTable = MachineInput
else:
    _CUTTERS = (process.cutter for process in PROCESSES.values())
    CutterInput = Annotated[reduce(or_, _CUTTERS), Field(discriminator="type")]
    MachineTable = Annotated[reduce(or_, MACHINE_INPUTS.values()), Field(discriminator="process")]


class BlankInput(Blank):
    """Blank of one member and its hand of spiral, ``"left"`` or ``"right"``."""

    hand: Hand


class FlankTable(InputModel):
    """Table `concave` or `convex` of a member: what all ways to give a flank have in common."""

    @property
    def nominal(self) -> CutFlankInput | None:
        """Cutter and machine settings, where they are given."""
        return None

    @property
    def version(self) -> int:
        """Changes whenever a file that the flank is read from does."""
        return 0

    def check(self, side: FlankSide, blank: BlankInput) -> None:
        """Refuse a cradle angle of the other hand.

        The centre of the cutter lies beside the mean point, towards +y for a right-hand member: in face milling and
        face hobbing, generated or not. The mean point is near y = -blank offset, over the work axis.
        """
        if self.nominal is None:
            return
        machine, hand = self.nominal.machine, blank.hand
        centre = machine.radial_setting * sin(machine.cradle_angle) + machine.blank_offset
        if (centre > 0.0) != (hand == "right"):
            allowed = ("positive" if hand == "right" else "negative") + f" for a {hand}-hand member"
            raise InputError(f"{side}.machine.cradle_angle", machine.cradle_angle, allowed)

    def check_member(self, member: Member, side: FlankSide) -> None:
        """Refuse a way that the member cannot have, or a file of another flank."""

    def flank(self, side: FlankSide, blank: BlankInput) -> Flank:
        """The flank on a blank."""
        raise InputError(f"{side}.ease_off", "a flank of one member alone", "a flank of a pair")


class CutFlankInput(FlankTable):
    """A flank given by the cutter and the machine settings that cut it."""

    cutter: CutterInput  # blade of the flank: the table of its cutting process
    machine: MachineTable  # settings of the cradle machine

    @property
    def nominal(self) -> CutFlankInput:
        """The settings themselves."""
        return self

    def flank(self, side: FlankSide, blank: BlankInput) -> CutFlank:
        """The flank that the blade leaves."""
        machine = self.machine.settings()
        return CutFlank(self.cutter.blade(side, blank.hand), machine, blank, index_start(machine, blank))


class GridFlankInput(FlankTable):
    """A flank given by points, measured or of another program."""

    grid: str  # path of the CSV file, see `contact.grid_flank`
    # standard uncertainty of one point along the normal [m]: the points are then smoothed, see `contact.measured_flank`
    measurement_uncertainty: Annotated[float, ValueRange("m", ge=1e-8, le=1e-4)] | None = None
    # nominal settings: the points then give the deviation from the flank they cut
    cutter: CutterInput | None = None
    machine: MachineTable | None = None

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

    @property
    def version(self) -> int:
        """Time at which the file was changed [ns]."""
        return Path(self.grid).stat().st_mtime_ns

    def check_member(self, member: Member, side: FlankSide) -> None:
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

    def flank(self, side: FlankSide, blank: BlankInput) -> Flank:
        """The flank through the points."""
        grid = read_point_grid(Path(self.grid))
        if self.measurement_uncertainty is None:
            return grid_flank(grid, side, blank, blank.hand)
        nominal = None if self.nominal is None else self.nominal.flank(side, blank)
        return measured_flank(grid, side, blank, blank.hand, self.measurement_uncertainty, nominal)


class ConjugateFlankInput(FlankTable):
    """A pinion flank that no setting has to cut: conjugate to its gear flank, less an ease-off."""

    ease_off: EaseOffTarget  # material missing on the pinion

    def check_member(self, member: Member, side: FlankSide) -> None:
        """Ease-offs belong to the pinion."""
        if member == "gear":
            allowed = "cutter and machine, or a grid: ease-offs belong to the pinion"
            raise InputError(f"gear.{side}.ease_off", "given for the gear", allowed)

    def conjugate(self, gear: Flank, blank: Blank, assembly: Assembly) -> Flank:
        """The flank conjugate to a gear flank in an assembly."""
        return conjugate_flank(gear, blank, assembly, self.ease_off.relief())


def _way(content: Any) -> str:
    """The way to give a flank that its keys show."""
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


def from_folder(content: Any, folder: Path) -> Any:
    """Content of a file with the names of point files, keys `grid` and `map`, counted from the folder it lies in."""
    if not isinstance(content, dict):
        return content
    return {
        key: str(folder / value) if key in ("grid", "map") and isinstance(value, str) else from_folder(value, folder)
        for key, value in content.items()
    }
