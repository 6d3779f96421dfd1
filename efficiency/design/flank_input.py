"""How a design file gives one flank: cutter and machine settings by their trade names, points, or an ease-off."""

from __future__ import annotations

from functools import reduce
from math import sin
from operator import or_
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import Discriminator, Field, Tag, model_validator

from efficiency.contact.assembly import Assembly
from efficiency.contact.conjugate import EaseOff, EaseOffTarget, conjugate_flank, read_ease_off_map
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

Relieved = Annotated[float, ValueRange("m", ge=-2e-3, le=2e-3)]
Place = Annotated[float, ValueRange("", ge=-1.0, le=1.0)]

if TYPE_CHECKING:
    CutterInput = BladeInput
    MachineTable = MachineInput
else:
    _CUTTERS = (process.cutter for process in PROCESSES.values())
    CutterInput = Annotated[reduce(or_, _CUTTERS), Field(discriminator="type")]
    MachineTable = Annotated[reduce(or_, MACHINE_INPUTS.values()), Field(discriminator="process")]


class CutFlankInput(InputModel):
    """A flank given by the cutter and the machine settings that cut it.

    Attributes
    ----------
    cutter : BladeInput
        Blade of the flank: the table of its cutting process.
    machine : MachineInput
        Settings of the cradle machine.
    """

    cutter: CutterInput
    machine: MachineTable

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
