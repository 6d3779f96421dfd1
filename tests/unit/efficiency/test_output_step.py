"""STEP solids, re-read by the kernel: closed, of the volume of the STL, flanks where the cutter leaves them."""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from efficiency.contact.gear_flanks import MEMBERS
from efficiency.contact.tooth_grid import tooth_grid
from efficiency.design.design import load_design
from efficiency.output.solid import member_solid
from efficiency.output.step import in_mesh, read_step, shape_volume, write_step

DESIGN = "fm_spiral_bevel_14x39"


def distance(face: Any, point: Any) -> float:
    """From a point [m] to a face, in m."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape
    from OCP.gp import gp_Pnt

    vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*(1e3 * float(x) for x in point))).Vertex()
    return 1e-3 * float(BRepExtrema_DistShapeShape(vertex, face).Value())


def test_step_of_a_member_is_read_back(tmp_path: Path) -> None:
    pytest.importorskip("OCP.TColgp", reason="extra cad")
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.TopAbs import TopAbs_FACE, TopAbs_SOLID
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    flanks = load_design(DESIGN).flanks()
    grid = tooth_grid(flanks, "pinion", 15, 31)
    written = write_step(tmp_path / "pinion.step", grid, "pinion")
    shape = read_step(tmp_path / "pinion.step")
    assert shape.ShapeType() == TopAbs_SOLID
    assert BRepCheck_Analyzer(shape).IsValid()
    assert shape_volume(shape) == pytest.approx(written, rel=1e-9)
    assert shape_volume(shape) == pytest.approx(member_solid(grid).volume, rel=1e-3)

    # 100 points of each flank between those of the grid, from the cutting simulation itself
    draw = np.random.default_rng(7)
    explorer, faces = TopExp_Explorer(shape, TopAbs_FACE), []
    while explorer.More():
        faces.append(TopoDS.Face_s(explorer.Current()))
        explorer.Next()
    for side, azimuth in zip(grid.sides, (grid.lower, grid.upper), strict=True):
        flank = flanks.of("pinion")[side]
        middle = flank.solve(grid.u[10, 15:16], grid.height[10, 15:16])[0]
        turn = azimuth[10, 15] - middle.azimuth[0]
        u = draw.uniform(0.98 * grid.u[0, 0], 0.98 * grid.u[0, -1], 100)
        lowest, highest = (np.interp(u, grid.u[0], grid.height[row]) for row in (6, 14))
        h = lowest + draw.uniform(0.02, 0.98, 100) * (highest - lowest)
        cut, found = flank.solve(u, h)
        assert found.all()
        points = grid.point(cut.azimuth + turn, u, h)
        centre = grid.point(azimuth[10, 15], grid.u[10, 15], grid.height[10, 15])
        face = min(faces, key=lambda face: distance(face, centre))
        assert max(distance(face, point) for point in points) < 1e-6


@pytest.mark.fast
@pytest.mark.parametrize("name", [DESIGN, "fm_hypoid_13x42_relieved"])
def test_mounted_members_mesh_without_penetration(name: str) -> None:
    design = load_design(name)
    grids = {member: tooth_grid(design.flanks(), member, 15, 31) for member in MEMBERS}
    placed, gear, pinion = design.placement(), grids["gear"], grids["pinion"]
    least = np.inf
    for tooth in range(pinion.blank.teeth):
        for azimuth in (pinion.lower, pinion.upper):
            points = np.moveaxis(pinion.point(azimuth + tooth * pinion.pitch, pinion.u, pinion.height)[6:], -1, 0)
            at = in_mesh(points.reshape(3, -1), pinion, placed, "pinion")
            u, h = gear.blank.coordinates(np.hypot(at[0], at[1]), at[2])
            inside = (np.abs(u) < 0.49 * gear.blank.face_width) & (h < gear.blank.tip(u)) & (h > gear.blank.root(u))
            for k in np.flatnonzero(inside):
                column = int(np.argmin(np.abs(gear.u[0] - u[k])))
                sides = (np.interp(h[k], gear.height[:, column], edge[:, column]) for edge in (gear.lower, gear.upper))
                low, high = (edge + gear.pitch * np.arange(gear.blank.teeth + 1) for edge in sides)
                # the gear tooth slopes along the face: corrected to the place of the point
                slope = np.gradient(gear.lower[10], gear.u[0])[column] * (u[k] - gear.u[0, column])
                turn = (np.arctan2(at[1, k], at[0, k]) - gear.middle - slope) % (2.0 * np.pi)
                off = np.maximum(low - turn, turn - high).min() * float(np.hypot(at[0, k], at[1, k]))
                least = min(least, off)
    # in contact within ease-off and the columns of the grid, and not in each other
    assert -3e-5 < least < 1e-4


def test_missing_kernel_is_named(mixed_ehl: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "OCP.Message", None)
    outcome = mixed_ehl("export", DESIGN, "-o", tmp_path, "--what", "step")
    assert outcome.code == 2
    assert "mixed-ehl[cad]" in outcome.err
    assert not list(tmp_path.iterdir())
