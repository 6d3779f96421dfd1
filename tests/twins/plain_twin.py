"""The rough, isothermal, sealed contact solved plainly: a second algorithm for checks and for comparing cost.

Dense Newton at every time step, the exactly integrated kernel by zero-padded FFT in the residual and as a full matrix
in the Jacobian, primal-dual active sets for cavitation and contact.  NumPy and SciPy only; lubricant laws, profiles
and the pressure of the wedge ahead of the mesh are the product's, nothing else is.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import solve, toeplitz

from ehl.common.arrays import FloatArray
from ehl.fluid.lubricant import Lubricant
from ehl.line_contact import LineContact
from ehl.rough.dry import DeflectionOperator
from ehl.rough.scaling import inlet_wedge, rough_length, solved_length
from ehl.rough.surfaces import RoughSurfaces
from ehl.surface.roughness import RoughProfile

FRONT, RAMP = -1.3, 0.3  # where the roughness starts and how softly [b]
# iterations, share of the derivatives of the conductance, relaxation
TURNS = ((25, 1.0, 1.0), (16, 0.0, 0.5), (20, 1.0, 1.0), (30, 0.0, 0.3), (20, 1.0, 1.0))
MIN_PART = 1.0 / 300.0
SMALL = 1e-5  # pressure change of the last iteration [p_h]


def periodic(profile: RoughProfile | None) -> CubicSpline | None:
    """Heights of the ring as a spline of position [m]."""
    if profile is None or profile.rms == 0.0:
        return None
    heights, period = profile.heights, profile.length
    return CubicSpline(np.linspace(0.0, period, heights.size + 1), np.append(heights, heights[0]), bc_type="periodic")


@dataclass
class PlainTwin:
    """Time march of one contact, as `ehl.rough.solve_transient`; pressures in p_h, lengths and films in m."""

    contact: LineContact
    lubricant: Lubricant
    surfaces: RoughSurfaces
    nodes: int  # over the solved length
    boundary_film: float = 30e-9
    boundary_friction: float = 0.1
    failures: int = field(default=0, init=False)
    steps: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        contact, b = self.contact, self.contact.half_width
        film = contact.film_moes(self.lubricant)
        inlet, outlet = solved_length(contact, film)
        dx = (outlet - inlet) * b / self.nodes
        if self.surfaces.profiles:
            period = self.surfaces.profiles[0].length
            dx = period / math.ceil(period / dx)  # as the engine, so that both see one profile at one resolution
        self.dx = dx
        inlet, outlet = rough_length(contact, film, self.surfaces.rms)
        first, last = -math.ceil(-inlet * b / dx), math.ceil(outlet * b / dx) + 2
        self.x = dx * (np.arange(first, last) + 0.5)
        n = self.x.size
        self.operator = DeflectionOperator(n, dx, contact.effective_modulus)
        self.matrix = toeplitz(self.operator.coefficients) * contact.pressure_hertz
        pressure, load, shear = inlet_wedge(contact, self.lubricant.viscosity_inlet, film, float(self.x[0] / b))
        self.inlet_pressure = pressure / contact.pressure_hertz
        self.load = (contact.load_per_length - load) / (contact.pressure_hertz * dx)
        self.wedge_friction = shear / contact.load_per_length
        self.wet = (np.arange(n) > 0) & (self.x < outlet * b)
        self.splines = [periodic(p) for p in (self.surfaces.profile_1, self.surfaces.profile_2)]
        self.p = np.sqrt(np.maximum(1.0 - (self.x / b) ** 2, 0.0))
        self.p *= self.load / self.p.sum()
        self.c = np.zeros(n)
        rigid = self.gap(0) + self.deflection()
        self.level = film - float(rigid[np.abs(self.x) < 0.7 * b].mean())
        mass = self.density(self.p) * np.maximum(self.level + rigid, 0.9 * film)
        self.mass = np.where(self.x > 0.0, np.minimum(mass, 1.3 * film), mass)
        self.mass_before: FloatArray | None = None
        self.last: tuple[FloatArray, FloatArray, FloatArray] | None = None
        self.solved = (self.p, self.c, self.level)

    def density(self, p: FloatArray) -> FloatArray:
        """rho/rho0 of a pressure in p_h."""
        return self.lubricant.density_ratio(np.maximum(p, 0.0) * self.contact.pressure_hertz)

    def deflection(self) -> FloatArray:
        """V of both pressures [m]."""
        return self.operator((self.p + self.c) * self.contact.pressure_hertz)

    def gap(self, step: int) -> FloatArray:
        """Rigid gap after a number of steps, without the approach [m]."""
        time = step * self.dx / self.contact.speed_entrainment
        rough = np.zeros(self.x.size)
        for spline, speed in zip(self.splines, (self.contact.speed_1, self.contact.speed_2), strict=True):
            if spline is not None:
                rough -= spline(self.x - self.x[0] - speed * time)
        b = self.contact.half_width
        s = np.clip((FRONT + step * self.dx / b - self.x / b) / RAMP, 0.0, 1.0)
        return self.x**2 / (2.0 * self.contact.radius_equivalent) + s * s * (3.0 - 2.0 * s) * rough

    def upstream_mass(self) -> tuple[FloatArray, FloatArray]:
        """Mass at the upstream end of the characteristic, weight of the sources (BDF2; Euler where film breaks)."""
        upstream_mass, weight = np.append(self.mass[0], self.mass[:-1]), np.ones(self.x.size)
        if self.mass_before is not None:
            second = (4.0 * self.mass[1:-1] - self.mass_before[:-2]) / 3.0
            good = np.abs(second - upstream_mass[2:]) < 0.5 * upstream_mass[2:]
            upstream_mass[2:] = np.where(good, second, upstream_mass[2:])
            weight[2:] = np.where(good, 2.0 / 3.0, 1.0)
        return upstream_mass, weight

    def conductance(self, h: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """dt p_h rho h^3 cosh S/(12 eta dx^2) between the nodes and its derivatives by film and pressure."""
        contact, oil = self.contact, self.lubricant
        film = np.maximum(0.5 * (h[1:] + h[:-1]), self.boundary_film)
        p = np.maximum(0.5 * (self.p[1:] + self.p[:-1]), 0.0) * contact.pressure_hertz
        mobility = 1.0 / oil.viscosity(p)
        shear = contact.speed_sliding / (oil.eyring_stress * film) if oil.rheology == "eyring" else 0.0 * film
        total = np.hypot(mobility, shear)
        part = (mobility / total) ** 2
        scale = contact.pressure_hertz / (12.0 * self.dx * contact.speed_entrainment)
        rho = oil.density_ratio(p)
        k = scale * rho * film**3 * total
        free = 0.5 * (h[1:] + h[:-1]) > self.boundary_film
        by_film = np.where(free, k * (2.0 + part) / film, 0.0)
        by_p = k * (oil.compression.slope(p) / rho - oil.pressure_law.by_pressure(p) * part) * contact.pressure_hertz
        return k, by_film, by_p

    def advance(self) -> tuple[float, float]:
        """One time step; returns mu and the mean film of the middle [m]."""
        self.steps += 1
        upstream_mass, weight = self.upstream_mass()
        rigid = self.gap(self.steps)
        self.p[0], self.c[0] = self.inlet_pressure, 0.0
        # the mean film stays, as the bodies do not jump
        middle = np.abs(self.x) < 0.8 * self.contact.half_width
        if self.steps > 1:
            self.level += self.film - float((self.level + rigid + self.deflection())[middle].mean())
        self._solve((rigid, upstream_mass, weight))
        self.p, self.c = np.maximum(self.p, 0.0), np.maximum(self.c, 0.0)
        full = self.level + rigid + self.deflection()
        h = np.maximum(full, self.boundary_film)
        carried = np.clip(upstream_mass + self._inflow(full, weight), 0.0, h)
        self.mass_before = self.mass
        self.mass = np.where(self.p > 0.0, self.density(self.p) * h, carried)
        self.film = float(full[middle].mean())
        shear = self.lubricant.shear_stress(self.p * self.contact.pressure_hertz, h, self.contact.speed_sliding)
        fluid = shear[1:][self.p[1:] > 0.0].sum() * self.dx / self.contact.load_per_length + self.wedge_friction
        share = self.c.sum() * self.contact.pressure_hertz * self.dx / self.contact.load_per_length
        return float(fluid + self.boundary_friction * share), float(h[middle].mean())

    def _solve(self, problem: tuple[FloatArray, FloatArray, FloatArray]) -> None:
        """Newton; where its sets cycle, the way from the last step's problem in parts (same solution, other way)."""
        start, done, part = (self.p, self.c, self.level), 0.0, 1.0
        while done < 1.0:
            here = min(done + part, 1.0)
            blend = [a + here * (b - a) for a, b in zip(self.last, problem, strict=True)] if here < 1.0 else problem
            if self._converge(blend):
                start, done = (self.p, self.c, self.level), here
                continue
            part *= 0.25
            if self.last is None or part < MIN_PART:
                self.failures += 1
                break
            if done == 0.0:
                start = self.solved
            self.p, self.c, self.level = start
        self.last, self.solved = problem, (self.p, self.c, self.level)

    def _converge(self, problem: list[FloatArray] | tuple[FloatArray, ...]) -> bool:
        """Newton and, where it stalls, turns of relaxed iterations with the present conductance and Newton."""
        for count, slopes, relaxation in TURNS:
            for _ in range(count):
                if self._newton(*problem, slopes, relaxation):
                    return True
        return False

    def _inflow(self, h: FloatArray, weight: FloatArray) -> FloatArray:
        flow = np.append(self.conductance(h)[0] * np.diff(self.p), 0.0)
        return weight * np.diff(flow, prepend=0.0)

    def _newton(
        self, rigid: FloatArray, upstream_mass: FloatArray, weight: FloatArray, slopes: float, relaxation: float
    ) -> bool:
        """One iteration on the present active sets; True when it changed nothing that matters."""
        n = self.x.size
        h = self.level + rigid + self.deflection()
        k, by_film, by_p = self.conductance(h)
        slope = np.diff(self.p)
        by_film, by_p = slopes * by_film, slopes * by_p
        rho = self.density(self.p)
        mass = upstream_mass + weight * np.diff(np.append(k * slope, 0.0), prepend=0.0) - rho * h
        # derivatives of the flow between i and i + 1 by p and h of both ends
        left, right = -k + 0.5 * by_p * slope, k + 0.5 * by_p * slope
        film = 0.5 * by_film * slope
        by_pressure, by_gap = np.zeros((n, n)), np.zeros((n, n))
        i = np.arange(n - 1)
        for target, here, there in ((by_pressure, left, right), (by_gap, film, film)):
            target[i, i] += here
            target[i, i + 1] += there
            target[i + 1, i] -= here
            target[i + 1, i + 1] -= there
        by_pressure *= weight[:, None]
        by_gap *= weight[:, None]
        ends = np.arange(n)
        ph = self.contact.pressure_hertz
        denser = self.lubricant.compression.slope(np.maximum(self.p, 0.0) * ph) * ph
        by_pressure[ends, ends] -= np.where(self.p > 0.0, denser * h, 0.0)
        by_gap[ends, ends] -= rho
        local = self.matrix[0, 0] - self.matrix[0, 1]
        stiffness = np.abs(np.diag(by_pressure)) + local
        fluid = self.wet & (self.p + mass / stiffness > 0.0)
        solid = (ends > 0) & (self.c + (self.boundary_film - h) / local > 0.0)
        # nodes outside a set give their pressure back in this step
        fixed_p, fixed_c = np.where(fluid | (ends == 0), 0.0, -self.p), np.where(solid, 0.0, -self.c)
        tri = np.zeros((n, n))  # by_gap times the kernel, row by row of a tridiagonal matrix
        tri += np.diag(by_gap)[:, None] * self.matrix
        tri[:-1] += np.diag(by_gap, 1)[:, None] * self.matrix[1:]
        tri[1:] += np.diag(by_gap, -1)[:, None] * self.matrix[:-1]
        f, s = np.flatnonzero(fluid), np.flatnonzero(solid)
        moved = self.matrix @ (fixed_p + fixed_c)
        right_mass = -mass - by_pressure @ fixed_p - by_gap @ moved
        right_gap = self.boundary_film - h - moved
        size = f.size + s.size + 1
        system, rhs = np.zeros((size, size)), np.empty(size)
        a, e = slice(0, f.size), slice(f.size, size - 1)
        system[a, a] = (by_pressure + tri)[np.ix_(f, f)]
        system[a, e] = tri[np.ix_(f, s)]
        system[a, -1] = by_gap.sum(axis=1)[f]
        system[e, a], system[e, e] = self.matrix[np.ix_(s, f)], self.matrix[np.ix_(s, s)]
        system[e, -1] = 1.0
        system[-1, :-1] = 1.0
        rhs[a], rhs[e] = right_mass[f], right_gap[s]
        rhs[-1] = self.load - (self.p + self.c + fixed_p + fixed_c).sum()
        # rows to one size, the approach in the unit of the local deflection: the system mixes metres and p_h
        scale = np.ones(size)
        scale[a], scale[e] = 1.0 / stiffness[f], 1.0 / local
        system *= scale[:, None]
        system[:, -1] *= local
        change = solve(system, scale * rhs, check_finite=False)
        step_p, step_c = fixed_p, fixed_c
        step_p[f], step_c[s] = change[a], change[e]
        damping = relaxation / max(1.0, float(np.max(np.abs(step_p) / (0.4 + 0.8 * np.maximum(self.p, 0.0)))))
        self.p = self.p + damping * step_p
        self.c = self.c + damping * step_c
        self.level += damping * float(change[-1]) * local
        settled = max(float(np.abs(step_p).max()), float(np.abs(step_c).max())) < SMALL
        return settled and abs(float(change[-1])) * local < SMALL * local


def roll(twin: PlainTwin, startup: float, window: float) -> tuple[float, float]:
    """mu and mean film [m] over a window after a start-up, both travels in b."""
    per_width = twin.contact.half_width / twin.dx
    for _ in range(round(startup * per_width)):
        twin.advance()
    values = [twin.advance() for _ in range(round(window * per_width))]
    mu, film = np.mean(values, axis=0)
    return float(mu), float(film)
