"""Flash temperature: the rise of a surface under a heat flux that it moves through.

The matrices are those A of ``rise = A @ flux`` for a flux that is linear between the nodes of any graded
mesh and zero outside it; the kernel is integrated exactly over each cell.
"""

import math
from functools import cache

import numpy as np
from scipy.special import k0e, k1e

from ehl.common.arrays import FloatArray
from ehl.heat import _kernels
from ehl.line_contact import LineContact
from ehl.material import Material

Matrices = tuple[FloatArray, FloatArray]

# a half-space at rest has no steady temperature field: the bulk temperature is imposed about 10 half-widths below the
# surface, the depth of the field at this Peclet number
PECLET_FLOOR = 0.1
# tuned: sharpness of the transition; it lowers the highest temperature by 2.5 % at the floor, 0.02 % at twice the
# floor and 2e-7 at Pe = 0.5
FLOOR_POWER = 8
_DEGREE = 7  # degree of the polynomials for the Bessel functions
NO_SHARE = 1e-10  # smallest share of the field of the reversed motion that is computed


def peclet_number(speed: float, half_width: float, body: Material) -> float:
    """Peclet number |u| b/(2 chi), the diffusion time over the time of passage of the half-width [-]."""
    return abs(speed) * half_width / (2.0 * body.thermal_diffusivity)


def bounded_rate(rate: float, half_width: float) -> float:
    """Inverse length of the heat field, ((|u|/(2 chi))^8 + (0.1/b)^8)^(1/8) [1/m], smooth and even in the speed.

    It is |u|/(2 chi) for a moving body and bounded from below for a body at rest.
    """
    return float((abs(rate) ** FLOOR_POWER + (PECLET_FLOOR / half_width) ** FLOOR_POWER) ** (1.0 / FLOOR_POWER))


def jaeger_matrix(x: FloatArray, speed: float, body: Material, half_width: float) -> FloatArray:
    """Exact quasi-stationary conduction in two dimensions (moving line sources on a half-space).

    T(x) = (1/(pi k)) int q(s) exp(z) K0(|z|) ds, z = u (x - s)/(2 chi) (Jaeger 1942; Carslaw & Jaeger, section 10.7).
    Its limit for large Peclet numbers is the one-dimensional conduction of the transient solver.

    Near u = 0 the field of a half-space grows without limit. The kernel here (own work) is
    (1/(pi k)) (cosh z + v sinh z) K0(|z|) with m of `bounded_rate`, z = m (x - s) and v = u/(2 chi m). It equals
    Jaeger's for |v| = 1 and is even in x at rest. At the source it has the slope of exp(u (x - s)/(2 chi)), and a
    reversed speed mirrors it. Friction is therefore continuous where a surface passes through rest.

    x (n,): nodes, increasing [m].
    speed: surface velocity along x, of either sign or zero [m/s].
    body: thermal properties.
    half_width: Hertz half-width, which sets the depth of the field at rest [m].
    Returns: rise per flux [K m2/W], shape (n, n).
    """
    rate = speed / (2.0 * body.thermal_diffusivity)
    bounded = bounded_rate(rate, half_width)
    unit = 1.0 / (math.pi * body.thermal_conductivity * bounded)
    onward, against = 0.5 * unit * (1.0 + rate / bounded), 0.5 * unit * (1.0 - rate / bounded)
    # cosh z + v sinh z is a superposition of motions along and against x with these weights
    parts = []
    if onward > NO_SHARE * unit:
        parts.append(onward * _moving_kernel(bounded * x))
    if against > NO_SHARE * unit:
        parts.append(against * _moving_kernel(-bounded * x[::-1])[::-1, ::-1])
    return np.ascontiguousarray(parts[0] if len(parts) == 1 else parts[0] + parts[1])


def _moving_kernel(place: FloatArray) -> FloatArray:
    """Jaeger's kernel exp(z) K0(|z|) integrated over each cell, z = place_i - place_j; `place` increases."""
    return np.asarray(_kernels.moving_kernel(np.ascontiguousarray(place), _bessel_table()))


@cache
def _bessel_table() -> FloatArray:
    """Polynomials of exp(r) K0(r) and r exp(r) K1(r), highest power first, over equal cells in each octave of r.

    They are accurate to twelve digits or more (test).
    """
    cells = np.arange((_kernels.HIGHEST - _kernels.LOWEST) * _kernels.PER_DOUBLING)
    doubling, part = np.divmod(cells, _kernels.PER_DOUBLING)
    t = np.cos((np.arange(_DEGREE + 1) + 0.5) * math.pi / (_DEGREE + 1))
    share = (part[:, None] + 0.5 + 0.5 * t) / _kernels.PER_DOUBLING
    r = np.ldexp(1.0 + share, doubling[:, None] + _kernels.LOWEST)
    values = np.stack([k0e(r), r * k1e(r)], axis=-1)
    return np.ascontiguousarray(
        np.linalg.solve(np.vander(t), np.moveaxis(values, 1, 0).reshape(t.size, -1))
        .reshape(t.size, cells.size, 2)
        .transpose(1, 0, 2)
    )


def surface_matrices(x: FloatArray, contact: LineContact, bodies: tuple[Material, Material]) -> Matrices:
    """Temperature rise of each surface per heat flux into it at the nodes `x` [K m2/W]."""
    first, second = (
        jaeger_matrix(x, speed, body, contact.half_width)
        for speed, body in zip((contact.speed_1, contact.speed_2), bodies, strict=True)
    )
    return first, second
