"""Unloaded transmission error and contact path from the ease-off: the lower envelope over all points of the flank.

At pinion angle psi a point of the real pinion flank with roll angle phi and ease-off e keeps the distance
``e + M (phi - psi)^2/2`` from the gear, where M follows from the relative curvature of the conjugate flanks normal to
their line of contact. The gear turns back by the smallest of these distances over their lever; where it is smallest is
the contact point. It lies beside the conjugate line by the slope of the ease-off times the equivalent radius; both the
place on the pinion and the one on the gear then differ from the conjugate pair of points, to first order in the
sliding in between.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.assembly import dot, turn
from efficiency.contact.mesh_surface import POSITION, MeshSurface

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class ContactPath:
    """Contact of one tooth pair without load; the flanks are continued a little beyond their blanks.

    Attributes
    ----------
    pinion_angle : (n,) array
        Roll of the pinion from the design point in driving direction [rad].
    transmission_error : (n,) array
        Gear rotation ahead of its place at constant ratio [rad]; zero at the highest point of the curve.
    u, height : (n,) arrays
        Contact point on the gear: distance from its mean point along the pitch cone, height over that cone [m].
    free : (n,) bool array
        False where the contact runs on the rim of the mapped flank (edge contact); the place is then approximate.
    """

    pinion_angle: FloatArray
    transmission_error: FloatArray
    u: FloatArray
    height: FloatArray
    free: NDArray[np.bool_]


def _envelope(surface: MeshSurface, angle: FloatArray, u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
    """Value, gradient and Hessian of the turning back of the gear at points (u, v)."""
    names = ("turn_back", "bend", "roll")
    p = surface.patch
    e, m, phi = p(u, v, names)
    eu, mu, pu = p(u, v, names, du=1)
    ev, mv, pv = p(u, v, names, dv=1)
    euu, muu, puu = p(u, v, names, du=2)
    euv, muv, puv = p(u, v, names, du=1, dv=1)
    evv, mvv, pvv = p(u, v, names, dv=2)
    d = phi - angle
    half = 0.5 * d * d
    value = e + half * m
    gu, gv = eu + half * mu + m * d * pu, ev + half * mv + m * d * pv
    huu = euu + half * muu + d * (2.0 * mu * pu + m * puu) + m * pu * pu
    hvv = evv + half * mvv + d * (2.0 * mv * pv + m * pvv) + m * pv * pv
    huv = euv + half * muv + d * (mu * pv + mv * pu + m * puv) + m * pu * pv
    return value, gu, gv, huu, huv, hvv


def contact_path(surface: MeshSurface, angle: FloatArray) -> ContactPath:
    """Contact point and transmission error of one tooth pair at pinion angles.

    Parameters
    ----------
    surface : MeshSurface
        Map of the mesh.
    angle : (n,) array
        Pinion angles from the design point, driving direction [rad].
    """
    (u0, u1), (v0, v1) = surface.patch.u_range, surface.patch.v_range
    grid_u, grid_v = (g.ravel() for g in np.meshgrid(np.linspace(u0, u1, 61), np.linspace(v0, v1, 41)))
    e, m, phi = surface.patch(grid_u, grid_v, ("turn_back", "bend", "roll"))
    lowest = np.argmin(e + 0.5 * m * (phi - angle[:, None]) ** 2, axis=1)
    u, v = grid_u[lowest], grid_v[lowest]
    step = np.full(angle.shape, np.inf)
    for _ in range(30):
        _, gu, gv, huu, huv, hvv = _envelope(surface, angle, u, v)
        determinant = huu * hvv - huv * huv
        du = np.clip((hvv * gu - huv * gv) / determinant, -0.1 * (u1 - u0), 0.1 * (u1 - u0))
        dv = np.clip((huu * gv - huv * gu) / determinant, -0.1 * (v1 - v0), 0.1 * (v1 - v0))
        u, v = np.clip(u - du, u0, u1), np.clip(v - dv, v0, v1)
        step = np.abs(du) / (u1 - u0) + np.abs(dv) / (v1 - v0)
        if np.max(step) < 1e-11:
            break
    free = step < 1e-8
    u, v = np.where(free, u, grid_u[lowest]), np.where(free, v, grid_v[lowest])
    error = -_envelope(surface, angle, u, v)[0]
    u, v = _on_gear(surface, angle, error, u, v)
    return ContactPath(angle, error, u, surface.height(u, v), free)


def _on_gear(
    surface: MeshSurface, angle: FloatArray, error: FloatArray, u: FloatArray, v: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Gear point that faces the pinion point conjugate to (u, v), after the sliding between both moments.

    To first order: the pinion point has slid over the gear since it was in conjugate contact, and the gear has turned
    back under it.
    """
    p = surface.patch
    position, (roll,) = p(u, v, POSITION), p(u, v, ("roll",))
    f2 = (surface.direction * roll + surface.roll_zero) * surface.assembly.ratio
    in_mesh = surface.assembly.gear_in_mesh(position, f2)
    sliding = turn(surface.direction * surface.assembly.sliding(in_mesh), -f2)
    ahead = error * np.sign(surface.direction * surface.assembly.ratio)
    spin = np.stack([-position[1], position[0], np.zeros_like(u)])
    shift = sliding * (angle - roll) - ahead * spin
    ru, rv = p(u, v, POSITION, du=1), p(u, v, POSITION, dv=1)
    e, f, g = dot(ru, ru), dot(ru, rv), dot(rv, rv)
    a, b = dot(ru, shift), dot(rv, shift)
    area = e * g - f * f
    return u + (g * a - f * b) / area, v + (e * b - f * a) / area
