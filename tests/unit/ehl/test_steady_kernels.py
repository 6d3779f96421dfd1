"""Compiled loops of the smooth solver against plain NumPy twins."""

import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from ehl.compile._kernels import factored, product, solve_factored
from ehl.compile.compiler import KERNEL, kernel
from ehl.fluid._kernels import inlet_laws, log_mobility
from ehl.fluid.lookup import law_table
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.rheology import LinearStress, ShearLaw
from ehl.smooth import _kernels
from ehl.smooth.continuation import PathReport, easy_start
from ehl.smooth.mesh import Features, grade
from ehl.smooth.newton import NewtonFactors, NodeGrid, solve_level
from ehl.smooth.scaling import Offset, ScaledContact

FEATURES = Features(0.1, 1.05, -1.0, 0.2, 0.95, 0.03)
PRESSURE = 1e9
HEATED = np.linspace(-3.0, 1.2, 600)
WARM = Offset(HEATED, np.exp(-((HEATED - np.array([[0.0], [0.1], [-0.2]])) ** 2)) * np.array([[-0.4], [-0.1], [-0.2]]))
OILS = {
    "barus": Lubricant(0.02, 1.5e-8, viscosity_law="barus"),
    "roelands": Lubricant(0.02, 1.5e-8),
    "modulus": Lubricant(0.02, 1.5e-8, viscosity_law="modulus", modulus_constants=(5e7, 0.0, 0.03, 0.0)),
}


def scaled(law="roelands", gamma=0.3, cross=0.6, offset=None, stiffness=1.0):
    table = law_table(OILS[law], PRESSURE, heated=False)
    return ScaledContact(0.02, table, gamma, cross, 10.0, stiffness, offset)


def weights(case, n, along=1.0, across=1.0):
    """Of the mobilities along and across the sliding, with their shares."""
    cross = np.full(n, case.cross)
    return cross * along, cross * (along - across) + (1.0 - cross) * across


def nodal_state(case, p, h, offset):
    state = np.empty((_kernels.ROWS, p.size))
    _kernels.nodal_state(case.groups, p, h, offset, *weights(case, p.size), state)
    return state[_kernels.RHO :]


@pytest.fixture(scope="module")
def grid():
    grading = grade(FEATURES)
    return NodeGrid.of(grading, grading.points(2 * 49 - 1))


def unknowns(grid, seed=0):
    rng = np.random.default_rng(seed)
    pressure = np.sqrt(np.clip(1.0 - grid.nodes**2, 0.0, None)) + 0.02 * rng.random(grid.nodes.size)
    pressure[-1] = 0.0
    return np.append(pressure, [0.4, 0.1, 1.01])  # film constant, flow, stretch


def evaluated(grid, case, u):
    """State and residual, or None outside the domain."""
    state, residual = np.empty((_kernels.ROWS, grid.nodes.size)), np.empty(grid.nodes.size + 1)
    upstream = _kernels.tail(grid.mesh.x_in, case.groups)[1]
    return (state, residual) if _kernels.evaluate(grid.mesh, case.groups, upstream, u, state, residual) else None


def twin_log_kernel(s):
    """Integral of ln|s_i - t| times the hat functions, from the twice integrated logarithm, all pairs at once."""
    r = s[:, None] - s[None, :]
    with np.errstate(divide="ignore", invalid="ignore"):
        second = np.where(r == 0.0, 0.0, 0.5 * r * r * np.log(np.abs(r)) - 0.75 * r * r)
        first = np.where(r == 0.0, 0.0, r * np.log(np.abs(r)) - r)
    slope = np.diff(second, axis=1) / np.diff(s)
    kernel = np.zeros_like(r)
    kernel[:, :-1] += slope
    kernel[:, 1:] -= slope
    kernel[:, 0] += first[:, 0]
    kernel[:, -1] -= first[:, -1]
    return kernel


def test_log_kernel(grid):
    twin = twin_log_kernel(grid.nodes)
    np.testing.assert_allclose(_kernels.log_kernel(grid.nodes), twin, rtol=1e-9, atol=1e-10)


