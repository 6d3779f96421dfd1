"""Flank given as a grid of points, measured by an inspection machine or written by another program.

File: CSV in the flank-inspection convention. A first line ``# mixed-ehl flank grid v1; member=pinion; flank=concave;
units=mm`` (all entries but the first are optional; further lines that start with # are ignored), a line with the column
names ``row,column,x,y,z`` or ``row,column,x,y,z,nx,ny,nz``, one line per point. Row 1 lies at the root, column 1 at the
heel; the numbers only identify a point. Any encoding, separator and decimal sign are accepted; points without a value
(empty, ``nan``, ``Bad``, -999) are omitted. Work frame of the member: z along its axis from the apex to the heel,
origin at the crossing point of the axes; normals out of the tooth, unit length. Units mm, m or inch.

The points are fitted by a smooth surface: azimuth as a polynomial of the blank coordinates, with slopes from the
normals if this reduces the error. The degree minimises the leave-one-out error, which is the error of the flank.
"""

import math
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.chebyshev import Patch
from efficiency.cutting.blank import Blank
from efficiency.cutting.cutter import FlankSide
from efficiency.cutting.flank import Flank
from efficiency.cutting.newton import Array
from ehl.common.arrays import FloatArray
from ehl.common.dialect import Dialect
from ehl.common.errors import InputError
from ehl.common.files import read_text


def normal_sense(side: FlankSide, blank: Blank) -> float:
    """+1 if the normal out of the tooth points towards increasing azimuth about the axis, otherwise -1."""
    return 1.0 if (side == "concave") == (blank.hand == "right") else -1.0


@dataclass(frozen=True)
class SmoothFlank(Flank):
    """Surface ``azimuth(u, v)``: u along the pitch cone from the mean point, v the fraction of the whole depth.

    The surface parameters are the blank coordinates u and h [m]; the third one is its own condition.
    """

    side: FlankSide  # ``"concave"`` or ``"convex"``
    blank: Blank
    sense: float  # +1 or -1, see `normal_sense`
    patch: Patch  # field ``azimuth`` [rad]
    origin: str  # origin of the surface, in words for results
    error: float  # estimated distance from the true surface along the normal [m]

    def sweep(self, x: Array) -> tuple[Array, Array, Array]:
        """Point, unit normal and the third parameter at (u, h, third)."""
        u, h = x[0], x[1]
        blank = self.blank
        sine, cosine = np.sin(blank.pitch_angle), np.cos(blank.pitch_angle)
        radius, z = blank.axial(u, h)
        slope_low, slope_high = -np.tan(blank.dedendum_angle), np.tan(blank.addendum_angle)
        depth, v = blank.tip(u) - blank.root(u), blank.fraction(u, h)
        (azimuth,), (by_u,), (by_v,) = self.patch.slopes(u, v, ("azimuth",))
        by_h = by_v / depth
        by_u = by_u - by_v * (slope_low + v * (slope_high - slope_low)) / depth
        c, s = np.cos(azimuth), np.sin(azimuth)
        point = np.stack([radius * c, radius * s, z + 0.0 * azimuth])
        # gradient of azimuth - azimuth(u, h), in radial, circumferential and axial direction, times the radius
        out = np.stack(
            [-radius * (by_u * sine + by_h * cosine), np.ones_like(azimuth), -radius * (by_u * cosine - by_h * sine)]
        )
        normal = self.sense * out / np.sqrt(np.sum(out * out, axis=0))
        turned = np.stack([c * normal[0] - s * normal[1], s * normal[0] + c * normal[1], normal[2]])
        return point, turned, x[2] + 0.0 * azimuth


FORMAT = "mixed-ehl flank grid v1"
_UNITS = {"mm": 1e-3, "m": 1.0, "inch": 0.0254, "in": 0.0254, "um": 1e-6}
_PLACEHOLDER = -999.0
_PLACE, _NORMAL = ("row", "column", "x", "y", "z"), ("nx", "ny", "nz")
_MIN_POINTS = 15
# tuned: largest distance of a point beyond its blank (fractions of face width and depth); more indicates another blank
# or another unit (this work); may be changed freely
_BEYOND = 0.35
# tuned: largest deviation of a normal from that of the surrounding points; more indicates an invalid or inverted normal
# [rad] (this work); may be changed freely
_NORMAL_OFF = 0.3


