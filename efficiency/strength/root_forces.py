"""Force and moment that pass from a tooth to its body, along the face, under loads on its flank.

The solid tooth of `efficiency.ltca.solid_tooth` is cut off at the lower end of its tooth block. What the block's
stiffness times its displacement leaves on the functions of that cut is the work of the tractions there on these
functions: constant and linear across the tooth, Legendre polynomials along the face. These sums are far more accurate
than stresses of the same solution, and forces and moments of the whole tooth are in balance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.tooth_grid import ToothGrid
from efficiency.ltca.rim_compliance import ring_response
from efficiency.ltca.ritz_solid import ORDERS, ritz_solid
from efficiency.ltca.solid_tooth import SolidTooth, flank_loading
from efficiency.ltca.tooth_cell import ToothCell, lagrange_values, legendre_polynomials

FloatArray = NDArray[np.float64]

_NEAR = 1e-3


@dataclass(frozen=True)
class RootFrames:
    """Frames of the root section at stations along the face; s stations."""

    place: FloatArray  # (s,) c of the tooth cell, 0 at the toe and 1 at the heel
    origin: FloatArray  # (s, 3) middle of the cut [m]
    # along, across, up: (s, 3) unit vectors along the trace to the heel, across the tooth to the upper flank, and out
    # to the tip
    along: FloatArray
    across: FloatArray
    up: FloatArray
    rate: FloatArray  # (s,) length of trace per unit of c [m]
    half: FloatArray  # (s,) half of the thickness at the cut, along `across` [m]
    # (s,) how far the upper end of the cut lies ahead of its middle, in c: the cut goes along a cone square to the
    # pitch cone, the section stands square to the trace
    oblique: FloatArray

    def section(self, station: int, points: FloatArray) -> FloatArray:
        """Points (n, 3) seen along the trace: across and up from the middle of the cut (n, 2) [m]."""
        away = points - self.origin[station]
        return np.stack([away @ self.across[station], away @ self.up[station]], axis=-1)


@dataclass(frozen=True)
class RootForces:
    """What unit normal forces on the flank send through the root, per length of trace."""

    cell: ToothCell  # geometry
    grid: ToothGrid  # its flanks
    frames: RootFrames  # stations
    nodes: tuple[FloatArray, FloatArray]  # nodes of the flank over the height and along the face
    # (3, s, n) shear force across [1/m], force towards the body [1/m] and bending moment that pulls at the loaded side
    # [-], per unit force at each node
    response: FloatArray
    side: float  # 1 where the loaded flank is the upper one, -1 where it is the lower one

    def of(self, face: FloatArray, height: FloatArray, force: FloatArray) -> FloatArray:
        """Resultants (3, s) of forces (n,) [N] at distances from the toe and over the root cone [m]."""
        b, c = self.cell.on_flank(face, height)
        over, along = (lagrange_values(nodes, x) for nodes, x in zip(self.nodes, (b, c), strict=True))
        shape = (over[:, :, None] * along[:, None, :]).reshape(b.size, -1)
        return np.asarray(self.response @ (force @ shape))


def root_frames(cell: ToothCell, place: FloatArray) -> RootFrames:
    """Frames at places c of the cell."""

    def cut(at: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        zero = np.zeros_like(at)
        left, right = (cell.tooth.place(np.full_like(at, a), zero, at)[0] for a in (0.0, 1.0))
        tip = cell.tooth.place(np.full_like(at, 0.5), np.ones_like(at), at)[0]
        return left, right, tip

    left, right, tip = cut(place)
    ends = [np.clip(place + step, 0.0, 1.0) for step in (-_NEAR, _NEAR)]
    behind, ahead = (0.5 * (a + b) for a, b, _ in map(cut, ends))
    trace = (ahead - behind) / (ends[1] - ends[0])[:, None]
    rate = np.linalg.norm(trace, axis=1)
    along, middle = trace / rate[:, None], 0.5 * (left + right)

    def square(vector: FloatArray) -> FloatArray:
        vector = vector - np.sum(vector * along, axis=1)[:, None] * along
        return np.asarray(vector / np.linalg.norm(vector, axis=1)[:, None])

    across = square(right - left)
    up = np.cross(along, across)
    up = up * np.sign(np.sum(up * (tip - middle), axis=1))[:, None]
    half = 0.5 * np.sum((right - left) * across, axis=1)
    oblique = 0.5 * np.sum((right - left) * along, axis=1) / rate
    return RootFrames(place, middle, along, across, up, rate, half, oblique)


def root_forces(tooth: SolidTooth, place: FloatArray, cells: int | None = None) -> RootForces:
    """Resultants through the root of a solid tooth at stations c of the face (0 at the toe, 1 at the heel).

    `cells` as in `efficiency.ltca.solid_tooth.solid_tooth`.
    """
    cell, body = tooth.cell, tooth.body
    solid = ritz_solid(cell, body.moduli, body.material.poisson_ratio, body.held, ORDERS)
    functions, upper = solid.functions["tooth"], tooth.side == 1.0
    b, _, _, _, loading = flank_loading(cell, solid, tooth.side, tooth.nodes)
    # functions of the cut, linear across: at the left end, at the right end
    degrees, count = functions.degrees, int(functions.degrees[:, 2].max()) + 1
    cut = np.zeros((2, count), np.int64)
    for index in np.flatnonzero((degrees[:, 0] < 2) & (degrees[:, 1] == 0)):
        cut[degrees[index, 0], degrees[index, 2]] = index
    stiffness = functions.stiffness(body.material.youngs_modulus, body.material.poisson_ratio)[:, cut.ravel()]
    rows = np.zeros((3, cut.size, 3, solid.count))
    rows[..., functions.number] = stiffness
    components = rows.reshape(3 * cut.size, -1)
    response = ring_response(solid, cell.pitch, cells or cell.teeth, np.concatenate([loading, components]), b.size)
    loads = loading.reshape(b.size, 3, -1)[:, :, functions.number[cut.ravel()]]
    inner = response.own[b.size :].reshape(3, cut.size, b.size) - np.moveaxis(loads, 0, -1)
    # what the body does to the tooth, per unit of c: its sum, and its first moment across
    ends = inner.reshape(3, 2, count, b.size)
    frames = root_frames(cell, place)

    degree = np.arange(count)
    # factors of Lanczos keep the last of them from rippling
    weights = (2.0 * degree + 1.0) * np.sinc(degree / count)

    def at_ends(share: float) -> tuple[FloatArray, FloatArray]:
        """Lower and upper end at the section: what grows towards an end acts at a share of the way to it."""
        found = []
        for end, way in enumerate((share, -share)):
            at = np.clip(place + way * frames.oblique, 0.0, 1.0)
            series = legendre_polynomials(count - 1, at)[0] * weights
            found.append(np.asarray(np.einsum("sk,xkn->snx", series, ends[:, end])))
        return found[0], found[1]

    # an even traction times 1 - a or a acts at a third of the way from the middle, bending at the ends
    total, (low, high) = sum(at_ends(1.0 / 3.0)), at_ends(1.0)
    sign = 1.0 if upper else -1.0
    across, up = (np.einsum("snx,sx->sn", total, v) for v in (frames.across, frames.up))
    moment = frames.half[:, None] * np.einsum("snx,sx->sn", high - low, frames.up)
    per_length = 1.0 / frames.rate[:, None]
    # the body pulls the loaded side down (up < 0) and holds against the force
    resultants = np.stack([sign * across, up, -sign * moment]) * per_length
    return RootForces(cell, tooth.grid, frames, tooth.nodes, resultants, sign)
