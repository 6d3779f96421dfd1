"""Load distributions as CSV files: of another program in place of the own one, and the own one out.

First line ``# torque = 300 N m``: torque of the pinion that the forces carry. Then a header of column names with units
(``pinion_angle [deg],face_gear [mm],height_gear [mm],force [N]``) and one row per point and mesh position:

``pinion_angle``
    Roll of the pinion from the design point in the driving direction; the positions divide one pitch evenly.
``face_gear``, ``height_gear``
    Place on the gear tooth, from the toe along the pitch cone and from the root cone square to it; or
``x``, ``y``, ``z``
    in the mesh frame.
``force``, or ``load_per_length`` with ``length``
    Normal force at the point, or along its part of the contact line.
``length`` (optional beside ``force``)
    Length of contact line the point stands for; without it half the way to both neighbours.
``pair`` (optional)
    Number of the tooth pair, 0 for the one at the design point, +1 further along in mesh.

Normals, arms, velocities and curvatures at the points are those of the design.
"""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.contact_lines import EdgeProximity, MeshPosition, conjugate_fields
from efficiency.contact.edge_lines import nearest_edge
from efficiency.contact.flank_pair import FlankPair
from efficiency.contact.mesh_surface import MeshSurface
from efficiency.ltca.equilibrium import Equilibrium
from efficiency.ltca.load_distribution import (
    ElasticPosition,
    LoadDistribution,
    PositionLoad,
    TeethElasticity,
    loads_of_forces,
    require_torque,
)
from efficiency.ltca.mesh_grids import LoadedGrids, MeshGrids
from ehl.common.errors import InputError
from ehl.common.files import read_text, replacing
from ehl.common.table_reader import numbered_table
from ehl.common.units import ValueRange, parse_quantity

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_COLUMNS = {
    "pinion_angle": ValueRange("rad"),
    **dict.fromkeys(("face_gear", "height_gear", "x", "y", "z"), ValueRange("m")),
    "force": ValueRange("N", ge=0.0),
    "load_per_length": ValueRange("N/m", ge=0.0),
    "length": ValueRange("m", ge=0.0),
    "pair": ValueRange(""),
}
# how far beyond an edge a point may lie, for the rounding of another mesh [m]
_BEYOND = 2e-4
# how far the forces of a position may be from the torque stated
_TORQUE = 0.05
# how far positions may be from dividing the pitch evenly, as a share of their distance
_EVEN = 0.02


def write_load(load: LoadDistribution, path: Path) -> None:
    """Write a load distribution in the format `read_load` reads; points without load are left out."""
    with replacing(path, "save_load") as draft, draft.open("w", newline="", encoding="utf-8") as file:
        file.write(f"# torque = {load.torque!r} N m\n")
        writer = csv.writer(file)
        writer.writerow(
            [f"{name} [{unit}]" for name, unit in (("pinion_angle", "rad"), ("pair", ""))]
            + [f"{name} [{unit}]" for name, unit in (("face_gear", "mm"), ("height_gear", "mm"), ("length", "mm"))]
            + ["force [N]"]
        )
        for p in load.positions:
            at = p.position
            for k in np.flatnonzero(p.force > 0.0):
                millimetres = (1e3 * float(values[k]) for values in (at.face_gear, at.height_gear, at.length))
                writer.writerow(
                    [repr(at.pinion_angle), int(at.pair[k]), *map(repr, millimetres), repr(float(p.force[k]))]
                )


def read_load(path: Path, contact: FlankPair, teeth: TeethElasticity, torque: float | None = None) -> LoadedGrids:
    """Load distribution of another program on the flanks of a pair, in place of the own one.

    Materials and edges of the teeth are used, their compliance is not. A torque given has to be that of the file [N m].
    Transmission error and compatibility of the result are unknown (nan).

    Raises
    ------
    InputError
        With the row: a column or unit that cannot be used, a point off the tooth; a torque that is not above 0 or that
        the forces do not carry; positions that do not divide the pitch evenly.
    """
    stated, columns, rows = _table(path)
    if torque is None:
        torque = stated
    require_torque(torque)
    if abs(torque / stated - 1.0) > 1e-3:
        raise InputError("torque", f"{torque:.6g} N m", f"{stated:.6g} N m, the torque of {path.name}")
    surface = contact.surface
    u, v, tooth = _places(path, surface, columns, rows)
    if "force" not in columns and not {"load_per_length", "length"} <= columns.keys():
        raise InputError(str(path), "columns " + ", ".join(columns), "force, or load_per_length and length")
    loads: list[PositionLoad] = []
    angles = np.unique(np.round(columns["pinion_angle"], 12))
    _require_even(path, angles, surface.pitch)
    for number, angle in enumerate(angles):
        here = np.flatnonzero(np.abs(columns["pinion_angle"] - angle) < 1e-11)
        here = here[np.argsort(tooth[here], kind="stable")]
        length = columns["length"][here] if "length" in columns else _spacing(surface, u[here], v[here], tooth[here])
        force = columns["force"][here] if "force" in columns else columns["load_per_length"][here] * length
        position = _position(surface, float(angle), u[here], v[here], tooth[here], length)
        carried = float(force @ position.lever_pinion)
        if not abs(carried / torque - 1.0) <= _TORQUE:
            raise InputError(
                f"{path.name}: forces at pinion angle {angle:.6g} rad (rows {rows[here[0]]} to {rows[here[-1]]})",
                f"{carried:.6g} N m about the pinion axis",
                f"within {_TORQUE:.0%} of the {torque:.6g} N m stated",
                "Check units, sign of the pinion angle, side (drive or coast), and that no tooth pair is missing.",
            )
        loads.append(_load(position, teeth, force, carried / torque - 1.0))
        if number == 0 and len(angles) < 2:
            raise InputError(str(path), "one mesh position", "at least 2 positions of one pitch")
    load = LoadDistribution(torque, tuple(loads), "converged", "", teeth.gear.outline())
    cycle = tuple(p.position for p in loads)
    most = max(line.size for position in cycle for line in position.lines)
    note = (
        f"load distribution from {path.name}: its forces carry {_carried(load):.4f} of the torque stated; transmission "
        "error and compatibility are not known, and no error of its grid along the lines"
    )
    mesh = MeshGrids(contact.name, contact.side, cycle, cycle, teeth, most, None, (*contact.notes, note))
    return LoadedGrids(replace(mesh, transmission_error=contact.transmission.peak_to_peak), load, load)