def test_log_kernel_of_a_constant_pressure(grid):
    s = grid.nodes[1:-1]
    left, right = s - grid.nodes[0], grid.nodes[-1] - s
    exact = left * (np.log(left) - 1.0) + right * (np.log(right) - 1.0)
    np.testing.assert_allclose(_kernels.log_kernel(grid.nodes).sum(axis=1)[1:-1], exact, rtol=1e-9, atol=1e-9)


def twin_nodal_state(case, oil, p, h, offset):
    gamma, cross = case.gamma, case.cross
    log_eta = case.stiffness * oil.log_viscosity_ratio(PRESSURE * p) + offset
    rho = oil.density_ratio(PRESSURE * p)
    ratio = gamma / h * np.exp(log_eta)
    angle = np.arcsinh(ratio)
    across = np.sinh(angle) / angle if gamma > 0.0 else 1.0
    return rho, log_eta, np.exp(-log_eta) * (cross * np.cosh(angle) + (1.0 - cross) * across)


@pytest.mark.parametrize("law", OILS)
@pytest.mark.parametrize(("gamma", "cross"), [(0.0, 1.0), (0.3, 1.0), (0.3, 0.0), (1e-3, 0.4), (20.0, 0.4)])
def test_nodal_state(law, gamma, cross):
    case = scaled(law, gamma, cross, stiffness=0.7)
    p, h, offset = np.linspace(0.0, 1.3, 40), np.linspace(3.0, 0.05, 40), np.linspace(-0.5, 0.2, 40)

    def state(p, h, offset):
        return nodal_state(case, p, h, offset)

    values = state(p, h, offset)
    for mine, twin in zip(
        (values[0], values[2], values[3]), twin_nodal_state(case, OILS[law], p, h, offset), strict=True
    ):
        np.testing.assert_allclose(mine, twin, rtol=2e-8, atol=1e-8)
    step = 1e-6
    centre = p + 1e-3, h, offset
    slopes = [state(*centre)[i] for i in (1, 4, 5, 6)]
    for slope, place, output in zip(slopes, (0, 0, 1, 2), (0, 3, 3, 3), strict=True):
        up, down = list(centre), list(centre)
        up[place], down[place] = up[place] + step, down[place] - step
        twin = (state(*up)[output] - state(*down)[output]) / (2.0 * step)
        np.testing.assert_allclose(slope, twin, rtol=2e-6, atol=1e-9 * np.abs(twin).max() + 1e-15)


@pytest.mark.parametrize("cross", [0.0, 0.4, 1.0])
def test_nodal_state_with_a_stress_that_rises_with_pressure(cross):
    """The short form against the general law in logarithms, whose directions add with the weights of a hot film."""
    shear = ShearLaw("eyring", LinearStress(4e6, 0.02)).numbers(PRESSURE, 5e6, 0.01)
    case = replace(scaled(cross=cross), shear=shear)
    p, h, offset = np.linspace(0.0, 1.3, 40), np.geomspace(3.0, 0.01, 40), np.linspace(-0.5, 0.2, 40)
    state = np.empty((_kernels.ROWS, p.size))
    shares = 0.9, 0.7
    _kernels.nodal_state(case.groups, p, h, offset, *weights(case, p.size, *shares), state)
    for i in range(p.size):
        _, slope, _, _ = inlet_laws(p[i], case.table)
        twin = np.zeros(4)
        for along, (weight,) in zip((1.0, 0.0), weights(case, 1, *shares), strict=True):
            value, *by = log_mobility(state[_kernels.LOG_ETA, i], case.gamma, h[i], p[i], along, shear)
            slopes = 1.0, by[0] * slope * case.stiffness + by[2], by[1] / h[i], by[0]
            twin += weight * np.exp(value) * np.array(slopes)
        np.testing.assert_allclose(state[_kernels.F : _kernels.F_X + 1, i], twin, rtol=1e-9, atol=1e-12 * twin[0])


