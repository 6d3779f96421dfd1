"""Local approach next to a free side face against finite elements of the end of a strip."""

from __future__ import annotations

import pytest
from twins.free_edge import approach

from efficiency.ltca.edge_contact import free_edge_compliance
from efficiency.ltca.local_compliance import weber_local


def test_elements_find_the_half_plane_far_from_all_faces() -> None:
    """A load forty depths from the side face of a quarter-plane: Weber's approach."""
    plain = float(weber_local(1.0, 0.2, 1.0, 1.0, 0.3))
    assert approach("quarter-plane", 40.0, 1.0, 0.2, 0.3) == pytest.approx(plain, rel=0.005)


@pytest.mark.parametrize("distance", [0.05, 0.15, 0.4])
def test_load_next_to_the_end_of_a_strip(distance: float) -> None:
    """What the end adds, from a strip far from its end, in the unit of the whole approach."""
    half_width = 0.2 * distance
    plain, far = (float(weber_local(1.0, b, 1.0, 1.0, 0.3)) for b in (half_width, 0.2))
    end = approach("strip", distance, 1.0, half_width, 0.3)
    added = end - plain - (approach("strip", 4.0, 1.0, 0.2, 0.3) - far)
    assert float(free_edge_compliance(distance, 1.0, 1.0, 0.3)) == pytest.approx(added, abs=0.035 * end)
