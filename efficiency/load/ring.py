"""A member as a ring of equal tooth cells: deflections of a tooth and of its neighbours under loads on it.

Each cell shares the functions on its left side with the cell before. What happens inside is condensed onto the two
sides; the ring of sides has a block-circulant stiffness, solved by the discrete Fourier transform over the teeth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from efficiency.load.ritz_solid import RitzSolid
from efficiency.load.shape_functions import FloatArray
from ehl.errors import ConvergenceError

IntArray = NDArray[np.int64]


REACH = 3
"""Teeth ahead of the loaded one whose deflection is kept."""


@dataclass(frozen=True)
class RingResponse:
    """What functionals of the displacement of a tooth read under loads on one tooth.

    Attributes
    ----------
    own : (k, m) array
        Reading on the loaded tooth per unit load [m/N].
    ahead : tuple of (k, m) arrays
        Reading on the next teeth in rising azimuth [m/N].
    """

    own: FloatArray
    ahead: tuple[FloatArray, ...]


def ring_response(solid: RitzSolid, pitch: float, cells: int, reading: FloatArray, loading: FloatArray) -> RingResponse:
    """Solve the ring.

    Parameters
    ----------
    solid : RitzSolid
        Of one cell, in its own frame.
    pitch : float
        Angle from one cell to the next [rad].
    cells : int
        Cells in the ring, at least three.
    reading : (k, 3 n) array
        Displacement at the points of interest as functionals of all components of all functions.
    loading : (m, 3 n) array
        Forces, each as the displacement it works on.

    Raises
    ------
    ConvergenceError
        The member is not held.
    """
    count = solid.count
    side = 3 * solid.left.size

    def components(functions: IntArray) -> IntArray:
        return np.concatenate([functions + i * count for i in range(3)])

    left, right = components(solid.left), components(solid.right)
    inner = np.setdiff1d(np.arange(3 * count), np.concatenate([left, right]))
    # displacements on the right side, in the frame of the next cell
    turn = np.kron(_rotation(pitch), np.eye(solid.left.size))
    border = np.concatenate([left, right])
    frame = np.eye(2 * side)
    frame[side:, side:] = turn

    stiffness = solid.stiffness
    scale = 1.0 / np.sqrt(np.diag(stiffness)[inner])
    try:
        factor = cho_factor(stiffness[np.ix_(inner, inner)] * scale[:, None] * scale, lower=True, check_finite=False)
    except LinAlgError as error:
        raise ConvergenceError("tooth_not_held", "the stiffness of the tooth is not positive definite") from error
    coupling = stiffness[np.ix_(inner, border)]
    right_sides = np.concatenate([coupling, loading[:, inner].T], axis=1)
    solved = scale[:, None] * cho_solve(factor, scale[:, None] * right_sides, check_finite=False)
    by_border, by_load = solved[:, : border.size], solved[:, border.size :]
    condensed = frame.T @ (stiffness[np.ix_(border, border)] - coupling.T @ by_border) @ frame
    force = frame.T @ (loading[:, border].T - coupling.T @ by_load)
    seen = (reading[:, border] - reading[:, inner] @ by_border) @ frame

    near = min(REACH, cells - 1)
    moved = _around(condensed, force, cells, near + 2)
    readings = [seen[:, :side] @ moved[j] + seen[:, side:] @ moved[j + 1] for j in range(near + 1)]
    return RingResponse(reading[:, inner] @ by_load + readings[0], tuple(readings[1:]))


def _rotation(angle: float) -> FloatArray:
    """Components in a frame from those in the frame turned by an angle about z."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _around(condensed: FloatArray, force: FloatArray, cells: int, count: int) -> FloatArray:
    """Displacements (count, side, loads) of the left sides of the loaded cell and of those behind it."""
    side = condensed.shape[0] // 2
    ll, lr, rr = condensed[:side, :side], condensed[:side, side:], condensed[side:, side:]
    moved = np.zeros((count, side, force.shape[1]))
    # harmonics k and cells - k are conjugate
    for k in range(cells // 2 + 1):
        phase = np.exp(2j * np.pi * k / cells)
        matrix = ll + rr + lr * phase + lr.T / phase
        pull = force[:side] + force[side:] / phase
        if k == 0 or 2 * k == cells:
            matrix, pull, share = np.real(matrix), np.real(pull), 1.0
        else:
            share = 2.0
        try:
            answer = cho_solve(cho_factor(matrix, lower=True, check_finite=False), pull, check_finite=False)
        except LinAlgError as error:
            raise ConvergenceError("tooth_not_held", "the body of the member is not held") from error
        for j in range(count):
            moved[j] += share / cells * np.real(phase**j * answer)
    return moved