def test_nodal_state_below_zero_pressure_continues_the_tangent():
    case = scaled()
    near = nodal_state(case, np.array([-1e-7, 1e-7]), np.ones(2), np.zeros(2))
    for values in near:
        assert values[0] == pytest.approx(values[1], rel=1e-5, abs=1e-5)


@pytest.mark.parametrize("count", [49, 97, 385])
def test_points_are_uniform_in_the_integral_of_the_density(count):
    grading = grade(Features(1e-3, 1.0, -1.0, 0.01, 0.98, 0.001))
    x, (centre, width, amount) = grading.points(count), grading.terms
    integral = np.arctan((x[:, None] - centre) / width) @ amount
    np.testing.assert_allclose(integral, np.linspace(integral[0], integral[-1], count), atol=1e-6)
    assert (x[0], x[-1]) == (grading.x_in, grading.x_exit)
    assert np.all(np.diff(x) > 0.0)


def test_sharpest_curvature(grid):
    x, p = grid.nodes, np.exp(-((grid.nodes + 0.8) ** 2) / 0.02)
    bend = np.abs(np.diff(np.diff(p) / np.diff(x))) / (0.5 * (x[2:] - x[:-2]))
    length = np.sqrt(np.maximum(p[1:-1], 0.4) / np.maximum(bend, 1e-12))
    inside = (x[1:-1] > -2.0) & (x[1:-1] < -0.5)
    k = np.flatnonzero(inside)[np.argmin(length[inside])]
    assert _kernels.sharpest(x, p, 0.4, -2.0, -0.5) == pytest.approx((x[1 + k], length[k]), rel=1e-12)
    assert _kernels.sharpest(x, p, 0.4, 5.0, 6.0)[1] == 0.0


def test_monotone_cubic_is_that_of_scipy():
    rng = np.random.default_rng(3)
    for _ in range(20):
        x, y = np.sort(rng.random(12)), rng.normal(size=12)
        y[4] = y[5]  # a flat piece
        twin = PchipInterpolator(x, y)
        at = np.sort(np.append(x, rng.uniform(x[0], x[-1], 60)))
        values, _ = _kernels.monotone_cubic(x, y, at)
        np.testing.assert_allclose(values, twin(at), rtol=1e-11, atol=1e-12)
        inside = np.sort(rng.uniform(x[0], x[-1], 60))
        np.testing.assert_allclose(
            _kernels.monotone_cubic(x, y, inside)[1], twin.derivative()(inside), rtol=1e-8, atol=1e-7
        )
        outside = _kernels.monotone_cubic(x, y, np.array([x[0] - 1.0, x[-1] + 1.0]))
        assert outside[0] == pytest.approx([y[0], y[-1]], rel=1e-12)
        assert outside[1].tolist() == [0.0, 0.0]


def test_open_inlet():
    x = np.linspace(-40.0, 1.2, 300)
    size = 1.3
    u = np.maximum(-x / size - 1.5, 0.0)
    value, slope = _kernels.open_inlet(x, size)
    np.testing.assert_allclose(value, 0.5 * x**2 * u**4 / (1.0 + u**4), rtol=1e-13)
    up, down = (_kernels.open_inlet(x + d, size)[0] for d in (1e-6, -1e-6))
    np.testing.assert_allclose(slope, (up - down) / 2e-6, rtol=1e-6, atol=1e-7)


def twin_residual(x, x_face, size, lam, p, h, flow, rho, f):
    base, base_face = (_kernels.open_inlet(v, size)[0] for v in (x, x_face))
    g = rho * h - base
    face = np.empty(x.size - 1)
    face[0] = 0.5 * (g[0] + g[1])
    face[1:] = 0.375 * g[2:] + 0.75 * g[1:-1] - 0.125 * g[:-2]
    mass = face + base_face
    mean = np.where(np.isclose(f[1:], f[:-1], rtol=1e-6), f[1:], np.diff(f) / np.log(f[1:] / f[:-1]))
    eps = mass**3 * mean / (lam * (0.5 * (rho[1:] + rho[:-1])) ** 2)
    return np.append(eps * np.diff(p) / np.diff(x) - (mass - flow), rho[-1] * h[-1] - flow)


