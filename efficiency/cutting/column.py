"""Followed along the blade: the points that successive lengths of the edge cut at fixed stations of the face.

At a station u the edge length s is prescribed; cutter angle and cradle roll follow from the place and the equation of
meshing. Unlike the search at a given height this stays regular where the flank turns back on itself (undercut).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.cutting import newton
from efficiency.cutting.flank import CutFlank
from efficiency.cutting.rotation import dot

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# every so many rows the edge is followed step by step
_STRIDE = 4


@dataclass(frozen=True)
class Columns:
    """Points cut by m lengths of the edge at k stations.

    Attributes
    ----------
    parameters : (m, 3, k) array
        Cutting parameters s, th, phi.
    position, normal : (m, 3, k) arrays
        Points in the work frame [m] and unit normals out of the tooth.
    height : (m, k) array
        Height over the pitch cone [m].
    regression : (m, k) array
        Rate of the equation of meshing along the motion of the contact point that leaves it in place in the work [m];
        zero on the edge of regression, of one sign on the flank, of the other behind it.
    found : (m, k) bool array
        Whether the edge reaches the station.
    """

    parameters: FloatArray
    position: FloatArray
    normal: FloatArray
    height: FloatArray
    regression: FloatArray
    found: BoolArray


def regression(flank: CutFlank, x: FloatArray) -> FloatArray:
    """Rate of the equation of meshing that vanishes on the edge of regression [m], at flank points x (3, n).

    A flank point stands still in the work where ``r_s ds + r_th dth + r_phi dphi = 0``; if the equation of meshing
    holds to first order along that motion, the flank has no tangent plane of its own there.
    """
    _, slope = flank.linearise(x)
    r_s, r_t, r_p = np.moveaxis(slope[:, :3], 0, -1).transpose(1, 0, 2)
    e, f, g = dot(r_s, r_s), dot(r_s, r_t), dot(r_t, r_t)
    a, b = dot(r_s, r_p), dot(r_t, r_p)
    area = e * g - f * f
    alpha, beta = (g * a - f * b) / area, (e * b - f * a) / area
    return np.asarray(slope[:, 6, 2] - alpha * slope[:, 6, 0] - beta * slope[:, 6, 1])


def at_length(flank: CutFlank, u: FloatArray, x: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Cutting parameters at stations u for the edge lengths ``x[0]``, from a start nearby (3, k)."""
    blank = flank.blank
    sine, cosine = np.sin(blank.pitch_angle), np.cos(blank.pitch_angle)
    s = x[:1]

    def linearised(y: FloatArray) -> tuple[FloatArray, FloatArray]:
        state, slope = flank.linearise(np.concatenate([s, y]))
        radius = np.hypot(state[0], state[1])
        along = (state[0] / radius)[:, None] * slope[:, 0] + (state[1] / radius)[:, None] * slope[:, 1]
        value = np.real(blank.coordinates(radius, state[2])[0]) - u
        rows = np.stack([along * sine + slope[:, 2] * cosine, slope[:, 6]], axis=1)
        return np.stack([value, state[6]]), rows[:, :, 1:]

    solved, found = newton.iterate(linearised, x[1:], np.array([0.1, 0.1]), np.full(2, 1e-11))
    return np.concatenate([s, solved]), found


def columns(flank: CutFlank, u: FloatArray, lengths: FloatArray, start: FloatArray) -> Columns:
    """Follow the edge through prescribed lengths at all stations together.

    Parameters
    ----------
    flank : CutFlank
        Flank, or fillet (its blade cutting with the edge radius).
    u : (k,) array
        Stations: distance from the mean point along the pitch cone [m].
    lengths : (m, k) array
        Edge lengths in the order they are followed [m], the first near `start`.
    start : (3, k) array
        Cutting parameters to start from.
    """
    count = lengths.shape[0]
    marks = np.unique(np.linspace(0, count - 1, -(-count // _STRIDE) + 1).round().astype(np.int64))
    x, alive = np.array(start), np.ones(u.size, dtype=bool)
    marked: list[FloatArray] = []
    reached: list[BoolArray] = []
    for s in lengths[marks]:
        ahead = np.zeros_like(x)
        if len(marked) > 1:
            # on along the straight line through the last two
            run = marked[-1][0] - marked[-2][0]
            ahead = (marked[-1] - marked[-2]) * np.where(run != 0.0, (s - x[0]) / np.where(run != 0.0, run, 1.0), 0.0)
        moved, found = at_length(flank, u, np.stack([s, x[1] + ahead[1], x[2] + ahead[2]]))
        alive = alive & found
        x = np.where(alive, moved, x)
        marked.append(x)
        reached.append(alive)
    # the rows between from those beside them, all at once
    place = np.arange(count)
    after = np.searchsorted(marks, place)
    before = np.maximum(after - 1, 0)
    share = ((place - marks[before]) / np.maximum(marks[after] - marks[before], 1))[:, None, None]
    path = np.stack(marked)
    between = path[before] + share * (path[after] - path[before])
    between[:, 0] = lengths
    solved, found = at_length(flank, np.tile(u, count), np.moveaxis(between, 1, 0).reshape(3, -1))
    exists = found.reshape(lengths.shape) & np.stack(reached)[after]
    parameters = np.where(exists[:, None], np.moveaxis(solved.reshape(3, *lengths.shape), 0, 1), between)
    flat = np.moveaxis(parameters, 1, 0).reshape(3, -1)
    points = flank.points(flat)
    _, height = flank.blank.coordinates(np.hypot(points.position[0], points.position[1]), points.position[2])
    shape = lengths.shape
    if flank.machine.generated:
        rate = regression(flank, flat).reshape(shape)
    else:
        # a surface that is not enveloped has no edge of regression
        rate = np.ones(shape)

    def by_row(values: FloatArray) -> FloatArray:
        return np.moveaxis(values.reshape(3, *shape), 0, 1)

    return Columns(
        parameters=parameters,
        position=by_row(points.position),
        normal=by_row(points.normal),
        height=np.real(height).reshape(shape),
        regression=rate,
        found=exists,
    )
