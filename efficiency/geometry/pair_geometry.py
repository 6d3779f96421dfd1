"""Geometry and unloaded contact of a pair on both sides, gathered for tables, figures and reports."""

import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from efficiency.contact.contact_lines import MeshPosition, mesh_cycle
from efficiency.contact.flank_pair import MARKING, ContactPattern, FlankPair, flank_pair
from efficiency.contact.gear_flanks import MEMBERS, SIDES, Side
from efficiency.cutting.cutter import FLANK_SIDES
from efficiency.cutting.flank import CutFlank
from efficiency.cutting.limits import flank_limits
from efficiency.design.design import Design
from ehl.common.arrays import finite_or_none
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.pages import Reportable, StatusOfReason
from ehl.common.units import ValueRange

MARKING_LIMITS = ValueRange("m", gt=0.0, le=1e-3)
_STATIONS = 9


@dataclass(frozen=True)
class SideGeometry:
    """Unloaded contact of one flank pair."""

    side: Side  # ``"drive"`` or ``"coast"``
    pair: FlankPair  # both flanks and the map of their mesh
    cycle: tuple[MeshPosition, ...]  # contact lines over one pinion pitch
    pattern: ContactPattern  # contact pattern for the marking thickness
    # roll angle between the first and the last point both flanks reach, in pitches [-]: the potential contact ratio
    contact_ratio: float
    path_ratio: float  # roll angle over which the unloaded flanks touch inside their edges, in pitches, two at most [-]
    ease_off: tuple[float, float]  # smallest and largest ease-off where both flanks reach [m]
    radius_equivalent: tuple[float, float]  # range of the equivalent radius normal to the contact lines [m]
    # contact point of the highest point of the curve on the gear: from the mean point to the heel, over the pitch cone
    # [m]
    contact_u: float
    contact_height: float
    # direction of the path there in the projection of the gear, from the line to the heel, in (-90, 90] deg [rad]
    path_angle: float
    notes: tuple[str, ...]  # notes on the contact
    seconds: float  # wall time of this side

    def to_dict(self) -> dict[str, Any]:
        """Numbers for JSON, SI units."""
        mesh, pattern, path = self.pair.transmission, self.pattern, self.pair.path
        kept_out = ("pair", "cycle", "pattern")
        centre_u, centre_depth = finite_or_none(pattern.centre)
        marked = {"area_share": pattern.area_share, "centre_u": centre_u, "centre_depth": centre_depth}
        marked |= {"length": pattern.length, "width": pattern.width, "edges": list(pattern.edges)}
        of_path = ("pinion_angle", "transmission_error", "u", "height", "free")
        return {name: getattr(self, name) for name in self.__dataclass_fields__ if name not in kept_out} | {
            "transmission_error_peak_to_peak": mesh.peak_to_peak,
            "transmission_error_interval": mesh.interval,
            "harmonics": mesh.harmonics.tolist(),
            "interpolation_error": self.pair.surface.interpolation_error,
            "pattern": marked,
            "path": {name: getattr(path, name).tolist() for name in of_path},
        }


@dataclass(frozen=True)
class FlankSummary:
    """One flank at its mean point."""

    # spiral angle and normal pressure angle [rad]
    spiral_angle: float
    pressure_angle: float
    # fraction of the whole depth above which the flank spans the face, 0 if it reaches the root cone [-]
    lowest: float
    # share of the face over which a cut flank turns back on itself above the end of the blade profile [-]
    undercut: float
    # from where to where the root the blade tips cut stands over the root cone of the blank [m]; None where the flank
    # is not given by cutter and machine, or the cutter does not reach it
    root_error: tuple[float, float] | None


@dataclass(frozen=True, repr=False)
class PairGeometry(StatusOfReason, Reportable):
    """Geometry of a pair: its flanks and the unloaded contact of each required side."""

    presenter = "efficiency.output.geometry_report:geometry"

    design: Design  # what it was computed from
    marking: float  # thickness of the marking compound [m]
    # `FlankSummary` of ``"pinion_concave"``, ``"pinion_convex"``, ``"gear_concave"``, ``"gear_convex"``
    flanks: dict[str, FlankSummary]
    sides: dict[Side, SideGeometry]  # `SideGeometry` of ``"drive"`` and ``"coast"``
    failures: dict[Side, str]  # why a side could not be computed
    notes: tuple[str, ...]  # notes on the members
    seconds: float  # wall time of all

    @property
    def reason(self) -> str:
        """Why a side could not be computed."""
        return "; ".join(f"{side}: {reason}" for side, reason in self.failures.items())

    def __repr__(self) -> str:
        sides = ", ".join(f"{name} contact ratio {side.contact_ratio:.3f}" for name, side in self.sides.items())
        return f"PairGeometry({self.design.name}: {sides}, {self.status})"

    def to_dict(self) -> dict[str, Any]:
        """Numbers for JSON, SI units."""
        return {
            "design": self.design.name,
            "misalignment": self.design.assembly.misalignment.model_dump(),
            "marking": self.marking,
            "flanks": {name: vars(flank) for name, flank in self.flanks.items()},
            "sides": {name: side.to_dict() for name, side in self.sides.items()},
            "failures": dict(self.failures),
            "notes": list(self.notes),
            "status": self.status,
            "seconds": self.seconds,
        }


