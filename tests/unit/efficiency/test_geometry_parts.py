"""The parts of the geometry, each for itself."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from samples import GEAR_BLANK as BLANK
from scipy.interpolate import Akima1DInterpolator, CubicSpline

from efficiency.contact.chebyshev import Patch, akima_curve, cubic_spline


@given(st.floats(-0.0127, 0.0127), st.floats(-0.006, 0.002), st.floats(-0.02, 0.02))
def test_blank_coordinates_round_trip(u: float, h: float, apex: float) -> None:
    blank = BLANK.model_copy(update={"pitch_apex_beyond_crossing": apex})
    back = blank.coordinates(*blank.axial(np.array([u]), np.array([h])))
    np.testing.assert_allclose(np.real(back)[:, 0], [u, h], atol=1e-15)


@settings(max_examples=20)
@given(st.integers(0, 2), st.integers(0, 2), st.floats(-0.9, 1.9), st.floats(0.1, 0.9))
def test_patch_is_exact_for_polynomials_and_their_derivatives(du: int, dv: int, u: float, v: float) -> None:
    nodes_u, nodes_v = Patch.nodes((-1.0, 2.0), (0.0, 1.0), (6, 5))
    patch = Patch.fit(
        (-1.0, 2.0), (0.0, 1.0), (6, 5), {"f": nodes_u**3 * nodes_v**2 + nodes_v, "one": 0.0 * nodes_u + 1.0}
    )
    up = [u**3, 3.0 * u**2, 6.0 * u][du]
    vp = [v**2, 2.0 * v, 2.0][dv]
    extra = [v, 1.0, 0.0][dv] if du == 0 else 0.0
    value = patch(np.array([u]), np.array([v]), ("f", "one"), du=du, dv=dv)[:, 0]
    np.testing.assert_allclose(value, [up * vp + extra, float(du == 0 and dv == 0)], atol=1e-11)


def test_patch_tail_tells_resolved_from_unresolved_fields() -> None:
    u, v = Patch.nodes((0.0, 1.0), (0.0, 1.0), (10, 10))
    patch = Patch.fit((0.0, 1.0), (0.0, 1.0), (10, 10), {"smooth": np.exp(u * v), "kink": np.abs(u - 0.4) + v})
    assert patch.tail["smooth"] < 1e-7
    assert patch.tail["kink"] > 1e-3


def test_curves_are_those_of_scipy() -> None:
    rng = np.random.default_rng(1)
    x = np.cumsum(rng.uniform(0.2, 2.0, 30))
    # a flat part, a straight part and a kink among the rest
    y = np.concatenate([rng.normal(size=15), np.zeros(5), 2.0 * x[20:26] - 3.0, rng.normal(size=4)])
    at = np.append(np.linspace(x[0] - 0.5, x[-1] + 0.5, 500), x)
    np.testing.assert_allclose(akima_curve(x, y, at), Akima1DInterpolator(x, y, method="makima")(at), atol=1e-13)
    assert np.all(akima_curve(x, y, np.linspace(x[16], x[18], 9)) == 0.0)
    for n in (5, 7, 15):
        rows, near = np.stack([y[:n], y[-n:]]), np.linspace(x[0] - 0.3, x[n - 1] + 0.3, 101)
        exact = CubicSpline(x[:n], rows, axis=-1)(near)
        np.testing.assert_allclose(cubic_spline(x[:n], rows, near), exact, atol=1e-12 * n)
        np.testing.assert_allclose(cubic_spline(x[:n], rows[1], near), exact[1], atol=1e-12 * n)
