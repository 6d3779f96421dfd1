"""Heat in the smooth contact: moving sources, division of heat, thermal balance, limits, the estimate for "auto"."""

import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest
from contacts import BEARING_STEEL as STEEL
from contacts import effective_rise, gear_range, thermal_traction
from contacts import hot_oil as oil
from contacts import line_contact as contact
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.linalg.lapack import dgetrs
from scipy.special import k0e, k1e
from scipy.stats import qmc
from twins.material_points import material_point_matrix

from ehl.fluid.lubricant import PAO, PARAFFINIC, FilmConductivity, Lubricant
from ehl.fluid.viscosity import ModulusLaw
from ehl.heat import _kernels, conduction
from ehl.heat.conduction import jaeger_matrix, peclet_number
from ehl.heat.estimate import convection_error, estimate_thermal_effect, murch_wilson_1975, thermal_loading
from ehl.heat.traction import film_temperature, flux_to_surface_1
from ehl.line_contact import LineContact, gupta_1992, moes_1992
from ehl.smooth.mesh import Features, grade
from ehl.smooth.thermal import solve_smooth

UNIT = np.sin(0.5 * np.pi * np.linspace(-1.0, 1.0, 121))
FILM, B = 0.4e-6, 2e-4


def speed(peclet: float) -> float:
    return 2.0 * peclet * STEEL.thermal_diffusivity / B


def cold_friction(line: LineContact, lubricant: Lubricant, film: float = FILM) -> float:
    """Friction at the inlet temperature."""
    pressure = line.pressure_hertz * np.sqrt(np.maximum(1.0 - UNIT**2, 0.0))
    stress = lubricant.shear_stress(pressure, np.full_like(UNIT, film), line.speed_sliding)
    return float(np.trapezoid(np.where(pressure > 0.0, stress, 0.0), UNIT * line.half_width)) / line.load_per_length


def solve(line: LineContact, lubricant: Lubricant, bodies=(STEEL, STEEL), film: float = FILM, **options):
    pressure = line.pressure_hertz * np.sqrt(np.maximum(1.0 - UNIT**2, 0.0))
    return thermal_traction(
        UNIT * line.half_width, pressure, np.full_like(UNIT, film), line, lubricant, bodies, **options
    )


def test_energy_balance_signs_and_what_an_unfinished_iteration_shows():
    line = contact(slide_to_roll=1.0)
    result, backward = solve(line, oil()), solve(contact(slide_to_roll=-1.0), oil())
    power = np.trapezoid(result.shear_stress, result.x) * line.speed_sliding
    assert result.status == "converged"
    assert np.trapezoid(result.heat_flux_1 + result.heat_flux_2, result.x) == pytest.approx(power, rel=1e-8)
    assert result.energy_residual < 1e-8
    assert result.friction_fluid == pytest.approx(backward.friction_fluid, rel=1e-9)
    assert_allclose(result.temperature_flash_1, backward.temperature_flash_2)
    along = solve(contact(slide_to_roll=0.02, speed_sliding_lengthwise=2.5), oil())
    assert along.friction_fluid == pytest.approx(solve(contact(slide_to_roll=0.5), oil()).friction_fluid, rel=0.01)
    unfinished = solve(contact(slide_to_roll=1.0, speed_entrainment=20.0), oil(), max_iterations=1)
    assert (unfinished.status, unfinished.reason) == ("failed", "no_thermal_balance")
    assert unfinished.energy_residual > 1e-3


def test_division_without_film_conduction_is_even_and_with_much_equalises_the_surfaces():
    x = UNIT * 1e-4
    fast, slow = material_point_matrix(x, 9.0, STEEL), material_point_matrix(x, 1.0, STEEL)
    flux = 1e8 * np.sqrt(np.maximum(1.0 - UNIT**2, 0.0))
    division, constant = flux_to_surface_1(np.zeros_like(x), fast, slow, 0.0)
    assert_allclose(division @ flux + constant, 0.5 * flux)
    division, constant = flux_to_surface_1(np.full_like(x, 1e14), fast, slow, 0.0)
    into_1 = division @ flux + constant
    assert_allclose((fast @ into_1)[1:], (slow @ (flux - into_1))[1:], rtol=1e-5)
    # equal surfaces at every x share the heat as e sqrt(u): 3 to 1
    assert_allclose(into_1[5:-5], 0.75 * flux[5:-5], rtol=1e-4)


