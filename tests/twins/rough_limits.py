"""Flow factors by direct 2-D solutions of Reynolds' equation, and the dry contact at the geometry of a run."""

import math

import numpy as np
from scipy.linalg import solve_banded
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve
from twins.rough_scenes import Scene, gaussian_pair, line

from ehl.compile.compiler import FAST_KERNEL, kernel
from ehl.fluid.density import INCOMPRESSIBLE
from ehl.fluid.lubricant import Lubricant
from ehl.line_contact import LineContact
from ehl.rough._kernels.motion import move_surfaces
from ehl.rough._kernels.newton import NEWTON, add_side_flow, poiseuille_flow
from ehl.rough._kernels.records import TRAVEL
from ehl.rough.dry import solve_dry
from ehl.rough.run import TransientRun

FLOOR = 0.02  # gap of rigid surfaces where they would overlap, in roughness


def gaussian_plane(points: int, correlation: float, gamma: float, seed: int) -> np.ndarray:
    """Periodic Gaussian heights of unit variance, ACF exp(-(x/lc)^2 - (y/(gamma lc))^2), lengths in cells."""
    k = 2.0 * np.pi * np.fft.fftfreq(points)
    envelope = np.exp(-((k[:, None] * correlation) ** 2 + (k[None, :] * gamma * correlation) ** 2) / 8.0)
    white = np.fft.fft2(np.random.default_rng(seed).standard_normal((points, points)))
    heights = np.fft.ifft2(white * envelope).real
    return np.asarray((heights - heights.mean()) / heights.std())


def flow_factor_direct(gap: np.ndarray) -> float:
    """phi_x of a rigid gap by a direct solution of the 2-D Reynolds equation: p given at both ends, periodic in y."""
    n, m = gap.shape
    along = (0.5 * (gap[1:] + gap[:-1])) ** 3
    across = (0.5 * (gap + np.roll(gap, -1, axis=1))) ** 3
    node = np.arange(n * m).reshape(n, m)
    i = np.concatenate([node[:-1].ravel(), node.ravel()])
    j = np.concatenate([node[1:].ravel(), np.roll(node, -1, axis=1).ravel()])
    f = np.concatenate([along.ravel(), across.ravel()])
    ends = np.zeros((n, m))
    ends[0], ends[-1] = 2.0 * gap[0] ** 3, 2.0 * gap[-1] ** 3
    diagonal = np.bincount(i, f, n * m) + np.bincount(j, f, n * m) + ends.ravel()
    matrix = coo_matrix((-f, (i, j)), (n * m, n * m))
    matrix = (matrix + matrix.T).tocsc()
    matrix.setdiag(diagonal)
    load = np.zeros((n, m))
    load[0] = ends[0]
    p = spsolve(matrix.tocsc(), load.ravel()).reshape(n, m)
    flow = float((ends[-1] * p[-1]).sum())
    return flow / m * n / float(np.mean(gap) ** 3)


@kernel(cache=False, **FAST_KERNEL)  # it compiles kernels of other files in
def conductances(state, step, macro, work, model):  # type: ignore[no-untyped-def]
    """Fluidity along x and exchange of the solver at its present films and pressures."""
    poiseuille_flow(state, step, work, model, NEWTON, 1.0, True, False)
    if model.fluid.flux_lateral > 0.0:
        add_side_flow(state, step, macro, work, model, NEWTON, True)


def flow_factor_model(mean: float, gamma: float, correlation: float = 24.0, seed: int = 1) -> float:
    """phi_x of the solver's exchange, its own kernels on a rigid slice: d/dx(f dp/dx) = k (p - P), P linear.

    ``mean`` in units of the roughness, ``correlation`` in nodes.
    """
    contact = line(1.0, 0.0)
    rms = 1e-6
    thin = Lubricant(1e-3, 1e-13, compression=INCOMPRESSIBLE, rheology="newtonian")
    nodes_per_b = 2000.0
    lc = correlation / nodes_per_b
    scene = Scene(contact, thin, gaussian_pair(contact, rms, lc, seed, 8.0), 2e-8, gamma)
    run = scene.run(nodes_per_b)
    problem = run.problem
    model = problem.model._replace(
        side_flow=problem.model.side_flow._replace(first=0),
        contact=problem.model.contact._replace(outlet=problem.x.size),
    )
    n = problem.x.size
    rough = np.zeros(n)
    move_surfaces(rough, 1e7, model.surfaces)
    rough -= model.surfaces.parabola
    rough *= problem.units.film
    heights = mean * rms + (rough - rough.mean()) * rms / rough.std()
    heights = np.maximum(heights, FLOOR * rms)
    run.state.film[:] = heights / problem.units.film
    linear = 1e-6 * np.linspace(2.0, 1.0, n)
    run.state.fluid_pressure[:] = linear
    run.macroscopic.pressure[:] = linear
    work = run._work
    for _ in range(2):  # the first pass finds the typical lateral fluidity
        conductances(run.state, run._step, run.macroscopic, work, model)
        run.macroscopic.typical[:] = math.exp(float(np.log(work.node.f).mean())) if math.isfinite(gamma) else 0.0
    f = work.fluidity.copy()
    exchange = work.exchange.copy()
    matrix = np.zeros((3, n))
    matrix[0, 1:] = -f[:-1]
    matrix[2, :-1] = -f[:-1]
    matrix[1] = exchange
    matrix[1, :-1] += f[:-1]
    matrix[1, 1:] += f[:-1]
    right = exchange * linear
    for end in (0, n - 1):
        matrix[1, end] = 1.0
        right[end] = linear[end]
    matrix[0, 1] = matrix[2, n - 2] = 0.0
    p = solve_banded((1, 1), matrix, right)
    flow = f[:-1] * (p[:-1] - p[1:])
    inner = slice(n // 10, n - n // 10)
    # a smooth gap of the same mean height carries this
    smooth = model.fluid.flux * float(np.mean(heights) / problem.units.film) ** 3 * (linear[0] - linear[-1]) / (n - 1)
    return float(flow[inner].mean() / smooth)


def dry_error(run: TransientRun, contact: LineContact) -> tuple[float, float, float]:
    """L1 difference of the pressures, contact lengths of run and of `ehl.rough.dry` over b, at the run's geometry."""
    problem = run.problem
    units, surfaces = problem.units, problem.model.surfaces
    gap = np.zeros(problem.x.size)
    move_surfaces(gap, run.state.scalars[TRAVEL], surfaces)
    x = problem.x * units.half_width
    total = (run.state.fluid_pressure + run.state.contact_pressure) * units.pressure
    dry = solve_dry(contact, x, -(gap - surfaces.parabola) * units.film, hardness=8e9)
    length = np.count_nonzero(run.state.contact_pressure > 0.0) * units.spacing
    difference = float(np.abs(dry.pressure - total).sum() / total.sum())
    return difference, length / contact.half_width, dry.contact_length / contact.half_width
