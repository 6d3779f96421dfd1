"""Contact next to a rounded edge against a numerical solution of the plane contact problem, and its limits."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from efficiency.ltca.edge_contact import EdgeSection, edge_angle, free_edge_compliance
from efficiency.ltca.equilibrium import solve_equilibrium
from efficiency.ltca.load_distribution import LocalApproach, weber_local
from ehl.material import Material, effective_modulus


def numerical(distance: float, ratio: float, cells: int = 500) -> tuple[float, float, float]:
    """Peak pressure, approach and half-length of the contact by cells of even pressure, load of Hertz, its units."""
    centre = min(distance, 0.0) * ratio / (1.0 + ratio)
    ends = np.linspace(centre - 1.3, centre + 1.3, cells + 1)
    x, width = 0.5 * (ends[1:] + ends[:-1]), ends[1] - ends[0]
    gap = x**2 + ratio * np.maximum(x - distance, 0.0) ** 2

    def primitive(s: np.ndarray) -> np.ndarray:
        return s * np.log(np.abs(s)) - s

    # displacement (2/pi) ln(1/|x - s|) per load: Hertz then has p = sqrt(1 - x^2)
    kernel = -2.0 / np.pi * (primitive(x[:, None] - ends[None, :-1]) - primitive(x[:, None] - ends[None, 1:]))
    # a constant makes the compliance positive; it shifts the approach only
    shift = 2.0
    result = solve_equilibrium(
        kernel / width + shift,
        lambda force: (1e-12 * force, np.full(force.size, 1e-12)),
        gap,
        np.ones(cells),
        0.5 * math.pi,
    )
    approach = result.angle - shift * 0.5 * math.pi
    loaded = result.force > 0.0
    return float(result.force.max()) / width, approach, 0.5 * width * np.count_nonzero(loaded)


def test_numerical_solution_gives_hertz() -> None:
    peak, approach, half_length = numerical(3.0, 50.0)
    assert peak == pytest.approx(1.0, abs=1e-3)
    assert half_length == pytest.approx(1.0, abs=6e-3)
    assert approach == pytest.approx(0.5 + math.log(2.0), abs=1e-3)


@pytest.mark.parametrize(
    ("distance", "ratio"), [(0.5, 60.0), (0.0, 60.0), (-0.7, 60.0), (0.3, 5.0), (-1.5, 5.0), (-4.0, 5.0)]
)
def test_closed_form_against_cells(distance: float, ratio: float) -> None:
    section = EdgeSection.of([distance], [ratio])
    peak, approach, half_length = numerical(distance, ratio)
    first_touch = min(distance, 0.0) ** 2 * ratio / (1.0 + ratio)
    extra = approach - first_touch - 0.5 - math.log(2.0)
    assert section.pressure_max[0] == pytest.approx(peak, rel=5e-3)
    assert section.approach[0] == pytest.approx(extra, abs=3e-3)
    assert section.half_length[0] == pytest.approx(half_length, rel=0.02)


@pytest.mark.parametrize(("distance", "ratio"), [(0.5, 60.0), (-1.5, 5.0), (-9.0, 60.0)])
def test_pressure_carries_the_load(distance: float, ratio: float) -> None:
    section = EdgeSection.of([distance], [ratio])
    length, a = float(section.half_length[0]), float(section.angle[0])

    def density(t: float) -> float:
        return float(section.pressure(np.array([t]))[0, 0]) * length * math.sin(t)

    total = quad(density, 0.0, math.pi, points=[a] if 0.0 < a < math.pi else None, limit=200)[0]
    assert total == pytest.approx(0.5 * math.pi, rel=1e-7)


def test_limits_are_hertz() -> None:
    """Edge out of the contact: Hertz. Contact on the rounding alone: Hertz with the reduced radius."""
    ratio = np.array([60.0, 60.0])
    section = EdgeSection.of([1.0, -20.0], ratio)
    np.testing.assert_allclose(section.half_length, [1.0, 1.0 / math.sqrt(61.0)], rtol=1e-14)
    np.testing.assert_allclose(section.pressure_max, [1.0, math.sqrt(61.0)], rtol=2e-4)
    np.testing.assert_allclose(section.approach, [0.0, 0.5 * math.log(61.0)], atol=1e-14)


def test_approach_is_continuous_and_its_rate_is_its_derivative() -> None:
    """At fixed e the load goes with b^2 and the approach with b^2 D(e/b): d(b^2 D) = -ln l d(b^2)."""
    ratio = 40.0
    for place in (0.4, -0.2, -1.0, -4.0, -6.3, -6.5):
        squares = np.array([1.0 - 1e-5, 1.0, 1.0 + 1e-5])
        section = EdgeSection.of(place / np.sqrt(squares), np.full(3, ratio))
        values = squares * section.approach
        assert (values[2] - values[0]) / 2e-5 == pytest.approx(float(section.approach_rate[1]), rel=1e-6, abs=1e-9)


def test_angle_solves_its_equation() -> None:
    rng = np.random.default_rng(1)
    distance, ratio = rng.uniform(-8.0, 1.2, 400), 10.0 ** rng.uniform(-1.0, 2.5, 400)
    a, k = edge_angle(distance, ratio), ratio / math.pi
    c, s, length = np.cos(a), np.sin(a), 1.0 / np.sqrt(1.0 + k * (a - np.sin(a) * np.cos(a)))
    wanted = np.clip(distance, -np.sqrt(1.0 + ratio), 1.0)
    np.testing.assert_allclose(length * (c - k * (s - a * c)), wanted, atol=1e-13)


def test_free_face_next_to_it_is_the_side_of_a_wedge() -> None:
    """Strain along the side of a quarter-plane loaded at its corner, less that on the axis of a half-plane.

    Radial stress of Michell's wedge of the angle 2 a, force at 45 deg to its axis:
    cos^2(45)/(a + sin(2 a)/2) + sin^2(45)/(a - sin(2 a)/2).
    """
    a, step = 0.25 * math.pi, 1e-6
    wedge = 0.5 / (a + 0.5 * math.sin(2.0 * a)) + 0.5 / (a - 0.5 * math.sin(2.0 * a))
    near, farther = (float(free_edge_compliance(c, 1e-3, 206e9, 0.3)) for c in (1e-8, 1e-8 * (1.0 + step)))
    assert (near - farther) / step == pytest.approx(0.91 / 206e9 * (wedge - 2.0 / math.pi), rel=1e-5)
    assert float(free_edge_compliance(1.0, 1e-3, 206e9, 0.3)) < 1e-6 * near


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
    depths, one = (np.full(3, depth), np.full(3, 1.3 * depth)), np.ones(3)
    law = LocalApproach(one, np.full(3, RADIUS), depths, 0.0 * one, np.inf * one, one, (STEEL, STEEL), MODULUS)
    loads = load * np.array([1.0 - 1e-4, 1.0, 1.0 + 1e-4])
    value, slope = law(loads)
    assert slope[1] == pytest.approx((value[2] - value[0]) / (loads[2] - loads[0]), rel=1e-6)
    assert slope[0] >= slope[2] > 0.0
    assert value[1] > 0.0
