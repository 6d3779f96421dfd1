"""Stress at the root fillets of a tooth section per unit force and moment through its root: plane strain.

Quadratic finite elements on a mesh that follows the outline: each row runs from a point of one flank, fillet or root
to the same point of the other side, square to both, so that rows lie like the skins of an onion round the root. The
stress along the free surface follows from the strain along it, at the points where quadratic elements have it best.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csc_matrix
from scipy.sparse.linalg import splu

from ehl.common.errors import ConvergenceError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# tuned: elements along flank, fillet and root, and across (ours); may be changed by whoever runs
# `test_root_stress_of_a_straight_tooth`
_FLANK, _FILLET, _LAND, _ACROSS = 8, 14, 8, 14
# tuned: how far the root goes on, in half thicknesses of the tooth, the rest of the body is rigid (ours); may be
# raised freely
_WIDTH = 4.0
# tuned: length of the end tangents of a row over its chord, from the tip to the fillets and along the root, so that
# rows do not cross (ours); may be changed by whoever solves all shipped designs
_BULGE = 0.4, 1.6
_SMOOTHINGS = 6
_GAUSS = 1.0 / np.sqrt(3.0)


@dataclass(frozen=True)
class Outline:
    """One side of a tooth section, tip to root, across (away from the tooth) and up from the middle [m]."""

    flank: FloatArray  # (n, 2) from the tip to where the fillet begins
    fillet: FloatArray  # (m, 2) from there to the root, where it runs across


@dataclass(frozen=True)
class RootSection:
    """Stress along the fillets of a section, from flank to root."""

    # loaded, far: (3, p) stress along the surface on the loaded and on the other side per unit shear force across
    # [1/m], force towards the body [1/m] and moment that pulls at the loaded side [1/m2], each per length of the tooth
    loaded: FloatArray
    far: FloatArray
    place_loaded: FloatArray  # (p, 2) where, across and up from the middle of the cut [m]


def arc_outline(flank: FloatArray, root: float, radius: float) -> Outline:
    """Outline of a flank (n, 2), tip first, that goes over into a level root by an arc [m].

    `ConvergenceError` where the flank stays away from the root, or the arc does not fit.
    """
    # straight on below its last point
    slope = flank[-1] - flank[-2]
    ahead = flank[-1] + slope / np.linalg.norm(slope) * np.linspace(0.0, 3.0, 13)[1:, None] * radius
    line = np.concatenate([flank, ahead])
    fine = np.linspace(0.0, 1.0, 40)[:-1]
    line = np.concatenate([*(a + fine[:, None] * (b - a) for a, b in pairwise(line)), line[-1:]])
    centres = line + radius * _outwards(line)
    above = centres[:, 1] - (root + radius)
    found = np.flatnonzero((above[:-1] > 0.0) & (above[1:] <= 0.0))
    if not found.size:
        raise ConvergenceError("no_fillet", f"no fillet of radius {radius * 1e3:.3g} mm fits between flank and root")
    k = int(found[0])
    share = above[k] / (above[k] - above[k + 1])
    centre, touch = (x[k] + share * (x[k + 1] - x[k]) for x in (centres, line))
    start = np.arctan2(*(touch - centre)[::-1]) % (2.0 * np.pi)
    angle = np.linspace(start, 1.5 * np.pi, 41)
    fillet = centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    above_touch = flank[flank[:, 1] > touch[1]]
    return Outline(np.concatenate([above_touch, touch[None]]), fillet)


def solve_section(loaded: Outline, far: Outline, poisson_ratio: float) -> RootSection:
    """Stress at both fillets of a section under unit forces and a unit moment.

    Outlines of loaded and other side, each with its own side as positive. `ConvergenceError` where the section is
    folded.
    """
    half = 0.5 * (loaded.fillet[0, 0] + far.fillet[0, 0])
    right = _side(loaded, _WIDTH * half)
    left = _side(far, _WIDTH * half) * np.array([-1.0, 1.0])
    nodes = _rows(right, left)
    rows, columns = nodes.shape[:2]
    matrix = _stiffness(nodes, _elements(rows, columns), poisson_ratio)
    free = 2 * (rows - 1) * columns  # the last row is held
    force = _tip_forces(nodes)
    flat = nodes.reshape(-1, 2)
    # resultants of the three loads at the tip: what goes through the root
    pushed = force.reshape(flat.shape[0], 2, 3)
    moment = (flat[:, 1, None] * -pushed[:, 0] + flat[:, 0, None] * pushed[:, 1]).sum(axis=0)
    resultants = np.stack([-pushed[:, 0].sum(axis=0), -pushed[:, 1].sum(axis=0), moment])
    moved = np.zeros_like(force)
    moved[:free] = splu(matrix[:free, :free]).solve(force[:free])
    unit = (moved @ np.linalg.inv(resultants)).reshape(*nodes.shape[:2], 2, 3)
    modulus = 1.0 / (1.0 - poisson_ratio**2)
    stresses, places = [], []
    for column in (0, -1):
        stress, place = _surface_strain(nodes[:, column], unit[:, column])
        stresses.append(modulus * stress.T)
        places.append(place)
    return RootSection(stresses[0], stresses[1], places[0])


def _outwards(line: FloatArray) -> FloatArray:
    """Unit normals of a side that runs down from the tip, out of the tooth."""
    tangent = np.gradient(line, axis=0)
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=-1)
    return np.asarray(normal / np.linalg.norm(normal, axis=1)[:, None])


def _smooth(normals: FloatArray) -> FloatArray:
    """Directions without the kinks that undercut leaves, for rows that do not cross."""
    for _ in range(_SMOOTHINGS):
        normals[1:-1] = 0.25 * normals[:-2] + 0.5 * normals[1:-1] + 0.25 * normals[2:]
    return np.asarray(normals / np.linalg.norm(normals, axis=1)[:, None])


def _shared(line: FloatArray, share: FloatArray) -> FloatArray:
    """Points of a line at shares of its length."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    return np.stack([np.interp(share * length[-1], length, line[:, k]) for k in (0, 1)], axis=-1)


