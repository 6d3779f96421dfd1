"""One tooth of a member: both flanks on one grid of its blank, placed to each other as they stand on the member."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.ease_off import conjugate_points, pinion_phase
from ehl.errors import ConvergenceError

if TYPE_CHECKING:
    from efficiency.blank.cones import Blank
    from efficiency.cutting.flank import Flank, FlankPoints
    from efficiency.design import Design

FloatArray = NDArray[np.float64]
Member = Literal["pinion", "gear"]


@dataclass(frozen=True)
class ToothGrid:
    """Section of one tooth by cones square to the pitch cone (columns) and levels of the depth (rows).

    Attributes
    ----------
    blank : Blank
        Blank of the member.
    u, height : (rows, columns) arrays
        Blank coordinates [m]; rows from root cone to face cone, columns from toe to heel.
    lower, upper : (rows, columns) arrays
        Azimuth of the flank that faces smaller and of the one that faces larger azimuths [rad].
    sides : (str, str)
        Which of the lower and the upper flank is the concave, which the convex one.
    extended : (bool, bool)
        Whether the lower, the upper flank ends above the root cone and was continued straight down to it.
    """

    blank: Blank
    u: FloatArray
    height: FloatArray
    lower: FloatArray
    upper: FloatArray
    sides: tuple[str, str]
    extended: tuple[bool, bool]

    @property
    def pitch(self) -> float:
        """Angular pitch of the member [rad]."""
        return 2.0 * np.pi / self.blank.teeth

    def point(self, azimuth: FloatArray, u: FloatArray, height: FloatArray) -> FloatArray:
        """Points (..., 3) in the work frame [m] of azimuths and blank coordinates."""
        radius, z = self.blank.axial(u, height)
        return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), z + 0.0 * azimuth], axis=-1)


def _flank_azimuth(flank: Flank, u: FloatArray, h: FloatArray) -> tuple[FloatArray, bool]:
    """Azimuth of a flank on a grid; below the end of an undercut flank continued straight to the root."""
    points, found = flank.solve(u.ravel(), h.ravel())
    azimuth = points.azimuth.reshape(u.shape)
    exists = found.reshape(u.shape)
    # the row from which on the flank is there up to the tip
    first = u.shape[0] - np.argmin(np.flip(exists, axis=0), axis=0)
    first = np.where(exists.all(axis=0), 0, first)
    if np.any(first > u.shape[0] - 3):
        raise ConvergenceError("undercut", f"the {flank.side} flank does not reach its tip over the whole face")
    for column in np.flatnonzero(first):
        low = first[column]
        slope = azimuth[low + 1, column] - azimuth[low, column]
        azimuth[:low, column] = azimuth[low, column] - slope * np.arange(low, 0, -1)
    return azimuth, bool(first.any())


def _faces_up(points: FlankPoints) -> bool:
    """Whether the flank at its first point faces larger azimuths."""
    x, y, _ = points.position[:, 0]
    return bool(x * points.normal[1, 0] - y * points.normal[0, 0] > 0.0)


def _pinion_turns(design: Design) -> dict[str, float]:
    """Rotation of each pinion flank that brings it into contact with its gear flank; backlash taken off evenly."""
    assembly = design.with_misalignment().placement()
    turns: dict[str, float] = {}
    for side in ("drive", "coast"):
        pinion, gear = design.flanks(side)
        middle = np.array([0.5 * (gear.blank.mean_addendum - pinion.blank.mean_addendum)])
        on_gear, found = gear.solve(np.zeros(1), middle)
        mean, there = pinion.solve(np.zeros(1), np.zeros(1))
        if not (found.all() and there.all()):
            raise ConvergenceError("flank", "the flanks do not reach their mean points")
        spiral = mean.angles(pinion.blank.pitch_angle)[0][0]
        radius = np.hypot(mean.position[0, 0], mean.position[1, 0])
        off = 0.5 * design.assembly.normal_backlash / (radius * np.cos(spiral))
        turns[pinion.side] = pinion_phase(conjugate_points(on_gear, assembly), pinion) - (
            off if _faces_up(mean) else -off
        )
    return turns


def tooth_grid(design: Design, member: Member, rows: int = 15, columns: int = 31) -> ToothGrid:
    """Both flanks of one tooth of a member.

    The gear flanks bound one slot, as the cutter leaves it; the pinion flanks are turned until both touch the slot of
    the gear, and the backlash is taken off the pinion tooth.

    Parameters
    ----------
    design : Design
        The pair; its misalignments do not matter here.
    member : {"pinion", "gear"}
        Which member.
    rows, columns : int
        Levels of the depth from root to tip, sections from toe to heel.

    Raises
    ------
    ConvergenceError
        A flank does not span its blank, or the flanks cross (pointed tooth, closed slot).
    """
    this = design.pinion if member == "pinion" else design.gear
    flanks = {side: this.flank(side) for side in ("concave", "convex")}
    blank = this.blank.blank()
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, columns) * blank.face_width, np.linspace(0.0, 1.0, rows))
    h = blank.height(u, v)
    azimuth, extended, upper = {}, {}, ""
    for side, flank in flanks.items():
        azimuth[side], extended[side] = _flank_azimuth(flank, u, h)
        if _faces_up(flank.solve(np.zeros(1), np.zeros(1))[0]):
            upper = side
    lower = "convex" if upper == "concave" else "concave"
    pitch = 2.0 * np.pi / blank.teeth
    if member == "pinion":
        for side, turn in _pinion_turns(design).items():
            azimuth[side] += turn
        shift = 0.0
    else:
        # flanks as cut bound a slot: the tooth lies one pitch back from the far one
        shift = -pitch
    thickness = azimuth[upper] - azimuth[lower] - shift
    # azimuths are known up to whole turns
    shift -= 2.0 * np.pi * np.round(float(thickness.mean()) / (2.0 * np.pi))
    thickness = azimuth[upper] - azimuth[lower] - shift
    middle = azimuth[lower] + shift + 0.5 * thickness
    centre = float(middle[rows // 2, columns // 2])
    grid = ToothGrid(
        blank,
        u,
        h,
        azimuth[lower] + shift - centre,
        azimuth[upper] - centre,
        (lower, upper),
        (extended[lower], extended[upper]),
    )
    for name, gap, least in (("tip", thickness[-1], "tooth"), ("root", pitch - thickness[0], "slot")):
        if np.any(gap <= 0.0):
            worst = int(np.argmin(gap))
            place = (u[0, worst] + 0.5 * blank.face_width) * 1e3
            raise ConvergenceError(
                "flanks_cross", f"the {least} of the {member} closes at its {name}, {place:.3g} mm from the toe"
            )
    return grid
