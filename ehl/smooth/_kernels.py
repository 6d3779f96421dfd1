"""Compiled loops of the steady smooth solver (dimensionless).

Film ``H = H00 + x^2/2 - (a/pi) K P`` on nodes ``x = x_in + a (s - x_in)``; ``K`` integrates ``ln|s - s'|`` against
the hat functions of the reference nodes ``s``. Each function has a plain NumPy twin in the tests.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ehl.fluid._kernels import inlet_laws, log_mobility
from ehl.io.kernel_compiler import INTERNAL_KERNEL, KERNEL, kernel

FAR = 24.0  # element sizes beyond which the moment series of the kernel replaces its closed form
LOG_VISCOSITY_CAP = 500.0  # exp() of more than this is no oil and would overflow


@kernel(**KERNEL)
def log_kernel(s):
    """Matrix K[i, j] = integral of ln|s_i - t| phi_j(t) dt, phi_j the hat function of node j."""
    n = s.size
    log = np.zeros((n, n))
    for i in range(1, n):
        for j in range(i):
            log[i, j] = math.log(s[i] - s[j])
            log[j, i] = log[i, j]
    k = np.empty((n, n))
    for j in range(n):
        left = s[j] - s[j - 1] if j > 0 else 0.0
        right = s[j + 1] - s[j] if j < n - 1 else 0.0
        limit = FAR * max(left, right)
        l2 = left * left
        r2 = right * right
        # Moments of the hat function about its node; the closed form loses digits far away.
        m0 = 0.5 * (left + right)
        m1 = (r2 - l2) / 6.0
        m2 = (r2 * right + l2 * left) / 12.0
        m3 = (r2 * r2 - l2 * l2) / 20.0
        m4 = (r2 * r2 * right + l2 * l2 * left) / 30.0
        m5 = (r2 * r2 * r2 - l2 * l2 * l2) / 42.0
        for i in range(n):
            r = s[i] - s[j]
            if abs(r) > limit:
                q = 1.0 / r
                series = m1 + q * (m2 / 2.0 + q * (m3 / 3.0 + q * (m4 / 4.0 + q * m5 / 5.0)))
                k[i, j] = m0 * log[i, j] - q * series
                continue
            # from the twice integrated logarithm, r^2/2 ln|r| - 3 r^2/4
            here = r * r * (0.5 * log[i, j] - 0.75)
            k[i, j] = 0.0
            if right > 0.0:
                ahead = r - right
                k[i, j] += (ahead * ahead * (0.5 * log[i, j + 1] - 0.75) - here) / right
            if left > 0.0:
                behind = r + left
                k[i, j] += (behind * behind * (0.5 * log[i, j - 1] - 0.75) - here) / left
            if left == 0.0 or right == 0.0:
                first = r * log[i, j] - r
                k[i, j] += first if left == 0.0 else -first
    return k


@njit(**INTERNAL_KERNEL)
def _mobility(log_eta, h, gamma, cross):
    """Film mobility f = S-factor/eta with its derivatives in ln(eta) and h.

    Along the sliding vector cosh(S)/eta = hypot(1/eta, gamma/h); across it sinh(S)/(S eta) = (gamma/h)/S.
    ``cross`` is the squared cosine of the angle between sliding vector and x.
    """
    fluidity = math.exp(-log_eta)
    if gamma == 0.0:
        return fluidity, -fluidity, 0.0
    rate = gamma / h
    along = math.sqrt(fluidity * fluidity + rate * rate)
    s = rate / fluidity
    f = cross * along
    f_eta = -cross * fluidity * fluidity / along
    f_h = -cross * rate * rate / (along * h)
    if cross < 1.0:
        if s < 1e-2:
            s2 = s * s
            ratio = 1.0 + s2 * (1.0 / 6.0 - s2 * 17.0 / 360.0)
            slope = s2 * (1.0 / 3.0 - s2 * 17.0 / 90.0)  # d ratio / d ln s
        else:
            angle = math.asinh(s) if s < 1e100 else math.log(2.0) + math.log(s)
            ratio = s / angle
            slope = ratio * (1.0 - ratio * fluidity / along)
        f += (1.0 - cross) * fluidity * ratio
        f_eta += (1.0 - cross) * fluidity * (slope - ratio)
        f_h -= (1.0 - cross) * fluidity * slope / h
    return f, f_eta, f_h


@njit(**INTERNAL_KERNEL)
def _log_mean(u, v):
    """Logarithmic mean of two positive numbers with both derivatives."""
    z = math.log(v / u)
    if abs(z) < 1e-3:
        g = math.sqrt(u * v) * (1.0 + z * z / 24.0)
        return g, g * (0.5 - z / 12.0) / u, g * (0.5 + z / 12.0) / v
    m = (v - u) / z
    return m, (m / u - 1.0) / z, (1.0 - m / v) / z


@kernel(**KERNEL)
def nodal_state(table, stiffness, gamma, cross, shear, p, h, offset):
    """Density, ln(eta/eta0), mobility and their slopes at the nodes.

    ``table`` holds the laws of viscosity and density, ln(eta/eta0) is multiplied by ``stiffness`` and raised by
    ``offset``; ``gamma`` is the shear number, ``cross`` cos^2 between sliding and x, ``shear`` the shear law. Returns
    rho, drho/dp, ln eta, f, df/dp, df/dh and df/d ln eta.
    """
    n = p.size
    rho = np.empty(n)
    rho_p = np.empty(n)
    log_eta = np.empty(n)
    f = np.empty(n)
    f_p = np.empty(n)
    f_h = np.empty(n)
    f_o = np.empty(n)
    for i in range(n):
        value, slope, rho[i], rho_p[i] = inlet_laws(p[i], table)
        value *= stiffness
        slope *= stiffness
        if value > LOG_VISCOSITY_CAP:
            value = LOG_VISCOSITY_CAP
            slope = 0.0
        log_eta[i] = value + offset[i]
        if shear.plain or gamma == 0.0:
            f[i], f_o[i], f_h[i] = _mobility(log_eta[i], h[i], gamma, cross)
            f_p[i] = f_o[i] * slope
        else:
            log_f, by_eta, by_film, by_pressure = log_mobility(log_eta[i], gamma, h[i], p[i], cross, shear)
            f[i] = math.exp(log_f)
            f_h[i] = f[i] * by_film / h[i]
            f_o[i] = f[i] * by_eta
            f_p[i] = f_o[i] * slope + f[i] * by_pressure
    return rho, rho_p, log_eta, f, f_p, f_h, f_o


@kernel(**KERNEL)
def monotone_cubic(x, y, at):
    """Piecewise cubic through nodes that keeps monotone runs monotone (Fritsch & Butland 1984), at increasing points.

    Points outside the nodes get the value at the end. Returns values and slopes.
    """
    n = x.size
    slope = np.zeros(n)
    for i in range(1, n - 1):
        a, b = x[i] - x[i - 1], x[i + 1] - x[i]
        left, right = (y[i] - y[i - 1]) / a, (y[i + 1] - y[i]) / b
        if left * right > 0.0:
            slope[i] = 3.0 * (a + b) / ((2.0 * b + a) / left + (b + 2.0 * a) / right)
    for end in range(2):
        first, second, third = (0, 1, 2) if end == 0 else (n - 1, n - 2, n - 3)
        a, b = x[second] - x[first], x[third] - x[second]
        near, far = (y[second] - y[first]) / a, (y[third] - y[second]) / b
        value = ((2.0 * a + b) * near - a * far) / (a + b)
        if value * near <= 0.0:
            value = 0.0
        elif near * far <= 0.0 and abs(value) > 3.0 * abs(near):
            value = 3.0 * near
        slope[first] = value
    values = np.empty(at.size)
    slopes = np.zeros(at.size)
    k = 0
    for i in range(at.size):
        place = min(max(at[i], x[0]), x[n - 1])
        while k < n - 2 and place > x[k + 1]:
            k += 1
        step = x[k + 1] - x[k]
        t = (place - x[k]) / step
        rise = y[k + 1] - y[k]
        low, high = step * slope[k], step * slope[k + 1]
        second, third = 3.0 * rise - 2.0 * low - high, low + high - 2.0 * rise
        values[i] = y[k] + t * (low + t * (second + t * third))
        if place == at[i]:
            slopes[i] = (low + t * (2.0 * second + 3.0 * t * third)) / step
    return values, slopes


@kernel(**KERNEL)
def film(x, kernel_pressure, stretch, h00):
    """Film thickness at the nodes."""
    return h00 + 0.5 * x * x - stretch / math.pi * kernel_pressure


@kernel(**KERNEL)
def open_inlet(x, size):
    """Parabola x^2/2 switched on smoothly upstream of -1.5 size, and its slope.

    Taken off the mass content before it is carried to the faces: where the mesh opens up quickly the parabola must
    not be interpolated, and where the film is thin nothing large may be subtracted from it.
    """
    n = x.size
    value = np.zeros(n)
    slope = np.zeros(n)
    for i in range(n):
        u = -x[i] / size - 1.5
        if u > 0.0:
            u4 = u * u * u * u
            share = u4 / (1.0 + u4)
            value[i] = 0.5 * x[i] * x[i] * share
            slope[i] = x[i] * share - 2.0 * x[i] * x[i] * u4 / (u * size * (1.0 + u4) * (1.0 + u4))
    return value, slope


@kernel(**KERNEL)
def residual(x, x_face, size, lam, p, h, flow, rho, f, out):
    """Rows of the first integral eps P' = rho H - Q on the faces, and rho H = Q at the exit.

    The mass content less the open inlet is carried to the faces by the third-order upwind rule in index space.
    Returns False where a face film is not positive.
    """
    n = x.size
    good = True
    base, _ = open_inlet(x, size)
    base_face, _ = open_inlet(x_face, size)
    for i in range(n - 1):
        g0 = rho[i] * h[i] - base[i]
        g1 = rho[i + 1] * h[i + 1] - base[i + 1]
        if i > 0:
            g = 0.75 * g0 + 0.375 * g1 - 0.125 * (rho[i - 1] * h[i - 1] - base[i - 1])
        else:
            g = 0.5 * (g0 + g1)
        mass = g + base_face[i]
        if mass <= 0.0:
            good = False
        density = 0.5 * (rho[i] + rho[i + 1])
        mean, _, _ = _log_mean(f[i], f[i + 1])
        eps = mass * mass * mass * mean / (density * density * lam)
        out[i] = eps * (p[i + 1] - p[i]) / (x[i + 1] - x[i]) - (mass - flow)
    out[n - 1] = rho[n - 1] * h[n - 1] - flow
    return good


@kernel(**KERNEL)
def jacobian(
    x, x_face, size, x_in, stretch, lam, p, h, flow, rho, rho_p, f, f_p, f_h, f_x, kernel, h_a, weights, jac, scale
):
    """Matrix of the Newton system; unknowns P[1..n-2], H00, Q, stretch; rows: faces, exit, load.

    Rows are divided by ``scale`` (filled here) so that the pivots of the inlet do not swamp those of the contact.
    """
    n = x.size
    jac[:, :] = 0.0
    base, base_x = open_inlet(x, size)
    base_face, base_face_x = open_inlet(x_face, size)
    for i in range(n):
        row = jac[i]
        if i < n - 1:
            w_up = -0.125 if i > 0 else 0.0
            w_0 = 0.75 if i > 0 else 0.5
            w_1 = 0.375 if i > 0 else 0.5
            up = i - 1 if i > 0 else 0
            g = w_0 * (rho[i] * h[i] - base[i]) + w_1 * (rho[i + 1] * h[i + 1] - base[i + 1])
            g += w_up * (rho[up] * h[up] - base[up])
            mass = g + base_face[i]
            density = 0.5 * (rho[i] + rho[i + 1])
            mean, mean_0, mean_1 = _log_mean(f[i], f[i + 1])
            dx = x[i + 1] - x[i]
            slope = (p[i + 1] - p[i]) / dx
            eps = mass * mass * mass * mean / (density * density * lam)
            d_mass = 3.0 * eps / mass * slope - 1.0
            d_density = -2.0 * eps / density * slope
            d_mean = eps / mean * slope
            scale[i] = 1.0 / (eps / dx + abs(flow))
            c_up = d_mass * w_up * rho[up]
            c_0 = d_mass * w_0 * rho[i] + d_mean * mean_0 * f_h[i]
            c_1 = d_mass * w_1 * rho[i + 1] + d_mean * mean_1 * f_h[i + 1]
            t_up = d_mass * w_up * rho_p[up] * h[up]
            t_0 = d_mass * w_0 * rho_p[i] * h[i] + 0.5 * d_density * rho_p[i] + d_mean * mean_0 * f_p[i] - eps / dx
            t_1 = d_mass * w_1 * rho_p[i + 1] * h[i + 1] + 0.5 * d_density * rho_p[i + 1]
            t_1 += d_mean * mean_1 * f_p[i + 1] + eps / dx
            flow_sign = 1.0
            d_a = c_up * h_a[up] + c_0 * h_a[i] + c_1 * h_a[i + 1]
            d_a += d_mean * (mean_0 * f_x[i] + mean_1 * f_x[i + 1])
            d_a -= (
                d_mass
                * (
                    w_up * base_x[up] * (x[up] - x_in)
                    + w_0 * base_x[i] * (x[i] - x_in)
                    + w_1 * base_x[i + 1] * (x[i + 1] - x_in)
                )
                / stretch
            )
            d_a += d_mass * base_face_x[i] * (x_face[i] - x_in) / stretch
            d_a -= eps * slope / stretch
        else:
            up = n - 2
            c_up = 0.0
            t_up = 0.0
            c_0 = rho[i]
            t_0 = rho_p[i] * h[i]
            c_1 = 0.0
            t_1 = 0.0
            flow_sign = -1.0
            d_a = c_0 * h_a[i]
            scale[i] = 1.0 / abs(flow)
        sc = scale[i]
        row[n - 1] = flow_sign * sc
        row[n - 2] = (c_up + c_0 + c_1) * sc
        row[n] = d_a * sc
        nxt = i + 1 if i < n - 1 else i
        q = -stretch / math.pi * sc
        b_up = q * c_up
        b_0 = q * c_0
        b_1 = q * c_1
        for j in range(1, n - 1):
            row[j - 1] = b_up * kernel[up, j] + b_0 * kernel[i, j] + b_1 * kernel[nxt, j]
        if up >= 1 and up <= n - 2:
            row[up - 1] += t_up * sc
        if i >= 1 and i <= n - 2:
            row[i - 1] += t_0 * sc
        if nxt >= 1 and nxt <= n - 2:
            row[nxt - 1] += t_1 * sc
    load = 0.0
    for j in range(n):
        load += weights[j] * p[j]
    for j in range(1, n - 1):
        jac[n, j - 1] = stretch * weights[j]
    jac[n, n] = load
    scale[n] = 1.0
