"""Common functions of the kernels: dense matrices in row order, bits of doubles, and a logarithm for vectors."""

from __future__ import annotations

import numpy as np
from numba import config, njit, types
from numba.extending import intrinsic

from ehl.compile.compiler import FAST_KERNEL, INTERNAL_KERNEL, internals, kernel

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

    def float_of_bits(bits):
        """`float_of_bits` if kernels run as plain Python."""
        return np.int64(bits).view(np.float64)


LN2_HIGH = 0.6931471803691238  # the low bits are zero: k LN2_HIGH is exact
LN2_LOW = 1.9082149292705877e-10
ROOT_HALF_BITS = 4604544271217802189  # bit pattern of sqrt(1/2)


@kernel(**FAST_KERNEL)
def log(x):
    """ln x of a positive normal number: x = 2^e m, sqrt(1/2) <= m < sqrt 2, and the series of artanh."""
    bits = bits_of_float(x)
    e = (bits - ROOT_HALF_BITS) >> 52
    m = float_of_bits(bits - (e << 52))
    s = (m - 1.0) / (m + 1.0)
    z = s * s
    p = 1.0 / 19.0
    p = p * z + 1.0 / 17.0
    p = p * z + 1.0 / 15.0
    p = p * z + 1.0 / 13.0
    p = p * z + 1.0 / 11.0
    p = p * z + 1.0 / 9.0
    p = p * z + 1.0 / 7.0
    p = p * z + 1.0 / 5.0
    p = p * z + 1.0 / 3.0
    p = p * z + 1.0
    return 2.0 * s * p + float(e) * (LN2_HIGH + LN2_LOW)
