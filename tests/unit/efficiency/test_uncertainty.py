"""Interval of the efficiency: exact where friction is a product of what is uncertain."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from samples import AXLE_OIL as OIL
from samples import tiny_load as loaded

from efficiency.loss.efficiency import mesh_efficiency
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.ehl_friction import EhlFriction
from efficiency.loss.kinematics import Operation
from efficiency.loss.uncertainty import (
    Spread,
    UncertainInputs,
    boundary_friction_of,
    efficiency_uncertainty,
    with_boundary_friction,
)
from ehl.fluid.oil import Oil
from ehl.io.errors import InputError
from ehl.state import ContactState
from regression.formula import friction_model
from regression.friction.models import FrictionEstimate, FrictionModel

OPERATION = Operation(125.0, 363.15, 0.4e-6, 0.3e-6)


@dataclass(frozen=True)
class Product:
    """mu = mu_b (1 + Rq1/1 um); an interval of two standard deviations of 4 % each."""

    boundary_friction: float = 0.1
    name: str = "product"

    def evaluate(self, state: ContactState, oil: Oil) -> FrictionEstimate:
        mu = self.boundary_friction * (1.0 + state.roughness_rms_1 / 1e-6)
        return FrictionEstimate(mu, 0.92 * mu, 1.08 * mu, np.zeros(mu.shape, np.int8))


def solve(model: FrictionModel, operation: Operation) -> EfficiencyResult:
    return mesh_efficiency(loaded(), model, OIL, operation)


def test_products_carry_their_relative_spreads() -> None:
    inputs = UncertainInputs(Spread(0.01), Spread(0.1e-6), Spread(0.1, relative=True))
    found = efficiency_uncertainty(solve(Product(), OPERATION), solve, inputs)
    loss = 1.0 - found.efficiency
    sigma = {source.name: source.sigma_efficiency / loss for source in found.sources}
    # the level of two standard deviations is 0.954
    assert sigma["friction formula"] == pytest.approx(0.04, rel=1e-6)
    assert sigma["boundary friction"] == pytest.approx(0.1, rel=1e-9)
    assert sigma["roughness of the pinion"] == pytest.approx(0.1 / 1.4, rel=1e-9)
    assert sigma["roughness of the gear"] == 0.0
    total = math.sqrt(sum(value**2 for value in sigma.values()))
    assert found.sigma_efficiency == pytest.approx(total * loss, rel=1e-12)
    assert sum(source.variance_share for source in found.sources) == pytest.approx(1.0)
    assert found.efficiency - found.efficiency_lower == pytest.approx(1.6449 * total * loss, rel=1e-4)
    assert found.to_dict()["sources"][0]["sigma_input"] is None


def test_independent_points_average_out() -> None:
    """The sum of n equal independent errors is sqrt(n) times one of them."""
    nothing = UncertainInputs(Spread(0.0), Spread(0.0), Spread(0.0))
    found = efficiency_uncertainty(solve(Product(), OPERATION), solve, nothing)
    result = solve(Product(), OPERATION)
    each = 0.04 * result.friction.mu * result.points.force * result.points.speed_sliding
    expected = np.sqrt(np.sum(each**2)) / result.positions / result.power_input
    rest = found.sigma_efficiency**2 - found.sources[0].sigma_efficiency ** 2
    assert found.sigma_efficiency_independent == pytest.approx(math.sqrt(expected**2 + rest), rel=1e-6)
    assert found.sigma_efficiency_independent < 0.5 * found.sigma_efficiency


def test_models_without_interval_or_boundary_friction_say_so() -> None:
    found = efficiency_uncertainty(solve(friction_model("benedict_kelley_1961"), OPERATION), solve)
    notes = {source.name: source.note for source in found.sources}
    assert "states no interval" in notes["friction formula"]
    assert "no input" in notes["boundary friction"]
    assert math.isfinite(found.efficiency_lower)


def test_boundary_friction_of_models() -> None:
    formula = friction_model("75w90_load_share")
    assert boundary_friction_of(formula) == 0.1
    changed = with_boundary_friction(formula, 0.12)
    assert changed is not None
    assert boundary_friction_of(changed) == 0.12
    solver = with_boundary_friction(EhlFriction("ehl"), 0.08)
    assert isinstance(solver, EhlFriction)
    assert solver.boundary_friction == 0.08
    assert with_boundary_friction(friction_model("constant:0.05"), 0.1) is None


def test_spreads() -> None:
    assert Spread.of_range(0.0, 12.0).sigma == pytest.approx(math.sqrt(12.0))
    assert Spread(0.1, relative=True).around(-3.0) == pytest.approx(0.3)
    for wrong in (lambda: Spread(-1.0), lambda: Spread(math.nan), lambda: Spread.of_range(2.0, 1.0)):
        with pytest.raises(InputError):
            wrong()
    with pytest.raises(InputError, match="level"):
        efficiency_uncertainty(solve(Product(), OPERATION), solve, level=1.0)