def test_residual(grid):
    case, u = scaled(), unknowns(grid)
    h00, flow, stretch = u[-3:]
    state, residual = evaluated(grid, case, u)
    x = grid.grading.x_in + stretch * (grid.nodes - grid.grading.x_in)
    x_face = grid.grading.x_in + stretch * (grid.faces - grid.grading.x_in)
    film = h00 + 0.5 * x**2 - stretch / np.pi * (twin_log_kernel(grid.nodes) @ u[:-3])
    np.testing.assert_allclose(state[_kernels.X], x, rtol=1e-14)
    np.testing.assert_allclose(state[_kernels.FILM], film, rtol=1e-8)
    rho, f = state[_kernels.RHO], state[_kernels.F]
    twin = twin_residual(x, x_face, grid.grading.features.size, case.lam, u[:-3], film, flow, rho, f)
    np.testing.assert_allclose(residual[:-1], twin, rtol=1e-5, atol=1e-8 * np.abs(twin).max())
    upstream = 2.0 * case.lam / (3.0 * x[0] ** 2)
    assert residual[-1] == pytest.approx(stretch * (grid.weights @ u[:-3]) + upstream - 0.5 * np.pi, rel=1e-12)


def test_residual_refuses_a_closed_film(grid):
    u = unknowns(grid)
    u[-3] = -5.0
    assert evaluated(grid, scaled(), u) is None


