"""What lies between a flank and the root: the fillet and the root line the cutter leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.cutting.flank import CutFlank, Flank
from efficiency.cutting.limits import flank_limits
from ehl.io.errors import ConvergenceError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class RootProfile:
    """Fillet of one flank at k stations along the face, toe to heel.

    Attributes
    ----------
    start : (k,) array
        Height where the flank begins [m].
    bottom : (k,) array
        Height where the fillet ends in the root [m].
    height, azimuth : (m, k) arrays
        Points of the fillet, the heights falling: over the pitch cone [m], about the axis of the member [rad].
    """

    start: FloatArray
    bottom: FloatArray
    height: FloatArray
    azimuth: FloatArray

    def at(self, height: FloatArray) -> FloatArray:
        """Azimuth (rows, k) at heights (rows, k) below `start`; below `bottom` that of the bottom."""
        return np.stack(
            [
                np.interp(column, heights[::-1], angles[::-1])
                for column, heights, angles in zip(height.T, self.height.T, self.azimuth.T, strict=True)
            ],
            axis=1,
        )


def root_profile(flank: Flank, stations: int, clearance: float) -> RootProfile | None:
    """Fillet and root of a cut flank; None where the settings say nothing sensible of them.

    Parameters
    ----------
    flank : Flank
        Any flank; only one given by cutter and machine has a fillet.
    stations : int
        Equally spaced from toe to heel.
    clearance : float
        Between root and mating tip [m]. A cutter that stays farther above the root cone of the blank would let the
        mating tip run into the root: such settings are meant for the flank alone.
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
    # an edge so long that it turns up again behind its deepest point cuts nothing there
    height = np.minimum.accumulate(curve.height, axis=0)
    azimuth = np.unwrap(np.arctan2(curve.position[:, 1], curve.position[:, 0]), axis=0)
    return RootProfile(limits.start, height[-1], height, azimuth)
