"""Flanks as grids of points for flank inspection, and their CSV file.

Row 1 lies at the root, the last row at the tip; column 1 at the heel, the last column at the toe. The points are given
in the work frame of the member: z along its axis from the apex to the heel, origin at the crossing point of the axes
(for a hypoid pair at the foot of the common normal). Normals are unit vectors out of the tooth.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError, InputError

if TYPE_CHECKING:
    from efficiency.contact.gear_flanks import Member
    from efficiency.cutting.cutter import FlankSide
    from efficiency.cutting.flank import Flank
    from efficiency.design.design import Design


FORMAT = "mixed-ehl flank grid v1"
COLUMNS = "row,column,x,y,z,nx,ny,nz"


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

    @property
    def azimuth(self) -> FloatArray:
        """Angle of the points about the axis of the member [rad], (rows, columns)."""
        return np.asarray(np.arctan2(self.position[1], self.position[0]))


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
    number_row, number_column = np.meshgrid(np.arange(1, rows + 1), np.arange(1, columns + 1), indexing="ij")
    table = np.column_stack(
        [number_row.ravel(), number_column.ravel(), *grid.position.reshape(3, -1) * 1e3, *grid.normal.reshape(3, -1)]
    )
    header = (
        f"# {FORMAT}; member={member}; flank={side}; units=mm\n"
        f"# design={design.name}; teeth={blank.teeth}; hand={blank.hand}; rows={rows} from root to tip; "
        f"columns={columns} from heel to toe; first row at {grid.lowest:.4g} of the whole depth over the root; "
        "z along the axis from apex to heel; origin at the crossing point; normals out of the tooth\n"
        f"{COLUMNS}"
    )
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savetxt(
            path, table, fmt=["%d", "%d"] + ["%.9f"] * 3 + ["%.12f"] * 3, delimiter=",", header=header, comments=""
        )
    except OSError as error:
        raise InputError("csv", str(path), "a writable file", f"{error}.") from None
