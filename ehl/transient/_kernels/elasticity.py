"""Elastic response by recursion: the O(N) product with a sum of exponentials."""

from __future__ import annotations

from numba import njit

FLAGS = {"reassoc", "contract", "arcp", "nsz"}
# for kernels that only kernels call: without the wrappers for Python they compile a third faster, and a call
# from Python would crash
INTERNAL = {
    "cache": True,
    "error_model": "numpy",
    "fastmath": FLAGS,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def exponential_product(q, weights, ratios, state, out):
    """out_i = sum_j K_|i-j| q_j with K_d = sum_m weights_m ratios_m^d; ``state`` is scratch, (2, modes)."""
    n = q.size
    modes = weights.size
    for m in range(modes):
        state[0, m] = 0.0
        state[1, m] = 0.0
    for i in range(n):
        out[i] = 0.0
    # both sweeps in one loop: the two recursions are independent and fill each other's waiting time
    right = 0.0
    for i in range(n):
        j = n - 1 - i
        qi = q[i]
        up = 0.0
        down = 0.0
        for m in range(modes):
            s = state[0, m] * ratios[m] + qi
            t = (state[1, m] + right) * ratios[m]
            state[0, m] = s
            state[1, m] = t
            up += weights[m] * s
            down += weights[m] * t
        out[i] += up
        out[j] += down
        right = q[j]
