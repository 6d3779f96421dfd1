"""The pinion conjugate to the cut gear, and the settings that cut it exactly: the gear's tool mirrored.

The pinion is cut by the same tool surface on the same cradle (see `generating`), seen from the other side: the cutter
is turned over about its x axis and its tip plane moved away by both dedenda. The blade that touches the gear's concave
flank from the slot becomes the inside blade of the pinion's convex flank.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.ease_off import ConjugatePoints, conjugate_points
from efficiency.cutting.cutter import FlankSide
from efficiency.cutting.flank import CutFlank
from efficiency.cutting.rotation import turn
from efficiency.machine_settings.gear import GearCut, PairDimensions
from efficiency.machine_settings.generating import ToolPose, machine_pose
from ehl.common.errors import ConvergenceError

FloatArray = NDArray[np.float64]

_SHAPE = (15, 9)
_FACE, _DEPTH = 0.9, (0.03, 0.97)
# where the gear itself is undercut the grid starts higher
_LOWEST = (0.03, 0.06, 0.1, 0.15, 0.2, 0.3)


def opposite(side: FlankSide) -> FlankSide:
    """The flank that mates."""
    return "convex" if side == "concave" else "concave"


@dataclass(frozen=True)
class FitGrid:
    """Gear points a pinion flank is fitted at.

    Attributes
    ----------
    u, h : (n,) arrays
        Blank coordinates on the gear [m].
    x, y : (n,) arrays
        Place on the face, -1 at the toe and 1 at the heel, and on the working depth, -1 at the gear's root and 1 at its
        tip.
    shape : (int, int)
        Points along the face and over the depth; the depth runs slowest.
    lowest : float
        Fraction of the working depth where the grid begins.
    """

    u: FloatArray
    h: FloatArray
    x: FloatArray
    y: FloatArray
    shape: tuple[int, int]
    lowest: float


def fit_grid(pair: PairDimensions, lowest: float = _DEPTH[0], shape: tuple[int, int] = _SHAPE) -> FitGrid:
    """Grid over nine tenths of the face and nearly the whole working depth."""
    blank = pair.gear
    x, v = (
        g.ravel() for g in np.meshgrid(np.linspace(-_FACE, _FACE, shape[0]), np.linspace(lowest, _DEPTH[1], shape[1]))
    )
    u = 0.5 * x * blank.face_width
    low = blank.root(u) + pair.clearance
    return FitGrid(u, low + v * (blank.tip(u) - low), x, 2.0 * v - 1.0, shape, lowest)


def grid_on_gear(pair: PairDimensions, gear: GearCut) -> FitGrid:
    """The grid, begun above the undercut of the gear where it has one.

    Raises
    ------
    ConvergenceError
        A gear flank does not exist over much of its working depth.
    """
    for lowest in _LOWEST:
        grid = fit_grid(pair, lowest)
        if all(gear.flank(side).solve(grid.u, grid.h)[1].all() for side in ("concave", "convex")):
            return grid
    raise ConvergenceError("undercut", "a gear flank does not span its working depth")


@dataclass(frozen=True)
class ConjugateFlankStart:
    """One pinion flank at the exactly conjugate settings.

    Attributes
    ----------
    flank : CutFlank
        The flank.
    phase : float
        Its rotation about the pinion axis in the frame of the unturned pinion [rad].
    points : ConjugatePoints
        Conjugate points of the grid.
    parameters : (3, n) array
        Cutting parameters that cut them.
    error : float
        Largest distance between both [m].
    """

    flank: CutFlank
    phase: float
    points: ConjugatePoints
    parameters: FloatArray
    error: float


def pinion_tool(pair: PairDimensions, gear: GearCut) -> ToolPose:
    """The gear cutter turned over, its tips at the pinion's root at the mean point."""
    outwards = -gear.tool.axes[:, 2]
    return ToolPose(gear.tool.centre + _reach(pair) * outwards, gear.tool.axes @ np.diag([1.0, -1.0, -1.0]))


def _reach(pair: PairDimensions) -> float:
    """Distance of both tip planes: gear dedendum and pinion dedendum at the mean point [m]."""
    gear, pinion = pair.dedendum_gear, pair.dedendum_pinion
    return float(gear * np.cos(pair.gear.dedendum_angle) + pinion * np.cos(pair.pinion.dedendum_angle))


def conjugate_start(pair: PairDimensions, gear: GearCut, side: FlankSide, grid: FitGrid) -> ConjugateFlankStart:
    """Exactly conjugate settings of one pinion flank.

    Raises
    ------
    ConvergenceError
        The gear flank does not exist or never touches a conjugate pinion at some points.
    """
    cut = gear.flank(opposite(side))
    points, found = cut.solve(grid.u, grid.h)
    if not found.all():
        raise ConvergenceError("undercut", f"the {cut.side} gear flank does not span its working depth")
    conjugate = conjugate_points(points, pair.assembly)

    assembly, screw = pair.assembly, gear.screw
    pose = machine_pose(
        screw.point,
        screw.direction,
        assembly.pinion_origin[:, 0],
        assembly.pinion_axis[:, 0],
        pinion_tool(pair, gear),
    )
    machine = pose.machine(1.0 / screw.rate, -screw.pitch)
    reach, sign = _reach(pair), cut.blade.sign
    angle = cut.blade.blade_angle
    zero = pose.cutter_turn - gear.tool_angle
    if pair.blade_groups:
        radius, height = cut.blade.point_radius, reach - cut.blade.reference_height
    else:
        # the radius of a face-mill blade is measured at the pitch plane, where it depends least on the blade angle
        height = pair.dedendum_pinion * float(np.cos(pair.pinion.dedendum_angle))
        radius = cut.blade.point_radius + sign * (reach - height) * np.tan(angle)
    blade = replace(
        cut.blade,
        side=side,
        point_radius=radius,
        reference_height=height,
        offset_angle=-cut.blade.offset_angle,
        phase=0.0,
    )
    flank = CutFlank(blade, machine, pair.pinion, zero)

    # the gear flank is turned by its blade phase; the pinion that touches it is turned back by the ratio
    ahead = -cut.index_ratio * cut.blade.phase
    reference = (gear.rotation - ahead) / assembly.ratio
    facing = assembly.pinion_frame.T @ pose.work_direction
    phase = float(np.arctan2(facing[1], facing[0])) - np.pi - reference
    th = zero - (points.parameters[1] - gear.cutter_turn - gear.tool_angle)
    rolled = conjugate.gear_roll / assembly.ratio - reference
    phi = (rolled + flank.index_ratio * (th - zero)) * screw.rate
    parameters = np.stack([reach / np.cos(angle) - points.parameters[0], th, phi])
    error = float(np.abs(flank.sweep(parameters)[0] - turn(conjugate.position, -phase)).max())
    return ConjugateFlankStart(flank, phase, conjugate, parameters, error)
