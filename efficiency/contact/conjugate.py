"""Pinion flank without machine settings: the flank conjugate to the gear flank, less an ease-off (after Litvin).

Every gear point generates its pinion point at constant ratio; the ease-off is applied along the normal into the pinion.
The surface has the parameters of the generation: position on the gear flank and rotation of the gear, related by the
equation of meshing. It is therefore smooth across its own limit of undercut and can be analysed like a cut flank.

An ease-off may also be a table of points: a CSV file with the columns ``length,depth,ease_off``. The length is -1 at
the toe and 1 at the heel, the depth ranges from -1 to 1 over the working depth of the gear (see `EaseOffTarget`), and
ease_off in um is material missing on the pinion. Lines that start with # are ignored. A polynomial is fitted by least
squares; its degree minimises the leave-one-out error.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Self

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from pydantic import Field, model_validator

from efficiency.contact.assembly import Assembly
from efficiency.contact.chebyshev import Patch, PointFit
from efficiency.contact.ease_off import conjugate_points, relative_regularity
from efficiency.contact.flank_grid import UNDERCUT
from efficiency.contact.mesh_surface import NORMAL, POSITION
from efficiency.cutting.blank import Blank
from efficiency.cutting.cutter import FlankSide
from efficiency.cutting.flank import Flank, FlankPoints
from efficiency.cutting.machine import dot, spin, turn
from efficiency.cutting.newton import Array
from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel

Relieved = Annotated[float, ValueRange("m", ge=-2e-3, le=2e-3)]
Place = Annotated[float, ValueRange("", ge=-1.0, le=1.0)]
EaseOff = Callable[[FloatArray, FloatArray], FloatArray]
"""Ease-off [m] at (length, depth) of the gear flank, both from -1 to 1, see `EaseOffTarget`."""

ORIGIN = "the flank conjugate to the gear flank with an ease-off, not cut by settings"
# coefficients of the gear flank, and its extension beyond the blank (fractions of face width and depth)
_SHAPE = (24, 20)
_BEYOND_FACE, _BEYOND_DEPTH = 0.2, 0.12
# for an undercut gear flank: ratio of points to coefficients, and least accepted regularity, smaller than that of the
# map (`UNDERCUT`), so that the map lies inside
_OVERSAMPLING, _MIN_REGULAR = 1.5, 0.5 * UNDERCUT
_FIELDS = (*POSITION, *NORMAL, "relief")


class EaseOffTerm(InputModel):
    """One further term of an ease-off: ``relief length^i depth^j``, both from -1 to 1."""

    # powers of length and depth
    length_power: Annotated[int, Field(ge=0, le=8)]
    depth_power: Annotated[int, Field(ge=0, le=8)]
    relief: Relieved  # coefficient [m]


class EaseOffTarget(InputModel):
    """Ease-off as a polynomial of length and depth on the gear flank, both from -1 to 1, plus an optional map.

    The length is -1 at the toe and 1 at the heel. The depth is -1 at the reach of the pinion tip at the mean cone
    distance, and 1 at the gear tip. Positive values are material missing on the pinion.

    ``lengthwise_crowning (x - bias y)^2 + profile_crowning y^2 + twist x y + sum c length^i depth^j``, where x and y
    are measured from the contact point.
    """

    lengthwise_crowning: Relieved = 0.0  # relief at toe and heel [m]
    profile_crowning: Relieved = 0.0  # relief at both ends of the depth [m]
    # displacement of the crest of the lengthwise crowning towards the heel from mid-depth to the tip, in half face
    # widths: it inclines the path of contact [-]
    bias: Annotated[float, ValueRange("", ge=-5.0, le=5.0)] = 0.0
    twist: Relieved = 0.0  # flank twist: relief at the corners heel-tip and toe-root, negative at the others [m]
    # length and depth of the point without relief
    contact_face: Place = 0.0
    contact_depth: Place = 0.0
    terms: tuple[EaseOffTerm, ...] = ()  # further terms
    map: str | None = None  # path of a CSV file with a table of the ease-off

    @model_validator(mode="after")
    def _readable(self) -> Self:
        if self.map is not None:
            read_ease_off_map(Path(self.map))
        return self

    def __call__(self, length: FloatArray, depth: FloatArray) -> FloatArray:
        """Relief [m] at points of the gear flank, without the map."""
        x, y = length - self.contact_face, depth - self.contact_depth
        relief = self.lengthwise_crowning * (x - self.bias * y) ** 2 + self.profile_crowning * y**2
        relief = relief + self.twist * x * y
        for term in self.terms:
            relief = relief + term.relief * length**term.length_power * depth**term.depth_power
        return np.asarray(relief)

    def relief(self) -> EaseOff:
        """The whole ease-off including the map."""
        if self.map is None:
            return self
        given = read_ease_off_map(Path(self.map))
        return lambda length, depth: self(length, depth) + given(length, depth)


@dataclass(frozen=True)
class ConjugateFlank(Flank):
    """Conjugate flank with ease-off; built by `conjugate_flank`.

    The surface parameters are u [m] and depth fraction v of the gear flank and the rotation of the gear [rad].
    """

    side: FlankSide  # ``"concave"`` or ``"convex"``
    blank: Blank  # blank of the pinion
    assembly: Assembly  # position of the members for which the flank is conjugate
    patch: Patch  # gear flank: position, normal, and ``relief`` [m]
    sense: float  # +1 or -1: directs the product of the tangents out of the tooth
    start: FloatArray  # (3, 1) parameters near `place`
    # blank coordinates (u, h) [m] of the starting point of searches: middle of the face, half the addendum, because the
    # mean point may lie at the limit of undercut
    place: tuple[float, float]
    origin: str  # kind of flank, in words for results
    error: float  # interpolation error of the gear flank [m]

    def sweep(self, x: Array) -> tuple[Array, Array, Array]:
        """Point, unit normal out of the tooth and equation of meshing at (u, v, gear rotation)."""
        u, v, f2 = x
        assembly, ratio = self.assembly, self.assembly.ratio
        here, by_u, by_v = self.patch.slopes(u, v, _FIELDS)
        point, normal, relief = assembly.gear_in_mesh(here[:3], f2), turn(here[3:6], f2), here[6]
        sliding = assembly.sliding(point)
        condition = dot(normal, sliding)

        # derivatives by the gear rotation in the rotating pinion frame
        spun = spin(normal)
        about = spin(point)
        normal_f = spun - assembly.about_pinion(normal) / ratio
        condition_f = dot(spun, sliding) + dot(normal, assembly.slid(about))
        tangents = []
        for slope in (by_u, by_v):
            along, tilt = turn(slope[:3], f2), turn(slope[3:6], f2)
            # on the flank the rotation depends on the position by the equation of meshing
            follow = -(dot(tilt, sliding) + dot(normal, assembly.slid(along))) / condition_f
            tangents.append(along - sliding / ratio * follow + slope[6] * normal + relief * (tilt + normal_f * follow))
        out = self.sense * np.cross(tangents[0], tangents[1], axis=0)
        out = out / np.sqrt(dot(out, out))
        return (*assembly.to_pinion(point + relief * normal, out, f2 / ratio), condition)

    def guess(self) -> FloatArray:
        """Parameters near `anchor`."""
        return self.start

    @property
    def anchor(self) -> tuple[float, float]:
        """Point at half the addendum, because the mean point may lie at the limit of undercut."""
        return self.place


def conjugate_flank(gear: Flank, blank: Blank, assembly: Assembly, relief: EaseOff) -> ConjugateFlank:
    """The pinion flank on a blank conjugate to a gear flank in an assembly, less an ease-off.

    The ease-off [m] is a function of (length, depth) as in `EaseOffTarget`. Raises `ConvergenceError` if the gear flank
    does not exist or the members do not mesh.
    """
    own = gear.blank
    half = 0.5 * own.face_width * (1.0 + _BEYOND_FACE)
    low, high = -blank.mean_addendum, own.mean_addendum
    lowest = (low + own.mean_dedendum) / (own.mean_addendum + own.mean_dedendum)
    u_range, v_range = (-half, half), (lowest - _BEYOND_DEPTH, 1.0 + _BEYOND_DEPTH)
    u, v, points, present = regular_points(gear, u_range, v_range, _SHAPE)
    whole = bool(present.all())
    if not whole:
        # undercut, usually below the working depth: least squares over the existing part
        denser = int(np.ceil(_OVERSAMPLING * _SHAPE[0])), int(np.ceil(_OVERSAMPLING * _SHAPE[1]))
        u, v, points, present = regular_points(gear, u_range, v_range, denser)
        u, v, points = u[present], v[present], gear.points(points.parameters[:, present])
    h = own.height(u, v)
    length, depth = 2.0 * u / own.face_width, (h - 0.5 * (low + high)) / (0.5 * (high - low))
    fields = dict(zip(_FIELDS, [*points.position, *points.normal, relief(length, depth)], strict=True))
    if whole:
        patch = Patch.fit(u_range, v_range, _SHAPE, fields)
        error = max(patch.tail[name] for name in POSITION)
    else:
        patch = PointFit(u_range, v_range, _SHAPE, u, v)(fields)
        error = float(np.abs(dot(points.normal, patch(u, v, POSITION) - points.position)).max())

    conjugate = conjugate_points(points, assembly)
    u1, h1 = blank.place(conjugate.position)
    nearest = int(np.argmin(u1**2 + (h1 - 0.5 * blank.mean_addendum) ** 2))
    place = float(u1[nearest]), float(h1[nearest])
    start = np.array([u[nearest], v[nearest], conjugate.gear_roll[nearest]])[:, None]
    side: FlankSide = "convex" if gear.side == "concave" else "concave"
    flank = ConjugateFlank(side, blank, assembly, patch, 1.0, start, place, ORIGIN, error)
    looks = dot(flank.points(start).normal, conjugate.normal[:, nearest : nearest + 1])
    return replace(flank, sense=-float(np.sign(looks[0])))


def regular_points(
    gear: Flank, u_range: tuple[float, float], v_range: tuple[float, float], shape: tuple[int, int]
) -> tuple[FloatArray, FloatArray, FlankPoints, NDArray[np.bool_]]:
    """Gear points at the nodes of a patch, and a mask of regular points."""
    u, v = Patch.nodes(u_range, v_range, shape)
    # an additional point at half the addendum is the reference
    height = np.append(gear.blank.height(u, v), 0.5 * gear.blank.mean_addendum)
    points, found = gear.solve(np.append(u, 0.0), height)
    if not found[-1]:
        raise ConvergenceError("undercut", f"the {gear.side} gear flank does not exist at half its addendum")
    present = relative_regularity(gear, points.parameters, found)[:-1] > _MIN_REGULAR
    nodes = FlankPoints(points.parameters[:, :-1], points.position[:, :-1], points.normal[:, :-1])
    return u, v, nodes, present


COLUMNS = "length,depth,ease_off"
_PLACE, _AMOUNT = ValueRange("", ge=-1.5, le=1.5), ValueRange("", ge=-1000.0, le=1000.0)
_MIN_POINTS, _HIGHEST = 6, 10


@dataclass(frozen=True)
class EaseOffMap:
    """Smooth ease-off fitted to a table."""

    coefficients: FloatArray  # (n, m) Chebyshev coefficients over length and depth [m]
    error: float  # largest leave-one-out error of a point [m]

    def __call__(self, length: FloatArray, depth: FloatArray) -> FloatArray:
        """Relief [m] at points of the gear flank."""
        return np.asarray(chebyshev.chebval2d(length, depth, self.coefficients), np.float64)


def read_ease_off_map(path: Path) -> EaseOffMap:
    """Ease-off from a file with a table; an `InputError` names an invalid cell."""
    from ehl.common.table_reader import read_table  # slow to import

    names = COLUMNS.split(",")
    columns, rows = read_table(path, dict(zip(names, (_PLACE, _PLACE, _AMOUNT), strict=True)), names)
    if len(rows) < _MIN_POINTS:
        raise InputError("ease_off.map", f"{path} with {len(rows)} points", f"at least {_MIN_POINTS} points")
    length, depth, relief = (np.array(columns[name], float) for name in names)
    return _fit(str(path), length, depth, relief * 1e-6)


def _fit(path: str, length: FloatArray, depth: FloatArray, relief: FloatArray) -> EaseOffMap:
    best: EaseOffMap | None = None
    for degree in range(1, _HIGHEST + 1):
        kept = np.add.outer(np.arange(degree + 1), np.arange(degree + 1)) <= degree
        matrix = np.asarray(chebyshev.chebvander2d(length, depth, [degree, degree]))[:, kept.ravel()]
        basis, triangle = np.linalg.qr(matrix)
        if 1.2 * matrix.shape[1] > length.size or np.abs(np.diag(triangle)).min() < 1e-8 * np.abs(triangle).max():
            break
        rest = relief - basis @ (basis.T @ relief)
        missed = float(np.abs(rest / (1.0 - np.sum(basis**2, axis=1)).clip(1e-3)).max())
        if best is None or missed < 0.9 * best.error:
            coefficients = np.zeros(kept.shape)
            coefficients[kept] = np.linalg.solve(triangle, basis.T @ relief)
            best = EaseOffMap(coefficients, missed)
    if best is None:
        raise InputError("ease_off.map", path, "points spread over length and depth")
    return best
