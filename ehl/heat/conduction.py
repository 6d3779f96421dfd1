"""Flash temperature: the rise of a surface under a heat flux that it moves through.

The matrices are those A of ``rise = A @ flux`` for a flux that is linear between the nodes of any graded
mesh and zero outside it; the kernel is integrated exactly over each cell.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from scipy.special import k0e, k1e

from ehl.common.arrays import FloatArray
from ehl.heat import _kernels
from ehl.line_contact import LineContact
from ehl.material import Material

Matrices = tuple[FloatArray, FloatArray]

# a body at rest has no steady field of its own: about 10 half-widths down, as deep as the field of a body at this
# Peclet number reaches, the bulk temperature is taken to hold
PECLET_FLOOR = 0.1
# tuned: how sharply that sets in, the highest temperature is 2.5 % lower at the floor, 0.02 % at twice it, 2e-7 at
# 0.5
FLOOR_POWER = 8
_DEGREE = 7  # of the polynomials of the Bessel functions
NO_SHARE = 1e-10  # of the field of a reversed motion: less is not computed


def peclet_number(speed: float, half_width: float, body: Material) -> float:
    """|u| b/(2 chi), the time heat needs to cross the half-width over the time of passage [-]."""
    return abs(speed) * half_width / (2.0 * body.thermal_diffusivity)


def bounded_rate(rate: float, half_width: float) -> float:
    """Inverse length of the heat field of a moving body, |u|/(2 chi) bounded by the depth of that of a body at rest.

    A smooth and even function of the speed: (|u|/(2 chi))^8 + (0.1/b)^8 to the power of 1/8.
    """
    return float((abs(rate) ** FLOOR_POWER + (PECLET_FLOOR / half_width) ** FLOOR_POWER) ** (1.0 / FLOOR_POWER))


def jaeger_matrix(x: FloatArray, speed: float, body: Material, half_width: float) -> FloatArray:
    """Exact quasi-stationary conduction in two dimensions (moving line sources on a half-space).

    T(x) = (1/(pi k)) int q(s) exp(z) K0(|z|) ds, z = u (x - s)/(2 chi) (Jaeger 1942; Carslaw & Jaeger, section 10.7).
    Its limit for large Peclet numbers is conduction in one dimension, as the transient solver computes it.

    Near u = 0 the field of a half-space grows without limit. Ours: with m of `bounded_rate`, z = m (x - s) and
    v = u/(2 chi m), the kernel is (1/(pi k)) (cosh z + v sinh z) K0(|z|). It is Jaeger's for |v| = 1; at rest it is
    even in x; between them it has the slope of exp(u (x - s)/(2 chi)) at the source; a reversed speed mirrors it. So
    friction is continuous where a surface passes through rest.

    x (n,): nodes, increasing [m].
    speed: surface velocity along x, of either sign or zero [m/s].
    body: thermal properties.
    half_width: Hertz half-width, for the depth of the field of a body at rest only [m].
    Returns: [K m2/W], shape (n, n).
    """
    rate = speed / (2.0 * body.thermal_diffusivity)
    bounded = bounded_rate(rate, half_width)
    unit = 1.0 / (math.pi * body.thermal_conductivity * bounded)
    onward, against = 0.5 * unit * (1.0 + rate / bounded), 0.5 * unit * (1.0 - rate / bounded)
    # cosh z + v sinh z is the field of a motion along x and one against it in these shares
    matrix = np.zeros((len(x), len(x)))
    if onward > NO_SHARE * unit:
        matrix += onward * _moving_kernel(bounded * x)
    if against > NO_SHARE * unit:
        matrix += against * _mirrored(_moving_kernel(-bounded * x[::-1]))
    return matrix


def _moving_kernel(place: FloatArray) -> FloatArray:
    """Jaeger's kernel exp(z) K0(|z|) integrated over each cell, z = place_i - place_j; `place` increases."""
    return np.asarray(_kernels.moving_kernel(np.ascontiguousarray(place), _bessel_table()))


@cache
def _bessel_table() -> FloatArray:
    """Polynomials of exp(r) K0(r) and r exp(r) K1(r), highest power first, over cells even in each doubling of r.

    They keep twelve digits or more (test).
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


def _mirrored(matrix: FloatArray) -> FloatArray:
    return np.ascontiguousarray(matrix[::-1, ::-1])


def surface_matrices(x: FloatArray, contact: LineContact, bodies: tuple[Material, Material]) -> Matrices:
    """Rise of each surface per flux into it at the nodes `x` [K m2/W]."""
    first, second = (
        jaeger_matrix(x, speed, body, contact.half_width)
        for speed, body in zip((contact.speed_1, contact.speed_2), bodies, strict=True)
    )
    return first, second
