"""Root bending stress of the teeth over the mesh cycle: forces through the root of the solid tooth, and its fillet.

stress at the fillet = A q + B n + C m

q, n, m: shear, thrust and moment through the root per length of face (`root_forces`, three-dimensional); A, B, C: what
each of them does along the fillet of that section (`root_section`, plane strain). Normal forces alone; of the
neighbouring teeth only the body under them is felt.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from efficiency.contact.gear_flanks import GearFlanks, Member
from efficiency.contact.tooth_grid import RootProfile, ToothGrid, root_profile
from efficiency.cutting.cutter import FlankSide
from efficiency.cutting.flank import CutFlank
from efficiency.ltca.load_distribution import PositionLoad
from efficiency.ltca.solid_tooth import COLUMNS, SolidTooth
from efficiency.ltca.tooth_cell import lagrange_values
from efficiency.strength.root_forces import RootForces, root_forces
from efficiency.strength.root_section import Outline, RootSection, arc_outline, solve_section
from ehl.common.errors import ConvergenceError, InputError

FloatArray = NDArray[np.float64]

# tuned: edge radius of a cutter that states none, in mean normal modules (ours; basic racks have 0.2 to 0.4); may be
# changed freely, a design states its own
EDGE_RADIUS = 0.25
# radii tried one after the other where the slot is too narrow for it
_RADII = (1.0, 0.75, 0.5)
# columns of the grid of the tooth at which sections are solved
_SECTIONS = (1, 3, 5)
# tuned: share of the face at toe and heel where a section is no longer one of a long tooth (ours); may be changed by
# whoever repeats docs/strength.md
_END = 0.05
_STATIONS = 31


@dataclass(frozen=True)
class RootTooth:
    """A tooth of one member, ready for any load on its flank."""

    member: Member
    forces: RootForces  # what loads send through its root
    # loaded, far: (3, s, p) stress at p points along the fillets of s stations per unit resultants, as in `RootSection`
    loaded: FloatArray
    far: FloatArray
    radius: FloatArray  # (s,) least radius of curvature of the fillet on the loaded side [m]
    chord: FloatArray  # (s,) thickness of the tooth where the fillets begin to turn away by 30 deg [m]
    height: FloatArray  # (s, p) of the points on the loaded side over the root cone [m]
    fillet: str  # where the fillets come from, in words

    @property
    def station(self) -> FloatArray:
        """Distance of the fillets on the loaded side from the toe [m], (s,)."""
        frames = self.forces.frames
        place = np.clip(frames.place - self.forces.side * frames.oblique, 0.0, 1.0)
        return np.asarray(place * self.forces.cell.width)


@dataclass(frozen=True)
class RootStress:
    """Root stress of one tooth as it goes through the mesh.

    Attributes
    ----------
    member : {"pinion", "gear"}
    tension : float
        Greatest tensile stress along the fillet on the loaded side [Pa].
    compression : float
        Most negative stress on the other side [Pa].
    face, height : float
        Where the greatest tension is: distance from the toe, height over the root cone [m].
    roll : (k,) array
        Roll of the tooth pair [rad of the pinion].
    history, history_compression : (k,) arrays
        Greatest tension and compression along the face at each roll [Pa].
    station : (s,) array
        Distance from the toe [m].
    along : (s,) array
        Greatest tension of the mesh cycle at these stations [Pa].
    radius, notch : float
        Radius of the fillet there [m], and its notch parameter: thickness over twice the radius [-].
    fillet : str
        Where the fillet comes from, in words.
    """

    member: Member
    tension: float
    compression: float
    face: float
    height: float
    roll: FloatArray
    history: FloatArray
    history_compression: FloatArray
    station: FloatArray
    along: FloatArray
    radius: float
    notch: float
    fillet: str


def root_tooth(
    flanks: GearFlanks, member: Member, tooth: SolidTooth, module: float, cells: int | None = None
) -> RootTooth:
    """Fillets, sections and root forces of the solid tooth of one member; `ConvergenceError` where no fillet fits.

    `module` is the mean normal module, for the edge radius of a cutter that states none [m]; `cells` the teeth in the
    ring, all if not given.
    """
    if not (np.isfinite(module) and module > 0.0):
        raise InputError("module", module, "a finite length above 0 m")
    grid = tooth.grid
    place = np.linspace(_END, 1.0 - _END, _STATIONS)
    columns = np.array(_SECTIONS) / (COLUMNS - 1.0)
    forces = root_forces(tooth, np.concatenate([place, columns]), cells)
    outlines, fillet = _outlines(flanks, member, grid, forces, module)
    upper = forces.side > 0.0
    poisson = tooth.body.material.poisson_ratio
    sections: list[RootSection] = []
    for low, high in outlines:
        sections.append(solve_section(high, low, poisson) if upper else solve_section(low, high, poisson))
    own = [pair[1 if upper else 0] for pair in outlines]
    shape = lagrange_values(columns, place)

    def spread(values: Sequence[FloatArray]) -> FloatArray:
        return np.asarray(np.tensordot(shape, np.stack(values), axes=1))

    frames = forces.frames
    heights = []
    for k, section in enumerate(sections):
        # up is square to the root, as the heights are to the pitch cone: alike but for the root angle
        floor = float(np.interp(columns[k] * forces.cell.width, forces.cell.stations, forces.cell.floor))
        heights.append(floor + section.place_loaded[:, 1])
    chord = np.array([_thickness(*pair) for pair in outlines])
    return RootTooth(
        member,
        replace(
            forces,
            frames=replace(frames, **{n: getattr(frames, n)[:_STATIONS] for n in frames.__dataclass_fields__}),
            response=forces.response[:, :_STATIONS],
        ),
        np.moveaxis(spread([s.loaded for s in sections]), 0, 1),
        np.moveaxis(spread([s.far for s in sections]), 0, 1),
        spread([np.array(_least_radius(o.fillet)) for o in own]),
        spread(list(chord)),
        spread(heights),
        fillet,
    )


def root_stress(tooth: RootTooth, loads: Sequence[PositionLoad], pitch: float) -> RootStress:
    """Stress of a tooth over the mesh cycle: loads over one pitch of the pinion [rad]."""
    rolls, resultants = [], []
    for load in loads:
        p = load.position
        face, height = (getattr(p, f"{name}_{tooth.member}") for name in ("face", "height"))
        for pair in np.unique(p.pair[load.force > 0.0]):
            at = (p.pair == pair) & (load.force > 0.0)
            rolls.append(p.pinion_angle + float(pair) * pitch)
            resultants.append(tooth.forces.of(face[at], height[at], load.force[at]))
    if not rolls:
        raise InputError("load", "no loaded point", "a load distribution with forces above 0 N")
    order = np.argsort(rolls)
    carried = np.stack(resultants)[order]
    tension = np.einsum("kxs,xsp->ksp", carried, tooth.loaded)
    pressed = np.einsum("kxs,xsp->ksp", carried, tooth.far)
    worst = np.unravel_index(int(np.argmax(tension)), tension.shape)
    station = tooth.station
    radius = float(tooth.radius[worst[1]])
    return RootStress(
        tooth.member,
        float(tension.max()),
        float(pressed.min()),
        float(station[worst[1]]),
        float(tooth.height[worst[1], worst[2]]),
        np.array(rolls)[order],
        tension.max(axis=(1, 2)),
        pressed.min(axis=(1, 2)),
        station,
        tension.max(axis=(0, 2)),
        radius,
        float(tooth.chord[worst[1]]) / (2.0 * radius),
        tooth.fillet,
    )


def _outlines(
    flanks: GearFlanks, member: Member, grid: ToothGrid, forces: RootForces, module: float
) -> tuple[list[tuple[Outline, Outline]], str]:
    """Outlines of the lower and upper side at the sections, and where their fillets come from."""
    given = [flank.blade.edge_radius if isinstance(flank, CutFlank) else 0.0 for flank in flanks.of(member).values()]
    stated = all(radius > 0.0 for radius in given)
    if stated:
        origin = "cut, edge radius of the design"
    else:
        origin = f"assumed, edge radius {EDGE_RADIUS:g} normal modules (none in the design)"
    error: ConvergenceError | None = None
    for share in _RADII:
        radius = share * EDGE_RADIUS * module
        try:
            sides = [_side(flanks, member, side, grid, forces, radius, k) for k, side in enumerate(grid.sides)]
        except ConvergenceError as found:
            error = found
            continue
        if not stated and share < 1.0:
            origin = f"assumed, edge radius {share * EDGE_RADIUS:.3g} normal modules: no larger one fits the slot"
        return list(zip(*sides, strict=True)), origin
    raise error or ConvergenceError("no_fillet", "no fillet fits between the flanks")


def _side(
    flanks: GearFlanks, member: Member, side: FlankSide, grid: ToothGrid, forces: RootForces, radius: float, upper: int
) -> list[Outline]:
    """Outlines of one side of the tooth at the sections."""
    azimuth = grid.upper if upper else grid.lower
    root = _cut_fillet(flanks, member, side, radius)
    outlines = []
    for k, column in enumerate(_SECTIONS):
        station = _STATIONS + k
        height = grid.height[:, column]
        line = scipy.interpolate.CubicSpline(height, azimuth[:, column])
        u = grid.u[0, column]
        low = height[0] if root is None else root.start[column]
        levels = np.linspace(height[-1], low, 25)

        def section(angles: FloatArray, heights: FloatArray, u: float = u, station: int = station) -> FloatArray:
            points = forces.frames.section(station, grid.point(angles, np.full_like(heights, u), heights))
            return np.asarray(points * np.array([1.0 if upper else -1.0, 1.0]))

        if root is None:
            flank = section(line(levels), levels)
            outlines.append(arc_outline(flank, float(flank[-1, 1]), radius))
            continue
        turn = float(line(low)) - root.azimuth[0, column]
        fillet = section(root.azimuth[:, column] + turn, root.height[:, column])
        outlines.append(Outline(section(line(levels), levels), fillet))
    return outlines


def _cut_fillet(flanks: GearFlanks, member: Member, side: FlankSide, radius: float) -> RootProfile | None:
    """Fillet the cutter leaves, with a given edge radius where its own is none; None where it leaves none."""
    flank = flanks.of(member)[side]
    if not isinstance(flank, CutFlank):
        return None
    if not flank.blade.edge_radius > 0.0:
        try:
            flank = replace(flank, blade=replace(flank.blade, edge_radius=radius))
        except (InputError, ConvergenceError, ValueError):
            return None
    blank, mate = flanks.blank(member), flanks.blank("gear" if member == "pinion" else "pinion")
    return root_profile(flank, COLUMNS, max(blank.mean_dedendum - mate.mean_addendum, 0.0))


def _least_radius(line: FloatArray) -> float:
    """Least radius of curvature of a fillet [m], its ends left out."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    even = np.linspace(0.0, length[-1], 15)
    x, y = (np.interp(even, length, line[:, k]) for k in (0, 1))
    angle = np.unwrap(np.arctan2(np.diff(y), np.diff(x)))
    bend = np.abs(np.diff(angle))[1:-1] / (even[1] - even[0])
    return float(1.0 / bend.max())


def _thickness(low: Outline, high: Outline) -> float:
    """Thickness between the points of both fillets whose tangent stands at 30 deg to the middle [m]."""
    total = 0.0
    for outline in (low, high):
        step = np.diff(outline.fillet, axis=0)
        steep = np.arctan2(step[:, 0], -step[:, 1]) >= np.pi / 6.0
        total += float(outline.fillet[int(np.argmax(steep)), 0])
    return total
