"""Direct tangency of two real flanks in space: the second algorithm behind the unloaded contact of the package.

At each pinion angle both flanks touch in one point with a common normal: three equations of position, two of the
normals and both conditions of the surfaces for the surface parameters of both points and the gear rotation. On an edge
one equation of the normals gives way to the edge, the other says that the edge lies in the tangent plane of the mating
flank. Newton's method, marched from angle to angle; no ease-off, no map, no interpolation.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.assembly import Assembly
from efficiency.contact.contact_search import ContactPath
from efficiency.contact.ease_off import conjugate_points, ease_off
from efficiency.contact.mesh_surface import EDGES, MeshSurface
from efficiency.cutting import newton
from efficiency.cutting.blank import Blank
from efficiency.cutting.flank import Flank
from efficiency.cutting.machine import cross, turn
from efficiency.cutting.newton import Array

FloatArray = NDArray[np.float64]

_STATES = ("offset", "E", "P", "G", "shaft_angle_error", "shaft_angle")
_SUBSTEP = 0.08
_STATE_STEPS = 2


@dataclass(frozen=True)
class Tangency:
    """Contact points of one tooth pair without load.

    Rotations about the axes of the mesh frame [rad], the pinion flank as cut, without phase; surface parameters of both
    points and the gear rotation (7, n); blank coordinates of the gear point [m]; where there is a contact.
    """

    pinion_rotation: FloatArray
    gear_rotation: FloatArray
    parameters: FloatArray
    gear_u: FloatArray
    gear_h: FloatArray
    found: NDArray[np.bool_]


def _rim(blank: Blank, edge: str, point: Array) -> tuple[Array, Array]:
    """How far points lie off an edge of their blank, and the gradient of that in space."""
    s, c = np.sin(blank.pitch_angle), np.cos(blank.pitch_angle)
    radius = np.sqrt(point[0] ** 2 + point[1] ** 2)
    along = radius * s + (point[2] + blank.pitch_apex_beyond_crossing) * c - blank.mean_cone_distance
    height = radius * c - (point[2] + blank.pitch_apex_beyond_crossing) * s
    name = edge.split()[1]
    if name in ("toe", "heel"):
        off = along + (0.5 if name == "toe" else -0.5) * blank.face_width
        by_radius, by_z = s, c
    else:
        taper = np.tan(blank.addendum_angle) if name == "tip" else -np.tan(blank.dedendum_angle)
        off = height - (blank.mean_addendum if name == "tip" else -blank.mean_dedendum) - taper * along
        by_radius, by_z = c - taper * s, -s - taper * c
    gradient = np.stack([by_radius * point[0] / radius, by_radius * point[1] / radius, by_z + 0.0 * radius])
    return off, gradient


def _result(gear: Flank, rotation: FloatArray, x: FloatArray, found: NDArray[np.bool_]) -> Tangency:
    point = np.real(gear.sweep(x[3:6])[0])
    u, h = gear.blank.coordinates(np.hypot(point[0], point[1]), point[2])
    return Tangency(rotation, x[6], x, np.real(u), np.real(h), found)


def march(gear: Flank, pinion: Flank, assembly: Assembly, rotation: FloatArray, start: FloatArray) -> Tangency:
    """March the contact of two flanks from the middle one of rising pinion rotations to both ends.

    Flanks are continued beyond their blanks. `start` (7,): surface parameters of the pinion and the gear point and gear
    rotation at the middle.
    """
    n = rotation.size
    x, found = np.tile(np.asarray(start)[:, None], (1, n)), np.zeros(n, dtype=bool)
    middle = n // 2
    for part in (range(middle, n), range(middle, -1, -1)):
        at, here = np.asarray(start, dtype=np.float64)[:, None].copy(), float(rotation[middle])
        for k in part:
            # sub-steps: from one pitch to the next the contact moves farther than Newton's method forgives
            for finer in (1, 2, 4):
                count = finer * max(1, int(np.ceil(abs(rotation[k] - here) / _SUBSTEP)))
                there, ok = at.copy(), True
                for f1 in here + (rotation[k] - here) * np.arange(1, count + 1) / count:
                    there[6] += assembly.ratio * (rotation[k] - here) / count
                    there, done = touching(gear, pinion, assembly, np.array([f1]), there)
                    ok = ok and bool(done[0])
                if ok:
                    break
            if not ok:
                break
            at = there
            here = float(rotation[k])
            x[:, k], found[k] = at[:, 0], True
    return _result(gear, rotation, x, found)


def follow(
    gear: Flank, pinion: Flank, before: tuple[Assembly, Tangency], assembly: Assembly, rotation: FloatArray
) -> Tangency:
    """Lead the contact from one assembly and rotations to others, all points together."""
    old, start = before
    x, found = start.parameters.copy(), start.found.copy()
    turned = start.pinion_rotation
    for share in np.arange(1, _STATE_STEPS + 1) / _STATE_STEPS:
        step = {name: getattr(old, name) + share * (getattr(assembly, name) - getattr(old, name)) for name in _STATES}
        f1 = start.pinion_rotation + share * (rotation - start.pinion_rotation)
        x[6] += assembly.ratio * (f1 - turned)
        turned = f1
        x, ok = touching(gear, pinion, replace(assembly, **step), f1, x)
        found &= ok
    return _result(gear, rotation, x, found)


def touching(
    gear: Flank, pinion: Flank, assembly: Assembly, f1: FloatArray, x: FloatArray, edge: str = ""
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Contact at pinion rotations f1 (n,) from starts nearby (7, n), and where it was found.

    `edge`, such as ``"pinion tip"``, is the edge of one member that touches the flank of the other; empty: two flanks.
    """
    size = gear.blank.mean_cone_distance
    limit = np.array([0.05 * size, 0.05, 0.05, 0.05 * size, 0.05, 0.05, 0.02])
    tolerance = 1e-9 * np.array([size, 1.0, 1.0, size, 1.0, 1.0, 1.0])
    normal = np.real(turn(gear.sweep(x[3:6])[1], x[6]))
    least = np.eye(3)[:, np.argmin(np.abs(normal), axis=0)]
    first = np.cross(normal, least, axis=0)
    second = np.cross(normal, first, axis=0)
    turned = assembly.pinion_frame

    def residual(y: Array) -> Array:
        p, normal_p, condition_p = pinion.sweep(y[:3])
        g, normal_g, condition_g = gear.sweep(y[3:6])
        at = np.pi + f1 + 0.0 * y[6]
        gap = turned @ turn(p, at) + assembly.pinion_origin - turn(g, y[6])
        gap = gap - np.array([[0.0], [0.0], [assembly.G]])
        facing_p, facing_g = turned @ turn(normal_p, at), turn(normal_g, y[6])
        if not edge:
            both = facing_p + facing_g
            rest = np.stack([np.sum(first * both, axis=0), np.sum(second * both, axis=0)])
        elif edge.startswith("pinion"):
            off, gradient = _rim(pinion.blank, edge, p)
            along = turned @ turn(cross(normal_p, gradient), at)
            rest = np.stack([off / size, np.sum(along * facing_g, axis=0)])
        else:
            off, gradient = _rim(gear.blank, edge, g)
            along = turn(cross(normal_g, gradient), y[6])
            rest = np.stack([off / size, np.sum(along * facing_p, axis=0)])
        return np.concatenate([gap, rest, condition_p[None], condition_g[None]])

    return newton.iterate(lambda x: newton.complex_jacobian(residual, x), x, limit, tolerance, 15)


