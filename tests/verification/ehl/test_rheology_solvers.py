"""Every shear law in both solvers: the transient solution of a smooth contact is the steady one."""

import math
from dataclasses import replace

import numpy as np
import pytest
from contacts import line_contact

from ehl.fluid._kernels import log_mobility
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.rheology import LinearStress, RisingStress
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.rough import RoughSurfaces
from ehl.rough._kernels.fluid import balanced_shear_row, fluidity_rows, isothermal_shear_row, temperature_place
from ehl.rough._kernels.march import MU_FLUID, STAGE
from ehl.rough._kernels.records import FluidityRows, HeatRows
from ehl.rough.accuracy import mesh_length
from ehl.rough.run import TransientRun
from ehl.rough.scaling import Settings, Units, build_problem, scaled_fluid
from ehl.smooth.solver import solve_steady

STEEL = Material.load("steel")
CONTACT = line_contact(speed_sliding_lengthwise=1.0)
OIL = Lubricant(0.015, 15e-9, temperature=353.15, temperature_viscosity=0.04)
SMOOTH = {"limiting_shear_coefficient": 0.06, "limiting_shear": "smooth", "limiting_shear_ambient": 2e6}
CARREAU = {"rheology": "carreau", "carreau_stress": 5e6, "carreau_exponent": 0.5}
OILS = {
    "newtonian": OIL,
    "eyring": replace(OIL, rheology="eyring", eyring_stress=5e6),
    "rising": replace(
        OIL,
        rheology="eyring",
        eyring_stress=RisingStress(stress_low=5e6, stress_slope=0.035, pressure_start=0.5e9, pressure_end=3.5e9),
    ),
    "linear": replace(OIL, rheology="eyring", eyring_stress=LinearStress(4e6, 0.009)),
    "carreau": replace(OIL, **CARREAU),
    "cut": replace(OIL, rheology="eyring", limiting_shear_coefficient=0.03, limiting_shear_ambient=1e6),
    "smooth eyring": replace(OIL, rheology="eyring", **SMOOTH),
    "smooth newtonian": replace(OIL, **SMOOTH),
    "smooth carreau": replace(OIL, **CARREAU, **SMOOTH),
}


def settled(contact: LineContact, oil: Lubricant, per_half_width: float, **changes: object) -> TransientRun:
    nodes = round(per_half_width * mesh_length(contact, contact.film_moes(oil)))
    settings = replace(Settings(nodes, 20e-9, 0.1, math.inf, False, 8e9), **changes)  # type: ignore[arg-type]
    run = TransientRun(build_problem(contact, oil, RoughSurfaces(), (STEEL, STEEL), settings))
    run.advance(round(4.5 * run.problem.units.steps_per_half_width))
    return run


@pytest.mark.parametrize("name", list(OILS))
def test_transient_settles_at_the_steady_solution(name: str) -> None:
    steady = solve_steady(CONTACT, OILS[name])
    assert steady.status == "converged"
    run = settled(CONTACT, OILS[name], 140.0)
    records, _ = run.advance(20)
    assert records[:, STAGE].max() == 0.0
    assert records[-1, MU_FLUID] == pytest.approx(steady.friction_fluid, rel=5e-4)
    middle = float(np.interp(0.0, run.problem.x, run.state.film)) * run.problem.units.film
    assert middle == pytest.approx(steady.film_central, rel=1e-3)


def test_slow_sliding_is_newtonian_whatever_the_law() -> None:
    slow = replace(CONTACT, slide_to_roll=1e-9, speed_sliding_lengthwise=0.0)
    films = [solve_steady(slow, oil).film_central for oil in OILS.values()]
    np.testing.assert_allclose(films, films[0], rtol=4e-6)


def test_a_limit_that_acts_on_the_flow_lowers_friction_and_film() -> None:
    free, limited = (solve_steady(CONTACT, OILS[name]) for name in ("eyring", "smooth eyring"))
    cut = solve_steady(CONTACT, replace(OILS["eyring"], limiting_shear_coefficient=0.06))
    assert limited.friction_fluid < cut.friction_fluid <= free.friction_fluid
    assert cut.film_central == pytest.approx(free.film_central, rel=1e-9)
    assert 0.95 * free.film_central < limited.film_central < free.film_central


