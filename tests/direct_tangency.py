"""Direct tangency of two real flanks in space: the second algorithm behind the unloaded contact of the package.

At each pinion angle both flanks touch in one point with a common normal: three equations of position, two of the
normals and both conditions of the surfaces for the surface parameters of both points and the gear rotation. On an edge
one equation of the normals gives way to the edge, the other says that the edge lies in the tangent plane of the mating
flank. Newton's method from the place that the path says; no ease-off, no map, no interpolation.
"""

import numpy as np

from efficiency.contact.contact_search import ContactPath
from efficiency.contact.ease_off import conjugate_points, ease_off
from efficiency.contact.mesh_surface import EDGES, MeshSurface
from efficiency.cutting import newton
from efficiency.cutting.blank import Blank
from efficiency.cutting.machine import cross, turn
from efficiency.cutting.newton import Array
from ehl.common.arrays import FloatArray, IntArray


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


def touching(surface: MeshSurface, f1: FloatArray, x: FloatArray, edge: str = "") -> FloatArray:
    """Contact at pinion rotations f1 (n,) from starts nearby (7, n).

    `edge`, such as ``"pinion tip"``, is the edge of one member that touches the flank of the other; empty: two flanks.
    """
    gear, pinion, assembly = surface.gear, surface.pinion, surface.assembly
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

    found, there = newton.iterate(lambda x: newton.complex_jacobian(residual, x), x, limit, tolerance, 15)
    assert there.all(), f"no contact of {edge or 'the flanks'}"
    return found


def start_at(surface: MeshSurface, path: ContactPath, at: IntArray) -> FloatArray:
    """Starts for Newton's method near points of a contact path, (7, n)."""
    on_gear, _ = surface.gear.solve(path.u[at], path.height[at])
    conjugate = conjugate_points(on_gear, surface.assembly)
    _, on_pinion, _ = ease_off(conjugate, surface.pinion, surface.phase)
    turned = surface.assembly.ratio * (surface.direction * path.pinion_angle[at] + surface.roll_zero)
    return np.concatenate([on_pinion, on_gear.parameters, turned[None]])


def check_path(surface: MeshSurface, path: ContactPath) -> tuple[float, float, int, int]:
    """Largest differences between a contact path of one tooth pair and direct tangency.

    Of the transmission error [rad] and the contact point in the blank coordinates of the gear [m]; numbers of pinion
    angles compared: two flanks, an edge and a flank. Corners and the limit of undercut have no tangency.
    """
    rotation = surface.direction * path.pinion_angle + surface.roll_zero + surface.phase
    errors, distances, edges = [], [], 0
    for kind in np.unique(path.edge):
        name = EDGES[kind] if kind >= 0 else ""
        at = np.flatnonzero((path.edge == kind) & ~path.corner & path.settled if name else path.free)
        if name == "pinion undercut" or not at.size:
            continue
        x = touching(surface, rotation[at], start_at(surface, path, at), name)
        lag = x[6] - surface.assembly.ratio * (rotation[at] - surface.phase)
        errors.append(np.abs(path.transmission_error[at] - surface.forward * lag).max())
        point = np.real(surface.gear.sweep(x[3:6])[0])
        u, h = np.real(surface.gear.blank.coordinates(np.hypot(point[0], point[1]), point[2]))
        distances.append(np.hypot(path.u[at] - u, path.height[at] - h).max())
        edges += at.size if name else 0
    return float(max(errors)), float(max(distances)), int(path.free.sum()), edges
