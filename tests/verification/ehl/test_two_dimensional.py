"""Rough contacts against an independent solver with roughness, Reynolds equation and elasticity in two dimensions."""

import math
from typing import Any

import numpy as np
import pytest
from twins.rough_scenes import eyring_oil, gaussian_pair, line

from ehl import Contact
from ehl.rough import solve_transient

SEEDS = range(1, 7)


@pytest.mark.parametrize(
    ("rms", "length", "gamma", "film", "share", "friction"),
    [
        (0.3e-6, 40e-6, 1.0, 0.326e-6, 0.0, 0.0231),
        (0.6e-6, 40e-6, 1.0, 0.42e-6, 0.034, 0.0260),
        (1.2e-6, 40e-6, 1.0, 0.73e-6, 0.48, 0.061),  # film: 0.66 and 0.80
        (0.6e-6, 20e-6, 1.0, math.nan, 0.73, 0.079),
        (0.6e-6, 40e-6, 3.0, 0.503e-6, 0.0023, 0.0222),
        (1.2e-6, 40e-6, 3.0, 0.794e-6, 0.074, 0.0280),
        (1.2e-6, 40e-6, 20.0, 1.05e-6, 0.038, 0.0226),
        # of our own program (validation/rough_2d.py); the first two served to choose MARKS_ALONG, the third did not
        (0.3e-6, 40e-6, 0.5, 0.312e-6, 0.024, 0.0253),
        (0.6e-6, 40e-6, 0.5, 0.467e-6, 0.294, 0.0447),
        (0.6e-6, 40e-6, 0.7, 0.465e-6, 0.135, 0.0329),
    ],
)
def test_shares_films_and_friction_of_two_dimensional_solutions(
    rms: float, length: float, gamma: float, film: float, share: float, friction: float
) -> None:
    """p_h 1.1 GPa, R 15 mm, 3 m/s, slide-to-roll 0.3, eta0 15 mPa s, 15 1/GPa, tau0 5 MPa, mu_b 0.1, 30 nm; isothermal.

    Asperity load share within 35 % or 0.05, as single realisations scatter (15 to 35 %; the references are one or two)
    and 0.034 is .06 to .09, 0.135 is .19 with "fast", less on finer meshes; mu within 20 %, mean film within 15 %.
    """
    contact = line(3.0, 0.3, 1.1e9)
    settings: Any = {"boundary_film": 30e-9, "peklenik_number": gamma, "hardness": 1e13}
    settings["accuracy"] = "standard" if share in (0.034, 0.135) else "fast"
    pairs = (gaussian_pair(contact, rms, length / contact.half_width, seed) for seed in SEEDS)
    runs = [solve_transient(contact, eyring_oil(), pair, **settings) for pair in pairs]
    found = np.mean([(run.asperity_load_share, run.friction_coefficient, run.film_mean) for run in runs], axis=0)
    assert abs(found[0] - share) < max(0.35 * share, 0.05)
    assert found[1] == pytest.approx(friction, rel=0.2)
    if math.isfinite(film):
        assert found[2] == pytest.approx(film, rel=0.15)


def test_asperity_load_does_not_grow_with_finer_meshes() -> None:
    """An outflow of spots that is not averaged over their width drains them the faster the finer the mesh is."""
    contact = line(3.0, 0.3, 1.1e9)
    pair = gaussian_pair(contact, 1.2e-6, 40e-6 / contact.half_width)
    settings: Any = {"travel": 40.0, "boundary_film": 30e-9, "hardness": 1e13, "boundary_study": False}
    coarse, fine = (solve_transient(contact, eyring_oil(), pair, nodes=nodes, **settings) for nodes in (320, 640))
    assert fine.asperity_load_share == pytest.approx(coarse.asperity_load_share, rel=0.1)


@pytest.mark.parametrize(("rms", "length"), [(1.2e-6, 40e-6), (0.9e-6, 60e-6)])
def test_side_flow_has_no_mean_exchange_at_the_end_of_a_run(rms: float, length: float) -> None:
    """Film ratios of 0.25 and 0.34: what the slice gains or loses of its throughput, and what that makes of mu."""
    contact = line(3.0, 0.3, 1.1e9)
    surfaces = gaussian_pair(contact, rms, length / contact.half_width)
    settings: Any = {"accuracy": "standard", "boundary_film": 30e-9, "boundary_study": False}
    run = solve_transient(contact, eyring_oil(), surfaces, **settings)
    assert run.film_ratio == pytest.approx(0.305e-6 / rms, rel=0.05)
    assert run.net_exchange < 0.05
    assert run.exchange_error == pytest.approx(0.15 * run.net_exchange * (1.0 - run.asperity_load_share))


@pytest.mark.parametrize("gamma", [0.5, 1.0])
def test_a_thick_film_without_marks_across_is_nearly_that_of_smooth_surfaces(gamma: float) -> None:
    """A film ratio of 4.1, isothermal. Flow factors of Patir & Cheng change the film by less than 3 % there."""
    state = {
        "oil": "fva3", "temperature": "60 degC", "pressure_hertz": "0.9 GPa", "radius_equivalent": "10 mm",
        "speed_entrainment": 10.0, "slide_to_roll": 0.3, "thermal": "off", "accuracy": "fast",
    }  # fmt: skip
    surfaces = {"roughness_rms": "0.35 um", "correlation_length": "10 um", "peklenik_number": gamma}
    smooth, rough = Contact(**state).solve(), Contact(**state, **surfaces).solve()
    assert rough.transient.film_mean == pytest.approx(smooth.film_central, rel=0.05)
    assert rough.friction_coefficient == pytest.approx(smooth.friction_coefficient, rel=0.005)
    assert rough.transient.net_exchange < 0.08
