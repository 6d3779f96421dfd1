"""Thermal friction of the FVA3 card against an independent estimate of ours (quasi-one-dimensional, other code).

That estimate takes the Hertz pressure, the film of a formula with the Zhu-Cheng inlet factor, equal-temperature
division of the heat, the viscosity at mid-film of a parabola and k = 0.14 (1 + 0.8 p/GPa) W/(m K); here film and
temperature are solved together. At 15 m/s and a slide-to-roll ratio of 0.5 that factor is 0.65, the solved one 0.78
(`test_film_energy` compares the latter with the energy equation): friction is 10 % lower for the thicker film.
"""

from dataclasses import replace

import pytest
from contacts import line_contact
from twins.material_points import at_mid_film

from ehl.fluid.lubricant import FilmConductivity
from ehl.fluid.oil import Oil
from ehl.material import Material
from ehl.smooth.thermal import solve_smooth

# p_h [GPa], u_r [m/s], SR: isothermal over thermal friction, thermal friction (0 where not noted)
ESTIMATE = [
    (1, 5, 0.05, 1.04, 0.0258), (1, 5, 0.5, 1.50, 0.0273), (1, 5, 1.5, 2.27, 0.0210), (1, 15, 0.5, 2.28, 0.0189),
    (1, 15, 1.5, 3.70, 0.0135), (2, 5, 0.2, 1.31, 0.0), (2, 5, 1.5, 2.71, 0.0152), (2, 15, 0.5, 2.42, 0.0161),
    (2, 15, 1.5, 4.05, 0.0105),
]  # fmt: skip


@pytest.mark.parametrize(("pressure", "speed", "slide", "ratio", "friction"), ESTIMATE)
def test_isothermal_over_thermal_friction(monkeypatch, pressure, speed, slide, ratio, friction):
    at_mid_film(monkeypatch)
    state = {"radius_equivalent": 10e-3, "effective_modulus": 226e9, "pressure_hertz": pressure * 1e9}
    contact = line_contact(**state, speed_entrainment=speed, slide_to_roll=slide)
    oil = replace(Oil.load("fva3").at(353.15), eyring_stress=5e6, limiting_shear_coefficient=0.047)
    oil = replace(oil, film_conductivity=FilmConductivity(c1=0.8e-9, c2=0.0))
    steel = Material.load("steel").model_copy(update={"thermal_conductivity": 46.0})
    result = solve_smooth(contact, oil, (steel, steel), thermal="on")
    assert result.status == "converged"
    assert result.isothermal.friction_fluid / result.friction_fluid == pytest.approx(ratio, rel=0.08)
    if friction:
        assert result.friction_fluid == pytest.approx(friction, rel=0.1)
