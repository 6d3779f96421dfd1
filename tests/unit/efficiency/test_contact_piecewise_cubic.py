"""Own piecewise cubics against those of scipy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import Akima1DInterpolator, CubicSpline

from efficiency.contact.chebyshev import akima_curve, cubic_spline


@pytest.mark.parametrize("count", [5, 7, 15])
def test_cubic_spline(count: int) -> None:
    rng = np.random.default_rng(count)
    x = np.cumsum(rng.uniform(0.2, 2.0, count))
    y = rng.normal(size=(3, count))
    at = np.linspace(x[0] - 0.3, x[-1] + 0.3, 101)
    np.testing.assert_allclose(cubic_spline(x, y, at), CubicSpline(x, y, axis=-1)(at), atol=1e-12 * count)
    np.testing.assert_allclose(cubic_spline(x, y[1], at), cubic_spline(x, y, at)[1], atol=1e-13 * count)
    np.testing.assert_allclose(cubic_spline(x, x**3, at), at**3, rtol=1e-11)


def test_akima_curve() -> None:
    rng = np.random.default_rng(1)
    x = np.cumsum(rng.uniform(0.2, 2.0, 30))
    # a flat part, a straight part and a kink among the rest
    y = np.concatenate([rng.normal(size=15), np.zeros(5), 2.0 * x[20:26] - 3.0, rng.normal(size=4)])
    at = np.append(np.linspace(x[0] - 0.5, x[-1] + 0.5, 500), x)
    np.testing.assert_allclose(akima_curve(x, y, at), Akima1DInterpolator(x, y, method="makima")(at), atol=1e-13)
    assert np.isnan(akima_curve(x, y, x[:1] - 1e-9)).all()
    assert np.all(akima_curve(x, y, np.linspace(x[16], x[18], 9)) == 0.0)
