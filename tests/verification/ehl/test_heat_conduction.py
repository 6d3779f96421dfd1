"""Moving heat sources: closed forms, the exact band source of Jaeger, and an independent solution in depth."""

import itertools
import math

import numpy as np
import pytest
from contacts import BEARING_STEEL as STEEL
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.special import k0e
from twins.material_points import material_point_matrix

from ehl.heat.conduction import jaeger_matrix

B = 2e-4


def speed(peclet: float) -> float:
    return 2.0 * peclet * STEEL.thermal_diffusivity / B


def band(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes from -2 b to 3 b with a unit flux on the band, its steps a 1e-9 b wide."""
    x = np.concatenate([np.linspace(-2, -1 - 1e-9, n // 4), np.linspace(-1, 1, n), np.linspace(1 + 1e-9, 3, n // 2)])
    return x * B, (np.abs(x) <= 1.0).astype(float)


def jaeger_band(x: float, peclet: float) -> float:
    """Rise under a unit band flux, times k/b, by adaptive quadrature of the kernel."""
    marks = [x - 1.0, x + 1.0]
    marks += [c for c in (-3 / peclet, -0.1 / peclet, 0.0, 0.1 / peclet, 3 / peclet) if x - 1 < c < x + 1]
    marks.sort()

    def kernel(s: float) -> float:
        return math.exp(peclet * (s - abs(s))) * float(k0e(peclet * abs(s)))

    parts = [quad(kernel, a, b, epsabs=1e-12, epsrel=1e-10, limit=200)[0] for a, b in itertools.pairwise(marks)]
    return sum(parts) / math.pi


def test_uniform_flux_on_any_mesh_is_exact():
    """And one that is linear over the way of a point."""
    x = np.sort(np.random.default_rng(0).random(60)) * B
    way, matrix = x - x[0], material_point_matrix(x, 3.0, STEEL)
    even = 2.0 * np.sqrt(way / (math.pi * 3.0)) / STEEL.thermal_effusivity
    assert_allclose(matrix @ np.ones_like(x), even, rtol=1e-10)
    assert_allclose(matrix @ way, 2.0 / 3.0 * way * even, rtol=1e-10)


@pytest.mark.parametrize("peclet", [0.5, 1.0, 2.0, 5.0, 10.0, 50.0])
def test_jaeger_matrix_against_quadrature_of_the_band_source(peclet):
    x, flux = band(200)
    rise = jaeger_matrix(x, speed(peclet), STEEL, B) @ flux * STEEL.thermal_conductivity / B
    picked = [20, 45, 60, 120, 200, 245, 260, 300]
    exact = [jaeger_band(x[i] / B, peclet) for i in picked]
    assert_allclose(rise[picked], exact, atol=1e-5 * max(exact))


def test_reversed_motion_mirrors_the_field():
    x = np.linspace(-1.0, 1.0, 41) * B
    flux = 1.0 + 0.5 * x / B
    back, onward = (jaeger_matrix(x, u, STEEL, B) for u in (-5.0, 5.0))
    assert_allclose(back @ flux, (onward @ flux[::-1])[::-1], rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize(("peclet", "excess"), [(0.5, 0.22), (1.0, 0.14), (2.0, 0.08), (5.0, 0.04), (50.0, 0.006)])
def test_error_of_one_dimensional_conduction(peclet, excess):
    # the figures behind the warning below Peclet number 2
    x, flux = band(200)
    exact = (jaeger_matrix(x, speed(peclet), STEEL, B) @ flux).max()
    simple = (material_point_matrix(x, speed(peclet), STEEL) @ flux).max()
    assert simple / exact - 1.0 == pytest.approx(excess, abs=0.005)
