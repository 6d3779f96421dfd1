"""Direct tangency of the two real flanks in space: the independent second algorithm behind the ease-off.

At each pinion angle both flanks touch in one point with a common normal. Unknown are the three cutting parameters of
each flank and the gear rotation; equations are three of position, two of the normals and both equations of meshing.
Flanks are continued beyond their blanks; tips, edges and undercut are not seen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.assembly import Assembly
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
        Cutting parameters of the pinion and the gear point.
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


def tangency(gear: Flank, pinion: Flank, assembly: Assembly, rotation: FloatArray, start: FloatArray) -> Tangency:
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
        Pinion (s, th, phi), gear (s, th, phi) and gear rotation f2 to start from.

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
            x, ok = _touch(gear, pinion, assembly, float(f1), x)
            if not ok:
                raise ConvergenceError("tangency", f"no common normal found at pinion rotation {f1:.4g} rad")
        here = float(target)
        found.append(x[:, 0].copy())
    result = np.stack(found, axis=1)
    point = np.real(gear.sweep(result[3:6])[0])
    u, h = gear.blank.coordinates(np.hypot(point[0], point[1]), point[2])
    return Tangency(rotation, result[6], result[:6], np.real(u), np.real(h))


def _touch(gear: Flank, pinion: Flank, assembly: Assembly, f1: float, x: FloatArray) -> tuple[FloatArray, bool]:
    """Tangency at one pinion rotation from a start nearby, (7, 1)."""
    size = gear.blank.mean_cone_distance
    limit = np.array([0.05 * size, 0.05, 0.05, 0.05 * size, 0.05, 0.05, 0.02])
    tolerance = 1e-9 * np.array([size, 1.0, 1.0, size, 1.0, 1.0, 1.0])
    normal = np.real(_rotate(gear.sweep(x[3:6])[1], x[6]))[:, 0]
    first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    basis = np.stack([first, np.cross(normal, first)])
    turned = assembly.pinion_frame

    def residual(y: Array) -> Array:
        p, normal_p, meshing_p = pinion.sweep(y[:3])
        g, normal_g, meshing_g = gear.sweep(y[3:6])
        at = np.pi + f1 + 0.0 * y[6]
        gap = turned @ _rotate(p, at) + assembly.pinion_origin - _rotate(g, y[6])
        gap = gap - np.array([[0.0], [0.0], [assembly.G]])
        tilt = basis @ (turned @ _rotate(normal_p, at) + _rotate(normal_g, y[6]))
        return np.concatenate([gap, tilt, meshing_p[None], meshing_g[None]])

    x, ok = newton.solve(residual, x, limit, tolerance)
    return x, bool(ok.all())
