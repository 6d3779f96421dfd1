"""Four numbers in one vector register, and elementary functions that a compiler can vectorise.

A recursion along the nodes is as slow as its longest chain of dependent operations. Small arrays live in memory and
every turn waits for the store of the last one; this type stays in registers, and `+`, `-`, `*` act on all four numbers.
Exponential and logarithm are accurate to about 1e-15 relative; those of the library cannot be inlined.
"""

from __future__ import annotations

import math
import operator
from typing import ClassVar

from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model
from numba.np.arrayobj import make_array

from ehl.compile._kernels import LN2_HIGH, LN2_LOW, ROOT_HALF_BITS
from ehl.compile.compiler import FAST_KERNEL, INTERNAL_KERNEL, kernel

LANES = 4
VECTOR = ir.VectorType(ir.DoubleType(), LANES)
LANE = ir.IntType(32)
_INTEGER = ir.IntType(64)

LOG2_E = 1.4426950408889634
WHOLE = 6755399441055744.0  # 1.5 2^52: the lowest bits of WHOLE + x are the nearest whole number to x
WHOLE_BITS = 4843621399236968448  # its bit pattern
# best polynomials (Remez) of e^r for |r| <= ln 2/2 and of 2 artanh(s)/s in s^2, s <= 0.172; errors 2e-16
EXP_0, EXP_1, EXP_2, EXP_3 = 1.0, 1.0000000000000067, 0.5000000000000006, 0.16666666666554406
EXP_4, EXP_5, EXP_6 = 0.04166666666657314, 0.008333333385667814, 0.0013888888932488625
EXP_7, EXP_8 = 0.00019841170270400204, 2.480150434696448e-05
EXP_9, EXP_10 = 2.7640180812804505e-06, 2.762635725527078e-07
LOG_0, LOG_1, LOG_2, LOG_3 = 2.0000000000000004, 0.6666666666655292, 0.4000000006174193, 0.2857141602105636
LOG_4, LOG_5, LOG_6 = 0.22223434551256419, 0.1812193430694884, 0.16837661506654086
# without a change of the order, which the splitting of x relies on
ELEMENTARY = FAST_KERNEL | {"fastmath": {"contract"}}


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
    """An operator on quads, or on a quad and a number.

    instruction: function of a builder of code and both operands.
    """
    pairs = ((quad, quad), (types.float64, quad), (quad, types.float64))

    @infer_global(symbol)
    class Template(ConcreteTemplate):
        cases: ClassVar = [signature(quad, *pair) for pair in pairs]

    def lower(context, builder, sig, args):
        vectors = [v if kind is quad else spread(builder, v) for kind, v in zip(sig.args, args, strict=True)]
        return instruction(builder, *vectors)

    for pair in pairs:
        lower_builtin(symbol, *pair)(lower)


for _symbol, _instruction in (
    (operator.add, ir.IRBuilder.fadd),
    (operator.sub, ir.IRBuilder.fsub),
    (operator.mul, ir.IRBuilder.fmul),
    (operator.truediv, ir.IRBuilder.fdiv),
):
    define(_symbol, _instruction)


def select(builder, relation, a, b, yes, no):
    """Lanes of ``yes`` where a relation of a and b holds, else of ``no``; none holds for a number that is none."""
    return builder.select(builder.fcmp_ordered(relation, a, b), yes, no)


for _symbol, _relation in ((max, ">"), (min, "<")):

    def _extreme(builder, a, b, relation=_relation):
        return select(builder, relation, a, b, a, b)

    define(_symbol, _extreme)


def by_name(builder, name, value):
    """Value of an elementwise function of LLVM of one argument."""
    suffix = f"v{LANES}f64" if value.type == VECTOR else "f64"
    of = ir.FunctionType(value.type, [value.type])
    return builder.call(cgutils.get_or_insert_function(builder.module, of, f"llvm.{name}.{suffix}"), [value])


def define_elementwise(symbol, name):
    """A function of one quad."""

    @infer_global(symbol)
    class Template(ConcreteTemplate):
        cases: ClassVar = [signature(quad, quad)]

    def lower(context, builder, sig, args):
        return by_name(builder, name, args[0])

    lower_builtin(symbol, quad)(lower)


for _symbol, _name in ((math.sqrt, "sqrt"), (abs, "fabs")):
    define_elementwise(_symbol, _name)


@intrinsic
def any_above(typingctx, a, b):
    """1 if a number of a quad is above that of another, else 0."""

    def codegen(context, builder, sig, args):
        bits = builder.bitcast(builder.fcmp_ordered(">", *args), ir.IntType(LANES))
        return builder.zext(builder.icmp_unsigned("!=", bits, bits.type(0)), _INTEGER)

    return types.int64(quad, quad), codegen


