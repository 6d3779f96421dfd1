"""Batch means, closed profiles and the change of mesh of the transient solver."""

import math

import numpy as np
import pytest
from contacts import line_contact
from refusals import refuses
from scipy.signal import lfilter

from ehl.rough import RoughSurfaces
from ehl.rough.accuracy import PER_SWEEP, inlet_sweep, make_run_plan
from ehl.rough.averaging import batch_means
from ehl.rough.surfaces import sample_ring
from ehl.surface.roughness import generate_profile


@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_intervals_cover_the_true_mean(memory: float) -> None:
    rng = np.random.default_rng(4)
    hits = 0
    for _ in range(300):
        noise, start = rng.standard_normal(1200), memory * rng.standard_normal() / math.sqrt(1.0 - memory**2)
        series = lfilter([1.0], [1.0, -memory], noise, zi=[start])[0]
        mean, half_width = batch_means(3.0 + series, 60)
        hits += abs(mean - 3.0) <= half_width
    assert 0.84 <= hits / 300 <= 0.95


def test_sampling_keeps_the_profile_on_every_mesh() -> None:
    profile = generate_profile(0.4e-6, 20e-6, 4e-3, 4e-6, 5)
    fine, coarse = sample_ring(profile, 1e-6), sample_ring(profile, 4e-6)
    np.testing.assert_allclose(fine[::4], coarse, atol=1e-15)
    np.testing.assert_allclose(coarse, profile.heights, atol=1e-15)
    with refuses("nodes"):
        sample_ring(profile, 30e-6)


def test_statistics_of_both_surfaces() -> None:
    one, two = (generate_profile(r, lc, 4e-3, 2e-6, 1) for r, lc in ((0.3e-6, 20e-6), (0.4e-6, 40e-6)))
    both = RoughSurfaces(one, two)
    assert both.rms == pytest.approx(0.5e-6, rel=1e-6)
    assert one.correlation_length < both.correlation_length < two.correlation_length
    assert RoughSurfaces().correlation_length == math.inf


def test_mesh_resolves_the_inlet_of_a_thin_film() -> None:
    contact = line_contact(pressure_hertz=2e9, speed_entrainment=0.1, slide_to_roll=0.1)
    film = 50e-9
    sweep = inlet_sweep(contact, film)
    assert sweep == pytest.approx((film * 0.015 / contact.half_width**2) ** (2 / 3))
    plan = make_run_plan("standard", contact, RoughSurfaces(), film, drained=False, thermal=False)
    assert plan.spacing == pytest.approx(0.5 * PER_SWEEP["standard"] * sweep)
    thick = make_run_plan("standard", contact, RoughSurfaces(), 1e-5, drained=False, thermal=False)
    assert thick.spacing == pytest.approx(1.0 / 128.0)
