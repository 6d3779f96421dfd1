"""Elastic part of the film shear: closed forms, its estimate, no step in mu, rough compared with smooth solver."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from contacts import line_contact
from scipy.integrate import solve_ivp

from ehl.common.arrays import FloatArray
from ehl.contact import Contact
from ehl.elastic_shear import (
    SHARE_FULL,
    SHARE_NEGLECTED,
    body_compliance,
    counted,
    elastic_shear,
    elastic_stress,
    rubbing_friction,
)
from ehl.fluid._kernels import march_stress, stress_after
from ehl.fluid.lubricant import Lubricant
from ehl.line_contact import LineContact
from ehl.rough.solve import solve_transient
from ehl.smooth.solver import solve_steady

STATE: dict[str, Any] = {"oil": "fva3", "temperature_oil": 353.15, "pressure_hertz": 1e9}
STATE |= {"radius_equivalent": 15e-3, "speed_entrainment": 5.0}


def even_film(oil: Lubricant, slip: float) -> tuple[LineContact, FloatArray, FloatArray, FloatArray, FloatArray]:
    """A film of constant pressure and height over 0.4 mm, and its viscous stress."""
    line, x = line_contact(slide_to_roll=slip), np.linspace(0.0, 4e-4, 401)
    pressure, film = np.full(401, 0.8e9), np.full(401, 4e-7)
    return line, x, pressure, film, oil.shear_stress(pressure, film, line.speed_sliding)


@pytest.mark.parametrize("slip", [1e-4, 1e-3, 1e-2])
def test_newtonian_film_is_strained_exponentially(slip: float) -> None:
    """tau = eta v_s/h (1 - exp(-x/l)), l = (h/G + k) u_r eta/h."""
    oil = Lubricant(0.02, 1e-8, viscosity_law="barus", shear_modulus=0.1e9)
    line, x, pressure, film, viscous = even_film(oil, slip)
    eta = float(oil.viscosity(pressure[:1])[0])
    length = (film[0] / 0.1e9 + body_compliance(line)) * line.speed_entrainment * eta / film[0]
    found = elastic_stress(x, pressure, film, viscous, line, oil)
    assert found == pytest.approx(viscous * -np.expm1(-x / length), rel=1e-9)


@pytest.mark.parametrize("final", [1e4, 3e6, 4e7, 1e8])
@pytest.mark.parametrize("start", [0.0, 0.3, 0.999, 1.0, 1.2])
@pytest.mark.parametrize("gain", [1e3, 1e6, 3e7, 1e8])
def test_eyring_film_against_an_integrator(final: float, start: float, gain: float) -> None:
    """d tau/ds = gain (1 - sinh(tau/tau0)/sinh(tau*/tau0)), tau0 = 5 MPa."""
    scale, stress = 5e6, start * final

    def rate(_: float, tau: FloatArray) -> FloatArray:
        share = np.exp((tau - final) / scale) * np.expm1(-2.0 * tau / scale) / math.expm1(-2.0 * final / scale)
        return np.asarray(gain * (1.0 - share))

    exact = solve_ivp(rate, (0.0, 1.0), [stress], method="Radau", rtol=1e-10, atol=1e-7 * final).y[0, -1]
    assert stress_after(stress, final, scale, gain) == pytest.approx(exact, rel=1e-5)


def test_stress_never_exceeds_the_limit_that_falls_towards_the_exit() -> None:
    limit = np.linspace(4e7, 0.0, 50)
    rising = march_stress(limit, np.full(50, 5e6), limit, np.full(50, 3e6))
    assert np.all(rising <= limit)
    assert np.any(rising > 0.99 * limit)


def test_initial_slope_over_a_rigid_film_is_that_of_carter() -> None:
    """mu = 2 R SR/b as long as nothing slips: the stress is the way times the slip over the compliance."""
    oil = Lubricant(1e3, 18e-9, shear_modulus=1e12)
    line = even_film(oil, 1e-7)[0]
    b = line.half_width
    x = np.linspace(-b, b, 801)
    stress = elastic_stress(x, np.full(801, 1e9), np.full(801, 1e-9), np.full(801, 1e12), line, oil)
    mu = np.trapezoid(stress, x) / line.load_per_length
    assert mu == pytest.approx(2.0 * line.radius_equivalent / b * 1e-7, rel=1e-3)


@pytest.mark.parametrize("modulus", [3e9, 3e8, 1e7, 1e6])
@pytest.mark.parametrize("slip", [1e-3, 1e-2])
def test_estimate_is_larger_than_what_the_elastic_part_takes(modulus: float, slip: float) -> None:
    result = Contact(**STATE, slide_to_roll=slip, shear_modulus=1e11).solve()
    film, line = result.film, result.problem.line
    oil = replace(result.problem.lubricant, shear_modulus=modulus)
    found = elastic_shear(film.x, film.pressure, film.film, film.shear_stress, line, oil)
    assert 1.0 - found.ratio < found.estimate


@pytest.mark.parametrize("slip", [1e-3, 3e-3])
def test_error_of_the_march_is_in_that_of_friction(slip: float) -> None:
    """Against a march in steps 32 times as short; the mesh itself is as fine as it is."""
    result = Contact(**STATE, slide_to_roll=slip, accuracy="fast").solve()
    line, oil = result.problem.line, result.problem.lubricant
    x, pressure, film = result.film.x, result.film.pressure, result.film.film
    viscous = oil.shear_stress(pressure, film, line.speed_sliding)
    found = elastic_shear(x, pressure, film, viscous, line, oil)
    exact = np.trapezoid(elastic_stress(x, pressure, film, viscous, line, oil, 128), x) / np.trapezoid(viscous, x)
    assert 0.3 * found.error < abs(found.ratio / exact - 1.0) < found.error
    assert result.friction_error > 0.5 * found.error


def test_friction_is_continuous_through_the_switch_and_through_zero_slip() -> None:
    shares = np.array([0.0, SHARE_NEGLECTED, SHARE_NEGLECTED + 1e-9, SHARE_FULL - 1e-9, SHARE_FULL, 1.0])
    assert [counted(share) for share in shares] == pytest.approx([0.0, 0.0, 0.0, 1.0, 1.0, 1.0], abs=1e-6)
    oil = Lubricant(0.02, 18e-9, rheology="eyring", eyring_stress=6e6, shear_modulus=0.1e9)
    left, ratios = [], []
    for slip in np.geomspace(0.003, 0.2, 60):
        line, x, pressure, film, _ = even_film(oil, slip)
        viscous = oil.shear_stress(pressure, film, line.speed_sliding)
        found = elastic_shear(x - 2e-4, pressure, film, viscous, line, oil)
        left.append(found.left_out)
        ratios.append(found.ratio)
    assert left[0] == 0.0
    assert ratios[-1] == 1.0
    assert np.all(np.diff(ratios) >= 0.0)
    assert np.max(np.diff(ratios)) < SHARE_NEGLECTED
    small = [Contact(**STATE, slide_to_roll=slip, thermal="off").solve() for slip in (0.0, 1e-6, -1e-6, 1e-5)]
    values = [result.friction_coefficient for result in small]
    assert values[0] == 0.0
    assert values[1] == pytest.approx(values[2], rel=1e-6)
    assert values[3] == pytest.approx(10.0 * values[1], rel=0.01)


def test_rough_solver_strains_the_film_like_the_smooth_one() -> None:
    """Both surfaces smooth: the transient film takes the same share of mu as the steady one."""
    line = even_film(Lubricant(0.02, 18e-9), 2e-3)[0]
    rigid = Lubricant(0.02, 18e-9, rheology="eyring", eyring_stress=6e6, limiting_shear_coefficient=0.05)
    soft = replace(rigid, shear_modulus=0.05e9)
    runs = [solve_transient(line, oil, accuracy="fast", travel=2.0) for oil in (rigid, soft)]
    ratio = runs[1].friction_fluid / runs[0].friction_fluid
    film = solve_steady(line, rigid)
    steady = elastic_shear(film.x, film.pressure, film.film, film.shear_stress, line, soft).ratio
    assert ratio < 0.97
    assert 1.0 - ratio == pytest.approx(1.0 - steady, rel=0.05)


@pytest.mark.parametrize("slip", [1e-5, 4e-4, 1.2e-3, 1.8e-3])
def test_rubbing_with_a_stick_zone_is_that_of_elastic_half_spaces(slip: float) -> None:
    """Relative strain of the half-spaces = slip where they stick, stress = mu p where they slip; by cells."""
    line = line_contact(slide_to_roll=slip)
    b, modulus, cells = line.half_width, 0.5 * line.effective_modulus, 400
    edges = np.linspace(-b, b, cells + 1)
    x, step = 0.5 * (edges[1:] + edges[:-1]), edges[1] - edges[0]
    sliding = 0.1 * line.pressure_hertz * np.sqrt(1.0 - (x / b) ** 2)

    def lag(distance: FloatArray) -> FloatArray:
        return distance * (np.log(np.maximum(np.abs(distance), 1e-300)) - 1.0)

    places = np.concatenate(([x[0] - step], x))[:, None]
    moved = 2.0 / (math.pi * modulus) * (lag(places - edges[1:]) - lag(places - edges[:-1]))
    strain, stick, stress = np.diff(moved, axis=0) / step, np.ones(cells, dtype=bool), sliding.copy()
    for _ in range(cells):
        right = slip - strain[np.ix_(stick, ~stick)] @ sliding[~stick]
        stress[stick] = np.linalg.solve(strain[np.ix_(stick, stick)], right)
        if np.all(stress <= sliding):
            break
        stick &= stress <= sliding
        stress = sliding.copy()
    assert rubbing_friction(line, 0.1) == pytest.approx(stress.sum() * step / line.load_per_length, rel=5e-3)


def test_friction_of_a_rough_contact_has_no_jump_at_rolling() -> None:
    def rough(slip: float) -> float:
        state = STATE | {"speed_entrainment": "0.5 m/s", "roughness_rms": "0.5 um", "seed": 1}
        return Contact(**state, slide_to_roll=slip, accuracy="fast").solve().friction_coefficient

    small, larger, full = rough(1e-6), rough(1e-5), rough(5e-3)
    assert small == pytest.approx(larger / 10.0, rel=0.2)
    assert 0.0 < small < 0.02 * full
