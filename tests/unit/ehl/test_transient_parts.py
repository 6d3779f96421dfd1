"""Batch means, closed profiles and the change of mesh of the transient solver."""

import math

import numpy as np
import pytest
from contacts import line_contact
from refusals import refuses
from scipy.signal import lfilter

from ehl.rough import RoughSurfaces
from ehl.rough.accuracy import PER_SWEEP, inlet_sweep, make_run_plan
from ehl.rough.averaging import batch_means, interval_of_means, neighbour_correlation, richardson
from ehl.rough.surfaces import sample_ring
from ehl.surface.roughness import generate_profile


def test_sampling_keeps_the_profile_on_every_mesh_and_both_surfaces_are_composed() -> None:
    profile = generate_profile(0.4e-6, 20e-6, 4e-3, 4e-6, 5)
    fine, coarse = sample_ring(profile, 1e-6), sample_ring(profile, 4e-6)
    np.testing.assert_allclose(fine[::4], coarse, atol=1e-15)
    np.testing.assert_allclose(coarse, profile.heights, atol=1e-15)
    with refuses("nodes"):
        sample_ring(profile, 30e-6)
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


SQUARE = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0])


@pytest.mark.parametrize(
    ("series", "steps", "student", "error"),
    [
        # ten means of +-1: no positive correlation, r = 0.1 for its bias, inflation 1.2222, freedom 10/1.2222 - 1
        (np.repeat(np.tile([1.0, -1.0], 5), 2), 4, 1.887387, math.sqrt(10.0 / 9.0 * 1.2222222 / 10.0)),
        # seven products of 0.25, four of them positive, over eight squares: r = 1/8, with its bias 0.125 + 1.375/8 =
        # 0.296875, inflation 1.844444, freedom 8/1.844444 - 1 = 3.337349
        (SQUARE, 1, 2.259480, math.sqrt(2.0 / 7.0 * 1.844444444 / 8.0)),
        # no correlation is trusted above its bound: inflation 9, two degrees of freedom
        (np.arange(6.0), 1, 2.919986, math.sqrt(3.5 * 9.0 / 6.0)),
    ],
)
def test_interval_of_a_mean_by_hand(series: np.ndarray, steps: int, student: float, error: float) -> None:
    """Student's t (95 %) times the standard error by half batches, inflated by (1 + r)/(1 - r) of their neighbours."""
    assert batch_means(series + 3.0, steps) == pytest.approx((3.0 + series.mean(), student * error), rel=1e-6)
    assert neighbour_correlation(SQUARE) == pytest.approx(0.125)
    assert neighbour_correlation(np.ones(8)) == 0.0


def test_interval_merges_twenty_parts_with_a_correlation_above_a_fifth() -> None:
    """Runs of two or three equal parts: r = 0.28; of 21 parts the first is left out, 19 are too few to be merged."""
    parts = 1e-3 * np.repeat([1.0, -1.0] * 4, [3, 3, 2, 3, 3, 2, 3, 2])
    assert neighbour_correlation(parts) == pytest.approx(0.284, abs=1e-3)
    merged = parts[1:].reshape(10, 2).mean(axis=1)
    assert interval_of_means(parts) == pytest.approx(interval_of_means(merged), rel=1e-12)
    assert interval_of_means(parts[1:]) == pytest.approx(interval_of_means(merged), rel=1e-12)
    pairs = interval_of_means(parts[3:].reshape(9, 2).mean(axis=1))
    assert interval_of_means(parts[2:]) != pytest.approx(pairs, rel=1e-3)


def test_interval_needs_five_batches_and_widens_with_its_confidence() -> None:
    assert math.isnan(batch_means(np.arange(8.0), 2)[1])
    assert [math.isfinite(interval_of_means(np.arange(float(count)))) for count in (2, 3)] == [False, True]
    assert math.isfinite(batch_means(np.arange(10.0), 2)[1])
    series = np.tile([1.0, -1.0], 5)
    # t(97.5 %) over t(95 %) at 7.1818 degrees of freedom: 2.352/1.888
    ratio = batch_means(series, 2, 0.95)[1] / batch_means(series, 2)[1]
    assert ratio == pytest.approx(2.352 / 1.888, rel=2e-3)


@pytest.mark.parametrize(
    ("coarse", "fine", "value", "error"),
    [
        (0.0516, 0.0504, 0.05, 0.0004),  # 0.05 + 0.0004 (h/dx)^2: exact, and the fine mean is off by the error
        (0.0484, 0.0496, 0.05, 0.0004),
        (1.2, 1.0, 1.0 - 0.1 / 3.0, 0.4 / 3.0),  # of a third of 0.2 a half is corrected; the third is error, and twice
        (-0.8, -1.0, -1.0 - 0.1 / 3.0, 0.4 / 3.0),  # what is left
    ],
)
def test_correction_of_two_meshes_is_bounded(coarse: float, fine: float, value: float, error: float) -> None:
    assert richardson(coarse, fine) == pytest.approx((value, error), rel=1e-9)


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
