"""Heat of the transient solver against direct quadrature, energy and the steady solver, with that of the inlet flow."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from contacts import line_contact
from samples import CONTACT, STEEL, contact_case
from twins.material_points import material_point_matrix, without_flow_heat

import ehl.smooth.thermal
from ehl.contact import Contact
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from ehl.inputs import TOLERANCE
from ehl.line_contact import LineContact
from ehl.rough import RoughSurfaces, solve_transient
from ehl.rough._kernels.march import HEAT_RATE, MU_FLUID, SHARE
from ehl.rough.mixed import ROLLING_EFFECT, ROUGHNESS_EFFECT, ROUGHNESS_POWER, ROUGHNESS_RATIO, film_heat_of
from ehl.rough.run import TransientRun
from ehl.rough.scaling import Settings, build_problem
from ehl.smooth.thermal import SmoothFilm, solve_smooth
from ehl.solve import NO_INLET_HEAT
from ehl.surface.roughness import generate_profile


def contact(speed: float = 10.0, slide_to_roll: float = 0.3, **change: float) -> LineContact:
    return line_contact(speed_entrainment=speed, slide_to_roll=slide_to_roll, **change)


SMALL = {"radius_equivalent": 0.01, "effective_modulus": 226e9}
OIL = Lubricant(0.0106, 12e-9, rheology="eyring", eyring_stress=5e6, temperature=373.15, temperature_viscosity=0.04)


def thermal_run(line: LineContact, nodes: int = 240, travel: float = 10.0, **options: Any) -> tuple[TransientRun, Any]:
    surfaces = options.pop("surfaces", RoughSurfaces())
    settings = Settings(nodes, 20e-9, 0.1, math.inf, True, 8e9, **options)
    run = TransientRun(build_problem(line, OIL, surfaces, (STEEL, STEEL), settings))
    return run, run.advance(round(travel * run.problem.units.steps_per_half_width))[0]


@pytest.mark.parametrize("slide_to_roll", [0.3, -1.2])
def test_preheating_by_an_even_flux_warms_like_a_half_space(slide_to_roll: float) -> None:
    """Behind the inlet the exposure of a point is its way over its speed: 2 q sqrt(t/pi)/effusivity."""
    line = contact(slide_to_roll=slide_to_roll)
    run, _ = thermal_run(line, 400, 0.0)
    x = run.problem.x
    run.preheat(12.0, np.full((2, x.size), 1e9))
    inside = (x > -1.5) & (x < 1.0)
    for s, speed in enumerate((line.speed_1, line.speed_2)):
        # past fluxes are in the memory, that of the step itself comes with the shear
        rise = run.state.surface_temperature[s] + 1e9 * run.problem.model.heat.weights[s].sum()
        exposed = (x - x[0]) * line.half_width / speed
        exact = 2.0 * 1e9 * np.sqrt(exposed / math.pi) / STEEL.thermal_effusivity
        assert rise[inside] == pytest.approx(exact[inside], rel=0.02)


def test_preheated_contact_settles_where_the_rolled_one_does() -> None:
    """The slower surface takes 8 b of travel to warm; with its own mean heat put in at once mu is the same."""
    line = contact(slide_to_roll=1.5)
    profile = generate_profile(0.2e-6, 0.05 * line.half_width, 16.0 * line.half_width, 2.5e-3 * line.half_width, 3)
    settings: Any = {"accuracy": "fast", "peklenik_number": math.inf, "thermal": True, "nodes": 300, "travel": 8.0}
    settings |= {"surfaces": RoughSurfaces(profile), "materials": (STEEL, STEEL)}
    heated, rolled = (solve_transient(line, OIL, fine_roughness=fine, **settings) for fine in (True, False))
    assert any("preheated by the mean heat" in note for note in heated.notes)
    assert not any("shorter start-up" in note for note in rolled.notes)
    assert heated.steps < 0.75 * rolled.steps
    assert heated.temperature_flash == pytest.approx(rolled.temperature_flash, abs=3.0)
    assert heated.friction_coefficient == pytest.approx(rolled.friction_coefficient, rel=0.01)


@pytest.mark.parametrize(
    ("slide_to_roll", "bound"), [(0.3, 0.012), (-1.2, 0.016), (3.0, 0.03)], ids=["1 faster", "2 faster", "2 backwards"]
)
def test_surface_temperatures_match_direct_quadrature(slide_to_roll: float, bound: float) -> None:
    """First order in the mesh: from 240 to 480 nodes the error halves."""
    line = contact(slide_to_roll=slide_to_roll)
    for nodes, allowed in ((240, bound), (480, 0.6 * bound)):
        run, _ = thermal_run(line, nodes)
        for s, speed in enumerate((line.speed_1, line.speed_2)):
            expected = material_point_matrix(run.problem.x * line.half_width, speed, STEEL) @ run.state.flux_into[s]
            computed = run.state.surface_temperature[s]
            assert np.abs(computed - expected).max() < allowed * expected.max()
            assert computed.max() == pytest.approx(expected.max(), rel=1e-2)


@pytest.mark.parametrize("rms", [0.0, 0.3e-6])
@pytest.mark.parametrize("rolling", [0.0, 2e6])
def test_heat_into_the_surfaces_is_the_friction_power_and_that_of_the_flow(rms: float, rolling: float) -> None:
    line = contact(slide_to_roll=0.5)
    surfaces = RoughSurfaces(generate_profile(rms, 20e-6, 16.0 * line.half_width, 2e-6, 3) if rms > 0.0 else None)
    x = np.linspace(-3.0, 1.0, 41) * line.half_width
    flux = rolling * np.exp(-((x / line.half_width + 1.0) ** 2) / 0.1)
    film_heat = (x, flux, 0.0 * x, 0.0 * x + 1.0) if rolling else None
    run, records = thermal_run(line, 200, 5.0, surfaces=surfaces, film_heat=film_heat)
    model, units = run.problem.model, run.problem.units
    friction = records[:, MU_FLUID] - model.contact.wedge_shear / model.contact.full_load + 0.1 * records[:, SHARE]
    power = friction * line.load_per_length * line.speed_sliding + np.trapezoid(flux, x)
    np.testing.assert_allclose(records[5:, HEAT_RATE] * units.spacing, power[5:], rtol=1e-3)


def rough_case(rms: float, speed: float = 15.0, **model: object) -> Contact:
    return contact_case(
        contact=CONTACT | {"radius_equivalent": 0.01, "speed_entrainment": speed},
        lubricant={"oil": "75w90", "temperature_oil": 333.15},
        surface={"roughness_rms_1": rms, "correlation_length": 60e-6},
        model={"accuracy": "fast"} | model,
    )


@pytest.mark.parametrize(
    ("oil", "celsius", "speed", "slide_to_roll"),
    [("75w90", 40, 20.0, 0.05), ("75w90", 60, 15.0, 0.5), ("fva3", 40, 20.0, 0.5), ("fva3", 60, 15.0, 0.05)],
)
def test_fast_smooth_film_is_the_steady_thermal_one(
    oil: str, celsius: float, speed: float, slide_to_roll: float
) -> None:
    line, lubricant = contact(speed, slide_to_roll, **SMALL), Oil.load(oil).at(273.15 + celsius)
    steady = solve_smooth(line, lubricant, (STEEL, STEEL), thermal="on")
    rolling = film_heat_of(steady.heat, line, lubricant)
    assert rolling is not None
    moving = solve_transient(line, lubricant, nodes=640, travel=2.0, thermal=True, film_heat=rolling)
    # without that heat the films of these four would be far thicker
    film = float(np.interp(0.0, moving.profiles.x, moving.profiles.film))
    assert film == pytest.approx(steady.film.film_central, rel=0.01)
    assert moving.friction_coefficient == pytest.approx(steady.friction_fluid, rel=0.01)
    assert moving.temperature_film_max == pytest.approx(steady.temperature_film_max, abs=1.5)  # in the pressure spike
    assert moving.temperature_flash == pytest.approx(steady.temperature_flash, abs=0.62)  # 1.5 % of the largest rise


def test_the_flow_heats_nothing_where_it_is_slow(monkeypatch: pytest.MonkeyPatch) -> None:
    line, oil = contact(1.0, 0.3, **SMALL), Oil.load("75w90").at(353.15)
    steady = solve_smooth(line, oil, (STEEL, STEEL), thermal="on", accuracy="reference")
    assert 0.0 < steady.heat.temperature_rise_rolling.max() < ROLLING_EFFECT / 0.02
    assert film_heat_of(steady.heat, line, oil) is None
    assert film_heat_of(None, line, oil) is None
    # and what is left out changes the film by less than half a per cent
    without_flow_heat(monkeypatch)
    without = solve_smooth(line, oil, (STEEL, STEEL), thermal="on", accuracy="reference")
    assert without.film.film_central == pytest.approx(steady.film.film_central, rel=5e-3)


@pytest.mark.parametrize("speed", [10.0, 20.0])
def test_the_hot_film_decides_whether_roughness_is_left_out(speed: float) -> None:
    # film ratio at which the estimated effect of roughness is half the tolerance
    limit = ROUGHNESS_RATIO * (ROUGHNESS_EFFECT / (0.5 * TOLERANCE["fast"])) ** (1.0 / ROUGHNESS_POWER)
    smooth = rough_case(0.0, speed).solve()
    hot = smooth.film_central
    assert hot < 0.85 * smooth.isothermal.film_central

    between = rough_case(hot / (0.9 * limit), speed).solve()
    assert between.film_ratio > limit  # stays the isothermal one
    assert between.transient is not None

    left_out = rough_case(hot / (1.05 * limit), speed).solve()
    assert left_out.transient is None
    by_roughness = left_out.friction_error - smooth.friction_error
    assert by_roughness == pytest.approx(0.5 * TOLERANCE["fast"] / 1.05**ROUGHNESS_POWER, abs=2e-3)


def test_a_note_says_where_no_balance_gave_the_heat_of_the_flow(monkeypatch: pytest.MonkeyPatch) -> None:
    def lost(*arguments: object, **options: object) -> SmoothFilm:
        found = solve_smooth(*arguments, **options)  # type: ignore[arg-type]
        return replace(found, status="failed", reason="thermal_rounds", heat=None)

    monkeypatch.setattr(ehl.solve, "solve_smooth", lost)
    result = rough_case(0.5e-6, friction_tolerance=0.5).solve()
    assert result.transient is not None
    assert NO_INLET_HEAT in result.notes
