"""Finishes and additives: figures inside their ranges, sources, lay at an angle, ranges of a surface by numbers."""

import math

import numpy as np
import pytest
from refusals import refuses
from samples import CONTACT, PLAIN_OIL
from scipy import integrate

import ehl
from ehl.surface.finish import STATES, Additive, Finish, default_correlation_length, lay_seen, surface_uncertainty
from ehl.surface.roughness import SelfAffine, generate_profile


@pytest.mark.parametrize("name", ehl.shipped("finishes"))
@pytest.mark.parametrize("state", STATES)
def test_every_figure_has_range_and_source(name, state):
    finish = Finish.load(name, state)
    for figure in (finish.roughness_rms, finish.correlation_length, finish.skewness, finish.lay_ratio):
        assert figure.low <= figure.value <= figure.high
        assert figure.source
        assert figure.sigma > 0.0
    # machined steel surfaces have 16 to 20 Rq, sure within a factor of 2
    if name in ("ground", "lapped", "milled"):
        assert 15.0 < finish.correlation_length.value / finish.roughness_rms.value < 50.0
        assert finish.correlation_length.sigma > math.log(2.0) / 1.645
    new = Finish.load(name, "new")
    assert finish.roughness_rms.value <= new.roughness_rms.value
    assert new.correlation_length.low <= finish.correlation_length.value <= new.correlation_length.high
    assert finish.skewness.value <= new.skewness.value


def test_unknown_names_are_refused():
    for load, names, field in (
        (Finish.load, ("polished",), "finish"),
        (Finish.load, ("ground", "worn"), "finish_state"),
        (Additive.load, ("MoDTC",), "additive"),
    ):
        with refuses(field):
            load(*names)


def test_a_finish_with_a_measured_rq_has_shorter_waves():
    """Within one finish lc goes with Rq^(2/3): slopes go with its cube root; within the usual lengths."""
    finish = Finish.load("ground", "new")
    less = finish.with_rms(0.8 * finish.roughness_rms.value)
    assert less.roughness_rms.value == 0.8 * finish.roughness_rms.value
    assert less.roughness_rms.sigma < finish.roughness_rms.sigma
    assert less.correlation_length.value == pytest.approx(12e-6 * 0.8 ** (2.0 / 3.0))
    assert less.correlation_length.sigma == pytest.approx(finish.correlation_length.sigma)
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
    numbers = surface_uncertainty(roughness_rms=0.4e-6, correlation_length=50e-6, boundary_film=20e-9)
    assert numbers["correlation_length"].value == 50e-6
    assert numbers["boundary_film"].value == pytest.approx(20e-9)
    assert numbers["boundary_film"].sigma == pytest.approx(Additive.load("EP").boundary_film.sigma)
    film = numbers["boundary_film"]  # 90 % of a log-normal figure lies between low and high
    assert math.log(film.high / film.low) == pytest.approx(2.0 * 1.644854 * film.sigma, rel=1e-3)


@pytest.mark.parametrize("hurst", [0.5, 0.8])
def test_self_affine_spectrum_and_profile(hurst):
    spectrum = SelfAffine(20e-6, hurst)
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
    assert ehl.Contact.from_dict(plain.to_dict()) == plain
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
