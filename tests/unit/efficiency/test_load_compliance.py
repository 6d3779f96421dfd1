"""Local compliance from Hertz's stresses, and the tooth around the plate."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from efficiency.contact.tooth_grid import ToothShape
from efficiency.ltca.local_compliance import LocalCompliance, weber_local
from efficiency.ltca.plate import CantileverPlate, PlateTooth
from ehl.common.errors import InputError
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


def shape() -> ToothShape:
    return ToothShape(
        14,
        np.array([0.0, 12e-3, 25e-3]),
        np.array([5e-3, 6e-3, 7e-3]),
        np.array([5e-3, 6e-3, 7e-3]),
        np.array([2e-3, 2.2e-3, 2.5e-3]),
    )


def test_tooth_is_unrolled_along_its_trace() -> None:
    tooth = PlateTooth.from_shape(shape(), np.radians(35.0), np.radians(20.0), STEEL)
    assert tooth.plate.length == pytest.approx(25e-3 / np.cos(np.radians(35.0)))
    assert tooth.depth([12e-3], [0.0]) == pytest.approx(3e-3 / np.cos(np.radians(20.0)))


def test_force_acts_where_its_line_meets_the_middle_plane() -> None:
    angle = np.radians(20.0)
    tooth = PlateTooth.from_shape(shape(), 0.0, angle, STEEL)
    face, height = np.array([12e-3]), np.array([4e-3])
    lowered = height - 0.5 * tooth.plate.thickness(face, height) * np.tan(angle)
    expected = np.cos(angle) ** 2 * tooth.plate.influence(face, lowered)
    np.testing.assert_allclose(tooth.influence(face, height), expected)


def test_points_beyond_an_edge_are_put_on_it() -> None:
    tooth = PlateTooth.from_shape(shape(), 0.0, 0.0, STEEL)
    inside = tooth.influence([0.0, 25e-3], [5e-3, 0.0])
    outside = tooth.influence([-1e-4, 25.1e-3], [5.2e-3, -1e-4])
    np.testing.assert_allclose(outside, inside, rtol=1e-12, atol=0.0)


@pytest.mark.parametrize(
    ("field", "values"),
    [("station", [0.0, 0.0]), ("height", [1e-3, -1e-3]), ("thickness_tip", [1e-3, np.nan])],
)
def test_impossible_plate_is_refused(field: str, values: list[float]) -> None:
    arguments = {
        "station": np.array([0.0, 0.02]),
        "height": np.full(2, 6e-3),
        "thickness_root": np.full(2, 6e-3),
        "thickness_tip": np.full(2, 2e-3),
    }
    arguments[field] = np.array(values)
    with pytest.raises(InputError, match=field):
        CantileverPlate(**arguments, youngs_modulus=E, poisson_ratio=NU)
