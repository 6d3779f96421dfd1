"""Measured gear states: their range, the share of a gear inside it, the correlation by its printed figures."""

import importlib
import math
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import efficiency
from efficiency.loss.efficiency import measured_states
from regression.friction.conditions import conditions_of

ROOT = Path(__file__).resolve().parents[3]
LIMITED = ("pressure_hertz", "speed_entrainment", "slide_to_roll_total", "film_ratio_formula")
OILS = ("minr", "paor", "estr", "pagd", "p150")


def test_range_holds_the_points_of_the_measured_states() -> None:
    known = measured_states()
    found: dict[str, list[float]] = {name: [] for name in LIMITED}
    for name in ("fzg_c14", "fzg_c40"):
        mesh = efficiency.load(name).mesh(positions=12, points_per_line=5)
        for torque in (94.1, 302.0):
            loaded = mesh.load(torque)
            for oil in OILS:
                for wheel in (200.0, 2000.0):
                    speed = 1.5 * wheel * math.pi / 30.0
                    result = loaded.efficiency("constant:0.05", oil=oil, speed=speed, temperature=353.15)
                    assert result.friction_range.measured_share == 1.0
                    local = conditions_of(result.points.state, result.case.card)
                    for variable, values in found.items():
                        values += [float(np.min(local[variable])), float(np.max(local[variable]))]
    for variable, values in found.items():
        low, high = known[variable]
        assert low <= min(values)
        assert high >= max(values)
        if low:
            assert low > 0.8 * min(values)
        assert high < 1.15 * max(values)


def test_gear_at_high_speed_is_outside() -> None:
    loaded = efficiency.load("fm_spiral_bevel_14x39_relieved").mesh().load("200 N m")
    inside, outside = (loaded.efficiency("constant:0.05", speed=speed) for speed in ("1200 rpm", "16000 rpm"))
    assert inside.friction_range.measured_share > 0.9
    assert outside.friction_range.measured_share == 0.0
    assert loaded.efficiency("constant:0", speed="1200 rpm").friction_range.measured_share > 0.9


def test_deviation_is_that_of_the_page() -> None:
    page = (ROOT / "docs" / "validation_truth.md").read_text(encoding="utf-8")
    row = re.search(r"\| mean mesh friction \| (\d+) \| \+(\d+) % \| (\d+) %", page)
    known = measured_states()
    figures = known["states"], round(100 * known["bias"]), round(100 * known["deviation"])
    assert figures == tuple(map(int, row.groups()))


# C40, 215 N m, 1200 rpm of the wheel (6.9 m/s), 80 degC, Ra 0.4 um
PRINTED = {"minr": 0.0348, "paor": 0.0270, "estr": 0.0264, "pagd": 0.0232, "p150": 0.0279}


@pytest.fixture(scope="module")
def table() -> Any:
    folder = str(ROOT / "validation")
    sys.path.insert(0, folder)
    try:
        yield importlib.import_module("truth_table")
    finally:
        sys.path.remove(folder)


@pytest.mark.parametrize("oil", PRINTED)
def test_correlation_of_measured_gear_friction(table: Any, oil: str) -> None:
    found = table.schlenk_feup(efficiency.load("fzg_c40"), oil, 215.0, 1.5 * 1200.0 * math.pi / 30.0, 80.0)
    assert found == pytest.approx(PRINTED[oil], abs=5.1e-5)


def state(table: Any, measured: float, low: float = 0.8, high: float = 1.25, sd: float = 0.0, **more: float) -> Any:
    figures = {"torque": 100.0, "speed": 10.0, "pressure": 1e9, "film_ratio": 1.0, "computed": 1.0} | more
    return table.State("q", "case", "oil", measured=measured, measured_sd=sd, low=low, high=high, **figures)


def test_statistics_by_hand(table: Any) -> None:
    """ln(computed/measured) of 0.1, 0.3: bias exp(0.2) - 1, standard deviation 0.1 sqrt(2)."""
    found = table.statistics([state(table, math.exp(-0.1)), state(table, math.exp(-0.3))])
    assert found["bias"] == pytest.approx(math.exp(0.2) - 1.0)
    assert found["deviation"] == pytest.approx(0.1 * math.sqrt(2.0))
    assert found["inside"] == 0.5
    # the uncertainty of the measurement widens the interval
    assert not state(table, 0.75).inside
    assert state(table, 0.75, sd=0.15).inside
    assert not state(table, 1.3).inside
    # the exponents are those of a power law
    at = [(t, v) for t in (90.0, 300.0) for v in (10.0, 40.0)]
    found = table.exponents([state(table, 1.0, torque=t, speed=v, computed=t**0.2 * v**-0.3) for t, v in at])
    assert found["torque"] == pytest.approx((0.2, 0.2, 0.2))
    assert found["speed"] == pytest.approx((-0.3, -0.3, -0.3))
