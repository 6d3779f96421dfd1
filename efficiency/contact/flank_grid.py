"""Flank points solved once for a map of the mesh and shared by all misaligned states."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from efficiency.contact.assembly import Assembly
from efficiency.contact.chebyshev import Patch, PointFit
from efficiency.contact.ease_off import ConjugatePoints, conjugate_points, ease_off, pinion_phase, relative_regularity
from efficiency.cutting.flank import Flank, FlankPoints
from efficiency.cutting.machine import turn
from ehl.common.arrays import BoolArray, FloatArray
from ehl.common.errors import ConvergenceError

# tuned: coefficients along face and depth, by the error of the map (docs/gear_geometry.md); may be changed after
# repeating that page
SHAPE = (18, 14)
# extension of the map beyond the blank along the face (fraction of the face width), above the tip and below the deepest
# contact with the face cone of the pinion (fraction of the depth), for bracketing line ends and for unloaded contact
# just beyond an edge
_OVERHANG, _OVERHANG_DEPTH = 0.04, 0.06
# relative regularity, compared with the design point, below which a flank is undercut; the fields are singular at zero,
# where the flank ends
# tuned: error of the map near the limit (docs/gear_geometry.md); may be changed after repeating that page
UNDERCUT = 0.08
# ratio of points to coefficients in both directions for a partly undercut flank
_OVERSAMPLING = 1.5
# points solved from the mean point of the blank; all others start from the surface through these points
_LEAD = (7, 6)


@dataclass(frozen=True)
class FlankGrid:
    """Solved flank points at the nodes of a map with the design point last, shared by all misaligned states."""

    # flanks
    gear: Flank
    pinion: Flank
    # extent of the map
    u_range: tuple[float, float]
    v_range: tuple[float, float]
    shape: tuple[int, int]  # coefficients along u and v
    dense: bool  # whether there are more nodes than coefficients, so that undercut points are allowed
    # (n + 1,) nodes
    u: FloatArray
    v: FloatArray
    points: FlankPoints  # points of the gear
    found: BoolArray  # (n + 1,) whether the gear flank exists and is regular
    # (n + 1,) regularity of the gear flank relative to the design point, -1 where it was not found
    regular: FloatArray
    start: FloatArray  # (3, n + 1) surface parameters of pinion points nearby

    def denser(self, assembly: Assembly) -> FlankGrid:
        """The map with more nodes than coefficients."""
        return _grid(self.gear, self.pinion, assembly, self.u_range, self.v_range, self.v[-1], self.shape, True)


def flank_grid(gear: Flank, pinion: Flank, assembly: Assembly, shape: tuple[int, int]) -> FlankGrid:
    """Solve the flank points of a map; parameters as in `mesh_surface`."""
    half = 0.5 * gear.blank.face_width * (1.0 + _OVERHANG)
    u_range = (-half, half)
    deepest = _deepest_contact(gear, pinion, assembly, u_range)
    v_range = (deepest - _OVERHANG_DEPTH, 1.0 + _OVERHANG_DEPTH)
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
    # the design point is the last point
    u, v = np.append(u, 0.0), np.append(v, middle)
    lead_u, lead_v = Patch.nodes(u_range, v_range, _LEAD)
    lead_u, lead_v = np.append(lead_u, 0.0), np.append(lead_v, middle)

    lead, found = gear.solve(lead_u, gear.blank.height(lead_u, lead_v))
    if not found[-1]:
        raise ConvergenceError("undercut", f"the {gear.side} gear flank does not reach its design point")
    radius, z = gear.blank.axial(u, gear.blank.height(u, v))

    def spread(parameters: FloatArray, some: BoolArray) -> FloatArray:
        """Starting values for Newton's method at the nodes; with fewer points a lower degree is used."""
        shape = _LEAD if some.all() else (4, 3)
        values = dict(zip(("a", "b", "c"), parameters[:, some], strict=True))
        return PointFit(u_range, v_range, shape, lead_u[some], lead_v[some])(values)(u, v, ("a", "b", "c"))

    parameters, on_gear = gear.refine(radius, z, spread(lead.parameters, found))
    regular = relative_regularity(gear, parameters, on_gear)
    on_gear = regular > UNDERCUT
    # missing gear points are replaced by the design point to avoid invalid numbers
    points = gear.points(np.where(on_gear, parameters, parameters[:, -1:]))

    conjugate = conjugate_points(gear.points(np.where(found, lead.parameters, lead.parameters[:, -1:])), assembly)
    phase = pinion_phase(last_point(conjugate), pinion)
    facing, reached = pinion.solve(*pinion.blank.place(turn(conjugate.position, -phase)))
    if not reached[-1]:
        raise ConvergenceError("undercut", f"the {pinion.side} pinion flank does not reach its design point")
    _, near, met = ease_off(conjugate, pinion, phase, np.where(reached, facing.parameters, facing.parameters[:, -1:]))
    start = spread(near, found & reached & met)
    if not dense and not (on_gear.all() and reached.all() and met.all()):
        return _grid(gear, pinion, assembly, u_range, v_range, middle, shape, True)
    return FlankGrid(gear, pinion, u_range, v_range, shape, dense, u, v, points, on_gear, regular, start)


