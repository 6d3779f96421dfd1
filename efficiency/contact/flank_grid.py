"""Flank points solved once for a map of the mesh, and taken over by every misaligned state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from efficiency.contact.assembly import Assembly
from efficiency.contact.chebyshev import Patch
from efficiency.contact.ease_off import ConjugatePoints, conjugate_points, ease_off, pinion_phase, relative_regularity
from efficiency.cutting.flank import Flank, FlankPoints
from efficiency.cutting.rotation import turn
from ehl.common.arrays import BoolArray, FloatArray
from ehl.common.errors import ConvergenceError

# tuned: coefficients along face and depth, by the error of the map (docs/gear_geometry.md); may be changed by whoever
# repeats that page
SHAPE = (18, 14)
# how far the map goes beyond the blank along the face and over the tip (fractions of face and depth): line ends can
# then be bracketed, and unloaded contact just over an edge is still seen
_OVERHANG = (0.04, 0.06)
# a flank counts as undercut where its regularity falls below this share of that at the design point: its fields have a
# singularity at zero, and the flank ends there anyway
# tuned: error of the map next to the limit (docs/gear_geometry.md); may be changed by whoever repeats that page
UNDERCUT = 0.08
# more points than coefficients in both directions where a part of the flank is undercut
_OVERSAMPLING = 1.5
# points solved from the mean point of the blank; all others start from the surface through them
_LEAD = (7, 6)


@dataclass(frozen=True)
class FlankGrid:
    """Solved flank points at the nodes of a map, the design point last; shared by all misaligned states."""

    # gear, pinion: the two flanks
    gear: Flank
    pinion: Flank
    # u_range, v_range: extent of the map
    u_range: tuple[float, float]
    v_range: tuple[float, float]
    shape: tuple[int, int]  # coefficients along u and v
    dense: bool  # more nodes than coefficients: undercut points are allowed
    # u, v: (n + 1,) nodes
    u: FloatArray
    v: FloatArray
    points: FlankPoints  # of the gear
    found: BoolArray  # (n + 1,) where the gear flank exists and is regular
    # (n + 1,) regularity of the gear flank as a share of that at the design point, -1 where it was not found
    regular: FloatArray
    start: FloatArray  # (3, n + 1) surface parameters of pinion points nearby

    def denser(self, assembly: Assembly) -> FlankGrid:
        """The same map with more nodes than coefficients."""
        return _grid(self.gear, self.pinion, assembly, self.u_range, self.v_range, self.v[-1], self.shape, True)


def flank_grid(
    gear: Flank, pinion: Flank, assembly: Assembly, overhang_root: float = 0.06, shape: tuple[int, int] = SHAPE
) -> FlankGrid:
    """Solve the flank points of a map; parameters as in `mesh_surface`."""
    half = 0.5 * gear.blank.face_width * (1.0 + _OVERHANG[0])
    u_range = (-half, half)
    deepest = _deepest_contact(gear, pinion, assembly, u_range)
    v_range = (deepest - overhang_root, 1.0 + _OVERHANG[1])
    return _grid(gear, pinion, assembly, u_range, v_range, 0.5 * (deepest + 1.0), shape, False)


def _grid(
    gear: Flank,
    pinion: Flank,
    assembly: Assembly,
    u_range: tuple[float, float],
    v_range: tuple[float, float],
    middle: float,
    shape: tuple[int, int],
    dense: bool,
) -> FlankGrid:
    rate = _OVERSAMPLING if dense else 1.0
    u, v = Patch.nodes(u_range, v_range, (int(np.ceil(rate * shape[0])), int(np.ceil(rate * shape[1]))))
    # the design point rides along as the last point
    u, v = np.append(u, 0.0), np.append(v, middle)
    lead_u, lead_v = Patch.nodes(u_range, v_range, _LEAD)
    lead_u, lead_v = np.append(lead_u, 0.0), np.append(lead_v, middle)

    lead, found = gear.solve(lead_u, gear.blank.height(lead_u, lead_v))
    if not found[-1]:
        raise ConvergenceError("undercut", f"the {gear.side} gear flank does not reach its design point")
    radius, z = gear.blank.axial(u, gear.blank.height(u, v))
    parameters, on_gear = gear.refine(
        radius, z, _spread(lead_u, lead_v, lead.parameters, found, u_range, v_range, u, v)
    )
    regular = relative_regularity(gear, parameters, on_gear)
    on_gear = regular > UNDERCUT
    # a missing gear point takes the place of the design point, so that no number of it spreads
    points = gear.points(np.where(on_gear, parameters, parameters[:, -1:]))

    conjugate = conjugate_points(gear.points(np.where(found, lead.parameters, lead.parameters[:, -1:])), assembly)
    phase = pinion_phase(last_point(conjugate), pinion)
    turned = turn(conjugate.position, -phase)
    u1, h1 = pinion.blank.coordinates(np.hypot(turned[0], turned[1]), turned[2])
    facing, reached = pinion.solve(np.real(u1), np.real(h1))
    if not reached[-1]:
        raise ConvergenceError("undercut", f"the {pinion.side} pinion flank does not reach its design point")
    _, near, met = ease_off(conjugate, pinion, phase, np.where(reached, facing.parameters, facing.parameters[:, -1:]))
    start = _spread(lead_u, lead_v, near, found & reached & met, u_range, v_range, u, v)
    if not dense and not (on_gear.all() and reached.all() and met.all()):
        return _grid(gear, pinion, assembly, u_range, v_range, middle, shape, True)
    return FlankGrid(gear, pinion, u_range, v_range, shape, dense, u, v, points, on_gear, regular, start)


def _spread(
    u: FloatArray,
    v: FloatArray,
    parameters: FloatArray,
    found: BoolArray,
    u_range: tuple[float, float],
    v_range: tuple[float, float],
    to_u: FloatArray,
    to_v: FloatArray,
) -> FloatArray:
    """Surface parameters at many nodes from those of a few: starts for Newton's method."""
    whole = bool(found.all())
    names = ("a", "b", "c")
    values = dict(zip(names, parameters[:, found], strict=True))
    # the fewer points there are, the stiffer the surface through them
    lead = Patch.fit_points(u_range, v_range, _LEAD if whole else (4, 3), u[found], v[found], values)
    return lead(to_u, to_v, names)


