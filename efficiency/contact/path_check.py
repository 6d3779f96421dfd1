"""How far the contact path from the ease-off lies from the direct tangency of the same flanks: its true error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from efficiency.contact.ease_off import conjugate_points, ease_off
from efficiency.contact.mesh_surface import MeshSurface
from efficiency.contact.tca import tangency
from efficiency.contact.transmission import contact_path


@dataclass(frozen=True)
class PathCheck:
    """Largest differences between both algorithms.

    Attributes
    ----------
    transmission_error : float
        Of the transmission error [rad].
    distance : float
        Of the contact point on the gear, in its blank coordinates [m].
    angles : int
        Pinion angles compared.
    """

    transmission_error: float
    distance: float
    angles: int


def check_path(surface: MeshSurface, reach: float = 0.5, angles: int = 7) -> PathCheck:
    """Compare the contact path of one tooth pair with direct tangency.

    Parameters
    ----------
    surface : MeshSurface
        Map of the mesh.
    reach : float
        Pinion pitches to both sides of the highest point.
    angles : int
        Pinion angles compared, an odd number.

    Returns
    -------
    PathCheck
        Over the angles where the contact does not run on the rim of the map.

    Raises
    ------
    ConvergenceError
        Direct tangency was not found.
    """
    assembly = surface.assembly
    angle = surface.crest_roll + np.linspace(-reach, reach, angles) * surface.pitch
    path = contact_path(surface, angle)
    middle = angles // 2
    on_gear, _ = surface.gear.solve(path.u[middle : middle + 1], path.height[middle : middle + 1])
    touching = conjugate_points(on_gear, assembly)
    _, on_pinion, _ = ease_off(touching, surface.pinion, surface.phase)
    start = np.concatenate([on_pinion[:, 0], on_gear.parameters[:, 0], touching.gear_roll])

    error = distance = 0.0
    compared: set[int] = set()
    for part in (np.arange(middle, angles), np.arange(middle, -1, -1)):
        part = part[np.logical_and.accumulate(path.free[part])]
        if part.size == 0:
            continue
        rotation = surface.direction * angle[part] + surface.roll_zero
        exact = tangency(surface.gear, surface.pinion, assembly, rotation + surface.phase, start)
        lag = exact.gear_rotation - assembly.ratio * rotation
        ahead = surface.direction * np.sign(assembly.ratio) * lag
        error = max(error, float(np.abs(path.transmission_error[part] - ahead).max()))
        off = np.hypot(path.u[part] - exact.gear_u, path.height[part] - exact.gear_h)
        distance = max(distance, float(off.max()))
        compared.update(part.tolist())
    return PathCheck(error, distance, len(compared))
