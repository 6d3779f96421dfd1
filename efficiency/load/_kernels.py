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
        low, high, now = 0.0, math.pi, 0.5 * math.pi
        for _ in range(60):
            s, c = math.sin(now), math.cos(now)
            length = 1.0 / math.sqrt(1.0 + kappa / math.pi * (now - s * c))
            reach = c - kappa / math.pi * (s - now * c)
            off = length * reach - distance[k]
            if off > 0.0:
                low = now
            else:
                high = now
            slope = -length * s * (1.0 + kappa / math.pi * (now + length * length * s * reach))
            following = now - off / slope
            if not low < following < high:
                following = 0.5 * (low + high)
            done = abs(following - now) < 1e-15
            now = following
            if done:
                break
        angle[k] = now
    return angle
