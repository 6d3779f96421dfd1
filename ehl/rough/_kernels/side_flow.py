"""Side flow through the valleys of the roughness: the macroscopic pressure P(x) that the pockets exchange oil with.

At every x the time mean of the exchange k (p - P) must vanish, or the slice would gain or lose mass in the mean.
P is moved towards that by the mean exchange over its conductance (local part) and by a diffusion problem (smooth
part, which the local part alone would need thousands of passages for).  Ahead of the first exchanging node the gap
is many times the roughness: there P is the mean of p and the boundary value of the diffusion problem.

Conductances and fluidities are long averages: window values correlate with the exchange and bias the fixed point
while every step still converges.
"""

from __future__ import annotations

import math

from numba import njit

from ehl.compile.compiler import FAST_INTERNAL_KERNEL
from ehl.rough._kernels.heat import log_or_floor

STEP_MAX = 0.3  # largest change of P in one update, p_h
# largest load of P over that of the contact: with more the bodies are lifted, the wider gap takes in oil faster than P
# answers, and light loads on thick films fly apart
LOAD_MAX = 1.05


@njit(**FAST_INTERNAL_KERNEL)
def add_logarithms(values, sums):
    """Add ln of each value to the sums."""
    for i in range(values.size):
        sums[i] += log_or_floor(values[i])


@njit(**FAST_INTERNAL_KERNEL)
def accumulate(state, macro, work, model):
    """Add the exchange of one converged step; True when the window is full."""
    first = model.side_flow.first
    outlet = model.contact.outlet
    for i in range(first):
        macro.sum_pressure[i] += state.fluid_pressure[i]
    # slices and not a range of indices: those could be negative to the compiler, and nothing would vectorise
    add_logarithms(work.fluidity[first - 1 : outlet], macro.sum_log_flux[first - 1 : outlet])
    add_logarithms(work.node.f[first:outlet], macro.sum_log_lateral[first:outlet])
    for i in range(first, outlet):
        k = work.exchange[i]
        exchange = k * (state.fluid_pressure[i] - macro.pressure[i])
        macro.sum_exchange[i] += exchange
        macro.total_exchange[i] += exchange
        macro.sum_conductance[i] += k
    macro.counts[0] += 1
    return macro.counts[0] >= model.side_flow.window


@njit(**FAST_INTERNAL_KERNEL)
def update_pressure(macro, model):
    """One relaxed step of P from the window means."""
    rule = model.side_flow
    first = rule.first
    outlet = model.contact.outlet
    per_step = 1.0 / macro.counts[0]
    weight = max(rule.memory, 1.0 / (macro.counts[1] + 1.0))
    below = macro.matrix[0]
    centre = macro.matrix[1]
    above = macro.matrix[2]
    change = macro.matrix[3]
    for i in range(first):
        macro.pressure[i] += rule.relaxation * (macro.sum_pressure[i] * per_step - macro.pressure[i])
        macro.sum_pressure[i] = 0.0
    for i in range(first - 1, outlet):
        macro.log_flux[i] += weight * (macro.sum_log_flux[i] * per_step - macro.log_flux[i])
        macro.sum_log_flux[i] = 0.0
    for i in range(first, outlet):
        macro.conductance[i] += weight * (macro.sum_conductance[i] * per_step - macro.conductance[i])
        mean_log = macro.sum_log_lateral[i] * per_step
        if macro.counts[1] == 0:
            macro.typical[i] = math.exp(mean_log)
        else:
            macro.typical[i] = math.exp((1.0 - weight) * math.log(macro.typical[i]) + weight * mean_log)
        macro.sum_exchange[i] *= per_step
    for i in range(first - 1, outlet):
        below[i] = above[i] = change[i] = 0.0
        centre[i] = 1.0
    for i in range(first, outlet - 1):
        left = math.exp(macro.log_flux[i - 1])
        right = math.exp(macro.log_flux[i])
        below[i] = -left
        above[i] = -right
        centre[i] = left + right + rule.storage * per_step
        change[i] = macro.sum_exchange[i]
    for i in range(first, outlet):
        ratio = below[i] / centre[i - 1]
        centre[i] -= ratio * above[i - 1]
        change[i] -= ratio * change[i - 1]
    change[outlet - 1] /= centre[outlet - 1]
    for i in range(outlet - 2, first - 2, -1):
        change[i] = (change[i] - above[i] * change[i + 1]) / centre[i]
    for i in range(first, outlet - 1):
        local = macro.sum_exchange[i] / macro.conductance[i] if macro.conductance[i] > 1e-300 else 0.0
        step = rule.relaxation * (change[i] + local)
        if not abs(step) < 1e6:
            step = 0.0
        macro.pressure[i] = max(macro.pressure[i] + min(max(step, -STEP_MAX), STEP_MAX), 0.0)
    carried = 0.0
    for i in range(outlet):
        carried += macro.pressure[i]
    if carried > LOAD_MAX * model.contact.full_load:
        lowered = LOAD_MAX * model.contact.full_load / carried
        for i in range(first, outlet):
            macro.pressure[i] *= lowered
    for i in range(first, outlet):
        macro.sum_exchange[i] = macro.sum_conductance[i] = macro.sum_log_lateral[i] = 0.0
    macro.counts[0] = 0
    macro.counts[1] += 1
