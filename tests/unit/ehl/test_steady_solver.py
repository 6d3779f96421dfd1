"""What solve_steady promises, and its compiled loops: shear laws, starts, failures, derivatives, Newton's method."""

import dataclasses
import math
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from contacts import line_contact
from refusals import refuses
from scipy.interpolate import PchipInterpolator

from ehl.compile._kernels import factored
from ehl.compile.compiler import KERNEL, kernel
from ehl.contact import Contact
from ehl.fluid._kernels import inlet_laws, log_mobility
from ehl.fluid.lookup import law_table
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.rheology import LinearStress, ShearLaw
from ehl.smooth import _kernels, continuation, scaling
from ehl.smooth.continuation import PathReport, easy_start
from ehl.smooth.mesh import Features, grade
from ehl.smooth.newton import NewtonFactors, NodeGrid, solve_level
from ehl.smooth.scaling import Offset, ScaledContact
from ehl.smooth.solver import FALLBACKS, REASONS, solve_steady

OIL = Lubricant(0.02, 1.8e-8, "roelands", rheology="eyring", eyring_stress=5e6)


def contact(pressure=1.0e9, radius=0.01, speed=5.0, slip=0.3, lengthwise=0.0):
    state = {"radius_equivalent": radius, "effective_modulus": 2.264e11, "pressure_hertz": pressure}
    return line_contact(**state, speed_entrainment=speed, slide_to_roll=slip, speed_sliding_lengthwise=lengthwise)


def test_sliding_along_and_across_share_the_shear_law_not_the_film():
    across = solve_steady(contact(slip=0.5), OIL, accuracy="reference")
    along = solve_steady(contact(slip=0.0, lengthwise=2.5), OIL, accuracy="reference")
    for result in (across, along):
        law = OIL.shear_stress(result.pressure, result.film, 2.5)
        np.testing.assert_allclose(result.shear_stress, law, rtol=1e-7)  # the solver reads its table
    # the flow along x sees cosh(S) in one case and sinh(S)/S < cosh(S) in the other
    assert along.film_min > across.film_min * (1.0 + 20.0 * across.film_error)
    newtonian = dataclasses.replace(OIL, rheology="newtonian")
    films = [solve_steady(contact(slip=s, lengthwise=v), newtonian).film_central for s, v in ((0.02, 0.0), (0.0, 0.1))]
    assert films[0] == pytest.approx(films[1], rel=1e-10)


def test_far_start_falls_back_to_the_path():
    base = solve_steady(contact(), OIL)
    far = contact(pressure=2.4e9, radius=0.05, speed=0.3)
    result = solve_steady(far, OIL, start=base)
    assert result.status == "converged"
    assert set(result.fallbacks) <= set(FALLBACKS)
    assert result.film_central == pytest.approx(solve_steady(far, OIL).film_central, rel=2e-3)


@pytest.mark.parametrize(
    ("pressure", "speed", "viscosity", "alpha"),
    [
        (0.3e9, 20.0, 0.15, 2.5e-8),
        (0.1e9, 60.0, 2.0, 3.5e-8),
        (2.5e9, 0.2, 0.003, 1.0e-8),
        (3.0e9, 0.05, 0.002, 8e-9),
        (1e9, 5.0, 0.02, 0.0),
    ],
)
def test_corners_of_the_gear_range_and_beyond(pressure, speed, viscosity, alpha):
    oil = dataclasses.replace(OIL, viscosity_inlet=viscosity, pressure_viscosity=alpha)
    result = solve_steady(contact(pressure=pressure, speed=speed), oil)
    assert result.status == "converged"
    assert 0.0 < result.film_min <= result.film_central * (1.0 + 1e-6) < math.inf
    assert result.pressure.min() >= 0.0
    assert result.film_error < 5e-3
    assert result.mass_residual < 1e-6
    assert result.load_residual < 1e-10