def last_point(conjugate: ConjugatePoints) -> ConjugatePoints:
    """The last of some conjugate points: the design point."""
    return ConjugatePoints(
        conjugate.gear_roll[-1:], conjugate.rate[-1:], conjugate.position[:, -1:], conjugate.normal[:, -1:]
    )


def _deepest_contact(gear: Flank, pinion: Flank, assembly: Assembly, u_range: tuple[float, float]) -> float:
    """Smallest fraction v of the gear's depth that the pinion's face cone reaches inside the face width."""
    columns, rows = np.linspace(*u_range, 7), np.linspace(0.0, 1.0, 9)
    u, v = (grid.ravel() for grid in np.meshgrid(columns, rows, indexing="ij"))
    points, found = gear.solve(u, gear.blank.height(u, v))
    f2, _ = assembly.roll(points.position, points.normal)
    found &= np.isfinite(f2)
    f2 = np.where(found, f2, 0.0)
    in_mesh = assembly.gear_in_mesh(points.position, f2)
    position, _ = assembly.to_pinion(in_mesh, points.normal, f2 / assembly.ratio)
    u1, h1 = pinion.blank.coordinates(np.hypot(position[0], position[1]), position[2])
    # a root that is undercut or never meshes lies below the deepest contact all the same
    room = np.where(found, pinion.blank.tip(np.real(u1)) - np.real(h1), -1.0).reshape(columns.size, rows.size)
    # room under the pinion's face cone grows with v; where it is never negative the whole depth is reached
    crossing = [float(np.interp(0.0, column, rows)) for column in room]
    deepest = min(crossing)
    if deepest > 0.9:
        raise ConvergenceError(
            "no_mesh", "the pinion blank hardly reaches the gear flank; check the blanks and the offset"
        )
    return deepest


