"""Load distributions as CSV files: import from another program, and export.

First line ``# torque = 300 N m``: pinion torque carried by the forces. A second line ``# friction = constant:0.05,
pinion driving`` states that the normal forces carry it together with this friction. Then follow a header of column
names with units (``pinion_angle [deg],face_gear [mm],height_gear [mm],force [N]``) and one row per point and mesh
position:

``pinion_angle``
    Roll angle of the pinion from the design point in the driving direction; the positions divide one pitch evenly.
``face_gear``, ``height_gear``
    Position on the gear tooth, from the toe along the pitch cone and from the root cone normal to it; or
``x``, ``y``, ``z``
    in the mesh frame.
``force``, or ``load_per_length`` with ``length``
    Normal force at the point, or along its part of the contact line.
``length`` (optional with ``force``)
    Length of contact line represented by the point; default: half the distance to both neighbours.
``pair`` (optional)
    Number of the tooth pair, 0 for the one at the design point, +1 for the next one ahead in mesh.
``edge``, ``edge_distance``, ``edge_section``, ``edge_touching`` (optional, together)
    As in `efficiency.contact.contact_lines.EdgeProximity`; default: the nearest edge, without edge contact.
``radius_equivalent`` (optional)
    Equivalent radius instead of that of the design, such as for edge contact.
``pressure_hertz`` (optional)
    Pressure for friction, instead of that from force, length and radius: the final forces of a saved load were
    balanced with friction at the previous ones.
``grid`` (optional)
    1 for points of the coarse grid without friction, from which the bulk temperature of the teeth is estimated; 0 for
    the load itself. Without such points the load itself is used.

Normals, lever arms, velocities and curvatures at the points are those of the design.
"""

import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from efficiency.contact.contact_lines import EdgeProximity, MeshPosition, conjugate_fields
from efficiency.contact.edge_lines import nearest_edge
from efficiency.contact.flank_pair import FlankPair
from efficiency.contact.mesh_surface import EDGES, MeshSurface
from efficiency.ltca import load_distribution
from efficiency.ltca.equilibrium import Equilibrium
from efficiency.ltca.load_distribution import LoadDistribution, PositionLoad, TeethElasticity
from efficiency.ltca.mesh_grids import FrictionBalance, LoadedGrids, MeshGrids
from ehl.common.arrays import FloatArray, IntArray
from ehl.common.dialect import with_point
from ehl.common.errors import InputError
from ehl.common.files import read_text, replacing
from ehl.common.table_reader import read_table
from ehl.common.units import ValueRange, parse_quantity

_COLUMNS = {
    "pinion_angle": ValueRange("rad"),
    **dict.fromkeys(("face_gear", "height_gear", "x", "y", "z"), ValueRange("m")),
    "force": ValueRange("N", ge=0.0),
    "load_per_length": ValueRange("N/m", ge=0.0),
    "length": ValueRange("m", ge=0.0),
    "pair": ValueRange(""),
    "edge": ValueRange("", ge=0.0, lt=len(EDGES)),
    "edge_distance": ValueRange("m"),
    "edge_section": ValueRange("", gt=0.0, le=1.0),
    "edge_touching": ValueRange("", ge=0.0, le=1.0),
    "radius_equivalent": ValueRange("m", gt=0.0),
    "pressure_hertz": ValueRange("Pa", ge=0.0),
    "grid": ValueRange("", ge=0.0, le=1.0),
}
_OF_EDGE = ("edge", "edge_distance", "edge_section", "edge_touching")
# columns of a saved load with their units
_WRITTEN = {"pinion_angle": "rad", "grid": "", "pair": "", "face_gear": "mm", "height_gear": "mm", "length": "mm"}
_WRITTEN |= {"force": "N", "radius_equivalent": "mm", "pressure_hertz": "Pa"}
_WRITTEN |= dict(zip(_OF_EDGE, ("", "mm", "", ""), strict=True))
# largest distance of a point beyond an edge, for the rounding of another mesh [m]
_BEYOND = 2e-4
# largest relative deviation of the forces of a position from the stated torque
_TORQUE = 0.05
# the same with friction stated in the file, which carries a part of the torque
_FRICTION = 0.3
# largest deviation of positions from even division of the pitch, relative to their distance
_EVEN = 0.02


def write_load(load: LoadDistribution, thermal: LoadDistribution, path: Path, friction: str = "") -> None:
    """Write a load distribution in the format of `read_load`, without unloaded points.

    load, thermal: the load, and the load for the bulk temperature of the teeth.
    friction: friction that carries the torque together with the normal forces, as ``"constant:0.05, pinion driving"``.
    """
    with replacing(path, "save_load") as draft, draft.open("w", newline="", encoding="utf-8") as file:
        file.write(f"# torque = {load.torque!r} N m\n" + (f"# friction = {friction}\n" if friction else ""))
        writer = csv.writer(file)
        writer.writerow([f"{name} [{unit}]" for name, unit in _WRITTEN.items()])
        for grid, p in [*((0, p) for p in load.positions), *((1, p) for p in thermal.positions)]:
            at, e, loaded = p.position, p.position.edge, p.force > 0.0
            columns = [at.pair, *(1e3 * length for length in (at.face_gear, at.height_gear, at.length)), p.force]
            columns += [1e3 * at.radius_equivalent, p.pressure_hertz]
            if e is not None:
                columns += [e.index, 1e3 * e.distance, e.crossing, e.touching.astype(int)]
            rows = zip(*(column[loaded].tolist() for column in columns), strict=True)
            writer.writerows([at.pinion_angle, grid, *row] for row in rows)


