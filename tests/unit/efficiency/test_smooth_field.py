"""Smooth function behind noisy values: likelihood, mean and covariance against plain formulas, honest uncertainty."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import multivariate_normal

from efficiency.contact import measured_flank as module
from efficiency.contact.measured_flank import Sizes, SmoothField, smooth_field

X, Y = np.meshgrid(np.linspace(-0.92, 0.92, 15), np.linspace(-0.92, 0.92, 9))
PLACE = np.stack([X.ravel(), Y.ravel()])
# across the middle, where the teeth of a pair hand over
LINE = np.stack([np.linspace(-0.2, 0.2, 5), np.linspace(0.5, -0.5, 5)])


def bend(values: NDArray[np.float64]) -> float:
    """How much the middle of the line stands out: what the transmission error is made of."""
    return float(values[2] - 0.5 * (values[0] + values[4]))


def covariance(sizes: Sizes, noise: float, free: float) -> NDArray[np.float64]:
    """Of values at PLACE, written out."""
    x, y = PLACE
    found = noise**2 * np.eye(x.size)
    for term in (np.ones_like(x), x, y):
        found += free**2 * np.outer(term, term)
    for term in (x * x, x * y, y * y):
        found += sizes.second**2 * np.outer(term, term)
    across = (x[:, None] - x) / sizes.lengths[0], (y[:, None] - y) / sizes.lengths[1]
    return np.asarray(found + sizes.field**2 * np.exp(-0.5 * (across[0] ** 2 + across[1] ** 2)))


def test_likelihood_is_that_of_the_normal_distribution_with_wide_free_terms() -> None:
    rng = np.random.default_rng(2)
    values = 3.0 * X.ravel() + 0.5 * Y.ravel() ** 2 + rng.standard_normal(X.size)
    sets = Sizes(2.0, 0.4, (0.8, 1.6), 1.0), Sizes(0.3, 1.5, (0.8, 1.6), 1.0)
    expected = [multivariate_normal.logpdf(values, cov=covariance(each, 1.1, 1e3)) for each in sets]
    terms = np.stack([np.ones_like(X.ravel()), X.ravel(), Y.ravel()], axis=1)
    free = np.linalg.qr(terms, mode="complete")[0][:, 3:].T
    x, y = PLACE
    apart = ((x[:, None] - x) / 0.8) ** 2 + ((y[:, None] - y) / 1.6) ** 2
    variance, own = np.linalg.eigh(free @ np.exp(-0.5 * apart) @ free.T)
    quadratic = np.stack([x * x, x * y, y * y], axis=1)
    found = [
        module._likelihood(
            variance, own.T @ free @ values, own.T @ free @ quadratic, np.array([s.field]), np.array([s.second]), 1.1
        ).item()
        for s in sets
    ]
    assert found[1] - found[0] == pytest.approx(expected[1] - expected[0], abs=1e-4)


def test_mean_and_covariance_are_those_of_the_mixture() -> None:
    """Two sets: each by the plain formulas, what is between their means counts as spread."""
    rng = np.random.default_rng(3)
    values = rng.standard_normal(X.size)
    sets = Sizes(1.0, 0.5, (0.4, 0.8), 0.25), Sizes(0.1, 1.5, (1.6, 1.6), 0.75)
    field = SmoothField(PLACE, values, 1, 1.0, sets)
    means, within = [], np.zeros((3, 3))
    for each in sets:
        noisy, clean = covariance(each, 1.0, 1e3), covariance(each, 0.0, 1e3)
        known = np.linalg.solve(noisy, clean[:, :3]).T
        means.append(known @ values)
        within += each.weight * (clean[:3, :3] - known @ clean[:, :3])
    mean = 0.25 * means[0] + 0.75 * means[1]
    between = 0.25 * np.outer(means[0] - mean, means[0] - mean) + 0.75 * np.outer(means[1] - mean, means[1] - mean)
    np.testing.assert_allclose(field.mean(PLACE[:, :3]), mean, atol=1e-6)
    np.testing.assert_allclose(field.covariance(PLACE[:, :3]), within + between, atol=1e-6)


def test_stated_uncertainty_covers() -> None:
    """Waves of a third of the noise, or none: 95 % intervals hold, and that a wave may be there costs little."""
    rng, inside, errors = np.random.default_rng(4), 0, []
    for draw in range(40):
        tilt, size, phase = rng.standard_normal(2), 0.3 * rng.standard_normal(), rng.uniform(0.0, 6.0)
        size = size if draw < 20 else 0.0

        def true(place: NDArray[np.float64], tilt: NDArray[np.float64], size: float, phase: float) -> Any:
            return 5.0 * tilt @ place + size * np.sin(1.5 * np.pi * (place[0] + 0.3 * place[1]) + phase)

        field = smooth_field(PLACE, true(PLACE, tilt, size, phase) + rng.standard_normal(X.size), 1.0, 1)
        error = bend(field.mean(LINE)) - bend(true(LINE, tilt, size, phase))
        weights = np.array([-0.5, 0.0, 1.0, 0.0, -0.5])
        inside += abs(error) < 1.96 * np.sqrt(weights @ field.covariance(LINE) @ weights)
        if draw >= 20:
            errors.append(error)
    assert inside >= 36
    # least squares with free terms of second order: standard error of their bend from the normal equations
    terms = module._terms(PLACE, 0, 2)
    bent = np.array([bend(column) for column in module._terms(LINE, 0, 2).T])
    assert np.sqrt(np.mean(np.square(errors))) < 1.5 * np.sqrt(bent @ np.linalg.solve(terms.T @ terms, bent))


def test_noise_above_the_stated_is_found() -> None:
    rng = np.random.default_rng(5)
    field = smooth_field(PLACE, 4.0 * rng.standard_normal(X.size), 0.5, 1)
    assert field.noise == pytest.approx(4.0, rel=0.15)
    assert smooth_field(PLACE, rng.standard_normal(X.size), 3.0, 1).noise == 3.0
