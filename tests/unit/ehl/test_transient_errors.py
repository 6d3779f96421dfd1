"""Error estimates of the transient solver: interval of a correlated mean, width of the inlet."""

from __future__ import annotations

import numpy as np
import pytest

from ehl.line_contact import LineContact
from ehl.rough import RoughSurfaces
from ehl.rough.accuracy import PER_SWEEP, inlet_sweep, make_run_plan
from ehl.rough.batch_means import batch_means


def correlated(rng: np.random.Generator, count: int, length: float) -> np.ndarray:
    """Gaussian series of unit variance whose correlation falls to 1/e over ``length`` steps."""
    keep = np.exp(-1.0 / length)
    noise = np.sqrt(1.0 - keep**2) * rng.standard_normal(count)
    series = np.empty(count)
    value = rng.standard_normal()
    for i in range(count):
        value = keep * value + noise[i]
        series[i] = value
    return series


@pytest.mark.parametrize("length", [5.0, 30.0])
def test_interval_of_a_correlated_mean_covers_as_it_says(length: float) -> None:
    rng = np.random.default_rng(3)
    found = [batch_means(correlated(rng, 1200, length), 100) for _ in range(200)]
    coverage = np.mean([abs(mean) <= half for mean, half in found])
    assert 0.83 < coverage < 0.96


def test_mesh_resolves_the_inlet_of_a_thin_film() -> None:
    contact = LineContact.from_pressure(
        radius_equivalent=0.015, effective_modulus=228e9, pressure_hertz=2e9, speed_entrainment=0.1, slide_to_roll=0.1
    )
    film = 50e-9
    sweep = inlet_sweep(contact, film)
    assert sweep == pytest.approx((film * 0.015 / contact.half_width**2) ** (2 / 3))
    plan = make_run_plan("standard", contact, RoughSurfaces(), film, drained=False, thermal=False)
    assert plan.spacing == pytest.approx(0.5 * PER_SWEEP["standard"] * sweep)
    thick = make_run_plan("standard", contact, RoughSurfaces(), 1e-5, drained=False, thermal=False)
    assert thick.spacing == pytest.approx(1.0 / 128.0)