def pair_geometry(design: Design, sides: Sequence[Side] = SIDES, marking: float = MARKING) -> PairGeometry:
    """Flanks and unloaded contact of a pair.

    design: the pair, misalignments included.
    sides: what to compute; a side that cannot be computed is a status with its reason, not an error.
    marking: thickness of the marking compound [m].
    Raises `InputError`: a marking thickness out of range; flanks of a member that cross; `ConvergenceError`: a flank
    does not exist at its mean point.
    """
    start = time.perf_counter()
    MARKING_LIMITS.check(marking, "marking")
    flanks = flank_summaries(design)
    notes = tuple(note for name, flank in flanks.items() for note in _flank_notes(design, name, flank))
    found: dict[Side, SideGeometry] = {}
    failures: dict[Side, str] = {}
    for side in sides:
        try:
            found[side] = side_geometry(design, side, marking)
        except ConvergenceError as error:
            failures[side] = str(error)
    seconds = time.perf_counter() - start
    return PairGeometry(design, marking, flanks, found, failures, notes, seconds)


def flank_summaries(design: Design) -> dict[str, FlankSummary]:
    """The four flanks at their mean points."""
    found = {}
    for name, side in product(MEMBERS, FLANK_SIDES):
        flank, undercut, root = design.flank(name, side), 0.0, None
        if isinstance(flank, CutFlank):
            with suppress(ConvergenceError):
                limits = flank_limits(flank, _STATIONS)
                undercut = float(limits.undercut.mean())
                reached = limits.root_error[np.isfinite(limits.root_error)]
                if reached.size == limits.u.size or (reached.size and reached.min() < 0.0):
                    root = float(reached.min()), float(reached.max())
        found[f"{name}_{side}"] = FlankSummary(*flank.mean_angles(), flank.lowest_fraction(), undercut, root)
    return found


def geometry_notes(design: Design, side: Side) -> tuple[str, ...]:
    """Notes on the members and on the unloaded contact of one side.

    Undercut, flanks that end early, roots too high or too deep, and where the contact pattern runs into edges.
    """
    of_members = [note for name, flank in flank_summaries(design).items() for note in _flank_notes(design, name, flank)]
    pair = flank_pair(design.flanks(), side)
    return (*of_members, *_side_notes(pair, pair.pattern()))


def side_geometry(design: Design, side: Side, marking: float = MARKING) -> SideGeometry:
    """Unloaded contact of one side; `ConvergenceError` where the flanks do not exist or do not mesh."""
    start = time.perf_counter()
    pair = flank_pair(design.flanks(), side)
    cycle = mesh_cycle(pair.surface)
    surface, path = pair.surface, pair.path
    pattern = pair.pattern(marking)
    per_pitch = 0.5 * (path.pinion_angle.size - 1)
    roll, relief = surface.patch(*surface.common_points(121, 81), ("roll", "ease_off"))
    middle = path.pinion_angle.size // 2
    du, dh = (value[middle + 1] - value[middle - 1] for value in (path.u, path.height))
    radii = np.concatenate([position.radius_equivalent for position in cycle])
    return SideGeometry(
        side=side,
        pair=pair,
        cycle=cycle,
        pattern=pattern,
        contact_ratio=float(np.ptp(roll)) / surface.pitch,
        path_ratio=float(path.free[:-1].sum()) / per_pitch,
        ease_off=(float(relief.min()), float(relief.max())),
        radius_equivalent=(float(radii.min()), float(radii.max())),
        contact_u=float(path.u[middle]),
        contact_height=float(path.height[middle]),
        path_angle=float(np.arctan(dh / du)) if du != 0.0 else 0.5 * np.pi,
        notes=_side_notes(pair, pattern),
        seconds=time.perf_counter() - start,
    )


def _side_notes(pair: FlankPair, pattern: ContactPattern) -> tuple[str, ...]:
    runs_into = ("the contact pattern runs into: " + ", ".join(pattern.edges),) if pattern.edges else ()
    return pair.notes + runs_into


def _flank_notes(design: Design, name: str, flank: FlankSummary) -> list[str]:
    """Notes on one flank."""
    member = name.partition("_")[0]
    own, mate = (design.pinion, design.gear) if member == "pinion" else (design.gear, design.pinion)
    clearance = own.blank.mean_dedendum - mate.blank.mean_addendum
    what = f"the {name.replace('_', ' ')} flank"
    notes = []
    if flank.lowest > 0.0:
        notes.append(f"{what} ends {100.0 * flank.lowest:.1f} % of the whole depth above the root cone")
    if flank.undercut > 0.0:
        share = 100.0 * flank.undercut
        notes.append(f"{what} is undercut over {share:.0f} % of its face, above the end of the blade profile")
    if flank.root_error is not None and flank.root_error[1] > max(clearance, 0.0):
        height = 1e3 * flank.root_error[1]
        notes.append(
            f"{what}: the blade tips leave a root up to {height:.2f} mm above the root cone, more than the clearance "
            f"of {1e3 * clearance:.2f} mm: the mating tip would reach it"
        )
    if flank.root_error is not None and -flank.root_error[0] > max(clearance, 0.0):
        depth = -1e3 * flank.root_error[0]
        notes.append(
            f"{what}: the blade tips cut a root up to {depth:.2f} mm below the root cone, more than the clearance of "
            f"{1e3 * clearance:.2f} mm: withdraw the cutter (sliding_base), or give its radius at the root of the blank"
        )
    return notes


def marking_thickness(given: float | str | None) -> float:
    """Thickness of the marking compound [m]; default: the usual one."""
    return MARKING if given is None else MARKING_LIMITS.check_given(given, "marking")


def chosen_sides(text: str) -> tuple[Side, ...]:
    """Sides named on the command line: drive, coast or both."""
    if text == "both":
        return SIDES
    for side in SIDES:
        if text == side:
            return (side,)
    raise InputError("side", text, "drive, coast or both")
