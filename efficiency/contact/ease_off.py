"""Ease-off: distance of the real pinion flank from the pinion flank conjugate to the real gear flank.

Every gear flank point contacts the conjugate pinion at its own roll angle. The ease-off is the distance from this point
to the real pinion flank along the common normal, positive if material is missing (relief). A pinion with zero ease-off
drives the gear at constant ratio.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.assembly import Assembly
from efficiency.cutting import newton
from efficiency.cutting.flank import Flank, FlankPoints
from efficiency.cutting.machine import turn
from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError


@dataclass(frozen=True)
class ConjugatePoints:
    """Points of the pinion flank conjugate to given gear points, in the frame of the pinion at zero rotation."""

    # (n,) gear rotation at contact [rad]; that of the pinion is ``gear_roll/ratio``
    gear_roll: FloatArray
    # (n,) derivative of the normal relative velocity by the pinion rotation [m/rad^2], see `Assembly.roll`
    rate: FloatArray
    # (3, n) points [m], and unit normals out of the gear tooth
    position: FloatArray
    normal: FloatArray


def conjugate_points(gear: FlankPoints, assembly: Assembly) -> ConjugatePoints:
    """Generate the pinion by the gear flank at constant ratio; `ConvergenceError` for gear points that never mesh."""
    f2, rate = assembly.roll(gear.position, gear.normal)
    if not np.isfinite(f2).all():
        raise ConvergenceError("no_mesh", f"{np.isnan(f2).sum()} gear points never contact the conjugate pinion")
    in_mesh = assembly.gear_in_mesh(gear.position, f2)
    position, normal = assembly.to_pinion(in_mesh, turn(gear.normal, f2), f2 / assembly.ratio)
    return ConjugatePoints(f2, rate, position, normal)


def pinion_phase(conjugate: ConjugatePoints, pinion: Flank, start: FloatArray | None = None) -> float:
    """Rotation of a real pinion flank about its axis [rad] for zero ease-off at one conjugate point (n = 1).

    `start` (3, 1): surface parameters of a pinion point nearby.
    """
    if start is None:
        points, ok = pinion.solve(*pinion.blank.place(conjugate.position))
    else:
        radius, z = np.hypot(conjugate.position[0], conjugate.position[1]), conjugate.position[2]
        parameters, ok = pinion.refine(radius, z, start)
        points = pinion.points(parameters)
    if not ok.all():
        raise ConvergenceError("flank", "the pinion flank does not reach the design point")
    there = np.arctan2(conjugate.position[1], conjugate.position[0])
    return float((there - points.azimuth)[0])


def ease_off(
    conjugate: ConjugatePoints, pinion: Flank, phase: float, start: FloatArray | None = None
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Ease-off of a real pinion flank, rotated by a phase [rad], at n conjugate points.

    `start` (3, n): surface parameters of pinion points nearby; default: from the blank coordinates.

    Returns: relief: distance along the normal [m], positive if material is missing; parameters: surface parameters of
    the real pinion points; found: whether the normal meets the real flank; otherwise the relief is meaningless
    (undercut).
    """
    position = turn(conjugate.position, -phase)
    normal = turn(conjugate.normal, -phase)
    if start is None:
        start = pinion.solve(*pinion.blank.place(position))[0].parameters
    x, found = meet_flank(pinion, position, normal, start, np.zeros(start.shape[1]))
    return x[3], x[:3], found


def meet_flank(
    flank: Flank,
    position: FloatArray,
    normal: FloatArray,
    start: FloatArray,
    distance: FloatArray,
    max_iterations: int = 30,
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Intersections of normals with a flank: surface parameters and distance along the normal (4, n), and found ones.

    start (3, n), distance (n,): starting values.
    """

    def linearised(y: FloatArray) -> tuple[FloatArray, FloatArray]:
        state, slope = flank.linearise(y[:3])
        value = np.concatenate([state[:3] - position - y[3] * normal, state[6:]])
        return value, bordered(slope, -normal)

    size = flank.blank.mean_cone_distance
    limit = np.array([0.05 * size, 0.1, 0.1, 0.02 * size])
    tolerance = 1e-10 * np.array([size, 1.0, 1.0, 0.01 * size])
    return newton.iterate(linearised, np.concatenate([start, distance[None]]), limit, tolerance, max_iterations)


def bordered(slope: FloatArray, normal: FloatArray) -> FloatArray:
    """Tangents of a surface and the gradient of its condition, bordered by a normal as last column, (n, 4, 4)."""
    border = np.concatenate([normal, np.zeros((1, normal.shape[1]))]).T[:, :, None]
    return np.concatenate([slope[:, [0, 1, 2, 6]], border], axis=2)


def relative_regularity(flank: Flank, parameters: FloatArray, found: NDArray[np.bool_]) -> FloatArray:
    """Regularity of the surface at parameters (3, n) relative to the last point, (n,); -1 where it was not found.

    The determinant of the tangents by the three parameters and the gradient of the condition, bordered by the normal:
    the surface element times that gradient. It vanishes on the edge of regression, the limit of undercut.
    """
    measure = np.full(found.shape, -1.0)
    state, slope = flank.linearise(parameters[:, found])
    measure[found] = np.linalg.det(bordered(slope, state[3:6]))
    measure[found] /= measure[-1]
    return measure
