"""Grids and unknowns of the smooth contact, and Newton's method on one grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
        """Grid from 2n - 1 points of the grading: nodes at even, faces at odd places."""
        nodes = np.ascontiguousarray(points[::2])
        half = 0.5 * (nodes[1:] - nodes[:-1])
        weights = np.zeros(nodes.size)
        weights[:-1] += half
        weights[1:] += half
        return cls(grading, nodes, np.ascontiguousarray(points[1::2]), weights, _kernels.log_kernel(nodes))

    @property
    def mesh(self) -> _kernels.Mesh:
        """For the compiled loops."""
        grading = self.grading
        return _kernels.Mesh(self.nodes, self.faces, self.weights, self.kernel, float(grading.x_in), grading.size)


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
        """Largest residual of the film's equation, in its flow."""
        return float(np.abs(self.residual[:-1]).max() / self.unknowns.flow)

    @property
    def load_residual(self) -> float:
        """Of the load, relative."""
        return abs(float(self.residual[-1])) / _kernels.HALF_PI

    @property
    def features(self) -> Features:
        """What the mesh of this level was graded for."""
        return self.grid.grading.features


class NewtonFailure(Exception):
    """No convergence on this mesh from this start; carries the iterations spent."""

    def __init__(self, reason: str, iterations: int) -> None:
        super().__init__(reason)
        self.reason = reason
        self.iterations = iterations


class NewtonFactors:
    """Factors of the last matrix on a grid, from which similar contacts on it may start."""

    def __init__(self, grid: NodeGrid) -> None:
        size = grid.nodes.size + 1
        self.matrix, self.scale, self.pivots = np.empty((size, size)), np.empty(size), np.empty(size, np.int32)
        self.known = False


def tail(x_in: float, scaled: ScaledContact) -> tuple[float, float]:
    """Pressure at the first node and load upstream of it: dP/dx = 4 lam eta/x^4 of the open parabolic inlet."""
    lam, distance = scaled.lam, abs(x_in)
    if scaled.offset is not None:
        lam *= float(np.exp(scaled.offset.at(np.array([x_in]))[0][0]))
    return 4.0 * lam / (3.0 * distance**3), 2.0 * lam / (3.0 * distance**2)


def solve_level(
    grid: NodeGrid,
    scaled: ScaledContact,
    start: Unknowns,
    *,
    tolerance: float = 1e-8,
    max_iterations: int = 40,
    factors: NewtonFactors | None = None,
) -> Level:
    """Converge on one grid, from the factors of a matrix where some are known.

    Raises `NewtonFailure`: reasons: "start_infeasible", "singular_matrix", "damping_exhausted", "iteration_limit".
    """
    n = grid.nodes.size
    u = np.concatenate([start.pressure, (start.h00, start.flow, start.stretch)])
    state, residual = np.empty((_kernels.ROWS, n)), np.empty(n + 1)
    factors = factors or NewtonFactors(grid)
    mesh = grid.mesh
    end, iterations = _kernels.newton(
        mesh, scaled.groups, *tail(mesh.x_in, scaled), u, tolerance, max_iterations, state, residual,
        factors.matrix, factors.scale, factors.pivots, factors.known,
    )  # fmt: skip
    factors.known = end == _kernels.CONVERGED
    if end != _kernels.CONVERGED:
        raise NewtonFailure(_ENDS[end], iterations)
    return Level(
        grid,
        scaled,
        Unknowns(u[:n], *u[n:].tolist()),
        state[_kernels.X],
        state[_kernels.FILM],
        state[_kernels.RHO],
        state[_kernels.LOG_ETA],
        iterations,
        residual,
    )


_ENDS = {
    _kernels.INFEASIBLE: "start_infeasible",
    _kernels.SINGULAR: "singular_matrix",
    _kernels.EXHAUSTED: "damping_exhausted",
    _kernels.LIMIT: "iteration_limit",
}
