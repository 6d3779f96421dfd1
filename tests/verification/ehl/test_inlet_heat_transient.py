"""Heat of the pressure-driven flow in the transient solver: fast films of gear oils against the steady solver."""

import math
from dataclasses import replace

import numpy as np
import pytest
from contacts import line_contact
from twins.material_points import without_flow_heat

import ehl.smooth.thermal
from ehl.common.validation import validate
from ehl.contact import Contact
from ehl.fluid.oil import Oil
from ehl.inputs import TOLERANCE
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.rough import RoughSurfaces, solve_transient
from ehl.rough._kernels.march import HEAT_RATE, MU_FLUID
from ehl.rough.mixed import (
    ROLLING_EFFECT,
    ROUGHNESS_EFFECT,
    ROUGHNESS_POWER,
    ROUGHNESS_RATIO,
    rolling_heat_of,
)
from ehl.rough.run import TransientRun
from ehl.rough.scaling import Settings, build_problem
from ehl.smooth.thermal import SmoothFilm, solve_smooth
from ehl.solve import NO_INLET_HEAT

STEEL = Material.load("steel")


def line(speed: float, slide_to_roll: float) -> LineContact:
    return line_contact(
        radius_equivalent=0.01, effective_modulus=226e9, speed_entrainment=speed, slide_to_roll=slide_to_roll
    )


def rough_case(rms: float, speed: float = 15.0, **model: object) -> Contact:
    return validate(
        Contact,
        {
            "contact": {
                "radius_equivalent": 0.01,
                "pressure_hertz": 1e9,
                "speed_entrainment": speed,
                "slide_to_roll": 0.3,
            },
            "lubricant": {"oil": "75w90", "temperature_oil": 333.15},
            "surface": {"roughness_rms_1": rms, "correlation_length": 60e-6},
            "model": {"accuracy": "fast"} | model,
        },
    )


@pytest.mark.parametrize(
    ("oil", "celsius", "speed", "slide_to_roll"),
    [("75w90", 40, 20.0, 0.05), ("75w90", 60, 15.0, 0.5), ("fva3", 40, 20.0, 0.5), ("fva3", 60, 15.0, 0.05)],
)
def test_fast_smooth_film_is_the_steady_thermal_one(
    oil: str, celsius: float, speed: float, slide_to_roll: float
) -> None:
    contact, lubricant = line(speed, slide_to_roll), Oil.load(oil).at(273.15 + celsius)
    steady = solve_smooth(contact, lubricant, (STEEL, STEEL), thermal="on")
    rolling = rolling_heat_of(steady.heat, lubricant)
    assert rolling is not None
    moving = solve_transient(contact, lubricant, nodes=640, travel=2.0, thermal=True, rolling_heat=rolling)
    # without that heat the films of these four would be far thicker
    film = float(np.interp(0.0, moving.profiles.x, moving.profiles.film))
    assert film == pytest.approx(steady.film.film_central, rel=0.01)
    assert moving.friction_coefficient == pytest.approx(steady.friction_fluid, rel=0.01)
    assert moving.temperature_film_max == pytest.approx(steady.temperature_film_max, abs=1.5)  # in the pressure spike
    assert moving.temperature_flash == pytest.approx(steady.temperature_flash, abs=0.62)  # 1.5 % of the largest rise


def test_heat_into_the_surfaces_is_the_friction_power_and_that_of_the_flow() -> None:
    contact, oil = line(15.0, 0.5), Oil.load("75w90").at(333.15)
    x = np.linspace(-3.0, 1.0, 41) * contact.half_width
    flux = 2e6 * np.exp(-((x / contact.half_width + 1.0) ** 2) / 0.1)
    settings = Settings(200, 20e-9, 0.1, math.inf, True, 8e9, rolling_heat=(x, flux))
    run = TransientRun(build_problem(contact, oil, RoughSurfaces(), (STEEL, STEEL), settings))
    units, model = run.problem.units, run.problem.model
    record = run.advance(round(3.0 * units.steps_per_half_width))[0][-1]
    sliding = record[MU_FLUID] - model.contact.wedge_shear / model.contact.full_load
    power = sliding * contact.load_per_length * contact.speed_sliding
    assert record[HEAT_RATE] * units.spacing == pytest.approx(power + np.trapezoid(flux, x), rel=2e-3)