def hard(pressure, radius, speed, viscosity, alpha, slip=0.0):
    """A fast or thin contact of a steep Roelands oil; z = alpha 1.96e8/(ln eta0 + 9.67) of 1.7 and more."""
    return contact(pressure, radius, speed, slip), Lubricant(viscosity, alpha, "roelands")


HARD = {
    "M = 18, ln eta = 148": hard(1.031e9, 0.01034, 52.0, 0.00115, 3.19e-8, 0.33),
    "M = 620, ln eta = 553": hard(3.070e9, 0.0220, 6.55, 0.00132, 2.87e-8),
    "M = 670, ln eta = 1240": hard(3.451e9, 0.0394, 12.5, 0.0017, 3.40e-8),
    "M = 3600, ln eta = 355": hard(2.659e9, 0.2194, 0.607, 0.00238, 3.17e-8, 0.5),
}


@pytest.mark.parametrize("name", HARD)
def test_rounding_of_the_spike_is_covered_by_its_error(name, monkeypatch):
    line, oil = HARD[name]
    result = solve_steady(line, oil, accuracy="fast")
    assert result.status == "converged"
    assert result.fallbacks[:1] == ("spike_rounded",)
    assert result.film_error < 0.02
    monkeypatch.setattr(scaling, "ROUNDING", 1e-4)  # a thirtieth, on a mesh three times as fine
    sharp = solve_steady(line, oil, accuracy="reference")
    for value in ("film_central", "film_min"):
        allowed = getattr(result, f"{value}_error") + getattr(sharp, f"{value}_error")
        assert getattr(result, value) == pytest.approx(getattr(sharp, value), rel=allowed)


def test_rounding_leaves_a_film_alone_that_shears():
    scene = scaling.scaled_contact(contact(slip=0.1), OIL)
    assert scene.rounded().gamma == scene.gamma > scene.rounding > 0.0
    still = scaling.scaled_contact(contact(slip=0.0), OIL)
    assert still.gamma == 0.0
    assert still.rounded(2.0).gamma == 2.0 * still.rounding
    rolling = solve_steady(contact(slip=0.0), OIL)
    assert (rolling.friction_fluid, rolling.friction_error) == (0.0, 0.0)
    assert rolling.rolling_traction > 0.0


def test_a_rounded_neighbour_is_met_without_its_path():
    line, oil = HARD["M = 620, ln eta = 553"]
    first = solve_steady(line, oil, accuracy="fast")
    moved = dataclasses.replace(line, speed_entrainment=1.02 * line.speed_entrainment)
    warm, cold = (solve_steady(moved, oil, accuracy="fast", start=start) for start in (first, None))
    assert warm.fallbacks == ("spike_rounded",)
    assert warm.iterations < 0.3 * cold.iterations
    assert warm.film_min == pytest.approx(cold.film_min, rel=warm.film_min_error + cold.film_min_error)


def test_thin_film_of_a_steep_oil_with_little_shear():
    # M = 2600, ln eta up to 1070: the path must not pass Newtonian contacts
    oil = Lubricant(0.00148, 3.24e-8, "roelands", rheology="eyring", eyring_stress=2.32e6)
    line = contact(3.354e9, 0.0882, 1.844, 0.81)
    result, reference = (solve_steady(line, oil, accuracy=accuracy) for accuracy in ("fast", "reference"))
    assert result.fallbacks == ()
    assert result.film_min == pytest.approx(reference.film_min, rel=result.film_min_error + reference.film_min_error)


def test_failure_is_a_status_with_a_reason_and_no_nan(monkeypatch):
    assert solve_steady(contact(speed=0.0), OIL).reason == "no_entrainment"
    with refuses("accuracy"):
        solve_steady(contact(), OIL, accuracy="best")
    monkeypatch.setattr(continuation, "MAX_ITERATIONS", 3)
    result = solve_steady(contact(), OIL)
    assert result.fallbacks == ()
    assert result.status == "failed"
    assert result.reason in REASONS
    assert not any(number != number for number in dataclasses.astuple(result) if isinstance(number, float))
    assert math.isinf(result.film_error)
    assert result.film_central == 0.0


