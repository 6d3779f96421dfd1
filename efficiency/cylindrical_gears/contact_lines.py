"""Contact lines of an involute pair over a pinion pitch, in the plane of action, and its elastic teeth.

Mesh frame: origin in the pitch point, x along the transverse line of action (the direction of the force on the gear),
z along the axes, y normal to the plane of action. A line of contact is x = x0 + z tan(beta_b); it moves with r_b1
times the speed of the pinion. Sliding is normal to the line at every point: v = (1 + 1/u) xi omega_1. The teeth
are elastic solids: the solver of bevel teeth on a blank whose pitch cone is a cylinder.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from efficiency.contact.assembly import Axis
from efficiency.contact.contact_lines import MeshPosition
from efficiency.contact.tooth_grid import ToothGrid
from efficiency.cutting.blank import Blank
from efficiency.cylindrical_gears.involute import InvolutePair
from efficiency.ltca.load_distribution import TeethElasticity
from efficiency.ltca.solid_tooth import COLUMNS, ROWS, SolidTooth, ToothBody, solid_tooth
from ehl.common.arrays import FloatArray
from ehl.material import Material

Relief = Callable[[FloatArray], FloatArray]
"""Gap from the tip relief of both members [m] over the place on the path of contact [m]."""

# shortest line of contact, over the face width
_SHORTEST = 1e-3


def axes_of(pair: InvolutePair) -> tuple[Axis, Axis]:
    """Axes of pinion and gear in the mesh frame."""
    along = np.array([0.0, 0.0, 1.0])
    (one, two), (first, second) = pair.tangent, pair.base
    return Axis(along, np.array([-one, first, 0.0])), Axis(along, np.array([two, -second, 0.0]))


def mesh_position(pair: InvolutePair, angle: float, points: int, relief: Relief) -> MeshPosition:
    """Points on all lines of contact at a pinion angle [rad], `points` on each line."""
    slope, (start, end), half = math.tan(pair.base_helix), pair.path, 0.5 * pair.face_width
    reach = half * slope
    low, high = (math.floor((value - pair.base[0] * angle) / pair.base_pitch) for value in (start - reach, end + reach))
    parts = []
    for number in range(low, high + 2):
        middle = pair.base[0] * angle + number * pair.base_pitch
        if slope == 0.0:
            ends = (-half, half) if start <= middle <= end else (0.0, 0.0)
        else:
            first, last = (float(np.clip((e - middle) / slope, -half, half)) for e in (start, end))
            ends = first, last
        if ends[1] - ends[0] < _SHORTEST * pair.face_width:
            continue
        step = (ends[1] - ends[0]) / points
        place = ends[0] + step * (np.arange(points) + 0.5)
        parts.append((np.full(points, float(number)), middle + slope * place, place, np.full(points, step)))
    pairs, xi, z, steps = (np.concatenate(column) for column in zip(*parts, strict=True))
    zero, ratio = np.zeros_like(xi), pair.teeth[1] / pair.teeth[0]
    sine, cosine = math.sin(pair.base_helix), math.cos(pair.base_helix)
    curvature = pair.tangent[0] + xi, pair.tangent[1] - xi
    radius = [np.hypot(base, rho) for base, rho in zip(pair.base, curvature, strict=True)]
    gap = relief(xi)
    rows = np.ones((xi.size, 1))
    # angle between the tooth trace, along which a flank is ground, and the contact line
    lay = [_lay(pair, member, rho) for member, rho in enumerate(curvature)]
    return MeshPosition(
        pinion_angle=angle,
        pair=pairs.astype(np.int64),
        position=np.column_stack([xi, zero, z]),
        normal=rows * np.array([cosine, 0.0, -sine]),
        along=rows * np.array([sine, 0.0, cosine]),
        across=rows * np.array([0.0, 1.0, 0.0]),
        length=steps / cosine,
        gap=gap - gap.min(),
        radius_equivalent=curvature[0] * curvature[1] / (curvature[0] + curvature[1]) / cosine,
        lever_pinion=np.full(xi.size, pair.base[0] * cosine),
        lever_gear=np.full(xi.size, pair.base[1] * cosine),
        sliding_along=zero,
        sliding_across=curvature[0] - curvature[1] / ratio,
        entrainment=0.5 * (curvature[0] + curvature[1] / ratio),
        height_gear=radius[1] - pair.root[1],
        height_pinion=radius[0] - pair.root[0],
        face_gear=z + half,
        face_pinion=z + half,
        transmission_error=-float(gap.min()) / (pair.base[1] * cosine),
        lay_pinion=lay[0],
        lay_gear=lay[1],
    )


def _lay(pair: InvolutePair, member: int, curvature: FloatArray) -> FloatArray:
    """Angle of the trace (theta' (r_b, rho), 1), theta' = tan(beta)/r, and the contact line (sin, 0, cos) [rad]."""
    turn = math.tan(pair.helix_angle) / pair.reference[member]
    base, sine, cosine = pair.base[member], math.sin(pair.base_helix), math.cos(pair.base_helix)
    length = np.sqrt(1.0 + turn**2 * (base**2 + curvature**2))
    return np.arccos(np.clip((turn * base * sine + cosine) / length, -1.0, 1.0))


def mesh_cycle(pair: InvolutePair, positions: int, points: int, relief: Relief) -> tuple[MeshPosition, ...]:
    """Positions over one pinion pitch."""
    pitch = 2.0 * math.pi / pair.teeth[0]
    return tuple(mesh_position(pair, pitch * (k + 0.5) / positions, points, relief) for k in range(positions))


# rim under the teeth over the whole depth (backup ratio of solid gears, as for bevel gears), at most half the way to
# the axis
RIM, TO_AXIS = 1.2, 0.5


class RigidTeeth(TeethElasticity):
    """Rigid teeth: only the contacts deform, so that the load per length is uniform within 10 %."""

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
    # a cone angle of zero is not allowed as an input; its heights are radii
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
        hand="right",  # without effect
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
        # the loaded flank of each member faces rising azimuth: sections that lead in the sense of rotation
        # are turned forwards on the pinion, backwards on the gear
        twist = (1.0 - 2.0 * member) * lead / pair.reference[member]
        rim = min(RIM * (tip - root), TO_AXIS * root)
        return cylindrical_tooth(
            pair.teeth[member], root, tip, pair.face_width, lambda r: pair.half_angle(member, r), rim,
            materials[member], twist,
        )  # fmt: skip

    kind = RigidTeeth if rigid else TeethElasticity
    return kind(tooth(0), tooth(1), *materials, edge_rounding, edge_rounding)