def test_heat_flows_from_the_hot_body_to_the_cold_one_without_sliding():
    result = solve(contact(slide_to_roll=0.0), oil(), temperature_bulk=(373.15, 413.15))
    assert result.friction_fluid == 0.0
    assert np.all(result.heat_flux_1[1:-1] > 0.0)
    assert_allclose(result.heat_flux_1, -result.heat_flux_2)
    assert np.all(result.temperature_flash_1[1:] > 373.15)
    assert np.all(result.temperature_flash_2[1:] < 413.15)


def test_film_temperature_against_the_exact_couette_flow():
    # exponential viscosity between walls at one temperature: tau h/(eta0 v) = asinh(s)/(s sqrt(1 + s^2)) with
    # s^2 = beta eta0 v^2/(8 k), exact
    body = STEEL.model_copy(update={"thermal_conductivity": 1e12})
    line = contact(speed_entrainment=10.0, slide_to_roll=1.0)
    lubricant = oil(viscosity_law="barus", rheology="newtonian", film_conductivity=FilmConductivity(c1=0.0, c2=0.0))
    result = solve(line, lubricant, (body, body))
    pressure = line.pressure_hertz * np.sqrt(np.maximum(1.0 - UNIT**2, 0.0))
    eta = np.exp(lubricant.log_viscosity(pressure, np.full_like(pressure, 373.15)))
    s = np.sqrt(0.04 * eta * line.speed_sliding**2 / (8.0 * 0.14))[1:-1]
    exact = np.arcsinh(s) / (s * np.sqrt(1.0 + s**2))
    assert np.count_nonzero(s > 10.0) > 10
    assert_allclose((result.shear_stress * FILM / (eta * line.speed_sliding))[1:-1], exact, rtol=0.02)


def test_effective_rise_against_its_closed_form() -> None:
    a = np.geomspace(1e-3, 30.0, 200)
    even = a * np.tanh(a) / 0.04  # beta = 0.04 1/K
    share, growth = effective_rise(even, np.full_like(a, 0.04))
    closed = 2.0 * a + np.log1p(-np.exp(-4.0 * a)) - np.log(4.0 * a)  # ln(sinh 2a/(2a))
    assert_allclose(share, closed / (0.04 * even), rtol=2.5e-3)
    steps = [effective_rise(even * (1.0 + e), np.full_like(a, 0.04))[0] * even * (1.0 + e) for e in (-1e-6, 1e-6)]
    assert_allclose(growth, (steps[1] - steps[0]) / (2e-6 * even), rtol=1e-6)
    cooling, _ = effective_rise(even, np.full_like(a, -0.04))  # a viscosity that increases with temperature
    assert_allclose(cooling, 2.0 / 3.0)


def test_opposed_surfaces_and_a_body_at_rest():
    opposed = solve(contact(slide_to_roll=3.0), oil())
    assert opposed.status == "converged"
    # each surface is hottest where it leaves the heat behind it
    assert np.argmax(opposed.temperature_flash_1) > len(UNIT) // 2 > np.argmax(opposed.temperature_flash_2)
    rest = solve(contact(slide_to_roll=2.0), oil())
    assert rest.status == "converged"
    assert rest.peclet_number == 0.0
    # where a lagged temperature oscillates
    assert solve(contact(pressure_hertz=2e9, speed_entrainment=15.0, slide_to_roll=1.5), oil()).iterations < 20


