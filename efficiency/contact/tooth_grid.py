"""One tooth of a member: both flanks on one grid of its blank, placed to each other as they stand on the member."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.gear_flanks import GearFlanks, Member
from efficiency.contact.tooth_root import RootProfile, root_profile
from ehl.io.errors import ConvergenceError

if TYPE_CHECKING:
    from efficiency.blanks.cones import Blank
    from efficiency.cutting.cutter import FlankSide
    from efficiency.cutting.flank import Flank, FlankPoints

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class ToothGrid:
    """Section of one tooth by cones square to the pitch cone (columns) and levels of the depth (rows).

    Attributes
    ----------
    blank : Blank
        Blank of the member.
    u, height : (rows, columns) arrays
        Blank coordinates [m]; rows from the root to the face cone, columns from toe to heel.
    lower, upper : (rows, columns) arrays
        Azimuth of the flank that faces smaller and of the one that faces larger azimuths [rad].
    sides : (str, str)
        Which of the lower and the upper flank is the concave, which the convex one.
    fillets : (bool, bool)
        Whether the lower, the upper flank goes over into the fillet the cutter leaves; else it is continued down to the
        root cone of the blank.
    """

    blank: Blank
    u: FloatArray
    height: FloatArray
    lower: FloatArray
    upper: FloatArray
    sides: tuple[FlankSide, FlankSide]
    fillets: tuple[bool, bool]

    @property
    def pitch(self) -> float:
        """Angular pitch of the member [rad]."""
        return 2.0 * np.pi / self.blank.teeth

    def point(self, azimuth: FloatArray, u: FloatArray, height: FloatArray) -> FloatArray:
        """Points (..., 3) in the work frame [m] of azimuths and blank coordinates."""
        radius, z = self.blank.axial(u, height)
        return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), z + 0.0 * azimuth], axis=-1)


def _flank_azimuth(flank: Flank, u: FloatArray, h: FloatArray, root: RootProfile | None) -> FloatArray:
    """Azimuth of a flank on a grid: of its fillet below its start, else continued straight where it has ended."""
    points, found = flank.solve(u.ravel(), h.ravel())
    azimuth = points.azimuth.reshape(u.shape)
    exists = found.reshape(u.shape)
    if root is not None:
        below = h < root.start
        fillet = root.at(h)
        # whole turns between both
        middle = u.shape[0] - 1, u.shape[1] // 2
        fillet += 2.0 * np.pi * np.round((azimuth[middle] - fillet[0, middle[1]]) / (2.0 * np.pi))
        azimuth, exists = np.where(below, fillet, azimuth), exists | below
    # the row from which on the flank is there up to the tip
    first = u.shape[0] - np.argmin(np.flip(exists, axis=0), axis=0)
    first = np.where(exists.all(axis=0), 0, first)
    if np.any(first > u.shape[0] - 3):
        raise ConvergenceError("undercut", f"the {flank.side} flank does not reach its tip over the whole face")
    for column in np.flatnonzero(first):
        low = first[column]
        slope = (azimuth[low + 1, column] - azimuth[low, column]) / (h[low + 1, column] - h[low, column])
        azimuth[:low, column] = azimuth[low, column] + slope * (h[:low, column] - h[low, column])
    return azimuth


def _heights(blank: Blank, u: FloatArray, rows: int, roots: list[RootProfile | None]) -> FloatArray:
    """Levels (rows, columns) from the root to the tip at stations u; a third of them between root and flanks."""
    known = [root for root in roots if root is not None]
    bottoms = [root.bottom for root in known] + ([] if len(known) == len(roots) else [blank.root(u)])
    bottom, tip = np.min(bottoms, axis=0), blank.tip(u)
    if not known:
        return np.asarray(np.linspace(bottom, tip, rows))
    start = np.clip(np.max([root.start for root in known], axis=0), bottom + 0.02 * (tip - bottom), None)
    low = max(2, rows // 3)
    return np.concatenate([np.linspace(bottom, start, low, endpoint=False), np.linspace(start, tip, rows - low)])


def _faces_up(points: FlankPoints) -> bool:
    """Whether the flank at its first point faces larger azimuths."""
    x, y, _ = points.position[:, 0]
    return bool(x * points.normal[1, 0] - y * points.normal[0, 0] > 0.0)


def _pinion_turns(flanks: GearFlanks) -> dict[FlankSide, float]:
    """Rotation of each pinion flank that brings it into contact with its gear flank; backlash taken off evenly."""
    turns: dict[FlankSide, float] = {}
    for side, pinion in flanks.pinion.items():
        mean, found = pinion.solve(np.zeros(1), np.zeros(1))
        if not found.all():
            raise ConvergenceError("undercut", f"the {side} pinion flank does not reach the mean point")
        spiral = mean.angles(pinion.blank.pitch_angle)[0][0]
        radius = np.hypot(mean.position[0, 0], mean.position[1, 0])
        off = 0.5 * flanks.normal_backlash / (radius * np.cos(spiral))
        turns[side] = flanks.pinion_phases[side] - (off if _faces_up(mean) else -off)
    return turns


def tooth_grid(pair: GearFlanks, member: Member, rows: int = 15, columns: int = 31) -> ToothGrid:
    """Both flanks of one tooth of a member.

    Between flanks and root lies the fillet the cutter leaves, down to the root it cuts (`root_profile`).
    The gear flanks bound one slot, as the cutter leaves it; the pinion flanks are turned until both touch the slot of
    the gear, and the backlash is taken off the pinion tooth.

    Parameters
    ----------
    pair : GearFlanks
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
    flanks = pair.of(member)
    blank = pair.blank(member)
    mate = pair.blank("gear" if member == "pinion" else "pinion")
    clearance = max(blank.mean_dedendum - mate.mean_addendum, 0.0)
    roots = {side: root_profile(flank, columns, clearance) for side, flank in flanks.items()}
    stations = np.linspace(-0.5, 0.5, columns) * blank.face_width
    h = _heights(blank, stations, rows, list(roots.values()))
    u = np.broadcast_to(stations, h.shape)
    azimuth: dict[FlankSide, FloatArray] = {}
    upper: FlankSide = "concave"
    for side, flank in flanks.items():
        azimuth[side] = _flank_azimuth(flank, u, h, roots[side])
        if _faces_up(flank.solve(np.zeros(1), np.zeros(1))[0]):
            upper = side
    lower: FlankSide = "convex" if upper == "concave" else "concave"
    pitch = 2.0 * np.pi / blank.teeth
    if member == "pinion":
        for side, turn in _pinion_turns(pair).items():
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
        (roots[lower] is not None, roots[upper] is not None),
    )
    for name, gap, least in (("tip", thickness[-1], "tooth"), ("root", pitch - thickness[0], "slot")):
        if np.any(gap <= 0.0):
            worst = int(np.argmin(gap))
            place = (u[0, worst] + 0.5 * blank.face_width) * 1e3
            raise ConvergenceError(
                "flanks_cross", f"the {least} of the {member} closes at its {name}, {place:.3g} mm from the toe"
            )
    return grid