def test_the_flow_heats_nothing_where_it_is_slow(monkeypatch: pytest.MonkeyPatch) -> None:
    contact, oil = line(1.0, 0.3), Oil.load("75w90").at(353.15)
    steady = solve_smooth(contact, oil, (STEEL, STEEL), thermal="on", accuracy="reference")
    assert steady.heat is not None
    assert 0.0 < steady.heat.temperature_rise_rolling.max() < ROLLING_EFFECT / 0.02
    assert rolling_heat_of(steady.heat, oil) is None
    assert rolling_heat_of(None, oil) is None
    # and what is left out changes the film by less than half a per cent
    without_flow_heat(monkeypatch)
    without = solve_smooth(contact, oil, (STEEL, STEEL), thermal="on", accuracy="reference")
    assert without.film.film_central == pytest.approx(steady.film.film_central, rel=5e-3)


def test_leaving_out_the_roughness_of_a_fast_film_makes_no_step() -> None:
    left_out = rough_case(0.15e-6).solve()
    assert left_out.transient is None
    rolled = rough_case(0.15e-6, shortcuts="off").solve()
    assert rolled.transient is not None
    allowed = left_out.friction_error + rolled.friction_error
    assert rolled.friction_coefficient == pytest.approx(left_out.friction_coefficient, rel=allowed)
    assert rolled.film_central == pytest.approx(left_out.film_central, rel=0.05)


@pytest.mark.parametrize("speed", [10.0, 20.0])
def test_the_hot_film_decides_whether_roughness_is_left_out(speed: float) -> None:
    # film ratio at which the estimated effect of roughness is half the tolerance
    limit = ROUGHNESS_RATIO * (ROUGHNESS_EFFECT / (0.5 * TOLERANCE["fast"])) ** (1.0 / ROUGHNESS_POWER)
    smooth = rough_case(0.0, speed).solve()
    assert smooth.isothermal is not None
    hot = smooth.film_central
    assert hot < 0.85 * smooth.isothermal.film_central

    between = rough_case(hot / (0.9 * limit), speed).solve()
    assert between.film_ratio > limit  # stays the isothermal one
    assert between.transient is not None

    rms = hot / (1.05 * limit)
    left_out, rolled = rough_case(rms, speed).solve(), rough_case(rms, speed, shortcuts="off").solve()
    assert left_out.transient is None
    assert rolled.transient is not None
    assert left_out.film_ratio == pytest.approx(rolled.film_ratio)
    by_roughness = left_out.friction_error - smooth.friction_error
    assert by_roughness == pytest.approx(0.5 * TOLERANCE["fast"] / 1.05**ROUGHNESS_POWER, abs=2e-3)
    allowed = left_out.friction_error + rolled.friction_error
    assert rolled.friction_coefficient == pytest.approx(left_out.friction_coefficient, rel=allowed)


def test_a_note_says_where_no_balance_gave_the_heat_of_the_flow(monkeypatch: pytest.MonkeyPatch) -> None:
    def lost(*arguments: object, **options: object) -> SmoothFilm:
        found = solve_smooth(*arguments, **options)  # type: ignore[arg-type]
        return replace(found, status="failed", reason="thermal_rounds", heat=None)

    monkeypatch.setattr(ehl.solve, "solve_smooth", lost)
    result = rough_case(0.5e-6, friction_tolerance=0.5).solve()
    assert result.transient is not None
    assert NO_INLET_HEAT in result.notes
