"""Dry contact: Hertz, an independent solution of the complementarity problem, the cap."""

import math

import numpy as np
import pytest
from contacts import line_contact
from numpy.testing import assert_allclose
from scipy import linalg, optimize
from scipy.integrate import quad
from scipy.linalg import toeplitz

from ehl.rough.dry import influence_coefficients, solve_dry, uniform_grid
from ehl.surface.roughness import generate_profile

CONTACT = line_contact(speed_entrainment=1.0, slide_to_roll=0.0)
B = CONTACT.half_width


def rough(x: np.ndarray, rms: float, seed: int = 3) -> np.ndarray:
    return generate_profile(rms, 25e-6, 30 * B, x[1] - x[0], seed).heights[: len(x)]


def test_hertz_and_its_order():
    errors = []
    for count in (128, 256, 512, 1024):
        x = uniform_grid(CONTACT, count)
        result = solve_dry(CONTACT, x)
        exact = 1e9 * np.sqrt(np.maximum(1.0 - (x / B) ** 2, 0.0))
        errors.append(np.abs(result.pressure - exact).sum() / exact.sum())
        assert result.status == "converged"
        assert result.load_residual < 1e-13
        assert result.gap_residual < 1e-7
    assert math.log2(errors[0] / errors[-1]) / 3.0 == pytest.approx(1.5, abs=0.1)
    assert result.pressure_max == pytest.approx(1e9, rel=1e-5)
    assert result.contact_length == pytest.approx(2.0 * B, rel=5e-3)


@pytest.mark.parametrize("rms", [0.1e-6, 0.5e-6])
def test_rough_contact_against_least_squares_with_bounds(rms):
    # min p'Kp/2 + g'p over p >= 0 at given load, by another algorithm on the dense matrix
    x = uniform_grid(CONTACT, 192)
    heights = rough(x, rms)
    result = solve_dry(CONTACT, x, heights, tolerance=1e-10)
    step = x[1] - x[0]
    matrix = toeplitz(influence_coefficients(len(x), step, CONTACT.effective_modulus)) * CONTACT.pressure_hertz / 1e-6
    matrix += 1.1 * np.abs(np.linalg.eigvalsh(matrix)[0]) + 1.0  # a level changes nothing at given load
    factor = linalg.cholesky(matrix, lower=True)
    gap = (x**2 / (2.0 * CONTACT.radius_equivalent) - heights) / 1e-6
    weight = 1e5
    system = np.vstack([factor.T, np.full(len(x), weight)])
    total = CONTACT.load_per_length / step / CONTACT.pressure_hertz
    rhs = np.append(-linalg.solve_triangular(factor, gap, lower=True), weight * total)
    pressure = optimize.nnls(system, rhs, maxiter=20000)[0] * CONTACT.pressure_hertz
    assert_allclose(result.pressure, pressure, atol=1e-5 * result.pressure_max)
    assert np.array_equal(result.pressure > 0.0, pressure > 0.0)


@pytest.mark.parametrize("rms", [0.3e-6, 1e-6, 2e-6])
def test_hardness_caps_the_pressure_and_keeps_the_load(rms):
    x = uniform_grid(CONTACT, 512)
    elastic = solve_dry(CONTACT, x, rough(x, rms))
    capped = solve_dry(CONTACT, x, rough(x, rms), hardness=2e9)
    assert elastic.pressure_max > 2e9
    assert capped.status == "converged"
    assert capped.pressure_max == 2e9
    assert capped.load_residual < 1e-12
    assert capped.contact_length >= elastic.contact_length
    assert capped.plastic_length > 0.0
    # yielded nodes overlap, no other does
    assert np.all(capped.gap[capped.pressure == 2e9] < 1e-10)
    assert np.all(capped.gap[capped.pressure < 2e9] > -1e-10)


def test_a_cap_that_is_not_reached_changes_nothing_and_failures_are_statuses():
    x = uniform_grid(CONTACT, 512)
    elastic = solve_dry(CONTACT, x, rough(x, 0.1e-6))
    capped = solve_dry(CONTACT, x, rough(x, 0.1e-6), hardness=1.01 * elastic.pressure_max)
    assert_allclose(capped.pressure, elastic.pressure, atol=1e-5 * elastic.pressure_max)
    assert capped.plastic_length == 0.0
    x = uniform_grid(CONTACT, 256)
    assert solve_dry(CONTACT, x, hardness=1e8).reason == "hardness_too_low"
    assert solve_dry(CONTACT, x, max_iterations=3).reason == "iteration_limit"
    assert solve_dry(CONTACT, uniform_grid(CONTACT, 256, reach=0.9)).reason == "domain_too_small"


@pytest.mark.parametrize("distance", [0, 1, 2, 7, 56, 60, 64, 400])
def test_coefficients_against_quadrature(distance):
    kinks, step = [0.0] if distance == 0 else None, 1.3e-6
    value, _ = quad(lambda s: math.log(abs(distance - s) * step), -0.5, 0.5, points=kinks, epsrel=1e-11, limit=200)
    expected = -4.0 / (math.pi * CONTACT.effective_modulus) * step * value
    found = influence_coefficients(401, step, CONTACT.effective_modulus)[distance]
    assert found == pytest.approx(expected, rel=1e-9)
