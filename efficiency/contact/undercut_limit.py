"""How far the flanks of a mesh go before they are undercut."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.ease_off import relative_regularity
from efficiency.contact.flank_grid import UNDERCUT, FlankGrid
from efficiency.contact.patch import Patch

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# change of the relative regularity from node to node beyond the linear one that no regular flank makes, with that many
# nodes over the depth; it grows with the square of their distance
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
    # more than that is the fit of the field, not the flank; the verdicts on map and contact stand behind it
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
