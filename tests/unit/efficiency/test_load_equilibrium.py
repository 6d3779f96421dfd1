"""The complementarity solver against closed forms, an exhaustive search and a general optimiser."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from efficiency.ltca import equilibrium
from efficiency.ltca.equilibrium import solve_equilibrium

FloatArray = np.ndarray


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


def test_two_springs_with_a_gap() -> None:
    """Springs k = 1e6 N/m, arm 0.1 m, gaps 0 and 1 mm: the second one takes part from 100 N m on."""
    args = (np.zeros((2, 2)), springs(1e6), np.array([0.0, 1e-3]), np.array([0.1, 0.1]))
    below = solve_equilibrium(*args, 99.0)
    np.testing.assert_allclose(below.force, [990.0, 0.0])
    above = solve_equilibrium(*args, 300.0)
    np.testing.assert_allclose(above.force, [2000.0, 1000.0])
    assert above.angle == pytest.approx(2e-2)


def test_matches_exhaustive_search_of_active_sets() -> None:
    n, torque = 7, 40.0
    compliance, gap, lever = random_problem(5, n)
    result = solve_equilibrium(compliance, springs(1e8), gap, lever, torque)
    matrix = compliance + np.eye(n) / 1e8
    found = []
    for choice in product((False, True), repeat=n):
        on = np.array(choice)
        if not on.any():
            continue
        size = on.sum()
        system = np.block([[matrix[np.ix_(on, on)], -lever[on][:, None]], [lever[on][None, :], np.zeros((1, 1))]])
        solution = np.linalg.solve(system, np.append(-gap[on], torque))
        force = np.zeros(n)
        force[on] = solution[:size]
        separation = matrix @ force + gap - lever * solution[-1]
        if np.all(force >= 0.0) and np.all(separation >= -1e-15):
            found.append(force)
    assert len(found) == 1
    np.testing.assert_allclose(result.force, found[0], rtol=1e-9, atol=1e-9)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6), n=st.integers(2, 120), torque=st.floats(1e-3, 1e4), scale=st.floats(-12.0, -8.0))
def test_complementarity_and_balance(seed: int, n: int, torque: float, scale: float) -> None:
    compliance, gap, lever = random_problem(seed, n)
    local = logarithmic(10**scale)
    result = solve_equilibrium(compliance, local, gap, lever, torque)
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
    usual = [solve_equilibrium(compliance, springs(1e9), *rest, 30.0) for compliance, *rest in problems]
    monkeypatch.setattr(equilibrium, "_primal_dual", lambda *_: None)
    for (compliance, *rest), expected in zip(problems, usual, strict=True):
        result = solve_equilibrium(compliance, springs(1e9), *rest, 30.0)
        np.testing.assert_allclose(result.force, expected.force, rtol=1e-6, atol=1e-6 * expected.force.max())
        assert (result.status, expected.fallbacks) == ("converged", 0)
        assert result.fallbacks == result.iterations > 0


def test_failure_is_a_status_with_a_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    compliance, gap, lever = random_problem(3, 30)
    monkeypatch.setattr(equilibrium, "NEWTON_LIMIT", 1)
    limited = solve_equilibrium(compliance, logarithmic(1e-8), gap, lever, 30.0)
    assert (limited.status, limited.reason) == ("failed", "newton_limit")
    monkeypatch.setattr(equilibrium, "_primal_dual", lambda *_: None)
    monkeypatch.setattr(equilibrium, "_one_by_one", lambda *_: None)
    stuck = solve_equilibrium(compliance, logarithmic(1e-8), gap, lever, 30.0)
    assert (stuck.status, stuck.reason) == ("failed", "active_set_limit")
