"""Closed triangle meshes of a tooth space and of whole members.

The toothed surface extends from toe to heel; the root between two flanks and the top land are parts of the root cone
and the face cone. The end faces are the back cones at toe and heel. Below the root they continue by the rim thickness;
plane faces and a bore close the body.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.tooth_grid import ToothGrid
from ehl.common.arrays import FloatArray, IntArray
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.files import write_file

_ACROSS = 5  # points across a top land and a root


@dataclass(frozen=True)
class Solid:
    """A closed surface of triangles with outward normals."""

    points: FloatArray  # corners [m]
    triangles: IntArray  # corner numbers

    @property
    def volume(self) -> float:
        """Volume from the divergence theorem [m3]."""
        a, b, c = (self.points[self.triangles[:, k]] for k in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)

    @property
    def closed(self) -> bool:
        """Whether every edge belongs to two triangles with opposite directions."""
        ends = np.concatenate([self.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
        size = len(self.points)
        forward = np.sort(ends[:, 0] * size + ends[:, 1])
        backward = np.sort(ends[:, 1] * size + ends[:, 0])
        return bool(np.array_equal(forward, backward) and np.all(np.diff(forward) > 0))


class _Mesh:
    """Points, quadrilaterals and triangles during assembly."""

    def __init__(self) -> None:
        self.points: list[FloatArray] = []
        self.quads: list[IntArray] = []
        self.triangles: list[IntArray] = []
        self.count = 0

    def add(self, points: FloatArray) -> IntArray:
        """Add points (..., 3); returns their numbers (...)."""
        flat = points.reshape(-1, 3)
        self.points.append(flat)
        numbers = np.arange(self.count, self.count + len(flat)).reshape(points.shape[:-1])
        self.count += len(flat)
        return numbers

    def sheet(self, numbers: IntArray) -> None:
        """Add the cells of grids of points (..., a, b); the normal is the step in a times the step in b."""
        p, q = numbers[..., :-1, :-1], numbers[..., 1:, :-1]
        r, s = numbers[..., 1:, 1:], numbers[..., :-1, 1:]
        self.quads.append(np.stack([p, q, r, s], axis=-1).reshape(-1, 4))

    def band(self, start: IntArray, stop: IntArray) -> None:
        """Add cells between two closed rings; the normal is the step between them times the step along."""
        self.sheet(np.stack([np.append(ring, ring[:1]) for ring in (start, stop)]))

    def solid(self) -> Solid:
        """The closed surface."""
        quads = np.concatenate(self.quads)
        halves = quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]
        return Solid(np.concatenate(self.points), np.concatenate([*halves, *self.triangles]))


@dataclass(frozen=True)
class _Rim:
    """Boundary of the toothed surface: numbers of its points at toe and heel, azimuths in all columns."""

    toe: IntArray
    heel: IntArray
    azimuth: FloatArray
    first_flank: IntArray
    last_flank: IntArray


def _between(start: FloatArray, stop: FloatArray) -> FloatArray:
    """Points strictly between values (cells, ...), shape (cells, across, ...)."""
    share = np.arange(1, _ACROSS + 1) / (_ACROSS + 1)
    return start[:, None] + share.reshape(-1, *(1,) * (start.ndim - 1)) * (stop - start)[:, None]


def _toothed_surface(mesh: _Mesh, grid: ToothGrid, left: FloatArray, right: FloatArray, closed: bool) -> _Rim:
    """Teeth between left and right flank azimuths (cells, rows, columns) with end faces, and the roots between them.

    (u, h, azimuth) is a right-handed system.
    """
    u, h = grid.u, grid.height
    low, high = mesh.add(grid.point(left, u, h)), mesh.add(grid.point(right, u, h))
    mesh.sheet(low)
    mesh.sheet(high.swapaxes(1, 2))
    land = mesh.add(grid.point(_between(left[:, -1], right[:, -1]), u[-1], h[-1]))
    land = np.concatenate([low[:, -1:], land, high[:, -1:]], axis=1)
    mesh.sheet(land)
    following = np.roll(left[:, 0], -1, axis=0)
    following[-1] += 2.0 * np.pi
    gaps = len(left) if closed else len(left) - 1
    bottom = _between(right[:gaps, 0], following[:gaps])
    root = mesh.add(grid.point(bottom, u[0], h[0]))
    mesh.sheet(np.concatenate([high[:gaps, :1], root, np.roll(low[:, :1], -1, axis=0)[:gaps]], axis=1))

    ends = []
    for column in (0, -1):
        inner = np.moveaxis(_between(left[:, :-1, column], right[:, :-1, column]), 1, 2)
        points = grid.point(inner, u[:-1, column, None], h[:-1, column, None])
        face = np.concatenate([mesh.add(points), land[:, None, 1:-1, column]], axis=1)
        face = np.concatenate([low[:, :, column, None], face, high[:, :, column, None]], axis=2)
        mesh.sheet(face.swapaxes(1, 2) if column == 0 else face)
        ends.append(_in_turn(face[:, 0], root[:, :, column]))
    base = np.concatenate([left[:, :1], _between(left[:, 0], right[:, 0]), right[:, :1]], axis=1)
    return _Rim(ends[0], ends[1], _in_turn(base, bottom), low[0], high[-1])


def _in_turn(cells: NDArray[Any], gaps: NDArray[Any]) -> NDArray[Any]:
    """Entries of cells (n, a, ...) and of the following gaps (n or n - 1, b, ...) in alternating order."""
    parts = [part for k in range(len(cells)) for part in (cells[k], *gaps[k : k + 1])]
    return np.concatenate(parts)


def tooth_space_solid(grid: ToothGrid, rim: float | None = None) -> Solid:
    """One tooth space between two half teeth, on a part of the rim.

    grid: flanks of the member.
    rim: rim thickness below the root [m]; default: the mean whole depth.
    """
    rim = _rim_thickness(grid, rim)
    centre = np.broadcast_to(0.5 * (grid.lower[-1] + grid.upper[-1]), grid.lower.shape)
    left = np.stack([centre, grid.lower + grid.pitch])
    right = np.stack([grid.upper, centre + grid.pitch])
    for half, name in ((right[0] - left[0], "first"), (right[1] - left[1], "second")):
        if np.any(half <= 0.0):
            raise ConvergenceError("flanks_cross", f"the {name} half tooth extends beyond the middle of its top land")
    mesh = _Mesh()
    edge = _toothed_surface(mesh, grid, left, right, closed=False)
    floor = mesh.add(grid.point(edge.azimuth, grid.u[0], grid.height[0] - rim))
    mesh.sheet(np.stack([edge.toe, floor[:, 0]]))
    mesh.sheet(floor.T)
    mesh.sheet(np.stack([floor[:, -1], edge.heel]))
    mesh.sheet(np.stack([floor[0], edge.first_flank[0]]))
    mesh.sheet(np.stack([floor[-1], edge.last_flank[0]]).T)
    return mesh.solid()


def teeth_surface(grid: ToothGrid, teeth: int, angle: float) -> FloatArray:
    """Corners (n, 4, 3) of the cells of some teeth and of the rim at both ends, rotated by an angle [rad]."""
    turns = angle + (np.arange(teeth) - teeth // 2)[:, None, None] * grid.pitch
    mesh, ends = _Mesh(), [0, -1]
    edge = _toothed_surface(mesh, grid, grid.lower + turns, grid.upper + turns, closed=False)
    depth = 0.35 * (grid.blank.mean_addendum + grid.blank.mean_dedendum)
    toe, heel = mesh.add(grid.point(edge.azimuth[:, ends], grid.u[0, ends], grid.height[0, ends] - depth)).T
    mesh.sheet(np.stack([edge.toe, toe]))
    mesh.sheet(np.stack([heel, edge.heel]))
    return np.asarray(np.concatenate(mesh.points)[np.concatenate(mesh.quads)])


def ring_points(azimuth: FloatArray, radius: float, z: float) -> FloatArray:
    """Points (n, 3) of a circle about the axis [m]."""
    return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), np.full_like(azimuth, z)], axis=-1)


def body_section(grid: ToothGrid, rim: float | None, bore: float | None) -> tuple[FloatArray, FloatArray, float]:
    """Radii and planes [m] of the ends of toe and heel cone, and the bore; see `member_solid`."""
    rim = _rim_thickness(grid, rim)
    blank = grid.blank
    radii, planes = blank.axial(grid.u[0, [0, -1]], grid.height[0, [0, -1]] - rim)
    smallest = float(radii.min())
    if bore is None:
        bore = 1.2 * smallest if blank.pitch_angle > np.pi / 4.0 else 0.0
    if not 0.0 <= 0.5 * bore < smallest:
        allowed = f"from 0 to below {2e3 * smallest:.6g} mm, where the body ends"
        raise InputError("bore", f"{bore * 1e3:.6g} mm", allowed)
    return radii, planes, bore


def member_solid(grid: ToothGrid, rim: float | None = None, bore: float | None = None) -> Solid:
    """A whole member: all teeth, toe and heel cones, plane faces, bore.

    grid: flanks of the member.
    rim: thickness of the body below the root along toe and heel cone [m]; default: the mean whole depth.
    bore: diameter of the bore [m], 0 for a solid body. Default: 0 for a pitch angle below 45 deg, otherwise 0.6 of the
        smaller face diameter of the body.
    Raises `InputError` if rim or bore do not fit into the member.
    """
    blank = grid.blank
    radii, planes, bore = body_section(grid, rim, bore)
    turns = np.arange(blank.teeth)[:, None, None] * grid.pitch
    mesh = _Mesh()
    edge = _toothed_surface(mesh, grid, grid.lower + turns, grid.upper + turns, closed=True)
    at_toe, at_heel = edge.azimuth[:, 0], edge.azimuth[:, -1]
    front = mesh.add(ring_points(at_toe, radii[0], planes[0]))
    back = mesh.add(ring_points(at_heel, radii[1], planes[1]))
    mesh.band(edge.toe, front)
    mesh.band(back, edge.heel)
    if bore == 0.0:
        for circle, z, face in ((front, planes[0], -1.0), (back, planes[1], 1.0)):
            (centre,) = mesh.add(np.array([[0.0, 0.0, z]]))
            ahead, middle = np.roll(circle, -1), np.full_like(circle, centre)
            corners = (circle, ahead, middle) if face > 0.0 else (ahead, circle, middle)
            mesh.triangles.append(np.stack(corners, axis=-1))
        return mesh.solid()
    inner = [mesh.add(ring_points(at_toe, 0.5 * bore, z)) for z in planes]
    mesh.band(front, inner[0])
    mesh.band(inner[0], inner[1])
    # all teeth are equal: the ring at the heel is counted from the tooth nearest in azimuth
    offset = np.angle(np.exp(1j * (at_heel - at_toe[0])))
    mesh.band(inner[1], np.roll(back, -int(np.argmin(np.abs(offset)))))
    return mesh.solid()


def _rim_thickness(grid: ToothGrid, rim: float | None) -> float:
    blank = grid.blank
    radius, _ = blank.axial(grid.u[0, :1], grid.height[0, :1])
    most = float(0.9 * radius[0] / np.cos(blank.pitch_angle))
    if rim is None:
        return min(blank.mean_addendum + blank.mean_dedendum, 0.5 * most)
    if not 0.0 < rim <= most:
        raise InputError("rim", f"{rim * 1e3:.6g} mm", f"above 0 and at most {most * 1e3:.6g} mm, close to the axis")
    return rim


STL_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def write_stl(path: Path, solid: Solid, title: str) -> None:
    """Write a solid as binary STL in mm.

    path: file to write.
    solid: closed surface.
    title: text of the header, limited to 80 bytes.
    Raises `InputError` if the file cannot be written.
    """
    corners = solid.points[solid.triangles] * 1e3
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    records = np.zeros(len(corners), STL_RECORD)
    records["normal"] = np.divide(normal, size, out=np.zeros_like(normal), where=size > 0.0)
    records["corners"] = corners
    # a header that begins with "solid" denotes the text format
    header = f"STL in mm: {title}".encode("ascii", "replace")[:80].ljust(80)
    write_file(path, header + np.uint32(len(records)).tobytes() + records.tobytes())
