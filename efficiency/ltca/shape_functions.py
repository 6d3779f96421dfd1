"""Polynomials of one coordinate on [0, 1]: hierarchic shape functions, Legendre polynomials, Lagrange interpolation."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Pair = tuple[FloatArray, FloatArray]
"""Values and derivatives, each (points, functions)."""


@lru_cache(maxsize=32)
def lobatto_nodes(count: int) -> FloatArray:
    """Gauss-Lobatto points of [0, 1], at least two, both ends among them."""
    # all of them are real, whatever the type: NumPy 2.5 states complex numbers
    inner = legendre.legroots(legendre.legder(np.eye(count)[count - 1])).real
    nodes = np.asarray(0.5 * (1.0 + np.concatenate([[-1.0], np.sort(inner), [1.0]])))
    nodes.setflags(write=False)
    return nodes


@lru_cache(maxsize=32)
def gauss_rule(count: int) -> tuple[FloatArray, FloatArray]:
    """Points and weights of the Gauss rule on [0, 1]."""
    points, weights = (0.5 * (shift + x) for shift, x in zip((1.0, 0.0), legendre.leggauss(count), strict=True))
    points.setflags(write=False)
    weights.setflags(write=False)
    return points, weights


def legendre_polynomials(degree: int, x: FloatArray) -> Pair:
    """Legendre polynomials up to a degree, of ``2 x - 1``."""
    s = 2.0 * x - 1.0
    slopes = legendre.legval(s, legendre.legder(np.eye(degree + 1)))
    return np.asarray(legendre.legvander(s, degree)), np.asarray(2.0 * np.broadcast_to(slopes.T, (x.size, degree + 1)))


def hierarchic_functions(degree: int, x: FloatArray) -> Pair:
    """``1 - x``, ``x``, and integrals of Legendre polynomials, which vanish at both ends (Szabo & Babuska 1991)."""
    p = legendre.legvander(2.0 * x - 1.0, degree)
    values, slopes = [1.0 - x, x], [-np.ones_like(x), np.ones_like(x)]
    for k in range(2, degree + 1):
        values.append((p[:, k] - p[:, k - 2]) / np.sqrt(2.0 * (2.0 * k - 1.0)))
        slopes.append(np.sqrt(2.0 * (2.0 * k - 1.0)) * p[:, k - 1])
    return np.stack(values, axis=-1), np.stack(slopes, axis=-1)


def lagrange_values(nodes: FloatArray, x: FloatArray) -> FloatArray:
    """Lagrange polynomials of nodes, (points, functions)."""
    return np.asarray(legendre.legvander(2.0 * x - 1.0, nodes.size - 1) @ _to_legendre(tuple(nodes.tolist())))


def lagrange_polynomials(nodes: FloatArray, x: FloatArray) -> Pair:
    """Lagrange polynomials of nodes and their derivatives."""
    values, slopes = legendre_polynomials(nodes.size - 1, x)
    inverse = _to_legendre(tuple(nodes.tolist()))
    return values @ inverse, slopes @ inverse


@lru_cache(maxsize=32)
def _to_legendre(nodes: tuple[float, ...]) -> FloatArray:
    """Matrix that takes values at nodes to Legendre coefficients."""
    return np.asarray(np.linalg.inv(legendre.legvander(2.0 * np.array(nodes) - 1.0, len(nodes) - 1)))
