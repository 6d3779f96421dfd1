"""Direct tangency of two real flanks in space: the second algorithm behind the unloaded contact of the package.

At each pinion angle both flanks touch in one point with a common normal: three equations of position, two of the
normals and both conditions of the surfaces for the surface parameters of both points and the gear rotation. On an edge
one equation of the normals gives way to the edge, the other says that the edge lies in the tangent plane of the mating
flank. Newton's method, marched from angle to angle; no ease-off, no map, no interpolation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.blank.cones import Blank
from efficiency.contact.assembly import Assembly
from efficiency.contact.ease_off import conjugate_points, ease_off
from efficiency.contact.mesh_surface import EDGES, MeshSurface
from efficiency.contact.transmission import ContactPath
from efficiency.cutting import newton
from efficiency.cutting.flank import Flank
from efficiency.cutting.newton import Array
from ehl.errors import ConvergenceError

FloatArray = NDArray[np.float64]

_SUBSTEP = 0.02


@dataclass(frozen=True)
class Tangency:
    """Contact points of one tooth pair without load.

    Attributes
    ----------
    pinion_rotation, gear_rotation : (n,) arrays
        Rotations f1, f2 about the axes of the mesh frame [rad]; the pinion flank is taken as cut, without phase.
    parameters : (6, n) array
        Surface parameters of the pinion and the gear point.
    gear_u, gear_h : (n,) arrays
        Blank coordinates of the contact point on the gear [m].
    """

    pinion_rotation: FloatArray
    gear_rotation: FloatArray
    parameters: FloatArray
    gear_u: FloatArray
    gear_h: FloatArray


def _rotate(vector: Array, angle: Array | FloatArray) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2] + 0.0 * c])


def _cross(a: Array, b: Array) -> Array:
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


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


def tangency(
    gear: Flank, pinion: Flank, assembly: Assembly, rotation: FloatArray, start: FloatArray, edge: str = ""
) -> Tangency:
    """March the contact point through pinion rotations, each from the one before.

    Parameters
    ----------
    gear, pinion : Flank
        The two flanks.
    assembly : Assembly
        Their position, misalignments included.
    rotation : (n,) array
        Pinion rotations f1 [rad], the first one near `start`.
    start : (7,) array
        Surface parameters of the pinion and the gear point and gear rotation f2 to start from.
    edge : str
        Edge of one member, such as ``"pinion tip"``, that touches the flank of the other; empty for two flanks.

    Raises
    ------
    ConvergenceError
        No tangency was found at one of the rotations.
    """
    x = np.array(start, dtype=np.float64)[:, None]
    here, found = float(rotation[0]), []
    for target in rotation:
        # sub-steps: from one pitch to the next the contact moves farther than Newton's method forgives
        count = max(1, int(np.ceil(abs(target - here) / _SUBSTEP)))
        for f1 in here + (target - here) * np.arange(1, count + 1) / count:
            x[6] += assembly.ratio * (target - here) / count
            x, ok = _touch(gear, pinion, assembly, float(f1), x, edge)
            if not ok:
                raise ConvergenceError("tangency", f"no contact found at pinion rotation {f1:.4g} rad")
        here = float(target)
        found.append(x[:, 0].copy())
    result = np.stack(found, axis=1)
    point = np.real(gear.sweep(result[3:6])[0])
    u, h = gear.blank.coordinates(np.hypot(point[0], point[1]), point[2])
    return Tangency(rotation, result[6], result[:6], np.real(u), np.real(h))


def _touch(
    gear: Flank, pinion: Flank, assembly: Assembly, f1: float, x: FloatArray, edge: str
) -> tuple[FloatArray, bool]:
    """Contact at one pinion rotation from a start nearby, (7, 1)."""
    size = gear.blank.mean_cone_distance
    limit = np.array([0.05 * size, 0.05, 0.05, 0.05 * size, 0.05, 0.05, 0.02])
    tolerance = 1e-9 * np.array([size, 1.0, 1.0, size, 1.0, 1.0, 1.0])
    normal = np.real(_rotate(gear.sweep(x[3:6])[1], x[6]))[:, 0]
    first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    basis = np.stack([first, np.cross(normal, first)])
    turned = assembly.pinion_frame

    def residual(y: Array) -> Array:
        p, normal_p, condition_p = pinion.sweep(y[:3])
        g, normal_g, condition_g = gear.sweep(y[3:6])
        at = np.pi + f1 + 0.0 * y[6]
        gap = turned @ _rotate(p, at) + assembly.pinion_origin - _rotate(g, y[6])
        gap = gap - np.array([[0.0], [0.0], [assembly.G]])
        facing_p, facing_g = turned @ _rotate(normal_p, at), _rotate(normal_g, y[6])
        if not edge:
            rest = basis @ (facing_p + facing_g)
        elif edge.startswith("pinion"):
            off, gradient = _rim(pinion.blank, edge, p)
            along = turned @ _rotate(_cross(normal_p, gradient), at)
            rest = np.stack([off / size, np.sum(along * facing_g, axis=0)])
        else:
            off, gradient = _rim(gear.blank, edge, g)
            along = _rotate(_cross(normal_g, gradient), y[6])
            rest = np.stack([off / size, np.sum(along * facing_p, axis=0)])
        return np.concatenate([gap, rest, condition_p[None], condition_g[None]])

    x, ok = newton.solve(residual, x, limit, tolerance)
    return x, bool(ok.all())


@dataclass(frozen=True)
class PathCheck:
    """Largest differences between a contact path and direct tangency.

    Attributes
    ----------
    transmission_error : float
        Of the transmission error [rad].
    distance : float
        Of the contact point on the gear, in its blank coordinates [m].
    free, edge : int
        Pinion angles compared: two flanks, an edge and a flank.
    """

    transmission_error: float
    distance: float
    free: int
    edge: int


def check_path(surface: MeshSurface, path: ContactPath) -> PathCheck:
    """Compare a contact path of one tooth pair with direct tangency, run by run of the same kind of contact.

    Each run is marched through from its middle, which starts at the place that the path says; corners and the limit of
    undercut have no tangency and are left out.
    """
    assembly = surface.assembly
    kinds = np.where(path.settled & ~path.corner, path.edge, -2)
    cuts = np.flatnonzero(np.diff(kinds) != 0) + 1
    error = distance = 0.0
    compared = {True: 0, False: 0}
    for run in np.split(np.arange(kinds.size), cuts):
        kind = int(kinds[run[0]])
        if kind == -2 or (kind >= 0 and EDGES[kind] == "pinion undercut"):
            continue
        middle = run.size // 2
        at = run[middle : middle + 1]
        on_gear, _ = surface.gear.solve(path.u[at], path.height[at])
        touching = conjugate_points(on_gear, assembly)
        _, on_pinion, _ = ease_off(touching, surface.pinion, surface.phase)
        shift = surface.direction * path.pinion_angle[at] + surface.roll_zero - touching.gear_roll / assembly.ratio
        start = np.concatenate([on_pinion[:, 0], on_gear.parameters[:, 0], touching.gear_roll + assembly.ratio * shift])
        for part in (run[middle:], run[middle::-1]):
            rotation = surface.direction * path.pinion_angle[part] + surface.roll_zero
            exact = tangency(
                surface.gear, surface.pinion, assembly, rotation + surface.phase, start, "" if kind < 0 else EDGES[kind]
            )
            lag = exact.gear_rotation - assembly.ratio * rotation
            error = max(error, float(np.abs(path.transmission_error[part] - surface.forward * lag).max()))
            off = np.hypot(path.u[part] - exact.gear_u, path.height[part] - exact.gear_h)
            distance = max(distance, float(off.max()))
        compared[kind < 0] += run.size
    return PathCheck(error, distance, compared[True], compared[False])