@intrinsic
def where_above(typingctx, a, b, yes, no):
    """``yes`` where a > b, else ``no``, of four numbers or one."""
    kind = quad if quad in (a, b, yes, no) else types.float64

    def codegen(context, builder, sig, args):
        values = (v if of is kind else spread(builder, v) for of, v in zip(sig.args, args, strict=True))
        return select(builder, ">", *values)

    return kind(a, b, yes, no), codegen


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


@intrinsic
def transposed(typingctx, a, b, c, d):
    """First, second, third and fourth lanes of four quads."""

    def codegen(context, builder, sig, args):
        pairs = args[:2], args[2:]
        even, odd = ([shuffle(builder, *pair, (k, k + 4, k + 2, k + 6)) for pair in pairs] for k in (0, 1))
        rows = [shuffle(builder, *both, lanes) for lanes in ((0, 1, 4, 5), (2, 3, 6, 7)) for both in (even, odd)]
        return context.make_tuple(builder, sig.return_type, rows)

    return types.UniTuple(quad, LANES)(quad, quad, quad, quad), codegen


@intrinsic
def whole_parts(typingctx, a):
    """Four non-negative numbers without their fractions, as a quad and as integers."""

    def codegen(context, builder, sig, args):
        whole = builder.fptosi(args[0], ir.VectorType(LANE, LANES))
        parts = [builder.zext(builder.extract_element(whole, ir.Constant(LANE, k)), _INTEGER) for k in range(LANES)]
        return context.make_tuple(builder, sig.return_type, [builder.sitofp(whole, VECTOR), *parts])

    return types.Tuple((quad, *(types.int64,) * LANES))(quad), codegen


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


def _integers(kind):
    """Integer type of the bits of a number or of four, and a function that makes constants of it."""
    if kind is quad:
        type_ = ir.VectorType(_INTEGER, LANES)
        return type_, lambda value: ir.Constant(type_, [value] * LANES)
    return _INTEGER, _INTEGER


@intrinsic
def nearest(typingctx, x):
    """The nearest whole number."""

    def codegen(context, builder, sig, args):
        return by_name(builder, "rint", args[0])

    return x(x), codegen


@intrinsic
def power_of_two(typingctx, k):
    """2^k of a whole number: WHOLE + k has the lowest bits of k."""

    def codegen(context, builder, sig, args):
        integers, constant = _integers(sig.args[0])
        whole = context.get_constant(types.float64, WHOLE)
        bits = builder.fadd(args[0], spread(builder, whole) if sig.args[0] is quad else whole)
        exponent = builder.add(builder.bitcast(bits, integers), constant(1023))
        return builder.bitcast(builder.shl(exponent, constant(52)), args[0].type)

    return k(k), codegen


@intrinsic
def binary_parts(typingctx, x):
    """m and e of a positive normal number x = 2^e m, sqrt(1/2) <= m < sqrt 2."""

    def codegen(context, builder, sig, args):
        integers, constant = _integers(sig.args[0])
        bits = builder.bitcast(args[0], integers)
        # 1024 more, so that nothing is negative
        above = builder.add(bits, constant((1024 << 52) - ROOT_HALF_BITS))
        whole = builder.add(builder.lshr(above, constant(52)), constant(WHOLE_BITS))
        whole = builder.bitcast(whole, args[0].type)
        offset = context.get_constant(types.float64, WHOLE + 1024.0)
        e = builder.fsub(whole, spread(builder, offset) if sig.args[0] is quad else offset)
        exponent = builder.and_(above, constant(~((1 << 52) - 1)))
        m = builder.bitcast(builder.add(builder.sub(bits, exponent), constant(1024 << 52)), args[0].type)
        return context.make_tuple(builder, sig.return_type, (m, e))

    return types.UniTuple(x, 2)(x), codegen


@kernel(**ELEMENTARY)
def exp(x):
    """e^x of a number or of four, x held within +-700: x = k ln 2 + r, |r| <= ln 2/2, and a polynomial in r."""
    x = min(max(x, -700.0), 700.0)
    k = nearest(x * LOG2_E)
    r = (x - k * LN2_HIGH) - k * LN2_LOW
    r2 = r * r
    r4 = r2 * r2
    low = (EXP_0 + EXP_1 * r) + (EXP_2 + EXP_3 * r) * r2
    middle = (EXP_4 + EXP_5 * r) + (EXP_6 + EXP_7 * r) * r2
    high = (EXP_8 + EXP_9 * r) + EXP_10 * r2
    return (low + (middle + high * r4) * r4) * power_of_two(k)


@kernel(**ELEMENTARY)
def log(x):
    """ln x of a positive normal number or of four: x = 2^e m and a polynomial for the series of artanh."""
    m, e = binary_parts(x)
    s = (m - 1.0) / (m + 1.0)
    z = s * s
    z2 = z * z
    p = (LOG_0 + LOG_1 * z) + (LOG_2 + LOG_3 * z) * z2
    p = p + ((LOG_4 + LOG_5 * z) + LOG_6 * z2) * (z2 * z2)
    return s * p + e * (LN2_HIGH + LN2_LOW)
