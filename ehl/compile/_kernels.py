"""Common functions of the kernels: dense matrices in row order, and bits of doubles."""

from __future__ import annotations

import numpy as np
from numba import config, njit, types
from numba.extending import intrinsic

from ehl.compile.compiler import INTERNAL_KERNEL, internals

if internals is not None:
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


def _factored_by_loops(matrix, pivots):
    """`factored` by elimination with partial pivoting; half as fast."""
    n = matrix.shape[0]
    for k in range(n):
        pivot = k + np.argmax(np.abs(matrix[k, k:]))
        pivots[k] = pivot + 1
        if matrix[k, pivot] == 0.0:
            return False
        if pivot != k:
            for i in range(n):
                matrix[i, k], matrix[i, pivot] = matrix[i, pivot], matrix[i, k]
        matrix[k, k + 1 :] /= matrix[k, k]
        for j in range(k + 1, n):
            matrix[j, k + 1 :] -= matrix[j, k] * matrix[k, k + 1 :]
    return True


if config.DISABLE_JIT:
    factored = _factored_by_loops
elif internals is None:
    factored = njit(**INTERNAL_KERNEL)(_factored_by_loops)


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
