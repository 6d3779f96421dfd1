"""Rough line contacts with two-dimensional roughness: an independent transient reference solution.

    python validation/rough_2d.py campaign --out validation/out/rough_2d.csv
    python validation/rough_2d.py case --rms 0.6 --length 40 --gamma 1 --speed 3 --seed 1

Nothing of `ehl.rough` enters the solution; its own numbers are those of `Case`. The contact is periodic along y.

Reynolds equation, along the mean motion u = (u1 + u2)/2 and with conserved mass m = rho h (rho relative):

    Dm/Dt = d/dx( f_x dp/dx ) + d/dy( f_y dp/dy ),    0 <= p,  m <= rho h,  p (rho h - m) = 0      (JFO)
    f_x = rho h^3/(12 eta) cosh(a),   f_y = rho h^3/(12 eta) sinh(a)/a,   a = asinh(eta |u1 - u2|/(tau0 h))

(Ehret, Dowson & Taylor 1998; Jakobsson, Floberg & Olsson). The time step is dx/u; Dm/Dt is of
second order along the mean motion (BDF2 with m(i), m_old(i - 1) and m_older(i - 2)), of first order where m changes by
more than half.

Elasticity: h = h0 + x^2/(2 R) - s1(x - u1 t, y) - s2(x - u2 t, y) + V. The mean over y of V comes from
-4/(pi E') ln|x|, its harmonics along y from 4/(pi E') K0(k_y |x|) (Johnson 1985), both integrated exactly over a node
along x; FFT in both directions, no periodic images along x. Contact: pc >= 0 complementary to h >= h_boundary; the film
of a contact is h_boundary and its p follows the same Reynolds equation. p + pc may be limited by a hardness.
The load is balanced at every step. Roelands viscosity, Dowson-Higginson density, isothermal, no limiting shear stress.

Each step is a semi-smooth Newton method on p, pc and h0, with relaxed fluidity in turn where it stalls, and at last
with the fluidity of the prediction. Its linear systems are solved by GMRES with the exact
derivatives of both integrals. The preconditioner solves for the mean over y, then for the local part (storage, pressure
flow, elasticity of the node itself) by a block elimination along x.

Definitions: rms is the composite Rq, each surface has rms/sqrt(2). length is l_x of the autocorrelation
exp(-(x/l_x)^2 - (y/(gamma l_x))^2) of each surface. film is the mean over |x| < 0.8 b. share is the load of pc. mu is
the mean film shear tau0 asinh(eta |u1 - u2|/(tau0 h)) plus mu_b pc over the load. The surfaces of a seed are the same
arrays for all rms, length and gamma at equal nodes per l_x. Errors are standard errors of batch means of one run.

unconverged is the share of the averaged steps whose largest residual exceeds 5 nm. One surface pair of six cells
scatters by 15 to 35 % in share. Comparison with the solver and an independent program: docs/roughness.md.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import scipy.fft as fourier
from common import OUT, command_line
from numba import njit
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve
from scipy.special import iti0k0

Array = NDArray[Any]  # float64; float32 inside of the linear systems

GPA, NM = 1e9, 1e-9  # units of the solver: pressure [GPa], film [nm]
ROELANDS_PRESSURE = 1.96e8
BEGIN, END = -2.5, 1.25  # ends of the mesh [b]
FRONT, ENTRY = -1.2, 0.5  # the roughness enters with its surface: its first front, its rise to full height [b]
SETTLED = 3.7  # travel before averages start: the slower surface has passed the contact [b]
BATCH = 0.5  # [b]
FULL, CAVITATED, ENDS = 0, 1, 2
FREE, TOUCHING, YIELDING = 0, 1, 2
NEWTON, PICARD, FROZEN = 0, 1, 2
TIGHT = 0.02  # hysteresis of the sets [nm]


@dataclass(frozen=True)
class Case:
    """One contact; SI units, lengths of roughness too."""

    rms: float
    length: float
    gamma: float
    speed: float
    seed: int = 1
    nodes: int = 12
    window: float = 3.0
    cells: int = 6
    pressure_hertz: float = 1.1e9
    radius: float = 0.015
    modulus: float = 228e9
    slide_to_roll: float = 0.3
    viscosity: float = 0.015
    alpha: float = 15e-9
    eyring_stress: float = 5e6
    boundary_friction: float = 0.1
    boundary_film: float = 30e-9
    hardness: float = math.inf

    @property
    def half_width(self) -> float:
        """b [m]."""
        return 4.0 * self.radius * self.pressure_hertz / self.modulus

    @property
    def spacing(self) -> float:
        """dx [m]."""
        return self.length / self.nodes

    @property
    def sliding(self) -> float:
        """abs(u1 - u2) [m/s]."""
        return abs(self.slide_to_roll) * self.speed

    @property
    def oil(self) -> tuple[float, float, float, float]:
        """eta0, A and z of Roelands, sliding speed over tau0 [m/Pa/s]."""
        height = math.log(self.viscosity) + 9.67
        return self.viscosity, height, self.alpha * ROELANDS_PRESSURE / height, self.sliding / self.eyring_stress


@njit(cache=True, error_model="numpy")
def density(p: float) -> tuple[float, float]:
    """Relative density and its derivative [1/GPa] (Dowson & Higginson)."""
    below = 1.0 + 1.7 * p
    return 1.0 + 0.6 * p / below, 0.6 / (below * below)


@njit(cache=True, error_model="numpy")
def fluidity(p: float, h: float, oil: tuple[float, float, float, float], along: bool) -> tuple[float, float, float]:
    """f/rho [m3/(Pa s)] and its logarithmic derivatives by p [1/GPa] and h [1/nm]; across (x) or along (y) the line."""
    eta0, height, z, sliding = oil
    base = 1.0 + max(p, 0.0) * GPA / ROELANDS_PRESSURE
    growth = base**z
    slope = height * z * growth / base / ROELANDS_PRESSURE * GPA
    thin = math.exp(-height * (growth - 1.0)) / eta0
    film = h * NM
    rate = sliding / film
    strain = rate / thin
    root = math.sqrt(1.0 + strain * strain)
    cube = film * film * film / 12.0
    if not along:
        return cube * thin * root, -slope / (root * root), (3.0 - strain * strain / (root * root)) / h
    if strain < 1e-4:
        return cube * thin, -slope, 3.0 / h
    a = math.log(strain + root)
    turn = strain / root / a
    return cube * rate / a, -slope * turn, (2.0 + turn) / h


@njit(cache=True, error_model="numpy")
def faces(p: Array, h: Array, oil: tuple[float, float, float, float], scale_x: float, scale_y: float) -> Array:
    """Flow per pressure difference [nm/GPa] through the face to the next node along x and along y, (2, 4, nx, ny).

    Then its derivatives by the p of both nodes and by both ln h. The pressures of both nodes enter by their mean
    fluidity, so that the flow rises with their difference however steep it is; the films by their geometric mean, the
    exact resistance of a linear gap where f grows with h^2 (Eyring) and nearly that where it grows with h^3.
    """
    nx, ny = p.shape
    node = np.zeros((2, 3, nx, ny))
    for i in range(nx):
        for j in range(ny):
            rho, rho_p = density(max(p[i, j], 0.0))
            for s in range(2):
                f, by_p, by_h = fluidity(p[i, j], h[i, j], oil, s == 1)
                node[s, 0, i, j] = f * 0.5 * (scale_y if s else scale_x) * rho
                node[s, 1, i, j] = by_p + rho_p / rho
                node[s, 2, i, j] = 0.5 * by_h * h[i, j]
    out = np.zeros((2, 4, nx, ny))
    for i in range(nx):
        for j in range(ny):
            for s in range(2):
                if s == 0 and i + 1 == nx:
                    continue
                m, k = (i + 1, j) if s == 0 else (i, j + 1 if j + 1 < ny else 0)
                ratio = math.log(h[m, k] / h[i, j])
                mine = node[s, 0, i, j] * math.exp(ratio * node[s, 2, i, j])
                its = node[s, 0, m, k] * math.exp(-ratio * node[s, 2, m, k])
                out[s, 0, i, j] = mine + its
                out[s, 1, i, j] = mine * node[s, 1, i, j]
                out[s, 2, i, j] = its * node[s, 1, m, k]
                out[s, 3, i, j] = mine * node[s, 2, i, j] + its * node[s, 2, m, k]
    return out


@njit(cache=True, error_model="numpy")
def outflow(p: Array, face: Array) -> Array:
    """Net pressure flow out of every node in a time step [nm]."""
    nx, ny = p.shape
    out = np.zeros((nx, ny))
    for i in range(nx):
        for j in range(ny):
            if i + 1 < nx:
                flow = face[0, 0, i, j] * (p[i, j] - p[i + 1, j])
                out[i, j] += flow
                out[i + 1, j] -= flow
            k = j + 1 if j + 1 < ny else 0
            flow = face[1, 0, i, j] * (p[i, j] - p[i, k])
            out[i, j] += flow
            out[i, k] -= flow
    return out


@njit(cache=True, error_model="numpy")
def linear_rows(dp: Array, dh: Array, p: Array, h: Array, face: Array, fluid: Array, weight: Array) -> Array:
    """Derivative of the mass balance of every node; rows of cavitated nodes and ends are dp."""
    nx, ny = p.shape
    out = np.zeros((nx, ny), dtype=np.float32)
    relative = dh / h
    for i in range(nx):
        for j in range(ny):
            for s in range(2):
                if s == 0 and i + 1 == nx:
                    continue
                m, k = (i + 1, j) if s == 0 else (i, j + 1 if j + 1 < ny else 0)
                flow = face[s, 1, i, j] * dp[i, j] + face[s, 2, i, j] * dp[m, k]
                flow += face[s, 3, i, j] * (relative[i, j] + relative[m, k])
                flow = face[s, 0, i, j] * (dp[i, j] - dp[m, k]) + flow * (p[i, j] - p[m, k])
                out[i, j] += flow
                out[m, k] -= flow
    for i in range(nx):
        for j in range(ny):
            if fluid[i, j] != FULL:
                out[i, j] = dp[i, j]
            else:
                below = 1.0 + 1.7 * p[i, j]
                out[i, j] *= weight[i, j]
                out[i, j] += (1.0 + 0.6 * p[i, j] / below) * dh[i, j] + 0.6 / (below * below) * h[i, j] * dp[i, j]
    return out


@njit(cache=True, error_model="numpy")
def factorise(
    first: int,
    p: Array,
    h: Array,
    face: Array,
    fluid: Array,
    contact: Array,
    weight: Array,
    own: float,
    inverse: Array,
    link: Array,
    scale: Array,
) -> None:
    """Inverses of the block elimination along x of the local part from plane first on.

    own is the compliance of a node [nm/GPa].
    """
    nx, ny = p.shape
    block = np.empty((ny, ny), dtype=np.float32)
    for i in range(first, nx):
        block[:] = 0.0
        for j in range(ny):
            link[0, i, j] = link[1, i, j] = 0.0
            scale[i, j] = own
            if fluid[i, j] != FULL:
                block[j, j] = 1.0
                continue
            rho, rho_p = density(p[i, j])
            mine = own if contact[i, j] == FREE else 0.0
            block[j, j] += rho_p * h[i, j] + rho * mine
            size = rho_p * h[i, j] + rho * own
            for side in range(4):
                if side < 2:
                    m, k, s = i + 1 - 2 * side, j, 0
                else:
                    m, k, s = i, (j + 5 - 2 * side + ny) % ny, 1
                a, b = (i, j) if side % 2 == 0 else (m, k)  # the node that holds the face
                drop = p[i, j] - p[m, k]  # outflow towards (m, k)
                its = own if contact[m, k] == FREE else 0.0
                w = weight[i, j]
                flow, by_h = w * face[s, 0, a, b], w * face[s, 3, a, b]
                by_mine, by_its = w * face[s, 1 + side % 2, a, b], w * face[s, 2 - side % 2, a, b]
                size += flow
                block[j, j] += flow + drop * (by_mine + by_h / h[i, j] * mine)
                other = drop * (by_its + by_h / h[m, k] * its) - flow
                if side == 0:
                    link[1, i, j] = other
                elif side == 1:
                    link[0, i, j] = other
                else:
                    block[j, k] += other
            scale[i, j] = own / size
        if i > 0:
            for j in range(ny):
                if link[0, i, j] != 0.0:
                    for k in range(ny):
                        block[j, k] -= link[0, i, j] * inverse[i - 1, j, k] * link[1, i - 1, k]
        inverse[i] = np.linalg.inv(block)


@njit(cache=True, error_model="numpy")
def eliminate(right: Array, inverse: Array, link: Array) -> Array:
    """Solution of the factorised local part."""
    nx, ny = right.shape
    out = np.zeros((nx, ny), dtype=np.float32)
    row = np.zeros(ny, dtype=np.float32)
    for i in range(nx):
        for j in range(ny):
            row[j] = right[i, j] - (link[0, i, j] * out[i - 1, j] if i > 0 else 0.0)
        out[i] = np.dot(inverse[i], row)
    for i in range(nx - 2, -1, -1):
        for j in range(ny):
            row[j] = link[1, i, j] * out[i + 1, j]
        out[i] -= np.dot(inverse[i], row)
    return out


class Elasticity:
    """Deflection [nm] of a pressure [GPa], (nx, ny); mean over y by the logarithm, harmonics by K0.

    The integrals over a node are exact along x: of ln|x|: x ln|x| - x; of K0: `scipy.special.iti0k0`.
    """

    def __init__(self, nx: int, ny: int, dx: float, dy: float, modulus: float) -> None:
        factor = 4.0 / (math.pi * modulus) * GPA / NM
        edge = (np.arange(-nx, nx + 1) - 0.5) * dx
        kernel = np.zeros((2 * nx, ny // 2 + 1))
        kernel[:, 0] = -np.diff(edge * np.log(np.abs(edge)) - edge)
        for n in range(1, ny // 2 + 1):
            wave = 2.0 * math.pi * n / (ny * dy)
            argument = wave * edge
            whole = iti0k0(np.minimum(np.abs(argument), 80.0))[1]
            kernel[:, n] = np.diff(np.sign(argument) * whole) / wave
        self.table = factor * np.roll(kernel, -nx, axis=0)  # lag 0 first
        weight = np.full(ny // 2 + 1, 2.0)
        weight[0] = 1.0
        if ny % 2 == 0:
            weight[-1] = 1.0
        self.own = float(self.table[0, 1:] @ weight[1:] + factor * dx) / ny  # of the node, without the log's far part
        self.symbol = fourier.fft(self.table, axis=0)
        self.short = self.symbol.astype(np.complex64)
        self.nx, self.ny = nx, ny

    def __call__(self, pressure: Array) -> Array:
        """Deflection [nm]."""
        waves = fourier.fft(fourier.rfft(pressure, axis=1), n=2 * self.nx, axis=0)
        waves *= self.symbol if pressure.dtype == np.float64 else self.short
        return np.asarray(fourier.irfft(fourier.ifft(waves, axis=0)[: self.nx], n=self.ny, axis=1))

    def mean_matrix(self) -> Array:
        """Deflection of the mean over y (nx, nx)."""
        lag = np.arange(self.nx)
        return self.table[(lag[:, None] - lag[None, :]) % (2 * self.nx), 0]


REFINED = 20  # positions of the surfaces per node


class Surface:
    """A periodic Gaussian surface [nm] along x, on twenty positions per node; moves by a multiple of a position."""

    def __init__(self, case: Case, ny: int, index: int) -> None:
        count = fourier.next_fast_len(round(14.0 * case.half_width / case.spacing))
        rng = np.random.default_rng([case.seed, index])
        kx = 2.0 * math.pi * np.fft.fftfreq(count) * case.nodes  # times l_x
        ky = 2.0 * math.pi * np.fft.rfftfreq(ny) * case.nodes  # times gamma l_x
        spectrum = np.fft.rfft2(rng.standard_normal((count, ny)))
        spectrum *= np.exp(-(kx[:, None] ** 2 + ky[None, :] ** 2) / 8.0)
        spectrum[0, 0] = 0.0
        heights = np.fft.irfft2(spectrum, s=(count, ny))
        self.count, self.ny = count, ny
        heights *= case.rms / math.sqrt(2.0) / NM / heights.std()
        self.heights = np.stack([self._shifted(heights, part / REFINED) for part in range(REFINED)])

    def _shifted(self, heights: Array, part: float) -> Array:
        wave = 2.0 * math.pi * np.fft.rfftfreq(self.count)[:, None]
        return np.asarray(np.fft.irfft(np.fft.rfft(heights, axis=0) * np.exp(1j * wave * part), n=self.count, axis=0))

    def at(self, nx: int, moved: int) -> Array:
        """Heights on the mesh after a way of positions."""
        nodes, part = divmod(-moved, REFINED)
        return self.heights[part][(np.arange(nx) + nodes) % self.count]


class Run:
    """State of one transient solution; `step` advances it by dx."""

    def __init__(self, case: Case) -> None:
        self.case = case
        dx, b = case.spacing, case.half_width
        nx = round((END - BEGIN) * b / dx)
        while fourier.next_fast_len(2 * nx, True) != 2 * nx:
            nx += 1
        ny = int(case.cells * case.nodes)
        self.x = BEGIN * b + dx * np.arange(nx)
        dt = dx / case.speed
        self.scales = dt / dx**2 * GPA / NM, dt / (case.gamma * dx) ** 2 * GPA / NM
        self.elastic = Elasticity(nx, ny, dx, case.gamma * dx, case.modulus)
        self.mean_elastic = self.elastic.mean_matrix()
        way = round(REFINED * 0.5 * case.slide_to_roll)
        if abs(way - REFINED * 0.5 * case.slide_to_roll) > 1e-9:
            raise ValueError("slide_to_roll must be a multiple of 0.1")
        self.ways = REFINED + way, REFINED - way
        self.surfaces = [Surface(case, ny, index) for index in (0, 1)] if case.rms > 0.0 else []
        self.load = math.pi / 2.0 * case.pressure_hertz * b / dx * ny / GPA  # sum of p + pc
        hertz = case.pressure_hertz / GPA * np.sqrt(np.maximum(0.0, 1.0 - (self.x / b) ** 2))
        self.p = np.repeat(hertz[:, None], ny, axis=1) * (self.load / (hertz.sum() * ny))
        self.c = np.zeros((nx, ny))
        self.shape = np.repeat((self.x**2 / (2.0 * case.radius) / NM)[:, None], ny, axis=1)
        gap = self.shape + self.elastic(self.p)
        start = 0.985 * self.film_estimate() / NM
        self.h0 = start - float(gap[np.abs(self.x) < 0.5 * b].mean())
        self.h = np.maximum(self.h0 + gap, case.boundary_film / NM)
        self.fluid = np.where(self.p > 0.0, FULL, CAVITATED)
        self.fluid[self.x < 0.0] = FULL
        self.fluid[0] = self.fluid[-1] = ENDS
        self.contact = np.zeros((nx, ny), dtype=np.int64)
        rho = density_of(self.p)
        self.m = rho * np.where(self.x[:, None] > 0.5 * b, np.minimum(self.h, start), self.h)
        self.mean_p, self.m_old, self.weight = self.p.mean(axis=1), self.m, np.ones((nx, ny))
        self.inverse = np.zeros((nx, ny, ny), dtype=np.float32)
        self.link = np.zeros((2, nx, ny), dtype=np.float32)
        self.scale = np.ones((nx, ny), dtype=np.float32)
        self.upstream = int(np.searchsorted(self.x, -1.2 * b))  # before it the local part changes little in a step
        self.steps = 0

    def film_estimate(self) -> float:
        """Central film of a smooth line contact [m] (Dowson & Higginson 1977, minimum over 0.8)."""
        case = self.case
        speed = case.viscosity * case.speed / (case.modulus * case.radius)
        load = math.pi / 2.0 * case.pressure_hertz * case.half_width / (case.modulus * case.radius)
        return 3.0 * speed**0.69 * (case.alpha * case.modulus) ** 0.56 * load**-0.10 * case.radius

    @property
    def travel(self) -> float:
        """[b]."""
        return self.steps * self.case.spacing / self.case.half_width

    def step(self, tolerance: float = 0.4, most: int = 90, trace: list[Any] | None = None) -> tuple[int, int, float]:
        """Advance by dx; Newton iterations, GMRES iterations, largest remaining residual [nm]."""
        case = self.case
        nx, ny = self.p.shape
        self.steps += 1
        gap = self.shape
        if self.surfaces:
            for surface, way in zip(self.surfaces, self.ways, strict=True):
                front = FRONT + way / REFINED * self.travel - self.x / case.half_width  # [b] behind the front
                gap = gap - np.clip(front / ENTRY, 0.0, 1.0)[:, None] * surface.at(nx, way * self.steps)
        # second order in time along the mean motion (BDF2), of first order where the film begins to cavitate
        upstream, weight = np.empty((nx, ny)), np.ones((nx, ny))
        upstream[1:] = self.m[:-1]
        upstream[0] = self.h[0]
        value = (4.0 * self.m[1:-1] - self.m_old[:-2]) / 3.0
        even = (value > 0.5 * self.m[1:-1]) & (value < 1.5 * self.m[1:-1]) & (self.steps > 2)
        upstream[2:][even], weight[2:][even] = value[even], 2.0 / 3.0
        self.weight, self.m_old = weight, self.m
        # the fluctuations travel with the mean motion
        self.mean_p += 0.03 * (self.p.mean(axis=1) - self.mean_p)
        p, c = self.p.copy(), self.c.copy()
        p[1:] = self.mean_p[1:, None] + self.p[:-1] - self.mean_p[:-1, None]
        c[1:] = self.c[:-1]
        fluid, contact = self.fluid.copy(), self.contact.copy()
        contact[1:] = self.contact[:-1]
        # a full film too many vanishes in one iteration, one too few is filled node by node
        fluid[1:] = np.where(np.abs(self.x[1:, None]) < 0.9 * case.half_width, CAVITATED, fluid[1:])
        fluid[1:][self.fluid[:-1] == FULL] = FULL
        fluid[0] = fluid[-1] = ENDS
        contact[0] = contact[-1] = FREE
        c[contact == FREE] = 0.0
        h0 = self.h0
        boundary, hardness = case.boundary_film / NM, case.hardness / GPA
        inner, worst, best, best_at, turn_at = 0, math.inf, math.inf, 0, 0
        mode, used, factored = NEWTON, np.empty(0), np.empty(0)
        kept = self.x < 0.8 * case.half_width  # the mass balance further downstream has no effect
        p[fluid != FULL] = 0.0
        for iteration in range(most + 1):
            for attempt in range(2):
                elastic_gap = h0 + gap + self.elastic(p + c)
                h = np.where(contact == FREE, np.maximum(elastic_gap, 0.2 * boundary), boundary)
                present = faces(p, h, case.oil, *self.scales)
                if iteration == 0 and attempt == 0:
                    start = lagged = present[:, 0]
                if mode == NEWTON:
                    used = present
                elif attempt == 0:
                    used = np.zeros_like(present)
                    used[:, 0] = np.sqrt(lagged * present[:, 0]) if mode == PICARD else start
                lagged = used[:, 0]
                out = weight * outflow(p, used)
                rho = density_of(np.maximum(p, 0.0))
                if attempt == 1:
                    break
                # a node that leaves a set gives its share to the other: the sum, which bends the bodies, stays
                full, touching = fluid == FULL, contact == TOUCHING
                empty = full & (p <= 0.0)
                filled = (fluid == CAVITATED) & (upstream - out > rho * h + TIGHT)
                lifted = touching & (c <= 0.0)
                closed = (contact == FREE) & (fluid != ENDS) & (elastic_gap < boundary - TIGHT)
                over = (contact != FREE) & (p + c > hardness)
                loose = (contact == YIELDING) & (elastic_gap > boundary)
                fluid[empty], fluid[filled] = CAVITATED, FULL
                contact[lifted], contact[closed | loose], contact[over] = FREE, TOUCHING, YIELDING
                changes = int((empty | filled | lifted | closed | loose | over).sum())
                if not changes:
                    break
                c[empty & (contact != FREE)] += p[empty & (contact != FREE)]
                p[empty] = 0.0
                back = lifted & (fluid == FULL)
                p[back] = np.maximum(p[back] + c[back], 0.0)
                c[contact == FREE] = 0.0
                c[contact == YIELDING] = hardness - p[contact == YIELDING]
            full, touching = fluid == FULL, contact == TOUCHING
            residual = np.where(full, rho * h + out - upstream, p)
            missing = np.where(touching, elastic_gap - boundary, 0.0)
            lack = (p + c).sum() / self.load - 1.0
            worst = max(np.abs(residual / (1.0 + h / 300.0))[kept].max(), np.abs(missing).max(), 1e3 * abs(lack))
            if mode == PICARD and changes == 0 and worst < tolerance:
                mode = NEWTON  # the present fluidity decides
                continue
            if (worst < tolerance and changes == 0 and iteration > 0) or iteration == most:
                break
            if worst < 0.7 * best:
                best, best_at = worst, iteration
            elif mode == NEWTON and iteration - best_at >= 6:
                mode, turn_at = PICARD, iteration
            elif mode == PICARD and iteration - turn_at >= 12:
                mode, best, best_at = NEWTON, worst, iteration
            if mode != FROZEN and iteration > most - 30:
                mode = FROZEN
            sets = 3 * fluid[: self.upstream] + contact[: self.upstream]
            stale = iteration == 0 or bool((sets != factored).any())
            factored = sets
            system = System(self, p, h, used, fluid, contact, first=0 if stale else self.upstream)
            right = np.concatenate(
                [-(residual * self.scale).ravel(), -missing.ravel(), [-lack * system.load_weight]]
            ).astype(np.float32)
            change, count = gmres(system.product, system.precondition, right, 0.08, 30)
            inner += count
            dp, dc, dh0 = change[: nx * ny].reshape(nx, ny), change[nx * ny : -1].reshape(nx, ny), float(change[-1])
            size = 1.0
            if mode == NEWTON:
                size = 1.0 / max(1.0, float((np.abs(dp) / (0.44 + 0.8 * np.maximum(p, 0.0)))[full].max()))
            p += np.where(full, size * dp, 0.0)
            c += np.where(touching, size * dc, 0.0)
            c[contact == YIELDING] = hardness - p[contact == YIELDING]
            h0 += size * dh0
            if trace is not None:
                trace.append((iteration, mode, float(worst), changes, count, size))
        self.p, self.c, self.h, self.h0 = p, c, h, h0
        self.fluid, self.contact = fluid, contact
        # by the flow, not by rho h: what a step leaves unsolved is then not lost but solved by the next one
        full = fluid == FULL
        low, high = np.where(full, 0.8 * rho * h - 5.0, 0.0), np.where(full, 1.2 * rho * h + 5.0, rho * h)
        self.m = np.clip(upstream - out, np.maximum(low, 0.0), high)
        self.m[0], self.m[-1] = h[0], self.m[-2]
        return iteration, inner, worst

    def record(self) -> dict[str, float]:
        """Film [nm], pressures [GPa], shares and friction of the present state."""
        case = self.case
        inside = np.abs(self.x) < case.half_width
        eta0, height, z, sliding = case.oil
        log_eta = height * ((1.0 + self.p * GPA / ROELANDS_PRESSURE) ** z - 1.0)
        tau = case.eyring_stress * np.arcsinh(eta0 * np.exp(log_eta) * sliding / (self.h * NM)) / GPA
        tau *= np.where(self.fluid == FULL, 1.0, 0.0)
        total = (self.p + self.c)[inside]
        share = float(self.c.sum()) / self.load
        centre = (self.p + self.c)[np.abs(self.x) < 0.5 * case.half_width]
        return {
            "film": float(self.h[np.abs(self.x) < 0.8 * case.half_width].mean()),
            "film_min": float(self.h[inside].min()),
            "share": share,
            "mu": float(tau.sum()) / self.load + case.boundary_friction * share,
            "contact_area": float((self.contact[inside] != FREE).mean()),
            "pressure_rms": float(np.sqrt(((centre - centre.mean(axis=1, keepdims=True)) ** 2).mean())),
            "pressure_999": float(np.partition(total.ravel(), -total.size // 1000)[-total.size // 1000]),
            "pressure_max": float(total.max()),
            "cavitated": float((self.fluid[inside] == CAVITATED).mean()),
        }


def density_of(p: Array) -> Array:
    """Relative density (Dowson & Higginson)."""
    return np.asarray(1.0 + 0.6 * p / (1.0 + 1.7 * p))


class System:
    """Linear system of a Newton iteration: rows of Reynolds, of touching nodes, of the load; single precision."""

    load_weight = 100.0

    def __init__(self, run: Run, p: Array, h: Array, face: Array, fluid: Array, contact: Array, first: int) -> None:
        self.run, self.fluid, self.contact, self.weight = run, fluid, contact, run.weight
        if not all(np.isfinite(part).all() for part in (p, h, face)):
            raise ArithmeticError(f"step {run.steps} has no solution; take more nodes per correlation length")
        factorise(first, p, h, face, fluid, contact, run.weight, run.elastic.own, run.inverse, run.link, run.scale)
        self.free, self.touching = (contact == FREE).astype(np.float32), (contact == TOUCHING).astype(np.float32)
        self.moves = self.free + self.touching
        self.full = (fluid == FULL).astype(np.float32)
        self.rigid = 1.0 - self.touching
        self.still = self.free * self.full + self.touching
        self.p, self.h, self.face = p.astype(np.float32), h.astype(np.float32), face.astype(np.float32)
        self.coarse = self._mean_matrix()

    def _mean_matrix(self) -> tuple[Array, Array]:
        """LU factors of the rows averaged over y for changes that are constant along y, bordered by the load."""
        run = self.run
        nx = self.p.shape[0]
        index = np.arange(nx)
        by_pressure, by_film = np.zeros((nx, nx)), np.zeros((nx, nx))
        none = np.zeros_like(self.p)
        for colour in range(3):  # rows couple a plane with its neighbours only
            moved = none.copy()
            moved[colour::3] = 1.0
            for matrix, dp, dh in (
                (by_pressure, moved * self.still * self.free, none),
                (by_film, none, moved * self.free),
            ):
                rows = linear_rows(dp, dh, self.p, self.h, self.face, self.fluid, self.weight)
                rows = (self.free * rows).mean(axis=1)
                for way in (-1, 0, 1):
                    column = index + way
                    inside = (column >= 0) & (column < nx) & (column % 3 == colour)
                    matrix[index[inside], column[inside]] = rows[inside]
        by_film[index, index] += self.touching.mean(axis=1)
        share = self.still.mean(axis=1)
        matrix = np.zeros((nx + 1, nx + 1))
        matrix[:nx, :nx] = by_pressure + by_film @ (run.mean_elastic * share[None, :])
        empty = share == 0.0
        matrix[index[empty], index[empty]] += 1.0
        matrix[:nx, nx] = by_film.sum(axis=1)
        matrix[nx, :nx] = self.load_weight * share * self.p.shape[1] / run.load
        return lu_factor(matrix, overwrite_a=True, check_finite=False)

    def product(self, change: Array) -> Array:
        """Derivative of all rows along a change."""
        shape, size = self.p.shape, self.p.size
        dp, dc = change[:size].reshape(shape), change[size:-1].reshape(shape)
        total = self.moves * dp + self.touching * dc
        moved = self.run.elastic(total) + change[-1]
        out = np.empty_like(change)
        rows = linear_rows(dp, self.free * moved, self.p, self.h, self.face, self.fluid, self.weight)
        np.multiply(rows, self.run.scale, out=out[:size].reshape(shape))
        out[size:-1] = (self.touching * moved + self.rigid * dc).ravel()
        out[-1] = self.load_weight * total.sum() / self.run.load
        return out

    def precondition(self, right: Array) -> Array:
        """The mean over y first, then the local part of what remains."""
        shape, size = self.p.shape, self.p.size
        rows, contact = right[:size].reshape(shape), right[size:-1].reshape(shape)
        mean = (self.free * rows / self.run.scale + self.touching * contact).mean(axis=1)
        coarse = lu_solve(self.coarse, np.append(mean, right[-1]), check_finite=False)
        first = np.empty_like(right)
        dq = coarse[:-1, None] * self.still
        first[:size] = (self.free * dq).ravel()
        first[size:-1] = (self.touching * dq).ravel()
        first[-1] = coarse[-1]
        rest = right - self.product(first)
        rows, contact = rest[:size].reshape(shape), rest[size:-1].reshape(shape)
        dp = eliminate(rows / self.run.scale, self.run.inverse, self.run.link)
        first[:size] += dp.ravel()
        first[size:-1] += (self.touching * (contact / self.run.elastic.own - dp) + self.rigid * contact).ravel()
        return first


Operator = Callable[[Array], Array]


def gmres(product: Operator, precondition: Operator, right: Array, tolerance: float, most: int) -> tuple[Array, int]:
    """Right-preconditioned GMRES without restart (Saad & Schultz 1986), single precision; solution and iterations."""
    norm = float(np.linalg.norm(right))
    basis, images = np.empty((most + 1, right.size), dtype=np.float32), np.empty((most, right.size), dtype=np.float32)
    basis[0] = right / norm
    hessenberg = np.zeros((most + 1, most))
    target = np.zeros(most + 1)
    target[0] = norm
    count, weights = 0, np.zeros(0)
    for k in range(most):
        images[k] = precondition(basis[k])
        new = product(images[k])
        hessenberg[: k + 1, k] = overlap = basis[: k + 1] @ new
        new -= overlap @ basis[: k + 1]
        hessenberg[k + 1, k] = size = float(np.linalg.norm(new))
        count = k + 1
        small = hessenberg[: k + 2, : k + 1]
        weights = np.linalg.lstsq(small, target[: k + 2], rcond=None)[0]
        if np.linalg.norm(target[: k + 2] - small @ weights) < tolerance * norm or size < 1e-7 * norm:
            break
        basis[k + 1] = new / size
    return weights.astype(np.float32) @ images[:count], count


def solve(case: Case) -> tuple[dict[str, float], Array]:
    """Averages over the window, their standard errors by batch means, and the mean profiles x/b, film, p, pc."""
    run = Run(case)
    begun = time.process_time()
    batch = max(1, round(BATCH * case.half_width / case.spacing))
    records: list[dict[str, float]] = []
    profiles = np.zeros((3, run.x.size))
    iterations, open_steps = 0, 0
    while run.travel < SETTLED + case.window:
        count, _, worst = run.step()
        if run.travel >= SETTLED:
            iterations += count
            open_steps += worst > 5.0
            records.append(run.record())
            profiles += np.stack([run.h.mean(axis=1), run.p.mean(axis=1), run.c.mean(axis=1)])
    found: dict[str, float] = {}
    for name in records[0]:
        series = np.array([record[name] for record in records])
        batches = series[: series.size // batch * batch].reshape(-1, batch).mean(axis=1)
        found[name] = float(series.mean())
        if name in ("film", "share", "mu"):
            found[f"{name}_error"] = float(batches.std(ddof=1) / math.sqrt(batches.size))
    profiles /= len(records)
    found["iterations"], found["unconverged"] = iterations / len(records), open_steps / len(records)
    found["cpu_seconds"] = time.process_time() - begun
    return found, np.vstack([run.x / case.half_width, profiles])


INPUTS = ("rms_um", "length_um", "gamma", "speed", "seed", "nodes", "window", "hardness_gpa", "film_ratio", "slope")


def append(path: Path, rows: Sequence[dict[str, object]]) -> None:
    """Rows at the end of a CSV table."""
    path.parent.mkdir(parents=True, exist_ok=True)
    pd.DataFrame(rows).to_csv(path, mode="a", header=not path.exists(), index=False)


def inputs(case: Case) -> dict[str, object]:
    """Columns that name a case; the film ratio is that of the smooth film of Dowson & Higginson."""
    film_ratio = Run(replace(case, nodes=4, rms=0.0)).film_estimate() / case.rms if case.rms else math.inf
    values = (case.rms * 1e6, case.length * 1e6, case.gamma, case.speed, case.seed, case.nodes, case.window)
    slope = case.rms / case.length
    return dict(zip(INPUTS, (*values, case.hardness / GPA, round(film_ratio, 3), round(slope, 4)), strict=True))


def one(case: Case, out: Path) -> dict[str, object]:
    """Solve a case; append its row and its profiles."""
    found, profiles = solve(case)
    row = inputs(case) | {name: float(f"{value:.5g}") for name, value in found.items()}
    append(out, [row])
    named = {name: row[name] for name in INPUTS[:6]}
    columns = ("x_over_b", "film_nm", "p_gpa", "pc_gpa")
    lines = [named | dict(zip(columns, (f"{v:.5g}" for v in line), strict=True)) for line in profiles.T[::2]]
    append(out.with_name(f"{out.stem}_profiles.csv"), lines)
    return row


# rms [um], length [um], gamma, speed [m/s], seed; the most informative first
CAMPAIGN = (
    *((rms, 40.0, gamma, 3.0, 1) for gamma in (1.0, 3.0, 2.0, 1.5, 6.0, 20.0) for rms in (1.2, 0.6)),
    *((rms, 40.0, gamma, 3.0, 2) for gamma in (1.0, 2.0) for rms in (0.6, 1.2)),
    *((0.6, 40.0, gamma, 1.0, 1) for gamma in (1.0, 2.0, 3.0)),
    *((0.3, 20.0, gamma, 1.5, 1) for gamma in (1.0, 2.0, 3.0)),
    *((0.6, 20.0, gamma, 3.0, 1) for gamma in (1.0, 2.0, 3.0)),
    *((0.3, 40.0, gamma, 3.0, 1) for gamma in (1.0, 3.0)),
    (0.6, 40.0, 0.5, 3.0, 1),
    (1.2, 40.0, 0.5, 3.0, 1),
)


def campaign(out: Path, nodes: int) -> None:
    """All cases of the campaign that the table does not hold yet."""
    done = set()
    if out.exists():
        done = set(pd.read_csv(out)[[*INPUTS[:6]]].astype(float).itertuples(index=False, name=None))
    for rms, length, gamma, speed, seed in CAMPAIGN:
        if (rms, length, gamma, speed, float(seed), float(nodes)) not in done:
            print(one(Case(rms / 1e6, length / 1e6, gamma, speed, seed, nodes), out), flush=True)


def main(argv: Sequence[str] | None = None) -> None:
    """Solve one case or the campaign."""
    parser = command_line(__doc__)
    parser.add_argument("what", choices=("case", "campaign"))
    parser.add_argument("--out", type=Path, default=OUT / "rough_2d.csv")
    parser.add_argument("--rms", type=float, default=0.6, help="composite Rq [um]")
    parser.add_argument("--length", type=float, default=40.0, help="l_x [um]")
    parser.add_argument("--gamma", type=float, default=1.0)
    parser.add_argument("--speed", type=float, default=3.0, help="mean of both surfaces [m/s]")
    parser.add_argument("--hardness", type=float, default=math.inf, help="limit of the pressure [GPa]")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--nodes", type=int, default=12, help="nodes per l_x")
    parser.add_argument("--window", type=float, default=3.0, help="averaged travel [b]")
    given = parser.parse_args(argv)
    if given.what == "campaign":
        campaign(given.out, given.nodes)
        return
    case = Case(given.rms / 1e6, given.length / 1e6, given.gamma, given.speed, given.seed, given.nodes, given.window)
    print(one(replace(case, hardness=given.hardness * GPA), given.out))


if __name__ == "__main__":
    main()
