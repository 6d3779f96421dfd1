"""Local compliance from Hertz's stresses."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from efficiency.ltca.local_compliance import LocalCompliance, weber_local
from ehl.material import Material, effective_modulus

STEEL = Material.load("steel")
E, NU = STEEL.youngs_modulus, STEEL.poisson_ratio
MODULUS = effective_modulus(STEEL, STEEL)
RADIUS = 0.012


def half_width(load: float) -> float:
    return float(np.sqrt(8.0 * load * RADIUS / (np.pi * MODULUS)))


@pytest.mark.parametrize("depth_ratio", [0.1, 1.0, 20.0])
def test_local_approach_is_the_integral_of_hertz_strain(depth_ratio: float) -> None:
    load = 3e5
    b = half_width(load)
    peak = 2.0 * load / (np.pi * b)
    z = np.linspace(0.0, depth_ratio, 100001)
    root = np.sqrt(1.0 + z**2)
    strain = (1.0 - NU**2) / E * peak * (1.0 / root - NU / (1.0 - NU) * ((1.0 + 2.0 * z**2) / root - 2.0 * z))
    expected = np.trapezoid(strain, z) * b
    assert weber_local(load, b, depth_ratio * b, E, NU) == pytest.approx(expected, rel=1e-8)


def test_deep_limit_is_webers_formula() -> None:
    load, depth = 2e5, 2.5e-3
    b = half_width(load)
    weber = 2.0 * load * (1.0 - NU**2) / (np.pi * E) * (np.log(2.0 * depth / b) - NU / (2.0 * (1.0 - NU)))
    assert weber_local(load, b, depth, E, NU) == pytest.approx(weber, rel=1e-3)


@given(load=st.floats(1e-3, 5e6), depth=st.floats(1e-4, 1e-2))
def test_slope_is_the_derivative_and_the_law_is_concave(load: float, depth: float) -> None:
    local = LocalCompliance(np.full(3, RADIUS), (np.full(3, depth), np.full(3, 1.3 * depth)), (STEEL, STEEL), MODULUS)
    loads = load * np.array([1.0 - 1e-4, 1.0, 1.0 + 1e-4])
    value, slope = local.approach(loads)
    assert slope[1] == pytest.approx((value[2] - value[0]) / (loads[2] - loads[0]), rel=1e-6)
    assert slope[0] >= slope[2] > 0.0
    assert value[1] > 0.0
