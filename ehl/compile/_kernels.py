"""Common functions of the kernels: dense matrices in row order, and bits of doubles."""

from __future__ import annotations

import numpy as np
from numba import njit, types
from numba.core import config
from numba.extending import intrinsic
from scipy.linalg.lapack import dgetrf

from ehl.compile.compiler import INTERNAL_KERNEL

# LU factors of a matrix in columns, by the library that the compiler links
_getrf = types.ExternalFunction(
    "numba_xxgetrf",
    types.intc(
        types.char, types.intp, types.intp, types.CPointer(types.float64), types.intp, types.CPointer(types.int32)
    ),
)
_DOUBLE = ord("d")


@njit(**INTERNAL_KERNEL)
def factored(matrix, pivots):
    """Replace a matrix by the LU factors of its transpose; False if it is singular."""
    n = matrix.shape[0]
    return _getrf(_DOUBLE, n, n, matrix.ctypes, n, pivots.ctypes) == 0


def _factored_without_compiler(matrix, pivots):
    """`factored` if kernels run as plain Python."""
    matrix.T[:], places, singular = dgetrf(matrix.T)
    pivots[:] = places + 1
    return singular == 0


if config.DISABLE_JIT:
    factored = _factored_without_compiler


@njit(**INTERNAL_KERNEL, fastmath={"reassoc", "contract"})
def product(matrix, vector, out):
    """Matrix times vector."""
    for i in range(matrix.shape[0]):
        row = matrix[i]
        total = 0.0
        for j in range(vector.size):
            total += row[j] * vector[j]
        out[i] = total


@njit(**INTERNAL_KERNEL, fastmath={"reassoc", "contract"})
def solve_factored(factors, pivots, x):
    """Replace the right-hand side by the solution, from the factors of the transposed matrix: U^T L^T P^T."""
    n = x.size
    for i in range(n):
        row = factors[i]
        total = 0.0
        for j in range(i):
            total += row[j] * x[j]
        x[i] = (x[i] - total) / row[i]
    for k in range(n):
        i = n - 1 - k
        row = factors[i]
        total = 0.0
        for j in range(i + 1, n):
            total += row[j] * x[j]
        x[i] -= total
    for k in range(n):
        i = n - 1 - k
        other = pivots[i] - 1
        x[i], x[other] = x[other], x[i]


@intrinsic
def float_of_bits(typingctx, bits):
    """Reinterpret an int64 as a float64."""

    def codegen(context, builder, signature, args):
        return builder.bitcast(args[0], context.get_value_type(types.float64))

    return types.float64(types.int64), codegen


@intrinsic
def bits_of_float(typingctx, value):
    """Reinterpret a float64 as an int64."""

    def codegen(context, builder, signature, args):
        return builder.bitcast(args[0], context.get_value_type(types.int64))

    return types.int64(types.float64), codegen


if config.DISABLE_JIT:

    def bits_of_float(value):
        """`bits_of_float` if kernels run as plain Python."""
        return int(np.float64(value).view(np.int64))
