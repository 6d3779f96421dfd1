"""Compiled loops of the steady heat balance against plain NumPy twins."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from contacts import effective_rise
from numpy.testing import assert_allclose
from scipy.linalg.lapack import dgetrs
from scipy.special import k0e, k1e

from ehl.fluid.lubricant import PAO, Lubricant
from ehl.fluid.viscosity import ModulusLaw
from ehl.heat import _kernels, conduction
from ehl.heat.traction import film_temperature, flux_to_surface_1
from ehl.material import Material
from ehl.smooth.mesh import Features, grade

PLACES = grade(Features(0.1, 1.05, -1.0, 0.2, 0.95, 0.003)).points(81)


def twin_moving_kernel(place):
    """From the closed integrals of exp(t) K0(|t|) and t exp(t) K0(|t|), all pairs at once."""
    z = place[:, None] - place[None, :]
    r = np.where(z == 0.0, 1.0, np.abs(z))
    k0, k1, decay = k0e(r), k1e(r), np.exp(-2.0 * np.minimum(r, 350.0))
    zeroth = np.where(z > 0.0, r * (k0 + k1) - 1.0, -(decay * r * (k0 - k1) + 1.0))
    first = np.where(z > 0.0, r * (r * (k0 + k1) - k1) + 1.0, decay * r * (r * (k0 - k1) - k1) + 1.0) / 3.0
    zeroth, first = np.where(z == 0.0, 0.0, zeroth), np.where(z == 0.0, 0.0, first)
    i0, i1 = -np.diff(zeroth, axis=1), -np.diff(first, axis=1)
    matrix = np.zeros_like(z)
    matrix[:, :-1] += (i1 - z[:, 1:] * i0) / np.diff(place)
    matrix[:, 1:] += (z[:, :-1] * i0 - i1) / np.diff(place)
    return matrix


@pytest.mark.parametrize("peclet", [1e-3, 0.1, 5.0, 500.0, 1e5])
def test_moving_kernel(peclet):
    place = peclet * PLACES
    matrix, twin = conduction._moving_kernel(place), twin_moving_kernel(place)
    # the closed forms themselves lose digits in small cells
    assert_allclose(matrix, twin, rtol=1e-7, atol=1e-7 * np.abs(twin).max())
    flux = np.sqrt(np.clip(1.0 - PLACES**2, 0.0, None))
    assert_allclose(matrix @ flux, twin @ flux, rtol=1e-9, atol=1e-12 * np.abs(twin @ flux).max())


@pytest.mark.parametrize("edge", [2.0**_kernels.LOWEST, 2.0**_kernels.HIGHEST])
def test_moving_kernel_beyond_the_table(edge):
    """Two nodes a little nearer, or farther apart, than the table of Bessel functions reaches."""
    for distance in (0.5 * edge, 0.9 * edge, 1.1 * edge, 2.0 * edge):
        place = np.array([0.0, distance])
        matrix, twin = conduction._moving_kernel(place), twin_moving_kernel(place)
        # the closed forms themselves lose 1e-16 over the distance
        assert_allclose(matrix, twin, rtol=1e-6, atol=1e-14 / distance)


def test_table_of_bessel_functions_keeps_its_digits():
    r = np.exp(np.random.default_rng(0).uniform(math.log(1e-8), math.log(1e8), 4000))
    mantissa, exponent = np.frexp(r)
    part = (mantissa - 0.5) * 2.0 * _kernels.PER_DOUBLING
    cell = (exponent - 1 - _kernels.LOWEST) * _kernels.PER_DOUBLING + part.astype(int)
    t = 2.0 * (part % 1.0) - 1.0
    rows = conduction._bessel_table()[cell]
    values = sum(rows[:, -1 - power] * t[:, None] ** power for power in range(rows.shape[1]))
    assert_allclose(values, np.column_stack([k0e(r), r * k1e(r)]), rtol=1e-13)


def twin_flow_heat(x, pressure, film, density, length, speed):
    slope = np.gradient(pressure, x, edge_order=2)
    inlet = (x < 0.0) & (np.maximum.accumulate(pressure) < 0.1 * pressure.max()) & (pressure > 0.0)
    if np.count_nonzero(inlet) > 3:
        power = np.gradient(np.log(pressure[inlet]), np.log(-x[inlet]), edge_order=2)
        slope[inlet] = pressure[inlet] / x[inlet] * power
    freed = np.maximum(speed * (film - film[-1] / density) * slope, 0.0)
    stored = np.zeros_like(x)
    for i in range(1, x.size):
        middle = 0.5 * (length[i] + length[i - 1])
        decay = np.exp(-(x[i] - x[i - 1]) / middle)
        stored[i] = stored[i - 1] * decay + 0.5 * (freed[i] + freed[i - 1]) * middle * (1.0 - decay)
    return np.where(pressure > 0.0, stored / length, 0.0)


def test_flow_heat():
    x = PLACES * 2e-4
    rng = np.random.default_rng(1)
    pressure = 1e9 * np.where(PLACES < 0.0, 1.0 / (1.0 + PLACES**4), np.sqrt(np.clip(1.0 - PLACES**2, 0.0, None)))
    pressure[3] = 0.0  # a node of no pressure in the inlet
    film = 1e-6 * (1.0 + 0.3 * rng.random(x.size)) + 0.5 * (PLACES * 2e-4) ** 2 / 15e-3
    density, length = 1.0 + 0.2 * pressure / 1e9, 1e-5 * (0.5 + rng.random(x.size))
    found = _kernels.flow_heat(x, pressure, film, density, length, 5.0)
    assert found.max() > 0.0
    assert_allclose(found, twin_flow_heat(x, pressure, film, density, length, 5.0), rtol=1e-9)
    # few nodes before the loaded part: the gradient of the mesh throughout
    short = slice(60, None)
    arguments = x[short], pressure[short], film[short], density[short], length[short], 5.0
    assert_allclose(_kernels.flow_heat(*arguments), twin_flow_heat(*arguments), rtol=1e-9)


MODULUS = ModulusLaw((2.704e7, 8.399e5, 0.0579, -5.921e-4), 373.15, (1000.0, 95.0))


@pytest.mark.parametrize("law", [MODULUS, ModulusLaw(MODULUS.constants, 353.15, beta=0.03)])
def test_compiled_modulus_law(law):
    """Values of the law, its slope and the fall of the slope, on both sides of nine tenths of the pole."""
    pressure, temperature = (g.ravel() for g in np.meshgrid(np.linspace(0.0, 4e9, 41), np.linspace(250.0, 700.0, 46)))
    nodes = np.empty((_kernels.ROWS, pressure.size))
    nodes[_kernels.PRESSURE], nodes[_kernels.TEMPERATURE] = pressure, temperature
    _kernels.modulus_viscosity(nodes, -3.0, law.numbers)
    assert_allclose(nodes[_kernels.LOG_ETA], law.log_ratio(pressure, temperature) - 3.0, rtol=1e-12, atol=1e-12)
    slope, warmer = (law.by_temperature(pressure, temperature + kelvin) for kelvin in (0.0, 1.0))
    assert_allclose(nodes[_kernels.BY_TEMPERATURE], slope, rtol=1e-12)
    loss = np.where(slope < 0.0, np.clip(1.0 - warmer / np.where(slope < 0.0, slope, 1.0), 0.0, 0.2), 0.0)
    assert_allclose(nodes[_kernels.LOSS], loss, atol=1e-12)
    assert np.count_nonzero(loss) > 0


def balanced(speed, surface_speeds, guess=None, tolerance=1e-9, law="roelands"):
    """A hot film with its conduction, on a graded mesh with a dry node in it."""
    x = PLACES[::2] * 2e-4
    steel = Material(
        youngs_modulus=206e9, poisson_ratio=0.3, thermal_conductivity=46.0, heat_capacity=470.0, density=7850.0
    )
    ceramic = steel.model_copy(update={"thermal_conductivity": 20.0, "density": 3200.0})
    modulus = {"modulus_constants": MODULUS.constants, "temperature_constants": MODULUS.vogel}
    oil = Lubricant(0.0106, 15e-9, law, rheology="eyring", limiting_shear_coefficient=0.06, temperature=373.15,
                    temperature_viscosity=0.04, **modulus if law == "modulus" else {})  # fmt: skip
    pressure = 1.2e9 * np.where(x < -2e-4, 0.01, np.sqrt(np.clip(1.0 - (x / 2.1e-4) ** 2, 0.0, None)))
    pressure[[5, -1]] = 0.0
    matrices = tuple(
        conduction.jaeger_matrix(x, u, body, 2e-4) for u, body in zip(surface_speeds, (steel, ceramic), strict=True)
    )
    line = SimpleNamespace(speed_sliding=speed)
    rolling = 1e6 * np.cos(x / 1e-4) ** 2
    bulk = (373.15, 393.15)
    found = film_temperature(
        pressure, 0.4e-6 + x**2 / 0.03, PAO(pressure, oil.thermal_conductivity), line, oil, bulk, matrices,
        rolling_heat=rolling,
        guess=guess, tolerance=tolerance,
    )  # fmt: skip
    return found, oil, matrices


@pytest.mark.parametrize("law", ["roelands", "barus", "modulus"])
@pytest.mark.parametrize("speeds", [(6.0, 4.0), (9.0, 1.0), (8.0, 0.0), (8.0, -4.0)])
def test_stress_and_temperature_fit_each_other(speeds, law):
    """The balance by dense matrices and the laws themselves."""
    found, oil, matrices = balanced(speeds[0] - speeds[1], speeds, law=law)
    assert found.converged
    k_film = PAO(found.pressure, oil.thermal_conductivity)
    division, constant = flux_to_surface_1(k_film / found.film, *matrices, 20.0)
    heat = (speeds[0] - speeds[1]) * found.stress + found.rolling_heat
    into_1 = division @ heat + constant
    walls = 383.15 + 0.5 * (matrices[0] @ into_1 + matrices[1] @ (heat - into_1))
    walls += found.film / (20.0 * k_film) * found.rolling_heat
    assert_allclose(found.walls, walls, rtol=1e-9)
    even = (speeds[0] - speeds[1]) * found.stress * found.film / (8.0 * k_film)
    share, _ = effective_rise(even, -oil.dlog_viscosity_dtemperature(found.pressure, found.temperature))
    assert_allclose(found.temperature, walls + even * share, rtol=1e-8)
    wet = found.pressure > 0.0
    log_viscous = oil.log_viscosity(found.pressure, found.temperature)
    log_viscous += math.log(speeds[0] - speeds[1]) - np.log(found.film)
    assert_allclose(np.log(found.stress[wet]), oil.shear_law.log_stress(log_viscous, found.pressure)[0][wet], atol=1e-8)
    assert np.all(found.stress[~wet] == 0.0)
    # what the matrix of Newton's method is made of where its estimate does not do
    _, *rises = _kernels.divided(found.conducted.walls._replace(difference=0.0), heat)
    assert_allclose(found.conducted.exact() @ heat, 0.5 * sum(rises), rtol=1e-9)


def test_conduction_of_a_film_between_two_bodies():
    """Factors of I + k/h (A1 + A2), and an estimate of the rise that is exact for a constant ratio of both rises."""
    rng, n = np.random.default_rng(0), 12
    first = np.eye(n) + rng.random((n, n))
    second, conductance = 0.4 * first, 0.1 + rng.random(n)
    factors, pivots, weights = np.empty((n, n)), np.empty(n, np.int32), np.empty(n)
    _kernels.conduct(first, second, conductance, factors, pivots, weights)
    system, right = np.eye(n) + conductance[:, None] * (first + second), rng.random(n)
    assert_allclose(dgetrs(factors.T, pivots - 1, right, trans=1)[0], np.linalg.solve(system, right), rtol=1e-9)
    through = conductance * (first + second).sum(axis=1)
    assert_allclose(weights, 0.25 * (1.0 - (0.6 / 1.4) ** 2 * through / (1.0 + through)), rtol=1e-12)


def test_a_near_guess_leads_to_the_same_balance_sooner():
    exact, *_ = balanced(5.0, (7.5, 2.5))
    near = exact.stress * (1.0 + 0.02 * np.cos(np.arange(exact.stress.size))), exact.walls + 2.0
    found, *_ = balanced(5.0, (7.5, 2.5), guess=near)
    assert found.iterations < exact.iterations
    assert_allclose(found.stress, exact.stress, rtol=1e-8)


def test_a_useless_estimate_of_conduction_is_replaced(monkeypatch):
    exact, *_ = balanced(5.0, (7.5, 2.5))
    first = _kernels.conduct

    def useless(*arguments):
        first(*arguments)
        arguments[-1][:] = 1e3

    monkeypatch.setattr(_kernels, "conduct", useless)
    found, *_ = balanced(5.0, (7.5, 2.5))
    assert found.converged
    assert_allclose(found.stress, exact.stress, rtol=1e-8)
