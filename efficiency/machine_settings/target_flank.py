"""Target of a pinion flank: ease-off over its conjugate points, root line, backlash."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.conjugate import read_ease_off_map
from efficiency.cutting.rotation import dot, spin, turn
from efficiency.machine_settings.conjugate import ConjugateFlankStart
from efficiency.machine_settings.fit import RootLine, TargetFlank
from efficiency.machine_settings.free_settings import free_axis
from efficiency.machine_settings.gear import PairDimensions
from efficiency.machine_settings.inputs import FlankTarget

FloatArray = NDArray[np.float64]

_STATIONS = np.array([-0.5, 0.0, 0.5])


def target_flank(
    pair: PairDimensions, start: ConjugateFlankStart, relief: FloatArray, root_weight: float, thinning: float = 0.0
) -> TargetFlank:
    """A flank to be fitted, from its conjugate start.

    Parameters
    ----------
    relief : (n,) array
        Ease-off at the points of the grid [m].
    root_weight : float
        Residual per root error; 0: the root is left alone and only measured.
    thinning : float
        Angle by which the flank is to stand back from contact [rad].
    """
    flank, parameters = free_axis(start.flank, start.parameters)
    conjugate = start.points
    phase = start.phase
    if thinning:
        point, facing, _ = flank.sweep(parameters)
        spun = spin(np.real(point))
        rate = np.median(dot(np.real(facing), spun) / dot(np.real(facing), turn(conjugate.normal, -phase)))
        phase -= float(np.sign(rate)) * thinning
    root: RootLine | None = root_line(pair, conjugate.position, parameters, root_weight)
    if root is not None and not np.isfinite(root.cut(flank).error).all():
        root = None
    return TargetFlank(flank, phase, conjugate.position, conjugate.normal, relief, parameters, root)


def root_line(pair: PairDimensions, position: FloatArray, parameters: FloatArray, weight: float) -> RootLine:
    """The blank's root at toe, middle and heel of the pinion; the nearest flank points are where the search starts."""
    blank = pair.pinion
    u, h = blank.coordinates(np.hypot(position[0], position[1]), position[2])
    stations = _STATIONS * blank.face_width
    nearest = [int(np.argmin((u - at) ** 2 + (h - blank.root(np.array([at]))[0]) ** 2)) for at in stations]
    return RootLine(stations, blank.root(stations), weight, parameters[1:, nearest])


def backlash_angle(pair: PairDimensions) -> float:
    """Angle of each pinion flank that gives the pair its backlash [rad]."""
    radius, _ = pair.pinion.axial(np.array([pair.calculation_pinion]), np.zeros(1))
    return 0.5 * pair.backlash / float(radius[0] * np.cos(pair.spiral_pinion))


def target_relief(target: FlankTarget, x: FloatArray, y: FloatArray) -> FloatArray:
    """Relief [m] at places on the face (-1 toe, 1 heel) and the working depth (-1 root, 1 tip of the gear).

    With ``X = x - contact_face - bias (y - contact_depth)`` and ``Y = y - contact_depth`` it is
    ``(heel + toe)/2 X^2 + (heel - toe)/2 X^3 + (tip + root)/2 Y^2 + (tip - root)/2 Y^3 + twist (x - contact_face) Y``:
    smooth, and the amounts of the targets at the ends of both axes for a contact in the middle. A map is added.
    """
    across = y - target.contact_depth
    along = x - target.contact_face - target.bias * across
    lengthwise = _ends(along, target.crowning_toe, target.crowning_heel)
    relief = (
        lengthwise
        + _ends(across, target.relief_root, target.relief_tip)
        + target.twist * (x - target.contact_face) * across
    )
    return relief if target.map is None else relief + read_ease_off_map(Path(target.map))(x, y)


def _ends(x: FloatArray, low: float, high: float) -> FloatArray:
    return np.asarray((0.5 * (high + low) + 0.5 * (high - low) * x) * x * x)
