"""Compiled loops of the steady smooth solver (dimensionless).

Film ``H = H00 + x^2/2 - (a/pi) K P`` on nodes ``x = x_in + a (s - x_in)``; ``K`` integrates ``ln|s - s'|`` against
the hat functions of the reference nodes ``s``.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from ehl.compile._kernels import factored, log, product, solve_factored
from ehl.compile.compiler import FAST_INTERNAL_KERNEL, INTERNAL_KERNEL, KERNEL, kernel
from ehl.fluid._kernels import inlet_laws, limited_stress, log_mobility, stress_scale
from ehl.fluid.lookup import LawTable
from ehl.fluid.rheology import EYRING, ShearNumbers

FAR = 24.0  # element sizes beyond which the moment series of the kernel replaces its closed form
LOG_VISCOSITY_CAP = 500.0  # exp() of more than this is no oil and would overflow
HALF_PI = 0.5 * math.pi
KEPT_MATRIX = 0.25  # a correction below this share of the one before: the matrix serves once more
LEAST_FACTOR = 1e-3  # of the damping

# rows of the state at the nodes; the last: df/d ln eta, then df/dx by the heat, and mobilities along and across sliding
X, KERNEL_PRESSURE, FILM, RHO, RHO_P, LOG_ETA, F, F_P, F_H, F_X, ALONG, ACROSS, ROWS = range(13)
# what became of an iteration
CONVERGED, INFEASIBLE, SINGULAR, EXHAUSTED, LIMIT = range(5)


class Mesh(NamedTuple):
    """Reference nodes and faces with the matrix of the kernel."""

    nodes: np.ndarray
    faces: np.ndarray
    weights: np.ndarray
    matrix: np.ndarray
    x_in: float
    size: float  # of the loaded zone


class Groups(NamedTuple):
    """Fluid and load; fields as of `ehl.smooth.scaling.ScaledContact`."""

    lam: float
    table: LawTable
    gamma: float
    cross: float
    stiffness: float
    shear: ShearNumbers
    offset_x: np.ndarray  # nodes of the effects of heat; none without heat
    offset: np.ndarray  # (3, n): added to ln(eta/eta0), and ln of the shares of the mobilities along and across sliding


@njit(**FAST_INTERNAL_KERNEL)
def _hat_functions(s, hats):
    """Moments of the hat functions about their nodes over their orders, reach of the near field, inverse lengths."""
    for j in range(s.size):
        left = s[j] - s[j - 1] if j > 0 else 0.0
        right = s[j + 1] - s[j] if j < s.size - 1 else 0.0
        l2, r2 = left * left, right * right
        hats[0, j] = 0.5 * (left + right)
        hats[1, j] = (r2 - l2) / 6.0
        hats[2, j] = (r2 * right + l2 * left) / 24.0
        hats[3, j] = (r2 * r2 - l2 * l2) / 60.0
        hats[4, j] = (r2 * r2 * right + l2 * l2 * left) / 120.0
        hats[5, j] = (r2 * r2 * r2 - l2 * l2 * l2) / 210.0
        hats[6, j] = FAR * max(left, right)
        hats[7, j] = 1.0 / left if left > 0.0 else 0.0
        hats[8, j] = 1.0 / right if right > 0.0 else 0.0


@njit(**FAST_INTERNAL_KERNEL)
def _kernel_row(s, i, hats, twice, row):
    """Row of `log_kernel`: moments far away, where the closed form from the twice integrated logarithm loses digits.

    Without branches or calls of a library, so that it works on vectors.
    """
    n = s.size
    for j in range(n):
        r = s[i] - s[j]
        ln = log(abs(r) + 1e-300)
        q = 1.0 / r
        series = hats[1, j] + q * (hats[2, j] + q * (hats[3, j] + q * (hats[4, j] + q * hats[5, j])))
        row[j] = hats[0, j] * ln - q * series
        twice[j] = r * r * (0.5 * ln - 0.75)
    for j in range(1, n - 1):
        here = twice[j]
        near = (twice[j + 1] - here) * hats[8, j] + (twice[j - 1] - here) * hats[7, j]
        row[j] = row[j] if abs(s[i] - s[j]) > hats[6, j] else near
    for j, sign, inner in ((0, 1.0, 1), (n - 1, -1.0, n - 2)):
        r = s[i] - s[j]
        if not abs(r) > hats[6, j]:
            end = r * log(abs(r) + 1e-300) - r
            row[j] = (twice[inner] - twice[j]) * (hats[7, j] + hats[8, j]) + sign * end


@kernel(**KERNEL)
def log_kernel(s):
    """Matrix K[i, j] = integral of ln|s_i - t| phi_j(t) dt, phi_j the hat function of node j."""
    n = s.size
    k, twice, hats = np.empty((n, n)), np.empty(n), np.empty((9, n))
    _hat_functions(s, hats)
    for i in range(n):
        _kernel_row(s, i, hats, twice, k[i])
    return k


@njit(**FAST_INTERNAL_KERNEL)
def _density(terms, x):
    """Sum of the Lorentzians of a mesh."""
    total = 0.0
    for k in range(terms.shape[1]):
        away = x - terms[0, k]
        total += terms[2, k] * terms[1, k] / (terms[1, k] * terms[1, k] + away * away)
    return total


@njit(**INTERNAL_KERNEL)
def _place(terms, x):
    """Integral of `_density`, a sum of arctangents."""
    total = 0.0
    for k in range(terms.shape[1]):
        total += terms[2, k] * math.atan((x - terms[0, k]) / terms[1, k])
    return total


@kernel(**KERNEL)
def graded_points(terms, x_in, x_exit, x):
    """Fill ``x`` with points from x_in to x_exit that are uniform in the integral of the density.

    From point to point by the Runge-Kutta method for dx/dF = 1/density, corrected by Newton's method for F.
    """
    n = x.size
    first = _place(terms, x_in)
    step = (_place(terms, x_exit) - first) / (n - 1)
    x[0], x[n - 1] = x_in, x_exit
    for i in range(1, n - 1):
        # one place for each long function: put in at several, they would take twice as long to compile
        here, moved, total, slope = x[i - 1], 0.0, 0.0, 0.0
        for stage in range(4):
            moved = 0.5 * step * slope if stage < 3 else step * slope
            slope = 1.0 / _density(terms, min(here + moved, x_exit))
            total += (1.0 if stage == 0 or stage == 3 else 2.0) * slope
        here = min(here + step * total / 6.0, x_exit)
        for _ in range(50):
            miss = _place(terms, here) - first - i * step
            here = min(max(here - miss / _density(terms, here), x[i - 1]), x_exit)
            if abs(miss) < 1e-5:  # quadratic convergence
                break
        x[i] = here


@kernel(**KERNEL)
def sharpest(x, pressure, least, start, stop):
    """Place and length of the largest curvature of the pressure over itself between two points; length 0 for none."""
    place, shortest = 0.0, math.inf
    for i in range(1, x.size - 1):
        if not start < x[i] < stop:
            continue
        right, left = x[i + 1] - x[i], x[i] - x[i - 1]
        bend = abs((pressure[i + 1] - pressure[i]) / right - (pressure[i] - pressure[i - 1]) / left)
        length = max(pressure[i], least) * 0.5 * (left + right) / max(bend, 1e-12)
        if length < shortest:
            place, shortest = x[i], length
    return place, math.sqrt(shortest) if shortest < math.inf else 0.0


@njit(**INTERNAL_KERNEL)
def _mobility(log_eta, h, gamma, first, second):
    """Film mobility f = S-factor/eta with its derivatives in ln(eta) and h, and the mobilities f consists of.

    ``first`` times that along the sliding vector, cosh(S)/eta = hypot(1/eta, gamma/h), and ``second`` times that across
    it, sinh(S)/(S eta) = (gamma/h)/S.
    """
    fluidity = math.exp(-log_eta)
    if gamma == 0.0:
        f = (first + second) * fluidity
        return f, -f, 0.0, fluidity, fluidity
    rate = gamma / h
    along = math.sqrt(fluidity * fluidity + rate * rate)
    s = rate / fluidity
    f = first * along
    f_eta = -first * fluidity * fluidity / along
    f_h = -first * rate * rate / (along * h)
    across = 0.0
    if second != 0.0:
        if s < 1e-2:
            s2 = s * s
            ratio = 1.0 + s2 * (1.0 / 6.0 - s2 * 17.0 / 360.0)
            slope = s2 * (1.0 / 3.0 - s2 * 17.0 / 90.0)  # d ratio / d ln s
        else:
            angle = math.asinh(s) if s < 1e100 else math.log(2.0) + math.log(s)
            ratio = s / angle
            slope = ratio * (1.0 - ratio * fluidity / along)
        across = fluidity * ratio
        f += second * across
        f_eta += second * fluidity * (slope - ratio)
        f_h -= second * fluidity * slope / h
    return f, f_eta, f_h, along, across


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
def nodal_state(groups, p, h, offset, first, second, e):
    """Density, ln(eta/eta0), mobility and their slopes at the nodes: rows RHO to ACROSS of ``e``.

    ln(eta/eta0) of the table is multiplied by the stiffness and raised by ``offset``. The mobility is the sum of those
    along and across the sliding with the weights ``first`` and ``second``.
    """
    gamma = groups.gamma
    shear = groups.shear
    short = shear.plain or gamma == 0.0 or (shear.kind == EYRING and not shear.smooth)
    for i in range(p.size):
        value, slope, e[RHO, i], e[RHO_P, i] = inlet_laws(p[i], groups.table)
        value *= groups.stiffness
        slope *= groups.stiffness
        if value > LOG_VISCOSITY_CAP:
            value = LOG_VISCOSITY_CAP
            slope = 0.0
        value += offset[i]
        e[LOG_ETA, i] = value
        if short:
            # f depends on gamma/(h scale): a change of the stress scale acts like one of the film
            scale, scale_p = stress_scale(p[i], shear)
            e[F, i], e[F_X, i], e[F_H, i], e[ALONG, i], e[ACROSS, i] = _mobility(
                value, h[i], gamma / scale, first[i], second[i]
            )
            e[F_P, i] = e[F_X, i] * slope + e[F_H, i] * h[i] * scale_p
        else:
            for row in (F, F_H, F_X, F_P, ALONG, ACROSS):
                e[row, i] = 0.0
            for across in range(2):
                weight = second[i] if across else first[i]
                if weight == 0.0:
                    continue
                log_f, by_eta, by_film, by_pressure = log_mobility(value, gamma, h[i], p[i], 1.0 - across, shear)
                one = math.exp(log_f)
                f = weight * one
                e[ACROSS if across else ALONG, i] = one
                e[F, i] += f
                e[F_H, i] += f * by_film / h[i]
                e[F_X, i] += f * by_eta
                e[F_P, i] += f * (by_eta * slope + by_pressure)


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
    for onward in range(1, -2, -2):
        first = 0 if onward > 0 else n - 1
        second, third = first + onward, first + 2 * onward
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
def moved_pressure(x, pressure, nodes, x_in, stretch):
    """Pressure interpolated to other reference nodes, that of the open inlet upstream of the first one."""
    places = _places(nodes, x_in, stretch)
    values, _ = monotone_cubic(x, pressure, places)
    for i in range(places.size):
        if places[i] < x[0]:
            ratio = x[0] / places[i]
            values[i] *= ratio * ratio * ratio
    return values


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
def _places(points, x_in, stretch):
    """Places of reference points on the mesh."""
    x = np.empty(points.size)
    for i in range(points.size):
        x[i] = x_in + stretch * (points[i] - x_in)
    return x


@kernel(**KERNEL)
def residual(mesh, lam, u, e, out):
    """Rows of the first integral eps P' = rho H - Q on the faces, and rho H = Q at the exit.

    The mass content less the open inlet is carried to the faces by the third-order upwind rule in index space.
    Returns False where a face film is not positive.
    """
    n = mesh.nodes.size
    p, flow = u[:n], u[n + 1]
    x, h, rho, f = e[X], e[FILM], e[RHO], e[F]
    good = True
    base, _ = open_inlet(x, mesh.size)
    base_face, _ = open_inlet(_places(mesh.faces, mesh.x_in, u[n + 2]), mesh.size)
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
def jacobian(mesh, lam, u, e, jac, scale):
    """Matrix of the Newton system; unknowns P[1..n-2], H00, Q, stretch; rows: faces, exit, load.

    Rows are divided by ``scale`` (filled here) so that the pivots of the inlet do not swamp those of the contact.
    """
    n = mesh.nodes.size
    p, flow, stretch = u[:n], u[n + 1], u[n + 2]
    x, h, rho, rho_p = e[X], e[FILM], e[RHO], e[RHO_P]
    f, f_p, f_h = e[F], e[F_P], e[F_H]
    kernel = mesh.matrix
    x_in = mesh.x_in
    h_a, f_x = np.empty(n), np.empty(n)
    for i in range(n):
        lever = (x[i] - x_in) / stretch
        h_a[i] = x[i] * lever - e[KERNEL_PRESSURE, i] / math.pi
        f_x[i] = e[F_X, i] * lever
    x_face = _places(mesh.faces, x_in, stretch)
    for i in range(n + 1):
        for j in range(n + 1):
            jac[i, j] = 0.0
    base, base_x = open_inlet(x, mesh.size)
    base_face, base_face_x = open_inlet(x_face, mesh.size)
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
        load += mesh.weights[j] * p[j]
    for j in range(1, n - 1):
        jac[n, j - 1] = stretch * mesh.weights[j]
    jac[n, n] = load
    scale[n] = 1.0


@njit(**INTERNAL_KERNEL)
def _correction(factors, pivots, scale, residual, out):
    """Newton correction of a residual whose rows are scaled."""
    for i in range(residual.size):
        out[i] = -scale[i] * residual[i]
    solve_factored(factors, pivots, out)


@njit(**INTERNAL_KERNEL)
def _length(step, u):
    """Scaled size of a correction: pressure by p_h, flow and film constant by the film, stretch by itself."""
    n = step.size - 1
    flow = max(u[n + 1], 1e-300)
    size = 0.0
    for i in range(n - 2):
        size += step[i] * step[i]
    level, rate = step[n - 2] / (1.0 + flow), step[n - 1] / flow
    return math.sqrt(size / max(n - 2, 1) + level * level + rate * rate + step[n] * step[n])


@njit(**INTERNAL_KERNEL)
def _moved(u, step, factor, out):
    """Unknowns a part of a correction further."""
    n = u.size - 3
    out[0] = u[0]
    for i in range(1, n - 1):
        out[i] = u[i] + factor * step[i - 1]
    out[n - 1] = u[n - 1]
    for i in range(3):
        out[n + i] = u[n + i] + factor * step[n - 2 + i]


@njit(**INTERNAL_KERNEL)
def _keep(u, e, out, kept_u, kept_e, kept_out):
    """Copy unknowns, state and residual."""
    for i in range(u.size):
        kept_u[i] = u[i]
    for i in range(out.size):
        kept_out[i] = out[i]
    for row in range(ROWS):
        for i in range(e.shape[1]):
            kept_e[row, i] = e[row, i]


@kernel(**KERNEL)
def evaluate(mesh, groups, upstream, u, e, out):
    """State at the nodes, and residual, of the unknowns: pressure, film constant, flow and stretch in a row.

    ``upstream`` is the load ahead of the mesh. Returns False outside the domain: film, flow or stretch not positive.
    """
    n = mesh.nodes.size
    p, h00, flow, stretch = u[:n], u[n], u[n + 1], u[n + 2]
    if not (flow > 0.0 and 0.05 < stretch < 20.0 and math.isfinite(h00)):
        return False
    x, h = e[X], e[FILM]
    product(mesh.matrix, p, e[KERNEL_PRESSURE])
    for i in range(n):
        x[i] = mesh.x_in + stretch * (mesh.nodes[i] - mesh.x_in)
        h[i] = h00 + 0.5 * x[i] * x[i] - stretch / math.pi * e[KERNEL_PRESSURE, i]
        if not h[i] > 0.0:
            return False
    heat, slopes = np.zeros((3, n)), np.zeros((3, n))
    for row in range(3 if groups.offset.size > 0 else 0):
        values, by_x = monotone_cubic(groups.offset_x, groups.offset[row], x)
        heat[row], slopes[row] = values, by_x
    # weights of the mobilities along and across the sliding (`ehl.heat._kernels.along_share`), and their slopes in x
    first, second, first_slope, second_slope = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    cross = groups.cross
    for i in range(n):
        along, across = math.exp(heat[1, i]), math.exp(heat[2, i])
        first[i], second[i] = cross * along, cross * (along - across) + (1.0 - cross) * across
        along, across = along * slopes[1, i], across * slopes[2, i]
        first_slope[i], second_slope[i] = cross * along, cross * (along - across) + (1.0 - cross) * across
    nodal_state(groups, p, h, heat[0], first, second, e)
    load = 0.0
    for i in range(n):
        e[F_X, i] = e[F_X, i] * slopes[0, i] + first_slope[i] * e[ALONG, i] + second_slope[i] * e[ACROSS, i]
        load += mesh.weights[i] * p[i]
        if not e[RHO, i] > 0.0:
            return False
    if not residual(mesh, groups.lam, u, e, out):
        return False
    out[n] = stretch * load + upstream - HALF_PI
    finite = True
    for i in range(n + 1):
        finite = finite and math.isfinite(out[i])
    return finite


@kernel(**KERNEL)
def tail(x_in, groups):
    """Pressure at the first node and load upstream of it: dP/dx = 4 lam eta/x^4 of the open parabolic inlet."""
    lam, distance = groups.lam, abs(x_in)
    if groups.offset.size > 0:
        lam *= math.exp(monotone_cubic(groups.offset_x, groups.offset[0], np.array([x_in]))[0][0])
    return 4.0 * lam / (3.0 * distance * distance * distance), 2.0 * lam / (3.0 * distance * distance)


@kernel(**KERNEL)
def newton(mesh, groups, u, tolerance, most, state, left_over, matrix, scale, pivots, given):
    """Newton's method on one mesh, damped by the natural monotonicity test (Deuflhard 2004).

    A matrix that still shortens the correction to a quarter is kept, the one ``given`` too. Unknowns, state and
    residual are left in ``u``, ``state`` and ``left_over``; returns what became of it and the number of matrices.
    """
    n = mesh.nodes.size
    ahead, upstream = tail(mesh.x_in, groups)
    step, trial = np.empty(n + 1), np.empty(n + 3)
    e, out = np.empty((ROWS, n)), np.empty(n + 1)
    for i in range(n + 3):
        trial[i] = u[i]
    trial[0], trial[n - 1] = ahead, 0.0
    lift, factor, length, left = 0.5, 1.0, 0.0, math.inf
    iteration, tried, kept, last = 0, False, False, False
    # one place for each long function: put in at several, they would take twice as long to compile
    while True:
        good = evaluate(mesh, groups, upstream, trial, e, out)
        if not (tried or good):
            # pressure from another mesh may close a thin film
            if lift > 16.0:
                return INFEASIBLE, 0
            trial[n] += lift * trial[n + 1]
            lift *= 2.0
            continue
        if tried:
            correction = np.empty(n + 1)
            if good and not last:
                _correction(matrix, pivots, scale, out, correction)
                left = _length(correction, trial)
                good = left < tolerance or left <= (KEPT_MATRIX if kept else 1.0 - 0.25 * factor) * length
            if not (good or kept):
                factor *= 0.4
                if factor < LEAST_FACTOR:
                    return EXHAUSTED, iteration
                _moved(u, step, factor, trial)
                continue
            step = correction
        if good:
            _keep(trial, e, out, u, state, left_over)
        if last:
            return CONVERGED, iteration
        last = good and factor == 1.0 and left < tolerance
        kept = last or (good and tried and factor == 1.0 and left < KEPT_MATRIX * length)
        length = left
        if not kept:
            kept = given and not tried
            if not kept:
                iteration += 1
                if iteration > most:
                    return LIMIT, most
                jacobian(mesh, groups.lam, u, state, matrix, scale)
                if not factored(matrix, pivots):
                    return SINGULAR, iteration
            tried = True
            _correction(matrix, pivots, scale, left_over, step)
            length = _length(step, u)
            if not (kept or length < 1e6):
                return SINGULAR, iteration
            factor = min(1.0, 4.0 * factor)
        _moved(u, step, factor, trial)


@kernel(**KERNEL)
def peak(y, sign):
    """Maximum of sign y, of the quartic through the five nodes around the largest value (mesh index as coordinate)."""
    k = 0
    for i in range(y.size):
        if sign * y[i] > sign * y[k]:
            k = i
    if k < 2 or k > y.size - 3:
        return sign * y[k]
    a, b, c, d, e = sign * y[k - 2], sign * y[k - 1], sign * y[k], sign * y[k + 1], sign * y[k + 2]
    first = (a - 8.0 * b + 8.0 * d - e) / 12.0
    second = (-a + 16.0 * b - 30.0 * c + 16.0 * d - e) / 24.0
    third = (-a + 2.0 * b - 2.0 * d + e) / 12.0
    fourth = (a - 4.0 * b + 6.0 * c - 4.0 * d + e) / 24.0
    t = 0.0
    for _ in range(8):
        slope = first + t * (2.0 * second + t * (3.0 * third + 4.0 * fourth * t))
        curvature = 2.0 * second + t * (6.0 * third + 12.0 * fourth * t)
        if curvature >= 0.0:
            break
        t = min(max(t - slope / curvature, -1.0), 1.0)
    return max(c + t * (first + t * (second + t * (third + fourth * t))), c)


@kernel(**KERNEL)
def at_centre(x, y):
    """Six-point Lagrange value at x = 0: between the nodes no lower order may show."""
    first = 0
    while first < x.size and x[first] < 0.0:
        first += 1
    first = min(max(first - 3, 0), x.size - 6)
    total = 0.0
    for i in range(6):
        share = y[first + i]
        for j in range(6):
            if j != i:
                share *= x[first + j] / (x[first + j] - x[first + i])
        total += share
    return total


@njit(**INTERNAL_KERNEL)
def _stress(log_eta, film, p, rate, law, ambient, slope):
    """Shear stress at a node, cut off at ``ambient + slope p``, and by how much the law exceeds this limit."""
    if not rate > 0.0:
        return 0.0, 0.0
    positive = max(p, 0.0)
    log_stress, _, _ = limited_stress(math.log(rate) + log_eta - math.log(film), positive, law)
    stress = math.exp(min(log_stress, LOG_VISCOSITY_CAP))
    if not math.isfinite(slope):
        return stress, 0.0
    limit = ambient + slope * positive
    return min(stress, limit), stress - limit


@kernel(**KERNEL)
def stresses(p, film, log_eta, rate, law, ambient, slope):
    """Shear stress at the nodes."""
    found = np.empty(p.size)
    for i in range(p.size):
        found[i], _ = _stress(log_eta[i], film[i], p[i], rate, law, ambient, slope)
    return found


@kernel(**KERNEL)
def outputs(x, p, film, log_eta, flow, lam, far, rate, law, ambient, slope):
    """Central and minimum film, friction, maximum pressure, flow, exit and rolling traction.

    Parameters: state at the nodes; where the integrals of the shear begin upstream of the mesh; eta0 |v_s| R/(p_h b^2);
    the shear law and the limit ``ambient + slope p`` that cuts its stress off (slope infinite: none), in p_h.
    """
    # Integrals of 1/H and of (1 - Q/H)/H from there to the first node, H a parabola: with v = 1/|x| both integrands are
    # nearly constant, so Simpson's rule is exact to far below the grid error
    near, end = 1.0 / abs(x[0]), 1.0 / abs(far)
    shear_length = 0.0
    flow_length = 0.0
    for k in range(3):
        v = near + 0.5 * k * (end - near)
        h = film[0] + 0.5 * (1.0 / (v * v) - x[0] * x[0])
        part = (4.0 if k == 1 else 1.0) * (near - end) / 6.0 / (v * v * h)
        shear_length += part
        flow_length += part * (1.0 - flow / h)
    viscosity = math.exp(log_eta[0])
    rolling = 2.0 * lam * viscosity * flow_length
    shear = 0.0
    stress_before = 0.0
    excess_before = 0.0
    for i in range(x.size):
        stress, excess = _stress(log_eta[i], film[i], p[i], rate, law, ambient, slope)
        if i > 0:
            rolling += (film[i] + film[i - 1]) * (p[i] - p[i - 1])
            shear += 0.5 * (stress + stress_before) * (x[i] - x[i - 1])
            if (excess > 0.0) != (excess_before > 0.0):
                # the lower of two straight lines, exactly: where they cross it exceeds the chord of its end values.
                # Never the difference of both integrals: a stiff oil's free stress is many orders above the limit
                one, other = abs(excess_before), abs(excess)
                shear += 0.5 * one * (other / (one + other)) * (x[i] - x[i - 1])
        stress_before = stress
        excess_before = excess
    # shear is far below the stress scale in the open inlet: linear in the rate
    shear += rate * viscosity * shear_length
    return (
        at_centre(x, film),
        -peak(film, -1.0),
        2.0 / math.pi * shear,
        peak(p, 1.0),
        flow,
        x[x.size - 1],
        rolling / (2.0 * math.pi),
    )
