"""Dense matrices in compiled loops, with the compiler and without."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

from ehl.compile._kernels import factored, product, solve_factored
from ehl.compile.compiler import KERNEL, kernel

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
