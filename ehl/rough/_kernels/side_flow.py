"""Side flow through the valleys of the roughness: the macroscopic pressure P(x) that the pockets exchange oil with.

At every x the time mean of the exchange k (p - P) must vanish, or the slice would gain or lose mass in the mean.
P is moved towards that by the mean exchange over its conductance (local part) and by a diffusion problem (smooth
part, which the local part alone would need thousands of passages for).  Ahead of the first exchanging node the gap
is many times the roughness: there P is the mean of p.

P is at most 0.02 p_h above the mean total pressure Q.

Where the film is full and the exchange strong (thick films, gamma up to about 1.5), p follows P, and a surplus of oil
leaves the contact only along x: there the smooth part is a step of Newton's method for the mean film
(`mean_film_step`). Where asperities carry a noticeable part of the load, a diffusion problem serves: the
exchange of single windows is then many times the throughput.

Conductances and fluidities are long averages: window values correlate with the exchange and bias the fixed point
while every step still converges. Their gain falls as 1/n, so that they become means over the whole travel.

Elasticity: the time mean Q(x) of the total pressure q acts through the line kernel, what deviates from it through that
of a lateral mode of wave number k_e (`ehl.rough.scaling.flattening_wave_number`):

    V = K_log Q + K_e (q - Q) = (K_log - K_e) Q + K_e q

The first term changes as slowly as Q and is part of the rigid gap.
"""

from __future__ import annotations

import math

from numba import njit

from ehl.compile.compiler import FAST_INTERNAL_KERNEL, FAST_KERNEL, kernel
from ehl.rough._kernels.heat import log_or_floor
from ehl.rough._kernels.quasi_separable import FLUID, exponential_product, factor_and_solve

STEP_MAX = 0.3  # largest change of P in one update, p_h
# largest load of P over that of the contact: with more the bodies are lifted, the wider gap takes in oil faster than P
# follows, and light loads on thick films fly apart
LOAD_MAX = 1.05
# gain of P in the first of the `settled` windows, while the roughness enters: P starts far from its mean, and what it
# scatters then is forgotten
START_GAIN, STARTING = 0.5, 1.0 / 6.0
# smooth part by Newton's method: asperity load shares up to and from which it has weights 1 and 0, windows before it
# starts, its first gain and windows after which this falls as 1/n, limit of the derivative of a flow by the fluidity
FILM_SHARES, FILM_START, FILM_GAIN, FILM_WINDOWS, FILM_MONOTONE = (0.05, 0.15), 20, 0.5, 40.0, 0.8
AHEAD = 0.5  # gain of P ahead of the first exchanging node, where p hardly scatters
AVERAGED = 3.0  # windows: the gain of the long averages is (1 + 3)/(n + 3) and weights the start-up less than a mean
# Q: gain of the first updates, windows after which it falls as 1/n, pressure below which it is not changed [p_h],
# diagonal compliance over that of the kernel, which keeps short waves of the noise out of Q
TOTAL_GAIN, TOTAL_WINDOWS, TOTAL_MIN, TOTAL_COMPLIANCE = 0.5, 20.0, 1e-3, 0.1
TOTAL_LOW = 0.1  # pressure below which that compliance grows as its inverse square [p_h]
OUTFLOW_PRESSURE = 0.02  # excess over P from which a spot drains as it does along x [p_h]
# limit of the factor on the mean-field exchange (this work): chosen among 20, 50, 200 and 2000 on six solutions with
# two-dimensional roughness (docs/roughness.md); snapshots of such solutions show factors up to 16
OUTFLOW_MAX = 50.0


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
    for i in range(state.film.size):
        macro.sum_total[i] += state.fluid_pressure[i] + state.contact_pressure[i]
    for i in range(first):
        macro.sum_pressure[i] += state.fluid_pressure[i]
    carried = 0.0
    for i in range(state.film.size):
        carried += state.contact_pressure[i]
    macro.shares[0] += carried / model.contact.full_load
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
def mean_film_step(macro, work, model, gain):
    """Step of Newton's method of the mean pressure, into ``work.solution[0]``: its film takes up the mean exchange E.

    d(rho h) - d(rho h)_upstream + gain/window d(rho h) - d(f dp/dx) = E with the line kernel, at constant load. The
    third term is what the film takes up during the window. Density, film and derivatives are those of the last step.
    """
    first, outlet = model.side_flow.first, model.contact.outlet
    per_step = 1.0 / macro.counts[0]
    band, half, rho, by_p, h = work.band, work.half, work.density, work.density_slope, work.node.film
    exchange, none = work.residual[0], work.residual[1]
    filling = 1.0 + gain * per_step
    for i in range(macro.total.size):
        macro.kind[i] = 0
        work.unit[i] = exchange[i] = none[i] = 0.0
    for i in range(1, outlet - 1):
        inside = i >= first
        if inside and macro.total[i] + macro.sum_total[i] * per_step < TOTAL_MIN:
            continue
        macro.kind[i] = FLUID
        left = math.exp(macro.log_flux[i - 1]) if inside else half.f[i - 1]
        right = math.exp(macro.log_flux[i]) if i >= first - 1 else half.f[i]
        flow_left = 0.5 * left * (macro.pressure[i] - macro.pressure[i - 1])
        flow_right = 0.5 * right * (macro.pressure[i + 1] - macro.pressure[i])
        most_left, most_right = FILM_MONOTONE * left, FILM_MONOTONE * right
        p_left = min(max(flow_left * half.by_pressure[i - 1] / half.f[i - 1], -most_left), most_left)
        p_right = min(max(flow_right * half.by_pressure[i] / half.f[i], -most_right), most_right)
        h_left = flow_left * half.by_film[i - 1] / half.f[i - 1]
        h_right = flow_right * half.by_film[i] / half.f[i]
        band[0, i] = p_left - left - by_p[i - 1] * h[i - 1]
        band[1, i] = left + right + p_left - p_right + filling * by_p[i] * h[i]
        band[2, i] = -right - p_right
        band[3, i] = h_left - rho[i - 1]
        band[4, i] = h_left - h_right + filling * rho[i]
        band[5, i] = -h_right
        work.unit[i] = band[3, i] + band[4, i] + band[5, i]
        exchange[i] = macro.sum_exchange[i] if inside else 0.0
    solve_mean(macro, work, model, exchange, none, 0.0)