def read_load(path: Path, contact: FlankPair, teeth: TeethElasticity, torque: float | None = None) -> LoadedGrids:
    """Load distribution of another program on the flanks of a pair, instead of the computed one.

    Materials and edges of the teeth are used, but not their compliance. A given torque must be that of the file [N m].
    Transmission error and compatibility of the result are unknown (nan).

    Raises `InputError` with the row for an invalid column or unit or a point off the tooth; for a torque that is not
    above 0 or not carried by the forces; for positions that do not divide the pitch evenly.
    """
    stated, friction, columns, rows = _table(path)
    if torque is None:
        torque = stated
    load_distribution.require_torque(torque)
    if abs(torque / stated - 1.0) > 1e-3:
        raise InputError("torque", f"{torque:.6g} N m", f"{stated:.6g} N m, the torque of {path.name}")
    surface = contact.surface
    u, v, tooth = _places(path, surface, columns, rows)
    if "force" not in columns and not {"load_per_length", "length"} <= columns.keys():
        raise InputError(str(path), "columns " + ", ".join(columns), "force, or load_per_length and length")
    grid = np.rint(columns.get("grid", np.zeros(u.size)))

    def distribution(part: float) -> LoadDistribution:
        """The load itself (0), or that of the coarse grid (1)."""
        allowed = _FRICTION if friction and part == 0.0 else _TORQUE
        chosen = np.flatnonzero(grid == part)
        loads: list[PositionLoad] = []
        angles = np.unique(np.round(columns["pinion_angle"][chosen], 12))
        if not angles.size:
            raise InputError(str(path), "points of the coarse grid alone", "points of the load (grid 0)")
        _require_even(path, angles, surface.pitch)
        for angle in angles:
            here = chosen[np.abs(columns["pinion_angle"][chosen] - angle) < 1e-11]
            here = here[np.argsort(tooth[here], kind="stable")]
            at, own = (u[here], v[here], tooth[here]), {name: column[here] for name, column in columns.items()}
            length = own["length"] if "length" in own else _spacing(surface, *at)
            force = own["force"] if "force" in own else own["load_per_length"] * length
            fields = conjugate_fields(surface, *at[:2], length)
            closing = fields.pop("minimum_gap") / fields["lever_gear"]
            gap, edge = (closing - closing.min()) * fields["lever_gear"], _edge(surface, *at[:2], own)
            position = MeshPosition(float(angle), at[2], gap=gap, transmission_error=math.nan, edge=edge, **fields)
            if "radius_equivalent" in own:
                position = replace(position, radius_equivalent=own["radius_equivalent"])
            carried = float(force @ position.lever_pinion)
            if not abs(carried / torque - 1.0) <= allowed:
                raise InputError(
                    f"{path.name}: forces at pinion angle {angle:.6g} rad (rows {rows[here[0]]} to {rows[here[-1]]})",
                    f"{carried:.6g} N m about the pinion axis",
                    f"within {allowed:.0%} of the stated {torque:.6g} N m",
                    "Check units, sign of the pinion angle, side (drive or coast), and that no tooth pair is missing.",
                )
            loads.append(_load(position, teeth, force, carried / torque - 1.0))
            if len(angles) < 2:
                raise InputError(str(path), "one mesh position", "at least 2 positions of one pitch")
        load = LoadDistribution(torque, tuple(loads), "converged", "", teeth.gear.outline())
        if "pressure_hertz" in columns:
            ordered = chosen[np.lexsort((tooth[chosen], np.round(columns["pinion_angle"][chosen], 12)))]
            carries = np.concatenate([p.force for p in loads]) > 0.0
            load.loaded["pressure_hertz"] = columns["pressure_hertz"][ordered[carries]]
        return load

    load = distribution(0.0)
    cycle = tuple(p.position for p in load.positions)
    most = max(line.size for position in cycle for line in position.lines)
    carried = np.mean([p.force @ p.position.lever_pinion for p in load.positions]) / load.torque
    note = (
        f"load distribution from {path.name}: its forces carry {carried:.4f} of the stated torque; transmission "
        "error, compatibility and discretisation error along the lines are unknown"
    )
    if friction:
        note += f"; the normal forces include the effect of friction, {friction}"
    notes, axes = (*contact.notes, note), surface.assembly.axes
    mesh = MeshGrids(contact.name, contact.side, cycle, cycle, teeth, most, axes, notes)
    mesh = replace(mesh, transmission_error=contact.transmission.peak_to_peak)
    balance = FrictionBalance(-1.0 if friction.endswith("gear driving") else 1.0, 0) if friction else None
    return LoadedGrids(mesh, load, load, balance, distribution(1.0) if np.any(grid == 1.0) else None)


