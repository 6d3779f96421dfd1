"""Root stress against other finite elements of the same teeth (`tests/twins/root_stress_fem.py`)."""

from __future__ import annotations

import pytest
from twins.compliance_fem import Counts
from twins.root_stress_fem import root_peaks

import efficiency


def test_root_stress_under_the_contact_forces() -> None:
    """Coarse elements; finer ones of ten members are in docs/strength.md."""
    loaded = efficiency.load("fh_spiral_bevel_12x37").mesh(positions=8, points_per_line=15).load()
    found = root_peaks(loaded, "pinion", Counts(tooth=3, slot=2, rows=16, body=3, along=8), 1.0e-3)
    assert found.model == pytest.approx(found.elements, rel=0.05)