@njit(**FAST_INTERNAL_KERNEL)
def solve_mean(macro, work, model, right_1, right_2, excess):
    """Change of the mean pressure with the sum ``excess``, into ``work.solution[0]``; 0 where it is not updated."""
    mean = model.elastic_mean
    n = macro.total.size
    factor_and_solve(
        1,
        n,
        macro.kind,
        work.band,
        mean.weights_newton,
        mean.ratios_newton,
        right_1,
        right_2,
        work.unit,
        work.solution,
        work.block,
    )
    moved = 0.0
    by_level = 0.0
    for i in range(n):
        if macro.kind[i] == FLUID:
            moved += work.solution[0, i]
            by_level += work.solution[2, i]
    level = (moved - excess) / by_level if by_level != 0.0 else 0.0
    for i in range(n):
        change = work.solution[0, i] - level * work.solution[2, i]
        work.solution[0, i] = change if macro.kind[i] == FLUID else 0.0


@njit(**FAST_INTERNAL_KERNEL)
def update_pressure(macro, work, model):
    """One relaxed step of P from the means of a window; `update_mean_total` follows and closes the window."""
    rule = model.side_flow
    first = rule.first
    outlet = model.contact.outlet
    per_step = 1.0 / macro.counts[0]
    weight = (1.0 + AVERAGED) / (macro.counts[1] + 1.0 + AVERAGED)
    relaxation = rule.relaxation * rule.settled / (macro.counts[1] + rule.settled)
    if macro.counts[1] < STARTING * rule.settled:
        relaxation = START_GAIN
    below = macro.matrix[0]
    centre = macro.matrix[1]
    above = macro.matrix[2]
    change = macro.matrix[3]
    macro.shares[1] += weight * (macro.shares[0] * per_step - macro.shares[1])
    macro.shares[0] = 0.0
    part = rule.thick * min(max((FILM_SHARES[1] - macro.shares[1]) / (FILM_SHARES[1] - FILM_SHARES[0]), 0.0), 1.0)
    if macro.counts[1] < FILM_START:
        part = 0.0
    for i in range(first):
        macro.pressure[i] += AHEAD * (macro.sum_pressure[i] * per_step - macro.pressure[i])
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
    if part > 0.0:
        gain = FILM_GAIN * FILM_WINDOWS / (macro.counts[1] + FILM_WINDOWS)
        mean_film_step(macro, work, model, gain)
        film_change = work.solution[0]
        for i in range(first, outlet - 1):
            change[i] += part * (gain / relaxation * film_change[i] - change[i])
        for i in range(1, outlet - 1):
            moved = min(max(part * gain * film_change[i], -STEP_MAX), STEP_MAX)
            macro.total[i] = max(macro.total[i] + moved, 0.0)
    for i in range(first, outlet - 1):
        local = macro.sum_exchange[i] / macro.conductance[i] if macro.conductance[i] > 1e-300 else 0.0
        step = relaxation * (change[i] + local)
        if not abs(step) < 1e6:
            step = 0.0
        highest = max(macro.total[i], macro.sum_total[i] * per_step) + OUTFLOW_PRESSURE
        macro.pressure[i] = min(max(macro.pressure[i] + min(max(step, -STEP_MAX), STEP_MAX), 0.0), highest)
    carried = 0.0
    for i in range(outlet):
        carried += macro.pressure[i]
    if carried > LOAD_MAX * model.contact.full_load:
        lowered = LOAD_MAX * model.contact.full_load / carried
        for i in range(first, outlet):
            macro.pressure[i] *= lowered
    for i in range(first, outlet):
        macro.sum_exchange[i] = macro.sum_conductance[i] = macro.sum_log_lateral[i] = 0.0


