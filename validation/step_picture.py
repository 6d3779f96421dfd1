"""Picture of the STEP solids of a pair as a CAD program reads them.

``python validation/step_picture.py [FOLDER]`` writes the members of DESIGN as STEP, reads the files back with Open
CASCADE (extra `cad`), draws its own triangles of the faces and prints volumes next to those of the STL.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from common import OUT, command_line
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from efficiency.contact.gear_flanks import Member
from efficiency.contact.tooth_grid import tooth_grid
from efficiency.design.design import load_design
from efficiency.output.solid import member_solid
from efficiency.output.step import read_step, shape_volume, write_step

DESIGN = "fm_spiral_bevel_14x39_relieved"
MEMBERS: tuple[Member, ...] = ("pinion", "gear")
DEFLECTION, ANGLE = 0.05, 0.2  # of the triangles: mm, rad
LIGHT = np.array([0.4, -0.5, 0.77])


def faces(shape: Any) -> Iterator[np.ndarray]:
    """Triangles (n, 3, 3) of each face [mm]."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS

    BRepMesh_IncrementalMesh(shape, DEFLECTION, False, ANGLE, True)
    explorer = TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        face, place = TopoDS.Face_s(explorer.Current()), TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(face, place)
        nodes = np.array([mesh.Node(i + 1).Coord() for i in range(mesh.NbNodes())])
        corners = np.array([mesh.Triangle(i + 1).Get() for i in range(mesh.NbTriangles())]) - 1
        yield nodes[corners]
        explorer.Next()


def draw(axes: Any, shape: Any) -> None:
    """A shaded solid."""
    triangles = np.concatenate(list(faces(shape)))
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-12)[:, None]
    # the triangles of a face may run either way round
    shade = 0.25 + 0.75 * np.abs(normal @ LIGHT)
    colours = shade[:, None] * np.array([0.72, 0.80, 0.90])
    axes.add_collection3d(
        Poly3DCollection(triangles, facecolors=colours, edgecolors=colours, linewidths=0.3, rasterized=True)
    )
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low, zoom=1.35)
    axes.set_axis_off()


def main(argv: Sequence[str] | None = None) -> None:
    """Write, read back, draw."""
    parser = command_line(__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=OUT)
    folder = parser.parse_args(argv).folder
    folder.mkdir(parents=True, exist_ok=True)
    flanks = load_design(DESIGN).flanks()
    figure = Figure(figsize=(9.6, 4.6), layout="constrained")
    for number, member in enumerate(MEMBERS, 1):
        grid = tooth_grid(flanks, member, 15, 31)
        with tempfile.TemporaryDirectory() as place:
            path = Path(place) / f"{member}.step"
            write_step(path, grid, member)
            shape = read_step(path)
        volume, meshed = shape_volume(shape), member_solid(grid).volume
        print(f"{member}: {1e6 * volume:.3f} cm3, {volume / meshed - 1.0:+.3%} against the STL")
        axes: Any = figure.add_subplot(1, 2, number, projection="3d")
        draw(axes, shape)
        axes.view_init(elev=-35.0, azim=-60.0)
        axes.set_title(f"{member}.step", y=1.0)
    figure.savefig(folder / "step.png", dpi=110)


if __name__ == "__main__":
    main()
