"""Pressures of a line contact at which the material below it begins to yield, and at which it no longer shakes down.

Hertz pressure of a half-plane that carries a normal load and sliding friction mu. With the yield stress Y in tension
and k = Y/sqrt(3) in shear (von Mises):

    first yield, mu = 0:   p = 1.79 Y = 3.1 k, at 0.70 b; greatest shear stress 0.30 p at 0.79 b
    shakedown:             p = k/max |tau_zx/p|;  4 k at mu = 0, k/mu where the surface decides

Residual stresses that a rolling line contact leaves cannot balance tau_zx, so where it exceeds k the material flows at
every pass (Johnson, Contact Mechanics; Johnson & Jefferis 1963, both from memory). The stresses are McEwen's.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]

YIELD_RATIO = 1.79
"""Hertz pressure at first yield of a line contact over the yield stress, Poisson's ratio 0.3."""
HARDNESS_RATIO = 3.0
"""Hardness over yield stress (Tabor)."""
_FRICTIONS = np.linspace(0.0, 0.5, 26)


def yield_stress(hardness: float) -> float:
    """Yield stress in tension of a material of some hardness [Pa] (Tabor)."""
    return hardness / HARDNESS_RATIO


def yield_pressure(stress: float) -> float:
    """Hertz pressure at which a line contact first yields below its surface [Pa]; `stress` is the yield stress."""
    return YIELD_RATIO * stress


def shear_stress(across: FloatArray, depth: FloatArray, friction: float) -> FloatArray:
    """tau_zx over the Hertz pressure at places in half-widths, depth positive (McEwen; Johnson)."""
    x, z = np.broadcast_arrays(across, depth)
    level = 1.0 - x**2 + z**2
    root = np.sqrt(level**2 + 4.0 * x**2 * z**2)
    m2, n2 = 0.5 * (root + level), 0.5 * (root - level)
    m, n = np.sqrt(m2), np.sqrt(np.maximum(n2, 0.0)) * np.sign(x)
    total = np.maximum(m2 + n2, 1e-300)
    normal = -n * (m2 - z**2) / total
    sideways = -(m * (1.0 + (z**2 + n2) / total) - 2.0 * z)
    return np.asarray(normal + friction * sideways)


@lru_cache(maxsize=1)
def _greatest_shear() -> FloatArray:
    """Greatest |tau_zx|/p for each of `_FRICTIONS`."""
    across, depth = np.linspace(-1.5, 1.5, 301)[:, None], np.linspace(1e-6, 1.5, 151)[None]
    return np.array([np.abs(shear_stress(across, depth, mu)).max() for mu in _FRICTIONS])


def shakedown_pressure(stress: float, friction: ArrayLike = 0.0) -> FloatArray:
    """Hertz pressure above which a line contact flows at every pass [Pa].

    Parameters
    ----------
    stress : float
        Yield stress in tension [Pa].
    friction : array_like
        Friction coefficient [-]; beyond 0.5 that of 0.5.
    """
    shear = np.interp(np.abs(np.asarray(friction, float)), _FRICTIONS, _greatest_shear())
    return np.asarray(stress / np.sqrt(3.0) / shear)
