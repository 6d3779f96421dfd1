"""Bulk temperatures of the teeth: exact for a linear loss, in balance for a real pair, refused where too hot."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from refusals import fails, refuses
from samples import AXLE_OIL as OIL
from samples import BEVEL as DESIGN
from samples import OPERATION, STEEL
from samples import tiny_load as loaded

from efficiency.design.design import Design
from efficiency.loss.efficiency import mesh_efficiency
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.heat_balance import (
    CoolingInput,
    MemberCooling,
    balance_heat,
    thermal_resistance,
    wetted_heat_transfer,
)
from efficiency.loss.kinematics import Operation
from efficiency.pair import GearPair
from ehl.common.validation import validate
from ehl.state import ContactState
from regression.formula import friction_model

BODIES = (STEEL, STEEL)


def linear_loss(slope: float, asked: list[Operation]) -> Any:
    """A loss of 1000 W that changes by a share for each kelvin of the inlet; half of the heat goes each way."""

    def solve(operation: Operation) -> Any:
        asked.append(operation)
        power = 1000.0 * (1.0 + slope * (operation.inlet - operation.temperature))
        state = ContactState.of(
            pressure_hertz=[1e9], radius_equivalent=0.01, effective_modulus=226e9, speed_entrainment=2.0
        )
        points = SimpleNamespace(state=state, force=np.ones(1), speed_sliding=np.array([power]))
        return SimpleNamespace(points=points, friction=SimpleNamespace(mu=np.ones(1)), positions=1, status="converged")

    return solve


@pytest.mark.parametrize("slope", [-0.02, 0.0, 0.01])
def test_linear_loss_is_exact(slope: float) -> None:
    """Rise of both: R Q/2 = R 500 (1 + slope (r1 + r2)/2), so the mean rise m = 500 R/(1 - 500 R slope), R the mean."""
    asked: list[Operation] = []
    found = balance_heat(linear_loss(slope, asked), OPERATION, (0.05, 0.03), BODIES)
    mean = 500.0 * 0.04 / (1.0 - 500.0 * 0.04 * slope)
    last = asked[-1]
    assert last.inlet - 363.15 == pytest.approx(mean, abs=0.02)
    rises = np.array(last.bulk) - 363.15
    assert rises[0] / rises[1] == pytest.approx(5.0 / 3.0, rel=1e-3)
    assert found.rounds == len(asked) <= 6
    assert found.residual < 0.01


def test_oil_may_enter_as_it_is() -> None:
    asked: list[Operation] = []
    balance_heat(linear_loss(-0.02, asked), OPERATION, (0.05, 0.03), BODIES, warm_inlet=False)
    assert all(operation.inlet == 363.15 for operation in asked)
    assert asked[-1].bulk[0] - 363.15 == pytest.approx(25.0, abs=0.02)


def test_runaway_is_said() -> None:
    """A loss that grows faster than the cooling."""
    with fails("bulk_too_hot"):
        balance_heat(linear_loss(0.1, []), OPERATION, (0.05, 0.05), BODIES)


def test_real_pair_is_in_balance() -> None:
    model = friction_model("75w90_load_share")

    def solve(operation: Operation) -> EfficiencyResult:
        return mesh_efficiency(loaded(), model, OIL, operation)

    cold = solve(OPERATION)
    found = balance_heat(solve, OPERATION, (0.1, 0.06), BODIES)
    result = found.result
    assert sum(found.heat) == pytest.approx(result.power_loss, rel=1e-12)
    for bulk, resistance, heat in zip(
        (result.temperature_bulk_1, result.temperature_bulk_2), found.thermal_resistance, found.heat, strict=True
    ):
        assert bulk - 363.15 == pytest.approx(resistance * heat, abs=0.01)
    assert result.temperature_inlet == pytest.approx(0.5 * (result.temperature_bulk_1 + result.temperature_bulk_2))
    # thinner films
    assert result.power_loss > cold.power_loss
    assert result.lubrication.film_ratio.min() < cold.lubrication.film_ratio.min()
    # flash on top of the bulk
    hotter = min(result.temperature_bulk_1, result.temperature_bulk_2)
    assert result.lubrication.temperature_flash.min() >= hotter


def test_what_is_given_comes_before_the_defaults() -> None:
    pinion = MemberCooling(thermal_resistance=0.2)
    gear = MemberCooling(heat_transfer_coefficient=500.0, cooled_area=0.01)
    angles = (math.radians(35.0), math.radians(35.0))
    oil = OIL.at(OPERATION.temperature)
    blanks = DESIGN.pinion.blank, DESIGN.gear.blank
    speeds = OPERATION.speed, OPERATION.speed * 14 / 39

    def resistances(*given: MemberCooling) -> tuple[float, ...]:
        parts = zip(blanks, given, speeds, angles, strict=True)
        return tuple(thermal_resistance(b, cooling, oil, speed, angle) for b, cooling, speed, angle in parts)

    assert resistances(pinion, gear) == pytest.approx((0.2, 0.2))
    default = resistances(MemberCooling(), MemberCooling())
    blank = DESIGN.pinion.blank
    area = 2.0 * 14 * blank.face_width / math.cos(angles[0]) * (blank.mean_addendum + blank.mean_dedendum)
    assert default[0] == pytest.approx(1.0 / (area * wetted_heat_transfer(OIL.at(363.15), 125.0)))


def test_default_heat_transfer_is_that_of_penetrating_heat() -> None:
    """Mean over a turn of the flux sqrt(k rho c/(pi t)) by quadrature, half of it."""
    oil = OIL.at(363.15)
    turn = 2.0 * math.pi / 150.0
    # t = s^2 removes the root from the integral
    s = (np.arange(1000) + 0.5) / 1000.0 * math.sqrt(turn)
    flux = math.sqrt(oil.thermal_conductivity * oil.density * oil.heat_capacity / math.pi) / s
    mean = float(np.mean(flux * 2.0 * s)) * math.sqrt(turn) / turn
    assert wetted_heat_transfer(oil, 150.0) == pytest.approx(0.5 * mean, rel=1e-9)


def test_cooling_is_read_and_refused() -> None:
    cooling = validate(CoolingInput, {"pinion": {"thermal_resistance": "0.1 K/W"}, "oil_inlet": "oil"})
    assert cooling.pinion.thermal_resistance == 0.1
    with refuses("gear.cooled_area"):
        validate(CoolingInput, {"gear": {"thermal_resistance": "0.1 K/W", "cooled_area": "0.1 m^2"}})
    with refuses("driver"):
        replace(OPERATION, driver="both")  # type: ignore[arg-type]
    with refuses("temperature_bulk_gear"):
        replace(OPERATION, temperature_bulk_gear=800.0)


def test_run_of_a_design() -> None:
    found = GearPair(DESIGN).mesh("drive", 4, 9).load(100.0).heat_balance("constant:0.05")
    assert found.result.status == "converged"
    assert found.result.temperature_bulk_1 > found.result.temperature


def with_cooling(resistance: float) -> Design:
    member = MemberCooling(thermal_resistance=resistance)
    return DESIGN.model_copy(update={"cooling": CoolingInput(pinion=member, gear=member)})


def test_a_stated_cooling_is_the_default() -> None:
    """In a point and in a grid; without it the result says that the teeth are as warm as the oil."""
    plain = GearPair(DESIGN).mesh("drive", 4, 9).load(100.0)
    cold = plain.efficiency("constant:0.05")
    assert any("as warm as the oil" in text for text in cold.skipped)
    mesh = GearPair(with_cooling(0.1)).mesh("drive", 4, 9)
    loaded = mesh.load(100.0)
    warm = loaded.efficiency("constant:0.05")
    assert not any("as warm as the oil" in text for text in warm.skipped)
    assert warm.temperature_bulk_1 > cold.temperature_bulk_1 + 1.0
    assert warm.temperature_bulk_1 == loaded.heat_balance("constant:0.05").result.temperature_bulk_1
    assert loaded.efficiency("constant:0.05", bulk="oil").temperature_bulk_1 == cold.temperature_bulk_1
    grid = mesh.over("constant:0.05", torque=[100.0], speed=[cold.operation.speed])
    assert grid.points[0].result.temperature_bulk_1 == pytest.approx(warm.temperature_bulk_1, abs=0.05)
    with refuses("bulk"):
        loaded.efficiency("constant:0.05", bulk="hot")
