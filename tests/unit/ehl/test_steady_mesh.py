"""Graded mesh, outputs and extrapolation of the smooth solver."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from samples import CONTACT

from ehl import Contact
from ehl.fluid.rheology import ShearLaw
from ehl.smooth import _kernels, refine
from ehl.smooth.mesh import Features, grade
from ehl.smooth.newton import FilmShear
from ehl.smooth.refine import FLOOR, extrapolate

positive = st.floats(1e-4, 1e3)


@given(flow=positive, inlet_width=st.floats(1e-3, 1.0), spike=st.floats(0.3, 1.0), spike_width=st.floats(1e-3, 0.3))
def test_points_increase_and_nest(flow, inlet_width, spike, spike_width):
    features = Features(flow, 1.0 + 0.4 * math.sqrt(1.0 + 2.0 * flow), -1.0, inlet_width, spike, spike_width)
    grading = grade(features)
    fine, coarse = grading.points(193), grading.points(97)
    assert fine[0] == grading.x_in
    assert fine[-1] == grading.x_exit
    assert np.all(np.diff(fine) > 0.0)
    np.testing.assert_allclose(fine[::2], coarse, rtol=1e-9, atol=1e-9)


def test_peak_of_a_smooth_maximum_between_nodes():
    for shift in (0.0, 0.2, 0.45, -0.3):
        values = np.cos((np.arange(21) - 10.0 - shift) / 8.0)
        for sign in (1.0, -1.0):
            assert _kernels.peak(sign * values, sign) == pytest.approx(1.0, abs=1e-7)
    assert _kernels.peak(np.array([3.0, 2.0, 1.0, 0.5, 0.2, 0.1]), 1.0) == 3.0


@pytest.mark.parametrize(
    "law",
    [
        ShearLaw("newtonian"),
        ShearLaw("eyring", 5e6),
        ShearLaw("eyring", 5e6, limit_slope=0.02, limit_ambient=1e6),
        ShearLaw("carreau", 5e6, exponent=0.6, limit_slope=0.06, limit="smooth"),
    ],
)
def test_friction_and_rolling_traction_are_integrals_of_stress_and_film(law):
    """Against trapezoids on two thousand times as many points, where linear state between nodes is the contact."""
    shear, x = FilmShear(law, 1e9, 1e-4), np.linspace(-3.0, 1.0, 41)
    p, film = np.clip(1.0 - x**2, 0.0, None) ** 1.5, 0.1 + 0.5 * np.clip(np.abs(x) - 1.0, 0.0, None) ** 2
    log_eta, flow, lam, far = 9.0 * p, 0.1, 0.02, -3.3
    law_numbers, ambient, slope = shear.numbers
    found = _kernels.outputs(x, p, film, log_eta, flow, lam, far, shear.rate, law_numbers, ambient, slope)
    free = FilmShear(replace(law, limit_slope=np.inf) if law.limit == "cut" else law, 1e9, 1e-4)
    fine = np.linspace(-3.0, 1.0, 80001)
    stress = np.interp(fine, x, free.stress_at(log_eta, film, p))
    if law.limited and law.limit == "cut":
        stress = np.minimum(stress, np.interp(fine, x, law.limiting_stress(1e9 * p) / 1e9))
    v = np.linspace(1.0 / 3.3, 1.0 / 3.0, 4001)
    inlet = film[0] + 0.5 * (1.0 / v**2 - 9.0)
    ahead = np.trapezoid(1.0 / (v * v * inlet), v), np.trapezoid((1.0 - flow / inlet) / (v * v * inlet), v)
    friction = np.trapezoid(stress, fine) + shear.rate * np.exp(log_eta[0]) * ahead[0]
    assert found[2] == pytest.approx(2.0 / np.pi * friction, rel=1e-4)
    rolling = np.trapezoid(film, p) / np.pi + lam * np.exp(log_eta[0]) * ahead[1] / np.pi
    assert found[6] == pytest.approx(rolling, rel=1e-3)
    assert found[0] == pytest.approx(0.1, rel=1e-6)
    assert found[1] == pytest.approx(0.1, rel=1e-2)
    assert found[3:6] == pytest.approx((1.0, flow, 1.0), rel=1e-6)


@pytest.mark.parametrize("ratio", [1.6, 2.0, 3.0])
def test_extrapolation_bounds_changes_of_lower_order(ratio):
    """Changes of the ratio r have the limit fine + change/(r - 1); the error is the distance to it."""
    levels = [np.array([2.0 + 0.01 * ratio**-k]) for k in range(3)]
    limit = extrapolate(levels, 49)
    deviation = abs(limit.values[0] - 2.0)
    assert deviation <= limit.errors[0] * (1.0 + 1e-9)
    assert limit.errors[0] <= 1.1 * deviation + 0.03 * abs(levels[2][0] - levels[1][0]) + FLOOR * limit.values[0]


def test_a_solution_that_breaks_the_condition_at_the_exit_is_no_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every solution has more than an allowed undershoot of -inf."""
    contact = Contact(oil="75w90", temperature="80 degC", thermal="off", **CONTACT)
    found = contact.solve()
    assert found.status == "converged"
    assert found.iterations >= 3 * 2  # of all of at least three meshes
    monkeypatch.setattr(refine, "UNDERSHOOT", -math.inf)
    failed = contact.solve()
    assert (failed.status, failed.reason) == ("failed", "negative_pressure")
