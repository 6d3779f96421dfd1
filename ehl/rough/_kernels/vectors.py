"""Four numbers in one vector register, and elementary functions that a compiler can vectorise.

A recursion along the nodes is as slow as its longest chain of dependent operations. Small arrays live in memory and
every turn waits for the store of the last one; this type stays in registers, and `+`, `-`, `*` act on all four numbers.
Exponential and logarithm are accurate to about 1e-14 relative; those of the library cannot be inlined.
"""

from __future__ import annotations

import math
import operator
from typing import ClassVar

from llvmlite import ir
from numba import njit, types
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model
from numba.np.arrayobj import make_array

from ehl.compile._kernels import LN2_HIGH, LN2_LOW, float_of_bits
from ehl.compile.compiler import FAST_KERNEL, INTERNAL_KERNEL, kernel

LANES = 4
VECTOR = ir.VectorType(ir.DoubleType(), LANES)
LANE = ir.IntType(32)

LOG2_E = 1.4426950408889634


class QuadType(types.Type):
    """Four float64."""

    def __init__(self) -> None:
        super().__init__(name="quad")


quad = QuadType()


@register_model(QuadType)
class QuadModel(models.PrimitiveModel):
    """Held in one register."""

    def __init__(self, manager, kind):
        super().__init__(manager, kind, VECTOR)


def shuffle(builder, a, b, lanes):
    """Lanes of a (0 to 3) and b (4 to 7)."""
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(LANE, len(lanes)), lanes))


def spread(builder, value):
    """The same number four times."""
    one = builder.insert_element(ir.Constant(VECTOR, ir.Undefined), value, ir.Constant(LANE, 0))
    return shuffle(builder, one, one, (0, 0, 0, 0))


def define(symbol, instruction):
    """An operator on quads, or on a quad and a number."""
    pairs = ((quad, quad), (types.float64, quad), (quad, types.float64))

    @infer_global(symbol)
    class Template(ConcreteTemplate):
        cases: ClassVar = [signature(quad, *pair) for pair in pairs]

    def lower(context, builder, sig, args):
        vectors = [v if kind is quad else spread(builder, v) for kind, v in zip(sig.args, args, strict=True)]
        return getattr(builder, instruction)(*vectors)

    for pair in pairs:
        lower_builtin(symbol, *pair)(lower)


for _symbol, _instruction in ((operator.add, "fadd"), (operator.sub, "fsub"), (operator.mul, "fmul")):
    define(_symbol, _instruction)


@intrinsic
def four(typingctx, value):
    """A number in all four lanes."""

    def codegen(context, builder, sig, args):
        return spread(builder, args[0])

    return quad(types.float64), codegen


@intrinsic
def pack(typingctx, a, b, c, d):
    """Four numbers."""

    def codegen(context, builder, sig, args):
        vector = ir.Constant(VECTOR, ir.Undefined)
        for place, value in enumerate(args):
            vector = builder.insert_element(vector, value, ir.Constant(LANE, place))
        return vector

    return quad(*(types.float64,) * LANES), codegen


@intrinsic
def lane(typingctx, a, index):
    """One of the four."""

    def codegen(context, builder, sig, args):
        return builder.extract_element(args[0], builder.trunc(args[1], LANE))

    return types.float64(quad, types.int64), codegen


@intrinsic
def total(typingctx, a):
    """Sum of the four."""

    def codegen(context, builder, sig, args):
        a = args[0]
        a = builder.fadd(a, shuffle(builder, a, a, (2, 3, 0, 1)))
        a = builder.fadd(a, shuffle(builder, a, a, (1, 0, 3, 2)))
        return builder.extract_element(a, ir.Constant(LANE, 0))

    return types.float64(quad), codegen


@intrinsic
def totals(typingctx, a, b, c, d):
    """Sum of each of four quads."""

    def codegen(context, builder, sig, args):
        a, b, c, d = args
        ab = builder.fadd(shuffle(builder, a, b, (0, 4, 2, 6)), shuffle(builder, a, b, (1, 5, 3, 7)))
        cd = builder.fadd(shuffle(builder, c, d, (0, 4, 2, 6)), shuffle(builder, c, d, (1, 5, 3, 7)))
        return builder.fadd(shuffle(builder, ab, cd, (0, 1, 4, 5)), shuffle(builder, ab, cd, (2, 3, 6, 7)))

    return quad(quad, quad, quad, quad), codegen


def _place(context, builder, kind, values, first):
    """Pointer to four consecutive entries."""
    array = make_array(kind)(context, builder, values)
    return builder.bitcast(builder.gep(array.data, [first]), VECTOR.as_pointer())


@intrinsic
def load(typingctx, values, first):
    """Entries first .. first + 3 of a contiguous row."""

    def codegen(context, builder, sig, args):
        return builder.load(_place(context, builder, sig.args[0], *args), align=8)

    return quad(values, types.intp), codegen


@intrinsic
def store(typingctx, values, first, four_values):
    """Write them."""

    def codegen(context, builder, sig, args):
        builder.store(args[2], _place(context, builder, sig.args[0], *args[:2]), align=8)
        return context.get_dummy_value()

    return types.void(values, types.intp, quad), codegen


@njit(**INTERNAL_KERNEL)
def part(values, first):
    """Entries first .. first + 3 of a row, zero beyond its end."""
    n = values.size
    return pack(
        values[first] if first < n else 0.0,
        values[first + 1] if first + 1 < n else 0.0,
        values[first + 2] if first + 2 < n else 0.0,
        values[first + 3] if first + 3 < n else 0.0,
    )


@kernel(**FAST_KERNEL)
def exp(x):
    """e^x, x held within +-700: x = k ln 2 + r, |r| <= ln 2/2, and the Taylor polynomial of degree 11."""
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
