"""Bulk temperature of the teeth: the published formula, the balance with the loss, and where it is switched off."""

from collections.abc import Callable
from dataclasses import replace

import pytest
from refusals import refuses
from samples import BEVEL as DESIGN
from samples import OPERATION

import efficiency
from efficiency.loss.kinematics import Operation
from efficiency.loss.lubrication import CoolingInput, iso_15144_bulk_rise, warming
from efficiency.pair import GearPair
from ehl.common.validation import validate

SIZE = (91.5e-3, 14e-3)


def warm_operation(loss: Callable[[Operation], float]) -> Operation:
    """The operation in balance with a loss."""
    run = warming(OPERATION, SIZE, 1.0)
    trial = next(run)
    while True:
        try:
            trial = run.send(loss(trial))
        except StopIteration as end:
            found: Operation = end.value
            return found


def test_formula_by_hand() -> None:
    """FZG type C: 0.3 kW over 91.5 mm times 14 mm: 7400 (2.342e-4)^0.72/1.2 = 15.0 K, dip lubrication."""
    assert iso_15144_bulk_rise(300.0, *SIZE) == pytest.approx(7400.0 * (0.3 / (91.5 * 14.0)) ** 0.72 / 1.2, rel=1e-12)
    assert iso_15144_bulk_rise(300.0, *SIZE) == pytest.approx(15.0, rel=1e-3)
    assert iso_15144_bulk_rise(600.0, *SIZE) / iso_15144_bulk_rise(300.0, *SIZE) == pytest.approx(2.0**0.72)
    assert iso_15144_bulk_rise(300.0, *SIZE, 0.2) == pytest.approx(0.2 * iso_15144_bulk_rise(300.0, *SIZE))
    assert iso_15144_bulk_rise(0.0, *SIZE) == 0.0


@pytest.mark.parametrize("slope", [-0.02, 0.0, 0.02])
def test_temperature_and_loss_are_in_balance(slope: float) -> None:
    """A loss that changes by a share for each kelvin of the teeth."""

    def loss(at: Operation) -> float:
        return 400.0 * (1.0 + slope * (at.bulk[0] - at.temperature))

    found = warm_operation(loss)
    rise = found.bulk[0] - found.temperature
    assert rise == pytest.approx(iso_15144_bulk_rise(loss(found), *SIZE), abs=0.05)
    assert found.bulk[0] == found.bulk[1] == found.inlet


def test_a_loss_that_runs_away_ends_at_the_hottest_oil() -> None:
    found = warm_operation(lambda at: 400.0 * 1.2 ** (at.bulk[0] - at.temperature))
    assert found.bulk[0] == pytest.approx(473.15, abs=0.1)


@pytest.mark.parametrize("friction", ["constant:0.05", "75w90", "ehl:smooth"])
def test_teeth_are_warm_by_default_and_as_the_oil_on_request(friction: str) -> None:
    loaded = GearPair(DESIGN).mesh("drive", 4, 9).load(100.0)
    warm, cold = (loaded.efficiency(friction, bulk=bulk) for bulk in (None, "oil"))
    assert cold.conditions.temperature_bulk_pinion == cold.conditions.temperature
    assert any("tooth temperature" in text for text in cold.skipped)
    assert not any("tooth temperature" in text for text in warm.skipped)
    rise = warm.conditions.temperature_bulk_pinion - warm.conditions.temperature
    size = loaded.mesh.pitch.radius_pinion + loaded.mesh.pitch.radius_gear, DESIGN.common_face_width
    # of the loss without friction in the torque balance, on the coarse grid, of a formula where contacts are solved
    within = 0.3 if friction == "ehl:smooth" else 0.06
    assert rise == pytest.approx(iso_15144_bulk_rise(warm.power_loss, *size), rel=within)
    with refuses("bulk"):
        loaded.efficiency(friction, bulk="hot")  # type: ignore[arg-type]


def test_a_bulk_temperature_at_the_end_of_the_oil_laws_has_a_note() -> None:
    loaded = GearPair(DESIGN).mesh("drive", 4, 9).load(100.0)
    hot, cold = (loaded.efficiency("constant:0.05", temperature=473.0, bulk=bulk) for bulk in (None, "oil"))
    assert hot.conditions.temperature_bulk_pinion == pytest.approx(473.15, abs=0.1)
    assert len(set(hot.notes) - set(cold.notes)) == 1


def test_lubrication_of_the_design_counts() -> None:
    cooling = validate(CoolingInput, {"lubrication": "submerged"})
    rises = []
    for design in (DESIGN, DESIGN.model_copy(update={"cooling": cooling})):
        result = GearPair(design).mesh("drive", 4, 9).load(100.0).efficiency("constant:0.05")
        rises.append(result.conditions.temperature_bulk_pinion - result.conditions.temperature)
    assert rises[1] / rises[0] == pytest.approx(0.2, rel=1e-3)
    with refuses("lubrication"):
        validate(CoolingInput, {"lubrication": "dry"})


def test_maps_and_cylindrical_pairs_have_warm_teeth() -> None:
    pair = efficiency.load("fzg_c14")
    grid = pair.mesh(positions=4, points_per_line=9).over("schlenk_1994", torque=["94 N m", "302 N m"])
    rises = [
        point.result.conditions.temperature_bulk_pinion - point.result.conditions.temperature for point in grid.points
    ]
    assert 3.0 < rises[0] < rises[1] < 40.0


def test_temperatures_outside_the_range_of_oils_are_refused() -> None:
    with refuses("temperature_bulk_gear"):
        replace(OPERATION, temperature_bulk_gear=800.0)
    with refuses("driver"):
        replace(OPERATION, driver="both")  # type: ignore[arg-type]
