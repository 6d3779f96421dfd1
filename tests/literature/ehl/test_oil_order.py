"""Friction of the base oils at equal state: order and rough ratios of bearings and discs, cards as they are."""

from __future__ import annotations

import numpy as np
import pytest

import ehl

OILS = {
    "naphthenic": ("n100",),
    "mineral": ("m100", "fva2b", "hvi"),
    "pao": ("pao_ester_additive_pma", "pao_ester_pao100", "paor"),
    "ester": ("ke_additive", "pti_additive", "estr"),
    "polyglycol": ("pg_kom1", "pg_1_1", "pagd"),
}


@pytest.fixture(scope="module")
def friction() -> dict[str, float]:
    """Geometric mean of mu of the oils of each base, at the same eta0 u_r."""

    def mu(oil: str) -> float:
        viscosity = float(ehl.Oil.load(oil).at(353.15).viscosity_inlet)
        result = ehl.Contact(
            oil=oil,
            temperature_oil="80 degC",
            pressure_hertz="1 GPa",
            radius_equivalent="15 mm",
            speed_entrainment=0.1 / viscosity,
            slide_to_roll=0.3,
        ).solve()
        assert result.status == "converged"
        return result.friction_coefficient

    return {base: float(np.exp(np.mean(np.log([mu(oil) for oil in oils])))) for base, oils in OILS.items()}


def test_order_of_the_base_oils(friction: dict[str, float]) -> None:
    assert friction["naphthenic"] > friction["mineral"] > friction["pao"] > friction["ester"]
    # the two lowest differ by less than their oils among each other
    assert friction["polyglycol"] == pytest.approx(friction["ester"], rel=0.15)


@pytest.mark.parametrize("base", ["pao", "ester", "polyglycol"])
def test_synthetic_over_mineral_oils(friction: dict[str, float], base: str) -> None:
    """0.56 to 0.57 in thrust bearings with rollers (line contacts): order and rough size, not local friction."""
    assert 0.4 < friction[base] / friction["mineral"] < 0.75
