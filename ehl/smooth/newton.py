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
    n = grid.nodes.size
    u = np.concatenate([start.pressure, (start.h00, start.flow, start.stretch)])
    state, residual = np.empty((_kernels.ROWS, n)), np.empty(n + 1)
    end, iterations = _kernels.newton(grid.mesh, scaled.groups, u, tolerance, max_iterations, state, residual)
    if end != _kernels.CONVERGED:
        raise NewtonFailure(_ENDS[end], iterations)
    return Level(
        grid,
        scaled,
        Unknowns(u[:n], *(float(v) for v in u[n:])),
        state[_kernels.X],
        state[_kernels.FILM],
        state[_kernels.RHO],
        state[_kernels.LOG_ETA],
        iterations,
        float(np.abs(residual[:-1]).max() / u[n + 1]),
        abs(float(residual[-1])) / _kernels.HALF_PI,
    )


_ENDS = {
    _kernels.INFEASIBLE: "start_infeasible",
    _kernels.SINGULAR: "singular_matrix",
    _kernels.EXHAUSTED: "damping_exhausted",
    _kernels.LIMIT: "iteration_limit",
}
