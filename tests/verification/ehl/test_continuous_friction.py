"""No shortcut, switch or bound makes friction or film jump, or leaves out, more than the stated error."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from samples import CONTACT, STEEL, contact_case

import ehl
from ehl.contact import Contact
from ehl.rough import RoughSurfaces, TransientResult, solve_transient
from ehl.rough.accuracy import BUDGET, WORK
from ehl.rough.dry_limit import dry_limit, flash_of_rubbing, share_deficit
from ehl.rough.mixed import OVER_CHANGE, film_stress_ratio, roughness_heights, roughness_matters
from ehl.smooth.thermal import solve_smooth
from ehl.surface.roughness import generate_profile

STEP = 1e-4  # of the scanned quantity, where the curves themselves change by far less than the errors


def at(**change) -> ehl.Contact:
    values = CONTACT | {"oil": "75w90", "temperature": 333.15, "slide_to_roll": 0.2, "accuracy": "fast"}
    return ehl.Contact(**(values | change))


def solved(**change) -> ehl.ContactResult:
    result = at(**change).solve()
    assert result.status == "converged"
    return result


def assert_no_jump(one: ehl.ContactResult, two: ehl.ContactResult) -> None:
    for name, error in (("friction_coefficient", "friction_error"), ("film_central", "film_error")):
        a, b = getattr(one, name), getattr(two, name)
        assert abs(a - b) <= 1.1 * max(getattr(one, error) * a, getattr(two, error) * b), name


@pytest.mark.parametrize(("temperature", "speed", "pressure"), [(60.0, 10.0, 0.8e9), (90.0, 2.0, 1.5e9)])
def test_friction_and_film_pass_a_surface_at_rest(temperature, speed, pressure):
    """Through SR = 2: each step of SR changes mu and film by as much as the next; a mirrored contact is the same."""
    slips = 2.0 + STEP * np.arange(-3.0, 4.0, 2.0)
    state = {"temperature": 273.15 + temperature, "speed_entrainment": speed, "pressure_hertz": pressure}
    *scan, mirrored = (solved(**state, slide_to_roll=slip) for slip in (*slips, -slips[0]))
    for values in ([r.friction_coefficient for r in scan], [r.film_central for r in scan]):
        steps = np.diff(np.log(values))
        assert steps[1] == pytest.approx(0.5 * (steps[0] + steps[2]), rel=0.05)
        assert abs(steps[1]) < 5e-3
    assert mirrored.friction_coefficient == pytest.approx(scan[0].friction_coefficient, rel=1e-12)


SCANS = {
    "slip": ("slide_to_roll", 1e-4, 0.5, {"speed_entrainment": 0.3}),
    "speed": ("speed_entrainment", 0.01, 10.0, {"slide_to_roll": 0.01}),
    "temperature": ("temperature", 300.0, 420.0, {"speed_entrainment": 0.3, "slide_to_roll": 0.02}),
}


@pytest.mark.parametrize("name", SCANS)
def test_heat_left_out_or_not_makes_no_jump(name):
    """At the very place where "auto" begins to compute heat, both sides agree within the stated errors."""
    key, low, high, others = SCANS[name]

    def heated(value: float) -> bool:
        return solved(**others, **{key: value}).heat is not None

    low, high = places(low, high, heated)
    assert_no_jump(solved(**others, **{key: low}), solved(**others, **{key: high}))


def test_rough_run_passes_a_surface_at_rest():
    """The memory of a surface turns round with its motion: a step of 2e-6 in SR changes mu by less than 1e-4."""
    found, settings = [], {"accuracy": "fast", "thermal": True, "nodes": 128, "travel": 1.0}
    for slip in (2.0 - 1e-6, 2.0, 2.0 + 1e-6):
        problem = at(slide_to_roll=slip, speed_entrainment=3.0).problem()
        half_width = problem.line.half_width
        rough = generate_profile(0.2e-6, 0.4 * half_width, 16.0 * half_width, 0.02 * half_width, 3)
        run = solve_transient(problem.line, problem.lubricant, RoughSurfaces(rough, None), **settings)
        found.append(run.friction_coefficient)
    assert found == pytest.approx([found[1]] * 3, rel=1e-4)


def smooth_of(contact: ehl.Contact) -> tuple[float, float, float, float]:
    """Film, friction, film ratio of the highest Rq and stress ratio of the smooth contact, as the switches see them."""
    problem = contact.problem()
    model, bulk = problem.model, problem.temperature_bulk
    found = solve_smooth(
        *(problem.line, problem.lubricant, (STEEL, STEEL)),
        temperature_bulk=bulk, thermal=model.thermal, accuracy=model.accuracy,
    )  # fmt: skip
    stress = film_stress_ratio(found.friction_fluid, problem.line, problem.lubricant)
    rms, _ = roughness_heights(problem.surface, problem.line)
    return found.isothermal.film_central, found.friction_fluid, found.film.film_central / rms, stress


def places(low: float, high: float, holds: Callable[[float], bool]) -> tuple[float, float]:
    """Two values, `STEP` apart, between which a switch turns."""
    first = holds(low)
    assert holds(high) != first
    while high / low - 1.0 > STEP:
        middle = (low * high) ** 0.5
        low, high = (middle, high) if holds(middle) == first else (low, middle)
    return low, high


ROUGH = {"roughness_rms": 0.2e-6, "correlation_length": 60e-6}


@pytest.mark.parametrize("slip", [0.02, 0.2])
def test_roughness_left_out_or_not_makes_no_jump(slip: float) -> None:
    """At the very speed from which the film is thick enough to leave roughness out."""

    def matters(speed: float) -> bool:
        contact = at(slide_to_roll=slip, speed_entrainment=speed, **ROUGH)
        _, _, ratio, stress = smooth_of(contact)
        return roughness_matters(ratio, contact.model, stress)

    low, high = places(1.0, 40.0, matters)
    with_it, without = (at(slide_to_roll=slip, speed_entrainment=speed, **ROUGH).solve() for speed in (low, high))
    assert with_it.transient is not None
    assert without.transient is None
    assert_no_jump(with_it, without)


def test_film_left_out_or_not_makes_no_jump() -> None:
    """At the very speed below which the contact counts as dry."""
    values = {"slide_to_roll": 0.5, "temperature": 393.15, "roughness_rms": 0.4e-6, "correlation_length": 60e-6}

    def wet(speed: float) -> bool:
        problem = at(speed_entrainment=speed, **values).problem()
        film, friction, _, _ = smooth_of(at(speed_entrainment=speed, **values))
        return dry_limit(replace(problem, bodies=(STEEL, STEEL)), film, friction) is None

    low, high = places(1e-4, 0.3, wet)
    dry, rolled = (at(speed_entrainment=speed, **values).solve() for speed in (low, high))
    assert dry.dry is not None
    assert rolled.transient is not None
    assert_no_jump(dry, rolled)


RMS = 0.4e-6


def case(speed: float, length: float, peklenik: float = 1.0, pressure: float = 1e9, **model: Any) -> Contact:
    """The test line of docs/validation_mixed.md; correlation length in half-widths (263 um at 1 GPa)."""
    contact = CONTACT | {"effective_modulus": 228e9, "pressure_hertz": pressure, "slide_to_roll": 0.5}
    rough = {"roughness_rms_1": RMS / 2.0**0.5, "roughness_rms_2": RMS / 2.0**0.5, "boundary_film": 30e-9}
    length *= 4.0 * 0.015 * pressure / 228e9
    return contact_case(
        contact=contact | {"speed_entrainment": speed},
        lubricant={"viscosity_inlet": 0.015, "pressure_viscosity": 15e-9, "temperature_oil": 373.15},
        surface=rough | {"peklenik_number": peklenik, "correlation_length": length},
        model={"accuracy": "fast", "thermal": "off"} | model,
    )


@pytest.mark.parametrize(("speed", "peklenik"), [(3e-4, 1.0), (3e-4, 3.0), (1e-4, 1e6)])
def test_dry_contact_instead_of_a_nil_film_changes_no_more_than_said(speed: float, peklenik: float) -> None:
    quick = case(speed, 0.1, peklenik).solve()
    full = case(speed, 0.1, peklenik, shortcuts="off").solve()
    assert quick.dry is not None
    assert any(text.startswith("film:") for text in quick.skipped)
    assert quick.status == "converged"
    assert full.dry is None
    assert full.transient is not None
    assert abs(full.friction_coefficient / quick.friction_coefficient - 1.0) <= quick.friction_error
    assert quick.friction_error < 0.025
    assert quick.film_central == pytest.approx(full.film_central, rel=quick.film_error + 0.1)
    # the dry contact is one of plane strain: summits of two-dimensional roughness are stiffer
    assert quick.pressure_max == pytest.approx(full.pressure_max, rel=0.15 if peklenik > 100.0 else 0.35)


def test_share_off_the_asperities_grows_with_film_lay_and_pressure() -> None:
    base = share_deficit(0.04, 1.0, 15.0)
    assert base == pytest.approx(0.01)
    assert share_deficit(0.08, 1.0, 15.0) == pytest.approx(base * 2.0**1.5)
    assert base < share_deficit(0.04, 3.0, 15.0) < share_deficit(0.04, 1e6, 15.0) == pytest.approx(0.12)
    assert share_deficit(0.04, 1.0, 30.0) > base == share_deficit(0.04, 1.0 / 3.0, 5.0)
    assert share_deficit(10.0, 1.0, 15.0) == 1.0
    # the flash temperature of rubbing follows the power
    line, bulk = case(1.0, 0.1).line_contact(), (350.0, 350.0)
    rises = [flash_of_rubbing(line, mu, (STEEL, STEEL), bulk) - 350.0 for mu in (0.05, 0.1)]
    assert rises[0] > 10.0
    assert rises[1] == pytest.approx(2.0 * rises[0])
    assert flash_of_rubbing(line, 0.0, (STEEL, STEEL), bulk) == 350.0


@pytest.mark.parametrize(("speed", "pressure"), [(2.0, 1e9), (0.7, 1.5e9)])
def test_coarser_answer_beyond_the_budget_bounds_the_resolved_one(
    monkeypatch: pytest.MonkeyPatch, speed: float, pressure: float
) -> None:
    full = case(speed, 0.05, pressure=pressure).solve()
    assert full.transient is not None
    assert full.reason != "mesh_budget"
    monkeypatch.setitem(BUDGET, "fast", (200, 200))
    coarse = case(speed, 0.05, pressure=pressure).solve()
    assert (coarse.status, coarse.reason) == ("unsettled", "mesh_budget")
    assert coarse.transient.nodes < 140
    true = abs(full.friction_coefficient / coarse.friction_coefficient - 1.0)
    assert true <= coarse.friction_error + full.friction_error
    # the point estimate itself is of use
    assert true < 0.6
    assert coarse.friction_error < 3.0


def test_a_wall_that_says_too_little_gives_way_to_a_mesh_as_fine_as_it_takes(monkeypatch: pytest.MonkeyPatch) -> None:
    full = case(0.7, 0.05).solve()
    monkeypatch.setitem(BUDGET, "fast", (200, 1200))
    fine = case(0.7, 0.05).solve()
    assert fine.transient.nodes > 200
    assert fine.transient.subgrid_error == 0.0
    true = abs(full.friction_coefficient / fine.friction_coefficient - 1.0)
    assert true <= fine.friction_error + full.friction_error
    assert fine.friction_error < 0.3

    # where that takes too much work, it is given up
    runs: list[TransientResult] = []

    def recorded(*given: Any, **options: Any) -> TransientResult:
        runs.append(solve_transient(*given, **options))
        return runs[-1]

    monkeypatch.setattr("ehl.rough.mixed.solve_transient", recorded)
    monkeypatch.setitem(WORK, "fast", 3e5)
    coarse = case(0.7, 0.05).solve()
    assert (coarse.status, coarse.reason) == ("unsettled", "mesh_budget")
    assert coarse.transient.nodes < 140 < fine.transient.nodes
    # twice the cut-off is part of the error
    kept, doubled = (run.friction_coefficient for run in runs)
    assert coarse.transient.subgrid_error >= OVER_CHANGE * abs(doubled / kept - 1.0) > 0.0
    true = abs(full.friction_coefficient / coarse.friction_coefficient - 1.0)
    assert true <= coarse.friction_error + full.friction_error


def test_a_wall_under_thick_films_is_an_answer_and_says_what_it_leaves_out(monkeypatch: pytest.MonkeyPatch) -> None:
    full = case(19.0, 0.05).solve()
    monkeypatch.setitem(BUDGET, "fast", (200, 1200))
    quick = case(19.0, 0.05).solve()
    assert quick.transient.nodes < 140
    assert 0.0 < quick.transient.subgrid_error < 0.2
    assert quick.friction_error == pytest.approx(quick.transient.friction_error, rel=1e-12)
    assert quick.friction_error > quick.transient.subgrid_error
    assert any("waves finer than the mesh" in text for text in quick.skipped)
    true = abs(full.friction_coefficient / quick.friction_coefficient - 1.0)
    assert true <= quick.friction_error + full.friction_error
