"""Elastic teeth and root stress against other finite elements (`tests/twins`), and the deflection near a free edge."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from twins.compliance_fem import Counts, influence, nine_points
from twins.free_edge import approach
from twins.root_stress_fem import root_peaks

import efficiency
from efficiency.contact.gear_flanks import Member
from efficiency.contact.tooth_grid import root_profile
from efficiency.design.design import load_design
from efficiency.ltca.edge_contact import free_edge_compliance
from efficiency.ltca.load_distribution import weber_local
from efficiency.ltca.ritz_solid import ORDERS, Orders
from efficiency.ltca.solid_tooth import solid_tooth_of
from efficiency.strength import root_mesh

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
    """Deflection along the middle and from root to tip under even load, over all orders times a factor."""
    design, found = load_design(name), []
    for factor in (0.6, 1.0, 1.4):
        orders = Orders(*(tuple(max(2, round(factor * n)) for n in each) for each in (ORDERS.tooth, ORDERS.body)))
        tooth = solid_tooth_of(design.flanks(), getattr(design, member).tooth_body(), member, "drive", orders)
        face = np.linspace(0.05, 0.95, 121) * tooth.face_width
        heights = (np.linspace(*ends, face.size) * tooth.whole_depth(face) for ends in ((0.5, 0.5), (0.25, 0.95)))
        found.append(np.concatenate([influence(tooth, face, height).mean(axis=1) for height in heights]))
    coarse, default, fine = found
    assert np.abs(default / fine - 1.0).max() < 0.04
    assert np.abs(default / fine - 1.0).max() < 0.5 * np.abs(coarse / fine - 1.0).max()
    assert default.mean() == pytest.approx(fine.mean(), rel=0.015)
    assert coarse.mean() < default.mean()


@pytest.mark.parametrize("distance", [0.05, 0.15, 0.4])
def test_load_next_to_the_end_of_a_strip(distance: float) -> None:
    """What the end adds, from a strip far from its end, in the unit of the whole approach."""
    half_width = 0.2 * distance
    plain, far = (float(weber_local(1.0, b, 1.0, 1.0, 0.3)) for b in (half_width, 0.2))
    end = approach(distance, 1.0, half_width, 0.3)
    added = end - plain - (approach(4.0, 1.0, 0.2, 0.3) - far)
    assert float(free_edge_compliance(distance, 1.0, 1.0, 0.3)) == pytest.approx(added, abs=0.035 * end)


def test_root_stress_under_the_contact_forces() -> None:
    """Coarse elements; finer ones of ten members are in docs/strength.md."""
    loaded = efficiency.load("fh_spiral_bevel_12x37").mesh(positions=8, points_per_line=15).load()
    found = root_peaks(loaded, "pinion", root_mesh.Counts(3, 5, 2, 1, 2, 8))
    assert found.model == pytest.approx(found.elements, rel=0.05)


@pytest.mark.parametrize("member", ["pinion", "gear"])
def test_outlines_of_the_root_mesh_are_the_flank_and_the_cut_fillet(member: Member) -> None:
    """At the middle of the face: above its start the flank itself, below it the fillet turned into its place."""
    mesh = efficiency.load("fh_spiral_bevel_12x37").mesh(positions=4, points_per_line=9)
    flanks, module, solid = mesh.bevel.flanks(), mesh.pitch.module_normal, getattr(mesh.grids.teeth, member)
    found = root_mesh.root_mesh(flanks, member, solid.grid, solid.body.rim_thickness, module, root_mesh.Counts())
    grid, middle = solid.grid, solid.grid.u.shape[1] // 2
    assert found.stations[found.counts.along] == pytest.approx(found.columns[middle], rel=1e-12)
    for k, (side, azimuth) in enumerate(zip(grid.sides, (grid.lower, grid.upper), strict=True)):
        flank = flanks.of(member)[side]
        flank = replace(flank, blade=replace(flank.blade, edge_radius=root_mesh.EDGE_RADIUS * module))
        cut = root_profile(flank, grid.u.shape[1], np.inf)
        line, height = (x[:, found.counts.along] for x in (found.outlines[k].azimuth, found.outlines[k].height))
        on_flank = line - CubicSpline(grid.height[:, middle], azimuth[:, middle])(height)
        assert np.abs(on_flank[height > cut.start[middle]]).max() < 1e-4
        kept = height < cut.start[middle]
        kept[:2] = False  # the root between the fillets
        off = line - np.interp(height, cut.height[::-1, middle], cut.azimuth[::-1, middle])
        assert kept.sum() >= 5
        assert np.ptp(off[kept]) < 1e-9