def test_a_path_whose_last_step_has_no_first_iterate_ends():
    """Near its end the path steps to the end; a step that failed is shortened all the same."""
    keys = {"pressure_hertz": 6.3032e9, "radius_equivalent": 0.3773327, "speed_entrainment": 0.0016570174}
    keys |= {"slide_to_roll": -0.000131044, "speed_sliding_lengthwise": 41.316371}
    found = Contact(oil="fva2a", temperature_oil=324.8745942354202, accuracy="fast", **keys).solve()
    assert (found.status, found.reason in REASONS) == ("failed", True)


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


def test_log_kernel_of_a_constant_pressure(grid):
    s = grid.nodes[1:-1]
    left, right = s - grid.nodes[0], grid.nodes[-1] - s
    exact = left * (np.log(left) - 1.0) + right * (np.log(right) - 1.0)
    np.testing.assert_allclose(_kernels.log_kernel(grid.nodes).sum(axis=1)[1:-1], exact, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("gamma", [1e-3, 0.3, 20.0])
@pytest.mark.parametrize("cross", [0.0, 0.4, 1.0])
def test_nodal_state_with_a_stress_that_rises_with_pressure(gamma, cross):
    """The short form against the general law in logarithms, whose directions add with the weights of a hot film."""
    shear = ShearLaw("eyring", LinearStress(4e6, 0.02)).numbers(PRESSURE, 5e6, 0.01)
    case = replace(scaled(gamma=gamma, cross=cross, stiffness=0.7), shear=shear)
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


def test_monotone_cubic_is_that_of_scipy():
    rng = np.random.default_rng(3)
    for _ in range(20):
        x, y = np.sort(rng.random(12)), rng.normal(size=12)
        y[4] = y[5]  # a flat piece
        twin, at = PchipInterpolator(x, y), np.sort(rng.uniform(x[0], x[-1], 60))
        values, slopes = _kernels.monotone_cubic(x, y, np.concatenate(([x[0] - 1.0], at, [x[-1] + 1.0])))
        np.testing.assert_allclose(values, [y[0], *twin(at), y[-1]], rtol=1e-11, atol=1e-12)
        np.testing.assert_allclose(slopes, [0.0, *twin.derivative()(at), 0.0], rtol=1e-8, atol=1e-7)


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


def test_newton_says_why_it_ends(grid):
    case, u = scaled(), unknowns(grid)
    state, residual = np.empty((_kernels.ROWS, grid.nodes.size)), np.empty(grid.nodes.size + 1)
    factors = NewtonFactors(grid)
    work = factors.matrix, factors.scale, factors.pivots

    def end(place, value, most=40):
        start = u.copy()
        start[place] = value
        return _kernels.newton(grid.mesh, case.groups, start, 1e-8, most, state, residual, *work, False)[0]

    assert end(-1, u[-1], most=1) in (_kernels.LIMIT, _kernels.EXHAUSTED)
    assert end(-3, -5.0) == end(-3, -1e3) == end(3, np.nan) == _kernels.INFEASIBLE  # closed films, no number


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
def has_factors(matrix):
    return factored(matrix, np.empty(len(matrix), np.int32))


def test_a_singular_matrix_has_no_factors():
    assert has_factors(np.eye(5))
    assert not has_factors(np.ones((5, 5)))


def test_a_smooth_contact_without_compiler_is_the_same():
    options = {"capture_output": True, "text": True, "check": True}
    surroundings = (os.environ, os.environ | {"NUMBA_DISABLE_JIT": "1"})
    runs = [subprocess.run([sys.executable, "-c", SOLVE], env=each, **options) for each in surroundings]
    answers = [float(run.stdout) for run in runs]
    assert answers[1] == pytest.approx(answers[0], rel=1e-9)
