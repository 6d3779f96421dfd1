"""Film and temperature solved together: limits, balances, an independent program, published inlet factors."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from contacts import BEARING_STEEL as STEEL
from contacts import gear_range
from contacts import hot_oil as oil
from contacts import line_contact as contact
from twins.material_points import at_mid_film, conducts_like_the_transient_solver, without_convection, without_flow_heat

from ehl.contact import Contact
from ehl.fluid.lubricant import FilmConductivity
from ehl.fluid.oil import Oil
from ehl.heat.estimate import murch_wilson_1975, thermal_loading
from ehl.smooth import hot_film, refine
from ehl.smooth import thermal as thermal_steady
from ehl.smooth.newton import NewtonFailure, solve_level
from ehl.smooth.solver import solve_steady
from ehl.smooth.thermal import solve_smooth

BODIES, CONSTANT = (STEEL, STEEL), FilmConductivity(c1=0.0, c2=0.0)

# alpha [1/GPa], p_h [GPa], u_r [m/s], SR: mu isothermal and thermal, highest rise of film and surface [K] (or None)
PROTOTYPE = [
    (9.68, 1, 5, 1.5, 137, 63, 27, 24), (9.68, 1, 15, 0.3, 69, 41, None, None),
    (9.68, 1, 15, 1.5, 157, 43, 50, 32), (9.68, 2, 5, 0.1, 65, 58, None, None),
    (9.68, 2, 15, 1.5, 156, 34, 81, 65), (15.0, 1, 5, 1.0, 316, 142, None, None),
    (15.0, 1, 15, 1.5, 361, 67, 91, 52), (15.0, 2, 5, 0.3, 290, 182, None, None),
    (15.0, 2, 5, 1.5, 342, 97, 103, 96), (15.0, 2, 15, 0.1, 265, 158, None, None),
    (15.0, 2, 15, 1.0, 338, 66, None, None), (15.0, 2, 15, 1.5, 352, 55, 147, 110),
]  # fmt: skip


@pytest.mark.parametrize("row", PROTOTYPE)
def test_against_an_independent_transient_program_run_to_steady_state(monkeypatch, row):
    conducts_like_the_transient_solver(monkeypatch)
    without_flow_heat(monkeypatch)
    without_convection(monkeypatch)
    at_mid_film(monkeypatch)
    alpha, pressure, speed, slide, cold, hot, film, flash = row
    line = contact(pressure_hertz=pressure * 1e9, speed_entrainment=speed, slide_to_roll=slide)
    lubricant = oil(pressure_viscosity=alpha * 1e-9, film_conductivity=CONSTANT)
    result = solve_smooth(line, lubricant, BODIES, thermal="on")
    assert result.status == "converged"
    # its mesh has 256 nodes (3 % where friction is nearly Newtonian), its figures four digits
    assert result.isothermal.friction_fluid == pytest.approx(cold * 1e-4, rel=0.03, abs=1e-4)
    assert result.friction_fluid == pytest.approx(hot * 1e-4, rel=0.03, abs=1e-4)
    if film is not None:
        assert result.temperature_film_max - 373.15 == pytest.approx(film, rel=0.01, abs=1.0)
        assert result.temperature_flash - 373.15 == pytest.approx(flash, rel=0.01, abs=1.0)


@pytest.mark.parametrize("speed", [5.0, 10.0, 15.0, 20.0, 25.0])
def test_inlet_heating_in_pure_rolling_against_published_factors(speed):
    line, lubricant = contact(speed_entrainment=speed, slide_to_roll=0.0), oil(film_conductivity=CONSTANT)
    result = solve_smooth(line, lubricant, BODIES, thermal="on")
    assert result.friction_fluid == 0.0
    assert result.energy_residual < 1e-3
    # two fits that conduct the heat where it is freed; the film carries it on, which thins it by 2.5 % more at 20 m/s
    loading = thermal_loading(line, lubricant)
    assert result.film_reduction == pytest.approx(murch_wilson_1975(loading), rel=0.04)
    # Zhu and Cheng (unverified), without sliding
    assert result.film_reduction == pytest.approx(1.0 / (1.0 + 0.213 * loading**0.64), rel=0.05)
    assert result.film_reduction < 0.98


def test_bulk_temperature_acts_as_a_warmer_oil_in_pure_rolling(monkeypatch):
    without_flow_heat(monkeypatch)
    # Barus: uniformly warmer bodies make a uniformly thinner oil, which the isothermal solver can solve too
    line, cold = contact(slide_to_roll=0.0), oil(viscosity_law="barus", pressure_viscosity=10e-9)
    warm = solve_smooth(line, cold, BODIES, thermal="on", temperature_bulk=(393.15, 393.15))
    thin = solve_steady(line, replace(cold, viscosity_inlet=cold.viscosity_inlet * math.exp(-0.04 * 20.0)))
    assert warm.film.film_central == pytest.approx(thin.film_central, rel=1e-4)
    assert warm.film.film_min == pytest.approx(thin.film_min, rel=1e-3)
    assert warm.film_reduction < 0.65


def test_contacts_of_the_gear_range_converge_and_balance():
    for line, lubricant in gear_range(8, 8):
        result = solve_smooth(line, lubricant, BODIES, thermal="on")
        assert result.status == "converged"
        assert result.energy_residual < 2e-3  # largest of 128 contacts: 1.3e-3
        assert result.heat is not None
        # a hot inlet thins the film, which raises friction at most like 1/h (nearly Newtonian films)
        assert 0.0 < result.friction_fluid <= 1.01 * result.isothermal.friction_fluid / result.film_reduction
        assert 0.1 < result.film_reduction <= 1.0 + 1e-4


def test_auto_leaves_heat_out_only_where_it_changes_little():
    skipped = 0
    for fast, lubricant in gear_range(8, 9):
        line = replace(fast, speed_entrainment=0.1 * fast.speed_entrainment, slide_to_roll=0.3 * fast.slide_to_roll)
        auto = solve_smooth(line, lubricant, BODIES, thermal="auto")
        assert auto.status == "converged"
        if auto.heat is not None:
            continue
        skipped += 1
        assert any(reason.startswith("heat:") for reason in auto.skipped)
        full = solve_smooth(line, lubricant, BODIES, thermal="on")
        assert full.friction_fluid == pytest.approx(auto.friction_fluid, rel=0.02)
        assert full.film.film_central == pytest.approx(auto.film.film_central, rel=0.02)
    assert 2 <= skipped <= 7


def test_reported_error_covers_the_difference_to_reference():
    for line, lubricant in gear_range(4, 10):
        standard = solve_smooth(line, lubricant, BODIES, thermal="on")
        reference = solve_smooth(line, lubricant, BODIES, thermal="on", accuracy="reference")
        true = abs(standard.friction_fluid / reference.friction_fluid - 1.0)
        assert true <= standard.friction_error + reference.friction_error
        assert true < 2e-3


def test_a_cold_film_that_cannot_be_solved_is_a_status(monkeypatch):
    def stubborn(*arguments, **options):
        return replace(solve_steady(*arguments, **options), status="failed", reason="path_limit", friction_fluid=0.0)

    monkeypatch.setattr(thermal_steady, "solve_steady", stubborn)
    result = solve_smooth(contact(), oil(), BODIES, thermal="on")
    assert (result.status, result.reason, result.heat, result.friction_fluid) == ("failed", "path_limit", None, 0.0)


def test_start_from_a_neighbour_gives_the_same_with_fewer_iterations():
    first = solve_smooth(contact(slide_to_roll=1.0), oil(), BODIES, thermal="on")
    line = contact(slide_to_roll=1.03, pressure_hertz=1.02e9)
    cold = solve_smooth(line, oil(), BODIES, thermal="on")
    warm = solve_smooth(line, oil(), BODIES, thermal="on", start=first.isothermal, start_heat=first.heat)
    assert warm.rounds <= cold.rounds
    assert warm.iterations < cold.iterations
    assert warm.friction_fluid == pytest.approx(cold.friction_fluid, rel=2e-4)
    assert warm.film.film_central == pytest.approx(cold.film.film_central, rel=2e-4)


@pytest.mark.parametrize(("pressure", "radius"), [(0.8e9, 0.08), (0.8e9, 0.005), (2.5e9, 0.08)])
def test_fast_rolling_of_a_cold_oil_heats_no_more_than_its_flow_work(pressure: float, radius: float) -> None:
    """The pressure-driven flow cannot give the oil more than all of its pressure, p/(rho c), on the way through."""
    line = contact(speed_entrainment=8.0, slide_to_roll=0.0, pressure_hertz=pressure, radius_equivalent=radius)
    cold = Oil.load("n100").at(313.15)
    result = solve_smooth(line, cold, BODIES, thermal="on", accuracy="fast")
    assert result.status == "converged"
    rise = result.temperature_film_max - cold.temperature
    assert 1.0 < rise < result.film.pressure_max / (cold.density * cold.heat_capacity)


def test_a_heat_balance_too_coarse_for_the_contact_goes_to_finer_grids(monkeypatch):
    """Thick and fast, with heat that the film convects."""
    line = contact(
        pressure_hertz=568.85e6, radius_equivalent=5.9903e-3, speed_entrainment=53.552, slide_to_roll=0.19932,
        speed_sliding_lengthwise=3.1207,
    )  # fmt: skip
    lubricant = oil(
        viscosity_inlet=1.2512, pressure_viscosity=2.2733e-8, rheology="newtonian", temperature=391.35,
        temperature_viscosity=0.03,
    )  # fmt: skip

    def solve(accuracy):
        return solve_smooth(line, lubricant, BODIES, thermal="on", accuracy=accuracy)

    fast, reference = solve("fast"), solve("reference")
    monkeypatch.setitem(refine.TOLERANCE, "fast", math.inf)  # three grids whatever their error
    coarse = solve("fast")
    assert fast.film.nodes > coarse.film.nodes
    assert coarse.friction_error > 1.1 * fast.friction_error
    assert fast.friction_error < 0.02
    assert fast.film_error < 1e-3
    friction, film = (fast.friction_fluid, reference.friction_fluid), (fast.film.film_min, reference.film.film_min)
    assert friction[0] == pytest.approx(friction[1], rel=fast.friction_error + reference.friction_error)
    assert film[0] == pytest.approx(film[1], rel=2.0 * fast.film_error)  # the estimate may be half of the true one


def lose(monkeypatch, first, beyond):
    """Films that cannot be solved from one call of the solver to another."""
    calls = itertools.count(1)

    def stubborn(*arguments, **options):
        if first <= next(calls) < beyond:
            raise NewtonFailure("damping_exhausted", 1)
        return solve_level(*arguments, **options)

    monkeypatch.setattr(hot_film, "solve_level", stubborn)


@pytest.mark.parametrize("fails", [3, 40])
def test_a_film_that_cannot_follow_takes_shorter_steps_or_says_so(fails, monkeypatch):
    """Some films fail on the first grid: with shorter steps the same contact; where all do, a failure."""
    exact = solve_smooth(contact(), oil(), BODIES, thermal="on")
    lose(monkeypatch, 2, 2 + fails)
    result = solve_smooth(contact(), oil(), BODIES, thermal="on")
    if fails == 3:
        assert result.status == "converged"
        assert result.friction_fluid == pytest.approx(exact.friction_fluid, rel=1e-4)
    else:
        assert (result.status, result.reason, result.heat) == ("failed", "damping_exhausted", None)
        assert (result.friction_fluid, result.friction_error) == (0.0, np.inf)


def test_a_film_that_follows_no_further_counts_its_last_change(monkeypatch):
    model, first = {}, hot_film.HotFilm.started
    lose(monkeypatch, 6, math.inf)

    def started(self, cold, guess):
        self.tolerance = 1e-12  # never met
        first(self, cold, guess)
        model["change"], model["rounds"] = self.change, self.rounds
        raise NewtonFailure("stop", 0)

    monkeypatch.setattr(hot_film.HotFilm, "started", started)
    solve_smooth(contact(), oil(), BODIES, thermal="on")
    assert model["rounds"] >= 4
    assert 0.0 < max(model["change"]) <= hot_film.ACCEPTED_CHANGE


def test_an_old_matrix_leaves_no_flow_that_does_not_balance(monkeypatch):
    """A matrix of an earlier round gives too small a correction; it is updated if the residual is too large."""
    case = Contact(
        pressure_hertz=1.3e9, radius_equivalent=6.08e-3, effective_modulus=226e9, speed_entrainment=24.16,
        slide_to_roll=0.967, speed_sliding_lengthwise=10.93, viscosity_inlet=0.0599, pressure_viscosity=1.34e-8,
        eyring_stress=2.63e6, temperature_oil=350.0, temperature_viscosity=0.0439, limiting_shear_coefficient=0.102,
        thermal="on", accuracy="fast",
    )  # fmt: skip
    monkeypatch.setattr(hot_film, "EXTRAPOLATED", -1.0)  # a heat balance on every grid
    balanced = case.solve()
    monkeypatch.setattr(hot_film, "MASS_RESIDUAL", np.inf)
    left = case.solve()
    assert balanced.film.mass_residual <= 5e-4 < left.film.mass_residual
    assert left.friction_coefficient == pytest.approx(balanced.friction_coefficient, rel=1e-4)
