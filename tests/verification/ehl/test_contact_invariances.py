"""Rough contacts under changes that leave friction as it is: exchange, other units, a mirror, twice the size."""

from __future__ import annotations

import pytest
from twins.contact_invariances import cases, checked

ROWS = cases(4, 11)
CHANGES = [{"exchanged", "other units"}, {"exchanged", "other units", "mirrored", "twice the size"},
           {"exchanged", "other units", "mirrored"}, {"exchanged", "other units", "twice the size"}]  # fmt: skip


@pytest.mark.parametrize("number", range(4))
def test_the_same_contact_seen_otherwise(number: int) -> None:
    found = checked(number, ROWS[number], 1.0, 128)
    assert {row["change"] for row in found} == CHANGES[number]
    # film ratios from 0.5 on: no history that amplifies the last digit
    assert all(row["equal"] and row["inside"] for row in found)
