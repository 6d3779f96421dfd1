"""Generated profiles: statistics, independence of the spacing, translation of heights."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from refusals import refuses
from scipy.signal import resample

from ehl.surface import roughness
from ehl.surface.roughness import autocorrelation, generate_profile, measured_correlation_length, translation

LC, LENGTH = 20e-6, 6.4e-3


def test_rms_mean_and_period_are_exact():
    profile = generate_profile(0.3e-6, LC, LENGTH, 1e-6, 7)
    assert_allclose(np.sqrt(np.mean(profile.heights**2)), 0.3e-6, rtol=1e-12)
    assert abs(np.mean(profile.heights)) < 1e-18
    assert profile.length == pytest.approx(LENGTH)
    assert not profile.heights.flags.writeable
    assert not np.any(generate_profile(0.0, LC, LENGTH, 2e-6, 7).heights)
    again, other = (generate_profile(0.3e-6, LC, LENGTH, 1e-6, seed).heights for seed in (7, 6))
    assert np.array_equal(profile.heights, again)
    assert abs(np.corrcoef(again, other)[0, 1]) < 0.3


@pytest.mark.parametrize(("skewness", "kurtosis"), [(0.0, 3.0), (-1.0, 5.0), (0.0, 1.9)])
def test_spacing_samples_one_physical_profile(skewness, kurtosis):
    fine = generate_profile(0.3e-6, LC, LENGTH, 1e-6, 7, skewness=skewness, kurtosis=kurtosis)
    coarse = generate_profile(0.3e-6, LC, LENGTH, 4e-6, 7, skewness=skewness, kurtosis=kurtosis)
    assert_allclose(fine.heights[::4], coarse.heights, atol=1e-18)
    if kurtosis == 3.0:  # band-limited
        assert_allclose(resample(coarse.heights, len(fine.heights)), fine.heights, atol=1e-18)
    assert (fine.skewness, fine.correlation_length) == (coarse.skewness, coarse.correlation_length)


def test_mean_autocorrelation_is_the_gaussian_one():
    # the band limit (1.3 % of the variance) and the finite length shift the mean curve by up to 0.02
    lags = np.arange(0, 40, 4)
    curves = [autocorrelation(generate_profile(1.0, LC, LENGTH, 1e-6, s).heights)[lags] for s in range(40)]
    assert_allclose(np.mean(curves, axis=0), np.exp(-((lags * 1e-6 / LC) ** 2)), atol=0.03)


def test_no_wavelength_below_the_cutoff():
    profile = generate_profile(1.0, LC, LENGTH, 1e-6, 1, cutoff=80e-6)
    power = np.abs(np.fft.rfft(profile.heights)) ** 2
    wavelength = LENGTH / np.arange(1, len(power))
    assert power[1:][wavelength < 80e-6 * (1 - 1e-9)].max() < 1e-20 * power.max()
    assert profile.cutoff == 80e-6


def test_correlation_length_of_an_exact_gaussian_acf():
    x = 1e-6 * np.arange(4000)
    spectrum = np.fft.rfft(np.exp(-((np.minimum(x, 4000e-6 - x) / LC) ** 2)))
    heights = np.fft.irfft(np.sqrt(np.maximum(spectrum.real, 0.0)), 4000)
    assert measured_correlation_length(heights - heights.mean(), 1e-6) == pytest.approx(LC, rel=2e-2)
    assert measured_correlation_length(np.random.default_rng(0).standard_normal(4096), 1e-6) < 1e-6  # white noise


@pytest.mark.parametrize(
    ("skewness", "kurtosis"),
    [(0.0, 1.9), (0.0, 6.0), (-1.2, 6.0), (0.5, 2.2), (-0.6, 2.4), (2.0, 12.0), (-3.0, 25.0), (0.02, 3.0006)],
)
def test_translation_has_the_moments_and_rises(skewness, kurtosis):
    w = math.exp(0.3**2)  # border of both families
    assert roughness.lognormal_kurtosis((w + 2) * math.sqrt(w - 1)) == pytest.approx(w**4 + 2 * w**3 + 3 * w**2 - 3)
    curve = translation(skewness, kurtosis)
    node = np.linspace(-9.0, 9.0, 40001)
    height = curve(node)
    weight = np.exp(-0.5 * node**2)
    weight /= weight.sum()
    assert_allclose([weight @ height, weight @ height**2], [0.0, 1.0], atol=1e-9)
    assert_allclose([weight @ height**3, weight @ height**4], [skewness, kurtosis], rtol=1e-5, atol=1e-6)
    # strictly rising until the bounded family saturates in double precision
    assert np.all(np.diff(height) >= 0.0)
    assert np.all(np.diff(curve(np.linspace(-4, 4, 801))) > 0.0)


def test_translated_profiles_have_the_moments_on_average():
    profiles = [generate_profile(1e-7, LC, 4e-2, 4e-6, s, skewness=-1.0, kurtosis=5.0) for s in range(10)]
    assert np.mean([p.skewness for p in profiles]) == pytest.approx(-1.0, abs=0.08)
    assert np.mean([p.kurtosis for p in profiles]) == pytest.approx(5.0, abs=0.4)
    assert np.mean([p.correlation_length for p in profiles]) == pytest.approx(LC, rel=0.05)
    assert all(p.rms == 1e-7 for p in profiles)


WRONG = {"rms": (-1e-7, math.nan), "correlation_length": (0.0,), "length": (5e-5,), "spacing": (3e-5,), "seed": (-1,)}
WRONG |= {"cutoff": (1.0,), "kurtosis": (1.0, 100.0), "skewness": (3.0,)}


@pytest.mark.parametrize(("name", "value"), [(name, value) for name, values in WRONG.items() for value in values])
def test_bad_input_names_the_field(name, value):
    arguments = {"rms": 1e-7, "correlation_length": LC, "length": LENGTH, "spacing": 1e-6, "seed": 1} | {name: value}
    with refuses("kurtosis" if name == "skewness" else name):
        generate_profile(**arguments)
