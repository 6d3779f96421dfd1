"""Grids and unknowns of the smooth contact, and Newton's method on one grid.

Dimensionless outputs of one converged level: films, pressures, friction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ehl.common.arrays import FloatArray
from ehl.fluid.rheology import ShearLaw, ShearNumbers
from ehl.smooth import _kernels
from ehl.smooth.mesh import Features, Grading
from ehl.smooth.scaling import ScaledContact

Array = NDArray[np.float64]


@dataclass(frozen=True)
class NodeGrid:
    """Reference nodes and faces of one level of a grading, with the kernel matrix."""

    grading: Grading
    nodes: Array
    faces: Array
    weights: Array
    kernel: Array

    @classmethod
    def of(cls, grading: Grading, points: Array) -> NodeGrid:
        """Grid from 2n - 1 points of the grading: nodes at even, faces at odd indices."""
        nodes = np.ascontiguousarray(points[::2])
        half = 0.5 * (nodes[1:] - nodes[:-1])
        weights = np.zeros(nodes.size)
        weights[:-1] += half
        weights[1:] += half
        return cls(grading, nodes, np.ascontiguousarray(points[1::2]), weights, _kernels.log_kernel(nodes))

    @cached_property
    def mesh(self) -> _kernels.Mesh:
        """Mesh for the compiled kernels."""
        grading = self.grading
        size = grading.features.size
        return _kernels.Mesh(self.nodes, self.faces, self.weights, self.kernel, float(grading.x_in), size)


@dataclass
class Unknowns:
    """Pressure at the nodes, film constant, flow and stretch of the mesh (x = x_in + stretch (s - x_in))."""

    pressure: Array
    h00: float
    flow: float
    stretch: float


@dataclass
class Level:
    """Converged solution on one grid."""

    grid: NodeGrid
    scaled: ScaledContact
    unknowns: Unknowns
    x: Array
    film: Array
    rho: Array
    log_eta: Array
    iterations: int
    residual: Array

    @property
    def mass_residual(self) -> float:
        """Largest residual of the Reynolds equation over the flow."""
        return float(np.abs(self.residual[:-1]).max() / self.unknowns.flow)

    @property
    def load_residual(self) -> float:
        """Relative residual of the load."""
        return abs(float(self.residual[-1])) / _kernels.HALF_PI

    @property
    def features(self) -> Features:
        """Features for which the mesh of this level was graded."""
        return self.grid.grading.features


class NewtonFailure(Exception):
    """No convergence on a mesh from a given start; holds the number of iterations."""

    def __init__(self, reason: str, iterations: int) -> None:
        super().__init__(reason)
        self.reason = reason
        self.iterations = iterations


class NewtonFactors:
    """LU factors of the last Newton matrix on a grid, reused for similar contacts."""

    def __init__(self, grid: NodeGrid) -> None:
        size = grid.nodes.size + 1
        self.matrix, self.scale, self.pivots = np.empty((size, size)), np.empty(size), np.empty(size, np.int32)
        self.known = False


def solve_level(
    grid: NodeGrid,
    scaled: ScaledContact,
    start: Unknowns,
    *,
    tolerance: float = 1e-8,
    max_iterations: int = 40,
    factors: NewtonFactors | None = None,
) -> Level:
    """Converged solution on one grid, with the given factors of a similar matrix if available.

    Raises `NewtonFailure`: "start_infeasible", "singular_matrix", "damping_exhausted" or "iteration_limit".
    """
    n = grid.nodes.size
    u = np.empty(n + 3)
    u[:n], u[n], u[n + 1], u[n + 2] = start.pressure, start.h00, start.flow, start.stretch
    state, residual = np.empty((_kernels.ROWS, n)), np.empty(n + 1)
    factors = factors or NewtonFactors(grid)
    end, iterations = _kernels.newton(
        grid.mesh, scaled.groups, u, tolerance, max_iterations, state, residual,
        factors.matrix, factors.scale, factors.pivots, factors.known,
    )  # fmt: skip
    factors.known = end == _kernels.CONVERGED
    if end != _kernels.CONVERGED:
        raise NewtonFailure(_ENDS[end], iterations)
    x, film, rho, log_eta = state[_kernels.X], state[_kernels.FILM], state[_kernels.RHO], state[_kernels.LOG_ETA]
    return Level(grid, scaled, Unknowns(u[:n], *u[n:].tolist()), x, film, rho, log_eta, iterations, residual)


_ENDS = {
    _kernels.INFEASIBLE: "start_infeasible",
    _kernels.SINGULAR: "singular_matrix",
    _kernels.EXHAUSTED: "damping_exhausted",
    _kernels.LIMIT: "iteration_limit",
}


FRICTION_INLET = 100.0  # start of the integral of the shear, in lengths of the loaded zone upstream


@dataclass(frozen=True)
class FilmShear:
    """Film shear in units of p_h, from ln(eta/eta0), film H and pressure P."""

    law: ShearLaw  # stress over rate [Pa]
    pressure_hertz: float  # [Pa]
    rate: float  # eta0 |v_s| R/(p_h b^2)

    @cached_property
    def numbers(self) -> tuple[ShearNumbers, float, float]:
        """Shear law for the compiled kernels, and ambient value [p_h] and slope of a limit that cuts the stress off."""
        slope = self.law.limit_slope if self.law.limited and self.law.limit == "cut" else math.inf
        unit = self.pressure_hertz
        return self.law.numbers(unit, unit, 1.0), self.law.limit_ambient / unit, slope

    def stress_at(self, log_eta: FloatArray, film: FloatArray, pressure: FloatArray) -> FloatArray:
        """Shear stress at the nodes."""
        return np.asarray(_kernels.stresses(pressure, film, log_eta, self.rate, *self.numbers))


class Numbers(NamedTuple):
    """Dimensionless outputs of one level, or their errors."""

    film_central: float
    film_min: float
    friction: float
    pressure_max: float
    flow: float
    exit: float
    rolling: float


def numbers_of(level: Level, shear: FilmShear) -> Numbers:
    """Outputs of a level; mu = (2/pi) integral of the shear stress from the friction inlet to the exit."""
    law, ambient, slope = shear.numbers
    return Numbers(
        *_kernels.outputs(
            level.x, level.unknowns.pressure, level.film, level.log_eta, level.unknowns.flow, level.scaled.lam,
            friction_inlet(level), shear.rate, law, ambient, slope,
        )
    )  # fmt: skip


def friction_inlet(level: Level) -> float:
    """Start of the integrals of the shear, in half-widths."""
    return -FRICTION_INLET * level.features.size
