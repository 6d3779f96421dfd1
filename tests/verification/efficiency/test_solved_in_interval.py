"""The interval of the default friction formula contains the efficiency by solved rough contacts, on three pairs."""

import pytest

import efficiency
from efficiency.loss.ehl_friction import EhlFriction


@pytest.mark.parametrize("kind", ["fm_spiral_bevel_14x39", "fm_hypoid_13x42", "fh_spiral_bevel_12x37"])
def test_interval_of_the_formula_contains_solved_contacts(kind: str) -> None:
    loaded = efficiency.load(f"{kind}_relieved").mesh(positions=6, points_per_line=11).load()
    formula = loaded.efficiency()
    solved = loaded.efficiency(EhlFriction("ehl", points=24, jobs=1))
    assert solved.solution.contacts >= 20
    assert formula.outside_range_share < 0.01
    assert formula.efficiency_lower < solved.efficiency < formula.efficiency_upper
    assert solved.efficiency_lower < formula.efficiency < solved.efficiency_upper