def _side(outline: Outline, width: float) -> FloatArray:
    """Nodes of one side from the tip to the end of the root (2 elements + 1)."""
    # towards the fillet the elements grow smaller
    down = np.linspace(0.0, 1.0, 2 * _FLANK + 1)
    flank = _shared(outline.flank, 1.0 - (1.0 - down) ** 1.3)
    fillet = _shared(outline.fillet, np.linspace(0.0, 1.0, 2 * _FILLET + 1))
    end = outline.fillet[-1]
    out = np.linspace(0.0, 1.0, 2 * _LAND + 1)[1:, None] ** 1.8
    land = end + out * np.array([max(width - end[0], 0.5 * width), 0.0])
    return np.concatenate([flank, fillet[1:], land])


def _rows(right: FloatArray, left: FloatArray) -> FloatArray:
    """Nodes (rows, columns, 2) on rows square to both sides, closer together at them."""
    inner = [_smooth(-_outwards(right)), _smooth(_outwards(left))]
    chord = np.linalg.norm(right - left, axis=1)[:, None]
    t = 0.5 * (1.0 - np.cos(np.pi * np.linspace(0.0, 1.0, 2 * _ACROSS + 1)))[None, :, None]
    bulge = np.full(chord.shape, _BULGE[1])
    bulge[: 2 * _FLANK + 1, 0] = np.linspace(*_BULGE, 2 * _FLANK + 1)
    start, end = (bulge * chord * normal for normal in inner)
    h00, h10 = 2 * t**3 - 3 * t**2 + 1, t**3 - 2 * t**2 + t
    h01, h11 = -2 * t**3 + 3 * t**2, t**3 - t**2
    return np.asarray(h00 * right[:, None] + h10 * start[:, None] + h01 * left[:, None] - h11 * end[:, None])