@dataclass(frozen=True)
class PointGrid:
    """Points of one flank from a file."""

    path: str
    # (n,) identification of the points
    row: NDArray[np.int64]
    column: NDArray[np.int64]
    position: FloatArray  # (3, n) [m]
    normal: FloatArray | None  # (3, n) unit normals out of the tooth
    # member and flank of the first line; empty if it states none
    member: str
    flank: str

    def place(self, index: int) -> str:
        """Name of a point for messages."""
        return f"{self.path}, row {self.row[index]}, column {self.column[index]}"


def read_point_grid(path: Path) -> PointGrid:
    """Grid of flank points from a file; an `InputError` names an invalid line, or row and column."""
    text = read_text(path, "grid", "a readable CSV file")
    lines = [line.strip("; \t,") if line.lstrip().startswith("#") else line for line in text.splitlines()]
    notes = [line.lstrip("# ") for line in lines if line.startswith("#")]
    stated = dict(part.strip().split("=", 1) for note in notes[:1] for part in note.split(";") if "=" in part)
    unit = stated.get("units", "mm")
    if unit not in _UNITS:
        raise InputError(f"{path}: units", unit, ", ".join(_UNITS))
    rows = [(k + 1, line) for k, line in enumerate(lines) if line.strip() and not line.startswith("#")]
    if not rows:
        raise InputError("grid", str(path), "a line of column names and one line per point", "The file is empty.")
    separator = max(",;\t", key=rows[0][1].count)
    names = tuple(name.casefold() for name in Dialect(separator, ".").cells(rows[0][1]))
    if names not in (_PLACE, _PLACE + _NORMAL):
        allowed = f"{','.join(_PLACE)} with or without {','.join(_NORMAL)}"
        raise InputError(f"{path}, line {rows[0][0]}", rows[0][1][:60], allowed)
    comma = separator != "," and any("," in line for _, line in rows[1:])
    dialect = Dialect(separator, "," if comma else ".")
    table = []
    for number, line in rows[1:]:
        cells = dialect.cells(line)
        if len(cells) > len(names):
            raise InputError(f"{path}, line {number}", f"{len(cells)} values", f"{len(names)} values")
        cells += [""] * (len(names) - len(cells))
        places = (f"{path}, line {number}, column {name}" for name in names)
        values = [_value(dialect, cell, place) for cell, place in zip(cells, places, strict=True)]
        if np.isfinite(values).all():
            table.append(values)
    if len(table) < _MIN_POINTS:
        raise InputError("grid", f"{path} with {len(table)} points", f"at least {_MIN_POINTS} points")
    data = np.array(table).T
    row, column = data[:2].astype(np.int64)
    normal, owner = data[5:8] if len(names) == 8 else None, (stated.get("member", ""), stated.get("flank", ""))
    grid = PointGrid(str(path), row, column, data[2:5] * _UNITS[unit], normal, *owner)
    _check_names(grid)
    return grid


def _value(dialect: Dialect, cell: str, where: str) -> float:
    """Number of a cell, nan for a missing value."""
    value = dialect.number(cell)
    if value is None:
        raise InputError(where, cell, "a finite number")
    return math.nan if value == _PLACEHOLDER else value


def _check_names(grid: PointGrid) -> None:
    names, counts = np.unique(np.stack([grid.row, grid.column]), axis=1, return_counts=True)
    if counts.max() > 1:
        row, column = names[:, int(np.argmax(counts))]
        raise InputError(f"{grid.path}, row {row}, column {column}", f"{counts.max()} points", "one point")
    if grid.normal is not None:
        length = np.linalg.norm(grid.normal, axis=0)
        worst = int(np.argmax(np.abs(length - 1.0)))
        if abs(length[worst] - 1.0) > 1e-3:
            raise InputError(grid.place(worst), f"a normal of length {length[worst]:.4g}", "unit normals")


