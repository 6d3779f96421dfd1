"""Values known at the loaded points of one grid, at those of another grid of the same contact lines."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from efficiency.loss.kinematics import LoadedPoints
from efficiency.ltca.load_distribution import LoadDistribution

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def values_on_lines(
    values: FloatArray,
    known: tuple[LoadDistribution, LoadedPoints],
    wanted: tuple[LoadDistribution, LoadedPoints],
) -> FloatArray:
    """Linear interpolation along each contact line; beyond the known points of a line the value of the last one.

    Where a line has no known point (it carries next to nothing on one of both grids), the mean of its position.

    Parameters
    ----------
    values : (n,) array
        At the loaded points of the known grid.
    known, wanted : LoadDistribution and LoadedPoints
        Of both grids: the same positions and lines.

    Returns
    -------
    (m,) array
        At the loaded points of the wanted grid.
    """
    lines, places = _lines(*known)
    wanted_lines, wanted_places = _lines(*wanted)
    result = np.empty(wanted[1].force.size)
    for position in np.unique(wanted[1].position):
        here = known[1].position == position
        asked = wanted[1].position == position
        for line in np.unique(wanted_lines[asked]):
            target = np.flatnonzero(asked & (wanted_lines == line))
            source = np.flatnonzero(here & (lines == line))
            if source.size == 0:
                result[target] = values[here].mean()
                continue
            chord = places[source[-1]] - places[source[0]]
            if source.size == 1 or not chord.any():
                result[target] = values[source[0]]
                continue
            run = places[source] @ chord
            order = np.argsort(run)
            result[target] = np.interp(wanted_places[target] @ chord, run[order], values[source][order])
    return result


def _lines(load: LoadDistribution, points: LoadedPoints) -> tuple[IntArray, FloatArray]:
    """Number of the line (or edge) and place in the mesh frame of each loaded point."""
    line = np.empty(points.force.size, np.int64)
    place = np.empty((points.force.size, 3))
    for number, position in enumerate(load.cycle):
        at = points.position == number
        line[at] = position.line_number[points.index[at]]
        place[at] = position.position[points.index[at]]
    return line, place
