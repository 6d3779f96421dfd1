"""Elastic teeth and root stress against other finite elements (`tests/twins`), and the deflection near a free edge."""

import numpy as np
import pytest
from twins.compliance_fem import Counts, line_load, nine_points, scaled_orders
from twins.free_edge import approach
from twins.root_stress_fem import Cells, root_peaks

import efficiency
from efficiency.contact.gear_flanks import Member
from efficiency.design.design import load_design
from efficiency.ltca.edge_contact import free_edge_compliance
from efficiency.ltca.load_distribution import weber_local
from efficiency.ltca.solid_tooth import solid_tooth_of

COARSE = Counts(tooth=2, slot=2, rows=6, body=3, along=8)


TEETH = [("fh_hypoid_9x34", "pinion", 1), ("fm_spiral_bevel_14x39", "gear", 3)]


@pytest.mark.parametrize(("name", "member", "cells"), TEETH)
def test_deflection_at_nine_flank_points(name: str, member: Member, cells: int) -> None:
    """Worst point 6.8 and 7.6 %, rms 2.1 and 2.4 % of the largest deflection away from the load; limit 10 %."""
    design = load_design(name)
    points = nine_points(design, member, COARSE, cells)
    tooth = solid_tooth_of(design.flanks(), getattr(design, member).tooth_body(), member, "drive", cells=cells)
    errors = points.errors(tooth)
    assert np.abs(errors).max() < 0.10
    assert np.sqrt(np.mean(errors**2)) < 0.03
    # the elements obey reciprocity, so the comparison is one of deflections and not of their directions
    assert np.abs(points.own - points.own.T).max() < 0.02 * points.own.max()
    if cells > 1:
        face, height = np.tile(points.face, 2), np.tile(points.height, 2)
        ahead = tooth.influences([(face, height, np.repeat([0, 1], 9))])[0][9:, :9]
        # read on the tooth that the loaded flank looks to: the next one if that flank is the upper one
        looks_back = design.flanks().loaded_side(member, "drive") == "convex"
        expected = points.ahead.T if looks_back else points.ahead
        assert np.abs(ahead - expected).max() < 0.06 * expected.max()


@pytest.mark.parametrize(("name", "member"), [tooth[:2] for tooth in TEETH])
def test_orders_have_converged(name: str, member: Member) -> None:
    """Deflection along two lines of contact under their even load: the worst place and the mean."""
    design = load_design(name)
    flanks, body = design.flanks(), getattr(design, member).tooth_body()
    coarse, default, fine = (
        line_load(solid_tooth_of(flanks, body, member, "drive", scaled_orders(factor))) for factor in (0.6, 1.0, 1.4)
    )
    assert np.abs(default / fine - 1.0).max() < 0.04
    assert np.abs(default / fine - 1.0).max() < 0.5 * np.abs(coarse / fine - 1.0).max()
    assert default.mean() == pytest.approx(fine.mean(), rel=0.015)
    assert coarse.mean() < default.mean()


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


def test_root_stress_under_the_contact_forces() -> None:
    """Coarse elements; finer ones of ten members are in docs/strength.md."""
    loaded = efficiency.load("fh_spiral_bevel_12x37").mesh(positions=8, points_per_line=15).load()
    found = root_peaks(loaded, "pinion", Cells(3, 7, 4, 3, 8), 0.25 * loaded.mesh.pitch.module_normal)
    assert found.model == pytest.approx(found.elements, rel=0.05)
