"""Compiled loops of the steady heat balance; each has a plain NumPy twin in the tests."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ehl.io.kernel_compiler import INTERNAL_KERNEL, KERNEL, kernel

# cells of the table of Bessel functions: so many in each doubling of r, from 2^LOWEST to 2^HIGHEST
PER_DOUBLING = 16
LOWEST, HIGHEST = -30, 30
EULER_GAMMA = 0.5772156649015329


@njit(**INTERNAL_KERNEL)
def _scaled_bessel(r, table):
    """exp(r) K0(r) and r exp(r) K1(r)."""
    mantissa, exponent = math.frexp(r)  # r = mantissa 2^exponent, mantissa from 1/2 to 1
    if exponent <= LOWEST:
        return (1.0 + r) * (-math.log(0.5 * r) - EULER_GAMMA), 1.0 + r
    if exponent > HIGHEST:
        root = math.sqrt(0.5 * math.pi / r)
        return root * (1.0 - 0.125 / r), root * (r + 0.375)
    place = (mantissa - 0.5) * (2.0 * PER_DOUBLING)
    cell = int(place)
    t = 2.0 * (place - cell) - 1.0
    row = table[(exponent - 1 - LOWEST) * PER_DOUBLING + cell]
    k0, k1 = row[0, 0], row[0, 1]
    for power in range(1, row.shape[0]):
        k0 = k0 * t + row[power, 0]
        k1 = k1 * t + row[power, 1]
    return k0, k1


@kernel(**KERNEL)
def moving_kernel(place, table):
    """Jaeger's kernel exp(z) K0(|z|) times the hat functions of the nodes, integrated; z = place_i - place_j.

    From the integrals from 0 to z of exp(t) K0(|t|) and of t exp(t) K0(|t|), which have closed forms.
    """
    n = place.size
    zeroth = np.zeros((n, n))
    first = np.zeros((n, n))
    for i in range(1, n):
        for j in range(i):
            r = place[i] - place[j]
            k0, rk1 = _scaled_bessel(r, table)
            rk0 = r * k0
            # behind the source exp(z) K is exp(r) K, ahead of it exp(-2 r) exp(r) K
            zeroth[i, j] = rk0 + rk1 - 1.0
            first[i, j] = (r * (rk0 + rk1) - rk1 + 1.0) / 3.0
            decay = math.exp(-2.0 * r) if r < 350.0 else 0.0
            zeroth[j, i] = -(decay * (rk0 - rk1) + 1.0)
            first[j, i] = (decay * (r * (rk0 - rk1) - rk1) + 1.0) / 3.0
    matrix = np.zeros((n, n))
    for i in range(n):
        for j in range(n - 1):
            far = place[i] - place[j]
            near = place[i] - place[j + 1]
            i0 = zeroth[i, j] - zeroth[i, j + 1]
            i1 = first[i, j] - first[i, j + 1]
            share = 1.0 / (place[j + 1] - place[j])
            matrix[i, j] += (i1 - near * i0) * share
            matrix[i, j + 1] += (far * i0 - i1) * share
    return matrix


@njit(**INTERNAL_KERNEL)
def _slope(x, y, out):
    """dy/dx on uneven nodes, second order, at the ends too."""
    n = x.size
    for i in range(1, n - 1):
        a = x[i] - x[i - 1]
        b = x[i + 1] - x[i]
        out[i] = (a * a * (y[i + 1] - y[i]) + b * b * (y[i] - y[i - 1])) / (a * b * (a + b))
    a, b = x[1] - x[0], x[2] - x[1]
    out[0] = -(2.0 * a + b) / (a * (a + b)) * y[0] + (a + b) / (a * b) * y[1] - a / (b * (a + b)) * y[2]
    a, b = x[n - 2] - x[n - 3], x[n - 1] - x[n - 2]
    out[n - 1] = b / (a * (a + b)) * y[n - 3] - (a + b) / (a * b) * y[n - 2] + (2.0 * b + a) / (b * (a + b)) * y[n - 1]


@kernel(**KERNEL)
def flow_heat(x, pressure, film, density, length, speed):
    """Heat of the pressure-driven flow where it reaches the walls: the film carries it along while it conducts.

    ``length`` l is that of d(l Q)/dx = q - Q. The gradient in the inlet is taken from ln p over ln|x|, since the
    pressure there nears a power of x on a coarse mesh; what is left at the exit goes with the oil.
    """
    n = x.size
    slope = np.empty(n)
    _slope(x, pressure, slope)
    top = 0.0
    for i in range(n):
        top = max(top, pressure[i])
    count = 0
    inlet = np.empty(n, np.int64)
    highest = 0.0
    for i in range(n):
        highest = max(highest, pressure[i])
        if not (x[i] < 0.0 and highest < 0.1 * top):
            break
        if pressure[i] > 0.0:
            inlet[count] = i
            count += 1
    if count > 3:
        distance = np.empty(count)
        log_pressure = np.empty(count)
        power = np.empty(count)
        for k in range(count):
            distance[k] = math.log(-x[inlet[k]])
            log_pressure[k] = math.log(pressure[inlet[k]])
        _slope(distance, log_pressure, power)
        for k in range(count):
            slope[inlet[k]] = pressure[inlet[k]] / x[inlet[k]] * power[k]
    heat = np.zeros(n)
    stored = 0.0
    before = 0.0
    for i in range(n):
        # the flow of this very mesh (density 1 at the exit): in the contact h - h* is a small difference
        freed = max(speed * (film[i] - film[n - 1] / density[i]) * slope[i], 0.0)
        if i > 0:
            middle = 0.5 * (length[i] + length[i - 1])
            decay = math.exp(-(x[i] - x[i - 1]) / middle)
            stored = stored * decay + 0.5 * (freed + before) * middle * (1.0 - decay)
        before = freed
        heat[i] = stored / length[i] if pressure[i] > 0.0 else 0.0
    return heat
