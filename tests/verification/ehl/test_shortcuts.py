"""Shortcuts of the rough solver against the runs without them: dry contact, roughness beyond the mesh budget."""

import math
from dataclasses import replace
from typing import Any

import pytest

from ehl.common.validation import validate
from ehl.contact import Contact
from ehl.fluid.lubricant import Lubricant
from ehl.material import Material
from ehl.rough import TransientResult, solve_transient
from ehl.rough.accuracy import BUDGET, WORK
from ehl.rough.dry_limit import flash_of_rubbing, share_deficit
from ehl.rough.mixed import OVER_CHANGE, film_stress_ratio, roughness_effect

RMS = 0.4e-6


def case(speed: float, length: float, peklenik: float = 1.0, pressure: float = 1e9, **model: Any) -> Contact:
    """The test line of docs/validation_mixed.md; correlation length in half-widths (263 um at 1 GPa)."""
    rms = RMS / 2.0**0.5
    return validate(
        Contact,
        {
            "contact": {
                "effective_modulus": 228e9, "radius_equivalent": 0.015, "pressure_hertz": pressure,
                "speed_entrainment": speed, "slide_to_roll": 0.5,
            },
            "lubricant": {"viscosity_inlet": 0.015, "pressure_viscosity": 15e-9, "temperature_oil": 373.15},
            "surface": {
                "roughness_rms_1": rms, "roughness_rms_2": rms, "peklenik_number": peklenik, "boundary_film": 30e-9,
                "correlation_length": length * 4.0 * 0.015 * pressure / 228e9,
            },
            "model": {"accuracy": "fast", "thermal": "off"} | model,
        },
    )  # fmt: skip


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


def test_a_film_that_carries_load_is_not_skipped() -> None:
    assert case(0.03, 0.1).solve().dry is None


def test_share_off_the_asperities_grows_with_film_lay_and_pressure() -> None:
    base = share_deficit(0.04, 1.0, 15.0)
    assert base == pytest.approx(0.01)
    assert share_deficit(0.08, 1.0, 15.0) == pytest.approx(base * 2.0**1.5)
    assert base < share_deficit(0.04, 3.0, 15.0) < share_deficit(0.04, 1e6, 15.0) == pytest.approx(0.12)
    assert share_deficit(0.04, 1.0, 30.0) > base == share_deficit(0.04, 1.0 / 3.0, 5.0)
    assert share_deficit(10.0, 1.0, 15.0) == 1.0


def test_flash_of_rubbing_follows_the_power() -> None:
    steel = Material.load("steel")
    line = case(1.0, 0.1).line_contact()
    bulk = (350.0, 350.0)
    rises = [flash_of_rubbing(line, mu, (steel, steel), bulk) - 350.0 for mu in (0.05, 0.1)]
    assert rises[0] > 10.0
    assert rises[1] == pytest.approx(2.0 * rises[0])
    assert flash_of_rubbing(line, 0.0, (steel, steel), bulk) == 350.0


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
    assert coarse.transient is not None
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
    assert fine.transient is not None
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
    assert coarse.transient is not None
    assert fine.transient is not None
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
    assert quick.transient is not None
    assert quick.transient.nodes < 140
    assert 0.0 < quick.transient.subgrid_error < 0.2
    assert quick.friction_error == pytest.approx(quick.transient.friction_error, rel=1e-12)
    assert quick.friction_error > quick.transient.subgrid_error
    assert any("waves finer than the mesh" in text for text in quick.skipped)
    true = abs(full.friction_coefficient / quick.friction_coefficient - 1.0)
    assert true <= quick.friction_error + full.friction_error


def test_stress_a_film_does_not_grow_beyond_is_its_limit_where_that_is_lower() -> None:
    contact = case(1.0, 0.1).line_contact()
    oil = Lubricant(0.015, 15e-9)
    limited = replace(oil, limiting_shear_coefficient=0.08)
    assert film_stress_ratio(0.02, contact, oil) == 0.0
    assert film_stress_ratio(0.02, contact, limited) == pytest.approx(0.25)
    assert film_stress_ratio(0.0, contact, limited) == math.inf
    eyring = replace(limited, rheology="eyring", eyring_stress=5e6)
    assert film_stress_ratio(0.02, contact, eyring) == pytest.approx(0.02 * 0.25 * math.pi * 1e9 / 5e6)
    assert roughness_effect(math.inf, 0.0) == 0.0