def _table(path: Path) -> tuple[float, str, dict[str, FloatArray], tuple[int, ...]]:
    """Stated torque [N m] and friction, columns in SI units, and the line of the file of each row."""
    torque, friction = None, ""
    lines = read_text(path, "load_from", "a CSV file with a load distribution").splitlines()
    for number, line in enumerate(lines, 1):
        bare = line.strip(' "\t,;')
        name, _, value = bare.lstrip("# \t").partition("=")
        if bare.startswith("#") and name.strip() == "torque":
            where = f"{path.name} line {number}: torque"
            torque = parse_quantity(with_point(value.strip(), ".", where), "N*m", field=where, bare=False)
        elif bare.startswith("#") and name.strip() == "friction":
            friction = value.strip()
    if torque is None:
        raise InputError(f"{path.name}: torque", None, "a first line such as '# torque = 300 N m'")
    load_distribution.require_torque(torque)
    columns, rows = read_table(path, _COLUMNS, ("pinion_angle",), bare=False)
    if not ({"face_gear", "height_gear"} <= columns.keys() or {"x", "y", "z"} <= columns.keys()):
        raise InputError(f"{path.name}: position of points", None, "columns face_gear and height_gear, or x, y and z")
    return torque, friction, {name: np.array(column, float) for name, column in columns.items()}, rows


def _places(
    path: Path, surface: MeshSurface, columns: dict[str, FloatArray], rows: tuple[int, ...]
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Map coordinates and tooth pair of each point; `InputError` with the row for one that is off the tooth."""
    blank, angle = surface.gear.blank, columns["pinion_angle"]
    if "face_gear" in columns:
        u = columns["face_gear"] - 0.5 * blank.face_width
        height = columns["height_gear"] + blank.root(u)
    else:
        u, height = blank.place(np.stack([columns["x"], columns["y"], columns["z"] - surface.assembly.G]))
    v = blank.fraction(u, height)
    margin = surface.margin(u, v)
    if margin.min() < -_BEYOND:
        worst = int(np.argmin(margin))
        face, over = u[worst] + 0.5 * blank.face_width, height[worst] - float(blank.root(u[worst : worst + 1])[0])
        where = f"{path.name}, row {rows[worst]}"
        stated = f"{face * 1e3:.4g} mm from the toe, {over * 1e3:.4g} mm above the root of the gear"
        allowed = f"a point of the common flank; this one is {-margin[worst] * 1e3:.3g} mm outside"
        raise InputError(where, stated, allowed, "Check units, frame and that the file belongs to this pair.")
    if "pair" in columns:
        return u, v, np.rint(columns["pair"]).astype(np.int64)
    roll = surface.patch(u, v, ("roll",))[0]
    return u, v, np.rint((roll - angle) / surface.pitch).astype(np.int64)


def _require_even(path: Path, angles: FloatArray, pitch: float) -> None:
    if len(angles) < 2:
        return
    step: FloatArray = np.append(angles[1:], angles[0] + pitch) - angles
    if np.abs(step * len(angles) / pitch - 1.0).max() > _EVEN * len(angles):
        where = f"{path.name}: pinion_angle"
        stated = f"{len(angles)} positions from {angles[0]:.6g} to {angles[-1]:.6g} rad"
        raise InputError(where, stated, f"positions that divide one pitch of {pitch:.6g} rad evenly, without its end")


def _edge(surface: MeshSurface, u: FloatArray, v: FloatArray, columns: dict[str, FloatArray]) -> EdgeProximity:
    if not columns.keys() >= set(_OF_EDGE):
        return EdgeProximity(*nearest_edge(surface, u, v), np.zeros(u.size, bool))
    index, distance, section, touching = (columns[name] for name in _OF_EDGE)
    return EdgeProximity(np.rint(index).astype(np.int64), distance, section, touching > 0.5)


def _spacing(surface: MeshSurface, u: FloatArray, v: FloatArray, tooth: IntArray) -> FloatArray:
    """Half the distance to both neighbours of the same tooth pair; at the ends the whole distance to the only one."""
    point = surface.patch(u, v, ("x", "y", "z"))
    length = np.zeros(u.size)
    for pair in np.unique(tooth):
        at = np.flatnonzero(tooth == pair)
        at = at[np.argsort(u[at])]
        if at.size < 2:
            raise InputError("length", None, "a column 'length [mm]': a tooth pair with a single point has no spacing")
        step = np.sqrt((np.diff(point[:, at], axis=1) ** 2).sum(axis=0))
        length[at] = 0.5 * (np.concatenate([step[:1], step]) + np.concatenate([step, step[-1:]]))
    return length


def _load(position: MeshPosition, teeth: TeethElasticity, force: FloatArray, off: float) -> PositionLoad:
    size = position.pair.size
    unknown = np.full(size, math.nan)
    given = Equilibrium(force, math.nan, math.nan, unknown, math.nan, abs(off), 0, 0, 0, "converged", "")
    unknown = np.full(1, math.nan)
    return load_distribution.loads_of_forces([position], teeth.local([position])[0], force, unknown, unknown, [given])[
        0
    ]