def start_at(surface: MeshSurface, path: ContactPath, at: NDArray[np.int64]) -> FloatArray:
    """Starts for Newton's method near points of a contact path, (7, n)."""
    on_gear, _ = surface.gear.solve(path.u[at], path.height[at])
    conjugate = conjugate_points(on_gear, surface.assembly)
    _, on_pinion, _ = ease_off(conjugate, surface.pinion, surface.phase)
    turned = surface.assembly.ratio * (surface.direction * path.pinion_angle[at] + surface.roll_zero)
    return np.concatenate([on_pinion, on_gear.parameters, turned[None]])


@dataclass(frozen=True)
class PathCheck:
    """Largest differences between a contact path and direct tangency.

    Of the transmission error [rad] and the contact point in the blank coordinates of the gear [m]; numbers of pinion
    angles compared: two flanks, an edge and a flank; the tangency of the two flanks, edges disregarded.
    """

    transmission_error: float
    distance: float
    free: int
    edge: int
    tangency: Tangency


def check_path(surface: MeshSurface, path: ContactPath, before: tuple[Assembly, Tangency] | None = None) -> PathCheck:
    """Compare a contact path of one tooth pair with direct tangency.

    Two flanks: marched from the middle of the path, or led from the tangency of another state of misalignment
    (`before`). Edges: each from the place that the path says; corners and the limit of undercut have no tangency and
    are left out.
    """
    assembly, gear, pinion = surface.assembly, surface.gear, surface.pinion
    rotation = surface.direction * path.pinion_angle + surface.roll_zero + surface.phase
    if before is None:
        middle = np.array([path.pinion_angle.size // 2])
        exact = march(gear, pinion, assembly, rotation, start_at(surface, path, middle)[:, 0])
    else:
        exact = follow(gear, pinion, before, assembly, rotation)
    errors, distances = [], []

    def compare(at: NDArray[np.int64], other: Tangency) -> None:
        lag = other.gear_rotation - assembly.ratio * (rotation[at] - surface.phase)
        errors.append(np.abs(path.transmission_error[at] - surface.forward * lag).max(initial=0.0))
        distances.append(np.hypot(path.u[at] - other.gear_u, path.height[at] - other.gear_h).max(initial=0.0))

    free = np.flatnonzero(path.free & exact.found)
    compare(free, _result(gear, rotation[free], exact.parameters[:, free], exact.found[free]))
    edges = 0
    for kind in np.unique(path.edge[path.edge >= 0]):
        at = np.flatnonzero((path.edge == kind) & ~path.corner & path.settled)
        if EDGES[kind] == "pinion undercut" or not at.size:
            continue
        x, ok = touching(gear, pinion, assembly, rotation[at], start_at(surface, path, at), EDGES[kind])
        assert ok.all(), f"no contact of the {EDGES[kind]}"
        compare(at, _result(gear, rotation[at], x, ok))
        edges += at.size
    return PathCheck(float(max(errors)), float(max(distances)), free.size, edges, exact)
