"""Non-dominated points and the volume they dominate; all figures are minimised."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]


def non_dominated(points: FloatArray) -> Mask:
    """Which of some points no other one dominates: none is as good in all figures and better in one.

    Parameters
    ----------
    points : (n, m) array
        Figures of n points; of equal points the first one counts.
    """
    keep = np.ones(len(points), dtype=bool)
    for k, point in enumerate(points):
        as_good = np.all(points <= point, axis=1)
        better = np.any(points < point, axis=1)
        same_before = np.all(points[:k] == point, axis=1).any()
        keep[k] = not (as_good & better).any() and not same_before
    return keep


def hypervolume(points: FloatArray, reference: FloatArray) -> float:
    """Volume that points dominate below a reference point, by slicing along the last figure.

    Parameters
    ----------
    points : (n, m) array
        Figures; points that are not below the reference in all of them add nothing.
    reference : (m,) array
        The corner of the volume.
    """
    inside = points[np.all(points < reference, axis=1)]
    if not len(inside):
        return 0.0
    if inside.shape[1] == 1:
        return float(reference[0] - inside.min())
    inside = inside[np.argsort(inside[:, -1], kind="stable")]
    edges = np.append(inside[:, -1], reference[-1])
    return float(
        sum(
            (edges[k + 1] - edges[k]) * hypervolume(inside[: k + 1, :-1], reference[:-1])
            for k in range(len(inside))
            if edges[k + 1] > edges[k]
        )
    )


def spread_out(points: FloatArray, count: int) -> list[int]:
    """Some of the points: the best in each figure, then always the one farthest from those taken (maximin).

    Parameters
    ----------
    points : (n, m) array
        Figures of a front.
    count : int
        How many at most.
    """
    span = np.ptp(points, axis=0)
    scaled = (points - points.min(axis=0)) / np.where(span > 0.0, span, 1.0)
    taken = list(dict.fromkeys(int(np.argmin(points[:, j])) for j in range(points.shape[1])))[:count]
    while len(taken) < min(count, len(points)):
        distance = np.min(np.linalg.norm(scaled[:, None] - scaled[taken][None], axis=2), axis=1)
        taken.append(int(np.argmax(distance)))
    return taken
