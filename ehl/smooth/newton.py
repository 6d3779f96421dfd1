"""Full Newton on one mesh, damped by the natural monotonicity test (Deuflhard 2004)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from ehl.smooth import _kernels
from ehl.smooth.mesh import Features, Grading
from ehl.smooth.scaling import ScaledContact

Array = NDArray[np.float64]
HALF_PI = 0.5 * math.pi


@dataclass(frozen=True)
class Grid:
    """Reference nodes and faces of one level of a grading, with the kernel matrix."""

    grading: Grading
    nodes: Array
    faces: Array
    weights: Array
    kernel: Array

    @classmethod
    def of(cls, grading: Grading, points: Array) -> Grid:
        """Grid from 2n - 1 points of the grading: nodes at even, faces at odd places."""
        nodes = np.ascontiguousarray(points[::2])
        step = np.diff(nodes)
        weights = np.zeros(nodes.size)
        weights[:-1] += 0.5 * step
        weights[1:] += 0.5 * step
        return cls(grading, nodes, np.ascontiguousarray(points[1::2]), weights, _kernels.log_kernel(nodes))


@dataclass
class Unknowns:
    """Pressure at the nodes, film constant, flow and stretch of the mesh (x = x_in + stretch (s - x_in))."""

    pressure: Array
    h00: float
    flow: float
    stretch: float

    def moved(self, step: Array, factor: float) -> Unknowns:
        pressure = self.pressure.copy()
        pressure[1:-1] += factor * step[:-3]
        return Unknowns(
            pressure, self.h00 + factor * step[-3], self.flow + factor * step[-2], self.stretch + factor * step[-1]
        )


@dataclass
class Evaluation:
    """Everything known at one set of unknowns."""

    unknowns: Unknowns
    x: Array
    x_face: Array
    kernel_pressure: Array
    film: Array
    rho: Array
    rho_p: Array
    log_eta: Array
    mobility: Array
    mobility_p: Array
    mobility_h: Array
    mobility_x: Array
    residual: Array


@dataclass
class Level:
    """Converged solution on one grid."""

    grid: Grid
    scaled: ScaledContact
    unknowns: Unknowns
    x: Array
    film: Array
    rho: Array
    log_eta: Array
    iterations: int
    mass_residual: float
    load_residual: float

    @property
    def features(self) -> Features:
        """What the mesh of this level was graded for."""
        return self.grid.grading.features


def tail(scaled: ScaledContact, x_in: float) -> tuple[float, float]:
    """Pressure at ``x_in`` and load upstream of it: dP/dx = 4 lam eta/x^4 of the open parabolic inlet."""
    lam = scaled.lam
    if scaled.offset is not None:
        lam *= math.exp(float(scaled.offset.at(np.array([x_in]))[0][0]))
    return 4.0 * lam / (3.0 * abs(x_in) ** 3), 2.0 * lam / (3.0 * x_in * x_in)


def evaluate(grid: Grid, scaled: ScaledContact, u: Unknowns) -> Evaluation | None:
    """Residual and nodal state; None outside the domain (film, flow or stretch not positive)."""
    if not (u.flow > 0.0 and 0.05 < u.stretch < 20.0 and np.isfinite(u.h00)):
        return None
    x_in = grid.grading.x_in
    x = x_in + u.stretch * (grid.nodes - x_in)
    x_face = x_in + u.stretch * (grid.faces - x_in)
    kernel_pressure = grid.kernel @ u.pressure
    film = _kernels.film(x, kernel_pressure, u.stretch, u.h00)
    if not film.min() > 0.0:
        return None
    offset = slope = np.zeros(x.size)
    if scaled.offset is not None:
        offset, slope = scaled.offset.at(x)
    state = _kernels.nodal_state(
        scaled.table, scaled.stiffness, scaled.gamma, scaled.cross, scaled.shear, u.pressure, film, offset
    )
    rho, rho_p, log_eta, f, f_p, f_h, f_o = state
    out = np.empty(x.size + 1)
    if not (
        rho.min() > 0.0
        and _kernels.residual(x, x_face, grid.grading.size, scaled.lam, u.pressure, film, u.flow, rho, f, out)
    ):
        return None
    out[-1] = u.stretch * (grid.weights @ u.pressure) + tail(scaled, x_in)[1] - HALF_PI
    if not np.isfinite(out).all():
        return None
    return Evaluation(u, x, x_face, kernel_pressure, film, rho, rho_p, log_eta, f, f_p, f_h, f_o * slope, out)


class LinearSystem:
    """Factorised Newton matrix of one evaluation."""

    def __init__(self, grid: Grid, scaled: ScaledContact, e: Evaluation, work: Array) -> None:
        u = e.unknowns
        x_in = grid.grading.x_in
        n = e.x.size
        lever = (e.x - x_in) / u.stretch
        h_a = e.x * lever - e.kernel_pressure / math.pi
        self.scale = np.empty(n + 1)
        _kernels.jacobian(
            e.x, e.x_face, grid.grading.size, x_in, u.stretch, scaled.lam, u.pressure, e.film, u.flow, e.rho, e.rho_p,
            e.mobility, e.mobility_p, e.mobility_h, e.mobility_x * lever, grid.kernel, h_a, grid.weights, work,
            self.scale,
        )  # fmt: skip
        self.lu, self.pivots, self.info = lapack.dgetrf(work.T, overwrite_a=True)

    def step(self, residual: Array) -> Array:
        """Newton correction of a residual."""
        solution, _ = lapack.dgetrs(self.lu, self.pivots, -self.scale * residual, trans=1, overwrite_b=True)
        return np.asarray(solution)


def _length(step: Array, u: Unknowns) -> float:
    """Scaled size of a correction: pressure by p_h, flow and film constant by the film, stretch by itself."""
    film = max(u.flow, 1e-300)
    size = float(step[:-3] @ step[:-3]) / max(step.size - 3, 1)
    reach = 1.0 + film
    return math.sqrt(size + (step[-3] / reach) ** 2 + (step[-2] / film) ** 2 + step[-1] ** 2)


class NewtonFailure(Exception):
    """No convergence on this mesh from this start; carries the iterations spent."""

    def __init__(self, reason: str, iterations: int) -> None:
        super().__init__(reason)
        self.reason = reason
        self.iterations = iterations


def solve_level(
    grid: Grid, scaled: ScaledContact, start: Unknowns, *, tolerance: float = 1e-8, max_iterations: int = 40
) -> Level:
    """Converge on one grid.

    Raises
    ------
    NewtonFailure
        Reasons: "start_infeasible", "singular_matrix", "damping_exhausted", "iteration_limit".
    """
    start = Unknowns(start.pressure.copy(), start.h00, start.flow, start.stretch)
    start.pressure[0], start.pressure[-1] = tail(scaled, grid.grading.x_in)[0], 0.0
    e = _feasible(grid, scaled, start)
    if e is None:
        raise NewtonFailure("start_infeasible", 0)
    n = grid.nodes.size
    work = np.empty((n + 1, n + 1))
    factor = 1.0
    for iteration in range(1, max_iterations + 1):
        system = LinearSystem(grid, scaled, e, work)
        step = system.step(e.residual) if system.info == 0 else np.array([np.nan])
        if not np.isfinite(step).all():
            raise NewtonFailure("singular_matrix", iteration)
        length = _length(step, e.unknowns)
        if not length < 1e6:
            raise NewtonFailure("singular_matrix", iteration)
        factor = min(1.0, 4.0 * factor)
        while True:
            trial = evaluate(grid, scaled, e.unknowns.moved(step, factor))
            if trial is not None:
                simplified = system.step(trial.residual)
                left = _length(simplified, trial.unknowns)
                if left <= (1.0 - 0.25 * factor) * length or left < tolerance:
                    break
            factor *= 0.4
            if factor < 1e-3:
                raise NewtonFailure("damping_exhausted", iteration)
        e = trial
        if factor == 1.0 and left < tolerance:
            final = evaluate(grid, scaled, e.unknowns.moved(simplified, 1.0))
            return _level(grid, scaled, final if final is not None else e, iteration)
    raise NewtonFailure("iteration_limit", max_iterations)


def _feasible(grid: Grid, scaled: ScaledContact, start: Unknowns) -> Evaluation | None:
    """Evaluation of the start, its film raised where pressure from another mesh would close it (thin films)."""
    e = evaluate(grid, scaled, start)
    for lift in (0.5, 1.0, 2.0, 4.0, 8.0, 16.0):
        if e is not None:
            break
        start.h00 += lift * start.flow
        e = evaluate(grid, scaled, start)
    return e


def _level(grid: Grid, scaled: ScaledContact, e: Evaluation, iterations: int) -> Level:
    mass = float(np.max(np.abs(e.residual[:-1]))) / e.unknowns.flow
    return Level(
        grid, scaled, e.unknowns, e.x, e.film, e.rho, e.log_eta, iterations, mass, abs(float(e.residual[-1])) / HALF_PI
    )