def _lagrange(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Quadratic functions on [-1, 1] with nodes -1, 0, 1, and their slopes (points, 3)."""
    values = np.stack([0.5 * x * (x - 1.0), 1.0 - x**2, 0.5 * x * (x + 1.0)], axis=-1)
    return values, np.stack([x - 0.5, -2.0 * x, x + 0.5], axis=-1)


def _elements(rows: int, columns: int) -> IntArray:
    """Numbers of the nine nodes of each element of a grid of nodes, row by row."""
    first = (np.arange(0, rows - 2, 2)[:, None] * columns + np.arange(0, columns - 2, 2)).reshape(-1, 1)
    local = (np.arange(3)[:, None] * columns + np.arange(3)).ravel()
    return np.asarray(first + local)


def _stiffness(nodes: FloatArray, elements: IntArray, poisson_ratio: float) -> csc_matrix:
    """Stiffness of all nodes for a modulus of elasticity of 1, plane strain; both components of a node in turn."""
    points, weights = np.polynomial.legendre.leggauss(3)
    values, slopes = _lagrange(points)
    grad = np.stack(
        [np.einsum("pi,qj->pqij", slopes, values), np.einsum("pi,qj->pqij", values, slopes)], axis=-1
    ).reshape(9, 9, 2)
    weight = np.outer(weights, weights).ravel()
    place = nodes.reshape(-1, 2)[elements]
    jacobian = np.einsum("gnk,enx->egkx", grad, place)
    area = np.linalg.det(jacobian)
    if np.any(area * np.sign(area.flat[0]) <= 0.0):
        raise ConvergenceError("section_folded", "the root section of the tooth is folded")
    slope = np.einsum("egxk,gnk->egnx", np.linalg.inv(jacobian), grad)
    area = np.abs(area) * weight
    shear = 0.5 / (1.0 + poisson_ratio)
    lame = poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio))
    product = np.einsum("eg,egnx,egmy->enxmy", area, slope, slope, optimize=True)
    laplace = np.einsum("enxmx->enm", product)
    matrix = lame * product + shear * product.transpose(0, 1, 4, 3, 2)
    for x in (0, 1):
        matrix[:, :, x, :, x] += shear * laplace
    numbers = (2 * elements[:, :, None] + np.arange(2)).reshape(elements.shape[0], -1)
    size = numbers.shape[1]
    row, column = np.repeat(numbers, size, axis=1).ravel(), np.tile(numbers, (1, size)).ravel()
    return coo_matrix((matrix.ravel(), (row, column)), shape=(2 * nodes[..., 0].size,) * 2).tocsc()


def _tip_forces(nodes: FloatArray) -> FloatArray:
    """Forces at the nodes of the tip: even across, even down, and down on one half and up on the other."""
    columns = nodes.shape[1]
    tip = nodes[0]
    points, weights = np.polynomial.legendre.leggauss(3)
    values, slopes = _lagrange(points)
    forces = np.zeros((nodes[..., 0].size, 2, 3))
    middle, half = 0.5 * (tip[0] + tip[-1]), 0.5 * np.linalg.norm(tip[0] - tip[-1])
    for first in range(0, columns - 2, 2):
        own = np.arange(first, first + 3)
        length = np.linalg.norm(slopes @ tip[own], axis=1) * weights
        lever = (values @ tip[own] - middle)[:, 0] / half
        even, linear = values.T @ length, values.T @ (length * lever)
        forces[own, 0, 0] -= even
        forces[own, 1, 1] -= even
        forces[own, 1, 2] -= linear
    return forces.reshape(-1, 3)


def _surface_strain(line: FloatArray, moved: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Strain (p, loads) along a side with displacements (nodes, 2, loads), and where (p, 2), on its fillet."""
    values, slopes = _lagrange(np.array([-_GAUSS, _GAUSS]))
    strains, places = [], []
    for first in range(2 * (_FLANK - 1), 2 * (_FLANK + _FILLET + 1), 2):
        own = slice(first, first + 3)
        tangent = slopes @ line[own]
        square = np.sum(tangent**2, axis=1)
        rate = np.einsum("pn,nxl->pxl", slopes, moved[own])
        strains.append(np.einsum("px,pxl->pl", tangent, rate) / square[:, None])
        places.append(values @ line[own])
    return np.concatenate(strains), np.concatenate(places)
