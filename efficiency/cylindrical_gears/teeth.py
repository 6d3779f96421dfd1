"""Teeth of cylindrical gears as elastic solids: the solver of bevel teeth on a blank whose pitch cone is a cylinder."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from efficiency.contact.contact_lines import MeshPosition
from efficiency.contact.tooth_grid import ToothGrid
from efficiency.cutting.blank import Blank
from efficiency.cylindrical_gears.involute import InvolutePair
from efficiency.ltca.load_distribution import TeethElasticity
from efficiency.ltca.solid_tooth import COLUMNS, ROWS, SolidTooth, ToothBody, solid_tooth
from ehl.common.arrays import FloatArray
from ehl.material import Material

# rim under the teeth over the whole depth (backup ratio of solid gears, as for bevel gears), at most half the way to
# the axis
RIM, TO_AXIS = 1.2, 0.5


class RigidTeeth(TeethElasticity):
    """Teeth that do not bend: the lines of contact flatten alone, so that the load per length is even within 10 %."""

    def bending(self, cycle: Sequence[MeshPosition]) -> list[FloatArray]:
        """No deflection at any point."""
        return [np.zeros((p.pair.size, p.pair.size)) for p in cycle]


def cylindrical_tooth(
    teeth: int,
    root: float,
    tip: float,
    width: float,
    half_angle: Callable[[float], float],
    rim: float,
    material: Material,
    twist: float = 0.0,
) -> SolidTooth:
    """One tooth between the root and tip radius, its ring below.

    root, tip, width, rim: [m].
    half_angle: half the angle the tooth fills at a radius [rad].
    twist: turn of the sections along the face [rad/m], positive towards the loaded flank.
    """
    # a cone of no angle is no blank that an input may be; its heights are radii
    blank = Blank.model_construct(
        teeth=teeth,
        pitch_angle=0.0,
        mean_cone_distance=0.5 * width,
        face_width=width,
        mean_addendum=tip,
        mean_dedendum=-root,
        addendum_angle=0.0,
        dedendum_angle=0.0,
        pitch_apex_beyond_crossing=0.0,
    )
    radii, stations = np.linspace(root, tip, ROWS), np.linspace(-0.5, 0.5, COLUMNS) * width
    height, u = (np.array(grid) for grid in np.meshgrid(radii, stations, indexing="ij"))
    half = np.array([half_angle(float(radius)) for radius in radii])[:, None]
    turned = twist * u
    grid = ToothGrid(blank, u, height, turned - half, turned + half, ("convex", "concave"), (False, False))
    return solid_tooth(grid, "concave", ToothBody(material, rim))


def elastic_pair(
    pair: InvolutePair, materials: tuple[Material, Material], edge_rounding: float, *, rigid: bool = False
) -> TeethElasticity:
    """Compliance of the teeth of both members; `rigid` teeth do not bend."""
    lead = math.tan(pair.helix_angle)

    def tooth(member: int) -> SolidTooth:
        root, tip = pair.root[member], pair.tip[member]
        # each member is seen with its loaded flank towards rising azimuth: sections that lead in the sense of rotation
        # are turned forwards on the pinion, backwards on the gear
        twist = (1.0 - 2.0 * member) * lead / pair.reference[member]
        rim = min(RIM * (tip - root), TO_AXIS * root)
        return cylindrical_tooth(
            pair.teeth[member], root, tip, pair.face_width, lambda r: pair.half_angle(member, r), rim,
            materials[member], twist,
        )  # fmt: skip

    kind = RigidTeeth if rigid else TeethElasticity
    return kind(tooth(0), tooth(1), *materials, edge_rounding, edge_rounding)
