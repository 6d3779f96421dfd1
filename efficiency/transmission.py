"""Unloaded transmission error and contact path from the ease-off: the lower envelope over all points of the flank.

At pinion angle psi a gear point with roll angle phi and ease-off e keeps the distance ``e + M (phi - psi)^2/2`` from the
pinion, where M follows from the relative curvature of the conjugate flanks normal to their line of contact. The gear
turns back by the smallest of these distances over their lever; where it is smallest is the contact point. Without the
second term the contact would stay on the conjugate line, to first order in the slope of the ease-off.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.mesh_surface import MeshSurface
from ehl.errors import ConvergenceError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class ContactPath:
    """Contact of one tooth pair without load; the flanks are continued beyond their blanks.

    Attributes
    ----------
    pinion_angle : (n,) array
        Roll of the pinion from the design point in driving direction [rad].
    transmission_error : (n,) array
        Gear rotation ahead of its place at constant ratio [rad]; zero at the highest point of the curve.
    u : (n,) array
        Distance of the contact point from the gear's mean point along its pitch cone [m].
    v : (n,) array
        Its fraction of the gear's whole depth.
    height : (n,) array
        Its height over the gear's pitch cone [m].
    """

    pinion_angle: FloatArray
    transmission_error: FloatArray
    u: FloatArray
    v: FloatArray
    height: FloatArray


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

    Raises
    ------
    ConvergenceError
        The contact leaves the mapped part of the flank (edge contact) at one of the angles.
    """
    (u0, u1), (v0, v1) = surface.patch.u_range, surface.patch.v_range
    grid_u, grid_v = (g.ravel() for g in np.meshgrid(np.linspace(u0, u1, 61), np.linspace(v0, v1, 41)))
    e, m, phi = surface.patch(grid_u, grid_v, ("turn_back", "bend", "roll"))
    lowest = np.argmin(e + 0.5 * m * (phi - angle[:, None]) ** 2, axis=1)
    u, v = grid_u[lowest], grid_v[lowest]
    limit_u, limit_v = 0.1 * (u1 - u0), 0.1 * (v1 - v0)
    step = np.inf
    for _ in range(30):
        _, gu, gv, huu, huv, hvv = _envelope(surface, angle, u, v)
        determinant = huu * hvv - huv * huv
        du = np.clip((hvv * gu - huv * gv) / determinant, -limit_u, limit_u)
        dv = np.clip((huu * gv - huv * gu) / determinant, -limit_v, limit_v)
        u, v = np.clip(u - du, u0, u1), np.clip(v - dv, v0, v1)
        step = float(np.max(np.abs(du) / (u1 - u0) + np.abs(dv) / (v1 - v0)))
        if step < 1e-10:
            break
    if step >= 1e-6:
        raise ConvergenceError("edge_contact", "the unloaded contact point leaves the tooth; widen the range of relief")
    value = _envelope(surface, angle, u, v)[0]
    return ContactPath(angle, -value, u, v, surface.height(u, v))
