"""A member as a ring of equal tooth cells: deflections of a loaded tooth and of its neighbours.

Each cell shares the functions on its left side with the previous cell. Its inner unknowns are condensed onto the two
sides. The ring of sides has a block-circulant stiffness, solved by the discrete Fourier transform over the teeth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve, cholesky, solve_triangular

from efficiency.ltca.ritz_solid import RitzSolid
from ehl.common.arrays import FloatArray, IntArray
from ehl.common.errors import ConvergenceError

REACH = 3
"""Teeth ahead of the loaded one whose deflection is kept."""


@dataclass(frozen=True)
class RingResponse:
    """Values of functionals of the displacement of a tooth under loads on one tooth."""

    own: FloatArray  # (k, m) value on the loaded tooth per unit load [m/N]
    ahead: tuple[FloatArray, ...]  # value on the next teeth in increasing azimuth [m/N]


def ring_response(solid: RitzSolid, pitch: float, cells: int, functionals: FloatArray, loads: int) -> RingResponse:
    """Solve a ring of cells, at least three, a pitch [rad] apart; `ConvergenceError` if the member is not held.

    `functionals` (k, 3 n): displacement at the points of interest, of all components of all functions. The first
    `loads` of them are also the places of unit forces in the direction of the displacement.
    """
    count, side = solid.count, 3 * solid.left.size

    def components(functions: IntArray) -> IntArray:
        return np.concatenate([functions + i * count for i in range(3)])

    border = np.concatenate([components(solid.left), components(solid.right)])
    body = np.union1d(*(solid.functions[part].number for part in ("foot", "slot")))
    # the tooth onto its root, then the body onto the sides
    part = _CondensedBody(np.arange(3 * count), solid.stiffness, functionals.T, np.zeros((len(functionals),) * 2))
    for kept in (components(body), border):
        part = part.condensed(kept)
    order = np.searchsorted(part.unknowns, border)
    stiffness, sides = part.stiffness[np.ix_(order, order)], part.functionals[order]
    # displacements on the right side, in the frame of the next cell
    frame = np.eye(2 * side)
    frame[side:, side:] = np.kron(rotation(pitch), np.eye(solid.left.size))
    seen = frame.T @ sides
    near = min(REACH, cells - 1)
    moved = ring_displacements(frame.T @ stiffness @ frame, seen[:, :loads], cells, near + 2)
    readings = [seen[:side].T @ moved[j] + seen[side:].T @ moved[j + 1] for j in range(near + 1)]
    return RingResponse(part.compliance[:, :loads] + readings[0], tuple(readings[1:]))


@dataclass(frozen=True)
class _CondensedBody:
    """A body condensed onto some unknowns: stiffness, functionals (columns), compliance of the eliminated unknowns."""

    unknowns: IntArray
    stiffness: FloatArray
    functionals: FloatArray
    compliance: FloatArray

    def condensed(self, kept: IntArray) -> _CondensedBody:
        """The same body on fewer unknowns (Schur complement)."""
        stays = np.isin(self.unknowns, kept)
        inner, outer = np.flatnonzero(~stays), np.flatnonzero(stays)
        scale = 1.0 / np.sqrt(np.diag(self.stiffness)[inner])
        matrix = self.stiffness[np.ix_(inner, inner)] * scale[:, None] * scale
        try:
            factor = cholesky(matrix, lower=True, overwrite_a=True, check_finite=False)
        except LinAlgError as error:
            raise ConvergenceError("tooth_not_held", "the stiffness of the tooth is not positive definite") from error
        coupling = self.stiffness[np.ix_(inner, outer)]
        # unknowns without coupling to the inside do not change
        touched = np.flatnonzero(coupling.any(axis=0))
        sides = np.concatenate([coupling[:, touched], self.functionals[inner]], axis=1)
        half = solve_triangular(factor, scale[:, None] * sides, lower=True, overwrite_b=True, check_finite=False)
        rest = half.T @ half
        size = touched.size
        stiffness, functionals = self.stiffness[np.ix_(outer, outer)], self.functionals[outer]
        stiffness[np.ix_(touched, touched)] -= rest[:size, :size]
        functionals[touched] -= rest[:size, size:]
        return _CondensedBody(self.unknowns[outer], stiffness, functionals, self.compliance + rest[size:, size:])


def rotation(angle: float) -> FloatArray:
    """Components in a frame from those in a frame rotated by an angle about z."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def ring_displacements(condensed: FloatArray, force: FloatArray, cells: int, count: int) -> FloatArray:
    """Displacements (count, side, loads) of the left sides of the loaded cell and of the following cells."""
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
            found = cho_solve(cho_factor(matrix, lower=True, check_finite=False), pull, check_finite=False)
        except LinAlgError as error:
            raise ConvergenceError("tooth_not_held", "the body of the member is not held") from error
        for j in range(count):
            moved[j] += share / cells * np.real(phase**j * found)
    return moved
