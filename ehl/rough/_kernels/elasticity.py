"""Elastic response by recursion: the O(N) product with a sum of exponentials."""

from __future__ import annotations

from ehl.compile.compiler import INTERNAL_KERNEL, KERNEL, kernel
from ehl.rough._kernels.quad import four, part, total

FLAGS = {"reassoc", "contract", "arcp", "nsz"}
# for kernels that Python calls, and for those that only kernels call
PUBLIC = KERNEL | {"fastmath": FLAGS, "_nrt": False}
INTERNAL = INTERNAL_KERNEL | {"fastmath": FLAGS}


BLOCK = 12  # modes of one pass, three quads


@kernel(**PUBLIC)
def exponential_product(q, weights, ratios, out):
    """out_i = sum_j K_|i-j| q_j with K_d = sum_m weights_m ratios_m^d."""
    n = q.size
    for i in range(n):
        out[i] = 0.0
    for begin in range(0, weights.size, BLOCK):
        w0, w1, w2 = part(weights, begin), part(weights, begin + 4), part(weights, begin + 8)
        r0, r1, r2 = part(ratios, begin), part(ratios, begin + 4), part(ratios, begin + 8)
        s0, s1, s2 = four(0.0), four(0.0), four(0.0)
        t0, t1, t2 = s0, s1, s2
        # both sweeps in one loop: the two recursions are independent and fill each other's waiting time
        right = 0.0
        for i in range(n):
            j = n - 1 - i
            s0, s1, s2 = r0 * s0 + q[i], r1 * s1 + q[i], r2 * s2 + q[i]
            t0, t1, t2 = r0 * (t0 + right), r1 * (t1 + right), r2 * (t2 + right)
            out[i] += total(w0 * s0 + w1 * s1 + w2 * s2)
            out[j] += total(w0 * t0 + w1 * t1 + w2 * t2)
            right = q[j]