def last_point(conjugate: ConjugatePoints) -> ConjugatePoints:
    """The last conjugate point: the design point."""
    return ConjugatePoints(
        conjugate.gear_roll[-1:], conjugate.rate[-1:], conjugate.position[:, -1:], conjugate.normal[:, -1:]
    )


def _deepest_contact(gear: Flank, pinion: Flank, assembly: Assembly, u_range: tuple[float, float]) -> float:
    """Smallest depth fraction v of the gear that the face cone of the pinion reaches inside the face width."""
    columns, rows = np.linspace(*u_range, 7), np.linspace(0.0, 1.0, 9)
    u, v = (grid.ravel() for grid in np.meshgrid(columns, rows, indexing="ij"))
    points, found = gear.solve(u, gear.blank.height(u, v))
    f2, _ = assembly.roll(points.position, points.normal)
    found &= np.isfinite(f2)
    f2 = np.where(found, f2, 0.0)
    in_mesh = assembly.gear_in_mesh(points.position, f2)
    position, _ = assembly.to_pinion(in_mesh, points.normal, f2 / assembly.ratio)
    u1, h1 = pinion.blank.place(position)
    # an undercut root, or one that never meshes, lies below the deepest contact
    room = np.where(found, pinion.blank.tip(u1) - h1, -1.0).reshape(columns.size, rows.size)
    # the distance to the face cone of the pinion increases with v; if it is never negative the whole depth is reached
    crossing = [float(np.interp(0.0, column, rows)) for column in room]
    deepest = min(crossing)
    if deepest > 0.9:
        what = "the pinion blank hardly reaches the gear flank; check the blanks and the offset"
        raise ConvergenceError("no_mesh", what)
    return deepest


# limit of the deviation of the relative regularity from linear extrapolation to the next node, for that number of nodes
# over the depth; it is proportional to the square of their distance
# tuned: discontinuities of undercut pinions (this work); may be changed after solving the random blanks of the tests
_LEAP, _LEAP_ROWS = 0.07, 21


def regular_part(grid: FlankGrid, parameters: FloatArray, found: BoolArray) -> tuple[BoolArray, Patch | None]:
    """Mask of points in the regular part of both flanks, and the field that bounds it.

    Beyond its limit of undercut a flank has no points, but Newton's method may converge to another sheet of the
    surface. Each column of nodes is therefore followed from mid-depth outwards. It ends where the regularity falls
    below the limit or deviates from its extrapolation.
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
    patch = PointFit(grid.u_range, grid.v_range, shape, grid.u, grid.v)({"regular": field})
    # points without a solution must lie outside, because the fields of the map are extrapolated there
    over = patch(grid.u[~present], grid.v[~present], ("regular",))[0].max(initial=0.0)
    # a larger excess is an error of the fit of the field; map and contact have their own criteria
    patch.coefficients[0, 0] -= min(over, UNDERCUT)
    return present, patch


def _followed(grid: FlankGrid, measure: FloatArray, unknown: BoolArray) -> tuple[BoolArray, FloatArray]:
    """Columns of nodes up to the end of the flank, and its relative regularity, extrapolated beyond it; both (nu, nv).

    An unknown measure (no point of the mating flank) is extrapolated.
    """
    rows = int(np.flatnonzero(np.diff(grid.u) != 0.0)[0]) + 1
    v, columns, hidden = grid.v[:rows], measure[:-1].reshape(-1, rows), unknown[:-1].reshape(-1, rows)
    # only small values matter: towards the undercut limit of the gear the measure of the pinion is unbounded
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
            # outside the flank the extrapolation continues below the limit
            beyond = np.where(hidden[:, k], ahead, np.minimum(ahead, bound[:, before]).clip(-1.0, 0.0))
            bound[:, k] = np.where(inside[:, k], columns[:, k], beyond)
    return inside, bound
