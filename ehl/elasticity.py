"""Elastic deflection of a line contact on a uniform grid, with exactly integrated kernel, by FFT or dense matrix.

V(x) = -(4/(pi E')) int p(s) ln|x - s| ds for both bodies, with x in metres. The deflection of a line contact is defined
up to a constant: only differences of V (or h0 + V) are meaningful.
"""

import math
from typing import Literal

import numpy as np
from scipy import fft, linalg

from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError

Element = Literal["constant", "linear"]


def influence_coefficients(
    count: int, spacing: float, effective_modulus: float, element: Element = "constant"
) -> FloatArray:
    """Deflection at distance 0, 1, 2... nodes from one element of unit pressure [m/Pa].

    Integrated exactly over the element: a cell of constant pressure about its node, or a linear hat function between
    the neighbouring nodes.

    count: number of distances.
    spacing: [m].
    effective_modulus: E' with 2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 [Pa].
    Returns: shape (count,).
    """
    distance = np.arange(count, dtype=float)
    if element == "constant":
        # first antiderivative of ln|t|, differenced over the cell
        weight = _log_integral(distance + 0.5) - _log_integral(distance - 0.5)
    else:
        weight = _log_integral_twice(distance + 1.0) - 2.0 * _log_integral_twice(distance)
        weight += _log_integral_twice(distance - 1.0)
    # far field by the moments of the element, exact to 1e-13: differences of large numbers lose digits there
    far = distance > 60.0
    second, fourth = (24.0, 320.0) if element == "constant" else (12.0, 60.0)
    square = distance[far] ** 2
    weight[far] = np.log(distance[far]) - 1.0 / (second * square) - 1.0 / (fourth * square**2)
    return np.asarray(-4.0 / (math.pi * effective_modulus) * spacing * (weight + math.log(spacing)))


def _log_integral(t: FloatArray) -> FloatArray:
    """Antiderivative of ln|t|: t ln|t| - t."""
    return np.asarray(t * np.log(np.where(t == 0.0, 1.0, np.abs(t))) - t)


def _log_integral_twice(t: FloatArray) -> FloatArray:
    """Second antiderivative of ln|t|: t^2 ln|t|/2 - 3 t^2/4."""
    return np.asarray(0.5 * t * t * np.log(np.where(t == 0.0, 1.0, np.abs(t))) - 0.75 * t * t)


class DeflectionOperator:
    """Deflection by a pressure on n uniform nodes; zero padding avoids periodic images.

    count: number of nodes.
    spacing: node distance [m].
    effective_modulus: E' [Pa].
    element ("constant", "linear"): shape of the pressure between nodes.
    """

    def __init__(self, count: int, spacing: float, effective_modulus: float, element: Element = "constant") -> None:
        if count < 2 or not spacing > 0.0 or not effective_modulus > 0.0:
            given = (count, spacing, effective_modulus)
            raise InputError("count, spacing, effective_modulus", given, "at least 2 nodes, > 0 m, > 0 Pa")
        self.count, self.spacing, self.effective_modulus, self.element = count, spacing, effective_modulus, element
        self.coefficients = influence_coefficients(count, spacing, effective_modulus, element)
        self._size = fft.next_fast_len(2 * count - 1, real=True)
        kernel = np.zeros(self._size)
        kernel[:count] = self.coefficients
        kernel[self._size - count + 1 :] = self.coefficients[:0:-1]
        self._spectrum = fft.rfft(kernel)

    def __call__(self, pressure: FloatArray) -> FloatArray:
        """Deflection V [m] of a pressure [Pa], both of shape (n,); O(n log n)."""
        product = fft.irfft(fft.rfft(pressure, self._size) * self._spectrum, self._size)
        return np.asarray(product[: self.count])

    def dense(self) -> FloatArray:
        """The operator as a matrix, shape (n, n), for checks and small problems."""
        return np.asarray(linalg.toeplitz(self.coefficients))
