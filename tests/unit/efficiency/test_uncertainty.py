"""Interval of the efficiency by uncertain inputs: exact where friction is a product of them, else random draws."""

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from refusals import refuses
from samples import AXLE_OIL as OIL
from samples import tiny_load as loaded

import efficiency
from efficiency.loss.efficiency import mesh_efficiency
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.kinematics import Operation
from efficiency.loss.uncertainty import LossSample, stand_in
from ehl.common.errors import InputError
from ehl.fluid.oil import Oil
from ehl.uncertainty.result import score_of
from ehl.uncertainty.spread import UncertaintyInput
from regression.formula import friction_model
from regression.friction.conditions import Conditions
from regression.friction.models import FrictionEstimate, FrictionModel
from regression.friction.uncertainty import boundary_friction_of, uncertain_inputs

OPERATION = Operation(125.0, 363.15, 0.4e-6, 0.3e-6)
Z = score_of(0.9)


@dataclass(frozen=True)
class Product(FrictionModel):
    """mu = mu_b Rq1 sqrt(lc), without an error of its own."""

    boundary_friction: float = 0.1
    error: float = 0.0
    name: str = "product"

    def evaluate(self, conditions: Conditions, oil: Oil) -> FrictionEstimate:
        mu = self.boundary_friction * conditions["roughness_rms_1"] / 1e-6
        mu = mu * np.sqrt(conditions["correlation_length"] / 30e-6)
        width = 2.0 * self.error
        return FrictionEstimate(mu, mu * np.exp(-width), mu * np.exp(width), np.zeros(mu.shape, np.int8))


def solve(model: FrictionModel, spreads: UncertaintyInput) -> EfficiencyResult:
    return mesh_efficiency(loaded(), model, OIL, replace(OPERATION, uncertainty=spreads))


def test_products_add_their_relative_spreads_as_squares() -> None:
    spreads = UncertaintyInput.none(boundary_friction=0.1, roughness_rms=0.2, correlation_length=0.4)
    found = solve(Product(error=0.04), spreads)
    widths = {
        source.name: math.log((1.0 - source.below) / (1.0 - source.above)) / 2.0 for source in found.inputs.sources
    }
    expected = {
        "boundary_friction": -Z * 0.1,
        "roughness_rms_1": -Z * 0.2,
        "correlation_length": -Z * 0.2,
        "friction formula": -Z * 0.04,
    }
    assert widths == pytest.approx(expected, rel=1e-9)
    total = math.exp(Z * math.sqrt(0.1**2 + 0.2**2 + 0.2**2 + 0.04**2))
    loss = 1.0 - found.efficiency
    assert 1.0 - found.efficiency_lower == pytest.approx(loss * total, rel=1e-9)
    assert 1.0 - found.efficiency_upper == pytest.approx(loss / total, rel=1e-9)
    assert sum(source.share for source in found.inputs.sources) == pytest.approx(1.0)
    assert json.loads(json.dumps(found.to_dict()))["uncertainty"]["low"] == found.efficiency_lower


def test_one_finish_makes_both_surfaces_wrong_the_same_way() -> None:
    """Of a sum of both Rq, two independent ones leave 1/sqrt(2) of what one cause leaves."""

    @dataclass(frozen=True)
    class Sum(FrictionModel):
        name: str = "sum"

        def evaluate(self, conditions: Conditions, oil: Oil) -> FrictionEstimate:
            mu = 0.1 * (conditions["roughness_rms_1"] + conditions["roughness_rms_2"]) / 1e-6
            return FrictionEstimate(mu, mu, mu, np.zeros(mu.shape, np.int8))

    at = replace(OPERATION, roughness_rms_gear=OPERATION.roughness_rms_pinion)
    spreads = UncertaintyInput.none(roughness_rms=0.01)
    apart = mesh_efficiency(loaded(), Sum(), OIL, replace(at, uncertainty=spreads)).inputs
    shared = spreads.model_copy(update={"same_surface": True})
    together = mesh_efficiency(loaded(), Sum(), OIL, replace(at, uncertainty=shared)).inputs
    assert len(together.sources) == 1
    assert (together.high - together.low) / (apart.high - apart.low) == pytest.approx(math.sqrt(2.0), rel=1e-4)


def test_nothing_uncertain_leaves_nothing_open() -> None:
    found = solve(Product(), UncertaintyInput.none())
    assert found.inputs.sources == ()
    assert found.efficiency_lower == found.efficiency_upper == found.efficiency
    constant = solve(friction_model("constant:0.05"), UncertaintyInput())
    assert constant.efficiency_lower == constant.efficiency_upper == constant.efficiency
    assert "not included" in constant.inputs.notes[0]


