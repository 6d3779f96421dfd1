"""The teeth of a design as elastic bodies."""

from __future__ import annotations

from typing import Literal

import numpy as np

from efficiency.contact.pair import Side
from efficiency.contact.thickness import tooth_shapes
from efficiency.contact.tooth_grid import Member, tooth_grid
from efficiency.cutting.cutter import FlankSide
from efficiency.design.design import Design
from efficiency.ltca.compliance import Tooth
from efficiency.ltca.plate import PlateTooth
from efficiency.ltca.ritz_solid import ORDERS, Orders
from efficiency.ltca.solid_tooth import SolidTooth, solid_tooth
from ehl.io.errors import ConvergenceError

ToothModel = Literal["solid", "plate"]

# levels of the depth and stations of the face at which the flanks of the solid are computed
ROWS, COLUMNS = 15, 7


def elastic_teeth(design: Design, side: Side, model: ToothModel = "solid") -> tuple[Tooth, Tooth]:
    """Pinion and gear tooth, loaded on the flanks of a side.

    Parameters
    ----------
    design : Design
        The pair.
    side : {"drive", "coast"}
        Which flanks are in contact.
    model : {"solid", "plate"}
        Three-dimensional tooth on its ring of teeth, or the plate on an elastic root it is compared with.

    Raises
    ------
    InputError
        The flanks of a member cross, or its rim reaches the axis.
    ConvergenceError
        A flank does not span its blank.
    """
    if model == "solid":
        return solid_tooth_of(design, "pinion", side), solid_tooth_of(design, "gear", side)
    teeth = []
    for shape, flank, member in zip(
        tooth_shapes(design), design.flanks(side), (design.pinion, design.gear), strict=True
    ):
        points, found = flank.solve(np.zeros(1), np.zeros(1))
        if not found.all():
            raise ConvergenceError("undercut", f"the {flank.side} flank does not reach the mean point")
        spiral, pressure = points.angles(flank.blank.pitch_angle)
        teeth.append(PlateTooth.from_shape(shape, float(spiral[0]), float(pressure[0]), member.elastic_material()))
    return teeth[0], teeth[1]


def solid_tooth_of(
    design: Design, member: Member, side: Side, orders: Orders = ORDERS, cells: int | None = None
) -> SolidTooth:
    """Solid tooth of one member; `orders` and `cells` as in `solid_tooth`."""
    given = design.pinion if member == "pinion" else design.gear
    try:
        grid = tooth_grid(design, member, ROWS, COLUMNS)
    except ConvergenceError as error:
        if error.reason == "flanks_cross":
            # says where and what to check, if they cross inside the tooth
            tooth_shapes(design)
        raise
    return solid_tooth(
        grid,
        loaded_flank(design, member, side),
        given.elastic_material(),
        given.body.thickness(grid.blank),
        frozenset(given.body.held),
        given.body.youngs_modulus,
        orders,
        cells,
    )


def loaded_flank(design: Design, member: Member, side: Side) -> FlankSide:
    """The flank of a member that carries on a side."""
    concave = (design.assembly.drive_flank_pinion == "concave") == ((member == "pinion") == (side == "drive"))
    return "concave" if concave else "convex"
