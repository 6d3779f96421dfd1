"""Compiled loops of the steady smooth solver (dimensionless).

Film ``H = H00 + x^2/2 - (a/pi) K P`` on nodes ``x = x_in + a (s - x_in)``; ``K`` integrates ``ln|s - s'|`` against
the hat functions of the reference nodes ``s``. Each function has a plain NumPy twin in the tests.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

FAR = 12.0  # element sizes beyond which the moment series of the kernel replaces its closed form
LOG_VISCOSITY_CAP = 500.0


@njit(cache=True, error_model="numpy")
def _second_primitive(r):
    """Twice integrated logarithm, r^2/2 ln|r| - 3 r^2/4."""
    if r == 0.0:
        return 0.0
    return 0.5 * r * r * math.log(abs(r)) - 0.75 * r * r


@njit(cache=True, error_model="numpy")
def log_kernel(s):
    """Matrix K[i, j] = integral of ln|s_i - t| phi_j(t) dt, phi_j the hat function of node j."""
    n = s.size
    k = np.empty((n, n))
    for j in range(n):
        left = s[j] - s[j - 1] if j > 0 else 0.0
        right = s[j + 1] - s[j] if j < n - 1 else 0.0
        size = max(left, right)
        l2 = left * left
        r2 = right * right
        # Moments of the hat function about its node: powers 0 to 5.
        m0 = 0.5 * (left + right)
        m1 = (r2 - l2) / 6.0
        m2 = (r2 * right + l2 * left) / 12.0
        m3 = (r2 * r2 - l2 * l2) / 20.0
        m4 = (r2 * r2 * right + l2 * l2 * left) / 30.0
        m5 = (r2 * r2 * r2 - l2 * l2 * l2) / 42.0
        for i in range(n):
            r = s[i] - s[j]
            if abs(r) > FAR * size:
                q = 1.0 / r
                series = m1 + q * (m2 / 2.0 + q * (m3 / 3.0 + q * (m4 / 4.0 + q * m5 / 5.0)))
                k[i, j] = m0 * math.log(abs(r)) - q * series
            else:
                here = _second_primitive(r)
                value = 0.0
                if right > 0.0:
                    # Slope of the primitive across the right element against its derivative at the node.
                    value += (_second_primitive(r - right) - here) / right
                if left > 0.0:
                    value += (_second_primitive(r + left) - here) / left
                # An end node carries half a hat: its missing half is closed by the derivative of the primitive.
                if right == 0.0 or left == 0.0:
                    slope = r * math.log(abs(r)) - r if r != 0.0 else 0.0
                    value += slope if right == 0.0 else 0.0
                    value -= slope if left == 0.0 else 0.0
                    if right == 0.0:
                        value -= 2.0 * slope
                    else:
                        value += 2.0 * slope
                k[i, j] = value
    return k