# change of the relative regularity from node to node beyond the linear one that no regular flank makes, with that many
# nodes over the depth; it grows with the square of their distance
# tuned: leaps of undercut pinions (ours); may be changed by whoever solves the random blanks of the tests
_LEAP, _LEAP_ROWS = 0.07, 21


def regular_part(grid: FlankGrid, parameters: FloatArray, found: BoolArray) -> tuple[BoolArray, Patch | None]:
    """Which points belong to the regular part of both flanks, and the field that bounds it.

    Beyond its limit of undercut a flank has no points, but Newton's method may end on another sheet of the surface. So
    each column of nodes is followed from the middle of the depth outwards, and ends where the regularity falls below
    the limit, or leaves the line it came on.
    """
    measure = relative_regularity(grid.pinion, parameters, found)
    if (measure > UNDERCUT).all() or not grid.dense:
        return measure > UNDERCUT, None
    inside, bound = _followed(grid, measure, ~grid.found)
    if not grid.found.all():
        on_gear, its_bound = _followed(grid, grid.regular, np.zeros_like(found))
        inside, bound = inside & on_gear, np.minimum(bound, its_bound)
    field = np.append(bound.ravel() - UNDERCUT, 1.0)
    shape = min(10, grid.shape[0]), min(9, grid.shape[1])
    present = np.append(inside.ravel(), True) & found
    patch = Patch.fit_points(grid.u_range, grid.v_range, shape, grid.u, grid.v, {"regular": field})
    # no place without points may lie inside: there the fields of the map are extrapolated
    over = patch(grid.u[~present], grid.v[~present], ("regular",))[0].max(initial=0.0)
    # more than that is the fit of the field, not the flank; map and contact have their own criteria
    patch.coefficients[0, 0] -= min(over, UNDERCUT)
    return present, patch


def _followed(grid: FlankGrid, measure: FloatArray, unknown: BoolArray) -> tuple[BoolArray, FloatArray]:
    """Columns of nodes as far as the flank goes, and its relative regularity there, continued beyond; both (nu, nv).

    Where the measure is unknown (no point of the mating flank) it goes on as it came.
    """
    rows = int(np.flatnonzero(np.diff(grid.u) != 0.0)[0]) + 1
    v, columns, hidden = grid.v[:rows], measure[:-1].reshape(-1, rows), unknown[:-1].reshape(-1, rows)
    # only what is small matters: towards the undercut limit of the gear the measure of the pinion grows without bound
    columns = np.where(columns > 1.0, 2.0 - 1.0 / columns.clip(1.0), columns)
    middle = int(np.argmin(np.abs(v - grid.v[-1])))
    leap = _LEAP * (_LEAP_ROWS / rows) ** 2
    inside = np.zeros(columns.shape, dtype=bool)
    inside[:, middle] = columns[:, middle] > UNDERCUT
    bound = columns.copy()
    for step, order in ((1, range(middle + 1, rows)), (-1, range(middle - 1, -1, -1))):
        for k in order:
            before, second = k - step, max(0, min(rows - 1, k - 2 * step))
            rate = (bound[:, before] - bound[:, second]) / (v[before] - v[second])
            ahead = bound[:, before] + rate * (v[k] - v[before])
            goes_on = np.abs(columns[:, k] - ahead) < leap
            inside[:, k] = inside[:, before] & goes_on & (columns[:, k] > UNDERCUT)
            # outside the flank the line it came on goes on, below the limit
            beyond = np.where(hidden[:, k], ahead, np.minimum(ahead, bound[:, before]).clip(-1.0, 0.0))
            bound[:, k] = np.where(inside[:, k], columns[:, k], beyond)
    return inside, bound
