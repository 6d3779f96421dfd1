"""Observed order of the smooth solver, and its error estimate against much finer grids."""

import numpy as np
import pytest
from contacts import gear_range

from ehl.smooth.continuation import PathReport, cold_path, features_of_level, transfer
from ehl.smooth.mesh import grade
from ehl.smooth.newton import NodeGrid, numbers_of, solve_level
from ehl.smooth.refine import extrapolate, settled
from ehl.smooth.scaling import scaled_contact
from ehl.smooth.solver import film_shear, solve_steady

OUTPUTS = ("film_central", "film_min", "friction_fluid")
ERRORS = ("film_central_error", "film_min_error", "friction_error")


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
        values = np.array([getattr(result, name) for name in OUTPUTS])
        reported = np.array([getattr(result, name) for name in ERRORS])
        true = np.abs(values / (fine.values[:3] * [height, height, 1.0]) - 1.0)
        inside.append(true <= reported)
        ratios.append(reported / true)
        assert np.all(reported < 5e-3)
    assert np.mean(inside) >= 0.95
    assert np.median(ratios, axis=0).max() < 5.0
