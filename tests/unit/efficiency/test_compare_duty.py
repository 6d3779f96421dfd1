"""Comparison of friction models over a duty cycle."""

import numpy as np
import pytest

import efficiency
from efficiency.conditions.duty import DutyRow


def test_ratios_over_a_duty_cycle() -> None:
    """With constants the ratio of the losses is nearly that of the constants, in every row and in total."""
    pair = efficiency.load("fm_spiral_bevel_14x39_relieved")
    rows = [DutyRow(torque, 100.0, 360.0, 1.0) for torque in (60.0, 200.0)]
    found = pair.compare(["constant:0.04", "constant:0.06"], 200.0, grid=(4, 9), duty=rows).rows
    low, high = found[0], found[1]
    assert (low.energy_factor, low.loss_factor) == (1.0, 1.0)
    ratios = np.array([high.loss_factor, high.energy_factor, high.energy_factor_min, high.energy_factor_max])
    np.testing.assert_allclose(ratios, 1.5, rtol=0.03)
    assert high.energy_factor_min <= high.energy_factor <= high.energy_factor_max
    cycle = pair.duty(rows, "constant:0.06", grid=(4, 9))
    assert high.energy_loss == pytest.approx(cycle.total("energy_loss"))
    assert np.isnan(next(row for row in found if row.kind == "closed form").energy_loss)
