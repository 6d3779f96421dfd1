"""Limits of the smooth contact with known answers: rigid cylinders, the Hertz contact, the kernel."""

import math
from dataclasses import replace

import numpy as np
import pytest
from contacts import gear_range
from scipy.integrate import cumulative_simpson, simpson
from scipy.optimize import brentq

from ehl.fluid.density import INCOMPRESSIBLE
from ehl.fluid.lubricant import Lubricant
from ehl.line_contact import LineContact
from ehl.smooth.continuation import PathReport, cold_path, features_of_level, transfer
from ehl.smooth.mesh import grade
from ehl.smooth.newton import NodeGrid, numbers_of, solve_level
from ehl.smooth.refine import extrapolate, settled
from ehl.smooth.scaling import scaled_contact
from ehl.smooth.solver import film_shear, solve_steady

MODULUS = 2.264e11


def from_moes(load, material, pressure=1e9, radius=0.01):
    """Contact and Barus oil of given Moes numbers."""
    bodies = {"radius_equivalent": radius, "effective_modulus": MODULUS}
    contact = LineContact.from_pressure(**bodies, pressure_hertz=pressure, speed_entrainment=1.0)
    weight = contact.load_per_length / (MODULUS * radius)
    twice_speed = (weight / load) ** 2
    alpha = material / twice_speed**0.25 / MODULUS
    viscosity = 0.5 * twice_speed * MODULUS * radius
    return contact, Lubricant(viscosity, alpha, "barus", compression=INCOMPRESSIBLE)


def rigid_pressure(exit_angle):
    """Isoviscous pressure of rigid cylinders over gamma, x = sqrt(2 R h0) tan(gamma), in 12 eta u sqrt(2 R h0)/h0^2."""
    gamma = np.linspace(-0.5 * math.pi, exit_angle, 20001)
    slope = np.cos(gamma) ** 2 - np.cos(gamma) ** 4 / math.cos(exit_angle) ** 2
    return gamma, cumulative_simpson(slope, x=gamma, initial=0.0)


EXIT_ANGLE = brentq(lambda angle: rigid_pressure(angle)[1][-1], 0.3, 0.6)


@pytest.mark.parametrize(("load", "tolerance"), [(0.05, 6e-3), (0.01, 1.2e-3)])
def test_thick_isoviscous_film_is_the_rigid_martin_solution(load, tolerance):
    contact, oil = from_moes(load, 0.0, pressure=1e8)
    result = solve_steady(contact, oil, accuracy="reference")
    assert result.status == "converged"
    group = result.film_min * contact.load_per_length / (oil.viscosity_inlet * contact.radius_equivalent)
    assert group == pytest.approx(4.895, rel=tolerance)
    length = math.sqrt(2.0 * contact.radius_equivalent * result.film_min)
    assert result.x_exit / length == pytest.approx(0.4751, rel=tolerance)
    assert result.flow / result.film_min == pytest.approx(1.2257, rel=tolerance)


@pytest.mark.parametrize(("load", "tolerance"), [(0.05, 8e-3), (0.01, 1.6e-3)])
def test_thick_piezoviscous_film_is_the_rigid_barus_solution(load, tolerance):
    # q = (1 - exp(-alpha p))/alpha obeys the isoviscous equation: p = -ln(1 - alpha q)/alpha.
    contact, oil = from_moes(load, 0.0, pressure=1e8)
    radius, viscosity = contact.radius_equivalent, oil.viscosity_inlet
    gamma, shape = rigid_pressure(EXIT_ANGLE)
    gamma, shape = gamma[1:-1], shape[1:-1]
    martin = 4.895 * viscosity * radius / contact.load_per_length

    def isoviscous(film):
        return 12.0 * viscosity * math.sqrt(2.0 * radius * film) / film**2 * shape

    alpha = 0.7 / isoviscous(martin).max()

    def surplus(film):
        pressure = -np.log(1.0 - alpha * isoviscous(film)) / alpha
        load = math.sqrt(2.0 * radius * film) * simpson(pressure / np.cos(gamma) ** 2, x=gamma)
        return load - contact.load_per_length

    film = brentq(surplus, martin, 3.0 * martin)
    assert film > 1.1 * martin
    result = solve_steady(contact, replace(oil, pressure_viscosity=alpha), accuracy="reference")
    assert result.film_min == pytest.approx(film, rel=tolerance)


@pytest.mark.parametrize(
    ("load", "peak", "exit_"), [(20.0, 0.9917, 1.026), (100.0, 0.9992, 1.008), (1000.0, 0.99998, 1.0015)]
)
def test_thin_film_tends_to_the_hertz_contact(load, peak, exit_):
    """Peak pressure and exit against the values of the reference program, and the Hertz ellipse inside."""
    contact, oil = from_moes(load, 1.0)
    result = solve_steady(contact, oil, accuracy="reference")
    assert result.pressure_max / contact.pressure_hertz == pytest.approx(peak, abs=1e-4)
    assert result.x_exit / contact.half_width == pytest.approx(exit_, abs=1.5e-3 if load < 50 else 5e-4)
    x = result.x / contact.half_width
    inside = np.abs(x) < 0.5
    deviation = result.pressure[inside] / contact.pressure_hertz - np.sqrt(1.0 - x[inside] ** 2)
    assert np.max(np.abs(deviation)) < 6.0 * (1.0 - peak) + 5e-5


def raw_values(contact, lubricant, counts):
    """Outputs of single grids of one grading, without extrapolation."""
    scaled, report = scaled_contact(contact, lubricant), PathReport()
    level = settled(cold_path(scaled, 97, report), report)
    grading = grade(features_of_level(level))
    values = []
    for count in counts:
        grid = NodeGrid.of(grading, grading.points(2 * count - 1))
        level = solve_level(grid, scaled, transfer(level, grid))
        values.append(numbers_of(level, film_shear(contact, lubricant))[:4])
    return np.array(values)


def test_observed_order_is_two():
    orders = []
    for contact, lubricant in gear_range(8, 5):
        values = raw_values(contact, lubricant, (129, 257, 513, 1025))
        change = np.abs(np.diff(values, axis=0))
        orders.append(np.log2(change[:-1] / change[1:]))
    last = np.median(np.array(orders)[:, -1], axis=0)
    # films, friction and the largest pressure
    assert last == pytest.approx([2.0] * 4, abs=0.1)


def test_reported_errors_hold_against_four_times_finer_grids():
    inside, ratios = [], []
    for contact, lubricant in gear_range(16, 6):
        result = solve_steady(contact, lubricant)
        assert result.status == "converged"
        counts = [(result.nodes - 1) * k + 1 for k in (1, 2, 4)]
        fine = extrapolate(list(raw_values(contact, lubricant, counts)), counts[0])
        height = contact.half_width**2 / contact.radius_equivalent
        values = np.array([result.film_central, result.film_min, result.friction_fluid])
        reported = np.array([result.film_central_error, result.film_min_error, result.friction_error])
        true = np.abs(values / (fine.values[:3] * [height, height, 1.0]) - 1.0)
        inside.append(true <= reported)
        ratios.append(reported / true)
        assert np.all(reported < 5e-3)
    assert np.mean(inside) >= 0.95
    assert np.median(ratios, axis=0).max() < 5.0
