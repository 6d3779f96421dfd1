"""The deterministic rough solver against independent solutions."""

import math

import numpy as np
import pytest
from twins.rough_limits import FLOOR, dry_error, flow_factor_direct, flow_factor_model, gaussian_plane
from twins.rough_scenes import Scene, eyring_oil, friction, gaussian_pair, line, speed_of_film_ratio
from twins.waviness import attenuation, curve, linear_attenuation, mesh_of, oil_of

from ehl.rough._kernels.march import SHARE
from ehl.smooth.solver import solve_steady

RMS = 0.4e-6


@pytest.mark.parametrize(
    ("gamma", "gap", "low", "high"),
    [
        # the mean field with the mode of elasticity, three seeds: half too conductive where gaps close, twice where the
        # lay is along the flow, and a third too tight in deep contact across it
        (3.0, 3.0, 0.85, 1.20), (3.0, 2.0, 0.80, 1.20), (3.0, 1.0, 0.50, 0.90),
        (1.0, 3.0, 0.95, 1.25), (1.0, 2.0, 1.00, 1.50), (1.0, 1.0, 0.90, 1.50),
        (1.0 / 3.0, 3.0, 1.00, 1.25), (1.0 / 3.0, 2.0, 1.05, 1.50), (1.0 / 3.0, 1.0, 1.00, 1.95),
    ],
)  # fmt: skip
def test_drainage_gives_the_flow_factor_of_a_two_dimensional_gap(
    gamma: float, gap: float, low: float, high: float
) -> None:
    direct = [flow_factor_direct(np.maximum(gap + gaussian_plane(128, 5.0, gamma, s), FLOOR)) for s in range(3)]
    model = [flow_factor_model(gap, gamma, seed=s) for s in range(3)]
    assert low < np.mean(model) / np.mean(direct) < high


def test_drained_share_and_friction_reach_their_limits() -> None:
    oil = eyring_oil()
    shares, frictions = [], []
    for ratio in (0.1, 0.01, 0.001):
        contact = line(speed_of_film_ratio(ratio, RMS, oil))
        run = Scene(contact, oil, gaussian_pair(contact, RMS, 0.2), 30e-9, 1.0).run(50.0)
        run.advance(450)
        records, _ = run.advance(100)
        shares.append(float(records[:, SHARE].mean()))
        frictions.append(float(friction(records).mean()))
    assert shares[0] < shares[1] < shares[2]
    assert shares[2] > 0.98
    assert frictions[2] == pytest.approx(0.1, rel=0.02)


@pytest.mark.parametrize(
    ("wavelength", "speed", "pressure"), [(0.125, 5.0, 0.7e9), (1.0, 5.0, 1.2e9), (1.0, 1.0, 1.2e9)]
)
def test_waviness_is_flattened_as_in_full_film_theory(wavelength: float, speed: float, pressure: float) -> None:
    value, g = attenuation(line(speed, 0.0, pressure), oil_of(), wavelength, max(60.0, 24.0 / wavelength))
    assert value == pytest.approx(curve(g), rel=0.1)


# the first two lie 14 and 11 % above the published curve
@pytest.mark.parametrize(
    ("wavelength", "speed", "pressure"), [(1.0, 5.0, 0.7e9), (0.25, 1.0, 1.2e9), (0.5, 0.3, 1.5e9), (2.0, 5.0, 0.7e9)]
)
def test_waviness_is_flattened_as_in_linear_theory(wavelength: float, speed: float, pressure: float) -> None:
    contact, oil = line(speed, 0.0, pressure), oil_of()
    value, _ = attenuation(contact, oil, wavelength, mesh_of(contact, oil, wavelength))
    smooth = solve_steady(contact, oil, accuracy="standard")
    exact = linear_attenuation(contact, oil, smooth, wavelength, max(90.0, 30.0 / wavelength))
    assert value == pytest.approx(exact, rel=0.005)


def test_without_oil_the_contact_is_the_dry_one() -> None:
    """Long ridges; the lateral mode is compared in `test_transient.py`."""
    contact = line(0.02)
    scene = Scene(contact, eyring_oil(1e-6, 1e-11), gaussian_pair(contact, RMS, 0.1), 20e-9, math.inf)
    run = scene.run(80.0)
    records, _ = run.advance(300)
    difference, touching, dry = dry_error(run, contact)
    assert records[-1, SHARE] > 0.999
    assert difference < 2e-3
    assert touching == pytest.approx(dry, rel=0.02)
