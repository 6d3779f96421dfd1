"""Finishes, additives and generated profiles: figures inside their ranges, lay at an angle, statistics, heights."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from refusals import refuses
from samples import CONTACT, PLAIN_OIL
from scipy import integrate
from scipy.signal import resample

import ehl
from ehl.surface import roughness
from ehl.surface.finish import STATES, Additive, Finish, default_correlation_length, lay_seen, surface_uncertainty
from ehl.surface.roughness import autocorrelation, generate_profile, measured_correlation_length, translation


@pytest.mark.parametrize("name", ehl.shipped("finishes"))
@pytest.mark.parametrize("state", STATES)
def test_every_figure_has_range_and_source(name, state):
    finish = Finish.load(name, state)
    for figure in (finish.roughness_rms, finish.correlation_length, finish.skewness, finish.lay_ratio):
        assert figure.low <= figure.value <= figure.high
        assert figure.source
        assert figure.low < figure.high
    # machined steel surfaces have 16 to 20 Rq, sure within a factor of 2
    if name in ("ground", "lapped", "milled"):
        assert 15.0 < finish.correlation_length.value / finish.roughness_rms.value < 50.0
        assert finish.correlation_length.high > 4.0 * finish.correlation_length.low
    new = Finish.load(name, "new")
    assert finish.roughness_rms.value <= new.roughness_rms.value
    assert new.correlation_length.low <= finish.correlation_length.value <= new.correlation_length.high
    assert finish.skewness.value <= new.skewness.value


def test_unknown_states_are_refused():
    with refuses("finish_state"):
        Finish.load("ground", "worn")


def test_a_finish_with_a_measured_rq_has_shorter_waves():
    """Within one finish lc goes with Rq^(2/3): slopes go with its cube root; within the usual lengths."""
    finish = Finish.load("ground", "new")
    less = finish.with_rms(0.8 * finish.roughness_rms.value)
    assert less.roughness_rms.value == 0.8 * finish.roughness_rms.value
    assert less.roughness_rms.high / less.roughness_rms.low < finish.roughness_rms.high / finish.roughness_rms.low
    assert less.correlation_length.value == pytest.approx(12e-6 * 0.8 ** (2.0 / 3.0))
    length = finish.correlation_length
    assert less.correlation_length.high / less.correlation_length.low == pytest.approx(length.high / length.low)
    assert finish.length_at([0.0, 0.5e-6, 4e-3]).tolist() == [8e-6, 12e-6, 150e-6]


@pytest.mark.parametrize(("angle", "ratio"), [(0.4, 3.0), (0.0, 5.0), (0.5 * math.pi, 5.0), (0.7, 1.0)])
def test_lay_is_the_ellipse_of_the_autocorrelation(angle, ratio):
    # independent way: the quadratic form of the ellipse, turned by a rotation matrix
    lc = 30e-6
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    form = turn.T @ np.diag([1.0 / lc**2, 1.0 / (ratio * lc) ** 2]) @ turn
    length, gamma = lay_seen(lc, ratio, angle)
    assert length == pytest.approx(form[0, 0] ** -0.5)
    assert gamma == pytest.approx((form[0, 0] / form[1, 1]) ** 0.5)


def test_uncertainty_of_a_surface():
    named = surface_uncertainty(finish="lapped", finish_state="new", additive="ZDDP")
    assert named["roughness_rms"] == Finish.load("lapped", "new").roughness_rms
    assert named["boundary_film"] == Additive.load("ZDDP").boundary_film
    numbers = surface_uncertainty(roughness_rms=0.4e-6, correlation_length=50e-6)
    assert numbers["correlation_length"].value == 50e-6


@pytest.mark.parametrize("hurst", [0.5, 0.8])
def test_self_affine_spectrum_and_profile(hurst):
    spectrum = roughness.SelfAffine(20e-6, hurst)
    assert hurst != 0.5 or spectrum.roll_off == pytest.approx(2.0 * math.pi * 20e-6)  # exponential autocorrelation

    def density(ratio):
        """Density at a wave number over that of the roll-off."""
        return float(spectrum.density(np.array([ratio * 2.0 * math.pi / spectrum.roll_off]))[0])

    fine, whole = (integrate.quad(density, start, np.inf)[0] for start in (spectrum.roll_off / 5e-6, 0.0))
    assert spectrum.share_below(5e-6) == pytest.approx(fine / whole, rel=1e-6)
    # power law k^-(1 + 2 H) far above the roll-off
    assert math.log2(density(2e3) / density(1e3)) == pytest.approx(-1.0 - 2.0 * hurst, abs=1e-4)
    profile = generate_profile(0.4e-6, 20e-6, 40e-3, 1e-6, 3, cutoff=2.5e-6, hurst=hurst)
    assert profile.rms == pytest.approx(0.4e-6)
    assert profile.correlation_length == pytest.approx(20e-6, rel=0.1)  # one realisation of 2000 lengths
    # the same long waves whatever the cut-off
    coarse = generate_profile(0.4e-6, 20e-6, 40e-3, 1e-6, 3, cutoff=10e-6, hurst=hurst)
    ratio = np.fft.rfft(profile.heights)[1:500] / np.fft.rfft(coarse.heights)[1:500]
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-9)


LINE = CONTACT | PLAIN_OIL


def test_finish_in_a_contact_and_what_overrides_it():
    ground = Finish.load("ground")
    surface = ehl.Contact(**LINE, finish="ground").surface
    assert surface.roughness_rms_1 == ground.roughness_rms.value == 0.4e-6
    assert surface.correlation_length == pytest.approx(ground.correlation_length.value) == pytest.approx(16e-6)
    assert (surface.peklenik_number, surface.spectrum, surface.hurst) == (pytest.approx(5.0), "gaussian", None)
    assert surface.skewness == ground.skewness.value
    assert ehl.Contact(**LINE, finish="ground", spectrum="self_affine").surface.hurst == 0.85
    own = ehl.Contact(**LINE, finish="ground", roughness_rms="0.3 um", skewness=0.0, peklenik_number=2.0).surface
    assert own.roughness_rms_1 == pytest.approx(0.3e-6 / 2.0**0.5)
    assert own.correlation_length == pytest.approx(16e-6 * (0.3 / 0.4 / 2.0**0.5) ** (2.0 / 3.0))
    assert (own.skewness, own.peklenik_number) == (0.0, 2.0)
    # without a finish the length follows Rq of one surface, also after a change, and is not stored
    plain = ehl.Contact(**LINE, roughness_rms_1="0.3 um", roughness_rms_2="0.3 um")
    rougher = plain.replace(roughness_rms_1="0.6 um", roughness_rms_2="0.6 um")
    assert [each.surface.correlation_length for each in (plain, rougher)] == pytest.approx([12e-6, 24e-6])
    assert ehl.Contact(**plain.to_dict()) == plain
    assert (default_correlation_length(0.01e-6), default_correlation_length(9e-6)) == (8e-6, 150e-6)
    turned = ehl.Contact(**LINE, finish="ground", lay_angle="30 deg").surface
    assert (turned.correlation_length, turned.peklenik_number) == pytest.approx(lay_seen(16e-6, 5.0, math.pi / 6.0))


def test_boundary_film_and_friction_of_additives():
    for name in ehl.shipped("additives"):
        additive = Additive.load(name)
        surface = ehl.Contact(**LINE, additive=name, roughness_rms="0.4 um").surface
        assert surface.boundary_friction == additive.boundary_friction.value
        assert surface.film_of_contact == additive.boundary_film.value
        rougher = ehl.Contact(**LINE, additive=name, roughness_rms="1.2 um", spectrum="self_affine")
        assert rougher.surface.film_of_contact == surface.film_of_contact  # nothing is added for the roughness
        for film in (0.5 * surface.film_of_contact, 2.0 * surface.film_of_contact):
            assert rougher.replace(boundary_film=film).surface.boundary_film == film
    own = ehl.Contact(**LINE, boundary_friction=0.08, boundary_film="12 nm").surface
    assert (own.boundary_friction, own.film_of_contact) == (0.08, pytest.approx(12e-9))


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


def test_no_wavelength_below_the_cutoff_and_correlation_length():
    profile = generate_profile(1.0, LC, LENGTH, 1e-6, 1, cutoff=80e-6)
    power = np.abs(np.fft.rfft(profile.heights)) ** 2
    wavelength = LENGTH / np.arange(1, len(power))
    assert power[1:][wavelength < 80e-6 * (1 - 1e-9)].max() < 1e-20 * power.max()
    assert profile.cutoff == 80e-6
    # of an exact Gaussian autocorrelation
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
