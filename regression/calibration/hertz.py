"""Hertz pressure of point contacts, and the line contact that stands in for one."""

from __future__ import annotations

import math

from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

# mean over largest pressure: 2/3 of an ellipsoid, pi/4 of a half cylinder
MEAN_POINT, MEAN_LINE = 2.0 / 3.0, math.pi / 4.0


def hertz_point_pressure(load: float, radius_1: float, radius_2: float, effective_modulus: float) -> float:
    """Largest pressure of an elliptical Hertz contact [Pa] (Johnson 1985, Contact Mechanics, section 4.2).

    1/(2 R') = (p0/E*) b/(e^2 a^2) (K - E), 1/(2 R'') = (p0/E*) b/(e^2 a^2) ((a/b)^2 E - K), W = 2 pi a b p0/3, with
    E* = E'/2, R' the larger radius, a the longer half axis, e^2 = 1 - (b/a)^2, K and E complete elliptic integrals.

    Parameters
    ----------
    load : float
        W [N].
    radius_1, radius_2 : float
        Equivalent radii in both directions [m].
    effective_modulus : float
        E' [Pa].
    """
    stiff = 0.5 * effective_modulus
    larger, smaller = max(radius_1, radius_2), min(radius_1, radius_2)
    if larger / smaller < 1.0 + 1e-4:
        mean = math.sqrt(larger * smaller)
        return float((6.0 * load * stiff**2 / (math.pi**3 * mean**2)) ** (1.0 / 3.0))

    def ratio(log_axes: float) -> float:
        axes = math.exp(log_axes)
        m = 1.0 - axes**-2
        return float(math.log((axes**2 * ellipe(m) - ellipk(m)) / (ellipk(m) - ellipe(m))) - math.log(larger / smaller))

    axes = math.exp(brentq(ratio, 1e-5, math.log(larger / smaller) + 1.0, xtol=1e-12))
    m = 1.0 - axes**-2
    short = (3.0 * load * larger * float(ellipk(m) - ellipe(m)) / (math.pi * axes**3 * m * stiff)) ** (1.0 / 3.0)
    return float(1.5 * load / (math.pi * axes * short**2))
