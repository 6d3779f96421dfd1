"""Compiled inner loop of the contact next to an edge."""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(cache=True)
def edge_angle(distance, ratio):
    """Angle at which the contact passes on to the rounding; see `efficiency.load.edge_contact.EdgeSection`."""
    angle = np.empty(distance.size)
    for k in range(distance.size):
        kappa = ratio[k]
        if distance[k] >= 1.0:
            angle[k] = 0.0
            continue
        if distance[k] <= -math.sqrt(1.0 + kappa):
            angle[k] = math.pi
            continue
        low, high = 0.0, math.pi
        for _ in range(60):
            middle = 0.5 * (low + high)
            s, c = math.sin(middle), math.cos(middle)
            length = 1.0 / math.sqrt(1.0 + kappa / math.pi * (middle - s * c))
            if length * (c - kappa / math.pi * (s - middle * c)) > distance[k]:
                low = middle
            else:
                high = middle
            if high - low < 1e-15:
                break
        angle[k] = 0.5 * (low + high)
    return angle
