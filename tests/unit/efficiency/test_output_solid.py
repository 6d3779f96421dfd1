"""Closed solids: manifold, of the right topology, and of the volume an independent integral gives."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from refusals import refuses

from efficiency.contact.gear_flanks import Member
from efficiency.contact.tooth_grid import ToothGrid, tooth_grid
from efficiency.cutting.limits import fillet, flank_limits
from efficiency.design.design import Design, bevel_names, load_design
from efficiency.output.solid import STL_RECORD, Solid, member_solid, tooth_space_solid, write_stl

MEMBERS: tuple[Member, ...] = ("pinion", "gear")


def euler_characteristic(solid: Solid) -> int:
    """Vertices minus edges plus triangles: 2 for a sphere, 0 for a body with a bore."""
    return int(np.unique(solid.triangles).size - 3 * len(solid.triangles) // 2 + len(solid.triangles))


@pytest.fixture(scope="module")
def grids(design: Design) -> dict[str, ToothGrid]:
    return {member: tooth_grid(design.flanks(), member, 11, 41) for member in MEMBERS}


def tooth_volume(grid: ToothGrid) -> float:
    """Volume of one tooth above its root cone: r dtheta du dh over the blank, Gauss points along the face."""
    blank = grid.blank
    thickness = grid.upper - grid.lower
    node, weight = leggauss(8)
    u = 0.5 * node * blank.face_width
    total = 0.0
    for at, share in zip(u, 0.5 * weight * blank.face_width, strict=True):
        column, levels = ([np.interp(at, grid.u[0], row) for row in values] for values in (thickness, grid.height))
        radius, _ = blank.axial(np.full(len(levels), at), np.array(levels))
        total += share * float(np.trapezoid(radius * column, levels))
    return total


def body_volume(grid: ToothGrid, rim: float, bore: float) -> float:
    """Volume of the body of revolution below the root, by discs through its corner points."""
    u, h = grid.u[0, [0, -1]], grid.height[0, [0, -1]]
    (r1, r2), (z1, z2) = grid.blank.axial(u, h)
    (r0, r3), (z0, z3) = grid.blank.axial(u, h - rim)
    corners = [(r0, z0), (r1, z1), (r2, z2), (r3, z3)]
    total = sum(np.pi / 3.0 * (zb - za) * (a * a + a * b + b * b) for (a, za), (b, zb) in pairwise(corners))
    return float(total) - 0.25 * np.pi * bore**2 * (z3 - z0)


@pytest.mark.parametrize("member", MEMBERS)
@pytest.mark.parametrize(("bore", "euler"), [(0.0, 2), (0.018, 0)])
def test_member_has_its_volume(grids: dict[str, ToothGrid], member: Member, bore: float, euler: int) -> None:
    grid = grids[member]
    solid = member_solid(grid, rim=0.003, bore=bore)
    assert solid.closed
    assert euler_characteristic(solid) == euler
    expected = grid.blank.teeth * tooth_volume(grid) + body_volume(grid, 0.003, bore)
    # chords for arcs across roots, lands and bore: pi^2/6 of the squared angular step
    assert solid.volume == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("member", MEMBERS)
def test_tooth_space_is_a_pitch_of_the_member(grids: dict[str, ToothGrid], member: Member) -> None:
    grid = grids[member]
    rim = 0.002
    solid = tooth_space_solid(grid, rim)
    assert solid.closed
    assert euler_characteristic(solid) == 2
    # under the root a slab of the rim over one pitch: area swept by the mid-level of the slab (Pappus)
    node, weight = leggauss(8)
    u = 0.5 * node * grid.blank.face_width
    radius, _ = grid.blank.axial(u, np.interp(u, grid.u[0], grid.height[0]) - 0.5 * rim)
    slab = float(np.sum(0.5 * weight * radius)) * grid.blank.face_width * rim * grid.pitch
    assert solid.volume == pytest.approx(tooth_volume(grid) + slab, rel=2e-3)


def test_stl_round_trip(tmp_path: Path, grids: dict[str, ToothGrid]) -> None:
    solid = tooth_space_solid(grids["gear"])
    path = tmp_path / "space.stl"
    write_stl(path, solid, "solid name")
    corners = np.frombuffer(path.read_bytes()[84:], STL_RECORD)["corners"].astype(float)
    assert not path.read_bytes().startswith(b"solid")
    assert np.abs(corners - 1e3 * solid.points[solid.triangles]).max() < 1e-5
    # the same points stay the same in single precision: the file is as closed as the solid
    flat, number = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    again = Solid(flat * 1e-3, number.reshape(-1, 3))
    assert again.closed
    assert again.volume == pytest.approx(solid.volume, rel=1e-5)


def test_bore_that_does_not_fit_is_refused(grids: dict[str, ToothGrid]) -> None:
    with refuses("bore"):
        member_solid(grids["pinion"], bore=0.2)
    with refuses("rim"):
        member_solid(grids["pinion"], rim=0.5)


@pytest.mark.parametrize("name", [name for name in bevel_names() if not name.endswith("_relieved")])
def test_solids_of_every_shipped_design_close(name: str) -> None:
    shipped = load_design(name)
    for member in MEMBERS:
        grid = tooth_grid(shipped.flanks(), member, 9, 9)
        np.testing.assert_allclose(grid.height[-1], grid.blank.tip(grid.u[-1]), atol=1e-12)
        for solid, euler in ((tooth_space_solid(grid), 2), (member_solid(grid, bore=0.0), 2)):
            assert solid.closed
            assert euler_characteristic(solid) == euler
            assert solid.volume > 0.0


def test_fillet_of_the_solid_is_the_one_the_cutter_leaves(design: Design) -> None:
    """Levels below the start of a gear flank, solved on the fillet as a flank of its own."""
    grid = tooth_grid(design.flanks(), "gear", 24, 9)
    assert grid.fillets == (True, True)
    # the settings of the pinion define its flanks only
    assert tooth_grid(design.flanks(), "pinion", 9, 9).fillets == (False, False)
    for side, azimuth in zip(grid.sides, (grid.lower, grid.upper), strict=True):
        flank = design.gear.flank("concave" if side == "concave" else "convex")
        limits, column = flank_limits(flank, 9), 3
        curve, height = limits.fillet, grid.height[:, column]
        rows = np.flatnonzero((height < limits.start[column]) & (height > limits.root[column]))
        assert rows.size > 2
        nearest = np.abs(curve.height[:, column, None] - height[rows]).argmin(axis=0)
        radius, z = grid.blank.axial(grid.u[rows, column], height[rows])
        parameters, found = fillet(flank).refine(radius, z, curve.parameters[nearest, :, column].T)
        exact, _ = flank.solve(grid.u[-1:, column], grid.height[-1:, column])
        turned = azimuth[-1, column] - exact.azimuth[0]
        there = fillet(flank).points(parameters).azimuth + turned
        assert found.all()
        # the solid takes it from a polygon of its points
        np.testing.assert_allclose(azimuth[rows, column], there, atol=2e-4)