@pytest.mark.parametrize("law", OILS)
@pytest.mark.parametrize("offset", [None, WARM], ids=["cold", "hot"])
def test_jacobian_is_the_derivative_of_the_residual(grid, law, offset):
    case, u = scaled(law, offset=offset), unknowns(grid, list(OILS).index(law))
    n = grid.nodes.size
    matrix, scale = np.empty((n + 1, n + 1)), np.empty(n + 1)
    _kernels.jacobian(grid.mesh, case.lam, u, evaluated(grid, case, u)[0], matrix, scale)
    for column in [0, 1, 7, n // 2, n - 4, n - 3, n - 2, n - 1, n]:
        place = column + 1 if column < n - 2 else column + 2  # the pressure at both ends is no unknown
        step = 1e-6 * np.eye(n + 3)[place]
        slope = (evaluated(grid, case, u + step)[1] - evaluated(grid, case, u - step)[1]) / 2e-6
        # solving for the slope returns the unit vector
        back = np.linalg.solve(matrix, scale * slope)
        np.testing.assert_allclose(back, np.eye(n + 1)[column], atol=2e-5)


def twin_newton(grid, case, u):
    """Undamped, every matrix made anew, solved by NumPy."""
    n = grid.nodes.size
    u, matrix, scale = u.copy(), np.empty((n + 1, n + 1)), np.empty(n + 1)
    u[0] = _kernels.tail(grid.mesh.x_in, case.groups)[0]
    for _ in range(40):
        state, residual = evaluated(grid, case, u)
        _kernels.jacobian(grid.mesh, case.lam, u, state, matrix, scale)
        step = np.linalg.solve(matrix, -scale * residual)
        u[1 : n - 1] += step[: n - 2]
        u[n:] += step[n - 2 :]
        if np.abs(step).max() < 1e-12:
            return u
    raise AssertionError("not converged")


@pytest.mark.parametrize("offset", [None, WARM], ids=["cold", "hot"])
def test_newton_finds_the_root_of_its_twin(offset):
    near, easy = easy_start(scaled(), 49, PathReport())
    case = replace(easy, offset=offset)
    level = solve_level(near.grid, case, near.unknowns)
    found = np.append(level.unknowns.pressure, [level.unknowns.h00, level.unknowns.flow, level.unknowns.stretch])
    away = found.copy()
    away[1:-4] *= 1.0 + 1e-3 * np.cos(np.arange(found.size - 5))
    np.testing.assert_allclose(found, twin_newton(near.grid, case, away), rtol=1e-8, atol=1e-9)
    assert level.mass_residual < 1e-8
    assert level.load_residual < 1e-8


def test_newton_says_why_it_ends(grid):
    case, u = scaled(), unknowns(grid)
    state, residual = np.empty((_kernels.ROWS, grid.nodes.size)), np.empty(grid.nodes.size + 1)
    factors = NewtonFactors(grid)
    work = factors.matrix, factors.scale, factors.pivots

    def end(u, most=40):
        return _kernels.newton(grid.mesh, case.groups, u, 1e-8, most, state, residual, *work, False)[0]

    assert end(u.copy(), most=1) in (_kernels.LIMIT, _kernels.EXHAUSTED)
    closed = u.copy()
    closed[-3] = -1e3
    assert end(closed) == _kernels.INFEASIBLE
    nothing = u.copy()
    nothing[3] = np.nan
    assert end(nothing) == _kernels.INFEASIBLE


def test_newton_from_the_factors_of_a_similar_contact():
    """The same root, with fewer matrices; factors of another contact are given up."""
    near, easy = easy_start(scaled(), 49, PathReport())
    case = replace(easy, offset=WARM)
    warmer = replace(easy, offset=Offset(HEATED, 1.025 * WARM.rows))
    factors = NewtonFactors(near.grid)
    first = solve_level(near.grid, case, near.unknowns, factors=factors)
    assert factors.known
    plain = solve_level(near.grid, warmer, first.unknowns)
    found = solve_level(near.grid, warmer, first.unknowns, factors=factors)
    assert found.iterations < plain.iterations
    factors.matrix[:] = np.eye(near.grid.nodes.size + 1)
    factors.pivots[:] = np.arange(1, factors.pivots.size + 1)
    anew = solve_level(near.grid, warmer, first.unknowns, factors=factors)
    assert anew.iterations == plain.iterations
    for level in (found, anew):
        np.testing.assert_allclose(level.unknowns.pressure, plain.unknowns.pressure, atol=1e-9)
        assert level.unknowns.flow == pytest.approx(plain.unknowns.flow, rel=1e-8)


SOLVE = """
from ehl import Contact
print(Contact(pressure_hertz=1e9, radius_equivalent=15e-3, speed_entrainment=5.0, slide_to_roll=0.3,
              temperature_oil="90 degC", oil="fva3", accuracy="fast", thermal="on").solve().friction_coefficient)
"""


@kernel(cache=False, **KERNEL)
def solved(matrix, right):
    """Solution, what is left of the right side, and whether there is one."""
    n = right.size
    factors, pivots, x, left = matrix.copy(), np.empty(n, np.int32), right.copy(), np.empty(n)
    good = factored(factors, pivots)
    if good:
        solve_factored(factors, pivots, x)
    product(matrix, x, left)
    return good, x, left


def test_solution_by_the_factors_of_the_transposed_matrix():
    rng = np.random.default_rng(0)
    matrix, right = rng.standard_normal((31, 31)), rng.standard_normal(31)
    good, x, left = solved(matrix, right)
    assert good
    np.testing.assert_allclose(x, np.linalg.solve(matrix, right), rtol=1e-9)
    np.testing.assert_allclose(left, right, rtol=1e-9)


def test_a_singular_matrix_is_told():
    matrix = np.ones((5, 5))
    assert not solved(matrix, np.ones(5))[0]


def test_a_smooth_contact_without_compiler_is_the_same():
    answers = [
        float(
            subprocess.run(
                [sys.executable, "-c", SOLVE], env={**os.environ, **more}, capture_output=True, text=True, check=True
            ).stdout
        )
        for more in ({}, {"NUMBA_DISABLE_JIT": "1"})
    ]
    assert answers[1] == pytest.approx(answers[0], rel=1e-9)
