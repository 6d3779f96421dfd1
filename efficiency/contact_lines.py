"""Potential contact lines of all tooth pairs in mesh, at the positions of one pinion pitch.

Frame: the fixed mesh frame, z along the gear axis from the crossing point towards the heel, right-handed,
SI units. Everything "per unit pinion speed" is for a pinion turning at 1 rad/s in its driving direction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.pair import GearPair

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class MeshPosition:
    """All potential contact lines at one pinion angle; one entry per point, lines consecutive.

    Attributes
    ----------
    pinion_angle : float
        Roll of the pinion from the design point in the driving direction [rad].
    pair : (n,) int array
        Tooth pair the point belongs to: 0 the reference pair, +1 a pair further along in mesh, -1 one behind.
    position : (n, 3) array
        Point in the mesh frame [m].
    normal : (n, 3) array
        Unit common normal out of the pinion flank into the gear tooth, the direction of the force
        on the gear.
    along, across : (n, 3) arrays
        Unit tangent of the contact line (y, toe to heel) and the one square to it (x = along cross normal).
    length : (n,) array
        Length of contact line the point stands for [m] (quadrature weight; their sum is the line length).
    gap : (n,) array
        Separation of the unloaded flanks along the normal [m]; the smallest over all pairs is zero.
    radius_equivalent : (n,) array
        Equivalent radius of curvature normal to the contact line [m].
    lever_pinion, lever_gear : (n,) arrays
        Arm of a unit normal force about each axis [m], positive: torque = sum(force lever).
        ``lever_gear/lever_pinion`` is the tooth ratio N2/N1 at every (conjugate) point.
    sliding_along, sliding_across : (n,) arrays
        Sliding velocity, pinion minus gear, along y and x per unit pinion speed [m].
    entrainment : (n,) array
        Mean surface velocity along x relative to the moving contact line, per unit pinion speed [m], signed:
        positive where the surfaces move towards +x. sliding_across/entrainment is the slide-to-roll ratio.
    height_gear, height_pinion : (n,) arrays
        Distance of the point from the root cone of each member, square to its pitch cone [m].
    face_gear, face_pinion : (n,) arrays
        Distance along the pitch cone from the toe of each member [m].
    transmission_error : float
        Rotation of the rigid unloaded gear ahead of its place at constant ratio [rad]; zero or negative
        when it lags behind the design point.
    """

    pinion_angle: float
    pair: IntArray
    position: FloatArray
    normal: FloatArray
    along: FloatArray
    across: FloatArray
    length: FloatArray
    gap: FloatArray
    radius_equivalent: FloatArray
    lever_pinion: FloatArray
    lever_gear: FloatArray
    sliding_along: FloatArray
    sliding_across: FloatArray
    entrainment: FloatArray
    height_gear: FloatArray
    height_pinion: FloatArray
    face_gear: FloatArray
    face_pinion: FloatArray
    transmission_error: float


def mesh_cycle(pair: GearPair, positions: int = 24, points_per_line: int = 31) -> tuple[MeshPosition, ...]:
    """Contact lines at equally spaced pinion angles over one pinion pitch, ``2 pi/N1``.

    Parameters
    ----------
    pair : GearPair
        Geometry of the pair.
    positions : int
        Number of pinion angles in the pitch (the end of the pitch, equal to its start, is left out).
    points_per_line : int
        Points on each contact line.

    Returns
    -------
    tuple of MeshPosition
        One entry per pinion angle.
    """
    raise NotImplementedError
