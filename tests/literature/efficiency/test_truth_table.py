"""The measured side of the truth table: the correlation by its printed figures, the statistics by hand."""

import importlib
import math
import sys
from pathlib import Path
from typing import Any

import pytest

import efficiency

# C40, 215 N m, 1200 rpm of the wheel (6.9 m/s), 80 degC, Ra 0.4 um
PRINTED = {"minr": 0.0348, "paor": 0.0270, "estr": 0.0264, "pagd": 0.0232, "p150": 0.0279}


@pytest.fixture(scope="module")
def table() -> Any:
    folder = str(Path(__file__).resolve().parents[3] / "validation")
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
