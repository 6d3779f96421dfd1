"""One tooth of a member: flanks, fillets and root on one grid of its blank, and its thickness.

The two flanks of the gear bound one slot, as the cutter leaves it. The pinion flanks are rotated into that slot until
both are in contact; the backlash is then removed from the pinion tooth. The fillet between flank and root is that of
the cutter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from efficiency.contact.gear_flanks import MEMBERS, GearFlanks, Member
from efficiency.cutting.blank import Blank
from efficiency.cutting.cutter import FLANK_SIDES, FlankSide
from efficiency.cutting.flank import CutFlank, Flank, FlankPoints
from efficiency.cutting.limits import flank_limits
from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError, InputError


@dataclass(frozen=True)
class ToothShape:
    """Depth and thickness of one tooth, at stations along the face from toe to heel."""

    face: FloatArray  # (m,) distance from the toe along the pitch cone [m]; ``face[-1]`` is the face width
    height: FloatArray  # (m,) whole depth, root cone to face cone, normal to the pitch cone [m]
    # (m,) normal tooth thickness at the root and at the tip [m], without fillets
    thickness_root: FloatArray
    thickness_tip: FloatArray


@dataclass(frozen=True)
class RootProfile:
    """Fillet of one flank at k stations along the face, toe to heel."""

    start: FloatArray  # (k,) height of the start of the flank [m]
    bottom: FloatArray  # (k,) height of the end of the fillet in the root [m]
    # (m, k) points of the fillet in order of decreasing height: height above the pitch cone [m], azimuth about the axis
    # of the member [rad]
    height: FloatArray
    azimuth: FloatArray

    def at(self, height: FloatArray) -> FloatArray:
        """Azimuth (rows, k) at heights (rows, k) below `start`; below `bottom` that of the bottom."""
        columns = zip(height.T, self.height.T, self.azimuth.T, strict=True)
        return np.stack([np.interp(column, h[::-1], angles[::-1]) for column, h, angles in columns], axis=1)


def root_profile(flank: Flank, stations: int, clearance: float) -> RootProfile | None:
    """Fillet and root of a flank at equally spaced stations; None if the settings give no valid ones.

    Only a flank given by cutter and machine has a fillet. If the cutter stays farther above the root cone of the blank
    than the clearance [m], the mating tip would interfere: such settings define the flank only.
    """
    if not isinstance(flank, CutFlank):
        return None
    try:
        limits = flank_limits(flank, stations)
    except ConvergenceError:
        return None
    curve = limits.fillet
    if not (curve.found.all() and np.isfinite(limits.start).all() and np.isfinite(limits.root).all()):
        return None
    if np.any(limits.root_error > clearance):
        return None
    # an edge that rises again behind its deepest point does not cut there
    height = np.minimum.accumulate(curve.height, axis=0)
    azimuth = np.unwrap(np.arctan2(curve.position[:, 1], curve.position[:, 0]), axis=0)
    return RootProfile(limits.start, height[-1], height, azimuth)


@dataclass(frozen=True)
class ToothGrid:
    """Section of one tooth by cones normal to the pitch cone (columns) and levels of the depth (rows)."""

    blank: Blank
    # (rows, columns) blank coordinates [m]; rows from the root to the face cone, columns from toe to heel
    u: FloatArray
    height: FloatArray
    # (rows, columns) azimuth of the flank facing smaller azimuths and of the flank facing larger azimuths [rad]
    lower: FloatArray
    upper: FloatArray
    sides: tuple[FlankSide, FlankSide]  # side (concave or convex) of the lower and of the upper flank
    # whether the lower and the upper flank end in the fillet of the cutter; otherwise they are extended to the root
    # cone of the blank
    fillets: tuple[bool, bool]
    # azimuth of the middle of the tooth in the work frame, 0 in this grid; both members mesh at zero rotation [rad]
    middle: float = 0.0

    @property
    def pitch(self) -> float:
        """Angular pitch of the member [rad]."""
        return 2.0 * np.pi / self.blank.teeth

    @property
    def winding(self) -> float:
        """Angle by which the tooth winds around the axis from toe to heel [rad]."""
        return float(np.abs(self.lower[:, -1] - self.lower[:, 0]).max())

    def point(self, azimuth: FloatArray, u: FloatArray, height: FloatArray) -> FloatArray:
        """Points (..., 3) in the work frame [m] of azimuths and blank coordinates."""
        radius, z = self.blank.axial(u, height)
        return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), z + 0.0 * azimuth], axis=-1)


def _flank_azimuth(flank: Flank, u: FloatArray, h: FloatArray, root: RootProfile | None) -> FloatArray:
    """Azimuth of a flank on a grid, of its fillet below its start, extrapolated linearly below its end.

    The teeth of a pinion with few teeth wind by more than a rotation: the azimuth is continued along the face at the
    tip, and from there to the root.
    """
    points, found = flank.solve(u.ravel(), h.ravel())
    azimuth, exists = points.azimuth.reshape(u.shape), found.reshape(u.shape)
    slope = points.winding(flank.blank.pitch_angle).reshape(u.shape)[-1]
    wound = np.append(0.0, np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(u[-1])))
    if root is not None:
        below = h < root.start
        azimuth, exists = np.where(below, root.at(h), azimuth), exists | below
    straight = azimuth[-1] - wound
    azimuth[-1] += 2.0 * np.pi * np.round((np.unwrap(straight) - straight) / (2.0 * np.pi))
    azimuth = np.flip(np.unwrap(np.flip(azimuth, axis=0), axis=0), axis=0)
    # first row above which the flank exists up to the tip
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


def _pinion_turns(flanks: GearFlanks) -> dict[FlankSide, float]:
    """Rotation of each pinion flank for contact with its gear flank; the backlash is removed equally from both."""
    # the lever is positive on the flank that faces larger azimuths
    levers = {side: float(flank.mean_point().lever[0]) for side, flank in flanks.pinion.items()}
    return {side: flanks.pinion_phases[side] - 0.5 * flanks.normal_backlash / lever for side, lever in levers.items()}


def tooth_grid(pair: GearFlanks, member: Member, rows: int = 15, columns: int = 31) -> ToothGrid:
    """Both flanks of one tooth of a member: levels of the depth from root to tip, sections from toe to heel.

    The fillet between flank and root is that of the cutter, down to the root it cuts (`root_profile`). The gear flanks
    bound one slot, as the cutter leaves it. The pinion flanks are rotated until both contact the slot of the gear, and
    the backlash is removed from the pinion tooth. Misalignments of the pair have no effect.

    Raises `ConvergenceError` if a flank does not cover its blank, or the flanks intersect (pointed tooth, closed slot).
    """
    flanks = pair.of(member)
    blank = pair.blank(member)
    roots = {side: root_profile(flank, columns, pair.clearance(member)) for side, flank in flanks.items()}
    stations = np.linspace(-0.5, 0.5, columns) * blank.face_width
    h = _heights(blank, stations, rows, list(roots.values()))
    u = np.broadcast_to(stations, h.shape)
    azimuth: dict[FlankSide, FloatArray] = {}
    upper: FlankSide = "concave"
    for side, flank in flanks.items():
        azimuth[side] = _flank_azimuth(flank, u, h, roots[side])
        if flank.mean_point().lever[0] > 0.0:
            upper = side
    lower: FlankSide = "convex" if upper == "concave" else "concave"
    pitch = 2.0 * np.pi / blank.teeth
    if member == "pinion":
        for side, turn in _pinion_turns(pair).items():
            azimuth[side] += turn
        shift = 0.0
    else:
        # flanks as cut bound a slot: the tooth lies one pitch behind its second flank
        shift = -pitch
    thickness = azimuth[upper] - azimuth[lower] - shift
    # azimuths are determined up to whole rotations
    shift += 2.0 * np.pi * np.round((float(thickness.mean()) - 0.5 * pitch) / (2.0 * np.pi))
    thickness = azimuth[upper] - azimuth[lower] - shift
    middle = azimuth[lower] + shift + 0.5 * thickness
    centre = float(middle[rows // 2, columns // 2])
    faces = azimuth[lower] + shift - centre, azimuth[upper] - centre
    fillets = roots[lower] is not None, roots[upper] is not None
    grid = ToothGrid(blank, u, h, *faces, (lower, upper), fillets, centre)
    tip, root = "a smaller addendum or more tooth thickness", "less tooth thickness or a smaller dedendum"
    ends = ("tip", thickness[-1], "tooth", tip), ("root", pitch - thickness[0], "slot", root)
    for name, gap, least, remedy in ends:
        if np.any(gap <= 0.0):
            worst = int(np.argmin(gap))
            place = (u[0, worst] + 0.5 * blank.face_width) * 1e3
            where = f"the {least} of the {member} closes at its {name}, {place:.3g} mm from the toe"
            raise ConvergenceError("flanks_cross", f"{where}; give the {member} {remedy}")
    return grid


# the root may be undercut or fillet: the thickness there is extrapolated from these fractions of the whole depth, at
# stations along the face
_FRACTIONS, _STATIONS = (0.2, 0.6, 1.0), 7
# tuned: largest tooth thickness at the mean point as a fraction of the pitch, above which the flanks intersect (this
# work); may be changed freely
_WIDEST = 0.9


def _points(flank: Flank, u: FloatArray, h: FloatArray, member: Member) -> tuple[FlankPoints, FloatArray]:
    """Flank points with the mean point as the last one, and an offset of 0 for existing points, nan otherwise."""
    points, found = flank.solve(np.append(u, 0.0), np.append(h, 0.0))
    if not found[-1]:
        raise ConvergenceError("undercut", f"the {flank.side} {member} flank does not reach the mean point")
    # missing points are replaced by the mean point to avoid invalid numbers
    points = flank.points(np.where(found, points.parameters, points.parameters[:, -1:]))
    return points, np.where(found[:-1], 0.0, np.nan)


def normal_thickness(flanks: GearFlanks, member: Member, u: FloatArray, h: FloatArray) -> FloatArray:
    """Normal circular tooth thickness of a member at blank coordinates [m]; nan where a flank is undercut.

    The tooth extends around the axis between the flanks facing backwards and forwards. Each flank may be that of any of
    the equal teeth, so whole pitches are removed. The thickness of the pinion is that with backlash.
    """
    concave, convex = (flanks.of(member)[side] for side in FLANK_SIDES)
    (one, missing_one), (other, missing_other) = (_points(flank, u, h, member) for flank in (concave, convex))
    turns = _pinion_turns(flanks) if member == "pinion" else dict.fromkeys(FLANK_SIDES, 0.0)
    tooth = np.sign(one.lever[-1]) * (one.azimuth + turns["concave"] - other.azimuth - turns["convex"])
    pitch = 2.0 * np.pi / concave.blank.teeth
    mean = tooth[-1] % pitch
    mean -= pitch * (mean > _WIDEST * pitch)
    angle = mean + np.angle(np.exp(1j * (tooth - tooth[-1])))
    radius = np.hypot(one.position[0], one.position[1])
    pitch_angle = concave.blank.pitch_angle
    spiral = 0.5 * (one.angles(pitch_angle)[0] + other.angles(pitch_angle)[0])
    return np.asarray((radius * angle * np.cos(spiral))[:-1] + missing_one + missing_other)


TIP_REMEDIES: dict[Member, str] = {
    "pinion": "lower the pinion's addendum (larger depth.gear_addendum_factor, smaller depth.depth_factor) or thicken "
    "it (larger depth.thickness_factor)",
    "gear": "lower the gear's addendum (smaller depth.gear_addendum_factor or depth.depth_factor) or thicken it "
    "(smaller depth.thickness_factor)",
}
"""Remedies for a pointed tooth, by the keys of a targets file."""


def _require_thickness(member: Member, place: str, values: FloatArray, face: FloatArray) -> None:
    if np.all(values > 0.0):
        return
    thinnest = int(np.argmin(values))
    cuts = "check point_radius and blade_angle of both cutters, both machine settings, the addendum and the pitch angle"
    remedy = f"{TIP_REMEDIES[member]} in the targets and repeat settings; or {cuts}" if place == "tip" else cuts
    where = f"{member}: tooth thickness at the {place}"
    stated = f"{values[thinnest] * 1e3:.3g} mm at {face[thinnest] * 1e3:.3g} mm from the toe"
    raise InputError(where, stated, "above 0 mm", f"The concave and the convex flank of the {member} cross: {remedy}.")


def _filled(width: FloatArray, face: FloatArray) -> FloatArray:
    """Missing values of (fractions, stations) from a smooth surface through the others: undercut thins the tooth."""
    found = np.isfinite(width)
    if found.all():
        return width
    across, along = np.meshgrid(np.array(_FRACTIONS), face / face[-1], indexing="ij")
    terms = np.stack([across**i * along**j for i in range(3) for j in range(3 - i)], axis=-1)
    filled = width.copy()
    filled[~found] = terms[~found] @ np.linalg.lstsq(terms[found], width[found], rcond=None)[0]
    return filled


def tooth_shapes(flanks: GearFlanks) -> tuple[ToothShape, ToothShape]:
    """Depth and thickness of one tooth of the pinion and of the gear, toe to heel.

    If a flank is undercut the thickness is extrapolated from the remainder of the tooth. Raises an `InputError` if the
    flanks of a member intersect, so that its tooth has no thickness at the tip or at the root.
    """
    shapes = {member: tooth_shape(flanks, member) for member in MEMBERS}
    for name, shape in shapes.items():
        for place, values in (("tip", shape.thickness_tip), ("root", shape.thickness_root)):
            _require_thickness(name, place, values, shape.face)
    return shapes["pinion"], shapes["gear"]


def tooth_shape(flanks: GearFlanks, member: Member) -> ToothShape:
    """Depth and thickness of a tooth as in `tooth_shapes`, also for intersecting flanks."""
    blank = flanks.blank(member)
    u = np.linspace(-0.5, 0.5, _STATIONS) * blank.face_width
    face = u + 0.5 * blank.face_width
    across = np.repeat(np.array(_FRACTIONS), _STATIONS)
    along = np.tile(u, len(_FRACTIONS))
    width = normal_thickness(flanks, member, along, blank.height(along, across))
    width = _filled(width.reshape(len(_FRACTIONS), _STATIONS), face)
    root = np.array([np.polyval(np.polyfit(_FRACTIONS, column, 2), 0.0) for column in width.T])
    return ToothShape(face, blank.tip(u) - blank.root(u), root, width[-1])
