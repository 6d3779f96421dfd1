"""Heat of the transient solver against direct quadrature and energy."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from contacts import line_contact
from twins.material_points import material_point_matrix

from ehl.fluid.lubricant import FilmConductivity, Lubricant
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.rough import RoughSurfaces, solve_transient
from ehl.rough._kernels.march import HEAT_RATE, MU_FLUID, SHARE
from ehl.rough.run import TransientRun
from ehl.rough.scaling import Settings, build_problem
from ehl.surface.roughness import generate_profile

STEEL = Material.load("steel")


def contact(speed: float = 10.0, slide_to_roll: float = 0.3) -> LineContact:
    return line_contact(speed_entrainment=speed, slide_to_roll=slide_to_roll)


CONSTANT = FilmConductivity(c1=0.0, c2=0.0)
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
    mu = [
        solve_transient(
            line, OIL, RoughSurfaces(profile), accuracy="fast", peklenik_number=math.inf, thermal=True, nodes=300,
            travel=8.0, materials=(STEEL, STEEL), fine_roughness=fine,
        )
        for fine in (True, False)
    ]  # fmt: skip
    assert any("preheated by the mean heat" in note for note in mu[0].notes)
    assert not any("shorter start-up" in note for note in mu[1].notes)
    assert mu[0].steps < 0.75 * mu[1].steps
    assert mu[0].temperature_flash == pytest.approx(mu[1].temperature_flash, abs=3.0)
    assert mu[0].friction_coefficient == pytest.approx(mu[1].friction_coefficient, rel=0.01)


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
    run, records = thermal_run(line, 200, 5.0, surfaces=surfaces, rolling_heat=(x, flux) if rolling else None)
    model, units = run.problem.model, run.problem.units
    friction = records[:, MU_FLUID] - model.contact.wedge_shear / model.contact.full_load + 0.1 * records[:, SHARE]
    power = friction * line.load_per_length * line.speed_sliding + np.trapezoid(flux, x)
    np.testing.assert_allclose(records[5:, HEAT_RATE] * units.spacing, power[5:], rtol=1e-3)


def test_heat_lowers_friction_at_sliding_as_the_study_found() -> None:
    # isothermal/thermal at 1 GPa, 15 m/s, alpha 15/GPa, SR 1: 0.0334/0.0076 (own earlier study, N = 256, viscosity at
    # mid-film of a parabola, which gives up to 7 % more friction under much heat)
    line = contact(15.0, 1.0)
    oil = Lubricant(0.0106, 15e-9, rheology="eyring", eyring_stress=5e6, temperature=373.15, temperature_viscosity=0.04)
    oil = replace(oil, film_conductivity=CONSTANT)
    annealed = STEEL.model_copy(update={"thermal_conductivity": 46.0})  # of the study
    cold = solve_transient(line, oil, nodes=240)
    warm = solve_transient(line, oil, nodes=240, thermal=True, materials=(annealed, annealed))
    assert cold.friction_coefficient == pytest.approx(0.0334, rel=0.02)
    assert 0.92 * 0.0076 < warm.friction_coefficient < 1.03 * 0.0076
    assert warm.temperature_film_max > warm.temperature_flash > oil.temperature + 25.0
    assert warm.film_mean < cold.film_mean
