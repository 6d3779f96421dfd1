"""Export of a design to files of other programs; each function returns a line that describes the written file.

Grids of points for flank inspection: row 1 lies at the root, the last row at the tip; column 1 at the heel, the last
column at the toe. The points are given in the work frame of the member: z along its axis from the apex to the heel,
origin at the crossing point of the axes (for a hypoid pair at the foot of the common normal). Normals are unit vectors
out of the tooth.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from efficiency.contact.conjugate import COLUMNS
from efficiency.contact.flank_pair import flank_pair
from efficiency.contact.gear_flanks import MEMBERS, SIDES, Member
from efficiency.contact.tooth_grid import ToothGrid, tooth_grid
from efficiency.cutting.cutter import FLANK_SIDES, FlankSide
from efficiency.cutting.flank import Flank
from efficiency.design.design import Design
from efficiency.output.machine_summary import Units, sheet_text, write_summary
from efficiency.output.solid import member_solid, tooth_space_solid, write_stl
from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError, check_choice, check_count
from ehl.common.files import replacing, write_file
from ehl.common.units import ValueRange

FORMAT = "mixed-ehl flank grid v1"
GRID_COLUMNS = "row,column,x,y,z,nx,ny,nz"


@dataclass(frozen=True)
class InspectionGrid:
    """One flank on a regular grid of its blank."""

    # distance from the mean point along the pitch cone to the heel, height above that cone [m]
    u: FloatArray
    height: FloatArray
    # points [m] and unit normals out of the tooth, work frame of the member
    position: FloatArray
    normal: FloatArray
    lowest: float  # depth fraction of the first row, 0 at the root cone; positive if the flank ends above the root


def inspection_grid(flank: Flank, rows: int = 15, columns: int = 31, margin: float = 0.0) -> InspectionGrid:
    """Points of a flank from root to tip (rows) and from heel to toe (columns).

    flank: any flank.
    rows, columns: size of the grid.
    margin: distance kept from root, tip, toe and heel, as a fraction of the face width and of the depth [-].
    Raises `ConvergenceError` if the flank does not cover its blank.
    """
    blank = flank.blank
    along = np.linspace(0.5 - margin, -0.5 + margin, columns) * blank.face_width
    lowest = margin
    for _ in range(2):
        u, v = np.meshgrid(along, np.linspace(lowest, 1.0 - margin, rows))
        h = blank.height(u, v)
        points, found = flank.solve(u.ravel(), h.ravel())
        if found.all():
            shape = (3, rows, columns)
            return InspectionGrid(u, h, points.position.reshape(shape), points.normal.reshape(shape), lowest)
        lowest = max(margin, flank.lowest_fraction(1.0 - margin))
    raise ConvergenceError("undercut", f"the {flank.side} flank does not cover its blank")


def write_inspection_grid(path: Path, design: Design, member: Member, side: FlankSide, grid: InspectionGrid) -> None:
    """Write one flank as CSV: two header lines, a line of column names, one line per point in mm.

    The first line, ``# mixed-ehl flank grid v1; member=pinion; flank=concave; units=mm``, contains all data needed to
    read the file. The second one contains the design and the position of the grid on the blank.

    Raises `InputError` if the file cannot be written.
    """
    blank = (design.pinion if member == "pinion" else design.gear).blank
    rows, columns = grid.u.shape
    numbers = np.indices((rows, columns)).reshape(2, -1) + 1
    table = np.column_stack([*numbers, *grid.position.reshape(3, -1) * 1e3, *grid.normal.reshape(3, -1)])
    header = (
        f"# {FORMAT}; member={member}; flank={side}; units=mm\n"
        f"# design={design.name}; teeth={blank.teeth}; hand={blank.hand}; rows={rows} from root to tip; "
        f"columns={columns} from heel to toe; first row at {grid.lowest:.4g} of the whole depth over the root; "
        "z along the axis from apex to heel; origin at the crossing point; normals out of the tooth\n"
        f"{GRID_COLUMNS}"
    )
    with replacing(path, "csv") as draft:
        np.savetxt(
            draft, table, fmt=["%d", "%d"] + ["%.9f"] * 3 + ["%.12f"] * 3, delimiter=",", header=header, comments=""
        )


EXPORTS = ("tooth", "member", "step", "grid", "ease_off", "summary")


def export_design(
    design: Design,
    folder: Path,
    what: Iterable[str],
    members: Iterable[Member],
    rows: int,
    columns: int,
    margin: float,
    rim: float | str | None,
    bore: float | str | None,
    units: Units,
) -> list[str]:
    """Write the chosen files; see `efficiency.pair.GearPair.export`."""
    chosen = list(what)
    for part in chosen:
        check_choice("what", part, EXPORTS)
    for name, count in (("rows", rows), ("columns", columns)):
        check_count(name, count, 5, 200)
    ValueRange("", ge=0.0, le=0.3).check(margin, "margin")
    length = ValueRange("m", ge=0.0, le=3.0)
    thickness = None if rim is None else length.check_given(rim, "rim")
    hole = None if bore is None else length.check_given(bore, "bore")
    written: list[str] = []
    grids: dict[Member, ToothGrid] = {}
    for member in members:
        solids = [part for part in ("tooth", "member", "step") if part in chosen]
        if solids:
            grid = grids[member] = tooth_grid(design.flanks(), member, rows, columns)
            written += [_export_solid(design, member, part, folder, grid, thickness, hole) for part in solids]
        if "grid" in chosen:
            for side in FLANK_SIDES:
                points = inspection_grid(design.flank(member, side), rows, columns, margin)
                path = folder / f"{member}_{side}.csv"
                write_inspection_grid(path, design, member, side, points)
                start = f", from {100.0 * points.lowest:.1f} % of the depth above the root" * (points.lowest > 0.0)
                written.append(f"{path}: {rows} x {columns} points{start}")
    if "step" in chosen and len(grids) == len(MEMBERS):
        written.append(_export_pair(design, folder, grids))
    if "ease_off" in chosen:
        written += export_ease_off(design, folder)
    if "summary" in chosen:
        table, sheet = folder / "machine_summary.csv", folder / "setting_sheet.csv"
        write_summary(table, design, units)
        write_file(sheet, sheet_text(design, units))  # for re-import
        written.append(f"{table}: blanks, cutters and settings of four flanks, {units}")
        written.append(f"{sheet}: the same data, one entry per line, {units}")
    return written


def _export_solid(
    design: Design, member: Member, part: str, folder: Path, grid: ToothGrid, rim: float | None, bore: float | None
) -> str:
    """STL of one tooth space between two half teeth, or STL or STEP of a whole member."""
    if part == "step":
        from efficiency.output.step import write_step

        path = folder / f"{member}.step"
        volume = write_step(path, grid, f"{design.name} {member}", rim, bore)
        return f"{path}: B-spline surfaces, closed, {1e9 * volume:.6g} mm3"
    path = folder / (f"{member}_tooth_space.stl" if part == "tooth" else f"{member}.stl")
    solid = tooth_space_solid(grid, rim) if part == "tooth" else member_solid(grid, rim, bore)
    if not solid.closed:
        raise ConvergenceError("open_solid", f"the surface of {path.name} is not closed: change rows or columns")
    write_stl(path, solid, f"{design.name} {path.stem}")
    bare = [side for side, fillet in zip(grid.sides, grid.fillets, strict=True) if not fillet]
    note = f"; {' and '.join(bare)} flank extended to the root cone without fillet" if bare else ""
    return f"{path}: {len(solid.triangles)} triangles, closed, {1e9 * solid.volume:.6g} mm3{note}"


def _export_pair(design: Design, folder: Path, grids: dict[Member, ToothGrid]) -> str:
    """STEP of both members as mounted, from their files."""
    from efficiency.output.step import placed_in_mesh, read_step, write_shapes

    placement = design.placement()
    shapes = [placed_in_mesh(read_step(folder / f"{m}.step"), grid, placement, m) for m, grid in grids.items()]
    path = folder / "pair.step"
    write_shapes(path, shapes, f"{design.name} pair")
    return f"{path}: both members in the mesh frame, z along the gear axis"


def export_ease_off(design: Design, folder: Path) -> list[str]:
    """CSV maps of the ease-off of both flank pairs, in the format of `map` of targets and flanks."""
    written = []
    flanks = design.flanks()
    for side in SIDES:
        surface = flank_pair(flanks, side).surface
        low, high = -surface.pinion.blank.mean_addendum, surface.gear.blank.mean_addendum
        blank = surface.gear.blank
        length, depth = (x.ravel() for x in np.meshgrid(np.linspace(-1.0, 1.0, 21), np.linspace(-1.0, 1.0, 11)))
        u = 0.5 * blank.face_width * length
        v = blank.fraction(u, 0.5 * (low + high) + 0.5 * (high - low) * depth)
        inside = surface.regular(u, v) > 0.0
        relief = surface.patch(u, v, ("ease_off",))[0] * 1e6
        rows = np.stack([length, depth, relief], axis=1)[inside]
        path = folder / f"ease_off_{side}.csv"
        head = f"# design={design.name}; {side} side; material missing on the pinion, um"
        lines = [head, COLUMNS, *(f"{x:.3f},{y:.3f},{z:.6f}" for x, y, z in rows)]
        write_file(path, "\n".join(lines) + "\n")
        written.append(f"{path}: ease-off of the {side} side, {len(rows)} points")
    return written
