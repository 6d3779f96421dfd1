"""Axis of a member in the mesh frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Axis:
    """Axis of one member in the mesh frame: unit direction (3,) and a point on it (3,) [m]."""

    direction: NDArray[np.float64]
    origin: NDArray[np.float64]
