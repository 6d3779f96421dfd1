"""Contact next to an edge against numerical solutions and closed forms; the complementarity solver."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from samples import STEEL

from efficiency.ltca import equilibrium
from efficiency.ltca.edge_contact import EdgeSection, free_edge_compliance
from efficiency.ltca.equilibrium import Equilibrium, EquilibriumProblem, Local, solve_equilibrium
from efficiency.ltca.load_distribution import LocalApproach, weber_local
from ehl.common.arrays import FloatArray
from ehl.material import effective_modulus


def solved(local: Local, *problem: object) -> Equilibrium:
    """Solution of a single problem."""
    return solve_equilibrium([EquilibriumProblem(*problem)], local)[0]


def springs(stiffness: float):
    return lambda force: (force / stiffness, np.full(force.size, 1.0 / stiffness))


def logarithmic(scale: float):
    """Concave, as a Hertz line contact: d = k F ln(1 + F0/F)."""

    def local(force: FloatArray) -> tuple[FloatArray, FloatArray]:
        part = np.log1p(1e6 / force)
        return scale * force * part, scale * (part - 1e6 / (force + 1e6))

    return local


def random_problem(seed: int, n: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    rng = np.random.default_rng(seed)
    place = np.sort(rng.uniform(0.0, 1.0, n))
    compliance = np.exp(-(((place[:, None] - place) / rng.uniform(0.02, 2.0)) ** 2)) * 10 ** rng.uniform(-10, -7)
    gap = np.abs(rng.normal(size=n)) * 10 ** rng.uniform(-8, -4)
    return compliance, gap - gap.min(), rng.uniform(0.02, 0.03, n)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6), n=st.integers(2, 120), torque=st.floats(1e-3, 1e4), scale=st.floats(-12.0, -8.0))
def test_complementarity_and_balance(seed: int, n: int, torque: float, scale: float) -> None:
    """All conditions of contact: with a positive compliance one solution has them."""
    compliance, gap, lever = random_problem(seed, n)
    local = logarithmic(10**scale)
    result = solved(local, compliance, gap, lever, torque)
    assert result.status == "converged"
    assert result.torque_residual < 1e-9
    assert np.all(result.force >= 0.0)
    loaded = result.force > 0.0
    deflection = np.zeros(n)
    deflection[loaded] = local(result.force[loaded])[0] if loaded.any() else 0.0
    separation = compliance @ result.force + deflection + gap - lever * result.angle
    scale_length = result.angle * lever.max()
    assert np.max(np.abs(separation[loaded])) < 1e-9 * scale_length
    assert separation.min() > -1e-9 * scale_length


def test_cycling_falls_back_and_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    problems = [random_problem(seed, 30) for seed in range(25)]
    usual = [solved(springs(1e9), compliance, *rest, 30.0) for compliance, *rest in problems]
    monkeypatch.setattr(equilibrium, "_primal_dual", lambda *_: None)
    for (compliance, *rest), expected in zip(problems, usual, strict=True):
        result = solved(springs(1e9), compliance, *rest, 30.0)
        np.testing.assert_allclose(result.force, expected.force, rtol=1e-6, atol=1e-6 * expected.force.max())
        assert (result.status, expected.fallbacks) == ("converged", 0)
        assert result.fallbacks == result.iterations > 0


def test_failure_is_a_status_with_a_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    compliance, gap, lever = random_problem(3, 30)
    monkeypatch.setattr(equilibrium, "NEWTON_LIMIT", 1)
    limited = solved(logarithmic(1e-8), compliance, gap, lever, 30.0)
    assert (limited.status, limited.reason) == ("failed", "newton_limit")
    monkeypatch.setattr(equilibrium, "_primal_dual", lambda *_: None)
    monkeypatch.setattr(equilibrium, "_one_by_one", lambda *_: None)
    stuck = solved(logarithmic(1e-8), compliance, gap, lever, 30.0)
    assert (stuck.status, stuck.reason) == ("failed", "active_set_limit")


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
    result = solved(springs(1e12), kernel / width + shift, gap, np.ones(cells), 0.5 * math.pi)
    approach = result.angle - shift * 0.5 * math.pi
    loaded = result.force > 0.0
    return float(result.force.max()) / width, approach, 0.5 * width * np.count_nonzero(loaded)


@pytest.mark.parametrize(("distance", "ratio"), [(0.5, 60), (0.0, 60), (-0.7, 60), (0.3, 5), (-1.5, 5), (-4.0, 5)])
def test_closed_form_against_cells(distance: float, ratio: float) -> None:
    section = EdgeSection.of([distance], [ratio])
    peak, approach, half_length = numerical(distance, ratio)
    first_touch = min(distance, 0.0) ** 2 * ratio / (1.0 + ratio)
    extra = approach - first_touch - 0.5 - math.log(2.0)
    assert section.pressure_max[0] == pytest.approx(peak, rel=5e-3)
    assert section.approach[0] == pytest.approx(extra, abs=3e-3)
    assert section.half_length[0] == pytest.approx(half_length, rel=0.02)


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


E, NU = STEEL.youngs_modulus, STEEL.poisson_ratio
MODULUS = effective_modulus(STEEL, STEEL)
RADIUS = 0.012


@pytest.mark.parametrize("depth_ratio", [0.1, 1.0, 20.0])
def test_local_approach_is_the_integral_of_hertz_strain(depth_ratio: float) -> None:
    load = 3e5
    b = float(np.sqrt(8.0 * load * RADIUS / (np.pi * MODULUS)))
    peak = 2.0 * load / (np.pi * b)
    z = np.linspace(0.0, depth_ratio, 100001)
    root = np.sqrt(1.0 + z**2)
    strain = (1.0 - NU**2) / E * peak * (1.0 / root - NU / (1.0 - NU) * ((1.0 + 2.0 * z**2) / root - 2.0 * z))
    expected = np.trapezoid(strain, z) * b
    assert weber_local(load, b, depth_ratio * b, E, NU) == pytest.approx(expected, rel=1e-8)


@given(load=st.floats(1e-3, 5e6), depth=st.floats(1e-4, 1e-2))
def test_slope_is_the_derivative_and_the_law_is_concave(load: float, depth: float) -> None:
    depths, one = (np.full(3, depth), np.full(3, 1.3 * depth)), np.ones(3)
    law = LocalApproach(one, np.full(3, RADIUS), depths, 0.0 * one, np.inf * one, one, (STEEL, STEEL), MODULUS)
    loads = load * np.array([1.0 - 1e-4, 1.0, 1.0 + 1e-4])
    value, slope = law(loads)
    assert slope[1] == pytest.approx((value[2] - value[0]) / (loads[2] - loads[0]), rel=1e-6)
    assert slope[0] >= slope[2] > 0.0
    assert value[1] > 0.0