def test_published_formula_says_that_its_own_error_is_missing() -> None:
    found = solve(friction_model("benedict_kelley_1961"), UncertaintyInput())
    assert found.efficiency_lower < found.efficiency < found.efficiency_upper
    assert {source.group for source in found.inputs.sources} == {"oil", "roughness"}
    assert "benedict_kelley_1961" in found.inputs.notes[0]


def test_interval_on_the_formula_holds_what_random_inputs_give() -> None:
    """300 draws of all inputs the formula holds at once: 85 to 95 % lie in the 90 % interval, both sides in use."""
    model = friction_model("75w90")
    outside = dict.fromkeys(("peklenik_number", "boundary_film", "temperature_bulk"), 0.0)
    spreads = UncertaintyInput(**outside)
    result = solve(model, spreads)
    sample = LossSample.of(result.points, result.friction)
    formula = [source for source in result.inputs.sources if source.group == "formula"]
    assert len(formula) == 1
    loss = float(result.friction.mu @ sample.power)
    rng = np.random.default_rng(3)
    low, high = result.inputs.low, result.inputs.high
    inputs = uncertain_inputs(model, sample.state, OIL, spreads)
    inside = below = 0
    count = 300
    for _ in range(count):
        case = model, sample.state, OIL
        for entry in inputs:
            case = entry.moved(case, float(rng.normal()))
        friction, state, oil = case
        width = math.log((1.0 - formula[0].below) / (1.0 - result.efficiency)) / Z
        drawn = float(friction.mu(state, oil=oil).mu @ sample.power) / loss * math.exp(width * rng.normal())
        eta = 1.0 - (1.0 - result.efficiency) * drawn
        inside += low <= eta <= high
        below += eta < low
    assert 0.85 * count <= inside <= 0.95 * count
    assert 0.01 * count <= below <= 0.09 * count


def test_solved_contacts_ask_the_formula_of_their_oil_and_keep_their_error_apart() -> None:
    from efficiency.loss.ehl_friction import EhlFriction

    formula, note = stand_in(EhlFriction("ehl", boundary_friction=0.08), OIL)
    assert boundary_friction_of(formula) == 0.08
    assert note == "by the formula 75w90"
    assert stand_in(EhlFriction("ehl"), OIL.model_copy(update={"name": "mine"}))[1].endswith("of another oil")


def test_a_design_file_may_state_its_own_spreads(tmp_path: Path) -> None:
    from ehl.common.data import data_path

    text = data_path("designs", "fm_spiral_bevel_14x39.toml").read_text(encoding="utf-8")
    file = tmp_path / "pair.toml"
    file.write_text(text + "\n[uncertainty]\nroughness_rms = 0.01\ntemperature_bulk = '5 K'\n")
    design = efficiency.load(file).design
    assert design.running(100.0, 350.0).uncertainty.roughness_rms == 0.01
    file.write_text(text + "\n[uncertainty]\nroughness_rms = -0.1\n")
    with refuses("uncertainty.roughness_rms"):
        efficiency.load(file)
    with refuses("level"):
        solve(Product(), UncertaintyInput()).uncertainty(level=1.0)


def test_rows_of_a_duty_cycle_are_wrong_the_same_way() -> None:
    from efficiency.conditions.duty import DutyRow

    pair = efficiency.load("fm_spiral_bevel_14x39")
    one = DutyRow(torque=300.0, speed=100.0, temperature=363.15, hours=1.0)
    cycle = pair.duty([one, replace(one, hours=3.0)], "75w90", grid=(4, 9))
    alone = cycle.results[0]
    assert cycle.inputs.low == pytest.approx(alone.efficiency_lower, rel=1e-9)
    assert cycle.inputs.high == pytest.approx(alone.efficiency_upper, rel=1e-9)
    assert cycle.to_dict()["total"]["efficiency_lower"] == cycle.inputs.low


def test_one_point_of_a_formula() -> None:
    formula = friction_model("75w90")
    point = {
        "pressure_hertz": 1.2e9, "radius_equivalent": 0.015, "speed_entrainment": 5.0, "slide_to_roll": 0.2,
        "temperature": 363.15, "roughness_rms": 4e-7,
    }  # fmt: skip
    found = formula.uncertainty(**point)
    assert found.value == pytest.approx(float(formula.mu(**point).mu))
    assert found.low < float(formula.mu(**point).lower)
    assert found.high > float(formula.mu(**point).upper)
    with pytest.raises(InputError, match="one contact point"):
        formula.uncertainty(**(point | {"slide_to_roll": [0.1, 0.2]}))