def placed_points(
    grid: PointGrid, side: FlankSide, blank: Blank
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Coordinates of the points on a blank: u [m], depth fraction, height above pitch cone [m], azimuth [rad]; (n,).

    Raises an `InputError` if they belong to another flank, do not lie on this blank, or do not cover it.
    """
    if grid.flank and grid.flank != side:
        raise InputError(f"{grid.path}: flank", grid.flank, side)
    u, h = blank.place(grid.position)
    v = blank.fraction(u, h)
    off = np.maximum(np.abs(u) / blank.face_width - 0.5, np.abs(v - 0.5) - 0.5)
    worst = int(np.argmax(off))
    if off[worst] > _BEYOND:
        stated = (
            f"{u[worst] * 1e3:.4g} mm from the mean point along the face, {h[worst] * 1e3:.4g} mm above the pitch cone"
        )
        depth = f"{-blank.mean_dedendum * 1e3:.4g} to {blank.mean_addendum * 1e3:.4g} mm"
        allowed = f"within {blank.face_width * 1e3:.4g} mm face width and {depth}"
        raise InputError(grid.place(worst), stated, allowed, "Check units, frame, member and blank.")
    for name, share, least in (("face width", np.ptp(u) / blank.face_width, 0.6), ("depth", np.ptp(v), 0.4)):
        if share < least:
            raise InputError("grid", f"{grid.path} over {100.0 * share:.3g} % of the {name}", f"at least {least:.0%}")
    turn = np.arctan2(grid.position[1], grid.position[0])
    middle = turn[int(np.argmin((u / blank.face_width) ** 2 + (v - 0.5) ** 2))]
    return u, v, h, middle + np.angle(np.exp(1j * (turn - middle)))


def grid_flank(grid: PointGrid, side: FlankSide, blank: Blank) -> SmoothFlank:
    """Smooth flank through a grid of points on a blank.

    Raises an `InputError` if the points do not lie on this blank, do not cover it, or do not form one surface.
    """
    u, v, h, azimuth = placed_points(grid, side, blank)
    samples = _Samples(u, v, azimuth, (float(u.min()), float(u.max())), (float(v.min()), float(v.max())), None)
    shape = _best_shape(grid, samples)
    if grid.normal is not None:
        # near a limit of undercut the normals change faster than a polynomial: then the points alone are better
        sloped = replace(samples, slopes=_slopes(grid, blank, u, v))
        other = _best_shape(grid, sloped)
        if np.ptp(sloped.left_out(other)) < np.ptp(samples.left_out(shape)):
            samples, shape = sloped, other
    missed = np.abs(samples.left_out(shape))
    patch = samples.fit(shape)
    flank = SmoothFlank(side, blank, normal_sense(side, blank), patch, f"the points of {grid.path}", 0.0)
    points = flank.points(np.stack([u, h, np.zeros_like(u)]))
    # distance along the normal: distance around the axis times the component of the normal in that direction
    share = np.abs(grid.position[0] * points.normal[1] - grid.position[1] * points.normal[0])
    if grid.normal is not None:
        angle = np.linalg.norm(np.cross(grid.normal, points.normal, axis=0), axis=0)
        angle = np.where(np.sum(grid.normal * points.normal, axis=0) > 0.0, angle, 2.0)
        worst = int(np.argmax(angle))
        if angle[worst] > _NORMAL_OFF:
            stated, near = (", ".join(f"{x:.4g}" for x in n[:, worst]) for n in (grid.normal, points.normal))
            allowed, hint = (
                f"near {near}, that of the surrounding points",
                "Normals point out of the tooth; also check ",
            )
            raise InputError(grid.place(worst), f"normal {stated}", allowed, f"{hint}flank and hand.")
    return replace(flank, error=float((missed * share).max()))


def _slopes(grid: PointGrid, blank: Blank, u: FloatArray, v: FloatArray) -> FloatArray:
    """Derivatives of the azimuth along u and v from the normals, (2, n)."""
    assert grid.normal is not None
    (x, y, _), (nx, ny, nz) = grid.position, grid.normal
    radius = np.hypot(x, y)
    out, around = (nx * x + ny * y) / radius, (ny * x - nx * y) / radius
    worst = int(np.argmin(np.abs(around)))
    if abs(around[worst]) < 0.05:
        raise InputError(grid.place(worst), "a normal without circumferential component", "the normal of a flank")
    by_radius, by_z = -out / (around * radius), -nz / (around * radius)
    sine, cosine = np.sin(blank.pitch_angle), np.cos(blank.pitch_angle)
    by_u, by_h = by_radius * sine + by_z * cosine, by_radius * cosine - by_z * sine
    depth = blank.tip(u) - blank.root(u)
    # along a line of constant depth fraction the height changes as well
    climb = blank.height(u + 1.0, v) - blank.height(u, v)
    return np.stack([by_u + by_h * climb, by_h * depth])


@dataclass(frozen=True)
class _Samples:
    """Azimuth over the flank at scattered points, with slopes if there are normals."""

    u: FloatArray
    v: FloatArray
    azimuth: FloatArray
    u_range: tuple[float, float]
    v_range: tuple[float, float]
    slopes: FloatArray | None

    def rows(self, shape: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
        """Equations (n, 1 or 3, coefficients) and their right-hand sides (n, 1 or 3), slopes weighted by lengths."""
        matrix = partial(self._patch(np.zeros((*shape, 1))).matrix, self.u, self.v)
        parts, values = [matrix()], [self.azimuth]
        if self.slopes is not None:
            # a slope over a third of the distance of the points has the weight of a point
            steps = 0.33 * np.array([np.ptp(self.u), np.ptp(self.v)]) / np.sqrt(self.u.size)
            parts += [steps[0] * matrix(du=1), steps[1] * matrix(dv=1)]
            values += [steps[0] * self.slopes[0], steps[1] * self.slopes[1]]
        return np.stack(parts, axis=1), np.stack(values, axis=1)

    def fit(self, shape: tuple[int, int]) -> Patch:
        """Fit of the azimuth."""
        matrix, values = self.rows(shape)
        solution = np.linalg.lstsq(matrix.reshape(-1, matrix.shape[-1]), values.ravel(), rcond=None)[0]
        return self._patch(np.asarray(solution, np.float64).reshape(*shape, 1))

    def _patch(self, coefficients: FloatArray) -> Patch:
        return Patch(("azimuth",), self.u_range, self.v_range, coefficients)

    def left_out(self, shape: tuple[int, int]) -> FloatArray:
        """Leave-one-out error of each point [rad]."""
        matrix, values = self.rows(shape)
        n, m, k = matrix.shape
        basis = np.linalg.qr(matrix.reshape(-1, k))[0].reshape(n, m, k)
        rest = values - np.einsum("nmk,k->nm", basis, np.einsum("nmk,nm->k", basis, values))
        own = np.eye(m) - np.einsum("nik,njk->nij", basis, basis)
        # a point that alone determines a coefficient cannot be left out
        held = np.linalg.det(own) < 1e-9
        own[held] = 1e-3 * np.eye(m)
        return np.asarray(np.linalg.solve(own, rest[..., None])[:, 0, 0])


def _best_shape(grid: PointGrid, samples: _Samples) -> tuple[int, int]:
    """Numbers of coefficients with the smallest leave-one-out error."""
    per_point = 1 if samples.slopes is None else 2
    most_u, most_v = (per_point * np.unique(x).size - 1 for x in (grid.column, grid.row))
    tries = {(min(k, most_u, 16), min(max(3, round(0.75 * k)), most_v, 12)) for k in range(3, 17)}
    scored = []
    for shape in sorted(tries):
        if min(shape) < 2 or shape[0] * shape[1] > 0.75 * per_point * samples.u.size:
            continue
        scored.append((float(np.sqrt(np.mean(samples.left_out(shape) ** 2))), shape))
    if not scored:
        raise InputError("grid", f"{grid.path} with {samples.u.size} points", "at least 5 rows and 5 columns")
    best = min(scored)[0]
    if best > 0.05 * float(np.ptp(samples.azimuth)) + 1e-4:
        raise InputError("grid", grid.path, "points of one smooth flank", "They do not lie on a smooth surface.")
    # the smallest one with nearly the same error, because it is smoother beyond the points
    return next(one for score, one in sorted(scored, key=lambda item: item[1][0] * item[1][1]) if score <= 1.2 * best)