def test_heat_field_of_a_body_at_rest_is_even_and_turns_over_with_the_motion():
    """At rest the kernel is even in x, its slope in speed alike on both sides, and a reversed speed mirrors it."""
    x = np.linspace(-2.0, 2.0, 41) * B
    for slow in (5.0, speed(0.02)):
        onward, rest, against = (jaeger_matrix(x, u, STEEL, B) for u in (slow, 0.0, -slow))
        assert_allclose(against[::-1, ::-1], onward, rtol=1e-9, atol=1e-15)
        assert_allclose(against[::-1, ::-1], jaeger_matrix(-x[::-1], slow, STEEL, B), rtol=1e-12)
    assert_allclose(rest[::-1, ::-1].sum(axis=1), jaeger_matrix(-x[::-1], 0.0, STEEL, B).sum(axis=1), rtol=1e-12)
    assert_allclose(0.5 * (onward + against), rest, rtol=1e-6)
    # exp(u (x - s)/(2 chi)) at the source: the rise grows along the motion by 0.02 per half-width
    distance = (x[:, None] - x[None, :]) / B
    near = (np.abs(distance) < 0.5) & (np.abs(distance) > 0.2)
    near[:, [0, -1]] = False  # the flux of the end nodes is one-sided
    growth = np.log(onward / against)[near] / (2.0 * distance[near])
    assert_allclose(growth, 0.02, rtol=0.02)  # the logarithm at the source bends within a cell


@pytest.mark.parametrize("opposed", [1.0, -1.0])
def test_bound_of_the_heat_field_leaves_moving_surfaces_alone(opposed):
    """From Peclet number 0.5 on the band source is met within 3e-7 of a kernel with a bound a hundred times as deep."""
    x = B * np.linspace(-1.5, 1.5, 121)
    flux = np.sqrt(np.maximum(1.0 - (x / B) ** 2, 0.0))
    bounded, free = (jaeger_matrix(x, opposed * speed(0.5), STEEL, b) @ flux for b in (B, 100.0 * B))
    assert_allclose(bounded, free, atol=3e-7 * free.max())
    assert not np.array_equal(bounded, free)


