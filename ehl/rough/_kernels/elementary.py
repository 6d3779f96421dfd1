"""Exponential and logarithm that a compiler can vectorise (the library's cannot be inlined).

Both are accurate to about 1e-14 relative; arguments of ``exp`` beyond +-700 are clamped.
"""

from __future__ import annotations

import math

from numba import types
from numba.extending import intrinsic

from ehl.compile.compiler import kernel
from ehl.rough._kernels.elasticity import PUBLIC

LOG2_E = 1.4426950408889634
LN2_HIGH = 0.6931471803691238  # the low bits are zero: k LN2_HIGH is exact
LN2_LOW = 1.9082149292705877e-10
ROOT_HALF_BITS = 4604544271217802189  # bit pattern of sqrt(1/2)


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


@kernel(**PUBLIC)
def exp(x):
    """e^x: x = k ln 2 + r, |r| <= ln 2/2, and the Taylor polynomial of degree 11."""
    x = min(max(x, -700.0), 700.0)
    k = math.floor(x * LOG2_E + 0.5)
    r = (x - k * LN2_HIGH) - k * LN2_LOW
    p = 1.0 / 39916800.0
    p = p * r + 1.0 / 3628800.0
    p = p * r + 1.0 / 362880.0
    p = p * r + 1.0 / 40320.0
    p = p * r + 1.0 / 5040.0
    p = p * r + 1.0 / 720.0
    p = p * r + 1.0 / 120.0
    p = p * r + 1.0 / 24.0
    p = p * r + 1.0 / 6.0
    p = p * r + 0.5
    p = p * r + 1.0
    p = p * r + 1.0
    return p * float_of_bits((int(k) + 1023) << 52)


@kernel(**PUBLIC)
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