def _carried(load: LoadDistribution) -> float:
    return float(np.mean([p.force @ p.position.lever_pinion for p in load.positions])) / load.torque


def _table(path: Path) -> tuple[float, dict[str, FloatArray], tuple[int, ...]]:
    """Torque stated [N m], columns in SI units, and the line of the file each row stands in."""
    torque: float | None = None
    lines = read_text(path, "load_from", "a CSV file with a load distribution").splitlines()
    for number, line in enumerate(lines, 1):
        name, _, value = line.lstrip("# \t").partition("=")
        if line.lstrip().startswith("#") and name.strip() == "torque":
            torque = parse_quantity(value.strip(), "N*m", field=f"{path.name} line {number}: torque", bare=False)
    if torque is None:
        raise InputError(f"{path.name}: torque", None, "a first line such as '# torque = 300 N m'")
    require_torque(torque)
    columns, rows = numbered_table(path, _COLUMNS, ("pinion_angle",), bare=False)
    if not ({"face_gear", "height_gear"} <= columns.keys() or {"x", "y", "z"} <= columns.keys()):
        raise InputError(f"{path.name}: place of the points", None, "columns face_gear and height_gear, or x, y and z")
    return torque, {name: np.array(column, float) for name, column in columns.items()}, rows


def _places(
    path: Path, surface: MeshSurface, columns: dict[str, FloatArray], rows: tuple[int, ...]
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Map coordinates and tooth pair of each point; `InputError` with the row for one that is off the tooth."""
    blank, angle = surface.gear.blank, columns["pinion_angle"]
    if "face_gear" in columns:
        u = columns["face_gear"] - 0.5 * blank.face_width
        height = columns["height_gear"] + blank.root(u)
    else:
        z = columns["z"] - surface.assembly.G
        along, over = blank.coordinates(np.hypot(columns["x"], columns["y"]), z)
        u, height = np.real(along), np.real(over)
    v = surface.fraction(u, height)
    margin = surface.margin(u, v)
    if margin.min() < -_BEYOND:
        worst = int(np.argmin(margin))
        face, over = u[worst] + 0.5 * blank.face_width, height[worst] - float(blank.root(u[worst : worst + 1])[0])
        raise InputError(
            f"{path.name}, row {rows[worst]}",
            f"{face * 1e3:.4g} mm from the toe, {over * 1e3:.4g} mm over the root of the gear",
            f"a point of the common flank; this one is {-margin[worst] * 1e3:.3g} mm outside of it",
            "Check units, frame and that the file belongs to this pair.",
        )
    if "pair" in columns:
        return u, v, np.rint(columns["pair"]).astype(np.int64)
    roll = surface.patch(u, v, ("roll",))[0]
    return u, v, np.rint((roll - angle) / surface.pitch).astype(np.int64)


def _require_even(path: Path, angles: FloatArray, pitch: float) -> None:
    if len(angles) < 2:
        return
    step: FloatArray = np.append(angles[1:], angles[0] + pitch) - angles
    if np.abs(step * len(angles) / pitch - 1.0).max() > _EVEN * len(angles):
        raise InputError(
            f"{path.name}: pinion_angle",
            f"{len(angles)} positions from {angles[0]:.6g} to {angles[-1]:.6g} rad",
            f"positions that divide one pitch of {pitch:.6g} rad evenly, its end left out",
        )


def _position(
    surface: MeshSurface, angle: float, u: FloatArray, v: FloatArray, tooth: IntArray, length: FloatArray
) -> MeshPosition:
    fields = conjugate_fields(surface, u, v, length)
    closing = fields.pop("minimum_gap") / fields["lever_gear"]
    gap = (closing - closing.min()) * fields["lever_gear"]
    edge = EdgeProximity(*nearest_edge(surface, u, v), np.zeros(u.size, bool))
    return MeshPosition(angle, tooth, gap=gap, transmission_error=math.nan, edge=edge, **fields)


def _spacing(surface: MeshSurface, u: FloatArray, v: FloatArray, tooth: IntArray) -> FloatArray:
    """Half the way to both neighbours of the same tooth pair; at the ends the whole way to the only one."""
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
    rounding = np.ones(size) if position.edge is None else teeth.rounding(position.edge)
    elastic = ElasticPosition(position, np.zeros((size, size)), teeth.local([position])[0], np.zeros(size), rounding)
    given = Equilibrium(
        force, math.nan, math.nan, np.full(size, math.nan), math.nan, abs(off), 0, 0, 0, "converged", ""
    )
    unknown = np.full(1, math.nan)
    return loads_of_forces([elastic], elastic.approach, force, unknown, unknown, [given])[0]
