"""Batch means, closed profiles and the change of mesh of the transient solver."""

import math
from dataclasses import replace

import numpy as np
import pytest
from contacts import line_contact
from refusals import refuses
from scipy.signal import lfilter

from ehl.fluid.lubricant import Lubricant
from ehl.material import Material
from ehl.rough import RoughSurfaces
from ehl.rough.accuracy import PER_SWEEP, inlet_sweep, make_run_plan
from ehl.rough.averaging import batch_means
from ehl.rough.run import TransientRun
from ehl.rough.scaling import Settings, build_problem
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


def test_finer_run_takes_over_the_coarse_state() -> None:
    line = line_contact()
    oil = Lubricant(0.015, 15e-9, rheology="eyring", eyring_stress=5e6)
    steel = Material.load("steel")
    surfaces = RoughSurfaces(generate_profile(0.2e-6, 30e-6, 16.0 * line.half_width, 3e-6, 1), None)
    settings = Settings(120, 20e-9, 0.1, 1.0, False, 8e9)
    coarse = TransientRun(build_problem(line, oil, surfaces, (steel, steel), settings))
    coarse.advance(round(6.0 * coarse.problem.units.steps_per_half_width))
    finer = replace(settings, nodes=240, start_travel=coarse.travel)
    fine = TransientRun(build_problem(line, oil, surfaces, (steel, steel), finer))
    fine.start_from(coarse)
    assert fine.travel == pytest.approx(coarse.travel, abs=fine.problem.model.surfaces.spacing)
    means = []
    for run in (coarse, fine):
        per_width = run.problem.units.steps_per_half_width
        run.advance(round(0.5 * per_width))
        means.append(float(run.advance(round(1.0 * per_width))[0][:, 0].mean()))
    assert means[1] == pytest.approx(means[0], rel=0.02)


def test_mesh_resolves_the_inlet_of_a_thin_film() -> None:
    contact = line_contact(pressure_hertz=2e9, speed_entrainment=0.1, slide_to_roll=0.1)
    film = 50e-9
    sweep = inlet_sweep(contact, film)
    assert sweep == pytest.approx((film * 0.015 / contact.half_width**2) ** (2 / 3))
    plan = make_run_plan("standard", contact, RoughSurfaces(), film, drained=False, thermal=False)
    assert plan.spacing == pytest.approx(0.5 * PER_SWEEP["standard"] * sweep)
    thick = make_run_plan("standard", contact, RoughSurfaces(), 1e-5, drained=False, thermal=False)
    assert thick.spacing == pytest.approx(1.0 / 128.0)