@njit(**FAST_INTERNAL_KERNEL)
def isotropic_outflow(state, macro, work, model):
    """Factor on the side flow of the next step where a spot's pressure exceeds the macroscopic one.

    The lateral outflow of a spot is that of its own profile, -(1/gamma^2) d/dx [f_y d(p - P)/dx] (local isotropy),
    averaged over the width of a spot, where this is more than the mean-field exchange. It moves with the mean velocity,
    one node per step.
    """
    p = state.fluid_pressure
    f = work.node.f
    flow = work.residual[0]
    first, far = model.side_flow.first, model.contact.outlet - 1
    for i in range(first - 1, far):
        flow[i] = (f[i] + f[i + 1]) * (p[i] - macro.pressure[i] - p[i + 1] + macro.pressure[i + 1])
    flow[far] = 0.0
    width = max(model.side_flow.spot, 1.0)
    beyond = 0.5 * (width - 1.0)
    reach = int(beyond)
    part = beyond - reach
    scale = 0.5 * model.side_flow.isotropic / width
    for i in range(far, first, -1):
        j = i - 1
        excess = p[j] - macro.pressure[j]
        factor = 1.0
        if excess > OUTFLOW_PRESSURE and work.exchange[j] > 0.0:
            right, left = min(j + reach, far), max(j - 1 - reach, first - 1)
            outflow = (1.0 - part) * (flow[right] - flow[left])
            outflow += part * (flow[min(right + 1, far)] - flow[max(left - 1, first - 1)])
            factor = scale * outflow * state.outflow[j] / (work.exchange[j] * excess)
            factor = min(max(factor, 1.0), OUTFLOW_MAX)
        state.outflow[i] = factor


@kernel(**FAST_KERNEL)
def deflect_mean(macro, work, model):
    """Deflection (K_log - K_e) Q of the mean total pressure, which is part of the gap."""
    exponential_product(macro.total, model.elastic_mean.weights, model.elastic_mean.ratios, macro.deflection)
    exponential_product(macro.total, model.elastic.weights, model.elastic.ratios, work.response)
    for i in range(macro.total.size):
        macro.deflection[i] -= work.response[i]


@njit(**FAST_INTERNAL_KERNEL)
def update_mean_total(macro, work, model):
    """One step of the mean total pressure Q towards the time mean of q, at constant load; closes the window.

    A change of Q moves the gap by (K_log - K_e) dQ, which q answers: (D + K_e) dq = -(K_log - K_e) dQ - dh0 with the
    compliance D of the film. Newton's step for <q> = Q is (D + K_log) dQ + dh0 = (D + K_e)(<q> - Q) with sum dQ =
    W - sum Q; its gain falls as 1/n (Robbins & Monro 1951).
    """
    n = macro.total.size
    per_step = 1.0 / macro.counts[0]
    gain = TOTAL_GAIN * TOTAL_WINDOWS / (macro.counts[1] + TOTAL_WINDOWS)
    mean = model.elastic_mean
    diagonal = 0.0
    for m in range(mean.weights_newton.size):
        diagonal += mean.weights_newton[m]
    compliance = TOTAL_COMPLIANCE * diagonal
    left = work.residual[1]
    band = work.band
    excess = model.contact.load
    for i in range(n):
        left[i] = macro.sum_total[i] * per_step - macro.total[i]
        excess -= macro.total[i]
        macro.kind[i] = FLUID if i > 0 and macro.total[i] + macro.sum_total[i] * per_step > TOTAL_MIN else 0
        macro.sum_total[i] = 0.0
        work.unit[i] = 1.0
        band[0, i] = band[2, i] = band[3, i] = band[5, i] = 0.0
        # the film of the inlet gives way to pressure
        low = TOTAL_LOW / max(macro.total[i], TOTAL_MIN)
        band[1, i] = compliance * max(low * low, 1.0)
        band[4, i] = 1.0
    exponential_product(left, model.elastic.weights, model.elastic.ratios, work.residual[0])
    for i in range(n):
        work.residual[0, i] += band[1, i] * left[i]
    solve_mean(macro, work, model, work.residual[0], left, excess)
    for i in range(n):
        macro.total[i] = max(macro.total[i] + gain * work.solution[0, i], 0.0)
    deflect_mean(macro, work, model)
    macro.counts[0] = 0
    macro.counts[1] += 1
