"""Elastic response by recursion: the O(N) product with a sum of exponentials."""

from __future__ import annotations

from numba import njit

FLAGS = {"reassoc", "contract", "arcp", "nsz"}


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def exponential_product(q, weights, ratios, state, out):
    """out_i = sum_j K_|i-j| q_j with K_d = sum_m weights_m ratios_m^d; ``state`` is scratch, one entry per mode."""
    n = q.size
    modes = weights.size
    for m in range(modes):
        state[m] = 0.0
    for i in range(n):
        acc = 0.0
        qi = q[i]
        for m in range(modes):
            s = state[m] * ratios[m] + qi
            state[m] = s
            acc += weights[m] * s
        out[i] = acc
    for m in range(modes):
        state[m] = 0.0
    right = 0.0
    for i in range(n - 1, -1, -1):
        acc = 0.0
        for m in range(modes):
            s = (state[m] + right) * ratios[m]
            state[m] = s
            acc += weights[m] * s
        out[i] += acc
        right = q[i]