MODULUS = {"viscosity_law": "modulus", "modulus_constants": (3.4e7, 5.0e5, 3.4e-2, 3.0e-5)}
ROWS = OILS | {
    "barus": replace(OILS["eyring"], viscosity_law="barus"),
    "modulus": replace(OILS["cut"], **MODULUS, temperature_constants=(800.0, 95.0)),
}


@pytest.mark.parametrize("name", list(ROWS))
@pytest.mark.parametrize("heated", [False, True])
@pytest.mark.parametrize("lengthwise", [0.0, 3.0])
def test_rows_of_the_transient_solver_hold_the_law(name: str, heated: bool, lengthwise: float) -> None:
    oil, contact = ROWS[name], replace(CONTACT, speed_sliding_lengthwise=lengthwise)
    units = Units(contact.half_width, 1e9, 1e-6, 2e-6, 4e-7)
    fluid = scaled_fluid(contact, oil, units, math.inf, heated)
    n, boundary = 60, 0.1
    rng = np.random.default_rng(4)
    film, pressure = 0.05 + rng.random(n), 1.6 * rng.random(n)
    pressure[:4] = 0.0
    wet, held = pressure > 0.0, np.maximum(film, boundary)
    neutral = temperature_place(oil.temperature, fluid.table)
    log_eta = oil.log_viscosity_ratio(pressure * 1e9)

    def rows(h: np.ndarray, p: np.ndarray) -> FluidityRows:
        row = FluidityRows.of(n)
        row.film[:], row.pressure[:], row.thermal[:] = h, p, neutral
        fluidity_rows(row, boundary, fluid, fluid.along, 1.0)
        return row

    shear = oil.shear_law.numbers(1e9, oil.shear_law.reference(1e9), 1e-6 / contact.half_width)
    log_f = [
        -ln if name == "newtonian" else log_mobility(ln, fluid.sliding, h, p, fluid.along, shear)[0]
        for ln, h, p in zip(log_eta, held, pressure, strict=True)
    ]
    here, step = rows(film, pressure), 1e-6
    density = oil.density_ratio(pressure * 1e9)
    np.testing.assert_allclose(here.f, density * held**3 * np.exp(log_f), rtol=1e-6 if heated else 1e-7)
    by_film = (rows(film + step, pressure).f - rows(film - step, pressure).f) / (2.0 * step)
    np.testing.assert_allclose(here.by_film, np.where(film < boundary, 0.0, by_film), rtol=1e-6)
    f_right, f_left = rows(film, pressure + step).f, rows(film, pressure - step).f
    log_density = np.log(oil.density_ratio((pressure + step) * 1e9) / oil.density_ratio((pressure - step) * 1e9))
    # density is left out of the pressure derivative: it changes f by less than 1e-3 of what viscosity does
    by_pressure = (f_right - f_left - here.f * log_density) / (2.0 * step)
    small = 1e-7 * np.abs(by_pressure).max()
    np.testing.assert_allclose(here.by_pressure[wet], by_pressure[wet], rtol=2e-5, atol=small)

    tau = np.zeros(n)
    isothermal_shear_row(film, pressure, boundary, fluid, tau)
    expected = np.where(wet, oil.shear_stress(pressure * 1e9, held * 1e-6, contact.speed_sliding), 0.0)
    np.testing.assert_allclose(tau * 1e9, expected, rtol=1e-7)
    if not heated:
        return

    heat = HeatRows(*(np.zeros(n) for _ in HeatRows._fields))
    heat.base[:], heat.resistance[:] = oil.temperature + 3.0, np.where(wet, 10.0 ** rng.uniform(2.0, 3.5, n), 0.0)
    temperature = np.zeros(n)
    balanced_shear_row(heat, film, pressure, boundary, fluid, temperature, tau)
    np.testing.assert_allclose(temperature, heat.base + heat.resistance * tau, atol=0.02)
    viscous = oil.log_viscosity(pressure * 1e9, temperature) + np.log(contact.speed_sliding / (held * 1e-6))
    hot = np.where(wet, np.exp(oil.shear_law.log_stress(viscous, pressure * 1e9)[0]), 0.0)
    np.testing.assert_allclose(tau * 1e9, hot, rtol=1e-3)
