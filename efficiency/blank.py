"""Blank of one member: cones, face width, tooth height along the face."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class ToothShape:
    """What a plate model of one tooth needs, at stations along the face from toe to heel.

    Attributes
    ----------
    teeth : int
        Number of teeth of the member.
    face : (m,) array
        Distance from the toe along the pitch cone [m]; ``face[-1]`` is the face width.
    height : (m,) array
        Whole depth, root cone to face cone, square to the pitch cone [m].
    thickness_root, thickness_tip : (m,) arrays
        Normal chordal tooth thickness at the root and at the tip [m]; fillets are not modelled.
    """

    teeth: int
    face: FloatArray
    height: FloatArray
    thickness_root: FloatArray
    thickness_tip: FloatArray