def test_every_contact_of_a_wide_range_balances():
    # p_h 0.1..4 GPa, R 1..500 mm, u 0.005..60 m/s, SR to 2, eta0 0.001..2 Pa s, alpha 5..35 1/GPa
    low = np.log([0.1e9, 1e-3, 0.005, 1e-4, 0.001, 5e-9, 1e6, 0.02e-6])
    high = np.log([4e9, 0.5, 60.0, 2.0, 2.0, 35e-9, 30e6, 3e-6])
    for k, u in enumerate(qmc.Sobol(8, seed=2).random(64)):
        p, radius, speed, slide, eta, alpha, tau0, film = np.exp(low + (high - low) * u)
        line = contact(pressure_hertz=p, radius_equivalent=radius, speed_entrainment=speed, slide_to_roll=slide)
        laws = {"viscosity_law": ("roelands", "barus")[k % 2], "rheology": ("eyring", "newtonian")[k // 2 % 2]}
        lubricant = oil(viscosity_inlet=eta, pressure_viscosity=alpha, eyring_stress=tau0, **laws)
        result = solve(line, lubricant, film=film)
        assert result.status == "converged"
        assert result.energy_residual < 1e-6
        assert result.iterations < 30
        assert 0.0 < result.friction_fluid <= cold_friction(line, lubricant, film) * (1.0 + 1e-9)


def test_estimate_skips_only_where_heat_changes_little():
    skipped = 0
    for line, lubricant in gear_range(128, 3):
        estimate = estimate_thermal_effect(line, lubricant, (STEEL, STEEL), film_central=FILM)
        result = solve(line, lubricant)
        change = 1.0 - result.friction_fluid / cold_friction(line, lubricant)
        assert change <= 1.1 * estimate.friction_change + 1e-9
        if not estimate.matters:
            skipped += 1
            assert change < 0.02
    assert 5 < skipped < 100


def test_estimate_counts_bulk_temperatures_and_pure_rolling():
    rolling = contact(slide_to_roll=0.0, speed_entrainment=2.0)
    assert estimate_thermal_effect(contact(slide_to_roll=0.0, speed_entrainment=10.0), oil(), (STEEL, STEEL)).matters
    assert not estimate_thermal_effect(rolling, oil(), (STEEL, STEEL)).matters
    warm = estimate_thermal_effect(rolling, oil(), (STEEL, STEEL), temperature_bulk=(375.15, 373.15))
    assert warm.matters
    assert warm.bulk_offset == 2.0


def test_film_heat_takes_the_conductivity_law_of_the_lubricant():
    line, body = contact(slide_to_roll=1.0), STEEL
    plain, own = oil(), oil(film_conductivity=PARAFFINIC)
    assert solve(line, own, (body, body)).friction_fluid > solve(line, plain, (body, body)).friction_fluid
    rises = [estimate_thermal_effect(line, lubricant, (body, body)).rise_film for lubricant in (plain, own)]
    ratio = PAO(line.pressure_hertz, 1.0) / PARAFFINIC(line.pressure_hertz, 1.0)
    assert rises[1] / rises[0] == pytest.approx(ratio, rel=1e-12)
    pressure = np.array([0.0, 1e9])  # about doubled at 1 GPa
    assert_allclose([PAO(pressure, 0.14) / 0.14, PARAFFINIC(pressure, 1.0)], [[1.0, 2.0448], [1.0, 2.117]], rtol=1e-4)
    peclets = [convection_error(line, lubricant, 1e-6, 0.9).peclet_film for lubricant in (plain, own)]
    assert peclets[1] / peclets[0] == pytest.approx(ratio, rel=1e-12)


def test_inlet_factors():
    assert murch_wilson_1975(0.0) == gupta_1992(0.0, 0.5) == 1.0
    # hand values: 3.94/4.94, 1/(1 + 0.213 x 3.23)
    assert murch_wilson_1975(1.0) == pytest.approx(0.797571, rel=1e-5)
    assert gupta_1992(1.0, -1.0) == pytest.approx(0.592421, rel=1e-5)
    # two publications
    loadings = np.array([0.1, 0.3, 1.0])
    assert gupta_1992(loadings, 0.0) == pytest.approx([murch_wilson_1975(float(one)) for one in loadings], rel=0.05)
    assert thermal_loading(contact(speed_entrainment=10.0), oil(thermal_conductivity=0.106)) == pytest.approx(0.4)


@pytest.mark.parametrize(("speed", "slip", "film"), [(2.0, 0.1, 0.3e-6), (1e-3, 0.4, 1e-7)], ids=["fast", "slow"])
def test_estimate_of_heat_by_hand(speed: float, slip: float, film: float) -> None:
    """Newtonian Barus oil: rises of film and surfaces, the slope of the viscosity, and the larger loss of film.

    |u| b/(2 chi) of the slow surfaces, 0.003 and 0.002, counts as 0.1.
    """
    line = contact(radius_equivalent=0.01, pressure_hertz=0.4e9, speed_entrainment=speed, slide_to_roll=slip)
    lubricant = Lubricant(
        0.01, 10e-9, viscosity_law="barus", temperature=353.15, temperature_viscosity=0.03, thermal_conductivity=0.14
    )
    found = estimate_thermal_effect(line, lubricant, (STEEL, STEEL), film_central=film)
    heat = (slip * speed) ** 2 * 0.01 * math.exp(4.0) / film
    k_film = float(PAO(np.array([0.4e9]), 0.14)[0])
    assert found.rise_film == pytest.approx(heat * film / (8.0 * k_film), rel=1e-9)
    chi = STEEL.thermal_conductivity / (STEEL.density * STEEL.heat_capacity)
    assert peclet_number(-speed, line.half_width, STEEL) == pytest.approx(speed * line.half_width / (2.0 * chi))
    # 2 q sqrt(2 b/(pi u))/e at the end of a band, for each body alone; half the heat would go to equal bodies
    speeds = np.maximum(speed * (1.0 + 0.5 * slip * np.array([1.0, -1.0])), 0.1 * 2.0 * chi / line.half_width)
    alone = 2.0 * heat * np.sqrt(2.0 * line.half_width / (math.pi * speeds)) / STEEL.thermal_effusivity
    assert found.rise_flash == pytest.approx(1.0 / np.sum(1.0 / alone), rel=1e-9)
    assert found.bulk_offset == 0.0
    assert found.viscosity_change == pytest.approx(0.03 * (found.rise_film + found.rise_flash), rel=1e-9)
    # a Newtonian stress follows the viscosity one to one
    assert found.friction_change == pytest.approx(found.viscosity_change, rel=1e-9)
    loading = 0.01 * 0.03 * speed**2 / 0.14
    factors = 1.0 / (1.0 + 0.1 * (1.0 + 14.8 * slip**0.83) * loading**0.64), 3.94 / (3.94 + loading**0.62)
    assert found.film_change == pytest.approx(1.0 - min(factors), rel=1e-9)
    # of the film of Moes where none is given
    moes = moes_1992(*line.moes_groups(lubricant)) * 0.01 * math.sqrt(2.0 * line.dowson_groups(lubricant)[0])
    given = estimate_thermal_effect(line, lubricant, (STEEL, STEEL), film_central=moes)
    assert estimate_thermal_effect(line, lubricant, (STEEL, STEEL)) == given


def test_error_of_convection_by_hand():
    """0.05 loss + 0.01 Pe + 0.002 of friction and 0.18 loss + 0.002 of film, loss = (-ln reduction)^1.4."""
    line, lubricant = contact(), oil()
    found = convection_error(line, lubricant, 1e-6, 0.6)
    k_film = float(PAO(np.array([line.pressure_hertz]), lubricant.thermal_conductivity)[0])
    peclet = lubricant.density * lubricant.heat_capacity * line.speed_entrainment * 1e-12 / (k_film * line.half_width)
    loss = math.log(1.0 / 0.6) ** 1.4
    assert found.peclet_film == pytest.approx(peclet, rel=1e-12)
    assert found.friction_change == pytest.approx(0.05 * loss + 0.01 * peclet + 0.002, rel=1e-12)
    assert found.film_change == pytest.approx(0.18 * loss + 0.002, rel=1e-12)
    thicker = convection_error(line, lubricant, 1e-6, 1.1)
    assert thicker.film_change == 0.002


PLACES = grade(Features(0.1, 1.05, -1.0, 0.2, 0.95, 0.003)).points(81)


def twin_moving_kernel(place):
    """From the closed integrals of exp(t) K0(|t|) and t exp(t) K0(|t|), all pairs at once."""
    z = place[:, None] - place[None, :]
    r = np.where(z == 0.0, 1.0, np.abs(z))
    k0, k1, decay = k0e(r), k1e(r), np.exp(-2.0 * np.minimum(r, 350.0))
    zeroth = np.where(z > 0.0, r * (k0 + k1) - 1.0, -(decay * r * (k0 - k1) + 1.0))
    first = np.where(z > 0.0, r * (r * (k0 + k1) - k1) + 1.0, decay * r * (r * (k0 - k1) - k1) + 1.0) / 3.0
    zeroth, first = np.where(z == 0.0, 0.0, zeroth), np.where(z == 0.0, 0.0, first)
    i0, i1 = -np.diff(zeroth, axis=1), -np.diff(first, axis=1)
    matrix = np.zeros_like(z)
    matrix[:, :-1] += (i1 - z[:, 1:] * i0) / np.diff(place)
    matrix[:, 1:] += (z[:, :-1] * i0 - i1) / np.diff(place)
    return matrix


@pytest.mark.parametrize("peclet", [1e-3, 0.1, 5.0, 500.0, 1e5])
def test_moving_kernel(peclet):
    matrix, twin = conduction._moving_kernel(peclet * PLACES), twin_moving_kernel(peclet * PLACES)
    # the closed forms themselves lose digits in small cells
    assert_allclose(matrix, twin, rtol=1e-7, atol=1e-7 * np.abs(twin).max())
    flux = np.sqrt(np.clip(1.0 - PLACES**2, 0.0, None))
    assert_allclose(matrix @ flux, twin @ flux, rtol=1e-9, atol=1e-12 * np.abs(twin @ flux).max())
    for edge in (2.0**_kernels.LOWEST, 2.0**_kernels.HIGHEST):  # of the table of Bessel functions
        for distance in (0.5 * edge, 1.1 * edge, 0.9 * edge, 2.0 * edge):
            place = np.array([0.0, distance])
            assert_allclose(
                conduction._moving_kernel(place), twin_moving_kernel(place), rtol=1e-6, atol=1e-14 / distance
            )


def test_heat_that_the_flow_frees_evenly_reaches_the_walls_after_its_length():
    """q (1 - exp(-(x - x_0)/l)) of q = u (h - h_exit/rho) dp/dx; none where there is no pressure, or p falls."""
    x = np.linspace(0.0, 3e-4, 61)
    pressure, density = 1e8 + 1e12 * x, np.full(61, 1.25)
    film = np.r_[np.full(60, 2e-6), 1e-6]
    wanted = 5.0 * (2e-6 - 0.8e-6) * 1e12 * -np.expm1(-x[:60] / 4e-5)
    found = _kernels.flow_heat(x, pressure, film, density, np.full(61, 4e-5), 5.0)
    assert_allclose(found[:60], wanted, rtol=0.02, atol=0.02 * wanted.max())
    pressure[30] = 0.0
    assert _kernels.flow_heat(x, pressure, film, density, np.full(61, 4e-5), 5.0)[30] == 0.0
    assert np.all(_kernels.flow_heat(x, 4e8 - 1e12 * x, film, density, np.full(61, 4e-5), 5.0) == 0.0)


MODULUS = ModulusLaw((2.704e7, 8.399e5, 0.0579, -5.921e-4), 373.15, (1000.0, 95.0))


@pytest.mark.parametrize("law", [MODULUS, ModulusLaw(MODULUS.constants, 353.15, beta=0.03)])
def test_compiled_modulus_law(law):
    """Values of the law, its slope and the fall of the slope, on both sides of nine tenths of the pole."""
    pressure, temperature = (g.ravel() for g in np.meshgrid(np.linspace(0.0, 4e9, 41), np.linspace(250.0, 700.0, 46)))
    nodes = np.empty((_kernels.ROWS, pressure.size))
    nodes[_kernels.PRESSURE], nodes[_kernels.TEMPERATURE] = pressure, temperature
    _kernels.modulus_viscosity(nodes, -3.0, law.numbers)
    assert_allclose(nodes[_kernels.LOG_ETA], law.log_ratio(pressure, temperature) - 3.0, rtol=1e-12, atol=1e-12)
    slope, warmer = (law.by_temperature(pressure, temperature + kelvin) for kelvin in (0.0, 1.0))
    assert_allclose(nodes[_kernels.BY_TEMPERATURE], slope, rtol=1e-12)
    loss = np.where(slope < 0.0, np.clip(1.0 - warmer / np.where(slope < 0.0, slope, 1.0), 0.0, 0.2), 0.0)
    assert_allclose(nodes[_kernels.LOSS], loss, atol=1e-12)
    assert np.count_nonzero(loss) > 0


def balanced(speed, surface_speeds, guess=None, tolerance=1e-9, law="roelands"):
    """A hot film with its conduction, on a graded mesh with a dry node in it."""
    x = PLACES[::2] * 2e-4
    ceramic = STEEL.model_copy(update={"thermal_conductivity": 20.0, "density": 3200.0})
    modulus = {"modulus_constants": MODULUS.constants, "temperature_constants": MODULUS.vogel}
    oil = Lubricant(0.0106, 15e-9, law, rheology="eyring", limiting_shear_coefficient=0.06, temperature=373.15,
                    temperature_viscosity=0.04, **modulus if law == "modulus" else {})  # fmt: skip
    pressure = 1.2e9 * np.where(x < -2e-4, 0.01, np.sqrt(np.clip(1.0 - (x / 2.1e-4) ** 2, 0.0, None)))
    pressure[[5, -1]] = 0.0
    matrices = tuple(
        conduction.jaeger_matrix(x, u, body, 2e-4) for u, body in zip(surface_speeds, (STEEL, ceramic), strict=True)
    )
    line = SimpleNamespace(speed_sliding=speed)
    rolling = 1e6 * np.cos(x / 1e-4) ** 2
    bulk = (373.15, 393.15)
    found = film_temperature(
        pressure, 0.4e-6 + x**2 / 0.03, PAO(pressure, oil.thermal_conductivity), line, oil, bulk, matrices,
        rolling_heat=rolling,
        guess=guess, tolerance=tolerance,
    )  # fmt: skip
    return found, oil, matrices


@pytest.mark.parametrize("law", ["roelands", "barus", "modulus"])
@pytest.mark.parametrize("speeds", [(6.0, 4.0), (9.0, 1.0), (8.0, 0.0), (8.0, -4.0)])
def test_stress_and_temperature_fit_each_other(speeds, law):
    """The balance by dense matrices and the laws themselves."""
    found, oil, matrices = balanced(speeds[0] - speeds[1], speeds, law=law)
    assert found.converged
    k_film = PAO(found.pressure, oil.thermal_conductivity)
    division, constant = flux_to_surface_1(k_film / found.film, *matrices, 20.0)
    heat = (speeds[0] - speeds[1]) * found.stress + found.rolling_heat
    into_1 = division @ heat + constant
    walls = 383.15 + 0.5 * (matrices[0] @ into_1 + matrices[1] @ (heat - into_1))
    walls += found.film / (20.0 * k_film) * found.rolling_heat
    assert_allclose(found.walls, walls, rtol=1e-9)
    even = (speeds[0] - speeds[1]) * found.stress * found.film / (8.0 * k_film)
    share, _ = effective_rise(even, -oil.dlog_viscosity_dtemperature(found.pressure, found.temperature))
    assert_allclose(found.temperature, walls + even * share, rtol=1e-8)
    wet = found.pressure > 0.0
    log_viscous = oil.log_viscosity(found.pressure, found.temperature)
    log_viscous += math.log(speeds[0] - speeds[1]) - np.log(found.film)
    assert_allclose(np.log(found.stress[wet]), oil.shear_law.log_stress(log_viscous, found.pressure)[0][wet], atol=1e-8)
    assert np.all(found.stress[~wet] == 0.0)
    # what the matrix of Newton's method is made of where its estimate does not do
    _, *rises = _kernels.divided(found.conducted.walls._replace(difference=0.0), heat)
    assert_allclose(found.conducted.exact() @ heat, 0.5 * sum(rises), rtol=1e-9)


def test_conduction_of_a_film_between_two_bodies():
    """Factors of I + k/h (A1 + A2), and an estimate of the rise that is exact for a constant ratio of both rises."""
    rng, n = np.random.default_rng(0), 12
    first = np.eye(n) + rng.random((n, n))
    second, conductance = 0.4 * first, 0.1 + rng.random(n)
    factors, pivots, weights = np.empty((n, n)), np.empty(n, np.int32), np.empty(n)
    _kernels.conduct(first, second, conductance, factors, pivots, weights)
    system, right = np.eye(n) + conductance[:, None] * (first + second), rng.random(n)
    assert_allclose(dgetrs(factors.T, pivots - 1, right, trans=1)[0], np.linalg.solve(system, right), rtol=1e-9)
    through = conductance * (first + second).sum(axis=1)
    assert_allclose(weights, 0.25 * (1.0 - (0.6 / 1.4) ** 2 * through / (1.0 + through)), rtol=1e-12)


def test_a_near_guess_and_a_useless_estimate_of_conduction_lead_to_the_same_balance(monkeypatch):
    exact, *_ = balanced(5.0, (7.5, 2.5))
    near = exact.stress * (1.0 + 0.02 * np.cos(np.arange(exact.stress.size))), exact.walls + 2.0
    found, *_ = balanced(5.0, (7.5, 2.5), guess=near)
    assert found.iterations < exact.iterations
    assert_allclose(found.stress, exact.stress, rtol=1e-8)
    first = _kernels.conduct

    def useless(*arguments):
        first(*arguments)
        arguments[-1][:] = 1e3

    monkeypatch.setattr(_kernels, "conduct", useless)
    found, *_ = balanced(5.0, (7.5, 2.5))
    assert found.converged
    assert_allclose(found.stress, exact.stress, rtol=1e-8)


def band(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes from -2 b to 3 b with a unit flux on the band, its steps a 1e-9 b wide."""
    x = np.concatenate([np.linspace(-2, -1 - 1e-9, n // 4), np.linspace(-1, 1, n), np.linspace(1 + 1e-9, 3, n // 2)])
    return x * B, (np.abs(x) <= 1.0).astype(float)


def jaeger_band(x: float, peclet: float) -> float:
    """Rise under a unit band flux, times k/b, by adaptive quadrature of the kernel."""
    marks = [x - 1.0, x + 1.0]
    marks += [c for c in (-3 / peclet, -0.1 / peclet, 0.0, 0.1 / peclet, 3 / peclet) if x - 1 < c < x + 1]
    marks.sort()

    def kernel(s: float) -> float:
        return math.exp(peclet * (s - abs(s))) * float(k0e(peclet * abs(s)))

    parts = [quad(kernel, a, b, epsabs=1e-12, epsrel=1e-10, limit=200)[0] for a, b in itertools.pairwise(marks)]
    return sum(parts) / math.pi


def test_uniform_flux_on_any_mesh_is_exact():
    """And one that is linear over the way of a point."""
    x = np.sort(np.random.default_rng(0).random(60)) * B
    way, matrix = x - x[0], material_point_matrix(x, 3.0, STEEL)
    even = 2.0 * np.sqrt(way / (math.pi * 3.0)) / STEEL.thermal_effusivity
    assert_allclose(matrix @ np.ones_like(x), even, rtol=1e-10)
    assert_allclose(matrix @ way, 2.0 / 3.0 * way * even, rtol=1e-10)


@pytest.mark.parametrize("peclet", [0.5, 1.0, 2.0, 5.0, 10.0, 50.0])
def test_jaeger_matrix_against_quadrature_of_the_band_source(peclet):
    x, flux = band(200)
    rise = jaeger_matrix(x, speed(peclet), STEEL, B) @ flux * STEEL.thermal_conductivity / B
    picked = [20, 45, 60, 120, 200, 245, 260, 300]
    exact = [jaeger_band(x[i] / B, peclet) for i in picked]
    assert_allclose(rise[picked], exact, atol=1e-5 * max(exact))


@pytest.mark.parametrize(("peclet", "excess"), [(0.5, 0.22), (1.0, 0.14), (2.0, 0.08), (5.0, 0.04), (50.0, 0.006)])
def test_error_of_one_dimensional_conduction(peclet, excess):
    # the figures behind the warning below Peclet number 2
    x, flux = band(200)
    exact = (jaeger_matrix(x, speed(peclet), STEEL, B) @ flux).max()
    simple = (material_point_matrix(x, speed(peclet), STEEL) @ flux).max()
    assert simple / exact - 1.0 == pytest.approx(excess, abs=0.005)


@pytest.mark.parametrize("slide_to_roll", [0.02, 0.3, 1.0])
@pytest.mark.parametrize("speed", [5.0, 12.0])
def test_inlet_factor_against_solved_films(slide_to_roll, speed):
    line, lubricant = contact(speed_entrainment=speed, slide_to_roll=slide_to_roll), oil(thermal_conductivity=0.14)
    found = solve_smooth(line, lubricant, (STEEL, STEEL), thermal="on", accuracy="fast")
    expected = gupta_1992(thermal_loading(line, lubricant), slide_to_roll)
    assert expected == pytest.approx(found.film_reduction, rel=0.15)


def test_heat_capacity_per_mass_hardly_changes_under_pressure():
    # rho c of Larsson et al. (2000), 1 + k1 p/(1 + k2 p), over the density law of the solver: c at constant mass flow
    pressure = np.linspace(0.0, 1.1, 12)
    for k1, k2 in ((0.41, 1.05), (0.47, 0.81)):
        ratio = (1.0 + k1 * pressure / (1.0 + k2 * pressure)) / oil().density_ratio(1e9 * pressure)
        assert 0.975 < ratio.min() < ratio.max() < 1.036
