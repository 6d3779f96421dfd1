"""Influence coefficients of the line contact and their FFT operator."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

from ehl.common.errors import InputError
from ehl.rough.dry import DeflectionOperator, influence_coefficients

E, STEP = 228e9, 1.3e-6


@pytest.mark.parametrize("distance", [0, 1, 2, 7, 56, 60, 64, 400])
def test_coefficients_against_quadrature(distance):
    kinks = [0.0] if distance == 0 else None
    value, _ = quad(lambda s: math.log(abs(distance - s) * STEP), -0.5, 0.5, points=kinks, epsrel=1e-11, limit=200)
    expected = -4.0 / (math.pi * E) * STEP * value
    assert influence_coefficients(401, STEP, E)[distance] == pytest.approx(expected, rel=1e-9)


def test_uniform_pressure_on_a_band_closed_form():
    count = 201
    operator = DeflectionOperator(count, STEP, E)
    x = STEP * (np.arange(count) - 100)
    a = 100.5 * STEP  # edges of the outermost cells
    v = operator(np.ones(count))
    exact = -4.0 / (math.pi * E) * ((a - x) * np.log(a - x) + (a + x) * np.log(a + x) - 2.0 * a)
    assert_allclose(v, exact, rtol=1e-11)


@pytest.mark.parametrize("arguments", [(1, STEP, E), (10, 0.0, E), (10, STEP, -1.0)])
def test_bad_arguments(arguments):
    with pytest.raises(InputError):
        DeflectionOperator(*arguments)
