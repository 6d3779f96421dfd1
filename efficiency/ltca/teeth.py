"""The teeth of a pair as elastic bodies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from efficiency.contact.gear_flanks import GearFlanks, Member, Side
from efficiency.contact.tooth_grid import tooth_grid, tooth_shapes
from efficiency.ltca.local_compliance import Tooth
from efficiency.ltca.plate import PlateTooth
from efficiency.ltca.ritz_solid import ORDERS, Orders
from efficiency.ltca.solid_tooth import SolidTooth, solid_tooth
from ehl.common.errors import ConvergenceError
from ehl.material import Material

ToothModel = Literal["solid", "plate"]

# levels of the depth and stations of the face at which the flanks of the solid are computed
ROWS, COLUMNS = 15, 7


@dataclass(frozen=True)
class ToothBody:
    """Material of a member and the body under its teeth.

    Attributes
    ----------
    material : Material
        Of the teeth.
    rim_thickness : float
        From the root cone to the base, square to the pitch cone [m].
    held : frozenset of {"base", "toe", "heel"}
        Surfaces of the body that do not move against the shaft.
    youngs_modulus : float, optional
        Of the body [Pa]; that of the teeth by default.
    """

    material: Material
    rim_thickness: float
    held: frozenset[str] = frozenset({"base"})
    youngs_modulus: float | None = None


Bodies = tuple[ToothBody, ToothBody]
"""Of pinion and gear."""


def elastic_teeth(flanks: GearFlanks, bodies: Bodies, side: Side, model: ToothModel = "solid") -> tuple[Tooth, Tooth]:
    """Pinion and gear tooth, loaded on the flanks of a side.

    Parameters
    ----------
    flanks : GearFlanks
        The pair.
    bodies : (ToothBody, ToothBody)
        Of pinion and gear.
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
        return solid_tooth_of(flanks, bodies[0], "pinion", side), solid_tooth_of(flanks, bodies[1], "gear", side)
    teeth = []
    for shape, flank, body in zip(tooth_shapes(flanks), flanks.mating(side), bodies, strict=True):
        teeth.append(PlateTooth.from_shape(shape, *flank.mean_angles(), body.material))
    return teeth[0], teeth[1]


def solid_tooth_of(
    flanks: GearFlanks,
    body: ToothBody,
    member: Member,
    side: Side,
    orders: Orders = ORDERS,
    cells: int | None = None,
) -> SolidTooth:
    """Solid tooth of one member; `orders` and `cells` as in `solid_tooth`."""
    try:
        grid = tooth_grid(flanks, member, ROWS, COLUMNS)
    except ConvergenceError as error:
        if error.reason == "flanks_cross":
            # says where and what to check, if they cross inside the tooth
            tooth_shapes(flanks)
        raise
    return solid_tooth(
        grid,
        flanks.loaded_side(member, side),
        body.material,
        body.rim_thickness,
        body.held,
        body.youngs_modulus,
        orders,
        cells,
    )
