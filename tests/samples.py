"""What many tests look at: steel, an oil, one contact, and a tiny mesh of the shipped spiral bevel pair.

A mesh and its load are computed once per process and shared; nothing in them can be changed.
"""

from functools import cache

import numpy as np

from efficiency.contact.gear_flanks import Side
from efficiency.cutting.blank import Blank
from efficiency.design.design import load_design
from efficiency.loss.kinematics import Operation
from efficiency.ltca.mesh_grids import LoadedGrids, load_grids
from efficiency.mesh import Mesh
from ehl.common.validation import validate
from ehl.contact import Contact
from ehl.fluid.oil import Oil
from ehl.material import Material

STEEL = Material.load("steel")
AXLE_OIL = Oil.load("75w90")
BEVEL = load_design("fm_spiral_bevel_14x39")
OPERATION = Operation(125.0, 363.15, 0.4e-6, 0.4e-6)

GEAR_BLANK = Blank(
    teeth=39, pitch_angle=np.radians(70.2532), mean_cone_distance=0.081273, face_width=0.0254, mean_addendum=0.001591,
    mean_dedendum=0.005639, addendum_angle=np.radians(2.1342), dedendum_angle=np.radians(6.4934), hand="right",
)  # fmt: skip

# a contact of a gear and an oil by numbers, as tables of an input file
CONTACT = {"radius_equivalent": 0.015, "pressure_hertz": 1e9, "speed_entrainment": 5.0, "slide_to_roll": 0.3}
PLAIN_OIL = {"viscosity_inlet": 0.02, "pressure_viscosity": 18e-9}


def contact_case(**tables: object) -> Contact:
    """Input of one contact: the sample contact and oil but for the tables given."""
    return validate(Contact, {"contact": CONTACT, "lubricant": PLAIN_OIL, **tables})


@cache
def tiny_mesh(side: Side = "drive", design: str = "fm_spiral_bevel_14x39") -> Mesh:
    """Four positions with nine points a line."""
    return Mesh.of(load_design(design), side, 4, 9, keep=True)


@cache
def tiny_load(torque: float = 200.0, side: Side = "drive") -> LoadedGrids:
    """The tiny mesh of the bevel pair under a pinion torque [N m]."""
    return load_grids(tiny_mesh(side).grids, torque)
